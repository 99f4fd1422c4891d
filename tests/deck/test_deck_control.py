"""What unit loads keep of a model's case control, and from which temperature they start."""

from __future__ import annotations

import re
from collections.abc import Sequence
from decimal import Decimal
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from deck_tools import LEFT, RIGHT, Card, bricks, plain, temperatures, written
from hypothesis import given
from hypothesis import strategies as st

from tedm_cli.errors import InputError
from tedm_cli.nastran.loads.temperature_sets import free_set_ids, temperature_cards
from tedm_cli.nastran.loads.temperature_sets import plain as real
from tedm_cli.nastran.op2.reader import open_op2
from tedm_cli.nastran.reading import read_deck
from tedm_cli.stages.model.solve import solve_deck

LONG = """\
NASTRAN SYSTEM(700)=1
ID A, B
SOL SEMODES
TIME 600
CEND
title = my model, with a comma,
ECHO = NONE
SET 44 = 1, 2, $ ids
   5 THRU 9
SPC = 1
spcf = all
METHOD = 7
STRESS(PLOT,CORNER) = 44
TEMP(INIT) = 3
PARAM,GRDPNT,0
SUBCASE 10
  LABEL = modes, first
  LOAD = 4
  DISP(SORT1,
    REAL) = ALL
subcase 20 $ second
  temperature = 8
OUTPUT(PLOT)
  CSCALE 1.3
  SET 1 ALL
  AXES X , Y , Z
BEGIN BULK
"""


def head_of(deck: str) -> list[str]:
    return deck.split("SUBCASE 1\n")[0].splitlines()


def test_case_control_of_another_solution(tmp_path: Path) -> None:
    deck, done = written(tmp_path, plain(bricks(), LONG))
    assert head_of(deck) == [
        *("NASTRAN SYSTEM(700)=1", "ID A, B", "TIME 600", "SOL 101", "CEND", "title = my model, with a comma,"),
        *("ECHO = NONE", "SET 44 = 1, 2, $ ids", "   5 THRU 9", "SPC = 1", "PARAM,GRDPNT,0"),
    ]
    assert done.notes == (
        "SOL SEMODES is now SOL 101, linear statics",
        "2 subcases of the model are replaced by the unit loads",
        "dropped: METHOD = 7, TEMPERATURE(INIT) = 3, LOAD = 4, TEMPERATURE = 8",
        "output requests dropped: SPCFORCES, STRESS, OUTPUT(PLOT)",
    )
    model = read_deck(done.path)
    assert {n: s.get_parameter("SPC")[0] for n, s in model.subcases.items() if n} == {1: 1, 2: 1, 3: 1}
    assert len(re.findall(r"DISPLACEMENT\(PLOT\) = ALL", deck)) == 3


def control(*subcases: str, above: str = "") -> str:
    parts = [f"SUBCASE {n}\n{text}" for n, text in enumerate(subcases, start=1)]
    return "SOL 101\nCEND\n" + above + "".join(parts) + "BEGIN BULK\n"


TWO = [*bricks(), ("SPC1", "2", "123456", "1", "2")]


def test_constraints_common_to_all_subcases(tmp_path: Path) -> None:
    for number, text in enumerate(
        (control("SPC = 2\nLOAD=1\n", "spc=2\n"), control("LOAD=1\n", "SPC = 2\n", above="SPC = 2\n"))
    ):
        deck, _ = written(tmp_path / str(number), plain(TWO, text))
        assert head_of(deck) == ["SOL 101", "CEND", "SPC = 2"]


def test_constraints_that_differ_are_the_users_choice(tmp_path: Path) -> None:
    model = plain(TWO, control("SPC = 1\n", "", above="SPC = 2\nPARAM,K6ROT,1.\n"))
    with pytest.raises(InputError, match="different SPC: 1 in subcase 1, 2 in subcase 2") as error:
        written(tmp_path, model)
    assert "constraints_of_subcase" in error.value.hint
    for chosen, spc in ((1, 1), (2, 2)):
        deck, done = written(tmp_path, model, f"constraints_of_subcase = {chosen}\n")
        assert sorted(head_of(deck)[2:]) == ["PARAM,K6ROT,1.", f"SPC = {spc}"]
        assert f"constraints are those of subcase {chosen}" in done.notes
    with pytest.raises(InputError, match="no subcase 5; there are: 1, 2"):
        written(tmp_path, model, "constraints_of_subcase = 5\n")


def test_a_subcase_without_constraints_differs_from_one_with(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="different SPC: 1 in subcase 1, none in subcase 2"):
        written(tmp_path, plain(TWO, control("SPC = 1\n", "")))
    with pytest.raises(InputError, match="different K2GG: KAAX in subcase 1, none in subcase 2"):
        written(tmp_path, plain(TWO, control("K2GG=KAAX\n", "", above="SPC = 1\n")))


@pytest.mark.parametrize(
    ("line", "piece"),
    [
        ("SUBCOM 9", "SUBCOM: a unit load must not combine"),
        ("SYM 9", "SYM: "),
        ("REPCASE 9", "REPCASE: "),
        ("SUPER = ALL", "SUPER: superelements"),
        ("BCONTACT = ALLBODY", "BCONTACT: contact"),
        ("ANALYSIS = HEAT", "ANALYSIS = HEAT"),
        ("NOVELTY = 3", "NOVELTY is not known"),
        ("param , inrel , -2", "PARAM,INREL,-2"),
        ("= 5", "= is not known"),
    ],
)
def test_case_control_that_is_refused_by_name(tmp_path: Path, line: str, piece: str) -> None:
    with pytest.raises(InputError, match=re.escape(piece)) as error:
        written(tmp_path, plain(bricks(), control(line + "\n", above="SPC = 1\n")))
    assert error.value.where.endswith("model.bdf:5")


# --- temperatures ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("tref", ["", "0.", "20.", "273.15", "-180.25", "2.9315+2", "1.-3"])
def test_unit_loads_step_up_from_the_reference(tmp_path: Path, tref: str) -> None:
    _, done = written(tmp_path, plain(bricks(tref)))
    rest = float(re.sub(r"(?<=\d|\.)([+-])", r"e\1", tref) or 0.0)
    assert done.reference == rest
    warm = temperatures(done.path)
    assert {n: sorted(t) for n, t in warm.items()} == {
        **{"LEFT": list(LEFT), "RIGHT": list(RIGHT)},
        "UNIFORM": [*LEFT, *RIGHT],
    }
    assert {t for case in warm.values() for t in case.values()} == {float(Decimal(str(rest)) + 1)}
    assert {card.temperature for card in read_deck(done.path).tempds.values()} == {rest}


@given(
    rest=st.decimals(-400, 4000, places=9),
    ids=st.sets(st.integers(1, 999_999_999), min_size=1, max_size=8),
    sid=st.integers(1, 99_999_999),
)
def test_temperature_cards_are_exact(rest: Decimal, ids: set[int], sid: int) -> None:
    """In small or large fields, whichever hold them; read back by columns."""
    lines = temperature_cards(sid, rest, np.array(sorted(ids)))
    width = 16 if "*" in lines[0][:8] else 8
    if width == 16:
        lines = [a + b[8:] for a, b in zip(lines[::2], lines[1::2], strict=True)]
    assert all(len(line) <= 8 + 8 * width and len(line) % 8 == 0 for line in lines)
    rows = [[line[k : k + width].strip() for k in range(8, len(line), width)] for line in lines]
    assert rows[0] == [str(sid), real(rest)]
    pairs = [(int(g), Decimal(t)) for row in rows[1:] for g, t in zip(row[1::2], row[2::2], strict=True)]
    assert pairs == [(i, rest + 1) for i in sorted(ids)]
    assert all(int(row[0]) == sid and "." in row[2] for row in rows[1:])


def test_a_temperature_that_fills_the_field_is_written_and_a_longer_one_refused() -> None:
    """Sixteen columns hold 293.150000000001; with a digit more the step would be rounded."""
    (line, _, *_) = temperature_cards(1, Decimal("293.150000000001"), np.array([7]))
    assert line[24:40] == "293.150000000001"
    with pytest.raises(InputError, match=r"293.1500000000001 has more digits than a field"):
        temperature_cards(1, Decimal("293.1500000000001"), np.array([7]))


def test_grid_ids_of_eight_digits_and_temperatures_of_nine(tmp_path: Path) -> None:
    for number, (first, tref) in enumerate(((99_999_980, "20."), (0, "293.1501"), (0, "1234.567"))):
        areas = {"LEFT": [first + i for i in LEFT], "RIGHT": [first + i for i in RIGHT]}
        deck, done = written(tmp_path / str(number), plain(bricks(tref, first)), "", **areas)
        assert {k: sorted(v) for k, v in temperatures(done.path).items() if k != "UNIFORM"} == areas
        assert ("TEMP*" in deck) == (number == 2 and len("1235.567") > 8)


def different(trefs: Sequence[str]) -> list[Card]:
    """The bricks, of materials with these reference temperatures."""
    cards = [c for c in bricks() if c[0] not in ("PSOLID", "MAT1", "PBAR")]
    for i, tref in enumerate(trefs, start=1):
        cards += [("MAT1", str(i), "7.+10", "", ".33", "2700.", "2.3-5", tref)]
    return [*cards, ("PSOLID", "1", "1"), ("PBAR", "2", "2", "1.-4", "1.-9", "1.-9", "2.-9")]


def test_different_references_give_the_same_unit_loads(tmp_path: Path) -> None:
    """TEMPERATURE(INITIAL) replaces every TREF; with constant properties the start does not matter."""
    results = []
    for number, trefs in enumerate((["20.", "20."], ["20.", "300."], ["", "77.35"])):
        deck, done = written(tmp_path / str(number), plain(different(trefs)))
        assert ("TEMPERATURE(INITIAL) = 4" in deck) == (number > 0)
        assert any("MYSTRAN" in note for note in done.notes) == (number > 0)
        out = tmp_path / f"{number}.op2"
        solve_deck(done.path, out)
        with open_op2(out) as (tables, read):
            results.append(np.stack([read(table).motion for table in tables]))
    for other in results[1:]:
        np.testing.assert_allclose(other, results[0], rtol=0, atol=2e-7 * np.abs(results[0]).max())


def test_laminates_have_a_reference_of_their_own(tmp_path: Path) -> None:
    laminate = [("PCOMP", "9", "", "", "", "", "50."), ("CQUAD4", "4", "9", "9", "10", "11", "12")]
    ply = [("MAT8", "8", "1.+11", "1.+10", ".3", "5.+9", "", "", "1600.", "1.-6", "2.-5", "20.")]
    cards = [*bricks("20."), *ply, laminate[0] + ("", "", "8", ".001", "0."), laminate[1]]
    deck, _ = written(tmp_path, plain(cards))
    assert "TEMPERATURE(INITIAL)" in deck


def test_materials_that_depend_on_temperature(tmp_path: Path) -> None:
    tables = [("MATT1", "1", "5"), ("TABLEM1", "5", "", "", "", "", "", "", "", "0.", "7.+10", "400.", "6.+10", "ENDT")]
    cards = [*bricks("20."), *tables]
    with pytest.raises(InputError, match=r"MATT1 1.*nothing says where") as error:
        written(tmp_path, plain(cards))
    assert "reference_temperature_K" in error.value.hint
    for kelvin, first in (("293.15", "293.15"), ("20.0", "20.")):
        deck, done = written(tmp_path, plain(cards), f"reference_temperature_K = {kelvin}\n")
        assert "TEMPERATURE(INITIAL) = 4" in deck
        assert f"TEMPD          4{first:>8}" in deck
        assert any(f"linearised at {first}" in note for note in done.notes)
    own = "SOL 101\nCEND\nSPC = 1\nTEMP(MATE) = 6\nBEGIN BULK\n"
    deck, done = written(tmp_path, plain([*cards, ("TEMPD", "6", "90.")], own))
    assert "TEMPERATURE(MATE) = 6" in deck
    assert "TEMPERATURE(INITIAL)" not in deck
    assert done.reference == 20.0
    with pytest.raises(InputError, match=r"TEMPERATURE\(MATERIAL\) excludes"):
        written(tmp_path, plain([*cards, ("TEMPD", "6", "90.")], own), "reference_temperature_K = 293.15\n")


def test_new_sets_do_not_meet_old_ones(tmp_path: Path) -> None:
    old = [("TEMPD", "7", "3."), ("TEMP", "9", "1", "5."), ("FORCE", "12", "9", "", "1.", "0.", "0.", "1.")]
    deck, done = written(tmp_path, plain([*bricks(), *old]))
    assert re.findall(r"TEMPERATURE\(LOAD\) = (\d+)", deck) == ["13", "14", "15"]
    assert all(f"{card[0]:<8}{card[1]:>8}" in deck for card in old)
    model = read_deck(done.path)
    for last, expected in ((99_999_996, [99_999_997, 99_999_998, 99_999_999]), (99_999_997, [1, 2, 3])):
        assert free_set_ids(_Sets([last]), 3, "") == expected
    assert free_set_ids(_Sets([2, 6, 99_999_998]), 3, "") == [3, 4, 5]
    assert set(model.tempds) == {7, 13, 14, 15}


class _Sets:
    """A model that has these load sets and no others."""

    load_combinations = tempds = dloads = dload_entries = tedm_element_temperatures = ()

    def __init__(self, loads: list[int]) -> None:
        self.loads = loads
        self.tedm_columns = SimpleNamespace(temperature_sets={})


def test_old_temperatures_of_elements_stay_and_new_sets_do_not_meet_them(tmp_path: Path) -> None:
    """Their elements may be gone: nothing selects their set."""
    old = ("TEMPP1", "40", "999", "25.", "3.")
    deck, _ = written(tmp_path, plain([*bricks(), old]))
    assert re.findall(r"TEMPERATURE\(LOAD\) = (\d+)", deck) == ["41", "42", "43"]
    assert deck.count("TEMPP1") == 1


def test_mass_by_a_matrix_is_refused_before_a_deck_is_written(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="M2GG"):
        written(tmp_path, plain(bricks(), control("M2GG = MEX\n", above="SPC = 1\n")))


def test_scalar_points_and_default_grids_are_no_hindrance(tmp_path: Path) -> None:
    extra = [("SPOINT", "77"), ("GRDSET", "", "", "", "", "", "", "456")]
    _, done = written(tmp_path, plain([*bricks(), *extra]))
    assert done.grids == 12


# --- the reference model ---------------------------------------------------------------------------------------------


def test_mini_ltp_again(mini_ltp_dir: Path, tmp_path: Path) -> None:
    """Its bare model and its areas give its own TEMP cards back; so does the deck itself, subcases and all."""
    import json

    text = (mini_ltp_dir / "mini_ltp.bdf").read_text()
    areas = json.loads((mini_ltp_dir / "areas.json").read_text())
    bare = re.sub(r"(?m)^TEMPD?\s.*\n", "", re.sub(r"(?s)SUBCASE 1\n.*?(?=BEGIN BULK)", "", text))
    assert len(bare) < 0.9 * len(text)
    wanted = temperatures(mini_ltp_dir / "mini_ltp.bdf")
    for name, model in (("bare", bare), ("whole", text)):
        _, done = written(tmp_path / name, model, **areas)
        assert temperatures(done.path) == wanted
        assert list(temperatures(done.path)) == [*areas, "UNIFORM"]
    whole = done.notes
    assert whole[0] == "20 subcases of the model are replaced by the unit loads"
    assert "TEMPERATURE(LOAD) = 1," in whole[1]


def test_decks_of_other_programs(nastran_dir: Path, tmp_path: Path) -> None:
    """A structural model in one piece becomes unit loads, the others are refused by name."""
    refused = {
        "cqra00366.bdf": "different K2GG: MATK in subcase 1, none in subcase 3",
        "htrussx.bdf": "different SPC: 1 in subcase 1, 2 in subcase 2",
        "see101nd.bdf": "BEGIN SUPER = 1: superelements",
        "static_solid_shell_bar.bdf": "INCLUDE of a file that does not exist",
        "v10112.bdf": "SUBCOM: a unit load",
    }
    for name, piece in refused.items():
        with pytest.raises(InputError, match=piece):
            written(tmp_path / name, (nastran_dir / name).read_bytes())
    whole = (nastran_dir / "TestStressTemp.bdf").read_bytes()
    grids = [int(line[8:16]) for line in whole.decode().splitlines() if line.startswith("GRID")]
    deck, done = written(tmp_path / "whole", whole, ALL=grids)
    assert any(n.startswith("dropped: TEMPERATURE(INITIAL) = 1, LOAD = 3, TEMPERATURE(LOAD) = 4, ") for n in done.notes)
    assert head_of(deck)[-1] == "SPC = 2"
    assert temperatures(done.path)["ALL"] == dict.fromkeys(grids, done.reference + 1.0)
