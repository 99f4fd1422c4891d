"""Stiffness and thermal coupling of flat shells with three or four grids.

Membrane: linear and bilinear displacements; in quadrilaterals the shear strain is its mean over the element (MacNeal, A
simple quadrilateral shell element, Computers & Structures 8, 1978). Bending and transverse shear: Reissner-Mindlin, the
rotations interpolated by the corners and the deflection one degree higher such that the shear strain is constant along
each edge, with a shear stiffness that fades with the thickness over the size of the element so that thin plates do not
lock (MIN4: Tessler & Hughes, Comput. Methods Appl. Mech. Engng. 39, 1983; MIN3: the same, 50, 1985).

The rotation about the normal is tied to the rotation of the mid-surface by a weak penalty, so that rigid rotations stay
free of stress (Zienkiewicz & Taylor, The Finite Element Method, vol. 2, on flat facet shells). The corners of a warped
quadrilateral, and those of an offset shell, hang on the mid-surface by rigid arms along its normal; the arms grow with
the temperature of the element, which leaves free expansion free of stress. A gradient of temperature along the normal
bends an unloaded shell by α times it in every direction; it has no part in the arms, nor in a shell without bending.

Local axes: z is the normal, x and y halve the angles of a quadrilateral's diagonals; a triangle's x is its first side.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from tedm_cli.arrays import BoolArray, FloatArray, IntArray
from tedm_cli.errors import PhysicsError
from tedm_cli.fem.constraints import rigid_body_matrix
from tedm_cli.fem.elements import ElementMatrices, dof_of
from tedm_cli.fem.shapes import Shape, gauss_rule, shape_of
from tedm_cli.fem.structure import ShellBlock

_BLOCK = 4096
# Weight of the bending stiffness of the corners' rotations over their shear stiffness in the correction of the latter:
# the reciprocals of the constants of MIN3 and MIN4.
_SHEAR_CORRECTION = {3: 2.0, 4: 3.6}
# Arms shorter than this share of the element are rounding; they would give rotations a stiffness where there is none.
_FLAT = 1e-12


def shell_matrices(position: FloatArray, block: ShellBlock) -> Iterator[ElementMatrices]:
    """Element matrices of `block`, a few thousand elements at a time.

    The thermal strain that grids give an element is that of the mean of their temperatures, constant through the
    thickness (Nastran Quick Reference Guide, on TEMP).

    Raises
    ------
    PhysicsError
        For shells whose corners are not those of a convex polygon; element ids are listed.
    """
    for start in range(0, len(block.element_id), _BLOCK):
        yield _matrices(position, block, slice(start, min(start + _BLOCK, len(block.element_id))))


def _matrices(position: FloatArray, block: ShellBlock, part: slice) -> ElementMatrices:
    corners = position[block.connectivity[part]]
    e, n = corners.shape[:2]
    axes = _local_axes(corners)
    flat = np.einsum("eij,enj->eni", axes, corners - corners.mean(axis=1, keepdims=True))
    plane = flat[..., :2]
    _require_convex(plane, block.element_id[part])
    height = block.offset[part, None] - flat[..., 2]  # from the grids to the mid-surface
    height[np.abs(height) < _FLAT * np.abs(plane).max(axis=(1, 2))[:, None]] = 0.0
    rates = np.ones((e, 3)) if block.law_rates is None else block.law_rates[part]
    local = _local_stiffness(plane, block, part, rates)

    arm = height[..., None] * axes[:, None, 2]
    turn = np.zeros((e, 6 * n, 6 * n))  # motions of the grids, basic frame, to local motions of the mid-surface
    both = np.zeros((e, 6, 6))
    both[:, :3, :3] = both[:, 3:, 3:] = axes
    for k in range(n):
        at = slice(6 * k, 6 * k + 6)
        turn[:, at, at] = both @ rigid_body_matrix(arm[:, k])
    grown_arms = np.zeros((e, 6 * n, 1))
    grown_arms[:, 2::6, 0] = height
    back = turn.transpose(0, 2, 1)
    push = rates[:, 0, None, None] * _push(plane, block.membrane_stiffness[part])
    expansion_load = (back @ (push - local @ grown_arms))[..., 0]
    share = (block.expansion[part] / n)[:, None, None]
    bend = (rates[:, 1] * block.bending_expansion[part])[:, None, None] * _bend(plane, block.bending_stiffness[part])
    return ElementMatrices(
        dof=dof_of(block.connectivity[part], 6),
        grids=block.connectivity[part],
        stiffness=back @ local @ turn,
        coupling=np.broadcast_to(share * expansion_load[..., None], (e, 6 * n, n)),
        expansion_load=expansion_load,
        reference_temperature=block.reference_temperature[part],
        gradient_load=back @ bend,
    )


def _local_axes(corners: FloatArray) -> FloatArray:
    """Unit axes [e, 3 axes, 3] of shells with corners [e, n, 3]; not finite where a shell has no plane."""
    with np.errstate(invalid="ignore", divide="ignore"):
        if corners.shape[1] == 3:
            side, other = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
            x, z = side, np.cross(side, other)
        else:
            one, two = corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1]
            z = np.cross(one, two)
            x = one / np.linalg.norm(one, axis=1, keepdims=True) - two / np.linalg.norm(two, axis=1, keepdims=True)
        x = x / np.linalg.norm(x, axis=1, keepdims=True)
        z = z / np.linalg.norm(z, axis=1, keepdims=True)
    return np.stack([x, np.cross(z, x), z], axis=1)


def _require_convex(plane: FloatArray, element_id: IntArray) -> None:
    ahead = np.roll(plane, -1, axis=1) - plane
    behind = np.roll(ahead, 1, axis=1)
    turning = behind[..., 0] * ahead[..., 1] - behind[..., 1] * ahead[..., 0]
    size = np.linalg.norm(ahead, axis=2).max(axis=1, keepdims=True) ** 2
    good: BoolArray = (turning > 1e-9 * size).all(axis=1)
    bad = element_id[~good]
    if bad.size:
        some = ", ".join(map(str, bad[:10])) + (" ..." if bad.size > 10 else "")
        raise PhysicsError(
            f"{bad.size} shell(s) whose corners do not make a convex polygon: {some}",
            hint="list the grids of CQUAD4 and CTRIA3 around the element; no inner angle may reach 180 degrees",
        )


def _rule(n: int, order: int) -> tuple[FloatArray, FloatArray]:
    """Integration points ξ [q, 2] and weights [q]; of quadrilaterals `order` points a side."""
    if n == 3:  # the midpoints of the sides, exact for quadratic functions
        return np.array([[0.5, 0.0], [0.5, 0.5], [0.0, 0.5]]), np.full(3, 1.0 / 6.0)
    return gauss_rule((order, order), (0, 0))


def _shape(n: int, nodes: int) -> Shape:
    shape = shape_of("CTRIA3" if n == 3 else "CQUAD4", nodes)
    assert shape is not None
    return shape


def _gradients(plane: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Shape functions of the corners [q, n], their gradients [e, q, n, 2], and weights with the Jacobian [e, q]."""
    n = plane.shape[1]
    point, weight = _rule(n, 2)
    value, slope = _shape(n, n).functions(point)
    inverse, determinant = _jacobian(plane, slope)
    return value, np.einsum("eqij,qnj->eqni", inverse, slope), weight * determinant


def _jacobian(plane: FloatArray, slope: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Inverse [e, q, 2, 2] (d/dx_i = sum over j of inverse[i, j] d/dξ_j) and determinant [e, q] of dx/dξ."""
    jacobian = np.einsum("qnj,eni->eqji", slope, plane)
    return np.linalg.inv(jacobian), np.linalg.det(jacobian)


def _membrane(gradient: FloatArray, weight: FloatArray) -> FloatArray:
    """Strains xx, yy, xy over the six motions of the corners, [e, q, 3, 6 n]."""
    e, q, n, _ = gradient.shape
    strain = np.zeros((e, q, 3, n, 6))
    strain[:, :, 0, :, 0] = strain[:, :, 2, :, 1] = gradient[..., 0]
    strain[:, :, 1, :, 1] = strain[:, :, 2, :, 0] = gradient[..., 1]
    strain[:, :, 2] = (np.einsum("eq,eqnc->enc", weight, strain[:, :, 2]) / weight.sum(axis=1)[:, None, None])[:, None]
    return strain.reshape(e, q, 3, 6 * n)


def _push(plane: FloatArray, stiffness: FloatArray) -> FloatArray:
    """Forces of the membrane [e, 6 n, 1] under a thermal strain of one."""
    _, gradient, weight = _gradients(plane)
    force = np.einsum("eq,eqrd,er->ed", weight, _membrane(gradient, weight), stiffness[:, :, :2].sum(axis=2))
    return np.asarray(force[..., None])


def _bend(plane: FloatArray, stiffness: FloatArray) -> FloatArray:
    """Moments of the plate [e, 6 n, 1] under curvatures xx and yy of one."""
    _, gradient, weight = _gradients(plane)
    moment = np.einsum("eq,eqrd,er->ed", weight, _curvature(gradient), stiffness[:, :, :2].sum(axis=2))
    return np.asarray(moment[..., None])


def _curvature(gradient: FloatArray) -> FloatArray:
    """Curvatures ry,x; -rx,y; ry,y - rx,x over the six motions of the corners, [e, q, 3, 6 n]."""
    e, q, n, _ = gradient.shape
    curvature = np.zeros((e, q, 3, n, 6))
    curvature[:, :, 0, :, 4] = curvature[:, :, 2, :, 3] = gradient[..., 0]
    curvature[:, :, 1, :, 3] = curvature[:, :, 2, :, 4] = gradient[..., 1]
    curvature[:, :, :, :, 3] *= -1.0
    return curvature.reshape(e, q, 3, 6 * n)


def _local_stiffness(plane: FloatArray, block: ShellBlock, part: slice, rates: FloatArray) -> FloatArray:
    """Stiffness [e, 6 n, 6 n] of shells with corners [e, n, 2] in their own axes, or its change by rates [e, 3].

    The stiffness is homogeneous in membrane, bending and shear: it is its own change where all rates are one.
    """
    value, gradient, weight = _gradients(plane)
    e, q, n, _ = gradient.shape
    drilling = np.zeros((e, q, 1, n, 6))  # rz - (v,x - u,y) / 2
    drilling[:, :, 0, :, 5] = value
    drilling[:, :, 0, :, 0], drilling[:, :, 0, :, 1] = 0.5 * gradient[..., 1], -0.5 * gradient[..., 0]

    in_plane, plate_rate, shear_rate = rates.T
    stiffness = _energy(_membrane(gradient, weight), block.membrane_stiffness[part], weight)
    stiffness += _energy(drilling.reshape(e, q, 1, 6 * n), block.drilling_stiffness[part, None, None], weight)
    stiffness *= in_plane[:, None, None]
    bending = _energy(_curvature(gradient), block.bending_stiffness[part], weight)
    shear = _energy(*_shear(plane))
    turning = (np.arange(6 * n) % 6 > 2) & (np.arange(6 * n) % 6 < 5)
    bent = np.diagonal(bending, axis1=1, axis2=2)[:, turning].sum(axis=1)
    sheared = np.diagonal(shear, axis1=1, axis2=2)[:, turning].sum(axis=1)
    corrected = np.zeros(e)
    plate = bent > 0.0
    own = 1.0 / block.shear_stiffness[part][plate]
    fading = sheared[plate] / (_SHEAR_CORRECTION[n] * bent[plate])
    share = 1.0 - fading / (own + fading)  # of the shear's own flexibility in the whole
    rate = share * shear_rate[plate] + (1.0 - share) * plate_rate[plate]
    corrected[plate] = rate / (own + fading)
    return np.asarray(stiffness + plate_rate[:, None, None] * bending + corrected[:, None, None] * shear)


def _energy(strain: FloatArray, law: FloatArray, weight: FloatArray) -> FloatArray:
    """Integral [e, d, d] of strainᵀ law strain: strain [e, q, r, d], law [e, r, r], weight [e, q]."""
    stress = weight[:, :, None, None] * (law[:, None] @ strain)
    e, q, r, d = strain.shape
    return np.asarray(strain.reshape(e, q * r, d).transpose(0, 2, 1) @ stress.reshape(e, q * r, d))


def _shear(plane: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Transverse shear strains xz, yz over the corners' motions [e, q, 2, 6 n], the unit law, and weights [e, q].

    Along an edge from corner i to corner j, at d, the deflection exceeds the linear one by 4 t (1 - t) (b_j - b_i) / 8
    with b = ry d_x - rx d_y, so that the shear strain along the edge is constant.
    """
    e, n, _ = plane.shape
    point, weight = _rule(n, 3)
    value, slope = _shape(n, n).functions(point)
    quadratic = _shape(n, 2 * n)
    inverse, determinant = _jacobian(plane, slope)
    deflection = np.zeros((e, len(point), 2, n, 6))
    deflection[..., 2] = np.einsum("eqij,qnj->eqin", inverse, slope)
    deflection[:, :, 0, :, 4], deflection[:, :, 1, :, 3] = value, -value
    bulge = np.einsum("eqij,qmj->meqi", inverse, quadratic.functions(point)[1][:, n:]) / 8.0
    for (i, j), one in zip(quadratic.edges, bulge, strict=True):
        span = plane[:, j] - plane[:, i]
        for corner, sign in ((i, -1.0), (j, 1.0)):
            deflection[:, :, :, corner, 4] += sign * one * span[:, None, None, 0]
            deflection[:, :, :, corner, 3] -= sign * one * span[:, None, None, 1]
    if n == 4:
        _add_bubble(deflection, plane, point, inverse)
    return (
        deflection.reshape(e, len(point), 2, 6 * n),
        np.broadcast_to(np.eye(2), (e, 2, 2)),
        weight * determinant,
    )


def _add_bubble(deflection: FloatArray, plane: FloatArray, point: FloatArray, inverse: FloatArray) -> None:
    """Give the deflection of quadrilaterals the term that a constant curvature has where they are no parallelogram.

    With x = x0 + ξ a + η b + ξ η d, ξ and η from -1 to 1, half a curvature times x x holds ξ² η² d d, which the sides
    do not determine: it is taken from the curvature at the centre. Without it constant bending is not reproduced.
    """
    d = 0.25 * (plane[:, 0] - plane[:, 1] + plane[:, 2] - plane[:, 3])
    slope = _shape(4, 4).functions(np.array([[0.5, 0.5]]))[1]
    centre = np.einsum("eqij,qnj->eni", _jacobian(plane, slope)[0], slope)
    along = 0.5 * np.einsum("eni,ei->en", centre, d)[:, None, None, :]
    t = point * (1.0 - point)
    gradient = 16.0 * np.stack([(1.0 - 2.0 * point[:, 0]) * t[:, 1], (1.0 - 2.0 * point[:, 1]) * t[:, 0]], axis=1)
    bubble = np.einsum("eqij,qj->eqi", inverse, gradient)[..., None]
    deflection[..., 4] -= bubble * along * d[:, None, None, None, 0]
    deflection[..., 3] += bubble * along * d[:, None, None, None, 1]
