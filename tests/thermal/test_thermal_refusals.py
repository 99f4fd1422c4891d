"""What is wrong with a thermal model is told in one clear error: file, place, fact, fix; and nothing is written."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from thermal_project import ThermalProject, write_tmd

from tedm_cli.files import tmd

WARM = dict.fromkeys(("SC", "SPACE", "SHIELD", "OB", "BOX", "JOINT"), 293.15)

#: Name of the mistake: file, a text in it, what takes its place; exit code, pieces of the error, of the hint.
TABLES: dict[str, tuple[str, str, str, int, tuple[str, ...], str]] = {
    "unit of capacity": ("nodes.csv", "capacity_J_K", "capacity_kJ_K", 4, ("nodes.csv:1", "misses capacity_J_K"), ""),
    "unit of conductance": (
        "conductors.csv", "GL_W_K", "GL_mW_K", 4, ("conductors.csv:1", "misses GL_W_K, has 'GL_mW_K'"), ""),
    "unit of power": ("powers.csv", "power_W", "power_mW", 4, ("powers.csv:1", "misses power_W"), ""),
    "unit of temperature": (
        "nodes.csv", "temperature_K", "temperature_F", 4, ("nodes.csv:1", "has 'temperature_F'"), ""),
    "missing node of a conductor": (
        "conductors.csv", "JOINT,OB", "JOINTS,OB", 4,
        ("conductors.csv:4", "node 'JOINTS' is not in", "nodes.csv"), "did you mean 'JOINT'"),
    "case of a conductor": (
        "conductors.csv", "JOINT,OB", "Joint,OB", 4, ("conductors.csv:4", "node 'Joint'"), "there is 'JOINT'"),
    "missing node of a power": ("powers.csv", "BOX,1", "BUS,1", 4, ("powers.csv:3", "node 'BUS' is not in"), ""),
    "negative capacity": (
        "nodes.csv", "2000,", "-2000,", 4, ("nodes.csv:4", "heat capacity -2000 is outside 0 to 1e+12 J/K"), ""),
    "negative conductance": (
        "conductors.csv", "BOX,OB,0.5", "BOX,OB,-0.5", 4, ("conductors.csv:6", "conductance -0.5 is outside"), ""),
    "negative radiation": (
        "conductors.csv", "BOX,SPACE,0,0.005", "BOX,SPACE,0,-0.005", 4,
        ("conductors.csv:7", "radiative conductance -0.005 is outside"), ""),
    "no number": ("conductors.csv", "0.5", "strong", 4, ("conductors.csv:6", "found 'strong'"), ""),
    "no conductance": ("conductors.csv", "BOX,OB,0.5,0", "BOX,OB,,0", 4, ("conductors.csv:6", "GL_W_K"), ""),
    "to itself": ("conductors.csv", "BOX,OB", "BOX,BOX", 4, ("conductors.csv:6", "joins node 'BOX' to itself"), ""),
    "no path to a boundary": (
        "conductors.csv", "SHIELD,JOINT,0.1,0\nJOINT,OB,0.1,0\n", "SHIELD,JOINT,0,0\nJOINT,OB,0,0\n", 4,
        ("conductors.csv", "no conductor leads to a boundary from node JOINT"), "conductors that are missing"),
    "case only": (
        "nodes.csv", "BOX,800", "ob,800", 4, ("nodes.csv:6", "nodes 'OB' and 'ob' differ in case only"), "rename"),
    "twice": ("nodes.csv", "BOX,800", "OB,800", 4, ("nodes.csv:6", "node 'OB' is there twice"), ""),
    "arithmetic with capacity": (
        "nodes.csv", "JOINT,0", "JOINT,4", 4, ("nodes.csv:7", "arithmetic, but its capacity is 4 J/K"), "write 0"),
    "diffusive without": (
        "nodes.csv", "800,diff", "0,diff", 4, ("nodes.csv:6", "its capacity is 0"), "call it arithmetic"),
    "kind": ("nodes.csv", "JOINT,0,arithmetic", "JOINT,0,edge", 4, ("nodes.csv:7", "found 'edge'"), ""),
    "boundary without temperature": (
        "nodes.csv", "boundary,3", "boundary,", 4,
        ("nodes.csv:3", "boundary 'SPACE' has no temperature"), "temperature_K"),
    "no boundary": (
        "nodes.csv", "SC,0,boundary,293.15\nSPACE,0,boundary,3", "SC,1,diffusive,293.15\nSPACE,1,diffusive,3", 4,
        ("no node is a boundary",), "deep space"),
    "below absolute zero": (
        "nodes.csv", "boundary,3", "boundary,-3", 4, ("nodes.csv:3", "temperature -3 is outside"), ""),
    "no steady state": (
        "powers.csv", "BOX,2", "BOX,-2000", 5, ("conductors.csv", "no steady state after"), "more power is taken"),
    "level of a table": ("bus.csv", "1e-5,1e-2", "1e-5,0", 4, ("bus.csv:2", "noise level 0 is outside"), ""),
    "range of a table": ("bus.csv", "1e-5,1e-2", "1e-3,1e-2", 4, ("bus.csv", "1e-05 Hz is asked for"), "extend it"),
    "order of a table": ("bus.csv", "1,1e-4", "1e-6,1e-4", 4, ("bus.csv", "not above"), ""),
    "not positive semidefinite": (
        "thermal.toml", "[[correlation]]",
        '[[disturbance]]\nname = "sun"\nnodes = ["SPACE"]\nkind = "temperature"\npreset = "white"\nlevel_K = 1\n'
        '[[correlation]]\ndisturbances = ["sun", "panel"]\nrho = 1\n'
        '[[correlation]]\ndisturbances = ["sun", "bus"]\nrho = -1\n[[correlation]]', 5,
        ("[[correlation]]", "not positive semidefinite", "panel"), "multiply the entries"),
    "node of a disturbance": (
        "thermal.toml", '["SC"]', '["SCC"]', 4, ("disturbance[0].nodes", "no node is called 'SCC'"), ""),
    "temperature of a free node": (
        "thermal.toml", '["SC"]', '["OB"]', 4, ("disturbance[0].nodes", "'OB' is diffusive"), "the node a boundary"),
    "power at a boundary": (
        "thermal.toml", '["BOX", "OB"]', '["BOX", "SC"]', 4, ("disturbance[1].nodes", "'SC' is a boundary"), ""),
    "node of an output": (
        "thermal.toml", "[frequency]", '[output]\nnodes = ["ob"]\n[frequency]', 4,
        ("output.nodes[0]", "no node is called 'ob'"), "there is 'OB', whose case differs"),
    "boundary as an output": (
        "thermal.toml", "[frequency]", '[output]\nnodes = ["SC"]\n[frequency]', 4,
        ("output.nodes[0]", "a boundary"), ""),
    "weights": ("thermal.toml", "[0.8, 0.2]", "[0.8, 0.3]", 3, ("disturbance[1]", "weights sum to 1.1"), ""),
    "number of weights": ("thermal.toml", "[0.8, 0.2]", "[1.0]", 3, ("disturbance[1]", "1 weights for 2 nodes"), ""),
    "weights of a temperature": (
        "thermal.toml", 'preset = "white"', 'weights = [1.0]\npreset = "white"', 3, ("weights share a power",), ""),
    "unit of a level": (
        "thermal.toml", "level_K = 1e-3", "level_W = 1e-3", 3, ("disturbance[0]", "level_W is given"), ""),
    "order": (
        "thermal.toml", 'preset = "white"', 'preset = "thesis"\norder = 12\ncorner_hz = 1e-9', 3,
        ("disturbance[0].order", "order 12 beyond 1e-09 Hz"), ""),
    "no level": ("thermal.toml", "level_K = 1e-3\n", "", 3, ("disturbance[0]", "preset white needs level_K"), ""),
    "flight power": (
        "thermal.toml", 'table = "bus.csv"', 'preset = "lpf_flight"', 3, ("cannot be used for powers",), ""),
    "names twice": ("thermal.toml", 'name = "bus"', 'name = "panel"', 3, ("disturbance panel is there twice",), ""),
    "unknown correlation": (
        "thermal.toml", '["panel", "bus"]', '["panel", "sun"]', 3, ("correlation[0]", "'sun'", "panel, bus"), ""),
    "correlation of itself": ("thermal.toml", '["panel", "bus"]', '["bus", "bus"]', 3, ("correlation[0]", "twice"), ""),
    "rho": ("thermal.toml", "rho = 0.5", "rho = 1.5", 3, ("correlation[0].rho", "1.5 is outside"), ""),
    "correlation twice": (
        "thermal.toml", "rho = 0.5", 'rho = 0.5\n[[correlation]]\ndisturbances = ["bus", "panel"]\nrho = 0.1', 3,
        ("correlation[1]", "have a correlation already"), ""),
    "frequencies": ("thermal.toml", "[1e-5, 1e-4,", "[1e-4, 1e-4,", 3, ("0.0001 Hz is not above",), ""),
    "two sources": ("thermal.toml", "[frequency]", 'tmd = "M.TMD"\n[frequency]', 3, (), ""),
    "no conductors": (
        "thermal.toml", 'conductors = "conductors.csv"\n', "", 3, ("network", "needs nodes and conductors"), ""),
    "idle time": ("thermal.toml", 'nodes = "nodes.csv"', 'nodes = "nodes.csv"\ntime_s = 1.0', 3, ("has no tmd",), ""),
    "no such table": ("thermal.toml", "powers.csv", "power.csv", 4, ("power.csv",), ""),
}  # fmt: skip


@pytest.mark.parametrize("mistake", TABLES)
def test_of_the_tables_and_the_file(mistake: str, tmp_path: Path) -> None:
    name, old, new, code, pieces, hint = TABLES[mistake]
    project = ThermalProject(tmp_path / "network")
    project.change(name, old, new)
    project.run("build-thermal").refused(code, *pieces, hint=hint)
    assert not (project.build / "thermal.h5").exists()


def test_of_columns_of_nodes(tmp_path: Path) -> None:
    project = ThermalProject(tmp_path / "network")
    (project.folder / "nodes.csv").write_text("node,capacity_J_K,kind\nOB,1,diffusive\n")
    project.run("build-thermal").refused(4, "nodes.csv:1", "has no column temperature_K", hint="may be empty")
    both = "node,capacity_J_K,kind,temperature_K,temperature_degC\nOB,1,boundary,300,\n"
    (project.folder / "nodes.csv").write_text(both)
    project.run("build-thermal").refused(4, "nodes.csv:1", "has both temperature_K and temperature_degC")
    (project.folder / "nodes.csv").write_text("node,capacity_J_K,kind,temperature_K,y_m\nOB,1,boundary,300,1\n")
    project.run("build-thermal").refused(4, "nodes.csv:1", "has y_m alone of x_m, y_m, z_m")


def test_what_no_boundary_holds_is_named_up_to_five(tmp_path: Path) -> None:
    project = ThermalProject(tmp_path / "network")
    with (project.folder / "nodes.csv").open("a") as nodes:
        nodes.write("".join(f"L{i},1,diffusive,\n" for i in range(8)))
    project.run("build-thermal").refused(4, "from nodes L0, L1, L2, L3, L4 and 3 more", hint="leave the nodes out")


REAL = np.zeros((2, 7, 13))
TMD: dict[str, tuple[dict[str, object], tuple[str, ...], str]] = {
    "no offset": ({"TAbs": None}, ("does not say whether its temperatures are in K or degC", "TAbs"), 'unit = "degC"'),
    "odd offset": ({"TAbs": 459.67}, ("TAbs is 459.67", "neither in K nor in degC"), ""),
    "offset of two": ({"TAbs": np.array([1.0, 2.0])}, ("attribute TAbs", "wanted one number"), "ESATAN-TMS"),
    "kelvin taken for celsius": ({"TAbs": 0.0}, ("outside 0 to 10000 K",), ""),
    "no nodes": ({"thermalNodes": None}, ("has no dataset thermalNodes",), "ESATAN-TMS"),
    "no conductors": ({"conductorsGR": None}, ("has no dataset conductorsGR",), "ESATAN-TMS"),
    "no temperature": (
        {"thermalNodesRealAttributes": np.array([*"ABCDEFGHIJKLM"], dtype="S3")},
        ("has no quantity T",), "ESATAN-TMS"),
    "other shape": (
        {"thermalNodesRealData": np.zeros((2, 6, 13))}, ("thermalNodesRealData is (2, 6, 13)", "(2, 7, 13)"), ""),
    "words for numbers": ({"times": np.array([b"a", b"b"])}, ("times holds |S1",), ""),
    "node beyond": ({"conductorsGL": np.array([[1, 8]] * 5)}, ("conductorsGL has 8 in row 1", "7 nodes"), ""),
    "number twice": (
        {"thermalNodes": np.array([[1], [2], [10], [10], [30], [40], [99]])}, ("node 10 is there twice",), ""),
    "kind": (
        {"thermalNodesStringData": np.array([[["Q", "x"]] * 7] * 2, dtype="S2")}, ("node 1 is of kind 'Q'",), ""),
    "negative conductance": (
        {"conductorDataGL": np.full((2, 5, 1), -0.5)}, ("1 to 10: conductance -0.5 is outside",), ""),
    "not a number": ({"thermalNodesRealData": np.full((2, 7, 13), np.nan)}, ("1: heat capacity nan is outside",), ""),
    "no boundary": (
        {"thermalNodesStringData": np.array([[["A", "x"]] * 7] * 2, dtype="S2"), "thermalNodesRealData": REAL},
        ("no node is a boundary",), "deep space"),
}  # fmt: skip


def esatan(folder: Path, network: str = 'tmd = "MODEL.TMD"') -> ThermalProject:
    project = ThermalProject(folder)
    (project.folder / "thermal.toml").write_text(f"[network]\n{network}\n")
    return project


@pytest.mark.parametrize("mistake", TMD)
def test_of_a_tmd_file(mistake: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(tmd, "_try", lambda path, identity: None)  # a process of its own, which the others start
    changed, pieces, hint = TMD[mistake]
    project = esatan(tmp_path / "network")
    # With kelvin, TAbs 0 says so: celsius below zero in it is no temperature.
    temperature = {**WARM, "SPACE": 200.0} if mistake == "kelvin taken for celsius" else WARM
    write_tmd(project.folder / "MODEL.TMD", temperature, **changed)
    project.run("build-thermal").refused(4, "MODEL.TMD", *pieces, hint=hint)
    assert not (project.build / "thermal.h5").exists()


def test_of_the_times_and_units_of_a_tmd_file(tmp_path: Path) -> None:
    project = esatan(tmp_path / "network", 'tmd = "MODEL.TMD"\ntime_s = 7.0')
    write_tmd(project.folder / "MODEL.TMD", WARM)
    project.run("build-thermal").refused(4, "has no time 7 s; the nearest is 0 s of 0 to 3600 s", hint="time_s")
    project = esatan(tmp_path / "network", 'tmd = "MODEL.TMD"\nunit = "K"')
    project.run("build-thermal").refused(4, "in degC by the attribute TAbs, but unit is K", hint="leave unit out")
    write_tmd(project.folder / "MODEL.TMD", WARM, TAbs=None)
    project = esatan(tmp_path / "network", 'tmd = "MODEL.TMD"\nunit = "degC"')
    project.run("build-thermal").ok()
    with project.file() as file:
        assert file["steady_K"][()] == pytest.approx(293.15, rel=1e-15)


@pytest.mark.parametrize("keep", [0, 3000])
def test_of_a_tmd_file_that_was_cut(keep: int, tmp_path: Path) -> None:
    project = esatan(tmp_path / "network")
    write_tmd(project.folder / "MODEL.TMD", WARM)
    raw = (project.folder / "MODEL.TMD").read_bytes()
    (project.folder / "MODEL.TMD").write_bytes(raw[:keep])
    project.run("build-thermal").refused(4, "MODEL.TMD", "not a readable HDF5 file", hint="ESATAN-TMS")
    (project.folder / "MODEL.TMD").unlink()
    project.run("build-thermal").refused(4, "no such file")
