"""Eight-node solids: element matrices against an independent derivation, patch tests, convergence."""

from __future__ import annotations

import numpy as np
import pytest
from fem_models import ALPHA, NU, YOUNG, block_mesh, determinate, hexes, nearest, solve, structure

from tedm_cli.errors import PhysicsError
from tedm_cli.fem.assembly import assemble
from tedm_cli.fem.constraints import rigid_motion
from tedm_cli.fem.solids import hex_matrices, single_layer_elements

# Corner signs of the eight-node brick in Nastran's order.
SIGNS = np.array(
    [[-1, -1, -1], [1, -1, -1], [1, 1, -1], [-1, 1, -1], [-1, -1, 1], [1, -1, 1], [1, 1, 1], [-1, 1, 1]], float
)


def brick_by_hand(corners, young, nu, alpha):
    """Stiffness [24, 24] and thermal coupling [24, 8] in Voigt notation."""
    elasticity = np.zeros((6, 6))
    elasticity[:3, :3] = nu
    elasticity[range(3), range(3)] = 1.0 - nu
    elasticity[range(3, 6), range(3, 6)] = 0.5 - nu
    elasticity *= young / ((1.0 + nu) * (1.0 - 2.0 * nu))
    stiffness, coupling = np.zeros((24, 24)), np.zeros((24, 8))
    for point in SIGNS / np.sqrt(3.0):
        factors = 1.0 + point * SIGNS
        shape = factors.prod(axis=1) / 8.0
        slope = np.stack([SIGNS[:, a] * np.delete(factors, a, axis=1).prod(axis=1) / 8.0 for a in range(3)], axis=1)
        jacobian = corners.T @ slope
        gradient = slope @ np.linalg.inv(jacobian)
        strain = np.zeros((6, 24))
        for row, (a, b) in enumerate([(0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 0)]):
            strain[row, a::3] = gradient[:, b]
            strain[row, b::3] = gradient[:, a]
        weight = np.linalg.det(jacobian)
        stiffness += weight * strain.T @ elasticity @ strain
        thermal = alpha * np.array([1.0, 1, 1, 0, 0, 0])
        coupling += weight * np.outer(strain.T @ elasticity @ thermal, shape)
    return stiffness, coupling


def distorted_cubes(number):
    rng = np.random.default_rng(3)
    cube = 0.5 * (SIGNS + 1.0)
    return cube + rng.uniform(-0.15, 0.15, (number, 8, 3)) + rng.uniform(-3, 3, (number, 1, 3))


def test_fem_element_matrices_equal_the_voigt_derivation_in_nastran_order():
    corners = distorted_cubes(5)
    young, nu, alpha = np.array([7e10, 1.1e11, 9e10, 2e11, 4e9]), np.array([0.33, 0.3, 0.24, 0.0, 0.45]), 1e-5
    block = hexes(np.arange(40).reshape(5, 8), young=young, nu=nu, alpha=alpha)
    (part,) = hex_matrices(corners.reshape(-1, 3), block)
    for k in range(5):
        stiffness, coupling = brick_by_hand(corners[k], young[k], nu[k], alpha)
        np.testing.assert_allclose(part.stiffness[k], stiffness, atol=1e-12 * np.abs(stiffness).max())
        np.testing.assert_allclose(part.coupling[k], coupling, atol=1e-12 * np.abs(coupling).max())


def test_fem_element_has_six_rigid_motions_and_no_hourglass_modes():
    (part,) = hex_matrices(distorted_cubes(1)[0], hexes(np.arange(8)[None]))
    values = np.linalg.eigvalsh(part.stiffness[0])
    assert np.abs(values[:6]).max() < 1e-13 * values[-1]
    assert values[6] > 1e-3 * values[-1]


def test_fem_patch_of_distorted_elements_carries_any_constant_strain():
    size = (0.3, 0.2, 0.25)
    position, corners = block_mesh((3, 3, 3), size, distortion=0.3)
    stiffness = assemble(structure(position, hexes=hexes(corners))).stiffness
    strain = np.array([[1.0, 0.3, -0.2], [0.3, -0.5, 0.7], [-0.2, 0.7, 0.4]]) * 1e-4
    motion = np.zeros((len(position), 6))
    motion[:, :3] = position @ strain
    force = (stiffness @ motion.reshape(-1)).reshape(-1, 6)
    inner = ((position > 1e-9) & (position < np.array(size) - 1e-9)).all(axis=1)
    assert inner.sum() == 8
    assert np.abs(force[inner]).max() < 1e-13 * np.abs(force).max()

    lame, shear = YOUNG * NU / ((1 + NU) * (1 - 2 * NU)), YOUNG / (2 * (1 + NU))
    energy = np.prod(size) * (0.5 * lame * np.trace(strain) ** 2 + shear * (strain**2).sum())
    assert 0.5 * motion.reshape(-1) @ force.reshape(-1) == pytest.approx(energy, rel=1e-12)


def test_fem_free_expansion_of_a_distorted_block_is_exact():
    size = (0.3, 0.2, 0.25)
    position, corners = block_mesh((4, 3, 3), size, distortion=0.3)
    model = structure(position, hexes=hexes(corners, tref=293.0), held=determinate(position, size))
    (motion,), report = solve(model, 295.5)
    expected = ALPHA * 2.5 * position
    assert np.abs(motion[:, :3] - expected).max() < 1e-10 * np.abs(expected).max()
    assert (motion[:, 3:] == 0.0).all()
    assert report.expansion_residual < 1e-13
    assert report.max_relative_residual < 1e-12


def test_fem_linear_temperature_converges_quadratically_to_the_stress_free_solution():
    # u = alpha g (x² - y² - z², 2 x y, 2 x z) / 2 has the strain alpha g x in all directions and no stress.
    errors = []
    for n in (4, 8, 16):
        position, corners = block_mesh((n, n, n), (1.0, 1.0, 1.0), distortion=0.0)
        model = structure(position, hexes=hexes(corners), held=determinate(position, (1.0, 1.0, 1.0)))
        (motion,), _ = solve(model, position[:, 0])
        x, y, z = position.T
        exact = 0.5 * ALPHA * np.stack([x**2 - y**2 - z**2, 2 * x * y, 2 * x * z], axis=1)
        # The exact field satisfies the 3-2-1 supports up to a rigid motion, which is fitted away.
        rigid = rigid_motion(position - position.mean(axis=0))[:, :3]
        gap = (motion[:, :3] - exact).reshape(-1)
        fit = np.linalg.lstsq(rigid.reshape(-1, 6), gap, rcond=None)[0]
        errors.append(np.sqrt(np.mean((gap - rigid.reshape(-1, 6) @ fit) ** 2)))
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    assert (orders > 1.9).all(), (errors, orders)


def test_fem_clamped_column_of_two_materials():
    # Without lateral contraction the column is two springs in series: u = dT (k1 a1 L1 - k2 a2 L2) / (k1 + k2).
    position, corners = block_mesh((6, 2, 2), (0.6, 0.1, 0.1))
    left = position[corners].mean(axis=1)[:, 0] < 0.2
    young, alpha = np.where(left, 7e10, 1.1e11), np.where(left, 2.3e-5, 8.6e-6)
    ends = np.flatnonzero((position[:, 0] < 1e-9) | (position[:, 0] > 0.6 - 1e-9))
    sides = [(row, "23") for row in range(len(position)) if row not in ends]
    held = [(row, "123") for row in ends]
    block = hexes(corners, young=young, nu=0.0, alpha=alpha)
    (motion,), _ = solve(structure(position, hexes=block, held=held + sides), 3.0)
    k1, k2 = 7e10 / 0.2, 1.1e11 / 0.4
    expected = 3.0 * (k1 * 2.3e-5 * 0.2 - k2 * 8.6e-6 * 0.4) / (k1 + k2)
    interface = nearest(position, (0.2, 0.05, 0.05))
    assert motion[interface, 0] == pytest.approx(expected, rel=1e-12)
    quarter = nearest(position, (0.1, 0.0, 0.1))
    assert motion[quarter, 0] == pytest.approx(0.5 * expected, rel=1e-12)


def test_fem_mirrored_and_collapsed_elements_are_refused_by_id():
    position, corners = block_mesh((3, 1, 1), (3.0, 1.0, 1.0))
    corners[1] = corners[1][[4, 5, 6, 7, 0, 1, 2, 3]]
    corners[2, 6] = corners[2, 0]
    with pytest.raises(PhysicsError, match=r"2 solid element\(s\).*: 2, 3$"):
        list(hex_matrices(position, hexes(corners)))


@pytest.mark.parametrize(("cells", "expected"), [((4, 4, 1), 16), ((4, 4, 2), 0), ((4, 1, 1), 4), ((2, 2, 2), 0)])
def test_fem_walls_of_one_element_are_counted(cells, expected):
    position, corners = block_mesh(cells, (1.0, 1.0, 0.1))
    assert len(single_layer_elements(hexes(corners))) == expected
    model = structure(position, hexes=hexes(corners), held=determinate(position, (1.0, 1.0, 0.1)))
    assert solve(model, 1.0)[1].single_layer_solids == expected
