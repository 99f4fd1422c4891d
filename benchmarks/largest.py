"""The largest models that were tried by each route, and their memory: minutes and gigabytes.

`python -m benchmarks largest` takes up to 6 GB. Routes: the stages from an OP2 to S with all masses, the deck, and the
embedded solver.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator, Sequence
from typing import Any

from benchmarks.growth import Cells
from benchmarks.process import run
from benchmarks.scale import DECK, Measured, row, stages

AREAS = 10
STAGES_AT: Cells = (203, 125, 80)  # 2,081,944 grids
DECKS_AT: Cells = (140, 84, 56)  # 683,145
SOLVED_AT: Sequence[Cells] = ((60, 24, 10), (100, 40, 15), (120, 48, 18))  # 16,775, 66,256 and 112,651
SOLVED = "factorised and solved by the embedded solver"


def rows(
    of_stages: Cells = STAGES_AT, of_decks: Cells = DECKS_AT, solved: Sequence[Cells] = SOLVED_AT
) -> Iterator[dict[str, Any]]:
    """Every stage without a deck, `ingest` with one, and the solver at three sizes, for its memory is no line."""
    for task, stage, found in stages(AREAS, of_stages):
        if task == stage:
            yield row(task, stage, AREAS, of_stages, found)
    for task, stage, found in stages(AREAS, of_decks, deck=True, only=tuple(DECK)):
        if task == stage in DECK:
            yield row(task, stage, AREAS, of_decks, found)
    for cells in solved:
        usage = run(["-m", "benchmarks.largest", "--solver", *map(str, cells)])
        told = json.loads(usage.output)
        memory = (usage.resident_mb, usage.anonymous_mb, usage.file_mb)
        found = Measured(told["processor_s"], told["wall_s"], 0.0, *memory)
        yield {**row(SOLVED, SOLVED, AREAS, cells, found), "solver": told["solver"]}


def _solve(cells: Cells) -> dict[str, Any]:
    import numpy as np

    from benchmarks.solver import bench
    from benchmarks.timing import timed
    from tedm_cli.fem.static import StaticSolution
    from tedm_cli.fem.structure import LoadCase

    structure, used = bench(cells), []
    area = np.random.default_rng(1).integers(0, AREAS, structure.n_grids)

    def work() -> None:
        solution = StaticSolution(structure)
        for _ in solution.solve(LoadCase(id=k, label="", temperature=(area == k).astype(float)) for k in range(AREAS)):
            pass
        used.append(solution.report.solver)

    times = timed(work, None, runs=1).ours
    return {"processor_s": times.best, "wall_s": min(times.clock), "solver": used[0]}


if __name__ == "__main__":
    assert sys.argv[1] == "--solver"
    nx, ny, nz = map(int, sys.argv[2:5])
    print(json.dumps(_solve((nx, ny, nz))))
