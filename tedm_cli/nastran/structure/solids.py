"""Solid elements of a deck, their integration and their materials."""

from __future__ import annotations

from collections import Counter
from typing import Any

import numpy as np

from tedm_cli.arrays import FloatArray
from tedm_cli.errors import InputError
from tedm_cli.fem.elasticity import isotropic_stiffness, orthotropic_stiffness, rotated
from tedm_cli.fem.shapes import corner_count
from tedm_cli.fem.structure import SolidBlock, SolidMaterials
from tedm_cli.nastran.bulk.columns import columns_of
from tedm_cli.nastran.plausible import anisotropic_stiffness
from tedm_cli.nastran.structure.references import CardReferences

SOLID_CARDS = ("CHEXA", "CPENTA", "CTETRA")
# IN and ISOP of hexahedra and pentahedra, without midside nodes and with: Nastran's default and full integration.
_MODELLED = {
    True: {(None, None), (None, "REDUCED"), ("BUBBLE", None), ("BUBBLE", "REDUCED"), (None, "FULL"), ("TWO", "FULL")},
    False: {(None, None), (None, "FULL"), ("THREE", "FULL")},
}
_MATERIALS = ("MAT1", "MAT9", "MAT11")


def read_solids(model: Any, references: CardReferences) -> tuple[SolidBlock, ...]:
    """Blocks of solids of one card, number of nodes and integration each, ids ascending.

    Raises
    ------
    InputError
        For a material that is not positive definite.
    """
    columns = columns_of(model)
    e = columns.element
    solid = e.is_of(SOLID_CARDS)
    pids = np.unique(e.property_id[solid]).tolist()
    table = [_material(model, references, pid) for pid in pids]
    materials = SolidMaterials(
        stiffness=np.array([stiffness for stiffness, _, _ in table]).reshape(-1, 6, 6),
        expansion=np.array([expansion for _, expansion, _ in table]).reshape(-1, 6),
        reference_temperature=np.array([tref for _, _, tref in table], dtype=np.float64),
    )
    groups: dict[tuple[str, int, bool], list[int]] = {}
    for number, element in enumerate(columns.examples()):
        if element.type in SOLID_CARDS:
            prop = model.properties.get(element.pid)
            bubble = prop is not None and prop.type == "PSOLID" and _has_bubble(element, prop)
            groups.setdefault((element.type, len(element.nodes), bubble), []).append(number)

    def block(card: str, nodes: int, bubble: bool, numbers: list[int]) -> SolidBlock:
        rows = np.flatnonzero(np.isin(columns.alike.number, numbers))
        node = e.node_id[e.node_offset[rows][:, None] + np.arange(nodes)]
        return SolidBlock(
            card=card,
            element_id=e.id[rows],
            connectivity=references.rows(node, card, e.id[rows]),
            material=np.searchsorted(pids, e.property_id[rows]),
            materials=materials,
            bubble=bubble,
        )

    return tuple(block(*kind, numbers) for kind, numbers in sorted(groups.items(), key=lambda group: group[0]))


def count_refused_solids(model: Any, found: Counter[str]) -> None:
    """Add to `found` what solids ask for that is not modelled."""
    columns = columns_of(model)
    for element, count in zip(columns.examples(), columns.alike.count.tolist(), strict=True):
        if element.type in SOLID_CARDS:
            if None in element.nodes:
                found[f"{element.type} with some midside nodes missing"] += count
            prop = model.properties.get(element.pid)
            if prop is not None and prop.type == "PSOLID":
                for feature in _refused(model, element, prop):
                    found[feature] += count


def _has_bubble(element: Any, prop: Any) -> bool:
    """Nastran's default for linear hexahedra and pentahedra."""
    return element.type != "CTETRA" and _is_linear(element) and prop.integ != "TWO" and prop.isop != "FULL"


def _is_linear(element: Any) -> bool:
    return len(element.nodes) == corner_count(element.type)


def _refused(model: Any, element: Any, prop: Any) -> list[str]:
    """Names of what a solid's property asks for that is not modelled."""
    out = []
    if prop.fctn != "SMECH":
        out.append(f"PSOLID with FCTN={prop.fctn}")
    if element.type != "CTETRA" and (prop.integ, prop.isop) not in _MODELLED[_is_linear(element)]:
        fields = f"IN={prop.integ or ''}, ISOP={prop.isop or ''}"
        out.append(f"{element.type} of {len(element.nodes)} nodes with PSOLID {fields}")
    material = model.materials.get(prop.mid)
    if material is not None and material.type in ("MAT9", "MAT11"):
        system = model.coords.get(prop.cordm)
        if prop.cordm == -1:
            out.append(f"{material.type} in element axes, PSOLID CORDM=-1")
        elif system is not None and not system.type.endswith("R"):
            out.append(f"{material.type} in a curvilinear system, PSOLID CORDM={prop.cordm} ({system.type})")
    return out


def _material(model: Any, references: CardReferences, pid: int) -> tuple[FloatArray, FloatArray, float]:
    """Stiffness, expansion (basic frame) and reference temperature of a property; any where cards are missing."""
    prop = references.card(model.properties, pid, "PSOLID", who="elements")
    found = None if prop is None else model.materials.get(prop.mid)
    if prop is None or found is None or found.type not in _MATERIALS:
        if prop is not None:
            references.card(model.materials, prop.mid, *_MATERIALS, who=f"PSOLID {pid}")
        return np.eye(6), np.zeros(6), 0.0
    if found.type == "MAT1":
        if not (found.e > 0.0 and -1.0 < found.nu < 0.5):
            raise InputError(
                f"MAT1 {found.mid}: E = {found.e:g} and NU = {found.nu:g} are not those of a solid",
                where=references.where,
            )
        # Solids follow E and NU; a G that does not fit them is for bars and plates alone, as in Nastran.
        expansion = np.array([found.a] * 3 + [0.0] * 3)
        return isotropic_stiffness(found.e, found.nu), expansion, float(found.tref)
    stiffness, expansion = _anisotropic(found, references)
    if not np.linalg.eigvalsh(stiffness).min() > 0.0:
        raise InputError(f"{found.type} {found.mid}: the stiffness is not positive definite", where=references.where)
    if prop.cordm > 0:
        if prop.cordm not in model.coords:
            references.card(model.coords, prop.cordm, "CORD1R", "CORD2R", who=f"PSOLID {pid}")
        else:
            stiffness, expansion = rotated(stiffness, expansion, _axes(model, prop.cordm))
    return stiffness, expansion, float(found.tref)


def _anisotropic(card: Any, references: CardReferences) -> tuple[FloatArray, FloatArray]:
    """Stiffness [6, 6] and expansion [6] of a MAT9 or MAT11 in its own axes."""
    if card.type == "MAT9":
        return anisotropic_stiffness(card), np.array(card.A, dtype=np.float64)
    young, shear = np.array([card.e1, card.e2, card.e3]), np.array([card.g12, card.g13, card.g23])
    if not (young.min() > 0.0 and shear.min() > 0.0):
        raise InputError(f"MAT11 {card.mid}: E1, E2, E3, G12, G13 and G23 must be positive", where=references.where)
    stiffness = orthotropic_stiffness(young, np.array([card.nu12, card.nu13, card.nu23]), shear)
    return stiffness, np.array([card.a1, card.a2, card.a3, 0.0, 0.0, 0.0])


def _axes(model: Any, cid: int) -> FloatArray:
    """Axes of a rectangular system as rows, [3, 3], in the basic frame."""
    nothing = ("elements", "properties", "masses", "materials", "loads", "constraints", "aero", "sets", "optimization")
    model.cross_reference(**{f"xref_{name}": False for name in nothing}, xref_nodes_with_elements=False)
    return np.array(model.coords[cid].beta(), dtype=np.float64)
