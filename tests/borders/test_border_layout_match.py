"""The optical layout against the model: test masses, levers, and the symmetry plane that follows the layout's frame."""

from __future__ import annotations

import json
import os
import re
import shutil
from pathlib import Path

import numpy as np
import pytest
from border_tools import CONFIGS, SMALL, Project, replace, tedm, untouched

from tedm_cli.contracts import OPTICS
from tedm_cli.files.store import open_checked

FRAME = "origin_m = [0.0, 0.0, 0.0]\naxes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]"
TM1 = 'name = "TM1"\nposition_m = [-0.188, 0.0, 0.0]\nside_m = 0.046'


def mrad(angle: float) -> str:
    """Axes turned about z, as TOML."""
    c, s = float(np.cos(1e-3 * angle)), float(np.sin(1e-3 * angle))
    return f"[[{c!r}, {s!r}, 0.0], [{-s!r}, {c!r}, 0.0], [0.0, 0.0, 1.0]]"


@pytest.fixture
def alone(tmp_path: Path) -> Project:
    """The configurations of the small sample, and nothing else."""
    folder = tmp_path / "project"
    folder.mkdir()
    shutil.copy(SMALL / "model.toml", folder)
    shutil.copy(CONFIGS / "optics.toml", folder)
    (folder / "tedm.toml").write_text('title = "small sample"\n')
    return Project(folder)


#: file, what stands there, what is put there, and what is said of it
DIFFERENCES = {
    "centre": (
        "model.toml",
        "position_m = [-0.188, 0.0, 0.0]",
        "position_m = [-0.188, 0.0, 0.0002]",
        "element[0].ref_m: TM1 is at (-0.188, 0, 0) m of the basic frame, by model.toml (test_mass[0].position_m) at"
        " (-0.188, 0, 0.0002) m: 0.2 mm apart",
    ),
    "centre in the layout": (
        "optics.toml",
        "ref_m = [0.188, 0.0, 0.0]",
        "ref_m = [188.0, 0.0, 0.0]",
        "element[1].ref_m: TM2 is at (188, 0, 0) m of the basic frame, by model.toml (test_mass[1].position_m) at"
        " (0.188, 0, 0) m: 1.878e+05 mm apart",
    ),
    "edge": (
        "model.toml",
        "side_m = 0.046",
        "side_m = 0.05",
        "element[0].front_offset_m: the face of TM1 is 0.023 m from its centre; half of its edge along x is 0.025 m by"
        " model.toml (test_mass[0].side_m): 2 mm apart",
    ),
    "one edge": (
        "model.toml",
        "side_m = 0.046",
        "side_m = [0.0464, 0.046, 0.046]",
        "half of its edge along x is 0.0232 m",
    ),
    "face": (
        "optics.toml",
        "front_offset_m = 0.023",
        "front_offset_m = 0.0228",
        "the face of TM1 is 0.0228 m from its centre; half of its edge along x is 0.023 m",
    ),
    "axes": (
        "model.toml",
        TM1,
        f"{TM1}\naxes = {mrad(5.0)}",
        "element[0].axes: x, y, z of TM1 are along (1, 0, 0), (0, 1, 0), (0, 0, 1) of the basic frame, by model.toml"
        " (test_mass[0].axes) along (0.9999875, 0.004999979, 0), (-0.004999979, 0.9999875, 0), (0, 0, 1):"
        " 0.005 rad (0.286 deg) apart",
    ),
    "normal": (
        "optics.toml",
        "normal = [1.0, 0.0, 0.0]\nfront_offset_m = 0.023",
        "normal = [0.8, 0.6, 0.0]\nfront_offset_m = 0.023",
        "element[0].normal: the face of TM1 looks along (0.8, 0.6, 0) of the basic frame, 0.6435 rad (36.9 deg) off the"
        " nearest axis by model.toml (test_mass[0].axes), x: (1, 0, 0)",
    ),
    "name": (
        "model.toml",
        'name = "TM1"',
        'name = "TMA"',
        "element[0].name: model.toml has no test mass TM1; it has TMA, TM2; TMA is at its place",
    ),
}


@pytest.mark.parametrize("slip", DIFFERENCES)
def test_test_masses_that_differ(alone: Project, slip: str) -> None:
    name, old, new, fact = DIFFERENCES[slip]
    if name == "model.toml" and slip == "name":
        replace(alone.model, 'TM1 = ["IS1"]', 'TMA = ["IS1"]')
    if slip == "axes":
        replace(alone.model, 'name = "lpf"', 'name = "lpf"\napplies_to = "single"')  # no differences of unlike axes
    replace(alone.folder / name, old, new)
    with untouched(alone.folder):
        outcome = alone.run("check-layout")
    outcome.refused(3, "optics.toml: element[", fact, hint="correct optics.toml, in the frame")
    assert ("both are in metres" in outcome.err) == (slip not in ("axes", "normal", "name"))


@pytest.mark.parametrize("command", ["build-distortion", "build-optics"])
def test_stages_refuse_all_that_differs_at_once(small: Project, command: str) -> None:
    replace(small.model, TM1, 'name = "TM1"\nposition_m = [-0.187, 0.0, 0.0]\nside_m = 0.05')
    replace(small.folder / "optics.toml", "ref_m = [0.088, 0.096, 0.0]", "ref_m = [88.0, 96.0, 0.0]")
    if command == "build-optics":  # a beam that misses is told first
        replace(small.folder / "optics.toml", "ref_m = [88.0, 96.0, 0.0]", "ref_m = [0.088, 0.096, 0.0]")
    with untouched(small.folder):
        outcome = small.run(command)
    lever = ["element[3].ref_m: FIR is 130.1 m away from its grid 900002"] if command == "build-distortion" else []
    outcome.refused(3, "element[0].ref_m: TM1 is at", "element[0].front_offset_m: ", *lever)
    assert len(outcome.err.splitlines()) == 3 + len(lever)


@pytest.mark.parametrize(
    ("name", "old", "new", "note"),
    [
        (
            "model.toml",
            "position_m = [-0.188, 0.0, 0.0]",
            "position_m = [-0.188, 0.0, 0.00005]",
            "by model.toml (test_mass[0].position_m) at (-0.188, 0, 5e-05) m: 0.05 mm apart",
        ),
        ("model.toml", "side_m = 0.046", "side_m = 0.04601", "half of its edge along x is 0.023005 m"),
        ("model.toml", TM1, f"{TM1}\naxes = {mrad(0.05)}", "5e-05 rad (0.00286 deg) apart"),
        (
            "model.toml",
            "[[test_mass]]\nname = \"TM2\"\nposition_m = [0.188, 0.0, 0.0]\nside_m = 0.046\nmass_kg = 1.96\n",
            "",
            "element[1].name: model.toml has no test mass TM2; it has TM1; TM2 has read-outs here, but no self-gravity",
        ),
    ],
    ids=["centre", "edge", "axes", "one has no self-gravity"],
)  # fmt: skip
def test_what_is_odd_but_no_mistake(alone: Project, name: str, old: str, new: str, note: str) -> None:
    replace(alone.folder / name, old, new)
    if not new:
        replace(alone.model, ', TM2 = ["IS2"]', "")
        replace(alone.model, 'name = "lpf"', 'name = "lpf"\napplies_to = "single"')
    outcome = alone.run("check-layout").ok()
    warnings = [line for line in outcome.out.splitlines() if line.startswith("warning: ")]
    assert warnings
    assert note in warnings[0]
    assert json.loads(alone.run("check-layout", "--json").ok().out)["against_model"]["notes"]


def test_rounding_is_not_spoken_of(alone: Project) -> None:
    replace(alone.model, "position_m = [-0.188, 0.0, 0.0]", "position_m = [-0.1880005, 0.0, 0.0]")
    outcome = alone.run("check-layout").ok()
    assert "warning" not in outcome.out
    assert "test masses as in the model: TM1, TM2" in outcome.out
    shown = json.loads(alone.run("check-layout", "--json").ok().out)
    assert shown["against_model"] == {"problems": [], "notes": [], "deck": None}


def test_a_layout_may_be_there_before_the_model(alone: Project) -> None:
    replace(alone.model, "mass_kg = 1.96", 'mass_kg = "heavy"')
    assert "not compared with the test masses of the model: " in alone.run("check-layout").ok().out
    alone.model.unlink()
    assert "model.toml: no such file" in alone.run("check-layout").ok().out
    assert json.loads(alone.run("check-layout", "--json").ok().out)["against_model"] is None


# --- levers ---------------------------------------------------------------------------------------------------------


def moved(project: Project, x: float) -> None:
    """Layout frame and test masses together, away from the model."""
    replace(project.folder / "optics.toml", FRAME, FRAME.replace("[0.0,", f"[{x},", 1))
    for centre in (-0.188, 0.188):
        replace(project.model, f"position_m = [{centre}, 0.0, 0.0]", f"position_m = [{centre + x}, 0.0, 0.0]")


def test_a_bench_off_by_more_than_its_size(small: Project) -> None:
    moved(small, 1.0)
    for command in ("build-distortion", "build-optics"):
        with untouched(small.folder):
            outcome = small.run(command)
            outcome.refused(3, "element[2].ref_m: FIM is 1 m away from its grid 900001", hint="is 0.25 m across")
        assert len(outcome.err.splitlines()) == 22 + 1
        assert "all are off by about (1, 0, 0) m in the basic frame: is origin_m of [frame] right?" in outcome.err


def test_a_bench_off_by_less_is_spoken_of(small: Project) -> None:
    moved(small, 0.05)
    for command in ("build-distortion", "build-optics"):
        warnings = [line for line in small.run(command).ok().out.splitlines() if line.startswith("warning: ")]
        assert len(warnings) == 1
        assert "optics.toml: more than 20 mm away from the grid that carries it: " in warnings[0]
        assert " 50 mm (grid 9000" in warnings[0]
        assert " and 18 more; " in warnings[0]
        assert "off by about (0.05, 0, 0) m" in warnings[0]
    with open_checked(small.build / "optics.h5", OPTICS) as file:  # of which a report tells it
        (note,) = file.strings(OPTICS.NOTE)
    assert note.startswith("optics.toml: more than 20 mm away")
    assert f"/{note}" in warnings[0]


@pytest.mark.parametrize("x", [0.05, 1.0])
def test_levers_that_are_meant(small: Project, x: float) -> None:
    """By element, or by a tolerance for all of them: nothing is said, and nothing refused."""
    moved(small, x)
    layout = small.folder / "optics.toml"
    text = layout.read_text()
    layout.write_text(text.replace("grid = 9", "lever_ok = true\ngrid = 9"))
    assert "warning" not in small.run("build-distortion").ok().out
    layout.write_text(text.replace("[tolerances]", f"[tolerances]\nlever_m = {1.001 * x}"))
    assert "warning" not in small.run("build-distortion").ok().out
    layout.write_text(text.replace("grid = 900001", "lever_ok = true\ngrid = 900001"))
    outcome = small.run("build-distortion")
    said = outcome.err if x == 1.0 else outcome.out
    assert said
    assert "FIM" not in said


def test_a_test_mass_has_no_lever(alone: Project) -> None:
    replace(alone.folder / "optics.toml", 'kind = "test_mass"', 'kind = "test_mass"\nlever_ok = true')
    alone.run("check-layout").refused(3, "element[0].lever_ok: a test_mass (TM1) has no such key")


# --- the plane that follows the layout's frame ----------------------------------------------------------------------


def shifted_plane(project: Project) -> None:
    """The frame by 1 mm along y; the test masses stay where they are by their own coordinates."""
    layout = project.folder / "optics.toml"
    replace(layout, "origin_m = [0.0, 0.0, 0.0]", "origin_m = [0.0, 0.001, 0.0]")
    for x in (-0.188, 0.188):
        replace(project.model, f"position_m = [{x}, 0.0, 0.0]", f"position_m = [{x}, 0.001, 0.0]")


@pytest.mark.parametrize(("command", "file"), [("build-distortion", "unit_loads"), ("build-optics", "distortion")])
def test_sides_of_another_plane_are_stale(small: Project, command: str, file: str) -> None:
    shifted_plane(small)
    with untouched(small.folder):
        small.run(command).refused(
            4, f"{file}.h5: is stale: the sides of its areas are those of y = 0; the symmetry plane is y = 0.001 m now"
        )
    small.run("ingest").ok()
    small.run("build-distortion").ok()
    small.run("build-optics").ok()


def test_check_tells_of_the_plane_and_of_nothing_else(small: Project) -> None:
    def problems() -> dict[str, list[str]]:
        found = json.loads(tedm("check", "-d", small.build, "--json").out)
        return {Path(f["file"]).stem: f["problems"] for f in found}

    layout = small.folder / "optics.toml"
    replace(layout, "title = ", "title = 'other' # ")
    replace(layout, "origin_m = [0.0, 0.0, 0.0]", "origin_m = [0.0, 0.0, 0.5]")  # along the plane
    assert problems()["unit_loads"] == []
    replace(layout, "origin_m = [0.0, 0.0, 0.5]", "origin_m = [0.0, 0.01, 0.5]")
    (fact,) = problems()["unit_loads"]
    assert "its symmetry plane was y = 0; by " in fact
    assert fact.endswith("optics.toml it is y = 0.01 m now")
    layout.write_text("frame = 1\n")
    assert "gives the symmetry plane, cannot be read" in problems()["unit_loads"][0]
    layout.unlink()
    assert "gives the symmetry plane, is gone" in problems()["unit_loads"][0]


def test_a_configured_plane_does_not_follow_the_layout(small: Project) -> None:
    """It makes the same file but for where the plane is from, and the layout may do as it likes."""
    shifted_plane(small)
    small.run("build-sensitivity").refused(4, "distortion.h5: is stale: the sides of its areas are those of y = 0;")
    plane = "symmetry_plane = { point_m = [0.0, 0.0, 0.0], normal = [0.0, 1.0, 0.0] }"
    replace(small.model, "[areas]", f"[areas]\n{plane}")
    outcome = small.run("build-distortion").ok()
    assert "stale" not in outcome.err
    assert "symmetry plane: y = 0 in the basic frame ([areas] symmetry_plane)" in small.run("ingest").ok().out
    os.truncate(small.folder / "optics.toml", 0)
    found = json.loads(tedm("check", "-d", small.build, "--json").out)
    assert next(f for f in found if f["kind"] == "unit_loads")["problems"] == []


def test_areas_and_ingest_say_which_plane(small: Project) -> None:
    said = "symmetry plane: y = 0 in the basic frame (x-z plane of the layout frame in optics.toml)"
    shutil.copy(SMALL / "ltp_small.bdf", small.folder)
    for command in ("areas", "ingest"):
        assert said in small.run(command).ok().out.splitlines()
    shown = json.loads(small.run("areas", "--json").ok().out)["symmetry_plane"]
    assert shown == {"point_m": [0.0, 0.0, 0.0], "normal": [0.0, 1.0, 0.0], "origin": "layout"}
    (small.folder / "optics.toml").unlink()
    assert "symmetry plane: y = 0 in the basic frame (the default without a layout)" in small.run("areas").out


@pytest.mark.parametrize("command", ["check-layout", "write-deck", "solve"])
def test_grids_are_looked_for_before_anything_is_solved(small: Project, command: str) -> None:
    """A slip in a grid, and an element 97 m away from its own; build-distortion, after hours, would say the same."""
    if command == "write-deck":
        shutil.copy(SMALL / "ltp_small.bdf", small.folder)
    replace(small.folder / "optics.toml", "grid = 900001", "grid = 990001")
    if command != "check-layout":  # a beam that misses is told first
        replace(small.folder / "optics.toml", "ref_m = [0.088, 0.096, 0.0]", "ref_m = [97.0, 0.096, 0.0]")
    with untouched(small.folder):
        outcome = small.run(command)
        outcome.refused(
            3,
            "optics.toml: element[2].grid: the model has no grid 990001, which is to carry FIM; the grid nearest to FIM"
            " is 900001, ",
            hint="add the grids to the model",
        )
    assert ("element[3].ref_m: FIR is 96.91 m away from its grid 900002" in outcome.err) == (command != "check-layout")


def test_grids_of_another_model_are_one_error(small: Project) -> None:
    text = (small.folder / "optics.toml").read_text().replace("grid = 9000", "grid = 7000")
    (small.folder / "optics.toml").write_text(text)
    outcome = small.run("check-layout")
    outcome.refused(
        3, "element: the model lacks ", " grids that elements name: 700001 of FIM, 700002 of FIR, ", " more"
    )
    assert outcome.err.count("error:") == 1


def test_a_layout_without_grids_yet_keeps_no_model_from_being_solved(small: Project) -> None:
    """The deck can be written, and run elsewhere; the matrices need the grids."""
    shutil.copy(SMALL / "ltp_small.bdf", small.folder)
    replace(small.folder / "optics.toml", "grid = 900001\n", "")
    small.run("write-deck").ok()
    assert "no grid yet" in small.run("check-layout").ok().out
    small.run("build-distortion").refused(3, "element[2]")


def test_what_grids_were_compared_with_is_said(small: Project) -> None:
    assert f"grids of 22 elements are in {small.deck.name}, near their elements" in small.run("check-layout").ok().out
    small.deck.write_text("nonsense\n")
    assert "not compared with the grids of the model: " in small.run("check-layout").ok().out
    small.deck.unlink()
    missing = small.folder / "ltp_small.bdf"
    assert f"not compared with the grids of the model: {missing}: no such file" in small.run("check-layout").ok().out


def test_problems_name_the_entry_and_its_line(small: Project) -> None:
    """Paths count from zero, and files have hundreds of lines; what the fact names already is not told twice."""
    replace(small.folder / "optics.toml", "front_offset_m = 0.023", "front_ofset_m = 0.023")
    replace(small.folder / "optics.toml", "grid = 900002", "grid = -4")
    rows = (small.folder / "optics.toml").read_text().splitlines()
    line = {name: rows.index(f'name = "{name}"') + 1 for name in ("TM1", "FIR")}
    outcome = small.run("check-layout")
    outcome.refused(3, f"did you mean front_offset_m? (TM1, line {line['TM1']})")
    assert re.search(rf"element\[3\]\.grid: .* \(FIR, line {line['FIR']}\)$", outcome.err, re.MULTILINE)
    replace(small.folder / "optics.toml", "grid = -4", "grid = 990002")
    replace(small.folder / "optics.toml", "front_ofset_m = 0.023", "front_offset_m = 0.023")
    outcome = small.run("check-layout")
    assert re.search(rf"which is to carry FIR; .* \(line {line['FIR']}\)$", outcome.err, re.MULTILINE)
