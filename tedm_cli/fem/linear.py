"""Direct solution of sparse symmetric systems behind one small interface."""

from __future__ import annotations

from typing import Any, Literal, Protocol

import numpy as np
import scipy.sparse as sp

from tedm_cli.arrays import FloatArray
from tedm_cli.errors import PhysicsError, UsageError

SolverName = Literal["auto", "mumps", "pardiso", "superlu"]

# MUMPS error numbers: matrix singular in structure, numerically singular.
_MUMPS_SINGULAR = (-6, -10)
# PARDISO's: a pivot that is zero or negative; and its name for symmetric positive definite matrices.
_PARDISO_SINGULAR, _POSITIVE_DEFINITE = -4, 2
# Its settings, by the numbers of its manual: own values; nested dissection; one step of iterative refinement; the same
# bits in every run (8.4 s instead of 7.4 s for 190,275 unknowns on two cores).
_PARDISO_SETTINGS = {1: 1, 2: 2, 8: 1, 34: 1}


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
    solver : "mumps", "pardiso", "superlu", or "auto": the first of the three that is installed (SuperLU is SciPy's).

    Raises
    ------
    numpy.linalg.LinAlgError
        If elimination meets a zero pivot.
    PhysicsError
        If the library gives up for another reason, usually for lack of memory.
    UsageError
        If a library is asked for by name and is not installed.
    """
    if matrix.shape[0] == 0:
        return _Empty()
    for name, library in _LIBRARIES.items():
        if solver in ("auto", name):
            try:
                return library(matrix)
            except ImportError:
                if solver == name:
                    raise UsageError(f"the solver {library.name} is not installed", hint='choose "superlu"') from None
    raise UsageError(f"there is no solver {solver!r}", hint="choose one of " + ", ".join(_LIBRARIES))


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


class _Pardiso:
    """LLᵀ by the PARDISO of Intel's MKL (Schenk and Gärtner, Future Gener. Comput. Syst. 20, 2004)."""

    name = "PARDISO"

    def __init__(self, matrix: sp.csr_matrix) -> None:
        from pypardiso.pardiso_wrapper import PyPardisoError, PyPardisoSolver

        self._matrix = sp.triu(matrix, format="csr")
        if not np.diff(self._matrix.indptr).all():  # the library would crash
            raise np.linalg.LinAlgError("a row without stiffness")
        self._solver: Any = PyPardisoSolver(mtype=_POSITIVE_DEFINITE)
        for number, value in _PARDISO_SETTINGS.items():
            self._solver.set_iparm(number, value)
        try:
            self._solver.factorize(self._matrix)
        except PyPardisoError as error:
            if error.value == _PARDISO_SINGULAR:
                raise np.linalg.LinAlgError(str(error)) from error
            raise PhysicsError(
                f"{error} while factorising {matrix.shape[0]} unknowns", hint="run Nastran on the written deck"
            ) from error

    def __del__(self) -> None:
        if solver := getattr(self, "_solver", None):  # the library keeps its factors until told
            solver.free_memory(everything=True)

    def solve(self, rhs: FloatArray) -> FloatArray:
        return np.asarray(self._solver.solve(self._matrix, np.asfortranarray(rhs)))


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


_LIBRARIES: dict[str, type[_Mumps] | type[_Pardiso] | type[_SuperLU]] = {
    "mumps": _Mumps,
    "pardiso": _Pardiso,
    "superlu": _SuperLU,
}
