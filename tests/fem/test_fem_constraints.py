"""Rigid and interpolation elements: rigidity, invariance, equilibrium, chains, and a foreign solver's results."""

from __future__ import annotations

import numpy as np
import pytest
from fem_models import structure
from hypothesis import given, settings
from hypothesis import strategies as st

from tedm_cli.errors import InputError
from tedm_cli.fem.constraints import eliminate, rbe3_coefficients, rigid_body_matrix
from tedm_cli.fem.structure import Rbe2, Rbe3


def rbe3(eid, dependent, independents, *, components="123456", weights=None, entering="123"):
    count = len(independents)
    return Rbe3(
        element_id=eid,
        dependent=dependent,
        components=components,
        independents=np.array(independents),
        weights=np.ones(count) if weights is None else np.asarray(weights, float),
        independent_components=(entering,) * count,
    )


def rbe2(eid, independent, dependents, components="123456"):
    return Rbe2(element_id=eid, independent=independent, dependents=np.array(dependents), components=components)


def spread(seed, count=7):
    return np.random.default_rng(seed).uniform(-0.5, 0.5, (count, 3)) + np.array([3.0, -2.0, 1.0])


@settings(max_examples=40, deadline=None)
@given(
    seed=st.integers(0, 10_000),
    entering=st.sampled_from(["123", "123456", "1234"]),
    size=st.floats(1e-3, 1e3),
)
def test_fem_rbe3_reproduces_rigid_motion_at_any_size_and_weight(seed, entering, size):
    position = size * spread(seed)
    weights = np.random.default_rng(seed).uniform(0.1, 10.0, 6)
    sources, coefficients = rbe3_coefficients(position, rbe3(1, 0, range(1, 7), weights=weights, entering=entering))
    motion = rigid_body_matrix(position - position[0]).reshape(-1, 6)[sources]
    np.testing.assert_allclose(
        coefficients @ motion / np.array([1, 1, 1, size, size, size]),
        np.eye(6) / np.array([1, 1, 1, size, size, size]),
        atol=1e-11 * max(1.0, 1.0 / size),
    )


def test_fem_rbe3_weighs_rotations_with_the_square_of_the_mean_arm():
    """The motion that minimises sum w (|u - t - θ x r|² + L² |φ - θ|²), L the mean arm, for motions that are not rigid.

    As the MSC Nastran Linear Static Analysis User's Guide has it; arms of different lengths tell the mean from others.
    """
    random = np.random.default_rng(5)
    position = np.array([[0, 0, 0], [1, 0, 0], [0, 2, 0], [0, 0, 0.5], [-3, 1, 1]], float)
    weights = np.array([1.0, 2.0, 0.5, 1.5])
    sources, coefficients = rbe3_coefficients(position, rbe3(1, 0, range(1, 5), weights=weights, entering="123456"))
    motion = random.normal(size=(5, 6))
    arm = position[1:]
    square = np.linalg.norm(arm, axis=1).mean() ** 2
    normal, right = np.zeros((6, 6)), np.zeros(6)
    for r, w, u in zip(arm, weights, motion[1:], strict=True):
        turning = np.column_stack([np.cross(axis, r) for axis in np.eye(3)])
        rows = np.block([[np.eye(3), turning], [np.zeros((3, 3)), np.eye(3)]])
        law = w * np.diag([1.0, 1.0, 1.0, square, square, square])
        normal, right = normal + rows.T @ law @ rows, right + rows.T @ law @ u
    np.testing.assert_allclose(coefficients @ motion.reshape(-1)[sources], np.linalg.solve(normal, right), rtol=1e-10)


@pytest.mark.parametrize("entering", ["123", "123456"])
def test_fem_rbe3_forces_balance_and_go_with_the_weights(entering):
    # The transpose spreads a load on the dependent grid: same resultant, and with equal arms by weight.
    angle = np.arange(4) * np.pi / 2
    position = np.vstack([np.zeros(3), np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)])
    element = rbe3(1, 0, range(1, 5), weights=[1.0, 2.0, 1.0, 2.0], entering=entering)
    sources, coefficients = rbe3_coefficients(position, element)
    load = np.array([1.0, -2.0, 3.0, 0.4, 0.5, -0.6])
    spread_out = coefficients.T @ load
    resultant = rigid_body_matrix(position).reshape(-1, 6)[sources].T @ spread_out
    np.testing.assert_allclose(resultant, load, atol=1e-14)
    pull = coefficients.T @ np.array([0.0, 0.0, 6.0, 0.0, 0.0, 0.0])
    np.testing.assert_allclose(pull[sources % 6 == 2], [1.0, 2.0, 1.0, 2.0], atol=1e-14)


def test_fem_rbe2_moves_as_a_rigid_body_and_leaves_other_components_free():
    position = spread(1, 4)
    transform = eliminate(structure(position, rbe2=(rbe2(1, 0, [1, 2], "123"), rbe2(2, 0, [3])))).transform
    free = np.random.default_rng(0).standard_normal(24)
    motion = (transform @ free).reshape(4, 6)
    hub = motion[0]
    arm = position - position[0]
    np.testing.assert_allclose(motion[1:, :3], hub[:3] + np.cross(hub[3:], arm[1:]), atol=1e-14)
    np.testing.assert_array_equal(motion[3, 3:], hub[3:])
    np.testing.assert_array_equal(motion[1:3, 3:], free.reshape(4, 6)[1:3, 3:])


def test_fem_chains_do_not_depend_on_the_order_of_the_elements():
    # 0 <- RBE3 of 1..4; 5 <- RBE2 of 0; 6 <- RBE3 of 5, 7, 8 and 1.
    position = spread(5, 9)
    three, two, last = rbe3(1, 0, [1, 2, 3, 4]), rbe2(2, 0, [5]), rbe3(3, 6, [5, 7, 8, 1])
    maps = [
        eliminate(structure(position, rbe2=(two,), rbe3=order)).transform.toarray()
        for order in ((three, last), (last, three))
    ]
    np.testing.assert_allclose(maps[0], maps[1], atol=1e-15)
    dependent = [g * 6 + c for g in (0, 5, 6) for c in range(6)]
    assert np.abs(maps[0][:, dependent]).max() == 0.0
    everywhere = rigid_body_matrix(position).reshape(-1, 6)
    np.testing.assert_allclose(maps[0] @ everywhere, everywhere, atol=1e-12)


@pytest.mark.parametrize(
    ("parts", "held", "fact"),
    [
        (
            {"rbe2": (rbe2(8, 0, [1, 2]), rbe2(9, 3, [2], "3"))},
            [],
            "grid 3 component 3 depends on both RBE2 8 and RBE2 9",
        ),
        ({"rbe2": (rbe2(8, 0, [1]), rbe2(9, 1, [2]), rbe2(10, 2, [0], "4"))}, [], "in a loop: .*RBE2"),
        ({"rbe3": (rbe3(4, 0, [0, 1, 2, 3]),)}, [], "loop: RBE3 4 -> RBE3 4"),
        ({"rbe2": (rbe2(8, 0, [1, 2]),)}, [(2, "13")], "grid 3 component 1 of RBE2 8"),
        ({"rbe2": (rbe2(8, 0, [1, 1], "1"),)}, [], "grid 2 component 1 is listed twice"),
        ({"rbe3": (rbe3(4, 0, [1, 2]),)}, [], "RBE3 4 determines only 5 of the 6"),
    ],
)
def test_fem_contradictory_rigid_elements_are_refused_by_id(parts, held, fact):
    with pytest.raises(InputError, match=fact):
        eliminate(structure(spread(2, 5), held=held, **parts))


def test_fem_optical_nodes_agree_with_mystran(mini_ltp_dir):
    from pyNastran.bdf.bdf import BDF
    from pyNastran.op2.op2 import read_op2

    model = BDF(debug=None)
    model.read_bdf(str(mini_ltp_dir / "mini_ltp.bdf"), xref=False)
    grids = np.array(sorted(model.nodes))
    position = np.array([model.nodes[g].xyz for g in grids])
    displacements = read_op2(
        str(mini_ltp_dir / "mini_ltp.op2"), include_results="displacements", debug=None
    ).displacements
    motion = np.stack([table.data[0] for table in displacements.values()], axis=2).astype(float)
    np.testing.assert_array_equal(next(iter(displacements.values())).node_gridtype[:, 0], grids)
    checked = []
    for eid, card in model.rigid_elements.items():
        if card.type == "RBE3":
            rows = np.searchsorted(grids, card.Gijs[0])
            target = int(np.searchsorted(grids, card.refgrid))
            sources, coefficients = rbe3_coefficients(position, rbe3(eid, target, rows))
            expected, got = motion[target], coefficients @ motion.reshape(-1, motion.shape[2])[sources]
            checked.append(int(card.refgrid))
            # Rotations are differences of displacements over the pad: they amplify the rounding.
            arm = np.linalg.norm(position[rows] - position[target], axis=1).mean()
        else:
            rows = np.searchsorted(grids, card.Gmi)
            hub = int(np.searchsorted(grids, card.gn))
            reach = rigid_body_matrix(position[rows] - position[hub])[:, [int(d) - 1 for d in card.cm]]
            expected = motion[rows][:, [int(d) - 1 for d in card.cm]]
            got, arm = np.einsum("mcd,dk->mck", reach, motion[hub]), 1.0
        scale = np.abs(motion[:, :3]).max()
        assert np.abs(got - expected)[..., :3, :].max() < 1e-7 * scale
        if card.type == "RBE3":
            assert np.abs(got - expected)[3:].max() < 1e-7 * scale / arm
    assert checked == [90001, 90002, 90004]
