"""The low-pass that fits a gain best: |H| ∝ 1 / √(1 + (f/fc)^2n), the shape of `noise.temperature.ShapedSpectrum`.

Fitted is ln |H| by least squares with equal weights over the frequencies, of more than 64 over as many of them; its
level is free. First the best of a table of orders and corners is found, then Levenberg and Marquardt's method goes on
from there, for many gains at once.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tedm_cli.arrays import BoolArray, ComplexArray, FloatArray

ORDERS = (0.05, 12.0)  # searched
BEYOND = 30.0  # factor beyond both ends of the frequencies, to which corners are searched
LEAST_FREQUENCIES = 4
_MOST_FREQUENCIES = 64
_ORDERS, _CORNERS = 20, 48  # of the table
_STEPS = 60
_SAME = 1e-10  # relative change of order and corner at which they are found
_STUCK = 1e9  # damping at which they do not move any more
_BLOCK = 1 << 18  # numbers of an array of gains that are fitted together
_FLAT = 1e-3  # a gain whose logarithm changes by less has no corner among the frequencies
_TINY = 1e-280


@dataclass(frozen=True, eq=False)
class LowPass:
    """Low-pass shapes, each [...]: NaN where there is no gain, or it falls to nothing, or frequencies are too few.

    order : n. corner_hz : fc; at an end of what is searched, it is beyond the frequencies. error : root mean square of
    ln(fit / gain).
    """

    order: FloatArray
    corner_hz: FloatArray
    error: FloatArray


def searched_hz(frequency_hz: FloatArray) -> tuple[float, float]:
    """Lowest and highest corner that is searched."""
    return float(frequency_hz[0]) / BEYOND, float(frequency_hz[-1]) * BEYOND


def within(corner_hz: FloatArray, frequency_hz: FloatArray) -> BoolArray:
    """Which corners are not at an end of what is searched, nor missing."""
    low, high = searched_hz(frequency_hz)
    return np.asarray((corner_hz > low * 1.001) & (corner_hz < high / 1.001))


def low_pass_shape(frequency_hz: FloatArray, order: FloatArray, corner_hz: FloatArray) -> FloatArray:
    """1 / √(1 + (f/fc)^2n), of arrays that go together."""
    steepness = 2.0 * order * np.log(frequency_hz / corner_hz)
    return np.asarray(np.exp(-0.5 * np.logaddexp(0.0, steepness)))


def fitted(transfer: ComplexArray, frequency_hz: FloatArray) -> LowPass:
    """The best low-pass of each gain of `transfer` [F, ...] at `frequency_hz` [F], ascending."""
    shape = transfer.shape[1:]
    used = np.unique(np.linspace(0, len(frequency_hz) - 1, _MOST_FREQUENCIES).round().astype(np.intp))
    gain = np.abs(transfer[used]).reshape(len(used), -1)
    out = np.full((3, gain.shape[1]), np.nan)
    if len(used) >= LEAST_FREQUENCIES:
        sound = np.flatnonzero((gain > _TINY).all(axis=0))
        at_once = max(1, _BLOCK // len(used))
        for start in range(0, len(sound), at_once):
            part = sound[start : start + at_once]
            out[:, part] = _fit(np.log(gain[:, part]).T, np.log(frequency_hz[used]))
    order, corner, error = (values.reshape(shape) for values in out)
    return LowPass(order, corner, error)


def _fit(wanted: FloatArray, x: FloatArray) -> FloatArray:
    """[3, p]: order, corner and error of ln gains `wanted` [p, F] at ln frequencies `x` [F]."""
    wanted = wanted - wanted.mean(axis=1, keepdims=True)
    bounds = tuple(np.log(ORDERS)), (x[0] - np.log(BEYOND), x[-1] + np.log(BEYOND))
    at = _best_of_table(wanted, x, *bounds[1])
    sums = _sums(wanted, x, at)
    damping = np.full(len(wanted), 1e-3)
    going = np.arange(len(wanted))
    for _ in range(_STEPS):
        step = _step(sums[:, going], damping[going], at[:, going], bounds)
        tried = np.stack([np.clip(at[i, going] + np.clip(step[i], -1.0, 1.0), *bounds[i]) for i in (0, 1)])
        found = _sums(wanted[going], x, tried)
        better = found[0] < sums[0, going]
        moved = np.abs(tried - at[:, going]).max(axis=0)
        at[:, going[better]], sums[:, going[better]] = tried[:, better], found[:, better]
        damping[going] *= np.where(better, 0.1, 8.0)
        going = going[(moved > _SAME) & (damping[going] < _STUCK)]
        if not going.size:
            break
    at[1, np.ptp(wanted, axis=1) < _FLAT] = bounds[1][1]
    return np.stack([np.exp(at[0]), np.exp(at[1]), np.sqrt(sums[0] / len(x))])


def _step(
    sums: FloatArray, damping: FloatArray, at: FloatArray, bounds: tuple[tuple[float, ...], tuple[float, ...]]
) -> FloatArray:
    """Steps [2, p] of ln order and ln corner. What is at an end, and would go beyond it, stays there."""
    _, aa, ab, bb, a, b = sums.copy()
    a, b = (
        np.where(((x <= low) & (down < 0.0)) | ((x >= high) & (down > 0.0)), 0.0, down)
        for x, down, (low, high) in zip(at, (a, b), bounds, strict=True)
    )
    ab = np.where((a == 0.0) | (b == 0.0), 0.0, ab)
    aa, bb = aa * (1.0 + damping) + 1e-300, bb * (1.0 + damping) + 1e-300
    det = aa * bb - ab**2
    det = np.where(det > 0.0, det, np.inf)
    return np.stack([(bb * a - ab * b) / det, (aa * b - ab * a) / det])


def _sums(wanted: FloatArray, x: FloatArray, at: FloatArray) -> FloatArray:
    """[6, p]: Σ r², Σ a², Σ a b, Σ b², Σ a r, Σ b r of residuals r and derivatives a, b by ln order and ln corner.

    The level is the best: the means over the frequencies are taken off.
    """
    order = 2.0 * np.exp(at[0])[:, None]
    z = order * (x - at[1][:, None])
    small = np.exp(-np.abs(z))
    shape = -0.5 * (np.maximum(z, 0.0) + np.log1p(small))
    share = 0.5 * np.where(z > 0.0, 1.0, small) / (1.0 + small)  # of z in the slope
    a, b = -share * z, share * order
    for values in (shape, a, b):
        values -= values.mean(axis=1, keepdims=True)
    r = wanted - shape
    pairs = ((r, r), (a, a), (a, b), (b, b), (a, r), (b, r))
    return np.stack([np.einsum("pf,pf->p", one, other) for one, other in pairs])


def _best_of_table(wanted: FloatArray, x: FloatArray, low: float, high: float) -> FloatArray:
    """ln order and ln corner [2, p] of a table that fit best."""
    order, corner = np.meshgrid(np.geomspace(0.1, 8.0, _ORDERS), np.linspace(low, high, _CORNERS), indexing="ij")
    order, corner = order.ravel(), corner.ravel()
    shape = -0.5 * np.logaddexp(0.0, 2.0 * order[:, None] * (x - corner[:, None]))
    shape -= shape.mean(axis=1, keepdims=True)
    # |wanted - shape|² but for |wanted|²
    cost = np.einsum("gf,gf->g", shape, shape) - 2.0 * wanted @ shape.T
    best = np.argmin(cost, axis=1)
    return np.stack([np.log(order[best]), corner[best]])
