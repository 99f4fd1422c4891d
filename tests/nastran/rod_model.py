"""A chain of rods through any grids in any frames: the least deck whose unit loads can be read."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path

import numpy as np

from tedm_cli.nastran.geometry import ModelGeometry, model_geometry
from tedm_cli.nastran.loads.unit_loads import UnitLoad
from tedm_cli.nastran.reading import deck_files, read_deck

Grid = tuple[int, int, Sequence[float], int]  # id, CP, coordinates, CD


def grid_card(grid: Grid) -> str:
    number, cp, (a, b, c), cd = grid
    return f"GRID*   {number:>16}{cp:>16}{a:>16.9f}{b:>16.9f}\n*       {c:>16.9f}{cd:>16}"


def rod_cards(ids: Sequence[int]) -> str:
    rods = [f"CROD,{90000 + i},99,{a},{b}" for i, (a, b) in enumerate(pairwise(ids))]
    return "\n".join([*rods, "PROD,99,99,1.-4", "MAT1,99,7.+10,,.3,2700.,2.-5"])


def write_deck(path: Path, grids: Sequence[Grid], cards: str = "", control: str = "", rods: bool = True) -> Path:
    body = [grid_card(g) for g in grids] + ([rod_cards([g[0] for g in grids])] if rods else [])
    text = "\n".join(["SOL 101", "CEND", *([control] if control else []), "BEGIN BULK", *body, cards, "ENDDATA", ""])
    path.write_text(text, encoding="ascii")
    return path


def read(path: Path) -> tuple[object, ModelGeometry]:
    model = read_deck(path)
    return model, model_geometry(model, deck_files(model, path))


def one_load(geometry: ModelGeometry, label: str = "ALL", output: str = "") -> UnitLoad:
    return UnitLoad(1, label, np.arange(len(geometry.grid_id)), 1.0, output)
