"""A reduced structure at its interface grids: stiffness, thermal loads of its areas, recovery of grids inside.

With the motions a of the interface grids, and w kelvin on the areas, nodal forces on the interface are K a - P w, and
grids inside move by u = G a + U w (static condensation: R. J. Guyan, AIAA Journal 3, 1965, p. 380, with loads). What
the matrices say is exact for linear statics.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tedm_cli.arrays import FloatArray, IntArray
from tedm_cli.errors import InputError
from tedm_cli.fem.constraints import rigid_body_matrix, to_displacement_frames

# What six digits leave of a symmetric matrix and of an eigenvalue of zero, of a matrix scaled to a unit diagonal.
_SYMMETRY, _NEGATIVE = 1e-6, 1e-6
_RIGID = 1e-5  # strain energy of a rigid motion, over that of the diagonal
_FOLLOWS = 1e-4  # of the motion of recovered grids under a rigid motion


@dataclass(frozen=True, eq=False, kw_only=True)
class ReducedMatrices:
    """Matrices over the six freedoms of each of b interface grids, then over n internal ones; in any one system of
    units, along and about the axes of the interface grids' displacement frames.

    Attributes
    ----------
    stiffness : [6 b + n, 6 b + n].
    loads : [6 b + n, k], per kelvin on each of k areas.
    recovery : [6 r, 6 b + n], six motions of each of r grids, in the frame of the positions.
    thermal_recovery : [6 r, k], what is added to them per kelvin on each area.
    """

    stiffness: FloatArray
    loads: FloatArray
    recovery: FloatArray
    thermal_recovery: FloatArray

    def without_internal(self, boundary: int) -> ReducedMatrices:
        """The same with all freedoms after the first `boundary` ones eliminated, which no force is on.

        Raises
        ------
        InputError
            If the stiffness does not hold the internal freedoms.
        """
        k, n = self.stiffness, len(self.stiffness) - boundary
        if n == 0:
            return self
        own = k[boundary:, boundary:]
        scale = np.sqrt(np.abs(np.diagonal(own)))
        if not scale.all() or np.linalg.cond(own / np.outer(scale, scale)) > 1e14:
            raise InputError(
                f"the stiffness does not hold its {n} internal freedoms, so they cannot be eliminated",
                hint="leave out those without stiffness",
            )
        solved = np.linalg.solve(own, np.hstack([k[boundary:, :boundary], self.loads[boundary:]]))
        by_motion, by_load = solved[:, :boundary], solved[:, boundary:]
        inside = self.recovery[:, boundary:]
        return ReducedMatrices(
            stiffness=k[:boundary, :boundary] - k[:boundary, boundary:] @ by_motion,
            loads=self.loads[:boundary] - k[:boundary, boundary:] @ by_load,
            recovery=self.recovery[:, :boundary] - inside @ by_motion,
            thermal_recovery=self.thermal_recovery + inside @ by_load,
        )

    def in_metres(self, length_m: float) -> tuple[FloatArray, FloatArray]:
        """Recovery and thermal recovery with motions in m and rad, of matrices whose unit of length is `length_m`."""
        size = [length_m] * 3 + [1.0] * 3
        rows, columns = (np.tile(size, n // 6)[:, None] for n in self.recovery.shape)
        return rows * self.recovery / columns.T, rows * self.thermal_recovery


def require_stiffness(stiffness: FloatArray) -> None:
    """Refuse a matrix [m, m] that is no stiffness.

    Raises
    ------
    InputError
        If it is not symmetric or has a negative eigenvalue.
    """
    diagonal = np.abs(np.diagonal(stiffness))
    scale = np.sqrt(np.where(diagonal > 0.0, diagonal, 1.0))
    scaled = stiffness / np.outer(scale, scale)
    skew = np.abs(scaled - scaled.T)
    if skew.max(initial=0.0) > _SYMMETRY:
        row, column = np.unravel_index(int(skew.argmax()), skew.shape)
        raise InputError(
            f"the stiffness is not symmetric: row {row + 1}, column {column + 1} has {stiffness[row, column]:.6g}, and"
            f" row {column + 1}, column {row + 1} {stiffness[column, row]:.6g}",
            hint="is it the whole matrix, and not one triangle of it?",
        )
    values = np.linalg.eigvalsh((scaled + scaled.T) / 2.0)
    if values.size and values[0] < -_NEGATIVE * max(values[-1], 1.0):
        raise InputError(
            f"the stiffness has a negative eigenvalue: {values[0]:.2g} of the largest {values[-1]:.2g}, both of the"
            " matrix scaled to a unit diagonal",
            hint="are rows and columns in one order, and is it the stiffness?",
        )


def made_free(
    matrices: ReducedMatrices,
    position: FloatArray,
    frame: FloatArray | None,
    recovered_id: IntArray,
    recovered: FloatArray,
) -> ReducedMatrices:
    """Condensed matrices of a structure that nothing outside of it acts on, refused where something does.

    What their digits leave of forces under rigid motions is taken away, and recovered grids follow these exactly.

    Parameters
    ----------
    position : [b, 3], of the interface grids; `frame` [b, 3, 3], unit vectors of their displacement frames (columns).
    recovered_id : [r], ids for messages. recovered : [r, 3], positions.

    Raises
    ------
    InputError
        If a rigid motion of the interface needs forces, if the thermal loads have a resultant, or if recovered grids do
        not follow a rigid motion.
    """
    middle = position.mean(axis=0)
    size = float(np.linalg.norm(position - middle, axis=1).max()) or 1.0
    turn = to_displacement_frames(frame, np.arange(len(position)))
    rigid = (turn @ rigid_body_matrix(position - middle)).reshape(-1, 6)
    rigid[:, 3:] /= size
    lengths = np.tile([1.0] * 3 + [1.0 / size] * 3, len(position))  # of freedoms, that rotations count as motions
    k = matrices.stiffness
    work = np.einsum("di,de,ei->i", rigid, k, rigid)
    most = np.einsum("di,d,di->i", rigid, np.abs(np.diagonal(k)), rigid)
    share = np.abs(np.divide(work, most, out=np.zeros(6), where=most > 0.0))
    if share.max() > _RIGID:
        name = ("translation x", "translation y", "translation z", "rotation x", "rotation y", "rotation z")
        raise InputError(
            f"the stiffness resists a rigid motion: strain energy under {name[int(share.argmax())]} is"
            f" {share.max():.2g} of that of its diagonal ({int((share > _RIGID).sum())} of 6 motions)",
            hint="are the interface grids in the order of the matrix, where they are in the deck, and in its units?"
            " set grounded = true if the reduced structure is held by itself",
        )
    force = np.abs(rigid.T @ matrices.loads)
    each = np.abs(rigid.T) @ np.abs(matrices.loads)
    out = np.divide(force, each, out=np.zeros_like(force), where=each > 0.0)
    if out.max(initial=0.0) > _FOLLOWS:
        raise InputError(
            f"the thermal load of column {int(out.max(axis=0).argmax()) + 1} has a resultant ({out.max():.2g} of its"
            " forces), and temperature makes none",
            hint="are the rows of the loads in the order of the stiffness?",
        )
    arms = rigid_body_matrix(recovered - middle).reshape(-1, 6)
    arms[:, 3:] /= size
    gap = np.abs(matrices.recovery @ rigid - arms).reshape(-1, 36)
    if gap.max(initial=0.0) > _FOLLOWS * max(1.0, float(np.abs(arms).max(initial=0.0))):
        worst = int(gap.max(axis=1).argmax())
        raise InputError(
            f"the recovery of grid {recovered_id[worst]} does not follow a rigid motion of the interface (off by"
            f" {gap.max():.2g} of it)",
            hint="are its rows missing or in another order, or is it elsewhere than the list of masses says?",
        )
    inverse = np.linalg.pinv(rigid / lengths[:, None]) / lengths
    without = np.eye(len(k)) - rigid @ inverse
    return ReducedMatrices(
        stiffness=without.T @ k @ without,
        loads=without.T @ matrices.loads,
        recovery=matrices.recovery @ without + arms @ inverse,
        thermal_recovery=matrices.thermal_recovery,
    )
