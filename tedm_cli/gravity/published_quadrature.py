"""The published quadratures over the test mass, for comparison with the exact kernel and for nothing else.

They integrate two edges of the cuboid in closed form and the third numerically (Montemurro 2004, eq. 7.1 and 7.14,
sections 7.1.1 and 7.3.1): composite Bode for the force, composite Simpson for its gradient.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike

from tedm_cli.arrays import FloatArray

_BODE = np.array([7.0, 32.0, 12.0, 32.0, 7.0]) / 90.0
_SIMPSON = np.array([1.0, 4.0, 1.0]) / 6.0


def bode_force_x(points: ArrayLike, sides: ArrayLike, panels: int) -> FloatArray:
    """Fx per unit G M m by the composite Bode rule along z (eq. 7.1, C.4, weights of eq. 7.2 corrected).

    Parameters
    ----------
    points : [n, 3], sources in the frame of the cuboid [m]; outside it and not on the lines of its y edges.
    sides : [3], full edge lengths [m].
    panels : number N of panels of five points (the printed weights over 180 N hold for N panels, N + 1 nodes x_j).

    Returns
    -------
    [n], 1/m².
    """
    return _composite(points, sides, panels, _BODE, lambda b, r: np.log(b + r))


def simpson_gamma_xy(points: ArrayLike, sides: ArrayLike, divisions: int) -> FloatArray:
    """Γxy = -∂Fx/∂Y per unit G M m by the composite Simpson rule along z (eq. 7.14).

    Parameters
    ----------
    points : [n, 3], sources in the frame of the cuboid [m], outside it.
    sides : [3], full edge lengths [m].
    divisions : number N of divisions of the edge, even (two to a panel).

    Returns
    -------
    [n], 1/m³.
    """
    if divisions % 2:
        raise ValueError(f"Simpson's rule needs an even number of divisions, got {divisions}")
    return _composite(points, sides, divisions // 2, _SIMPSON, lambda b, r: 1.0 / r)


def _composite(
    points: ArrayLike,
    sides: ArrayLike,
    panels: int,
    rule: FloatArray,
    corner: Callable[[FloatArray, FloatArray], FloatArray],
) -> FloatArray:
    """Mean over z of the corner sum over x and y of `corner(b, r)`, b and r seen from the source."""
    points = np.asarray(points, dtype=np.float64).reshape(-1, 3)
    half = np.asarray(sides, dtype=np.float64) / 2.0
    steps = len(rule) - 1
    weights = np.zeros(panels * steps + 1)
    for panel in range(panels):
        weights[panel * steps : (panel + 1) * steps + 1] += rule / panels
    height = np.linspace(-half[2], half[2], weights.size)[None, :] - points[:, 2, None]
    total = np.zeros_like(height)
    for sign_x in (-1.0, 1.0):
        for sign_y in (-1.0, 1.0):
            a = sign_x * half[0] - points[:, 0, None]
            b = sign_y * half[1] - points[:, 1, None]
            total += sign_x * sign_y * corner(b, np.sqrt(a * a + b * b + height**2))
    return np.asarray(total @ weights / (4.0 * half[0] * half[1]))
