"""The same body in two meshes: its field by quadrature is the same, its field by lumped masses is not."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from tedm_cli.gravity.masses import PointMasses, mass_distribution
from tedm_cli.gravity.structure import StructureGravity, structure_gravity
from tedm_cli.gravity.testmass import TestMass
from tedm_cli.nastran.geometry import ModelGeometry, model_geometry
from tedm_cli.nastran.reading import read_deck

ROOT = Path(__file__).parents[2]
CUBE = TestMass(name="TM1", position_m=np.array([-0.188, 0.0, 0.0]), side_m=np.full(3, 0.046), mass_kg=1.96)
TOLERANCE = 1e-4


@pytest.fixture(scope="module")
def meshes(tmp_path_factory: pytest.TempPathFactory) -> list[ModelGeometry]:
    """The small sample with elements as long as its blocks, and of 12 mm."""
    folder = tmp_path_factory.mktemp("meshes")
    out = []
    for size in ("1000", "12"):
        deck = folder / f"{size}.bdf"
        script = [sys.executable, "sample_models/ltp_like.py", "--detail", "small", "--element-size-mm", size]
        subprocess.run([*script, "--layout", "configs/optics.toml", "-o", str(deck)], cwd=ROOT, check=True)
        out.append(model_geometry(read_deck(deck), [deck]))
    return out


def gravity(geometry: ModelGeometry, *, lumped: bool) -> StructureGravity:
    e, c = geometry.elements, geometry.concentrated
    masses = mass_distribution(
        geometry.position_m,
        element_id=e.id,
        card=e.type,
        mass=e.mass_kg,
        node_offset=e.node_offset,
        node_index=e.node_index,
        lever=e.lever,
        thickness=e.section,
        points=PointMasses(name=[f"CONM2 {i}" for i in c.id], mass=c.kg, node=c.node, offset=c.lever),
        lumped=lumped,
    )
    return structure_gravity(masses, CUBE, tolerance=TOLERANCE)


def moved(one: StructureGravity, other: StructureGravity, name: str) -> float:
    a, b = getattr(one.field, name), getattr(other.field, name)
    return float(np.abs(a - b).max() / np.abs(b).max())


def test_field_by_quadrature_does_not_depend_on_the_mesh(meshes: list[ModelGeometry]) -> None:
    coarse, fine = (gravity(m, lumped=False) for m in meshes)
    for name in ("acceleration", "angular_acceleration", "gamma_lin", "omega_lin", "gamma_ang", "omega_ang"):
        assert moved(coarse, fine, name) < TOLERANCE, name


def test_field_of_lumped_masses_does_and_converges_to_that_of_quadrature(meshes: list[ModelGeometry]) -> None:
    """The gradient is 130 % of its size off on the coarse mesh and still 3 % with elements of 12 mm."""
    coarse, fine = (gravity(m, lumped=True) for m in meshes)
    spread = gravity(meshes[1], lumped=False)
    assert moved(coarse, spread, "acceleration") > 0.1
    assert moved(coarse, spread, "gamma_lin") > 1.0
    assert 0.01 < moved(fine, spread, "gamma_lin") < 0.05
