"""Stiffness and thermal coupling of straight Euler-Bernoulli bars.

Local axes: x from end A to end B, plane 1 spanned by x and the orientation vector, z normal to plane 1. Each end has
three translations and three rotations (Przemieniecki, Theory of Matrix Structural Analysis, section 5.6, with a product
of inertia added to the bending energy).
"""

from __future__ import annotations

import numpy as np

from tedm_cli.errors import PhysicsError
from tedm_cli.fem.elements import ElementMatrices, dof_of
from tedm_cli.fem.structure import BarBlock, Bools, Floats, Ints

# Local degrees of freedom (end A: u v w rx ry rz, then end B) of bending in plane 1 and in plane 2, in the order
# deflection A, slope A, deflection B, slope B. The slope of w is minus the rotation about y.
_PLANE_1 = np.array([1, 5, 7, 11])
_PLANE_2 = np.array([2, 4, 8, 10])
_SIGN_2 = np.array([1.0, -1.0, 1.0, -1.0])


def bar_matrices(position: Floats, block: BarBlock) -> ElementMatrices:
    """Element matrices of all bars.

    Raises
    ------
    PhysicsError
        For a bar without length, an orientation vector along the bar, or I1 I2 <= I12²; element ids are listed.
    """
    length, axes = _local_axes(position, block)
    _require(
        (block.inertia_1 * block.inertia_2 > block.inertia_12**2) | (block.inertia_12 == 0.0),
        block.element_id,
        "I12² not below I1 I2",
    )
    n = len(length)
    local = np.zeros((n, 12, 12))
    axial = block.youngs_modulus * block.area / length
    torsion = block.shear_modulus * block.torsion_constant / length
    for stiffness, first in ((axial, 0), (torsion, 3)):
        for i, j, sign in ((0, 0, 1.0), (6, 6, 1.0), (0, 6, -1.0), (6, 0, -1.0)):
            local[:, first + i, first + j] = sign * stiffness

    bending = _bending(length) * block.youngs_modulus[:, None, None]
    for rows, row_sign, columns, column_sign, inertia in (
        (_PLANE_1, np.ones(4), _PLANE_1, np.ones(4), block.inertia_1),
        (_PLANE_2, _SIGN_2, _PLANE_2, _SIGN_2, block.inertia_2),
        (_PLANE_1, np.ones(4), _PLANE_2, _SIGN_2, block.inertia_12),
        (_PLANE_2, _SIGN_2, _PLANE_1, np.ones(4), block.inertia_12),
    ):
        local[:, rows[:, None], columns] += inertia[:, None, None] * bending * np.outer(row_sign, column_sign)

    rotation = np.zeros((n, 12, 12))  # basic to local, one 3x3 per translation and rotation of each end
    for k in range(0, 12, 3):
        rotation[:, k : k + 3, k : k + 3] = axes
    expansion_load = np.zeros((n, 12))
    thrust = (block.youngs_modulus * block.area)[:, None] * axes[:, 0]
    expansion_load[:, :3], expansion_load[:, 6:9] = -thrust, thrust
    # The thermal strain is that of the mean of the two end temperatures.
    half = 0.5 * block.expansion[:, None] * expansion_load
    return ElementMatrices(
        dof=dof_of(block.connectivity, 6),
        grids=block.connectivity,
        stiffness=rotation.transpose(0, 2, 1) @ local @ rotation,
        coupling=np.stack([half, half], axis=2),
        expansion_load=expansion_load,
        reference_temperature=block.reference_temperature,
    )


def _local_axes(position: Floats, block: BarBlock) -> tuple[Floats, Floats]:
    """Lengths [B] and unit axes [B, 3 axes, 3] in the basic frame."""
    span = position[block.connectivity[:, 1]] - position[block.connectivity[:, 0]]
    length = np.linalg.norm(span, axis=1)
    _require(length > 0.0, block.element_id, "no length")
    x = span / length[:, None]
    z = np.cross(x, block.orientation)
    height = np.linalg.norm(z, axis=1)
    upright = height > 1e-8 * np.linalg.norm(block.orientation, axis=1)
    _require(upright, block.element_id, "an orientation vector along the bar")
    z /= height[:, None]
    return length, np.stack([x, np.cross(z, x), z], axis=1)


def _bending(length: Floats) -> Floats:
    """Integral of the products of the cubic shape functions' curvatures, [B, 4, 4]."""
    one = np.ones_like(length)
    first = [12.0 * one, 6.0 * length, -12.0 * one, 6.0 * length]
    second = [first[1], 4.0 * length**2, -first[1], 2.0 * length**2]
    third = [-entry for entry in first]
    fourth = [first[1], second[3], -first[1], second[1]]
    table = np.array([first, second, third, fourth])  # [4, 4, B]
    return np.asarray(np.moveaxis(table, 2, 0) / length[:, None, None] ** 3)


def _require(good: Bools, element_id: Ints, fact: str) -> None:
    bad = element_id[~good]
    if bad.size:
        some = ", ".join(map(str, bad[:10])) + (" ..." if bad.size > 10 else "")
        raise PhysicsError(f"{bad.size} bar(s) with {fact}: {some}", hint="correct the CBAR, GRID or PBAR cards")
