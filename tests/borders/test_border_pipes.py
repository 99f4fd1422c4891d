"""Inputs that are no regular files are refused by name before they are opened: opening a pipe waits for a writer."""

from __future__ import annotations

import os
import signal
from collections.abc import Iterator
from pathlib import Path

import pytest
from border_tools import Project, replace, tedm

SECONDS = 20  # until a wait counts as one without end


@pytest.fixture(autouse=True)
def _no_hang() -> Iterator[None]:
    def stop(*_: object) -> None:
        raise BaseException("waits for the pipe")  # no Exception: nobody may take it for a fault of the file

    before = signal.signal(signal.SIGALRM, stop)
    signal.alarm(SECONDS)
    yield
    signal.alarm(0)
    signal.signal(signal.SIGALRM, before)


def pipe(path: Path) -> None:
    path.unlink(missing_ok=True)
    os.mkfifo(path)


READERS = {
    "unit_loads.bdf": ["ingest", "solve"],
    "unit_loads.op2": ["ingest"],
    "areas.csv": ["ingest", "write-deck", "areas"],
    "model.bdf": ["write-deck", "areas"],
    "model.toml": ["ingest"],
    "tedm.toml": ["ingest"],
    "build/unit_loads.h5": ["build-distortion"],
}


@pytest.mark.parametrize("name", READERS)
def test_pipes_are_refused_by_name(tiny: Project, name: str) -> None:
    pipe(tiny.folder / name)
    if name == "model.bdf":
        tiny.deck.unlink()
    for command in READERS[name]:
        tiny.run(command).refused(4, f"{name}: is a pipe (FIFO), not a regular file", hint="save its content as a file")


def test_pipes_of_includes_tables_and_checks(tiny: Project) -> None:
    pipe(tiny.folder / "grids.inc")
    pipe(tiny.folder / "points.csv")
    tedm("show", tiny.folder / "points.csv").refused(4, "points.csv: is a pipe (FIFO)")
    tedm("self-gravity", "--points", tiny.folder / "points.csv", "-c", tiny.folder / "tedm.toml").refused(
        4, "points.csv: is a pipe (FIFO)"
    )
    pipe(tiny.op2)
    done = tedm("check", "-d", tiny.build)
    assert done.code == 4
    assert "unit_loads.op2 is gone" in done.out + done.err
    for deck, command in ((tiny.deck, "solve"), (tiny.folder / "model.bdf", "write-deck")):
        replace(deck, "ENDDATA", "INCLUDE 'grids.inc'\nENDDATA")
        tiny.run(command).refused(4, f"{deck.name}:", "grids.inc, which is a pipe (FIFO), not a regular file")


def test_a_folder_is_no_input(tiny: Project) -> None:
    tiny.deck.unlink()
    tiny.deck.mkdir()
    tiny.run("ingest").refused(4, "unit_loads.bdf: is a folder, not a regular file")
