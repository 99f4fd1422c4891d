"""Time series of outputs: what a trend leaves of them, and how their estimated spectra stand to requirements."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import scipy

from tedm_cli.arrays import FloatArray
from tedm_cli.noise.requirements import Requirement, Verdict, judge
from tedm_cli.noise.spectral_estimate import Estimate


class Trend:
    """Least squares of n regular series by a constant, or by a straight line over the number of the sample.

    Fed block by block; what is asked for is a mean or a line of all that was fed.
    """

    def __init__(self, n: int) -> None:
        self.count = 0
        self._sum: FloatArray = np.zeros(n)
        self._moment: FloatArray = np.zeros(n)

    def add(self, block: FloatArray) -> None:
        """Take the next samples [B, n]."""
        number = np.arange(self.count, self.count + len(block), dtype=np.float64)
        self._sum += block.sum(axis=0)
        self._moment += number @ block
        self.count += len(block)

    def line(self, remove: str) -> tuple[FloatArray, FloatArray]:
        """Value [n] at sample 0 and slope [n] per sample of the `mean` or the `linear` trend; zeros for others."""
        n, zero = self.count, np.zeros_like(self._sum)
        if remove not in ("mean", "linear"):
            return zero, zero
        mean = self._sum / n
        if remove == "mean" or n < 2:
            return mean, zero
        middle = (n - 1) / 2.0
        slope = (self._moment - middle * self._sum) * 12.0 / (n * (float(n) ** 2 - 1.0))
        return mean - middle * slope, slope


@dataclass(frozen=True)
class SeriesVerdict:
    """An output's estimated spectrum against one requirement, where the band and the estimate overlap.

    Parameters
    ----------
    worst : at the largest ratio; the scatter of the estimate is in it.
    band_rms, band_limit : roots of the integrals of noise and limit over `judged_hz`, unit of the output, both before
        the safety factor.
    judged_hz : the frequencies that are judged, of those of the requirement, `band_hz`.
    """

    worst: Verdict
    band_rms: float
    band_limit: float
    judged_hz: tuple[float, float]
    band_hz: tuple[float, float]

    @property
    def whole(self) -> bool:
        """Whether the whole band is judged."""
        return self.judged_hz == self.band_hz

    @property
    def left_out(self) -> list[str]:
        """The parts of the band that are not judged, in words."""
        (low, high), (first, last) = self.band_hz, self.judged_hz
        below = [f"{low:g} to {first:.4g} Hz, below the estimate"] if first > low else []
        above = [f"{last:.4g} to {high:g} Hz, above the estimate"] if last < high else []
        return [f"{self.worst.requirement} over {part}" for part in below + above]


def judge_estimate(
    estimate: Estimate, o: int, requirement: Requirement, safety_factor: float, *, kind: str, output: str
) -> SeriesVerdict | str:
    """Output number `o` of an estimate against a requirement, or why its frequencies do not allow that.

    What is judged is the overlap of band and estimate. At its edges, which need not be bins, the PSD is interpolated.
    Raises `ConfigError` for another quantity.
    """
    f, (low, high) = estimate.frequency_hz, requirement.band_hz
    if not len(f):
        return f"{requirement.name}, as there is no spectrum"
    first = low if f[0] <= low * (1.0 + 1e-9) else float(f[0])
    last = high if f[-1] >= high * (1.0 - 1e-9) else float(f[-1])
    if first >= last:
        reach = f"{f[0]:.4g} to {f[-1]:.4g} Hz"
        coarse = ": the samples are too far apart for the band" if f[-1] <= low else ""
        return f"{requirement.name} is over {low:g} to {high:g} Hz, the estimate over {reach}{coarse}"
    inside = f[(f > first * (1.0 + 1e-9)) & (f < last * (1.0 - 1e-9))]
    grid = np.concatenate([[first], inside, [last]])
    floor = np.finfo(np.float64).tiny  # for an output without noise
    psd = np.exp(np.interp(np.log(grid), np.log(f), np.log(np.maximum(estimate.psd[o], floor))))
    part = replace(requirement, band_hz=(first, last))
    verdict = judge(np.sqrt(psd), grid, part, safety_factor, kind=kind, output=output)
    rms, limit_rms = (
        float(np.sqrt(scipy.integrate.trapezoid(power, grid))) for power in (psd, requirement.amplitude(grid) ** 2)
    )
    return SeriesVerdict(verdict, rms, limit_rms, (first, last), (low, high))
