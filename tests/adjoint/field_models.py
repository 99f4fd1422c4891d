"""Points of a temperature field with sensitivities that are made up."""

from __future__ import annotations

import numpy as np
from scipy.spatial.distance import cdist

from tedm_cli.adjoint.temperature_field import FieldPoints
from tedm_cli.arrays import FloatArray, IntArray

LENGTHS = (0.02, 0.15, 1.0)


def bar(nx: int, ny: int = 3, nz: int = 3, step: float = 0.02) -> tuple[FloatArray, IntArray, IntArray]:
    """A bar of hexahedra along x: positions of the grids, [n, 3], and its elements as offsets and rows of grids."""
    x, y, z = np.meshgrid(*(np.arange(count) * step for count in (nx, ny, nz)), indexing="ij")
    number = np.arange(nx * ny * nz).reshape(nx, ny, nz)
    corners = [number[i : nx - 1 + i, j : ny - 1 + j, k : nz - 1 + k] for i in (0, 1) for j in (0, 1) for k in (0, 1)]
    index = np.stack(corners, axis=-1).reshape(-1, 8)
    return np.stack([x, y, z], axis=-1).reshape(-1, 3), np.arange(len(index) + 1) * 8, index.ravel()


def random_points(n: int, outputs: int = 2, seed: int = 1) -> FieldPoints:
    draw = np.random.default_rng(seed)
    return FieldPoints(
        position=draw.uniform(0.0, 0.4, (n, 3)),
        volume=draw.uniform(0.5, 2.0, n) * 1e-6,
        sensitivity=draw.normal(size=(outputs, n)) + 0.3,
    )


def dense(points: FieldPoints, length: float) -> FloatArray:
    """The covariance of the field, as a whole."""
    return np.asarray(np.exp(-cdist(points.position, points.position) / length))


def means(points: FieldPoints, area: IntArray) -> FloatArray:
    """Means by volume as a matrix [k, n]."""
    weight = np.zeros((area.max() + 1, len(area)))
    weight[area, np.arange(len(area))] = points.volume
    return np.asarray(weight / weight.sum(axis=1, keepdims=True))
