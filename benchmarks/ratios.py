"""Pieces of work against their peers, side by side in one process: what they are, and their rows."""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Iterator
from functools import partial
from importlib.util import find_spec
from typing import Any

import numpy as np

from benchmarks import bodies, thermal
from benchmarks.adjoint import against_unit_loads
from benchmarks.desk import one_run
from benchmarks.dynamics import closed_loop
from benchmarks.gravity import against_choclo, all_quantities, contraction, operator
from benchmarks.noise import realisation
from benchmarks.optics import against_optiland
from benchmarks.process import run
from benchmarks.solver import bench
from benchmarks.timing import Result, timed

NEAR, FAR = (0.041, 0.069), (0.045, 0.5)  # m from the centre of a cube of 46 mm
_PLACES = (("within 1.5 sides", NEAR), ("within 11 sides", FAR))


def solver() -> Result:
    """Factors and ten cases by this machine's default solver, against SciPy's SuperLU, which is always there."""
    from tedm_cli.fem.static import StaticSolution
    from tedm_cli.fem.structure import LoadCase

    structure = bench((30, 12, 8))
    area = np.random.default_rng(1).integers(0, 10, structure.n_grids)
    loads = [LoadCase(id=k, label="", temperature=(area == k).astype(float)) for k in range(10)]
    used = StaticSolution(structure).report.solver
    return timed(
        lambda: list(StaticSolution(structure).solve(loads)),
        lambda: list(StaticSolution(structure, solver="superlu").solve(loads)),
        f"default: {used}",
        runs=2,
    )


#: Work, its peer (none: nothing else does it), and how both are measured.
BENCHMARKS: dict[tuple[str, str | None], Callable[[], Result]] = {
    **{
        (f"F and Γ of a cube, {where}", peer): partial(against_choclo, *limits, shared)
        for where, limits in _PLACES
        for peer, shared in (("choclo, nine calls", False), ("choclo's corner kernels, each once", True))
    },
    **{(f"all six quantities of a cube, {where}", None): partial(all_quantities, *limits) for where, limits in _PLACES},
    ("operator by quadrature, 68,000 grids, one test mass", "lumped masses"): partial(operator, (64, 38, 26)),
    ("S = -G D, 66,000 grids × 78 areas in memory", "one product by BLAS"): contraction,
    **{
        (f"six quantities of a {what}, {where}", "those of a cube"): partial(bodies.against_cuboid, make, limits)
        for what, make in bodies.OTHERS.items()
        for where, limits in (("near", bodies.NEAR), ("far", bodies.FAR))
    },
    ("3,627 grids factorised, 10 unit loads solved", "SciPy's SuperLU"): solver,
    ("adjoint of 24 outputs, 16,775 grids", "unit loads of 80 areas"): against_unit_loads,
    ("gains of 5,120 thermal nodes", "SciPy's solver in its own order"): thermal.against_default_order,
    ("realisation of 1,000,000 samples, 24 outputs, 78 areas", "their random numbers"): realisation,
    ("budgets in closed loop, 114 noises × 75 outputs", "python-control, H alone"): closed_loop,
    ("chain of the small sample, tedm run -j 2", "a process per command"): one_run,
}
if find_spec("polyhedral_gravity"):
    BENCHMARKS |= {
        (f"F and Γ of {n:,} triangles, {where}", "polyhedral-gravity"): partial(
            bodies.against_polyhedral_gravity, make, limits
        )
        for n, make in ((60, bodies.cut_cube), (1280, bodies.ball))
        for where, limits in (("near", bodies.NEAR), ("far", bodies.FAR))
    }
if find_spec("optiland"):
    BENCHMARKS["trace of 8 beam paths", "Optiland"] = against_optiland


def in_one_process() -> Iterator[dict[str, Any]]:
    """The rows, measured in a process of its own with one thread of BLAS."""
    yield from map(json.loads, run(["-m", "benchmarks.ratios"]).output.splitlines())


def rows() -> Iterator[dict[str, Any]]:
    """One row a benchmark, and how long each took."""
    for (work, peer), benchmark in BENCHMARKS.items():
        start = time.perf_counter()
        yield {"work": work, "peer": peer, **of(benchmark()), "took_s": round(time.perf_counter() - start, 1)}


def of(result: Result) -> dict[str, Any]:
    """What is stored of a result."""
    each = {"number": result.each[0], "of": result.each[1]} if result.each else None
    sides = {"ours": result.ours, "other": result.peer}
    times = {
        name: {"best_s": _short(t.best), "median_s": _short(t.median), "clock_s": _short(min(t.clock))}
        for name, t in sides.items()
        if t
    }
    return {**times, "ratio": _short(result.ratio) if result.ratio else None, "each": each, "note": result.note}


def _short(value: float) -> float:
    return float(f"{value:.4g}")


if __name__ == "__main__":
    for one in rows():
        print(json.dumps(one), flush=True)
