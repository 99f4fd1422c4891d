"""Exactness and identities of the field of a cuboid."""

import subprocess
import sys

import numpy as np
import pytest
from accuracy_table import BANDS, COLUMNS, CUBE, SHAPES, errors_by_band, random_points
from gravity_reference import (
    AXIS_PERMUTATION,
    QUANTITIES,
    cross_matrix,
    exact_field,
    exact_fields,
    face_quadrature,
)
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.constants import gravitational_constant

from tedm_cli.errors import PhysicsError
from tedm_cli.gravity.kernel import cuboid_field, cuboid_force_gradient


def limit(name):
    """Largest relative error allowed."""
    if name == "force":
        return 2e-14
    if name in ("gamma_lin", "force alone", "gamma_lin alone"):
        return 1e-13
    return 1e-12


@pytest.mark.parametrize("shape", SHAPES)
def test_exact_from_surface_to_far_field(shape):
    table = errors_by_band(shape)
    assert sum(len(points) for points, _ in table.values()) >= 140
    for points, errors in table.values():
        assert tuple(errors) == COLUMNS
        for name, error in errors.items():
            worst = int(np.argmax(error))
            assert error[worst] < limit(name), f"{name} at {points[worst]}: {error[worst]:.1e}"


@pytest.mark.parametrize(
    ("point", "shape"),
    [((0.041, 0.012, -0.027), "cube"), ((-0.03, 0.01, 0.02), "slab")],
)
def test_corner_sum_reference_against_quadrature(point, shape):
    exact = exact_field(point, SHAPES[shape])
    force, gamma = face_quadrature(point, SHAPES[shape])
    assert exact["force"][0] == pytest.approx(force, rel=1e-14)
    assert exact["gamma_lin"][0, 0] == pytest.approx(gamma, rel=1e-13)


def test_force_against_volume_quadrature():
    """At 12 mm from the face of the test mass, against the volume integral by product quadrature."""
    point = np.array([0.035, -0.01, 0.02])
    nodes, weights = np.polynomial.legendre.leggauss(40)
    grid = np.stack(np.meshgrid(nodes, nodes, nodes, indexing="ij"), axis=-1) * CUBE / 2
    delta = point - grid
    density = np.einsum("i,j,k->ijk", weights, weights, weights) / 8 / np.linalg.norm(delta, axis=-1) ** 3
    force = np.einsum("ijk,ijkc->c", density, delta)
    np.testing.assert_allclose(cuboid_field(point[None], CUBE).force[0], force, rtol=1e-13)


sides_strategy = st.sampled_from([(1.0, 1.0, 1.0), (1.0, 1.0, 0.1), (0.1, 1.0, 0.1), (0.46, 1.0, 0.7)]).map(np.array)
unit_strategy = arrays(int, 3, elements=st.integers(-1000, 1000)).filter(np.any).map(lambda v: v / 1000.0)
gap_strategy = st.floats(-6.0, 3.0).map(lambda exponent: 10.0**exponent)


def place(sides, direction, gap):
    """A point on the ray `direction`, where it has left the cuboid by the fraction `gap`."""
    return direction / np.abs(direction / (sides / 2)).max() * (1.0 + gap)


@settings(deadline=None, max_examples=60, derandomize=True)
@given(sides_strategy, unit_strategy, gap_strategy)
def test_identities(sides, direction, gap):
    point = place(sides, direction, gap)
    field = cuboid_field(point[None], sides)
    force, gamma, torque = field.force[0], field.gamma_lin[0], field.torque[0]
    omega, gamma_ang, omega_ang = field.omega_lin[0], field.gamma_ang[0], field.omega_ang[0]
    # the closed form of a body 10 times thinner than wide loses two digits
    assert abs(np.trace(gamma)) < 1e-12 * np.abs(gamma).max()
    np.testing.assert_array_equal(gamma, gamma.T)
    assert abs(np.trace(omega)) < 1e-11 * np.abs(omega).max()
    scale = np.abs(omega).max() * np.linalg.norm(point)
    assert np.abs(omega_ang - omega_ang.T + cross_matrix(torque)).max() < 1e-11 * scale
    # the definitions, in which the monopole cancels: absolute rounding of the monopole
    rounding = 1e-12 * np.abs(force).max()
    assert np.abs(torque - np.cross(point, force)).max() < rounding * np.linalg.norm(point)
    assert np.abs(omega - cross_matrix(force) - cross_matrix(point) @ gamma).max() < rounding
    assert np.abs(gamma_ang + cross_matrix(force) + gamma @ cross_matrix(point)).max() < rounding


@settings(deadline=None, max_examples=40, derandomize=True)
@given(sides_strategy, unit_strategy, gap_strategy, arrays(bool, 3))
def test_mirror_and_permutation_symmetry(sides, direction, gap, mirrored):
    """Reflections and cyclic renaming of the axes: no axis is special in the edge form or the expansion."""
    point = place(sides, direction, gap)
    field = cuboid_field(point[None], sides)
    for transform, parity in (
        (np.diag(np.where(mirrored, -1.0, 1.0)), (-1.0) ** mirrored.sum()),
        (AXIS_PERMUTATION, 1.0),
    ):
        image = cuboid_field((transform @ point)[None], np.abs(transform) @ sides)
        # polar vectors and tensors map by the transform, axial ones change sign under a reflection
        for name, axial in (("force", 0), ("torque", 1)):
            expected = parity**axial * transform @ getattr(field, name)[0]
            scale = (
                np.abs(field.force).max() if name == "force" else np.abs(field.omega_lin).max() * np.abs(point).max()
            )
            assert np.abs(getattr(image, name)[0] - expected).max() < 1e-11 * scale
        for name, axial in (("gamma_lin", 0), ("omega_lin", 1), ("gamma_ang", 1), ("omega_ang", 2)):
            expected = parity**axial * transform @ getattr(field, name)[0] @ transform.T
            assert np.abs(getattr(image, name)[0] - expected).max() < 1e-11 * np.abs(expected).max()


@settings(deadline=None, max_examples=30, derandomize=True)
@given(sides_strategy, unit_strategy, gap_strategy, st.sampled_from([2.0**-20, 0.5, 2.0**12]))
def test_scaling_of_lengths(sides, direction, gap, factor):
    point = place(sides, direction, gap)
    field, scaled = cuboid_field(point[None], sides), cuboid_field(factor * point[None], factor * sides)
    powers = {"force": 2, "gamma_lin": 3, "torque": 1, "omega_lin": 2, "gamma_ang": 2, "omega_ang": 1}
    for name, power in powers.items():
        expected = getattr(field, name)
        np.testing.assert_allclose(
            getattr(scaled, name) * factor**power, expected, rtol=0, atol=1e-14 * np.abs(expected).max()
        )


def test_flux_through_a_closed_surface_is_four_pi():
    """Gauss: the attraction by the cuboid through a box around it, by quadrature of the kernel on its six faces."""
    sides = SHAPES["brick"]
    box = np.array([0.05, 0.06, 0.055])
    nodes, weights = np.polynomial.legendre.leggauss(64)
    flux = 0.0
    for axis in range(3):
        u, v = (box[(axis + n) % 3] / 2 for n in (1, 2))
        points = np.empty((nodes.size, nodes.size, 3))
        points[..., (axis + 1) % 3] = u * nodes[:, None]
        points[..., (axis + 2) % 3] = v * nodes[None, :]
        points[..., axis] = box[axis] / 2
        normal = cuboid_field(points.reshape(-1, 3), sides).force[:, axis].reshape(nodes.size, -1)
        flux += 2 * u * v * np.einsum("i,j,ij", weights, weights, normal)
    assert flux == pytest.approx(4 * np.pi, rel=1e-13)


@pytest.mark.parametrize("offset", [1e-16, 1e-17, 1e-18, 0.0, -1e-18, -1e-17])
def test_no_branch_jump_beside_a_face_plane(offset):
    """A hair above and below the plane of a face, outside its outline, the field is that in the plane."""
    half = 0.023
    points = np.array([[half + offset, 0.04, 0.01], [half + offset, 0.03, 0.04], [half + offset, half, 0.05]])
    field = cuboid_field(points, CUBE)
    plane = exact_fields(points, CUBE)
    np.testing.assert_allclose(field.force, plane["force"], rtol=1e-12)
    np.testing.assert_allclose(field.gamma_lin, plane["gamma_lin"], atol=1e-12 * np.abs(plane["gamma_lin"]).max())


@pytest.mark.parametrize(
    "inside", [(0.0, 0.0, 0.0), (0.0, 0.0229, 0.0), (0.023, 0.0, 0.0), (0.023, -0.023, 0.01), (0.023, 0.023, 0.023)]
)
def test_source_inside_or_on_the_body_is_named(inside):
    points = np.array([[0.1, 0.0, 0.0], [0.0, 0.0, 0.05], inside])
    with pytest.raises(PhysicsError, match=rf"source 2 .* {np.linalg.norm(inside):.6g} m from its centre"):
        cuboid_field(points, CUBE)


def test_source_without_a_position_is_named():
    with pytest.raises(PhysicsError, match=r"source 1 .* no finite position"):
        cuboid_field([[0.1, 0.0, 0.0], [np.nan, 0.0, 1.0]], CUBE)


def test_results_are_independent_of_order_and_threads_to_the_bit():
    rng = np.random.default_rng(7)
    points = np.concatenate([random_points(CUBE, *band, 700, rng) for band in BANDS])
    order = rng.permutation(len(points))
    field = cuboid_field(points, CUBE)
    shuffled, threaded = cuboid_field(points[order], CUBE), cuboid_field(points, CUBE, threads=3)
    for name in QUANTITIES:
        value = getattr(field, name)
        np.testing.assert_array_equal(getattr(threaded, name), value)
        np.testing.assert_array_equal(getattr(shuffled, name), value[order])
        with pytest.raises(ValueError, match="read-only"):
            value[0] = 0.0
    both = zip(cuboid_force_gradient(points, CUBE), cuboid_force_gradient(points, CUBE, threads=2), strict=True)
    for one, two in both:
        np.testing.assert_array_equal(one, two)


def test_importing_the_room_does_not_import_the_compiler():
    code = "import sys, tedm_cli.gravity.operator; sys.exit('numba' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_digits_of_the_reference_suffice():
    """At 1200 half diagonals the torque of a cube cancels some 12 digits of the corner sum, and r³ as many."""
    point = random_points(CUBE, 1100.0, 1200.0, 1, np.random.default_rng(3))[0]
    coarse, fine = exact_field(point, CUBE), exact_field(point, CUBE, 80)
    for name in QUANTITIES:
        assert np.abs(coarse[name] - fine[name]).max() <= 1e-15 * np.abs(fine[name]).max()


def test_against_choclo():
    """An independent closed form of the prism, where double precision serves it well."""
    from choclo import prism  # of its own compiled kernels

    sides = SHAPES["brick"]
    points = random_points(sides, 1.1, 2.0, 8, np.random.default_rng(11))
    limits = [sign * side / 2 for side in sides for sign in (-1, 1)]
    unit = gravitational_constant * sides.prod()  # the prism of density 1 attracts a point, per unit mass of it
    force, gamma = cuboid_force_gradient(points, sides)
    for point, f, g in zip(points, force, gamma, strict=True):
        attraction = np.array([component(*point, *limits, 1.0) for component in (prism.gravity_e, prism.gravity_u)])
        gradient = np.array([component(*point, *limits, 1.0) for component in (prism.gravity_ee, prism.gravity_en)])
        assert np.abs(-attraction / unit - f[[0, 2]]).max() < 1e-12 * np.linalg.norm(f)
        assert np.abs(gradient / unit - g[0, :2]).max() < 1e-11 * np.linalg.norm(g)
