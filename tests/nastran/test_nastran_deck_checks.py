"""What a deck says is read, or refused by name and line: names of cards, words of case control, fields, its end."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tedm_cli.errors import InputError, PhysicsError
from tedm_cli.nastran.card_names import REFUSED, WITHOUT_INFLUENCE
from tedm_cli.nastran.geometry import model_geometry
from tedm_cli.nastran.reading import passed_over, read_deck

CUBE = """\
SOL 101
CEND
SPC = 1
BEGIN BULK
GRID           1              0.      0.      0.
GRID           2              1.      0.      0.
GRID           3              1.      1.      0.
GRID           4              0.      1.      0.
GRID*                  5                              0.              0.
*                     1.
GRID           6              1.      0.      1.
GRID,7,,1.,1.,1.
GRID           8              0.      1.      1.
CHEXA          1       1       1       2       3       4       5       6+A
+A             7       8
PSOLID         1       1
MAT1           1  7.+10             .33   2700.   2.3-5
CONM2          9       8             27.
SPC1           1     123       1       2       3       4
PARAM   POST    -1
ENDDATA
"""


def read(folder: Path, text: str, **options: Any) -> Any:
    path = folder / "deck.bdf"
    path.write_text(text)
    return read_deck(path, **options)


def changed(old: str, new: str) -> str:
    assert CUBE.count(old) == 1, old
    return CUBE.replace(old, new)


def refused(folder: Path, text: str, line: int | None, fact: str) -> InputError:
    with pytest.raises(InputError, match=fact) as error:
        read(folder, text)
    assert error.value.where == f"{folder / 'deck.bdf'}{'' if line is None else f':{line}'}"
    return error.value


def line_of(text: str, start: str) -> int:
    return next(i for i, line in enumerate(text.splitlines(), start=1) if line.startswith(start))


def test_the_sound_deck(tmp_path: Path) -> None:
    model = read(tmp_path, CUBE)
    assert model_geometry(model, [tmp_path / "deck.bdf"]).total_kg == pytest.approx(2727.0)
    assert passed_over(model) == []


# --- names of cards --------------------------------------------------------------------------------------------------


def flipped_names() -> list[tuple[int, str]]:
    """Every flip of one bit in every letter of every card name of the cube, as a whole deck, with its line."""
    lines = CUBE.splitlines()
    out = []
    for number in range(4, len(lines)):
        name = re.match(r"[A-Z0-9]*", lines[number])
        for column in range(name.end() if name else 0):
            for bit in range(7):
                letter = chr(ord(lines[number][column]) ^ 1 << bit)
                line = lines[number][:column] + letter + lines[number][column + 1 :]
                out.append((number + 1, "\n".join([*lines[:number], line, *lines[number + 1 :], ""])))
    return out


def test_a_flipped_bit_in_a_name_is_refused_or_changes_nothing(tmp_path: Path) -> None:
    """No card vanishes: what remains of the deck is the same model, or the deck is refused."""
    sound = read(tmp_path, CUBE)
    kept = 0
    for number, text in flipped_names():
        (tmp_path / "deck.bdf").write_bytes(text.encode("latin-1"))
        try:
            model = read_deck(tmp_path / "deck.bdf")
            assert model_geometry(model, [tmp_path / "deck.bdf"]).total_kg == pytest.approx(2727.0)
        except InputError:
            continue
        kept += 1
        assert sum(model.card_count.values()) == sum(sound.card_count.values()), text.splitlines()[number - 1]
        assert sorted(model.nodes) == sorted(sound.nodes)
        assert sorted(model.masses) == sorted(sound.masses)
    letters = sum(c.isalpha() for line in CUBE.splitlines()[4:] for c in re.split("[^A-Z0-9]", line)[0])
    assert kept == letters, "capitals and small letters are the same name, and nothing else is"


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("CHEXA", "BHEXA"),
        ("CONM2", "RONM2"),
        ("SPC1 ", "SQC1 "),
        ("PARAM", "QARAM"),
        ("MAT1", "MATT11"),
        ("PSOLID", "PSOLIE"),
    ],
)
def test_an_unknown_card_is_refused_by_name_and_line(tmp_path: Path, old: str, new: str) -> None:
    text = re.sub(rf"(?m)^{old}\s?", f"{new:<{len(old) + 1}}", CUBE)
    refused(tmp_path, text, line_of(text, new.strip()), f"^.*{new.strip()} card: cards of this name are not read")


def test_a_card_of_an_include_is_refused_with_its_file(tmp_path: Path) -> None:
    (tmp_path / "part.inc").write_text("$\n$\nCONM7,5,1,,2.\n")
    with pytest.raises(InputError, match="CONM7 card") as error:
        read(tmp_path, changed("PSOLID ", "INCLUDE 'part.inc'\nPSOLID "))
    assert error.value.where == f"{tmp_path / 'part.inc'}:3"
    text = changed("PSOLID ", "INCLUDE 'part.inc'\nPSOLID ").replace("CONM2", "CONM8")
    (tmp_path / "part.inc").write_text("$\n$\n$\n")
    refused(tmp_path, text, line_of(text, "CONM8"), "CONM8 card")


def test_cards_without_influence_are_told(tmp_path: Path) -> None:
    model = read(tmp_path, changed("ENDDATA", "SET4,1,PROP,PSOLID,1\nPLOTEL4,5,1,2,3,4\nSET4,2,PROP,PSOLID,1\nENDDATA"))
    assert passed_over(model) == ["not read, without influence on unit loads and masses: PLOTEL4 (1), SET4 (2)"]


def test_no_card_of_the_structure_is_without_influence() -> None:
    """The list holds what pyNastran does not read, and no element, property, material, load, constraint or frame."""
    from pyNastran.bdf.bdf import BDF

    assert not WITHOUT_INFLUENCE & BDF(debug=None).cards_to_read
    assert not WITHOUT_INFLUENCE & REFUSED.keys()
    structure = re.compile(
        r"C(?!AMP)|R(?!CROSS)|MAT(?!FTG)|P(?!LOT|ANEL|FTG)|SPC|MPC|LOAD|FORCE|TEMP|GRID|CORD|NSM|DMIG|B(?!EAD|ND)"
    )
    assert [name for name in sorted(WITHOUT_INFLUENCE) if structure.match(name)] == []


# --- fields ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("old", "new", "start", "fact"),
    [
        ("GRID,7,,1.,1.,1.", "GRID,7,,1.,1.,.", "GRID,7", "GRID 7: a point alone is no number"),
        ("     27.", "       .", "CONM2", "CONM2 9: a point alone is no number"),
        ("*                     1.", "*                      .", "GRID*", r"GRID\*? 5: a point alone is no number"),
        ("GRID,7,,1.,1.,1.", "GRID,7,,1_0.,1.,1.", "GRID,7", r"GRID 7: 1_0. is no number"),
        ("     27.", "    2_7.", "CONM2", "CONM2 9: 2_7. is no number"),
        ("*                     1.", "*                   1_1.", "GRID*", r"GRID\*? 5: 1_1. is no number"),
        ("7.+10 ", "7.+1_0", "MAT1", r"MAT1 1: 7.\+1_0 is no number"),
        ("     27.", "   1e999", "CONM2", "CONM2 9: 1e999 is no number"),
        ("     27.", "  1.-400", "CONM2", "CONM2 9: 1.-400 is no number"),
        ("  7.+10 ", "  7.*10 ", "MAT1", "MAT1 1 .*: has an asterisk among its fields"),
        ("GRID           2   ", "GRID           2,  ", "GRID           2", "has a comma in a line of fixed fields"),
        ("+A             7       8", "+A         7   ,   8", "CHEXA", "has a comma in a line of fixed fields"),
        ("+A             7", "+B             7", "CHEXA", r"CHEXA 1: ends its line with \+A, but \+B follows"),
        ("*                     1.", "+                     1.", "GRID*", "in the middle of its large ones"),
        ("GRID           2   ", "GRID           2\x0b  ", "GRID           2", r"has a control character \(11\)"),
    ],
)
def test_what_only_looks_like_a_field(tmp_path: Path, old: str, new: str, start: str, fact: str) -> None:
    text = changed(old, new)
    refused(tmp_path, text, line_of(text, start), fact)


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("GRID           2              1.", "GRID           2 $            1."),
        ("GRID           2              1.", "GRID           2             $1."),
        ("*                     1.", "*    $                1."),
        ("+A             7       8", "$              7       8"),
        ("+A             7       8", "  $            7       8"),
        ("   8             27.", "   8      $      27."),
    ],
)
def test_fields_that_a_dollar_has_cut_off(tmp_path: Path, old: str, new: str) -> None:
    text = changed(old, new).replace("6+A", "6")
    refused(tmp_path, text, next(i for i, line in enumerate(text.splitlines(), start=1) if "$" in line), "behind \\$")


@pytest.mark.parametrize(
    "comment", ["$ 12", "$ part 7", "$", "$$      8", "$2345678", "$.......2.......3", "$  1.2 3.4"]
)
def test_comments_of_people(tmp_path: Path, comment: str) -> None:
    assert len(read(tmp_path, changed("     27.\n", f"     27. {comment}\n")).nodes) == 8
    assert len(read(tmp_path, changed("     27.\n", f"     27.\n{comment}\n$       1.0     2.0\n")).nodes) == 8


def test_lines_that_have_run_together(tmp_path: Path) -> None:
    text = changed("     27.\nSPC1", "     27." + " " * 40 + "SPC1")
    refused(tmp_path, text, line_of(text, "CONM2"), "has a line of more than 80 columns")


def test_numbers_of_every_form_are_read(tmp_path: Path) -> None:
    for form in ("27.", "2.7+1", "2.7E1", "2.7d+1", "+27.", "270.-1", "2.7E+001"):
        model = read(tmp_path, changed("     27.", f"{form:>8}"))
        assert model.masses[9].mass == 27.0


# --- case control ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("line", "fact", "hint"),
    [
        ("LAOD = 3", "LAOD is not known", "is it LOAD, misspelt"),
        ("TEMP)ERATURE(LOAD) = 3", r"TEMP\)ERATURE\(LOAD\) is not known", ""),
        ("TEMPERATUSE(LOAD) = 3", "TEMPERATUSE is not known", "TEMPERATURE, misspelt"),
        ("TEMPERATURE(INIUIAL) = 3", r"TEMPERATURE\(INIUIAL\) is not known", "INITIAL"),
        ("SPB = 1", "SPB is not known", "SPC, misspelt"),
        ("BCONTACT = ALLBODY", "BCONTACT: contact", ""),
        ("INITS = 5", "INITS: initial stress", ""),
        ("BOLTLD = 5", "BOLTLD: bolt preload", ""),
        ("STEP 1", "STEP: a unit load has no steps", ""),
        ("M2GG = MASS", "M2GG: the mass of a matrix .* CONM2", ""),
    ],
)
def test_a_word_that_is_not_known_or_not_ours(tmp_path: Path, line: str, fact: str, hint: str) -> None:
    error = refused(tmp_path, changed("SPC = 1", line), 3, fact)
    assert hint in error.hint


@pytest.mark.parametrize(
    "line", ["DISP(PLOT) = ALL", "DISPLACEMENTS = ALL", "SPCF=ALL", "title = a)b", "SET 5 = 1 THRU 4", "TEMP(INIT) = 3"]
)
def test_abbreviations_are_known(tmp_path: Path, line: str) -> None:
    read(tmp_path, changed("SPC = 1", line))


# --- the end ---------------------------------------------------------------------------------------------------------


def test_a_deck_without_its_end(tmp_path: Path) -> None:
    error = refused(tmp_path, changed("ENDDATA\n", ""), None, "has no ENDDATA")
    assert "model.allow_missing_enddata" in error.hint
    assert len(read(tmp_path, changed("ENDDATA\n", ""), allow_missing_enddata=True).nodes) == 8


@pytest.mark.parametrize("end", ["enddata", "  ENDDATA", "ENDDATA $ of all"])
def test_ends_of_other_forms(tmp_path: Path, end: str) -> None:
    assert len(read(tmp_path, changed("ENDDATA", end)).nodes) == 8


def test_an_include_needs_no_end(tmp_path: Path) -> None:
    body, tail = CUBE.split("PSOLID ")
    (tmp_path / "part.inc").write_text(f"PSOLID {tail.replace('ENDDATA', '$')}")
    read(tmp_path, f"{body}INCLUDE 'part.inc'\nENDDATA\n")
    refused(tmp_path, f"{body}INCLUDE 'part.inc'\n", None, "has no ENDDATA")


def test_a_card_after_the_end(tmp_path: Path) -> None:
    text = changed("CONM2 ", "ENDDATA\nCONM2 ")
    refused(tmp_path, text, line_of(text, "CONM2"), "CONM2 card after ENDDATA")
    assert passed_over(read(tmp_path, CUBE + "$ a comment\n\nleft over\n")) == [
        "not read, without influence on unit loads and masses: lines after ENDDATA (1)"
    ]


# --- what no structure has -------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("cards", "fact"),
    [
        ("MAT1,7,7.+10,,.3,-2700.", "MAT1 7: a density of -2700 is negative"),
        ("MAT8,7,7.+10,7.+10,.3,3.+10,,,-2000.", "MAT8 7: a density of -2000 is negative"),
        ("MAT1,7,7.+10,,.3,2700.,1.+30", r"MAT1 7: an expansion of 1e\+30 per kelvin"),
        ("MAT8,7,7.+10,7.+10,.3,3.+10,,,2000.\n,1.-6,.5", "MAT8 7: an expansion of 0.5 per kelvin"),
        ("PSHELL,7,1,-.01,1", "PSHELL pid=7 Thickness=-0.01"),
        ("PSHELL,7,1,1.+30,1", r"PSHELL 7: a thickness of 1e\+30 m is larger than any model"),
        ("PCOMP,7\n,1,-.001,0.,YES", "PCOMP 7: a ply thickness of -0.001 is negative"),
        ("PBAR,7,1,-1.-4", "PBAR 7: a section of -0.0001 is negative"),
    ],
)
def test_materials_and_sizes_that_nothing_has(tmp_path: Path, cards: str, fact: str) -> None:
    with pytest.raises(InputError, match=fact):
        read(tmp_path, changed("ENDDATA", f"{cards}\nENDDATA"))


@pytest.mark.parametrize(
    ("cards", "fact"),
    [
        ("CQUAD4,20,7,1,2,3,4,,,\n,,,-.01\nPSHELL,7,1,.01,1", "CQUAD4 20: a thickness of -0.01 is negative"),
        ("CONROD,20,1,2,1,-1.-4", "CONROD 20: a section of -0.0001 is negative"),
        ("MAT5,7,1.\nPSOLID,7,7\nCTETRA,20,7,1,2,3,5", "PSOLID 7: MAT5 7 is a material of heat transfer alone"),
        ("MAT9,7,7.+10,,.33,2700.", "MAT9 7: the stiffness is not positive definite"),
        ("PMASS,7,27.\nCMASS3,20,7,8,7", "CMASS3 20: is on grid 8"),
    ],
)
def test_elements_that_nothing_is(tmp_path: Path, cards: str, fact: str) -> None:
    with pytest.raises(InputError, match=fact):
        model_geometry(read(tmp_path, changed("ENDDATA", f"{cards}\nENDDATA")), [tmp_path / "deck.bdf"])


@pytest.mark.parametrize(
    "card", ["MAT1,7,7.+10,,.3,22600.,-9.-6", "MAT1,7,1.+6,,.4,20.,3.-4", "MAT1,7,7.+10,,.3,0.,0."]
)
def test_materials_that_exist(tmp_path: Path, card: str) -> None:
    read(tmp_path, changed("ENDDATA", f"{card}\nENDDATA"))


@pytest.mark.parametrize(
    "rows", [(-1.0, 0.0, 1.0, 0.0, 0.0, 1.0), (0.0, 0.1, 0.0, 0.0, 0.0, 0.0), (1.0, 0.0, 1.0, 2.0, 0.0, 1.0)]
)
def test_an_inertia_of_no_body(tmp_path: Path, rows: tuple[float, ...]) -> None:
    text = changed("     27.\n", "     27.\n        " + "".join(f"{v:8.1f}" for v in rows) + "\n")
    with pytest.raises(InputError, match="CONM2 9: its inertia about its centre of gravity is impossible for a body"):
        model_geometry(read(tmp_path, text), [tmp_path / "deck.bdf"])


def test_a_point_mass_on_a_lever_is_a_body(tmp_path: Path) -> None:
    """A CONM1 with the matrix of a point, in seven digits, has no inertia of its own but its rounding."""
    w, kg = np.array([0.1234567, -0.7654321, 0.3333333]), 27.0
    cross = np.array([[0.0, -w[2], w[1]], [w[2], 0.0, -w[0]], [-w[1], w[0], 0.0]])
    full = np.block([[kg * np.eye(3), -kg * cross], [kg * cross, -kg * cross @ cross]])
    values = [f"{full[i, j]:.5E}".replace("E", "") for i in range(6) for j in range(i + 1)]
    rows = ["CONM1,9,8,0," + ",".join(values[:5]), *("," + ",".join(values[k : k + 8]) for k in (5, 13))]
    text = re.sub(r"CONM2 .*\n", "\n".join(rows) + "\n", CUBE)
    assert model_geometry(read(tmp_path, text), [tmp_path / "deck.bdf"]).total_kg == pytest.approx(2727.0)


def test_a_continuation_that_its_card_has_left_behind(tmp_path: Path) -> None:
    """The card before takes it for midside nodes; real ones are near the middle of their edges."""
    cards = "CHEXA,1,1,1,2,3,4,5,6\n,7,8{0}\n"
    text = re.sub(r"(?s)CHEXA.*?\+A .*?\n", cards, changed("GRID,7", "GRID,20,,.5,0.,.1\nGRID,7"))
    assert model_geometry(read(tmp_path, text.format("")), [tmp_path / "deck.bdf"]).total_kg == pytest.approx(2727.0)
    found = model_geometry(read(tmp_path, text.format(",20")), [tmp_path / "deck.bdf"])
    assert found.elements.partial == [1]
    for extra in ("\n,4,3", ",,,20", ",3"):
        with pytest.raises(InputError, match=r"CHEXA 1: its midside node (4|20|3) is [\d.]+ of its edge.s length"):
            model_geometry(read(tmp_path, text.format(extra)), [tmp_path / "deck.bdf"])


def test_a_solid_whose_grids_are_out_of_order(tmp_path: Path) -> None:
    """It has a mass: that of its sound parts minus that of the parts that are inside out."""
    text = changed("+A             7       8", "+A             8       7")
    with pytest.raises(PhysicsError, match="1 CHEXA with a Jacobian that changes its sign: 1"):
        model_geometry(read(tmp_path, text), [tmp_path / "deck.bdf"])
    inside_out = re.sub(r"(?s)CHEXA.*?\+A .*?\n", "CHEXA,1,1,5,6,7,8,1,2\n,3,4\n", CUBE)
    assert model_geometry(read(tmp_path, inside_out), [tmp_path / "deck.bdf"]).total_kg == pytest.approx(2727.0)


def test_half_of_a_card_in_large_fields(tmp_path: Path) -> None:
    text = changed("*                     1.\n", "")
    refused(tmp_path, text, line_of(text, "GRID*"), "GRID 5.*: lacks the second line of its large fields")
