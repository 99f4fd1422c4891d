"""The spacecraft around the LTP-like sample: how it is held, what it weighs, and what it does to the bench."""

from __future__ import annotations

import csv
import fnmatch
import re
import subprocess
import sys
import tomllib
from collections import defaultdict
from pathlib import Path

import numpy as np
import pytest

from tedm_cli.arrays import FloatArray
from tedm_cli.fem.constraints import rigid_body_matrix
from tedm_cli.fem.static import StaticSolution
from tedm_cli.fem.structure import LoadCase, Structure
from tedm_cli.nastran.geometry import ModelGeometry, model_geometry
from tedm_cli.nastran.reading import read_deck
from tedm_cli.nastran.structure.deck import read_solver_deck

ROOT = Path(__file__).parents[2]
CONFIGS = ROOT / "configs" / "spacecraft"
LAST_SOLID, HELD = 599999, 790001  # ids of grids


def made(folder: Path, mount: str) -> Path:
    """The deck of the small model in the spacecraft."""
    bdf = folder / mount / "ltp_spacecraft.bdf"
    script = [sys.executable, "sample_models/ltp_like.py", "--detail", "small", "--element-size-mm", "1000"]
    script += ["--spacecraft", "--mount", mount, "--layout", "configs/optics.toml", "-o", str(bdf)]
    subprocess.run(script, cwd=ROOT, check=True)
    return bdf


def areas(deck: Path) -> dict[str, list[int]]:
    """Grids of each thermal area."""
    out: dict[str, list[int]] = defaultdict(list)
    with deck.with_name("ltp_spacecraft_areas.csv").open(encoding="ascii", newline="") as lines:
        for row in csv.DictReader(lines):
            out[row["area"]].append(int(row["node_id"]))
    return out


@pytest.fixture(scope="module")
def deck(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return made(tmp_path_factory.mktemp("spacecraft"), "clamped")


@pytest.fixture(scope="module")
def geometry(deck: Path) -> ModelGeometry:
    return model_geometry(read_deck(deck), [deck])


def structure_of(deck: Path) -> Structure:
    """The structure; its deck is given a load case, without which it is none for a solver."""
    text = deck.read_text().replace("BEGIN BULK", "SUBCASE 1\n TEMP(LOAD) = 1\nBEGIN BULK")
    loaded = deck.with_name("loaded.bdf")
    loaded.write_text(text.replace("ENDDATA", "TEMPD,1,0.\nENDDATA"))
    return read_solver_deck(loaded)[0]


def motions(structure: Structure, warm: dict[str, list[int]]) -> FloatArray:
    """Motions [areas, N, 6] where the grids of one area are 1 K warm."""
    cases = [
        LoadCase(id=n, label=name, temperature=np.isin(structure.grid_id, grids).astype(float))
        for n, (name, grids) in enumerate(warm.items(), start=1)
    ]
    return np.array([motion for _, motion in StaticSolution(structure).solve(cases)])


def share_distorted(structure: Structure, motion: FloatArray) -> FloatArray:
    """Of the solids' motion [cases, N, 6], the share that is no rigid motion."""
    solid = structure.grid_id <= LAST_SOLID
    rigid = rigid_body_matrix(structure.position[solid])[:, :3].reshape(-1, 6)
    moved = motion[:, solid, :3].reshape(len(motion), -1).T
    rest = moved - rigid @ np.linalg.lstsq(rigid, moved, rcond=None)[0]
    return np.asarray(np.abs(rest).max(axis=0) / np.abs(moved).max(axis=0))


@pytest.mark.parametrize("mount", ["clamped", "hexapod", "bipods"])
def test_a_warm_spacecraft_moves_an_isostatic_bench_as_one(tmp_path: Path, mount: str) -> None:
    """However it displaces and turns the feet of the struts: to rounding. Clamped struts pass distortion on."""
    deck = made(tmp_path, mount)
    structure = structure_of(deck)
    warm = {name: grids for name, grids in areas(deck).items() if name.startswith("SC_")}
    motion = motions(structure, warm)
    assert np.abs(motion[:, structure.grid_id <= LAST_SOLID]).max(axis=(1, 2)).min() > 1e-10
    share = share_distorted(structure, motion)
    assert share.max() < 1e-7 if mount != "clamped" else share.max() > 1e-3


def test_nothing_holds_it_but_the_mean_of_the_bay(tmp_path: Path) -> None:
    """Of one expansion, on a mount that passes no force on, it grows freely about the place where it is held."""
    deck = made(tmp_path, "hexapod")
    text, count = re.subn(r"(?m)^(MAT1 {11}[789].{32}).{8}", r"\1    2.-6", deck.read_text())
    assert count == 3
    deck.write_text(text)
    structure = structure_of(deck)
    (motion,) = motions(structure, {"all": structure.grid_id.tolist()})
    shell = np.unique(structure.quads.connectivity)
    (held,) = structure.position[structure.grid_id == HELD]
    expected = 2e-6 * (structure.position[shell] - held)
    np.testing.assert_allclose(motion[shell, :3], expected, atol=1e-9 * np.abs(expected).max())


def test_shells_join(deck: Path) -> None:
    """No two grids at one place, both planes mirror them, and only array and floor have edges of one shell."""
    structure = structure_of(deck)
    shell = structure.grid_id[np.unique(structure.quads.connectivity)]
    place = np.round(structure.position[np.isin(structure.grid_id, shell)], 7)
    assert len(np.unique(place, axis=0)) == len(place)
    for mirror in ([-1, 1, 1], [1, -1, 1]):
        np.testing.assert_array_equal(np.unique(place * mirror + 0.0, axis=0), np.unique(place + 0.0, axis=0))
    corners = structure.quads.connectivity
    edge = np.sort(np.stack([corners, np.roll(corners, -1, axis=1)], axis=2).reshape(-1, 2), axis=1)
    unique, count = np.unique(edge, axis=0, return_counts=True)
    free = structure.position[unique[count == 1]]
    x, y, z = np.moveaxis(np.round(free, 6), 2, 0)
    from_axis = np.hypot(x, y)
    array, floor = z == 0.35, (z == -0.208) & (np.abs(x) == 0.27)
    assert (array | floor).all()
    assert array.any()
    assert floor.any()
    assert ((from_axis < 0.07) | (from_axis > 1.29))[array].all()


def test_mass_and_places_of_the_spacecraft(geometry: ModelGeometry) -> None:
    """Of the usual size of a small satellite; all units hang on it; panels mirror in both planes, units do not."""
    e, c = geometry.elements, geometry.concentrated
    shells = np.array(e.type) == "CQUAD4"
    kg = e.mass_kg[shells].sum()
    assert 90 < kg < 150
    assert c.kg.sum() - 0.24 == pytest.approx(277.0)  # two masses of the small model
    centre = np.array([
        geometry.position_m[e.node_index[a:b]].mean(axis=0)
        for a, b in zip(e.node_offset[:-1][shells], e.node_offset[1:][shells], strict=True)
    ])  # fmt: skip
    moment = (e.mass_kg[shells, None] * centre).sum(axis=0)
    assert np.abs(moment[:2]).max() < 1e-9 * kg


def test_configuration_fits(deck: Path) -> None:
    """Every area of the model has a rule of its own name, and the groups of subsystems and temperatures exist."""
    model = tomllib.loads((CONFIGS / "model.toml").read_text())
    cases = tomllib.loads((CONFIGS / "cases.toml").read_text())
    of = {}
    for area in areas(deck):
        (of[area], *_) = (r["group"] for r in model["areas"]["rule"] if fnmatch.fnmatch(area, r["match"]))
    spacecraft = [area for area in of if area.startswith("SC_")]
    assert len(spacecraft) == 43
    assert {of[area] for area in spacecraft} == {"panels", "bay", "array"}
    groups = {group for table in cases["temperature"]["override"] for group in table["groups"]}
    assert groups == {of[area] for area in spacecraft}
    alone = next(case for case in cases["case"] if case["id"] == "S1")
    assert set(alone["blocks"][0]["groups"]) == groups
    assert model["gravity"]["subsystems"]["S/C"] == "rest"
