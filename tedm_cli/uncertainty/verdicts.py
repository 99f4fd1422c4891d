"""Distributions of verdicts: probabilities of a violation, quantiles, and which parameters the variance is by."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy

from tedm_cli.arrays import BoolArray, FloatArray
from tedm_cli.uncertainty.parameters import Parameters
from tedm_cli.uncertainty.response import Ratio
from tedm_cli.uncertainty.sampling import latin_hypercube, two_sets

CONFIDENCE = 0.95
PROBABILITIES = np.arange(1, 100) / 100.0
SHARE_POWER = 12  # 4,096 draws behind the shares
_SHARE_SEED = 1  # is added to the seed: the shares are of other draws


@dataclass(frozen=True)
class Draws:
    """How many draws there are, and from which seed; `share_power`: the shares have 2^share_power of them."""

    samples: int = 10_000
    seed: int = 1
    share_power: int = SHARE_POWER


@dataclass(frozen=True)
class Chance:
    """A probability by draws: its standard error, and the ends of an interval of 95 % confidence (Wilson).

    Both are those of as many independent draws; a Latin hypercube is at least as good.
    """

    probability: float
    error: float
    low: float
    high: float

    @classmethod
    def of(cls, happened: BoolArray) -> Chance:
        """Of what happened, or did not, in each draw [n]."""
        n, k = len(happened), int(happened.sum())
        p = k / n
        interval = scipy.stats.binomtest(k, n).proportion_ci(CONFIDENCE, method="wilson")
        return cls(p, float(np.sqrt(p * (1.0 - p) / n)), float(interval.low), float(interval.high))


@dataclass(frozen=True, eq=False)
class Distribution:
    """The distribution of one verdict's ratio, with the safety factor.

    Parameters
    ----------
    output, requirement : names.
    nominal : the ratio of the verdict itself, without deviations.
    violated, violated_bare : that the ratio is above 1, with the safety factor and with 1 in its place.
    mean, deviation : mean and standard deviation of the ratio.
    quantile : [q], at `PROBABILITIES`.
    share_first, share_total : [s], parts of the ratio's variance by each independent source alone, and with all its
        interactions; they sum to at most 1 and to at least 1. 0 where nothing varies. Estimates, by draws of their own.
    """

    output: str
    requirement: str
    nominal: float
    violated: Chance
    violated_bare: Chance
    mean: float
    deviation: float
    quantile: FloatArray
    share_first: FloatArray
    share_total: FloatArray

    def percentile(self, percent: int) -> float:
        """A percentile, from 1 to 99, of the ratio."""
        return float(self.quantile[percent - 1])


@dataclass(frozen=True)
class JudgedChance:
    """That any requirement on an output is violated, with the safety factor and with 1."""

    output: str
    violated: Chance
    violated_bare: Chance


@dataclass(frozen=True, eq=False)
class MeshComparison:
    """A second mesh: its build folder, size of its elements over that of this mesh's, and order of the error.

    other_ratio, extrapolated_ratio : [verdicts], by the other mesh, and at elements without size.
    """

    other: str
    refinement: float
    order: float
    other_ratio: FloatArray
    extrapolated_ratio: FloatArray


@dataclass(frozen=True, eq=False)
class CaseUncertainty:
    """How sure the verdicts of a case are.

    Parameters
    ----------
    parameters : what is uncertain.
    left_out : what is configured and could not be propagated, and why.
    draws : how many.
    verdicts : in the order of the case's.
    outputs : each judged output once.
    any_violated, any_violated_bare : that any verdict is a violation, with the safety factor and with 1.
    mesh : the other mesh, where there is one.
    """

    parameters: Parameters
    left_out: tuple[str, ...]
    draws: Draws
    verdicts: tuple[Distribution, ...]
    outputs: tuple[JudgedChance, ...]
    any_violated: Chance
    any_violated_bare: Chance
    mesh: MeshComparison | None = None

    @property
    def sources(self) -> list[str]:
        """Names of the independent sources that the shares are of."""
        return self.parameters.sources


@dataclass(frozen=True, eq=False)
class Judged:
    """A verdict: its names, its nominal ratio, and the ratio as a function; both with the safety factor."""

    output: str
    requirement: str
    nominal: float
    ratio: Ratio


def uncertainty(
    parameters: Parameters,
    judged: Sequence[Judged],
    safety_factor: float,
    draws: Draws,
    left_out: Sequence[str] = (),
    mesh: MeshComparison | None = None,
) -> CaseUncertainty:
    """Draw the parameters, and find what they make of verdicts."""
    x = parameters.deviations(latin_hypercube(draws.samples, len(parameters), draws.seed))
    ratios = np.empty((len(judged), draws.samples))
    verdicts = []
    for ratio, one in zip(ratios, judged, strict=True):
        ratio[:], binding = one.ratio.worst(x)
        if not len(parameters):
            ratio[:] = one.nominal
        first, total = variance_shares(parameters, one.ratio.at(np.unique(binding)), draws)
        verdicts.append(
            Distribution(
                output=one.output,
                requirement=one.requirement,
                nominal=one.nominal,
                violated=Chance.of(ratio > 1.0),
                violated_bare=Chance.of(ratio > safety_factor),
                mean=float(ratio.mean()),
                deviation=float(ratio.std()),
                quantile=np.quantile(ratio, PROBABILITIES),
                share_first=first,
                share_total=total,
            )
        )
    worst = {
        label: np.max([r for r, one in zip(ratios, judged, strict=True) if one.output == label], axis=0)
        for label in dict.fromkeys(one.output for one in judged)
    }
    highest = ratios.max(axis=0, initial=0.0)
    return CaseUncertainty(
        parameters=parameters,
        left_out=tuple(left_out),
        draws=draws,
        verdicts=tuple(verdicts),
        outputs=tuple(
            JudgedChance(label, Chance.of(ratio > 1.0), Chance.of(ratio > safety_factor))
            for label, ratio in worst.items()
        ),
        any_violated=Chance.of(highest > 1.0),
        any_violated_bare=Chance.of(highest > safety_factor),
        mesh=mesh,
    )


def variance_shares(parameters: Parameters, ratio: Ratio, draws: Draws) -> tuple[FloatArray, FloatArray]:
    """First-order and total shares [s] of a ratio's variance by the s independent sources (Saltelli et al. 2010).

    Parameters that are correlated are drawn together, and are one source.
    """
    sources = len(parameters.sources)
    if not sources:
        return np.zeros(0), np.zeros(0)
    one, two = two_sets(draws.share_power, len(parameters), draws.seed + _SHARE_SEED)
    mixed = []
    for number in range(sources):
        changed = one.copy()
        mine = parameters.block == number
        changed[:, mine] = two[:, mine]
        mixed.append(ratio.of(parameters.deviations(changed)))
    values = [ratio.of(parameters.deviations(u)) for u in (one, two)]
    if not np.ptp(np.concatenate(values)) > 1e-12 * values[0].max(initial=0.0):
        return np.zeros(sources), np.zeros(sources)
    if sources == 1:  # SciPy's indices are of two or more
        return np.ones(1), np.ones(1)
    found = scipy.stats.sobol_indices(
        func={"f_A": values[0][None], "f_B": values[1][None], "f_AB": np.array(mixed)[:, None]}, n=len(one)
    )
    return np.asarray(found.first_order).reshape(-1), np.asarray(found.total_order).reshape(-1)
