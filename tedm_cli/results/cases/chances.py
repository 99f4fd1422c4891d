"""What a reader is told of the uncertainty of verdicts: probabilities, the spread of ratios, and what it is by."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from tedm_cli.results.cases.noise import CaseNoise, JudgedOutput
from tedm_cli.results.wording import chance_text, percent, ratio_text, sci
from tedm_cli.uncertainty.parameters import HALF_WIDTH, Parameter
from tedm_cli.uncertainty.verdicts import CaseUncertainty, Chance, Distribution

SPREAD = (5, 95)  # percentiles that are told as the ends of a spread


def distribution_of(case: CaseNoise, j: JudgedOutput) -> Distribution | None:
    """Of the ratio of a judged output of a case; None where nothing is uncertain."""
    return None if case.uncertainty is None else distribution_in(case.uncertainty, j)


def distribution_in(u: CaseUncertainty, j: JudgedOutput) -> Distribution:
    """Of the ratio of a judged output, the first of several that say the same."""
    first = j.output.split(", ")[0]
    return next(d for d in u.verdicts if (d.output, d.requirement) == (first, j.requirement))


def probability_text(chance: Chance) -> str:
    """A probability; where it happened in no draw or in all, what it is below or above."""
    return chance_text(chance.probability, chance.low, chance.high)


def probability_words(chance: Chance) -> str:
    """`probability 0.97`, `probability below 0.0004`."""
    text = probability_text(chance)
    return "probability " + text.replace("< ", "below ").replace("> ", "above ")


def spread_words(d: Distribution) -> str:
    """Between which ratios nine of ten draws are."""
    low, high = (ratio_text(d.percentile(p)) for p in SPREAD)
    return f"{low} to {high} in 90 % of the draws"


def largest_sources(u: CaseUncertainty, d: Distribution, least: float = 0.01) -> list[tuple[str, float, float]]:
    """Sources of a ratio's variance with their shares, alone and with interactions; the largest first.

    They are estimates by draws, and may be beyond 0 or 1 by their error: that is not told.
    """
    order = np.argsort(-d.share_total, kind="stable").tolist()
    first, total = (np.clip(share, 0.0, 1.0) for share in (d.share_first, d.share_total))
    shares = [(u.sources[i], float(first[i]), float(total[i])) for i in order]
    return [share for share in shares if share[2] >= least]


def shares_text(u: CaseUncertainty, d: Distribution, most: int = 3) -> str:
    """The largest sources of a ratio's variance: `level_inside 0.91 (0.93), glass 0.05 (0.06)`."""
    listed = [f"{name} {first:.2f} ({total:.2f})" for name, first, total in largest_sources(u, d)[:most]]
    return ", ".join(listed) or "nothing"


def uncertain_cases(cases: Sequence[CaseNoise]) -> list[tuple[CaseNoise, CaseUncertainty]]:
    """Cases whose verdicts have probabilities, with these."""
    return [(case, case.uncertainty) for case in cases if case.uncertainty is not None]


def deviation_text(p: Parameter) -> str:
    """`± 0.2 %`, `σ 3 %`, `± 2 × 10⁻⁸ 1/K`: half the width of a uniform distribution, or one standard deviation."""
    size = percent(p.deviation, 1 if p.deviation < 0.1 else 0) if p.unit == "1" else f"{sci(p.deviation, 2)} {p.unit}"
    return f"{'±' if p.measure == HALF_WIDTH else 'σ'} {size}"
