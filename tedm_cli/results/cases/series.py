"""Time series as their files tell them: the outputs that are worst, in few enough points to be drawn."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from tedm_cli.arrays import FloatArray, IntArray
from tedm_cli.contracts import SERIES
from tedm_cli.files.store import Reader
from tedm_cli.noise.requirements import AppliedRequirement, in_band
from tedm_cli.noise.spectral_estimate import Estimate
from tedm_cli.results.cases.noise import Limit, Spectrum, spectra_of
from tedm_cli.results.ranking import first_largest

_BLOCK = 1 << 20  # samples read at a time
_LIMIT_POINTS = 200
MOST_PIECES = 400  # pieces along an axis; a printed panel has no more dots to tell apart


@dataclass(frozen=True)
class JudgedSeriesOutput:
    """One output of a time series against one requirement; rms in `unit`.

    ratio : largest safety factor × noise / limit; binding_hz : where; passed : ratio <= 1.
    band_rms, band_limit : root mean square over what is judged, of the output and of noise at the limit.
    judged_hz : the frequencies that are judged; whole_band : whether the requirement has no others.
    """

    output: str
    unit: str
    requirement: str
    ratio: float
    binding_hz: float
    passed: bool
    band_rms: float
    band_limit: float
    judged_hz: tuple[float, float]
    whole_band: bool

    @property
    def band_text(self) -> str:
        """The frequencies that are judged, `1 to 30 mHz`, and whether that is all."""
        low, high = (f"{1e3 * f:.3g}" for f in self.judged_hz)
        return f"{low} to {high} mHz{'' if self.whole_band else ' only'}"


@dataclass(frozen=True)
class SeriesSummary:
    """Where a series comes from, what became of it, and its verdicts; `span_s` from its first sample to its last.

    `unjudged`: what is not judged of the requirements, and why.
    """

    source: str
    treatment: str
    safety_factor: float
    samples: int
    span_s: float
    verdicts: tuple[JudgedSeriesOutput, ...]
    unjudged: tuple[str, ...] = ()


@dataclass(frozen=True, eq=False)
class SeriesOutput:
    """One output of a time series.

    Parameters
    ----------
    output, kind, unit : names; rms : in `unit`.
    time_s, low, high : [b], smallest and largest value of the samples around each time.
    spectrum : estimate with its interval, without the safety factor.
    limit_hz, limits : those that judge it, and the frequencies they are given at.
    verdict : the worst; None where it is not judged.
    parts : by name, spectra of parts that make the output together; none of a series without the loop.
    """

    output: str
    kind: str
    unit: str
    rms: float
    time_s: FloatArray
    low: FloatArray
    high: FloatArray
    spectrum: Spectrum
    limit_hz: FloatArray
    limits: tuple[Limit, ...]
    verdict: JudgedSeriesOutput | None
    parts: Mapping[str, Spectrum] = field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class SeriesNoise:
    """What became of a temperature series: the output of each quantity that is worst."""

    source: str
    treatment: str
    safety_factor: float
    confidence: float
    outputs: tuple[SeriesOutput, ...]


def read_series_summary(file: Reader) -> SeriesSummary:
    """All of a series but its samples and spectra."""
    time = file.dataset(SERIES.TIME)
    n = time.shape[0]
    first, last = (float(time[i : i + 1][0]) for i in (0, n - 1))
    unit = dict(zip(file.strings(SERIES.OUTPUT_LABEL), file.strings(SERIES.OUTPUT_UNIT), strict=True))
    outputs, requirements = file.strings(SERIES.VERDICT_OUTPUT), file.strings(SERIES.VERDICT_REQUIREMENT)
    numbers = [
        file.array(SERIES.VERDICT_RATIO).tolist(),
        file.array(SERIES.VERDICT_BINDING_FREQUENCY).tolist(),
        file.array(SERIES.VERDICT_PASSED).astype(bool).tolist(),
        file.array(SERIES.VERDICT_BAND_RMS).tolist(),
        file.array(SERIES.VERDICT_BAND_LIMIT).tolist(),
        list(zip(*(file.array(p).tolist() for p in (SERIES.VERDICT_LOWEST, SERIES.VERDICT_HIGHEST)), strict=True)),
        file.array(SERIES.VERDICT_WHOLE_BAND).astype(bool).tolist(),
    ]
    return SeriesSummary(
        source=file.string(SERIES.TEMPERATURE_SOURCE),
        treatment=file.string(SERIES.TEMPERATURE_TREATMENT),
        safety_factor=file.number(SERIES.VERDICT_SAFETY_FACTOR),
        samples=n,
        span_s=last - first,
        verdicts=tuple(
            JudgedSeriesOutput(output, unit[output], requirement, *row)
            for output, requirement, *row in zip(outputs, requirements, *numbers, strict=True)
        ),
        unjudged=tuple(file.strings(SERIES.UNJUDGED)),
    )


def read_series(file: Reader, requirements: Sequence[AppliedRequirement], confidence: float) -> SeriesNoise:
    """The worst output of each judged quantity; where nothing is judged, the one with the largest rms of each."""
    labels, kinds, units = (file.strings(p) for p in (SERIES.OUTPUT_LABEL, SERIES.OUTPUT_KIND, SERIES.OUTPUT_UNIT))
    rms = file.array(SERIES.OUTPUT_RMS)
    summary = read_series_summary(file)
    shown: list[tuple[int, JudgedSeriesOutput | None]] = []
    judged = {kinds[labels.index(v.output)] for v in summary.verdicts}
    for kind in dict.fromkeys(kinds):
        if kind in judged:
            of_kind = [v for v in summary.verdicts if kinds[labels.index(v.output)] == kind]
            largest = first_largest(of_kind, [v.ratio for v in of_kind])
            shown.append((labels.index(largest.output), largest))
        elif not judged:
            of = [o for o, k in enumerate(kinds) if k == kind]
            shown.append((first_largest(of, [float(rms[o]) for o in of]), None))
    outputs = []
    for o, worst in shown:
        time, low, high = _extremes(file, labels[o])
        f, psd, nu = (file.array(p) for p in (SERIES.FREQUENCY, SERIES.PSD.of(labels[o]), SERIES.DEGREES_OF_FREEDOM))
        limit_hz, limits = _limits(labels[o], requirements)
        outputs.append(
            SeriesOutput(
                labels[o],
                kinds[o],
                units[o],
                float(rms[o]),
                time,
                low,
                high,
                spectra_of(Estimate(f, psd[None], nu), confidence)[0],
                limit_hz,
                limits,
                worst,
            )
        )
    return SeriesNoise(
        summary.source,
        summary.treatment,
        summary.safety_factor,
        confidence,
        tuple(outputs),
    )


def _extremes(file: Reader, output: str) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Times [p], smallest and largest values of an output in equal pieces of its series, read in blocks."""
    data, time = file.dataset(SERIES.SERIES.of(output)), file.dataset(SERIES.TIME)
    n = data.shape[0]
    start = piece_starts(n)
    low, high = np.empty(len(start)), np.empty(len(start))
    ends = np.append(start[1:], n)
    first = 0
    while first < len(start):
        last = max(first + 1, int(np.searchsorted(ends, start[first] + _BLOCK, side="right")))
        values = data[int(start[first]) : int(ends[last - 1])]
        cuts = start[first:last] - start[first]
        low[first:last], high[first:last] = np.minimum.reduceat(values, cuts), np.maximum.reduceat(values, cuts)
        first = last
    begin, end = (float(time[i : i + 1][0]) for i in (0, n - 1))
    middle = (start + ends - 1) / 2.0  # samples are equally far apart
    return begin + (end - begin) * middle / max(n - 1, 1), low, high


def _limits(output: str, requirements: Sequence[AppliedRequirement]) -> tuple[FloatArray, tuple[Limit, ...]]:
    """Limits that judge an output, on a grid of frequencies that holds their kinks."""
    applied = [r.requirement for r in requirements if output in r.outputs]
    if not applied:
        return np.empty(0), ()
    held = [f for q in applied for f in q.grid_hz]
    grid = np.unique(np.append(np.geomspace(min(held), max(held), _LIMIT_POINTS), held))
    limits = []
    for q in applied:
        amplitude = np.full(len(grid), np.nan)
        inside = in_band(q, grid)
        amplitude[inside] = q.amplitude(grid[inside])
        limits.append(Limit(q.name, q.source, q.unit, q.band_hz, amplitude, q.title))
    return grid, tuple(limits)


def piece_starts(samples: int, most: int = MOST_PIECES) -> IntArray:
    """First sample of each of at most `most` equal pieces of a series; pieces of one sample where there are few."""
    pieces = min(samples, most)
    return np.arange(pieces, dtype=np.int64) * samples // pieces


@dataclass(frozen=True, eq=False)
class ThinSpectrum:
    """A spectrum in pieces of its frequencies [p]: ends of the estimate, and of its interval."""

    frequency_hz: FloatArray
    least: FloatArray
    most: FloatArray
    low: FloatArray
    high: FloatArray

    def trace(self) -> tuple[FloatArray, FloatArray]:
        """A line [2 p] through both ends of every piece, which looks like the whole curve."""
        return np.repeat(self.frequency_hz, 2), np.stack([self.least, self.most], axis=1).reshape(-1)


def thinned(s: Spectrum) -> ThinSpectrum:
    """At most `MOST_PIECES` pieces, equal on a logarithmic axis of frequency."""
    f = s.frequency_hz
    start = np.arange(len(f))
    if len(f) > MOST_PIECES:
        edges = np.geomspace(f[0], f[-1], MOST_PIECES + 1)[:-1]
        start = np.unique(np.searchsorted(f, edges * (1 + 1e-12)))
        start[0] = 0
    width = np.diff(np.append(start, len(f)))
    middle = np.exp(np.add.reduceat(np.log(f), start) / width)
    return ThinSpectrum(
        middle,
        np.minimum.reduceat(s.asd, start),
        np.maximum.reduceat(s.asd, start),
        np.minimum.reduceat(s.low, start),
        np.maximum.reduceat(s.high, start),
    )
