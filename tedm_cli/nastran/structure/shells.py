"""Shell elements of a deck: CQUAD4 and CTRIA3 of one isotropic layer (PSHELL, MAT1)."""

from __future__ import annotations

from typing import Any

import numpy as np

from tedm_cli.arrays import FloatArray
from tedm_cli.errors import InputError
from tedm_cli.fem.structure import ShellBlock
from tedm_cli.nastran.bulk.columns import columns_of
from tedm_cli.nastran.parameter_values import number_parameter
from tedm_cli.nastran.structure.references import CardReferences

# Weight of the tie of rotations about the normal: PARAM K6ROT, by default 100, times 1e-6 of the membrane's shear
# stiffness (Nastran Quick Reference Guide).
_K6ROT, _K6ROT_UNIT = 100.0, 1e-6
_NO_LAW = object()


def read_shells(model: Any, references: CardReferences, card: str) -> ShellBlock:
    """All shells of one card, CQUAD4 or CTRIA3."""
    n = 4 if card == "CQUAD4" else 3
    columns = columns_of(model)
    e = columns.element
    rows = np.flatnonzero(e.is_of([card]))
    membrane, bending = np.zeros((len(rows), 3, 3)), np.zeros((len(rows), 3, 3))
    shear, expansion, bending_expansion, reference = (np.zeros(len(rows)) for _ in range(4))
    alike = columns.alike.number[rows]
    for number, example in zip(*np.unique(alike, return_index=True), strict=True):
        shell, k = model.elements[int(e.id[rows[example]])], np.flatnonzero(alike == number)
        for eid in e.id[rows[k]].tolist():  # each that lacks a card is named
            prop, laws = _cards(model, references, shell.pid, f"{card} {eid}")
            if prop is not None and None not in laws:
                break
        if prop is None:
            continue
        thickness = corner_thickness(shell, prop)[0]
        first, second, third = (None if law is _NO_LAW else law for law in laws)
        if first is not None:
            membrane[k] = thickness * _plane_stress(first, references.where)
            expansion[k], reference[k] = first.a, first.tref
        if second is not None:
            bending[k] = prop.twelveIt3 * thickness**3 / 12.0 * _plane_stress(second, references.where)
            bending_expansion[k] = second.a
            shear[k] = np.inf if third is None else prop.tst * thickness * third.g
    weight = _K6ROT_UNIT * number_parameter(model, "K6ROT", _K6ROT, references.where)
    return ShellBlock(
        element_id=e.id[rows],
        connectivity=references.rows(e.node_id[e.node_offset[rows][:, None] + np.arange(n)], card, e.id[rows]),
        membrane_stiffness=membrane,
        bending_stiffness=bending,
        shear_stiffness=shear,
        drilling_stiffness=weight * membrane[:, 2, 2],
        offset=columns.plate_offsets(e.id[rows]),
        expansion=expansion,
        bending_expansion=bending_expansion,
        reference_temperature=reference,
    )


def _cards(model: Any, references: CardReferences, pid: int, who: str) -> tuple[Any, list[Any]]:
    """The property of a shell, and its three materials: `_NO_LAW` where it has none, None where a card is missing."""
    prop = references.card(model.properties, pid, "PSHELL", who=who)
    mids = () if prop is None else (prop.mid1, prop.mid2, prop.mid3)
    return prop, [
        _NO_LAW if mid is None else references.card(model.materials, mid, "MAT1", who=f"PSHELL {prop.pid}")
        for mid in mids
    ]


def corner_thickness(shell: Any, prop: Any) -> list[float]:
    """Thickness at each corner: given there (in units of the property's with TFLAG 1), else the property's."""
    given = [getattr(shell, f"T{k}") for k in range(1, len(shell.nodes) + 1)]
    unit = prop.t if shell.tflag else 1.0
    return [float(prop.t if value is None else unit * value) for value in given]


def _plane_stress(material: Any, where: str) -> FloatArray:
    """Stresses over strains in plane stress, [3, 3], Pa."""
    if abs(material.g * 2.0 * (1.0 + material.nu) / material.e - 1.0) > 0.01:
        raise InputError(f"MAT1 {material.mid}: E, G and NU of a shell do not agree within 1 %", where=where)
    direct = material.e / (1.0 - material.nu**2)
    return np.array([[direct, material.nu * direct, 0.0], [material.nu * direct, direct, 0.0], [0.0, 0.0, material.g]])
