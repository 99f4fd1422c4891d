"""The part of the benches' motion that is rigid, apart from their distortion.

A bench that moves as one against the test masses is read as the opposite motion of the test masses: the bench really
moves, and the optics make no error. What is left once that is taken off is the distortion of the optical path. Benches
without a beam between them move each by themselves.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tedm_cli.arrays import FloatArray
from tedm_cli.optics.benches import benches
from tedm_cli.optics.layout import N_MOTIONS, OpticalLayout
from tedm_cli.optics.sensitivity import cross_matrix


@dataclass(frozen=True, eq=False)
class CommonMode:
    """Rigid motion of each bench per thermal area.

    `benches`: their names. `amplitude` [6 * n_benches, k] (m/K, rad/K): translation of the points `about`
    [n_benches, 3] (m) and rotation, layout frame. `motion` [6 * n_elements, k]: the motion of every element that
    follows, zero for the test masses.
    """

    benches: tuple[str, ...]
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
    """The rigid motion of each bench nearest to the elements' motions `motion` [6 * n_elements, k] (m/K, rad/K).

    In the layout frame. Least squares over the translations and rotations of all elements of a bench alike, a rotation
    counting as the translation that it makes at the rms distance of the elements from their mean position. Windows are
    not asked: they ride on the inertial sensors, and parallel to their test mass they are not read. A bench of windows
    alone asks them.

    Parameters
    ----------
    node_positions_m : as for `rigid_motion`.
    """
    pivots = layout.pivots_m(node_positions_m)
    members = benches(layout)
    amplitudes, centres = [], []
    followed = np.zeros_like(motion)
    for elements in members.values():
        asked = [e for e in elements if e.kind != "window"] or list(elements)
        points = pivots[[layout.index(e.name) for e in asked]]
        about = points.mean(axis=0)
        lever = float(np.sqrt(np.mean(np.sum((points - about) ** 2, axis=1)))) or 1.0
        modes = rigid_motion(layout, node_positions_m, about_m=about)
        rows = layout.columns_of(tuple(asked))
        weight = np.tile([1.0] * 3 + [lever] * 3, len(asked))[:, None]
        unit = np.array([lever] * 3 + [1.0] * 3)  # columns of like size: the fit is well conditioned at any scale
        fitted = np.linalg.lstsq(weight * modes[rows] * unit, weight * motion[rows], rcond=None)[0]
        amplitudes.append(unit[:, None] * fitted)
        centres.append(about)
        bench = layout.columns_of(elements)
        followed[bench] = modes[bench] @ amplitudes[-1]
    return CommonMode(tuple(members), np.concatenate(amplitudes), np.array(centres), followed)
