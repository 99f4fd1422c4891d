"""Bars under gradients of temperature across them: against theory and solids."""

from __future__ import annotations

import numpy as np
import pytest
from fem_models import ALPHA, YOUNG, bars, nearest, solid_mesh, solids, solve, structure
from own_temperatures import GRADIENT, motions, own

from tedm_cli.fem.element_loads import element_loads

AXIS, UP = np.array([1.0, 0.0, 0.0]), (0.0, 1.0, 0.0)


def across(plane, at_a, at_b=None):
    out = np.zeros((1, 2, 2))
    out[0, :, plane - 1] = at_a, at_a if at_b is None else at_b
    return out


def tip(gradient, *, length=0.5, held=((0, "123456"),), ends=((0, 1),), **section):
    """Motions [6] of the end of a bar along x whose y is the basic y."""
    position = np.array([[0.0, 0.0, 0.0], [length, 0.0, 0.0]])
    model = structure(position, bars=bars(ends, UP, **section), held=held)
    (motion,), _ = motions(model, own(model.bars.element_id, gradient=gradient))
    return motion[1]


@pytest.mark.parametrize("section", [{}, {"shear": 0.5}, {"pins": (3,)}])
@pytest.mark.parametrize(("plane", "deflection", "rotation", "sign"), [(1, 1, 5, -1.0), (2, 2, 4, 1.0)])
def test_fem_cantilever_bends_away_from_its_warm_side(section, plane, deflection, rotation, sign):
    """By alpha T' L²/2 at constant, alpha (T'a/3 + T'b/6) L² at linear gradients, whether shear deforms it or not."""
    length = 0.5
    for at_a, at_b in ((GRADIENT, GRADIENT), (GRADIENT, 0.0), (-50.0, 120.0)):
        motion = tip(across(plane, at_a, at_b), length=length, **section)
        wanted = np.zeros(6)
        wanted[deflection] = -ALPHA * length**2 * (at_a / 3 + at_b / 6)
        wanted[rotation] = sign * ALPHA * length * (at_a + at_b) / 2
        np.testing.assert_allclose(motion, wanted, atol=1e-12)


def test_fem_many_bars_under_a_gradient_are_one():
    """Exact at any number of elements: the forces inside cancel."""
    x = np.linspace(0.0, 0.5, 5)
    position = np.stack([x, 0 * x, 0 * x], axis=1)
    model = structure(position, bars=bars([(k, k + 1) for k in range(4)], UP), held=[(0, "123456")])
    slope = lambda at: 100.0 + 300.0 * at  # noqa: E731
    gradient = np.zeros((4, 2, 2))
    gradient[:, 0, 1], gradient[:, 1, 1] = slope(x[:-1]), slope(x[1:])
    (motion,), _ = motions(model, own(model.bars.element_id, gradient=gradient))
    np.testing.assert_allclose(motion[-1], tip(across(2, slope(0.0), slope(0.5))), atol=1e-12)


def test_fem_gradients_of_a_turned_section_are_moments_over_its_own_inertia():
    """T'1 is the moment of the temperature over I1: with I12, a field g1 y + g2 z has T'1 = g1 + g2 I12 / I1."""
    angle, i1, i2 = 0.5, 3e-9, 8e-9
    c, s = np.cos(angle), np.sin(angle)
    own_y, own_z = 150.0, -70.0  # along the principal axes
    motion = tip(np.array([[[own_y, own_z]] * 2]), i1=i1, i2=i2)
    # the same bar with axes turned by -angle about x: y' = c y - s z, z' = s y + c z
    turned = bars([(0, 1)], (0.0, c, -s), i1=c**2 * i1 + s**2 * i2, i2=s**2 * i1 + c**2 * i2, i12=c * s * (i1 - i2))
    a, b, i12 = turned.inertia_1[0], turned.inertia_2[0], turned.inertia_12[0]
    g = c * own_y - s * own_z, s * own_y + c * own_z
    effective = [g[0] + g[1] * i12 / a, g[1] + g[0] * i12 / b]
    model = structure(np.array([[0.0, 0, 0], [0.5, 0, 0]]), bars=turned, held=[(0, "123456")])
    (found,), _ = motions(model, own(turned.element_id, gradient=np.array([[effective] * 2])))
    np.testing.assert_allclose(found[1], motion, atol=1e-12)
    (missed,), _ = motions(model, own(turned.element_id, gradient=np.array([[g] * 2])))
    assert np.abs(missed[1] - motion).max() > 0.1 * np.abs(motion).max()


@pytest.mark.parametrize(
    ("pins", "wanted"),
    [
        ((), {5: 1.0, 11: -1.0}),
        ((11,), {5: 1.5, 1: 1.5, 7: -1.5}),  # a propped cantilever
        ((5, 11), {}),
        ((1, 5), {}),
    ],
)
def test_fem_a_bar_under_a_gradient_pushes_with_what_its_ends_hold(pins, wanted):
    """Nodal forces over E I alpha T' (and over the length, where they are forces), by the textbook."""
    block = bars([(0, 1)], UP, i1=3e-9, pins=pins)
    model = structure(np.array([[0.0, 0, 0], [0.3, 0, 0]]), bars=block)
    loads = element_loads(model)
    force = loads.forces(loads.own(np.zeros(2), own(block.element_id, gradient=across(1, GRADIENT)))[:, None])[:, 0]
    force[[1, 7]] *= 0.3
    expected = np.zeros(12)
    expected[list(wanted)] = list(wanted.values())
    np.testing.assert_allclose(force / (YOUNG * 3e-9 * ALPHA * GRADIENT), expected, atol=1e-12)


def test_fem_an_offset_bar_bends_its_own_line():
    """The grids ride on rigid arms: the tip's arm turns with the tip."""
    arm = np.array([0.0, 0.02, -0.01])
    motion = tip(across(1, GRADIENT), offset=np.array([[arm, arm]]))
    plain = tip(across(1, GRADIENT))
    np.testing.assert_allclose(motion[3:], plain[3:], atol=1e-12)
    np.testing.assert_allclose(motion[:3], plain[:3] - np.cross(plain[3:], arm), atol=1e-12)


def test_fem_a_propped_bar_bends_as_a_solid_beam_of_its_section():
    """A field g1 y + g2 z on CHEXA20: deflections of the axis within the shear near the ends."""
    length, b, h = 0.4, 0.02, 0.03
    position, connectivity = solid_mesh("CHEXA", 20, (16, 2, 2), (length, b, h))
    centred = position - [0.0, b / 2, h / 2]
    foot = np.flatnonzero(position[:, 0] < 1e-9)
    axis = lambda x: nearest(centred, (x, 0.0, 0.0))  # noqa: E731
    held = [*((k, "1") for k in foot), (axis(0.0), "23"), (nearest(centred, (0, b / 2, 0)), "3"), (axis(length), "3")]
    g = np.array([120.0, 200.0])
    model = structure(position, solids=(solids("CHEXA", connectivity),), held=held)
    (solid,), _ = solve(model, centred[:, 1:] @ g)
    x = np.linspace(0.0, length, 9)
    line = np.stack([x, 0 * x, 0 * x], axis=1)
    block = bars([(k, k + 1) for k in range(8)], UP, i1=h * b**3 / 12, i2=b * h**3 / 12, area=b * h, shear=5 / 6)
    model = structure(line, bars=block, held=[(0, "123456"), (8, "3")])
    (bar,), _ = motions(model, own(block.element_id, gradient=np.tile(g, (8, 2, 1))))
    at = [axis(each) for each in x]
    for component in (1, 2):
        wanted = solid[at, component]
        assert np.abs(wanted).max() > 1e-6
        np.testing.assert_allclose(bar[:, component], wanted, atol=4e-3 * np.abs(wanted).max(), rtol=0)
