"""Multipole expansion of the field of any homogeneous body beyond its monopole, about its centre of mass.

Harmonics and their derivatives as in `tedm_cli.gravity.moments`; a body without symmetry has moments of all degrees and
orders, ``U = Σ_l Re[conj(M_l0) I_l^0 + 2 Σ_{m>0} conj(M_lm) I_l^m]`` with the means M_lm of ``R_l^m`` over the body.
"""

from __future__ import annotations

import math

import numpy as np

from tedm_cli.arrays import ComplexArray, FloatArray
from tedm_cli.gravity.compiled import compiled
from tedm_cli.gravity.moments import derivative

# Points taken together: the innermost loops run over them, so that the compiler can use vector instructions.
_LANES = 64
_COMPONENTS = 8
_TOGETHER = 4  # degrees
_BLOCK = 256  # points of a surface
_LOWEST = 8  # degrees that rounding may be seen in from afar
# Moments below this part of the sum of the magnitudes they are made of are rounding: the body has none by symmetry.
_ROUNDING = 64.0 * np.finfo(np.float64).eps


def body_moments(points: FloatArray, weights: FloatArray, order: int) -> ComplexArray:
    """Moments of a body from a rule over its surface, [order + 1, order + 1] by degree and order.

    By Gauss's theorem ``∫ R_l^m dV = ∮ (x·n) R_l^m dA / (l + 3)``, R_l^m being homogeneous of degree l.

    Parameters
    ----------
    points : [n, 3], in units of the radius that the expansion is scaled by, about the centre of mass.
    weights : [n], ``(x·n) dA`` over three times the volume: they add up to 1.
    order : highest degree.
    """
    sums, sizes = np.zeros((2, order + 1, order + 1)), np.zeros((order + 1, order + 1))
    filled = -len(points) % _BLOCK
    _surface_sums(np.pad(points, ((0, filled), (0, 0))), np.pad(weights, (0, filled)), sums, sizes)
    moments = sums[0] + 1j * sums[1]
    moments[np.abs(moments) < _ROUNDING * sizes] = 0.0
    return np.asarray(moments * (3.0 / (np.arange(order + 1) + 3.0))[:, None])


@compiled
def _surface_sums(points: FloatArray, weights: FloatArray, sums: FloatArray, sizes: FloatArray) -> None:
    """Add real and imaginary parts of the harmonics to `sums`; to `sizes` their magnitudes, of the lowest degrees.

    The number of points is a multiple of a block.
    """
    order = sums.shape[1] - 1
    real, imaginary = np.empty(_BLOCK), np.empty(_BLOCK)
    square = np.empty(_BLOCK)
    a = np.empty((order + 1, _BLOCK))
    for start in range(0, points.shape[0], _BLOCK):
        part = points[start : start + _BLOCK]
        x, y, z = part[:, 0], part[:, 1], part[:, 2]
        for p in range(_BLOCK):
            square[p] = x[p] * x[p] + y[p] * y[p] + z[p] * z[p]
            real[p], imaginary[p] = weights[start + p], 0.0
        for m in range(order + 1):
            for p in range(_BLOCK):
                a[0, p] = 1.0
            for k in range(1, order + 1 - m):
                degree = m + k - 1
                across = 1.0 / ((degree + 1.0) ** 2 - m * m)
                for p in range(_BLOCK):
                    before = a[k - 2, p] if k > 1 else 0.0
                    a[k, p] = ((2 * degree + 1) * z[p] * a[k - 1, p] - square[p] * before) * across
            sums[0, m:, m] += np.dot(a[: order + 1 - m], real)
            sums[1, m:, m] += np.dot(a[: order + 1 - m], imaginary)
            for k in range(max(0, min(_LOWEST, order + 1) - m)):
                for p in range(_BLOCK):
                    sizes[m + k, m] += math.hypot(real[p], imaginary[p]) * abs(a[k, p])
            for p in range(_BLOCK):
                even, odd = real[p], imaginary[p]
                real[p] = (x[p] * even - y[p] * odd) / (2.0 * m + 2.0)
                imaginary[p] = (x[p] * odd + y[p] * even) / (2.0 * m + 2.0)


def general_weights(moments: ComplexArray) -> FloatArray:
    """Weights of the harmonics in the field of a body less that of a point mass at its centre of mass.

    Returns
    -------
    [M, 16, order + 7]: by m (up to the last that is not all zeros) and by degree from m on, padded with zeros, for x,
    y, z, xx, yy, xy, xz, yz the factor of the real part of ``I_l^m/(2l-1)!!``, then for all of them that of its
    imaginary part.
    """
    order = moments.shape[0] - 1
    size = order + 3
    potential = np.zeros((size, 2 * size + 1), dtype=np.complex128)
    for degree in range(2, order + 1):
        orders = np.arange(degree + 1)
        potential[degree, size + orders] = moments[degree, : degree + 1].conj()
        potential[degree, size - orders] = (-1.0) ** orders * moments[degree, : degree + 1]
    # force = -∇U; gamma = -∂force/∂R = ∇∇U
    gradient = [derivative(potential, axis) for axis in range(3)]
    fields = [
        *(-row for row in gradient),
        *(derivative(gradient[i], j) for i, j in ((0, 0), (1, 1), (0, 1), (0, 2), (1, 2))),
    ]
    series = np.stack([row[:, size : 2 * size] for row in fields], axis=-1)  # [degree, m, component]
    double = np.where(np.arange(size) > 0, 2.0, 1.0)[None, :, None]
    factorial = np.cumprod(np.maximum(2.0 * np.arange(size) - 1.0, 1.0))[:, None, None]
    series = (series * double * factorial).transpose(1, 2, 0)
    last = int(np.flatnonzero(series.any(axis=(1, 2)))[-1]) if series.any() else -1
    weights = np.zeros((last + 1, 2 * _COMPONENTS, size + _TOGETHER))
    for m in range(last + 1):
        weights[m, :_COMPONENTS, : size - m] = series[m, :, m:].real
        weights[m, _COMPONENTS:, : size - m] = -series[m, :, m:].imag
    return weights


@compiled
def general_field(points: FloatArray, scale: float, weights: FloatArray, field: FloatArray) -> None:
    """Field of a body less that of a point mass at its centre of mass; recursion and columns as of `excess_field`.

    Parameters
    ----------
    points : [n, 3], beyond the sphere of radius `scale` about the centre of mass that holds the body [m].
    weights : from `general_weights`, of moments in units of `scale`.
    field : [n, 9], receives force along x, y, z [1/m²], then gradient xx, yy, zz, xy, xz, yz [1/m³].
    """
    count, orders, degrees = points.shape[0], weights.shape[0], weights.shape[2] - _TOGETHER
    x, y, z, square = np.empty(_LANES), np.empty(_LANES), np.empty(_LANES), np.empty(_LANES)
    real, imaginary = np.empty(_LANES), np.empty(_LANES)
    a = np.zeros((degrees + _TOGETHER, _LANES))
    with_real, with_imaginary = np.empty(_LANES), np.empty(_LANES)
    total = np.empty((_COMPONENTS, _LANES))
    for start in range(0, count, _LANES):
        for p in range(_LANES):
            # the last group is filled up with its last point
            n = min(start + p, count - 1)
            px, py, pz = points[n, 0] / scale, points[n, 1] / scale, points[n, 2] / scale
            square[p] = 1.0 / (px * px + py * py + pz * pz)
            x[p], y[p], z[p] = px * square[p], py * square[p], pz * square[p]
            real[p], imaginary[p] = math.sqrt(square[p]), 0.0
        total[:] = 0.0
        for m in range(orders):
            a[0] = 1.0
            a[1] = z
            for k in range(2, degrees - m):
                degree = m + k - 1
                down = (degree * degree - m * m) / (4.0 * degree * degree - 1.0)
                for p in range(_LANES):
                    a[k, p] = z[p] * a[k - 1, p] - down * square[p] * a[k - 2, p]
            for c in range(_COMPONENTS):
                with_real[:] = 0.0
                with_imaginary[:] = 0.0
                # several degrees at a time: the sums are loaded and stored less often
                for k in range(0, degrees - m, _TOGETHER):
                    u0, u1, u2, u3 = weights[m, c, k], weights[m, c, k + 1], weights[m, c, k + 2], weights[m, c, k + 3]
                    d = c + _COMPONENTS
                    v0, v1, v2, v3 = weights[m, d, k], weights[m, d, k + 1], weights[m, d, k + 2], weights[m, d, k + 3]
                    for p in range(_LANES):
                        a0, a1, a2, a3 = a[k, p], a[k + 1, p], a[k + 2, p], a[k + 3, p]
                        with_real[p] += u0 * a0 + u1 * a1 + u2 * a2 + u3 * a3
                        with_imaginary[p] += v0 * a0 + v1 * a1 + v2 * a2 + v3 * a3
                for p in range(_LANES):
                    total[c, p] += real[p] * with_real[p] + imaginary[p] * with_imaginary[p]
            for p in range(_LANES):
                even, odd = real[p], imaginary[p]
                real[p] = x[p] * even - y[p] * odd
                imaginary[p] = x[p] * odd + y[p] * even
        for p in range(min(_LANES, count - start)):
            n = start + p
            for c in range(3):
                field[n, c] = total[c, p] / scale**2
            field[n, 3] = total[3, p] / scale**3
            field[n, 4] = total[4, p] / scale**3
            field[n, 5] = -(field[n, 3] + field[n, 4])
            for c in range(3):
                field[n, 6 + c] = total[5 + c, p] / scale**3
