"""Run benchmarks and keep their results as JSON: `python -m benchmarks [SET ...] [--into FOLDER] [--before COMMIT]`.

Without a set, all but `largest`. `python -m benchmarks.page FOLDER` makes tables and figures of what was kept.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Callable, Iterable, Mapping
from functools import partial
from pathlib import Path
from typing import Any

from benchmarks import chunks, goals, growth, largest, ratios
from benchmarks.process import ROOT
from benchmarks.record import About, Record
from benchmarks.tables import TABLES

Rows = Iterable[Mapping[str, Any]]
INTO = ROOT / "build" / "benchmarks"


def sets(before: str | None = None) -> dict[str, Callable[[], Rows]]:
    """Every set of benchmarks by name."""
    return {
        "ratios": ratios.in_one_process,
        "op2": growth.of_op2,
        "grids": growth.by_grids,
        "areas": growth.by_areas,
        "decks": growth.of_decks,
        "chunks": chunks.rows,
        "goals": partial(goals.rows, before),
        "largest": largest.rows,
    }


def main(arguments: list[str] | None = None) -> None:
    """Run the sets that are named, print their tables, and keep them."""
    every = sets()
    parser = argparse.ArgumentParser(prog="python -m benchmarks", description=__doc__)
    parser.add_argument("sets", nargs="*", metavar="SET", help=f"of {', '.join(every)}; default: all but largest")
    parser.add_argument("--into", type=Path, default=INTO, help="folder of the results (default: build/benchmarks)")
    parser.add_argument("--before", metavar="COMMIT", help="measure the goals of this older tree as well, in turn")
    told = parser.parse_args(arguments)
    if unknown := sorted(set(told.sets) - set(every)):
        parser.error(f"no set {', '.join(unknown)}; there are {', '.join(every)}")
    for name in told.sets or [name for name in every if name != "largest"]:
        start, about = time.perf_counter(), About.here()
        print(f"{name} ...", file=sys.stderr, flush=True)
        record = Record(name, about, list(sets(told.before)[name]()))
        path = record.write(told.into)
        for table in TABLES:
            if table.of == name:
                print(f"\n{table.markdown(record)}", flush=True)
        print(f"{name}: {time.perf_counter() - start:.0f} s, {path}", file=sys.stderr, flush=True)


if __name__ == "__main__":
    main()
