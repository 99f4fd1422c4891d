"""The low-pass that fits a gain best: |H| ∝ 1 / √(1 + (f/fc)^2n), the shape of `noise.temperature.ShapedSpectrum`.

Fitted is ln |H| by least squares with equal weights over the frequencies; its level is free. First the best of a table
of orders and corners is found, then Levenberg and Marquardt's method goes on from there, for all gains at once.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tedm_cli.arrays import ComplexArray, FloatArray

ORDERS = (0.05, 12.0)  # searched
BEYOND = 30.0  # factor beyond both ends of the frequencies, to which corners are searched
LEAST_FREQUENCIES = 4
_ORDERS, _CORNERS = 28, 72  # of the table
_STEPS = 25
_BLOCK = 1 << 22  # numbers held of gains that are fitted together
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


def fitted(transfer: ComplexArray, frequency_hz: FloatArray) -> LowPass:
    """The best low-pass of each gain of `transfer` [F, ...] at `frequency_hz` [F], ascending."""
    shape = transfer.shape[1:]
    gain = np.abs(transfer).reshape(len(frequency_hz), -1)
    out = np.full((3, gain.shape[1]), np.nan)
    if len(frequency_hz) >= LEAST_FREQUENCIES:
        sound = np.flatnonzero((gain > _TINY).all(axis=0))
        at_once = max(1, _BLOCK // len(frequency_hz))
        for start in range(0, len(sound), at_once):
            part = sound[start : start + at_once]
            out[:, part] = _fit(np.log(gain[:, part]).T, np.log(frequency_hz))
    order, corner, error = (values.reshape(shape) for values in out)
    return LowPass(order, corner, error)


def _fit(wanted: FloatArray, x: FloatArray) -> FloatArray:
    """[3, p]: order, corner and error of ln gains `wanted` [p, F] at ln frequencies `x` [F]."""
    wanted = wanted - wanted.mean(axis=1, keepdims=True)
    low, high = x[0] - np.log(BEYOND), x[-1] + np.log(BEYOND)
    order, corner = _best_of_table(wanted, x, low, high)
    damping = np.full(len(wanted), 1e-3)
    residual, jacobian = _model(wanted, x, order, corner)
    cost = np.einsum("pf,pf->p", residual, residual)
    bounds = np.log(ORDERS), (low, high)
    at = np.stack([np.log(order), corner])
    for _ in range(_STEPS):
        normal = np.einsum("pfi,pfj->pij", jacobian, jacobian)
        normal[:, [0, 1], [0, 1]] *= 1.0 + damping[:, None]
        normal[:, [0, 1], [0, 1]] += 1e-300
        down = np.einsum("pfi,pf->pi", jacobian, residual)
        det = normal[:, 0, 0] * normal[:, 1, 1] - normal[:, 0, 1] ** 2
        det = np.where(det > 0.0, det, np.inf)
        step = np.stack([
            (normal[:, 1, 1] * down[:, 0] - normal[:, 0, 1] * down[:, 1]) / det,
            (normal[:, 0, 0] * down[:, 1] - normal[:, 0, 1] * down[:, 0]) / det,
        ])  # fmt: skip
        tried = np.stack([np.clip(at[i] + np.clip(step[i], -1.0, 1.0), *bounds[i]) for i in (0, 1)])
        new_residual, new_jacobian = _model(wanted, x, np.exp(tried[0]), tried[1])
        new_cost = np.einsum("pf,pf->p", new_residual, new_residual)
        better = new_cost < cost
        at[:, better] = tried[:, better]
        residual[better], jacobian[better], cost[better] = new_residual[better], new_jacobian[better], new_cost[better]
        damping = np.clip(np.where(better, damping / 5.0, damping * 5.0), 1e-12, 1e12)
        if not better.any() and (damping > 1e6).all():
            break
    flat = np.ptp(wanted, axis=1) < _FLAT
    at[1, flat] = high
    return np.stack([np.exp(at[0]), np.exp(at[1]), np.sqrt(cost / len(x))])


def _model(wanted: FloatArray, x: FloatArray, order: FloatArray, corner: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Residuals [p, F] of the shape with its best level, and its derivatives [p, F, 2] by ln order and ln corner."""
    z = 2.0 * order[:, None] * (x - corner[:, None])
    shape = -0.5 * np.logaddexp(0.0, z)
    share = 0.5 / (1.0 + np.exp(-np.clip(z, -700.0, 700.0)))  # of z in the slope
    by = np.stack([-share * z, 2.0 * order[:, None] * share], axis=2)
    return wanted - (shape - shape.mean(axis=1, keepdims=True)), by - by.mean(axis=1, keepdims=True)


def _best_of_table(wanted: FloatArray, x: FloatArray, low: float, high: float) -> tuple[FloatArray, FloatArray]:
    """Order and ln corner [p] of a table that fit best."""
    order, corner = np.meshgrid(np.geomspace(0.1, 8.0, _ORDERS), np.linspace(low, high, _CORNERS), indexing="ij")
    order, corner = order.ravel(), corner.ravel()
    shape = -0.5 * np.logaddexp(0.0, 2.0 * order[:, None] * (x - corner[:, None]))
    shape -= shape.mean(axis=1, keepdims=True)
    # |wanted - shape|² but for |wanted|²
    cost = np.einsum("gf,gf->g", shape, shape) - 2.0 * wanted @ shape.T
    best = np.argmin(cost, axis=1)
    return order[best], corner[best]
