"""How outputs change with materials, thicknesses and positions of test masses: rows of all thermal areas."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from tedm_cli.arrays import BoolArray, FloatArray, IntArray
from tedm_cli.contracts import ADJOINT, SENSITIVITY
from tedm_cli.files.store import Reader
from tedm_cli.uncertainty.parameters import DENSITY, EXPANSION, MODULUS


@dataclass(frozen=True, eq=False)
class Derivatives:
    """Changes of r outputs under k areas by m materials and q properties of shells, as adjoint.h5 has them.

    label : [r]. material, card, used_by, expansion : [m], id, its card, properties that name it, and 1/K (NaN where it
    is not the same in all directions). by_logarithm : [m, r, k] of expansion, modulus and density.
    by_expansion : [m, r, k] by 1/K. shell_id : [q]. by_thickness : [q, r, k], by its logarithm.
    """

    label: list[str]
    material: IntArray
    card: list[str]
    used_by: list[str]
    expansion: FloatArray
    by_logarithm: dict[str, FloatArray]
    by_expansion: FloatArray
    shell_id: IntArray
    by_thickness: FloatArray

    def materials_of(self, wanted: Callable[[int], bool]) -> BoolArray:
        """Mask [m] of the materials that a wanted property names."""
        return np.array([any(wanted(pid) for pid in _ids(text)) for text in self.used_by], dtype=bool)

    @property
    def properties(self) -> list[int]:
        """Ids of the properties that name a material, ascending."""
        return sorted({pid for text in self.used_by for pid in _ids(text)})


def _ids(used_by: str) -> list[int]:
    """`PSHELL 3, PSOLID 1` as 3 and 1."""
    return [int(number) for number in re.findall(r"\b\d+\b", used_by)]


def read_derivatives(file: Reader) -> Derivatives | str:
    """What adjoint.h5 says of materials, or why there is no adjoint."""
    if file.has(ADJOINT.REFUSAL):
        return "; ".join(file.strings(ADJOINT.REFUSAL))
    return Derivatives(
        label=file.strings(ADJOINT.ROW_LABEL),
        material=file.array(ADJOINT.MATERIAL_ID),
        card=file.strings(ADJOINT.MATERIAL_CARD),
        used_by=file.strings(ADJOINT.MATERIAL_USED_BY),
        expansion=file.array(ADJOINT.MATERIAL_EXPANSION),
        by_logarithm={
            EXPANSION: file.array(ADJOINT.DS_DLNALPHA),
            MODULUS: file.array(ADJOINT.DS_DLNE),
            DENSITY: file.array(ADJOINT.DS_DLNRHO),
        },
        by_expansion=file.array(ADJOINT.DS_DALPHA),
        shell_id=file.array(ADJOINT.SHELL_PROPERTY_ID),
        by_thickness=file.array(ADJOINT.DS_DLNT),
    )


def read_position_rows(file: Reader, test_mass: str, axis: int) -> dict[str, FloatArray] | None:
    """Rows [k] of sensitivity.h5 by its outputs' changes when a test mass moves along an axis of the basic frame.

    Outputs of other test masses do not change. None: the file has none.
    """
    if not file.has(SENSITIVITY.DS_DPOSITION):
        return None
    change = file.array(SENSITIVITY.DS_DPOSITION)[:, axis]
    return {
        label: row if label.split("_")[0] == test_mass else np.zeros_like(row)
        for label, row in zip(file.strings(SENSITIVITY.ROW_LABEL), change, strict=True)
    }
