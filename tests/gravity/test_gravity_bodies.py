"""Fields of bodies that are no cuboid: exactness, identities, and the same body described in several ways."""

import numpy as np
import pytest
from bodies import (
    ALL,
    CUBE,
    HALF,
    SKEW,
    Z,
    cube_of_triangles,
    cylinder,
    eight_cuboids,
    points_outside,
    tetrahedron,
    tube,
)
from body_reference import exact_centre, exact_cylinder, exact_polyhedron, quantities
from gravity_reference import QUANTITIES, cross_matrix, relative_errors
from scipy.spatial.transform import Rotation

from tedm_cli.errors import PhysicsError
from tedm_cli.gravity.bodies.box import Box
from tedm_cli.gravity.bodies.composite import Composite, Pocket
from tedm_cli.gravity.bodies.cuboid import Cuboid, Sphere
from tedm_cli.gravity.bodies.polyhedron import Polyhedron
from tedm_cli.gravity.bodies.solid import cuboid_mesh

LIMIT = {"force": 2e-14, "gamma_lin": 2e-13, "torque": 2e-12}
KINDS = pytest.mark.parametrize("kind", ALL)


def worst(body, points, exact):
    """Largest relative error of each quantity against a list of exact fields."""
    exact = {name: np.array([row[name] for row in exact]) for name in QUANTITIES}
    return {name: float(error.max()) for name, error in relative_errors(body.field(points), exact, points).items()}


def assert_exact(errors, scale=1.0):
    for name, error in errors.items():
        assert error < scale * LIMIT.get(name, 1e-12), f"{name}: {error:.1e}"


@pytest.mark.parametrize("kind", ["cube of triangles", "tetrahedron", "chamfered"])
def test_polyhedron_is_exact_from_its_surface_on(kind):
    body = ALL[kind]
    solid = body.solids[0]
    points = points_outside(body, 20)
    centre = exact_centre(solid.corner_m, solid.triangle)
    exact = [quantities(p, centre, *exact_polyhedron(p, solid.corner_m, solid.triangle)) for p in points]
    assert_exact(worst(body, points, exact))


def test_a_face_that_is_bent_a_little_is_not_taken_for_a_plane():
    """The middle of the upper face raised by 1 µm and by 1e-12 m: its triangles are one facet only where it is flat."""
    corner, triangle = cuboid_mesh(np.full(3, -HALF), np.full(3, HALF))
    top = [1, 3, 7, 5] if corner[1, 2] > 0 else [4, 5, 7, 6]
    kept = triangle[~np.isin(triangle, top).all(axis=1)]
    lid = [(top[k], top[(k + 1) % 4], 8) for k in range(4)]
    facets = []
    for raised in (1e-6, 1e-12, 0.0):
        solid = Polyhedron(np.concatenate([corner, [[0.0, 0.0, HALF + raised]]]), np.concatenate([kept, lid]))
        facets.append(len(solid.facets.anchor))
        body = Composite([solid])
        moved = solid.moved(-body.centre_m)
        centre = exact_centre(moved.corner_m, moved.triangle)
        points = np.array([[0.01, 0.002, 0.0235], [-0.02, 0.03, 0.01]])
        exact = [quantities(p, centre, *exact_polyhedron(p, moved.corner_m, moved.triangle)) for p in points]
        assert_exact(worst(body, points, exact))
    assert facets == [9, 9, 6]


def test_polyhedron_is_exact_in_the_planes_of_its_facets():
    """Where rounding decides on which side of a facet a point is, and its solid angle is 0 or a little less."""
    body = ALL["tetrahedron"]
    solid = body.solids[0]
    a, b, c = np.moveaxis(solid.surface(), 1, 0)
    points = np.concatenate(
        [a + s * (b - a) + t * (c - a) for s, t in ((1.3, 0.9), (-0.7, 1.1), (0.2, -1.6), (2.1, 2.3))]
    )
    centre = exact_centre(solid.corner_m, solid.triangle)
    exact = [quantities(p, centre, *exact_polyhedron(p, solid.corner_m, solid.triangle)) for p in points]
    assert_exact(worst(body, points, exact))


@pytest.mark.parametrize(("radius", "half"), [(0.02, 0.03), (0.03, 0.002), (0.005, 0.04)])
def test_cylinder_is_exact_from_its_surface_on(radius, half):
    body = cylinder(Z, radius, half)
    points = points_outside(body, 4, -4.0, 0.8)
    exact = [quantities(p, [0, 0, 0], *exact_cylinder(p, radius, -half, half)) for p in points]
    assert_exact(worst(body, points, exact))


def test_polyhedra_agree_with_polyhedral_gravity():
    """With the closed form of Tsoulis (2012) in C++, where it keeps its digits: near the body."""
    peer = pytest.importorskip("polyhedral_gravity", reason="extra dev")
    for body in (tetrahedron(), cube_of_triangles()):
        solid = body.solids[0]
        points = points_outside(body, 200, -2.0, 0.3)
        theirs = peer.evaluate(
            peer.Polyhedron(
                (solid.corner_m.tolist(), solid.triangle.tolist()), 1.0 / body.volume_m3,
                metric_unit=peer.MetricUnit.UNITLESS,
            ),
            points.tolist(), parallel=False,
        )  # fmt: skip
        force = np.array([row[1] for row in theirs])
        gamma = np.array([row[2] for row in theirs])[:, [0, 3, 4, 3, 1, 5, 4, 5, 2]].reshape(-1, 3, 3)
        ours = body.field(points)
        force *= np.sign((force * ours.force).sum())
        np.testing.assert_allclose(ours.force, force, rtol=0, atol=1e-12 * np.abs(force).max())
        np.testing.assert_allclose(ours.gamma_lin, gamma, rtol=0, atol=1e-12 * np.abs(gamma).max())


@pytest.mark.parametrize("body", [cube_of_triangles(), eight_cuboids()], ids=["triangles", "eight cuboids"])
def test_a_cube_is_a_cube_however_it_is_described(body):
    points = points_outside(CUBE, 1000)
    cube = CUBE.field(points)
    errors = relative_errors(body.field(points), {name: getattr(cube, name) for name in QUANTITIES}, points)
    assert errors["force"].max() < 1e-13
    assert errors["gamma_lin"].max() < 1e-13
    for name in QUANTITIES[2:]:
        assert errors[name].max() < 1e-12, name
    np.testing.assert_allclose(body.gyration_m2, CUBE.gyration_m2, rtol=0, atol=1e-15 * CUBE.gyration_m2[0, 0])
    assert body.volume_m3 == pytest.approx(CUBE.volume_m3, rel=1e-15)


@KINDS
def test_identities(kind):
    body = ALL[kind]
    points = points_outside(body, 120, -4.0, 2.5)
    field = body.field(points)
    size = {name: np.abs(getattr(field, name)).reshape(len(points), -1).max(axis=1) for name in QUANTITIES}
    distance = np.linalg.norm(points, axis=1)
    assert (np.abs(np.trace(field.gamma_lin, axis1=1, axis2=2)) < 1e-12 * size["gamma_lin"]).all()
    np.testing.assert_array_equal(field.gamma_lin, field.gamma_lin.swapaxes(1, 2))
    assert (np.abs(np.trace(field.omega_lin, axis1=1, axis2=2)) <= 1e-11 * size["omega_lin"]).all()
    np.testing.assert_array_equal(field.gamma_ang, field.omega_lin.swapaxes(1, 2))
    for n, point in enumerate(points):
        r, f = cross_matrix(point), cross_matrix(field.force[n])
        rounding = 2e-12 * size["force"][n]
        assert np.abs(field.torque[n] - np.cross(point, field.force[n])).max() < rounding * distance[n]
        assert np.abs(field.omega_lin[n] - f - r @ field.gamma_lin[n]).max() < rounding
        assert np.abs(field.gamma_ang[n] + f + field.gamma_lin[n] @ r).max() < rounding
        skew = field.omega_ang[n] - field.omega_ang[n].T + cross_matrix(field.torque[n])
        assert np.abs(skew).max() <= 1e-11 * max(size["omega_lin"][n] * distance[n], rounding * distance[n])
    force, gamma = body.force_gradient(points)
    assert (np.abs(force - field.force).max(axis=1) < 1e-13 * size["force"]).all()
    assert (np.abs(gamma - field.gamma_lin).max(axis=(1, 2)) < 1e-12 * size["gamma_lin"]).all()


@KINDS
def test_gradients_are_derivatives(kind):
    """Central differences of force and torque, extrapolated, at half a radius to some radii from the surface."""
    body = ALL[kind]
    points = points_outside(body, 12, -0.3, 0.6)
    step = 0.02 * body.radius_m
    field = body.field(points)
    for name, gradient in (("force", "gamma_lin"), ("torque", "omega_lin")):
        slope = np.zeros((len(points), 3, 3))
        for k in range(3):
            for weight, h in zip((15 / 10, -6 / 10, 1 / 10), (1, 2, 3), strict=True):
                move = np.eye(3)[k] * step * h
                ahead, behind = (getattr(body.field(points + s * move), name) for s in (1, -1))
                slope[:, :, k] += weight * (ahead - behind) / (2.0 * h * step)
        wanted = -getattr(field, gradient)
        scale = np.abs(wanted).max(axis=(1, 2)) + np.abs(field.force).max(axis=1) * (1e-6 if name == "torque" else 0)
        # the sixth derivative of a point mass over a step of a twenty-fifth of the distance
        assert (np.abs(slope - wanted).max(axis=(1, 2)) < 2e-4 * scale).all(), name


@KINDS
def test_flux_through_a_sphere_is_four_pi(kind):
    """Gauss, with half the rule inside the reach of the closed form."""
    body = ALL[kind]
    nodes, weights = np.polynomial.legendre.leggauss(60)
    angle = 2 * np.pi * np.arange(120) / 120
    flat = np.sqrt(1 - nodes**2)
    normal = np.stack([np.outer(flat, np.cos(angle)), np.outer(flat, np.sin(angle)), np.outer(nodes, np.ones(120))], -1)
    radius = 1.4 * body.radius_m
    force = body.field(radius * normal.reshape(-1, 3)).force
    flux = radius**2 * np.einsum("ni,ni,n", force, normal.reshape(-1, 3), np.repeat(weights, 120) * 2 * np.pi / 120)
    assert flux == pytest.approx(4 * np.pi, rel=1e-9)


@KINDS
def test_near_and_far_form_agree(kind):
    """Just inside and outside each switch of the expansion the field goes on, to the change over the gap."""
    body = ALL[kind]
    rng = np.random.default_rng(5)
    way = rng.normal(size=(40, 3))
    way /= np.linalg.norm(way, axis=1, keepdims=True)
    for ratio in (1.5, 1.7, 2.1, 2.4, 2.8, 4.0, 8.0, 20.0, 60.0):
        inner, outer = (body.field(way * body.radius_m * ratio * (1 + s * 1e-14)) for s in (-1, 1))
        for name in QUANTITIES:
            a, b = getattr(inner, name), getattr(outer, name)
            size = 3e-12 * np.abs(b).reshape(len(way), -1).max(axis=1)
            # nearby the torque comes from the force, and keeps the rounding of that
            power = {"torque": 1, "omega_lin": 0, "gamma_ang": 0, "omega_ang": 1}.get(name, -np.inf)
            near = ratio < 1.8 and power >= 0
            size += 3e-13 * near * (body.radius_m * ratio) ** max(power, 0) * np.abs(outer.force).max(axis=1)
            assert (np.abs(a - b).reshape(len(way), -1).max(axis=1) <= size).all(), (name, ratio)


@KINDS
def test_as_a_source_it_pulls_as_it_is_pulled(kind):
    """Newton's third law: its points pull on a point mass as the point mass pulls on the body, and with its torque."""
    body = ALL[kind]
    points, parts = body.sources(14)
    assert parts.sum() == pytest.approx(1.0, rel=1e-13)
    np.testing.assert_allclose(parts @ points, 0.0, atol=1e-15)
    second = (parts[:, None] * points).T @ points
    if not isinstance(body, Sphere):
        np.testing.assert_allclose(np.trace(second) * np.eye(3) - second, body.gyration_m2, rtol=0, atol=1e-17)
    way = np.random.default_rng(7).normal(size=(6, 3))
    for place in way / np.linalg.norm(way, axis=1, keepdims=True) * body.radius_m * 2.0:
        delta = place - points
        pull = parts[:, None] * delta / np.linalg.norm(delta, axis=1, keepdims=True) ** 3
        field = body.field(place[None])
        force, torque = pull.sum(axis=0), np.cross(points, pull).sum(axis=0)
        np.testing.assert_allclose(field.force[0], force, rtol=0, atol=1e-9 * np.abs(force).max())
        np.testing.assert_allclose(field.torque[0], torque, rtol=0, atol=1e-8 * body.radius_m * np.abs(force).max())


def test_sphere_is_a_point_without_torque():
    sphere = Sphere(0.03)
    points = points_outside(sphere, 50, -9.0, 3.0)
    field = sphere.field(points)
    r = np.linalg.norm(points, axis=1, keepdims=True)
    np.testing.assert_allclose(field.force, points / r**3, rtol=1e-15)
    for name in ("torque", "omega_lin", "gamma_ang", "omega_ang"):
        assert not getattr(field, name).any()


def test_pockets_are_what_the_body_lacks():
    """A composite with pockets, from inside a pocket to far away, is the sum over the bodies it is made of."""
    body = ALL["pockets"]
    solid, pockets = body.solids[0], [p.solid for p in body.pockets]
    inside = np.array([[0.004, -0.003, 0.020], [0.004, -0.003, HALF], [0.007, -0.003, 0.0229], [0.022, 0.002, -0.006]])
    points = np.concatenate([inside - body.centre_m, points_outside(body, 60, -3.0, 0.5)])
    field = body.field(points)
    force, gamma = np.zeros((len(points), 3)), np.zeros((len(points), 3, 3))
    for sign, part in [(1.0, solid), *((-1.0, p) for p in pockets)]:
        nine = np.empty((len(points), 9))
        part.near(points, nine)
        force += sign * part.volume_m3 / body.volume_m3 * nine[:, :3]
        gamma += sign * part.volume_m3 / body.volume_m3 * nine[:, [3, 6, 7, 6, 4, 8, 7, 8, 5]].reshape(-1, 3, 3)
    np.testing.assert_allclose(field.force, force, rtol=0, atol=1e-12 * np.abs(force).max())
    np.testing.assert_allclose(field.gamma_lin, gamma, rtol=0, atol=1e-12 * np.abs(gamma).max())
    assert (
        np.abs(np.trace(field.gamma_lin, axis1=1, axis2=2)) < 1e-11 * np.abs(field.gamma_lin).max(axis=(1, 2))
    ).all()


def test_in_the_plane_of_an_opening_the_field_goes_on():
    """A plunger's end flush with the face: closed forms of body and pocket both jump there, and the jumps cancel."""
    body = ALL["pockets"]
    middle = np.array([0.005, -0.002, HALF]) - body.centre_m
    steps = np.array([-1e-9, 0.0, 1e-9])[:, None] * Z
    gamma = body.field(middle + steps).gamma_lin
    assert np.abs(gamma - gamma[1]).max() < 1e-6 * np.abs(gamma).max()


def test_on_an_edge_that_is_cut_away_the_field_is_finite():
    """The upper edge of the cuboid lies in the step: both closed forms are infinite there."""
    body = ALL["notched"]
    edge = np.array([0.02, 0.003, 0.01]) - body.centre_m
    field = body.field(np.stack([edge, edge + 1e-9]))
    np.testing.assert_allclose(
        field.gamma_lin[0], field.gamma_lin[1], rtol=0, atol=1e-6 * np.abs(field.gamma_lin).max()
    )
    np.testing.assert_allclose(field.force[0], field.force[1], rtol=0, atol=1e-6 * np.abs(field.force).max())


def test_notched_cuboid_is_its_two_parts():
    lower = Box(np.array([-0.02, -0.015, -0.01]), np.array([0.02, 0.015, 0.004]))
    upper = Box(np.array([-0.02, -0.015, 0.004]), np.array([0.012, 0.015, 0.01]))
    parts, body = Composite([lower, upper]), ALL["notched"]
    np.testing.assert_allclose(parts.centre_m, body.centre_m, rtol=1e-13)
    np.testing.assert_allclose(parts.gyration_m2, body.gyration_m2, rtol=0, atol=1e-14 * body.gyration_m2.max())
    assert abs(body.gyration_m2[0, 2]) > 0.01 * body.gyration_m2.max()
    points = points_outside(body, 500, -3.0, 2.0)
    a, b = parts.field(points), body.field(points)
    for name in ("force", "gamma_lin", "omega_lin"):
        first, second = getattr(a, name), getattr(b, name)
        size = np.abs(first).reshape(len(points), -1).max(axis=1)
        assert (np.abs(first - second).reshape(len(points), -1).max(axis=1) < 1e-12 * size).all(), name


def test_tube_is_the_difference_of_two_cylinders_also_in_its_bore():
    points = np.array([[0.0, 0.0, 0.0], [0.01, 0.002, 0.005], [0.0149, 0.0, 0.0], [0.0, 0.0, 0.02], [0.03, 0.01, 0.0]])
    body = tube()
    field = body.field(points)
    nodes, weights = np.polynomial.legendre.leggauss(40)
    radius, turn = 0.02 + 0.005 * nodes, 2 * np.pi * np.arange(200) / 200
    for n in (0, 1, 4):
        force = np.zeros(3)
        for r, weight in zip(radius, 0.005 * weights * radius * 2 * np.pi / 200, strict=True):
            ring = np.stack([r * np.cos(turn), r * np.sin(turn), np.zeros(200)], axis=1)
            delta = points[n] - ring[:, None, :] - 0.02 * nodes[None, :, None] * Z
            pull = delta / np.linalg.norm(delta, axis=-1, keepdims=True) ** 3
            force += weight * np.einsum("tzc,z->c", pull, 0.02 * weights)
        np.testing.assert_allclose(field.force[n], force / body.volume_m3, atol=1e-9 * np.abs(field.force).max())
    assert body.first_inside(points) is None
    assert body.first_inside(np.array([[0.02, 0.0, 0.0]])) == 0


@pytest.mark.parametrize("axis", [Z, [1.0, 0, 0], [0, 1.0, 0], SKEW])
def test_a_turned_cylinder_is_pulled_as_if_the_source_were_turned(axis):
    upright, turned = cylinder(), cylinder(axis)
    way = Rotation.align_vectors([axis], [Z])[0].as_matrix()
    points = points_outside(upright, 100, -3.0, 1.5)
    a, b = upright.field(points), turned.field(points @ way.T)
    np.testing.assert_allclose(b.force, a.force @ way.T, rtol=0, atol=1e-12 * np.abs(a.force).max())
    wanted = way @ a.omega_lin @ way.T
    assert (np.abs(b.omega_lin - wanted).max(axis=(1, 2)) < 1e-11 * np.abs(wanted).max(axis=(1, 2))).all()
    np.testing.assert_allclose(turned.gyration_m2, way @ upright.gyration_m2 @ way.T, rtol=0, atol=1e-18)


def test_the_frame_of_the_geometry_does_not_matter():
    """A body described elsewhere has its centre of mass there, and about it the same field."""
    corner, triangle = cuboid_mesh(np.full(3, -HALF), np.full(3, HALF))
    by = np.array([0.3, -0.2, 0.1])
    moved = Composite([Polyhedron(corner + by, triangle)])
    np.testing.assert_allclose(moved.centre_m, by, rtol=1e-15)
    points = points_outside(CUBE, 100, -2.0, 1.0)
    np.testing.assert_allclose(moved.field(points).force, CUBE.field(points).force, rtol=0, atol=1e-9)


@KINDS
def test_contains_and_distance(kind):
    body = ALL[kind]
    inside = body.sources(3)[0]
    assert body.contains(np.zeros((1, 3)))[0] == (kind != "tube")
    outside = points_outside(body, 200, -4.0, 0.5)
    assert not body.contains(outside).any()
    distance = body.distance(outside)
    assert (distance > 0.0).all()
    assert not body.distance(inside[body.contains(inside)]).any()
    # a lower bound: no point inside is nearer
    inside = inside[body.contains(inside)]
    assert (distance < np.linalg.norm(outside[:, None] - inside, axis=2).min(axis=1)).all()
    for bad in (np.full(3, np.nan), np.array([np.inf, 0.0, 0.0])):
        with pytest.raises(PhysicsError, match=r"source 1 .* has no finite position"):
            body.field(np.stack([outside[-1], bad]))
    if kind != "tube":
        with pytest.raises(PhysicsError, match=r"source 1 .* lies inside or on the test mass, 0 m from its centre"):
            body.field(np.stack([outside[-1], np.zeros(3)]))


def test_threads_change_nothing():
    body = ALL["pockets"]
    points = points_outside(body, 300, -2.0, 1.0).repeat(40, axis=0)
    one, two = body.field(points), body.field(points, threads=2)
    for name in QUANTITIES:
        np.testing.assert_array_equal(getattr(one, name), getattr(two, name))


def test_nothing_is_left():
    box = Box(np.full(3, -HALF), np.full(3, HALF))
    with pytest.raises(PhysicsError, match="no volume is left"):
        Composite([box], [Pocket(box)])


@pytest.mark.parametrize("make", [lambda: Cuboid([1.0, 0.0, 1.0]), lambda: Sphere(0.0), lambda: Sphere(np.inf)])
def test_sizes_must_be_positive(make):
    with pytest.raises(PhysicsError, match="must be positive"):
        make()
