"""The sample's thermal network: its tables against the deck and by hand, and what it gives, solved apart from tedm."""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
import tomllib
from collections import Counter, defaultdict
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from dense_network import SIGMA, DenseNetwork, DenseSpectra, read_network, rows, spectra
from thermal_project import ThermalProject

from tedm_cli.nastran.geometry import ModelGeometry, model_geometry
from tedm_cli.nastran.reading import read_deck

ROOT = Path(__file__).parents[2]
SMALL = ROOT / "sample_models" / "small"
THERMAL = {"full": ROOT / "configs" / "thermal.toml", "small": SMALL / "thermal.toml"}
NAMES = [f"thermal_{name}.csv" for name in ("nodes", "conductors", "powers")]
SPECIFIC_HEAT = {1: 820.0, 2: 526.0, 3: 251.0, 4: 132.0, 5: 550.0, 6: 900.0}  # J/(kg K), by material
ELECTRONICS = 900.0
MILLIHERTZ = 1e-3


def made(folder: Path, size: str, mount: str = "clamped") -> Path:
    script = [sys.executable, "sample_models/ltp_like.py", "--mount", mount, "--element-size-mm", size]
    subprocess.run([*script, "--layout", "configs/optics.toml", "-o", str(folder / "ltp.bdf")], cwd=ROOT, check=True)
    return folder


@pytest.fixture(scope="module")
def coarse(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The full sample with elements as long as its blocks."""
    return made(tmp_path_factory.mktemp("coarse"), "1000")


@pytest.fixture(scope="module", params=["full", "small", "hexapod", "bipods"])
def folder(request: pytest.FixtureRequest, coarse: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The tables of the full model, of the small one, and of the full one on other mounts."""
    if request.param in ("full", "small"):
        return coarse if request.param == "full" else SMALL
    return made(tmp_path_factory.mktemp(request.param), "1000", request.param)


@pytest.fixture(scope="module")
def geometry(folder: Path) -> ModelGeometry:
    deck = next(p for p in (folder / "ltp.bdf", folder / "ltp_small.bdf") if p.exists())
    return model_geometry(read_deck(deck), [deck])


@pytest.fixture(scope="module")
def net(folder: Path) -> DenseNetwork:
    return read_network(*(folder / name for name in NAMES))


@pytest.fixture(scope="module")
def full(coarse: Path) -> DenseNetwork:
    return read_network(*(coarse / name for name in NAMES))


@pytest.fixture(scope="module")
def noise(full: DenseNetwork) -> DenseSpectra:
    return spectra(full, THERMAL["full"], np.array([1e-3, 3e-3, 1e-2, 3e-2]))


def test_network_is_the_same_of_every_mesh_and_elements_follow(coarse: Path, tmp_path: Path) -> None:
    fine = made(tmp_path, "15")
    for name in NAMES:
        assert (fine / name).read_bytes() == (coarse / name).read_bytes()
    of = [Counter(row["tmm_node"] for row in rows(f / "thermal_elements.csv")) for f in (coarse, fine)]
    assert set(of[0]) == set(of[1])
    assert of[1].total() > 1.2 * of[0].total()


def test_every_conducting_element_is_in_one_node(folder: Path, geometry: ModelGeometry) -> None:
    ids = [int(row["element_id"]) for row in rows(folder / "thermal_elements.csv")]
    e = geometry.elements
    assert set(e.type) == {"CHEXA", "CBAR"}
    assert sorted(ids) == sorted(e.id.tolist())
    nodes = {row["node"]: row for row in rows(folder / "thermal_nodes.csv")}
    assert {row["tmm_node"] for row in rows(folder / "thermal_elements.csv")} <= set(nodes)
    assert all(nodes[row["tmm_node"]]["kind"] == "diffusive" for row in rows(folder / "thermal_elements.csv"))


def test_capacities_are_masses_of_the_deck_times_specific_heat(folder: Path, geometry: ModelGeometry) -> None:
    """Node by node, with masses and materials as tedm reads them; the bars' area has four digits in the deck."""
    e = geometry.elements
    material = {10: 6} | {n: n for n in range(1, 7)}  # of a property
    of_element = dict(zip(e.id.tolist(), zip(e.mass_kg, e.property_id, strict=True), strict=True))
    expected: dict[str, float] = defaultdict(float)
    for row in rows(folder / "thermal_elements.csv"):
        kg, pid = of_element[int(row["element_id"])]
        expected[row["tmm_node"]] += kg * SPECIFIC_HEAT[material[int(pid)]]
    capacity = {row["node"]: float(row["capacity_J_K"]) for row in rows(folder / "thermal_nodes.csv")}
    assert {n: capacity[n] for n in expected} == pytest.approx(dict(expected), rel=3e-5)
    with_mass = re.compile(r"IS\d_(CAGING_DRIVE|FEE)|HUB_\d")
    lumped = sum(c for n, c in capacity.items() if with_mass.match(n))
    assert lumped == pytest.approx(geometry.concentrated.kg.sum() * ELECTRONICS, rel=1e-6)


def test_places_are_those_of_the_elements(folder: Path, geometry: ModelGeometry) -> None:
    e = geometry.elements
    first, last = e.node_offset[:-1], e.node_offset[1:]
    centre = {
        int(i): geometry.position_m[e.node_index[a:b]].mean(axis=0) for i, a, b in zip(e.id, first, last, strict=True)
    }
    mass = dict(zip(e.id.tolist(), e.mass_kg, strict=True))
    moment: dict[str, np.ndarray] = defaultdict(lambda: np.zeros(4))
    for row in rows(folder / "thermal_elements.csv"):
        i = int(row["element_id"])
        moment[row["tmm_node"]] += mass[i] * np.append(centre[i], 1.0)
    for row in rows(folder / "thermal_nodes.csv"):
        if row["node"] in moment:
            m = moment[row["node"]]
            np.testing.assert_allclose([float(row[f"{a}_m"]) for a in "xyz"], m[:3] / m[3], atol=1.1e-6)


def test_conductors_are_positive_once_each_and_join_all_to_the_boundary(folder: Path, net: DenseNetwork) -> None:
    pairs = rows(folder / "thermal_conductors.csv")
    assert all(float(p["GL_W_K"]) >= 0 and float(p["GR_m2"]) >= 0 for p in pairs)
    assert all(float(p["GL_W_K"]) + float(p["GR_m2"]) > 0 and p["node_a"] != p["node_b"] for p in pairs)
    assert max(Counter(frozenset((p["node_a"], p["node_b"])) for p in pairs).values()) == 1
    reached, joined = np.zeros(len(net.name), dtype=bool), net.gl + net.gr > 0
    reached[net.fixed[0]] = True
    for _ in net.name:
        reached |= joined[reached].any(axis=0)
    assert reached.all()
    arithmetic = [n for n, row in zip(net.name, rows(folder / "thermal_nodes.csv"), strict=True)
                  if row["kind"] == "arithmetic"]  # fmt: skip
    assert [n for n in net.name if net.capacity[net.name.index(n)] == 0 and not n.startswith("SC_")] == arithmetic


def mirrored(name: str, pairs: list[tuple[str, str]]) -> str:
    """A name on the other side of a plane."""
    other = {a: b for pair in pairs for a, b in (pair, pair[::-1])}
    return re.sub("|".join(sorted(other, key=len, reverse=True)), lambda m: other[m[0]], name)


MIRROR_X = [
    *[("IS1", "IS2"), ("TM1", "TM2"), ("LEFT", "RIGHT"), ("MINUS_X", "PLUS_X"), ("FEE_1", "FEE_2")],
    *[(f"{part}_{n}", f"{part}_{n + 2}") for part in ("FLANGE", "HUB") for n in (1, 2)],
    *[(f"STRUT_{n}", f"STRUT_{n + 4}") for n in (1, 2, 3, 4)],
]
MIRROR_Y = [
    *[("MINUS_Y", "PLUS_Y"), ("UNIT_PHASEMETER", "UNIT_LASER")],
    *[(f"{part}_{n}", f"{part}_{n + 1}") for part in ("FLANGE", "HUB") for n in (1, 3)],
    *[(f"STRUT_{n}", f"STRUT_{n + 2}") for n in (1, 2, 5, 6)],
]


@pytest.mark.parametrize("pairs", [MIRROR_X, MIRROR_Y], ids=["x", "y"])
def test_mirror_images_conduct_and_radiate_alike(net: DenseNetwork, pairs: list[tuple[str, str]]) -> None:
    """All but phasemeter and laser, which differ, and the masses on two hubs of the small model.

    Six struts mirror across the x-z plane alone.
    """
    if pairs is MIRROR_X and "STRUT_6_1" not in net.name:
        assert not {mirrored(n, pairs) for n in net.name} <= set(net.name)
        return
    image = [net.name.index(mirrored(n, pairs)) for n in net.name]
    assert sorted(image) == list(range(len(image)))
    units = np.array([n in ("UNIT_PHASEMETER", "UNIT_LASER") for n in net.name])
    for matrix in (net.gl, net.gr):
        same = np.isclose(matrix, matrix[np.ix_(image, image)], rtol=1e-8, atol=0)
        assert same[np.ix_(~units, ~units)].all()
    solid = ~units & np.array([not n.startswith("HUB") for n in net.name])
    np.testing.assert_allclose(net.capacity[solid], net.capacity[image][solid], rtol=1e-8)


def test_conductors_by_hand(full: DenseNetwork) -> None:
    """A strut, two pieces of the bench, a bolted joint, plates of the housing and its enclosure, a test mass."""
    at = {n: i for i, n in enumerate(full.name)}

    def gl(a: str, b: str) -> float:
        return float(full.gl[at[a], at[b]])

    length, section = np.sqrt(0.06**2 + 0.1**2 + 0.11**2), np.pi * 0.006**2
    chain = ["HUB_1", *(f"STRUT_1_{n}" for n in (1, 2, 3, 4)), "SC_MINUS_Y"]
    ways = [gl(a, b) for a, b in pairwise(chain)]
    assert 1 / sum(1 / g for g in ways) == pytest.approx(0.5 * section / length, rel=1e-8)

    left, mid = "OB_BENCH_LEFT_PLUS_Y_EDGE_TOP", "OB_BENCH_MID_PLUS_Y_EDGE_TOP"
    assert gl(left, mid) == pytest.approx(1.46 * 0.049 * 0.021 / 0.0665, rel=1e-8)

    # Bracket (37 mm of titanium) on the wall of the enclosure (12 mm): 54 x 54 mm, 500 W/(m2 K).
    joint = 0.0185 / 6.7 + 1 / 500 + 0.006 / 6.7
    assert gl("IS1_BRACKET_PLUS_Y", "IS1_VE_PLUS_Y") == pytest.approx(0.054**2 / joint, rel=1e-8)

    # Above the housing: its face without the posts (6 x 6 mm), and caging block against it (24 x 24 mm), in between.
    gr = full.gr[at["IS2_EH_UP"]]
    walls = gr[at["IS2_VE_UP_PLUS_Y"]] + gr[at["IS2_VE_UP_MINUS_Y"]]
    titanium = 1 / (1 / 0.04 + 1 / 0.6 - 1)
    assert walls == pytest.approx((0.066**2 - 0.024**2 - 4 * 0.006**2) * titanium, rel=1e-8)
    assert gr[at["IS2_CAGING_UP"]] == pytest.approx(0.024**2 * titanium, rel=1e-8)

    # A test mass sees gold on all sides, but the window through the hole of the housing (24 x 24 mm).
    gold, hole = 1 / (2 / 0.04 - 1), 0.024**2
    assert full.gr[at["TM1"]].sum() == pytest.approx(
        (6 * 0.046**2 - hole) * gold + hole / (1 / 0.04 + 1 / 0.85 - 1), rel=1e-8
    )
    assert not full.gl[at["TM1"]].any()


def test_heat_of_the_steady_state(net: DenseNetwork) -> None:
    """What is dissipated leaves through the boundary, and the instrument is at room temperature."""
    lost = net.heat(net.steady).sum(axis=1)
    np.testing.assert_allclose(lost[net.free], net.power[net.free], atol=1e-10)
    assert -lost[net.fixed].sum() == pytest.approx(net.power.sum(), rel=1e-9)
    inside = [i for i, n in enumerate(net.name) if n.startswith(("OB_", "IS", "TM"))]
    assert net.steady[inside].min() > 295.0
    assert net.steady[inside].max() < 303.0


def test_gains_of_an_isothermal_network_sum_to_one(net: DenseNetwork) -> None:
    """With all boundaries alike and no power, all of it follows them at f -> 0, also by radiation."""
    alike = np.where(np.isnan(net.boundary), np.nan, 293.15)
    cold = DenseNetwork(net.name, net.capacity, alike, net.gl, net.gr, np.zeros(len(net.name)))
    np.testing.assert_allclose(cold.steady, 293.15, rtol=1e-12)
    panels = [{"kind": "temperature", "nodes": [net.name[i]]} for i in net.fixed]
    gains = cold.transfer(np.array([0.0, MILLIHERTZ]), panels)
    np.testing.assert_allclose(gains[0].sum(axis=1), 1.0, rtol=1e-9)
    assert (np.abs(gains[1].sum(axis=1)) < 0.2).all()


def test_gains_are_the_slopes_of_the_steady_state(full: DenseNetwork) -> None:
    """At f = 0, against differences of Newton's own solutions."""
    at, step = full.name.index("SC_PLUS_Z"), 1e-3
    warm = []
    for sign in (-1, 1):
        moved = full.boundary.copy()
        moved[at] += sign * step
        warm.append(DenseNetwork(full.name, full.capacity, moved, full.gl, full.gr, full.power).steady)
    gain = full.transfer(np.zeros(1), [{"kind": "temperature", "nodes": ["SC_PLUS_Z"]}])[0, :, 0]
    np.testing.assert_allclose(gain.real, ((warm[1] - warm[0]) / (2 * step))[full.free], atol=1e-8)


def test_a_strut_is_a_rod(full: DenseNetwork) -> None:
    """Its mean at 1 µHz against a continuous rod that conducts and radiates, between its hub and the panel."""
    frequency, (k, density, c_p, radius) = 1e-6, (0.5, 1950.0, 900.0, 0.006)
    gain = full.transfer(np.array([frequency]), [{"kind": "temperature", "nodes": ["SC_MINUS_Y"]}])[0, :, 0]
    names = [full.name[i] for i in full.free]
    hub = gain[names.index("HUB_1")]
    bars = [names.index(f"STRUT_1_{n}") for n in (1, 2, 3, 4)]
    section, length = np.pi * radius**2, np.sqrt(0.06**2 + 0.1**2 + 0.11**2)
    wall = 2 * np.pi * radius / (1 / 0.05 + 1 / 0.85 - 1) * 4 * SIGMA
    t = full.steady[full.free][bars].mean()
    given, taken = wall * full.steady[full.name.index("SC_MINUS_Y")] ** 3, wall * t**3
    stored = taken + 2j * np.pi * frequency * density * c_p * section
    m, ground = np.sqrt(stored / (k * section)) * length, given / stored
    a = hub - ground
    b = (1 - ground - a * np.cosh(m)) / np.sinh(m)
    mean = ground + (a * np.sinh(m) + b * (np.cosh(m) - 1)) / m
    assert abs(gain[bars].mean() / mean - 1) < 0.02


def time_constants(net: DenseNetwork) -> np.ndarray:
    """Of the linearised network, s, ascending; nodes without capacity eliminated."""
    k, f = net.conduction(net.steady), net.free
    own, none = f[net.capacity[f] > 0], f[net.capacity[f] == 0]
    kept: np.ndarray = k[np.ix_(own, own)] - k[np.ix_(own, none)] @ np.linalg.solve(
        k[np.ix_(none, none)], k[np.ix_(none, own)]
    )
    rate = np.linalg.eigvals(kept / net.capacity[own][:, None])
    np.testing.assert_allclose(rate.imag, 0.0, atol=1e-12)
    return np.sort(1 / rate.real)


def test_time_constants(full: DenseNetwork) -> None:
    """All decay; the slowest are the test masses, then all within the shield together, about as by hand."""
    tau = time_constants(full)
    assert tau[0] > 1.0
    out = full.gl + 4 * SIGMA * full.gr * full.steady[:, None] ** 3
    test_mass = [n.startswith("TM") for n in full.name]
    alone = full.capacity[test_mass] / out[test_mass].sum(axis=1)
    np.testing.assert_allclose(tau[-2:], alone, rtol=0.15)
    inside = np.array([n.startswith(("OB_", "IS", "TM", "FLANGE")) for n in full.name])
    shield = np.array([n.startswith("SHIELD") for n in full.name])
    ways = [out[np.ix_(inside, ~inside)].sum(), out[np.ix_(shield, ~inside & ~shield)].sum()]
    together = full.capacity[inside].sum() * (1 / ways[0] + 1 / ways[1])
    assert 1.0 < tau[-3] / together < 1.5, "longer, as the inside is not isothermal"
    assert np.sum(tau > 5 * 3600) == 5, "then the sensors against each other, and the bench against both"


def asd(noise: DenseSpectra, net: DenseNetwork, pattern: str) -> np.ndarray:
    """Amplitude spectral densities [F, nodes] of the free nodes of a pattern, K/sqrt(Hz)."""
    chosen = [i for i, n in enumerate(net.free) if re.fullmatch(pattern, net.name[n])]
    assert chosen
    return np.sqrt(np.einsum("fii->fi", noise.psd).real[:, chosen])


def test_levels_are_those_that_were_published(noise: DenseSpectra, full: DenseNetwork) -> None:
    """The shield's inner side about 1e-4 K/sqrt(Hz) at 1 mHz (thesis, 3.4); within, no more than flight saw."""
    shield = asd(noise, full, "SHIELD_INNER_.*")[0]
    assert shield.min() > 0.9e-4
    assert shield.max() < 1.2e-4
    with_elements = r"OB_.*|IS\d_(VE|WINDOW|EH|SUPPORT|CM|BRACKET|PUMP)_?.*|IS\d_CAGING_(UP|DOWN)"
    assert asd(noise, full, with_elements).max() < 1e-5
    outside = asd(noise, full, "STRUT_.*|FLANGE_.*")[0]
    assert outside.min() > 1e-5
    assert outside.max() < 1e-3


def test_spectra_are_hermitian_and_positive(noise: DenseSpectra) -> None:
    for s in noise.psd:
        np.testing.assert_allclose(s, s.conj().T, rtol=1e-9, atol=1e-12 * np.abs(s).max())
        assert np.linalg.eigvalsh(s).min() > -1e-12 * np.abs(s).max()


@pytest.mark.parametrize("detail", ["full", "small"])
def test_configuration_fits_the_network(detail: str, coarse: Path) -> None:
    """Nodes of the disturbances by kind, the bus by the units' powers, conductivities of the deck's materials."""
    tables = tomllib.loads(THERMAL[detail].read_text(encoding="utf-8"))
    folder = coarse if detail == "full" else SMALL
    kind = {row["node"]: row["kind"] for row in rows(folder / "thermal_nodes.csv")}
    power = {row["node"]: float(row["power_W"]) for row in rows(folder / "thermal_powers.csv")}
    for given in tables["disturbance"]:
        assert {kind[n] == "boundary" for n in given["nodes"]} == {given["kind"] == "temperature"}
    bus = next(d for d in tables["disturbance"] if d["name"] == "bus_voltage")
    total = sum(power[n] for n in bus["nodes"])
    assert bus["weights"] == pytest.approx([power[n] / total for n in bus["nodes"]], abs=1e-3)
    assert bus["level_W"] == pytest.approx(1e-4 * total, rel=0.01)
    light = next(d for d in tables["disturbance"] if d["name"] == "photodiodes")
    shares = light.get("weights", [1.0])
    assert dict(zip(light["nodes"], shares, strict=True)) == pytest.approx(
        {n: p / 0.04 for n, p in power.items() if n.startswith("OB_")}
    )
    bodies = {str(n): k for n, k in enumerate((1.46, 6.7, 138.0, 174.0, 0.8, 0.5), start=1)}
    assert tables["map"]["conductivity_W_m_K"] == {n: k for n, k in bodies.items() if detail == "full" or n in "126"}


def test_build_thermal_finds_the_same(folder: Path, net: DenseNetwork, tmp_path: Path) -> None:
    """Steady state, gains and spectra in thermal.h5 against the dense solution: no code in common."""
    frequency = [1e-5, 1e-4, 1e-3, 1e-2, 0.1]
    project = ThermalProject(tmp_path / "project")
    text = THERMAL["small" if folder == SMALL else "full"].read_text(encoding="utf-8").split("\n[map]")[0]
    beside = project.build if "{build_dir}/" in text else project.folder
    (project.folder / "thermal.toml").write_text(f"{text}\n[frequency]\nlist_hz = {frequency}\n", encoding="utf-8")
    beside.mkdir(exist_ok=True)
    for name in NAMES:
        shutil.copy(folder / name, beside)
    project.run("build-thermal").ok()
    expected = spectra(net, project.folder / "thermal.toml", np.array(frequency))
    with project.file() as file:
        assert file["node/name"].asstr()[()].tolist() == net.name
        assert file["node/free"][()].tolist() == net.free.tolist()
        assert file["disturbance/name"].asstr()[()].tolist() == expected.disturbance
        np.testing.assert_allclose(file["steady_K"][()], net.steady, rtol=1e-11)
        scale = np.abs(expected.transfer).max(axis=1, keepdims=True)
        assert (np.abs(file["transfer"][()] - expected.transfer) / scale).max() < 1e-10
        own = np.sqrt(np.einsum("fii->fi", expected.psd).real)
        assert (np.abs(file["psd"][()] - expected.psd) / (own[:, :, None] * own[:, None, :])).max() < 1e-9


def test_page_shows_what_is_assumed() -> None:
    """The table of docs/explanation/sample.md is the one that the script prints."""
    script = ROOT / "sample_models" / "ltp_like_assumptions.py"
    printed = subprocess.run(
        [sys.executable, "-X", "utf8", script], capture_output=True, encoding="utf-8", check=True
    ).stdout
    assert printed.count("\n") > 40
    assert printed in (ROOT / "docs" / "explanation" / "sample.md").read_text(encoding="utf-8"), (
        f"python {script.relative_to(ROOT)} prints the table"
    )
