"""Which thermal areas, and which paths, an output's noise comes from.

Area i takes the share h_i Σ_j R_ij h_j / S of the power S = Σ_ij h_i R_ij h_j: its own power where it is uncorrelated,
and a signed part of its block's where it is correlated. A negative share cancels others; those of an output sum to 1.
Where an output is a sum over paths, y = Σ_p y_p (the read-out over the optical elements that move), path p takes the
share Re(y_p y*) / S in the same way.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tedm_cli.arrays import AnyArray, FloatArray
from tedm_cli.noise.sources import AnyNoise


@dataclass(frozen=True, eq=False)
class ReadOutParts:
    """What a read-out [k] per kelvin is made of.

    Parameters
    ----------
    names : [p], optical elements that move, plates whose glass changes, and effects of the user's own; by_element :
        [p, k], what each makes of the read-out; their sum is it.
    distortion : [k], the read-out if the bench did not move as one: what the distortion and all else makes of it, NaN
        of areas of which that is not known; None of an acceleration, which has parts where there are effects of the
        user's own.
    """

    names: tuple[str, ...]
    by_element: FloatArray
    distortion: FloatArray | None

    def __sub__(self, other: ReadOutParts) -> ReadOutParts:
        """Of the difference of two read-outs of one bench."""
        rest = None if self.distortion is None or other.distortion is None else self.distortion - other.distortion
        return ReadOutParts(self.names, self.by_element - other.by_element, rest)


def area_shares(noise: AnyNoise) -> FloatArray:
    """Share [n_out, k] of each area in the PSD of each output at one frequency, or in its power over F of them."""
    power = noise.area_powers()
    total = power.sum(axis=1, keepdims=True)
    return np.divide(power, total, out=np.zeros_like(power), where=total > 0.0)  # zero for an output without any noise


def path_shares(paths: AnyNoise) -> FloatArray:
    """Share [p] of each path in the output that is the sum of the p `paths`, at one frequency or over F of them."""
    power = paths.path_powers()
    total = power.sum()
    return np.asarray(power / total) if total > 0.0 else np.zeros(len(power))


def share_weights(
    row: FloatArray, amplitude: FloatArray, correlation: AnyArray, delay_s: FloatArray, frequency_hz: float
) -> FloatArray:
    """Weights w [k] (K/√Hz over the unit of the output per √Hz) that turn any term of an output into its share.

    Where an output is a sum of terms, y = Σ_n y_n with rows r_n [k] per kelvin that add up to `row`, the share of a
    term in the PSD is Re(y_n y*) / S = r_n · w: linear, so that w is found once for any number of terms. All zero where
    there is no noise.

    Parameters
    ----------
    row : g [k], of the whole output; amplitude : A(f) [k], K/√Hz.
    correlation : R [k, k] before delays, real or complex; delay_s : [k].
    """
    phase = np.exp(-2j * np.pi * frequency_hz * delay_s)
    driven = amplitude * np.real(phase * (correlation @ (phase.conj() * row * amplitude)))
    power = float(row @ driven)
    return np.asarray(driven / power if power > 0.0 else np.zeros(len(row)))


def sum_by(values: FloatArray, labels: AnyArray) -> tuple[AnyArray, FloatArray]:
    """Sums of `values` [n_out, k] over areas of equal label [k] (group, shield, shape): labels [q], sums [n_out, q]."""
    names, index = np.unique(labels, return_inverse=True)
    sums: FloatArray = values @ np.eye(len(names))[index]
    return names, sums
