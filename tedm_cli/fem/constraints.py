"""Rigid (RBE2) and interpolation (RBE3) elements and equations (MPC) as one linear map u = T u_independent.

A degree of freedom is 6 n + c with n the grid's row and c = 0 to 5, along and about the axes of the grid's displacement
frame. Displacements are small: the end of a rigid arm r moves by u + theta x r.
"""

from __future__ import annotations

from dataclasses import dataclass
from graphlib import CycleError, TopologicalSorter

import numpy as np
import scipy.sparse as sp

from tedm_cli.arrays import FloatArray, IntArray
from tedm_cli.errors import InputError
from tedm_cli.fem.structure import Mpc, Rbe2, Rbe3, Structure

# An RBE3 whose least-squares problem is worse conditioned than this does not determine the motion it is asked for.
_RANK_TOLERANCE = 1e-10


@dataclass(frozen=True, eq=False)
class Elimination:
    """The map of all degrees of freedom on the independent ones.

    transform : sparse [6 N, 6 N]; columns of dependent degrees of freedom are empty, rows of independent ones are
        those of the unit matrix.
    dependent : [.], sorted dependent degrees of freedom.
    """

    transform: sp.csr_matrix
    dependent: IntArray


@dataclass(frozen=True, eq=False)
class _Equations:
    """Dependent degrees of freedom [m] of one element as `coefficients` [m, k] of `sources` [k]."""

    name: str
    dependent: IntArray
    sources: IntArray
    coefficients: FloatArray


def rigid_body_matrix(arm: FloatArray) -> FloatArray:
    """Motion of points at `arm` [M, 3] (m) from a reference under the reference's six motions, [M, 6, 6]."""
    motion = np.zeros((len(arm), 6, 6))
    motion[:, range(6), range(6)] = 1.0
    x, y, z = arm.T
    motion[:, 0, 4], motion[:, 0, 5] = z, -y
    motion[:, 1, 3], motion[:, 1, 5] = -z, x
    motion[:, 2, 3], motion[:, 2, 4] = y, -x
    return motion


def to_basic(structure: Structure) -> sp.csr_matrix:
    """Motions in the grids' displacement frames to motions in the frame of the positions, sparse [6 N, 6 N]."""
    if structure.displacement_frame is None:
        return sp.identity(6 * structure.n_grids, format="csr")
    blocks = np.repeat(structure.displacement_frame, 2, axis=0)
    where = np.arange(len(blocks) + 1)
    return sp.csr_matrix(sp.bsr_matrix((blocks, where[:-1], where), shape=(6 * structure.n_grids,) * 2))


def rbe3_coefficients(
    position: FloatArray, element: Rbe3, frame: FloatArray | None = None
) -> tuple[IntArray, FloatArray]:
    """Weighted least-squares motion of an RBE3's dependent grid.

    The rigid motion of the dependent grid that fits the independent displacements best, in the sense of the weights, is
    taken; rotations of independent grids are weighted with the square of the mean arm, and so made lengths (MSC Nastran
    Linear Static Analysis User's Guide, on RBE3). Rigid motions are reproduced exactly.

    Parameters
    ----------
    position : [N, 3], m.
    frame : [N, 3, 3], see `Structure.displacement_frame`, or None.

    Returns
    -------
    sources : [k] degrees of freedom of the independent grids.
    coefficients : [6, k], the six motions of the dependent grid (m and rad); all in the grids' displacement frames.

    Raises
    ------
    InputError
        If the independent components do not determine all six motions.
    """
    arm = position[element.independents] - position[element.dependent]
    scale = float(np.linalg.norm(arm, axis=1).mean()) or 1.0
    to_length = np.array([1.0, 1.0, 1.0, scale, scale, scale])
    grid, component = _expand(element.independent_components)
    weight = np.sqrt(element.weights[grid]) * to_length[component]
    motion = to_displacement_frames(frame, element.independents) @ rigid_body_matrix(arm)
    design = weight[:, None] * motion[grid, component] / to_length
    left, singular, right = np.linalg.svd(design, full_matrices=False)
    rank = int((singular > _RANK_TOLERANCE * singular[0]).sum())
    if rank < 6:
        raise InputError(
            f"RBE3 {element.element_id} determines only {rank} of the 6 motions of its dependent grid",
            hint="give it three independent grids that are not on one line",
        )
    inverse = (right.T / singular) @ left.T * weight / to_length[:, None]
    return (
        6 * element.independents[grid] + component,
        to_displacement_frames(frame, np.array([element.dependent]))[0] @ inverse,
    )


def eliminate(structure: Structure) -> Elimination:
    """Resolve all rigid and interpolation elements and equations, chains included, into one map.

    Raises
    ------
    InputError
        For a degree of freedom that two elements make dependent, a single-point constraint on a dependent degree of
        freedom, a loop of elements, or an RBE3 without enough independent components.
    """
    equations = [_rbe2_equations(structure, element) for element in structure.rbe2]
    equations += [_rbe3_equations(structure, element) for element in structure.rbe3]
    equations += [_mpc_equation(number, one) for number, one in enumerate(structure.mpc, 1)]
    owner = _owners(structure, equations)
    _refuse_loops(equations, owner)

    size = 6 * structure.n_grids
    dependent = np.flatnonzero(owner >= 0)
    independent = np.flatnonzero(owner < 0)
    rows, columns, values = [independent], [independent], [np.ones(len(independent))]
    for one in equations:
        rows.append(np.repeat(one.dependent, len(one.sources)))
        columns.append(np.tile(one.sources, len(one.dependent)))
        values.append(one.coefficients.reshape(-1))
    step = sp.csr_matrix((np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))), shape=(size, size))
    step.eliminate_zeros()
    transform = step
    # Each product replaces dependent sources by their own; the longest chain bounds the number of products.
    while (owner[transform.indices] >= 0).any():
        transform = transform @ step
        transform.eliminate_zeros()
    transform.sort_indices()
    return Elimination(transform, dependent)


def _expand(components: tuple[str, ...]) -> tuple[IntArray, IntArray]:
    """Grid number and zero-based component of every digit in `components`."""
    pairs = [(k, int(digit) - 1) for k, digits in enumerate(components) for digit in digits]
    table = np.array(pairs, dtype=np.int64).reshape(-1, 2)
    return table[:, 0], table[:, 1]


def to_displacement_frames(frame: FloatArray | None, grids: IntArray) -> FloatArray:
    """Six motions in the frame of the positions to motions in the displacement frames of `grids` [M], [M, 6, 6]."""
    out = np.tile(np.eye(6), (len(grids), 1, 1))
    if frame is not None:
        out[:, :3, :3] = out[:, 3:, 3:] = frame[grids].transpose(0, 2, 1)
    return out


def _rbe2_equations(structure: Structure, element: Rbe2) -> _Equations:
    position, frame = structure.position, structure.displacement_frame
    motion = rigid_body_matrix(position[element.dependents] - position[element.independent])
    motion = (
        to_displacement_frames(frame, element.dependents)
        @ motion
        @ to_displacement_frames(frame, np.array([element.independent]))[0].T
    )
    grid, component = _expand((element.components,) * len(element.dependents))
    return _Equations(
        f"{element.kind} {element.element_id}",
        6 * element.dependents[grid] + component,
        6 * element.independent + np.arange(6),
        motion[grid, component],
    )


def _rbe3_equations(structure: Structure, element: Rbe3) -> _Equations:
    sources, coefficients = rbe3_coefficients(structure.position, element, structure.displacement_frame)
    _, component = _expand((element.components,))
    return _Equations(f"RBE3 {element.element_id}", 6 * element.dependent + component, sources, coefficients[component])


def _mpc_equation(number: int, element: Mpc) -> _Equations:
    dof = 6 * element.grids + element.components - 1
    return _Equations(
        f"equation {number} of the MPC set", dof[:1], dof[1:], -element.coefficients[None, 1:] / element.coefficients[0]
    )


def _owners(structure: Structure, equations: list[_Equations]) -> IntArray:
    """For every degree of freedom the number of the element that makes it dependent, else -1."""
    owner = np.full(6 * structure.n_grids, -1, dtype=np.int64)
    for number, one in enumerate(equations):
        taken = one.dependent[owner[one.dependent] >= 0]
        unique, count = np.unique(one.dependent, return_counts=True)
        if taken.size:
            raise InputError(
                f"{_dof_name(structure, taken[0])} depends on both {equations[owner[taken[0]]].name} and {one.name}",
                hint="a degree of freedom may be dependent in one rigid element only",
            )
        if (count > 1).any():
            raise InputError(f"{_dof_name(structure, unique[count > 1][0])} is listed twice as dependent by {one.name}")
        owner[one.dependent] = number
    spc = 6 * structure.spc_grid + structure.spc_component - 1
    clash = spc[owner[spc] >= 0]
    if clash.size:
        raise InputError(
            f"{clash.size} constrained degree(s) of freedom also depend on a rigid element, the first is "
            f"{_dof_name(structure, clash[0])} of {equations[owner[clash[0]]].name}",
            hint="constrain the independent grid instead",
        )
    return owner


def _refuse_loops(equations: list[_Equations], owner: IntArray) -> None:
    graph = {number: set(owner[one.sources].tolist()) - {-1} for number, one in enumerate(equations)}
    try:
        TopologicalSorter(graph).prepare()
    except CycleError as loop:
        names = " -> ".join(equations[number].name for number in loop.args[1])
        raise InputError(
            f"rigid elements depend on each other in a loop: {names}", hint="make one grid of the loop independent"
        ) from loop


def _dof_name(structure: Structure, dof: int) -> str:
    return f"grid {structure.grid_id[dof // 6]} component {dof % 6 + 1}"
