"""Verdicts on an optical sensitivity matrix: residuals of its invariances against what its digits allow."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tedm_cli.arrays import FloatArray
from tedm_cli.errors import PhysicsError
from tedm_cli.optics.common_mode import rigid_motion
from tedm_cli.optics.invariances import (
    invariance_residuals,
    scaled_matrix,
    scaled_motion,
    scaled_read_out,
    slopes_and_translations,
    untouched_entries,
)
from tedm_cli.optics.layout import OpticalLayout
from tedm_cli.optics.read_out import read_out_inverse

RESIDUAL_LIMIT = 1e-9  # rigid motions through an exact matrix leave rounding, about 1e-14
#: A face that looks this far off the axes of its test mass is that of a drawing; further off it is a mistake, rad.
LARGEST_SKEW_RAD = 1e-4
_LOST_DIGITS = 0.1  # of the smallest singular value; more of it may not be error


@dataclass(frozen=True)
class Judged:
    """A dimensionless residual against its limit (infinite: reported only)."""

    name: str
    value: float
    limit: float

    @property
    def passed(self) -> bool:
        return self.value <= self.limit


@dataclass(frozen=True)
class BlockDifference:
    """Largest difference of two matrices in the rows of a path and the columns of an element.

    A fraction of the largest entry of the second, lengths in units of the layout's size.
    """

    path: str
    element: str
    value: float


def block_differences(layout: OpticalLayout, S_BW: FloatArray, other: FloatArray) -> tuple[BlockDifference, ...]:
    """Differences of all blocks of two matrices [5 * n_paths, 6 * n_elements], largest first."""
    scaled = scaled_matrix(layout, other)
    difference = np.abs(scaled_matrix(layout, S_BW) - scaled) / np.abs(scaled).max()
    blocks = [
        BlockDifference(path.label, e.name, float(difference[layout.rows(path), layout.columns(e.name)].max()))
        for path in layout.paths
        for e in layout.elements
    ]
    return tuple(sorted(blocks, key=lambda b: -b.value))


def judge_matrix(
    layout: OpticalLayout,
    S_BW: FloatArray,
    P: FloatArray,
    node_positions_m: FloatArray,
    error: FloatArray | None = None,
) -> tuple[Judged, ...]:
    """Residuals of `invariance_residuals` and, of an imported matrix, of `row_factors`, each with its limit.

    Parameters
    ----------
    error : bound of the error of each entry of an imported S_BW; None for a traced one. A limit is the residual that
        errors of this size can make at worst, at least 1e-9. A face off its axes by what a drawing may be reads y as x
        by that angle, which bench motions are allowed besides.

    Raises
    ------
    InputError : an array does not fit the layout.
    PhysicsError : the read-out matrix of a set is singular, or no more than its errors are.
    """
    residuals = invariance_residuals(layout, S_BW, node_positions_m, P).named()
    limits = dict.fromkeys(residuals, RESIDUAL_LIMIT)
    if error is not None:
        residuals["photodiode_rows"] = float(np.nan_to_num(np.abs(row_factors(layout, S_BW) - 1.0), nan=np.inf).max())
        limits = _limits(layout, S_BW, P, node_positions_m, error)
        _judge_condition(layout, S_BW, P, error)
    if layout.has_geometry and (skew := float(layout.skews_rad.max(initial=0.0))) <= LARGEST_SKEW_RAD:
        for name in layout.sets:
            limits[f"bench_motion_{name}"] += 3.0 * skew
    # Photodiode columns are not judged: they are rounding only where both beams meet at the photodiode's centre.
    limits["photodiode_columns"] = np.inf
    return tuple(Judged(name, value, max(limits[name], RESIDUAL_LIMIT)) for name, value in residuals.items())


def row_factors(layout: OpticalLayout, S_BW: FloatArray) -> FloatArray:
    """Factor by which each output looks scaled, [n_paths, 5]: x, y, opl, z1, z2; all are 1 in a sound matrix.

    A photodiode that moves alone gives the scale away, at any incidence. With its axes ex, ey, ez and the direction d
    of the beam, a unit vector, x moves by (ez (ex.d) / (ez.d) - ex).u, y alike, opl by ez.u / (ez.d), z1 by
    theta.(ex x d) and z2 by theta.(ey x d). NaN where the photodiode's own columns do not fit this form at all.
    """
    out = np.full((len(layout.paths), 5), np.nan)
    for i, path in enumerate(layout.paths):
        own = S_BW[layout.rows(path), layout.columns(path.photodiode)]
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            out[i] = _factors(own[:3, :3], own[3:, 3:])
    out[~np.isfinite(out)] = np.nan
    return np.where(np.isnan(out).any(axis=1)[:, None], np.nan, out)


def row_factor_error(layout: OpticalLayout, error: FloatArray) -> float:
    """How far `row_factors` can be off for entries off by `error`; the entries they are made of are of order one."""
    return 8 * float(max(error[layout.rows(p), layout.columns(p.photodiode)].max() for p in layout.paths))


def _factors(shift: FloatArray, turn: FloatArray) -> FloatArray:
    normal = shift[2] / np.linalg.norm(shift[2])
    across = shift[:2] - np.outer(shift[:2] @ normal, normal)
    x, y = np.linalg.norm(across, axis=1)
    ex, ey = -across[0] / x, -across[1] / y
    ez = np.cross(ex, ey)
    dy, dx = -(turn[0] @ ez) / (turn[0] @ ey), -(turn[1] @ ez) / (turn[1] @ ex)  # over dz
    dz = -1.0 / np.sqrt(1.0 + dx**2 + dy**2)
    opl, z1, z2 = (shift[2] @ ez) * dz, -(turn[0] @ ey) / dz, (turn[1] @ ex) / dz
    if opl < 0 and (z1 < 0) != (z2 < 0):  # the axes were taken from x and y: one of these has the wrong sign
        x, y = (-x, y) if z2 < 0 else (x, -y)
        opl, z1, z2 = -opl, abs(z1), abs(z2)
    return np.array([x, y, opl, z1, z2])


def _limits(
    layout: OpticalLayout, S_BW: FloatArray, P: FloatArray, node_positions_m: FloatArray, error: FloatArray
) -> dict[str, float]:
    """Residuals that entries off by `error` can make at worst."""
    S, E = scaled_matrix(layout, S_BW), scaled_matrix(layout, error)
    motion = np.abs(rigid_motion(layout, node_positions_m))
    M = scaled_motion(layout, motion)
    largest = float(np.abs(S).max())
    slopes, translations = slopes_and_translations(layout)
    spread = float((E @ M).max())  # of the scaled outputs under rigid motions
    limits = {
        "rigid_body": spread / float((np.abs(S) @ M).max()),
        "slope_translation": float(E[np.ix_(slopes, translations)].max()) / largest,
        "untouched_elements": float(E[untouched_entries(layout)].max(initial=0.0)) / largest,
        "photodiode_rows": row_factor_error(layout, error),
    }
    for name, photodiodes in layout.sets.items():
        rows = layout.laser_rows(photodiodes)
        inverse = read_out_inverse(layout, name, P @ S_BW).inverse
        read = scaled_read_out(layout, np.abs(inverse) @ np.abs(P[rows]) @ (error @ motion))
        limits[f"bench_motion_{name}"] = float(read.max())
    return limits


def _judge_condition(layout: OpticalLayout, S_BW: FloatArray, P: FloatArray, error: FloatArray) -> None:
    """Refuse a set whose smallest singular value is no more than the errors of its entries."""
    for name, photodiodes in layout.sets.items():
        law = read_out_inverse(layout, name, P @ S_BW)
        rows = layout.laser_rows(photodiodes)
        unsure = float(np.linalg.norm(np.abs(P[rows]) @ error @ np.abs(layout.read_out_motions), 2))
        least = float(law.singular_values[-1])
        if unsure > _LOST_DIGITS * least:
            raise PhysicsError(
                f"the smallest singular value of the read-out matrix is {least:.3g}, condition number"
                f" {law.condition:.3g}; its entries are known to {unsure:.1g} only",
                where=f"read-out set {name} ({', '.join(photodiodes)})",
                hint="give the matrix with more digits, or check the units of the test masses' columns",
            )
