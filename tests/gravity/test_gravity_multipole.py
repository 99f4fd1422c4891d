"""Leading multipoles of the cuboid, and the far field as that of a point mass."""

from itertools import pairwise

import mpmath as mp
import numpy as np
import pytest

from tedm_cli.gravity.edge_form import edge_form
from tedm_cli.gravity.kernel import cuboid_field
from tedm_cli.gravity.moments import cuboid_moments, field_weights
from tedm_cli.gravity.multipole import excess_field

RNG = np.random.default_rng(11)
DIRECTIONS = RNG.normal(size=(30, 3))
DIRECTIONS /= np.linalg.norm(DIRECTIONS, axis=1)[:, None]


def gradient(potential, point):
    """-∇ of a potential of three mpmath arguments."""
    with mp.workdps(40):
        return -np.array(
            [float(mp.diff(potential, tuple(map(mp.mpf, point)), n)) for n in ((1, 0, 0), (0, 1, 0), (0, 0, 1))]
        )


def test_leading_term_of_a_brick_is_its_quadrupole():
    """U = 1/r + [C20 (3 z² - r²) + 3 C22 (x² - y²)]/r⁵ + ..."""
    lx, ly, lz = sides = np.array([0.02, 0.046, 0.03])
    c20, c22 = (2 * lz**2 - lx**2 - ly**2) / 48, (lx**2 - ly**2) / 48

    def quadrupole(x, y, z):
        r2 = x * x + y * y + z * z
        return (c20 * (3 * z * z - r2) + 3 * c22 * (x * x - y * y)) / r2 ** mp.mpf(2.5)

    deviations = []
    for distance in (10.0, 20.0):
        errors = []
        for direction in DIRECTIONS[:8]:
            point = distance * direction
            expected = gradient(quadrupole, point)
            field = cuboid_field(point[None], sides)
            errors.append(np.abs(np.cross(point, expected) - field.torque[0]).max() / np.abs(field.torque[0]).max())
        deviations.append(max(errors))
    # what is left is the degree 4, two powers of the distance down
    assert deviations[0] < 1e-4
    assert deviations[0] / deviations[1] == pytest.approx(4.0, rel=1e-3)


def test_leading_term_of_a_cube_is_its_hexadecapole():
    side = 0.046

    def hexadecapole(x, y, z):
        r2 = x * x + y * y + z * z
        fourth = (x**4 + y**4 + z**4) / r2**2
        return -mp.mpf(7) / 960 * mp.mpf(side) ** 4 / r2 ** mp.mpf(2.5) * (5 * fourth - 3)

    deviations = []
    for distance in (5.0, 10.0):
        errors = []
        for direction in DIRECTIONS[:8]:
            point = distance * direction
            expected = gradient(hexadecapole, point)
            field = cuboid_field(point[None], np.full(3, side))
            errors.append(np.abs(np.cross(point, expected) - field.torque[0]).max() / np.abs(field.torque[0]).max())
        deviations.append(max(errors))
    assert deviations[0] < 1e-3
    assert deviations[0] / deviations[1] == pytest.approx(4.0, rel=1e-3)


def test_quadrupole_of_a_cube_is_exactly_zero_and_of_a_near_cube_exact():
    assert (cuboid_moments(0.023, 0.023, 0.023, 8)[2] == 0.0).all()
    # the sides as given are 1 and 1 + 2^-40: their difference must not drown in the normalisation
    long = 1.0 + 2.0**-40
    moments = cuboid_moments(1.0, 1.0, long, 8)
    assert moments[2, 0] == pytest.approx(2 * 2.0**-40 * (1 + long) / 12 / (2 + long**2), rel=1e-14)
    assert moments[2, 2] == 0.0


@pytest.mark.parametrize(("sides", "power"), [((1.0, 1.0, 1.0), 4), ((1.0, 1.0, 0.1), 2), ((0.1, 1.0, 0.2), 2)])
def test_far_field_is_that_of_a_point(sides, power):
    """The relative excess falls as r⁻² for a brick and as r⁻⁴ for a cube."""
    excess = []
    for distance in (50.0, 100.0):
        points = distance * DIRECTIONS
        field = cuboid_field(points, sides)
        # the excess itself drowns in the force in double precision for a cube: taken from the torque
        excess.append(np.abs(field.torque).max() / (distance * np.abs(field.force).max()))
        np.testing.assert_allclose(field.force, DIRECTIONS / distance**2, rtol=0, atol=10.0 / distance**4)
        gamma = (3 * DIRECTIONS[:, :, None] * DIRECTIONS[:, None, :] - np.eye(3)) / distance**3
        np.testing.assert_allclose(field.gamma_lin, gamma, rtol=0, atol=30.0 / distance**5)
    assert np.log2(excess[0] / excess[1]) == pytest.approx(power, abs=5e-3)


def test_expansion_converges_geometrically_to_the_closed_form():
    """Each degree gains one power of the ratio of distance to half diagonal, down to rounding."""
    half_sides = np.array([0.5, 0.2, 0.35])
    ratio = 2.5
    scale = float(np.linalg.norm(half_sides))
    points = ratio * scale * DIRECTIONS
    distance, unit = ratio * scale, DIRECTIONS.T
    closed, field = np.empty((len(points), 9)), np.empty((len(points), 9))
    edge_form(points, -half_sides, half_sides, closed)
    pairs = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))
    point = np.array([*(unit / distance**2), *((3 * unit[i] * unit[j] - (i == j)) / distance**3 for i, j in pairs)]).T
    errors = []
    for order in (8, 16, 24, 32):
        excess_field(points, scale, field_weights(*half_sides, order), field)
        deviation = np.abs(field + point - closed)
        errors.append([deviation[:, part].max() / np.abs(closed[:, part]).max() for part in (slice(3), slice(3, 9))])
    for coarse, fine in pairwise(np.array(errors[:-1])):
        assert (coarse / fine > ratio**7).all()
    assert max(errors[-1]) < 1e-13


def test_moments_up_to_degree_four_against_monomial_integrals():
    """⟨x²⟩ = a²/3, ⟨x⁴⟩ = a⁴/5, ⟨x²y²⟩ = a²b²/9 in R₄⁰ = (8z⁴ - 24 z²ρ² + 3ρ⁴)/192 and R₄⁴ = Re (x + iy)⁴/384."""
    half = np.array([0.5, 0.2, 0.35])
    a, b, c = (half / np.linalg.norm(half)) ** 2
    moments = cuboid_moments(*half, 6)
    rho4 = a**2 / 5 + 2 * a * b / 9 + b**2 / 5
    assert moments[4, 0] == pytest.approx((8 * c**2 / 5 - 24 * c * (a + b) / 9 + 3 * rho4) / 192, rel=1e-13)
    assert moments[4, 4] == pytest.approx((a**2 / 5 - 6 * a * b / 9 + b**2 / 5) / 384, rel=1e-13)
    assert (moments[1::2] == 0).all()
    assert (moments[:, 1::2] == 0).all()
