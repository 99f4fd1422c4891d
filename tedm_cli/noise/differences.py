"""Labels of outputs, and of those that are the difference of two others (of the two test masses, say)."""

from __future__ import annotations

import difflib
from collections.abc import Sequence


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
