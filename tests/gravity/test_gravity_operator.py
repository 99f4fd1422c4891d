"""The operator of nodal displacements against displaced fields."""

import numpy as np
import pytest
from mass_models import lumped_operator
from scipy.spatial.transform import Rotation

from tedm_cli.errors import PhysicsError
from tedm_cli.gravity.field import self_gravity
from tedm_cli.gravity.operator import contract, sensitivity_row_labels, sensitivity_row_units
from tedm_cli.gravity.testmass import TestMass

RNG = np.random.default_rng(17)
NODES = np.concatenate([RNG.uniform([-0.4, -0.4, 0.1], [0.4, 0.4, 0.9], (60, 3)), RNG.uniform(0.07, 0.1, (20, 3))])
MASSES = RNG.uniform(0.0, 1.0, 80)
DISPLACEMENTS = RNG.normal(size=(3, 80, 3)) * 1e-3
TEST_MASSES = [
    TestMass(name="TM1", position_m=np.array([-0.1, 0.0, 0.0]), side_m=np.array([0.04, 0.05, 0.03]), mass_kg=1.9),
    TestMass(
        name="TM2",
        position_m=np.array([0.2, 0.01, 0.0]),
        side_m=np.full(3, 0.046),
        mass_kg=1.96,
        axes=Rotation.from_rotvec([0.3, -0.8, 0.5]).as_matrix(),
    ),
]


def accelerations(points):
    results = [self_gravity(points, MASSES, tm) for tm in TEST_MASSES]
    return np.concatenate([*(r.acceleration for r in results), *(r.angular_acceleration for r in results)])


def test_sensitivity_is_the_derivative_of_the_displaced_field():
    """Central differences of the full field, second order in the displacement."""
    sensitivity = contract(lumped_operator(NODES, MASSES, TEST_MASSES), DISPLACEMENTS)
    assert sensitivity.shape == (12, 3)
    for case in range(3):
        errors = []
        for scale in (1.0, 0.5):
            shift = scale * DISPLACEMENTS[case]
            difference = (accelerations(NODES + shift) - accelerations(NODES - shift)) / (2 * scale)
            blocks = np.abs(difference - sensitivity[:, case]).reshape(4, 3).max(axis=1)
            errors.append(blocks / np.abs(sensitivity[:, case]).reshape(4, 3).max(axis=1))
        np.testing.assert_allclose(np.log2(errors[0] / errors[1]), 2.0, atol=0.05)
        assert (errors[1] < 1e-2).all()


def test_common_translation_gives_minus_the_gradients():
    """All sources moved alike are the test masses moved the other way."""
    operator = lumped_operator(NODES, MASSES, TEST_MASSES)
    for index, tm in enumerate(TEST_MASSES):
        gravity = self_gravity(NODES, MASSES, tm)
        translations = np.broadcast_to(np.eye(3)[:, None, :], (3, 80, 3))
        change = contract(operator, translations)
        rows = slice(3 * index, 3 * index + 3)
        np.testing.assert_allclose(
            change[:6][rows], -gravity.gamma_lin @ tm.axes, rtol=0, atol=1e-13 * np.abs(gravity.gamma_lin).max()
        )
        np.testing.assert_allclose(
            change[6:][rows], -gravity.omega_lin @ tm.axes, rtol=0, atol=1e-13 * np.abs(gravity.omega_lin).max()
        )


def test_rows_follow_a_rigid_rotation_of_everything():
    turn = Rotation.from_rotvec([1.0, 0.4, -2.0]).as_matrix()
    turned = [
        TestMass(
            name=tm.name,
            position_m=turn @ tm.position_m,
            side_m=tm.side_m,
            mass_kg=tm.mass_kg,
            axes=tm.axes @ turn.T,
        )
        for tm in TEST_MASSES
    ]
    before = contract(lumped_operator(NODES, MASSES, TEST_MASSES), DISPLACEMENTS)
    after = contract(lumped_operator(NODES @ turn.T, MASSES, turned), DISPLACEMENTS @ turn.T)
    scale = np.abs(before).reshape(4, 3, 3).max(axis=1).repeat(3, axis=0)
    assert (np.abs(after - before) < 1e-12 * scale).all()


def test_blocks_of_nodes_add_up():
    operator = lumped_operator(NODES, MASSES, TEST_MASSES)
    blocks = [
        contract(lumped_operator(NODES[part], MASSES[part], TEST_MASSES), DISPLACEMENTS[:, part])
        for part in (slice(0, 33), slice(33, 80))
    ]
    whole = contract(operator, DISPLACEMENTS)
    np.testing.assert_allclose(sum(blocks), whole, rtol=0, atol=1e-14 * np.abs(whole).max())


def test_massless_nodes_inside_a_test_mass_give_zeros():
    nodes = np.concatenate([NODES, [TEST_MASSES[0].position_m, TEST_MASSES[1].position_m]])
    operator = lumped_operator(nodes, np.append(MASSES, [0.0, 0.0]), TEST_MASSES)
    assert operator.shape == (12, 82, 3)
    assert (operator[:, 80:] == 0).all()
    np.testing.assert_array_equal(operator[:, :80], lumped_operator(NODES, MASSES, TEST_MASSES))


def test_node_inside_a_test_mass_is_named():
    masses = np.append(MASSES, 0.5)
    nodes = np.concatenate([NODES, TEST_MASSES[1].position_m[None] + 0.01])
    with pytest.raises(PhysicsError, match="'TM2': node 180 "):
        lumped_operator(nodes, masses, TEST_MASSES, node_ids=np.arange(100, 181))


def test_labels_and_units_of_the_rows():
    assert sensitivity_row_labels(TEST_MASSES) == [
        *("TM1_a_x", "TM1_a_y", "TM1_a_z", "TM2_a_x", "TM2_a_y", "TM2_a_z"),
        *("TM1_omegadot_x", "TM1_omegadot_y", "TM1_omegadot_z"),
        *("TM2_omegadot_x", "TM2_omegadot_y", "TM2_omegadot_z"),
    ]
    assert sensitivity_row_units(TEST_MASSES) == ["m/s^2/K"] * 6 + ["rad/s^2/K"] * 6
    assert len(sensitivity_row_labels(TEST_MASSES[:1])) == lumped_operator(NODES, MASSES, TEST_MASSES[:1]).shape[0]


def test_shapes_that_do_not_match_are_refused():
    with pytest.raises(ValueError, match="does not match"):
        contract(np.zeros((12, 5, 3)), np.zeros((2, 4, 3)))


def test_single_precision_is_summed_in_double():
    rng = np.random.default_rng(2)
    operator, move = rng.normal(size=(12, 1300, 3)), rng.normal(size=(5, 1300, 3)).astype(np.float32)
    found = contract(operator, move)
    np.testing.assert_array_equal(found, contract(operator, move.astype(np.float64)))
    wanted = -np.einsum("rnc,knc->rk", operator, move.astype(np.longdouble))
    np.testing.assert_allclose(found, wanted.astype(np.float64), rtol=0, atol=1e-12)
