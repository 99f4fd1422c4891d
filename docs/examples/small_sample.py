"""The shipped small sample, from the Nastran results to a sensitivity, checked by moving the mass.

Three commands turn the unit loads of the sample of `tedm init` into [S_SG], the acceleration of each test mass per
kelvin of each thermal area. Here one entry is found again without the operator that makes it: every piece of the
structure's mass is moved by what 10 K in the area do to it, forwards and backwards, and the two fields are subtracted.
"""

import subprocess
import sys
import tempfile
from pathlib import Path

from tedm_cli.config.model.file import load_model
from tedm_cli.contracts import DISTORTION, SENSITIVITY, UNIT_LOADS
from tedm_cli.files.store import open_checked
from tedm_cli.gravity.field import self_gravity
from tedm_cli.gravity.quadrature import quadrature_points
from tedm_cli.results.unit_loads import mass_of

AREA, KELVIN = "STRUT_1", 10.0

with tempfile.TemporaryDirectory() as folder:
    project = Path(folder) / "demo"
    for command in (["init", str(project)], ["ingest"], ["build-distortion"], ["build-sensitivity"]):
        where = Path(folder) if command[0] == "init" else project
        subprocess.run([sys.executable, "-m", "tedm_cli.cli", *command, "--quiet"], cwd=where, check=True)
    build = project / "build"
    _, config = load_model(project / "model.toml")
    with (
        open_checked(build / "unit_loads.h5", UNIT_LOADS) as unit_loads,
        open_checked(build / "distortion.h5", DISTORTION) as distortion,
        open_checked(build / "sensitivity.h5", SENSITIVITY) as sensitivity,
    ):
        column = sensitivity.strings("/area/name").index(AREA)
        row = sensitivity.strings("/row/label").index("TM1_a_x")
        stored = sensitivity.array("/S")[row, column]
        motion = KELVIN * distortion.dataset("/D/translation")[column]
        masses = mass_of(unit_loads)

test_mass = config.test_masses()[0]
ahead = behind = 0.0
for piece in quadrature_points(masses, test_mass, config.gravity.quadrature_tolerance):
    position = piece.position.reshape(-1, 3) @ test_mass.axes + test_mass.position_m
    shift = (piece.values @ motion[piece.nodes]).reshape(-1, 3)
    ahead += self_gravity(position + shift, piece.mass.ravel(), test_mass).acceleration[0]
    behind += self_gravity(position - shift, piece.mass.ravel(), test_mass).acceleration[0]
moved = (ahead - behind) / (2.0 * KELVIN)

print(f"TM1_a_x per kelvin of {AREA}: {stored:.6e} m s^-2/K in the file, {moved:.6e} by moving the mass")
assert abs(moved / stored - 1.0) < 1e-5
