"""Which of the assumed correlations is most like the one that a thermal network gives."""

from __future__ import annotations

import numpy as np

from tedm_cli.arrays import AnyArray, IndexArray
from tedm_cli.noise.bounds import matrix_at
from tedm_cli.noise.correlation import Correlation


def deviation(coherence: AnyArray, area: IndexArray, assumed: Correlation, frequency_hz: float) -> float:
    """Root mean square of |C_ij - R_ij| over all pairs of nodes; NaN where the assumed case silences one of them.

    Amplitudes have no part in it. Nodes of one area have the correlation 1 in the assumed case.

    Parameters
    ----------
    coherence : C [n, n], correlation of the nodes at the frequency, complex.
    area : [n], the area that each node is in, columns of the assumed case.
    """
    one, other = np.triu_indices(len(area), 1)
    if not assumed.active[area].all() or not one.size:
        return float("nan")
    matrix = matrix_at(assumed.matrix().astype(np.complex128), assumed.delay_s, frequency_hz)
    of_nodes = matrix[np.ix_(area, area)]
    difference = (coherence - of_nodes)[one, other]
    return float(np.sqrt(np.mean(difference.real**2 + difference.imag**2)))
