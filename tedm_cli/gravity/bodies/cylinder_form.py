"""Field of a homogeneous cylinder: integrals over its surface, along the axis and over the caps in closed form.

What is left is one integral over the azimuth φ of smooth functions, for a point at the distance ρ from the axis, with
``s² = (a - ρ)² + 4aρ sin²(φ/2)`` to a generator of the lateral surface and ``c = a² - aρ cos φ``:

    ∫∫ dA/r over a cap at the distance d = ∮ c/(r + |d|) dφ,    its solid angle = sgn(d) ∮ c/(r (r + |d|)) dφ,
    F_ρ = (1/V) ∮ a cos φ L dφ,    Γ_ρz = (1/V) [∮ a cos φ dφ / r] between the caps,
    Γ_ρρ = -(1/V) ∮ a cos φ (a cos φ - ρ) J dφ,    Γ_φφ = -(1/V) ∮ a² sin² φ J dφ,

L and J being ``∫ dz/r`` and ``∫ dz/r³`` along a generator. Nothing is singular outside, on the axis and on the planes
of the caps included. The functions are analytic but for points at the imaginary distance δ from φ = 0, with
``sinh(δ/2) = g/(2√(aρ))`` and the distance g from the nearest rim or generator: Gauss-Legendre panels that double in
width from δ on converge as for a fixed ratio, 16 points to rounding.
"""

from __future__ import annotations

import math

import numpy as np

from tedm_cli.arrays import FloatArray
from tedm_cli.gravity.compiled import compiled

_POINTS = 16
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(_POINTS)  # type: ignore[no-untyped-call]
GAUSS = np.ascontiguousarray(np.stack([_NODES, _WEIGHTS]))


@compiled
def cylinder_form(
    points: FloatArray, axes: FloatArray, centre: FloatArray, radius: float, low: float, high: float,
    gauss: FloatArray, field: FloatArray,
) -> None:  # fmt: skip
    """Mean over the cylinder of the attraction towards each point, and its gradient.

    Parameters
    ----------
    points : [n, 3], [m]. Inside the cylinder the attraction is that of all of it, as of `edge_form`.
    axes : [3, 3], rows are unit vectors, the last along the axis of the cylinder.
    centre : [3], a point of the axis [m].
    radius, low, high : of the cylinder; coordinates of its caps along the axis from the origin of the points [m].
    gauss : [2, p], nodes and weights.
    field : [n, 9], as of `edge_form`.
    """
    volume = math.pi * radius * radius * (high - low)
    turn = np.empty((3, 3))
    for n in range(points.shape[0]):
        u = v = z = 0.0
        for i in range(3):
            u += axes[0, i] * (points[n, i] - centre[i])
            v += axes[1, i] * (points[n, i] - centre[i])
            z += axes[2, i] * points[n, i]
        rho = math.hypot(u, v)
        z1, z2 = low - z, high - z
        gap = max(z1, -z2, 0.0)
        gap = math.sqrt((radius - rho) ** 2 + gap * gap)
        delta = 2.0 * math.asinh(gap / (2.0 * math.sqrt(radius * rho))) if rho > 0.0 else math.pi
        fr = fz = grr = gff = gzz = grz = 0.0
        start, width = 0.0, min(max(delta, 1e-12), math.pi)
        while start < math.pi:
            half = 0.5 * min(width, math.pi - start)
            for k in range(gauss.shape[1]):
                phi = start + half * (1.0 + gauss[0, k])
                weight = 2.0 * half * gauss[1, k]
                sine = math.sin(0.5 * phi)
                versed = 2.0 * radius * sine * sine  # a (1 - cos φ)
                x = radius - versed
                off = (radius - rho) - versed
                y = 2.0 * radius * sine * math.cos(0.5 * phi)
                square = (radius - rho) ** 2 + 2.0 * rho * versed
                across = radius * (radius - rho) + rho * versed
                r1, r2 = math.sqrt(square + z1 * z1), math.sqrt(square + z2 * z2)
                p1, p2 = across / (r1 + abs(z1)), across / (r2 + abs(z2))
                # ∫ dz/r, and ∫ dz/r³ without taking like from like
                middle = z1 + z2
                near, near_radius = (-z2, r2) if middle < 0.0 else (z1, r1)
                near_sum = near_radius + abs(near)
                if near < 0.0:
                    near_sum = square / near_sum
                log = math.log1p((z2 - z1) * (1.0 + abs(middle) / (r1 + r2)) / near_sum)
                if z1 < 0.0 < z2:
                    cube = (z2 / r2 - z1 / r1) / square
                else:
                    cube = (z2 - z1) * abs(middle) / (r1 * r2 * (abs(z2) * r1 + abs(z1) * r2))
                fz += weight * (p2 - p1)
                fr += weight * x * log
                gzz += weight * ((p1 / r1 if z1 > 0.0 else -p1 / r1 if z1 < 0.0 else 0.0)
                                 - (p2 / r2 if z2 > 0.0 else -p2 / r2 if z2 < 0.0 else 0.0))  # fmt: skip
                grz += weight * x * (1.0 / r2 - 1.0 / r1)
                grr -= weight * x * off * cube
                gff -= weight * y * y * cube
            start += width
            width *= 2.0
        # unit vectors of ρ, φ and z
        cosine, sine = (u / rho, v / rho) if rho > 0.0 else (1.0, 0.0)
        for i in range(3):
            turn[0, i] = cosine * axes[0, i] + sine * axes[1, i]
            turn[1, i] = cosine * axes[1, i] - sine * axes[0, i]
            turn[2, i] = axes[2, i]
        for i in range(3):
            field[n, i] = (fr * turn[0, i] + fz * turn[2, i]) / volume
        for column in range(6):
            i = column if column < 3 else (0 if column < 5 else 1)
            j = column if column < 3 else (1 if column == 3 else 2)
            field[n, 3 + column] = (
                grr * turn[0, i] * turn[0, j]
                + gff * turn[1, i] * turn[1, j]
                + gzz * turn[2, i] * turn[2, j]
                + grz * (turn[0, i] * turn[2, j] + turn[2, i] * turn[0, j])
            ) / volume
