"""Stiffness and thermal coupling of straight bars.

Local axes: x from end A to end B, plane 1 spanned by x and the orientation vector, z normal to plane 1. Each end has
three translations and three rotations (Przemieniecki, Theory of Matrix Structural Analysis, section 5.6, shear
deformation included, with a product of inertia added to the bending energy).

Gradients of temperature T'1 along y and T'2 along z are Nastran's: moments of the temperature over the section, divided
by I1 and I2 (MSC Nastran Quick Reference Guide, TEMPRB), linear along the bar. An unloaded bar then has the
curvatures -α I1 T'1 and -α I2 T'2 times the inverse of the matrix of I1, I12 and I2; its forces undo them.
"""

from __future__ import annotations

import numpy as np

from tedm_cli.arrays import BoolArray, FloatArray, IntArray
from tedm_cli.errors import PhysicsError
from tedm_cli.fem.constraints import rigid_body_matrix
from tedm_cli.fem.elements import ElementMatrices, dof_of
from tedm_cli.fem.structure import BarBlock

# Local degrees of freedom (end A: u v w rx ry rz, then end B) of bending in plane 1 and in plane 2, in the order
# deflection A, slope A, deflection B, slope B. The slope of w is minus the rotation about y.
_PLANE_1 = np.array([1, 5, 7, 11])
_PLANE_2 = np.array([2, 4, 8, 10])
_SIGN_2 = np.array([1.0, -1.0, 1.0, -1.0])
# Released freedoms between which the bar has less than this share of its stiffness are free of each other.
_RANK_TOLERANCE = 1e-10
_ROUNDING = 1e-13


def bar_matrices(position: FloatArray, block: BarBlock) -> ElementMatrices:
    """Element matrices of all bars; the stretch is that of the mean of the two end temperatures.

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
    local = _local_stiffness(length, block)
    thrust = block.youngs_modulus * block.area
    push = np.zeros((n, 12, 5))  # of a thermal strain of one, then of gradients of one
    push[:, 0, 0], push[:, 6, 0] = -thrust, thrust
    push[:, :, 1:] = local[:, :, :6] @ _unloaded(length, block)
    local, push = _release(local, push, block.released)

    turn = np.zeros((n, 12, 12))  # motions of the grids in the basic frame to motions of the ends along the bar's axes
    for k in range(0, 12, 3):
        turn[:, k : k + 3, k : k + 3] = axes
    for number, end in enumerate((slice(0, 6), slice(6, 12))):
        turn[:, end, end] = turn[:, end, end] @ rigid_body_matrix(block.offset[:, number])
    back = turn.transpose(0, 2, 1)
    half = 0.5 * block.expansion[:, None] * (back @ push[:, :, :1])[..., 0]
    # The uniform expansion that tests the elements is of everything, rigid arms included.
    arms = np.zeros((n, 12))
    arms[:, 0:3] = (axes @ block.offset[:, 0, :, None])[..., 0]
    arms[:, 6:9] = (axes @ block.offset[:, 1, :, None])[..., 0]
    return ElementMatrices(
        dof=dof_of(block.connectivity, 6),
        grids=block.connectivity,
        stiffness=back @ local @ turn,
        coupling=np.stack([half, half], axis=2),
        expansion_load=(back @ (push[:, :, :1] - local @ arms[:, :, None]))[..., 0],
        reference_temperature=block.reference_temperature,
        gradient_load=back @ push[:, :, 1:],
    )


def _unloaded(length: FloatArray, block: BarBlock) -> FloatArray:
    """Motions of end A of unloaded bars of which end B is held, [B, 6, 4], per gradient as in `ElementMatrices`.

    The curvature of an unloaded bar is linear along it, whether shear deforms it or not.
    """
    inertia = np.stack([block.inertia_1, block.inertia_12, block.inertia_12, block.inertia_2], 1).reshape(-1, 2, 2)
    curvature = -block.expansion[:, None, None] * np.eye(2)  # [B, plane of it, plane of the gradient]
    oblique = block.inertia_12 != 0.0
    own = inertia[oblique] * np.eye(2)
    curvature[oblique] = -block.expansion[oblique, None, None] * np.linalg.solve(inertia[oblique], own)
    out = np.zeros((len(length), 6, 2, 2))  # by end and plane of the gradient
    for end, share in ((0, 1.0 / 6.0), (1, 1.0 / 3.0)):
        out[:, 1:3, end] = share * length[:, None, None] ** 2 * curvature
        out[:, 5, end] = -0.5 * length[:, None] * curvature[:, 0]
        out[:, 4, end] = 0.5 * length[:, None] * curvature[:, 1]
    return out.reshape(len(length), 6, 4)


def _local_stiffness(length: FloatArray, block: BarBlock) -> FloatArray:
    """Stiffness along the bars' axes, [B, 12, 12]."""
    local = np.zeros((len(length), 12, 12))
    axial = block.youngs_modulus * block.area / length
    torsion = block.shear_modulus * block.torsion_constant / length
    for stiffness, first in ((axial, 0), (torsion, 3)):
        for i, j, sign in ((0, 0, 1.0), (6, 6, 1.0), (0, 6, -1.0), (6, 0, -1.0)):
            local[:, first + i, first + j] = sign * stiffness
    for rows, row_sign, columns, column_sign, inertia, plane in (
        (_PLANE_1, np.ones(4), _PLANE_1, np.ones(4), block.inertia_1, 0),
        (_PLANE_2, _SIGN_2, _PLANE_2, _SIGN_2, block.inertia_2, 1),
        (_PLANE_1, np.ones(4), _PLANE_2, _SIGN_2, block.inertia_12, None),
        (_PLANE_2, _SIGN_2, _PLANE_1, np.ones(4), block.inertia_12, None),
    ):
        rigidity = block.youngs_modulus * inertia
        shear = np.zeros_like(length)  # shear over bending flexibility
        if plane is not None:
            factor = np.nan_to_num(block.shear_factor[:, plane], posinf=0.0)
            carrying = block.shear_modulus * factor * block.area
            flexible = (carrying > 0.0) & (block.inertia_12 == 0.0) & (rigidity > 0.0)
            np.divide(12.0 * rigidity, carrying * length**2, out=shear, where=flexible)
        bending = rigidity[:, None, None] * _bending(length, shear)
        local[:, rows[:, None], columns] += bending * np.outer(row_sign, column_sign)
    return local


def _release(local: FloatArray, push: FloatArray, released: BoolArray) -> tuple[FloatArray, FloatArray]:
    """Stiffness [B, 12, 12] and forces [B, 12, m] after the released freedoms have followed the others freely."""
    local, push = local.copy(), push.copy()
    for k in np.flatnonzero(released.any(axis=1)):
        whole, thrust = np.sqrt(np.diagonal(local[k])), np.abs(push[k]).max(axis=0)
        out = np.flatnonzero(released[k] & (whole > 0.0))
        size = np.outer(whole[out], whole[out])
        inverse = np.linalg.pinv(local[k][np.ix_(out, out)] / size, rcond=_RANK_TOLERANCE, hermitian=True) / size
        follow = local[k][:, out] @ inverse
        push[k] -= follow @ push[k][out]
        local[k] -= follow @ local[k][out]
        local[k][released[k]] = local[k][:, released[k]] = push[k][released[k]] = 0.0
        # What cancels leaves rounding, which would be a stiffness where there is none.
        local[k][np.abs(local[k]) < _ROUNDING * np.outer(whole, whole)] = 0.0
        push[k][np.abs(push[k]) < _ROUNDING * thrust] = 0.0
    return local, push


def _local_axes(position: FloatArray, block: BarBlock) -> tuple[FloatArray, FloatArray]:
    """Lengths [B] and unit axes [B, 3 axes, 3] in the basic frame."""
    ends = position[block.connectivity] + block.offset
    span = ends[:, 1] - ends[:, 0]
    length = np.linalg.norm(span, axis=1)
    _require(length > 0.0, block.element_id, "no length")
    x = span / length[:, None]
    z = np.cross(x, block.orientation)
    height = np.linalg.norm(z, axis=1)
    upright = height > 1e-8 * np.linalg.norm(block.orientation, axis=1)
    _require(upright, block.element_id, "an orientation vector along the bar")
    z /= height[:, None]
    return length, np.stack([x, np.cross(z, x), z], axis=1)


def _bending(length: FloatArray, shear: FloatArray) -> FloatArray:
    """Bending stiffness over the rigidity E I, [B, 4, 4]; `shear` is 12 E I / (K A G L²)."""
    one = np.ones_like(length)
    first = [12.0 * one, 6.0 * length, -12.0 * one, 6.0 * length]
    second = [first[1], (4.0 + shear) * length**2, -first[1], (2.0 - shear) * length**2]
    third = [-entry for entry in first]
    fourth = [first[1], second[3], -first[1], second[1]]
    table = np.array([first, second, third, fourth])  # [4, 4, B]
    return np.asarray(np.moveaxis(table, 2, 0) / ((1.0 + shear) * length**3)[:, None, None])


def _require(good: BoolArray, element_id: IntArray, fact: str) -> None:
    bad = element_id[~good]
    if bad.size:
        some = ", ".join(map(str, bad[:10])) + (" ..." if bad.size > 10 else "")
        raise PhysicsError(f"{bad.size} bar(s) with {fact}: {some}", hint="correct the CBAR, GRID or PBAR cards")
