"""The adjoint against the unit loads of 10, 100 and 1,000 areas: from the factors to the sensitivities of 24 outputs.

python -m benchmarks.adjoint [CELLS CELLS CELLS]: a block of bubble hexahedra, 66,256 grids where left out. All is done
with one factorisation, whose peak of memory is told before anything is solved.
"""

from __future__ import annotations

import json
import os
import sys
import time
from collections.abc import Iterator
from dataclasses import asdict, dataclass

import numpy as np

from benchmarks.process import memory, run
from benchmarks.solver import bench
from benchmarks.timing import Result, Times
from tedm_cli.adjoint.areas import Warmed, temperatures
from tedm_cli.arrays import FloatArray
from tedm_cli.fem.static import StaticSolution
from tedm_cli.fem.structure import LoadCase

OUTPUTS = 24  # accelerations of two test masses, and two sets of read-outs
AREAS = (10, 100, 1000)
CELLS = (100, 40, 15)


@dataclass(frozen=True)
class Line:
    """Seconds of a piece of work, of the clock and of the processor, and the peak of memory since the beginning."""

    work: str
    areas: int
    seconds: float
    processor_s: float
    peak_mb: float


def lines(cells: tuple[int, int, int], numbers: tuple[int, ...]) -> Iterator[Line]:
    """The factorisation, and for these numbers of areas the adjoint and the unit loads; both have to agree."""
    structure = bench(cells)
    rng = np.random.default_rng(1)
    outputs = rng.normal(size=(6 * structure.n_grids, OUTPUTS))
    clock = _Clock()
    solution = StaticSolution(structure)
    yield clock.line("assembly and factorisation", 0)
    for count in numbers:
        area = rng.integers(0, count, structure.n_grids)
        clock = _Clock()
        found = _by_adjoint(solution, outputs, area, count)
        yield clock.line("adjoint", count)
        clock = _Clock()
        loads = (LoadCase(id=k, label="", temperature=(area == k).astype(float)) for k in range(count))
        wanted = np.array([outputs.T @ motion.reshape(-1) for _, motion in solution.solve(loads)]).T
        yield clock.line("unit loads", count)
        assert np.abs(found - wanted).max() < 1e-9 * np.abs(wanted).max()


def _by_adjoint(solution: StaticSolution, outputs: FloatArray, area: np.ndarray, count: int) -> FloatArray:
    of = temperatures(solution.adjoint(outputs, ["output"] * OUTPUTS), np.zeros(0, dtype=bool))
    grids = np.split(np.argsort(area, kind="stable"), np.cumsum(np.bincount(area, minlength=count))[:-1])
    return of.sums([Warmed(grid=rows, element=np.zeros(0, dtype=np.int64)) for rows in grids])


class _Clock:
    def __init__(self) -> None:
        self._start, self._processor = time.perf_counter(), time.process_time()

    def line(self, work: str, areas: int) -> Line:
        seconds, processor = time.perf_counter() - self._start, time.process_time() - self._processor
        return Line(work, areas, seconds, processor, memory()["VmHWM"] / 1e3)


def against_unit_loads(cells: tuple[int, int, int] = (60, 24, 10)) -> Result:
    """24 outputs by the adjoint, whatever the areas, against the unit loads of 80 of them; in a process of its own."""
    text = run(["-m", "benchmarks.adjoint", "--json", *map(str, cells)]).output
    factors, ours, peer = (Line(**line) for line in json.loads(text))
    note = f"after a factorisation of {factors.processor_s:.1f} s"
    ours_s, peer_s = (Times((line.processor_s,), (line.seconds,)) for line in (ours, peer))
    return Result(ours_s, peer_s, note=note)


def main() -> None:
    if sys.argv[1:2] == ["--json"]:
        nx, ny, nz = map(int, sys.argv[2:5])
        print(json.dumps([asdict(line) for line in lines((nx, ny, nz), (80,))]))
        return
    nx, ny, nz = map(int, sys.argv[1:4] or CELLS)
    print(f"{(nx + 1) * (ny + 1) * (nz + 1):,} grids, {OUTPUTS} outputs")
    print(f"{'':28} {'areas':>6} {'seconds':>9} {'processor':>9} {'peak MB':>9} {'load':>5}", flush=True)
    for line in lines((nx, ny, nz), AREAS):
        numbers = f"{line.areas or '':6} {line.seconds:9.2f} {line.processor_s:9.2f} {line.peak_mb:9.0f}"
        print(f"{line.work:28} {numbers} {os.getloadavg()[0]:5.1f}", flush=True)


if __name__ == "__main__":
    main()
