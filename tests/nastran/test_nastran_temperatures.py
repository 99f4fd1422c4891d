"""The temperature step of a unit load is read from its cards, against the temperature of no strain."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from rod_model import read, write_deck

from tedm_cli.errors import InputError
from tedm_cli.nastran.loads.temperatures import Field, step
from tedm_cli.nastran.loads.unit_loads import UnitLoads, deck_unit_loads

GRIDS = [(i, 0, (0.1 * i, 0.01 * i, 0.0), 0) for i in range(1, 7)]
TWO = "SUBCASE 1\n LABEL = A\n {key} = 1\nSUBCASE 2\n LABEL = B\n {key} = 2"
LOADS = "TEMP,1,1,{w},2,{w},3,{w}\nTEMPD,1,{c}\nTEMP,2,4,{w},5,{w}\nTEMP,2,6,{w}\nTEMPD,2,{c}"


def loads(folder: Path, cards: str, control: str = "", key: str = "TEMPERATURE(LOAD)", tref: str = "") -> UnitLoads:
    path = write_deck(folder / "deck.bdf", GRIDS, cards, f"{control}\n{TWO.format(key=key)}".strip())
    if tref:
        path.write_text(path.read_text().replace("2700.,2.-5", f"2700.,2.-5,{tref}"))
    return deck_unit_loads(*read(path), "UNIFORM")


def check(found: UnitLoads, step: float) -> None:
    assert [list(a.rows) for a in found.areas] == [[0, 1, 2], [3, 4, 5]]
    assert [a.load_K for a in found.areas] == pytest.approx([step, step], rel=1e-9, abs=0)


@pytest.mark.parametrize(("warm", "cold", "step"), [(1.0, 0.0, 1.0), (294.15, 293.15, 1.0), (18.5, 20.0, -1.5)])
def test_step_above_tref(tmp_path: Path, warm: float, cold: float, step: float) -> None:
    """TEMP cards may be many; rounding of eight digits is no step."""
    check(loads(tmp_path, LOADS.format(w=warm, c=cold), tref=f"{cold}"), step)


@pytest.mark.parametrize(
    ("warm", "cold", "step"),
    [
        ("293.02", "293.", 0.02),
        ("293.17", "293.15", 0.02),
        ("1293.153", "1293.152", 0.001),  # what eight columns make of 0.0006 K is what the solver applies
        ("273.1501", "273.15", 1e-4),
        ("-.02", "0.", -0.02),
        ("300.", "299.99999", 1e-5),
    ],
)
def test_the_step_is_that_of_the_decimals_on_the_cards(tmp_path: Path, warm: str, cold: str, step: float) -> None:
    """To the last digit, where the difference of doubles has lost five of them."""
    found = loads(tmp_path, LOADS.format(w=warm, c=cold), tref=cold)
    assert [a.load_K for a in found.areas] == [step, step]


def test_grids_without_temperature_leave_the_others_their_digits() -> None:
    none = np.zeros(0)
    load, initial = Field(np.array([1]), np.array([293.02]), np.nan), Field(none.astype(int), none, 293.0)
    np.testing.assert_array_equal(step(load, initial, np.array([1, 2])), [0.02, np.nan])


def test_a_step_that_single_precision_does_not_hold(tmp_path: Path) -> None:
    """Four bytes hold all of 293 K, and of 293.02 K 293.019989013671875: the step is 0.055 % too small."""
    (first, _) = loads(tmp_path, LOADS.format(w="293.02", c="293."), tref="293.").areas
    assert first.single_error == pytest.approx(1.0 - 0.019989013671875 / 0.02, abs=1e-9)
    (first, _) = loads(tmp_path, LOADS.format(w="294.15", c="293.15"), tref="293.15").areas
    assert first.single_error == 0.0  # both are off by the same
    (first, _) = loads(tmp_path, LOADS.format(w="0.02", c="0."), tref="0.").areas
    assert first.single_error < 2.0**-24


def test_step_above_the_initial_temperature(tmp_path: Path) -> None:
    """TEMPERATURE(INITIAL) goes before TREF, which is 99 K and of no account; TEMP in it goes before TEMPD."""
    cards = LOADS.format(w=22.0, c=20.0) + "\nTEMPD,7,20."
    check(loads(tmp_path, cards, "TEMPERATURE(INITIAL) = 7", tref="99."), 2.0)
    uneven = cards + "\nTEMP,7,2,21."
    with pytest.raises(InputError, match=r"'A'.*by 1 to 2 K"):
        loads(tmp_path, uneven, "TEMP(INIT) = 7")


def test_initial_temperature_that_differs_from_grid_to_grid(tmp_path: Path) -> None:
    """What counts is the step, not the temperatures."""
    initial = "TEMPD,7,20.\nTEMP,7,2,30.\nTEMP,7,5,40."
    cards = "TEMPD,1,20.\nTEMP,1,1,21.,2,31.,3,21.\nTEMP,1,5,40.\nTEMPD,2,20.\nTEMP,2,4,21.,5,41.,6,21.\nTEMP,2,2,30."
    check(loads(tmp_path, f"{initial}\n{cards}", "TEMPERATURE(INITIAL) = 7"), 1.0)


def test_the_uniform_load_may_be_a_default_temperature(tmp_path: Path) -> None:
    text = TWO.format(key="TEMPERATURE(LOAD)") + "\nSUBCASE 3\n LABEL = UNIFORM\n TEMPERATURE(LOAD) = 3"
    path = write_deck(tmp_path / "deck.bdf", GRIDS, LOADS.format(w=1.0, c=0.0) + "\nTEMPD,3,1.", text)
    found = deck_unit_loads(*read(path), "UNIFORM")
    check(found, 1.0)
    assert found.uniform is not None
    assert list(found.uniform.rows) == list(range(6))


MATT = "\nMATT1,99,5\nTABLEM1,5\n,0.,7.+10,100.,6.+10,ENDT"
PLAIN = LOADS.format(w=1.0, c=0.0)


@pytest.mark.parametrize(
    "key", ["TEMPERATURE", "TEMPERATURE(BOTH)", "TEMP(BOTH)", "TEMP", "temp ( load )", "TEMP(LOAD)"]
)
def test_ways_to_select_a_load(tmp_path: Path, key: str) -> None:
    check(loads(tmp_path, PLAIN, key=key), 1.0)


def test_properties_that_depend_on_temperature(tmp_path: Path) -> None:
    """They stay as they are under TEMPERATURE(LOAD); MATERIAL, and BOTH with it, evaluates them anew."""
    check(loads(tmp_path, PLAIN + MATT), 1.0)
    check(loads(tmp_path, PLAIN, "TEMPERATURE(MATERIAL) = 2"), 1.0)
    for control, key in (("", "TEMPERATURE"), ("", "TEMPERATURE(BOTH)"), ("TEMP(MATE) = 2", "TEMPERATURE(LOAD)")):
        with pytest.raises(InputError, match="MATT1 99 depends on temperature"):
            loads(tmp_path, PLAIN + MATT, control, key)


SECOND = "\nCROD,80,98,1,6\nPROD,98,98,1.-4\nMAT1,98,7.+10,,.3,2700.,{a},{tref}"
REFUSED = {
    "rest off TREF": (
        LOADS.format(w=21.0, c=20.0),
        "",
        r"'A'.*rests at 20 K \(TEMPD\), but the materials' TREF is 0 K",
    ),
    "rest off INITIAL": (PLAIN + "\nTEMPD,7,-3.", "TEMPERATURE(INITIAL) = 7", r"rests at 0 K.*INITIAL\) is -3 K"),
    "two TREF": (PLAIN + SECOND.format(a="1.-5", tref="20."), "", r"TREF differ: 0 K \(MAT1 99\), 20 K \(MAT1 98\)"),
    "no TEMPD": ("TEMP,1,1,1.,2,1.\nTEMP,2,3,1.", "", r"'A'.*4 structural grids have no temperature: 3, 4, 5, 6"),
    "INITIAL without TEMPD": (PLAIN + "\nTEMP,7,1,0.", "TEMPERATURE(INITIAL) = 7", "5 structural grids have no temp"),
    "two temperatures": (PLAIN + "\nTEMP,1,2,3.", "", r"'A'.*set 1 gives grid 2 both 1 and 3"),
    "two loads": (PLAIN, "TEMPERATURE = 2", "selects two temperature sets as loads: 1, 2"),
    "everything cold": (LOADS.format(w=0.0, c=0.0), "", r"'A'.*warms nothing \(temperature set 1\)"),
    "enforced displacement": (PLAIN + "\nSPC,5,1,1,1.-3", "SPC = 5", "SPC 5 enforces a displacement"),
    "matrix load": (PLAIN, "P2G = LOADS", "subcase 1: P2G = .*LOADS"),
    "heat transfer": (PLAIN, "ANALYSIS = HEAT", r"subcase 1 \(ANALYSIS = HEAT\).*temperatures, not displacements"),
    "heat in SOL 101": (PLAIN + "\nPARAM,HEATSTAT,YES", "", "PARAM,HEATSTAT asks for heat transfer"),
    "laminate": (
        PLAIN + "\nCTRIA3,70,70,1,2,3\nPCOMP,70,,,,,20.\n,98,1.-3,0.,NO\nMAT1,98,7.+10,,.3,2700.,1.-5,0.",
        "",
        r"TREF differ: 0 K \(MAT1 99\), 20 K \(PCOMP 70\)",
    ),
}


@pytest.mark.parametrize("name", REFUSED)
def test_refused(tmp_path: Path, name: str) -> None:
    cards, control, fact = REFUSED[name]
    with pytest.raises(InputError, match=fact):
        loads(tmp_path, cards, control)


def test_a_material_that_does_not_expand_has_no_say(tmp_path: Path) -> None:
    check(loads(tmp_path, PLAIN + SECOND.format(a="", tref="20.")), 1.0)
    check(
        loads(tmp_path, PLAIN + SECOND.format(a="1.-5", tref="20.") + "\nTEMPD,7,0.", "TEMPERATURE(INITIAL) = 7"), 1.0
    )


def test_temperatures_of_elements_are_no_step_of_grids(tmp_path: Path) -> None:
    """In a set that a subcase selects; another set is nobody's."""
    check(loads(tmp_path, f"{PLAIN}\nTEMPRB,7,90001,1.,1."), 1.0)
    with pytest.raises(InputError, match=r"'A'.*whose temperature is their own in another area.*: 90001"):
        loads(tmp_path, f"{PLAIN}\nTEMPRB,2,90001,1.,1.")


@pytest.mark.parametrize("card", ["TEMPP3,1,1", "TEMPN1,1,1,,1.", "TEMPADD,1,2", "TEMPB3,1,1,1."])
def test_temperatures_of_other_kinds_are_named(tmp_path: Path, card: str) -> None:
    with pytest.raises(InputError, match=rf"deck.bdf:\d+: {card.split(',')[0]} card: "):
        loads(tmp_path, f"{PLAIN}\n{card}")


@pytest.mark.parametrize("control", ["SUPER = 1", "BEGIN SUPER = 1"])
def test_superelements_are_named(tmp_path: Path, control: str) -> None:
    with pytest.raises(InputError, match="superelements are not read"):
        loads(tmp_path, PLAIN, control)


def test_an_include_given_twice(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """pyNastran would leave a file behind in the working folder."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "more.inc").write_text("TEMPD,8,0.\n")
    with pytest.raises(InputError, match=r"read already: .*more\.inc"):
        loads(tmp_path, f"{PLAIN}\nINCLUDE 'more.inc'\nINCLUDE 'more.inc'")
    assert {p.name for p in tmp_path.iterdir()} == {"more.inc", "deck.bdf"}


def test_nothing_is_printed(
    tmp_path: Path, capfd: pytest.CaptureFixture[str], recwarn: pytest.WarningsRecorder
) -> None:
    loads(tmp_path, PLAIN + "\nCONM2,60,3,0,1.5")
    for twice in ("GRID,1,,5.,5.,5.", "CROD,90001,99,3,3"):
        with pytest.raises(InputError, match="the number is given twice"):
            loads(tmp_path, f"{PLAIN}\n{twice}")
    assert capfd.readouterr() == ("", "")
    assert not recwarn.list
