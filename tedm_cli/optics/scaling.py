"""The size of a bench, and S_BW without units: metres counted in bench sizes, so that all entries compare."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.distance import pdist

from tedm_cli.optics.labels import input_labels, output_labels
from tedm_cli.optics.layout import OpticalLayout

Array = NDArray[np.float64]


def bench_size_m(layout: OpticalLayout) -> float:
    """Largest distance between the reference points of two elements, m."""
    return float(pdist(layout.refs_m).max())


def dimensionless(S_BW: Array, layout: OpticalLayout) -> Array:
    """S_BW with all lengths, of outputs and of motions, in units of the bench size L.

    Entries in m/m and rad/rad stay, those in m/rad are divided by L, those in rad/m multiplied by it.
    """
    size = bench_size_m(layout)
    output, motion = (
        np.array([size if unit == "m" else 1.0 for unit in labels(layout).units])
        for labels in (output_labels, input_labels)
    )
    return np.asarray(S_BW * motion / output[:, None])
