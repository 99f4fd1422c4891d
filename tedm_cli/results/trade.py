"""A trade of variants as trade.h5 tells it: its variants, criteria, values, and what contributes to them."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from tedm_cli.arrays import BoolArray, FloatArray
from tedm_cli.contracts import TRADE
from tedm_cli.contracts.trade import JUDGED, NOT_JUDGED
from tedm_cli.files.store import Reader, Writer
from tedm_cli.results.wording import ratio_text, sci, unit_text
from tedm_cli.trade.pareto import best, costs, dominance, fronts, scores


@dataclass(frozen=True)
class TradedVariant:
    """A variant: its name, the title of its project, what differs, its build folder as seen from trade.h5.

    `failure`: why it has no results, or "". With `front` 1 it is on the Pareto front; 0: it is not compared. `score`:
    0 for the best in all criteria with weights, 1 for the worst; None: none.
    """

    name: str
    title: str
    differs: str
    build: str
    failure: str
    front: int = 0
    score: float | None = None


@dataclass(frozen=True)
class TradedCriterion:
    """A criterion: what its values are and in which unit, which are better, and what they are judged by.

    `limit` is None where they are not judged, `weight` 0 where the criterion is not in the score. `parts`: what
    contributors add; empty where there are none.
    """

    name: str
    kind: str
    words: str
    unit: str
    goal: str
    limit: float | None
    weight: float
    parts: str

    def text(self, value: float) -> str:
        """A value as it is printed, without its unit."""
        if value == int(value) and abs(value) < 1e6:
            return sci(value, 7)
        return ratio_text(value) if self.unit == "1" and value > 0.0 else sci(value, 4)

    def with_unit(self, value: float) -> str:
        """A value as it is printed, with its unit."""
        return self.text(value) if self.unit == "1" else f"{self.text(value)} {unit_text(self.unit)}"

    @property
    def limit_words(self) -> str:
        """`at most 1`, or `at least 5 Hz`; empty where nothing is judged."""
        if self.limit is None:
            return ""
        return f"at {'most' if self.goal == 'min' else 'least'} {self.with_unit(self.limit)}"


@dataclass(frozen=True)
class Cell:
    """The value of a criterion for a variant; None where the variant lacks it, and then `reason` says why.

    `of`: output, case and frequency that it is of. `passed`: the verdict; None where it is not judged. `parts`: by
    contributor, signed; they sum to the value, or to its square (`TradedCriterion.parts`).
    """

    value: float | None
    reason: str = ""
    of: str = ""
    passed: bool | None = None
    parts: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class Trade:
    """Variants [v] by criteria [c]: `cells[v][c]`, and `dominates` [v, v], whether the row dominates the column."""

    title: str
    variants: tuple[TradedVariant, ...]
    criteria: tuple[TradedCriterion, ...]
    cells: tuple[tuple[Cell, ...], ...]
    dominates: BoolArray

    @property
    def names(self) -> list[str]:
        return [variant.name for variant in self.variants]

    @property
    def values(self) -> FloatArray:
        """[v, c], NaN where a variant lacks a criterion."""
        return _values(self.cells, len(self.criteria))

    @property
    def front(self) -> list[str]:
        """The variants on the Pareto front, in their order."""
        return [variant.name for variant in self.variants if variant.front == 1]

    def best_by(self, criterion: int) -> list[str]:
        """The variants with the best value of a criterion; none where all lack it."""
        goal = self.criteria[criterion].goal == "max"
        return [self.names[v] for v in best(costs(self.values[:, [criterion]], [goal])[:, 0])]

    def marked(self, criterion: int) -> list[str]:
        """The variants with the best value, where others have a worse one."""
        best, there = self.best_by(criterion), np.count_nonzero(~np.isnan(self.values[:, criterion]))
        return best if len(best) < there else []

    def dominated_by(self, variant: int) -> list[str]:
        """The variants that dominate one."""
        return [self.names[other] for other in np.flatnonzero(self.dominates[:, variant])]


def _values(cells: Sequence[Sequence[Cell]], criteria: int) -> FloatArray:
    rows = [[math.nan if cell.value is None else cell.value for cell in row] for row in cells]
    return np.array(rows, dtype=np.float64).reshape(len(cells), criteria)


def compared(
    title: str,
    variants: Sequence[TradedVariant],
    criteria: Sequence[TradedCriterion],
    cells: Sequence[Sequence[Cell]],
) -> Trade:
    """The trade of variants with these cells: fronts and scores are found here."""
    cost = costs(_values(cells, len(criteria)), [criterion.goal == "max" for criterion in criteria])
    score = scores(cost, np.array([criterion.weight for criterion in criteria]))
    placed = [
        TradedVariant(v.name, v.title, v.differs, v.build, v.failure, int(front), _known(of_all))
        for v, front, of_all in zip(variants, fronts(cost), score.tolist(), strict=True)
    ]
    return Trade(title, tuple(placed), tuple(criteria), tuple(map(tuple, cells)), dominance(cost))


def write_trade(writer: Writer, trade: Trade) -> None:
    """Write a trade into a file of the kind `TRADE`."""
    variants, criteria = trade.variants, trade.criteria
    writer.write(TRADE.TITLE, trade.title)
    writer.write(TRADE.VARIANT_NAME, [v.name for v in variants])
    writer.write(TRADE.VARIANT_TITLE, [v.title for v in variants])
    writer.write(TRADE.VARIANT_DIFFERS, [v.differs for v in variants])
    writer.write(TRADE.VARIANT_BUILD, [v.build for v in variants])
    writer.write(TRADE.VARIANT_FAILURE, [v.failure for v in variants])
    writer.write(TRADE.VARIANT_FRONT, [v.front for v in variants])
    writer.write(TRADE.VARIANT_SCORE, [_number(v.score) for v in variants])
    writer.write(TRADE.DOMINATES, trade.dominates.astype(int))
    writer.write(TRADE.CRITERION_NAME, [c.name for c in criteria])
    writer.write(TRADE.CRITERION_KIND, [c.kind for c in criteria])
    writer.write(TRADE.CRITERION_WORDS, [c.words for c in criteria])
    writer.write(TRADE.CRITERION_UNIT, [c.unit for c in criteria])
    writer.write(TRADE.CRITERION_GOAL, [c.goal for c in criteria])
    writer.write(TRADE.CRITERION_LIMIT, [_number(c.limit) for c in criteria])
    writer.write(TRADE.CRITERION_WEIGHT, [c.weight for c in criteria])
    writer.write(TRADE.CRITERION_PARTS, [c.parts for c in criteria])
    writer.write(TRADE.VALUE, trade.values)
    writer.write(TRADE.REASON, [[cell.reason for cell in row] for row in trade.cells])
    writer.write(TRADE.OF, [[cell.of for cell in row] for row in trade.cells])
    writer.write(TRADE.VERDICT, [[_verdict(cell.passed) for cell in row] for row in trade.cells])
    parts = [
        (v, c, name, part)
        for v, row in enumerate(trade.cells)
        for c, cell in enumerate(row)
        for name, part in cell.parts.items()
    ]
    writer.write(TRADE.CONTRIBUTOR_VARIANT, np.array([part[0] for part in parts], dtype=int))
    writer.write(TRADE.CONTRIBUTOR_CRITERION, np.array([part[1] for part in parts], dtype=int))
    writer.write(TRADE.CONTRIBUTOR_NAME, [part[2] for part in parts])
    writer.write(TRADE.CONTRIBUTOR_PART, np.array([part[3] for part in parts], dtype=np.float64))


def read_trade(file: Reader) -> Trade:
    """The trade in an open file."""
    texts = [file.strings(d) for d in (TRADE.VARIANT_NAME, TRADE.VARIANT_TITLE, TRADE.VARIANT_DIFFERS)]
    texts += [file.strings(d) for d in (TRADE.VARIANT_BUILD, TRADE.VARIANT_FAILURE)]
    numbers = zip(file.array(TRADE.VARIANT_FRONT).tolist(), map(_known, file.array(TRADE.VARIANT_SCORE)), strict=True)
    variants = tuple(TradedVariant(*words, *of) for *words, of in zip(*texts, numbers, strict=True))
    said = (TRADE.CRITERION_NAME, TRADE.CRITERION_KIND, TRADE.CRITERION_WORDS, TRADE.CRITERION_UNIT)
    columns = [file.strings(d) for d in (*said, TRADE.CRITERION_GOAL)]
    limits = map(_known, file.array(TRADE.CRITERION_LIMIT))
    weights = file.array(TRADE.CRITERION_WEIGHT).tolist()
    parts_of = file.strings(TRADE.CRITERION_PARTS)
    criteria = tuple(TradedCriterion(*row) for row in zip(*columns, limits, weights, parts_of, strict=True))
    parts: dict[tuple[int, int], dict[str, float]] = {}
    of_variant, of_criterion = file.array(TRADE.CONTRIBUTOR_VARIANT), file.array(TRADE.CONTRIBUTOR_CRITERION)
    names, part = file.strings(TRADE.CONTRIBUTOR_NAME), file.array(TRADE.CONTRIBUTOR_PART)
    for v, c, name, size in zip(of_variant.tolist(), of_criterion.tolist(), names, part.tolist(), strict=True):
        parts.setdefault((v, c), {})[name] = size
    shape = len(variants), len(criteria)
    value = file.array(TRADE.VALUE)
    reason, of, verdict = (
        np.array(file.strings(d), dtype=object).reshape(shape) for d in (TRADE.REASON, TRADE.OF, TRADE.VERDICT)
    )
    cells = tuple(
        tuple(
            Cell(_known(value[v, c]), reason[v, c], of[v, c], _passed(verdict[v, c]), parts.get((v, c), {}))
            for c in range(shape[1])
        )
        for v in range(shape[0])
    )
    dominates = file.array(TRADE.DOMINATES).astype(bool)
    return Trade(file.string(TRADE.TITLE), variants, criteria, cells, dominates)


def _verdict(passed: bool | None) -> str:
    return NOT_JUDGED if passed is None else JUDGED[0] if passed else JUDGED[1]


def _passed(verdict: str) -> bool | None:
    return None if verdict == NOT_JUDGED else verdict == JUDGED[0]


def _known(number: float) -> float | None:
    return None if math.isnan(number) else float(number)


def _number(known: float | None) -> float:
    return math.nan if known is None else known
