"""Displacements under each thermal node, on the small sample: outputs by them are those by the adjoint."""

from __future__ import annotations

import re
import shutil
import sys
from pathlib import Path

import h5py
import numpy as np
import pytest

sys.path.append(str(Path(__file__).parents[1] / "borders"))

from shipped_cases import cases_of_areas
from test_chain_thermal import SMALL, command, network_case, project_in, weights_project

from tedm_cli.config.project import Project, load_project

NODES = "[map]\nareas = true\n[map.conductivity_W_m_K]\n1 = 1.46\n2 = 6.7\n6 = 8.0\n"


@pytest.fixture(scope="module")
def sample(small: Project, tmp_path_factory: pytest.TempPathFactory) -> Project:
    return network_case(small, cases_of_areas(), tmp_path_factory)


def copied(sample: Project, folder: Path) -> Project:
    """The sample's build folder, to be changed."""
    shutil.copytree(sample.file.path.parent, folder)
    return load_project(folder / "tedm.toml", folder / "build")


def outputs_by(project: Project) -> tuple[np.ndarray, np.ndarray, list[str]]:
    """Accelerations by -G D of thermal.h5 and sensitivity.h5 [6 t, n], those of /sensitivity, and the nodes."""
    with h5py.File(project.build_dir / "thermal.h5") as t, h5py.File(project.build_dir / "sensitivity.h5") as s:
        d, turned, rotation = t["D/translation"][:], t["D/turned_node"][:], t["D/rotation"][:]
        lever = s["operator/offset_node"][:]
        found = -np.einsum("rnc,knc->rk", s["operator/G"][:], d)
        found -= np.einsum("rlc,klc->rk", s["operator/G_rotation"][:], rotation[:, np.searchsorted(turned, lever)])
        labels, rows = t["row/label"].asstr()[:].tolist(), s["row/label"].asstr()[:].tolist()
        return found, t["sensitivity"][:][[labels.index(r) for r in rows]], t["map/node"].asstr()[:].tolist()


def test_accelerations_by_displacements_are_those_by_the_adjoint(sample: Project) -> None:
    found, wanted, _ = outputs_by(sample)
    for block in (slice(0, 3), slice(3, 6), slice(6, 9), slice(9, 12)):
        np.testing.assert_allclose(found[block], wanted[block], rtol=0.0, atol=1e-8 * np.abs(wanted[block]).max())
    with h5py.File(sample.build_dir / "thermal.h5") as t:
        assert t["check/difference"][:].max() < 1e-8  # read-outs too
        assert t["check/difference"].shape == t["sensitivity"].shape
        assert t["check/uniform"][()] < 1e-9
        assert t["check/residual"][()] < 1e-8


def test_all_nodes_together_are_the_uniform_load(sample: Project) -> None:
    """Rows of P sum to one: under all nodes the structure moves as under all unit loads, with OP2 digits."""
    with h5py.File(sample.build_dir / "thermal.h5") as t, h5py.File(sample.build_dir / "unit_loads.h5") as u:
        together = t["D/translation"][:].sum(axis=0)
        areas = (u["translation"][:] / u["area/load_K"][:][:, None, None]).sum(axis=0)
    assert np.abs(together - areas).max() < 1e-5 * np.abs(areas).max()


def test_weights_of_one_area_are_its_unit_load(small: Project, tmp_path: Path) -> None:
    """A node that is an area: its displacements are the column of the area, its outputs S_SG and N."""
    with h5py.File(small.build_dir / "unit_loads.h5") as u:
        areas = u["area/name"].asstr()[:].tolist()
        wanted = u["translation"][:] / u["area/load_K"][:][:, None, None]
    project = project_in(tmp_path / "p", small, '[map]\nweights = "w.csv"\n', cases_of_areas())
    (tmp_path / "p" / "w.csv").write_text("node,area,weight\n" + "".join(f"N_{a},{a},1\n" for a in areas))
    command(project, "build-thermal").ok()
    found, _s_sg, nodes = outputs_by(project)
    with h5py.File(project.build_dir / "thermal.h5") as t, h5py.File(project.build_dir / "sensitivity.h5") as s:
        at = [nodes.index(f"N_{a}") for a in areas]
        np.testing.assert_allclose(t["D/translation"][:][at], wanted, rtol=1e-14, atol=0.0)
        np.testing.assert_allclose(found[:, at], s["S"][:], rtol=0.0, atol=1e-9 * np.abs(s["S"][:]).max())
        assert np.isnan(t["check/residual"][()])


def test_another_solver(sample: Project, tmp_path: Path) -> None:
    """The deck of the nodes, solved elsewhere (here by `solve --deck`): the same displacements with OP2 digits."""
    project = copied(sample, tmp_path / "p")
    deck = tmp_path / "nodes.bdf"
    assert "thermal nodes, each a field on" in command(project, "write-deck", "--thermal-nodes", "-o", deck).ok().out
    command(project, "solve", "--deck", deck, "-o", tmp_path / "nodes.op2").ok()
    text = (tmp_path / "p" / "thermal.toml").read_text()
    (tmp_path / "p" / "thermal.toml").write_text(text.replace("[map]", f'[map]\nresults = ["{tmp_path}/nodes.op2"]', 1))
    command(project, "build-thermal").ok()
    with h5py.File(sample.build_dir / "thermal.h5") as a, h5py.File(project.build_dir / "thermal.h5") as b:
        wanted, found = a["D/translation"][:], b["D/translation"][:]
        assert np.abs(found - wanted).max() < 1e-6 * np.abs(wanted).max()
        assert not np.array_equal(found, wanted)
        assert 1e-12 < b["check/difference"][:].max() < 1e-4
    lines = deck.read_text().splitlines()
    first = next(i for i, line in enumerate(lines) if line.startswith("TEMP*"))
    lines[first] = lines[first][:40] + f"{'9.':>16}" + lines[first][56:]
    deck.write_text("\n".join(lines) + "\n")
    command(project, "solve", "--deck", deck, "-o", tmp_path / "nodes.op2").ok()
    said = command(project, "build-thermal")
    assert said.code == 5
    assert "by its displacements differs from that by the adjoint" in said.err
    assert (project.build_dir / "thermal.h5").exists()


UNCERTAIN = """
[[uncertainty.material]]
name = "zerodur"
material = 1
of = "expansion"
absolute_sigma_per_K = 1e-8
source = "a test"

[[uncertainty.material]]
name = "modulus"
material = 2
of = "modulus"
relative_sigma = 0.05
source = "a test"

[[uncertainty.test_mass]]
name = "place"
test_mass = "TM1"
axes = ["x"]
absolute_sigma_m = 1e-3
source = "a test"
"""


def uncertain(project: Project) -> None:
    """With a model of its own, in which materials and a position are uncertain, built up to thermal.h5."""
    folder = project.file.path.parent
    for name in ("ltp_small.bdf", "ltp_small_areas.csv", "unit_loads.bdf", "unit_loads.op2", "unit_loads.h5"):
        if (SMALL / name).exists():
            shutil.copy(SMALL / name, folder)
    (folder / "model.toml").write_text((SMALL / "model.toml").read_text() + UNCERTAIN)
    text = project.file.path.read_text().replace(str(SMALL / "model.toml"), "model.toml")
    project.file.path.write_text(text)
    for words in ("build-sensitivity", "build-adjoint", "build-thermal"):
        command(load_project(project.file.path, project.build_dir), words).ok()


def test_materials_and_positions_are_uncertain(small: Project, tmp_path: Path) -> None:
    """Nodes that are areas, each with a boundary of its own: the same probabilities as the case of areas."""
    project, _ = weights_project(tmp_path / "p", small, cases_of_areas(), common=False)
    text = project.cases.read_text().replace("samples = 10000", "samples = 1000", 1)
    project.cases.write_text(re.sub(r"\[\[uncertainty\.level\]\].*?\n\n", "", text, flags=re.S))
    uncertain(project)
    out = command(project, "run-case", "T", "2").ok().out
    assert "left out" not in out
    with h5py.File(project.build_dir / "caseT.h5") as t, h5py.File(project.build_dir / "case02.h5") as case:
        assert t["uncertainty/parameter/name"].asstr()[:].tolist() == ["zerodur", "modulus", "place_x"]
        assert case["uncertainty/parameter/name"].asstr()[:3].tolist() == ["zerodur", "modulus", "place_x"]
        wanted = case["uncertainty/quantile"][:]
        np.testing.assert_allclose(t["uncertainty/quantile"][:], wanted, rtol=1e-4)
        assert (wanted[:, -1] > 1.01 * wanted[:, 0]).all()


def test_changes_by_nodes_of_a_conducted_map(sample: Project, tmp_path: Path) -> None:
    """All expansions together make the outputs; a factor on all moduli changes nothing; all nodes are all areas."""
    project = copied(sample, tmp_path / "p")
    uncertain(project)
    with (
        h5py.File(project.build_dir / "thermal.h5") as t,
        h5py.File(project.build_dir / "sensitivity.h5") as s,
        h5py.File(project.build_dir / "adjoint.h5") as a,
    ):
        value = t["sensitivity"][:] - t["D/direct"][:]
        size = np.abs(value).max(axis=1)[:, None]
        assert (np.abs(t["change/dlnalpha"][:].sum(axis=0) - value) < 1e-8 * size).all()
        assert (np.abs(t["change/dlnE"][:].sum(axis=0)) < 1e-6 * size).all()
        assert (np.abs(t["change/dlnE"][:]).max(axis=(0, 2)) > 1e-3 * size[:, 0]).all()
        for path, other in (("change/dlnE", "material/dS_dlnE"), ("change/dlnrho", "material/dS_dlnrho")):
            whole, wanted = t[path][:].sum(axis=2), a[other][:].sum(axis=2)
            np.testing.assert_allclose(whole, wanted, rtol=0.0, atol=1e-4 * np.abs(wanted).max(axis=0).max())
        assert t["position/name"].asstr()[:].tolist() == ["TM1_x"]
        own = np.char.startswith(s["row/label"].asstr()[:].astype(str), "TM1_")
        wanted = s["test_mass/dS_dposition"][own, 0].sum(axis=1)
        found = t["position/change"][0].sum(axis=1)
        np.testing.assert_allclose(found, wanted, rtol=0.0, atol=1e-4 * np.abs(wanted).max())
