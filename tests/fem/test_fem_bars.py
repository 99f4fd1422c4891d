"""Bars: textbook bars and frames under thermal load, rotated sections and frames."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from fem_models import ALPHA, NU, YOUNG, bars, rotated, rotation_matrix, solve, structure

from tedm_cli.errors import PhysicsError
from tedm_cli.fem.assembly import assemble
from tedm_cli.fem.bars import bar_matrices
from tedm_cli.fem.constraints import rigid_body_matrix
from tedm_cli.fem.rods import rod_matrices
from tedm_cli.fem.structure import BarBlock, RodBlock

SHEAR = YOUNG / (2 * (1 + NU))


def chain(n, length, direction=(1.0, 0.0, 0.0), orientation=(0.0, 1.0, 0.0), **section):
    position = np.linspace(0.0, length, n + 1)[:, None] * np.asarray(direction)
    ends = np.stack([np.arange(n), np.arange(1, n + 1)], axis=1)
    return position, bars(ends, orientation, **section)


def test_fem_bar_between_walls_stays_and_pushes_with_the_full_thermal_force():
    position, block = chain(4, 0.8)
    model = structure(position, bars=block, held=[(0, "123456"), (4, "123456")])
    (uniform, half, single), _ = solve(model, 2.0, np.where(np.arange(5) <= 2, 2.0, 0.0), [0, 0, 0, 0, 2.0])
    assert np.abs(uniform).max() < 1e-18
    force = assemble(model).thermal.forces(np.full((5, 1), 2.0)).reshape(5, 6)
    assert force[[0, 4], 0] == pytest.approx(YOUNG * 1e-4 * ALPHA * 2.0 * np.array([-1.0, 1.0]), rel=1e-14)
    # Strains alpha T - eps0 with the mean temperature of each bar; the ends do not move apart.
    mean = np.array([2.0, 2.0, 1.0, 0.0])
    expected = ALPHA * 0.2 * np.concatenate([[0.0], np.cumsum(mean - mean.mean())])
    np.testing.assert_allclose(half[:, 0], expected, atol=1e-12 * np.abs(expected).max())
    assert single[3, 0] == pytest.approx(-0.75 * ALPHA * 0.2, rel=1e-12)


def test_fem_fully_held_bar_has_no_unknowns_and_no_motion():
    position, block = chain(1, 0.5)
    model = structure(position, bars=block, held=[(0, "123456"), (1, "123456")])
    (motion,), report = solve(model, 5.0)
    assert report.n_dof == 0
    assert (motion == 0.0).all()


def test_fem_bar_free_at_one_end_grows_without_bending():
    position, block = chain(5, 0.8, direction=(0.6, 0.0, 0.8), orientation=(0.2, 1.0, 0.3), i12=1e-9)
    (motion,), _ = solve(structure(position, bars=block, held=[(0, "123456")]), 4.0)
    np.testing.assert_allclose(motion[:, :3], ALPHA * 4.0 * position, atol=1e-11 * ALPHA)
    assert np.abs(motion[:, 3:]).max() < 1e-10 * ALPHA * 4.0


@pytest.mark.parametrize(("orientation", "inertia"), [((1.0, 1.0, 0.0), 3e-9), ((0.0, 0.0, 1.0), 5e-9)])
def test_fem_heated_clamped_corner_frame(orientation, inertia):
    # Two equal bars, x then y, clamped at their far ends; displacement method with u, v and the rotation of the corner:
    #   (k + c) u - b theta = P_x, (k + c) v - b theta = P_y, -b (u + v) + 8 E I / L theta = 0,
    # k = E A / L, c = 12 E I / L³, b = 6 E I / L²; P_x = E A alpha T_1, P_y = -E A alpha T_2.
    length, area, heat = 0.7, 1e-4, np.array([3.0, 1.0])
    position = np.array([[0, 0, 0], [length, 0, 0], [length, length, 0]])
    model = structure(position, bars=bars([[0, 1], [1, 2]], orientation), held=[(0, "123456"), (2, "123456")])
    # One grid temperature per bar end: the corner's is shared, so the far ends make up the wanted means.
    (motion,), _ = solve(model, [2 * heat[0] - 1.0, 1.0, 2 * heat[1] - 1.0])
    k, c = YOUNG * area / length, 12 * YOUNG * inertia / length**3
    thrust = YOUNG * area * ALPHA * heat
    difference = (thrust[0] + thrust[1]) / (k + c)
    total = (thrust[0] - thrust[1]) / (k + c - 9 * YOUNG * inertia / length**3)
    rotation = 6 * YOUNG * inertia / length**2 * total / (8 * YOUNG * inertia / length)
    np.testing.assert_allclose(
        motion[1, [0, 1, 5]], [(total + difference) / 2, (total - difference) / 2, rotation], rtol=1e-11
    )
    assert np.abs(motion[1, [2, 3, 4]]).max() < 1e-18


def test_fem_bar_tip_flexibility_is_that_of_a_cantilever():
    position, block = chain(1, 0.5)
    tip = np.linalg.inv(bar_matrices(position, block).stiffness[0][6:, 6:])
    length = 0.5
    expected = [
        length / (YOUNG * 1e-4),
        length**3 / (3 * YOUNG * 3e-9),
        length**3 / (3 * YOUNG * 5e-9),
        length / (SHEAR * 6e-9),
        length / (YOUNG * 5e-9),
        length / (YOUNG * 3e-9),
    ]
    np.testing.assert_allclose(np.diag(tip), expected, rtol=1e-12)
    assert tip[1, 5] == pytest.approx(length**2 / (2 * YOUNG * 3e-9), rel=1e-12)
    assert tip[2, 4] == pytest.approx(-(length**2) / (2 * YOUNG * 5e-9), rel=1e-12)


def test_fem_turning_the_section_equals_transforming_its_inertia():
    # Axes turned by phi from the principal ones: I1 = I c² + J s², I2 = I s² + J c², I12 = (I - J) s c.
    angle, major, minor = 0.4, 8e-9, 2e-9
    c, s = np.cos(angle), np.sin(angle)
    position, turned = chain(1, 0.5, orientation=(0.0, c, s), i1=major, i2=minor)
    _, transformed = chain(
        1, 0.5, i1=major * c**2 + minor * s**2, i2=major * s**2 + minor * c**2, i12=(major - minor) * s * c
    )
    one, other = (bar_matrices(position, block).stiffness[0] for block in (turned, transformed))
    np.testing.assert_allclose(one, other, atol=1e-13 * np.abs(one).max())


def test_fem_frame_turns_with_its_coordinates():
    position = np.array([[0, 0, 0], [0.7, 0.1, 0], [0.8, 0.6, 0.3], [1.2, 0.5, 0.9]])
    block = bars([[0, 1], [1, 2], [2, 3]], (0.1, 0.2, 1.0), i12=1e-9)
    model = structure(position, bars=block, held=[(0, "123456"), (3, "123456")])
    turn = rotation_matrix((1.0, -2.0, 0.5), 1.1)
    heat = [1.0, 0.0, 3.0, -1.0]
    (here,), (there,) = solve(model, heat)[0], solve(rotated(model, turn), heat)[0]
    np.testing.assert_allclose(there[:, :3], here[:, :3] @ turn.T, atol=1e-12 * np.abs(here[:, :3]).max())
    np.testing.assert_allclose(there[:, 3:], here[:, 3:] @ turn.T, atol=1e-12 * np.abs(here[:, 3:]).max())


@pytest.mark.parametrize(
    ("change", "fact"),
    [
        ({"orientation": (2.0, 0.0, 0.0)}, "orientation vector along the bar: 501, 502"),
        ({"length": 0.0}, "no length: 501, 502"),
        ({"i12": 4e-9}, "I12² not below I1 I2: 501, 502"),
    ],
)
def test_fem_impossible_bars_are_refused_by_id(change, fact):
    position, block = chain(2, **{"length": 0.5, **change})
    with pytest.raises(PhysicsError, match=fact):
        bar_matrices(position, block)


def tip_motion(block, position, force):
    """Motion of the last grid under a force on it, the first one clamped."""
    stiffness = assemble(structure(position, bars=block)).stiffness.toarray()[6:, 6:]
    return np.linalg.solve(stiffness, np.concatenate([np.zeros(len(stiffness) - 6), force]))[-6:]


@pytest.mark.parametrize(("plane", "inertia"), [(0, 3e-9), (1, 5e-9)])
def test_fem_shear_adds_its_share_to_a_cantilevers_deflection(plane, inertia):
    length, factor = 0.05, (0.7, 0.4)
    position, block = chain(3, length, shear=factor)
    force = np.zeros(6)
    force[1 + plane] = 1.0
    expected = length**3 / (3 * YOUNG * inertia) + length / (factor[plane] * 1e-4 * SHEAR)
    assert tip_motion(block, position, force)[1 + plane] == pytest.approx(expected, rel=1e-11)


def test_fem_a_bar_on_two_hinges_carries_thrust_alone():
    # Both ends released about y and z and one about x: what is left is the axial spring, and the thermal thrust.
    position, block = chain(1, 0.5, direction=(0.6, 0.0, 0.8), pins=(3, 4, 5, 10, 11))
    found = bar_matrices(position, block)
    axis = np.array([0.6, 0.0, 0.8])
    push = np.concatenate([-axis, np.zeros(3), axis, np.zeros(3)])
    np.testing.assert_allclose(
        found.stiffness[0], YOUNG * 1e-4 / 0.5 * np.outer(push, push), atol=1e-9 * YOUNG * 1e-4 / 0.5
    )
    np.testing.assert_allclose(found.coupling[0].sum(axis=1), YOUNG * 1e-4 * ALPHA * push, atol=1e-9)


def test_fem_a_released_thrust_leaves_no_thermal_force():
    position, block = chain(1, 0.5, pins=(6,))
    found = bar_matrices(position, block)
    assert np.abs(found.coupling).max() == 0.0
    assert np.abs(found.stiffness[0][[0, 6]]).max() == 0.0
    assert found.stiffness[0][7, 7] > 0.0


def test_fem_a_hinge_inside_a_propped_cantilever_is_that_of_statics():
    # Clamped left, hinge in the middle, guided right: 3 E I / a³ of each half in series.
    position, block = chain(2, 0.6)
    released = block.released.copy()
    released[1, [4, 5]] = True
    stiffness = assemble(structure(position, bars=replace(block, released=released))).stiffness.toarray()
    free = [7, 13]  # the deflections of the middle and of the guided end; the slope of the middle follows
    inner = [11]
    condensed = stiffness[np.ix_(free, free)] - stiffness[np.ix_(free, inner)] @ np.linalg.solve(
        stiffness[np.ix_(inner, inner)], stiffness[np.ix_(inner, free)]
    )
    tip = np.linalg.solve(condensed, [0.0, 1.0])
    arm = 0.3**3 / (3 * YOUNG * 3e-9)
    np.testing.assert_allclose(tip, [arm, 2 * arm], rtol=1e-11)


def test_fem_offset_ends_hang_on_rigid_arms():
    # The same bar between grids at its ends and between grids elsewhere, tied by hand.
    position, block = chain(1, 0.5, direction=(0.0, 0.6, 0.8), orientation=(1.0, 0.0, 0.0), shear=(0.8, 0.9))
    arm = np.array([[0.01, 0.02, -0.03], [0.02, 0.02, -0.03]])
    here = bar_matrices(position, block)
    there = bar_matrices(position - arm, replace(block, offset=arm[None]))
    tie = np.zeros((12, 12))
    tie[:6, :6], tie[6:, 6:] = rigid_body_matrix(arm)
    stiffness = tie.T @ here.stiffness[0] @ tie
    np.testing.assert_allclose(there.stiffness[0], stiffness, atol=1e-12 * np.abs(stiffness).max())
    np.testing.assert_allclose(there.coupling[0], tie.T @ here.coupling[0], atol=1e-12)


def test_fem_growing_with_everything_leaves_an_offset_bar_free_of_stress():
    """Grids, rigid arms and bar grow by one: their forces are those of a thermal strain of one."""
    position = np.array([[0.0, 0.0, 0.0], [0.3, 0.1, -0.2]])
    arms = [[0.01, 0.02, -0.03], [-0.02, 0.01, 0.04]]
    operators = assemble(structure(position, bars=bars([[0, 1]], [0.0, 0.0, 1.0], i12=1e-9, offset=arms)))
    grown = np.zeros((2, 6))
    grown[:, :3] = position
    force = operators.stiffness @ grown.reshape(-1)
    np.testing.assert_allclose(force, operators.expansion_load, rtol=0, atol=1e-12 * np.abs(force).max())


def test_fem_offset_bars_below_a_bar_make_a_bimetal():
    # Two equal bars, joined along their length at a distance d: curvature of the common fibre by statics of two bars,
    # k = (a1 - a2) T d / (d² + 2 (I1 + I1) / A ... ) with E A and E I equal: k = (a1 - a2) T d / (d² + 4 I / A).
    distance, heat, second = 0.004, 2.0, 1e-5
    position, upper = chain(6, 0.3, alpha=3e-5, i1=3e-9, offset=[0.0, distance / 2, 0.0])
    _, lower = chain(6, 0.3, alpha=second, i1=3e-9, offset=[0.0, -distance / 2, 0.0])
    both = BarBlock(**{name: np.concatenate([getattr(upper, name), getattr(lower, name)]) for name in vars(upper)})
    (motion,), _ = solve(structure(position, bars=both, held=[(0, "123456")]), heat)
    curvature = np.diff(motion[:, 5]) / 0.05
    expected = -(3e-5 - second) * heat * distance / (distance**2 + 4 * 3e-9 / 1e-4)
    np.testing.assert_allclose(curvature, expected, rtol=1e-8)


def rods(ends, **section):
    block = bars(ends, (0.0, 0.0, 1.0), **section)
    return RodBlock(**{field: getattr(block, field) for field in RodBlock.__dataclass_fields__})


def test_fem_a_rod_is_a_bar_without_bending():
    position, block = chain(2, 0.8, direction=(0.6, 0.64, 0.48), orientation=(0.0, 0.0, 1.0), i1=0.0, i2=0.0)
    here, there = bar_matrices(position, block), rod_matrices(position, rods(block.connectivity))
    for name in ("stiffness", "coupling", "expansion_load"):
        one, other = getattr(here, name), getattr(there, name)
        np.testing.assert_allclose(other, one, atol=1e-12 * np.abs(one).max())


def test_fem_a_warm_rod_in_a_three_bar_truss_lifts_the_joint():
    # Three rods from a ceiling meet below; the vertical one of length L is heated: v = a T L / (1 + 2 cos³ 45°).
    length, heat = 0.4, 5.0
    position = np.array([[0, 0, 0], [-length, 0, length], [0, 0, length], [length, 0, length]], dtype=float)
    held = [(row, "123456") for row in (1, 2, 3)] + [(0, "2")]
    model = structure(position, rods=rods([[0, 1], [0, 2], [0, 3]]), held=held)
    # The joint is at zero: the vertical rod's mean is T, the others' far ends are at zero.
    (motion,), _ = solve(model, [0.0, 0.0, 2 * heat, 0.0])
    assert motion[0, 2] == pytest.approx(-ALPHA * heat * length / (1 + 2 * np.cos(np.pi / 4) ** 3), rel=1e-12)
    assert abs(motion[0, 0]) < 1e-12 * abs(motion[0, 2])


def test_fem_rotations_that_a_rod_resists_along_no_axis_are_not_a_mechanism():
    # A twist stiffness about a slanted axis is one direction of three; the others are left out, as AUTOSPC does.
    position, block = chain(2, 0.8, direction=(0.6, 0.64, 0.48))
    held = [(row, "23") for row in range(3)] + [(0, "1"), (0, "456")]
    turned = replace(structure(position, rods=rods(block.connectivity), held=held))
    (motion,), _ = solve(turned, 1.0)
    assert np.abs(motion[:, 3:]).max() == 0.0
    assert motion[2, 0] > 0.0


def test_fem_rods_without_length_are_refused_by_id():
    with pytest.raises(PhysicsError, match=r"1 rod\(s\) with no length: 501"):
        rod_matrices(np.zeros((2, 3)), rods([[0, 1]]))
