"""Shell elements of a deck: CQUAD4 and CTRIA3 of one isotropic layer (PSHELL, MAT1)."""

from __future__ import annotations

from typing import Any

import numpy as np

from tedm_cli.arrays import FloatArray
from tedm_cli.errors import InputError
from tedm_cli.fem.structure import ShellBlock
from tedm_cli.nastran.parameter_values import number_parameter
from tedm_cli.nastran.structure.references import CardReferences

# Weight of the tie of rotations about the normal: PARAM K6ROT, by default 100, times 1e-6 of the membrane's shear
# stiffness (Nastran Quick Reference Guide).
_K6ROT, _K6ROT_UNIT = 100.0, 1e-6


def read_shells(model: Any, references: CardReferences, card: str) -> ShellBlock:
    """All shells of one card, CQUAD4 or CTRIA3."""
    n = 4 if card == "CQUAD4" else 3
    shells = [element for _, element in sorted(model.elements.items()) if element.type == card]
    membrane, bending = np.zeros((len(shells), 3, 3)), np.zeros((len(shells), 3, 3))
    shear, expansion, bending_expansion, reference = (np.zeros(len(shells)) for _ in range(4))
    for k, shell in enumerate(shells):
        prop = references.card(model.properties, shell.pid, "PSHELL", who=f"{card} {shell.eid}")
        if prop is None:
            continue
        thickness = corner_thickness(shell, prop)[0]
        first, second, third = (
            None if mid is None else references.card(model.materials, mid, "MAT1", who=f"PSHELL {prop.pid}")
            for mid in (prop.mid1, prop.mid2, prop.mid3)
        )
        if first is not None:
            membrane[k] = thickness * _plane_stress(first, references.where)
            expansion[k], reference[k] = first.a, first.tref
        if second is not None:
            bending[k] = prop.twelveIt3 * thickness**3 / 12.0 * _plane_stress(second, references.where)
            bending_expansion[k] = second.a
            shear[k] = np.inf if third is None else prop.tst * thickness * third.g
    weight = _K6ROT_UNIT * number_parameter(model, "K6ROT", _K6ROT, references.where)
    return ShellBlock(
        element_id=np.array([shell.eid for shell in shells], dtype=np.int64),
        connectivity=references.rows([s.nodes for s in shells], card, [s.eid for s in shells]).reshape(-1, n),
        membrane_stiffness=membrane,
        bending_stiffness=bending,
        shear_stiffness=shear,
        drilling_stiffness=weight * membrane[:, 2, 2],
        offset=np.array([shell.zoffset or 0.0 for shell in shells], dtype=np.float64),
        expansion=expansion,
        bending_expansion=bending_expansion,
        reference_temperature=reference,
    )


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
