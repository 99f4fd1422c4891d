"""Configuration: every problem of a file at once, by dotted path, and nothing unknown is passed over."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest
from border_tools import CONFIGS, Project, replace, tedm, untouched


def refuse(project: Project, command: str, *pieces: str, code: int = 3, hint: str = "") -> None:
    with untouched(project.folder):
        project.stage(command).refused(code, *pieces, hint=hint)


@pytest.mark.parametrize(
    ("old", "new", "piece"),
    [
        ("side_m = 0.046", "side_m = 0.046\nside_mm = 46.0", "test_mass[0].side_mm: unknown key; did you mean side_m?"),
        ("side_m = 0.046", "sid_m = 0.046", "test_mass[0].sid_m: unknown key; did you mean side_m, which is missing?"),
        ("[[test_mass]]", "[[testmass]]", "testmass: unknown key; did you mean test_mass?"),
        ("areas_csv", "area_csv", "model.area_csv: unknown key; did you mean areas_csv?"),
        (
            'group = "bricks", shield',
            'grup = "bricks", shield',
            "areas.rule[0].grup: unknown key; did you mean group, which",
        ),
        ("mass_kg = 1.96", 'mass_kg = "1.96"', "test_mass[0].mass_kg: must be a valid number (found '1.96')"),
        ("mass_kg = 1.96", "mass_kg = -1.96", "test_mass[0].mass_kg: mass -1.96 is outside 1e-18 to 1e+06 kg"),
        ("mass_kg = 1.96", "mass_kg = nan", "test_mass[0].mass_kg: must be a finite number"),
        ("mass_kg = 1.96", "mass_kg = true", "test_mass[0].mass_kg: must be a valid number (found True)"),
        ("[0.1, 0.2, 0.0]", "[0.1, 0.2]", "test_mass[0].position_m: must have at least 3 items, not 2 (found [0.1"),
        ("side_m = 0.046", "side_m = [0.1, 0.2]", "test_mass[0].side_m: must have at least 3 items, not 2 (found"),
        (
            "[areas]",
            '[areas]\ndefine = [{ name = "A", element = "" }]',
            "areas.define[0].element: must be an id, a range of ids such as '1:99', or a list of these (found '')",
        ),
        ("[0.1, 0.2, 0.0]", '[0.1, "0.2", 0.0]', "test_mass[0].position_m[1]: must be a valid number (found '0.2')"),
        (
            "side_m = 0.046",
            'side_m = "46"',
            "test_mass[0].side_m: must be a valid number or must be a valid list (found",
        ),
        ("side_m = 0.046", "side_m = [1, 2, -3]", "test_mass[0].side_m[2]: length -3 is outside 1e-09 to 10000 m"),
        (
            'shield = "inside"',
            'shield = "within"',
            "areas.rule[0].shield: must be 'inside' or 'outside' (found 'within')",
        ),
        ("[[test_mass]]", "[test_mass]", "test_mass: there may be several of these tables: write [[test_mass]], in"),
        ("[model]", "[[model]]", "model: there is one such table: write [model], in single brackets"),
        (
            'name = "TM1"',
            'name = "A B"',
            "test_mass[0].name: must be made of letters without accents and digits, a letter",
        ),
        ("side_m = 0.046", "", "test_mass[0].side_m: missing"),
        ("[areas]", "[areas", "not valid TOML"),
        ('op2 = ["unit_loads.op2"]', 'op2 = "unit_loads.op2"', "model.op2: must be a valid list"),
        (
            "[areas]",
            "[areas]\nsymmetry_plane = { normal = [0, 1, 0], point = [0, 0, 0], origin = 1 }",
            "areas.symmetry_plane.origin: unknown key; its table has point_m, normal",
        ),
        (
            "[areas]",
            "[areas]\nsymmetry_plane = { normal = [0, 1, 0], point = [0, 0, 0], origin = 1 }",
            "areas.symmetry_plane.point: unknown key; did you mean point_m, which is missing?",
        ),
        (
            'op2 = ["unit_loads.op2"]',
            'op2 = ["unit_loads.op2"]\nreference_temperature_K = -5.0',
            "model.reference_temperature_K: temperature -5 is outside 0 to 10000 K",
        ),
        ("side_m = 0.046", "side_m = 0.046\naxes = [[1,0,0],[0,1,0],[0,1,1]]", "test_mass[0].axes: "),
    ],
)
def test_model_file(tiny: Project, old: str, new: str, piece: str) -> None:
    replace(tiny.model, old, new)
    refuse(tiny, "ingest", "model.toml: " + piece)


def test_axes_to_ten_digits(tiny: Project) -> None:
    """What a drawing prints is a frame; the gravity room, which is strict, is given the nearest."""
    rows = "axes = [[0.8660254038, 0.5, 0.0], [-0.5, 0.8660254038, 0.0], [0.0, 0.0, 1.0]]"
    replace(tiny.model, "side_m = 0.046", f"side_m = 0.046\n{rows}")
    tiny.stage("ingest").ok()


def test_steps_of_a_degree_that_is_no_kelvin(tiny: Project) -> None:
    """A deck with steps of 1 K, of which the configuration says Fahrenheit: [D] would be too large by 1.8."""
    said = (
        'note: every step is 1 degF (0.556 K): are the temperatures of the deck in kelvin? then set temperature = "K"'
    )
    assert said not in tiny.stage("ingest").ok().out.splitlines()
    for scale in ("degC", "degF"):
        before = tiny.model.read_text(encoding="utf-8")
        replace(tiny.model, "[model]", f'[model]\ntemperature = "{scale}"')
        assert (said in tiny.stage("ingest").ok().out.splitlines()) == (scale == "degF")
        tiny.model.write_text(before, encoding="utf-8")


@pytest.mark.parametrize(("y", "misses"), [(5.0, True), (-0.001, True), (0.0, False), (0.05, False)])
def test_a_symmetry_plane_that_misses_the_model(tiny: Project, y: float, misses: bool) -> None:
    replace(
        tiny.model, "[areas]", f"[areas]\nsymmetry_plane = {{ point_m = [0.0, {y}, 0.0], normal = [0.0, 1.0, 0.0] }}"
    )
    for command in ("areas", "ingest"):
        said = [line for line in tiny.run(command).ok().out.splitlines() if "misses the thermal areas" in line]
        assert len(said) == misses
        if y == 5.0:
            assert "note: the symmetry plane (y = 5 m)" in said[0]
            assert "4.9 to 5 m off on its side -y: none has a mirror image" in said[0]


def test_all_problems_at_once(tiny: Project) -> None:
    replace(tiny.model, "side_m = 0.046", "side_mm = 46.0")
    replace(tiny.model, "mass_kg = 1.96", "mass_kg = 0")
    replace(tiny.model, 'op2 = ["unit_loads.op2"]', "op2 = []")
    outcome = tiny.run("ingest")
    outcome.refused(3, "did you mean side_m, which is missing?", "test_mass[0].mass_kg", "model.op2")
    assert len(outcome.err.splitlines()) == 3


def test_two_test_masses_of_one_name(tiny: Project) -> None:
    text = tiny.model.read_text()
    tiny.model.write_text(text + text[text.index("[[test_mass]]") :])
    refuse(tiny, "ingest", "TM1")


@pytest.mark.parametrize("contents", [b"\xff\xfe\x00", b"\x00", b"title = 'a'\ntitle = 'b'\n", b"= 1\n"])
def test_not_toml(tiny: Project, contents: bytes) -> None:
    (tiny.folder / "tedm.toml").write_bytes(contents)
    refuse(tiny, "ingest", "tedm.toml: not valid TOML")


@pytest.mark.parametrize(
    ("name", "hint"),
    [("tedm.toml", "--config"), ("model.toml", "that names no other: model")],
)
def test_missing_file(tiny: Project, name: str, hint: str) -> None:
    (tiny.folder / name).unlink()
    refuse(tiny, "ingest", name, code=4, hint=hint)


def test_empty_project_file(tiny: Project) -> None:
    (tiny.folder / "tedm.toml").write_text("")
    refuse(tiny, "ingest", "tedm.toml: title: missing")


def test_test_mass_inside_the_structure(small: Project) -> None:
    replace(small.model, "position_m = [-0.188, 0.0, 0.0]", "position_m = [-0.2, 0.0, 0.0]")
    refuse(small, "build-sensitivity", "TM1", "CHEXA ", code=5)


@pytest.mark.parametrize(("case", "near"), [("11", "1"), ("4c", "4"), ("3.0", "3")])
def test_a_case_that_is_not_there(small: Project, case: str, near: str) -> None:
    with untouched(small.folder):
        small.run("run-case", case).refused(2, "cases.toml", case, "1, 2, 3, 4, 4b, 5", hint=near)


def test_one_output_for_several_cases(small: Project) -> None:
    with untouched(small.folder):
        small.run("run-case", "3", "4", "-o", small.build / "x.h5").refused(2, "--output", "2 cases")


@pytest.mark.parametrize(
    ("arguments", "piece", "hint"),
    [
        (["ingset"], "ingset", "tedm --help"),
        (["ingest", "--bogus"], "--bogus", "tedm ingest --help"),
        (["ingest", "extra"], "extra", "tedm ingest --help"),
        (["ingest", "-c"], "-c", "--help"),
        (["run-case"], "CASE", "tedm run-case --help"),
        (["show"], "FILE", "tedm show --help"),
    ],
)
def test_usage(arguments: list[str], piece: str, hint: str) -> None:
    tedm(*arguments).refused(2, piece, hint=hint)


def test_write_deck_without_its_inputs(tiny: Project) -> None:
    replace(tiny.model, 'areas_csv = "areas.csv"\n', "")
    refuse(tiny, "write-deck", "model.areas_csv: needed to write a deck")


@pytest.mark.parametrize(
    ("old", "new", "piece"),
    [
        ("3,LEFT", "x3,LEFT", "areas.csv:4: wanted a grid id"),
        ("3,LEFT", "3,LEFT,1", "areas.csv:4: wanted a grid id"),
        ("3,LEFT", "3,2LEFT", "areas.csv:4: a name of an area must begin with a letter"),
        ("3,LEFT", "2,LEFT", "areas.csv:4: grid 2 is in line 3 already"),
        ("3,LEFT", "3,Left", "areas.csv:4: area 'Left' is also spelled 'LEFT'"),
        ("3,LEFT", "333,LEFT", "area 'LEFT' names 1 grids that do not exist: 333"),
        ("3,LEFT\n", "", "structural grids are in no thermal area: 3"),
        ("node_id,area", "id,area", "areas.csv:1: must begin with the header node_id,area"),
        ("RIGHT", "UNIFORM", "area 'UNIFORM' has the name of the uniform load"),
    ],
)
def test_areas_file(tiny: Project, old: str, new: str, piece: str) -> None:
    replace(tiny.folder / "areas.csv", old, new, count=99)
    refuse(tiny, "write-deck", piece, code=4)


def test_areas_file_of_a_spreadsheet(tiny: Project) -> None:
    """Byte order mark, CR LF and empty lines are no mistakes."""
    before = tiny.deck.read_bytes()
    text = (tiny.folder / "areas.csv").read_text()
    (tiny.folder / "areas.csv").write_bytes(b"\xef\xbb\xbf" + text.replace("\n", "\r\n").encode() + b"\r\n\r\n")
    tiny.run("write-deck").ok()
    assert tiny.deck.read_bytes() == before


def test_nothing_is_left_in_the_working_directory(
    tiny: Project, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """pyNastran dumps a file there when an INCLUDE is missing."""
    (tmp_path / "elsewhere").mkdir()
    monkeypatch.chdir(tmp_path / "elsewhere")
    shutil.copy(tiny.deck, tiny.folder / "copy.bdf")
    replace(tiny.deck, "SPC1,1", "INCLUDE 'gone.inc'\nSPC1,1")
    replace(tiny.folder / "model.bdf", "SPC1,1", "INCLUDE 'gone.inc'\nSPC1,1")
    for command in ("ingest", "write-deck", "solve"):
        tiny.run(command).refused(4, "gone.inc")
    assert not list(Path.cwd().iterdir())


@pytest.mark.parametrize(
    ("command", "key"),
    [
        (["ingest"], "model"),
        (["check-layout"], "optics"),
        (["run-case", "1"], "cases"),
        (["ingest"], "dynamics"),
        (["ingest"], "thermal"),
    ],
)
def test_a_file_that_the_project_names_is_not_there(tiny: Project, command: list[str], key: str) -> None:
    """It is the project file that is wrong, whichever file the command needs."""
    (tiny.folder / "tedm.toml").write_text(f'title = "t"\n{key} = "lost.toml"\n')
    outcome = tiny.run(*command)
    lost = tiny.folder / "lost.toml"
    outcome.refused(
        3, f"tedm.toml: {key}: names 'lost.toml', but there is no file {lost}", hint="relative to the project"
    )
    assert "--config" not in outcome.err
    assert ("leaves the key out" in outcome.err) == (key in ("optics", "dynamics", "thermal"))
    (tiny.folder / "tedm.toml").unlink()
    tiny.run(*command).refused(4, "tedm.toml: cannot read the configuration", hint="--config")


@pytest.mark.parametrize(
    ("text", "place", "code"),
    [
        ('title = "a\\u0000b"', "title", "U+0000"),
        ('title = "a\\u001b[2J"', "title", "U+001B"),
        ('title = "a\\u202eb"', "title", "U+202E"),
        ('title = "a"\nmodel = "m\\uffff.toml"', "model", "U+FFFF"),
        ('title = "a"\n"mo\\u0007del" = "m.toml"', "mo?del", "U+0007"),
        ('title = "a"\ncases = ["a", "b\\u0085"]', "cases[1]", "U+0085"),
    ],
)
def test_control_characters_are_refused_by_place(tiny: Project, text: str, place: str, code: str) -> None:
    (tiny.folder / "tedm.toml").write_text(text + "\n", encoding="utf-8")
    tiny.run("check-layout").refused(3, f"tedm.toml: {place}: ", f"the control character {code}")


def test_a_byte_order_mark_is_no_part_of_a_configuration(tiny: Project) -> None:
    """Editors write one; of UTF-16 it says what is wrong."""
    for path in tiny.folder.glob("*.toml"):
        path.write_bytes(b"\xef\xbb\xbf" + path.read_bytes())
    tiny.run("ingest").ok()
    tiny.model.write_text(tiny.model.read_text(encoding="utf-8-sig"), encoding="utf-16")
    tiny.run("ingest").refused(3, "model.toml: not valid TOML", hint="save it as UTF-8")


def test_titles_may_have_lines_and_tabs(tiny: Project) -> None:
    (tiny.folder / "tedm.toml").write_text(
        f'title = """two\n\tlines"""\noptics = "{CONFIGS / "optics.toml"}"\n', encoding="utf-8"
    )
    tiny.model.unlink()  # whose test mass is not that of the layout
    tiny.run("check-layout").ok()


@pytest.mark.parametrize("text", ["a = " + 3000 * "[", "a = " + 5000 * "9", "a = 1\na = 2", "\xff"])
def test_what_toml_readers_stumble_over_is_one_error(tiny: Project, text: str) -> None:
    (tiny.folder / "tedm.toml").write_bytes(text.encode("latin-1"))
    tiny.run("check-layout").refused(3, "tedm.toml: not valid TOML")
