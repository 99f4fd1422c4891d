"""Time and peak memory of the stages, from an OP2 to S: `python -m benchmarks.scale AREAS CELLS CELLS CELLS [deck]`.

With `deck`, the deck is written and ingested as well, which takes pyNastran kilobytes per grid; without, the model is
made up. Every stage runs in a process of its own, on files that are not in the page cache; its peer, in another such
process, reads or writes the same bytes plainly.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
import time
from collections import deque
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass
from functools import cache
from pathlib import Path

import h5py

from benchmarks import synthetic
from benchmarks.timing import Result, timed
from tedm_cli.nastran.displacements import unit_load_displacements
from tedm_cli.nastran.geometry import model_geometry
from tedm_cli.nastran.loads.unit_loads import UnitLoads
from tedm_cli.nastran.reading import read_deck

CELLS = (64, 38, 26)  # 68,000 grids


@dataclass(frozen=True)
class Measured:
    """Seconds of a task, those that it streams displacements (where it says so), and its process's peak memory."""

    seconds: float
    streaming_s: float
    peak_mb: float


def measure(task: str, folder: Path, areas: int, cells: tuple[int, int, int]) -> Measured:
    """Run one task in a process of its own, with the files of `folder` out of the page cache."""
    for path in folder.iterdir():
        with open(path, "rb") as stream:
            os.fsync(stream.fileno())
            os.posix_fadvise(stream.fileno(), 0, 0, os.POSIX_FADV_DONTNEED)
    command = [sys.executable, "-m", "benchmarks.scale", "--task", task, str(folder), *map(str, (areas, *cells))]
    return Measured(**json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout))


def _written(target: Path, size: int) -> None:
    """A plain file of zeros on the disk."""
    block = bytes(1 << 24)
    with open(target, "wb") as stream:
        for start in range(0, size, len(block)):
            stream.write(block[: size - start])
        os.fsync(stream.fileno())
    target.unlink()


def _copied(source: Path, names: tuple[str, ...], *, read: bool) -> None:
    """A plain contiguous copy by h5py to the disk, area by area; without `read` of the first area again and again."""
    target = source.with_suffix(".copy")
    with h5py.File(source) as old, h5py.File(target, "w") as new:
        for name in names:
            data, row = new.create_dataset(name, old[name].shape, old[name].dtype), old[name][0]
            for i in range(len(data)):
                data[i] = old[name][i] if read else row
    with open(target, "rb+") as stream:
        os.fsync(stream.fileno())
    target.unlink()


def _read(source: Path) -> None:
    """A plain read of [D] by h5py, area by area."""
    with h5py.File(source) as file:
        for i in range(len(file["D/translation"])):
            file["D/translation"][i]


def _run(task: str, folder: Path, areas: int, cells: tuple[int, int, int]) -> Measured:
    """In the process of the task."""
    from tedm_cli.stages.gravity.sensitivity import build_sensitivity
    from tedm_cli.stages.model.distortion import build_distortion
    from tedm_cli.stages.model.ingest import ingest

    unit, distortion = folder / "unit_loads.h5", folder / "distortion.h5"
    deck, op2 = folder / "unit_loads.bdf", folder / "unit_loads.op2"
    project, marks = synthetic.project(folder, "lumped" if task.endswith("lumped") else "quadrature"), []

    def made_up() -> tuple[synthetic.Block, UnitLoads]:  # not in the processes of the stages, whose memory is measured
        model = synthetic.block(cells)
        return model, synthetic.unit_loads(model, areas)

    def step(done: int, total: int, what: str) -> None:
        if what.startswith(("contracting", "reading")) or (what.startswith("summing") and done == total):
            marks.append(time.perf_counter())

    tasks: dict[str, Callable[[], object]] = {
        "write OP2": lambda: synthetic.write_results(op2, *made_up()),
        "plain file": lambda: _written(op2.with_suffix(".copy"), op2.stat().st_size),
        "write deck": lambda: synthetic.write_deck(deck, *made_up()),
        "displacements": lambda: synthetic.write_unit_loads(project, synthetic.block(cells), areas, step, [op2]),
        "plain write": lambda: _copied(unit, ("translation", "rotation"), read=False),
        "ingest": lambda: ingest(project, None, step),
        "build-distortion": lambda: build_distortion(project, None, step),
        "plain copy": lambda: _copied(unit, ("translation",), read=True),
        "build-sensitivity": lambda: build_sensitivity(project, None, step),
        "build-sensitivity, lumped": lambda: build_sensitivity(project, None, step),
        "plain read": lambda: _read(distortion),
    }
    start = time.perf_counter()
    tasks[task]()
    end = time.perf_counter()
    # of this program alone; ru_maxrss counts the process that started it as well
    status = dict(line.split(":", 1) for line in Path("/proc/self/status").read_text().splitlines())
    peak = float(status["VmHWM"].split()[0]) / 1e3
    streaming = (end - marks[0] if task in ("displacements", "ingest") else marks[-1] - marks[0]) if marks else 0.0
    return Measured(end - start, streaming, peak)


RESULTS = (("write OP2", "plain file"), ("displacements", "plain write"))
DECK = (("write deck", None), ("ingest", "plain write"))
STAGES = (
    ("build-distortion", "plain copy"),
    ("build-sensitivity", "plain read"),
    ("build-sensitivity, lumped", "plain read"),
)


def run(
    areas: int, cells: tuple[int, int, int], deck: bool = False
) -> Iterator[tuple[str, str | None, Measured, Measured | None]]:
    """Every stage and its peer, in turn, in a folder that is removed afterwards; the OP2 goes as soon as it is read."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for task, peer in (*RESULTS, *(DECK if deck else ()), *STAGES):
            ours = measure(task, folder, areas, cells)
            if task == ("ingest" if deck else "displacements"):
                (folder / "unit_loads.op2").unlink()
            yield task, peer, ours, None if peer is None else measure(peer, folder, areas, cells)


@cache
def _small() -> dict[str, tuple[Measured, Measured]]:
    return {task: (ours, plain) for task, _, ours, plain in run(80, CELLS) if plain is not None}


def streaming(task: str) -> Result:
    """One stage at 68,000 grids and 80 areas against the plain reading or writing of the bytes that it streams."""
    ours, peer = _small()[task]
    return Result(ours.streaming_s or ours.seconds, peer.seconds, f"peak {ours.peak_mb:.0f} MB")


def op2_reading(areas: int = 20) -> Result:
    """All displacements of an OP2 of 68,000 grids in the basic frame, one subcase after the other."""
    model = synthetic.block(CELLS)
    with tempfile.TemporaryDirectory() as name:
        project, loads = synthetic.project(Path(name)), synthetic.unit_loads(model, areas)
        deck, op2 = (project.build_dir / f"unit_loads.{kind}" for kind in ("bdf", "op2"))
        synthetic.write_deck(deck, model, loads)
        synthetic.write_results(op2, model, loads)
        geometry = model_geometry(read_deck(deck), [deck])
        every = [*loads.areas, *([loads.uniform] if loads.uniform else [])]
        note = f"{op2.stat().st_size / 1e6:.0f} MB"
        return timed(lambda: deque(unit_load_displacements([op2], every, geometry), 0), op2.read_bytes, note, runs=3)


def main() -> None:
    if sys.argv[1] == "--task":
        task, folder, areas, *cells = sys.argv[2:]
        nx, ny, nz = map(int, cells)
        print(json.dumps(asdict(_run(task, Path(folder), int(areas), (nx, ny, nz)))))
        return
    areas, nx, ny, nz = map(int, sys.argv[1:5])
    grids = (nx + 1) * (ny + 1) * (nz + 1)
    print(f"{grids:,} grids, {areas} areas, {grids * areas * 12 / 1e9:.2f} GB for each of /translation, /rotation, [D]")
    print(f"{'stage / peer':40} {'seconds':>9} {'streaming':>9} {'peak MB':>9} {'peer s':>9} {'load':>5}", flush=True)
    for task, peer, ours, plain in run(areas, (nx, ny, nz), deck="deck" in sys.argv[5:]):
        numbers = (ours.seconds, ours.streaming_s, ours.peak_mb, plain.seconds if plain else 0.0)
        text = " ".join(f"{x:9.2f}" for x in numbers)
        print(f"{f'{task} / {peer}' if peer else task:40} {text} {os.getloadavg()[0]:5.1f}", flush=True)


if __name__ == "__main__":
    main()
