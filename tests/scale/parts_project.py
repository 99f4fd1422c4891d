"""The small sample, lumped, with its results in eight OP2 files, a tied compensation mass and uncertain positions."""

from __future__ import annotations

import re
import shutil
from collections.abc import Callable
from pathlib import Path

from tedm_cli.arrays import FloatArray
from tedm_cli.config.project import Project, load_project
from tedm_cli.nastran.op2.reader import open_op2
from tedm_cli.nastran.op2.writer import write_op2

ROOT = Path(__file__).parents[2]
SMALL = ROOT / "sample_models" / "small"
FILES = [f"results/batch{n}.op2" for n in range(1, 9)]
MORE = """
[[compensation_mass]]
name = "CM1"
centre_m = [-0.188, -0.126, 0.0]
size_m = 1e-3
mass_kg = 0.5
grid = 850001

[[compensation_mass]]
name = "CM2"
centre_m = [0.0, 0.0, 0.1]
size_m = 0.02
mass_kg = 0.2

[[uncertainty.test_mass]]
name = "place"
source = "assumed"
test_mass = "TM1"
axes = ["x", "z"]
absolute_sigma_m = 1e-4
"""


def parts_project(folder: Path) -> Project:
    """Areas are dealt out in turn, so that no file has neighbours; the uniform load is in the fifth file."""
    for name in ("model.toml", "tedm.toml", "thermal.toml", "unit_loads.bdf", "ltp_small_areas.csv"):
        shutil.copy(SMALL / name, folder / name)
    for table in SMALL.glob("thermal_*.csv"):
        shutil.copy(table, folder / table.name)
    for name in ("optics.toml", "cases.toml"):
        shutil.copy(ROOT / "configs" / name, folder / name)
    project = (folder / "tedm.toml").read_text().replace("../../configs/", "")
    (folder / "tedm.toml").write_text(project)
    model = (folder / "model.toml").read_text().replace('bdf = "ltp_small.bdf"\n', "")
    model = re.sub(r"op2 = \[.*?\]", f"op2 = {FILES}".replace("'", '"'), model)
    model = model.replace('mass_model = "quadrature"', 'mass_model = "lumped"')  # quicker, and no less of a test
    (folder / "model.toml").write_text(model + MORE)
    (folder / "results").mkdir()
    with open_op2(SMALL / "unit_loads.op2") as (tables, read):
        for number, name in enumerate(FILES):
            mine = [t for i, t in enumerate(tables) if i % len(FILES) == number]
            got = [(t, read(t)) for t in mine]
            write_op2(folder / name, got[0][1].grid_id, [(t.subcase, t.label, g.motion) for t, g in got])
    return load_project(folder / "tedm.toml", folder / "build")


def rewritten(path: Path, change: Callable[[int, str, FloatArray], tuple[int, str, FloatArray] | None]) -> None:
    """Write an OP2 again, with each (subcase, label, motion [N, 6]) as `change` returns it; None: left out."""
    with open_op2(path) as (tables, read):
        got = [(t, read(t)) for t in tables]
    cases = [change(t.subcase, t.label, g.motion) for t, g in got]
    write_op2(path, got[0][1].grid_id, [case for case in cases if case is not None])
