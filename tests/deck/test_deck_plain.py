"""Plain cards read as columns: the bits that pyNastran reads alone, in every form, and its judgement of the others."""

from __future__ import annotations

import contextlib
import io
import random
import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pyNastran.bdf.bdf import BDF

from tedm_cli.errors import InputError
from tedm_cli.nastran.bulk.columns import columns_of
from tedm_cli.nastran.bulk.numbers import integers, padded, reals, window
from tedm_cli.nastran.reading import cross_reference, deck_files, read_deck

HEAD = "SOL 101\nCEND\nTEMPERATURE(LOAD) = 1\nBEGIN BULK\n"
REST = [
    "MAT1,1,7.+10,,.33,2700.,2.3-5,0.",
    "PSOLID,1,1",
    "PSHELL,2,1,.01,1",
    "CORD2R,5,,0.,0.,0.,0.,0.,1.",
    ",1.,0.,0.",
    "TEMPD,1,20.",
]
NODES = {"CHEXA": (8, 20), "CPENTA": (6, 15), "CTETRA": (4, 10), "CPYRAM": (5, 13), "CQUAD4": (4,), "CTRIA3": (3,)}


def alone(path: Path) -> Any:
    """The deck as pyNastran reads it without us."""
    model = BDF(debug=None)
    with contextlib.redirect_stdout(io.StringIO()):
        model.read_bdf(str(path), xref=False, encoding="latin-1")
    return model


def require_same(path: Path, *, plain: bool = True) -> Any:
    """Read a deck both ways; the columns and the cards made of them are what pyNastran reads, to the bit."""
    theirs, model = alone(path), read_deck(path, cross_reference=False)
    assert (model.tedm_how is not None) == plain
    ours = columns_of(model)
    grids = [theirs.nodes[i] for i in sorted(theirs.nodes)]
    assert ours.grid.id.tolist() == [g.nid for g in grids]
    assert ours.grid.xyz.tobytes() == np.array([g.xyz for g in grids], dtype=float).tobytes()
    assert [*zip(ours.grid.cp.tolist(), ours.grid.cd.tolist(), strict=True)] == [(g.cp, g.cd) for g in grids]
    elements = [theirs.elements[i] for i in sorted(theirs.elements)]
    e = ours.element
    assert e.id.tolist() == [x.eid for x in elements]
    assert e.card.tolist() == [x.type for x in elements]
    assert e.property_id.tolist() == [x.pid for x in elements]
    parts = np.split(e.node_id, e.node_offset[1:-1])
    assert [p.tolist() for p in parts] == [[n or 0 for n in x.nodes] for x in elements]
    for table in ("nodes", "elements"):
        for number, card in getattr(theirs, table).items():
            found = getattr(model, table)[number]
            assert (type(found), found.raw_fields()) == (type(card), card.raw_fields())
    temperatures = {
        sid: [(grid, t.hex()) for card in cards for grid, t in card.temperatures.items()]
        for sid, cards in sorted(theirs.loads.items())
    }
    assert {
        sid: [(grid, t.hex()) for grid, t in zip(of.grid_id.tolist(), of.value.tolist(), strict=True)]
        for sid, of in ours.temperature_sets.items()
    } == temperatures
    counts = {k: n for k, n in theirs.card_count.items() if n}
    assert {k: n for k, n in model.card_count.items() if n} == counts
    return model


def number(choose: random.Random, width: int) -> str:
    """A real number as people and programs write it."""
    value = choose.choice([0.0, 1.0, choose.uniform(-10, 10), choose.gauss(0, 1) * 10.0 ** choose.randint(-12, 12)])
    digits = choose.randint(1, width - 6)
    form = choose.choice(["fixed", "e", "E", "D", "d", "bare"])
    if form == "fixed":
        text = f"{value:.{min(digits, 6)}f}"
        text = text if len(text) <= width else f"{value:.0e}"
    else:
        mantissa, exponent = f"{value:.{max(digits - 4, 0)}e}".split("e")
        sign = choose.choice(["+", "-"]) if form == "bare" else choose.choice(["", "+", "-"])
        letter = "" if form == "bare" else form
        text = f"{mantissa if '.' in mantissa else mantissa + '.'}{letter}{sign}{abs(int(exponent))}"
    if "." not in text:
        text = text.replace("e", ".e")
    if re.match(r"-?0\.\d", text) and choose.random() < 0.5:
        text = text.replace("0.", ".", 1)
    return text if len(text) <= width else "1."


def written(choose: random.Random, fields: Sequence[str]) -> str:
    """A card in small, large or free fields, with names of continuations or without."""
    name, data = fields[0], list(fields[1:])
    form = choose.choice(["small", "large", "free", "tabs"])
    if form == "tabs" and any(len(f) > 7 for f in data):
        form = "small"
    if form == "small" and any(len(f) > 8 for f in data):
        form = "large"
    per_line = 4 if form == "large" else 8
    lines = [data[k : k + per_line] for k in range(0, len(data), per_line)]
    if name == "GRID" and form == "large" and len(lines) == 1:
        lines.append([])
    named, out = choose.random() < 0.5, []
    upper = name if choose.random() < 0.8 else name.lower()
    for k, line in enumerate(lines):
        mark = f"+{k}A" if named else ""
        follows = f"+{k + 1}A" if named and k + 1 < len(lines) else ""
        if form == "free":
            pad = choose.choice(["", " "])
            begin = upper if k == 0 else mark or choose.choice(["", "+"])
            row = [begin, *(pad + f for f in line)]
            if follows:
                row += [""] * (9 - len(row)) + [follows]
            out.append(",".join(row))
        else:
            star = "*" if form == "large" else ""
            begin = upper + star if k == 0 else (mark.replace("+", "*") if star else mark) or star
            width = 16 if star else 8
            side = choose.choice(["<", ">", "^"])
            text = f"{begin:<8}" + "".join(f"{f:{side}{width}}" for f in line)
            if follows:
                text = f"{text:<72}" + (follows.replace("+", "*") if star else follows)
            if form == "tabs" and not named:
                text = "\t".join([begin, *line])
            out.append(text.rstrip() if k == 0 or not star else text)
    return "\n".join(out)


def random_deck(choose: random.Random) -> list[str]:
    """Cards of a deck of all kinds that are read as columns, and of others between them."""
    ids = choose.sample(range(1, 10**8), 24)
    cards = []
    for i in ids:
        ends = choose.choice([[], [choose.choice(["", "0", "5"])], ["", choose.choice(["1", "123456", "24"])]])
        xyz = [choose.choice([number(choose, 8), number(choose, 16), ""]) for _ in range(3)]
        cards.append(written(choose, ["GRID", str(i), choose.choice(["", "0", "5"]), *xyz, *ends]))
    used = choose.sample(range(1, 10**8), 30)
    for eid in used:
        name = choose.choice(list(NODES))
        nodes = choose.sample(ids, choose.choice(NODES[name]))
        fields = [name, str(eid), "2" if name in ("CQUAD4", "CTRIA3") else "1", *map(str, nodes)]
        if len(nodes) < 5 and name.startswith(("CQ", "CT")) and name != "CTETRA":
            fields += choose.choice([[], [number(choose, 8)], ["5"], ["", number(choose, 8)]])
        cards.append(written(choose, fields))
    for _ in range(20):
        grids = choose.sample(ids, choose.randint(1, 3))
        pairs = [text for g in grids for text in (str(g), number(choose, choose.choice([8, 16])))]
        cards.append(written(choose, ["TEMP", choose.choice("12"), *pairs]))
    cards += [
        "$ a comment",
        "",
        "   $ 1 and words",
        f"CBAR,{max(used) + 1},9,{ids[0]},{ids[1]},0.,1.,0.",
        "PBAR,9,1,1.,1.,1.",
    ]
    cards += [f"CONM2,{max(used) + 2},{ids[2]},,1.", f"GRID,{max(ids) + 1},,1.,2.,3. $ with a note"]
    choose.shuffle(cards)
    return cards


@pytest.mark.parametrize("seed", range(6))
def test_random_decks_are_read_to_the_bit(tmp_path: Path, seed: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """In any form, in files that include each other, and in blocks that end anywhere."""
    choose = random.Random(seed)
    monkeypatch.setattr("tedm_cli.nastran.bulk.streamed._BLOCK", choose.choice([499, 4999, 1 << 22]))
    cards, end = random_deck(choose), choose.choice(["\n", "\r\n"])
    half = len(cards) // 2
    (tmp_path / "more.inc").write_bytes((end.join("\n".join(cards[half:]).split("\n")) + end).encode())
    text = HEAD + "\n".join([*REST, *cards[:half], "INCLUDE 'more.inc'", "ENDDATA", "left over"])
    (tmp_path / "model.bdf").write_bytes(end.join(text.split("\n")).encode())
    model = require_same(tmp_path / "model.bdf")
    columns = columns_of(model)
    assert len(columns.plain_grids.id) > 18
    assert sum(len(p.id) for p in columns.plain_elements.values()) > 24
    assert len(deck_files(model, tmp_path / "model.bdf")) == 2


def test_every_number_that_is_read_is_that_of_pynastran() -> None:
    """Of strings of all characters of numbers: what is read is float() of it, and what is no number is not read."""
    choose = random.Random(3)
    texts = ["".join(choose.choice("0123456789.+-eEdD ") for _ in range(choose.randint(1, 9))) for _ in range(20000)]
    texts += [number(choose, 9) for _ in range(20000)]
    data = "".join(f"{t:<9}" for t in texts).encode()
    start = 9 * np.arange(len(texts))
    field = window(padded(data), start, start + 9, 9)
    real, whole = reals(field), integers(field)
    assert real.read.sum() > 20000
    for row, text in enumerate(texts):
        stripped = text.strip()
        if real.read[row] and not real.blank[row]:
            plain = stripped.lower().replace("d", "e")
            with contextlib.suppress(ValueError):
                assert real.value[row].tobytes() == np.float64(float(plain)).tobytes()
                continue
            sign = max(plain.rfind("+"), plain.rfind("-"))
            assert real.value[row].tobytes() == np.float64(float(f"{plain[:sign]}e{plain[sign:]}")).tobytes()
        assert real.blank[row] == whole.blank[row] == (not stripped) or not whole.read[row] or stripped.isdecimal()
        if whole.read[row] and stripped:
            assert whole.value[row] == int(stripped)
    assert not whole.read[[i for i, t in enumerate(texts) if t.strip() and not t.strip().isdecimal()]].any()


PLAIN = [*REST, "GRID,1,,0.,0.,0.", "GRID,2,,1.,0.,0.", "GRID,3,,0.,1.,0.", "GRID,4,,0.,0.,1.", "CTETRA,1,1,1,2,3,4"]


def deck(path: Path, cards: Sequence[str], head: str = HEAD) -> Path:
    path.write_text(head + "\n".join([*cards, "ENDDATA", ""]))
    return path


@pytest.mark.parametrize(
    "cards",
    [
        ["GRID,1,,0.,0.,0."],  # a copy
        ["GRID,5,,0.,0.,0.", "$              5"],  # fields that are commented out
        ["GRID,5,,0.,0.,0.", "INCLUDE 'more.inc'", "+,1"],  # goes on after the file
        ["INCLUDE 'torn.inc'"],  # goes on in the file
        ["INCLUDE 'end.inc'"],  # ends the data
    ],
    ids=["copy", "numbers alone", "after INCLUDE", "in INCLUDE", "ENDDATA in INCLUDE"],
)
def test_pynastran_alone_judges_what_is_not_plain(tmp_path: Path, cards: list[str]) -> None:
    """Decks that are one by what stands around their cards, whether they are read or refused."""
    (tmp_path / "more.inc").write_text("GRID,6,,0.,0.,0.\n")
    (tmp_path / "torn.inc").write_text(",,,\nGRID,7,,0.,0.,0.\n")
    (tmp_path / "end.inc").write_text("ENDDATA\n")
    path = deck(tmp_path / "model.bdf", [*PLAIN, *cards])
    with pytest.MonkeyPatch.context() as patch, contextlib.suppress(InputError):
        patch.setattr("tedm_cli.nastran.bulk.views.CardTable.__getitem__", lambda *_: pytest.fail("made of a column"))
        model = read_deck(path, cross_reference=False)
        assert model.tedm_how is None
        assert not len(columns_of(model).plain_grids.id)


@pytest.mark.parametrize(
    ("cards", "fact"),
    [
        (["GRID,5,,0.,0.,1"], "GRID 5: field 5 (x3) is '1', and must be a float or blank"),
        (["GRID,5,,0.,0.,nan"], "GRID 5: nan is no number"),
        (["GRID,1,,0.,0.,9."], "GRID 1"),
        (["CTETRA,2,1,1,2,3,99"], "99"),
        (["CTETRA,2,77,1,2,3,4"], "77"),
        (["GRID,5,8,0.,0.,1."], "8"),
        (["GRID     5             0.      0.      0.      0.      0.             0.         9"], "columns"),
    ],
    ids=["no point", "nan", "twice", "no grid", "no property", "no frame", "long"],
)
def test_errors_name_file_and_line(tmp_path: Path, cards: list[str], fact: str) -> None:
    """As pyNastran alone finds them, also where the deck is cross-referenced later."""
    path = deck(tmp_path / "model.bdf", [*PLAIN, "$ a word", "", *cards])
    with pytest.raises(InputError) as first:
        read_deck(path)
    with pytest.raises(InputError) as later:
        cross_reference(read_deck(path, cross_reference=False), path)
    assert str(first.value) == str(later.value)
    assert fact in first.value.fact
    assert first.value.where == f"{path}:{HEAD.count(chr(10)) + len(PLAIN) + 3}"


def test_defaults_of_grids_hold_for_plain_ones(tmp_path: Path) -> None:
    """GRDSET, as pyNastran has it: the displacement frame alone, once the model is cross-referenced."""
    path = deck(tmp_path / "model.bdf", [*PLAIN, "GRDSET,,,,,,5"])
    theirs = alone(path)
    theirs.cross_reference(xref_loads=False)
    model = read_deck(path)
    assert model.tedm_how is not None
    assert columns_of(model).grid.cd.tolist() == [theirs.nodes[i].Cd() for i in range(1, 5)] == [5] * 4
    assert [model.nodes[i].Cd() for i in range(1, 5)] == [5] * 4


def test_places_of_other_cards_are_those_of_the_file(tmp_path: Path) -> None:
    """Plain cards before them are no longer among the lines that pyNastran counts."""
    (tmp_path / "more.inc").write_text("GRID,6,,0.,0.,0.\n$ note\nPARAM,WTMASS,1.\n")
    path = deck(tmp_path / "model.bdf", [*PLAIN, "PARAM,POST,-1", "GRID,5,,0.,0.,0.", "INCLUDE 'more.inc'"])
    model = read_deck(path, cross_reference=False)
    assert model.tedm_how is not None
    assert model.tedm_parameters == {"POST": f"{path}:16", "WTMASS": f"{tmp_path / 'more.inc'}:3"}
    assert sorted(model.nodes) == [1, 2, 3, 4, 5, 6]


def test_case_control_of_a_file_is_no_bulk_data(tmp_path: Path) -> None:
    (tmp_path / "control.inc").write_text("TEMPERATURE(LOAD) = 1\n")
    head = "SOL 101\nCEND\nINCLUDE 'control.inc'\nBEGIN BULK\n"
    model = read_deck(deck(tmp_path / "model.bdf", PLAIN, head), cross_reference=False)
    assert model.tedm_how is not None
    assert len(columns_of(model).plain_grids.id) == 4
    (tmp_path / "control.inc").write_text("TEMPERATURE(LOAD) = 1\nBEGIN BULK\n")
    head = "SOL 101\nCEND\nINCLUDE 'control.inc'\n"
    assert read_deck(deck(tmp_path / "model.bdf", PLAIN, head), cross_reference=False).tedm_how is None
