"""What becomes of the series of outputs: written as they come, root mean square and peak, spectra, verdicts."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tedm_cli.arrays import FloatArray
from tedm_cli.config.series import SeriesTable
from tedm_cli.contracts import SeriesDatasets
from tedm_cli.errors import InputError
from tedm_cli.files.store import Writer
from tedm_cli.noise.log_spectrum import log_estimate
from tedm_cli.noise.requirements import AppliedRequirement
from tedm_cli.noise.series import SeriesVerdict, judge_estimate
from tedm_cli.noise.spectral_estimate import Estimate, Welch, longest_segment, segment_length

_LEAST_LOG = 64  # samples of a log-spaced spectrum
Blocks = Callable[[], Iterator[tuple[int, FloatArray]]]


@dataclass(frozen=True, eq=False)
class SeriesResult:
    """What became of a temperature series.

    Parameters
    ----------
    labels, units, kinds, rms, peak : of the outputs.
    first_s, step_s, samples : stamps of their series.
    verdicts : of what could be judged, in whole or in part; unjudged : what could not, and why.
    treatment : trend and resampling, in words.
    """

    path: Path
    name: str
    source: Path
    labels: list[str]
    units: list[str]
    kinds: list[str]
    rms: FloatArray
    peak: FloatArray
    first_s: float
    step_s: float
    samples: int
    estimate: Estimate
    verdicts: list[SeriesVerdict]
    unjudged: list[str]
    safety_factor: float
    confidence: float
    treatment: str


@dataclass(frozen=True)
class Regular:
    """n series as they are to be told: their blocks (number of the first sample, values [B, n]), stamps, and where
    spectra end."""

    blocks: Blocks
    n: int
    samples: int
    first_s: float
    step_s: float
    highest_hz: float


def welch_segment(
    samples: int, step_s: float, highest_hz: float, table: SeriesTable, lowest_hz: float, source: Path
) -> int:
    """Samples of a segment of Welch's spectrum: from the table's own lowest frequency, or from `lowest_hz`.

    A series that is too short for `lowest_hz`, or whose spectrum ends (at `highest_hz`) below it, has a spectrum from
    where it can; 0 where it cannot have any. What the table wants is wanted: a series that cannot give that is refused,
    and the message says what would do.
    """
    wanted = table.lowest_hz if table.lowest_hz is not None else lowest_hz
    segment, highest_hz = segment_length(1.0 / step_s, wanted), min(highest_hz, 0.5 / step_s)
    if wanted >= highest_hz and table.lowest_hz is not None:
        raise InputError(
            f"samples of {step_s:.6g} s have a spectrum up to {highest_hz:.3g} Hz, below lowest_hz = {wanted:g}",
            where=str(source),
            hint="take a series of shorter steps, or a lower lowest_hz, or none",
        )
    if samples >= segment and wanted < highest_hz:
        return segment
    if table.lowest_hz is None:
        return longest_segment(samples)
    raise InputError(
        f"{samples:,} samples of {step_s:.6g} s ({samples * step_s:.6g} s) are too few for a spectrum from"
        f" {wanted:g} Hz, which takes {segment:,}",
        where=str(source),
        hint=f"take a longer series, or lowest_hz = {wanted * segment / samples * 1.01:.2g} or more, or none",
    )


def store(
    writer: Writer, series: Regular, targets: Sequence[tuple[str, str]], spectrum: str, segment: int
) -> tuple[FloatArray, FloatArray, Estimate]:
    """Write series to the datasets `targets` [n] (path, unit) with their stamps; rms [n], peak [n] and spectra.

    `segment`: samples of a segment of Welch's spectra; 0 where there are none.
    """
    n, rate = series.samples, 1.0 / series.step_s
    welch = Welch(series.n, rate, segment) if spectrum == "welch" and segment else None
    time = writer.allocate(SeriesDatasets.TIME, (n,))
    kept = [writer.allocate(path, (n,), units=unit) for path, unit in targets]
    square, peak = np.zeros(series.n), np.zeros(series.n)
    for first, block in series.blocks():
        part = slice(first, first + len(block))
        time[part] = series.first_s + series.step_s * np.arange(part.start, part.stop)
        for o, target in enumerate(kept):
            target[part] = block[:, o]
        square += np.sum(block**2, axis=0)
        peak = np.maximum(peak, np.abs(block).max(axis=0))
        if welch is not None:
            welch.add(block.T)
    if welch is not None:
        estimate = welch.estimate()
    elif spectrum == "log" and n >= _LEAST_LOG:
        estimate = _log(series)
    else:
        estimate = Estimate(np.empty(0), np.empty((series.n, 0)), np.empty(0))
    inside = estimate.frequency_hz <= series.highest_hz
    estimate = Estimate(estimate.frequency_hz[inside], estimate.psd[:, inside], estimate.degrees_of_freedom[inside])
    return np.sqrt(square / n), peak, estimate


def _log(series: Regular) -> Estimate:
    """Log-spaced spectra, for which one output at a time is held."""
    found = []
    for o in range(series.n):
        one = np.concatenate([block[:, o] for _, block in series.blocks()])
        found.append(log_estimate(one, 1.0 / series.step_s)[0])
    return Estimate(found[0].frequency_hz, np.concatenate([e.psd for e in found]), found[0].degrees_of_freedom)


def judge_all(
    estimate: Estimate,
    labels: Sequence[str],
    kinds: Sequence[str],
    requirements: Sequence[AppliedRequirement],
    safety_factor: float,
) -> tuple[list[SeriesVerdict], list[str]]:
    """Verdicts on the outputs `labels` of an estimate, and what of the requirements cannot be judged, and why."""
    verdicts: list[SeriesVerdict] = []
    unjudged: dict[str, list[str]] = {}  # outputs by what is not judged of them
    for applied in requirements:
        for label in applied.outputs:
            o = labels.index(label)
            found = judge_estimate(estimate, o, applied.requirement, safety_factor, kind=kinds[o], output=label)
            if isinstance(found, str):
                unjudged.setdefault(found, []).append(label)
            else:
                verdicts.append(found)
                for fact in found.left_out:
                    unjudged.setdefault(fact, []).append(label)
    return verdicts, [f"{', '.join(outputs)}: {fact}" for fact, outputs in unjudged.items()]


def write_result(writer: Writer, r: SeriesResult, column: list[str]) -> None:
    """All of a result but its series; `column` [k] as in `temperature_series.Sampled`."""
    kind = SeriesDatasets
    writer.write(kind.TEMPERATURE_COLUMN, column)
    writer.write(kind.TEMPERATURE_SOURCE, f"{r.name}: {r.source.name}")
    writer.write(kind.TEMPERATURE_TREATMENT, r.treatment)
    writer.write(kind.OUTPUT_LABEL, r.labels)
    writer.write(kind.OUTPUT_UNIT, r.units)
    writer.write(kind.OUTPUT_KIND, r.kinds)
    writer.write(kind.OUTPUT_RMS, r.rms, units="see /output/unit")
    writer.write(kind.OUTPUT_PEAK, r.peak, units="see /output/unit")
    writer.write(kind.FREQUENCY, r.estimate.frequency_hz)
    writer.write(kind.DEGREES_OF_FREEDOM, r.estimate.degrees_of_freedom)
    for o, (label, unit) in enumerate(zip(r.labels, r.units, strict=True)):
        writer.write(kind.PSD.of(label), r.estimate.psd[o], units=f"({unit})^2/Hz")
    worst = [v.worst for v in r.verdicts]
    writer.write(kind.VERDICT_SAFETY_FACTOR, r.safety_factor)
    writer.write(kind.VERDICT_REQUIREMENT, [v.requirement for v in worst])
    writer.write(kind.VERDICT_OUTPUT, [v.output for v in worst])
    writer.write(kind.VERDICT_RATIO, [v.ratio for v in worst])
    writer.write(kind.VERDICT_BINDING_FREQUENCY, [v.binding_hz for v in worst])
    writer.write(kind.VERDICT_PASSED, [int(v.passed) for v in worst])
    writer.write(kind.VERDICT_BAND_RMS, [v.band_rms for v in r.verdicts], units="unit of the output")
    writer.write(kind.VERDICT_BAND_LIMIT, [v.band_limit for v in r.verdicts], units="unit of the output")
    writer.write(kind.VERDICT_LOWEST, [v.judged_hz[0] for v in r.verdicts])
    writer.write(kind.VERDICT_HIGHEST, [v.judged_hz[1] for v in r.verdicts])
    writer.write(kind.VERDICT_WHOLE_BAND, [int(v.whole) for v in r.verdicts])
    writer.write(kind.UNJUDGED, r.unjudged)
