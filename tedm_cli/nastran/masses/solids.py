"""Solids: density of their material."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from tedm_cli.arrays import IntArray
from tedm_cli.errors import InputError
from tedm_cli.nastran.masses.spread import Spread, density_of


def solid_spread(property_id: IntArray, properties: Mapping[int, Any], nodes: int, where: str) -> Spread:
    """Densities of solids [E] with so many nodes; `InputError` names hyperelastic, composite and fluid properties."""
    ids, first, number = np.unique(property_id, return_index=True, return_inverse=True)
    known = np.zeros(len(ids))
    for k in np.argsort(first).tolist():
        prop = properties[int(ids[k])]
        if prop.type != "PSOLID":
            raise InputError(f"{prop.type} {prop.pid}: solids with this property are not read", where=where)
        if getattr(prop, "fctn", None) not in (None, "SMECH", "FGAP"):
            raise InputError(f"PSOLID {prop.pid}: FCTN = {prop.fctn} is no structure", where=where)
        known[k] = density_of(prop.mid_ref, f"PSOLID {prop.pid}", where)
    zero = np.broadcast_to(0.0, (len(number), nodes, 3))
    return Spread(
        structural=np.broadcast_to(known[number][:, None], (len(number), nodes)),
        nonstructural=np.broadcast_to(0.0, (len(number), nodes)),
        axis=zero,
        structural_lever=zero,
        nonstructural_lever=zero,
        section=np.zeros(len(number)),
    )
