"""Optical matrices made elsewhere, put into the order, units, frame and reference points of the layout.

Nothing is guessed: what the maker of a matrix chose (labels, units, frame, rotation points, Zernike convention) is
declared, and every label must have its place. How exactly the entries are known follows from the digits they have.
"""

from __future__ import annotations

import difflib
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np

from tedm_cli.arrays import FloatArray
from tedm_cli.errors import InputError
from tedm_cli.optics.invariances import scaled_matrix
from tedm_cli.optics.labels import Labels, input_labels, laser_labels, output_labels
from tedm_cli.optics.layout import N_MOTIONS, N_OUTPUTS, Beam, OpticalLayout, Vec3
from tedm_cli.optics.sensitivity import cross_matrix, turned_about

Slopes = Literal["angle", "zernike", "noll"]
Frame = Literal["layout", "basic"]
MassAxes = Literal["frame", "own"]

#: Unit of a row or column: what it measures, and its size in SI.
UNIT_SCALES: Mapping[str, tuple[Literal["m", "rad"], float]] = {
    **{f"{prefix}m": ("m", size) for prefix, size in {"": 1.0, "m": 1e-3, "u": 1e-6, "n": 1e-9, "p": 1e-12}.items()},
    **{f"{prefix}rad": ("rad", size) for prefix, size in {"": 1.0, "m": 1e-3, "u": 1e-6, "n": 1e-9}.items()},
    "deg": ("rad", np.pi / 180),
    "arcmin": ("rad", np.pi / 10800),
    "arcsec": ("rad", np.pi / 648000),
}
_ALL = 13  # digits that are as good as double precision
_LAST = 280  # decimals whose power of ten is a number
_DIGITS = range(3, _ALL)  # fewer are taken as exact: such numbers are short by themselves (0, 1, -0.5)
_SINGLE = 2.0**-21  # a few roundings in single precision
_SHOWN = 8  # labels named in one message


@dataclass(frozen=True, eq=False)
class LabelledMatrix:
    """A matrix as its maker wrote it: an entry has the unit of its row per unit of its column."""

    values: FloatArray
    rows: Labels
    columns: Labels


@dataclass(frozen=True)
class Conventions:
    """What the outputs of a matrix mean.

    Parameters
    ----------
    beams : what the labels call the measurement and the reference beam.
    slopes : z1, z2 are slopes of the wave front (an angle), or its Zernike tilts, lengths `R z` (unnormalised) or
        `R z / 2` (Noll), R the pupil radius.
    pupil_radius_m : R; None for angles.
    accuracy : error of the entries where it is not that of their digits, as a fraction of the largest entry (lengths in
        units of the layout's size).
    """

    beams: Mapping[Beam, str]
    slopes: Slopes
    pupil_radius_m: float | None = None
    accuracy: float | None = None

    @property
    def slope_per_output(self) -> float:
        """Slope (rad) per unit of z1, z2 as given (rad, or m of a Zernike tilt)."""
        if self.slopes == "angle" or self.pupil_radius_m is None:
            return 1.0
        return (1.0 if self.slopes == "zernike" else 2.0) / self.pupil_radius_m


@dataclass(frozen=True)
class MotionConventions:
    """What the motions of a sensitivity matrix mean.

    Parameters
    ----------
    frame : axes of translations, rotations and given reference points: those of the layout, or the model's basic frame.
    reference_points : what the elements turn about: "layout" (their `ref_m`), "grid" (their finite-element grid; a test
        mass has none and keeps `ref_m`), or coordinates in m; one for all, or by element.
    test_mass_axes : columns of test masses are along the axes of `frame`, or of each along its own; None where the axes
        of all test masses are those of the layout.
    """

    frame: Frame
    reference_points: str | Mapping[str, str | Vec3]
    test_mass_axes: MassAxes | None = None


@dataclass(frozen=True, eq=False)
class ImportedSensitivity:
    """A sensitivity matrix in SI and in the order of the layout, [5 * n_paths, 6 * n_elements].

    Parameters
    ----------
    S_BW, error : in the layout frame, about the grids; bound of the error of each entry.
    digits : how the error was found.
    given, given_error : the same on the axes and about the points that its maker used.
    points_m : these points, [n_elements, 3] in that frame.
    frame : that frame.
    """

    S_BW: FloatArray
    error: FloatArray
    digits: str
    given: FloatArray
    given_error: FloatArray
    points_m: FloatArray
    frame: Frame


def import_sensitivity(
    layout: OpticalLayout,
    matrix: LabelledMatrix,
    outputs: Conventions,
    motions: MotionConventions,
    node_positions_m: FloatArray,
) -> ImportedSensitivity:
    """S_BW as `optics_chain` takes it, for motions of the grids at `node_positions_m` [n_bench, 3] (m, basic frame).

    Raises
    ------
    InputError : labels or units that do not fit the layout, or reference points that are missing; all are named. Axes
        of test masses that are not declared.
    """
    expected = output_labels(layout, outputs.beams)
    lengths = outputs.slopes != "angle"
    rows = Labels(expected.names, tuple("m" if lengths else unit for unit in expected.units))
    values, error, digits = _arranged(matrix, rows, input_labels(layout))
    slope = _slopes(layout, outputs)[:, None]
    given, given_error = slope * values, slope * error
    turn = _mass_axes(layout, motions)
    given, given_error = given @ turn, given_error @ np.abs(turn)
    if outputs.accuracy is not None:
        unit = scaled_matrix(layout, np.ones_like(given))
        given_error = np.maximum(given_error, outputs.accuracy * np.abs(unit * given).max() / unit)
        digits = f"declared accuracy {outputs.accuracy:g}"
    points = _reference_points(layout, motions, node_positions_m)
    offsets = points - layout.pivots_m(node_positions_m)
    axes = layout.axes if motions.frame == "basic" else np.eye(3)
    # u_layout = axes u_given, so that S_layout = S_given axes^T on translations and rotations alike.
    S_BW = turned_about(_on_axes(given, axes.T), offsets)
    bound = _on_axes(given_error, np.abs(axes.T))
    blocks = bound.reshape(len(bound), -1, 2, 3)  # a view
    blocks[:, :, 1] += np.einsum("rei,eij->rej", blocks[:, :, 0], np.abs(cross_matrix(offsets)))
    return ImportedSensitivity(
        S_BW, bound, digits, given, given_error, in_frame(layout, motions.frame, points), motions.frame
    )


def own_axes(layout: OpticalLayout, frame: Frame) -> FloatArray:
    """Motions of all elements as columns have them by those on axes of `frame`, [6 * n_elements, 6 * n_elements].

    Those of test masses turned onto their own axes, of all others as they are: `S_frame = S_own own_axes`.
    """
    axes = layout.test_mass_axes if frame == "layout" else layout.test_mass_axes_basic
    out = np.eye(N_MOTIONS * len(layout.elements))
    for mass, turn in zip(layout.test_masses, axes, strict=True):
        columns = layout.columns(mass.name)
        out[columns, columns] = np.kron(np.eye(2), turn)
    return out


def in_frame(layout: OpticalLayout, frame: Frame, points_m: FloatArray) -> FloatArray:
    """Points [n, 3] of the layout frame in the layout or the basic frame."""
    return np.asarray(points_m @ layout.axes + np.array(layout.frame_origin_m) if frame == "basic" else points_m)


def import_law(layout: OpticalLayout, matrix: LabelledMatrix, outputs: Conventions) -> FloatArray:
    """P [3 * n_pd, 5 * n_paths] as `optics_chain` takes it: OPD (m), WFT (rad) by outputs in m and rad.

    Raises
    ------
    InputError : labels or units that do not fit the layout; all are named.
    """
    expected = output_labels(layout, outputs.beams)
    lengths = outputs.slopes != "angle"
    columns = Labels(expected.names, tuple("m" if lengths else unit for unit in expected.units))
    values, _, _ = _arranged(matrix, laser_labels(layout), columns)
    return np.asarray(values / _slopes(layout, outputs))


def printed_accuracy(values: FloatArray) -> tuple[FloatArray, str]:
    """Bound of the rounding error of each of `values`, and in words what it was found from.

    Taken for numbers printed with n digits, or n decimals where that is fewer, when all of them are; else for numbers
    in single, else in double precision.
    """
    eps = float(np.finfo(np.float64).eps)

    def same(rounded: FloatArray) -> bool:
        return bool((np.abs(rounded - values) <= 8 * eps * np.abs(values)).all())

    size = np.abs(values)
    exponent = np.floor(np.log10(np.where(size > 0, size, 1.0)))
    digits = next((n for n in range(1, _ALL) if same(_rounded(values, n - 1 - exponent))), _ALL)
    decimals = next((n for n in range(1, _ALL) if same(_rounded(values, np.full_like(values, n)))), _ALL)
    if decimals in _DIGITS and decimals <= digits:
        return np.full_like(values, 0.5 * 10.0**-decimals), f"{decimals} decimals"
    if digits in _DIGITS:
        return np.where(size > 0, 0.5 * 10.0 ** (exponent + 1 - digits), 0.0), f"{digits} significant digits"
    if digits == _ALL and same(values.astype(np.float32).astype(np.float64)):
        return _SINGLE * size, "single precision"
    return 8 * eps * size, "double precision"


def _rounded(values: FloatArray, decimals: FloatArray) -> FloatArray:
    """Values at so many decimals; by powers of ten that are exact as long as they may be, not by their inverses."""
    held = np.clip(decimals, -_LAST, _LAST)  # further out there is no power of ten
    up, down = 10.0 ** np.maximum(held, 0), 10.0 ** np.maximum(-held, 0)
    return np.where(held == decimals, np.round(values / down * up) / up * down, values)


def _arranged(matrix: LabelledMatrix, rows: Labels, columns: Labels) -> tuple[FloatArray, FloatArray, str]:
    """Values and errors of the wanted rows and columns in their order, in SI."""
    problems = [
        *_label_problems("row", matrix.rows, rows),
        *_label_problems("column", matrix.columns, columns),
    ]
    if problems:
        raise InputError(
            "; ".join(problems),
            hint="give all labels of the layout, with units: PD1A_meas_x by BS3_ux (S_BW), PD1A_OPD by PD1A_meas_x (P)",
        )
    if not np.isfinite(matrix.values).all():
        i, j = np.argwhere(~np.isfinite(matrix.values))[0]
        raise InputError(f"row {matrix.rows.names[i]}, column {matrix.columns.names[j]} is not a finite number")
    error, digits = printed_accuracy(matrix.values)
    factors = _sizes(matrix.rows)[:, None] / _sizes(matrix.columns)
    order = np.ix_(_places(matrix.rows, rows), _places(matrix.columns, columns))
    return (matrix.values * factors)[order], (error * factors)[order], digits


def _label_problems(axis: str, given: Labels, wanted: Labels) -> list[str]:
    out = []
    repeated = [name for name, n in Counter(given.names).items() if n > 1]
    missing = [name for name in wanted.names if name not in set(given.names)]
    extra = [name for name in given.names if name not in set(wanted.names)]
    for what, names in (("given twice", repeated), ("missing", missing), ("unknown", extra)):
        if names:
            more = f" and {len(names) - _SHOWN} more" if len(names) > _SHOWN else ""
            out.append(f"{axis}s {what}: {', '.join(names[:_SHOWN])}{more}")
    if missing and extra and (near := difflib.get_close_matches(extra[0], missing, n=1, cutoff=0.5)):
        out[-1] += f" (is {extra[0]} meant to be {near[0]}?)"
    unit_of = dict(zip(wanted.names, wanted.units, strict=True))
    for name, unit in zip(given.names, given.units, strict=True):
        if unit not in UNIT_SCALES:
            out.append(f"{axis} {name}: unknown unit {unit!r}, known are {', '.join(UNIT_SCALES)}")
        elif name in unit_of and UNIT_SCALES[unit][0] != unit_of[name]:
            what = "a length" if unit_of[name] == "m" else "an angle"
            out.append(f"{axis} {name}: {unit} is not the unit of {what}")
    return out[:_SHOWN]


def _sizes(labels: Labels) -> FloatArray:
    return np.array([UNIT_SCALES[unit][1] for unit in labels.units])


def _places(given: Labels, wanted: Labels) -> list[int]:
    at = {name: i for i, name in enumerate(given.names)}
    return [at[name] for name in wanted.names]


def _mass_axes(layout: OpticalLayout, motions: MotionConventions) -> FloatArray:
    """What takes columns as declared to the axes of their frame, [6 * n_elements, 6 * n_elements]."""
    if motions.test_mass_axes is None and layout.has_own_axes:
        raise InputError(
            "the test masses have axes of their own; which axes their columns are along is not declared",
            hint='declare test_mass_axes = "own" (axes of each test mass) or "frame" (axes of all other elements)',
        )
    return (
        own_axes(layout, motions.frame) if motions.test_mass_axes == "own" else np.eye(N_MOTIONS * len(layout.elements))
    )


def _slopes(layout: OpticalLayout, outputs: Conventions) -> FloatArray:
    """SI output per output as given, [5 * n_paths]."""
    factors = np.ones((len(layout.paths), N_OUTPUTS))
    factors[:, 3:] = outputs.slope_per_output
    return factors.reshape(-1)


def _on_axes(S: FloatArray, turn: FloatArray) -> FloatArray:
    """S [rows, 6 * n_elements] with each triple of columns times `turn` [3, 3]."""
    return np.asarray((S.reshape(len(S), -1, 3) @ turn).reshape(S.shape))


def _reference_points(layout: OpticalLayout, motions: MotionConventions, node_positions_m: FloatArray) -> FloatArray:
    """What the elements turn about, [n_elements, 3] m, layout frame."""
    given = motions.reference_points
    names = [e.name for e in layout.elements]
    by_element = dict.fromkeys(names, given) if isinstance(given, str) else given
    problems = [
        f"reference points {what}: {', '.join(listed)}"
        for what, listed in (
            ("missing", [n for n in names if n not in by_element]),
            ("of unknown elements", [n for n in by_element if n not in names]),
        )
        if listed
    ]
    if problems:
        raise InputError("; ".join(problems), hint="name every element of the layout, or give one word for all")
    known = {"layout": layout.refs_m, "grid": layout.pivots_m(node_positions_m)}
    out = np.zeros((len(names), 3))
    for i, name in enumerate(names):
        point = by_element[name]
        if isinstance(point, str):
            out[i] = known[point][i]
        elif motions.frame == "basic":
            out[i] = layout.axes @ (np.array(point) - np.array(layout.frame_origin_m))
        else:
            out[i] = point
    return out
