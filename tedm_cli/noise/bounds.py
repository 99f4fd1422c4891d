"""What any correlation between the thermal areas could do to an output, for given amplitudes.

With signed contributions h_i = g_i A_i of the active areas the power is S = Σ_ij h_i R_ij h_j*. Over all correlation
matrices R it runs from the smallest to the largest square of the vector sum of arrows of lengths |h_i|. Complex R
(delays) widens neither end: h is real, so S = h Re(R) hᵀ, and Re(R) is a correlation matrix as well; the arrows of the
minimum close in a plane, which real R = V Vᵀ with unit rows of V [k, 2] holds.

Mean temperatures and gradients are in the same sums: a panel's gradient may well follow its mean, whatever the case
assumes of them.
"""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray

from tedm_cli.arrays import AnyArray, ComplexArray, FloatArray
from tedm_cli.noise.correlation import Correlation
from tedm_cli.noise.sources import AnyNoise


@dataclass(frozen=True, eq=False)
class Bounds:
    """One-sided PSDs [n_out, F] that enclose the output, each attained by some correlation.

    Parameters
    ----------
    minimum : over all correlations, max(0, 2 max|h_i| - Σ|h_i|)².
    known_blocks_minimum : blocks as the case has them, unknown correlation between them: the same of the √S_b.
    known_blocks : the same knowledge, the largest: (Σ_b √S_b)².
    maximum_non_negative : over all correlations without a negative entry, p² + n² with the positive and negative sums.
    maximum : over all correlations, (Σ|h_i|)².
    """

    minimum: FloatArray
    known_blocks_minimum: FloatArray
    known_blocks: FloatArray
    maximum_non_negative: FloatArray
    maximum: FloatArray


BOUNDS = tuple(field.name for field in fields(Bounds))


def correlation_bounds(noise: AnyNoise) -> Bounds:
    """Bounds on the noise of outputs over the correlations of the areas that are in a block."""
    sizes = noise.sizes()
    block_sum, block_max = noise.block_amplitudes()
    return Bounds(
        minimum=_least(sizes.largest, sizes.total),
        known_blocks_minimum=_least(block_max, block_sum),
        known_blocks=block_sum**2,
        maximum_non_negative=sizes.positive**2 + sizes.negative**2,
        maximum=sizes.total**2,
    )


def _least(largest: FloatArray, total: FloatArray) -> FloatArray:
    """Smallest square of the vector sum of arrows, from the length of the largest and of all together."""
    square: FloatArray = np.square(np.maximum(0.0, 2.0 * largest - total))
    return square


def extremal(noise: AnyNoise, amplitude: FloatArray, frequency_hz: FloatArray, bound: str) -> FloatArray:
    """Vectors V [n_out, k, 2] of a correlation that reaches one of `BOUNDS`, from contributions `amplitude` [n_out, k].

    Each output has its own frequency [n_out].
    """
    if not bound.startswith("known_blocks"):
        return np.array([extremal_vectors(h, bound) for h in amplitude])
    smallest = bound == "known_blocks_minimum"
    pairs = zip(amplitude, frequency_hz.tolist(), strict=True)
    return np.array([extremal_block_vectors(h, noise.source.correlation_at(f), f, smallest=smallest) for h, f in pairs])


def extremal_vectors(h: FloatArray, bound: str) -> FloatArray:
    """Vectors V [k, 2] whose correlation V_i · V_j reaches a bound over all correlations, for contributions `h` [k].

    Rows are unit vectors: (1, 0) and (-1, 0) are opposed, (0, 1) is uncorrelated to both. They are zero where h is
    zero: such an area may have any correlation. `bound` is `maximum`, `maximum_non_negative` or `minimum`.
    """
    if bound == "maximum":
        return np.stack([np.sign(h), np.zeros(len(h))], axis=1)
    if bound == "maximum_non_negative":
        return np.stack([h > 0.0, h < 0.0], axis=1).astype(np.float64)
    angle = _closing_angles(np.abs(h))
    vectors: FloatArray = np.sign(h)[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    return vectors


def extremal_block_vectors(
    h: FloatArray, correlation: Correlation, frequency_hz: float, *, smallest: bool = False
) -> FloatArray:
    """Vectors V [k, 2] whose V_i · V_j, between areas of different blocks, reaches a bound with known blocks.

    `h` [k] are the contributions at `frequency_hz`. |V_i| is the coherence of area i with the sum of its block; inside
    the blocks the correlation stays what it is.
    """
    field = _delayed_factor(correlation, frequency_hz)
    drive = h @ field  # [m], each column belongs to one block
    power = np.bincount(correlation.column_block, np.abs(drive) ** 2)
    amplitude = np.sqrt(power)
    arrow = extremal_vectors(amplitude, "minimum" if smallest else "maximum") @ np.array([1.0, 1j])
    turn = np.divide(arrow, amplitude, out=np.zeros(len(arrow), dtype=np.complex128), where=amplitude > 0.0)
    coherence = field @ (drive.conj() * turn[correlation.column_block])
    return np.stack([coherence.real, coherence.imag], axis=1)


def extremal_matrix(
    vectors: FloatArray, block: NDArray[np.int_] | None = None, inside: FloatArray | None = None
) -> FloatArray:
    """Real correlation matrix [k, k] of extremal `vectors` [k, 2].

    Areas of zero vectors are uncorrelated to all others. Where the blocks are known, `block` [k] is the number of each
    area's, and areas of the same block have the correlation `inside` [k, k].
    """
    matrix: FloatArray = vectors @ vectors.T
    if block is not None and inside is not None:
        matrix = np.where(block[:, None] == block, inside, matrix)
    np.fill_diagonal(matrix, 1.0)
    return matrix


def matrix_at(matrix: AnyArray, delay_s: FloatArray, frequency_hz: float) -> FloatArray:
    """Real part [k, k], which is all that counts, of R_ij exp(-2πi f (τ_i - τ_j)) at one frequency."""
    turn = np.exp(-2j * np.pi * frequency_hz * (delay_s[:, None] - delay_s))
    real: FloatArray = np.real(matrix * turn)
    return real


def _delayed_factor(correlation: Correlation, frequency_hz: float) -> ComplexArray:
    """Factor [k, m] of the correlation at one frequency."""
    phase = np.exp(-2j * np.pi * frequency_hz * correlation.delay_s)
    delayed: ComplexArray = phase[:, None] * correlation.factor
    return delayed


def _closing_angles(size: FloatArray) -> FloatArray:
    """Angles [k] at which arrows of these lengths add up to the least: zero unless one is longer than all others."""
    order = np.argsort(-size, kind="stable")
    if 2.0 * size.max() >= size.sum():
        angle = np.full(len(size), np.pi)
        angle[order[0]] = 0.0
        return angle
    # Three sides that meet the triangle inequality: the next longest arrow goes to the shortest side.
    side, member = np.zeros(3), np.zeros(len(size), dtype=np.intp)
    for i in order:
        member[i] = side.argmin()
        side[member[i]] += size[i]
    a, b, c = side
    gamma = np.arccos(np.clip((a**2 + b**2 - c**2) / (2 * a * b), -1.0, 1.0))
    beta = np.arccos(np.clip((a**2 + c**2 - b**2) / (2 * a * c), -1.0, 1.0))
    angles: FloatArray = np.array([0.0, np.pi - gamma, np.pi + beta])[member]
    return angles
