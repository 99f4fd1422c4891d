"""Defects in the rows of an optical sensitivity matrix, and factors whose cause is known."""

from __future__ import annotations

from itertools import combinations

import numpy as np

from tedm_cli.arrays import FloatArray
from tedm_cli.optics.imported import ImportedSensitivity
from tedm_cli.optics.invariances import slopes_and_translations, untouched_entries
from tedm_cli.optics.labels import input_labels, output_labels
from tedm_cli.optics.layout import N_OUTPUTS, OpticalLayout
from tedm_cli.optics.matrix_checks import row_factor_error, row_factors

_OUTPUTS = ("x", "y", "opl", "z1", "z2")
_SAME = 1e-3  # relative: a factor that has a name
_SLIP = 1e-3  # factors nearer to one, and entries smaller than this of the largest, are errors of numbers, no slips
_STRAY = 1e-3  # of the stray entries may be left by an exchange that is taken for their cause
_FACTORS = {
    1e-3: "mm or mrad given as m or rad",
    1e-6: "um or urad given as m or rad",
    1e-9: "nm or nrad given as m or rad",
    np.pi / 180: "deg given as rad",
    0.5: "Noll's factor of the Zernike tilts",
    -1.0: "the other sign",
}


def named_factor(factor: float) -> str:
    """A factor, and what it is known for: `0.001 (mm or mrad given as m or rad?)`."""
    for value, words in _FACTORS.items():
        if abs(factor / value - 1) < _SAME:
            return f"{factor:.6g} ({words}?)"
        if abs(factor * value - 1) < _SAME:
            return f"{factor:.6g} ({words}, or the inverse?)"
    return f"{factor:.6g}"


def row_defect(layout: OpticalLayout, matrix: ImportedSensitivity) -> str:
    """Rows that look scaled or that belong to another photodiode; empty when there are none."""
    factors = row_factors(layout, matrix.given)
    limit = max(_SLIP, row_factor_error(layout, matrix.given_error))
    for path, of_path in zip(layout.paths, factors, strict=True):
        if np.isnan(of_path).any():
            rows = matrix.given[layout.rows(path)]
            sizes = {name: float(np.linalg.norm(rows[:, layout.columns(name)])) for name in layout.photodiodes}
            strongest = max(sizes, key=lambda name: sizes[name])
            label = f"{path.photodiode}_{path.beam}"
            if strongest != path.photodiode:
                return f"rows of {label} respond to the photodiode {strongest} instead"
            return f"rows of {label} do not respond to {path.photodiode} as to a photodiode (x and y exchanged?)"
    scaled: dict[str, list[tuple[int, int]]] = {}
    for i, k in np.argwhere(np.abs(factors - 1) > limit):
        scaled.setdefault(f"{factors[i, k]:.4g}", []).append((int(i), int(k)))
    texts = []
    for places in scaled.values():
        mean = float(np.mean([factors[place] for place in places]))
        tilts = " (Zernike tilts declared as slopes, or another pupil?)" if len(places) == 2 * len(layout.paths) else ""
        slopes = all(_OUTPUTS[k] in ("z1", "z2") for _, k in places)
        texts.append(f"{_rows(layout, places)} look scaled by {named_factor(mean)}{tilts if slopes else ''}")
    return "; ".join(texts[:4])


def _rows(layout: OpticalLayout, places: list[tuple[int, int]]) -> str:
    """`rows opl of all paths`, `all rows of PD1A_meas`, or the labels."""
    paths, outputs = sorted({i for i, _ in places}), sorted({k for _, k in places})
    if len(paths) * len(outputs) != len(places):
        return "rows " + ", ".join(output_labels(layout).names[N_OUTPUTS * i + k] for i, k in places)
    of = [f"{layout.paths[i].photodiode}_{layout.paths[i].beam}" for i in paths]
    where = "all paths" if len(paths) == len(layout.paths) else ", ".join(of)
    what = "all rows" if len(outputs) == N_OUTPUTS else "rows " + ", ".join(_OUTPUTS[k] for k in outputs)
    return f"{what} of {where}"


def stray_entry(layout: OpticalLayout, S: FloatArray) -> str:
    """Two paths whose rows look exchanged, or the largest entry where none can be; empty when there is none.

    Parameters
    ----------
    S : the matrix without dimension, [5 * n_paths, 6 * n_elements].
    """
    slopes, translations = slopes_and_translations(layout)
    untouched = untouched_entries(layout)
    before = float(np.linalg.norm(S[untouched]))
    for a, b in combinations(layout.paths, 2):
        swapped = S.copy()
        swapped[layout.rows(a)], swapped[layout.rows(b)] = S[layout.rows(b)], S[layout.rows(a)]
        if np.linalg.norm(swapped[untouched]) < _STRAY * before:
            return f"rows of {a.photodiode}_{a.beam} and {b.photodiode}_{b.beam} look exchanged"
    for zero, words in (
        (np.outer(slopes, translations), "a slope, responds to the translation"),
        (untouched, "whose path does not meet that element, responds to"),
    ):
        stray = np.where(zero, np.abs(S), 0.0)
        i, j = np.unravel_index(stray.argmax(), S.shape)
        if stray[i, j] > _SLIP * np.abs(S).max():
            return f"{output_labels(layout).names[i]}, {words} {input_labels(layout).names[j]}"
    return ""
