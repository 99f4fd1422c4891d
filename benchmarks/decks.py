"""Time and memory of reading decks: `python -m benchmarks.decks AREAS CELLS CELLS CELLS [TASK ...]`.

The deck of a block of hexahedra is read as `ingest` does, and by pyNastran alone, each in a process of its own. TASK is
`read`, `alone` or `ingest`; without any, `read` and `ingest`. Grids in millions take pyNastran alone kilobytes each.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
import time
from dataclasses import asdict, dataclass
from pathlib import Path

from benchmarks import synthetic


@dataclass(frozen=True)
class Cost:
    """Seconds on the clock and of processors, and memory (MB) at most and before the task, with all libraries."""

    seconds: float
    processor_s: float
    peak_mb: float
    before_mb: float

    def per_grid(self, grids: int) -> str:
        """Kilobytes and microseconds per grid."""
        return f"{1e3 * (self.peak_mb - self.before_mb) / grids:.2f} kB {1e6 * self.processor_s / grids:.1f} us"


def _status(name: str) -> float:
    status = dict(line.split(":", 1) for line in Path("/proc/self/status").read_text().splitlines())
    return float(status[name].split()[0]) / 1e3


def _run(task: str, folder: Path) -> Cost:
    """In the process of the task."""
    from tedm_cli.nastran.reading import read_deck
    from tedm_cli.progress import silent
    from tedm_cli.stages.model.ingest import ingest

    deck = folder / "unit_loads.bdf"
    small = folder / "small.bdf"
    read_deck(small)  # loads the libraries
    project = synthetic.project(folder)
    before, start = _status("VmRSS"), time.perf_counter()
    used = sum(os.times()[:2])
    if task == "ingest":
        ingest(project, None, silent)
    elif task == "alone":
        from unittest import mock

        from tedm_cli.nastran.bulk.lines import NotPlainError

        with mock.patch("tedm_cli.nastran.reading.StreamedDeck", side_effect=NotPlainError):
            read_deck(deck)
    else:
        read_deck(deck)
    return Cost(time.perf_counter() - start, sum(os.times()[:2]) - used, _status("VmHWM"), before)


def measure(task: str, folder: Path) -> Cost:
    """One task on the deck and results of `folder`."""
    command = [sys.executable, "-m", "benchmarks.decks", "--task", task, str(folder)]
    return Cost(**json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout))


def write(folder: Path, areas: int, cells: tuple[int, int, int]) -> int:
    """Deck and results of a block; the number of its grids."""
    synthetic.project(folder)
    small, model = synthetic.block((4, 4, 4)), synthetic.block(cells)
    synthetic.write_deck(folder / "small.bdf", small, synthetic.unit_loads(small, 2))
    loads = synthetic.unit_loads(model, areas)
    synthetic.write_deck(folder / "unit_loads.bdf", model, loads)
    synthetic.write_results(folder / "unit_loads.op2", model, loads)
    return len(model.grid_id)


def main() -> None:
    if sys.argv[1] == "--task":
        print(json.dumps(asdict(_run(sys.argv[2], Path(sys.argv[3])))))
        return
    areas, nx, ny, nz = map(int, sys.argv[1:5])
    with tempfile.TemporaryDirectory() as name:
        grids = write(Path(name), areas, (nx, ny, nz))
        size = (Path(name) / "unit_loads.bdf").stat().st_size
        print(f"{grids:,} grids, {areas} areas, a deck of {size / 1e6:.0f} MB", flush=True)
        print(f"{'task':8} {'seconds':>9} {'processor':>9} {'peak MB':>9}   per grid", flush=True)
        for task in sys.argv[5:] or ("read", "ingest"):
            cost = measure(task, Path(name))
            numbers = " ".join(f"{x:9.1f}" for x in (cost.seconds, cost.processor_s, cost.peak_mb))
            print(f"{task:8} {numbers}   {cost.per_grid(grids)}", flush=True)


if __name__ == "__main__":
    main()
