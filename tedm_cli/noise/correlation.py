"""Correlation of the temperature noise between thermal areas: blocks, correlation matrix, its factor and its checks.

A case (Montemurro 2004, section 10.5) is a list of blocks. Inside a block the temperatures are fully correlated,
between blocks uncorrelated; an area in no block is silent. R is then a direct sum of matrices of ones.
"""

from __future__ import annotations

import difflib
from collections.abc import Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tedm_cli.errors import ConfigError, PhysicsError
from tedm_cli.noise.areas import AreaTable

Array = NDArray[np.float64]
Indices = NDArray[np.intp]
Mask = NDArray[np.bool_]
Matrix = NDArray[Any]  # real or complex


@dataclass(frozen=True)
class BlockSelector:
    """Areas of one block: those that meet every key given, each key by any of its values.

    Parameters
    ----------
    groups, shield, side : values of the columns of `AreaTable`.
    areas : patterns of area names, with `*`, `?` and `[...]`.
    each_alone : every selected area is a block of its own (mutually uncorrelated) instead of one block of all.
    """

    groups: tuple[str, ...] = ()
    shield: tuple[str, ...] = ()
    side: tuple[str, ...] = ()
    areas: tuple[str, ...] = ()
    each_alone: bool = False


@dataclass(frozen=True)
class CorrelationCase:
    """A named set of blocks; `where` (a file) is for messages only."""

    id: str
    title: str
    blocks: tuple[BlockSelector, ...]
    where: str = ""


def blocks(case: CorrelationCase, areas: AreaTable) -> list[Indices]:
    """Column indices of each fully correlated block, in the order of the case.

    Raises
    ------
    ConfigError : all of the case's problems with these areas at once: an unknown group, a pattern or a block that
        selects nothing, an area in two blocks, an area on neither side that a choice of sides leaves out.
    """
    problems: list[tuple[str, str]] = []
    selected = []
    for number, selector in enumerate(case.blocks):
        mask, facts = _select(selector, areas)
        problems += [(f"blocks[{number}]{key}", fact) for key, fact in facts]
        selected.append(mask)
    owner = np.full(len(areas), -1)
    for number, mask in enumerate(selected):
        twice = np.flatnonzero(mask & (owner >= 0))
        if twice.size:
            fact = f"{_names(areas, twice)} already in blocks[{owner[twice[0]]}]"
            problems.append((f"blocks[{number}]", fact))
        owner[mask] = number
    problems += _left_in_the_middle(case, areas, owner >= 0)
    if problems:
        where = f"{case.where}: case {case.id}" if case.where else f"case {case.id}"
        raise ConfigError(problems, where=where)
    out: list[Indices] = []
    for selector, mask in zip(case.blocks, selected, strict=True):
        index = np.flatnonzero(mask)
        out += [np.array([i]) for i in index] if selector.each_alone else [index]
    return out


def block_factor(block_list: Sequence[Indices], k: int) -> Array:
    """Factor F [k, blocks] with R = F Fᵀ: ones where an area is in a block. Exact, unlike a numerical factor of R."""
    factor = np.zeros((k, len(block_list)))
    for column, index in enumerate(block_list):
        factor[index, column] = 1.0
    return factor


def correlation_matrix(case: CorrelationCase, areas: AreaTable) -> tuple[Array, Mask]:
    """Correlation matrix R [k, k] of a case and the mask [k] of its active areas.

    Rows and columns of silent areas are zero, their diagonal too. Raises `ConfigError` as `blocks` does.
    """
    factor = block_factor(blocks(case, areas), len(areas))
    return factor @ factor.T, factor.any(axis=1)


def check_correlation(matrix: Matrix, active: Mask | None = None, *, tolerance: float = 1e-9) -> None:
    """Check that `matrix` [k, k] is a correlation matrix.

    Parameters
    ----------
    matrix : real or complex; complex entries hold phase shifts, such as a delay, between areas.
    active : [k], the areas that must have a unit diagonal; the others must have zero rows. All by default.
    tolerance : on entries, and on eigenvalues relative to the largest.

    Raises
    ------
    PhysicsError : not finite, not Hermitian, a wrong diagonal, or a negative eigenvalue (which is named).
    """
    where = "correlation matrix"
    if matrix.ndim != 2 or matrix.shape[0] != matrix.shape[1] or not matrix.size:
        raise PhysicsError(f"its shape is {matrix.shape}, not square", where=where)
    if not np.isfinite(matrix).all():
        raise PhysicsError(f"{np.count_nonzero(~np.isfinite(matrix))} entries are not finite", where=where)
    skew = np.abs(matrix - matrix.conj().T)
    i, j = divmod(int(skew.argmax()), len(matrix))
    if skew[i, j] > tolerance:
        fact = f"not Hermitian: entries [{i}, {j}] and [{j}, {i}] are {matrix[i, j]:.6g} and {matrix[j, i]:.6g}"
        raise PhysicsError(fact, where=where)
    wanted = np.ones(len(matrix)) if active is None else active.astype(np.float64)
    off = np.abs(np.diag(matrix) - wanted)
    i = int(off.argmax())
    if off[i] > tolerance:
        raise PhysicsError(f"diagonal entry [{i}, {i}] is {matrix[i, i]:.6g}, not {wanted[i]:g}", where=where)
    eigenvalues = np.linalg.eigvalsh(matrix)
    if eigenvalues[0] < -tolerance * max(1.0, eigenvalues[-1]):
        raise PhysicsError(
            f"not positive semidefinite: eigenvalue {eigenvalues[0]:.6g} (largest {eigenvalues[-1]:.6g})",
            where=where,
            hint="no temperatures can be correlated like this; some pairs contradict each other",
        )


def correlation_factor(matrix: Matrix) -> Matrix:
    """Factor F [k, rank] with R = F Fᴴ, from the eigenvectors of a checked R [k, k] (zero rows for silent areas).

    Raises `PhysicsError` as `check_correlation` does.
    """
    check_correlation(matrix, np.diag(matrix) != 0.0)
    eigenvalues, vectors = np.linalg.eigh(matrix)
    kept = eigenvalues > len(matrix) * np.finfo(np.float64).eps * eigenvalues[-1]
    factor: Matrix = vectors[:, kept] * np.sqrt(eigenvalues[kept])
    return factor


def _select(
    selector: BlockSelector, areas: AreaTable, *, ignore_side: bool = False
) -> tuple[Mask, list[tuple[str, str]]]:
    """Mask [k] of the selected areas, and what is wrong with the selector as (key, fact)."""
    mask = np.ones(len(areas), dtype=bool)
    facts: list[tuple[str, str]] = []
    for key, wanted, column in (
        ("groups", selector.groups, areas.group),
        ("shield", selector.shield, areas.shield),
        ("side", () if ignore_side else selector.side, areas.side),
    ):
        if wanted:
            mask &= np.isin(column, wanted)
            existing = sorted(set(column.tolist()))
            facts += [(f".{key}", _unknown(value, existing)) for value in wanted if value not in existing]
    if selector.areas:
        hits = np.array([[fnmatchcase(name, p) for p in selector.areas] for name in areas.name.tolist()])
        mask &= hits.any(axis=1)
        names = areas.name.tolist()
        facts += [
            (".areas", _unknown(p, names)) for p, hit in zip(selector.areas, hits.any(axis=0), strict=True) if not hit
        ]
    if not facts and not mask.any():
        facts.append(("", f"selects none of the {len(areas)} thermal areas; present: {_present(areas)}"))
    return mask, facts


def _left_in_the_middle(case: CorrelationCase, areas: AreaTable, covered: Mask) -> list[tuple[str, str]]:
    """Areas on neither side that only a block's choice of sides would silence."""
    for number, selector in enumerate(case.blocks):
        if not selector.side:
            continue
        alike, _ = _select(selector, areas, ignore_side=True)
        left = np.flatnonzero(alike & ~covered & (areas.side == "mid"))
        if left.size:
            fact = f'{_names(areas, left)} on neither side and would be silent; add "mid" to the block to join'
            return [(f"blocks[{number}].side", fact)]
    return []


def _unknown(value: str, existing: list[str]) -> str:
    near = difflib.get_close_matches(value, existing, n=1)
    shown = ", ".join(existing[:12]) + (f", ... ({len(existing)} in all)" if len(existing) > 12 else "")
    return f"no thermal area has {value!r}" + (f"; did you mean {near[0]}?" if near else "") + f"; there are: {shown}"


def _names(areas: AreaTable, index: Indices) -> str:
    shown = ", ".join(areas.name[index[:4]].tolist()) + (f" and {len(index) - 4} more" if len(index) > 4 else "")
    return f"{shown} {'is' if len(index) == 1 else 'are'}"


def _present(areas: AreaTable) -> str:
    combos = sorted(set(zip(areas.group.tolist(), areas.shield.tolist(), areas.side.tolist(), strict=True)))
    return "; ".join("/".join(combo) for combo in combos[:12]) + ("; ..." if len(combos) > 12 else "")
