"""Total mass, centre of gravity and moments of inertia of a mass distribution."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from tedm_cli.arrays import FloatArray
from tedm_cli.fem.measure import blocks, whole_rule
from tedm_cli.gravity.masses import MassDistribution


@dataclass(frozen=True, eq=False)
class MassProperties:
    """Mass, centre of gravity [3] and inertia [3, 3] about it, ∫ (r² 1 - r rᵀ) dm, in the basic frame."""

    mass_kg: float
    centre_m: FloatArray
    inertia_kg_m2: FloatArray


def mass_properties(distribution: MassDistribution, own_inertia: FloatArray | None = None) -> MassProperties:
    """Moments of a mass distribution by Gauss quadrature over whole elements (see `tedm_cli.fem.measure`).

    Plates count as surfaces and line elements as lines: the inertia about their own middle is left out.

    Parameters
    ----------
    own_inertia : [3, 3], sum of the inertia of concentrated masses about their own centres, kg m².
    """
    mass, first, second = 0.0, np.zeros(3), np.zeros((3, 3))
    # moments about a place within the model keep the digits of a small model far from the origin
    origin = distribution.position.mean(axis=0)
    for m, x in _pieces(distribution):
        r = x - origin
        mass += float(m.sum())
        first += m @ r
        second += (m[:, None] * r).T @ r
    centre = first / mass
    inertia = _tensor(second - mass * np.multiply.outer(centre, centre))
    return MassProperties(mass, origin + centre, inertia if own_inertia is None else inertia + own_inertia)


def _pieces(distribution: MassDistribution) -> Iterator[tuple[FloatArray, FloatArray]]:
    points = distribution.points
    yield points.mass, distribution.position[points.node] + points.offset
    for block in distribution.elements:
        for part in blocks(len(block.id)):
            x = distribution.position[block.nodes[part]] + block.offset[part]
            values, weight = whole_rule(block.shape, x)
            if block.weight is not None:
                weight = weight * (block.weight[part] @ values.T)
            m = block.mass[part, None] * weight / weight.sum(axis=1, keepdims=True)
            yield m.ravel(), (values @ x).reshape(-1, 3)


def _tensor(second: FloatArray) -> FloatArray:
    return np.asarray(np.trace(second) * np.eye(3) - second)
