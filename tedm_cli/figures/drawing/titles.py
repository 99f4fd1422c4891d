"""Headings of figures of one judged output: in plain words, with labels in small type below."""

from __future__ import annotations

from collections.abc import Sequence

from tedm_cli.results.cases.noise import Limit, limit_named
from tedm_cli.results.titles import output_title
from tedm_cli.results.wording import capital, mhz_text, ratio_text


def judged_title(output: str, case: str) -> str:
    """`Read-out of x, test mass 2, sets A and B, case 3`."""
    return f"{capital(output_title(output))}, case {case}"


def limit_words(ratio: float, limits: Sequence[Limit], requirement: str, at_hz: float) -> str:
    """How far an output is from its limit and where, and what that is."""
    return f"{ratio_text(ratio)} times its limit at {mhz_text(at_hz)} ({limit_named(limits, requirement).plain})."


def labels_words(output: str, requirement: str) -> str:
    """What commands and files call an output and its requirement."""
    return f"Labels: {output}; {requirement}."
