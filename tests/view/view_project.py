"""The page of the small sample: three cases, a series, and texts that are code to a browser."""

from __future__ import annotations

import json
import re
import shutil
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from tedm_cli.config.cases import select_cases
from tedm_cli.config.project import Project, load_project
from tedm_cli.progress import silent
from tedm_cli.stages.gravity.sensitivity import build_sensitivity
from tedm_cli.stages.model.distortion import build_distortion
from tedm_cli.stages.model.ingest import ingest
from tedm_cli.stages.noise.case import run_cases
from tedm_cli.stages.noise.series import run_series
from tedm_cli.stages.optics.build import build_optics
from tedm_cli.stages.reporting.view import view

ROOT = Path(__file__).parents[2]
SMALL = ROOT / "sample_models" / "small"
TITLE = '</title><script>pwned=1</script>{{program}} & "it\'s" 🛰️'
GROUP = "struts</script><img src=x onerror=pwned=1>'\""
REASON = "<!--<script>pwned=1</script>"
COMPENSATION = """
[[compensation_mass]]
name = "CM"
centre_m = [-0.1, 0.0, 0.0]
size_m = [0.01, 0.03, 0.03]
mass_kg = 0.2
grid = 850001
"""
SAMPLES = 4000
SERIES = '\n[[series]]\nname = "warm"\nfile = "warm.csv"\nremove = "linear"\nlowest_hz = 1e-3\n'


@dataclass(frozen=True, eq=False)
class Built:
    """A project whose page has been written, the page, and what it holds."""

    project: Project
    path: Path
    text: str
    content: dict[str, Any]


def quoted(text: str) -> str:
    """As a basic string of TOML."""
    return '"' + "".join(f"\\U{ord(c):08x}" for c in text) + '"'


def content_of(page: str) -> dict[str, Any]:
    """What a page holds, as its own program would find it."""
    found = re.search(r'<script type="application/json" id="content">(.*?)</script>', page, re.S)
    assert found is not None
    return dict(json.loads(found[1]))


def build(folder: Path) -> Built:
    """The project in `folder`, run up to its page."""
    for name in ("model.toml", "ltp_small.bdf", "ltp_small_areas.csv", "unit_loads.bdf", "unit_loads.op2"):
        shutil.copy(SMALL / name, folder)
    shutil.copy(ROOT / "configs" / "optics.toml", folder)
    model = folder / "model.toml"
    text = model.read_text(encoding="utf-8").replace('group = "struts"', f"group = {quoted(GROUP)}")
    model.write_text(text + COMPENSATION, encoding="utf-8")
    cases = (ROOT / "configs" / "cases.toml").read_text(encoding="utf-8").replace('"struts"', quoted(GROUP))
    head, *found = cases.split("[[case]]")
    kept = [c for c in found if re.search(r'^id = "(1|3|7|10)"$', c, re.M)]
    kept[0] = re.sub("^reason = .*", lambda _: f"reason = {quoted(REASON)}", kept[0], flags=re.M)
    kept[3] += '\ndelays = [{ areas = ["STRUT_1"], delay_s = 40.0 }]\n'
    (folder / "cases.toml").write_text("[[case]]".join([head, *kept]) + SERIES, encoding="utf-8")
    (folder / "tedm.toml").write_text(f"title = {quoted(TITLE)}\n", encoding="utf-8")
    rng = np.random.default_rng(5)
    walk = 1e-5 * np.cumsum(rng.normal(size=(SAMPLES, 2)), axis=0)
    table = np.column_stack([10.0 * np.arange(SAMPLES), 293.0 + walk, 290.0 + 1e-3 * np.arange(SAMPLES)])
    np.savetxt(folder / "warm.csv", table, delimiter=",", header="time_s,outside,OB,inside", comments="", fmt="%.12g")
    project = load_project(folder / "tedm.toml", folder / "build")
    ingest(project, None, silent)
    build_distortion(project, None, silent)
    build_sensitivity(project, None, silent)
    build_optics(project, None)
    run_cases(project, select_cases(project.cases, ["all"]), None, silent)
    run_series(project, ["warm"], None, silent)
    done = view(project, None, silent)
    page = done.path.read_text(encoding="utf-8")
    return Built(project, done.path, page, content_of(page))
