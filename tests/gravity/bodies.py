"""Bodies that the tests of all kinds of them share, about their centres of mass, and points outside them."""

import numpy as np

from tedm_cli.gravity.bodies.box import Box
from tedm_cli.gravity.bodies.composite import Composite, Pocket
from tedm_cli.gravity.bodies.cuboid import Cuboid, Sphere
from tedm_cli.gravity.bodies.cylinder import Cylinder
from tedm_cli.gravity.bodies.polyhedron import Polyhedron, chamfered_cuboid
from tedm_cli.gravity.bodies.solid import cuboid_mesh

HALF = 0.023
CUBE = Cuboid([2 * HALF] * 3)
Z = np.array([0.0, 0.0, 1.0])
NOT, UP = (False, False, False), (False, False, True)


def cube_of_triangles():
    return Composite([Polyhedron(*cuboid_mesh(np.full(3, -HALF), np.full(3, HALF)))])


def eight_cuboids():
    ends = (-HALF, HALF)
    return Composite([Box(*np.sort([[0.0] * 3, [a, b, c]], axis=0)) for a in ends for b in ends for c in ends])


def tetrahedron():
    corner = np.array([[0, 0, 0], [0.05, 0.004, 0], [0.01, 0.04, 0.003], [0.013, 0.009, 0.06]])
    return Composite([Polyhedron(corner, np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]]))])


def chamfered():
    return Composite([chamfered_cuboid(np.full(3, 2 * HALF), 0.003)])


def cylinder(axis=Z, radius=0.02, half=0.03):
    return Composite([Cylinder(np.asarray(axis, dtype=float), np.zeros(3), radius, -half, half)])


def tube():
    outer, bore = (Cylinder(Z, np.zeros(3), r, -0.02, 0.02) for r in (0.025, 0.015))
    return Composite([outer], [Pocket(bore, UP, UP, "bore")])


SKEW = np.array([2.0, -1.0, 2.0]) / 3.0


def with_pockets():
    """Chamfered cube with a round recess in its upper face off the middle and a cuboid one in its side."""
    upper = Pocket(Cylinder(Z, np.array([0.004, -0.003, 0.0]), 0.006, 0.018, HALF), NOT, UP, "upper")
    side = Pocket(
        Box(np.array([0.019, -0.005, -0.012]), np.array([HALF, 0.005, 0.002])), NOT, (True, False, False), "side"
    )
    return Composite([chamfered_cuboid(np.full(3, 2 * HALF), 0.003)], [upper, side])


def notched():
    """A cuboid less a step along one of its edges: the step and the cuboid share an edge and three planes."""
    base = Box(np.array([-0.02, -0.015, -0.01]), np.array([0.02, 0.015, 0.01]))
    step = Pocket(
        Box(np.array([0.012, -0.015, 0.004]), np.array([0.02, 0.015, 0.01])),
        (False, True, False),
        (True, True, True),
        "step",
    )
    return Composite([base], [step])


ALL = {
    "cuboid": Cuboid([0.05, 0.03, 0.04]),
    "cube of triangles": cube_of_triangles(),
    "eight cuboids": eight_cuboids(),
    "tetrahedron": tetrahedron(),
    "chamfered": chamfered(),
    "cylinder": cylinder(),
    "skew cylinder": cylinder(SKEW, 0.015, 0.01),
    "tube": tube(),
    "sphere": Sphere(0.03),
    "pockets": with_pockets(),
    "notched": notched(),
}


def points_outside(body, count, low=-5.0, high=2.5, seed=1):
    """Points off the surface by 10**low to 10**high of the radius, evenly in the exponent, [count, 3]."""
    rng = np.random.default_rng(seed)
    surface = body.surface()
    normal = np.cross(surface[:, 1] - surface[:, 0], surface[:, 2] - surface[:, 0])
    area = np.linalg.norm(normal, axis=1)
    points, wanted = np.empty((count, 3)), np.arange(count)
    while wanted.size:
        t = rng.choice(len(surface), wanted.size, p=area / area.sum())
        foot = np.einsum("nk,nkc->nc", rng.dirichlet([1.0, 1.0, 1.0], wanted.size), surface[t])
        way = (normal[t] / area[t, None] + 0.3 * rng.normal(size=foot.shape)) * body.radius_m
        foot = _out_of(body, foot, way)
        points[wanted] = foot + way * 10.0 ** (low + (high - low) * wanted / count)[:, None]
        wanted = wanted[body.contains(points[wanted])]
    return points


def _out_of(body, foot, way, most=0.02):
    """Where the ways [n, 3] from points of the drawn surface, which is inside where the body is round, leave it."""
    leaves = np.flatnonzero(body.contains(foot) & ~body.contains(foot + most * way))
    inner, outer = np.zeros((leaves.size, 1)), np.full((leaves.size, 1), most)
    for _ in range(45 if leaves.size else 0):
        middle = (inner + outer) / 2
        inside = body.contains(foot[leaves] + middle * way[leaves])[:, None]
        inner, outer = np.where(inside, middle, inner), np.where(inside, outer, middle)
    foot[leaves] += outer * way[leaves]
    return foot
