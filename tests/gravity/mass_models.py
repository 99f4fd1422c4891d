"""Small mass models for the tests: single elements of any shape at a chosen distance from a test mass."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.spatial.transform import Rotation

from tedm_cli.fem.shapes import Shape, shape_of
from tedm_cli.gravity.constants import G_CODATA_2018
from tedm_cli.gravity.masses import ElementMasses, MassDistribution, PointMasses, mass_distribution
from tedm_cli.gravity.structure import stack_rows, structure_gravity
from tedm_cli.gravity.testmass import TestMass

CUBE = TestMass(name="TM1", position_m=np.zeros(3), side_m=np.full(3, 0.046), mass_kg=1.96)
NO_POINTS = PointMasses(name=[], mass=np.zeros(0), node=np.zeros(0, dtype=np.int64), offset=np.zeros((0, 3)))


def model(
    xyz: np.ndarray,
    elements: list[tuple[str, list[int]]],
    mass: np.ndarray | list[float] | None = None,
    *,
    lever: np.ndarray | None = None,
    thickness: float = 0.0,
    points: PointMasses = NO_POINTS,
    weight: np.ndarray | None = None,
    lumped: bool = False,
) -> MassDistribution:
    """Elements (card, nodes) on the grids `xyz`, of 1 kg each unless `mass` says otherwise."""
    index = np.array([n for _, nodes in elements for n in nodes], dtype=np.int64)
    return mass_distribution(
        np.asarray(xyz, dtype=float),
        ElementMasses(
            id=np.arange(1, len(elements) + 1),
            card=[card for card, _ in elements],
            mass=np.ones(len(elements)) if mass is None else np.asarray(mass, dtype=float),
            node_offset=np.cumsum([0, *(len(nodes) for _, nodes in elements)]),
            node_index=index,
            lever=np.zeros((len(index), 3)) if lever is None else lever,
            section=np.full(len(elements), thickness),
            weight=weight,
        ),
        points,
        lumped=lumped,
    )


def lumped_operator(
    points: np.ndarray,
    masses: np.ndarray,
    test_masses: Sequence[TestMass],
    *,
    G: float = G_CODATA_2018,
    node_ids: np.ndarray | None = None,
) -> np.ndarray:
    """Operator [6 t, n, 3] of point masses on grids of their own."""
    ids = np.arange(len(points)) if node_ids is None else node_ids
    grids = PointMasses(
        name=[f"node {i}" for i in ids],
        mass=np.asarray(masses, dtype=float),
        node=np.arange(len(points)),
        offset=np.zeros((len(points), 3)),
    )
    distribution = model(points, [], points=grids)
    return stack_rows(structure_gravity(distribution, tm, tolerance=1e-3, G=G).operator for tm in test_masses)


def single(card: str, xyz: np.ndarray, *, lumped: bool = False) -> MassDistribution:
    """One element of 1 kg whose nodes are all of `xyz`."""
    return model(xyz, [(card, list(range(len(xyz))))], lumped=lumped)


def brick(low: list[float], high: list[float]) -> np.ndarray:
    """Nodes of an axis-parallel CHEXA8."""
    low_, high_ = np.array(low), np.array(high)
    return low_ + (high_ - low_) * shape_of("CHEXA", 8).reference_nodes()  # type: ignore[union-attr]


def random_element(shape: Shape, gap: float, size: float, rng: np.random.Generator) -> np.ndarray:
    """Nodes of a turned, stretched and distorted element whose distance from `CUBE` is `gap` (m)."""
    xi = shape.reference_nodes() - 0.5
    stretch = np.exp(rng.uniform(np.log(0.15), 0.0, shape.dimension))
    distortion = 0.04 if shape.edges else 0.12
    flat = (xi + distortion * rng.uniform(-1.0, 1.0, xi.shape)) * stretch / stretch.max() * size
    nodes = np.concatenate([flat, np.zeros((len(flat), 3 - shape.dimension))], axis=1)
    if shape.dimension == 2:
        nodes[:, 2] = distortion / 2 * np.ptp(flat, axis=0).min() * rng.uniform(-1.0, 1.0, len(flat))
    nodes = nodes @ Rotation.random(random_state=rng).as_matrix()
    away = rng.normal(size=3)
    away /= np.linalg.norm(away)
    t = np.array(list(np.ndindex(*(9,) * shape.dimension))) / 8.0
    surface = shape.functions(shape.to_element(t))[0] @ nodes

    def distance(shift: float) -> float:
        beyond = np.maximum(0.0, np.abs(surface + shift * away) - CUBE.side_m / 2)
        return float(np.linalg.norm(beyond, axis=1).min())

    low, high = 0.0, 1.0 + gap + size
    for _ in range(50):
        middle = (low + high) / 2
        low, high = (middle, high) if distance(middle) < gap else (low, middle)
    return nodes + high * away
