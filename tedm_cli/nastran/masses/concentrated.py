"""Concentrated masses: CONM1, CONM2 and scalar masses on grids (Nastran Quick Reference Guide).

Gravity acts on a mass, not on the inertia that a card gives one direction alone: what is not the same in all three
directions is not the mass of a body and is refused.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from tedm_cli.arrays import FloatArray, IntArray
from tedm_cli.errors import InputError
from tedm_cli.nastran.plausible import is_mass_tensor
from tedm_cli.nastran.positions import Frames, basis_at

_ALIKE = 1e-6  # of the mass: cards have seven digits


@dataclass(frozen=True)
class Concentrated:
    """Concentrated masses: cards and ids, rows of the grid table, masses (kg).

    lever : [C, 3], from the grids (basic frame, m).
    inertia : [C, 3, 3], about their own centres of gravity (basic frame, kg m²).
    """

    card: list[str]
    id: IntArray
    node: IntArray
    kg: FloatArray
    lever: FloatArray
    inertia: FloatArray


@dataclass(frozen=True)
class _Mass:
    card: str
    id: int
    grid: int
    kg: float
    lever: FloatArray
    inertia: FloatArray


def concentrated_masses(
    model: Any,
    frames: Frames,
    factor: float,
    where: str,
    position_of: Callable[[int], FloatArray],
    rows: Callable[[IntArray, str], IntArray],
) -> Concentrated:
    """All concentrated masses of a cross-referenced model, by id.

    Parameters
    ----------
    factor : PARAM,WTMASS.
    position_of : place [3] of a grid by its id, basic frame, m.
    rows : rows of the grid table of grid ids, with what names them.

    Raises
    ------
    InputError : a mass that differs by direction, couples two grids, has the inertia of no body, or is of a kind that
        is not read.
    """
    found: list[_Mass] = []
    scalar: dict[int, list[tuple[int, int, float]]] = {}
    for eid in sorted(model.masses):
        mass = model.masses[eid]
        if mass.type == "CONM2":
            found.append(_conm2(mass, frames, position_of(int(mass.Nid()))))
        elif mass.type == "CONM1":
            found.append(_conm1(mass, frames, position_of(int(mass.Nid())), where))
        elif mass.type in ("CMASS1", "CMASS2"):
            for grid, component, kg in _on_grid(mass, model, where):
                scalar.setdefault(grid, []).append((int(eid), component, kg))
        elif mass.type in ("CMASS3", "CMASS4"):  # on scalar points, which are nowhere
            _check_scalar(mass, model, where)
        else:
            raise InputError(f"{mass.type} {eid}: masses of this kind are not read", where=where)
    found += [_three(grid, parts, where) for grid, parts in scalar.items() if any(c <= 3 for _, c, _ in parts)]
    for m in found:
        if m.kg >= 0.0 and not is_mass_tensor(m.inertia, m.kg * float(m.lever @ m.lever)):
            raise InputError(
                f"{m.card} {m.id}: its inertia about its centre of gravity is impossible for a body",
                where=where,
                hint="the matrix of I11, I21, I22, I31, I32 and I33 has to be positive definite, or zero",
            )
    found.sort(key=lambda m: m.id)
    return Concentrated(
        card=[m.card for m in found],
        id=np.array([m.id for m in found], dtype=np.int64),
        node=rows(np.array([m.grid for m in found], dtype=np.int64), "a concentrated mass"),
        kg=factor * np.array([m.kg for m in found], dtype=float),
        lever=np.array([m.lever for m in found], dtype=float).reshape(-1, 3),
        inertia=factor * np.array([m.inertia for m in found], dtype=float).reshape(-1, 3, 3),
    )


def _conm2(mass: Any, frames: Frames, position: FloatArray) -> _Mass:
    """CID: X and I along the axes that the system has at the grid; -1: X is the place itself, in the basic frame."""
    given, cid = np.array(mass.X, dtype=float), int(mass.Cid())
    xx, xy, yy, xz, yz, zz = (float(v) for v in mass.I)
    inertia = np.array([[xx, -xy, -xz], [-xy, yy, -yz], [-xz, -yz, zz]])
    if cid == -1:
        lever = given - position
    else:
        axes = basis_at(frames, cid, position)
        lever, inertia = given @ axes, axes.T @ inertia @ axes
    return _Mass("CONM2", int(mass.eid), int(mass.Nid()), float(mass.Mass()), lever, inertia)


def _conm1(mass: Any, frames: Frames, position: FloatArray, where: str) -> _Mass:
    """A symmetric 6 x 6 matrix in the axes that CID has at the grid; of a body of mass m at w it is

    [ m 1     -m [w]x            ]
    [ m [w]x   I - m [w]x [w]x   ]   with I about its centre of gravity.
    """
    given = np.array(mass.mass_matrix, dtype=float)
    full = np.where(given != 0.0, given, given.T)  # read on one side of the diagonal only
    name = f"CONM1 {mass.eid}"
    kg = float(np.trace(full[:3, :3])) / 3.0
    if np.abs(full[:3, :3] - kg * np.eye(3)).max() > _ALIKE * abs(kg):
        raise InputError(
            f"{name}: its mass differs by direction",
            where=where,
            hint="M11, M22 and M33 must be the same, M21, M31 and M32 zero",
        )
    if not kg:
        return _Mass("CONM1", int(mass.eid), int(mass.Nid()), 0.0, np.zeros(3), full[3:, 3:])
    coupling = full[3:, :3] / kg  # [w]x
    lever = np.array([coupling[2, 1], coupling[0, 2], coupling[1, 0]])
    if np.abs(coupling - _cross(lever)).max() > _ALIKE * max(float(np.abs(coupling).max()), 1e-12):
        raise InputError(
            f"{name}: its static moments are impossible for a body",
            where=where,
            hint="M53 = -M62, M61 = -M43, M42 = -M51, and M41 = M52 = M63 = 0",
        )
    inertia = full[3:, 3:] + kg * _cross(lever) @ _cross(lever)
    axes = basis_at(frames, int(mass.Cid()), position)
    return _Mass("CONM1", int(mass.eid), int(mass.Nid()), kg, lever @ axes, axes.T @ inertia @ axes)


def _cross(w: FloatArray) -> FloatArray:
    return np.array([[0.0, -w[2], w[1]], [w[2], 0.0, -w[0]], [-w[1], w[0], 0.0]])


def _on_grid(mass: Any, model: Any, where: str) -> list[tuple[int, int, float]]:
    """(grid, component, kg) of a scalar mass that is grounded; none where it is on a scalar point."""
    ends = [(int(g), int(c or 0)) for g, c in ((mass.G1(), mass.c1), (mass.G2(), mass.c2)) if g]
    ends = [(g, c) for g, c in ends if g in model.nodes]
    if len(ends) > 1:
        raise InputError(
            f"{mass.type} {mass.eid}: a mass between two grids is no body",
            where=where,
            hint="use CONM2 on one of them",
        )
    return [(g, c, float(mass.Mass())) for g, c in ends]


def _check_scalar(mass: Any, model: Any, where: str) -> None:
    on_grid = [int(n) for n in mass.node_ids if n and n in model.nodes]
    if on_grid:
        raise InputError(
            f"{mass.type} {mass.eid}: is on grid {on_grid[0]}, and this card is for scalar points",
            where=where,
            hint="use CMASS1 or CMASS2 with a component, or CONM2",
        )


def _three(grid: int, parts: list[tuple[int, int, float]], where: str) -> _Mass:
    """The mass of equal scalar masses in the three directions of a grid; those of its rotations have none."""
    sums = np.zeros(7)
    for _, component, kg in parts:
        sums[component] += kg
    first = min(eid for eid, component, _ in parts if component <= 3)
    kg = float(sums[1:4].mean())
    if np.abs(sums[1:4] - kg).max() > _ALIKE * abs(kg):
        raise InputError(
            f"CMASS {first}: the scalar masses of grid {grid} differ by direction: "
            + ", ".join(f"{v:.6g}" for v in sums[1:4]),
            where=where,
            hint="give components 1, 2 and 3 the same mass, or use CONM2",
        )
    return _Mass("CMASS", first, grid, kg, np.zeros(3), np.diag(sums[4:7]))
