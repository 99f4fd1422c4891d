"""Temperatures of elements (TEMPP1, TEMPRB): in every form of a card, by range, by INCLUDE, and what is refused."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from tedm_cli.deck_units import SYSTEMS, DeckUnits
from tedm_cli.errors import InputError
from tedm_cli.fem.structure import ElementTemperatures
from tedm_cli.nastran.loads.element_temperatures import element_temperature_sets, element_temperatures
from tedm_cli.nastran.loads.temperature_sets import free_set_ids
from tedm_cli.nastran.reading import read_deck

CARDS = """GRID,1,,0.,0.,0.
GRID,2,,1.,0.,0.
GRID,3,,1.,1.,0.
GRID,4,,0.,1.,0.
GRID,5,,0.,0.,1.
GRID,6,,1.,0.,1.
GRID,7,,1.,1.,1.
GRID,8,,0.,1.,1.
CQUAD4,1,1,1,2,3,4
CTRIA3,2,1,5,6,7
CTRIA3,4,1,5,7,8
CBAR,11,2,1,5,1.,0.,0.
CROD,12,3,2,6
CONROD,13,3,7,1,1.-4
CHEXA,20,4,1,2,3,4,5,6,\n,7,8
CBUSH,21,5,1,5,,,,0
RBE2,22,1,123456,2
CONM2,23,1,,1.
PSHELL,1,1,.01,1
PBAR,2,1,1.-4,1.-8,1.-8,,1.-8
PROD,3,1,1.-4
PSOLID,4,1
PBUSH,5,K,1.,1.,1.
MAT1,1,7.+10,,.3,2700.,2.-5
"""


def deck(folder: Path, cards: str) -> Path:
    folder.mkdir(exist_ok=True)
    path = folder / "deck.bdf"
    path.write_text(f"SOL 101\nCEND\nBEGIN BULK\n{CARDS}{cards}\nENDDATA\n")
    return path


def read(folder: Path, cards: str, set_id: int = 7, units: DeckUnits | None = None) -> ElementTemperatures:
    found = element_temperatures(read_deck(deck(folder, cards), units=units or DeckUnits()), set_id)
    assert found is not None
    return found


SHELL = ["TEMPP1", 7, 2, "21.", "-1.5", "20.", "22.", None, None, 1, 4]
BAR = ["TEMPRB", 7, 12, "21.", "22.", "3.", "4.", "5.", "6.", *["20."] * 8, 11]


def free(fields: list[object], end: int = 9) -> str:
    words = ["" if field is None else str(field) for field in fields]
    lines = [words[:end], *(["", *words[k : k + 8]] for k in range(end, len(words), 8))]
    return "\n".join(",".join(line) for line in lines)


def fixed(fields: list[object], width: int) -> str:
    count, mark = (8, "") if width == 8 else (4, "*")
    words = ["" if field is None else str(field) for field in fields[1:]]
    lines = [words[k : k + count] for k in range(0, len(words), count)]
    heads = [f"{fields[0]}{mark}", *[mark] * (len(lines) - 1)]
    return "\n".join(f"{h:<8}" + "".join(f"{w:>{width}}" for w in line) for h, line in zip(heads, lines, strict=True))


FORMS = {"free": free, "small": lambda f: fixed(f, 8), "large": lambda f: fixed(f, 16)}


@pytest.mark.parametrize("form", FORMS)
def test_every_form_of_a_card(tmp_path: Path, form: str) -> None:
    """Fields by their places; temperatures of fibres are without effect; further elements in the next line."""
    found = read(tmp_path, f"{FORMS[form](SHELL)}\n{FORMS[form](BAR)}\nTEMPD,7,20.")
    np.testing.assert_array_equal(found.element_id, [1, 2, 4, 11, 12])
    np.testing.assert_array_equal(found.mean, [[21.0, 21.0]] * 3 + [[21.0, 22.0]] * 2)
    through, across = [[-1.5, 0.0]] * 2, [[3.0, 5.0], [4.0, 6.0]]
    np.testing.assert_array_equal(found.gradient, [through] * 3 + [across] * 2)


def test_lists_by_range_pass_over_gaps(tmp_path: Path) -> None:
    """Ids and ranges of two forms; what is blank is no gradient."""
    found = read(tmp_path, "TEMPP1,7,2,21.\n,1,THRU,3,4,THRU,9\nTEMPRB,7,11,1.,1.\n,\n,12,13")
    np.testing.assert_array_equal(found.element_id, [1, 2, 4, 11, 12, 13])
    assert not found.gradient.any()
    assert (found.mean[:, 0] == [21.0] * 3 + [1.0] * 3).all()


def test_sets_are_apart_and_known(tmp_path: Path) -> None:
    """New sets of unit loads keep clear of those with temperatures of elements alone."""
    path = deck(tmp_path, "TEMPP1,7,2,21.,1.\nTEMPP1,9,2,22.,1.\nTEMP,3,1,20.")
    model = read_deck(path)
    assert element_temperature_sets(model) == {7, 9}
    assert element_temperatures(model, 3) is None
    for number, mean in ((7, 21.0), (9, 22.0)):
        found = element_temperatures(model, number)
        assert found is not None
        assert found.mean.tolist() == [[mean, mean]]
    assert free_set_ids(model, 2, "deck") == [10, 11]
    assert model.card_count["TEMPP1"] == 2


def test_the_same_twice_is_once(tmp_path: Path) -> None:
    assert read(tmp_path, "TEMPP1,7,2,21.,1.\nTEMPP1,7,1,21.,1.\n,2").element_id.tolist() == [1, 2]


def test_an_error_in_an_include_names_its_line(tmp_path: Path) -> None:
    path = deck(tmp_path, "INCLUDE 'loads.inc'")
    (tmp_path / "loads.inc").write_text("$ loads\nTEMPP1,7,99,21.\n")
    model = read_deck(path)
    with pytest.raises(InputError, match="element 99, which does not exist") as error:
        element_temperatures(model, 7)
    assert error.value.where == f"{tmp_path / 'loads.inc'}:2"


BAD = {
    "TEMPP1,7,99,21.,0.": "TEMPP1 of set 7 names element 99, which does not exist",
    "TEMPP1,7,1,21.,0.\n,30,THRU,40": "names elements 30 THRU 40, none of which exists",
    "TEMPP1,7,11,21.,0.": "names CBAR 11, and is for CQUAD4, CQUAD8, .*write TEMPRB",
    "TEMPRB,7,2,21.,21.": "names CTRIA3 2, and is for CBAR, .*write TEMPP1",
    "TEMPP1,7,20,21.,0.": "names CHEXA 20, .*load its grids",
    "TEMPP1,7,1,21.,0.\n,4,THRU,20": "names CBAR 11",
    "TEMPRB,7,21,21.,21.": "names CBUSH 21",
    "TEMPRB,7,22,21.,21.": "names RBE2 22, which has no temperature",
    "TEMPP1,7,23,21.": "names CONM2 23, which has no temperature",
    "TEMPP1,7,1,21.,1.\nTEMPP1,7,2,21.,2.\n,1": r"element 1 another temperature than .*deck.bdf:29 does",
    "TEMPP1,7,1,21.,1.\nTEMPP1,7,1,22.,1.": "element 1 another temperature",
    "TEMPP1,7,1,1.+5": "temperature 100000 is outside",
    "TEMPP1,7,1,21.,-1.+7": r"temperature gradient -1e\+07 is outside -1e\+06 to 1e\+06 K/m",
    "TEMPP1,7,1,nan": "nan is no number",
    "TEMPP1,7,1,1.+301": "is no number",
    "TEMPP1,7,1": r"TEMPP1: field 3 \(TBAR\) is blank, and must be a float",
    "TEMPRB,7,11,21.": r"field 4 \(TB\) is blank",
    "TEMPP1,7,1,21": r"field 3 \(TBAR\) is '21', and must be a float",
    "TEMPP1,7,1,21.,x": r"field 4 \(TPRIME\) is 'X', and must be",
    "TEMPRB,7,11,21.,21.,,,,\n,warm": r"field 9 \(TCA\)",
    "TEMPP1,,1,21.": r"field 1 \(SID\) is blank, and must be an integer",
    "TEMPP1,0,1,21.": "numbers of sets and elements are 1 and more",
    "TEMPP1,7,1,21.,0.,,,2,4": "fields behind TS2",
    "TEMPP1,7,1,21.,0.\n,2,THRU": "THRU lacks its last number",
    "TEMPP1,7,1,21.,0.\n,THRU,4": "THRU in its list of elements names none",
    "TEMPP1,7,1,21.,0.\n,4,THRU,2": "4 THRU 2 runs backwards",
    "TEMPP1,7,1,21.,0.\n,2.": "2. in its list of elements names none",
    "TEMPP1,7,1,21.,0.\n,-2": "-2 in its list of elements names none",
}


@pytest.mark.parametrize("cards", BAD)
def test_refused_with_file_and_line(tmp_path: Path, cards: str) -> None:
    with pytest.raises(InputError) as error:
        read(tmp_path, cards)
    assert error.value.where == f"{tmp_path / 'deck.bdf'}:{28 + cards.count('TEMP')}"
    assert re.search(BAD[cards], f"{error.value.fact} {error.value.hint}"), error.value.fact


def test_bounds_are_in_si(tmp_path: Path) -> None:
    """100 degrees per millimetre are 1e5 K/m; in inches the same number is less."""
    units = {name: DeckUnits(*system) for name, system in SYSTEMS.items()}
    assert read(tmp_path, "TEMPP1,7,1,21.,2000.").gradient[0, 0, 0] == 2000.0
    with pytest.raises(InputError, match="gradient 2e"):
        read(tmp_path, "TEMPP1,7,1,21.,2000.", units=units["mm-t-s"])
    assert read(tmp_path, "TEMPP1,7,1,21.,2000.", units=units["in-lbf-s"]).gradient[0, 0, 0] == 2000.0


@pytest.mark.parametrize("name", ["TEMPP2", "TEMPP3", "TEMPB3", "TEMPN1", "TEMPADD", "TEMPF"])
def test_other_cards_stay_refused(tmp_path: Path, name: str) -> None:
    with pytest.raises(InputError, match=f"{name} card: is not read"):
        read(tmp_path, f"{name},7,1,1.")
