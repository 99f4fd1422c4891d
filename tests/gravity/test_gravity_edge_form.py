"""The closed form of many points at once: its logarithm and angle against 50 digits, the form against the slow way."""

import math

import mpmath as mp
import numpy as np
import pytest
from accuracy_table import CUBE, SHAPES, extension_points, random_points, surface_points
from hypothesis import example, given, settings
from hypothesis import strategies as st

from tedm_cli.gravity.edge_form import angle_around, edge_form, log_of_one_plus

UNITS = 3.0  # in the last place


def units_off(found, exact):
    """Error in units of the last place of the exact value."""
    return float(abs(mp.mpf(found) - exact) / mp.mpf(float(np.spacing(abs(float(exact))))))


exponents = st.floats(-150.0, 150.0).map(lambda exponent: 10.0**exponent)
near_octants = st.tuples(st.integers(0, 16), st.floats(-17.0, -1.0), st.sampled_from([-1.0, 1.0]))
#: Ratios of all sizes, and those next to the powers of √2, where the exponent that is split off changes.
ratios = st.one_of(
    exponents, st.tuples(st.integers(-3, 20), st.floats(0.99, 1.01)).map(lambda t: 2 ** (t[0] / 2) * t[1])
)


@settings(deadline=None, max_examples=300, derandomize=True)
@given(ratios, exponents)
@example(1e300, 1e-100)  # the largest that an edge gives is far below
@example(2.3e-308, 1.0)
@example(1.0, 1.0)
@example(math.sqrt(2.0) - 1.0, 1.0)
@example(1e-16, 3.0)
def test_logarithm_in_all_its_range(ratio, below):
    above = ratio * below
    with mp.workdps(50):
        exact = mp.log1p(mp.mpf(above) / mp.mpf(below))
        assert units_off(log_of_one_plus(above, below), exact) < UNITS


@pytest.mark.parametrize("below", [1e-280, 2.3e-308, 1.0, 1e300])
def test_logarithm_of_one_is_zero(below):
    assert log_of_one_plus(0.0, below) == 0.0


@settings(deadline=None, max_examples=300, derandomize=True)
@given(st.one_of(st.floats(0.0, 6.283), near_octants), exponents)
@example(0.0, 1e-300)
@example(math.pi, 1e300)
def test_angle_all_around(angle, size):
    if isinstance(angle, tuple):
        octant, exponent, sign = angle
        angle = octant * math.pi / 8.0 + sign * 10.0**exponent
    y, x = size * math.sin(angle), size * math.cos(angle)
    with mp.workdps(50):
        exact = mp.atan2(mp.mpf(y), mp.mpf(x))
        exact += 2 * mp.pi if exact < 0 else 0
        assert units_off(angle_around(y, x), exact) < UNITS


@pytest.mark.parametrize(
    ("y", "x", "eighths"),
    [
        *((0.0, 0.0, 0), (-0.0, 0.0, 0), (0.0, 1.0, 0), (-0.0, 1.0, 0), (0.0, -1.0, 4), (-0.0, -1.0, 4)),
        *((1.0, 0.0, 2), (1.0, -0.0, 2), (-1.0, 0.0, 6), (1.0, 1.0, 1), (1.0, -1.0, 3), (-1.0, -1.0, 5)),
        *((-1.0, 1.0, 7), (-1e-300, 1.0, 8), (1e300, 1e-300, 2), (1e-300, -1e300, 4)),
    ],
)
def test_angle_on_the_axes_and_between_them(y, x, eighths):
    assert angle_around(y, x) == eighths * (math.pi / 4.0)


def slow_edge_form(point, low, high):
    """The same form of one point, with the functions of the mathematical library."""
    corner = np.array([low - point, high - point]).T
    radius = np.linalg.norm(np.stack(np.meshgrid(*corner, indexing="ij"), axis=-1), axis=-1)
    log, potential, solid = np.zeros((3, 2, 2)), np.zeros((3, 2)), np.zeros((3, 2))
    for axis in range(3):
        ends = radius.transpose(axis, (axis + 1) % 3, (axis + 2) % 3)
        (first, last), u, v = corner[axis], corner[(axis + 1) % 3], corner[(axis + 2) % 3]
        for j, k in np.ndindex(2, 2):
            near, r = (-last, ends[1, j, k]) if first + last < 0.0 else (first, ends[0, j, k])
            sum_near = r + near if near >= 0.0 else max(u[j] ** 2 + v[k] ** 2, 1e-280) / (r - near)
            length = (last - first) * (1.0 + abs(first + last) / ends[:, j, k].sum())
            log[axis, j, k] = math.log1p(length / max(sum_near, 1e-280))
        for i in range(2):
            product = complex(1.0)
            for j, k in np.ndindex(2, 2):
                product *= complex(abs(corner[axis, i]) * ends[i, j, k], (1 if j == k else -1) * u[j] * v[k])
            angle = math.atan2(product.imag, product.real) % (2.0 * math.pi)
            solid[axis, i] = np.sign(corner[axis, i]) * angle
    for axis in range(3):
        u, v = (axis + 1) % 3, (axis + 2) % 3
        for i in range(2):
            for end, sign in ((1, 1.0), (0, -1.0)):
                potential[axis, i] += sign * (corner[u, end] * log[v, i, end] + corner[v, end] * log[u, end, i])
            potential[axis, i] -= corner[axis, i] * solid[axis, i]
    mixed = log[:, 1, 1] - log[:, 1, 0] - log[:, 0, 1] + log[:, 0, 0]
    force, gamma = potential[:, 1] - potential[:, 0], solid[:, 0] - solid[:, 1]
    return np.array([*force, *gamma, *mixed[::-1]]) / np.prod(high - low)


@pytest.mark.parametrize("shape", ["cube", "brick", "slab"])
def test_the_form_is_that_of_the_mathematical_library(shape):
    """Outside, in the planes of faces, on prolonged edges, within, on faces and on edges, where a part may be taken."""
    sides = SHAPES[shape]
    rng = np.random.default_rng(4)
    low, high = -0.3 * sides, 0.7 * sides
    around = [random_points(sides, 0.6, 6.0, 40, rng), surface_points(sides, 1e-6, rng), extension_points(sides)]
    within = rng.uniform(-0.45, 0.45, (40, 3)) * sides
    on_face, on_edge = within[:10] * [0, 1, 1] + sides * [0.5, 0, 0], within[:10] * [0, 0, 1] + sides * [0.5, 0.5, 0]
    points = np.concatenate([*around, within, on_face, on_edge]) + (low + high) / 2.0
    found = np.empty((len(points), 9))
    edge_form(points, low, high, found)
    wanted = np.array([slow_edge_form(point, low, high) for point in points])
    assert np.isfinite(found).all()
    # both lose digits far away, and the more where the body is thin
    away = np.maximum(np.linalg.norm(points - (low + high) / 2.0, axis=1) / np.linalg.norm(sides), 1.0)
    few = 4e-15 * away**3 * sides.max() / sides.min()
    for part in (slice(0, 3), slice(3, 9)):
        error = np.abs(found - wanted)[:, part].max(axis=1) / np.abs(wanted[:, part]).max(axis=1)
        assert (error < few).all(), (error / few).max()


def test_an_edge_that_is_taken_away_leaves_nothing():
    """On an edge of a cuboid and of a part taken from it, where both logarithms are infinite: the rest is right."""
    low, middle, high = np.zeros(3), np.array([1.0, 0.7, 0.4]), np.array([1.0, 0.7, 1.1])
    points = np.array([[0.0, 0.0, 0.5], [1.0, 0.7, 0.9], [1.0, 0.0, 1.05]])
    whole, upper, lower = (np.empty((len(points), 9)) for _ in range(3))
    edge_form(points, low, high, whole)
    edge_form(points, np.array([0.0, 0.0, 0.4]), high, upper)
    edge_form(points, low, middle, lower)
    np.testing.assert_allclose(whole * 1.1 - upper * 0.7, lower * 0.4, rtol=0, atol=1e-12)


def test_a_point_is_computed_alike_in_any_company():
    """Groups of points are filled up and computed together: to the bit as if each came alone."""
    rng = np.random.default_rng(8)
    points = random_points(CUBE, 0.9, 3.0, 150, rng)
    together, alone = np.empty((len(points), 9)), np.empty((1, 9))
    edge_form(points, -CUBE / 2, CUBE / 2, together)
    for point, field in zip(points, together, strict=True):
        edge_form(point[None], -CUBE / 2, CUBE / 2, alone)
        np.testing.assert_array_equal(alone[0], field)
    for count in (63, 64, 65, 128, 129):
        some = np.empty((count, 9))
        edge_form(points[:count], -CUBE / 2, CUBE / 2, some)
        np.testing.assert_array_equal(some, together[:count])
