"""A deck with every kind of element under forces, moments, accelerations and motions of its supports."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from fem_models import nearest, solid_mesh
from pyNastran.bdf.field_writer_8 import print_float_8

SIZE = (0.3, 0.2, 0.1)


def numbers(*values: float) -> str:
    """Numbers in fields of eight columns, which is what MYSTRAN reads of free ones."""
    return ",".join(print_float_8(value).strip() for value in values)


def card(name: str, *fields: object) -> str:
    """In free format, ten fields a line; numbers that are not whole in eight columns."""
    words = [numbers(float(f)) if isinstance(f, float | np.floating) else str(f) for f in fields]
    return "\n".join(",".join([name if k == 0 else "", *words[k : k + 8]]) for k in range(0, len(words), 8))


def solids(card_name: str, nodes: int, counts: tuple[int, int, int], first: int, shift: float) -> tuple[list[str], int]:
    """A block of solids, held at its end x = 0 by SPC set 1; grids and elements from `first`."""
    position, corners = solid_mesh(card_name, nodes, counts, SIZE)
    pid = first
    cards = [card("GRID", first + k, "", float(x) + shift, float(y), float(z)) for k, (x, y, z) in enumerate(position)]
    cards += [card(card_name, first + k, pid, *(ids + first)) for k, ids in enumerate(corners)]
    cards += [f"PSOLID,{pid},1" if card_name == "CTETRA" else f"PSOLID,{pid},1,0,TWO,,FULL"]
    cards += [card("SPC1", 1, 123, *(np.flatnonzero(position[:, 0] < 1e-9) + first))]
    return cards, first + nearest(position, (0.3, 0.2, 0.1))


def bulk(moved: tuple[tuple[int, int, float], ...] = ()) -> list[str]:
    """Blocks of solids, a plate of quadrilaterals and triangles, a frame of bars and rods, rigid elements, masses.

    Components that are `moved` by SPC cards are held by no SPC1, where MYSTRAN would refuse them.
    """
    cards, tips = [], []
    for kind, nodes, counts, first, shift in (
        ("CHEXA", 8, (3, 2, 2), 1000, 0.0),
        ("CTETRA", 10, (2, 1, 1), 2000, 1.0),
        ("CPENTA", 6, (3, 2, 1), 3000, 2.0),
    ):
        some, tip = solids(kind, nodes, counts, first, shift)
        cards += some
        tips.append(tip)
    # A cantilever plate of parallelograms, half of them cut into triangles, with an offset; held at its left side.
    cards += [card("GRID", 1 + 4 * i + j, "", 0.1 * i + 0.02 * j, 0.1 * j, 0.5) for i in range(5) for j in range(4)]
    e = 0
    for i in range(4):
        for j in range(3):
            a, b, c, d = 1 + 4 * i + j, 5 + 4 * i + j, 6 + 4 * i + j, 2 + 4 * i + j
            for ids in [(a, b, c, d)] if i < 2 else [(a, b, c), (a, c, d)]:
                e += 1
                cards.append(card("CQUAD4" if len(ids) == 4 else "CTRIA3", e, 1, *ids, *([""] if i < 2 else []), 0.003))
    # A space frame: oblique bars with offsets, I12 and hinges, rods; a grid on an RBE2, one on an RBE3.
    frame = {41: (0.0, 1.0, 0.0), 42: (0.5, 1.1, 0.05), 43: (0.9, 1.0, 0.2), 44: (0.5, 1.3, 0.4), 45: (0.2, 1.2, 0.6)}
    frame |= {46: (0.55, 1.2, 0.1), 47: (0.4, 0.2, 0.6)}
    cards += [card("GRID", k, "", *place, 7 if k == 44 else "") for k, place in frame.items()]
    return [
        *cards,
        "CORD2R,7,,0.,0.,0.,0.,.6,.8\n,1.,.1,0.",
        "CORD2C,8,,.1,0.,0.,.1,0.,1.\n,1.,0.,0.",
        *("PSHELL,1,1,.002,1,,1,,3.", "CROD,51,5,42,45", "CROD,52,5,44,45", "PROD,5,1,2.-5,1.-10,,.4"),
        "CBAR,61,6,41,42,.1,1.,.3\n,,,.01,.02,-.01,0.,.03,.01",
        "CBAR,62,7,42,43,.1,1.,.3\n,5,46",
        "CBAR,63,6,42,44,1.,.2,0.",
        "PBAR,6,1,1.-4,2.-9,5.-9,6.-9,.3\n,\n,.8,.6",
        "PBAR,7,1,1.-4,3.-9,4.-9,6.-9\n,\n,,,1.-9",
        "MAT1,1,7.+10,,.3,2700.,,20.",
        "RBE2,71,42,123456,46",
        "RBE3,72,,47,123456,1.,123,14,18\n,19,20",
        *("CONM2,81,46,,2.,.01,-.02,.03\n,.003,0.,.004,0.,0.,.005", "CONM2,82,47,,.5"),
        *(f"CONM2,{90 + k},{tip},,.7" for k, tip in enumerate(tips)),
        *(f"SPC1,1,{held(grid, moved)},{grid}" for grid in (1, 2, 3, 4, 41, 43, 45)),
        *(card("SPC", 1, *one) for one in moved),
        *("PARAM,K6ROT,0.", "PARAM,POST,-1"),
        *loads(tips),
    ]


def held(grid: int, moved: tuple[tuple[int, int, float], ...]) -> str:
    return "".join(digit for digit in "123456" if (grid, int(digit)) not in {one[:2] for one in moved})


def loads(tips: list[int]) -> list[str]:
    """Sets 11 to 14, tension and bending, torsion, weight along two systems, and a sum of them, 17."""
    return [
        *(f"FORCE,11,{tip},,100.,.3,-1.,2." for tip in tips),
        *(
            "FORCE,11,20,8,10.,1.,.5,2.",
            "FORCE,11,44,7,20.,1.,2.,-1.",
            "FORCE,11,46,,30.,0.,1.,1.",
            "FORCE,11,47,,5.,1.,0.,2.",
        ),
        *("MOMENT,12,46,,3.,1.,.2,.3", "MOMENT,12,44,7,2.,0.,1.,1.", "MOMENT,12,47,8,1.,.2,1.,0."),
        *(f"FORCE,12,{tip},,50.,0.,1.,0." for tip in tips),
        "GRAV,13,,9.80665,.1,-.2,-1.",
        "GRAV,14,7,3.,1.,0.,0.",
        "LOAD,17,2.,1.5,11,-1.,12,.5,13",
    ]


MOTIONS = ((41, 1, 1e-4), (43, 3, -2e-4), (41, 5, 2e-4), (1, 3, 1e-5), (45, 2, 3e-4))
"""Grids, components and values of supports that move."""

CASES = (11, 12, 13, 14, 17)


def control(cases: tuple[int, ...] = CASES) -> str:
    return "SOL 101\nCEND\nSPC = 1\n" + "".join(
        f"SUBCASE {k}\n  LABEL = C{k}\n  LOAD = {k}\n  DISPLACEMENT(PLOT) = ALL\n" for k in cases
    )


def deck(folder: Path, cards: list[str], cases: tuple[int, ...] = CASES) -> Path:
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / "deck.bdf"
    path.write_text(f"{control(cases)}BEGIN BULK\n" + "\n".join(cards) + "\nENDDATA\n")
    return path
