"""One pass over an OP2, to columns of S and motions of the optics: `python -m benchmarks.one_pass FOLDER AREAS`.

The OP2 is made in the folder if it is not there. The peer is a plain read of the same bytes, from the page cache.
Memory is that of the process: what it has allocated, and what it has mapped of files.
"""

from __future__ import annotations

import sys
import tempfile
import threading
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import numpy as np

from benchmarks import synthetic
from benchmarks.scale import CELLS
from benchmarks.timing import Result, timed
from tedm_cli.arrays import FloatArray
from tedm_cli.columns import Reduction, reduced
from tedm_cli.deck_units import SI
from tedm_cli.distortion import RigidFit
from tedm_cli.nastran.displacements import OnGrids
from tedm_cli.nastran.geometry import ModelGeometry
from tedm_cli.nastran.op2.reader import open_op2

_PIECE = 1 << 22  # bytes of the plain read at once


class Peak:
    """The largest memory of this process, in MB, by kind, while the block runs."""

    def __enter__(self) -> Peak:
        self.mb = {"RssAnon": 0.0, "RssFile": 0.0}
        self._ended = threading.Event()
        self._watch = threading.Thread(target=self._look)
        self._watch.start()
        return self

    def __exit__(self, *_: Any) -> None:
        self._ended.set()
        self._watch.join()

    def _look(self) -> None:
        while not self._ended.wait(0.002):
            status = dict(line.split(":", 1) for line in Path("/proc/self/status").read_text().splitlines())
            self.mb = {kind: max(peak, float(status[kind].split()[0]) / 1e3) for kind, peak in self.mb.items()}


def one_pass(areas: int = 80, folder: Path | None = None) -> Result:
    """68,000 grids, two test masses: all that displacements are reduced to, without checks of rigid elements."""
    model = synthetic.block(CELLS)
    n = len(model.grid_id)
    none = np.zeros(n, dtype=bool)
    geometry = SimpleNamespace(
        grid_id=model.grid_id,
        position_m=model.position,
        displacement_frame=np.zeros(n, dtype=np.int64),
        frames={},
        units=SI,
        structural=~none,
        in_rigid_element=none,
        lumped_kg=np.ones(n),
    )
    by = Reduction(
        operator=np.random.default_rng(0).normal(size=(12, n, 3)),
        rotation=np.zeros((12, 0, 3)),
        levers=np.zeros(0, dtype=np.int64),
        optics=np.arange(20),
        blocks=(),
        fit=RigidFit(model.position, np.ones(n), model.position.mean(axis=0)),
    )
    on_grids = OnGrids(cast(ModelGeometry, geometry))
    with tempfile.TemporaryDirectory() as name:
        op2 = (folder or Path(name)) / "unit_loads.op2"
        if not op2.exists():
            synthetic.write_results(op2, model, synthetic.unit_loads(model, areas))

        def motions() -> Iterator[tuple[float, bool, FloatArray, FloatArray]]:
            with open_op2(op2) as (tables, read):
                for table in tables:
                    motion = on_grids.motion(read(table), table, str(op2))
                    yield 1.0, True, motion[:, 0], motion[:, 1]

        def plain() -> None:
            buffer = bytearray(_PIECE)
            with open(op2, "rb", buffering=0) as stream:
                while stream.readinto(buffer):
                    pass

        with Peak() as peak:
            reduced(motions(), by)
        memory = ", ".join(f"{kind} {mb:.0f} MB" for kind, mb in peak.mb.items())
        note = f"{op2.stat().st_size / 1e6:.0f} MB; {memory}"
        return timed(lambda: reduced(motions(), by), plain, note, runs=3)


if __name__ == "__main__":
    print(one_pass(int(sys.argv[2]), Path(sys.argv[1])))
