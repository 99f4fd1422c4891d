"""A small model as cards, in any format Nastran reads, and a project around it."""

from __future__ import annotations

import contextlib
import io
import random
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from unittest import mock

from tedm_cli.cli import main
from tedm_cli.config.project import Project, load_project
from tedm_cli.nastran.reading import any_encoding
from tedm_cli.stages.model.deck import DeckSummary, write_deck

Card = tuple[str, ...]
HEAD = "SOL 101\nCEND\nSPC = 1\nBEGIN BULK\n"
LEFT, RIGHT = range(1, 9), range(9, 13)
MODEL_TOML = """\
[model]
bdf = "model.bdf"
areas_csv = "areas.csv"
deck = "run/unit_loads.bdf"
op2 = ["results/unit_loads.op2"]
{more}
[areas]
rule = [{{ match = "*", group = "bricks", shield = "inside" }}]

[[test_mass]]
name = "TM1"
position_m = [0.1, 0.2, 0.0]
side_m = 0.046
mass_kg = 1.96
"""


def bricks(tref: str = "", first_id: int = 0) -> list[Card]:
    """Two bricks of 0.1 m, held at one end, and a bar on the other."""
    n = first_id
    cards: list[Card] = []
    for i, x in enumerate(("0.", ".1", ".2")):
        for j, (y, z) in enumerate((("0.", "0."), (".1", "0."), (".1", ".1"), ("0.", ".1"))):
            cards.append(("GRID", str(n + 4 * i + j + 1), "", x, y, z))
    cards += [
        ("CHEXA", "1", "1", *(str(n + i) for i in range(1, 9))),
        ("CHEXA", "2", "1", *(str(n + i) for i in range(5, 13))),
        ("PSOLID", "1", "1"),
        ("MAT1", "1", "7.+10", "", ".33", "2700.", "2.3-5", tref),
        ("SPC1", "1", "123", *(str(n + i) for i in range(1, 5))),
        ("CBAR", "3", "2", str(n + 9), str(n + 11), "1.", "0.", "0."),
        ("PBAR", "2", "1", "1.-4", "1.-9", "1.-9", "2.-9"),
        ("SPC1", "1", "456", str(n + 9), str(n + 11)),
    ]
    return cards


def small(card: Card) -> str:
    lines = [card[1:][k : k + 8] for k in range(0, len(card) - 1, 8)]
    return "".join(
        (card[0] if i == 0 else "").ljust(8) + "".join(f.rjust(8) for f in fields) + "\n"
        for i, fields in enumerate(lines)
    )


def large(card: Card) -> str:
    rows = [card[1:][k : k + 4] for k in range(0, len(card) - 1, 4)]
    if len(rows) % 2:
        rows.append(())
    return "".join(
        ((card[0] if i == 0 else "") + "*").ljust(8) + "".join(f.rjust(16) for f in fields) + "\n"
        for i, fields in enumerate(rows)
    )


def free(card: Card, separator: str = ",") -> str:
    rows = [card[1:][k : k + 8] for k in range(0, len(card) - 1, 8)]
    return "".join(separator.join([card[0] if i == 0 else "", *fields]) + "\n" for i, fields in enumerate(rows))


def tabs(card: Card) -> str:
    return free(card, "\t")


def project(folder: Path, model: str | bytes, more: str = "", areas: dict[str, Sequence[int]] | None = None) -> Project:
    """A project whose model file has this text."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "model.bdf").write_bytes(model if isinstance(model, bytes) else model.encode("latin-1"))
    (folder / "model.toml").write_text(MODEL_TOML.format(more=more))
    parts = areas or {"LEFT": LEFT, "RIGHT": RIGHT}
    rows = [f"{i},{name}" for name, ids in parts.items() for i in ids]
    (folder / "areas.csv").write_text("\n".join(["node_id,area", *rows]) + "\n")
    (folder / "tedm.toml").write_text('title = "bricks"\n')
    return load_project(folder / "tedm.toml", folder / "build")


def written(folder: Path, model: str | bytes, more: str = "", **areas: Sequence[int]) -> tuple[str, DeckSummary]:
    """The unit-load deck of this model, and what write-deck says of it."""
    done = write_deck(project(folder, model, more, areas or None), None)
    return done.path.read_bytes().decode("latin-1"), done


def plain(cards: Sequence[Card], head: str = HEAD) -> str:
    return head + "".join(small(card) for card in cards) + "ENDDATA\n"


def disguised(cards: Sequence[Card], folder: Path, seed: int) -> None:
    """The same model in `folder/model.bdf`: every card in some format and case, in nested includes, with comments."""
    choose = random.Random(seed)
    folder.mkdir(parents=True, exist_ok=True)
    end = choose.choice(["\n", "\r\n"])

    def text(card: Card) -> str:
        out = choose.choice([small, large, free, tabs])(card)
        return out.lower() if choose.random() < 0.4 else out

    def put(name: str, chunk: list[str], depth: int) -> None:
        lines = []
        for piece in chunk:
            if choose.random() < 0.15:
                lines.append(choose.choice(["$ a comment\n", "$ caf\xe9 '\n", "\n", "$include 'nothing'\n"]))
            lines.append(piece)
        if depth < 3 and len(lines) > 4:
            a, b = sorted(choose.sample(range(len(lines)), 2))
            other = f"part {depth}.inc" if choose.random() < 0.5 else f"part{depth}.inc"
            sub = choose.choice(["", "deep/"]) if depth == 0 else ""
            below = Path(name).parent / sub / other
            put(str(below), lines[a:b], depth + 1)
            cut = choose.randint(1, len(other) - 1)
            broken = other[:cut].strip() == other[:cut] and other[cut:].strip() == other[cut:] and choose.random() < 0.3
            quoted = sub + (other[:cut] + "\n   " + other[cut:] if broken else other)
            word = choose.choice(["INCLUDE", "include", "Include"])
            lines[a:b] = [f"{word} {choose.choice(['{0}{1}{0}'])}".format(choose.choice("'\""), quoted) + "\n"]
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_bytes("".join(lines).replace("\n", end).encode("latin-1"))

    put("bulk.inc", [text(card) for card in cards], 0)
    bulk = (folder / "bulk.inc").read_bytes().decode("latin-1")
    begin = choose.choice(["BEGIN BULK", "begin bulk  $ here", "BEGIN"])
    tail = choose.choice(["ENDDATA", "enddata" + end + "left over"])
    control = choose.choice(["SPC = 1", "spc=1 $ held", " SPC 1"])
    head = end.join(["$ main", choose.choice(["SOL 101", "sol sestatic"]), " CEND", control, begin, ""])
    (folder / "model.bdf").write_bytes((head + bulk + tail).encode("latin-1"))


def temperatures(deck: Path) -> dict[str, dict[int, float]]:
    """Temperatures that each subcase's TEMP cards give to grids, by label, as pyNastran alone reads them."""
    from pyNastran.bdf.bdf import BDF

    model = BDF(debug=None)
    with contextlib.redirect_stdout(io.StringIO()):
        model.read_bdf(str(deck), xref=False, encoding=any_encoding(model))
    out = {}
    for number, subcase in model.case_control_deck.subcases.items():
        if number:
            sid = subcase.get_parameter("TEMPERATURE(LOAD)")[0]
            cards = model.loads.get(sid, [])
            out[str(subcase.get_parameter("LABEL")[0])] = {n: t for c in cards for n, t in c.temperatures.items()}
    return out


@dataclass(frozen=True)
class Outcome:
    code: int
    out: str
    err: str


def tedm(*args: object) -> Outcome:
    """Run `tedm` with these arguments in this process."""
    out, err = io.StringIO(), io.StringIO()
    argv = ["tedm", *(str(a) for a in args)]
    with mock.patch.object(sys, "argv", argv), contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        try:
            main()
            code: object = 0
        except SystemExit as exc:
            code = exc.code or 0
    assert isinstance(code, int)
    return Outcome(code, out.getvalue(), err.getvalue())
