"""Decks of a few elements for the tests of masses."""

from __future__ import annotations

from pathlib import Path

from tedm_cli.nastran.geometry import ModelGeometry, model_geometry
from tedm_cli.nastran.reading import read_deck

# Four corners of a plate of 2 x 1 m, four more 3 m above, and two on the x axis.
GRIDS = {
    1: (0.0, 0.0, 0.0),
    2: (2.0, 0.0, 0.0),
    3: (2.0, 1.0, 0.0),
    4: (0.0, 1.0, 0.0),
    5: (0.0, 0.0, 3.0),
    6: (2.0, 0.0, 3.0),
    7: (2.0, 1.0, 3.0),
    8: (0.0, 1.0, 3.0),
}
MATERIALS = """MAT1,1,7.+10,,.3,1000.
MAT1,2,7.+10,,.3,3000.
MAT8,8,7.+10,7.+10,.3,3.+10,,,2000."""


def deck(cards: str, grids: dict[int, tuple[float, float, float]] = GRIDS, *, control: str = "", cp: str = "") -> str:
    """Text of a deck; `cp` is the coordinate system (CP) of its grids."""
    lines = [f"GRID,{i},{cp},{x!r},{y!r},{z!r}" for i, (x, y, z) in grids.items()]
    return f"SOL 101\nCEND\n{control}\nBEGIN BULK\n" + "\n".join(lines) + f"\n{MATERIALS}\n{cards}\nENDDATA\n"


def read(folder: Path, text: str) -> ModelGeometry:
    path = folder / "model.bdf"
    path.write_text(text, encoding="ascii")
    return model_geometry(read_deck(path), [path])
