"""Every card that is read, in four systems of units: what follows from it is the same in SI.

The numbers of the cards are given in SI with their dimension, by hand from the Nastran Quick Reference Guide, and
written in each system.
"""

from __future__ import annotations

import re
from dataclasses import fields, is_dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from plate_instrument import SYSTEMS, real

from tedm_cli import deck_units
from tedm_cli.deck_units import SI, DeckUnits
from tedm_cli.errors import InputError
from tedm_cli.fem import structure as fem_structure
from tedm_cli.nastran.geometry import ModelGeometry, model_geometry
from tedm_cli.nastran.masses.audit import check_sample, weight_table
from tedm_cli.nastran.masses.concentrated import Concentrated
from tedm_cli.nastran.masses.elements import Elements
from tedm_cli.nastran.membership import membership
from tedm_cli.nastran.reading import read_deck
from tedm_cli.nastran.structure.deck import read_solver_deck
from tedm_cli.nastran.units import DIMENSIONS
from tedm_cli.stages.model.masses import properties_of

# Exponents of length, mass, time and temperature, of the letters behind the numbers of the cards.
TAGS = {
    "L": (1, 0, 0, 0),
    "A": (2, 0, 0, 0),
    "I": (4, 0, 0, 0),
    "E": (-1, 1, -2, 0),
    "rho": (-3, 1, 0, 0),
    "m": (0, 1, 0, 0),
    "mL": (-1, 1, 0, 0),
    "mA": (-2, 1, 0, 0),
    "S": (1, 1, 0, 0),
    "J": (2, 1, 0, 0),
    "a": (0, 0, 0, -1),
    "T": (0, 0, 0, 1),
}
UNITS = {name: DeckUnits(length, mass, 1.0) for name, (length, mass) in SYSTEMS.items()}
UNITS["in-lbf-s, degF"] = DeckUnits(*SYSTEMS["in-lbf-s"], 1.0, "degF")
UNITS["cm-g-ms"] = DeckUnits(0.01, 0.001, 0.001)
OTHERS = [name for name in UNITS if name != "m-kg-s"]


def written(text: str, units: DeckUnits) -> str:
    """The cards with their tagged numbers in a system of units; temperatures from the zero of their scale."""
    base = (units.length_m, units.mass_kg, units.time_s, 1.0 / 1.8 if units.temperature == "degF" else 1.0)

    def number(match: re.Match[str]) -> str:
        value = float(match[1])
        for unit, exponent in zip(base, TAGS[match[2]], strict=True):
            value /= unit**exponent
        return real(value)

    return re.sub(r"<(\S+) (\w+)>", number, text)


FRAMES = """
CORD2R,7,,<1. L>,<.1 L>,<0. L>,<1. L>,<.1 L>,<1. L>
,<1. L>,<1. L>,<.2 L>
CORD2C,8,7,<.1 L>,<0. L>,<.2 L>,<.1 L>,<.3 L>,<1. L>
,<1. L>,<0. L>,<.1 L>
CORD2S,9,8,<.5 L>,30.,<.1 L>,<.7 L>,75.,<.9 L>
,<.9 L>,-40.,<.1 L>
CORD1R,10,1,2,4
"""
CORNERS = """
GRID,1,,<0. L>,<0. L>,<0. L>
GRID,2,,<.2 L>,<0. L>,<0. L>
GRID,3,,<.2 L>,<.1 L>,<0. L>
GRID,4,,<0. L>,<.1 L>,<0. L>
GRID,5,,<0. L>,<0. L>,<.3 L>
GRID,6,,<.2 L>,<0. L>,<.3 L>
GRID,7,,<.2 L>,<.1 L>,<.3 L>
GRID,8,,<0. L>,<.1 L>,<.3 L>
GRID,21,8,<.2 L>,95.,<.1 L>,8
GRID,22,9,<.3 L>,40.,-70.,9
GRID,23,7,<.1 L>,<.2 L>,<.3 L>,10
GRID,24,10,<.1 L>,<.2 L>,<.3 L>
"""
MATERIALS = """
MAT1,1,<7.e10 E>,,.33,<2700. rho>,<2.3e-5 a>,<20. T>
MAT9,9,<11.e9 E>,<2.e9 E>,<1.e9 E>,,,,<12.e9 E>
,<3.e9 E>,,,,<13.e9 E>
,<4.e9 E>,,,<5.e9 E>,,<6.e9 E>,<2800. rho>,<1.e-6 a>
,<2.e-6 a>,<3.e-6 a>,<4.e-6 a>,<5.e-6 a>,<6.e-6 a>,<20. T>
MAT11,11,<1.4e11 E>,<1.e10 E>,<9.e9 E>,.3,.28,.4,<5.e9 E>
,<4.5e9 E>,<3.5e9 E>,<1600. rho>,<-1.e-6 a>,<3.e-5 a>,<2.e-5 a>,<20. T>
"""
# What both the masses and the embedded solver read.
COMMON = """
CHEXA,101,101,1,2,3,4,5,6
,7,8
CPENTA,102,102,1,2,4,5,6,8
CTETRA,103,103,1,2,3,5
PSOLID,101,1
PSOLID,102,9,7
PSOLID,103,11,10
CQUAD4,104,104,1,2,3,4,,<.004 L>
,,,<.002 L>,<.002 L>,<.002 L>,<.002 L>
CTRIA3,105,104,6,7,8,,<-.003 L>
,,1,1.5,1.5,1.5
PSHELL,104,1,<.003 L>,1,2.,1,.8,<3. mA>
CBAR,106,106,1,21,1.,0.,.5,GGG
,5,16,<.01 L>,<0. L>,<.02 L>,<.003 L>,<.001 L>,<-.004 L>
PBAR,106,1,<1.e-4 A>,<2.e-9 I>,<1.e-9 I>,<4.e-9 I>,<.5 mL>
,,,,,,,,
,,,<.4e-9 I>
CBAR,107,107,2,22,1.,.2,0.
PBARL,107,1,,BOX
,<.04 L>,<.03 L>,<.002 L>,<.003 L>,<.4 mL>
CBEAM,108,108,3,23,0.,0.,1.
PBEAM,108,1,<2.e-4 A>,<3.e-9 I>,<4.e-9 I>,,<5.e-9 I>,<.3 mL>
CBEAM,109,109,4,24,1.,0.,1.
PBEAML,109,1,,TUBE
,<.01 L>,<.008 L>,<.2 mL>
CROD,110,110,5,21
PROD,110,1,<1.e-4 A>,<2.e-9 I>,<.01 L>,<.6 mL>
CONROD,111,6,22,1,<3.e-4 A>,<1.e-9 I>,,<.7 mL>
CTUBE,112,112,7,23
PTUBE,112,1,<.02 L>,<.002 L>,<.1 mL>
CONM2,201,5,8,<1.5 m>,<.01 L>,<.02 L>,<.03 L>
,<3.e-3 J>,<1.e-4 J>,<4.e-3 J>,<2.e-4 J>,<1.e-4 J>,<5.e-3 J>
CONM2,202,6,-1,<.5 m>,<.21 L>,<.02 L>,<.33 L>
CONM1,203,21,8,<2. m>,,<2. m>,,
,<2. m>,,<-.06 S>,<.04 S>,<9.e-3 J>,<.06 S>,,<-.02 S>
,,<8.e-3 J>,<-.04 S>,<.02 S>,,,,<7.e-3 J>
PMASS,14,<.25 m>
CMASS1,211,14,7,1
CMASS1,212,14,7,2
CMASS1,213,14,7,3
CMASS2,214,<.125 m>,8,1
CMASS2,215,<.125 m>,8,2
CMASS2,216,<.125 m>,8,3
NSM,31,PSHELL,104,<2.5 mA>
NSM1,32,PBAR,<.15 mL>,106
NSML,33,PROD,110,<.05 m>
NSML1,34,ELEMENT,<.07 m>,104,105
NSMADD,30,31,32,33,34
"""
MASSES = """
MAT8,8,<7.e10 E>,<6.e10 E>,.3,<3.e10 E>,<3.e10 E>,<3.e10 E>,<1600. rho>
,<1.e-6 a>,<2.e-5 a>,<20. T>
CPYRAM,301,101,1,2,3,4,5
CQUAD8,302,302,1,2,3,4
PCOMP,302,<-.001 L>,<1.2 mA>
,8,<.001 L>,0.,,8,<.002 L>,90.
CQUADR,303,303,5,6,7,8
PCOMPG,303,<.002 L>,<.6 mA>
,11,8,<.004 L>
CSHEAR,304,304,5,6,7,8
PSHEAR,304,1,<.002 L>,<1.1 mA>
CBEAM,305,305,1,7,0.,1.,0.
PBEAM,305,1,<1.e-4 A>,<1.e-9 I>,<1.e-9 I>,,<2.e-9 I>,<.5 mL>
,,,,,,,,
,YES,1.,<3.e-4 A>,<1.e-9 I>,<1.e-9 I>,,<2.e-9 I>,<.7 mL>
,,,,,,,,
,,,,,,,,
,<.004 L>,<-.001 L>,<.003 L>,<-.002 L>,<.001 L>,<.002 L>,<.001 L>,<.002 L>
CBEAM,306,306,2,8,0.,1.,0.
PBCOMP,306,1,<1.e-4 A>,<1.e-9 I>,<1.e-9 I>,,<2.e-9 I>,<.5 mL>
,,,<.003 L>,<-.001 L>,<.002 L>,<.001 L>,0
CBUSH,307,307,1,2,,,,0
PBUSH,307,K,1.
,,M,<.35 m>
CELAS1,308,308,1,1,2,1
PELAS,308,1.
"""
SOLVED = """
RBAR,401,1,24,,123456,123
RBE3,402,,22,123456,1.,123,5,6
,2.,123,7
MPC,3,21,1,2.,4,5,<-.03 L>
,,6,6,<.02 L>,7,3,1.
SPC1,9,123456,1,2
TEMPD,1,<21. T>
TEMP,1,3,<24. T>
TEMPD,2,<20. T>
PARAM,K6ROT,50.
"""
CONTROL = """SOL 101
CEND
NSM = 30
SPC = 9
MPC = 3
TEMPERATURE(INITIAL) = 2
SUBCASE 1
  LABEL = ALL
  TEMPERATURE(LOAD) = 1
BEGIN BULK
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("cards")


def deck(folder: Path, cards: str, name: str, units: DeckUnits) -> Path:
    path = folder / f"{name}.bdf"
    text = written(FRAMES + CORNERS + MATERIALS + COMMON + cards, units)
    path.write_text(CONTROL + "\n".join(line for line in text.splitlines() if line) + "\nENDDATA\n", encoding="ascii")
    return path


@pytest.fixture(scope="module")
def geometry(folder: Path) -> Any:
    @cache
    def read(name: str) -> tuple[ModelGeometry, Any]:
        path = deck(folder, MASSES + SOLVED, f"masses {name}", UNITS[name])
        model = read_deck(path, units=UNITS[name])
        return model_geometry(model, [path]), model

    return read


def agree(wanted: Any, found: Any, at: str = "") -> int:
    """Compare two trees of dataclasses; the number of arrays compared."""
    if is_dataclass(wanted):
        pairs = [(getattr(wanted, f.name), getattr(found, f.name), f"{at}.{f.name}") for f in fields(wanted)]
        return sum(agree(*pair) for pair in pairs)
    if isinstance(wanted, tuple | list | dict):
        assert isinstance(found, type(wanted))
        keys = wanted if isinstance(wanted, dict) else range(len(wanted))
        assert len(wanted) == len(found), at
        return sum(agree(wanted[k], found[k], f"{at}[{k}]") for k in keys)
    if isinstance(wanted, np.ndarray) and wanted.dtype.kind == "f":
        scale = float(np.abs(wanted[np.isfinite(wanted)]).max(initial=0.0))
        np.testing.assert_allclose(found, wanted, rtol=1e-11, atol=1e-13 * scale, err_msg=at)
        return 1
    if isinstance(wanted, np.ndarray):
        np.testing.assert_array_equal(found, wanted, err_msg=at)
    elif not isinstance(wanted, Path | DeckUnits):
        assert wanted == found, at
    return 0


@pytest.mark.parametrize("name", OTHERS)
def test_geometry_and_masses(geometry: Any, name: str) -> None:
    wanted, _ = geometry("m-kg-s")
    found, model = geometry(name)
    assert found.units == UNITS[name]
    for attribute in ("position_m", "elements", "concentrated", "lumped_kg", "frames"):
        assert agree(getattr(wanted, attribute), getattr(found, attribute), attribute)
    ours, theirs = properties_of(found), properties_of(wanted)
    assert ours.mass_kg == pytest.approx(theirs.mass_kg, rel=1e-12)
    np.testing.assert_allclose(ours.inertia_kg_m2, theirs.inertia_kg_m2, rtol=0, atol=1e-11)
    assert check_sample(model, found).largest == pytest.approx(
        check_sample(*geometry("m-kg-s")[::-1]).largest, abs=1e-9
    )
    assert agree(membership(geometry("m-kg-s")[1], wanted, positions=True), membership(model, found, positions=True))


def test_every_kind_of_mass_is_there(geometry: Any) -> None:
    """Or the comparisons above would be of nothing."""
    g, _ = geometry("m-kg-s")
    massless = [c for c, kg in zip(g.elements.type, g.elements.mass_kg, strict=True) if kg <= 0.0]
    assert massless == ["CELAS1"]
    assert set(g.concentrated.card) == {"CONM1", "CONM2", "CMASS"}
    assert (g.concentrated.lever != 0.0).any(axis=1).sum() == 3
    assert np.abs(g.elements.lever).max(axis=1).astype(bool).sum() > 8
    assert (g.elements.added_kg > 0.0).sum() == 4


@pytest.mark.parametrize("name", OTHERS)
def test_what_the_embedded_solver_solves(folder: Path, name: str) -> None:
    (wanted, cases), (found, others) = (
        read_solver_deck(deck(folder, SOLVED, f"solved {n}", UNITS[n]), UNITS[n]) for n in ("m-kg-s", name)
    )
    assert agree(wanted, found, "structure") > 30
    assert agree(cases, others, "cases") == 1
    (equation,) = wanted.mpc
    assert equation.coefficients.tolist() == [2.0, -0.03, 0.02, 1.0]


def test_every_field_has_a_dimension() -> None:
    """A class or a field that is new is an error as soon as a deck is read, in SI too."""
    for kind, dimensions in DIMENSIONS.items():
        assert {f.name for f in fields(kind)} == dimensions.keys(), kind
    read = {c.__name__ for c in vars(fem_structure).values() if isinstance(c, type) and is_dataclass(c)}
    # of whole numbers, ratios and names, or converted with the structure or load case that holds them
    rest = {"SolidBlock", "Rbe2", "Rbe3", "Mpc", "OnFreedoms", "DirectStiffness"}
    assert read | {"Elements", "Concentrated"} == {c.__name__ for c in DIMENSIONS} | rest
    assert {Elements, Concentrated} < DIMENSIONS.keys()


def test_a_grid_point_weight_table_is_in_the_units_of_its_deck(mini_ltp_dir: Path) -> None:
    path = mini_ltp_dir / "mini_ltp.op2"
    plain = weight_table(path, lambda grid: np.zeros(3))
    scaled = weight_table(path, lambda grid: np.zeros(3), UNITS["mm-t-s"])
    assert plain is not None
    assert scaled is not None
    np.testing.assert_allclose(scaled.mass, 1e3 * plain.mass, rtol=1e-12)
    np.testing.assert_allclose(scaled.centre, 1e-3 * plain.centre, rtol=1e-12)
    np.testing.assert_allclose(scaled.inertia, 1e-3 * plain.inertia, rtol=1e-12)


def test_mass_of_in_lbf_s() -> None:
    """One pound-force gives it an inch per second squared; gravity there is the well-known 386.09 in/s2."""
    units = UNITS["in-lbf-s"]
    assert units.mass_kg * units.length_m == pytest.approx(4.4482216152605, rel=1e-14)
    assert units.gravity == pytest.approx(386.0886, rel=1e-6)
    assert units.factor(deck_units.STRESS) == pytest.approx(6894.757293168, rel=1e-12)  # psi


@pytest.mark.parametrize(
    ("card", "fact"),
    [
        ("PSHELL,19,1,150.", "a thickness of 150 m is larger than any model"),
        ("PROD,19,1,150.", "a section of 150 m2 is larger than any model"),
        ("PTUBE,19,1,150.", "a diameter of 150 m is larger than any model"),
    ],
)
def test_bounds_of_cards_are_in_si(tmp_path: Path, card: str, fact: str) -> None:
    """What no model has in metres is common in millimetres: the others of its cards tell which it is."""
    for name, hint in (("mm-t-s", 'set [model] units = "mm-t-s"'), ("m-kg-s", 'looks right in units = "m-kg-s"')):
        path = deck(tmp_path, f"{card}\n", "card", UNITS[name])
        with pytest.raises(InputError, match=fact) as told:
            read_deck(path)
        assert hint in told.value.hint
        read_deck(path, units=UNITS["mm-t-s"])


def test_the_bound_of_expansions_is_per_kelvin(tmp_path: Path) -> None:
    path = deck(tmp_path, "MAT1,19,7.+10,,.3,2700.,.009\n", "card", SI)
    read_deck(path)
    with pytest.raises(InputError, match=r"an expansion of 0\.0162 per kelvin"):
        read_deck(path, units=DeckUnits(temperature="degF"))
