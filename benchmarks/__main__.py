"""Run all benchmarks and print a table: median time, the peer's median time in the same run, and their ratio."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable
from functools import partial
from importlib.util import find_spec
from pathlib import Path

import numpy as np

from benchmarks import bodies, thermal
from benchmarks.adjoint import against_unit_loads
from benchmarks.desk import one_run
from benchmarks.dynamics import closed_loop
from benchmarks.gravity import against_choclo, all_quantities, contraction, operator
from benchmarks.noise import realisation
from benchmarks.optics import against_optiland, derivative
from benchmarks.scale import op2_reading, streaming
from benchmarks.solver import assembly
from benchmarks.timing import Result, timed


def cases(k: int = 78, outputs: int = 24, frequencies: int = 4096) -> Result:
    """One case for all outputs, against the k x k product at every frequency."""
    from tedm_cli.noise.areas import AreaTable
    from tedm_cli.noise.propagation import output_psd
    from tedm_cli.noise.temperature import thesis_model

    rng = np.random.default_rng(3)
    shield = np.where(np.arange(k) < 12, "outside", "inside")
    names = np.array([f"A{i}" for i in range(k)])
    areas = AreaTable(name=names, group=shield, shield=shield, side=np.full(k, "mid"))
    model = thesis_model(areas)
    rows = rng.normal(size=(outputs, k))
    correlation = (shield[:, None] == shield[None, :]).astype(float)
    f = np.geomspace(1e-4, 0.1, frequencies)

    def dense() -> object:
        h = rows[:, :, None] * model.amplitudes(f)[None]
        return np.einsum("oif,oif->of", h, np.einsum("ij,ojf->oif", correlation, h, optimize=True))

    return timed(lambda: output_psd(rows, model, correlation, f), dense)


def solver() -> Result:
    """Factorising and solving the small sample with the default solver, against SciPy's SuperLU."""
    from tedm_cli.fem.static import StaticSolution
    from tedm_cli.nastran.structure.deck import read_solver_deck

    root = Path(__file__).parents[1]
    structure, load_cases = read_solver_deck(root / "sample_models" / "small" / "unit_loads.bdf")
    return timed(
        lambda: list(StaticSolution(structure).solve(load_cases)),
        lambda: list(StaticSolution(structure, solver="superlu").solve(load_cases)),
    )


def command_line() -> Result:
    """`tedm --help` against an empty Python."""

    def run(*arguments: str) -> Callable[[], object]:
        return lambda: subprocess.run([sys.executable, *arguments], check=True, stdout=subprocess.DEVNULL)

    return timed(run("-m", "tedm_cli.cli", "--help"), run("-c", "pass"))


BENCHMARKS: dict[str, Callable[[], Result]] = {
    "gravity kernel, all six quantities, 66,000 points / point mass in NumPy": all_quantities,
    "G and field by quadrature, 68,000 grids, one test mass / lumped": partial(operator, (64, 38, 26)),
    "G and field by quadrature, 683,000 grids, one test mass / lumped": partial(operator, (140, 84, 56)),
    "S = -G D, 66,000 grids x 78 areas / copy of D": contraction,
    "OP2 to unit_loads.h5, without a deck, 68,000 grids x 80 areas / plain write": partial(streaming, "displacements"),
    "build-distortion, 68,000 grids x 80 areas / plain copy of [D]": partial(streaming, "build-distortion"),
    "contraction with D from the disk, 68,000 x 80 / plain read": partial(streaming, "build-sensitivity"),
    "displacements of an OP2, 68,000 grids x 20 subcases / plain read": op2_reading,
    "S_BW 40 x 144, analytic / complex step of the same trace": derivative,
    "one case, 24 outputs, 4,096 frequencies / k x k per frequency": cases,
    "realisation, 1e7 samples, 24 outputs, 78 areas as 4 blocks / its random numbers": partial(realisation, 4),
    "realisation, 1e7 samples, 24 outputs, 78 areas alone / their random numbers": partial(realisation, 78),
    "small sample, default solver / SuperLU": solver,
    "solver, 66,256 grids: assembly / factorisation": assembly,
    "adjoint of 24 outputs, 66,256 grids / unit loads of 80 areas": against_unit_loads,
    "gains of 5,120 thermal nodes, 5 frequencies / SciPy's solver in its own order": thermal.against_default_order,
    "gains of 5,120 thermal nodes, 300 frequencies x 20 disturbances / a minute": thermal.whole,
    "tedm --help / python -c pass": command_line,
    "chain of the small sample, tedm run -j 2 / a process per command": one_run,
    "budgets in closed loop, 4,096 frequencies x 114 noises x 75 outputs / python-control": closed_loop,
}
BENCHMARKS |= {
    f"F and gradient, 66,000 points {where}, threads: {threads} / choclo": partial(against_choclo, *limits, threads)
    for where, limits in (("within 11 sides", (0.045, 0.5)), ("within 1.5 sides", (0.041, 0.069)))
    for threads in (1, 2)
}
BENCHMARKS |= {
    f"six quantities of a {what}, 4,000 points {where} / cube": partial(bodies.against_cuboid, make, limits)
    for what, make in bodies.OTHERS.items()
    for where, limits in (("near", bodies.NEAR), ("far", bodies.FAR))
}
if find_spec("polyhedral_gravity"):
    BENCHMARKS |= {
        f"F and gradient, polyhedron of {n} triangles, 4,000 points {where} / polyhedral-gravity": partial(
            bodies.against_polyhedral_gravity, make, limits
        )
        for n, make in ((60, bodies.cut_cube), (1280, bodies.ball))
        for where, limits in (("near", bodies.NEAR), ("far", bodies.FAR))
    }
if find_spec("optiland"):
    BENCHMARKS["trace of 8 beam paths / Optiland"] = against_optiland


def main() -> None:
    print(f"{'work / peer':72} {'seconds':>9} {'peer':>9} {'ratio':>7}")
    for name, benchmark in BENCHMARKS.items():
        result = benchmark()
        ratio = result.ours / result.peer
        print(f"{name:72} {result.ours:9.4f} {result.peer:9.4f} {ratio:7.2f}  {result.note}".rstrip(), flush=True)


if __name__ == "__main__":
    main()
