"""Checks that an optical sensitivity matrix must pass whatever made it: residuals that vanish by symmetry alone.

Each residual is dimensionless. Lengths are measured in L, the largest distance between two reference points of the
layout: rows in metres are divided by L and columns per metre multiplied by L, after which the entries of a sound matrix
are of order one, and a residual of 1e-3 means a defect of a thousandth of the largest effect.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from tedm_cli.arrays import BoolArray, FloatArray
from tedm_cli.optics.common_mode import rigid_motion
from tedm_cli.optics.labels import Labels, input_labels, laser_labels, output_labels, read_out_labels
from tedm_cli.optics.law import law_matrix
from tedm_cli.optics.layout import N_MOTIONS, N_OUTPUTS, OpticalLayout
from tedm_cli.optics.read_out import read_out_inverse
from tedm_cli.optics.sensitivity import check_shape


@dataclass(frozen=True)
class InvarianceResiduals:
    """Dimensionless residuals; all are rounding (below about 1e-13) for an exact and complete matrix.

    Parameters
    ----------
    rigid_body : largest output under the six rigid motions of all elements together, as a fraction of the largest sum
        of its terms' magnitudes, so that 1 means no cancellation at all.
    bench_motion : per set, read-out of a rigid motion of the bench with the test masses at rest, plus that motion;
        largest entry, motions of unit size (1 L, 1 rad).
    photodiode_columns : largest effect of a photodiode's own motion on the laser outputs for plane waves, as a fraction
        of the largest entry of P S_BW. It is not rounding where the two beams of a photodiode arrive at an angle.
    slope_translation : largest slope per translation, as a fraction of the largest entry of S_BW.
    untouched_elements : largest effect of an element on a path that does not meet it, as a fraction of the largest
        entry; zero where the steps of the paths are not known.
    """

    rigid_body: float
    bench_motion: Mapping[str, float]
    photodiode_columns: float
    slope_translation: float
    untouched_elements: float

    def named(self) -> dict[str, float]:
        """All residuals under flat names, `bench_motion_A` and so on per set."""
        return {
            "rigid_body": self.rigid_body,
            **{f"bench_motion_{name}": value for name, value in self.bench_motion.items()},
            "photodiode_columns": self.photodiode_columns,
            "slope_translation": self.slope_translation,
            "untouched_elements": self.untouched_elements,
        }


def invariance_residuals(
    layout: OpticalLayout, S_BW: FloatArray, node_positions_m: FloatArray | None = None, P: FloatArray | None = None
) -> InvarianceResiduals:
    """Residuals of `S_BW` [5 * n_paths, 6 * n_elements].

    Parameters
    ----------
    node_positions_m : points the bench elements' rotations are about, [n_bench, 3] m, basic frame, layout order; None
        for the layout's reference points.
    P : law [3 * n_pd, 5 * n_paths] in place of `law_matrix`.

    Raises
    ------
    InputError : an array does not fit the layout.
    PhysicsError : the read-out matrix of a set is singular.

    Notes
    -----
    Wrong rotation points show as a rigid-body residual, except an error common to the whole bench and along an axis
    across which the beams cannot tell bench from test masses (x, when neither y nor z is read).
    """
    check_shape(S_BW, layout)
    motion = rigid_motion(layout, node_positions_m)
    S, M = scaled_matrix(layout, S_BW), scaled_motion(layout, motion)
    slopes, translations = slopes_and_translations(layout)
    size = layout.size_m
    plane = (law_matrix(layout, curved=False) if P is None else P) @ S_BW
    plane *= _in_units_of(laser_labels(layout), size)[:, None] / _in_units_of(input_labels(layout), size)
    diodes = layout.columns_of(tuple(e for e in layout.elements if e.kind == "photodiode"))
    return InvarianceResiduals(
        rigid_body=_ratio(S @ M, np.abs(S) @ np.abs(M)),
        bench_motion=_bench_motion(layout, (law_matrix(layout) if P is None else P) @ S_BW, motion),
        photodiode_columns=_ratio(plane[:, diodes], plane),
        slope_translation=_ratio(S[np.ix_(slopes, translations)], S),
        untouched_elements=_ratio(S[untouched_entries(layout)], S),
    )


def scaled_matrix(layout: OpticalLayout, S_BW: FloatArray) -> FloatArray:
    """S_BW without dimension: lengths in units of the largest distance between two reference points."""
    size = layout.size_m
    return np.asarray(
        S_BW * (_in_units_of(output_labels(layout), size)[:, None] / _in_units_of(input_labels(layout), size))
    )


def scaled_motion(layout: OpticalLayout, motion: FloatArray) -> FloatArray:
    """`rigid_motion` [6 * n_elements, 6] in the same units."""
    return _scaled(motion, input_labels(layout), layout.size_m)


def scaled_read_out(layout: OpticalLayout, motion: FloatArray) -> FloatArray:
    """Read-out [n_dof, 6] of the columns of `rigid_motion`, in the same units."""
    return _scaled(motion, read_out_labels(layout), layout.size_m)


def slopes_and_translations(layout: OpticalLayout) -> tuple[BoolArray, BoolArray]:
    """Rows of S_BW that are slopes, and columns that are translations; the entries where both meet are zero."""
    slopes = np.array([unit == "rad" for unit in output_labels(layout).units])
    return slopes, np.array([unit == "m" for unit in input_labels(layout).units])


def untouched_entries(layout: OpticalLayout) -> BoolArray:
    """Entries of S_BW of elements that a path does not meet, as far as its steps are known; they are zero."""
    untouched = np.zeros((N_OUTPUTS * len(layout.paths), N_MOTIONS * len(layout.elements)), dtype=bool)
    for path in layout.paths:
        untouched[layout.rows(path)] = bool(path.steps)
        for name in {step.element for step in path.steps}:
            untouched[layout.rows(path), layout.columns(name)] = False
    return untouched


def _bench_motion(layout: OpticalLayout, PS: FloatArray, motion: FloatArray) -> dict[str, float]:
    bench = layout.columns_of(layout.bench)
    expected = -layout.read_out_motions.T @ motion
    out = {}
    for name, photodiodes in layout.sets.items():
        inverse = read_out_inverse(layout, name, PS).inverse
        read = inverse @ PS[np.ix_(layout.laser_rows(photodiodes), bench)] @ motion[bench]
        out[name] = float(np.abs(scaled_read_out(layout, read - expected)).max())
    return out


def _in_units_of(labels: Labels, size: float) -> FloatArray:
    """Factors that measure the labelled quantities in units of `size` (lengths) and radians (angles)."""
    return np.array([1 / size if unit == "m" else 1.0 for unit in labels.units])


def _scaled(motion: FloatArray, rows: Labels, size: float) -> FloatArray:
    """Rows in units of `size` or radians, for rigid motions of one `size` and one radian."""
    return np.asarray(motion * _in_units_of(rows, size)[:, None] * np.array([size] * 3 + [1.0] * 3))


def _ratio(part: FloatArray, whole: FloatArray) -> float:
    largest = float(np.abs(whole).max())
    return float(np.abs(part).max(initial=0.0)) / largest if largest > 0 else 0.0
