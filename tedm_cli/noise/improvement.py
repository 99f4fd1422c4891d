"""What would bring a verdict down: quieter areas, areas that are matched thermally, and more stable groups."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tedm_cli.arrays import AnyArray, BoolArray, FloatArray, IndexArray
from tedm_cli.noise.sources import AnyNoise

COUNTS = (0, 1, 2, 3, 5, 10)
QUIETER = 10.0  # factor on amplitudes of areas made quieter


@dataclass(frozen=True, eq=False)
class Improvement:
    """How the ratio of one verdict would change.

    Parameters
    ----------
    worst : [10], areas in the order of greatest relief at the binding frequency, each after those before it were
        silenced; -1 where no further area brings relief.
    silenced, quieter : [6], ratio with the first `COUNTS` of them without noise, and with a `QUIETER`-th of it.
    match : [10], blocks of the correlation that lower the noise at the binding frequency most when they are matched:
        the best pair, then the best block to join those before it; -1 where none lowers it. An area that stands alone
        is a block. Blocks that hold a gradient are matched with none.
    matched : [6], ratio with the first `COUNTS` of these blocks matched: all their areas share one fluctuation of
        temperature, each with its own amplitude A_i(f) and none later than another, and the other blocks stay as they
        are: S = (Σ_matched g_i A_i)² + S of the others. Whole blocks are matched because an area taken out of one
        would be torn from those it moves with. One block is no match: the ratios at 0 and 1 are that of the case.
    group_factor : [G], the factor on the temperature amplitudes of each group, the others unchanged, that would just
        meet the requirement: how much quieter it must be (< 1) or how much noisier it may be (> 1, infinite where the
        output does not feel it); NaN where this group alone cannot do it.
    """

    worst: IndexArray
    silenced: FloatArray
    quieter: FloatArray
    match: IndexArray
    matched: FloatArray
    group_factor: FloatArray


def improvement(output: AnyNoise, binding: int, limit: FloatArray, groups: Sequence[BoolArray]) -> Improvement:
    """Improvements of one output against a limit.

    Parameters
    ----------
    output : with one row [1, k], at the F frequencies of the band.
    binding : index of the binding frequency among them.
    limit : [F], the limit over the safety factor.
    groups : masks [k].
    """
    row, source, at = output.rows[0], output.source, output.frequency_hz[binding : binding + 1]
    terms = output.at(at).terms()
    worst = _worst(terms, COUNTS[-1])

    def noise(areas: Sequence[IndexArray], scale: float) -> FloatArray:
        """Power [6, F] with the amplitudes of the areas scaled, for each of `COUNTS` those in its place."""
        rows = np.tile(row, (len(COUNTS), 1))
        for n, chosen in enumerate(areas):
            rows[n, chosen] *= scale
        return output.of(rows).psd()

    amplitude = output.amplitude_contributions(at)[0]
    blocks = source.blocks
    by_block = np.array([terms[b].sum(axis=0) for b in blocks]).reshape(len(blocks), len(terms.T))
    # A gradient shares no temperature; blocks are uncorrelated, so that one left out changes no relief of the others.
    shareable = np.array([b for b, held in enumerate(blocks) if not source.gradient[held].any()], int)
    of_block = np.array([amplitude[b].sum() for b in blocks])
    match = shareable[_match(by_block[shareable], of_block[shareable], COUNTS[-1])]
    joined = [np.concatenate([np.empty(0, np.intp), *(blocks[b] for b in match[:n])]) for n in COUNTS]
    members = np.zeros((len(COUNTS), len(row)))
    for n, inside in enumerate(joined):
        members[n, inside] = row[inside]
    matched = noise(joined, 0.0) + output.of(members).in_phase()
    matched[:2] = noise([], 1.0)[:2]
    first = [worst[:n] for n in COUNTS]

    parts = np.array([part for mask in groups for part in (np.where(mask, row, 0.0), np.where(mask, 0.0, row))])
    of_parts = output.of(parts).components()
    return Improvement(
        worst=_filled(worst),
        silenced=_ratios(noise(first, 0.0), limit),
        quieter=_ratios(noise(first, 1.0 / QUIETER), limit),
        match=_filled(match),
        matched=_ratios(matched, limit),
        group_factor=np.array([scale_to_meet(of_parts[2 * g], of_parts[2 * g + 1], limit) for g in range(len(groups))]),
    )


def _ratios(psd: FloatArray, limit: FloatArray) -> FloatArray:
    ratio: FloatArray = (np.sqrt(psd) / limit).max(axis=1)
    return ratio


def _filled(chosen: IndexArray) -> IndexArray:
    return np.pad(chosen, (0, COUNTS[-1] - len(chosen)), constant_values=-1)


def _worst(terms: AnyArray, most: int) -> IndexArray:
    """Areas whose silence lowers |Σ_i terms_i|² most, one after the other, of `terms` [k, m]."""
    total = terms.sum(axis=0)
    own = np.sum(np.abs(terms) ** 2, axis=1)
    least = 1e-12 * float(np.sum(np.abs(total) ** 2))  # rounding brings no relief
    chosen: list[int] = []
    for _ in range(min(most, len(terms))):
        relief = 2.0 * np.real(terms @ total.conj()) - own  # |total|² - |total - terms_i|²
        relief[chosen] = 0.0
        best = int(relief.argmax())
        if relief[best] <= least:
            break
        chosen.append(best)
        total = total - terms[best]
    return np.array(chosen, dtype=np.intp)


def _match(terms: AnyArray, amplitude: FloatArray, most: int) -> IndexArray:
    """Blocks that lower (Σ_in amplitude_b)² + |Σ_out terms_b|² most by being in: the best pair, then one by one.

    `terms` [b, m] of blocks that are out, signed `amplitude` [b] of blocks that are in.
    """
    total = terms.sum(axis=0)
    own = np.sum(np.abs(terms) ** 2, axis=1)
    least = 1e-12 * float(np.sum(np.abs(total) ** 2) + own.sum())  # rounding brings no relief
    leaves = 2.0 * np.real(terms @ total.conj()) - own  # |total|² - |total - terms_i|²
    common = np.real(terms @ terms.conj().T) + np.outer(amplitude, amplitude)
    relief = leaves[:, None] + leaves - amplitude[:, None] ** 2 - amplitude**2 - 2.0 * common
    np.fill_diagonal(relief, -np.inf)
    if most < 2 or len(terms) < 2 or relief.max() <= least:
        return np.empty(0, dtype=np.intp)
    chosen = [int(i) for i in np.unravel_index(relief.argmax(), relief.shape)]
    inside = float(amplitude[chosen].sum())
    total = total - terms[chosen].sum(axis=0)
    for _ in range(2, min(most, len(terms))):
        gain = 2.0 * np.real(terms @ total.conj()) - own - amplitude * (2.0 * inside + amplitude)
        gain[chosen] = -np.inf
        best = int(gain.argmax())
        if gain[best] <= least:
            break
        chosen.append(best)
        inside += float(amplitude[best])
        total = total - terms[best]
    return np.array(chosen, dtype=np.intp)


def scale_to_meet(own: AnyArray, others: AnyArray, limit: FloatArray) -> float:
    """Factor s at which |s y_own + y_others| just meets the limit [F], for their components [m, F]; NaN for none."""

    def power(y: AnyArray) -> FloatArray:
        return np.asarray(np.sum(y.real**2 + y.imag**2, axis=0))

    # s² a + 2 s b + c <= limit² at every frequency: one interval each, their intersection is what is possible.
    a, b, c = power(own), np.sum(own.real * others.real + own.imag * others.imag, axis=0), power(others) - limit**2
    felt = a > 0.0
    if np.any(~felt & (c > 0.0)) or np.any(felt & (b**2 < a * c)):
        return np.nan
    root = np.sqrt(b[felt] ** 2 - a[felt] * c[felt])
    low = float(np.max((-b[felt] - root) / a[felt], initial=0.0))
    high = float(np.min((-b[felt] + root) / a[felt], initial=np.inf))
    failing = bool(np.any(a + 2.0 * b + c > 0.0))
    # Noisier until others are cancelled is no requirement on a stability.
    return np.nan if high < low or (failing and low > 1.0) else high
