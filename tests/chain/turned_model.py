"""The small sample turned and shifted as one: its grids, its layout's frame, its test masses. Nothing is solved anew.

All grids are given, move and are loaded in a coordinate system of their own, so that what the solver found in it holds
wherever the system stands.
"""

from __future__ import annotations

import re
import shutil
from pathlib import Path

import numpy as np
from shipped_cases import cases_of_areas

from tedm_cli.arrays import FloatArray
from tedm_cli.config.project import Project, load_project

ROOT = Path(__file__).parents[2]
SMALL = ROOT / "sample_models" / "small"
CONFIGS = ROOT / "configs"
FRAME = 7


def turned_deck(text: str, origin: FloatArray, axes: FloatArray) -> str:
    """The unit-load deck with all grids in the coordinate system of this origin and these axes (rows)."""
    lines = []
    for line in text.splitlines():
        if line.startswith("GRID*"):
            lines.append(f"{line[:24]}{FRAME:16d}{line[40:]}")
        elif line.startswith("*"):
            lines.append(f"{line.rstrip():<24}{FRAME:16d}")
        else:
            lines.append(line)
    a = [f"{v:16.9e}" for point in (origin, origin + axes[2], origin + axes[0]) for v in point]
    card = [f"CORD2R* {FRAME:16d}{0:16d}" + "".join(a[:2])]
    card += ["*       " + "".join(a[2:6]), "*       " + "".join(a[6:])]
    begin = lines.index("BEGIN BULK") + 1
    return "\n".join([*lines[:begin], *card, *lines[begin:]]) + "\n"


def turned_project(folder: Path, origin: FloatArray, axes: FloatArray, *, side_m: str = "0.046") -> Project:
    """A project in `folder`, with the x, y, z of the sample along `axes` (rows) and its origin at `origin` (m)."""
    folder.mkdir()
    (folder / "unit_loads.bdf").write_text(turned_deck((SMALL / "unit_loads.bdf").read_text(), origin, axes))
    shutil.copy(SMALL / "unit_loads.op2", folder)
    shutil.copy(SMALL / "ltp_small_areas.csv", folder)
    (folder / "cases.toml").write_text(cases_of_areas())
    model = (SMALL / "model.toml").read_text()
    for x in (-0.188, 0.188):
        place = (origin + np.array([x, 0.0, 0.0]) @ axes).tolist()
        model = model.replace(f"position_m = [{x}, 0.0, 0.0]", f"position_m = {place}\naxes = {axes.tolist()}")
    (folder / "model.toml").write_text(model.replace("side_m = 0.046", f"side_m = {side_m}"))
    (folder / "optics.toml").write_text(turned_layout((CONFIGS / "optics.toml").read_text(), origin, axes))
    (folder / "tedm.toml").write_text('title = "turned small sample"\n')
    return load_project(folder / "tedm.toml", folder / "build")


def turned_layout(text: str, origin: FloatArray, axes: FloatArray) -> str:
    """The layout with another frame."""
    frame = f"[frame]\norigin_m = {origin.tolist()}\naxes = {axes.tolist()}\n\n[tolerances]"
    text, count = re.subn(r"\[frame\].*?\n\[tolerances\]", frame, text, flags=re.S)
    assert count == 1
    return text
