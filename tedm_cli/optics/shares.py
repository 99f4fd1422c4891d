"""What each element, degree of freedom, beam and thermal area carries of a read-out.

The motion of the elements reads as `gain @ motion`, the sum of `gain[r, m] * motion[m, j]` over the motions m. With
`gain = inverse P S_BW` it is the sum of one term per beam on a photodiode, too. What the glass of plates does to the
beams comes on top.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tedm_cli.arrays import FloatArray
from tedm_cli.optics.layout import N_OUTPUTS


def motion_terms(gain: FloatArray, motion: FloatArray) -> FloatArray:
    """Terms [n_dof, n_motions, k] of the read-out by motions; their sum over the second axis is N without plates.

    Parameters
    ----------
    gain : [n_dof, n_motions] (m, rad by m, rad).
    motion : [n_motions, k] (m/K, rad/K).
    """
    return np.asarray(gain[:, :, None] * motion)


def beam_terms(inverse: FloatArray, P: FloatArray, outputs: FloatArray) -> FloatArray:
    """Terms [n_dof, n_paths, k] of the read-out by the beam that carries them; their sum over the paths is N.

    Parameters
    ----------
    inverse : [n_dof, 3 * n_pd], zero for photodiodes out of the set.
    P : [3 * n_pd, 5 * n_paths].
    outputs : of the beams, [5 * n_paths, k] (m/K, rad/K): S_BW motion, with what the plates do.
    """
    by_beam = outputs.reshape(-1, N_OUTPUTS, outputs.shape[1])
    law = (inverse @ P).reshape(len(inverse), -1, N_OUTPUTS)
    return np.asarray(np.einsum("rpo,pok->rpk", law, by_beam))


def shares(terms: FloatArray, total: FloatArray) -> FloatArray:
    """Signed shares [n_terms] of the terms [n_terms, k] in their sum `total` [k] over the areas; they sum to 1.

    With one area the term over the sum. With several, `sum_j terms_j total_j / sum_j total_j^2`: the share of the
    variance when the areas' temperatures fluctuate alike and independently. Without any read-out
    the shares are zero.
    """
    power = float(total @ total)
    if power == 0.0:
        return np.zeros(len(terms))
    return np.asarray(terms @ total / power)


@dataclass(frozen=True, eq=False)
class SetComparison:
    """Two redundant sets, per read-out [n_dof] each.

    Amplitudes (m/K, rad/K) are roots of the sum of squares over the areas: what areas that fluctuate alike and
    independently make. `mean` is that of the mean of the two sets; `best` of `weight * first + (1 - weight) * second`
    with the weight between 0 and 1 that makes it least: sets that hardly differ could be played off against each other
    with large weights of opposite sign, but these would amplify the photodiodes' own noise as much. `difference`
    [n_dof, k] is N of the first minus N of the second.
    """

    first: str
    second: str
    difference: FloatArray
    amplitudes: tuple[FloatArray, FloatArray]
    mean: FloatArray
    best: FloatArray
    weight: FloatArray

    @property
    def relative(self) -> FloatArray:
        """Amplitude of the difference over the larger one of the two sets, [n_dof]."""
        larger = np.maximum(*self.amplitudes)
        return np.asarray(_amplitude(self.difference) / np.where(larger > 0, larger, 1.0))


#: Sets whose relative difference is below this read the same: what is left is rounding.
SAME = 1e-9


def compare_sets(first: str, N_first: FloatArray, second: str, N_second: FloatArray) -> SetComparison:
    """What the set `second` adds to the set `first`, from their read-outs [n_dof, k] (m/K, rad/K)."""
    difference = N_first - N_second
    squared = np.sum(difference**2, axis=1)
    # minimum over w of |N_second + w difference|^2; sets that agree leave the weight open, and half is as good as any
    weight = np.full(len(difference), 0.5)
    apart = _amplitude(difference) > SAME * _amplitude(N_second)
    weight[apart] = np.clip(-np.sum(N_second * difference, axis=1)[apart] / squared[apart], 0.0, 1.0)
    return SetComparison(
        first,
        second,
        difference,
        (_amplitude(N_first), _amplitude(N_second)),
        _amplitude((N_first + N_second) / 2),
        _amplitude(N_second + weight[:, None] * difference),
        weight,
    )


def _amplitude(N: FloatArray) -> FloatArray:
    return np.asarray(np.sqrt(np.sum(N**2, axis=1)))
