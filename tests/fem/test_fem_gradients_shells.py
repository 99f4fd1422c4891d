"""Shells under a gradient of temperature through their thickness: against theory and solids."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from fem_models import ALPHA, NU, YOUNG, nearest, rotated, rotation_matrix, solid_mesh, solids, solve, structure
from own_temperatures import GRADIENT, motions, own, part
from shell_models import sheet, shells

from tedm_cli.fem.assembly import assemble
from tedm_cli.fem.constraints import rigid_body_matrix
from tedm_cli.fem.element_loads import element_loads

SHAPES = pytest.mark.parametrize("corners", [3, 4])


@SHAPES
@pytest.mark.parametrize("offset", [0.0, 4e-3])
@pytest.mark.parametrize("thickness", [2e-4, 2e-2])
def test_fem_a_free_plate_bends_by_alpha_times_the_gradient_without_stress(corners, offset, thickness):
    """Its stiffness times this motion is the load, on any mesh in any plane: the curvature is exact."""
    position, connectivity = sheet((4, 3), (0.3, 0.2), corners=corners, distortion=0.25)
    block = shells(connectivity, thickness, offset=offset)
    bent, (x, y, _) = ALPHA * GRADIENT, position.T
    motion = np.zeros((len(position), 6))
    motion[:, 2], motion[:, 3], motion[:, 4] = -0.5 * bent * (x**2 + y**2), -bent * y, bent * x
    motion[:, 0], motion[:, 1] = -offset * motion[:, 4], offset * motion[:, 3]  # grids hang below the mid-surface
    turn = rotation_matrix([1.0, 2.0, -1.0], 0.8)
    model = rotated(structure(position, **part(corners, block)), turn)
    motion = (motion.reshape(-1, 3) @ turn.T).reshape(-1)
    loads = element_loads(model)
    force = loads.forces(loads.own(np.zeros(len(position)), own(block.element_id, gradient=GRADIENT))[:, None])[:, 0]
    stiffness = assemble(model).stiffness
    # What cancels are the forces that each motion has by itself.
    scale = abs(stiffness) @ np.abs(motion)
    assert (np.abs(stiffness @ motion - force) < 1e-12 * scale.max()).all()
    assert np.abs(force).max() > 0.01 * YOUNG * thickness**3 / 12 * bent


@SHAPES
def test_fem_a_plate_held_at_its_edges_stays_and_pushes_with_the_full_thermal_moment(corners):
    position, connectivity = sheet((6, 3), (0.6, 0.2), corners=corners, distortion=0.2)
    x, y, _ = position.T
    edge = (x < 1e-9) | (x > 0.6 - 1e-9) | (y < 1e-9) | (y > 0.2 - 1e-9)
    block = shells(connectivity, 4e-3)
    model = structure(position, **part(corners, block), held=[(k, "123456") for k in np.flatnonzero(edge)])
    load = own(block.element_id, gradient=GRADIENT)
    (motion,), _ = motions(model, load)
    moment = YOUNG * 4e-3**3 / 12 / (1 - NU) * ALPHA * GRADIENT  # D (1 + nu) alpha T', per length
    loads = element_loads(model)
    force = loads.forces(loads.own(np.zeros(len(position)), load)[:, None]).reshape(-1, 6)
    assert np.abs(motion).max() < 1e-12 * ALPHA * GRADIENT
    for side, sign in ((0.0, -1.0), (0.6, 1.0)):
        assert force[np.abs(x - side) < 1e-9, 4].sum() == pytest.approx(sign * moment * 0.2, rel=1e-12)


SIDE, THICK = 0.3, 6e-3


def on_edges(position, across_x, across_y, everywhere):
    """Components held on the four sides of a square: `across_x` where x is that of a side, `across_y` where y is."""
    held = []
    for k, point in enumerate(position):
        for at, digits in zip(point[:2], (across_x, across_y), strict=True):
            if at < 1e-9 or at > SIDE - 1e-9:
                held.append((k, digits + everywhere))
    return held


def supported_plate(corners, cells):
    """Deflection at the centre of a square plate on simple supports, along which it does not turn."""
    position, connectivity = sheet((cells, cells), (SIDE, SIDE), corners=corners)
    centre = nearest(position, (SIDE / 2, SIDE / 2, 0.0))
    block = shells(connectivity, THICK)
    held = [*on_edges(position, "4", "5", "3"), (centre, "126")]
    (motion,), _ = motions(
        structure(position, **part(corners, block), held=held), own(block.element_id, gradient=GRADIENT)
    )
    return motion[centre, 2]


def supported_solids(cells):
    """The same of CHEXA20 under a temperature linear through the thickness."""
    position, connectivity = solid_mesh("CHEXA", 20, (cells, cells, 1), (SIDE, SIDE, THICK))
    held = on_edges(position, "2", "1", "3")
    model = structure(position, solids=(solids("CHEXA", connectivity),), held=held)
    (motion,), _ = solve(model, GRADIENT * (position[:, 2] - THICK / 2))
    return motion[nearest(position, (SIDE / 2, SIDE / 2, THICK / 2)), 2]


def test_fem_a_supported_plate_under_a_gradient_converges_to_theory_and_to_solids():
    """The Laplacian of its deflection is -(1 + nu) alpha T' (Timoshenko & Woinowsky-Krieger, Theory of Plates, 24)."""
    m = np.arange(1, 200, 2)
    terms = np.sin(m * np.pi / 2) / m**3 * (1 - 1 / np.cosh(np.minimum(m * np.pi / 2, 300.0)))
    exact = 4 * ALPHA * GRADIENT * (1 + NU) * SIDE**2 / np.pi**3 * terms.sum()
    for corners, order, least in ((4, 1.5, 1e-3), (3, 2.0, 5e-3)):
        error = np.abs([supported_plate(corners, n) / exact - 1.0 for n in (4, 8, 16)])
        assert (np.log2(error[:-1] / error[1:]) > order).all()
        assert error[-1] < least
    error = np.abs([supported_solids(n) / exact - 1.0 for n in (4, 8, 16)])
    assert (error < [2e-2, 8e-3, 1e-3]).all()


def clamped_tip(corners, cells):
    """Deflection of the middle of the free side of a plate that is clamped along the other."""
    position, connectivity = sheet(cells, (0.3, 0.2), corners=corners)
    block = shells(connectivity, THICK)
    held = [(k, "123456") for k in np.flatnonzero(position[:, 0] < 1e-9)]
    model = structure(position, **part(corners, block), held=held)
    (motion,), _ = motions(model, own(block.element_id, gradient=GRADIENT))
    return motion[nearest(position, (0.3, 0.1, 0.0)), 2]


def clamped_solid_tip(cells):
    position, connectivity = solid_mesh("CHEXA", 20, cells, (0.3, 0.2, THICK))
    held = [(k, "123") for k in np.flatnonzero(position[:, 0] < 1e-9)]
    model = structure(position, solids=(solids("CHEXA", connectivity),), held=held)
    (motion,), _ = solve(model, GRADIENT * (position[:, 2] - THICK / 2))
    return motion[nearest(position, (0.3, 0.1, THICK / 2)), 2]


def test_fem_solids_come_down_to_a_clamped_plate_as_their_mesh_gets_finer():
    """At the clamp is a layer as thin as the plate, which solids have to resolve and plates do not have."""
    quads, trias = clamped_tip(4, (24, 16)), clamped_tip(3, (24, 16))
    assert trias == pytest.approx(quads, rel=2e-3)
    apart = np.abs([clamped_solid_tip(cells) / quads - 1.0 for cells in ((6, 4, 1), (12, 8, 1), (18, 12, 2))])
    assert (apart < [9e-2, 4e-2, 1.6e-2]).all()


def test_fem_a_free_plate_bends_as_free_solids_do():
    """Both have the exact curvature, and so the same deflection at every grid, to the rounding of so thin solids."""
    size = (0.3, 0.2, 6e-3)
    position, connectivity = solid_mesh("CHEXA", 20, (3, 2, 2), size)
    supports = lambda at, level: [  # noqa: E731
        (nearest(at, (*xy, level)), digits) for xy, digits in (((0, 0), "123"), ((0.3, 0), "23"), ((0, 0.2), "3"))
    ]
    model = structure(position, solids=(solids("CHEXA", connectivity),), held=supports(position, 3e-3))
    (solid,), _ = solve(model, GRADIENT * (position[:, 2] - 3e-3))
    plane, corners = sheet((3, 2), size[:2])
    block = shells(corners, 6e-3)
    held = [*supports(plane, 0.0), (nearest(plane, (0.3, 0.2, 0.0)), "6")]
    (shell,), _ = motions(structure(plane, quads=block, held=held), own(block.element_id, gradient=GRADIENT))
    at = [nearest(position, point + np.array([0.0, 0.0, 3e-3])) for point in plane]
    np.testing.assert_allclose(shell[:, 2], solid[at, 2], atol=1e-7 * np.abs(solid[:, 2]).max(), rtol=0)


def test_fem_bending_has_an_expansion_of_its_own_and_a_membrane_has_none():
    """MID2: its expansion for gradients, MID1's for means; without bending stiffness a gradient does nothing."""
    position, connectivity = sheet((4, 2), (0.2, 0.1))
    held = [(k, "123456") for k in np.flatnonzero(position[:, 0] < 1e-9)]
    plain = shells(connectivity, 2e-3)
    half = replace(plain, bending_expansion=0.5 * plain.bending_expansion)
    flat = replace(plain, bending_stiffness=0 * plain.bending_stiffness)
    warm, bent = own(plain.element_id, mean=3.0), own(plain.element_id, gradient=GRADIENT)
    (grown, curved), _ = motions(structure(position, quads=plain, held=held), warm, bent)
    (same, less), _ = motions(structure(position, quads=half, held=held), warm, bent)
    np.testing.assert_array_equal(same, grown)
    np.testing.assert_allclose(less, 0.5 * curved, rtol=1e-9, atol=1e-18)
    (membrane, nothing), _ = motions(structure(position, quads=flat, held=held), warm, bent)
    np.testing.assert_allclose(membrane[:, :2], grown[:, :2], atol=1e-9 * np.abs(grown).max())
    assert not nothing.any()


def saddle(points, twist):
    """Points (x, y, height over it) on z = twist x y, heights along the normal."""
    x, y, height = points.T
    normal = np.stack([-twist * y, -twist * x, np.ones_like(x)], axis=1)
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    return np.stack([x, y, twist * x * y], axis=1) + height[:, None] * normal


def clamped_saddle(twist):
    """Motion of the middle of the free side of a clamped saddle of shells and of solids."""
    position, connectivity = sheet((12, 8), (0.3, 0.2))
    at = nearest(position, (0.3, 0.1, 0.0))
    block = shells(connectivity, THICK, drilling=1e-2)  # K6ROT of 1e4, as facets of curved shells need it
    held = [(k, "123456") for k in np.flatnonzero(position[:, 0] < 1e-9)]
    model = structure(saddle(position, twist), quads=block, held=held)
    (shell,), _ = motions(model, own(block.element_id, gradient=GRADIENT))
    flat, bricks = solid_mesh("CHEXA", 20, (12, 8, 1), (0.3, 0.2, THICK))
    flat -= [0.0, 0.0, THICK / 2]
    held = [(k, "123") for k in np.flatnonzero(flat[:, 0] < 1e-9)]
    model = structure(saddle(flat, twist), solids=(solids("CHEXA", bricks),), held=held)
    (solid,), _ = solve(model, GRADIENT * flat[:, 2])
    return shell[at, 2], solid[nearest(flat, (0.3, 0.1, 0.0)), 2]


def test_fem_warped_shells_follow_solids_as_flat_ones_do():
    """Corners 0.3 mm off their planes: the clamp's layer is the whole difference, as it is of a flat plate."""
    (flat, flat_solid), (shell, solid) = (clamped_saddle(twist) for twist in (0.0, 2.0))
    assert shell / solid == pytest.approx(flat / flat_solid, rel=1e-3)
    assert abs(solid / flat_solid - 1.0) > 5e-3


@SHAPES
@pytest.mark.parametrize("offset", [0.0, -3e-3])
def test_fem_forces_of_a_gradient_are_in_equilibrium(corners, offset):
    """Of warped and offset shells in a general place too: they do no work on a rigid motion."""
    rng = np.random.default_rng(corners)
    angle = 2 * np.pi * np.arange(corners) / corners
    ring = 0.05 * np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
    position = ring + rng.uniform(-5e-3, 5e-3, (corners, 3)) + [0.3, -0.2, 0.1]
    model = structure(position, **part(corners, shells([range(corners)], 2e-3, offset=offset)))
    loads = element_loads(model)
    force = loads.forces(loads.own(np.zeros(corners), own([1], gradient=GRADIENT))[:, None])[:, 0]
    rigid = rigid_body_matrix(position - position.mean(axis=0)).reshape(-1, 6)
    assert np.abs(rigid.T @ force).max() < 1e-12 * np.abs(force).max()
