"""Thermal areas on the command line: defined, shown, drawn, and held against the deck that was solved."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import h5py
import numpy as np
import pytest
from border_tools import LEFT, RIGHT, SMALL, Project, replace, tedm, tiny_ids, tiny_motions, untouched

from tedm_cli.areas.csv_file import read_area_csv
from tedm_cli.nastran.op2.writer import write_op2

DEFINE = """
[[areas.define]]
name = "LEFT"
element = 1

[[areas.define]]
name = "RIGHT"
remainder = true

[[test_mass]]"""


def defined(project: Project, text: str = DEFINE) -> Project:
    """The two bricks with definitions in place of the CSV."""
    replace(project.model, 'areas_csv = "areas.csv"\n', "")
    replace(project.model, "\n[[test_mass]]", text)
    return project


def test_definitions_write_the_deck_of_the_csv(tiny: Project) -> None:
    before = tiny.deck.read_bytes()
    outcome = defined(tiny, DEFINE.replace("remainder = true", "element = 2")).run("write-deck").ok()
    assert tiny.deck.read_bytes() == before
    step, warning, *notes = outcome.out.splitlines()[1:]
    assert step == "mean step of the areas' own elements: 50 % (RIGHT) to 100 % (LEFT)"
    assert warning.startswith("warning: ")
    assert "RIGHT 50 % (element 2)" in warning
    assert notes == ["note: area RIGHT: 4 shared grids stay with earlier definitions (LEFT 4)"]
    tiny.run("ingest").ok()


@pytest.mark.parametrize(
    ("old", "new", "pieces"),
    [
        (
            "element = 1",
            "box = { x_m = [0.0, 0.05] }",
            ["area 'LEFT'", "4 grids are warmed but not defined: 5, 6, 7, 8"],
        ),
        (
            'name = "RIGHT"',
            'name = "REST"',
            ["other thermal areas: REST defined, but not in the deck; RIGHT in the deck"],
        ),
    ],
)
def test_ingest_refuses_a_deck_of_other_areas(tiny: Project, old: str, new: str, pieces: list[str]) -> None:
    defined(tiny)
    replace(tiny.model, old, new)
    if 'name = "REST"' in new:
        replace(tiny.model, 'match = "RIGHT"', 'match = "R*"')
    with untouched(tiny.folder):
        tiny.run("ingest").refused(4, *pieces)


def test_ingest_compares_the_csv_too(tiny: Project) -> None:
    replace(tiny.folder / "areas.csv", "9,RIGHT", "9,LEFT")
    with untouched(tiny.folder):
        tiny.run("ingest").refused(4, "unit_loads.bdf", "area 'LEFT': 1 grids are defined but not warmed: 9 (1 more")
    (tiny.folder / "areas.csv").unlink()
    tiny.run("ingest").refused(4, "areas.csv: no such file")


def test_names_are_compared_as_nastran_does(tiny: Project) -> None:
    replace(tiny.deck, "LABEL = LEFT", "LABEL = Left")
    replace(tiny.model, 'match = "LEFT"', 'match = "[Ll]*"')
    tiny.run("ingest").ok()


def test_table_needs_no_results_and_adds_up(tiny: Project) -> None:
    """From the model and its definitions, from the CSV, and from the deck's TEMP cards: the same areas."""
    tiny.op2.unlink()
    found = [json.loads(tiny.run("areas", "--json").ok().out)]
    replace(tiny.model, 'areas_csv = "areas.csv"\n', "")
    found.append(json.loads(tiny.run("areas", "--json").ok().out))
    replace(tiny.model, "\n[[test_mass]]", DEFINE)
    tiny.deck.unlink()
    found.append(json.loads(tiny.run("areas", "--json").ok().out))
    # Definitions alone say which elements are an area's own; else one that is shared evenly counts by half in both.
    steps = [[(a.pop("mean_step"), a.pop("mean_step_elements")) for a in f["areas"]] for f in found]
    assert steps[0] == steps[1] == [(pytest.approx(1.25 / 1.5), [1, 2]), (pytest.approx(0.5), [2])]
    assert steps[2] == [(pytest.approx(1.0), [1]), (pytest.approx(0.5), [2])]
    assert found[0]["areas"] == found[1]["areas"] == found[2]["areas"]
    assert [Path(f["deck"]).name for f in found] == ["model.bdf", "unit_loads.bdf", "model.bdf"]
    left, right = found[0]["areas"]
    assert (left["grids"], right["grids"]) == (len(LEFT), len(RIGHT))
    np.testing.assert_allclose(left["centroid_m"], [0.05, 0.05, 0.05], rtol=0, atol=1e-15)
    # Two bricks of 2.7 kg; the plane between them is the left area's.
    assert left["mass_kg"] == pytest.approx(2.7 * 1.5, rel=1e-12)
    assert left["mass_kg"] + right["mass_kg"] == pytest.approx(found[0]["model_kg"], rel=1e-12)
    assert found[0]["is_partition"]
    assert found[0]["structural_grids"] == 12


def test_csv_goes_round(tiny: Project) -> None:
    tiny.run("areas", "-o", tiny.folder / "out.csv", "-q").ok()
    before, after = read_area_csv(tiny.folder / "areas.csv"), read_area_csv(tiny.folder / "out.csv")
    assert before.keys() == after.keys()
    assert all(np.array_equal(before[k], after[k]) for k in before)


def test_leftovers_are_shown_before_they_are_refused(tiny: Project, monkeypatch: pytest.MonkeyPatch) -> None:
    """The table and the picture are what one needs to define the rest; the CSV would be of no use."""
    defined(tiny, DEFINE.replace("remainder = true", "box = { x_m = [0.15, 0.3], y_m = [-inf, 0.05] }"))
    monkeypatch.setattr("tedm_cli.figures.model.areas.DPI", 40)
    csv, figure = tiny.folder / "out.csv", tiny.folder / "out.svg"
    outcome = tiny.run("areas", "-o", csv, "--figure", figure)
    assert "10 of 12 structural grids are in exactly one area, 2 in none" in outcome.out
    outcome.refused(4, "model.bdf: 2 structural grids are in no thermal area: 10, 11", hint="remainder = true")
    assert not csv.exists()
    assert "magenta: grids in no area" in figure.read_text()
    tiny.run("write-deck").refused(4, "2 structural grids are in no thermal area: 10, 11")


def test_figure_formats(tiny: Project, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("tedm_cli.figures.model.areas.DPI", 40)
    for name, start in (("a.svg", b"<?xml"), ("a.png", b"\x89PNG")):
        tiny.run("areas", "-q", "--figure", tiny.folder / name).ok()
        first = (tiny.folder / name).read_bytes()
        assert first.startswith(start)
        tiny.run("areas", "-q", "--figure", tiny.folder / name).ok()
        assert (tiny.folder / name).read_bytes() == first
    assert all(label in (tiny.folder / "a.svg").read_text() for label in ("LEFT", "RIGHT", "x (m)", "from +z"))
    with untouched(tiny.folder):
        tiny.run("areas", "--figure", tiny.folder / "a.pdf").refused(2, ".svg or .png")


@pytest.mark.parametrize("backend", ["module://matplotlib_inline.backend_inline", "bogus"])
def test_figures_need_no_backend_of_the_user(tiny: Project, backend: str) -> None:
    """Notebooks name theirs in the environment of their terminals; in a new process, as matplotlib looks once."""
    figure = tiny.folder / "out.svg"
    command = [sys.executable, "-m", "tedm_cli.cli", "areas", "-c", tiny.folder / "tedm.toml", "--figure", figure]
    done = subprocess.run(
        [str(c) for c in command], env=os.environ | {"MPLBACKEND": backend}, capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr
    assert figure.is_file()


def test_what_is_shown_is_what_is_ingested(chain: Project) -> None:
    shown = json.loads(tedm("areas", "-c", SMALL / "tedm.toml", "--json").ok().out)
    with h5py.File(chain.build / "unit_loads.h5") as file:
        area = file["area"]
        assert [a["name"] for a in shown["areas"]] == list(area["name"].asstr())
        for key in ("group", "shield", "side"):
            assert [a[key] for a in shown["areas"]] == list(area[key].asstr())
        np.testing.assert_allclose([a["mass_kg"] for a in shown["areas"]], area["mass"], rtol=1e-14)
        np.testing.assert_allclose([a["centroid_m"] for a in shown["areas"]], area["centroid"], rtol=0, atol=1e-15)


def test_definitions_on_a_deck_solved_by_another_program(mini_ltp_dir: Path, tmp_path: Path, tiny: Project) -> None:
    """Its areas by their properties: the panel, the boxes' tops, the struts; the bench by boxes."""
    text = tiny.model.read_text()
    head = f'[model]\nbdf = "{(mini_ltp_dir / "mini_ltp.bdf").resolve()}"\n[areas]\n'
    head += 'rule = [{ match = "*", group = "all", shield = "inside" }]\n'
    tables = [
        'name = "TOP_PANEL"\nproperty = 5',
        'name = "STRUTS"\nproperty = 7',
        'name = "IS1"\nproperty = 3\nbox = { x_m = [-inf, 0.0] }',
        'name = "REST"\nremainder = true',
    ]
    defines = "".join(f"[[areas.define]]\n{t}\n" for t in tables)
    tiny.model.write_text(head + defines + text[text.index("[[test_mass]]") :])
    shown = json.loads(tiny.run("areas", "--json").ok().out)
    reference = json.loads((mini_ltp_dir / "areas.json").read_text())
    sizes = {a["name"]: a["grids"] for a in shown["areas"]}
    assert sizes["TOP_PANEL"] == len(reference["TOP_PANEL"])
    assert sizes["STRUTS"] == sum(len(ids) for name, ids in reference.items() if name.startswith("STRUT"))
    assert sum(sizes.values()) == shown["structural_grids"]


NAMES = ["STRUT 1", "PANEL +Y", "Shield (outer)/lid", "A.B-c_d:2 E", "N" * 56]
NO_NAMES = ["STRUT  1", "1STRUT", "A*", "A[1]", "A?", "A;B", "É", "N" * 57, "A 'B'"]


@pytest.mark.parametrize("name", NAMES)
def test_a_name_is_good_everywhere(tiny: Project, name: str, tmp_path: Path) -> None:
    """areas.csv to deck, deck to areas without the CSV, these to a CSV again, and a definition: one rule."""
    csv = tiny.folder / "areas.csv"
    csv.write_text(csv.read_text().replace("LEFT", name))
    replace(tiny.model, 'match = "LEFT"', f'match = "{name}"')
    tiny.run("write-deck").ok()
    assert f"LABEL = {name}" in tiny.deck.read_text()
    before = csv.read_text()
    replace(tiny.model, 'areas_csv = "areas.csv"\n', "")
    tiny.run("areas", "-o", tmp_path / "again.csv").ok()
    assert sorted((tmp_path / "again.csv").read_text().split("\n")) == sorted(before.split("\n"))
    assert set(read_area_csv(tmp_path / "again.csv")) == {name, "RIGHT"}
    replace(tiny.model, "\n[[test_mass]]", DEFINE.replace("LEFT", name))
    tiny.run("areas").ok()


@pytest.mark.parametrize("name", NO_NAMES)
def test_a_name_is_refused_everywhere(tiny: Project, name: str) -> None:
    fact = "a name of an area must begin with a letter"
    csv = tiny.folder / "areas.csv"
    if "  " not in name:  # blanks of a LABEL are one
        text = tiny.deck.read_text(encoding="utf-8")
        sound = text.replace("LABEL = LEFT", f"LABEL = {name}")
        assert sound != text
        tiny.deck.write_text(sound, encoding="latin-1")
        tiny.run("ingest").refused(4, "unit_loads.bdf: subcase 1: its LABEL names no area", fact, hint="LABEL")
    csv.write_text(csv.read_text().replace("LEFT", name), encoding="utf-8")
    tiny.run("areas").refused(4, "areas.csv:2", fact)
    defined(tiny, DEFINE.replace("LEFT", name)).run("areas").refused(3, "areas.define[0].name", fact)


def test_labels_with_blanks_go_through_the_whole_model(tiny: Project) -> None:
    """The results name the subcase as the deck does; blanks in rows are one."""
    tiny.deck.write_text(tiny.deck.read_text().replace("LABEL = LEFT", "LABEL = LEFT   BRICK"))
    replace(tiny.model, 'areas_csv = "areas.csv"\n', "")
    replace(tiny.model, 'match = "LEFT"', 'match = "LEFT *"')
    write_op2(
        tiny.op2,
        tiny_ids(),
        [(n, label.replace("LEFT", "LEFT BRICK"), motion) for n, label, motion in tiny_motions()],
    )
    tiny.run("ingest").ok()
    with h5py.File(tiny.build / "unit_loads.h5") as file:
        assert list(file["/area/name"].asstr()) == ["LEFT BRICK", "RIGHT"]
