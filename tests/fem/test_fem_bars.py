"""Bars: textbook bars and frames under thermal load, rotated sections and frames."""

from __future__ import annotations

import numpy as np
import pytest
from fem_models import ALPHA, NU, YOUNG, bars, rotated, rotation_matrix, solve, structure

from tedm_cli.errors import PhysicsError
from tedm_cli.fem.assembly import assemble
from tedm_cli.fem.bars import bar_matrices

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
