"""The same body in two meshes: its field by quadrature is the same, its field by lumped masses is not."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from tedm_cli.gravity.quadrature import quadrature_points
from tedm_cli.gravity.structure import StructureGravity, structure_gravity
from tedm_cli.gravity.testmass import TestMass
from tedm_cli.nastran.geometry import ModelGeometry, model_geometry
from tedm_cli.nastran.reading import read_deck
from tedm_cli.stages.model.masses import distribution_of

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
    return structure_gravity(distribution_of(geometry, lumped=lumped), CUBE, tolerance=TOLERANCE)


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


def test_mass_moments_against_pynastran(meshes: list[ModelGeometry]) -> None:
    """pyNastran sums elements as points at their centroids: what lacks is each brick's and bar's own inertia.

    By quadrature the rest is exactly that; lumped at the corners a brick has three times its own inertia, and so has
    a bar at its ends.
    """
    from pyNastran.bdf.mesh_utils.mass_properties import mass_properties

    geometry = meshes[0]
    e = geometry.elements
    total, centre, inertia = mass_properties(read_deck(geometry.files[0]), sym_axis="no")
    own = np.zeros(3)
    for first, last, mass in zip(e.node_offset[:-1], e.node_offset[1:], e.mass_kg, strict=True):
        edge = np.ptp(geometry.position_m[e.node_index[first:last]], axis=0)
        own += mass * ((edge**2).sum() - edge**2) / 12.0
    for lumped, factor in ((False, 1.0), (True, 3.0)):
        pieces = list(quadrature_points(distribution_of(geometry, lumped=lumped), CUBE, 1e-3))
        mass = np.concatenate([p.mass.ravel() for p in pieces])
        x = np.concatenate([p.position.reshape(-1, 3) for p in pieces]) + CUBE.position_m
        assert mass.sum() == pytest.approx(total, rel=1e-12)
        np.testing.assert_allclose(mass @ x / total, centre, rtol=0, atol=1e-13)
        arm = x - centre
        moment = mass @ ((arm**2).sum(axis=1)[:, None] - arm**2)
        np.testing.assert_allclose(moment, inertia[:3] + factor * own, rtol=1e-10)
