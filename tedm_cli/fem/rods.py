"""Stiffness and thermal coupling of rods: stretch and twist of a straight line between two grids."""

from __future__ import annotations

import numpy as np

from tedm_cli.arrays import FloatArray
from tedm_cli.errors import PhysicsError
from tedm_cli.fem.elements import ElementMatrices, dof_of
from tedm_cli.fem.structure import RodBlock


def rod_matrices(position: FloatArray, block: RodBlock) -> ElementMatrices:
    """Element matrices of all rods; the thermal strain is that of the mean of the two end temperatures.

    Raises
    ------
    PhysicsError
        For rods without length; element ids are listed.
    """
    span = position[block.connectivity[:, 1]] - position[block.connectivity[:, 0]]
    length = np.linalg.norm(span, axis=1)
    if not (length > 0.0).all():
        bad = block.element_id[~(length > 0.0)]
        some = ", ".join(map(str, bad[:10])) + (" ..." if bad.size > 10 else "")
        raise PhysicsError(f"{bad.size} rod(s) with no length: {some}", hint="correct the CROD, CONROD or CTUBE cards")
    axis = span / length[:, None]
    difference = np.zeros((len(length), 2, 12))  # of the stretch and of the twist, end B less end A
    difference[:, 0, 0:3], difference[:, 0, 6:9] = -axis, axis
    difference[:, 1, 3:6], difference[:, 1, 9:12] = -axis, axis
    thrust = block.youngs_modulus * block.area
    rate = np.stack([thrust, block.shear_modulus * block.torsion_constant], axis=1) / length[:, None]
    expansion_load = thrust[:, None] * difference[:, 0]
    half = 0.5 * block.expansion[:, None] * expansion_load
    return ElementMatrices(
        dof=dof_of(block.connectivity, 6),
        grids=block.connectivity,
        stiffness=difference.transpose(0, 2, 1) @ (rate[:, :, None] * difference),
        coupling=np.stack([half, half], axis=2),
        expansion_load=expansion_load,
        reference_temperature=block.reference_temperature,
    )
