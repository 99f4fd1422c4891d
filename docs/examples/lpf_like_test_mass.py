"""How far the true shape of a test mass moves what the cube of its size gives.

A test mass like that of LISA Pathfinder: 46 mm, all edges chamfered, and in the middle of both z faces a recess for the
plunger that holds it at launch. The sizes are ours, of published magnitude, and no flight data. Its mass
stays that of the cube. On the sample of `tedm init`, or on a project that is built:
`python lpf_like_test_mass.py tedm.toml build`.
"""

import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

from tedm_cli.config.model.body import TestMassTable
from tedm_cli.config.model.file import load_model
from tedm_cli.config.project import load_project
from tedm_cli.contracts import DISTORTION, UNIT_LOADS
from tedm_cli.files.store import open_checked
from tedm_cli.gravity.body_source import field_of_other_test_mass
from tedm_cli.gravity.operator import contract
from tedm_cli.gravity.structure import structure_gravity
from tedm_cli.gravity.testmass import TestMass
from tedm_cli.results.unit_loads import mass_of

# What [[test_mass]] says besides name, position_m, side_m and mass_kg
CHAMFERS = {"chamfer_m": 0.002}
RECESSES = {"pocket": [{"face": face, "diameter_m": 0.010, "depth_m": 0.003} for face in ("+z", "-z")]}
SHAPES = {"cube": {}, "chamfers": CHAMFERS, "recesses": RECESSES, "both": CHAMFERS | RECESSES}

with tempfile.TemporaryDirectory() as folder:
    project = Path(folder) / "demo"
    config, build = project / "tedm.toml", project / "build"
    if len(sys.argv) > 1:
        config, build = map(Path, sys.argv[1:3])
    else:
        for command in (["init", str(project)], ["ingest"], ["build-distortion"]):
            where = Path(folder) if command[0] == "init" else project
            subprocess.run([sys.executable, "-m", "tedm_cli.cli", *command, "--quiet"], cwd=where, check=True)
    with open_checked(build / "unit_loads.h5", UNIT_LOADS) as file:
        masses = mass_of(file)
    with open_checked(build / "distortion.h5", DISTORTION) as file:
        translation, rotation = file.array(DISTORTION.D_TRANSLATION), file.array(DISTORTION.D_ROTATION)
    tables = load_model(load_project(config, build).model)[1].test_mass


def shaped(keys: dict[str, object]) -> list[TestMass]:
    """The test masses of the project, of this shape."""
    made = [TestMassTable.model_validate(table.model_dump(exclude_unset=True) | keys) for table in tables]
    return [table.test_mass(table.body(config.parent)) for table in made]


def results(test_masses: list[TestMass]) -> dict[str, np.ndarray]:
    """Field of structure and other test mass at rest, stiffness, and S_SG of the structure; TM1 alone of the sample."""
    fields, parts = [], []
    for tm, other in (test_masses, test_masses[::-1])[: 2 if len(sys.argv) > 1 else 1]:
        structure = structure_gravity(masses, tm, tolerance=1e-3)
        fields.append(structure.field + field_of_other_test_mass(tm, other)[0])
        operators = (structure.operator, translation), (structure.rotation, rotation)
        parts.append(sum(contract(o.reshape(6, -1, 3), d) for o, d in operators))
    return {
        "a at rest, m/s^2": np.array([f.acceleration for f in fields]),
        "omegadot at rest, rad/s^2": np.array([f.angular_acceleration for f in fields]),
        "Gamma_lin, 1/s^2": np.array([f.gamma_lin for f in fields]),
        "Omega_ang, 1/s^2": np.array([f.omega_ang for f in fields]),
        "S_SG of a, m/s^2/K": np.array([s[:3] for s in parts]),
        "S_SG of omegadot, rad/s^2/K": np.array([s[3:] for s in parts]),
    }


test_masses = {name: shaped(keys) for name, keys in SHAPES.items()}
body = {name: pair[0].body for name, pair in test_masses.items()}
found = {name: results(pair) for name, pair in test_masses.items()}
cube = body["cube"]
print(f"{'':28}{'largest, cube':>15}" + "".join(f"{name:>12}" for name in SHAPES if name != "cube"))
volumes = [body[name].volume_m3 / cube.volume_m3 - 1.0 for name in SHAPES if name != "cube"]
print(f"{'volume':28}{cube.volume_m3:15.4e}" + "".join(f"{100 * v:+11.3f}%" for v in volumes))
change = {}
for quantity, value in found["cube"].items():
    size = np.abs(value).max()
    change[quantity] = [np.abs(found[name][quantity] - value).max() / size for name in SHAPES if name != "cube"]
    print(f"{quantity:28}{size:15.4e}" + "".join(f"{100 * c:11.4f}%" for c in change[quantity]))

# The chamfers of the edges take prisms, which meet in the corners: 6 c² (s - c); a recess takes its cylinder. And a
# test mass is nearly a point whatever its shape, but its torque is all shape.
c, s = 0.002, 0.046
error = max(abs(volumes[0] + 6.0 * c**2 * (s - c) / s**3), abs(volumes[1] + 2.0 * np.pi * 0.005**2 * 0.003 / s**3))
assert error < 1e-12 < max(change["a at rest, m/s^2"]) < 0.01 < max(change["omegadot at rest, rad/s^2"])
