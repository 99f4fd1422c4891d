"""Sparse factorisation of conductance matrices."""

from __future__ import annotations

from typing import Any

import scipy

from tedm_cli.errors import PhysicsError


def factorised(matrix: scipy.sparse.csc_array) -> Any:
    """LU of K + 2πi f C or of K [n, n], as SciPy's SuperLU.

    Pivots stay on the diagonal: every column is diagonally dominant, by the heat that a node gives off and its
    neighbours take up, and a capacity only adds to its diagonal. So the order of elimination follows the pattern alone.
    """
    try:
        return scipy.sparse.linalg.splu(
            matrix, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True}
        )
    except RuntimeError:
        raise lost_in_rounding() from None


def lost_in_rounding() -> PhysicsError:
    """The error for conductances from which no temperatures follow in double precision."""
    return PhysicsError(
        "the conductances differ by so much that what leads to the boundaries is lost in rounding, or a node that only"
        " radiates is at 0 K",
        hint="make one node of those that a very large conductance holds together; give temperatures above 0 K",
    )
