"""Materials and shells in adjoint.h5, ranked by what a little more of each of their properties does to an output."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tedm_cli.arrays import BoolArray, FloatArray
from tedm_cli.contracts import ADJOINT
from tedm_cli.files.store import Reader
from tedm_cli.results.ranking import first_largest

# An output that is this small beside the largest of its block is zero by symmetry, or nearly so: a share of it says
# nothing, and unit loads in single precision are no more exact.
_NOTHING = 1e-3


@dataclass(frozen=True)
class MaterialEffect:
    """What one property of a material or of shells does to the output that it changes most.

    quantity : modulus, expansion, density or thickness. of, used_by : "MAT1 3", and the properties that name it.
    change : relative change of the output's root mean square over that of the property, where the temperatures of all
        areas of a mean temperature vary independently and by as much. area : through which most of it comes.
    """

    quantity: str
    of: str
    used_by: str
    output: str
    change: float
    area: str


def material_effects(file: Reader, value: FloatArray, block: list[str], means: BoolArray) -> list[MaterialEffect]:
    """Of every property its largest effect, largest first.

    The root mean square of an output is in proportion to the root of Σ S² over the areas, and it changes by Σ S dS over
    Σ S², with dS by the logarithm of the property. Those of all expansions sum to one where nothing but the structure
    acts on the output, those of all moduli to zero.

    Parameters
    ----------
    value : [r, k], S_SG and N. block : [r], see adjoint.h5. means : [k], areas of a mean temperature.
    """
    s = value[:, means]
    power = (s**2).sum(axis=1)
    names = np.array(block)
    largest = np.array([power[names == name].max(initial=0.0) for name in block])
    rows = np.flatnonzero(power > _NOTHING**2 * largest)
    if not rows.size:
        return []
    labels = file.strings(ADJOINT.ROW_LABEL)
    areas = np.array(file.strings(ADJOINT.AREA_NAME))[means].tolist()
    cards, ids = file.strings(ADJOINT.MATERIAL_CARD), file.array(ADJOINT.MATERIAL_ID)
    materials = [f"{card} {mid}" for card, mid in zip(cards, ids, strict=True)]
    shells = [f"PSHELL {pid}" for pid in file.array(ADJOINT.SHELL_PROPERTY_ID)]
    used_by = file.strings(ADJOINT.MATERIAL_USED_BY)
    out = []
    for quantity, path, owners, users in (
        ("modulus", ADJOINT.DS_DLNE, materials, used_by),
        ("expansion", ADJOINT.DS_DLNALPHA, materials, used_by),
        ("density", ADJOINT.DS_DLNRHO, materials, used_by),
        ("thickness", ADJOINT.DS_DLNT, shells, [""] * len(shells)),
    ):
        terms = file.array(path)[:, rows][:, :, means] * s[rows] / power[rows, None]
        for owner, user, term in zip(owners, users, terms, strict=True):
            change = term.sum(axis=1)
            row = first_largest(range(len(rows)), np.abs(change).tolist())
            if change[row]:
                area = first_largest(areas, np.abs(term[row]).tolist())
                out.append(MaterialEffect(quantity, owner, user, labels[rows[row]], float(change[row]), area))
    return sorted(out, key=lambda effect: -abs(effect.change))
