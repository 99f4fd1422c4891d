"""Tables of the page of large models, of stored results: their cells and what is said below them."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from benchmarks.growth import column, exponent, per_size, tasks_of
from benchmarks.largest import SOLVED
from benchmarks.record import Record
from benchmarks.scale import DECK

Rows = Sequence[Mapping[str, Any]]
Cells = list[list[str]]
_MB = 1e6
_ROOM_GB = 16.0


@dataclass(frozen=True)
class Table:
    """A table by its name on the page: of which set, its heads, and its cells."""

    name: str
    of: str
    cells: Callable[[Rows], Cells]

    def markdown(self, record: Record) -> str:
        """The table and a line of what, when and where."""
        head, *body = self.cells(record.rows)
        lines = [f"| {' | '.join(cells)} |" for cells in (head, ["---"] * len(head), *body)]
        about = record.about
        of = f"*Measured on {about.day} at commit {about.commit} of {about.commit_date}"
        return "\n".join([*lines, "", f"{of}; {about.machine}, load {about.load:g}; {about.libraries}.*"])


def number(value: float | None) -> str:
    """Two figures of small numbers, all before the point of large ones."""
    if value is None:
        return ""
    if value == 0.0 or abs(value) >= 9.95:
        return f"{value:,.0f}"
    digits = 1
    while abs(value) * 10**digits < 9.95 and digits < 4:
        digits += 1
    return f"{value:.{digits}f}"


def _ratios(rows: Rows) -> Cells:
    cells = [["work", "peer", "time", "peer's time", "ratio", ""]]
    for row in rows:
        times = [_time(row[side]["best_s"], row["each"]) if side in row else "" for side in ("ours", "other")]
        cells.append([row["work"], row["peer"] or "", *times, number(row["ratio"]), row["note"]])
    return cells


def _time(seconds: float, each: Mapping[str, Any] | None) -> str:
    if each is None:
        return f"{number(seconds)} s"
    one = seconds / each["number"]
    for factor, unit in ((1.0, "s"), (1e3, "ms"), (1e6, "µs"), (1e9, "ns")):
        if one * factor >= 1.0 or unit == "ns":
            return f"{number(one * factor)} {unit} a {each['of']}"
    raise AssertionError


def _op2(rows: Rows) -> Cells:
    plain = {row["stage"]: row["processor_s"] for row in rows if row["task"].startswith("plain")}
    cells = [["work", "processor s", "plain = 1", "anonymous MB"]]
    for row in rows:
        seconds = _streamed(row)
        ratio = number(seconds / plain[row["stage"]])
        cells.append([row["task"], number(seconds), ratio, number(row["anonymous_mb"])])
    return cells


def _streamed(row: Mapping[str, Any]) -> float:
    return float(row["streaming_s"] or row["processor_s"])


def _sizes(rows: Rows, size: str) -> list[int]:
    return sorted({row[size] for row in rows})


def _growth(rows: Rows, size: str, key: str, slope: str, grown: Callable[[list[float], list[float]], float]) -> Cells:
    cells = [["stage", *(f"{n:,} {size}" for n in _sizes(rows, size)), slope]]
    for task in tasks_of(rows):
        sizes, values = column(rows, task, key, size)
        cells.append(
            [
                task,
                *map(number, values),
                f"{grown(sizes, values):.2f}" if grown is exponent else number(grown(sizes, values)),
            ]
        )
    return cells


def _grids_time(rows: Rows) -> Cells:
    return _growth(rows, "grids", "processor_s", "exponent", exponent)


def _grids_memory(rows: Rows) -> Cells:
    return _growth(rows, "grids", "anonymous_mb", "bytes a grid", lambda n, mb: _MB * per_size(n, mb))


def _areas_time(rows: Rows) -> Cells:
    return _growth(rows, "areas", "processor_s", "exponent", exponent)


def _areas_memory(rows: Rows) -> Cells:
    heads = [f"{n:,} areas" for n in _sizes(rows, "areas")]
    cells = [["stage: anonymous, resident MB", *heads, "resident bytes an area and grid"]]
    for task in tasks_of(rows):
        sizes, resident = column(rows, task, "resident_mb", "areas")
        _, anonymous = column(rows, task, "anonymous_mb", "areas")
        pairs = [f"{a:,.0f}, {r:,.0f}" for a, r in zip(anonymous, resident, strict=True)]
        slope = _MB * per_size(sizes, resident) / rows[0]["grids"]
        cells.append([task, *pairs, f"{round(slope, 1) + 0.0:.1f}"])
    return cells


def _decks(rows: Rows) -> Cells:
    ((ours, (peer,)),) = DECK.items()
    own = [row for row in rows if row["task"] in (ours, peer)]
    cells = [["", *(f"{n:,} grids" for n in _sizes(own, "grids")), "slope"]]
    for task in (ours, peer):
        for key, what, factor, unit in (
            ("processor_s", "processor s", 1e6, "µs a grid"),
            ("anonymous_mb", "anonymous MB", _MB, "bytes a grid"),
        ):
            sizes, values = column(own, task, key, "grids")
            cells.append(
                [f"{task}: {what}", *map(number, values), f"{number(factor * per_size(sizes, values))} {unit}"]
            )
    return cells


def _chunks(rows: Rows) -> Cells:
    cells = [["chunk (areas × grids), HDF5's chunk cache", "write", "read by area", "read by block"]]
    for row in rows:
        cache = f"{row['cache_MB']} MB" if row["cache_MB"] else "none"
        shape = "{:,} × {:,}, {}".format(*row["chunk"], cache) if row["chunk"] else "contiguous"
        cells.append([shape, *(number(row[key]) for key in ("write", "by_area", "by_block"))])
    return cells


def _goals(rows: Rows) -> Cells:
    compared = any("before" in row for row in rows)
    older = [f"commit {rows[0]['commit']}"] if compared else []
    cells = [["", "goal", *older, "now", *(["now / before"] if compared else [])]]
    for row in rows:
        limit = f"flat, {row['unit']}" if row["limit"] is None else f"{number(row['limit'])} {row['unit']}"
        told = [_with_processor(row, which) for which in (("before", "now") if compared else ("now",))]
        key = "_processor_s" if row["now_processor_s"] else ""
        before = row.get(f"before{key}")
        ratio = [number(row[f"now{key}"] / before) if before else ""] if compared else []
        cells.append([row["goal"], limit, *told, *ratio])
    return cells


def _with_processor(row: Mapping[str, Any], which: str) -> str:
    seconds = row[f"{which}_processor_s"]
    return number(row[which]) + (f" ({number(seconds)} processor s)" if seconds else "")


def _largest(rows: Rows) -> Cells:
    cells = [["route", "largest tried", "processor s", "anonymous MB", "bytes a grid", f"grids in {_ROOM_GB:.0f} GB"]]
    for task in [*tasks_of(rows), SOLVED]:
        own = sorted((row for row in rows if row["task"] == task), key=lambda row: row["grids"])
        if not own:
            continue
        last = own[-1]
        each = _MB * last["anonymous_mb"] / last["grids"]
        if len(own) > 1:  # no line: the growth between the two largest goes on
            growth = exponent([row["grids"] for row in own[-2:]], [row["anonymous_mb"] for row in own[-2:]])
            most = last["grids"] * (1e3 * _ROOM_GB / last["anonymous_mb"]) ** (1.0 / growth)
        else:
            most = 1e9 * _ROOM_GB / each
        tried = f"{last['grids']:,} grids × {last['areas']} areas"
        told = (number(last["processor_s"]), number(last["anonymous_mb"]), number(each), f"{most / 1e6:.1f} million")
        cells.append([f"{task}{', ' + last['solver'] if 'solver' in last else ''}", tried, *told])
    return cells


TABLES = (
    Table("goals", "goals", _goals),
    Table("ratios", "ratios", _ratios),
    Table("op2", "op2", _op2),
    Table("grids-time", "grids", _grids_time),
    Table("grids-memory", "grids", _grids_memory),
    Table("areas-time", "areas", _areas_time),
    Table("areas-memory", "areas", _areas_memory),
    Table("decks", "decks", _decks),
    Table("chunks", "chunks", _chunks),
    Table("largest", "largest", _largest),
)
