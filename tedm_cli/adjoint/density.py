"""Gravity of the mass of some elements: what their density does to the accelerations."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from tedm_cli.adjoint.outputs import acceleration_outputs
from tedm_cli.arrays import BoolArray, FloatArray
from tedm_cli.fem.parts import NodalForces
from tedm_cli.gravity.masses import ElementMasses, PointMasses, mass_distribution
from tedm_cli.gravity.structure import stack_rows, structure_gravity
from tedm_cli.gravity.testmass import TestMass
from tedm_cli.threads import side_by_side


@dataclass(frozen=True, kw_only=True)
class GravitySum:
    """How the gravity of the model is summed: see `structure_gravity`; `lumped`: see `mass_distribution`."""

    test_masses: Sequence[TestMass]
    tolerance: float
    constant: float
    lumped: bool


def gravity_share(
    position: FloatArray,
    masses: ElementMasses,
    members: BoolArray,
    how: GravitySum,
    advance: Callable[[int], None],
) -> NodalForces:
    """Rows of -G by the mass of some `members` [E] of the elements, [n, 6 t]; `advance`: see `structure_gravity`.

    Raises
    ------
    PhysicsError
        As `structure_gravity`.
    """
    counts = np.diff(masses.node_offset)
    rows = np.flatnonzero(np.repeat(members, counts))
    grids, index = np.unique(masses.node_index[rows], return_inverse=True)
    part = ElementMasses(
        id=masses.id[members],
        card=[masses.card[e] for e in np.flatnonzero(members)],
        mass=masses.mass[members],
        node_offset=np.concatenate([[0], np.cumsum(counts[members])]),
        node_index=index,
        lever=masses.lever[rows],
        section=masses.section[members],
        weight=None if masses.weight is None else masses.weight[rows],
    )
    none = PointMasses(name=[], mass=np.zeros(0), node=np.zeros(0, dtype=np.int64), offset=np.zeros((0, 3)))
    distribution = mass_distribution(position[grids], part, none, lumped=how.lumped, grid_id=grids)
    found = side_by_side(
        lambda tm, on: structure_gravity(distribution, tm, tolerance=how.tolerance, G=how.constant, advance=on),
        how.test_masses,
        advance,
    )
    force = acceleration_outputs(
        stack_rows([f.operator for f in found]), distribution.lever_node, stack_rows([f.rotation for f in found])
    )
    return NodalForces(dof=(6 * grids[:, None] + np.arange(6)).ravel(), force=force)
