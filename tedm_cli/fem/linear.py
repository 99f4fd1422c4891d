"""Direct solution of sparse symmetric systems behind one small interface."""

from __future__ import annotations

from typing import Any, Literal, Protocol

import numpy as np
import scipy.sparse as sp

from tedm_cli.arrays import FloatArray
from tedm_cli.errors import PhysicsError, UsageError

SolverName = Literal["auto", "mumps", "superlu"]

# MUMPS error numbers: matrix singular in structure, numerically singular.
_MUMPS_SINGULAR = (-6, -10)


class Factorisation(Protocol):
    """A factorised matrix."""

    @property
    def name(self) -> str:
        """The library that factorised it."""

    def solve(self, rhs: FloatArray) -> FloatArray:
        """Solution [n, m] for the right-hand sides [n, m]."""


def factorise(matrix: sp.csr_matrix, solver: SolverName = "auto") -> Factorisation:
    """Factorise a symmetric matrix once for many right-hand sides.

    Parameters
    ----------
    matrix : sparse [n, n], symmetric, both triangles stored.
    solver : "mumps", "superlu", or "auto": MUMPS where it can be imported, else SciPy's SuperLU.

    Raises
    ------
    numpy.linalg.LinAlgError
        If elimination meets a zero pivot.
    PhysicsError
        If the library gives up for another reason, usually for lack of memory.
    UsageError
        If MUMPS is asked for by name and is not installed.
    """
    if matrix.shape[0] == 0:
        return _Empty()
    if solver == "superlu":
        return _SuperLU(matrix)
    try:
        return _Mumps(matrix)
    except ImportError:
        if solver == "mumps":
            raise UsageError("the solver python-mumps is not installed", hint='choose "superlu"') from None
        return _SuperLU(matrix)


class _Empty:
    """A structure that is constrained everywhere leaves nothing to solve for."""

    name = "none"

    def solve(self, rhs: FloatArray) -> FloatArray:
        return rhs


class _Mumps:
    """LDLᵀ by MUMPS (Amestoy et al., SIAM J. Matrix Anal. Appl. 23, 2001)."""

    name = "MUMPS"

    def __init__(self, matrix: sp.csr_matrix) -> None:
        import mumps

        self._context: Any = mumps.Context()
        self._context.set_matrix(sp.triu(matrix, format="coo"), overwrite_a=True, symmetric=True)
        try:
            self._context.factor(ordering="metis")
        except mumps.MUMPSError as error:
            if error.error in _MUMPS_SINGULAR:
                raise np.linalg.LinAlgError(str(error)) from error
            raise PhysicsError(
                f"{error} while factorising {matrix.shape[0]} unknowns", hint="run Nastran on the written deck"
            ) from error

    def solve(self, rhs: FloatArray) -> FloatArray:
        return np.asarray(self._context.solve(np.asfortranarray(rhs)))


class _SuperLU:
    """LU by SuperLU with a fill-reducing ordering of the symmetric pattern and diagonal pivots."""

    name = "SuperLU"

    def __init__(self, matrix: sp.csr_matrix) -> None:
        from scipy.sparse.linalg import splu

        try:
            self._factors: Any = splu(
                matrix.tocsc(),
                permc_spec="MMD_AT_PLUS_A",
                diag_pivot_thresh=0.0,
                options={"SymmetricMode": True},
            )
        except RuntimeError as error:  # "Factor is exactly singular"
            raise np.linalg.LinAlgError(str(error)) from error

    def solve(self, rhs: FloatArray) -> FloatArray:
        return np.asarray(self._factors.solve(rhs))
