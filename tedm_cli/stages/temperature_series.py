"""Temperature series of the cases file: chosen by name, read in blocks, checked, applied to rows and resampled.

Sensitivities are applied to each block, then the signals are resampled where that is asked for (both are linear, so
their order does not matter), and kept in a temporary file until the trend is known. Memory does not grow with the
length of the series. What propagates series and what drives the drag-free loop with them reads them here.
"""

from __future__ import annotations

import difflib
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from fnmatch import fnmatchcase
from pathlib import Path
from typing import IO

import numpy as np

from tedm_cli.arrays import BoolArray, FloatArray
from tedm_cli.config.cases import CasesConfig, load_cases
from tedm_cli.config.project import Project
from tedm_cli.config.series import SeriesTable
from tedm_cli.config.temperature.node_weights import read_node_weights
from tedm_cli.config.thermal.tmd import unit_of_tmd
from tedm_cli.documentation import Page
from tedm_cli.errors import ConfigError, InputError, TedmError, UsageError
from tedm_cli.noise.areas import AreaTable
from tedm_cli.noise.columns import part_words, parts_of_columns, parts_of_nodes
from tedm_cli.noise.resample import LinearResampler, PolyphaseResampler, pieces
from tedm_cli.noise.selection import listed
from tedm_cli.noise.series import Trend
from tedm_cli.noise.stamps import Stamps
from tedm_cli.progress import Step
from tedm_cli.quantities import CELSIUS, GRADIENT, TEMPERATURE, TIME_STAMP
from tedm_cli.results.wording import count
from tedm_cli.tables import wide_table
from tedm_cli.tables.tmd_table import TMD_SUFFIX, open_tmd
from tedm_cli.tables.wide_table import WideTable, open_wide

_BLOCK_SAMPLES = 1 << 16  # of all signals when they are read back; a multiple of the chunks of the files


@dataclass
class Scratch:
    """Samples of `width` numbers in a temporary file, written block after block and read back as often as needed."""

    file: IO[bytes]
    width: int
    samples: int = 0

    def add(self, block: FloatArray) -> None:
        """Take the next samples [B, width]."""
        self.file.write(np.ascontiguousarray(block, dtype=np.float64).tobytes())
        self.samples += len(block)

    def blocks(self) -> Iterator[tuple[int, FloatArray]]:
        """(number of the first sample, values [B, width])."""
        self.file.seek(0)
        for first in range(0, self.samples, _BLOCK_SAMPLES):
            count = min(_BLOCK_SAMPLES, self.samples - first)
            yield first, np.frombuffer(self.file.read(8 * count * self.width)).reshape(count, self.width)


@dataclass(frozen=True, eq=False)
class SeriesColumns:
    """The thermal areas [k] of which a series is, or the nodes that stand in their place.

    network : names of nodes that columns may have though they are not on the model; None where they are areas.
    """

    areas: AreaTable
    network: frozenset[str] | None = None


@dataclass(frozen=True, eq=False)
class ReadTable:
    """An open table of temperatures.

    parts : what part each of its columns has in each area or node [k, columns]. start : [columns], what is taken off
    at once. unit : K or degC of its temperatures. unused : columns that belong to no area or node.
    """

    parts: FloatArray
    start: FloatArray | None
    unit: str
    unused: tuple[str, ...]


@dataclass(frozen=True)
class Sampled:
    """Signals of a temperature series at regular stamps, before the trend is removed.

    `highest_hz` is where their spectra end; `column` says which column each area follows, or which with what weights;
    empty for none. `read` is what the table was.
    """

    kept: Scratch
    first_s: float
    step_s: float
    highest_hz: float
    trend: Trend
    column: list[str]
    read: ReadTable

    @property
    def samples(self) -> int:
        return self.kept.samples

    def blocks(self, remove: str) -> Iterator[tuple[int, FloatArray]]:
        """(number of the first sample, values [B, n]) without the trend."""
        start, slope = self.trend.line(remove)
        for first, raw in self.kept.blocks():
            yield first, raw - start - slope * np.arange(first, first + len(raw))[:, None]


def select_series(project: Project, wanted: Sequence[str]) -> list[str]:
    """Names of configured series for what the user typed; `UsageError` lists what exists.

    `all` of none is none, which is no fault: whoever runs it says so (`no_series`).
    """
    _, config = load_cases(project.cases)
    names = [table.name for table in config.series]
    if list(wanted) == ["all"]:
        return names
    for name in wanted:
        if name not in names:
            near = difflib.get_close_matches(name, names, n=1)
            raise UsageError(
                f"there is no series {name!r}; there are: {', '.join(names) or 'none'}",
                where=str(project.cases),
                hint=f"did you mean {near[0]}?" if near else "describe it in a table [[series]]",
            )
    return list(dict.fromkeys(wanted))


def no_series(project: Project) -> str:
    """That there is nothing to run, and how to add something."""
    return (
        f"{project.cases} describes no time series, so nothing was run; add one as a table [[series]] with name and"
        f" file ({Page.TEMPERATURES})"
    )


def run_each(
    config: CasesConfig, names: Sequence[str], run: Callable[[SeriesTable], None], step: Step, what: str
) -> None:
    """Run the series of these names; one that is refused keeps no other from being run, and is raised at the end."""
    refused: dict[str, TedmError] = {}
    for number, table in enumerate(t for t in config.series if t.name in names):
        try:
            run(table)
        except TedmError as error:
            refused[table.name] = error
            continue
        step(number + 1, len(names), what)
    if refused:
        first, *others = refused.values()
        if others:
            first.hint = f"{first.hint}; refused too: series {', '.join(list(refused)[1:])}".removeprefix("; ")
        raise first


def series_files(project: Project, table: SeriesTable) -> list[Path]:
    """The file of a series, and that of its weights where it has them."""
    names = [table.file, *([table.weights] if table.weights is not None else [])]
    return [project.cases.parent / name for name in names]


@contextmanager
def open_series(
    project: Project, table: SeriesTable, columns: SeriesColumns, where: str
) -> Iterator[tuple[WideTable, ReadTable]]:
    """The open table of a series, and what its columns are.

    Raises
    ------
    InputError : a file that is refused, or columns or weights that do not fit the areas or nodes.
    ConfigError : `constant` or `unused` names nothing; temperatures of a TMD file that are said to be deviations.
    """
    areas = columns.areas
    moving = ~_constant(table, areas, where, "thermal area" if columns.network is None else "thermal node")
    source, *weights = series_files(project, table)
    nodes = read_node_weights(weights[0]) if weights else None
    gradients = dict.fromkeys(areas.name[areas.gradient].tolist(), GRADIENT)
    with ExitStack() as stack:
        is_tmd = source.suffix.lower() == TMD_SUFFIX
        if is_tmd:
            if table.remove == "nothing":
                fact = 'the temperatures of a TMD file are no deviations: take "mean", "linear" or "reference"'
                raise ConfigError([("remove", fact)], where=where)
            wide, unit = stack.enter_context(
                open_tmd(source, lambda offset: unit_of_tmd(offset, table.unit, str(source), "[[series]]"))
            )
        else:
            unit = table.unit or "K"
            of_means = CELSIUS if unit == "degC" else TEMPERATURE
            wide = stack.enter_context(open_wide(source, "time_s", TIME_STAMP, of_means, gradients))
        if columns.network is None:
            parts = parts_of_columns(wide.columns, areas, moving, where=str(source), nodes=nodes)
        else:
            idle = np.array([is_tmd or name in columns.network for name in wide.columns])
            idle |= _unused(table, wide.columns, areas, where)
            parts = parts_of_nodes(wide.columns, areas, moving, idle, where=str(source))
        start = None
        if table.remove == "nothing" or table.reference is not None:
            start = np.where([name in gradients for name in wide.columns], 0.0, table.reference or 0.0)
        unused = tuple(n for n, used in zip(wide.columns, parts.any(axis=0), strict=True) if not used)
        yield wide, ReadTable(parts, start, unit, unused)


def sample_series(
    project: Project, table: SeriesTable, columns: SeriesColumns, rows: FloatArray, where: str, scratch: IO[bytes]
) -> Sampled:
    """Read and check the series of a table, apply the `rows` [n, k] of the areas or nodes, and resample.

    Raises
    ------
    InputError : a file or stamps that are refused; less than two samples.
    ConfigError : as `open_series`.
    """
    source = series_files(project, table)[0]
    kept = Scratch(scratch, len(rows))
    with open_series(project, table, columns, where) as (wide, read):
        by_column = rows @ read.parts
        stamps = Stamps(wide.place, regular=table.method != "linear", max_gap_s=table.max_gap_s)
        trend = Trend(len(rows))
        resampler: LinearResampler | PolyphaseResampler | None = None
        for time, values in _propagated(wide, stamps, by_column, read.start):
            if table.resample_s is not None and resampler is None:
                resampler = _resampler(table, stamps, len(time), str(source))
            for some, part in pieces(time, values, stamps.first_s, table.resample_s, where):
                made = part if resampler is None else resampler.push(some, part)
                trend.add(made)
                kept.add(made)
    if trend.count < 2:
        raise InputError(f"{stamps.count} rows make {trend.count} samples, too few for a series", where=str(source))
    step = table.resample_s if table.resample_s is not None else stamps.mean_step_s
    late = resampler.first * step if isinstance(resampler, PolyphaseResampler) else 0.0
    highest = 0.5 / step
    if isinstance(resampler, PolyphaseResampler):
        highest = min(highest, 0.5 / stamps.step_s) * resampler.passes
    return Sampled(kept, stamps.first_s + late, step, highest, trend, part_words(read.parts, wide.columns), read)


def _propagated(
    wide: WideTable, stamps: Stamps, rows: FloatArray, start: FloatArray | None
) -> Iterator[tuple[FloatArray, FloatArray]]:
    """(stamps [B], signals [B, n]) of every block; a table of few columns is not read in more rows than signals bear.

    Where a mean is removed later the first row is taken off at once: absolute temperatures would cost digits.
    """
    for block in wide.blocks(max(1, wide_table.BLOCK_NUMBERS // max(rows.shape))):
        stamps.add(block.key, block.places)
        if start is None:
            start = block.values[0]
        yield block.key, (block.values - start) @ rows.T


def _constant(table: SeriesTable, areas: AreaTable, where: str, what: str) -> BoolArray:
    """Mask [k] of the areas that are said to keep their temperature."""
    patterns = table.constant or []
    names = areas.name.tolist()
    idle = [p for p in patterns if not any(fnmatchcase(name, p) for name in names)]
    if idle:
        raise ConfigError([("constant", f"no {what} has {p!r}") for p in idle], where=where)
    return np.array([any(fnmatchcase(name, p) for p in patterns) for name in names])


def _unused(table: SeriesTable, columns: Sequence[str], nodes: AreaTable, where: str) -> BoolArray:
    """Mask [columns] of those that are said to be of no use."""
    patterns = table.unused or []
    others = [name for name in columns if name not in set(nodes.name.tolist())]
    idle = [p for p in patterns if not any(fnmatchcase(name, p) for name in others)]
    if idle:
        facts = [("unused", f"no column that is not on the model has {p!r}") for p in idle]
        raise ConfigError(facts, where=where)
    return np.array([any(fnmatchcase(name, p) for p in patterns) for name in columns])


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


def treatment_words(table: SeriesTable, columns: SeriesColumns, sampled: Sampled) -> str:
    """Whose a series is, what is removed from it, how it is resampled, and which gradients and columns it has."""
    followed = np.array([bool(words) for words in sampled.column])
    areas, said = columns.areas, _without_gradients(table, sampled.read.unit)
    if columns.network is not None:
        said = f"of {count(int((~areas.gradient).sum()), 'thermal node')}, {said}"
        if unused := sampled.read.unused:
            said += f"; not on the model: {listed(unused)}"
    if not areas.gradient.any():
        return said
    silent = areas.name[areas.gradient & ~followed].tolist()
    if not silent:
        return f"{said}; gradients in K/m from columns of their own"
    others = ", the others in K/m from columns of their own" if (areas.gradient & followed).any() else ""
    return f"{said}; silent gradients, which have no column: {listed(silent)}{others}"


def _without_gradients(table: SeriesTable, unit: str) -> str:
    said = removed_words(table, unit)
    if unit == "degC":
        said = f"degrees Celsius, of which only differences count, {said}"
    if table.weights is not None:
        said = f"areas from nodes by {Path(table.weights).name}, {said}"
    if table.resample_s is None:
        return f"{said}, as sampled"
    how = {
        "linear": "by straight lines, without anti-alias filter",
        "polyphase": "by a polyphase low-pass (118 dB, flat to 0.66 of the lower Nyquist frequency)",
    }
    return f"{said}, resampled to {table.resample_s:g} s {how[str(table.method)]}"


def removed_words(table: SeriesTable, unit: str) -> str:
    """What is taken off the temperatures of a series."""
    if table.reference is not None:
        return f"above {table.reference:g} {unit}"
    return {
        "nothing": "nothing removed",
        "mean": "mean removed",
        "linear": "mean and linear trend removed",
    }[table.remove]
