"""Structures reduced to their interface, by hand: springs and rods in a row, and what is refused of given matrices."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tedm_cli.errors import InputError, PhysicsError
from tedm_cli.fem.condensation import condense, part_grids, part_of
from tedm_cli.fem.constraints import rigid_body_matrix
from tedm_cli.fem.parts import of_elements
from tedm_cli.fem.static import StaticSolution
from tedm_cli.fem.structure import DirectStiffness, LoadCase, OnFreedoms, RodBlock, Structure
from tedm_cli.fem.superelement import ReducedMatrices, made_free, require_stiffness

E, AREA, ALPHA, LENGTH = 70e9, 1e-4, 2.3e-5, 0.5
SPRING = E * AREA / LENGTH


def rods(n: int = 4) -> Structure:
    """Grids 1 to n along x, a rod between neighbours, the ends held; nothing else has stiffness."""
    connectivity = np.column_stack([np.arange(n - 1), np.arange(1, n)])
    line = np.full(n - 1, 1.0)
    return Structure(
        grid_id=np.arange(1, n + 1),
        position=np.column_stack([LENGTH * np.arange(n), np.zeros(n), np.zeros(n)]),
        rods=RodBlock(
            element_id=np.arange(1, n),
            connectivity=connectivity,
            area=AREA * line,
            torsion_constant=0.0 * line,
            youngs_modulus=E * line,
            shear_modulus=E / 2.6 * line,
            expansion=ALPHA * line,
            reference_temperature=0.0 * line,
        ),
        spc_grid=np.array([0, n - 1]),
        spc_component=np.array([1, 1]),
    )


def warm(*kelvin: float) -> LoadCase:
    return LoadCase(id=1, label="A", temperature=np.array(kelvin))


def test_two_rods_in_a_row() -> None:
    """Reduced to grid 2, the rods 2-3 and 3-4 are a spring of half the stiffness, and push as they grow."""
    whole = rods()
    of_part = part_grids(whole, np.array([1]), 2)
    assert of_part.tolist() == [False, False, True, True]
    part = part_of(whole, of_part)
    found = condense(part, np.array([1]), np.array([2, 1]), [warm(0.0, 0.0, 1.0, 1.0)])
    stiffness = np.zeros((6, 6))
    stiffness[0, 0] = SPRING / 2
    np.testing.assert_allclose(found.stiffness, stiffness, rtol=1e-12, atol=1e-9 * SPRING)
    # mean steps of the rods are 1/2 K and 1 K
    assert found.loads[0, 0] == pytest.approx(-SPRING / 2 * ALPHA * LENGTH * 1.5, rel=1e-12)
    assert found.recovery[0, 0] == pytest.approx(0.5, rel=1e-12)
    # with grid 2 held, grid 3 is pushed by the difference of the two growths
    assert found.thermal_recovery[0, 0] == pytest.approx(-ALPHA * LENGTH * 0.25, rel=1e-12)
    np.testing.assert_array_equal(found.recovery[6:], np.eye(6))
    assert not found.thermal_recovery[6:].any()


def test_the_rest_with_the_matrices_is_the_whole() -> None:
    whole = rods(5)
    case = warm(0.0, 1.0, 0.0, 2.0, 1.0)
    (motion,) = (m for _, m in StaticSolution(whole).solve([case]))
    part = part_of(whole, part_grids(whole, np.array([2]), 3))
    found = condense(part, np.array([2]), np.array([3]), [case])
    rest = replace(
        of_elements(whole, np.array([1, 2])),
        spc_grid=np.array([0]),
        spc_component=np.array([1]),
        direct=DirectStiffness(dof=12 + np.arange(6), matrix=found.stiffness),
    )
    force = OnFreedoms(12 + np.arange(6), found.loads[:, 0])
    (reduced,) = (m for _, m in StaticSolution(rest).solve([replace(case, force=force)]))
    np.testing.assert_allclose(reduced[:3], motion[:3], rtol=1e-10, atol=1e-18)
    inside = found.recovery @ reduced[2] + found.thermal_recovery[:, 0]
    np.testing.assert_allclose(inside, motion[3], rtol=1e-10, atol=1e-18)


def test_internal_freedoms_are_eliminated() -> None:
    """Springs 1 and 2 N/m in a row, a force on the point between them, which is recovered."""
    k = np.zeros((7, 7))
    k[0, 0], k[0, 6], k[6, 0], k[6, 6] = 1.0, -1.0, -1.0, 3.0
    loads, recovery = np.zeros((7, 1)), np.zeros((6, 7))
    loads[6], recovery[0, 6] = 6.0, 1.0
    found = ReducedMatrices(
        stiffness=k, loads=loads, recovery=recovery, thermal_recovery=np.zeros((6, 1))
    ).without_internal(6)
    assert found.stiffness[0, 0] == pytest.approx(2 / 3)
    assert found.loads[0, 0] == pytest.approx(2.0)
    assert found.recovery[0, 0] == pytest.approx(1 / 3)
    assert found.thermal_recovery[0, 0] == pytest.approx(2.0)
    loose = ReducedMatrices(
        stiffness=np.diag([1.0] * 6 + [0.0]), loads=loads, recovery=recovery, thermal_recovery=np.zeros((6, 1))
    )
    with pytest.raises(InputError, match="does not hold its 1 internal freedoms"):
        loose.without_internal(6)


def free_matrices() -> tuple[ReducedMatrices, np.ndarray]:
    """Two grids that a spring joins, with a third in their middle."""
    position = np.array([[0.0, 0.0, 0.0], [1.0, 0.5, 0.0]])
    rigid = rigid_body_matrix(position).reshape(12, 6)
    basis = np.linalg.qr(np.hstack([rigid, np.random.default_rng(1).standard_normal((12, 6))]))[0][:, 6:]
    middle = rigid_body_matrix(position.mean(axis=0)[None])[0]
    return ReducedMatrices(
        stiffness=1e6 * basis @ basis.T,
        loads=basis[:, :1],
        recovery=middle @ np.linalg.pinv(rigid),
        thermal_recovery=np.zeros((6, 1)),
    ), position


def test_a_free_structure_is_free() -> None:
    matrices, position = free_matrices()
    middle = position.mean(axis=0)[None]
    require_stiffness(matrices.stiffness)
    made_free(matrices, position, None, np.array([7]), middle)

    ground = matrices.stiffness.copy()
    ground[1, 1] += 1e3
    with pytest.raises(InputError, match=r"resists a rigid motion.*\(\d of 6"):
        made_free(replace(matrices, stiffness=ground), position, None, np.array([7]), middle)
    with pytest.raises(InputError, match="column 1 has a resultant"):
        made_free(replace(matrices, loads=np.ones((12, 1))), position, None, np.array([7]), middle)
    rows = matrices.recovery.copy()
    rows[0] = 0.0
    with pytest.raises(InputError, match="recovery of grid 7 does not follow"):
        made_free(replace(matrices, recovery=rows), position, None, np.array([7]), middle)
    with pytest.raises(InputError, match="recovery of grid 7 does not follow"):
        made_free(matrices, position, None, np.array([7]), middle + np.array([0.0, 0.01, 0.0]))


def test_no_stiffness() -> None:
    matrices, _ = free_matrices()
    skew = matrices.stiffness.copy()
    skew[2, 1] += 1e-3 * skew[2, 2]
    with pytest.raises(InputError, match=r"not symmetric: row \d+, column \d+"):
        require_stiffness(skew)
    with pytest.raises(InputError, match="negative eigenvalue"):
        require_stiffness(matrices.stiffness - 1e4 * np.eye(12))


def test_what_cuts_nothing_off() -> None:
    with pytest.raises(InputError, match="cuts nothing off"):
        part_grids(rods(), np.array([0]), 2)
    with pytest.raises(InputError, match="grid 2 is of the interface"):
        part_grids(rods(), np.array([1]), 1)


def test_a_structure_that_matrices_hold_needs_no_support() -> None:
    """Matrices that are free hold nothing, and the parts are named."""
    free, position = free_matrices()
    dof = np.arange(12)
    structure = Structure(
        grid_id=np.array([1, 2]), position=position, direct=DirectStiffness(dof=dof, matrix=free.stiffness)
    )
    with pytest.raises(PhysicsError, match="keep 6 of 6 rigid-body modes"):
        StaticSolution(structure)
    held = replace(structure, direct=DirectStiffness(dof=dof, matrix=free.stiffness + 1e5 * np.eye(12)))
    force = np.zeros(12)
    force[0] = 2.0
    ((_, motion),) = StaticSolution(held).solve(
        [LoadCase(id=1, label="A", temperature=np.zeros(2), force=OnFreedoms(dof, force))]
    )
    np.testing.assert_allclose(held.direct.matrix @ motion.reshape(-1), force, atol=1e-9)


def test_digits_that_a_file_lacks_hold_nothing() -> None:
    """Seven digits of a free stiffness, of loads and of a recovery: made free, to rounding."""
    matrices, position = free_matrices()
    middle = position.mean(axis=0)[None]
    noise = np.random.default_rng(3)
    k = matrices.stiffness * (1.0 + 1e-7 * noise.standard_normal((12, 12)))
    rough = replace(
        matrices,
        stiffness=(k + k.T) / 2.0,
        loads=matrices.loads * (1.0 + 1e-7 * noise.standard_normal((12, 1))),
        recovery=matrices.recovery + 1e-7 * noise.standard_normal((6, 12)),
    )
    rigid = rigid_body_matrix(position).reshape(12, 6)
    assert np.abs(rough.stiffness @ rigid).max() > 1e-9 * np.abs(k).max()
    found = made_free(rough, position, None, np.array([7]), middle)
    assert np.abs(found.stiffness @ rigid).max() < 1e-14 * np.abs(k).max()
    assert np.abs(rigid.T @ found.loads).max() < 1e-14
    np.testing.assert_allclose(found.recovery @ rigid, rigid_body_matrix(middle)[0], atol=1e-14)
    np.testing.assert_allclose(found.stiffness, matrices.stiffness, atol=1e-6 * np.abs(k).max())
