"""Stiffness [6, 6] and thermal expansion [6] of linear elastic materials, and their rotation.

Components are in Nastran's order xx, yy, zz, xy, yz, zx with engineering shear strains: the expansion's last three are
twice the tensor's components.
"""

from __future__ import annotations

import numpy as np

from tedm_cli.arrays import FloatArray

PAIRS = ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 0))
"""Tensor indices of the six components."""

ISOTROPIC = np.array([1.0, 1.0, 1.0, 0.0, 0.0, 0.0])
"""A strain of one in all directions."""


def isotropic_stiffness(youngs_modulus: float, poisson_ratio: float) -> FloatArray:
    """Stiffness [6, 6] in Pa (Timoshenko & Goodier, Theory of Elasticity, section 6)."""
    nu = poisson_ratio
    stiffness = np.zeros((6, 6))
    stiffness[:3, :3] = nu
    stiffness[range(3), range(3)] = 1.0 - nu
    stiffness[range(3, 6), range(3, 6)] = 0.5 - nu
    return stiffness * (youngs_modulus / ((1.0 + nu) * (1.0 - 2.0 * nu)))


def orthotropic_stiffness(
    youngs_modulus: FloatArray, poisson_ratio: FloatArray, shear_modulus: FloatArray
) -> FloatArray:
    """Stiffness [6, 6] in Pa from E1, E2, E3, from NU12, NU13, NU23 and from G12, G13, G23.

    NU12 is the contraction along the second axis under stress along the first (Jones, Mechanics of Composite Materials,
    section 2.2).
    """
    e, (nu12, nu13, nu23), (g12, g13, g23) = youngs_modulus, poisson_ratio, shear_modulus
    compliance = np.diag([*(1.0 / e), 1.0 / g12, 1.0 / g23, 1.0 / g13])
    for i, j, ratio in ((0, 1, nu12 / e[0]), (0, 2, nu13 / e[0]), (1, 2, nu23 / e[1])):
        compliance[i, j] = compliance[j, i] = -ratio
    return np.asarray(np.linalg.inv(compliance))


def rotated(stiffness: FloatArray, expansion: FloatArray, axes: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Stiffness [6, 6] and expansion [6] of a material whose axes are the rows of `axes` [3, 3], in the basic frame."""
    strain = _strain_map(axes)
    return strain.T @ stiffness @ strain, np.asarray(np.linalg.solve(strain, expansion))


def _strain_map(axes: FloatArray) -> FloatArray:
    """Engineering strains along `axes` of those along the basic axes, [6, 6]; from ε' = R ε Rᵀ."""
    out = np.empty((6, 6))
    for column, (i, j) in enumerate(PAIRS):
        tensor = np.zeros((3, 3))
        tensor[i, j] = tensor[j, i] = 1.0 if i == j else 0.5
        turned = axes @ tensor @ axes.T
        out[:, column] = [turned[a, b] * (1.0 if a == b else 2.0) for a, b in PAIRS]
    return out
