"""Single-point and multipoint constraints of a deck."""

from __future__ import annotations

from typing import Any

import numpy as np

from tedm_cli.arrays import FloatArray, IntArray
from tedm_cli.errors import InputError
from tedm_cli.fem.structure import Mpc
from tedm_cli.nastran.bulk.columns import columns_of
from tedm_cli.nastran.structure.references import CardReferences


def read_constraints(
    model: Any, constraint: int | None, references: CardReferences
) -> tuple[IntArray, IntArray, FloatArray]:
    """Constrained grid rows and components, from the selected SPC set and the GRID cards, without repetition, and the
    displacements that its SPC cards enforce there, in the displacement frames.

    Raises
    ------
    InputError : two different displacements of one degree of freedom.
    """
    held: dict[tuple[int, int], float] = {}
    columns = columns_of(model)
    plain = columns.plain_grids
    on_cards = [(grid.nid, str(grid.ps or "")) for grid in columns.grid_cards.values()]
    rows = np.flatnonzero(plain.held)
    for number, digits in [*zip(plain.id[rows].tolist(), map(str, plain.held[rows].tolist()), strict=True), *on_cards]:
        held.update(((number, int(digit)), 0.0) for digit in digits)
    for card in [] if constraint is None else _spc_cards(model, constraint):
        nodes, moved = card.nodes, [0.0] * len(card.nodes)
        if card.type == "SPC1":
            components = [card.components] * len(nodes)
            # A THRU range, which pyNastran has expanded, may have gaps; a list of grids may not.
            is_range = len(nodes) > 2 and nodes[-1] - nodes[0] == len(nodes) - 1
            present = [node in model.nodes for node in nodes]
            if is_range and any(present):
                nodes = [node for node, there in zip(nodes, present, strict=True) if there]
                components, moved = components[: len(nodes)], moved[: len(nodes)]
        else:
            components, moved = card.components, card.enforced
        for node, digits, value in zip(nodes, components, moved, strict=True):
            for digit in str(digits) if node not in model.spoints else "":
                if digit != "0":
                    _hold(held, (int(node), int(digit)), float(value or 0.0), references.where)
    table = np.array(sorted(held), dtype=np.int64).reshape(-1, 2)
    enforced = np.array([held[freedom] for freedom in sorted(held)], dtype=np.float64)
    return references.rows(table[:, 0], f"SPC set {constraint}"), table[:, 1], enforced


def _hold(held: dict[tuple[int, int], float], freedom: tuple[int, int], value: float, where: str) -> None:
    before = held.get(freedom, 0.0)
    if value and before and value != before:
        grid, component = freedom
        fact = f"grid {grid} component {component} has two enforced displacements, {before:g} and {value:g}"
        raise InputError(fact, where=where, hint="leave one of the SPC cards out")
    held[freedom] = value or before


def read_equations(model: Any, equations: int | None, references: CardReferences) -> tuple[Mpc, ...]:
    """The equations of the selected MPC set."""
    if equations is None:
        return ()
    sids = {equations}
    for one in model.mpcadds.get(equations, []):
        sids.update(one.mpc_ids)
    return tuple(
        Mpc(
            grids=references.rows(card.nodes, f"MPC set {card.conid}"),
            components=np.array([int(digit) for digit in card.components], dtype=np.int64),
            coefficients=np.array(card.coefficients, dtype=np.float64),
        )
        for sid in sorted(sids)
        for card in model.mpcs.get(sid, [])
    )


def _spc_cards(model: Any, constraint: int) -> list[Any]:
    sids = {constraint}
    for one in model.spcadds.get(constraint, []):
        sids.update(one.sets)
    return [card for sid in sorted(sids) for card in model.spcs.get(sid, [])]
