"""Single-point and multipoint constraints of a deck."""

from __future__ import annotations

from typing import Any

import numpy as np

from tedm_cli.arrays import IntArray
from tedm_cli.fem.structure import Mpc
from tedm_cli.nastran.structure.references import CardReferences


def read_constraints(model: Any, constraint: int | None, references: CardReferences) -> tuple[IntArray, IntArray]:
    """Constrained grid rows and components, from the selected SPC set and the GRID cards, without repetition."""
    pairs: set[tuple[int, int]] = set()
    for grid in model.nodes.values():
        pairs.update((grid.nid, int(digit)) for digit in str(grid.ps or ""))
    for card in [] if constraint is None else _spc_cards(model, constraint):
        nodes = card.nodes
        if card.type == "SPC1":
            components = [card.components] * len(nodes)
            # A THRU range, which pyNastran has expanded, may have gaps; a list of grids may not.
            is_range = len(nodes) > 2 and nodes[-1] - nodes[0] == len(nodes) - 1
            present = [node in model.nodes for node in nodes]
            if is_range and any(present):
                nodes = [node for node, there in zip(nodes, present, strict=True) if there]
                components = components[: len(nodes)]
        else:
            components = card.components
        for node, digits in zip(nodes, components, strict=True):
            if node not in model.spoints:
                pairs.update((int(node), int(digit)) for digit in str(digits) if digit != "0")
    table = np.array(sorted(pairs), dtype=np.int64).reshape(-1, 2)
    return references.rows(table[:, 0], f"SPC set {constraint}"), table[:, 1]


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
