"""What is wrong with an optical sensitivity matrix whose invariances fail.

Each hypothesis is one slip that people make with such matrices. It is fitted alone, and the simplest one that restores
the invariance under rigid motions is named. Rows drop out of that invariance one by one, so their scale is taken from
the photodiodes' own columns (`matrix_checks.row_factors`).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from itertools import combinations, permutations, product

import numpy as np

from tedm_cli.arrays import FloatArray, IndexArray
from tedm_cli.optics.common_mode import rigid_motion_about
from tedm_cli.optics.imported import Frame, ImportedSensitivity, in_frame, own_axes
from tedm_cli.optics.invariances import scaled_matrix
from tedm_cli.optics.labels import input_labels, output_labels
from tedm_cli.optics.layout import OpticalLayout
from tedm_cli.optics.row_defects import named_factor, row_defect, stray_entry
from tedm_cli.optics.sensitivity import cross_matrix

RESTORED = 1e-3  # of the residual, or what the digits make of it, may be left by a slip that is taken for the cause
_NEEDED = 0.1  # of the residual at most, whatever the digits
_AS_GOOD = 10.0  # residuals within this factor of the best fit as well: the simplest is named
_MOTIONS = ("ux", "uy", "uz", "rx", "ry", "rz")


@dataclass(frozen=True)
class Explanation:
    """A slip in words, and the residual under rigid motions that is left once it is mended (root of sum of squares)."""

    text: str
    left: float


def explain_defect(layout: OpticalLayout, matrix: ImportedSensitivity, node_positions_m: FloatArray) -> str:
    """The defect of an imported S_BW in words; empty when no single slip explains what fails.

    Parameters
    ----------
    node_positions_m : [n_bench, 3] m, basic frame.
    """
    trial = _trial(layout, matrix, matrix.points_m)
    S, M, before = trial.S, trial.M, float(np.linalg.norm(trial.residual))
    noise = float(np.linalg.norm((_row_units(layout)[:, None] * matrix.given_error) @ np.abs(M)))
    floor = max(noise, 1e-12 * float(np.linalg.norm(np.abs(S) @ np.abs(M))))
    if before > floor:
        enough = min(max(floor, RESTORED * before), _NEEDED * before)
        mending = [h for h in _hypotheses(trial, matrix, node_positions_m) if h.left <= enough]
        if mending:
            best = max(floor, min(h.left for h in mending))
            return next(h.text for h in mending if h.left <= _AS_GOOD * best)
    return row_defect(layout, matrix) or stray_entry(layout, scaled_matrix(layout, matrix.given))


def most_changed(layout: OpticalLayout, matrix: ImportedSensitivity) -> str:
    """The output that changes most when everything moves together, and the motion, in words."""
    residual = _trial(layout, matrix, matrix.points_m).residual
    i, j = np.unravel_index(np.abs(residual).argmax(), residual.shape)
    return f"{output_labels(layout).names[i]} when all {('shift along', 'turn about')[j // 3]} {'xyz'[j % 3]}"


@dataclass(frozen=True, eq=False)
class _Trial:
    """FloatArray S and rigid motions M of all elements, in the maker's frame, about the declared points.

    Rows of S and columns of M are in units of the layout's size; the motions between them stay in m and rad, so that
    columns given as others keep the size they were given with.
    """

    layout: OpticalLayout
    S: FloatArray
    M: FloatArray

    @cached_property
    def residual(self) -> FloatArray:
        return self.S @ self.M


def _trial(layout: OpticalLayout, matrix: ImportedSensitivity, points_m: FloatArray) -> _Trial:
    size = layout.size_m
    motion = rigid_motion_about(points_m, points_m.mean(axis=0)) * np.repeat([size, 1.0], 3)
    return _Trial(layout, _row_units(layout)[:, None] * matrix.given, motion)


def _row_units(layout: OpticalLayout) -> FloatArray:
    """Factors that measure the outputs in units of the layout's size."""
    return np.array([1 / layout.size_m if unit == "m" else 1.0 for unit in output_labels(layout).units])


def _hypotheses(trial: _Trial, matrix: ImportedSensitivity, node_positions_m: FloatArray) -> Iterator[Explanation]:
    """From the simplest to the least specific."""
    yield from _scaled_kinds(trial)
    yield from _other_points(trial, matrix, node_positions_m)
    yield from _other_mass_axes(trial, matrix.frame)
    yield from _other_frames(trial)
    yield from _scaled_columns(trial)
    yield from _exchanged(trial)
    yield from _reordered(trial)
    yield from _moved_points(trial)
    yield from _wrong_columns(trial)


def _scaled_kinds(trial: _Trial) -> Iterator[Explanation]:
    """All rotations against all translations, all test masses against the bench."""
    layout, n = trial.layout, trial.S.shape[1]
    rotations = np.flatnonzero(np.arange(n) % 6 >= 3)
    yield from _scaling("columns of all rotations, against those of all translations,", trial, rotations)
    masses = layout.columns_of(layout.test_masses)
    yield from _scaling("columns of the test masses, against those of the bench,", trial, masses)


def _scaled_columns(trial: _Trial) -> Iterator[Explanation]:
    """Of one element: all its columns, its translations or rotations, one column."""
    for size in (6, 3, 1):
        for first in range(0, trial.S.shape[1], size):
            name = trial.layout.elements[first // 6].name
            what = {
                6: f"columns of {name}",
                3: f"columns of the {('translations', 'rotations')[first // 3 % 2]} of {name}",
                1: f"column {name}_{_MOTIONS[first % 6]}",
            }[size]
            yield from _scaling(what, trial, np.arange(first, first + size))


def _scaling(what: str, trial: _Trial, chosen: IndexArray) -> Iterator[Explanation]:
    """The chosen columns times one factor."""
    part = trial.S[:, chosen] @ trial.M[chosen]
    square = float((part**2).sum())
    if square == 0:
        return
    mend = 1 - float((part * trial.residual).sum()) / square
    if abs(mend) > 1e-12:
        looks = "looks" if what.startswith("column ") else "look"
        left = float(np.linalg.norm(trial.residual + (mend - 1) * part))
        yield Explanation(f"{what} {looks} scaled by {named_factor(1 / mend)}", left)


def _other_points(trial: _Trial, matrix: ImportedSensitivity, node_positions_m: FloatArray) -> Iterator[Explanation]:
    """Turned about the layout's reference points or about the grids, whatever was declared."""
    layout = trial.layout
    for what, points in (
        ("ref_m of the layout", layout.refs_m),
        ("grids of the elements", layout.pivots_m(node_positions_m)),
    ):
        other = _trial(layout, matrix, in_frame(layout, matrix.frame, points))
        if not np.array_equal(other.M, trial.M):
            yield Explanation(f"rotations look to be about the {what}", float(np.linalg.norm(other.residual)))


def _other_mass_axes(trial: _Trial, frame: Frame) -> Iterator[Explanation]:
    """The columns of the test masses along their own axes, or along those of the frame, whatever was declared."""
    if trial.layout.has_own_axes:
        turn = own_axes(trial.layout, frame)
        for what, axes in (("their own axes", turn), (f"the axes of the {frame} frame", turn.T)):
            left = float(np.linalg.norm(trial.S @ axes @ trial.M))
            yield Explanation(f"columns of the test masses look to be along {what}", left)


def _other_frames(trial: _Trial) -> Iterator[Explanation]:
    """The six columns of every element on other axes or in another order.

    Both act alike on all elements, so only the sums over elements `T[i, j] = sum S_e,i M_e,j` of all pairs matter.
    """
    T = np.einsum("rei,ejm->ijrm", trial.S.reshape(len(trial.S), -1, 6), trial.M.reshape(-1, 6, 6))
    for turn, axes in _rotations(trial.layout):
        left = float(np.linalg.norm(np.einsum("ijrm,ij->rm", T, np.kron(np.eye(2), turn))))
        yield Explanation(f"the matrix looks to be in another frame, with {axes}", left)
    for order, names in _orders():
        left = float(np.linalg.norm(T[order, range(6)].sum(axis=0)))
        yield Explanation(f"columns of every element look to be in the order {names}", left)


def _rotations(layout: OpticalLayout) -> Iterator[tuple[FloatArray, str]]:
    """Rotations from the declared axes to others, in words: along other axes, or of layout and basic frame."""
    for places in permutations(range(3)):
        for signs in product((1.0, -1.0), repeat=3):
            turn = np.zeros((3, 3))
            turn[range(3), places] = signs
            if np.linalg.det(turn) > 0 and not np.array_equal(turn, np.eye(3)):
                named = (("-" if s < 0 else "") + "xyz"[k] for k, s in zip(places, signs, strict=True))
                yield turn, f"its axes along {', '.join(named)} of the declared one"
    if not np.array_equal(layout.axes, np.eye(3)):
        yield layout.axes, "the axes of the layout in place of the basic ones"
        yield layout.axes.T, "the basic axes in place of those of the layout"


def _orders() -> Iterator[tuple[tuple[int, ...], str]]:
    """Where each of the six motions is found, and the order that makes."""
    for order in permutations(range(6)):
        if order != tuple(range(6)):
            yield order, " ".join(_MOTIONS[order.index(i)] for i in range(6))


def _exchanged(trial: _Trial) -> Iterator[Explanation]:
    """Two elements, or two columns, exchanged: `R = R0 + (S_a - S_b)(M_b - M_a)`."""
    names = [e.name for e in trial.layout.elements]
    S, M = trial.S.reshape(len(trial.S), -1, 6), trial.M.reshape(-1, 6, 6)
    for a, b in combinations(range(len(names)), 2):
        left = float(np.linalg.norm(trial.residual + (S[:, a] - S[:, b]) @ (M[b] - M[a])))
        yield Explanation(f"columns of {names[a]} and {names[b]} look exchanged", left)
    # The same for all pairs of columns at once, from products of the columns with each other and with the residual.
    cross = trial.S.T @ trial.residual @ trial.M.T
    own = np.diag(cross)
    change = cross + cross.T - own[:, None] - own
    square = float((trial.residual**2).sum()) + 2 * change + _distances(trial.S.T) * _distances(trial.M)
    labels = input_labels(trial.layout).names
    for a, b in zip(*np.triu_indices(len(labels), 1), strict=True):
        if square[a, b] <= _NEEDED**2 * square[a, a]:
            swapped = trial.residual + np.outer(trial.S[:, a] - trial.S[:, b], trial.M[b] - trial.M[a])
            yield Explanation(f"columns {labels[a]} and {labels[b]} look exchanged", float(np.linalg.norm(swapped)))


def _distances(rows: FloatArray) -> FloatArray:
    """Squared distances between all rows."""
    return np.asarray(np.sum((rows[:, None] - rows[None]) ** 2, axis=2))


def _reordered(trial: _Trial) -> Iterator[Explanation]:
    """The six columns of one element in another order."""
    S, M = trial.S.reshape(len(trial.S), -1, 6), trial.M.reshape(-1, 6, 6)
    orders = list(_orders())
    for e, element in enumerate(trial.layout.elements):
        T = np.einsum("ri,jm->ijrm", S[:, e], M[e])
        rest = trial.residual - S[:, e] @ M[e]
        left = np.linalg.norm(rest + T[np.array([o for o, _ in orders]), range(6)].sum(axis=1), axis=(1, 2))
        best = int(left.argmin())
        yield Explanation(f"columns of {element.name} look to be in the order {orders[best][1]}", float(left[best]))


def _moved_points(trial: _Trial) -> Iterator[Explanation]:
    """Rotations of one element, or of the whole bench, about a point off the declared one by r: `R = R0 - S_u [r]x`."""
    layout = trial.layout
    for what, elements in (
        *((f"reference point of {e.name} looks", (e,)) for e in layout.elements),
        ("reference points of all the bench look", layout.bench),
    ):
        shift = sum(trial.S[:, layout.columns(e.name)][:, :3] for e in elements)
        effect = np.zeros((*trial.residual.shape, 3))
        for k in range(3):
            effect[:, 3:, k] = -shift @ cross_matrix(np.eye(3)[k])
        r, *_ = np.linalg.lstsq(effect.reshape(-1, 3), -trial.residual.reshape(-1), rcond=1e-9)
        mm = ", ".join(f"{1e3 * v:.4g}" for v in r)
        yield Explanation(
            f"{what} to be ({mm}) mm off the declared one", float(np.linalg.norm(trial.residual + effect @ r))
        )


def _wrong_columns(trial: _Trial) -> Iterator[Explanation]:
    """One column that may be anything, or an element that is left out."""
    labels = input_labels(trial.layout).names
    for i in (i for i in range(len(labels)) if i % 6 < 3):
        yield Explanation(f"column {labels[i]} looks wrong or missing", _left_free(trial, np.array([i])))
    for k in range(3):
        # All elements turn alike, so their columns cannot be told apart.
        text = f"a column {_MOTIONS[3 + k]} looks wrong or missing; which element's cannot be told"
        yield Explanation(text, _left_free(trial, np.array([3 + k])))
    for e in trial.layout.elements:
        columns = np.arange(len(labels))[trial.layout.columns(e.name)]
        if not trial.S[:, columns].any() and _is_met(trial.layout, e.name):
            yield Explanation(f"columns of {e.name} are all zero", _left_free(trial, columns))


def _left_free(trial: _Trial, chosen: IndexArray) -> float:
    """Residual when the chosen columns may be anything."""
    span = trial.M[chosen]
    return float(np.linalg.norm(trial.residual - trial.residual @ np.linalg.pinv(span) @ span))


def _is_met(layout: OpticalLayout, name: str) -> bool:
    known = [path for path in layout.paths if path.steps]
    return not known or any(step.element == name for path in known for step in path.steps)
