"""The published figures of numerical error, value by value, and their orders of convergence."""

import mpmath as mp
import numpy as np
import pytest
from gravity_reference import exact_field
from scipy.spatial.transform import Rotation

from tedm_cli.gravity.accuracy import bode_error, collapse_error, linearisation_error, nodal_mesh, simpson_error
from tedm_cli.gravity.compensation import CompensationMass, field_of_compensation_masses
from tedm_cli.gravity.field import self_gravity
from tedm_cli.gravity.kernel import cuboid_field
from tedm_cli.gravity.published_quadrature import bode_force_x, simpson_gamma_xy
from tedm_cli.gravity.testmass import TestMass

CUBE = np.full(3, 0.046)


def at(x):
    return np.array([float(x)])


@pytest.mark.parametrize(("panels", "percent", "digit"), [(5, 6e-3, 1e-3), (10, 1.5e-4, 1e-5), (25, 3.2e-8, 1e-9)])
def test_published_errors_of_bode(panels, percent, digit):
    """Figure 7.2 at X = Y = Z = 25 mm, to half a printed digit."""
    assert abs(100.0 * bode_error(at(0.025), [panels], CUBE)[0, 0] - percent) < 0.5 * digit


@pytest.mark.parametrize(("divisions", "percent", "digit"), [(20, 5.2e-2, 1e-3), (40, 7.3e-3, 1e-4)])
def test_published_errors_of_simpson(divisions, percent, digit):
    """Figure 7.8 at X = Y = Z = 25 mm, to half a printed digit."""
    assert abs(100.0 * simpson_error(at(0.025), [divisions], CUBE)[0, 0] - percent) < 0.5 * digit


def test_quadratures_converge_at_their_order_on_any_cuboid():
    points = np.array([[0.05, 0.03, -0.02], [-0.04, 0.06, 0.01]])
    sides = np.array([0.04, 0.05, 0.06])
    exact = cuboid_field(points, sides)
    bode = [np.abs(bode_force_x(points, sides, n) / exact.force[:, 0] - 1.0) for n in (4, 8)]
    simpson = [np.abs(simpson_gamma_xy(points, sides, n) / exact.gamma_lin[:, 0, 1] - 1.0) for n in (32, 64)]
    assert (bode[0] / bode[1] > 0.8 * 2**6).all()
    np.testing.assert_allclose(simpson[0] / simpson[1], 2**4, rtol=0.05)
    with pytest.raises(ValueError, match="even number of divisions, got 5"):
        simpson_gamma_xy(points, sides, 5)


@pytest.mark.parametrize(
    ("shape", "power", "force", "gradient"),
    [
        # hexadecapole of a cube: V4 = -(7/480) d^4/r^5 on its axis
        ("centre", 4, 5 * 7 / 480, 15 * 7 / 480),
        # eight lumps at the corners have 14 times the difference: h⁴ per edge in place of h⁴/5 and h⁴/9
        ("corners", 4, 14 * 5 * 7 / 480, 14 * 15 * 7 / 480),
        # the quadrupole of the slab: (1 - 0.1²)/12 of d²
        ("slab", 2, 3 * 0.99 / 12, 6 * 0.99 / 12),
    ],
)
def test_collapse_far_away(shape, power, force, gradient):
    """7.29 (d/r)⁴ % for F and 21.9 (d/r)⁴ % for Γ, eight corner lumps 14 times that, a slab (d/r)²."""
    d = 0.2 if power == 4 else 0.02
    r = 6.0
    found = collapse_error(at(r), at(d), CUBE, shape)
    for value, wanted in zip(found, (force, gradient), strict=True):
        assert value[0, 0] / (d / r) ** power == pytest.approx(wanted, rel=5e-3)


def test_collapse_of_a_cube_at_the_guideline():
    """d = r/10 keeps a cube to 1e-3 %, corner lumps to 1.2e-2 %; a slab is out by a quarter of a percent."""
    force = {s: 100.0 * collapse_error(at(0.1), at(0.01), CUBE, s)[0][0, 0] for s in ("centre", "corners", "slab")}
    assert force["centre"] < 1e-3
    assert force["corners"] == pytest.approx(14.0 * force["centre"], rel=0.02)
    assert 0.2 < force["slab"] < 0.3


def test_collapse_against_another_quadrature():
    """The mean field over the source by the graded quadrature of a compensation mass, close to the test mass."""
    r, d = 0.05, 0.02
    tm = TestMass(name="TM1", position_m=np.zeros(3), side_m=CUBE, mass_kg=1.96)
    source = CompensationMass(name="S", centre_m=np.array([r, 0, 0]), size_m=np.full(3, d), mass_kg=1.0)
    exact, _, _ = field_of_compensation_masses(tm, [source], tolerance=1e-10)
    point = self_gravity([[r, 0.0, 0.0]], [1.0], tm)
    force, gradient = collapse_error(at(r), at(d), CUBE, "centre")
    assert force[0, 0] == pytest.approx(abs(point.acceleration[0] / exact.acceleration[0] - 1.0), rel=1e-6)
    assert gradient[0, 0] == pytest.approx(abs(point.gamma_lin[0, 0] / exact.gamma_lin[0, 0] - 1.0), rel=1e-6)


def test_sources_that_would_reach_the_test_mass_are_left_out():
    force, _ = collapse_error(np.array([0.03, 0.05]), np.array([0.01, 0.02]), CUBE, "centre")
    np.testing.assert_array_equal(np.isnan(force), [[False, False], [True, False]])


def test_linearisation():
    """1.5 dx/x for a point, about 2e-4 % at dx = 9e-8 m near the cube (figure 8.1)."""
    assert linearisation_error(at(5.0), at(9e-8), CUBE)[0, 0] == pytest.approx(1.5 * 9e-8 / 5.0, rel=1e-3)
    near = 100.0 * linearisation_error(np.linspace(0.0231, 0.06, 20), at(9e-8), CUBE)
    assert near.min() > 1.75e-4
    assert near.max() < 2.5e-4


@pytest.mark.parametrize(("x", "dx"), [(0.025, 1e-8), (0.04, 9e-8), (0.15, 1e-9)])
def test_linearisation_keeps_its_digits(x, dx):
    """Against accelerations at 60 digits: their difference keeps some 8 digits in double precision, this more."""
    with mp.workdps(60):
        # Γxx over dx by Simpson at high precision: exact_field returns doubles, whose difference would not do
        gamma = [mp.mpf(exact_gamma(mp.mpf(x) + mp.mpf(dx) * n / 4)) for n in range(5)]
        mean = (7 * gamma[0] + 32 * gamma[1] + 12 * gamma[2] + 32 * gamma[3] + 7 * gamma[4]) / 90
        wanted = float(abs(1 - gamma[0] / mean))
    assert linearisation_error(at(x), at(dx), CUBE)[0, 0] == pytest.approx(wanted, rel=1e-6)
    assert float(gamma[0]) == pytest.approx(exact_field((x, 0.0, 0.0), CUBE)["gamma_lin"][0, 0], rel=1e-12)


def exact_gamma(x):
    """Γxx of the cube on its x axis: the two faces' solid angles over the volume."""
    half, side = mp.mpf("0.023"), mp.mpf("0.046")

    def angle(distance):
        return 4 * mp.atan(half * half / (distance * mp.sqrt(2 * half * half + distance * distance)))

    return (angle(x - half) - angle(x + half)) / side**3


def test_nodal_mesh_is_the_block_but_for_its_second_moments():
    block = CompensationMass(
        name="CM",
        centre_m=np.array([0.1, -0.05, 0.02]),
        size_m=np.array([0.01, 0.02, 0.03]),
        mass_kg=0.7,
        axes=Rotation.from_rotvec([0.3, -0.2, 0.5]).as_matrix(),
    )
    points, masses = nodal_mesh(block, 0.01)
    assert len(masses) == 2 * 3 * 4
    assert masses.sum() == pytest.approx(0.7, rel=1e-14)
    np.testing.assert_allclose(masses @ points / 0.7, block.centre_m, atol=1e-16)
    local = (points - block.centre_m) @ block.axes.T
    moments = np.einsum("n,ni,ni->i", masses, local, local) / 0.7
    # nodal lumping of n elements along an edge is too long by 2/n²
    np.testing.assert_allclose(moments, block.size_m**2 / 12.0 * (1.0 + 2.0 / np.array([1, 2, 3]) ** 2), rtol=1e-13)


def test_nodal_mesh_converges_by_the_quadrupole_of_its_elements():
    """Equal cubes have none: order four. Flat elements of edge h and thickness t have one that goes with h² - t²."""
    tm = TestMass(name="TM1", position_m=np.zeros(3), side_m=CUBE, mass_kg=1.96)
    plate = CompensationMass(
        name="CM", centre_m=np.array([0.05, 0.0, 0.0]), size_m=np.array([0.003, 0.03, 0.03]), mass_kg=0.7
    )
    exact, _, _ = field_of_compensation_masses(tm, [plate])
    errors = []
    for edge in (0.003, 0.0015):
        points, masses = nodal_mesh(plate, edge)
        errors.append(abs(self_gravity(points, masses, tm).acceleration[0] / exact.acceleration[0] - 1.0))
    assert errors[0] / errors[1] == pytest.approx(16.0, rel=0.2)
    flat = []
    for edge in (0.01, 0.005):
        points, masses = nodal_mesh(plate, edge)
        flat.append(self_gravity(points, masses, tm).acceleration[0] / exact.acceleration[0] - 1.0)
    assert flat[0] / flat[1] == pytest.approx((10**2 - 3**2) / (5**2 - 3**2), rel=0.02)
