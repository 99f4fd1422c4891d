"""Run all benchmarks and print a table: median time, the peer's median time in the same run, and their ratio."""

from __future__ import annotations

import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from statistics import median

import numpy as np

RUNS = 5


def timed(work: Callable[[], object], peer: Callable[[], object]) -> tuple[float, float]:
    """Median seconds of both, run in turn so that a change of the machine's speed meets both."""
    work(), peer()
    ours, theirs = [], []
    for _ in range(RUNS):
        for call, times in ((work, ours), (peer, theirs)):
            start = time.perf_counter()
            call()
            times.append(time.perf_counter() - start)
    return median(ours), median(theirs)


def kernel(n: int = 66_000) -> tuple[float, float]:
    """Force and gradient (and the torque family) of a cuboid at n points, against a point mass in plain NumPy."""
    from tedm_cli.gravity.kernel import cuboid_field

    rng = np.random.default_rng(1)
    direction = rng.normal(size=(n, 3))
    points = direction / np.linalg.norm(direction, axis=1, keepdims=True) * rng.uniform(0.045, 0.5, (n, 1))

    def point_mass() -> object:
        r = np.linalg.norm(points, axis=1)
        force = points / r[:, None] ** 3
        gradient = 3 * points[:, :, None] * points[:, None, :] / r[:, None, None] ** 5
        gradient -= np.eye(3) / r[:, None, None] ** 3
        return force, gradient

    return timed(lambda: cuboid_field(points, np.full(3, 0.046)), point_mass)


def contraction(n: int = 66_000, k: int = 78) -> tuple[float, float]:
    """S = -G D over blocks of grids, against a plain copy of the same bytes of D."""
    from tedm_cli.gravity.operator import contract

    rng = np.random.default_rng(2)
    g, d = rng.normal(size=(12, n, 3)), rng.normal(size=(k, n, 3))
    block = 16384

    def blocks() -> object:
        return sum(contract(g[:, i : i + block], d[:, i : i + block]) for i in range(0, n, block))

    return timed(blocks, d.copy)


def cases(k: int = 78, outputs: int = 24, frequencies: int = 4096) -> tuple[float, float]:
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


def solver() -> tuple[float, float]:
    """Factorising and solving the small sample with MUMPS where it is installed, against SciPy's SuperLU."""
    from tedm_cli.fem.static import StaticSolution
    from tedm_cli.nastran.solver_deck import read_solver_deck

    root = Path(__file__).parents[1]
    structure, load_cases = read_solver_deck(root / "sample_models" / "small" / "unit_loads.bdf")
    return timed(
        lambda: list(StaticSolution(structure).solve(load_cases)),
        lambda: list(StaticSolution(structure, solver="superlu").solve(load_cases)),
    )


def command_line() -> tuple[float, float]:
    """`tedm --help` against an empty Python."""

    def run(*arguments: str) -> Callable[[], object]:
        return lambda: subprocess.run([sys.executable, *arguments], check=True, stdout=subprocess.DEVNULL)

    return timed(run("-m", "tedm_cli.cli", "--help"), run("-c", "pass"))


BENCHMARKS = {
    "gravity kernel, 66,000 points / point mass in NumPy": kernel,
    "S = -G D, 66,000 grids x 78 areas / copy of D": contraction,
    "one case, 24 outputs, 4,096 frequencies / k x k per frequency": cases,
    "small sample, default solver / SuperLU": solver,
    "tedm --help / python -c pass": command_line,
}


def main() -> None:
    print(f"{'work / peer':64} {'seconds':>9} {'peer':>9} {'ratio':>7}")
    for name, benchmark in BENCHMARKS.items():
        ours, theirs = benchmark()
        print(f"{name:64} {ours:9.4f} {theirs:9.4f} {ours / theirs:7.2f}", flush=True)


if __name__ == "__main__":
    main()
