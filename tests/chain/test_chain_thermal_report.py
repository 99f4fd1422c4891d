"""The thermal network and its case in figures, report and page: what is drawn and said is what the files have."""

from __future__ import annotations

import base64
import json
import re
import shutil
import sys
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest

sys.path += [str(Path(__file__).parents[1] / folder) for folder in ("borders", "report")]

from figure_texts import drawn, faults
from report_project import sketch
from shipped_cases import cases_of_areas
from test_chain_thermal import CASE_T, GRAVITY, changed, command, network_case

from tedm_cli.config.project import Project, load_project
from tedm_cli.contracts import THERMAL
from tedm_cli.errors import InputError
from tedm_cli.progress import silent
from tedm_cli.report.evidence import cancels, share_text
from tedm_cli.results.build_folder import open_results
from tedm_cli.results.cases.file import read_case
from tedm_cli.results.wording import rounded_down
from tedm_cli.stages.noise.case import run_cases
from tedm_cli.stages.reporting.plot import figure_specs
from tedm_cli.stages.reporting.report import report
from tedm_cli.stages.thermal.build import build_thermal


@pytest.fixture(scope="module")
def sample(small: Project, tmp_path_factory: pytest.TempPathFactory) -> Project:
    return network_case(small, cases_of_areas(), tmp_path_factory)


@pytest.fixture(scope="module")
def reported(sample: Project, tmp_path_factory: pytest.TempPathFactory) -> Project:
    """Case 1 and the case of the network alone, with figures (empty ones but for the map) and the report."""
    folder = tmp_path_factory.mktemp("reported") / "p"
    shutil.copytree(sample.file.path.parent, folder)
    text = (folder / "cases.toml").read_text(encoding="utf-8")
    second = text.index("[[case]]", text.index("[[case]]") + 1)
    (folder / "cases.toml").write_text(text[:second] + CASE_T)
    project = load_project(folder / "tedm.toml", folder / "build")
    run_cases(project, ["1"], None, silent)
    with pytest.raises(InputError, match=r"is stale: not made from .*cases\.toml"), open_results(project):
        pass  # thermal.h5 has the frequencies of another file of cases
    build_thermal(project, None, silent)
    run_cases(project, ["1", "T"], None, silent)
    sketch(project)
    return project


def test_figures_of_the_network(reported: Project) -> None:
    """Which there are, and that the map shows the steady state of the nodes as averages over their elements."""
    with open_results(reported) as results:
        cases = [read_case(file) for file in results.cases]
        specs = {s.name: s for s in figure_specs(results, cases) if s.section == "thermal"}
        assert set(specs) == {
            "steady_temperatures.svg",
            "temperature_map.svg",
            *(f"thermal_gains_{kind}.svg" for kind in ("temperature", "power")),
            "thermal_low_passes.svg",
            *(f"{name}_caseT.svg" for name in ("disturbances", "required_stability", "disturbance_spectra")),
        }
        assert {name for name, s in specs.items() if s.decides} == {
            "disturbances_caseT.svg",
            "required_stability_caseT.svg",
        }
        for spec in specs.values():
            assert faults(drawn(spec.draw())) == [], spec.name
        assert results.thermal is not None
        steady, grids = (results.thermal.array(p) for p in (THERMAL.STEADY_K, THERMAL.MAP_STEADY_K))
        node, mapped = (results.thermal.strings(p) for p in (THERMAL.NODE_NAME, THERMAL.MAP_NODE))
        tau = steady[[node.index(name) for name in mapped]]
        there = grids[np.isfinite(grids)]
        # Averages are kept, so every node is between the grids; and conduction puts no grid far beyond the nodes.
        assert there.min() <= tau.min() < tau.max() <= there.max()
        assert np.ptp(there) < 1.5 * np.ptp(tau)
        assert len(there) > 0.9 * len(grids)


def test_report_of_the_network(reported: Project) -> None:
    """Facts and sentences, with numbers of the file; the case by disturbance in the report itself."""
    report(reported, None, ["md"])
    told, annex = ((reported.build_dir / f"report{end}.md").read_text(encoding="utf-8") for end in ("", "_annex"))
    section = told[told.index("## Evidence: the thermal network") :]
    with h5py.File(reported.build_dir / "caseT.h5") as case:
        names = case["disturbance/name"].asstr()[:].tolist()
        factor = case["disturbance/level_factor"][:].min(axis=0)
        cannot = [name for name, f in zip(names, factor, strict=True) if np.isnan(f)]
        at = case["output/label"].asstr()[:].tolist().index(GRAVITY)
        share, worst = case["disturbance/share"][at], case["verdict/ratio"][:].max()
        psd, alone = case[f"psd/{GRAVITY}"][:], case["disturbance/asd"][at]
    assert cannot == names, "of the small sample the read-outs are beyond their limits, whoever is quiet"
    assert "**No single disturbance is enough**" in section
    assert f"All together must have at most {rounded_down(1.0 / worst)} times" in section
    (line,) = (text for text in section.splitlines() if GRAVITY in text and names[int(share.argmax())] in text)
    assert f"{names[int(share.argmax())]} {share_text(share.max(), cancels(share))}" in line
    # What is drawn of a disturbance alone goes with the whole: none is above what all would make in phase.
    assert (alone.sum(axis=0) >= np.sqrt(psd) * (1 - 1e-9)).all()
    section = annex[annex.index("## Thermal network") :]
    with h5py.File(reported.build_dir / "thermal.h5") as file:
        node, steady = file["node/name"].asstr()[:].tolist(), file["steady_K"][:]
        power, boundary = file["node/power"][:].sum(), file["node/kind"].asstr()[:] == "boundary"
        assert f"- Nodes: {len(node)} nodes (" in section
        assert f"- Warmest node: {node[int(steady.argmax())]}, {steady.max():.2f} K" in section
        assert f"powers {power:.4g} W, boundaries take {file['node/net_heat'][:][boundary].sum():.4g} W" in section
        grids = file["map/steady_K"][:]
    assert f"from {np.nanmin(grids):.2f} K" in section
    assert "The cases assume order 2 and 1 mHz" in section
    assert "| thermal.h5 |" in annex


def unpacked(packed: dict[str, Any]) -> np.ndarray:
    return np.frombuffer(base64.b64decode(packed["float64"])).reshape(packed["shape"])


def test_the_page_shows_the_case(reported: Project) -> None:
    """`tedm view`: nodes are columns behind the areas. The typical pattern of an output makes one amplitude of it."""
    out = command(reported, "view").ok().out
    assert "without" not in out
    text = (reported.build_dir / "view.html").read_text(encoding="utf-8")
    found = re.search(r'<script type="application/json" id="content">(.*?)</script>', text, re.S)
    assert found is not None
    page = json.loads(found[1])
    with h5py.File(reported.build_dir / "thermal.h5") as t, h5py.File(reported.build_dir / "caseT.h5") as case:
        nodes, k = t["map/node"].asstr()[:].tolist(), page["areas"]["count"]
        assert page["areas"]["name"][k:] == nodes
        rows = unpacked(page["outputs"]["rows"])
        label, known = page["outputs"]["label"], t["row/label"].asstr()[:].tolist()
        both = [o for o in label if o in known]
        np.testing.assert_array_equal(
            rows[[label.index(o) for o in both], k:], t["sensitivity"][:][[known.index(o) for o in both]]
        )
        moved = page["drawing"]["mesh"]["scale"]
        largest = np.abs(t["D/translation"][:]).max(axis=(1, 2))
        assert (unpacked(moved)[k:] * 32767 <= largest * (1 + 1e-12)).all()
        assert (unpacked(moved)[k:] * 32767 > 0.3 * largest).all()  # of the surface
        shown = next(c for c in page["cases"] if c["id"] == "T")
        assert shown["nodes"]
        assert shown["film"]["steps"]["shape"][0] == k + len(nodes)
        frequency = case["frequency"][:]
        for verdict in shown["verdicts"]:
            typical, worst = unpacked(verdict["typical"]), unpacked(verdict["worst"])
            assert not typical[:k].any()
            at = int(np.abs(frequency - verdict["patternHz"]).argmin())
            sigma = unpacked(verdict["asd"])[at]
            assert rows[verdict["output"]] @ typical == pytest.approx(sigma, rel=1e-12)
            psd = case[f"bounds/maximum/{label[verdict['output']]}"][at]
            assert rows[verdict["output"]] @ worst == pytest.approx(np.sqrt(psd), rel=1e-12)
        scale = unpacked(shown["film"]["scale"])
        assert not scale[:k].any()
        assert scale[k:].any()


def test_a_stale_network_is_not_drawn(reported: Project, tmp_path: Path) -> None:
    shutil.copytree(reported.file.path.parent, tmp_path / "p")
    project = load_project(tmp_path / "p" / "tedm.toml", tmp_path / "p" / "build")
    changed(tmp_path / "p" / "thermal.toml", "level_K = 2e-3", "level_K = 3e-3")
    command(project, "plot").refused(4, "is stale", hint="build-thermal")
