"""Multipole expansion of the field of a homogeneous cuboid beyond its monopole.

Irregular solid harmonics ``I_l^m = (l-m)! P_l^m(cos θ) e^{imφ} / r^{l+1}`` (no Condon-Shortley phase,
``I_l^{-m} = (-1)^m conj I_l^m``) turn derivatives into index shifts: ``∂z I_l^m = -I_{l+1}^m``,
``(∂x + i∂y) I_l^m = -I_{l+1}^{m+1}``, ``(∂x - i∂y) I_l^m = I_{l+1}^{m-1}`` (Hobson 1931). The moments are the means
of the regular harmonics ``R_l^m = r^l P_l^m(cos θ) e^{imφ} / (l+m)!`` over the body; its three mirror planes leave
only even l and even m.
"""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]


def excess_field(points: Array, half_sides: Array, order: int) -> tuple[Array, Array]:
    """Field of the cuboid less that of a point mass at its centre, by the degrees 2 to `order`.

    Parameters
    ----------
    points : [3, n], points beyond the circumscribed sphere, in the frame of the cuboid [m].
    half_sides : [3], half edge lengths [m].
    order : highest degree of the expansion (even).

    Returns
    -------
    force : [3, n], excess of ``(1/V) ∫ (R - r)/|R - r|³ dV`` over ``R/R³`` [1/m²].
    gamma : [6, n], ``-∂force_i/∂R_j`` for xx, yy, zz, xy, xz, yz [1/m³].
    """
    scale = float(np.sqrt((half_sides**2).sum()))
    x, y, z = points / scale
    inverse_square = 1.0 / (x * x + y * y + z * z)
    x_rel, y_rel, z_rel = x * inverse_square, y * inverse_square, z * inverse_square
    tables = _coefficients(*(float(side) for side in half_sides), order)

    n = points.shape[1]
    # real and imaginary parts of I_l^m for two successive degrees, [2, m, n]
    current = np.zeros((2, order + 3, n))
    previous = np.zeros_like(current)
    following = np.zeros_like(current)
    current[0, 0] = np.sqrt(inverse_square)
    force = np.zeros((3, n))
    gamma = np.zeros((6, n))
    for degree in range(order + 2):
        rows = degree + 1
        m = np.arange(rows)
        following[:, :rows] = (2 * degree + 1) * z_rel * current[:, :rows]
        # the row m = degree of `previous` holds no value yet, and its factor is 0
        following[:, :rows] -= ((degree**2 - m**2)[:, None] * inverse_square) * previous[:, :rows]
        following[0, rows] = (2 * degree + 1) * (x_rel * current[0, degree] - y_rel * current[1, degree])
        following[1, rows] = (2 * degree + 1) * (x_rel * current[1, degree] + y_rel * current[0, degree])
        previous, current, following = current, following, previous
        real, imaginary = tables[degree + 1]
        if real.size:
            target = force if (degree + 1) % 2 else gamma
            target += real @ current[0, : rows + 1] + imaginary @ current[1, : rows + 1]
    return force / scale**2, gamma / scale**3


@lru_cache(maxsize=64)
def _coefficients(hx: float, hy: float, hz: float, order: int) -> list[tuple[Array, Array]]:
    """Weights of ``Re I_l^m`` and ``Im I_l^m`` (m = 0..l), per degree l = 0..order + 2.

    Odd degrees carry the force, [3, l + 1]; even degrees the gradient, [6, l + 1]; degrees without terms are empty.
    """
    moments = cuboid_moments(hx, hy, hz, order)
    # potential = Σ c_lm I_l^m over m = -l..l, m offset to the middle column
    size = order + 3
    potential = np.zeros((size, 2 * size + 1), dtype=np.complex128)
    for degree in range(2, order + 1, 2):
        for m in range(0, degree + 1, 2):
            potential[degree, size + m] = potential[degree, size - m] = moments[degree, m]

    gradient = [_derivative(potential, axis) for axis in range(3)]
    # force = -∇U; gamma = -∂force/∂R = ∇∇U
    pairs = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))
    hessian = [_derivative(gradient[i], j) for i, j in pairs]
    tables: list[tuple[Array, Array]] = []
    for degree in range(order + 3):
        if degree < 3:
            tables.append((np.empty((0, degree + 1)), np.empty((0, degree + 1))))
            continue
        source = [-row for row in gradient] if degree % 2 else hessian
        weights = np.array([row[degree, size : size + degree + 1] for row in source])
        # c_{-m} I_l^{-m} is the complex conjugate of c_m I_l^m
        weights[:, 1:] *= 2.0
        tables.append((weights.real.copy(), -weights.imag))
    return tables


def _derivative(series: Complex, axis: int) -> Complex:
    """Coefficients of the derivative of ``Σ c_lm I_l^m`` along x, y or z (axis 0, 1, 2)."""
    result = np.zeros_like(series)
    if axis == 2:
        result[1:] = -series[:-1]
        return result
    raised = np.zeros_like(series)
    lowered = np.zeros_like(series)
    raised[1:, 1:] = -series[:-1, :-1]
    lowered[1:, :-1] = series[:-1, 1:]
    return (raised + lowered) / 2.0 if axis == 0 else (raised - lowered) / 2.0j


@lru_cache(maxsize=64)
def cuboid_moments(hx: float, hy: float, hz: float, order: int) -> Array:
    """Means of the regular solid harmonics ``R_l^m`` over a cuboid of half sides (hx, hy, hz), [order + 1, order + 1].

    In units of half the body diagonal, such that ``U = Σ_l [M_l0 I_l^0 + 2 Σ_{m>0} M_lm Re I_l^m]``.
    Gauss-Legendre quadrature, exact for these polynomials.
    """
    scale = math.sqrt(hx * hx + hy * hy + hz * hz)
    count = order // 2 + 1
    nodes, weights = np.polynomial.legendre.leggauss(2 * ((count + 1) // 2))  # type: ignore[no-untyped-call]
    # every term kept is even in x, y and z: one octant represents the body
    octant = nodes > 0
    x, y, z = (grid.ravel() for grid in np.meshgrid(*(h / scale * nodes[octant] for h in (hx, hy, hz)), indexing="ij"))
    weight = np.einsum("i,j,k->ijk", *(weights[octant],) * 3).ravel()
    square = x * x + y * y + z * z

    moments = np.zeros((order + 1, order + 1))
    current = np.zeros((order + 1, x.size), dtype=np.complex128)
    previous = np.zeros_like(current)
    current[0] = 1.0
    moments[0, 0] = 1.0
    for degree in range(order):
        m = np.arange(degree + 1)
        following = np.zeros_like(current)
        following[: degree + 1] = (2 * degree + 1) * z * current[: degree + 1] - square * previous[: degree + 1]
        following[: degree + 1] /= ((degree + 1) ** 2 - m**2)[:, None]
        following[degree + 1] = (x + 1j * y) / (2 * degree + 2) * current[degree]
        previous, current = current, following
        if degree % 2:
            moments[degree + 1, : degree + 2 : 2] = current[: degree + 2 : 2].real @ weight
    # The quadrupole of a cube vanishes: written so that it does so exactly, and keeps its digits for a near cube.
    # R_2^0 = (2z² - x² - y²)/4 and R_2^2 = (x² - y²)/8 averaged over the body, <x²> = hx²/3.
    moments[2, 0] = ((hz - hx) * (hz + hx) + (hz - hy) * (hz + hy)) / (12.0 * scale**2)
    moments[2, 2] = (hx - hy) * (hx + hy) / (24.0 * scale**2)
    return moments
