"""The cuboid kernel against choclo (Fatiando a Terra), the operator of a block, and its contraction with [D]."""

from __future__ import annotations

import sys
import tracemalloc
from collections.abc import Callable
from functools import cache
from pathlib import Path

import numpy as np

from benchmarks.synthetic import hexahedra
from benchmarks.timing import Result, timed
from tedm_cli.arrays import FloatArray
from tedm_cli.gravity.masses import MassDistribution

SIDES = np.full(3, 0.046)
SAMPLE = 60


def points_between(lower: float, upper: float, n: int = 66_000) -> FloatArray:
    """Points in all directions, their distance [m] from the centre uniform between two limits."""
    rng = np.random.default_rng(1)
    direction = rng.normal(size=(n, 3))
    return direction / np.linalg.norm(direction, axis=1, keepdims=True) * rng.uniform(lower, upper, (n, 1))


def against_choclo(lower: float, upper: float, shared: bool) -> Result:
    """The three components of the force and the six of its gradient at 66,000 points, on one thread.

    choclo has a function for each component, so all nine take nine calls, and every corner's logarithms and arctangents
    are computed up to three times. `shared` is the loop that its user could write: choclo's corner kernels of the
    gradient, each once, from which the components of the force follow.
    """
    from tedm_cli.gravity.kernel import cuboid_force_gradient

    loop = _shared_corners() if shared else _nine_calls()
    points = points_between(lower, upper)
    limits = [sign * side / 2 for side in SIDES for sign in (-1, 1)]

    def peer() -> FloatArray:
        nine = np.empty((len(points), 9))
        loop(points, *limits, nine)
        return nine

    nine = peer()
    force, gamma = cuboid_force_gradient(points, SIDES)
    # choclo's components, per unit density, of the attraction in place of the force on the test mass: signs turn
    volume = float(SIDES.prod())
    errors = _worst_errors(points, (force, gamma), (-nine[:, :3] / volume, _tensor(nine[:, 3:]) / volume))
    return timed(lambda: cuboid_force_gradient(points, SIDES, threads=1), peer, errors, each=(len(points), "point"))


def all_quantities(lower: float = 0.045, upper: float = 0.5) -> Result:
    """All six quantities of a cuboid at 66,000 points on one thread; nothing else computes them."""
    from tedm_cli.gravity.kernel import cuboid_field

    points = points_between(lower, upper)
    return timed(lambda: cuboid_field(points, SIDES), None, each=(len(points), "point"))


def contraction(n: int = 66_000, k: int = 78) -> Result:
    """S = -G D over blocks of grids, against one product by BLAS of the same numbers laid out for it."""
    from tedm_cli.gravity.operator import contract

    rng = np.random.default_rng(2)
    g, d = rng.normal(size=(12, n, 3)), rng.normal(size=(k, n, 3))
    block = 16384

    def blocks() -> object:
        return sum(contract(g[:, i : i + block], d[:, i : i + block]) for i in range(0, n, block))

    return timed(blocks, lambda: -(g.reshape(12, -1) @ d.reshape(k, -1).T))


def operator(cells: tuple[int, int, int]) -> Result:
    """G of one test mass and its field by quadrature at 1e-4, against the same with lumped masses; a structured block.

    The block, 1.0 x 0.6 x 0.4 m of hexahedra with a hollow around the test mass, has about product(cells) grids.
    """
    from tedm_cli.gravity.structure import structure_gravity
    from tedm_cli.gravity.testmass import TestMass

    tm = TestMass(name="TM1", position_m=np.zeros(3), side_m=SIDES, mass_kg=1.96)
    fine, lumped = (_block(cells, lumped) for lumped in (False, True))
    structure_gravity(_block((6, 5, 4), False), tm, tolerance=1e-4)  # compiles
    tracemalloc.start()
    sources = structure_gravity(fine, tm, tolerance=1e-4).sources
    peak = tracemalloc.get_traced_memory()[1] / 1e6
    tracemalloc.stop()
    note = f"{len(fine.position):,} grids, peak {peak:.0f} MB"
    return timed(
        lambda: structure_gravity(fine, tm, tolerance=1e-4),
        lambda: structure_gravity(lumped, tm, tolerance=1e-4),
        note,
        runs=2,
        each=(sources, "quadrature point"),
    )


def _block(cells: tuple[int, int, int], lumped: bool) -> MassDistribution:
    from tedm_cli.gravity.masses import ElementMasses, PointMasses, mass_distribution

    position, nodes = hexahedra(cells, [(0.0, 0.0, 0.0)])
    count = len(nodes)
    return mass_distribution(
        position,
        ElementMasses(
            id=np.arange(1, count + 1),
            card=["CHEXA"] * count,
            mass=np.full(count, 600.0 / count),
            node_offset=np.arange(0, 8 * count + 1, 8),
            node_index=nodes.ravel(),
            lever=np.zeros((8 * count, 3)),
            section=np.zeros(count),
        ),
        PointMasses(name=[], mass=np.zeros(0), node=np.zeros(0, dtype=np.int64), offset=np.zeros((0, 3))),
        lumped=lumped,
    )


@cache
def _nine_calls() -> Callable[..., None]:
    import numba
    from choclo import prism

    e, n, u = prism.gravity_e, prism.gravity_n, prism.gravity_u
    ee, nn, uu = prism.gravity_ee, prism.gravity_nn, prism.gravity_uu
    en, eu, nu = prism.gravity_en, prism.gravity_eu, prism.gravity_nu

    def loop(
        points: FloatArray,
        west: float,
        east: float,
        south: float,
        north: float,
        bottom: float,
        top: float,
        out: FloatArray,
    ) -> None:
        for i in range(points.shape[0]):
            x, y, z = points[i, 0], points[i, 1], points[i, 2]
            out[i, 0] = e(x, y, z, west, east, south, north, bottom, top, 1.0)
            out[i, 1] = n(x, y, z, west, east, south, north, bottom, top, 1.0)
            out[i, 2] = u(x, y, z, west, east, south, north, bottom, top, 1.0)
            out[i, 3] = ee(x, y, z, west, east, south, north, bottom, top, 1.0)
            out[i, 4] = nn(x, y, z, west, east, south, north, bottom, top, 1.0)
            out[i, 5] = uu(x, y, z, west, east, south, north, bottom, top, 1.0)
            out[i, 6] = en(x, y, z, west, east, south, north, bottom, top, 1.0)
            out[i, 7] = eu(x, y, z, west, east, south, north, bottom, top, 1.0)
            out[i, 8] = nu(x, y, z, west, east, south, north, bottom, top, 1.0)

    return numba.njit(loop)  # type: ignore[no-any-return]


@cache
def _shared_corners() -> Callable[..., None]:
    import numba
    from choclo import prism
    from scipy.constants import gravitational_constant

    ee, nn, uu = prism.kernel_ee, prism.kernel_nn, prism.kernel_uu
    en, eu, nu = prism.kernel_en, prism.kernel_eu, prism.kernel_nu

    def loop(
        points: FloatArray,
        west: float,
        east: float,
        south: float,
        north: float,
        bottom: float,
        top: float,
        out: FloatArray,
    ) -> None:
        for i in range(points.shape[0]):
            nine = np.zeros(9)
            for a in range(2):
                x = (west if a else east) - points[i, 0]
                for b in range(2):
                    y = (south if b else north) - points[i, 1]
                    for c in range(2):
                        z = (bottom if c else top) - points[i, 2]
                        r = np.sqrt(x * x + y * y + z * z)
                        sign = -1.0 if (a + b + c) % 2 else 1.0
                        xx, yy, zz = sign * ee(x, y, z, r), sign * nn(x, y, z, r), sign * uu(x, y, z, r)
                        xy, xz, yz = sign * en(x, y, z, r), sign * eu(x, y, z, r), sign * nu(x, y, z, r)
                        nine[0] -= x * xx + y * xy + z * xz
                        nine[1] -= x * xy + y * yy + z * yz
                        nine[2] -= x * xz + y * yz + z * zz
                        nine[3] += xx
                        nine[4] += yy
                        nine[5] += zz
                        nine[6] += xy
                        nine[7] += xz
                        nine[8] += yz
            out[i] = gravitational_constant * nine

    return numba.njit(loop)  # type: ignore[no-any-return]


def _tensor(six: FloatArray) -> FloatArray:
    return six[:, [0, 3, 4, 3, 1, 5, 4, 5, 2]].reshape(-1, 3, 3)


def _worst_errors(points: FloatArray, ours: tuple[FloatArray, FloatArray], peer: tuple[FloatArray, FloatArray]) -> str:
    """Largest relative error of force and gradient of both, over a sample of the points, against 50 digits."""
    sys.path.insert(0, str(Path(__file__).parents[1] / "tests" / "gravity"))
    from gravity_reference import exact_fields
    from scipy.constants import gravitational_constant

    sample = np.linspace(0, len(points) - 1, SAMPLE).astype(int)
    exact = exact_fields(points[sample], SIDES)
    found = []
    for result, factor in ((ours, 1.0), (peer, gravitational_constant)):
        for value, name in zip(result, ("force", "gamma_lin"), strict=True):
            axes = tuple(range(1, value.ndim))
            error = np.abs(value[sample] / factor - exact[name]).max(axis=axes)
            found.append(f"{(error / np.abs(exact[name]).max(axis=axes)).max():.0e}")
    return f"worst error in F, gradient: {found[0]}, {found[1]}; peer {found[2]}, {found[3]}"
