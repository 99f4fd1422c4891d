"""Multipole moments of a homogeneous cuboid, and the weights of its field in irregular solid harmonics.

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

from tedm_cli.arrays import ComplexArray, FloatArray


@lru_cache(maxsize=64)
def field_weights(hx: float, hy: float, hz: float, order: int) -> FloatArray:
    """Weights of the harmonics in the field of a cuboid less that of a point mass at its centre.

    Parameters
    ----------
    hx, hy, hz : half sides.
    order : highest degree of the expansion (even).

    Returns
    -------
    [order + 3, order // 2 + 2, 5], by m and k, for the degrees ``m + 2 k`` (first) and ``m + 2 k + 1`` (second). Odd
    degrees carry the force, even ones the gradient, each component by the real or imaginary part of ``I_l^m/(2l-1)!!``:

    ======  ================  ================  ==============  ==============  ==========
    m       0, first          1, first          2, first        3, second       4, second
    ======  ================  ================  ==============  ==============  ==========
    even    xx, real          yy, real          xy, imaginary   0               z, real
    odd     x, real           y, imaginary      0               xz, real        yz, imaginary
    ======  ================  ================  ==============  ==============  ==========
    """
    moments = cuboid_moments(hx, hy, hz, order)
    # potential = Σ c_lm I_l^m over m = -l..l, m offset to the middle column
    size = order + 3
    potential = np.zeros((size, 2 * size + 1), dtype=np.complex128)
    for degree in range(2, order + 1, 2):
        for m in range(0, degree + 1, 2):
            potential[degree, size + m] = potential[degree, size - m] = moments[degree, m]

    # force = -∇U; gamma = -∂force/∂R = ∇∇U
    gradient = [derivative(potential, axis) for axis in range(3)]
    x, y, z = (-row[:, size:] for row in gradient)
    xx, yy, xy, xz, yz = (derivative(gradient[i], j)[:, size:] for i, j in ((0, 0), (1, 1), (0, 1), (0, 2), (1, 2)))
    # c_{-m} I_l^{-m} is the complex conjugate of c_m I_l^m
    double = np.where(np.arange(size + 1) > 0, 2.0, 1.0)
    factorial = np.cumprod(np.maximum(2.0 * np.arange(size) - 1.0, 1.0))
    weights = np.zeros((order + 3, order // 2 + 2, 5))
    for m in range(order + 3):
        first, second = range(m, size, 2), range(m + 1, size, 2)
        columns = (
            ((first, xx.real), (first, yy.real), (first, -xy.imag), None, (second, z.real))
            if m % 2 == 0
            else ((first, x.real), (first, -y.imag), None, (second, xz.real), (second, -yz.imag))
        )
        for column, entry in enumerate(columns):
            if entry is not None:
                degrees, series = entry
                weights[m, : len(degrees), column] = double[m] * factorial[degrees] * series[degrees, m]
    weights.flags.writeable = False
    return weights


def derivative(series: ComplexArray, axis: int) -> ComplexArray:
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
def cuboid_moments(hx: float, hy: float, hz: float, order: int) -> FloatArray:
    """Means of the regular solid harmonics ``R_l^m`` over a cuboid of half sides (hx, hy, hz), [order + 1, order + 1].

    In units of half the body diagonal, such that ``U = Σ_l [M_l0 I_l^0 + 2 Σ_{m>0} M_lm Re I_l^m]``. By Gauss's
    theorem the mean of a homogeneous function of degree l over the body is the sum of its means over the three pairs
    of faces, divided by l + 3; Gauss-Legendre quadrature is exact for these polynomials.
    """
    scale = math.sqrt(hx * hx + hy * hy + hz * hz)
    half = np.array([hx, hy, hz]) / scale
    nodes, weights = np.polynomial.legendre.leggauss(2 * (order // 4 + 1))  # type: ignore[no-untyped-call]
    # every term kept is even in x, y and z: a quarter of one face of each pair represents it
    quarter = nodes > 0
    u, v = (grid.ravel() for grid in np.meshgrid(nodes[quarter], nodes[quarter], indexing="ij"))
    weight = np.tile(np.outer(weights[quarter], weights[quarter]).ravel(), 3)
    faces = np.stack([[one := np.ones_like(u), u, v], [u, one, v], [u, v, one]], axis=1)
    x, y, z = half[:, None] * faces.reshape(3, -1)
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
            moments[degree + 1, : degree + 2 : 2] = current[: degree + 2 : 2].real @ weight / (degree + 4)
    # The quadrupole of a cube vanishes: written so that it does so exactly, and keeps its digits for a near cube.
    # R_2^0 = (2z² - x² - y²)/4 and R_2^2 = (x² - y²)/8 averaged over the body, <x²> = hx²/3.
    moments[2, 0] = ((hz - hx) * (hz + hx) + (hz - hy) * (hz + hy)) / (12.0 * scale**2)
    moments[2, 2] = (hx - hy) * (hx + hy) / (24.0 * scale**2)
    return moments
