"""Solids: density of their material."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from tedm_cli.errors import InputError
from tedm_cli.nastran.masses.spread import Spread, density_of


def solid_spread(elements: Sequence[Any], nodes: int, where: str) -> Spread:
    """Densities of solids with so many nodes; `InputError` names hyperelastic, composite and fluid properties."""
    known: dict[int, float] = {}
    for element in elements:
        prop = element.pid_ref
        if prop.pid in known:
            continue
        if prop.type != "PSOLID":
            raise InputError(f"{prop.type} {prop.pid}: solids with this property are not read", where=where)
        if getattr(prop, "fctn", None) not in (None, "SMECH", "FGAP"):
            raise InputError(f"PSOLID {prop.pid}: FCTN = {prop.fctn} is no structure", where=where)
        known[prop.pid] = density_of(prop.mid_ref, f"PSOLID {prop.pid}", where)
    density = np.array([known[e.pid] for e in elements])
    zero = np.zeros((len(elements), nodes, 3))
    return Spread(
        structural=np.repeat(density[:, None], nodes, axis=1),
        nonstructural=np.zeros((len(elements), nodes)),
        axis=zero,
        structural_lever=zero,
        nonstructural_lever=zero,
        section=np.zeros(len(elements)),
    )
