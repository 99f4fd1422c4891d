"""The optics law P: from the outputs of the beams on the photodiodes to what a phase meter and its quadrants report.

Montemurro 2004, eq. 10.3, for photodiodes and wave fronts of any orientation and curvature.
"""

from __future__ import annotations

import numpy as np

from tedm_cli.arrays import FloatArray
from tedm_cli.optics.layout import N_LASER, N_OUTPUTS, BeamPath, OpticalLayout
from tedm_cli.optics.trace import trace

_ROUNDING = 1e-12  # nominal slopes (rad) and spots (m) this small are rounding of the trace, not geometry


def law_matrix(layout: OpticalLayout, *, curved: bool = True) -> FloatArray:
    """P, [3 * n_pd, 5 * n_paths]: OPD (m), WFT1, WFT2 (rad) of each photodiode as measurement minus reference beam.

    All are those of the phase front at a point q that is fixed to the photodiode: nominally the middle of its two
    spots, where the light is. A beam that meets the plane at s = (x, y) with the slopes z = (z1, z2) and the wave-front
    radius Rc has there, with C = 1 - z zᵀ and g = z - C (s - q) / Rc the gradient of its path on the plane,

        path(q) = opl - z.(s - q),    d path(q) = d opl - g.ds - (s - q).dz,    dg = dz - C ds / Rc

    to first order in s - q, which is zero where the beams meet. The path to the plane alone would count the motion of
    a spot on a tilted photodiode as length, tan(tilt) per metre, which the phase at a point of the detector does not.
    For beams on the normal that meet at the centre this is `OPD = opl`, `WFT = z - x / Rc`, each as a difference; a
    layout without geometry is taken to be such.

    Parameters
    ----------
    curved : False takes all beams as plane.

    Raises
    ------
    PhysicsError : a nominal ray misses an element.
    """
    nominal = np.zeros((len(layout.paths), N_OUTPUTS))
    if layout.has_geometry:
        nominal = np.asarray(trace(layout), dtype=np.float64)
        nominal[np.abs(nominal) < _ROUNDING] = 0.0
    matrix = np.zeros((N_LASER * len(layout.photodiodes), N_OUTPUTS * len(layout.paths)))
    for number, name in enumerate(layout.photodiodes):
        arriving = [i for i, path in enumerate(layout.paths) if path.photodiode == name]
        q = nominal[arriving, :2].mean(axis=0)
        for i in arriving:
            path = layout.paths[i]
            rows = slice(N_LASER * number, N_LASER * (number + 1))
            matrix[rows, layout.rows(path)] = _law(path, nominal[i, :2] - q, nominal[i, 3:], curved)
    return matrix


def _law(path: BeamPath, off: FloatArray, z: FloatArray, curved: bool) -> FloatArray:
    """Signed part [3, 5] of one beam that arrives `off` [2] m from the point q with slopes `z` [2]."""
    curvature = 1.0 / path.wavefront_radius_m if curved and path.wavefront_radius_m else 0.0
    by_spot = curvature * (np.eye(2) - np.outer(z, z))
    part = np.zeros((N_LASER, N_OUTPUTS))
    part[0, :2] = by_spot @ off - z
    part[0, 2] = 1.0
    part[0, 3:] = -off
    part[1:, :2] = -by_spot
    part[1:, 3:] = np.eye(2)
    return part if path.beam == "meas" else -part
