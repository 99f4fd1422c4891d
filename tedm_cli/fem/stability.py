"""Is the structure held? Free rigid motions are named before the factorisation, mechanisms after it."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import scipy.sparse as sp
from scipy.linalg import eigh
from scipy.sparse.csgraph import connected_components

from tedm_cli.arrays import BoolArray, FloatArray, IntArray
from tedm_cli.errors import PhysicsError
from tedm_cli.fem.constraints import rigid_body_matrix, to_displacement_frames
from tedm_cli.fem.factors import Factorisation
from tedm_cli.fem.linear import MemoryNeed, SolverName, factorise
from tedm_cli.fem.structure import Structure

_RANK_TOLERANCE = 1e-9
# Strain energy of a rigid motion in a given stiffness, over that of its diagonal; rounding leaves some 1e-15.
_RESISTED = 1e-12
# Smallest eigenvalue of the stiffness scaled to a unit diagonal; rounding leaves about 1e-16 of a zero one.
_SINGULAR = 1e-14
# Share of the diagonal added to a stiffness that could not be factorised, to find out what moves.
_SHIFT = 1e-9


def require_supported(
    structure: Structure, stiffness: sp.csr_matrix, active: IntArray, constrained: IntArray, measure: FloatArray
) -> None:
    """Refuse a structure of which a connected part can move as a rigid body.

    Parameters
    ----------
    stiffness : sparse [6 N, 6 N], with rigid elements eliminated and supports not yet applied.
    active, measure : degrees of freedom with stiffness, see `stiff_components`.
    constrained : degrees of freedom held by single-point constraints.

    Raises
    ------
    PhysicsError
        Naming every part that is not held, and its free motions.
    """
    loose = [
        f"the {len(grids)} grid(s) from {grids[0]} to {grids[-1]} keep {_count(motions)}"
        for grids, motions in _loose_parts(structure, stiffness, active, constrained, measure)
    ]
    if loose:
        raise PhysicsError(
            "the structure is not held: " + "; ".join(loose),
            hint="add single-point constraints or the missing connection; free-free structures have no static solution",
        )


def free_motions(
    structure: Structure, stiffness: sp.csr_matrix, active: IntArray, constrained: IntArray, measure: FloatArray
) -> list[str]:
    """Names of the rigid motions of all connected parts that nothing holds; parameters as of `require_supported`."""
    parts = _loose_parts(structure, stiffness, active, constrained, measure)
    return [motion for _, motions in parts for motion in motions]


def _loose_parts(
    structure: Structure, stiffness: sp.csr_matrix, active: IntArray, constrained: IntArray, measure: FloatArray
) -> list[tuple[IntArray, list[str]]]:
    """Ids of the grids of each connected part that is not held, and its free motions."""
    entries = stiffness.tocoo()
    links = (np.ones(entries.nnz, dtype=np.float32), (entries.row // 6, entries.col // 6))
    _, part_of = connected_components(
        sp.csr_matrix(links, shape=(structure.n_grids, structure.n_grids)), directed=False
    )
    held = np.zeros(stiffness.shape[0], dtype=bool)
    held[constrained] = True
    active_part = part_of[active // 6]
    order = np.argsort(active_part, kind="stable")
    bounds = np.flatnonzero(np.diff(active_part[order])) + 1
    loose = []
    for dofs in np.split(active[order], bounds) if len(active) else []:
        motions = _free_motions(structure, dofs, held[dofs], measure[dofs])
        if motions:
            loose.append((np.unique(structure.grid_id[dofs // 6]), motions))
    return loose


def _count(motions: list[str]) -> str:
    return f"{len(motions)} of 6 rigid-body modes ({', '.join(motions)})"


def _free_motions(structure: Structure, dofs: IntArray, held: BoolArray, measure: FloatArray) -> list[str]:
    """Names of the rigid motions of a part that its constrained degrees of freedom do not stop."""
    points, where = np.unique(dofs // 6, return_inverse=True)
    arm = structure.position[points] - structure.position[points].mean(axis=0)
    size = float(np.linalg.norm(arm, axis=1).max()) or 1.0
    # rotations as displacements at the outermost grid
    motion = to_displacement_frames(structure.displacement_frame, points) @ rigid_body_matrix(arm / size)
    triples = motion.reshape(len(points), 2, 3, 6)[where.reshape(-1), dofs % 6 // 3]
    modes = np.einsum("di,dij->dj", measure, triples)
    free = _null_space(np.vstack([modes[held], _resisted(structure, points, size)]))
    # A straight part without rotational stiffness has no sixth motion: drop motions that move nothing.
    moving = free @ _row_space(modes @ free)
    translations = moving @ _null_space(moving[3:])
    rotations = _row_space(moving[3:].T)
    return _axis_names("translation", translations[:3]) + _axis_names("rotation about", rotations)


def _resisted(structure: Structure, points: IntArray, size: float) -> FloatArray:
    """Rigid motions [m, 6] about the middle of a part that the stiffness given as a matrix resists, as rows.

    That of a structure which is held by itself does; of one that is free it leaves nothing (`made_free`).
    """
    dof, matrix = structure.direct.dof, structure.direct.matrix
    here = np.isin(dof // 6, points)
    dof, matrix = dof[here], matrix[np.ix_(here, here)]
    if not dof.size:
        return np.zeros((0, 6))
    grids, where = np.unique(dof // 6, return_inverse=True)
    arm = structure.position[grids] - structure.position[points].mean(axis=0)
    motion = to_displacement_frames(structure.displacement_frame, grids) @ rigid_body_matrix(arm)
    rigid = motion[where.reshape(-1), dof % 6]
    rigid[:, 3:] /= size
    diagonal = np.einsum("di,d,dj->ij", rigid, np.abs(np.diagonal(matrix)), rigid)
    diagonal += np.finfo(float).eps * np.trace(diagonal) * np.eye(6)
    share, vectors = eigh(rigid.T @ matrix @ rigid, diagonal)
    return np.asarray(_row_space(vectors[:, share > _RESISTED].T @ diagonal).T)


def _null_space(matrix: FloatArray) -> FloatArray:
    """Orthonormal basis [n, k] of the null space of [m, n]."""
    if not matrix.shape[0] or not matrix.shape[1]:
        return np.eye(matrix.shape[1])
    _, singular, right = np.linalg.svd(np.linalg.qr(matrix, mode="r"), full_matrices=True)
    return np.asarray(right[int((singular > _RANK_TOLERANCE).sum()) :].T)


def _row_space(matrix: FloatArray) -> FloatArray:
    """Orthonormal basis [n, k] of the row space of [m, n]."""
    if not matrix.shape[1]:
        return np.zeros((0, 0))
    _, singular, right = np.linalg.svd(matrix, full_matrices=False)
    return np.asarray(right[: int((singular > _RANK_TOLERANCE).sum())].T)


def _axis_names(motion: str, basis: FloatArray) -> list[str]:
    """Name the directions spanned by orthonormal columns [3, k], coordinate axes first."""
    names, rest = [], basis
    for axis, name in enumerate("xyz"):
        if rest.shape[1] and np.linalg.norm(rest[axis]) > 1.0 - 1e-6:
            names.append(f"{motion} {name}")
            rest = rest @ _null_space(rest[axis : axis + 1])
    for column in rest.T:
        vector = np.round(column * np.sign(column[np.abs(column).argmax()]), 2) + 0.0  # no minus sign on zero
        names.append(f"{motion} ({vector[0]:.2f}, {vector[1]:.2f}, {vector[2]:.2f})")
    return names


def factorise_supported(
    structure: Structure,
    stiffness: sp.csr_matrix,
    free: IntArray,
    solver: SolverName,
    *,
    beside_bytes: int = 0,
    told: Callable[[MemoryNeed], None] | None = None,
) -> tuple[Factorisation, float]:
    """Factorise the stiffness [n, n] of the degrees of freedom `free` [n] and make sure that nothing moves freely.

    The last two are those of `tedm_cli.fem.linear.factorise`, which raises `MemoryShortError`.

    Returns
    -------
    The factors, and an estimate of the smallest eigenvalue of the stiffness scaled to a unit diagonal.

    Raises
    ------
    PhysicsError
        If the stiffness is singular; the message names the grid and component that move most.
    """
    if not len(free):
        return factorise(stiffness, solver), 1.0
    diagonal = stiffness.diagonal()
    try:
        factors = factorise(stiffness, solver, beside_bytes=beside_bytes, told=told)
        eigenvalue, mode = _softest(factors, stiffness, diagonal)
    except np.linalg.LinAlgError:
        shifted = factorise((stiffness + sp.diags(_SHIFT * diagonal)).tocsr(), solver)
        eigenvalue, mode = 0.0, _softest(shifted, stiffness, diagonal)[1]
    if not eigenvalue > _SINGULAR:
        dof = free[int(np.argmax(np.abs(mode)))]
        raise PhysicsError(
            f"the stiffness is singular (scaled eigenvalue {eigenvalue:.1e}): a mechanism moves grid "
            f"{structure.grid_id[dof // 6]} component {dof % 6 + 1} most",
            hint="look for a bar on a grid of solids, which do not hold its rotation, or for a hinge without stiffness",
        )
    return factors, eigenvalue


def _softest(factors: Factorisation, stiffness: sp.csr_matrix, diagonal: FloatArray) -> tuple[float, FloatArray]:
    """Smallest eigenvalue, and its vector, of the scaled stiffness by inverse iteration from a fixed start."""
    scale = np.sqrt(diagonal)
    vector = np.random.default_rng(0).standard_normal((len(diagonal), 1))
    for _ in range(4):
        vector = scale[:, None] * factors.solve(scale[:, None] * vector)
        norm = float(np.linalg.norm(vector))
        if not (np.isfinite(norm) and norm > 0.0):
            raise np.linalg.LinAlgError("the solution is not finite")
        vector /= norm
    unscaled = vector[:, 0] / scale
    return float(unscaled @ (stiffness @ unscaled)), vector[:, 0]
