"""Grids that rigid elements and multipoint constraints hold."""

from __future__ import annotations

from typing import Any

from tedm_cli.errors import InputError


def grids_of_rigid_elements(model: Any, where: str) -> list[int]:
    """Ids of the grids in rigid elements (RBE2, RBE3, RBAR, ...) and multipoint constraints.

    Raises
    ------
    InputError : a zero or a blank among the grids of a rigid element.
    """
    tied: set[int] = set()
    for eid, element in sorted(model.rigid_elements.items()):
        try:
            tied.update(int(n) for n in [*element.independent_nodes, *element.dependent_nodes] if n)
        except TypeError as exc:  # pyNastran cannot sort what is no grid
            raise InputError(f"{element.type} {eid} has a zero or a blank among its grids", where=where) from exc
    for mpcs in model.mpcs.values():
        for mpc in mpcs:
            tied.update(int(n) for n in mpc.node_ids if n)
    return sorted(tied)
