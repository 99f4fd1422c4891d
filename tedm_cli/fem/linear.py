"""Direct solution of sparse symmetric systems: which library, whether its factors fit into memory, and the factors."""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np
import scipy.sparse as sp

from tedm_cli.errors import MemoryShortError, UsageError
from tedm_cli.fem.factors import Empty, Factorisation, Factors, Mumps, Pardiso, Rslab, SuperLU
from tedm_cli.memory import available_bytes

SolverName = Literal["auto", "rslab", "mumps", "pardiso", "superlu"]
SOLVER_VARIABLE = "TEDM_SOLVER"

# In the order in which `auto` tries them.
_LIBRARIES: dict[str, type[Rslab | Mumps | Pardiso | SuperLU]] = {
    "rslab": Rslab,
    "mumps": Mumps,
    "pardiso": Pardiso,
    "superlu": SuperLU,
}
# How a library that does not come with this package is got.
_INSTALL = {
    "mumps": "pip install python-mumps==0.0.2 (Python 3.11 on Linux only)",
    "pardiso": "pip install pypardiso",
    "rslab": "pip install rslab",
}


@dataclass(frozen=True, kw_only=True)
class MemoryNeed:
    """What factorising takes, before it begins.

    Attributes
    ----------
    solver : the library.
    unknowns : number.
    needed_bytes : largest memory that is taken beside what the process holds already.
    available_bytes : what is left to the process; None where the system does not tell.
    """

    solver: str
    unknowns: int
    needed_bytes: int
    available_bytes: int | None

    def __str__(self) -> str:
        left = "" if self.available_bytes is None else f" of {_gigabytes(self.available_bytes)} that are left"
        return f"{self.solver}: {self.unknowns:,} unknowns need {_gigabytes(self.needed_bytes)}{left}"


def factorise(
    matrix: sp.csr_matrix,
    solver: SolverName = "auto",
    *,
    beside_bytes: int = 0,
    told: Callable[[MemoryNeed], None] | None = None,
) -> Factorisation:
    """Factorise a symmetric matrix once for many right-hand sides.

    Parameters
    ----------
    matrix : sparse [n, n], symmetric, both triangles stored.
    solver : "rslab", "mumps", "pardiso", "superlu", or "auto": the one that the environment variable TEDM_SOLVER names,
        else the first of these that is installed (SuperLU is SciPy's).
    beside_bytes : memory that will be needed beside the factors.
    told : called with what memory is needed, between analysis and factorisation.

    Raises
    ------
    numpy.linalg.LinAlgError
        If elimination meets a zero pivot.
    MemoryShortError
        If more memory is needed than is left.
    PhysicsError
        If the library gives up.
    UsageError
        If a library is asked for by name that does not exist or is not installed.
    """
    if matrix.shape[0] == 0:
        return Empty()
    factors = _analysed(matrix, solver)
    need = MemoryNeed(
        solver=factors.name,
        unknowns=matrix.shape[0],
        needed_bytes=max(factors.peak_bytes, factors.kept_bytes + beside_bytes),
        available_bytes=available_bytes(),
    )
    if told is not None:
        told(need)
    if need.available_bytes is not None and need.needed_bytes > need.available_bytes:
        raise MemoryShortError(
            str(need).replace(" that are left", ", which is what is left"),
            hint="let your own Nastran solve the deck (`tedm write-deck`), or that of the adjoint, with a load case for"
            " each output instead of each area (`tedm write-deck --adjoint`); or condense a part to a superelement"
            " (`tedm reduce`); or mesh more coarsely; or end what else holds memory",
        )
    factors.factorise()
    return factors


def _analysed(matrix: sp.csr_matrix, solver: str) -> Factors:
    where = ""
    if solver == "auto":
        solver = os.environ.get(SOLVER_VARIABLE, "auto")
        where = f"environment, {SOLVER_VARIABLE}"
    if solver not in ("auto", *_LIBRARIES):
        raise UsageError(
            f"there is no solver {solver!r}", where=where, hint="choose one of auto, " + ", ".join(_LIBRARIES)
        )
    for name, library in _LIBRARIES.items():
        if solver in ("auto", name):
            try:
                return library(matrix)
            except ImportError as error:
                if solver != name:
                    continue
                missing = isinstance(error, ModuleNotFoundError)
                fact = f"the solver {library.name} " + ("is not installed" if missing else f"cannot be used: {error}")
                hint = f"{_INSTALL[name]}, or choose another: auto, superlu"
                raise UsageError(fact, where=where, hint=hint) from error
    raise AssertionError("SuperLU is SciPy's, which is always there")


def _gigabytes(size: int) -> str:
    return f"{size / 1e9:.1f} GB" if size >= 50_000_000 else f"{size / 1e6:.0f} MB"


def block_bytes(unknowns: int, grids: int, columns: int) -> int:
    """Arrays of `columns` right-hand sides while they are solved: of the unknowns and of all degrees of freedom."""
    return np.dtype(float).itemsize * columns * (4 * unknowns + 12 * grids)
