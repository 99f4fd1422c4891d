"""Gauss rules over cubes, triangles and tetrahedra for polynomials of any degree."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
import scipy

from tedm_cli.arrays import FloatArray

_ROUNDING = 1e-17


@lru_cache(maxsize=64)
def gauss(n: int, power: int) -> tuple[FloatArray, FloatArray]:
    """Nodes and weights [n] on 0 to 1 for the weight (1 - t)^power, adding up to 1/(power + 1)."""
    t, w = scipy.special.roots_jacobi(n, power, 0.0)
    return (1.0 + t) / 2.0, w / 2.0 ** (power + 1)


def cube_rule(n: int) -> tuple[FloatArray, FloatArray]:
    """Points [n³, 3] of the unit cube and weights [n³] adding up to 1, exact to degree 2n - 1 in each coordinate."""
    t, w = gauss(n, 0)
    return np.stack(np.meshgrid(t, t, t, indexing="ij"), axis=-1).reshape(-1, 3), np.einsum(
        "i,j,k->ijk", w, w, w
    ).ravel()


@lru_cache(maxsize=64)
def _unit_triangle(n: int) -> tuple[FloatArray, FloatArray]:
    """Barycentric coordinates [n², 3] and weights [n²] adding up to 1 (Stroud's conical product), to degree 2n - 1."""
    (u, wu), (v, wv) = gauss(n, 1), gauss(n, 0)
    first = np.repeat(u, n)
    second = np.tile(v, n) * (1.0 - first)
    return np.stack([1.0 - first - second, first, second], axis=1), 2.0 * np.outer(wu, wv).ravel()


@lru_cache(maxsize=16)
def _unit_tetrahedron(n: int) -> tuple[FloatArray, FloatArray]:
    (u, wu), (v, wv), (t, wt) = gauss(n, 2), gauss(n, 1), gauss(n, 0)
    first, second, third = (g.ravel() for g in np.meshgrid(u, v, t, indexing="ij"))
    second = second * (1.0 - first)
    third = third * (1.0 - first - second)
    return np.stack([first, second, third], axis=1), 6.0 * np.einsum("i,j,k->ijk", wu, wv, wt).ravel()


def triangle_rule(triangle: FloatArray, order: int, radius: float) -> tuple[FloatArray, FloatArray]:
    """Points [q, 3] on triangles [t, 3, 3] and n dA [q, 3] for solid harmonics to degree `order`, to rounding.

    A triangle that is small against `radius`, that of the body, needs fewer points than exactness asks for: on it a
    harmonic of degree l varies as exp(l h), with h half its extent over the radius, whose remainder after degree k is
    ``(l h/2)^k / k!`` of its magnitude (Trefethen 2013, chapter 8).
    """
    extent = np.linalg.norm(triangle - np.roll(triangle, 1, axis=1), axis=2).max(axis=1)
    most = order // 2 + 1
    counts = np.full(len(triangle), most)
    growth = np.log(np.maximum(order * extent / (4.0 * radius), 1e-30))
    for n in range(most - 1, 0, -1):
        counts[2 * n * growth - scipy.special.gammaln(2 * n + 1.0) < np.log(_ROUNDING)] = n
    points, areas = [], []
    for n in np.unique(counts):
        some = triangle[counts == n]
        barycentric, weight = _unit_triangle(int(n))
        points.append((barycentric @ some).reshape(-1, 3))
        area = np.cross(some[:, 1] - some[:, 0], some[:, 2] - some[:, 0]) / 2.0
        areas.append((area[:, None, :] * weight[:, None]).reshape(-1, 3))
    return np.concatenate(points), np.concatenate(areas)


def tetrahedron_rule(apex: FloatArray, triangle: FloatArray, n: int) -> tuple[FloatArray, FloatArray]:
    """Points [q, 3] and volumes [q], with sign, of the tetrahedra between a point and triangles [t, 3, 3]."""
    unit, weight = _unit_tetrahedron(n)
    legs = triangle - apex
    volume = np.linalg.det(legs) / 6.0
    return apex + (unit @ legs).reshape(-1, 3), (volume[:, None] * weight).ravel()


def legendre_cube(n: int) -> tuple[FloatArray, FloatArray]:
    """Points [n³, 3] of the cube from -1 to 1 and weights [n³] adding up to 1; exact as `cube_rule`."""
    nodes, weights = np.polynomial.legendre.leggauss(n)  # type: ignore[no-untyped-call]
    points = np.stack(np.meshgrid(nodes, nodes, nodes, indexing="ij"), axis=-1).reshape(-1, 3)
    return points, np.einsum("i,j,k->ijk", weights, weights, weights).ravel() / 8.0
