"""Solid elements of a deck."""

from __future__ import annotations

from typing import Any

import numpy as np

from tedm_cli.errors import InputError
from tedm_cli.fem.structure import HexBlock
from tedm_cli.nastran.solver.finder import Finder, material_of


def read_hexes(model: Any, finder: Finder) -> HexBlock:
    ids = sorted(eid for eid, element in model.elements.items() if element.type == "CHEXA")
    pids = np.array([model.elements[eid].pid for eid in ids], dtype=np.int64)
    table = np.ones((5, len(ids)))
    for pid in np.unique(pids):
        _, mat = material_of(model, finder, int(pid), "PSOLID")
        if mat is not None:
            if abs(mat.g * 2.0 * (1.0 + mat.nu) / mat.e - 1.0) > 0.01:
                raise InputError(f"MAT1 {mat.mid}: E, G and NU of a solid do not agree within 1 %")
            table[:, pids == pid] = np.array([[mat.e], [mat.nu], [mat.rho], [mat.a], [mat.tref]])
    nodes = finder.rows([model.elements[eid].nodes for eid in ids], "CHEXA").reshape(-1, 8)
    return HexBlock(
        element_id=np.array(ids, dtype=np.int64),
        connectivity=nodes,
        youngs_modulus=table[0],
        poisson_ratio=table[1],
        density=table[2],
        expansion=table[3],
        reference_temperature=table[4],
    )
