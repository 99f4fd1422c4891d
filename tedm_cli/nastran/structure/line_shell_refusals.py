"""Features of line, shell and rigid elements that the embedded solver does not model, by name with counts."""

from __future__ import annotations

from collections import Counter
from typing import Any

import numpy as np

from tedm_cli.nastran.bulk.columns import columns_of
from tedm_cli.nastran.structure.bars import section
from tedm_cli.nastran.structure.rigid import leading_end
from tedm_cli.nastran.structure.sections import SECTIONS
from tedm_cli.nastran.structure.shells import corner_thickness

# Offsets and orientation in the displacement frames of the grids.
_GRID_FRAMES = "GGG"


def line_refusals(model: Any, used: set[int]) -> Counter[str]:
    """Features of bars, beams and rods; `used` are the properties that elements refer to."""
    found: Counter[str] = Counter()
    for element in columns_of(model).element_cards.values():
        if element.type in ("CBAR", "CBEAM"):
            offset = np.any(element.wa) or np.any(element.wb)
            # The first letter is about the orientation vector, which G0 replaces.
            code = str(element.offt or _GRID_FRAMES)
            turned = code[0] != "G" and not element.g0
            found[f"{element.type} with OFFT {code}"] += bool(turned or (code[1:] != "GG" and offset))
        if element.type == "CBEAM":
            found["CBEAM with warping points SA/SB"] += bool(element.sa or element.sb)
            found["CBEAM with a BIT field"] += element.bit is not None
    for pid in used & model.properties.keys():
        prop = model.properties[pid]
        if prop.type == "PBEAM":
            found["PBEAM that tapers"] += any(np.ptp(row) > 0.0 for row in (prop.A, prop.i1, prop.i2, prop.i12, prop.j))
            found["PBEAM with shear relief S1/S2"] += bool(prop.s1 or prop.s2)
            found["PBEAM with warping CW"] += bool(prop.cwa or prop.cwb)
            found["PBEAM with an offset neutral axis N1/N2"] += any((prop.n1a, prop.n2a, prop.n1b, prop.n2b))
            found["PBEAM with I12 and shear factors"] += bool(prop.i12.any() and np.isfinite(section(prop)[5:]).any())
        if prop.type == "PBEAML":
            found["PBEAML that tapers"] += bool(np.ptp(prop.dim, axis=0).any())
        if prop.type in ("PBARL", "PBEAML"):
            found[f"{prop.type} with section {prop.beam_type}"] += prop.beam_type not in SECTIONS
        if prop.type == "PTUBE":
            found["PTUBE that tapers"] += prop.OD1 != prop.OD2
    return found


def shell_refusals(model: Any, used: set[int]) -> Counter[str]:
    """Features of shells; `used` are the properties that elements refer to."""
    found: Counter[str] = Counter()
    columns = columns_of(model)
    for element, count in zip(columns.examples(), columns.alike.count.tolist(), strict=True):
        if element.type not in ("CQUAD4", "CTRIA3"):
            continue
        prop = model.properties.get(element.pid)
        is_shell = prop is not None and prop.type == "PSHELL"
        if is_shell and (prop.t is None or np.ptp(corner_thickness(element, prop)) > 0.0):
            found[f"{element.type} with unequal corner thicknesses Ti"] += count
    for pid in used & model.properties.keys():
        prop = model.properties[pid]
        if prop.type == "PSHELL":
            found["PSHELL with membrane-bending coupling MID4"] += prop.mid4 is not None
            found["PSHELL in plane strain (MID2 = -1)"] += prop.mid2 == -1
            alien = [
                mid
                for mid in (prop.mid1, prop.mid2, prop.mid3)
                if mid in model.materials and mid not in _isotropic(model)
            ]
            found["PSHELL with a material other than MAT1"] += bool(alien)
    return found


def _isotropic(model: Any) -> set[int]:
    return {mid for mid, material in model.materials.items() if material.type == "MAT1"}


def rigid_refusals(model: Any) -> Counter[str]:
    """Features of rigid elements."""
    found: Counter[str] = Counter()
    for element in model.rigid_elements.values():
        found[f"{element.type} with thermal expansion ALPHA"] += bool(getattr(element, "alpha", 0.0))
        found["RBE3 with moved dependents UM"] += element.type == "RBE3" and bool(element.Gmi)
        found["RBAR with independent freedoms at both ends"] += element.type == "RBAR" and leading_end(element) is None
    return found
