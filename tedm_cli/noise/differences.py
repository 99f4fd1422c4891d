"""Outputs that are the difference of two others, such as the differential acceleration of two test masses."""

from __future__ import annotations

import difflib
from collections.abc import Sequence

import numpy as np

from tedm_cli.arrays import FloatArray
from tedm_cli.noise.requirements import AppliedRequirement


def terms(label: str) -> tuple[str, str] | None:
    """(`TM1_a_x`, `TM2_a_x`) of `TM1_a_x-TM2_a_x`; None for the label of a single output."""
    parts = label.split("-")
    return (parts[0], parts[1]) if len(parts) == 2 and all(parts) else None


def no_output(label: str, labels: Sequence[str]) -> str:
    """That there is no output `label`, and which of `labels` may be meant."""
    plain = {known.lower(): known for known in labels}
    near = difflib.get_close_matches(label.lower(), plain, n=1)
    meant = f"; did you mean {plain[near[0]]}?" if near else ""
    return f"there is no output {label!r}{meant}; there are: {', '.join(labels)}"


def with_differences(
    rows: FloatArray, labels: Sequence[str], kinds: Sequence[str], requirements: Sequence[AppliedRequirement]
) -> tuple[FloatArray, list[str], list[str]]:
    """Outputs with the differences that the requirements judge: rows g_1 - g_2, so that common noise cancels.

    Parameters
    ----------
    rows : [n_out, k]; labels, kinds : [n_out].

    Returns
    -------
    rows, labels and kinds of all outputs, the differences last. A difference whose terms do not exist, or are of
    different quantities, is left out: the requirement then names an output that there is not.
    """
    place = {label: i for i, label in enumerate(labels)}
    found: dict[str, tuple[int, int]] = {}
    for label in dict.fromkeys(label for applied in requirements for label in applied.outputs):
        pair = terms(label)
        if label in place or pair is None or pair[0] not in place or pair[1] not in place:
            continue
        first, second = place[pair[0]], place[pair[1]]
        if kinds[first] == kinds[second]:
            found[label] = (first, second)
    extra = [rows[i] - rows[j] for i, j in found.values()]
    return np.array([*rows, *extra]), [*labels, *found], [*kinds, *(kinds[i] for i, _ in found.values())]
