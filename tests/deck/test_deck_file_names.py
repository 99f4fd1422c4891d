"""File names in any script, and INCLUDEs nested as deep as programs write them."""

from __future__ import annotations

import os
import shutil
import time
from pathlib import Path

import h5py
import pytest
from deck_tools import bricks, plain, project, tedm

NAMES = {"UTF-8": "模型", "accents": "modèle thermo-élastique", "Latin-1": os.fsdecode("modèle".encode("latin-1"))}


def split(folder: Path, name: str) -> None:
    """Move the GRIDs of `model.bdf` to `name.inc`, in a folder of that name, and rename the rest to `name.bdf`."""
    text = (folder / "model.bdf").read_bytes()
    lines = text.splitlines(keepends=True)
    grids = [line for line in lines if line.startswith(b"GRID")]
    (folder / name).mkdir()
    (folder / name / f"{name}.inc").write_bytes(b"".join(grids))
    include = b"INCLUDE '" + os.fsencode(f"{name}/{name}.inc") + b"'\n"
    rest = b"".join(line for line in lines if line not in grids).replace(b"BEGIN BULK\n", b"BEGIN BULK\n" + include)
    (folder / "model.bdf").unlink()
    (folder / f"{name}.bdf").write_bytes(rest)


@pytest.mark.parametrize("script", NAMES)
def test_names_of_decks_and_includes_in_any_script(tmp_path: Path, script: str) -> None:
    """write-deck writes the names of its sources into the deck; solve and ingest follow the INCLUDE themselves.

    A name that is not UTF-8 cannot be recorded in a file of ours.
    """
    name, folder = NAMES[script], tmp_path / "project"
    project(folder, plain(bricks()))
    options = ("-c", folder / "tedm.toml", "-d", tmp_path / "build")
    split(folder, name)
    shutil.move(folder / f"{name}.bdf", folder / "model.bdf")
    assert tedm("write-deck", *options).code == 0
    deck = folder / "run" / "unit_loads.bdf"
    assert b"$   " + f"{name}.inc".encode("unicode_escape") in deck.read_bytes()  # a comment of ASCII, on one line

    shutil.copytree(folder / name, folder / "run" / name)
    lines = deck.read_bytes().splitlines(keepends=True)
    grids = [line for line in lines if line.startswith(b"GRID")]
    include = b"INCLUDE '" + os.fsencode(f"{name}/{name}.inc") + b"'\n"
    rest = b"".join(line for line in lines if line not in grids)
    deck.unlink()
    deck = folder / "run" / f"{name}.bdf"
    deck.write_bytes(rest.replace(b"BEGIN BULK\n", b"BEGIN BULK\n" + include))
    if script != "Latin-1":  # which no TOML can name
        config = folder / "model.toml"
        config.write_text(config.read_text("utf-8").replace("run/unit_loads.bdf", f"run/{name}.bdf"), "utf-8")
    else:
        deck.rename(folder / "run" / "unit_loads.bdf")
    assert tedm("solve", *options).code == 0
    done = tedm("ingest", *options)
    if script == "Latin-1":
        assert done.code == 4
        assert "has a name that is not UTF-8" in done.err
        return
    assert done.code == 0, done.err
    with h5py.File(tmp_path / "build" / "unit_loads.h5") as file:
        paths = file["/provenance/input_path"].asstr()[()]
    assert len(paths) == 4  # the configuration is none of them: deck, INCLUDE, areas and results


def test_a_missing_include_is_named_in_its_script(tmp_path: Path) -> None:
    folder = tmp_path / "project"
    project(folder, plain(bricks()))
    deck = folder / "model.bdf"
    deck.write_bytes(deck.read_bytes().replace(b"BEGIN BULK\n", "BEGIN BULK\nINCLUDE '模型.inc'\n".encode()))
    done = tedm("write-deck", "-c", folder / "tedm.toml")
    assert done.code == 4
    assert f"INCLUDE of a file that does not exist: {folder / '模型.inc'}" in done.err


def test_a_long_chain_of_includes_takes_seconds(tmp_path: Path) -> None:
    """1,500 files, each included by the one before: the time of each is that of reading it."""
    folder = tmp_path / "project"
    project(folder, plain(bricks()))
    (folder / "run").mkdir()
    (folder / "results").mkdir()
    depth = 1500
    for k in range(depth):
        more = f"INCLUDE 'c{k + 1}.inc'\n" if k + 1 < depth else ""
        for place in (folder, folder / "run"):
            (place / f"c{k}.inc").write_text(f"GRID,{1000 + k},,0.,0.,0.\n{more}")
    options = ("-c", folder / "tedm.toml", "-d", tmp_path / "build")
    assert tedm("write-deck", *options).code == 0
    for deck in (folder / "model.bdf", folder / "run" / "unit_loads.bdf"):
        deck.write_text(deck.read_text().replace("ENDDATA", "INCLUDE 'c0.inc'\nENDDATA"))
    assert tedm("write-deck", *options, "-o", folder / "run" / "other.bdf").code == 0
    written = (folder / "run" / "other.bdf").read_text()
    assert written.count("GRID,") == depth
    start = time.process_time()
    for stage in ("solve", "ingest"):
        done = tedm(stage, *options)
        assert done.code == 0, done.err
    assert time.process_time() - start < 30.0
