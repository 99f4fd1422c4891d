"""Shells: patch tests, rigid motion, free expansion, plates and curved shells of the literature."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.sparse.linalg as sparse_linalg
from fem_models import ALPHA, nearest, rotated, rotation_matrix, solve, structure
from hypothesis import given, settings
from hypothesis import strategies as st
from shell_models import sheet, shells

from tedm_cli.errors import PhysicsError
from tedm_cli.fem.assembly import assemble
from tedm_cli.fem.constraints import rigid_body_matrix
from tedm_cli.fem.shells import shell_matrices

SHAPES = pytest.mark.parametrize("corners", [3, 4])


def part(corners, block):
    return {"quads" if corners == 4 else "trias": block}


def one(position, **section):
    (found,) = shell_matrices(position, shells([range(len(position))], section.pop("thickness", 2e-3), **section))
    return found


def ring(count, seed, warp=0.0):
    """An irregular convex polygon of some centimetres in a general plane, its corners `warp` off it."""
    rng = np.random.default_rng(seed)
    angle = 2 * np.pi * (np.arange(count) + rng.uniform(-0.2, 0.2, count)) / count
    flat = 0.05 * np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1) * rng.uniform(0.8, 1.2, (count, 1))
    flat[:, 2] += warp * rng.uniform(-1.0, 1.0, count)
    return flat @ rotation_matrix(rng.standard_normal(3), 1.3).T + rng.uniform(-1.0, 1.0, 3)


def deflect(model, load, held):
    """Displacements [N, 6] under nodal forces [N, 6], with `held` [N, 6] fixed."""
    stiffness, free = assemble(model).stiffness, ~held.reshape(-1)
    motion = np.zeros(held.size)
    motion[free] = sparse_linalg.spsolve(stiffness[free][:, free].tocsc(), load.reshape(-1)[free])
    return motion.reshape(held.shape)


@SHAPES
@settings(max_examples=25, deadline=None)
@given(
    seed=st.integers(0, 10_000),
    warp=st.sampled_from([0.0, 5e-3]),
    offset=st.sampled_from([0.0, -3e-3]),
    thickness=st.sampled_from([5e-6, 2e-3, 2e-2]),
)
def test_fem_a_shell_has_six_rigid_motions_no_others_and_grows_freely(corners, seed, warp, offset, thickness):
    position = ring(corners, seed, warp)
    found = one(position, offset=offset, thickness=thickness)
    stiffness = found.stiffness[0]
    rigid = rigid_body_matrix(position - position.mean(axis=0)).reshape(-1, 6)
    size = np.sqrt(np.diagonal(stiffness))
    scaled = stiffness / np.outer(size, size)
    assert np.abs(stiffness @ rigid / size[:, None]).max() < 1e-11 * np.abs(size[:, None] * rigid).max()
    values = np.linalg.eigvalsh(scaled)
    assert (np.abs(values[:6]) < 1e-12).all()
    assert values[6] > 1e-11  # thin and warped: bending is soft beside the membrane
    grown = np.zeros((corners, 6))
    grown[:, :3] = position - position.mean(axis=0)
    gap = stiffness @ grown.reshape(-1) - found.expansion_load[0]
    assert np.abs(gap).max() < 1e-12 * np.abs(found.expansion_load).max()


def constant_membrane(position):
    x, y = position[:, 0], position[:, 1]
    motion = np.zeros((len(position), 6))
    motion[:, 0], motion[:, 1] = 1e-3 * x + 4e-4 * y, -2e-4 * x + 7e-4 * y
    motion[:, 5] = 0.5 * (-2e-4 - 4e-4)
    return motion


def constant_curvature(position):
    x, y = position[:, 0], position[:, 1]
    motion = np.zeros((len(position), 6))
    motion[:, 2] = 0.5 * (1e-3 * x**2 - 4e-4 * y**2) + 7e-4 * x * y
    motion[:, 3], motion[:, 4] = -4e-4 * y + 7e-4 * x, -(1e-3 * x + 7e-4 * y)
    return motion


@SHAPES
@pytest.mark.parametrize("state", [constant_membrane, constant_curvature])
@pytest.mark.parametrize("thickness", [1e-4, 1e-2])
def test_fem_constant_strains_and_curvatures_pass_through_distorted_meshes(corners, state, thickness):
    size = np.array([0.4, 0.3])
    position, connectivity = sheet((4, 3), size, corners=corners, distortion=0.25)
    stiffness = assemble(structure(position, **part(corners, shells(connectivity, thickness)))).stiffness
    motion = state(position).reshape(-1)
    force, size_of = (found.reshape(-1, 6) for found in (stiffness @ motion, abs(stiffness) @ np.abs(motion)))
    inner = ((position[:, :2] > 1e-9) & (position[:, :2] < size - 1e-9)).all(axis=1)
    assert inner.sum() == 6
    assert (np.abs(force[inner]) <= 1e-12 * size_of[inner]).all()
    assert np.abs(force[~inner] / size_of[~inner].max()).max() > 1e-4


@SHAPES
def test_fem_constant_shear_strain_has_its_energy(corners):
    # u_z = a x + b y without rotation: gamma = (a, b) everywhere. A stiffness so small that no correction is left.
    position = ring(corners, 5)
    position -= position.mean(axis=0)
    block = shells([range(corners)], 1.0)
    weak = np.full(1, 1e5)
    block = type(block)(**{**vars(block), "shear_stiffness": weak, "drilling_stiffness": 0 * weak})
    (found,) = shell_matrices(position, block)
    normal = np.cross(position[2] - position[0], position[-1] - position[1])
    area = 0.5 * np.linalg.norm(normal)
    normal /= np.linalg.norm(normal)
    slope = np.cross(normal, [0.3, -0.5, 0.8])
    motion = np.zeros((corners, 6))
    motion[:, :3] = (position @ slope)[:, None] * normal
    motion = motion.reshape(-1)
    assert motion @ found.stiffness[0] @ motion == pytest.approx(1e5 * area * slope @ slope, rel=1e-6, abs=0)


@SHAPES
def test_fem_renumbering_the_corners_changes_nothing(corners):
    position = ring(corners, 11, 3e-3)
    shift = np.roll(np.arange(6 * corners).reshape(corners, 6), -1, axis=0).reshape(-1)
    here, there = one(position).stiffness[0], one(np.roll(position, -1, axis=0)).stiffness[0]
    np.testing.assert_allclose(there, here[np.ix_(shift, shift)], atol=1e-11 * np.abs(here).max())


def plate(corners, cells, thickness, clamped, *, distortion=0.0, shear=5 / 6):
    """Centre deflection of a unit square under unit pressure, times the bending stiffness."""
    position, connectivity = sheet((cells, cells), (1.0, 1.0), corners=corners, distortion=distortion)
    area = np.zeros(len(position))
    for nodes in connectivity:
        x, y = position[nodes, 0], position[nodes, 1]
        area[nodes] += 0.5 * abs(x @ np.roll(y, -1) - y @ np.roll(x, -1)) / corners
    load, held = np.zeros((len(position), 6)), np.zeros((len(position), 6), dtype=bool)
    load[:, 2] = area
    held[:, [0, 1, 5]] = True
    sides = [(position[:, axis] < 1e-9) | (position[:, axis] > 1 - 1e-9) for axis in (0, 1)]
    held[sides[0] | sides[1], 2] = True
    for side, along in zip(sides, (3, 4), strict=True):
        held[side, along] = True
        held[side, 7 - along] |= clamped
    block = shells(connectivity, thickness, nu=0.3, shear=shear)
    motion = deflect(structure(position, **part(corners, block)), load, held)
    return motion[nearest(position, (0.5, 0.5, 0.0)), 2] * block.bending_stiffness[0, 0, 0]


@SHAPES
@pytest.mark.parametrize(("clamped", "exact"), [(False, 0.00406235), (True, 0.00126532)])
def test_fem_thin_square_plates_do_not_lock(corners, clamped, exact):
    # Timoshenko & Woinowsky-Krieger, Theory of Plates and Shells, tables 8 and 35.
    coarse, fine = (plate(corners, n, 1e-4, clamped, distortion=0.2) / exact - 1.0 for n in (8, 16))
    assert abs(coarse) < 0.04
    assert abs(fine) < 0.012
    stiff = plate(corners, 8, 1e-4, clamped, distortion=0.2, shear=None) / exact - 1.0
    assert stiff == pytest.approx(coarse, abs=1e-6)


@SHAPES
def test_fem_plates_converge_with_the_square_of_the_element_size(corners):
    error = [abs(plate(corners, n, 1e-4, False) / 0.004062353 - 1.0) for n in (6, 12, 24)]
    assert error[0] / error[1] > 3.5
    assert error[1] / error[2] > 3.5


def test_fem_thick_strip_bends_and_shears_as_a_beam():
    # A cantilever of length L with nu = 0 under a tip force: L³ / 3 E I + L / (5/6 G A).
    length, width, thickness, young = 0.1, 0.02, 0.03, 7e10
    position, connectivity = sheet((40, 1), (length, width))
    load, held = np.zeros((len(position), 6)), np.zeros((len(position), 6), dtype=bool)
    tip = position[:, 0] > length - 1e-9
    load[tip, 2] = 0.5
    held[position[:, 0] < 1e-9] = True
    motion = deflect(structure(position, quads=shells(connectivity, thickness, nu=0.0)), load, held)
    inertia = width * thickness**3 / 12
    bending, shear = length**3 / (3 * young * inertia), length / (5 / 6 * young / 2 * width * thickness)
    assert shear / bending > 0.05
    assert motion[tip, 2].mean() == pytest.approx(bending + shear, rel=2e-3)


def test_fem_membrane_and_bending_of_a_flat_plate_are_not_coupled_and_an_offset_couples_them():
    flat, lifted = (one(ring(4, 3), offset=offset) for offset in (0.0, 4e-3))
    position = ring(4, 3)
    normal = np.cross(position[2] - position[0], position[3] - position[1])
    normal /= np.linalg.norm(normal)
    arm = np.tile(4e-3 * normal, (4, 1))
    turn = np.zeros((24, 24))
    for k, block in enumerate(rigid_body_matrix(arm)):
        turn[6 * k : 6 * k + 6, 6 * k : 6 * k + 6] = block
    moved = turn.T @ flat.stiffness[0] @ turn
    np.testing.assert_allclose(lifted.stiffness[0], moved, atol=1e-10 * np.abs(moved).max())
    np.testing.assert_allclose(lifted.expansion_load[0], turn.T @ flat.expansion_load[0], rtol=1e-9, atol=1e-3)


def test_fem_bimetal_strip_bends_to_timoshenkos_curvature():
    # Two strips h thick, joined, of equal modulus: curvature 3/2 (alpha_1 - alpha_2) T / (2 h); nu = 0 makes it exact.
    thickness, width, heat = 1e-3, 0.01, 10.0
    position, connectivity = sheet((20, 1), (0.1, width))
    layers = [
        shells(connectivity, thickness, nu=0.0, alpha=alpha, offset=side * thickness / 2)
        for alpha, side in ((2e-5, 1.0), (1e-5, -1.0))
    ]
    both = type(layers[0])(
        **{
            name: np.concatenate([getattr(layer, name) for layer in layers])
            for name, value in vars(layers[0]).items()
            if value is not None
        }
    )
    model = structure(position, quads=both, held=[(0, "123456")])
    (motion,), _ = solve(model, heat)
    curvature = -np.diff(motion[connectivity[:, :2], 4], axis=1)[:, 0] / 5e-3
    np.testing.assert_allclose(curvature, -1.5 * 1e-5 * heat / (2 * thickness), rtol=1e-9)


def test_fem_bent_sheets_need_no_more_than_the_weak_tie_of_their_normal_rotations():
    # A box-like fold, held in a determinate way and warmed, grows like its coordinates without a rotation; so it does
    # when it is turned, as the tie follows the mid-surface.
    position, connectivity = sheet((4, 6), (0.2, 0.3), distortion=0.2)
    position[:, 2] = np.maximum(0.0, position[:, 1] - 0.1) * 0.8
    far, side = nearest(position, (0.2, 0, 0)), nearest(position, (0, 0.1, 0.0))
    model = structure(position, quads=shells(connectivity, 2e-3), held=[(0, "123"), (far, "23"), (side, "3")])
    (motion,), report = solve(model, 3.0)
    grown = 3.0 * ALPHA * position
    np.testing.assert_allclose(motion[:, :3], grown - grown[0], atol=1e-9 * np.abs(grown).max())
    assert np.abs(motion[:, 3:]).max() < 1e-8 * ALPHA
    assert report.smallest_scaled_eigenvalue > 1e-10


def test_fem_a_sheet_in_a_general_plane_turns_with_its_coordinates():
    position, connectivity = sheet((4, 3), (0.2, 0.15), distortion=0.2)
    position[:, 2] = 0.3 * position[:, 0] ** 2
    left = np.flatnonzero(position[:, 0] < 1e-9)
    model = structure(position, quads=shells(connectivity, 2e-3), held=[(row, "123456") for row in left])
    turn = rotation_matrix((1.0, -2.0, 0.5), 1.1)
    heat = position[:, 1] / 0.15
    (here,), (there,) = solve(model, heat)[0], solve(rotated(model, turn), heat)[0]
    for axis in (slice(0, 3), slice(3, 6)):
        assert np.abs(there[:, axis] - here[:, axis] @ turn.T).max() < 1e-9 * np.abs(here[:, axis]).max()


@pytest.mark.parametrize(("k6rot", "coarse", "fine"), [(1e4, 0.03, 0.008), (100.0, 0.06, 0.035)])
def test_fem_scordelis_lo_roof(k6rot, coarse, fine):
    """MacNeal & Harder, A proposed standard set of problems, Finite Elements in Analysis and Design 1, 1985.

    A thin curved shell of facets asks for a stiffer tie about the normal than Nastran's default of PARAM,K6ROT.
    """
    radius, half, angle, thickness, young = 25.0, 25.0, np.radians(40.0), 0.25, 4.32e8
    found = []
    for cells in (6, 12):
        flat, connectivity = sheet((cells, cells), (angle, half))
        position = np.stack([radius * np.sin(flat[:, 0]), flat[:, 1], radius * np.cos(flat[:, 0])], axis=1)
        area = np.zeros(len(position))
        np.add.at(area, connectivity, radius * angle * half / cells**2 / 4.0)
        load, held = np.zeros((len(position), 6)), np.zeros((len(position), 6), dtype=bool)
        load[:, 2] = -90.0 * area
        held[np.ix_(flat[:, 0] < 1e-9, [0, 4, 5])] = True
        held[np.ix_(flat[:, 1] < 1e-9, [1, 3, 5])] = True
        held[np.ix_(flat[:, 1] > half - 1e-9, [0, 2])] = True
        block = shells(connectivity, thickness, young=young, nu=0.0, drilling=1e-6 * k6rot)
        motion = deflect(structure(position, quads=block), load, held)
        found.append(motion[np.argmax(flat[:, 0] - flat[:, 1]), 2] / -0.3024)
    assert found[0] == pytest.approx(1.0, abs=coarse)
    assert found[1] == pytest.approx(1.0, abs=fine)
    assert (abs(found[1] - 1.0) > 0.01) == (k6rot == 100.0)


def test_fem_membranes_and_plates_alone_leave_the_rest_free():
    position, connectivity = sheet((2, 2), (0.2, 0.1))
    position = position @ rotation_matrix((0.3, 1.0, -0.2), 0.7).T
    block = shells(connectivity, 1e-3, drilling=0.0)
    membrane = type(block)(**{**vars(block), "bending_stiffness": 0 * block.bending_stiffness})
    held = [(nearest(position, position[0]), "123"), (6, "12"), (2, "12")]
    (motion,), report = solve(structure(position, quads=membrane, held=held), 1.0)
    # Nothing resists motion along the normal, which is along no axis: one component of each free grid is left out.
    assert report.n_dof <= 2 * 9 - 2
    assert (motion[:, 3:] == 0.0).all()
    assert np.abs(motion[:, :3]).max() > 0.0


@pytest.mark.parametrize("bad", [[0, 2, 1, 3], [0, 1, 1, 3], [0, 3, 2, 1]])
def test_fem_shells_without_a_convex_polygon_are_refused_by_id(bad):
    position = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], dtype=float)
    if bad == [0, 3, 2, 1]:
        position[2] = [0.2, 0.2, 0.0]  # a dart
    with pytest.raises(PhysicsError, match=r"convex polygon: 1 --|convex polygon: 1"):
        one(position[bad])


def test_fem_shell_thermal_strain_is_that_of_the_mean_temperature():
    found = one(ring(4, 2))
    np.testing.assert_array_equal(found.coupling[0] @ [4.0, 0.0, 0.0, 0.0], found.coupling[0] @ np.ones(4))
    np.testing.assert_allclose(found.coupling[0].sum(axis=1), ALPHA * found.expansion_load[0], rtol=1e-14)
