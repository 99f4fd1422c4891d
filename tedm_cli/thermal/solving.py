"""Sparse factorisation of conductance matrices."""

from __future__ import annotations

from typing import Any

import scipy


def factorised(matrix: scipy.sparse.csc_array) -> Any:
    """LU of K + 2πi f C or of K [n, n], as SciPy's SuperLU.

    Pivots stay on the diagonal: every column is diagonally dominant, by the heat that a node gives off and its
    neighbours take up, and a capacity only adds to its diagonal. So the order of elimination follows the pattern alone.
    """
    return scipy.sparse.linalg.splu(
        matrix, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True}
    )
