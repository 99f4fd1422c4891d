"""Spectra of a network that was stepped in time, against those that its gains give."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tedm_cli.arrays import FloatArray, IndexArray
from tedm_cli.noise.realisation import Plan
from tedm_cli.noise.spectral_estimate import Estimate, Welch, Window, samples_wanted, segment_length, through_window
from tedm_cli.results.thermal.disturbed_network import DisturbedNetwork
from tedm_cli.thermal.spectra import node_factor
from tedm_cli.thermal.transfer import transfer

CONFIDENCE = 0.95
_TOLERANCE = 0.25  # of a PSD that is estimated: some 60 averages
_HELD = 1 << 24  # numbers of the segments that are held: 134 MB
_CLEAR = 1.1  # from the lowest frequency, below which disturbances are level
_APART = 8  # bins between values that are independent of each other
_FALSE_ALARM = 1e-3  # probability that right spectra are found wrong
_BIAS = 0.03  # relative, of a mean of PSDs, that is no disagreement: what folds, and the window
_FOLDED = 0.2  # of the rate: above, what is faster than the samples and folds changes a PSD by more than some percent
_ALIASES = np.arange(-6, 7)


@dataclass(frozen=True, eq=False)
class SpectraCheck:
    """How the spectra of stepped nodes stand to those of the gains.

    nodes : number of them. frequency_hz : [F]. inside : share of all values that hold their expectation in their
    interval of 95 %. mean : [nodes], of estimate over expectation at frequencies that are independent of each other;
    allowed : between which it is by chance alone, with all nodes together but for one time in a thousand. straight :
    relative change of a PSD that straight lines between the samples make, the largest of the nodes at the highest of
    the frequencies.
    """

    nodes: int
    frequency_hz: FloatArray
    inside: float
    mean: FloatArray
    allowed: tuple[float, float]
    straight: float

    @property
    def agrees(self) -> bool:
        """Whether the means are as they should be, or within 3 % of that."""
        low, high = self.allowed
        return bool(((self.mean >= low - _BIAS) & (self.mean <= high + _BIAS)).all())


def lowest_checked_hz(samples: int, rate_hz: float, frequency_hz: FloatArray) -> float | None:
    """Lowest frequency whose PSD a series of so many samples tells within 25 %; None where it tells none."""
    low, high = _CLEAR * float(frequency_hz[0]), float(frequency_hz[-1])
    wanted = low
    for _ in range(60):
        needed = samples_wanted(rate_hz, wanted, _TOLERANCE, CONFIDENCE)
        if needed <= samples:
            return wanted
        wanted *= max(1.02, needed / samples)
        if wanted > high / 2.0:
            return None
    return None


class CheckedNodes:
    """Estimates spectra of the nodes whose gains are known; of some of them, evenly chosen, where they are many."""

    def __init__(self, found: DisturbedNetwork, plan: Plan) -> None:
        segment = segment_length(plan.rate_hz, plan.lowest_hz)
        psd = found.psd
        heard = np.flatnonzero((psd > 0.0).all(axis=1))
        most = max(1, _HELD // segment)
        chosen = heard[np.unique(np.linspace(0, len(heard) - 1, min(most, len(heard))).astype(np.intp))]
        self._rows: IndexArray = found.kept[chosen]
        self._psd, self._plan, self._found, self._chosen = psd[chosen], plan, found, chosen
        self._welch = Welch(len(chosen), plan.rate_hz, segment)

    def add(self, temperature: FloatArray) -> None:
        """The next temperatures [n_free, T]."""
        self._welch.add(temperature[self._rows])

    def check(self) -> SpectraCheck:
        """The comparison, at those frequencies of the gains that the estimate tells apart."""
        estimate, plan, known = self._welch.estimate(), self._plan, self._found.frequency_hz
        usable = known[(known >= plan.lowest_hz * (1.0 - 1e-9)) & (known <= min(plan.high_hz, _FOLDED * plan.rate_hz))]
        bins = np.unique(np.abs(estimate.frequency_hz[:, None] - usable).argmin(axis=0))
        f, log_f = estimate.frequency_hz[bins], np.log(known)

        def psd(at: FloatArray) -> FloatArray:
            return np.asarray(np.exp([np.interp(np.log(at), log_f, np.log(row)) for row in self._psd]))

        expected = through_window(psd, f, Window(plan.rate_hz / self._welch.segment))
        ratio = estimate.psd[:, bins] / expected
        low, high = (factor[bins] for factor in estimate.interval(CONFIDENCE))
        inside = float(np.mean((ratio * low <= 1.0) & (ratio * high >= 1.0)))
        apart = [0]
        for place in range(1, len(bins)):
            if bins[place] - bins[apart[-1]] >= _APART:
                apart.append(place)
        of_mean = Estimate(f[:1], ratio[:, :1], estimate.degrees_of_freedom[:1] * len(apart))
        below, above = (float(factor[0]) for factor in of_mean.interval(1.0 - _FALSE_ALARM / len(ratio)))
        straight = self._straight(int(np.searchsorted(known, usable[-1])))
        return SpectraCheck(len(ratio), f, inside, ratio[:, apart].mean(axis=1), (1.0 / above, 1.0 / below), straight)

    def _straight(self, at: int) -> float:
        """Change of the PSDs at frequency number `at` by what is faster than the samples and folds onto it."""
        found, step = self._found, 1.0 / self._plan.rate_hz
        f = float(found.frequency_hz[at])
        folded = f + _ALIASES / step
        gains = transfer(found.linear, np.abs(folded), self._rows)
        gains = np.where(folded[:, None, None] < 0.0, np.conj(gains), gains)
        weight = (np.sinc(folded * step) / np.sinc(f * step)) ** 2
        sampled = np.tensordot(weight, gains, axes=(0, 0))[None]
        asd = found.asd[:, [at]]
        one, other = (
            np.abs(node_factor(h, asd, found.factor)[0]) ** 2 for h in (sampled, found.transfer[[at]][:, self._chosen])
        )
        return float(np.abs(one.sum(axis=1) / other.sum(axis=1) - 1.0).max())
