"""Which verdicts decide, by the roles of the cases; each is listed once."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Protocol, TypeVar

import numpy as np

from tedm_cli.results.cases.noise import CaseNoise, JudgedOutput, Limit
from tedm_cli.results.ranking import ALIKE, first_largest

Pair = tuple[CaseNoise, JudgedOutput]

LIKELY, POSSIBLE, DIAGNOSTIC = "likely", "possible", "diagnostic"


class InRole(Protocol):
    """A case, by itself or in closed loop."""

    @property
    def role(self) -> str: ...


class Judged(Protocol):
    """An output against a requirement."""

    @property
    def ratio(self) -> float: ...

    @property
    def passed(self) -> bool: ...


C = TypeVar("C", bound=InRole)
J = TypeVar("J", bound=Judged)


def by_requirement(cases: Sequence[CaseNoise]) -> list[tuple[Limit, list[Pair]]]:
    """Every requirement that judges something, with all that it judges."""
    found = []
    for limit in cases[0].limits:
        pairs = [(c, j) for c in cases for j in c.judged if j.requirement == limit.name]
        if pairs:
            found.append((limit, pairs))
    return found


def worst_of(pairs: Sequence[tuple[C, J]]) -> tuple[C, J]:
    """The case and output with the largest ratio."""
    return first_largest(pairs, [j.ratio for _, j in pairs])


def possible_of(pairs: Sequence[tuple[C, J]]) -> list[tuple[C, J]]:
    """Those of cases that can occur; all where there are diagnostic ones only."""
    return [p for p in pairs if p[0].role != DIAGNOSTIC] or list(pairs)


def deciding(pairs: Sequence[tuple[C, J]]) -> tuple[C, J]:
    """What a verdict hangs on: the worst of the likely cases if they violate it, or else of all that are possible.

    Diagnostic cases decide only where there are no others.
    """
    likely = [p for p in pairs if p[0].role == LIKELY]
    if any(not j.passed for _, j in likely):
        return worst_of(likely)
    return worst_of(possible_of(pairs))


def worth_showing(cases: Sequence[CaseNoise], kind: str) -> list[Pair]:
    """What decides the verdicts on one quantity, and the worst that can occur where that is another case."""
    merged = without_repeats(cases)
    pairs = [(c, j) for c in merged for j in c.of_kind(kind)]
    first = deciding(pairs)
    worst = worst_of(possible_of(pairs))
    return [first] if worst[0] is first[0] else [first, worst]


def deciding_pairs(cases: Sequence[CaseNoise]) -> list[Pair]:
    """For each output and requirement the case that decides; outputs that say the same are told once."""
    found: list[Pair] = []
    for _, pairs in by_requirement(without_repeats(cases)):
        outputs = dict.fromkeys(j.output for _, j in pairs)
        found += [deciding([p for p in pairs if p[1].output == output]) for output in outputs]
    return found


def without_repeats(cases: Sequence[CaseNoise]) -> list[CaseNoise]:
    """The cases with outputs that say the same, as redundant read-outs do, as one that bears all their names.

    Outputs say the same where ratio and contributions are equal up to rounding in every case.
    """
    families: dict[tuple[int, ...], list[int]] = {}
    for place in range(len(cases[0].judged)):
        families.setdefault(tuple(_family(case.judged, place) for case in cases), []).append(place)
    merged = []
    for case in cases:
        names = [(family[0], ", ".join(case.judged[i].output for i in family)) for family in families.values()]
        merged.append(replace(case, judged=tuple(replace(case.judged[first], output=name) for first, name in names)))
    return merged


def _family(judged: Sequence[JudgedOutput], place: int) -> int:
    """Place of the first output that says the same as the one at `place`."""
    j = judged[place]
    scale = float(np.abs(j.contribution).max())
    for first, k in enumerate(judged[:place]):
        same = (k.requirement, k.unit) == (j.requirement, j.unit) and abs(k.ratio - j.ratio) <= ALIKE * j.ratio
        if same and np.allclose(j.contribution, k.contribution, rtol=0.0, atol=ALIKE * scale):
            return first
    return place
