"""However the model is written, the unit-load deck is the same model."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from deck_tools import HEAD, bricks, disguised, free, large, plain, project, small, temperatures, written

from tedm_cli.errors import InputError
from tedm_cli.nastran.reading import read_deck
from tedm_cli.stages.model.deck import write_deck
from tedm_cli.stages.model.solve import solve_deck


def bulk_of(deck: str) -> str:
    """The model's own lines of a written deck."""
    return re.split(r"BEGIN BULK\r?\n", deck)[1].split("$ Unit loads added by tedm")[0]


@pytest.mark.parametrize("seed", range(16))
def test_any_format_and_any_includes_give_the_same_unit_loads(tmp_path: Path, seed: int) -> None:
    """Same arrays, same temperatures, and the same displacements to the byte."""
    cards = bricks("20.")
    reference, done = written(tmp_path / "plain", plain(cards))
    disguised(cards, tmp_path / "other", seed)
    model = (tmp_path / "other" / "model.bdf").read_bytes()
    again = write_deck(project(tmp_path / "other", model), None)
    assert temperatures(again.path) == temperatures(done.path)
    a, b = (read_deck(d.path) for d in (done, again))
    assert sorted(a.nodes) == sorted(b.nodes)
    for i in a.nodes:
        np.testing.assert_array_equal(a.nodes[i].get_position(), b.nodes[i].get_position())
    for i in a.elements:
        assert a.elements[i].raw_fields() == b.elements[i].raw_fields()
    op2 = [tmp_path / f"{k}.op2" for k in range(2)]
    for deck, out in zip((done.path, again.path), op2, strict=True):
        solve_deck(deck, out)
    assert op2[0].read_bytes() == op2[1].read_bytes()
    assert bulk_of(reference) == "".join(small(c) for c in cards) + "PARAM,POST,-1\n"


def test_bulk_data_stay_to_the_byte(tmp_path: Path) -> None:
    odd = b"$ \xe4\xf6\xfc \x85 latin\r\nMAT1    9\t1.+7\t\t.3   $ unused  \r\n\r\n$\r\n"
    body = "".join(free(c) for c in bricks()).replace("\n", "\r\n").encode() + odd
    deck, _ = written(tmp_path, HEAD.replace("\n", "\r\n").encode() + body + b"ENDDATA\r\n")
    assert bulk_of(deck).encode("latin-1") == body + b"PARAM,POST,-1\n"
    own = deck.encode("latin-1").split(b"PARAM,POST,-1\n")
    assert b"\n" not in own[1].replace(b"\r\n", b"")


def nested(folder: Path, where: str) -> str:
    """A model whose include includes another one, which lies beside the main file or beside the including file."""
    cards = [small(c) for c in bricks()]
    (folder / "parts").mkdir(parents=True)
    (folder / "parts" / "a.inc").write_text("".join(cards[:6]) + "INCLUDE 'b.inc'\n")
    places = {"main": [folder], "parent": [folder / "parts"], "both": [folder, folder / "parts"], "none": []}
    for place in places[where]:
        (place / "b.inc").write_text("".join(cards[6:]))
    return HEAD + "INCLUDE 'parts/a.inc'\nENDDATA\n"


@pytest.mark.parametrize("where", ["main", "parent"])
def test_nested_includes_of_either_convention(tmp_path: Path, where: str) -> None:
    deck, _ = written(tmp_path, nested(tmp_path, where))
    assert bulk_of(deck) == "".join(small(c) for c in bricks()) + "PARAM,POST,-1\n"
    assert "b.inc" in deck.split("$ Unit loads added")[1]


def test_a_nested_include_that_can_be_two_files(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"'b.inc' can be .*b.inc or .*parts/b.inc") as error:
        written(tmp_path, nested(tmp_path, "both"))
    assert error.value.where.endswith("a.inc:7")


def test_includes_that_lead_nowhere(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="does not exist") as error:
        written(tmp_path / "none", nested(tmp_path / "none", "none"))
    assert error.value.where.endswith("a.inc:7")
    with pytest.raises(InputError, match="includes itself"):
        written(tmp_path / "self", HEAD + "INCLUDE 'model.bdf'\n")
    with pytest.raises(InputError, match="closing quote"):
        written(tmp_path / "open", HEAD + "INCLUDE 'model\n")
    with pytest.raises(InputError, match="no variable NOWHERE_SET"):
        written(tmp_path / "variable", HEAD + "INCLUDE 'NOWHERE_SET:model.inc'\n")


def test_include_by_variable_and_backslash(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "store" / "deep").mkdir(parents=True)
    (tmp_path / "store" / "deep" / "m.inc").write_text("".join(large(c) for c in bricks()))
    monkeypatch.setenv("MODELS", str(tmp_path / "store"))
    for number, name in enumerate(("MODELS:deep/m.inc", "$MODELS/deep/m.inc", "..\\store\\deep\\m.inc")):
        deck, _ = written(tmp_path / f"p{number}", HEAD + f"INCLUDE '{name}'\nENDDATA\n")
        assert bulk_of(deck) == "".join(large(c) for c in bricks()) + "PARAM,POST,-1\n"


def test_messages_name_the_included_file_and_its_line(tmp_path: Path) -> None:
    (tmp_path / "b.inc").write_text("$\nTEMPP3,2,1,1.,0.\n")
    with pytest.raises(InputError, match="TEMPP3") as error:
        written(tmp_path, HEAD + "".join(small(c) for c in bricks()) + "INCLUDE 'b.inc'\nENDDATA\n")
    assert error.value.where == f"{tmp_path / 'b.inc'}:2"


@pytest.mark.parametrize(
    ("text", "piece"),
    [
        ("SOL 101\nCEND\nSPC = 1\n", "no BEGIN BULK"),
        ("SPC = 1\nBEGIN BULK\n", "no CEND"),
        (HEAD + "BEGIN SUPER=2\nENDDATA\n", "BEGIN SUPER=2: superelements"),
        (HEAD.replace("BULK", "SUPER=2") + "ENDDATA\n", "BEGIN SUPER=2: superelements"),
        (HEAD + "SELOC,2,1\nENDDATA\n", "SELOC card: superelements"),
        (HEAD + "PARAM,INREL,-1\nENDDATA\n", "PARAM,INREL,-1: inertia relief"),
        (HEAD + "PARAM*            INREL              -2\n*\nENDDATA\n", "PARAM,INREL,-2: inertia relief"),
        (HEAD.replace("SPC = 1", "PARAM,CHECKOUT,YES") + "ENDDATA\n", "PARAM,CHECKOUT,YES"),
        ("ALTER 5\n" + HEAD, "ALTER: the model alters"),
        ("ASSIGN MASTER='x'\n" + HEAD, "ASSIGN"),
        (HEAD.replace("101", "153"), "SOL 153 is heat transfer"),
    ],
)
def test_models_that_cannot_be_unit_loads(tmp_path: Path, text: str, piece: str) -> None:
    with pytest.raises(InputError, match=re.escape(piece)):
        written(tmp_path, text)


def test_superelement_grids(tmp_path: Path) -> None:
    cards = bricks()
    cards[3] = (*cards[3], "", "", "7")
    with pytest.raises(InputError, match=r"superelements \(SEID\): 4"):
        written(tmp_path, plain(cards))


def test_constraints_that_are_missing_or_move(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="selects SPC 5, which is not"):
        written(tmp_path / "a", plain(bricks(), HEAD.replace("SPC = 1", "SPC = 5")))
    moved = [*bricks(), ("SPC", "7", "1", "3", ".001"), ("SPCADD", "5", "1", "7")]
    with pytest.raises(InputError, match="SPC 7 moves grids 1"):
        written(tmp_path / "b", plain(moved, HEAD.replace("SPC = 1", "SPC = 5")))
    written(tmp_path / "c", plain(moved))


@pytest.mark.parametrize(
    ("params", "kept", "note"),
    [
        (["PARAM,POST,-1\n"], ["PARAM,POST,-1\n"], ""),
        (["PARAM   POST    0\n"], ["$ PARAM   POST    0\n", "PARAM,POST,-1\n"], "PARAM,POST,0 is now"),
        (["param\tpost\t-1 $\n", "PARAM,POST,-1\n"], ["param\tpost\t-1 $\n", "$ PARAM,POST,-1\n"], ""),
        (
            ["PARAM*  POST                          -2\n", "*\n"],
            ["$ PARAM*  POST                          -2\n", "$ *\n", "PARAM,POST,-1\n"],
            "PARAM,POST,-2",
        ),
    ],
)
def test_one_param_post(tmp_path: Path, params: list[str], kept: list[str], note: str) -> None:
    body = "".join(small(c) for c in bricks())
    deck, done = written(tmp_path, HEAD + body + "".join(params) + "ENDDATA\n")
    assert bulk_of(deck) == body + "".join(kept)
    assert note in " ".join(done.notes)
    assert bool(done.notes) == bool(note)


@pytest.mark.parametrize(
    ("card", "named"),
    [
        ("MAT1,9,1.+7,,.3,2e-08\n", "2e-08"),
        ("MAT1           9    1.+7              .3             2-8\n", "2-8"),
        ("MAT1*                  9            1.+7                              .3\n*                    1D3\n", "1D3"),
        ("MAT1,9,1.+7,,.3,2.-8 $ 2e-08\n", ""),
        ("MAT1,9,1000.25+3,,.3,1.e-08\n", ""),
        ("MAT1,9,1.+7,,.3,,,,,+1E5\n+1E5,2.-3\n", ""),
        ("SET1,9,1,THRU,4\nSET1          10       3      -1\n", ""),
    ],
)
def test_reals_without_a_point_are_noted(tmp_path: Path, card: str, named: str) -> None:
    """pyNastran takes 2e-08 for a real, MYSTRAN refuses it; the line stays, and the note names it and its place."""
    deck, done = written(tmp_path, (HEAD + "".join(map(free, bricks())) + card + "ENDDATA\n").encode())
    assert card in deck
    notes = [note for note in done.notes if note.startswith("reals without a decimal point")]
    assert [re.findall(r"(\S+) \(\S*model\.bdf:\d+\)", note) for note in notes] == ([[named]] if named else [])


def test_the_deck_is_not_written_over_the_model(tmp_path: Path) -> None:
    own = project(tmp_path, plain(bricks()))
    with pytest.raises(InputError, match="is a file of the model itself"):
        write_deck(own, tmp_path / "model.bdf")


def test_a_deck_that_does_not_read_back_is_not_written(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The old deck stays when the new one has lost a card on the way."""
    from tedm_cli.nastran.loads import unit_deck

    _, done = written(tmp_path, plain(bricks()))
    before = done.path.read_bytes()
    whole = unit_deck.kept_bulk
    for number, piece in ((3, "nodes 4"), (19, "elements 3"), (16, "properties 1"), (21, "SPC 1")):
        monkeypatch.setattr(
            unit_deck, "kept_bulk", lambda lines, n=number: ([t for i, t in enumerate(whole(lines)[0]) if i != n], [])
        )
        with pytest.raises(InputError, match=f"does not read back.*: {piece}\n"):
            written(tmp_path, plain(bricks()))
        assert done.path.read_bytes() == before
    assert [p.name for p in done.path.parent.iterdir()] == [done.path.name]


@pytest.mark.parametrize(("old", "new"), [("294.15", "294.151"), ("294.15", "294.1499"), ("293.15", "293.1501")])
def test_a_deck_whose_temperatures_are_rounded_is_not_written(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, old: str, new: str
) -> None:
    """A step must read back as one kelvin to the last digit, and the rest as the reference."""
    from tedm_cli.nastran.loads import unit_deck

    cards = unit_deck.temperature_cards
    monkeypatch.setattr(
        unit_deck,
        "temperature_cards",
        lambda *args: [line.replace(old.rjust(8), new.rjust(8)) for line in cards(*args)],
    )
    with pytest.raises(InputError, match=r"does not read back.*(step|temperatures) of subcase 1 \(LEFT\)"):
        written(tmp_path, plain(bricks("293.15")))
