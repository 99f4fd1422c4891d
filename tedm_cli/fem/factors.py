"""The libraries that factorise sparse symmetric matrices, each behind the same three steps.

A library is imported when it is first used. `Factors(matrix)` analyses the pattern and says what memory the rest takes,
`factorise` computes the factors, `solve` uses them.
"""

from __future__ import annotations

import os
from typing import Any, Protocol

import numpy as np
import scipy.sparse as sp

from tedm_cli.arrays import FloatArray
from tedm_cli.errors import PhysicsError

# MUMPS error numbers: matrix singular in structure, numerically singular.
_MUMPS_SINGULAR = (-6, -10)
# PARDISO's: a pivot that is zero or negative; and its name for symmetric positive definite matrices.
_PARDISO_SINGULAR, _POSITIVE_DEFINITE = -4, 2
# Its phases.
_ANALYSE, _FACTORISE, _SOLVE = 11, 22, 33
# Its settings, by the numbers of its manual: own values; nested dissection; one step of iterative refinement; the same
# bits in every run (8.4 s instead of 7.4 s for 190,275 unknowns on two cores).
_PARDISO_SETTINGS = {1: 1, 2: 2, 8: 1, 34: 1}
# SuperLU tells no size before it is done. Fill of solids grows with the power 4/3 of the unknowns; bytes that a block
# of hexahedra took, of 33,225 unknowns (454 bytes).
_SUPERLU_BYTES, _SUPERLU_POWER = 500.0, 4.0 / 3.0


class Factorisation(Protocol):
    """A factorised matrix."""

    @property
    def name(self) -> str:
        """The library that factorised it."""

    def solve(self, rhs: FloatArray) -> FloatArray:
        """Solution [n, m] for the right-hand sides [n, m]."""


class Factors(Factorisation, Protocol):
    """A matrix [n, n] that is analysed, and factorised in a second step.

    Attributes
    ----------
    peak_bytes, kept_bytes : memory that the library says it takes more, while it factorises and afterwards.
    """

    peak_bytes: int
    kept_bytes: int

    def factorise(self) -> None:
        """Compute the factors.

        Raises
        ------
        numpy.linalg.LinAlgError
            If elimination meets a zero pivot.
        PhysicsError
            If the library gives up for another reason.
        """


class Empty:
    """A structure that is constrained everywhere leaves nothing to solve for."""

    name = "none"

    def solve(self, rhs: FloatArray) -> FloatArray:
        return rhs


class Rslab:
    """LDLᵀ by RSLAB: supernodes, nested dissection, Bunch and Kaufman's pivots. The same bits for any number of threads
    and of right-hand sides at a time."""

    name = "RSLAB"
    _process: int | None = None  # that has its threads

    def __init__(self, matrix: sp.csr_matrix) -> None:
        import rslab

        # Its threads do not come along into a forked process, which would wait for them forever.
        if Rslab._process not in (None, os.getpid()):
            raise ImportError("its threads are those of the process from which this one is forked")
        Rslab._process = os.getpid()
        self._lower = sp.tril(matrix, format="csc")
        if not np.diff(self._lower.indptr).all():
            raise np.linalg.LinAlgError("a row without stiffness")
        # Other orderings are tried by default: on solids this one always wins, in half the time.
        self._analysis: Any = rslab.analyze(self._lower, path="ldlt", ordering="metis")
        plan = self._analysis.memory_plan("float64")
        self.peak_bytes, self.kept_bytes = int(plan["peak_bytes"]), int(plan["resident_bytes"])
        self._factors: Any = None

    def factorise(self) -> None:
        try:
            self._factors = self._analysis.factor(self._lower)
        except RuntimeError as error:  # "matrix is numerically rank-deficient"
            raise np.linalg.LinAlgError(str(error)) from error
        del self._lower, self._analysis

    def solve(self, rhs: FloatArray) -> FloatArray:
        return np.asarray(self._factors.solve_many(rhs))


class Mumps:
    """LDLᵀ by MUMPS (Amestoy et al., SIAM J. Matrix Anal. Appl. 23, 2001)."""

    name = "MUMPS"

    def __init__(self, matrix: sp.csr_matrix) -> None:
        import mumps

        self._unknowns, self._error = matrix.shape[0], mumps.MUMPSError
        self._context: Any = mumps.Context()
        self._context.set_matrix(sp.triu(matrix, format="coo"), overwrite_a=True, symmetric=True)
        self._call(lambda: self._context.analyze(ordering="metis"))
        self.peak_bytes = self.kept_bytes = 1_000_000 * int(self._context.analysis_stats.est_mem_incore)

    def factorise(self) -> None:
        self._call(lambda: self._context.factor(reuse_analysis=True))

    def _call(self, step: Any) -> None:
        try:
            step()
        except self._error as error:
            if error.error in _MUMPS_SINGULAR:
                raise np.linalg.LinAlgError(str(error)) from error
            raise _given_up(error, self._unknowns) from error

    def solve(self, rhs: FloatArray) -> FloatArray:
        return np.asarray(self._context.solve(np.asfortranarray(rhs)))


class Pardiso:
    """LLᵀ by the PARDISO of Intel's MKL (Schenk and Gärtner, Future Gener. Comput. Syst. 20, 2004)."""

    name = "PARDISO"

    def __init__(self, matrix: sp.csr_matrix) -> None:
        from pypardiso.pardiso_wrapper import PyPardisoError, PyPardisoSolver

        self._matrix, self._error = sp.triu(matrix, format="csr"), PyPardisoError
        if not np.diff(self._matrix.indptr).all():  # the library would crash
            raise np.linalg.LinAlgError("a row without stiffness")
        self._solver: Any = PyPardisoSolver(mtype=_POSITIVE_DEFINITE)
        for number, value in _PARDISO_SETTINGS.items():
            self._solver.set_iparm(number, value)
        self._call(_ANALYSE, np.zeros((matrix.shape[0], 1)))
        # In KiB: peak of the analysis, what it keeps, and what the rest takes beside that.
        peak, kept, rest = (1024 * int(self._solver.get_iparm(number)) for number in (15, 16, 17))
        self.peak_bytes, self.kept_bytes = max(peak, kept + rest), kept + rest

    def factorise(self) -> None:
        self._call(_FACTORISE, np.zeros((self._matrix.shape[0], 1)))

    def solve(self, rhs: FloatArray) -> FloatArray:
        return self._call(_SOLVE, np.asfortranarray(rhs))

    def _call(self, phase: int, rhs: FloatArray) -> FloatArray:
        # Its own `factorize` analyses in the same call, and its `solve` compares all of the matrix every time.
        self._solver.set_phase(phase)
        try:
            return np.asarray(self._solver._call_pardiso(self._matrix, rhs))
        except self._error as error:
            if error.value == _PARDISO_SINGULAR:
                raise np.linalg.LinAlgError(str(error)) from error
            raise _given_up(error, self._matrix.shape[0]) from error

    def __del__(self) -> None:
        if solver := getattr(self, "_solver", None):  # the library keeps its factors until told
            solver.free_memory(everything=True)


class SuperLU:
    """LU by SciPy's SuperLU with a fill-reducing ordering of the symmetric pattern and diagonal pivots."""

    name = "SuperLU"

    def __init__(self, matrix: sp.csr_matrix) -> None:
        self._columns = matrix.tocsc()
        self.peak_bytes = self.kept_bytes = round(_SUPERLU_BYTES * matrix.shape[0] ** _SUPERLU_POWER)
        self._factors: Any = None

    def factorise(self) -> None:
        from scipy.sparse.linalg import splu

        try:
            self._factors = splu(
                self._columns,
                permc_spec="MMD_AT_PLUS_A",
                diag_pivot_thresh=0.0,
                options={"SymmetricMode": True},
            )
        except RuntimeError as error:  # "Factor is exactly singular"
            raise np.linalg.LinAlgError(str(error)) from error
        del self._columns

    def solve(self, rhs: FloatArray) -> FloatArray:
        return np.asarray(self._factors.solve(rhs))


def _given_up(error: Exception, unknowns: int) -> PhysicsError:
    return PhysicsError(f"{error} while factorising {unknowns:,} unknowns", hint="run Nastran on the written deck")
