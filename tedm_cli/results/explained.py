"""What is told of a name: facts, and tables whose cells keep their numbers until they are printed."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from typing import Literal

import numpy as np

from tedm_cli.arrays import BoolArray, FloatArray
from tedm_cli.noise.areas import AreaTable
from tedm_cli.results.areas import unit_per
from tedm_cli.uncertainty.verdicts import Chance

Cell = str | float | bool | Chance | None
Form = Literal["text", "number", "fixed", "share", "ratio", "chance", "verdict"]
ROUNDING = 1e-12  # shares, and sums over what is summed, below this are nothing


@dataclass(frozen=True)
class Column:
    """Name of a column, what its cells are (`fixed`: numbers with one decimal, `chance`: a probability), and their unit
    where all have one.

    whole : what shares are of, for its title where tables of one output differ in that.
    """

    name: str
    form: Form = "text"
    unit: str = ""
    whole: str = ""


@dataclass(frozen=True)
class Table:
    """Rows of cells. `ranked`: the largest come first, and the first few will do."""

    name: str
    columns: tuple[Column, ...]
    rows: tuple[tuple[Cell, ...], ...]
    ranked: bool = False


@dataclass(frozen=True)
class Told:
    """What a name is (`sort`), in plain words, with what is known of it."""

    name: str
    sort: str
    title: str
    facts: tuple[str, ...] = ()
    tables: tuple[Table, ...] = ()
    notes: tuple[str, ...] = ()
    source: str = field(default="", kw_only=True)


def by_size(rows: Iterable[tuple[Cell, ...]], place: int) -> tuple[tuple[Cell, ...], ...]:
    """Rows by the magnitude of the number at `place`, the largest first."""

    def size(row: tuple[Cell, ...]) -> float:
        value = row[place]
        return -abs(value) if isinstance(value, float) else 0.0

    return tuple(sorted(rows, key=size))


def by_share(rows: Iterable[tuple[Cell, ...]], place: int) -> tuple[tuple[Cell, ...], ...]:
    """The same, without rows that carry nothing but rounding."""
    kept = [row for row in rows if not (isinstance(value := row[place], float) and abs(value) <= ROUNDING)]
    return by_size(kept, place)


def row_tables(value: FloatArray, unit: str, areas: AreaTable) -> tuple[Table, ...]:
    """An output [k] per kelvin of each area: areas, their groups, and gradients apart, whose unit is another.

    A share is that of the variance where the areas fluctuate alike and independently; a group's value is its sum, what
    it does where all of it warms by a kelvin.
    """
    means = ~areas.gradient
    power = float(value[means] @ value[means])
    share = np.where(means, value**2, 0.0) / power if power > 0.0 else np.zeros(len(value))
    of_mean = unit_per(unit, "K")
    numbers = (Column("value", "number", of_mean), Column("share", "share"))
    listed = [
        (str(name), str(group), float(v), float(s))
        for name, group, v, s, mean in zip(areas.name, areas.group, value, share, means, strict=True)
        if mean
    ]
    groups = []
    for group in dict.fromkeys(areas.group[means].tolist()):
        own = means & (areas.group == group)
        groups.append((group, float(own.sum()), clean_sum(value[own]), float(share[own].sum())))
    tables = [
        Table("areas", (Column("area"), Column("group"), *numbers), by_share(listed, 3), ranked=True),
        Table(
            "groups",
            (Column("group"), Column("areas", "number"), Column("sum", "number", of_mean), Column("share", "share")),
            by_share(groups, 3),
            ranked=True,
        ),
    ]
    if areas.gradient.any():
        rows = [(str(n), float(v)) for n, v in zip(areas.name[~means], value[~means], strict=True)]
        columns = (Column("gradient"), Column("value", "number", unit_per(unit, "K/m")))
        tables.append(Table("gradients", columns, by_size(rows, 1), ranked=True))
    return tuple(tables)


def clean_sum(values: FloatArray) -> float:
    """The sum of the values; 0 where they cancel but for rounding."""
    total = float(values.sum())
    return total if abs(total) > ROUNDING * float(np.abs(values).sum()) else 0.0


def sizes(value: FloatArray, means: BoolArray) -> tuple[float, float]:
    """Root of the sum of squares over the areas of a mean temperature, and their sum: the uniform load."""
    return float(np.linalg.norm(value[means])), clean_sum(value[means])


def without_empty(told: Told) -> Told:
    """The same without tables that have no rows."""
    return replace(told, tables=tuple(table for table in told.tables if table.rows))


def also(told: Told, others: Sequence[str]) -> Told:
    """The same with a note on what other sorts have the name too."""
    return replace(told, notes=(*told.notes, *(f"of the same name, and not told: {other}" for other in others)))
