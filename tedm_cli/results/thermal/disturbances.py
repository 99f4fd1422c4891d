"""How stable each disturbance of the thermal network has to be: the output that asks for most."""

from __future__ import annotations

import math
from dataclasses import dataclass

from tedm_cli.results.cases.deciding import without_repeats
from tedm_cli.results.cases.noise import CaseNoise


@dataclass(frozen=True)
class Strictest:
    """A disturbance, the smallest factor on its level that an output asks for, and the output and its requirement.

    factor : the others unchanged; infinite where no output feels it, NaN where it cannot meet that requirement alone.
    """

    name: str
    factor: float
    output: str
    requirement: str


def strictest_of(case: CaseNoise) -> list[Strictest]:
    """Of a case of the thermal network every disturbance, those that must be most stable first."""
    judged = [(j, j.disturbances) for j in without_repeats([case])[0].judged if j.disturbances is not None]
    found = []
    for d, name in enumerate(judged[0][1].names if judged else ()):
        factors = [float(of.level_factor[d]) for _, of in judged]
        at = min(range(len(factors)), key=lambda v: _rank(factors[v]))
        found.append(Strictest(name, factors[at], judged[at][0].output, judged[at][0].requirement))
    return sorted(found, key=lambda s: _rank(s.factor))


def all_together(case: CaseNoise) -> Strictest:
    """The same of all disturbances at once, by one factor."""
    worst = max(without_repeats([case])[0].judged, key=lambda j: j.ratio)
    factor = 1.0 / worst.ratio if worst.ratio > 0.0 else math.inf
    return Strictest("all together", factor, worst.output, worst.requirement)


def _rank(factor: float) -> float:
    """What no factor meets comes first."""
    return -math.inf if math.isnan(factor) else factor
