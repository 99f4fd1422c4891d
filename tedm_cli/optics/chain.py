"""From the optical sensitivity matrix to the read-out noise per thermal area (Montemurro 2004, eqs. 10.3 to 10.11).

The read-out is calibrated with the undistorted bench, so a distortion appears as `n = O^-1 D`: a rigid motion of
the bench with the test masses at rest reads as minus that motion.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tedm_cli.arrays import FloatArray
from tedm_cli.errors import InputError
from tedm_cli.optics.common_mode import CommonMode, common_mode
from tedm_cli.optics.law import law_matrix
from tedm_cli.optics.layout import N_MOTIONS, OpticalLayout
from tedm_cli.optics.plates import PlateEffect
from tedm_cli.optics.read_out import RANK_TOLERANCE, ReadOutInverse, read_out_inverse
from tedm_cli.optics.sensitivity import check_shape


@dataclass(frozen=True, eq=False)
class SetReadOut:
    """Read-out of one set: its law, the read-out per motion of an element and per thermal area.

    `inverse` [n_dof, 3 * n_pd]: that of `law`, with zeros for the photodiodes of other sets, so that `N = inverse D`.
    `gain` [n_dof, 6 * n_elements] (m, rad by m, rad; layout order and frame), `N` [n_dof, k] (m/K, rad/K), of which
    `N_rigid` is each bench moving as one, `N_plates` the glass of plates that changes, and `N_distortion` the rest.
    """

    name: str
    photodiodes: tuple[str, ...]
    law: ReadOutInverse
    inverse: FloatArray
    gain: FloatArray
    N: FloatArray
    N_rigid: FloatArray
    N_plates: FloatArray

    @property
    def N_distortion(self) -> FloatArray:
        return self.N - self.N_plates - self.N_rigid


@dataclass(frozen=True, eq=False)
class OpticsChain:
    """All matrices of the optical chain.

    `P` [3 * n_pd, 5 * n_paths]; `O_ideal` [3 * n_pd, 6 * n_tm] by the motions of the test masses on their own axes,
    with its `singular_values` and `rank`; `motion` [6 * n_elements, k] of all elements in the layout frame, of a test
    mass that of its face; `D` [3 * n_pd, k] (m/K, rad/K); the rigid part of the motion; one `SetReadOut` per set.
    """

    P: FloatArray
    O_ideal: FloatArray
    singular_values: FloatArray
    rank: int
    motion: FloatArray
    D: FloatArray
    rigid: CommonMode
    sets: tuple[SetReadOut, ...]


def optics_chain(
    layout: OpticalLayout,
    S_BW: FloatArray,
    D_opt: FloatArray,
    node_positions_m: FloatArray | None = None,
    face_m: FloatArray | None = None,
    P: FloatArray | None = None,
    plates: PlateEffect | None = None,
) -> OpticsChain:
    """Optical chain for all read-out sets.

    Parameters
    ----------
    S_BW : [5 * n_paths, 6 * n_elements], layout frame; its rotations must be about the points that `D_opt` moves (see
        `move_reference_points`).
    D_opt : motion of the bench elements in layout order per thermal area, [k, n_bench, 6] in m/K and rad/K, basic
        frame.
    node_positions_m : the points that `D_opt` moves, [n_bench, 3] m, basic frame; None for the reference points.
    face_m : how far the face of each test mass moves along its normal, [n_tm, k] m/K (see `face_motion`); None: not.
    P : law [3 * n_pd, 5 * n_paths] in place of `law_matrix`.
    plates : those whose glass changes with temperature (see `plate_effect`); None: none do.

    Raises
    ------
    InputError : an array does not fit the layout or is not finite.
    PhysicsError : the read-out matrix of a set is singular, or a nominal ray misses.
    """
    check_shape(S_BW, layout)
    motion = element_motion(layout, D_opt, face_m)
    rigid = common_mode(layout, motion, node_positions_m)
    P = law_matrix(layout) if P is None else P
    PS = P @ S_BW
    O_ideal = PS @ layout.test_mass_motions
    values = np.linalg.svd(O_ideal, compute_uv=False)
    by_plates = np.zeros((len(P), motion.shape[1])) if plates is None else P @ plates.outputs
    sets = []
    for name, photodiodes in layout.sets.items():
        law = read_out_inverse(layout, name, PS)
        inverse = np.zeros((len(law.inverse), len(P)))
        inverse[:, layout.laser_rows(photodiodes)] = law.inverse
        gain = inverse @ PS
        N_plates = inverse @ by_plates
        N = gain @ motion + N_plates
        sets.append(SetReadOut(name, photodiodes, law, inverse, gain, N, gain @ rigid.motion, N_plates))
    rank = int(np.count_nonzero(values > RANK_TOLERANCE * values[0]))
    return OpticsChain(P, O_ideal, values, rank, motion, PS @ motion + by_plates, rigid, tuple(sets))


def element_motion(layout: OpticalLayout, D_opt: FloatArray, face_m: FloatArray | None = None) -> FloatArray:
    """Motions of all elements, [6 * n_elements, k] in the layout frame.

    A plane that moves along its normal reflects as if its body had moved, so a test mass that expands stands here with
    the motion of its face.
    """
    n_bench = len(layout.bench)
    if D_opt.ndim != 3 or D_opt.shape[1:] != (n_bench, N_MOTIONS) or not np.isfinite(D_opt).all():
        raise InputError(
            f"element motions have shape {D_opt.shape}; finite values [k, {n_bench}, {N_MOTIONS}] are needed",
            where="D_opt",
        )
    k = D_opt.shape[0]
    motion = np.zeros((N_MOTIONS * len(layout.elements), k))
    turned = (D_opt.reshape(k, n_bench, 2, 3) @ layout.axes.T).reshape(k, n_bench * N_MOTIONS)
    motion[layout.columns_of(layout.bench)] = turned.T
    if face_m is not None:
        shape = (len(layout.test_masses), k)
        if face_m.shape != shape or not np.isfinite(face_m).all():
            raise InputError(f"motions of the faces have shape {face_m.shape}; finite ones {shape} are needed")
        for mass, along in zip(layout.test_masses, face_m, strict=True):
            motion[layout.columns(mass.name)][:3] = np.outer(mass.normal, along)
    return motion
