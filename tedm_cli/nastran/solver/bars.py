"""Bar elements of a deck."""

from __future__ import annotations

from typing import Any

import numpy as np

from tedm_cli.fem.structure import BarBlock, Floats
from tedm_cli.nastran.solver.finder import Finder, material_of


def read_bars(model: Any, finder: Finder, position: Floats) -> BarBlock:
    ids = sorted(eid for eid, element in model.elements.items() if element.type == "CBAR")
    bars = [model.elements[eid] for eid in ids]
    table = np.ones((9, len(ids)))
    pids = np.array([bar.pid for bar in bars], dtype=np.int64)
    for pid in np.unique(pids):
        prop, mat = material_of(model, finder, int(pid), "PBAR")
        if mat is not None:
            section = [prop.A, prop.i1, prop.i2, prop.i12, prop.j]
            table[:, pids == pid] = np.array([*section, mat.e, mat.g, mat.a, mat.tref])[:, None]
    nodes = finder.rows([bar.nodes for bar in bars], "CBAR").reshape(-1, 2)
    orientation = np.zeros((len(bars), 3))
    for k, bar in enumerate(bars):
        if bar.g0:
            orientation[k] = position[finder.rows(bar.g0, f"CBAR {bar.eid} G0")] - position[nodes[k, 0]]
        else:
            orientation[k] = bar.x
    return BarBlock(
        element_id=np.array(ids, dtype=np.int64),
        connectivity=nodes,
        area=table[0],
        inertia_1=table[1],
        inertia_2=table[2],
        inertia_12=table[3],
        torsion_constant=table[4],
        youngs_modulus=table[5],
        shear_modulus=table[6],
        expansion=table[7],
        reference_temperature=table[8],
        orientation=orientation,
    )
