"""Whether a matrix is a correlation matrix, and its factor."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from tedm_cli.arrays import AnyArray, BoolArray
from tedm_cli.errors import PhysicsError

_CARRIERS = 6  # areas named for a negative eigenvalue
_CARRIES = 0.1  # least part of the largest component of its eigenvector


def check_correlation(
    matrix: AnyArray,
    active: BoolArray | None = None,
    *,
    tolerance: float = 1e-9,
    names: Sequence[str] = (),
    where: str = "correlation matrix",
) -> None:
    """Check that `matrix` [k, k] is a correlation matrix.

    Parameters
    ----------
    matrix : real or complex; complex entries hold phase shifts between areas.
    active : [k], the areas that must have a unit diagonal; the others must have zero rows. All by default.
    tolerance : on entries, and on eigenvalues relative to the largest.
    names : [k], of the areas, for messages; rows are numbered without them.

    Raises
    ------
    PhysicsError : not finite, not Hermitian, a wrong diagonal, or a negative eigenvalue, which is named with the areas
        that carry its eigenvector and the factor on the entries off the diagonal that would mend it.
    """
    if matrix.ndim != 2 or matrix.shape[0] != matrix.shape[1] or not matrix.size:
        raise PhysicsError(f"its shape is {matrix.shape}, not square", where=where)

    def entry(i: int, j: int) -> str:
        return f"[{names[i]}, {names[j]}]" if names else f"[{i}, {j}]"

    if not np.isfinite(matrix).all():
        raise PhysicsError(f"{np.count_nonzero(~np.isfinite(matrix))} entries are not finite", where=where)
    skew = np.abs(matrix - matrix.conj().T)
    i, j = divmod(int(skew.argmax()), len(matrix))
    if skew[i, j] > tolerance:
        fact = f"not Hermitian: entries {entry(i, j)} and {entry(j, i)} are {matrix[i, j]:.6g} and {matrix[j, i]:.6g}"
        raise PhysicsError(fact, where=where, hint="give R_ji = conj(R_ij)")
    wanted = np.ones(len(matrix)) if active is None else active.astype(np.float64)
    off = np.abs(np.diag(matrix) - wanted)
    i = int(off.argmax())
    if off[i] > tolerance:
        hint = "divide covariances by the two standard deviations" if wanted[i] else ""
        fact = f"diagonal entry {entry(i, i)} is {matrix[i, i]:.6g}, not {wanted[i]:g}"
        raise PhysicsError(fact, where=where, hint=hint)
    eigenvalues, vectors = np.linalg.eigh(matrix)
    lowest = float(eigenvalues[0])
    if lowest < -tolerance * max(1.0, eigenvalues[-1]):
        size = np.abs(vectors[:, 0])
        ranked = [int(i) for i in np.argsort(-size, kind="stable")[:_CARRIERS] if size[i] > _CARRIES * size.max()]
        carried = ", ".join(names[i] if names else str(i) for i in ranked)
        possible = np.floor(1e4 / (1.0 - lowest)) / 1e4  # of R' = I + λ (R - I) the lowest is 1 - λ (1 - lowest)
        raise PhysicsError(
            f"not positive semidefinite: eigenvalue {lowest:.6g} (largest {eigenvalues[-1]:.6g}), carried by {carried}",
            where=where,
            hint=f"they contradict each other; multiply the entries off the diagonal by {possible:g} or less",
        )


def correlation_factor(matrix: AnyArray) -> AnyArray:
    """Factor F [k, rank] with R = F Fᴴ, from the eigenvectors of a checked R [k, k] (zero rows for silent areas).

    Raises `PhysicsError` as `check_correlation` does.
    """
    check_correlation(matrix, np.diag(matrix) != 0.0)
    eigenvalues, vectors = np.linalg.eigh(matrix)
    kept = eigenvalues > len(matrix) * np.finfo(np.float64).eps * eigenvalues[-1]
    factor: AnyArray = vectors[:, kept] * np.sqrt(eigenvalues[kept])
    return factor
