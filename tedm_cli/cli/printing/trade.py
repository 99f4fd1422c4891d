"""A trade of variants, as lines of text and for programs."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from tedm_cli.chain.graph import Step
from tedm_cli.cli.printing.chain import step_line
from tedm_cli.cli.printing.table import table
from tedm_cli.results.trade import Cell, Trade
from tedm_cli.results.wording import number_text
from tedm_cli.stages.chain.plan import Plan

_ACROSS = 6  # variants beside each other
_EMPTY = "-"


def variant_step_line(name: str, number: int, plan: Plan, step: Step) -> str:
    """That a step of a variant begins, and why it has to run."""
    return f"{name}: {step_line(number, plan, step)}"


def failure_text(said: str) -> str:
    """Why a command was refused, in one line, by what it said on standard error."""
    lines = [line for line in said.splitlines() if line.strip()]
    errors = [line.removeprefix("error: ") for line in lines if line.startswith("error: ")] or lines
    return "; ".join(errors) or "it said nothing"


def trade_lines(trade: Trade, paths: Sequence[Path], verbose: int) -> list[str]:
    """Criteria by variants, the Pareto front, what is not on it and why, and the files."""
    lines: list[str] = []
    for begin in range(0, len(trade.variants), _ACROSS):
        lines += [*_table(trade, range(begin, min(begin + _ACROSS, len(trade.variants)))), ""]
    lines.append("*: best; FAIL: its limit is violated; -: the variant lacks it" + ("" if verbose else " (-v: why)"))
    if verbose:
        lines += _reasons(trade)
    lines.append(f"Pareto front: {', '.join(trade.front) or 'no variant can be compared'}")
    for place, variant in enumerate(trade.variants):
        if variant.front > 1:
            lines.append(f"{variant.name}: dominated by {', '.join(trade.dominated_by(place))}")
        elif variant.failure:
            lines.append(f"{variant.name}: failed: {variant.failure}")
        elif not variant.front:
            lines.append(f"{variant.name}: has none of the criteria")
    return [*lines, f"open {next(path for path in paths if path.suffix == '.html')}"]


def _table(trade: Trade, shown: range) -> list[str]:
    rows = []
    for c, criterion in enumerate(trade.criteria):
        best = trade.marked(c)
        unit = "" if criterion.unit in ("", "1") else f" ({criterion.unit})"
        limit = f", {criterion.limit_words}" if criterion.limit_words else ""
        values = [_value(trade, c, trade.cells[v][c], trade.names[v] in best) for v in shown]
        rows.append([f"{criterion.name}{unit}{limit}", *values])
    fronts = [trade.variants[v].front for v in shown]
    rows.append(["front", *("Pareto" if front == 1 else str(front or _EMPTY) for front in fronts)])
    if any(variant.score is not None for variant in trade.variants):
        scores = [trade.variants[v].score for v in shown]
        rows.append(["score, 0 best, 1 worst", *(_EMPTY if s is None else number_text(s) for s in scores)])
    head = ("criterion", *(trade.names[v] for v in shown))
    return table(head, rows, right=range(1, len(head)))


def _value(trade: Trade, c: int, cell: Cell, is_best: bool) -> str:
    if cell.value is None:
        return _EMPTY
    return f"{trade.criteria[c].text(cell.value)}{' *' if is_best else ''}{' FAIL' if cell.passed is False else ''}"


def _reasons(trade: Trade) -> list[str]:
    """What each value is of, and why there is none."""
    return [
        f"  {variant.name}, {criterion.name}: {cell.reason or cell.of}"
        for variant, cells in zip(trade.variants, trade.cells, strict=True)
        if not variant.failure
        for criterion, cell in zip(trade.criteria, cells, strict=True)
    ]


def trade_dict(trade: Trade, paths: Sequence[Path] = ()) -> dict[str, Any]:
    """For a program; a criterion that a variant lacks has the value null and a reason."""
    return {
        "title": trade.title,
        "front": trade.front,
        "criteria": [
            {
                "name": criterion.name,
                "kind": criterion.kind,
                "unit": criterion.unit,
                "goal": criterion.goal,
                "limit": criterion.limit,
                "weight": criterion.weight,
                "best": trade.best_by(c),
            }
            for c, criterion in enumerate(trade.criteria)
        ],
        "variants": [
            {
                "name": variant.name,
                "differs": variant.differs,
                "failure": variant.failure or None,
                "front": variant.front or None,
                "score": variant.score,
                "dominated_by": trade.dominated_by(v),
                "values": {
                    criterion.name: {
                        "value": cell.value,
                        "of": cell.of or None,
                        "passed": cell.passed,
                        "reason": cell.reason or None,
                        "parts": dict(cell.parts),
                    }
                    for criterion, cell in zip(trade.criteria, trade.cells[v], strict=True)
                },
            }
            for v, variant in enumerate(trade.variants)
        ],
        "files": list(paths),
    }
