"""The reference model: a mesh of 2689 nodes around two cubes, with fields computed by another program."""

import json

import numpy as np
import pytest
from mass_models import lumped_operator

from tedm_cli.gravity.field import self_gravity
from tedm_cli.gravity.operator import contract
from tedm_cli.gravity.testmass import TestMass


@pytest.fixture(scope="module")
def reference(mini_ltp_dir):
    with np.load(mini_ltp_dir / "reference.npz") as arrays:
        tables = {name: arrays[name] for name in ("gid", "xyz", "mass", "D", "areas", "S_SG")}
    return json.loads((mini_ltp_dir / "reference.json").read_text()), tables


@pytest.fixture(scope="module")
def cubes(reference):
    return [
        TestMass(name=f"TM{n}", position_m=tm["centre"], side_m=np.full(3, tm["side"]), mass_kg=tm["mass"])
        for n, tm in enumerate(reference[0]["tm"], start=1)
    ]


@pytest.fixture(scope="module")
def sensitivity(reference, cubes):
    record, tables = reference
    operator = lumped_operator(tables["xyz"], tables["mass"], cubes, G=record["G"], node_ids=tables["gid"])
    return contract(operator, tables["D"][:, :, :3])


def assert_relative(found, expected, tolerance):
    expected = np.asarray(expected)
    assert np.abs(found - expected).max() <= tolerance * np.abs(expected).max()


@pytest.mark.parametrize("index", [0, 1])
def test_static_field_and_matrices(reference, cubes, index):
    record, tables = reference
    tm, expected = cubes[index], record["tm"][index]
    gravity = self_gravity(tables["xyz"], tables["mass"], tm, G=record["G"], node_ids=tables["gid"])
    inertia = np.diag(tm.inertia_kg_m2)[:, None]
    assert_relative(np.diag(tm.inertia_kg_m2), expected["inertia"], 1e-15)
    assert_relative(gravity.acceleration, expected["a_dc"], 1e-14)
    # the reference itself states 4e-13 for its torques, by comparison with 40 digits
    assert_relative(gravity.angular_acceleration, expected["omegadot_dc"], 1e-12)
    assert_relative(gravity.gamma_lin * tm.mass_kg, expected["Gamma_lin"], 2e-14)
    assert_relative(gravity.omega_lin * inertia, expected["Omega_lin"], 1e-12)
    assert_relative(gravity.gamma_ang * tm.mass_kg, expected["Gamma_ang"], 1e-12)
    assert_relative(gravity.omega_ang * inertia, expected["Omega_ang"], 1e-12)


def test_sensitivity_to_the_thermal_areas(reference, sensitivity):
    expected = reference[1]["S_SG"]
    assert sensitivity.shape == expected.shape == (12, 19)
    for row in range(12):
        assert_relative(sensitivity[row], expected[row], 2e-14 if row < 6 else 5e-13)


@pytest.mark.parametrize("area", ["IS1_TOP", "STRUT3"])
def test_sensitivity_against_the_displaced_mesh(reference, sensitivity, area):
    """Central differences of the 40-digit field over the displacements of 1 K; their own error is of second order."""
    record, tables = reference
    column = sensitivity[:, list(tables["areas"]).index(area)].reshape(4, 3)
    differences = np.reshape(record["brute_force"][area]["central"], (4, 3))
    for found, expected in zip(column, differences, strict=True):
        assert_relative(found, expected, 5e-9)
