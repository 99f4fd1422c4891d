"""Which material and which thickness every element of a deck has."""

from __future__ import annotations

from typing import Any

import numpy as np

from tedm_cli import deck_units as u
from tedm_cli.adjoint.materials import NONE, MaterialUse
from tedm_cli.nastran.bulk.columns import columns_of
from tedm_cli.nastran.units import units_of

_SHELLS = ("CQUAD4", "CTRIA3")


def material_use(model: Any) -> MaterialUse:
    """Of all elements of a pyNastran model that `solver_structure` reads, cross-referenced or not; SI."""
    columns = columns_of(model)
    number = columns.alike.number
    of_element = [_materials(model, element) for element in columns.examples()]  # and those that are alike
    material_id = sorted({mid for laws, _, _ in of_element for mid in laws if mid})
    thick = sorted({pid for _, _, pid in of_element if pid})
    row = {0: NONE, **{mid: k for k, mid in enumerate(material_id)}}
    thickness_row = {0: NONE, **{pid: k for k, pid in enumerate(thick)}}
    factor = units_of(model).factor(u.EXPANSION)
    cards = [model.materials[mid] for mid in material_id]
    return MaterialUse(
        material_id=np.array(material_id, dtype=np.int64),
        expansion=np.array([factor * card.a if card.type == "MAT1" else np.nan for card in cards], dtype=np.float64),
        shell_property_id=np.array(thick, dtype=np.int64),
        element_id=columns.element.id,
        law=np.array([[row[mid] for mid in laws] for laws, _, _ in of_element], dtype=np.int64).reshape(-1, 3)[number],
        mass=np.array([row[mid] for _, mid, _ in of_element], dtype=np.int64)[number],
        thickness=np.array([thickness_row[pid] for _, _, pid in of_element], dtype=np.int64)[number],
    )


def material_cards(model: Any) -> dict[int, tuple[str, str]]:
    """Card of every material of `material_use`, and the properties of elements that name it: "PSOLID 1, CONROD"."""
    users: dict[int, dict[str, None]] = {}
    for element in columns_of(model).examples():
        laws, _, _ = _materials(model, element)
        prop = None if element.type == "CONROD" else model.properties[element.pid]
        name = "CONROD" if prop is None else f"{prop.type} {prop.pid}"
        for mid in laws:
            users.setdefault(mid, {})[name] = None
    return {mid: (model.materials[mid].type, ", ".join(names)) for mid, names in sorted(users.items()) if mid}


def _materials(model: Any, element: Any) -> tuple[tuple[int, int, int], int, int]:
    """Materials of an element's laws, of its mass, and the property that has its thickness; 0: none.

    A shell whose corners have thicknesses of their own has none of its property's, unless they are relative to it.
    """
    if element.type == "CONROD":
        return (element.mid,) * 3, element.mid, 0
    prop = model.properties[element.pid]
    if element.type not in _SHELLS:
        return (prop.mid,) * 3, prop.mid, 0
    laws = (prop.mid1 or 0, prop.mid2 or 0, prop.mid3 or 0)
    if not laws[1]:
        laws = (laws[0], 0, 0)  # transverse shear is of plates alone
    given = any(getattr(element, f"T{k}") is not None for k in range(1, len(element.nodes) + 1))
    return laws, laws[0] or laws[1], 0 if given and not element.tflag else prop.pid
