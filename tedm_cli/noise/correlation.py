"""Correlation of the temperature noise between thermal areas: cases, their blocks, and the factor of R.

A case (Montemurro 2004, section 10.5) is a list of blocks, or a matrix. Inside a block of n areas the temperatures have
the correlation R = ρ J + (1 - ρ) I, with J all ones and ρ = 1 unless given (any ρ >= -1/(n - 1) is possible); between
blocks they are uncorrelated; an area in no block is silent. Where areas follow with delays τ, ΔT_i(t - τ_i), the
correlation becomes R_ij exp(-2πi f (τ_i - τ_j)): as coherent as before.

What a block takes of means and gradients is a block of each, uncorrelated, unless it is `across_kinds`; a matrix may
correlate the two kinds as it correlates any areas. Gradient areas that have no spectrum are in no block.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
import scipy

from tedm_cli.arrays import AnyArray, BoolArray, FloatArray, IndexArray
from tedm_cli.errors import ConfigError
from tedm_cli.noise.areas import AreaTable
from tedm_cli.noise.correlation_check import check_correlation, correlation_factor
from tedm_cli.noise.selection import BlockSelector, Facts, divide, listed, select, unknown

Role = Literal["likely", "possible", "diagnostic"]
SILENT = "of gradients without a spectrum, and silent; give them one in [[temperature.gradient]], in K/m/sqrt(Hz)"


@dataclass(frozen=True, eq=False)
class LabelledMatrix:
    """Correlation of the named areas, `value` [n, n], real or complex, in any order; `where`, a file, for messages."""

    names: tuple[str, ...]
    value: AnyArray
    where: str = "correlation matrix"


@dataclass(frozen=True, eq=False)
class CorrelationCase:
    """A named set of blocks or a matrix, with delays (s) of some areas; `where` (a file) is for messages only.

    `thermal`: temperatures and their correlation are those of the thermal network, and there are no blocks.
    `role`: likely in flight, possible, or diagnostic (not physical, it isolates a part); `reason`: why the case exists.
    """

    id: str
    title: str
    blocks: tuple[BlockSelector, ...]
    where: str = ""
    matrix: LabelledMatrix | None = None
    delays: tuple[tuple[BlockSelector, float], ...] = ()
    role: Role = "possible"
    reason: str = ""
    thermal: bool = False


@dataclass(frozen=True, eq=False)
class Correlation:
    """R_ij(f) = (F Fᴴ)_ij exp(-2πi f (τ_i - τ_j)) of k areas, as a direct sum of blocks.

    Parameters
    ----------
    blocks : indices of the areas of each block; different blocks are uncorrelated.
    factor : F [k, m], zero rows for areas in no block.
    column_block : [m], the block whose areas each column of the factor drives, ascending.
    delay_s : τ [k], s.
    """

    blocks: tuple[IndexArray, ...]
    factor: AnyArray
    column_block: IndexArray
    delay_s: FloatArray

    @classmethod
    def of_factor(cls, factor: AnyArray, delay_s: FloatArray | None = None) -> Correlation:
        """R = F Fᴴ of a factor F [k, m], as one block of all areas that are not silent; without delays unless given."""
        k, columns = factor.shape
        members = np.flatnonzero(factor.any(axis=1))
        column_block = np.zeros(columns, dtype=np.intp)
        return cls((members,), factor, column_block, np.zeros(k) if delay_s is None else delay_s)

    @property
    def active(self) -> BoolArray:
        """Areas [k] that are in a block."""
        driven: BoolArray = self.factor.any(axis=1)
        return driven

    def matrix(self) -> AnyArray:
        """R [k, k] before delays."""
        product: AnyArray = self.factor @ self.factor.conj().T
        return product


def correlation(case: CorrelationCase, areas: AreaTable, heard: BoolArray | None = None) -> Correlation:
    """The correlation of a case.

    `heard` [k] are the areas that have a spectrum (`TemperatureModel.heard`): by default all but gradient areas.

    Raises
    ------
    ConfigError : a case of the thermal network, which has no blocks.
    ConfigError : all of the case's problems with these areas at once: an unknown group, a pattern or a block that
        selects nothing, or nothing but silent gradient areas, an area in two blocks, an area on neither side that a
        choice of sides leaves out, an area without a mirror image, a coefficient that no block of that size can have,
        an area with two delays, an area of the matrix that does not exist.
    PhysicsError : the matrix is not a correlation matrix.
    """
    if case.thermal:
        fact = "its temperatures are those of the thermal network, by nodes in place of areas, which this cannot take"
        raise ConfigError(
            [("thermal", fact)], where=f"{case.where}: case {case.id}" if case.where else f"case {case.id}"
        )
    problems: Facts = []
    heard = ~areas.gradient if heard is None else heard
    if case.matrix is None:
        members, coefficients, problems = _blocks(case, areas, heard)
        factors = [_coefficient_factor(len(b), rho) for b, rho in zip(members, coefficients, strict=True)]
    else:
        members, factors, problems = _matrix_blocks(case.matrix, areas, heard)
    delay_s, facts = _delays(case, areas)
    delay_s[~heard] = 0.0
    problems += facts
    if problems:
        raise ConfigError(problems, where=f"{case.where}: case {case.id}" if case.where else f"case {case.id}")
    width = [f.shape[1] for f in factors]
    factor = np.zeros((len(areas), sum(width)), dtype=np.result_type(*factors))
    edges = np.concatenate([[0], np.cumsum(width)])
    for b, (index, part) in enumerate(zip(members, factors, strict=True)):
        factor[index, edges[b] : edges[b + 1]] = part
    return Correlation(tuple(members), factor, np.repeat(np.arange(len(members)), width), delay_s)


def blocks(case: CorrelationCase, areas: AreaTable) -> list[IndexArray]:
    """Column indices of each block, in the order of the case; raises as `correlation` does."""
    return list(correlation(case, areas).blocks)


def block_factor(block_list: Sequence[IndexArray], k: int) -> FloatArray:
    """Factor F [k, blocks] of fully correlated blocks: ones where an area is in a block, R = F Fᵀ."""
    factor = np.zeros((k, len(block_list)))
    for column, index in enumerate(block_list):
        factor[index, column] = 1.0
    return factor


def full_blocks(block_list: Sequence[IndexArray], k: int) -> Correlation:
    """k areas in fully correlated blocks, without delays."""
    return Correlation(tuple(block_list), block_factor(block_list, k), np.arange(len(block_list)), np.zeros(k))


def correlation_matrix(case: CorrelationCase, areas: AreaTable) -> tuple[AnyArray, BoolArray]:
    """Correlation matrix R [k, k] of a case, before delays, and the mask [k] of its active areas.

    Rows and columns of silent areas are zero, their diagonal too. Raises as `correlation` does.
    """
    of_case = correlation(case, areas)
    return of_case.matrix(), of_case.active


def _blocks(case: CorrelationCase, areas: AreaTable, heard: BoolArray) -> tuple[list[IndexArray], list[float], Facts]:
    """Blocks, those of gradients that are divided from means last, their coefficients, and problems."""
    problems: Facts = []
    of_kind: dict[bool, list[tuple[IndexArray, float]]] = {False: [], True: []}
    owner = np.full(len(areas), -1)
    twice: Facts = []
    for number, selector in enumerate(case.blocks):
        mask, facts = select(selector, areas)
        if not facts and not (mask & heard).any():
            facts = [("", f"{_are(areas, np.flatnonzero(mask))} {SILENT}")]
        kinds = (False,) if selector.across_kinds else (False, True)
        for gradient in kinds if not facts else ():
            mine = mask & heard & ((areas.gradient == gradient) | selector.across_kinds)
            parts, found = divide(selector, mine, areas) if mine.any() else ([], [])
            of_kind[gradient] += [(part, selector.rho) for part in parts]
            facts += found + _impossible_coefficient(selector.rho, max(map(len, parts), default=1))
        problems += [(f"blocks[{number}]{key}", fact) for key, fact in facts]
        again = np.flatnonzero(mask & (owner >= 0))
        if again.size:
            fact = f"{_are(areas, again)} already in blocks[{owner[again[0]]}]"
            twice.append((f"blocks[{number}]", fact))
        owner[mask] = number
    problems += twice + _left_in_the_middle(case, areas, (owner >= 0) | ~heard)
    found_blocks = [*of_kind[False], *of_kind[True]]
    return [members for members, _ in found_blocks], [rho for _, rho in found_blocks], problems


def _impossible_coefficient(rho: float, n: int) -> Facts:
    if n > 1 and rho < -1.0 / (n - 1) * (1.0 + 1e-9):
        fact = f"{n} areas cannot all be correlated with {rho:g} to each other; at least -1/{n - 1} = {-1 / (n - 1):g}"
        return [(".rho", fact)]
    return []


def _coefficient_factor(n: int, rho: float) -> FloatArray:
    """Factor of ρ J + (1 - ρ) I [n, n]: exact where ρ is 0 or 1, so that areas that cancel keep their digits."""
    ones = np.ones((n, 1))
    if n == 1 or rho == 1.0:
        return ones
    if rho >= 0.0:
        alone = np.sqrt(1.0 - rho) * np.eye(n)
        return alone if rho == 0.0 else np.hstack([np.sqrt(rho) * ones, alone])
    mean = np.full((n, n), 1.0 / n)  # projector on the eigenvector of 1 + (n - 1) ρ
    root: FloatArray = np.sqrt(1.0 - rho) * (np.eye(n) - mean) + np.sqrt(max(0.0, 1.0 + (n - 1) * rho)) * mean
    return root


def _matrix_blocks(
    matrix: LabelledMatrix, areas: AreaTable, heard: BoolArray
) -> tuple[list[IndexArray], list[AnyArray], Facts]:
    """Areas that the matrix connects as blocks, each with its factor."""
    names = areas.name.tolist()
    problems: Facts = [("matrix", f"{matrix.where}: {unknown(n, names)}") for n in matrix.names if n not in names]
    twice = [n for n in dict.fromkeys(matrix.names) if matrix.names.count(n) > 1]
    problems += [("matrix", f"{matrix.where}: area {n!r} is named {matrix.names.count(n)} times") for n in twice]
    if problems:
        return [], [], problems
    check_correlation(matrix.value, names=matrix.names, where=matrix.where)
    place = np.array([names.index(n) for n in matrix.names])
    if not heard[place].any():
        return [], [], [("matrix", f"{matrix.where}: {_are(areas, place)} {SILENT}")]
    order = np.argsort(place)
    order = order[heard[place[order]]]
    value, place = matrix.value[np.ix_(order, order)], place[order]
    number, label = scipy.sparse.csgraph.connected_components(
        scipy.sparse.csr_array(np.abs(value) > 0.0), directed=False
    )
    members = [np.flatnonzero(label == b) for b in range(number)]
    return [place[m] for m in members], [correlation_factor(value[np.ix_(m, m)]) for m in members], []


def _delays(case: CorrelationCase, areas: AreaTable) -> tuple[FloatArray, Facts]:
    """Delay of every area [k], s."""
    delay_s, owner, problems = np.zeros(len(areas)), np.full(len(areas), -1), []
    for number, (selector, value) in enumerate(case.delays):
        mask, facts = select(selector, areas)
        problems += [(f"delays[{number}]{key}", fact) for key, fact in facts]
        again = np.flatnonzero(mask & (owner >= 0))
        if again.size:
            fact = f"{_are(areas, again)} already in delays[{owner[again[0]]}]"
            problems.append((f"delays[{number}]", fact))
        owner[mask] = number
        delay_s[mask] = value
    return delay_s, problems


def _left_in_the_middle(case: CorrelationCase, areas: AreaTable, covered: BoolArray) -> Facts:
    """Areas on neither side that only a block's choice of sides would silence."""
    for number, selector in enumerate(case.blocks):
        if not selector.side:
            continue
        alike, _ = select(selector, areas, ignore_side=True)
        left = np.flatnonzero(alike & ~covered & (areas.side == "mid"))
        if left.size:
            fact = f'{_are(areas, left)} on neither side and would be silent; add "mid" to the block to join'
            return [(f"blocks[{number}].side", fact)]
    return []


def _are(areas: AreaTable, index: IndexArray) -> str:
    return f"{listed(areas.name[index].tolist())} {'is' if len(index) == 1 else 'are'}"
