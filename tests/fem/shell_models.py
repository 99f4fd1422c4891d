"""Plates and shells for the tests of the shell elements."""

from __future__ import annotations

import numpy as np
from fem_models import ALPHA, NU, YOUNG

from tedm_cli.fem.structure import ShellBlock


def plane_stress(young=YOUNG, nu=NU):
    return young / (1 - nu**2) * np.array([[1, nu, 0], [nu, 1, 0], [0, 0, (1 - nu) / 2]])


def shells(
    corners, thickness, *, young=YOUNG, nu=NU, alpha=ALPHA, offset=0.0, drilling=1e-2, shear=5 / 6
) -> ShellBlock:
    """Homogeneous shells; `shear` is the share of the thickness that carries shear, None without shear flexibility."""
    count = len(corners)
    full = lambda value: np.broadcast_to(np.asarray(value, float), count).copy()  # noqa: E731
    law, modulus = plane_stress(young, nu), young / (2 * (1 + nu))
    return ShellBlock(
        element_id=np.arange(1, count + 1),
        connectivity=np.asarray(corners),
        membrane_stiffness=np.tile(thickness * law, (count, 1, 1)),
        bending_stiffness=np.tile(thickness**3 / 12 * law, (count, 1, 1)),
        shear_stiffness=full(np.inf if shear is None else shear * thickness * modulus),
        drilling_stiffness=full(drilling * thickness * modulus),
        offset=full(offset),
        expansion=full(alpha),
        bending_expansion=full(alpha),
        reference_temperature=full(0.0),
    )


def sheet(cells, size, *, corners=4, distortion=0.0, seed=3):
    """Positions [N, 3] in z = 0 and connectivity of a rectangle; `distortion` moves inner grids, in cell widths."""
    nx, ny = cells
    x, y = (np.linspace(0.0, length, n + 1) for length, n in zip(size, cells, strict=True))
    position = np.stack([*np.meshgrid(x, y, indexing="ij"), np.zeros((nx + 1, ny + 1))], -1).reshape(-1, 3)
    index = np.arange(len(position)).reshape(nx + 1, ny + 1)
    quads = np.stack([index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:]], -1).reshape(-1, 4)
    inner = ((position[:, :2] > 1e-9) & (position[:, :2] < np.array(size) - 1e-9)).all(axis=1)
    shift = np.random.default_rng(seed).uniform(-1, 1, (len(position), 2)) * distortion * np.array(size) / cells
    position[:, :2] += shift * inner[:, None]
    if corners == 4:
        return position, quads
    return position, np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
