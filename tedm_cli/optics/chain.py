"""From the optical sensitivity matrix to the read-out noise per thermal area (Montemurro 2004, eqs. 10.3 to 10.11).

The read-out is calibrated with the undistorted bench, so a distortion appears as `n = O^-1 D`: a rigid motion of
the bench with the test masses at rest reads as minus that motion.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tedm_cli.errors import InputError, PhysicsError
from tedm_cli.optics.labels import read_out_labels
from tedm_cli.optics.layout import N_LASER, N_MOTIONS, N_OUTPUTS, OpticalLayout
from tedm_cli.optics.sensitivity import check_shape

Matrix = NDArray[np.float64]

#: Singular values up to this fraction of the largest one count as zero; tolerates matrices printed with seven digits.
RANK_TOLERANCE = 1e-6
_LOST = 0.01  # share of a degree of freedom inside the null space from which it is named as lost


@dataclass(frozen=True, eq=False)
class ReadOutInverse:
    """Law of one set on the measured degrees of freedom, and its (least-squares) inverse.

    `O` [3 * n_pd, n_dof] (m, rad by m, rad), `inverse` [n_dof, 3 * n_pd], `condition` in the 2-norm of those units.
    """

    O: Matrix  # noqa: E741 - the matrix has this name in the field
    inverse: Matrix
    singular_values: Matrix
    condition: float


@dataclass(frozen=True, eq=False)
class SetReadOut:
    """Read-out of one set: its law, the read-out per bench motion and per thermal area.

    `gain` [n_dof, 6 * n_bench] (m, rad by m, rad; bench elements in layout order, layout frame), `N` [n_dof, k] (m/K,
    rad/K).
    """

    name: str
    photodiodes: tuple[str, ...]
    law: ReadOutInverse
    gain: Matrix
    N: Matrix


@dataclass(frozen=True, eq=False)
class OpticsChain:
    """All matrices of the optical chain.

    `P` [3 * n_pd, 5 * n_paths]; `O_ideal` [3 * n_pd, 6 * n_tm] with its `singular_values` and `rank`; `D` [3 * n_pd, k]
    (m/K, rad/K); one `SetReadOut` per set.
    """

    P: Matrix
    O_ideal: Matrix
    singular_values: Matrix
    rank: int
    D: Matrix
    sets: tuple[SetReadOut, ...]


def law_matrix(layout: OpticalLayout, *, curved: bool = True) -> Matrix:
    """P, [3 * n_pd, 5 * n_paths]: OPD (m), WFT1, WFT2 (rad) of each photodiode as measurement minus reference beam.

    A beam with wave-front radius Rc at the photodiode contributes the slope at the photodiode's centre, `z - x / Rc`.
    `curved=False` takes all beams as plane.
    """
    matrix = np.zeros((N_LASER * len(layout.photodiodes), N_OUTPUTS * len(layout.paths)))
    for path in layout.paths:
        sign = 1.0 if path.beam == "meas" else -1.0
        curvature = 1.0 / path.wavefront_radius_m if curved and path.wavefront_radius_m else 0.0
        first = N_LASER * layout.photodiodes.index(path.photodiode)
        matrix[first : first + N_LASER, layout.rows(path)] = sign * np.array(
            [[0, 0, 1, 0, 0], [-curvature, 0, 0, 1, 0], [0, -curvature, 0, 0, 1]]
        )
    return matrix


def read_out_inverse(layout: OpticalLayout, set_name: str, PS: Matrix) -> ReadOutInverse:
    """Law of the set `set_name` on the measured degrees of freedom, and its inverse.

    Parameters
    ----------
    PS : P S_BW, [3 * n_pd, 6 * n_elements].

    Raises
    ------
    PhysicsError : the set cannot tell all measured degrees of freedom apart; those lost are named.
    """
    law = PS[np.ix_(layout.laser_rows(layout.sets[set_name]), layout.read_out_columns)]
    left, found, right = np.linalg.svd(law, full_matrices=True)
    n_dof = law.shape[1]
    values = np.zeros(n_dof)
    values[: found.size] = found
    lost = values <= RANK_TOLERANCE * values[0]
    if lost.any():
        share = np.sum(right[lost] ** 2, axis=0)
        names = [name for name, s in zip(read_out_labels(layout).names, share, strict=True) if s > _LOST]
        raise PhysicsError(
            f"the read-out matrix has rank {n_dof - np.count_nonzero(lost)} for {n_dof} degrees of freedom; "
            f"lost: {', '.join(names)}",
            where=f"read-out set {set_name} ({', '.join(layout.sets[set_name])})",
            hint="give the set a photodiode of every interferometer, or measure fewer degrees of freedom",
        )
    inverse = right.T @ (left[:, :n_dof].T / values[:, None])
    return ReadOutInverse(law, inverse, values, float(values[0] / values[-1]))


def optics_chain(layout: OpticalLayout, S_BW: Matrix, D_opt: Matrix) -> OpticsChain:
    """Optical chain for all read-out sets.

    Parameters
    ----------
    S_BW : [5 * n_paths, 6 * n_elements], layout frame; its rotations must be about the points that `D_opt` moves (see
        `move_reference_points`).
    D_opt : motion of the bench elements in layout order per thermal area, [k, n_bench, 6] in m/K and rad/K, basic
        frame.

    Raises
    ------
    InputError : an array does not fit the layout or is not finite.
    PhysicsError : the read-out matrix of a set is singular.
    """
    check_shape(S_BW, layout)
    n_bench = len(layout.bench)
    if D_opt.ndim != 3 or D_opt.shape[1:] != (n_bench, N_MOTIONS) or not np.isfinite(D_opt).all():
        raise InputError(
            f"element motions have shape {D_opt.shape}; finite values [k, {n_bench}, {N_MOTIONS}] are needed",
            where="D_opt",
        )
    k = D_opt.shape[0]
    motion = _in_layout_frame(layout, D_opt).reshape(k, n_bench * N_MOTIONS).T

    P = law_matrix(layout)
    PS = P @ S_BW
    PS_bench = PS[:, layout.columns_of(layout.bench)]
    O_ideal = PS[:, layout.columns_of(layout.test_masses)]
    values = np.linalg.svd(O_ideal, compute_uv=False)
    sets = []
    for name, photodiodes in layout.sets.items():
        law = read_out_inverse(layout, name, PS)
        gain = law.inverse @ PS_bench[layout.laser_rows(photodiodes)]
        sets.append(SetReadOut(name, photodiodes, law, gain, gain @ motion))
    rank = int(np.count_nonzero(values > RANK_TOLERANCE * values[0]))
    return OpticsChain(P, O_ideal, values, rank, PS_bench @ motion, tuple(sets))


def noise_by_element(layout: OpticalLayout, read_out: SetReadOut, D_opt: Matrix) -> Matrix:
    """Part of `read_out.N` by the motion of each bench element, [n_bench, n_dof, k]; their sum is N.

    `D_opt` as in `optics_chain`.
    """
    k, n_bench = D_opt.shape[:2]
    motion = _in_layout_frame(layout, D_opt).reshape(k, n_bench, N_MOTIONS)
    gain = read_out.gain.reshape(len(read_out.gain), n_bench, N_MOTIONS)
    parts: Matrix = np.einsum("dem,kem->edk", gain, motion)
    return parts


def _in_layout_frame(layout: OpticalLayout, D_opt: Matrix) -> Matrix:
    """Translations and rotations [k, n_bench, 2, 3] along the axes of the layout."""
    turned: Matrix = D_opt.reshape(*D_opt.shape[:2], 2, 3) @ layout.axes.T
    return turned
