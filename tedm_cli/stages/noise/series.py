"""run-series: a temperature time series to the time series and spectra of all outputs.

The table is read once, in blocks. Sensitivities are applied to each block, then the outputs are resampled where that is
asked for (both are linear, so their order does not matter), and kept in a temporary file beside the result until the
trend is known. Memory does not grow with the length of the series.
"""

from __future__ import annotations

import difflib
import tempfile
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase
from pathlib import Path
from typing import IO

import numpy as np

from tedm_cli.arrays import FloatArray
from tedm_cli.config.cases import CasesConfig, load_cases
from tedm_cli.config.project import Project
from tedm_cli.config.series import SeriesTable
from tedm_cli.contracts import SERIES
from tedm_cli.errors import ConfigError, InputError, TedmError, UsageError
from tedm_cli.files.build_folder import OPTICS_FILE, SENSITIVITY_FILE, provenance, series_file_name
from tedm_cli.files.store import Writer, create
from tedm_cli.noise.areas import AreaTable
from tedm_cli.noise.case_run import judged_outputs
from tedm_cli.noise.columns import columns_of_areas
from tedm_cli.noise.resample import LinearResampler, PolyphaseResampler, pieces
from tedm_cli.noise.series import SeriesVerdict, Trend, judge_estimate, rows_by_column
from tedm_cli.noise.spectral_estimate import Estimate, Welch, segment_length
from tedm_cli.noise.stamps import Stamps
from tedm_cli.progress import Step
from tedm_cli.quantities import TEMPERATURE, TIME_STAMP
from tedm_cli.results.areas import write_areas
from tedm_cli.results.outputs import ModelOutputs, read_outputs
from tedm_cli.stages.noise.log_spectrum import log_estimate, require_speckit
from tedm_cli.tables.wide_table import WideTable, open_wide

_BLOCK_SAMPLES = 1 << 16  # of all outputs when they are read back; a multiple of the chunks of the file


@dataclass(frozen=True, eq=False)
class SeriesResult:
    """What became of a temperature series.

    Parameters
    ----------
    labels, units, rms, peak : of the outputs.
    first_s, step_s, samples : stamps of their series.
    verdicts : of what could be judged; unjudged : why the rest could not.
    treatment : trend and resampling, in words.
    """

    path: Path
    name: str
    source: Path
    labels: list[str]
    units: list[str]
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
class _Sampled:
    """The outputs' series in a temporary file: `samples` rows of n_out numbers, before the trend is removed."""

    file: IO[bytes]
    n_out: int
    samples: int
    first_s: float
    step_s: float
    highest_hz: float
    trend: Trend
    column: list[str]

    def blocks(self, remove: str) -> Iterator[tuple[int, FloatArray]]:
        """(first sample, values [B, n_out]) without the trend."""
        start, slope = self.trend.line(remove)
        self.file.seek(0)
        for first in range(0, self.samples, _BLOCK_SAMPLES):
            count = min(_BLOCK_SAMPLES, self.samples - first)
            raw = np.frombuffer(self.file.read(8 * count * self.n_out)).reshape(count, self.n_out)
            yield first, raw - start - slope * np.arange(first, first + count)[:, None]


def select_series(project: Project, wanted: Sequence[str]) -> list[str]:
    """Names of configured series for what the user typed, `all` included; `UsageError` lists what exists."""
    _, config = load_cases(project.cases)
    names = [table.name for table in config.series]
    if list(wanted) == ["all"]:
        if not names:
            raise UsageError(
                "describes no time series", where=str(project.cases), hint="describe them in tables [[series]]"
            )
        wanted = names
    for name in wanted:
        if name not in names:
            near = difflib.get_close_matches(name, names, n=1)
            raise UsageError(
                f"there is no series {name!r}; there are: {', '.join(names) or 'none'}",
                where=str(project.cases),
                hint=f"did you mean {near[0]}?" if near else "describe it in a table [[series]]",
            )
    return list(dict.fromkeys(wanted))


def run_series(
    project: Project,
    names: Sequence[str],
    output: Path | None,
    step: Step,
    done: Callable[[SeriesResult], None] = lambda result: None,
) -> None:
    """Propagate the series of these names and write one file each; `done` is told of each.

    A series that is refused does not keep the others from being run: the first refusal is raised at the end.
    """
    file, config = load_cases(project.cases)
    sources = [project.build_dir / SENSITIVITY_FILE, project.build_dir / OPTICS_FILE]
    outputs = read_outputs(project).with_differences(config.applied_requirements())
    try:
        judged_outputs(config.criteria(), outputs, config.frequency_hz())
    except ConfigError as error:
        raise ConfigError(error.problems, where=str(project.cases)) from error
    refused: dict[str, TedmError] = {}
    for number, table in enumerate(t for t in config.series if t.name in names):
        path = output if output is not None else project.build_dir / series_file_name(table.name)
        source = project.cases.parent / table.file
        try:
            if table.spectrum == "log":
                require_speckit()
            trace = provenance([file], [*sources, source])
            path.parent.mkdir(parents=True, exist_ok=True)
            with tempfile.TemporaryFile(dir=path.parent) as scratch:
                sampled = _sample(source, table, outputs, f"{project.cases}: series {table.name}", scratch)
                with create(path, SERIES, trace) as writer:
                    result = _finish(writer, path, source, sampled, table, outputs, config)
        except TedmError as error:
            refused[table.name] = error
            continue
        done(result)
        step(number + 1, len(names), "running series")
    if refused:
        first, *others = refused.values()
        if others:
            first.hint = f"{first.hint}; refused too: series {', '.join(list(refused)[1:])}".removeprefix("; ")
        raise first


def _sample(source: Path, table: SeriesTable, outputs: ModelOutputs, where: str, scratch: IO[bytes]) -> _Sampled:
    """Read, check, propagate and resample the series of a table."""
    moving = ~_constant(table, outputs.areas, where)
    with open_wide(source, "time_s", TIME_STAMP, TEMPERATURE) as wide:
        index = columns_of_areas(wide.columns, outputs.areas, moving, where=str(source))
        rows = rows_by_column(outputs.rows, index, wide.columns)
        stamps = Stamps(wide.place, regular=table.method != "linear", max_gap_s=table.max_gap_s)
        trend = Trend(len(rows))
        resampler: LinearResampler | PolyphaseResampler | None = None
        for time, values in _propagated(wide, stamps, rows, table.remove):
            if table.resample_s is not None and resampler is None:
                resampler = _resampler(table, stamps, len(time), str(source))
            for some, part in pieces(time, values, stamps.first_s, table.resample_s, where):
                made = part if resampler is None else resampler.push(some, part)
                trend.add(made)
                scratch.write(np.ascontiguousarray(made).tobytes())
    if trend.count < 2:
        raise InputError(f"{stamps.count} rows make {trend.count} samples; that is no series", where=str(source))
    step = table.resample_s if table.resample_s is not None else stamps.mean_step_s
    late = resampler.first * step if isinstance(resampler, PolyphaseResampler) else 0.0
    highest = 0.5 / step
    if isinstance(resampler, PolyphaseResampler):
        highest = min(highest, 0.5 / stamps.step_s) * resampler.passes
    column = [wide.columns[i] if i >= 0 else "" for i in index]
    return _Sampled(scratch, len(rows), trend.count, stamps.first_s + late, step, highest, trend, column)


def _propagated(
    wide: WideTable, stamps: Stamps, rows: FloatArray, remove: str
) -> Iterator[tuple[FloatArray, FloatArray]]:
    """(stamps [B], outputs [B, n_out]) of every block.

    Where a mean is removed later the first row is taken off at once: absolute temperatures would cost digits.
    """
    start: FloatArray | None = None
    for block in wide.blocks():
        stamps.add(block.key, block.places)
        if start is None:
            start = np.zeros(block.values.shape[1]) if remove == "nothing" else block.values[0]
        yield block.key, (block.values - start) @ rows.T


def _constant(table: SeriesTable, areas: AreaTable, where: str) -> np.ndarray[tuple[int], np.dtype[np.bool_]]:
    """Mask [k] of the areas that are said to keep their temperature."""
    patterns = table.constant or []
    names = areas.name.tolist()
    idle = [p for p in patterns if not any(fnmatchcase(name, p) for name in names)]
    if idle:
        raise ConfigError([("constant", f"no thermal area has {p!r}") for p in idle], where=where)
    return np.array([any(fnmatchcase(name, p) for p in patterns) for name in names])


def _resampler(table: SeriesTable, stamps: Stamps, rows: int, where: str) -> LinearResampler | PolyphaseResampler:
    wanted = table.resample_s
    assert wanted is not None
    if rows < 2:
        raise InputError("one row is no series", where=where)
    if table.method == "polyphase":
        return PolyphaseResampler(stamps.mean_step_s, wanted)
    if wanted > stamps.step_s * 1.001:
        raise InputError(
            f"resample_s = {wanted:g} s is coarser than the steps of {stamps.step_s:.6g} s: straight lines would fold"
            " what is faster into the band",
            where=where,
            hint='take method = "polyphase", which filters, or resample_s at most the step',
        )
    return LinearResampler(wanted)


def _finish(
    writer: Writer,
    path: Path,
    source: Path,
    sampled: _Sampled,
    table: SeriesTable,
    outputs: ModelOutputs,
    config: CasesConfig,
) -> SeriesResult:
    """Remove the trend, write the series, estimate and judge."""
    n, rate = sampled.samples, 1.0 / sampled.step_s
    units = list(outputs.units)
    lowest = table.lowest_hz if table.lowest_hz is not None else config.lowest_band_hz()
    segment = segment_length(rate, lowest)
    if table.spectrum == "welch" and n < segment:
        raise InputError(
            f"{n:,} samples of {sampled.step_s:.6g} s ({n / rate:.6g} s) are too few for a spectrum from {lowest:g} Hz,"
            f" which takes {segment:,}",
            where=str(source),
            hint=f"take a longer series, or lowest_hz = {lowest * segment / n * 1.01:.2g} or more",
        )
    welch = Welch(sampled.n_out, rate, segment) if table.spectrum == "welch" else None
    time = writer.allocate(SERIES.TIME, (n,))
    series = [
        writer.allocate(SERIES.SERIES.of(label), (n,), units=unit)
        for label, unit in zip(outputs.labels, units, strict=True)
    ]
    square, peak = np.zeros(sampled.n_out), np.zeros(sampled.n_out)
    for first, block in sampled.blocks(table.remove):
        part = slice(first, first + len(block))
        time[part] = sampled.first_s + sampled.step_s * np.arange(part.start, part.stop)
        for o, target in enumerate(series):
            target[part] = block[:, o]
        square += np.sum(block**2, axis=0)
        peak = np.maximum(peak, np.abs(block).max(axis=0))
        if welch is not None:
            welch.add(block.T)
    estimate = welch.estimate() if welch is not None else _log(sampled, table.remove)
    inside = estimate.frequency_hz <= sampled.highest_hz
    estimate = Estimate(estimate.frequency_hz[inside], estimate.psd[:, inside], estimate.degrees_of_freedom[inside])
    verdicts, unjudged = _judge(estimate, outputs, config)
    result = SeriesResult(
        path, table.name, source, list(outputs.labels), units, np.sqrt(square / n), peak, sampled.first_s,
        sampled.step_s, n, estimate, verdicts, unjudged, config.safety_factor, table.confidence, _treatment(table),
    )  # fmt: skip
    _write(writer, result, outputs, sampled.column)
    return result


def _log(sampled: _Sampled, remove: str) -> Estimate:
    """Log-spaced spectra, for which one output at a time is held."""
    found = []
    for o in range(sampled.n_out):
        series = np.concatenate([block[:, o] for _, block in sampled.blocks(remove)])
        found.append(log_estimate(series, 1.0 / sampled.step_s)[0])
    return Estimate(found[0].frequency_hz, np.concatenate([e.psd for e in found]), found[0].degrees_of_freedom)


def _judge(estimate: Estimate, outputs: ModelOutputs, config: CasesConfig) -> tuple[list[SeriesVerdict], list[str]]:
    verdicts: list[SeriesVerdict] = []
    unjudged: list[str] = []
    for applied in config.applied_requirements():
        for label in applied.outputs:
            o = outputs.labels.index(label)
            found = judge_estimate(
                estimate, o, applied.requirement, config.safety_factor, kind=outputs.kinds[o], output=label
            )
            if isinstance(found, str):
                unjudged.append(found)
            else:
                verdicts.append(found)
    return verdicts, unjudged


def _treatment(table: SeriesTable) -> str:
    removed = {"nothing": "nothing removed", "mean": "mean removed", "linear": "mean and linear trend removed"}
    if table.resample_s is None:
        return f"{removed[table.remove]}, as sampled"
    how = {
        "linear": "by straight lines, without anti-alias filter",
        "polyphase": "by a polyphase low-pass (118 dB, flat to 0.66 of the lower Nyquist frequency)",
    }
    return f"{removed[table.remove]}, resampled to {table.resample_s:g} s {how[str(table.method)]}"


def _write(writer: Writer, r: SeriesResult, outputs: ModelOutputs, column: list[str]) -> None:
    write_areas(writer, outputs.areas, outputs.area_id)
    writer.write(SERIES.TEMPERATURE_COLUMN, column)
    writer.write(SERIES.TEMPERATURE_SOURCE, f"{r.name}: {r.source.name}")
    writer.write(SERIES.TEMPERATURE_TREATMENT, r.treatment)
    writer.write(SERIES.OUTPUT_LABEL, r.labels)
    writer.write(SERIES.OUTPUT_UNIT, r.units)
    writer.write(SERIES.OUTPUT_KIND, outputs.kinds)
    writer.write(SERIES.OUTPUT_RMS, r.rms, units="see /output/unit")
    writer.write(SERIES.OUTPUT_PEAK, r.peak, units="see /output/unit")
    writer.write(SERIES.FREQUENCY, r.estimate.frequency_hz)
    writer.write(SERIES.DEGREES_OF_FREEDOM, r.estimate.degrees_of_freedom)
    for o, (label, unit) in enumerate(zip(r.labels, r.units, strict=True)):
        writer.write(SERIES.PSD.of(label), r.estimate.psd[o], units=f"({unit})^2/Hz")
    worst = [v.worst for v in r.verdicts]
    writer.write(SERIES.VERDICT_SAFETY_FACTOR, r.safety_factor)
    writer.write(SERIES.VERDICT_REQUIREMENT, [v.requirement for v in worst])
    writer.write(SERIES.VERDICT_OUTPUT, [v.output for v in worst])
    writer.write(SERIES.VERDICT_RATIO, [v.ratio for v in worst])
    writer.write(SERIES.VERDICT_BINDING_FREQUENCY, [v.binding_hz for v in worst])
    writer.write(SERIES.VERDICT_PASSED, [int(v.passed) for v in worst])
    writer.write(SERIES.VERDICT_BAND_RMS, [v.band_rms for v in r.verdicts], units="unit of the output")
    writer.write(SERIES.VERDICT_BAND_LIMIT, [v.band_limit for v in r.verdicts], units="unit of the output")
