"""Labels of outputs, and of those that are the difference of two others (of the two test masses, say)."""

from __future__ import annotations

import difflib
from collections.abc import Mapping, Sequence

import numpy as np

from tedm_cli.arrays import FloatArray


def terms(label: str) -> tuple[str, str] | None:
    """(`TM1_a_x`, `TM2_a_x`) of `TM1_a_x-TM2_a_x`; None for the label of a single output."""
    parts = label.split("-")
    return (parts[0], parts[1]) if len(parts) == 2 and all(parts) else None


def rows_of(labels: Sequence[str], known: Mapping[str, FloatArray]) -> FloatArray:
    """Rows [n, k] of outputs and of differences, g_1 - g_2, by the rows [k] of the outputs that are `known`.

    `KeyError` names an output that is not.
    """
    rows = []
    for label in labels:
        pair = None if label in known else terms(label)
        rows.append(known[label] if pair is None else known[pair[0]] - known[pair[1]])
    return np.array(rows)


def no_output(label: str, labels: Sequence[str]) -> str:
    """That there is no output `label`, and which of `labels` may be meant."""
    plain = {known.lower(): known for known in labels}
    near = difflib.get_close_matches(label.lower(), plain, n=1)
    meant = f"; did you mean {plain[near[0]]}?" if near else ""
    return f"there is no output {label!r}{meant}; there are: {', '.join(labels)}"
