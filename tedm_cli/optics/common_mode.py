"""The part of the bench's motion that is rigid, apart from the distortion of the bench.

A bench that moves as one against the test masses is read as the opposite motion of the test masses: the bench really
moves, and the optics make no error. What is left once that is taken off is the distortion of the optical path.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tedm_cli.arrays import FloatArray
from tedm_cli.optics.layout import N_MOTIONS, OpticalLayout
from tedm_cli.optics.sensitivity import cross_matrix


@dataclass(frozen=True, eq=False)
class CommonMode:
    """Rigid motion of the bench per thermal area.

    `amplitude` [6, k] (m/K, rad/K): translation of the point `about` [3] (m) and rotation, layout frame. `motion`
    [6 * n_elements, k]: the motion of every element that follows, zero for the test masses.
    """

    amplitude: FloatArray
    about: FloatArray
    motion: FloatArray


def rigid_motion(
    layout: OpticalLayout, node_positions_m: FloatArray | None = None, *, about_m: FloatArray | None = None
) -> FloatArray:
    """Motions of all elements under the six rigid motions about a point, [6 * n_elements, 6].

    Columns: translations along, then rotations about, the layout axes. The point `about_m` [3] (m, layout frame) is the
    mean of the reference points unless given.

    Parameters
    ----------
    node_positions_m : points the bench elements' rotations are about, [n_bench, 3] m, basic frame, layout order; None
        for the layout's reference points.
    """
    centre = layout.refs_m.mean(axis=0) if about_m is None else about_m
    return rigid_motion_about(layout.pivots_m(node_positions_m), centre)


def rigid_motion_about(pivots_m: FloatArray, centre_m: FloatArray) -> FloatArray:
    """Motions of elements with pivots [n, 3] under the six rigid motions about `centre_m`, [6 * n, 6], same axes."""
    motion = np.zeros((len(pivots_m), N_MOTIONS, N_MOTIONS))
    motion[:, :3, :3] = np.eye(3)
    motion[:, 3:, 3:] = np.eye(3)
    motion[:, :3, 3:] = -cross_matrix(pivots_m - centre_m)
    return motion.reshape(-1, N_MOTIONS)


def common_mode(layout: OpticalLayout, motion: FloatArray, node_positions_m: FloatArray | None = None) -> CommonMode:
    """The rigid motion nearest to the elements' motions `motion` [6 * n_elements, k] (m/K, rad/K, layout frame).

    Least squares over the translations and rotations of all bench elements alike, a rotation counting as the
    translation that it makes at the rms distance of the elements from their mean position. Windows are not asked: they
    ride on the inertial sensors, and parallel to their test mass they are not read.

    Parameters
    ----------
    node_positions_m : as for `rigid_motion`.
    """
    asked = [e for e in layout.bench if e.kind != "window"]
    points = layout.pivots_m(node_positions_m)[[layout.index(e.name) for e in asked]]
    about = points.mean(axis=0)
    lever = float(np.sqrt(np.mean(np.sum((points - about) ** 2, axis=1))))
    modes = rigid_motion(layout, node_positions_m, about_m=about)
    rows = layout.columns_of(tuple(asked))
    weight = np.tile([1.0] * 3 + [lever] * 3, len(asked))[:, None]
    unit = np.array([lever] * 3 + [1.0] * 3)  # columns of like size, so that the fit is well conditioned at any scale
    fitted = np.linalg.lstsq(weight * modes[rows] * unit, weight * motion[rows], rcond=None)[0]
    amplitude = unit[:, None] * fitted
    followed = np.zeros_like(motion)
    bench = layout.columns_of(layout.bench)
    followed[bench] = modes[bench] @ amplitude
    return CommonMode(amplitude, about, followed)
