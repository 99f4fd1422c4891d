"""How accurate a self-gravity model is: quadrature over the test mass, size of elements, linearisation.

The studies of Montemurro 2004, figures 6.4, 7.2, 7.3, 7.8, 7.9 and 8.1, against the exact kernel. All errors are
relative magnitudes (not percent); sources are outside the cuboid; `PhysicsError` names one that is not.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

import numpy as np

from tedm_cli.arrays import FloatArray
from tedm_cli.gravity.compensation import CompensationMass
from tedm_cli.gravity.kernel import cuboid_field
from tedm_cli.gravity.published_quadrature import bode_force_x, simpson_gamma_xy

Shape = Literal["centre", "corners", "slab"]

SLAB_THICKNESS = 0.1
"""Thickness over edge length of the slab of `collapse_error`."""
# Gauss points per edge over the source: they converge to 1e-8 where the gap is 0.7 half edges, faster farther out.
_SOURCE_POINTS = 8
_LINE_POINTS = 3


def bode_error(distance: FloatArray, panels: Sequence[int], sides: FloatArray) -> FloatArray:
    """Error of Fx by composite Bode for sources at X = Y = Z = `distance` (figure 7.2), [panels, distances]."""
    points = np.repeat(distance[:, None], 3, axis=1)
    exact = cuboid_field(points, sides).force[:, 0]
    return np.stack([np.abs(bode_force_x(points, sides, n) / exact - 1.0) for n in panels])


def simpson_error(distance: FloatArray, divisions: Sequence[int], sides: FloatArray) -> FloatArray:
    """Error of Γxy by composite Simpson for sources at X = Y = Z = `distance` (figure 7.8), [divisions, distances]."""
    points = np.repeat(distance[:, None], 3, axis=1)
    exact = cuboid_field(points, sides).gamma_lin[:, 0, 1]
    return np.stack([np.abs(simpson_gamma_xy(points, sides, n) / exact - 1.0) for n in divisions])


def collapse_error(
    distance: FloatArray, size: FloatArray, sides: FloatArray, shape: Shape
) -> tuple[FloatArray, FloatArray]:
    """Error of a finite homogeneous source on the x axis that is replaced by points (figures 7.3 and 7.9).

    Parameters
    ----------
    distance : [n], of the source's centre from the centre of the test mass [m].
    size : [m], edge length of the source, along the test mass axes [m].
    sides : [3], edge lengths of the test mass [m].
    shape : a cube collapsed to its `centre`, a cube to its eight `corners` (nodal lumping), or a `slab` (normal along
        x, a tenth as thick as wide) to its centre.

    Returns
    -------
    force, gradient : [m, n], errors of Fx and Γxx; NaN where the source would reach the test mass.
    """
    nodes, weights = np.polynomial.legendre.leggauss(_SOURCE_POINTS)  # type: ignore[no-untyped-call]
    # mirror planes y = 0 and z = 0 leave a quarter of the source
    half, half_weights = nodes[nodes > 0], weights[nodes > 0]
    unit = np.stack(np.meshgrid(nodes, half, half, indexing="ij"), axis=-1).reshape(-1, 3)
    weight = np.einsum("i,j,k->ijk", weights, half_weights, half_weights).ravel() / 2.0
    corners = np.stack(np.meshgrid((-1.0, 1.0), (1.0,), (1.0,), indexing="ij"), axis=-1).reshape(-1, 3)
    flat = np.array([SLAB_THICKNESS if shape == "slab" else 1.0, 1.0, 1.0])
    force, gradient = np.full((2, size.size, distance.size), np.nan)
    for row, edge in enumerate(size):
        fits = np.flatnonzero(distance - flat[0] * edge / 2.0 > sides[0] / 2.0)
        if not fits.size:
            continue
        centre = np.stack([distance[fits], np.zeros(fits.size), np.zeros(fits.size)], axis=1)
        exact = _mean_field(centre, unit * flat * edge / 2.0, weight, sides)
        lumps = corners * edge / 2.0 if shape == "corners" else np.zeros((1, 3))
        lumped = _mean_field(centre, lumps, np.full(len(lumps), 1.0 / len(lumps)), sides)
        force[row, fits], gradient[row, fits] = (np.abs(lumped[n] / exact[n] - 1.0) for n in (0, 1))
    return force, gradient


def linearisation_error(distance: FloatArray, displacement: FloatArray, sides: FloatArray) -> FloatArray:
    """Error of Δa = -Γxx dx for a point source on the x axis moved by dx along it (figure 8.1, eq. 8.4 corrected).

    The difference is integrated from the change of Γxx over dx, which keeps ten digits where that of two accelerations
    would lose all: Δa + Γxx(x) dx = -∫ [Γxx(x + s) - Γxx(x)] ds.

    Returns
    -------
    [displacements, distances], |Δa - Δa_lin| / |Δa|.
    """
    nodes, weights = np.polynomial.legendre.leggauss(_LINE_POINTS)  # type: ignore[no-untyped-call]
    along = displacement[:, None, None] * (nodes + 1.0) / 2.0
    gamma = _gamma_xx(distance[None, :, None] + along, sides)
    start = _gamma_xx(distance, sides)
    change = (gamma - start[None, :, None]) @ (weights / 2.0)
    return np.asarray(np.abs(change / (start + change)))


def nodal_mesh(block: CompensationMass, edge_m: float) -> tuple[FloatArray, FloatArray]:
    """Block meshed by equal hexahedra no longer than `edge_m`, each sharing its mass equally among its corners.

    Returns
    -------
    points : [n, 3], nodes in the basic frame [m].
    masses : [n], kg.
    """
    counts = np.maximum(1, np.ceil(block.size_m / edge_m * (1.0 - 1e-12)).astype(int))
    axes, weights = [], []
    for count, side in zip(counts, block.size_m, strict=True):
        axes.append(np.linspace(-side / 2.0, side / 2.0, count + 1))
        share = np.full(count + 1, 1.0 / count)
        share[[0, -1]] /= 2.0
        weights.append(share)
    local = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    masses = block.mass_kg * np.einsum("i,j,k->ijk", *weights).ravel()
    return block.centre_m + local @ block.axes, masses


def _mean_field(
    centre: FloatArray, offsets: FloatArray, weights: FloatArray, sides: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Weighted mean of Fx and Γxx over the points `centre` + `offsets`, [n] each."""
    points = (centre[:, None, :] + offsets[None, :, :]).reshape(-1, 3)
    field = cuboid_field(points, sides)
    shape = (len(centre), len(offsets))
    return field.force[:, 0].reshape(shape) @ weights, field.gamma_lin[:, 0, 0].reshape(shape) @ weights


def _gamma_xx(x: FloatArray, sides: FloatArray) -> FloatArray:
    points = np.zeros((x.size, 3))
    points[:, 0] = x.ravel()
    return cuboid_field(points, sides).gamma_lin[:, 0, 0].reshape(x.shape)
