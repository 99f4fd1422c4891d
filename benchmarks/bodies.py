"""Bodies of test masses other than the cuboid: polyhedra against polyhedral-gravity, the others against the cuboid."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from benchmarks.timing import Result, timed
from tedm_cli.arrays import FloatArray
from tedm_cli.gravity.bodies.body import Body
from tedm_cli.gravity.bodies.composite import Composite, Pocket
from tedm_cli.gravity.bodies.cuboid import Cuboid, Sphere
from tedm_cli.gravity.bodies.cylinder import Cylinder
from tedm_cli.gravity.bodies.polyhedron import Polyhedron, chamfered_cuboid, convex_hull

SIDES, Z = np.full(3, 0.046), np.array([0.0, 0.0, 1.0])
NEAR, FAR = (1.02, 1.45), (2.0, 12.0)  # distances over the radius of the body: closed form, and expansion
POINTS = 4_000


def cut_cube() -> Polyhedron:
    """Cube with chamfered edges: 60 triangles in 18 facets."""
    return chamfered_cuboid(SIDES, 0.002)


def ball(corners: int = 642) -> Polyhedron:
    """Convex hull of points on a sphere, evenly spread: 2 (corners - 2) triangles."""
    n = np.arange(corners) + 0.5
    polar, turn = np.arccos(1.0 - 2.0 * n / corners), np.pi * (1.0 + np.sqrt(5.0)) * n
    corner = 0.03 * np.stack([np.cos(turn) * np.sin(polar), np.sin(turn) * np.sin(polar), np.cos(polar)], axis=1)
    return convex_hull(corner)


def pocketed() -> Body:
    """The chamfered cube with two round recesses."""
    recess = [Cylinder(Z, np.zeros(3), 0.005, *ends) for ends in ((0.02, 0.023), (-0.023, -0.02))]
    up, none = (False, False, True), (False, False, False)
    return Composite([cut_cube()], [Pocket(recess[0], none, up), Pocket(recess[1], up, none)])


OTHERS: dict[str, Callable[[], Body]] = {
    "sphere": lambda: Sphere(0.03),
    "cylinder": lambda: Composite([Cylinder(Z, np.zeros(3), 0.02, -0.02, 0.02)]),
    "chamfered cube": lambda: Composite([cut_cube()]),
    "chamfered cube with two recesses": pocketed,
}


def points_around(radius: float, limits: tuple[float, float]) -> FloatArray:
    rng = np.random.default_rng(1)
    direction = rng.normal(size=(POINTS, 3))
    direction /= np.linalg.norm(direction, axis=1, keepdims=True)
    nearest, farthest = np.log(limits).tolist()
    return np.asarray(direction * radius * np.exp(rng.uniform(nearest, farthest, (POINTS, 1))))


def against_cuboid(make: Callable[[], Body], limits: tuple[float, float]) -> Result:
    """All six quantities, on one thread, against those of a cube at as many points as far in terms of its radius."""
    body, cube = make(), Cuboid(SIDES)
    points, others = points_around(body.radius_m, limits), points_around(cube.radius_m, limits)
    return timed(lambda: body.field(points), lambda: cube.field(others), each=(POINTS, "source"))


def against_polyhedral_gravity(make: Callable[[], Polyhedron], limits: tuple[float, float]) -> Result:
    """Force and gradient of a polyhedron on one thread; the peer returns the potential as well."""
    import polyhedral_gravity as peer

    solid = make()
    body = Composite([solid])
    points = points_around(body.radius_m, limits)
    moved = body.solids[0]
    theirs = peer.GravityEvaluable(
        peer.Polyhedron(
            (solid.corner_m - body.centre_m, solid.triangle),
            1.0 / moved.volume_m3,
            metric_unit=peer.MetricUnit.UNITLESS,
            integrity_check=peer.PolyhedronIntegrity.DISABLE,
        )
    )
    listed = points.tolist()
    found = np.array([row[2] for row in theirs(listed, parallel=False)])[:, [0, 3, 4, 3, 1, 5, 4, 5, 2]]
    gamma = body.force_gradient(points)[1].reshape(-1, 9)
    apart = (np.abs(found - gamma).max(axis=1) / np.abs(gamma).max(axis=1)).max()
    return timed(
        lambda: body.force_gradient(points),
        lambda: theirs(listed, parallel=False),
        f"gradients apart by {apart:.0e}",
        each=(POINTS, "source"),
    )
