"""The small sample with one concentrated mass more, on a lever."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from tedm_cli.config.project import Project, load_project

SMALL = Path(__file__).parents[2] / "sample_models" / "small"
LEVER = np.array([0.05, 0.02, 0.03])


def with_mass(folder: Path, grid: int) -> Project:
    """The small sample with 0.5 kg more, off `grid` by the lever; its results are massless and stay as they are."""
    return changed_small(folder, f"CONM2,900077,{grid},,0.5,{LEVER[0]},{LEVER[1]},{LEVER[2]}\n")


def changed_small(folder: Path, card: str = "", tables: str = "") -> Project:
    """The small sample in a folder of its own, with a card more in its deck and tables more in its model.toml."""
    deck = (SMALL / "unit_loads.bdf").read_text(encoding="ascii")
    (folder / "unit_loads.bdf").write_text(deck.replace("ENDDATA", card + "ENDDATA"), encoding="ascii")
    model = (SMALL / "model.toml").read_text(encoding="utf-8")
    model = model.replace('op2 = ["unit_loads.op2"]', f'op2 = ["{(SMALL / "unit_loads.op2").resolve()}"]')
    model = model.replace('"ltp_small_areas.csv"', f'"{(SMALL / "ltp_small_areas.csv").resolve()}"')
    (folder / "model.toml").write_text(model + tables, encoding="utf-8")
    project = (SMALL / "tedm.toml").read_text(encoding="utf-8")
    configs = (SMALL / "../../configs").resolve()
    project = project.replace("../../configs", str(configs)).replace('"thermal.toml"', f'"{SMALL}/thermal.toml"')
    (folder / "tedm.toml").write_text(project, encoding="utf-8")
    return load_project(folder / "tedm.toml", folder / "build")
