"""Exactness and identities of the field of a cuboid."""

import numpy as np
import pytest
from gravity_reference import (
    AXIS_PERMUTATION,
    QUANTITIES,
    cross_matrix,
    exact_field,
    exact_fields,
    face_quadrature,
    relative_errors,
)
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from tedm_cli.errors import PhysicsError
from tedm_cli.gravity.kernel import cuboid_field

CUBE = np.full(3, 0.046)
SHAPES = {
    "cube": CUBE,
    "slab": np.array([0.046, 0.046, 0.0046]),
    "brick": np.array([0.02, 0.046, 0.03]),
    "rod": np.array([0.005, 0.046, 0.006]),
    "near cube": np.array([0.046, 0.046, 0.046 * (1 + 1e-7)]),
}
# distance from the centre over half the body diagonal
BANDS = ((0.6, 1.7), (1.7, 2.1), (2.1, 2.8), (2.8, 4.0), (4.0, 8.0), (8.0, 20.0), (20.0, 60.0), (60.0, 1200.0))


def random_points(sides, lower, upper, count, rng):
    directions = rng.normal(size=(4 * count, 3))
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    ratio = np.exp(rng.uniform(np.log(lower), np.log(upper), size=4 * count))
    points = directions * ratio[:, None] * np.linalg.norm(sides) / 2
    return points[(np.abs(points) > sides / 2).any(axis=1)][:count]


def surface_points(sides, gap, rng):
    """Points at up to `gap` from faces, edges and corners."""
    half = sides / 2
    points = []
    for outside in np.ndindex(2, 2, 2):
        if any(outside):
            inner = rng.uniform(-1, 1, 3) * half
            outer = rng.choice([-1.0, 1.0], 3) * (half + gap * rng.uniform(0.1, 1.0, 3))
            points.append(np.where(outside, outer, inner))
    return np.array(points)


def extension_points(sides):
    """Points on the planes of faces, the lines of edges, and both prolonged, outside the body."""
    x, y, z = sides / 2
    return np.array(
        [
            [x, 1.5 * y, 0.3 * z],
            [-x, 0.2 * y, 4.0 * z],
            [x, y, 1.1 * z],
            [x, -y, -3.0 * z],
            [3.0 * x, y, z],
            [-1.01 * x, -y, z],
            [x, 5.0 * y, -z],
            [0.0, 1.3 * y, 0.0],
            [0.0, 0.0, -2.0 * z],
            [x, 40.0 * y, z],
            [1.5 * x, 1.5 * y, 1.5 * z],
        ]
    )


@pytest.mark.parametrize("shape", SHAPES)
def test_exact_from_surface_to_far_field(shape):
    sides = SHAPES[shape]
    rng = np.random.default_rng(20040501)
    sets = [random_points(sides, *band, 8, rng) for band in BANDS]
    sets += [surface_points(sides, gap * sides.max(), rng) for gap in (1e-9, 1e-5, 1e-2)]
    points = np.concatenate([*sets, extension_points(sides)])
    assert len(points) >= 90
    errors = relative_errors(cuboid_field(points, sides), exact_fields(points, sides), points)
    for name in QUANTITIES:
        limit = 2e-14 if name == "force" else 1e-12
        worst = int(np.argmax(errors[name]))
        assert errors[name][worst] < limit, f"{name} at {points[worst]}: {errors[name][worst]:.1e}"


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


def test_results_are_read_only_and_independent_of_order():
    rng = np.random.default_rng(7)
    points = np.concatenate([random_points(CUBE, *band, 5, rng) for band in BANDS])
    order = rng.permutation(len(points))
    field, shuffled = cuboid_field(points, CUBE), cuboid_field(points[order], CUBE)
    for name in QUANTITIES:
        value = getattr(field, name)
        scale = np.abs(value).reshape(len(points), -1).max(axis=1).reshape(-1, *(1,) * (value.ndim - 1))
        assert (np.abs(getattr(shuffled, name) - value[order]) <= 1e-14 * scale[order]).all()
        with pytest.raises(ValueError, match="read-only"):
            value[0] = 0.0


def test_digits_of_the_reference_suffice():
    """At 1200 half diagonals the torque of a cube cancels some 12 digits of the corner sum, and r³ as many."""
    point = random_points(CUBE, 1100.0, 1200.0, 1, np.random.default_rng(3))[0]
    coarse, fine = exact_field(point, CUBE, 60), exact_field(point, CUBE, 80)
    for name in QUANTITIES:
        assert np.abs(coarse[name] - fine[name]).max() <= 1e-15 * np.abs(fine[name]).max()
