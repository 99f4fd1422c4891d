"""Which motion of which element makes a read-out: the product `gain @ motion` before its sum is taken.

With the read-out of a set `n = O^-1 P S_BW m` (Montemurro 2004, eqs. 10.3 to 10.11), `gain` is `O^-1 P S_BW` on the
columns of the bench and m the motion of its elements; every term of that product belongs to one degree of freedom of
one element.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tedm_cli.errors import InputError
from tedm_cli.optics.layout import N_MOTIONS

Array = NDArray[np.float64]


def element_shares(gain: Array, motion: Array) -> Array:
    """Contribution of each degree of freedom of each element, [k, n_dof, n_bench, 6]; its sum over both is N.T.

    Parameters
    ----------
    gain : read-out per element motion, [n_dof, 6 * n_bench] (m, rad by m, rad).
    motion : of the bench elements in the frame and about the points of `gain`, [k, n_bench, 6] (m, rad; or per kelvin).

    Raises
    ------
    InputError : the arrays do not fit each other.
    """
    if motion.ndim != 3 or motion.shape[2] != N_MOTIONS or gain.shape[1:] != (motion.shape[1] * N_MOTIONS,):
        raise InputError(
            f"motions {motion.shape} do not fit a gain {gain.shape}; [k, n, 6] and [n_dof, 6 n] are needed",
            where="element shares",
        )
    by_element = gain.reshape(len(gain), motion.shape[1], N_MOTIONS)
    return np.asarray(by_element[None] * motion[:, None])
