"""Time series of outputs: what a trend leaves of them, and how their estimated spectra stand to requirements."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.integrate import trapezoid

from tedm_cli.arrays import FloatArray, IndexArray
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
        """Value [n] at sample 0 and slope [n] per sample of the `mean` or the `linear` trend; zeros for `nothing`."""
        n, zero = self.count, np.zeros_like(self._sum)
        if remove == "nothing":
            return zero, zero
        mean = self._sum / n
        if remove == "mean" or n < 2:
            return mean, zero
        middle = (n - 1) / 2.0
        slope = (self._moment - middle * self._sum) * 12.0 / (n * (float(n) ** 2 - 1.0))
        return mean - middle * slope, slope


@dataclass(frozen=True)
class SeriesVerdict:
    """An output's estimated spectrum against one requirement.

    Parameters
    ----------
    worst : at the largest ratio; the scatter of the estimate is in it.
    band_rms, band_limit : roots of the integrals of noise and limit over the band, unit of the output, both before the
        safety factor.
    """

    worst: Verdict
    band_rms: float
    band_limit: float


def judge_estimate(
    estimate: Estimate, o: int, requirement: Requirement, safety_factor: float, *, kind: str, output: str
) -> SeriesVerdict | str:
    """Output number `o` of an estimate against a requirement, or why its frequencies do not allow that.

    At the edges of the band, which need not be bins, the PSD is interpolated. Raises `ConfigError` for another
    quantity.
    """
    f, (low, high) = estimate.frequency_hz, requirement.band_hz
    if not len(f) or f[0] > low * (1.0 + 1e-9) or f[-1] < high * (1.0 - 1e-9):
        reach = f"{f[0]:.4g} to {f[-1]:.4g} Hz" if len(f) else "no frequency"
        return f"{output}: {requirement.name} is over {low:g} to {high:g} Hz, the estimate over {reach}"
    inside = f[(f > low * (1.0 + 1e-9)) & (f < high * (1.0 - 1e-9))]
    grid = np.concatenate([[low], inside, [high]])
    floor = np.finfo(np.float64).tiny  # for an output without noise
    psd = np.exp(np.interp(np.log(grid), np.log(f), np.log(np.maximum(estimate.psd[o], floor))))
    verdict = judge(np.sqrt(psd), grid, requirement, safety_factor, kind=kind, output=output)
    limit = requirement.amplitude(grid)
    return SeriesVerdict(verdict, float(np.sqrt(trapezoid(psd, grid))), float(np.sqrt(trapezoid(limit**2, grid))))


def rows_by_column(rows: FloatArray, index: IndexArray, columns: Sequence[str]) -> FloatArray:
    """Sensitivities [n_out, columns] to the columns of a table, from those to the areas [n_out, k] that follow them.

    `index` [k] is the column of each area, -1 for areas that keep their temperature.
    """
    moved = index >= 0
    followers = np.zeros((len(index), len(columns)))
    followers[np.flatnonzero(moved), index[moved]] = 1.0
    out: FloatArray = rows @ followers
    return out
