"""Rod elements of a deck: CROD, CONROD and CTUBE."""

from __future__ import annotations

from typing import Any

import numpy as np

from tedm_cli.fem.structure import RodBlock
from tedm_cli.nastran.bulk.columns import columns_of
from tedm_cli.nastran.structure.references import CardReferences, material_of

_KINDS = {"CROD": "PROD", "CTUBE": "PTUBE", "CONROD": ""}


def read_rods(model: Any, references: CardReferences) -> RodBlock:
    own = columns_of(model).element_cards  # no rod is without an object
    ids = sorted(eid for eid, element in own.items() if element.type in _KINDS)
    rods = [own[eid] for eid in ids]
    table = np.ones((6, len(ids)))
    for k, rod in enumerate(rods):
        if rod.type == "CONROD":
            prop, mat = rod, references.card(model.materials, rod.mid, "MAT1", who=f"CONROD {rod.eid}")
        else:
            prop, mat = material_of(model, references, rod.pid, _KINDS[rod.type])
        if mat is not None:
            table[:, k] = [*_section(prop), mat.e, mat.g, mat.a, mat.tref]
    return RodBlock(
        element_id=np.array(ids, dtype=np.int64),
        connectivity=references.rows([rod.nodes for rod in rods], "CROD, CONROD and CTUBE", ids).reshape(-1, 2),
        area=table[0],
        torsion_constant=table[1],
        youngs_modulus=table[2],
        shear_modulus=table[3],
        expansion=table[4],
        reference_temperature=table[5],
    )


def _section(prop: Any) -> tuple[float, float]:
    """Area and torsion constant."""
    if prop.type != "PTUBE":
        return float(prop.A), float(prop.j)
    outer = 0.5 * prop.OD1
    inner = outer - prop.t if prop.t else 0.0
    return np.pi * (outer**2 - inner**2), 0.5 * np.pi * (outer**4 - inner**4)
