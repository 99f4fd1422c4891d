"""A small deck for the tests of the embedded solver."""

from __future__ import annotations

from fem_models import block_mesh, nearest

SIZE = (0.3, 0.2, 0.1)
CASE_CONTROL = """SOL 101
CEND
SPC = 4
DISPLACEMENT(PLOT) = ALL
SUBCASE 3
  LABEL = Left_Half, mixed Case
  TEMPERATURE(LOAD) = 31
SUBCASE 7
  LABEL = STRUT
  TEMP(LOAD) = 32
SUBCASE 99
  LABEL = UNIFORM
  TEMPERATURE = 99
BEGIN BULK
"""


def bulk() -> list[str]:
    """A block, a rigid hub (80) with a bar to a clamped foot (81), an optical grid (90), a plain grid for G0 (95)."""
    position, corners = block_mesh((2, 2, 2), SIZE)
    cards = [f"GRID,{k},,{x:.6f},{y:.6f},{z:.6f}" for k, (x, y, z) in enumerate(position, 1)]
    cards += ["GRID,80,,.15,.1,-.05", "GRID,81,,.15,.1,-.25,,123456", "GRID,90,,.1,.1,.2", "GRID,95,,1.,1.,-.05"]
    for k, nodes in enumerate(corners + 1, 1):
        cards.append(f"CHEXA,{k},1,{','.join(map(str, nodes[:6]))},\n,{nodes[6]},{nodes[7]}")
    bottom = [nearest(position, p) + 1 for p in ((0, 0, 0), (0.3, 0, 0), (0, 0.2, 0))]
    top = [nearest(position, p) + 1 for p in ((0, 0, 0.1), (0.3, 0, 0.1), (0, 0.2, 0.1), (0.3, 0.2, 0.1))]
    cards += [
        "PSOLID,1,1",
        "MAT1,1,7.+10,,.33,2700.,2.3-5,20.",
        "MAT1,2,4.5+10,,.28,1900.,4.-6,20.",
        "CONM2,70,80,,.15",
    ]
    cards += ["CBAR,60,2,80,81,95", "PBAR,2,2,1.131-4,4.637-9,3.-9,9.274-9", "CORD2R,5,,0.,0.,0.,0.,0.,1.,\n,1.,0.,0."]
    cards += [
        f"RBE2,61,80,123,{','.join(map(str, bottom))}",
        f"RBE3,62,,90,123456,1.,123,{top[0]},{top[1]},\n,2.,123,{top[2]},{top[3]}",
    ]
    cards += ["PARAM,POST,-1", "PARAM,AUTOSPC,YES", "SPCADD,4,5", "FORCE,12,1,0,1.,1.,0.,0."]
    cards += [
        f"SPC1,5,1,{nearest(position, (0.3, 0.2, 0.1)) + 1}",
        f"SPC,5,{nearest(position, (0, 0.2, 0.1)) + 1},1,0.",
    ]
    cards += ["TEMPD,31,20.", *(f"TEMP,31,{k},21." for k in range(1, 10)), "TEMPD,32,20.", "TEMP,32,80,21.,81,21."]
    return [*cards, "TEMPD,99,21."]


def write_deck(folder, cards=None, control=CASE_CONTROL):
    path = folder / "deck.bdf"
    path.write_text(control + "\n".join(bulk() if cards is None else cards) + "\nENDDATA\n")
    return path
