"""Surfaces of triangles and pockets as users give them: what is read, mended, and refused by name."""

import re
import struct

import numpy as np
import pytest
from bodies import HALF, Z, chamfered

from tedm_cli.errors import PhysicsError
from tedm_cli.gravity.bodies.box import Box
from tedm_cli.gravity.bodies.composite import Composite, Pocket
from tedm_cli.gravity.bodies.cylinder import Cylinder
from tedm_cli.gravity.bodies.mesh_check import checked_polyhedron
from tedm_cli.gravity.bodies.pockets import check_pockets
from tedm_cli.gravity.bodies.polyhedron import chamfered_cuboid
from tedm_cli.gravity.bodies.solid import cuboid_triangles
from tedm_cli.gravity.bodies.stl import stl_triangles

CUBE = cuboid_triangles(np.full(3, -HALF), np.full(3, HALF))


def refused(triangles, *patterns):
    with pytest.raises(PhysicsError) as caught:
        checked_polyhedron(np.asarray(triangles))
    for pattern in patterns:
        assert re.search(pattern, str(caught.value)), str(caught.value)


def ascii_stl(triangles):
    lines = ["solid body"]
    for t in triangles:
        corners = [f"   vertex {' '.join(repr(float(c)) for c in corner)}" for corner in t]
        lines += [" facet normal 0 0 0", "  outer loop", *corners, "  endloop", " endfacet"]
    return "\n".join([*lines, "endsolid body", ""]).encode()


def binary_stl(triangles, header=b"solid by some program"):
    records = [struct.pack("<12fH", 0, 0, 0, *t.ravel(), 0) for t in triangles]
    return header.ljust(80) + len(records).to_bytes(4, "little") + b"".join(records)


@pytest.mark.parametrize("write", [ascii_stl, binary_stl])
def test_stl_is_read_as_it_was_written(write):
    triangles = chamfered().solids[0].surface()
    read = stl_triangles(write(triangles))
    exact = triangles if write is ascii_stl else triangles.astype(np.float32)
    np.testing.assert_array_equal(read, exact)
    body = checked_polyhedron(read)
    assert body.volume_m3 == pytest.approx(chamfered().volume_m3, rel=1e-6)


@pytest.mark.parametrize(
    ("content", "fact"),
    [
        (b"", "is no STL file"),
        (b"\x89PNG" + b"0" * 200, "says that it has"),
        (binary_stl(CUBE)[:-10], "says that it has 12 triangles, 684 bytes, but has 674"),
        (ascii_stl(CUBE).replace(b"loop", b"l\xf5op", 1), "line 3 is no text"),
        (ascii_stl(CUBE)[:-300], "should have three each and end with 'endsolid'"),
        (ascii_stl(CUBE).replace(b"vertex 0.023 ", b"vertex ", 1), "line .*has not three coordinates"),
        (ascii_stl(CUBE).replace(b"vertex 0.023 ", b"vertex 0.0.23 ", 1), "a coordinate is no number"),
    ],
)
def test_what_is_no_stl_file_is_refused(content, fact):
    if content.startswith(b"solid by"):
        content = content.replace(b"solid by", b"STL   by")
    with pytest.raises(PhysicsError, match=fact):
        stl_triangles(content)


def test_a_cube_is_sound():
    body = checked_polyhedron(CUBE)
    assert body.volume_m3 == pytest.approx((2 * HALF) ** 3, rel=1e-15)
    assert len(body.corner_m) == 8
    assert len(body.facets.anchor) == 6
    assert len(body.facets.edge) == 12


def test_wholly_inside_out_is_turned():
    assert checked_polyhedron(CUBE[:, ::-1]).volume_m3 == pytest.approx((2 * HALF) ** 3, rel=1e-15)


def test_a_cavity_is_taken_away():
    hole = cuboid_triangles(np.full(3, -0.01), np.full(3, 0.01))[:, ::-1]
    body = checked_polyhedron(np.concatenate([CUBE, hole]))
    assert body.volume_m3 == pytest.approx((2 * HALF) ** 3 - 0.02**3, rel=1e-14)
    assert not Composite([body]).contains(np.zeros((1, 3)))[0]


def test_open_surface():
    refused(CUBE[1:], "is open: 3 edges", r"of triangle \d+ from \(-0\.023, ")


def test_edges_of_one_triangle_turned():
    turned = CUBE.copy()
    turned[3] = turned[3, ::-1]
    refused(turned, r"triangles \d+ and \d+ have opposite orientations")


def test_three_triangles_at_an_edge():
    doubled = np.concatenate([CUBE, cuboid_triangles(np.full(3, HALF), np.full(3, 2 * HALF))])
    assert checked_polyhedron(doubled).volume_m3 > 0  # touch in a corner
    beside = cuboid_triangles(np.array([HALF, HALF, -HALF]), np.array([2 * HALF, 2 * HALF, HALF]))
    refused(np.concatenate([CUBE, beside]), "4 triangles meet at one edge")


def test_self_crossing_names_triangles():
    other = cuboid_triangles(np.array([-0.03, -0.005, -0.004]), np.array([0.04, 0.007, 0.006]))
    refused(np.concatenate([CUBE, other]), r"intersects itself: triangles \d+ and \d+", "first near")


def test_a_corner_pushed_through_the_other_side():
    pushed = CUBE.copy()
    corner = np.full(3, HALF)
    pushed[(pushed == corner).all(axis=2)] = [-0.03, -0.02, -0.028]
    refused(pushed, "intersects itself")


def test_a_shell_within_a_shell():
    inner = cuboid_triangles(np.full(3, -0.01), np.full(3, 0.01))
    refused(np.concatenate([CUBE, inner]), r"shell of 12 triangles with triangle \d+ is inside out")


def test_too_few_or_not_finite():
    refused(CUBE[:2], "has 2 triangles")
    bad = CUBE.copy()
    bad[4, 1, 2] = np.nan
    refused(bad, "triangle 5 is not finite")


def test_triangles_without_area_add_nothing():
    """A corner on an edge of the neighbour's: exporters close the gap with a flat triangle."""
    corner, middle = CUBE[0], (CUBE[0][0] + CUBE[0][1]) / 2
    a, b, c = corner
    split = np.concatenate([CUBE[1:], [[a, middle, c], [middle, b, c], [a, b, middle]]])
    body, cube = Composite([checked_polyhedron(split)]), Composite([checked_polyhedron(CUBE)])
    points = np.array([[0.03, 0.01, 0.02], [0.0231, -0.02, 0.004], [-0.0231, 0.001, -0.02]])
    np.testing.assert_allclose(body.field(points).gamma_lin, cube.field(points).gamma_lin, rtol=0, atol=1e-9)


BASE = Box(np.full(3, -HALF), np.full(3, HALF))


def box(low, high, name="p"):
    return Pocket(Box(np.array(low), np.array(high)), name=name)


def round_(x, y, radius, bottom, top, name="r"):
    return Pocket(Cylinder(Z, np.array([x, y, 0.0]), radius, bottom, top), name=name)


def test_pockets_that_touch_are_apart():
    check_pockets(
        BASE,
        [
            box([-0.01, -0.01, 0.02], [0.0, 0.01, HALF], "a"),
            box([0.0, -0.01, 0.02], [0.01, 0.01, HALF], "b"),
            round_(0.0, 0.0, 0.004, 0.01, 0.02, "below"),
            round_(0.016, 0.016, 0.0069, 0.0, HALF, "corner"),
        ],
    )


@pytest.mark.parametrize(
    ("pockets", "fact"),
    [
        ([box([0.0, 0.0, 0.02], [0.01, 0.01, 0.024])], "p is not inside the body: it sticks out of it by 0.001 m"),
        ([round_(0.02, 0.0, 0.005, 0.01, HALF)], "r is not inside the body: it sticks out of it by 0.002 m"),
        ([box([0.0] * 3, [0.01] * 3, "a"), box([0.005] * 3, [0.02] * 3, "b")], "a and b overlap"),
        ([box([0.0, 0, 0], [0.01] * 3, "a"), round_(0.012, 0.005, 0.003, 0.0, 0.01, "c")], "a and c overlap"),
        ([round_(0, 0, 0.005, 0, 0.01, "d"), round_(0.009, 0, 0.0045, 0, 0.01, "c")], "d and c overlap"),
    ],
)
def test_pockets_out_of_the_body_or_overlapping(pockets, fact):
    with pytest.raises(PhysicsError, match=fact):
        check_pockets(BASE, pockets)


def test_pocket_out_of_a_chamfer_or_a_round_side():
    near_the_edge = box([0.018, -0.01, 0.019], [0.021, 0.01, HALF])
    check_pockets(BASE, [near_the_edge])
    with pytest.raises(PhysicsError, match="sticks out"):
        check_pockets(chamfered_cuboid(np.full(3, 2 * HALF), 0.003), [near_the_edge])
    post = Cylinder(Z, np.zeros(3), 0.02, -0.02, 0.02)
    check_pockets(post, [box([-0.01, -0.01, 0.0], [0.01, 0.01, 0.02])])
    with pytest.raises(PhysicsError, match="sticks out"):
        check_pockets(post, [box([-0.015, -0.015, 0.0], [0.015, 0.015, 0.02])])
