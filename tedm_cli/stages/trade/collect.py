"""The values of all criteria for all variants, and trade.h5."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from tedm_cli.chain.graph import Step
from tedm_cli.config.trade import CriterionTable
from tedm_cli.contracts import TRADE
from tedm_cli.errors import TedmError
from tedm_cli.files.build_folder import provenance
from tedm_cli.files.provenance import ConfigFile, relative_name
from tedm_cli.files.store import create
from tedm_cli.progress import Step as Progress
from tedm_cli.results.trade import Cell, Trade, TradedCriterion, TradedVariant, compared, write_trade
from tedm_cli.stages.trade.criteria import Measured, commands, measured
from tedm_cli.stages.trade.found import LacksError, VariantResults
from tedm_cli.stages.trade.variants import OpenTrade, Variant

TRADE_FILE = "trade.h5"


def wanted_steps(trade: OpenTrade, variant: Variant, *, whole: bool = False) -> Callable[[Step], bool]:
    """The steps of a variant's chain that make what the criteria are read from; `whole`: all else of the chain, too.

    Raises
    ------
    ConfigError, InputError : its configuration cannot be read.
    """
    assert variant.project is not None
    results = VariantResults(variant.project)
    wanted = {command for criterion in trade.config.criteria for command in commands(criterion, results)}
    return lambda step: step.command in wanted or (whole and not step.on_request)


@dataclass(frozen=True)
class _Row:
    """The values of one variant, why it has none, and the files that they are from."""

    measured: tuple[Measured | str, ...]
    failure: str = ""
    files: tuple[Path, ...] = ()


def collect(trade: OpenTrade, failures: Mapping[str, str], step: Progress) -> tuple[Trade, Path]:
    """Read the criteria of all variants, compare them, and write trade.h5; `failures`: of those whose chain failed.

    Raises
    ------
    InputError : the file cannot be written.
    """
    rows = []
    for number, variant in enumerate(trade.variants, start=1):
        rows.append(_row(trade.config.criteria, variant, failures.get(variant.name, variant.failure)))
        step(number, len(trade.variants), "reading variants")
    criteria = [_criterion(table, [row.measured[c] for row in rows]) for c, table in enumerate(trade.config.criteria)]
    cells = [[_cell(table, m) for table, m in zip(trade.config.criteria, row.measured, strict=True)] for row in rows]
    variants = [_variant(trade, v, row.failure) for v, row in zip(trade.variants, rows, strict=True)]
    found = compared(trade.config.title, variants, criteria, cells)
    path = trade.folder / TRADE_FILE
    configs: list[ConfigFile] = [trade.file]
    with create(path, TRADE, provenance(configs, [file for row in rows for file in row.files])) as writer:
        write_trade(writer, found)
    return found, path


def _row(criteria: Sequence[CriterionTable], variant: Variant, failure: str) -> _Row:
    if failure or variant.project is None:
        return _Row(("its chain failed",) * len(criteria), failure)
    found: list[Measured | str] = []
    try:
        results = VariantResults(variant.project)
        for criterion in criteria:
            try:
                found.append(measured(criterion, results))
            except LacksError as exc:
                found.append(str(exc))
    except TedmError as exc:
        return _Row(("its results cannot be read",) * len(criteria), exc.placed.replace("\n", "; "))
    return _Row(tuple(found), files=tuple(results.files))


def _criterion(table: CriterionTable, found: Sequence[Measured | str]) -> TradedCriterion:
    units = [m.unit for m in found if isinstance(m, Measured)]
    kind = table.of_kind
    return TradedCriterion(
        table.name, table.kind, kind.words, units[0] if units else "", table.better, table.judged_by, table.weight,
        kind.parts,
    )  # fmt: skip


def _cell(table: CriterionTable, found: Measured | str) -> Cell:
    if isinstance(found, str):
        return Cell(None, found)
    return Cell(found.value, "", found.of, table.passes(found.value), found.parts)


def _variant(trade: OpenTrade, variant: Variant, failure: str) -> TradedVariant:
    title = "" if variant.project is None else variant.project.title
    build = relative_name(variant.build_dir, trade.folder)
    return TradedVariant(variant.name, title, variant.table.differs or "", build, failure)
