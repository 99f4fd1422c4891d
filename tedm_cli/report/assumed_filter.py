"""Verdicts that another temperature filter would turn: order and corner of the low-pass are assumed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tedm_cli.arrays import FloatArray
from tedm_cli.report.document import Block, Heading, Paragraph, Ref, Strong
from tedm_cli.report.verdicts import Judgement
from tedm_cli.results.cases.deciding import LIKELY, Pair, possible_of
from tedm_cli.results.cases.noise import CaseNoise, JudgedOutput
from tedm_cli.results.titles import output_title
from tedm_cli.results.wording import and_text, clause, count, ratio_text, span

_TOLD = 3  # outputs that are named


@dataclass(frozen=True)
class TurnedByFilter:
    """A verdict that another filter turns: smallest and largest ratio over the filters, in the worst case of each."""

    found: Judgement[CaseNoise, JudgedOutput]
    low: float
    high: float

    @property
    def words(self) -> str:
        return f"the {clause(output_title(self.found.output))} is {span(self.low, self.high)} times its limit"


def turned_by_filter(noise: Sequence[Judgement[CaseNoise, JudgedOutput]]) -> list[TurnedByFilter]:
    """The verdicts whose state is another one with a filter that was tried, the largest possible ratio first.

    Every case has the filter at once, for they share one temperature model. Cases without a low-pass do not change.
    """
    turned = [t for found in noise if (t := _turned(found)) is not None]
    return sorted(turned, key=lambda t: -t.high)


def _turned(found: Judgement[CaseNoise, JudgedOutput]) -> TurnedByFilter | None:
    possible = possible_of(found.pairs)
    likely = [p for p in possible if p[0].role == LIKELY] or possible
    of_likely, of_possible = _worst(likely), _worst(possible)
    violated, met = of_likely > 1.0, of_possible <= 1.0
    same = {"violated": violated, "met": met, "open": ~violated & ~met}[found.state]
    if same.all():
        return None
    decisive = of_likely if found.state == "violated" else of_possible
    return TurnedByFilter(found, float(decisive.min()), float(decisive.max()))


def _worst(pairs: Sequence[Pair]) -> FloatArray:
    """The largest ratio of the cases with each filter."""
    ratios = [np.asarray(j.ratio if j.filter_ratio is None else j.filter_ratio) for _, j in pairs]
    return np.asarray(np.max(np.broadcast_arrays(*ratios), axis=0))


def filter_remedy(turned: Sequence[TurnedByFilter]) -> list[Block]:
    """What to do about verdicts that hang on the filter."""
    if not turned:
        return []
    named = and_text([t.words for t in turned[:_TOLD]])
    more = f"; {count(len(turned) - _TOLD, 'more verdict')} would change" if len(turned) > _TOLD else ""
    return [
        Heading("Temperature filter"),
        Paragraph(
            (
                Strong("Measure the spectrum of the temperatures, or confirm the filter"),
                ": order and corner of the low-pass are assumed, and the verdict on"
                f" {count(len(turned), 'output')} changes with them. Over the filters that were tried, {named}{more}. A"
                ' measured spectrum takes the place of the filter (preset = "table" in [temperature]). Every filter is'
                " in ",
                Ref("sure"),
                ".",
            )
        ),
    ]


def beyond_words(turned: Sequence[TurnedByFilter]) -> str:
    """How far another filter brings what is met."""
    worst = turned[0]
    return f"the {clause(output_title(worst.found.output))} up to {ratio_text(worst.high)} times its limit"
