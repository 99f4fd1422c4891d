"""Projects with every kind of file that users write: two bricks with cases and matrices, and a drag-free loop."""

from __future__ import annotations

import contextlib
import io
import re
import shutil
import sys
from dataclasses import dataclass
from pathlib import Path
from unittest import mock

import h5py
import numpy as np
from adjoint_solver import solve_forces
from fuzz_model import CONFIGS, fuzz_case
from thermal_project import FILES, write_tmd

from tedm_cli.cli import main
from tedm_cli.config.project import load_project
from tedm_cli.dynamics.signals import COORDINATES, INPUTS
from tedm_cli.gravity.bodies.solid import cuboid_triangles
from tedm_cli.nastran.op2.writer import write_op2
from tedm_cli.stages.dynamics.loop import project_loop

SMALL = CONFIGS.parent / "sample_models" / "small"
CASES = """
[[requirement]]
name = "budget"
table = "budget.csv"
quantity = "acceleration"
outputs = ["TM1_a_x"]

[[temperature.override]]
areas = ["TIP"]
preset = "table"
table = "spectra.csv"

[realisation]
seed = 1
rate_hz = 0.5
lowest_hz = 1e-2
samples = 8000

[[series]]
name = "warm"
file = "series.csv"
remove = "linear"
lowest_hz = 0.02

[[series]]
name = "nodes"
file = "thermal.csv"
weights = "nodes.csv"
unit = "degC"
remove = "mean"
lowest_hz = 0.02

[[case]]
id = "own"
title = "From a file"
matrix = "r.csv"
delays = [{ areas = ["TIP"], delay_s = 3.0 }]

[[case]]
id = "npz"
title = "From an archive"
matrix = "r.npz"
"""
ALL = '\n[[case]]\nid = "1"\ntitle = "All"\nblocks = [{ areas = ["*"], rho = 0.5 }]\n'
#: The nodes of a thermal model on the two bricks: one by its elements, one by its place.
THERMAL = """
[map]
elements = "map.csv"
nearest = "places.csv"

[map.conductivity_W_m_K]
1 = 150.0
2 = 20.0
"""
MAPPED = "[map]\nareas = true\n\n[map.conductivity_W_m_K]\n1 = 1.4\n2 = 6.7\n6 = 20.0\n"
BLOCKS = (
    "name,x_m,y_m,z_m,size_x_m,size_y_m,size_z_m,rotation_x_rad,rotation_y_rad,rotation_z_rad,mass_kg\n"
    "CM1,0.1,-0.2,0.0,0.02,0.03,0.04,0.1,0.2,0.3,0.5\nCM2,0.3,-0.2,0.1,0.02,0.03,0.04,0,0,0,1.5\n"
)
LOADS = """
[[foot]]
name = "ROOT"
box = { x_m = [-0.01, 0.01] }
motions = ["ux", "rz"]

[[gravity_release]]
name = "G"
ground_m_s2 = [0.0, 1.0, -9.8]

[[moisture_release]]
name = "DRY"

[[moisture_release.swelling]]
material = 2
expansion_per_percent = 2e-4
change_percent = -0.5

[modes]
number = 3
"""
#: Which nodes of a TMD file make the areas.
NUMBERED = "node,area,weight\n11,ROOT,0.25\n12,ROOT,0.75\n12,WAIST,1.0\n11,TIP,0.5\n12,TIP,0.5\n"
TEXTS = {
    "loads.toml": LOADS,
    "numbers.csv": NUMBERED,
    "budget.csv": "frequency_hz,amplitude\n1e-3,1e-12\n5e-3,1e-12\n3e-2,1e-11\n",
    "spectra.csv": "frequency_hz,TIP\n1e-5,1e-2\n1e-3,1e-3\n1,1e-5\n",
    "r.csv": "area,ROOT,WAIST,TIP\nROOT,1,0.5,0.1-0.2j\nWAIST,0.5,1,0\nTIP,0.1+0.2j,0,1\n",
    "points.csv": "x_m,y_m,z_m,mass_kg\n0.5,0.1,0.2,3.0\n-0.4,0.3,0.1,2.5\n",
    "blocks.csv": BLOCKS,
    "thermal.toml": THERMAL,
    "map.csv": "tmm_node,element_id\nNEAR,1\n",
    "places.csv": "node,capacity_J_K,x_m,y_m,z_m\nFAR,900,0.15,0.05,0.05\nSKY,0,,,\n",
    "tau.csv": "set,NEAR,FAR\nwarm,0.25,0.75\nwarmer,1.5,1.25\n",
    "nodes.csv": "node,area,weight\nN1,ROOT,0.25\nN2,ROOT,0.75\nN2,WAIST,1.0\nN1,TIP,0.5\nN2,TIP,0.5\n",
}
#: Boxes at the small sample, tolerances of parts of it, and what was measured of them.
BALANCE = """
clearance_m = 0.003

[tolerance]
block_mass = 1e-3
block_position_m = 1e-5
parts = "parts.csv"
draws = 100

[[box]]
name = "OUTER"
frame = "TM1"
low_m = [-0.064, 0.016, -0.030]
high_m = [-0.034, 0.060, 0.030]
density_kg_m3 = 18500.0
mirror = true
alike = true

[[box]]
name = "TRIM"
centre_m = [-0.23, 0.0, 0.0]
size_m = 0.012
rotation_rad = [0.0, 0.0, 0.1]
density_kg_m3 = 18500.0
step_kg = 0.005
alike = true
group = "IS1"
alike_group = "IS2"

[[keep_out]]
name = "BEAM"
low_m = [-0.1, -0.01, -0.01]
high_m = [0.1, 0.01, 0.01]
"""
PARTS = "part,sigma_mass,sigma_position_m\narea IS1_EH_OUTER,1e-3,1e-5\nproperty 1,1e-3,0\n"
MEASURED = "part,mass_kg,dx_m,dy_m,dz_m\narea IS1_EH_OUTER,0,1e-4,0,0\nblock OUTER,0,0,1e-4,0\n"
LOOP = """
[spacecraft]
mass_kg = 430.0
inertia_matrix_kg_m2 = [[203.0, 1.0, 0.5], [1.0, 210.0, 0.0], [0.5, 0.0, 192.0]]

[stiffness.electrostatic]
TM1 = [1e-6, 1e-6, 3e-6, 4e-6, 4e-6, 3e-6]
TM2 = [1e-6, 1e-6, 3e-6, 4e-6, 4e-6, 3e-6]

[read_out]
set = "B"

[[controller.loop]]
name = "x12"
crossover_hz = 8e-4
delay_s = 0.3

[controller.shape]
lead = 3.0

[noise]
actuation_stability = 4e-6
omit = ["sun"]

[[noise.source]]
name = "thruster_Fx"
level = 0.1e-6

[[noise.source]]
name = "magnetic"
group = "magnetic"
gains = { s_TM1_a_x = 1.0, s_TM2_a_x = -1.0 }
table = "magnetic.csv"

[[requirement]]
name = "lpf_acceleration"
outputs = ["delta_g"]
applies_to = "differential"
"""
MAGNETIC = "frequency_hz,amplitude\n1e-5,4e-15\n1e-3,1e-15\n1.0,5e-16\n"


@dataclass(frozen=True)
class Ran:
    code: int
    out: str
    err: str


def command(*args: object) -> Ran:
    """Run `tedm` in this process."""
    out, err = io.StringIO(), io.StringIO()
    argv = ["tedm", *(str(a) for a in args)]
    with mock.patch.object(sys, "argv", argv), contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        try:
            main()
        except SystemExit as exc:
            return Ran(exc.code if isinstance(exc.code, int) else 0, out.getvalue(), err.getvalue())
    return Ran(0, out.getvalue(), err.getvalue())


@dataclass(frozen=True)
class UserProject:
    """A project in a folder of its own, with its files between the stages in `build`."""

    folder: Path

    @property
    def build(self) -> Path:
        return self.folder / "build"

    def run(self, args: list[str], config: bool = True) -> Ran:
        args = [str(self.folder / a) if a.endswith((".csv", ".op2")) or a.startswith("build/") else a for a in args]
        project = ["-c", self.folder / "tedm.toml"] if config else []
        return command(*args, *project, *([] if args[0] == "self-gravity" else ["-d", self.build]))

    def sound(self, args: list[str], config: bool = True) -> str:
        ran = self.run(args, config)
        assert ran.code == 0, (args, ran.err)
        return ran.out


def bricks(folder: Path) -> UserProject:
    """Two bricks with compensation masses, cases of every kind, their matrices as CSV, NPZ and MAT, and the adjoint."""
    project = UserProject(fuzz_case(folder).folder)
    cases = (CONFIGS / "cases.toml").read_text(encoding="utf-8")
    cases = cases[: cases.index("# A requirement of your own")].replace("points = 301", "points = 31")
    text = re.sub(r"(?s)\[\[requirement\]\].*", "", cases) + CASES + ALL
    (project.folder / "cases.toml").write_text(text, encoding="utf-8")
    for name, text in TEXTS.items():
        (project.folder / name).write_text(text)
    file = project.folder / "tedm.toml"
    file.write_text('thermal = "thermal.toml"\nloads = "loads.toml"\n' + file.read_text())
    cube = cuboid_triangles(np.full(3, -0.023), np.full(3, 0.023))
    triangles = [[f"vertex {x} {y} {z}" for x, y, z in t] for t in cube]
    facets = ["\n".join(["facet normal 0 0 1", "outer loop", *t, "endloop", "endfacet"]) for t in triangles]
    (project.folder / "body.stl").write_text("\n".join(["solid cube", *facets, "endsolid cube", ""]))
    rows = "".join(f"{2.0 * n},{293.0 + 0.01 * np.sin(n):.6f},{293.0 + 1e-4 * n:.6f}\n" for n in range(900))
    (project.folder / "series.csv").write_text("time_s,TIP,all\n" + rows)
    nodes = "".join(f"{2.0 * n};{20.0 + 0.01 * np.sin(n):.6f};{20.0 + 1e-4 * n:.6f}\n" for n in range(900))
    (project.folder / "thermal.csv").write_text("time_s;N1;N2\n" + nodes.replace(".", ","))
    _write_temperatures(project.folder / "TIMES.TMD")
    R = np.array([[1.0, 0.5, 0.0], [0.5, 1.0, 0.2], [0.0, 0.2, 1.0]])
    np.savez_compressed(project.folder / "r.npz", area=np.array(["ROOT", "WAIST", "TIP"]), R=R)
    model = project.folder / "model.toml"
    model.write_text(model.read_text() + '\n[gravity]\ncompensation_masses = "blocks.csv"\n')
    for args in (["ingest"], ["build-distortion"], ["build-sensitivity"], ["build-optics"]):
        project.sound(args)
    for fmt in ("csv", "npz", "mat"):
        project.sound(["export", "--format", fmt, "-o", str(project.folder / "matrices")], config=False)
    project.sound(["write-deck", "--adjoint"])
    found = solve_forces(project.folder / "adjoint_loads.bdf", project.folder / "unit_loads.bdf")
    write_op2(project.folder / "adjoint.op2", *found)
    return project


def _write_temperatures(path: Path) -> None:
    """Three nodes over time, one of them inactive."""
    n = np.arange(900)
    real = np.zeros((900, 3, 2))
    real[:, 0, 0], real[:, 1, 0] = 20.0 + 0.01 * np.sin(n), 20.0 + 1e-4 * n
    with h5py.File(path, "w") as file:
        group = file.create_group("AnalysisSet1")
        group.attrs["TAbs"] = 273.15
        group["thermalNodes"] = np.array([[11, 0], [12, 0], [13, 0]], dtype=np.int32)
        group["thermalNodesRealAttributes"] = np.array(["T", "C"], dtype="S4")
        group["DataGroup1/times"] = 2.0 * n
        group["DataGroup1/thermalNodesRealData"] = real
        group["DataGroup1/thermalNodesStringData"] = np.array([[["D"], ["D"], ["X"]]] * 900).astype("S4")


def network(folder: Path) -> UserProject:
    """A thermal network in tables, with disturbances of both kinds, and the same as a file of ESATAN-TMS."""
    folder.mkdir(parents=True)
    for name, text in FILES.items():
        for table in ("nodes.csv", "conductors.csv", "powers.csv"):
            text = text.replace(f'"{table}"', f'"thermal_{table}"')
        (
            folder / (f"thermal_{name}" if f'"{name}"' in FILES["thermal.toml"] and name != "bus.csv" else name)
        ).write_text(text)
    project = UserProject(folder)
    project.sound(["build-thermal"])
    rows = "".join(f"{50.0 * n},{1e-3 * np.sin(n):.9f},{1e-2 * np.cos(n):.9f}\n" for n in range(200))
    (folder / "disturbances.csv").write_text("time_s,panel,bus\n" + rows)
    with h5py.File(project.build / "thermal.h5") as file:
        names = [name.decode() for name in file["node/name"][()]]
        write_tmd(folder / "MODEL.TMD", dict(zip(names, file["steady_K"][()].tolist(), strict=True)))
    return project


def small_chain(folder: Path, cases: str, dynamics: str) -> UserProject:
    """The small sample as far as its matrices, with two test masses, one case, and a configured loop."""
    folder.mkdir(parents=True)
    for name in ("ltp_small.bdf", "unit_loads.bdf", "unit_loads.op2", "model.toml", "ltp_small_areas.csv"):
        shutil.copy(SMALL / name, folder)
    shutil.copy(CONFIGS / "optics.toml", folder)
    head, *rest = (CONFIGS / "cases.toml").read_text(encoding="utf-8").split("\n[[case]]")
    third = next(text for text in rest if text.startswith('\nid = "3"'))
    text = head.replace("points = 301", "points = 31") + "\n[[case]]" + third + cases
    (folder / "cases.toml").write_text(text, encoding="utf-8")
    (folder / "dynamics.toml").write_text(dynamics)
    for name, text in FILES.items():
        if name != "tedm.toml":
            (folder / name).write_text(text)
    file = folder / "thermal.toml"
    file.write_text(file.read_text() + "\n" + MAPPED)
    areas = dict.fromkeys(line.split(",")[1] for line in (folder / "ltp_small_areas.csv").read_text().split()[1:])
    numbers = ",".join(f"{0.1 * k:.1f}" for k in range(len(areas)))
    (folder / "tau.csv").write_text(f"set,{','.join(areas)}\nrising,{numbers}\n")
    (folder / "balance.toml").write_text(BALANCE)
    (folder / "parts.csv").write_text(PARTS)
    (folder / "loads.toml").write_text(
        LOADS.replace("x_m = [-0.01, 0.01]", "y_m = [0.0, inf]").replace("= 2\n", "= 6\n")
    )
    named = "".join(f'{name} = "{name}.toml"\n' for name in ("dynamics", "thermal", "balance", "loads"))
    (folder / "tedm.toml").write_text(f'title = "small sample"\n{named}')
    project = UserProject(folder)
    for args in (["ingest"], ["build-distortion"], ["build-sensitivity"], ["build-optics"]):
        project.sound(args)
    return project


def loop(folder: Path) -> UserProject:
    """A satellite with a loop of its own, a table of noise, and the default controller as an archive."""
    project = small_chain(folder, "", "")
    (folder / "magnetic.csv").write_text(MAGNETIC)
    _controller(project)
    (folder / "dynamics.toml").write_text(LOOP)
    project.sound(["build-dynamics"])
    return project


def balanced(folder: Path) -> UserProject:
    """The small sample, balanced, and a table of what was measured of it."""
    project = small_chain(folder, "", "")
    (folder / "measured.csv").write_text(MEASURED)
    project.sound(["balance"])
    return project


def _controller(project: UserProject) -> None:
    """The default controller as matrices with names."""
    s = project_loop(load_project(project.folder / "tedm.toml", project.build)).controller.state_space()
    names = {"inputs": np.array(COORDINATES), "outputs": np.array(INPUTS)}
    np.savez_compressed(project.folder / "controller.npz", A=s.a, B=s.b, C=-s.c, D=-s.d, **names)
