"""Bar elements of a deck: CBAR, and CBEAM where it is a uniform bar."""

from __future__ import annotations

from typing import Any

import numpy as np

from tedm_cli.arrays import FloatArray
from tedm_cli.errors import InputError
from tedm_cli.fem.structure import BarBlock
from tedm_cli.nastran.bulk.columns import columns_of
from tedm_cli.nastran.structure.references import CardReferences, material_of
from tedm_cli.nastran.structure.sections import SECTIONS

# PBAR's shear factors default to zero in Nastran, "infinitely stiff"; pyNastran writes that as 1e8.
_RIGID_IN_SHEAR = 1e7
_KINDS = {"CBAR": ("PBAR", "PBARL"), "CBEAM": ("PBEAM", "PBEAML")}


def read_bars(model: Any, references: CardReferences, position: FloatArray, frame: FloatArray | None) -> BarBlock:
    """All bars.

    Parameters
    ----------
    position : [N, 3], m.
    frame : [N, 3, 3], the grids' displacement frames, in which orientation vectors and offsets are given, or None.
    """
    own = columns_of(model).element_cards  # no bar is without an object
    ids = sorted(eid for eid, element in own.items() if element.type in _KINDS)
    bars = [own[eid] for eid in ids]
    table = np.ones((11, len(ids)))
    pids = np.array([bar.pid for bar in bars], dtype=np.int64)
    kinds = np.array([bar.type for bar in bars], dtype=str)
    for pid in np.unique(pids):
        for kind in np.unique(kinds[pids == pid]):
            prop, mat = material_of(model, references, int(pid), *_KINDS[kind])
            if mat is not None:
                _require_section(prop, references.where)
                rows = (pids == pid) & (kinds == kind)
                table[:, rows] = np.array([*section(prop), mat.e, mat.g, mat.a, mat.tref])[:, None]
    nodes = references.rows([bar.nodes for bar in bars], "CBAR and CBEAM", ids).reshape(-1, 2)
    orientation, offset = np.zeros((len(bars), 3)), np.zeros((len(bars), 2, 3))
    released = np.zeros((len(bars), 12), dtype=np.bool_)
    axes = np.eye(3) if frame is None else frame
    for k, bar in enumerate(bars):
        ends = np.broadcast_to(axes, (len(position), 3, 3))[nodes[k]]
        if bar.g0:
            orientation[k] = position[references.rows(bar.g0, f"{bar.type} {bar.eid} G0")] - position[nodes[k, 0]]
        else:
            orientation[k] = ends[0] @ bar.x
        offset[k] = (ends @ np.stack([bar.wa, bar.wb])[:, :, None])[..., 0]
        for end, digits in enumerate((bar.pa, bar.pb)):
            released[k, [6 * end + digit - 1 for digit in _pins(bar, digits, references.where)]] = True
    return BarBlock(
        element_id=np.array(ids, dtype=np.int64),
        connectivity=nodes,
        area=table[0],
        inertia_1=table[1],
        inertia_2=table[2],
        inertia_12=table[3],
        torsion_constant=table[4],
        shear_factor=table[5:7].T,
        youngs_modulus=table[7],
        shear_modulus=table[8],
        expansion=table[9],
        reference_temperature=table[10],
        orientation=orientation,
        offset=offset,
        released=released,
    )


def _pins(bar: Any, digits: Any, where: str) -> list[int]:
    """Components 1 to 6 that an end releases."""
    pins = [int(digit) for digit in str(digits or "") if digit != "0"]
    if any(digit > 6 for digit in pins):
        raise InputError(
            f"{bar.type} {bar.eid}: pins {digits} are no components",
            where=where,
            hint="PA and PB are made of the digits 1 to 6",
        )
    return pins


def _require_section(prop: Any, where: str) -> None:
    """Refuse areas and moments below zero, which would pull where they should push."""
    for name, value in zip(("A", "I1", "I2", "", "J"), section(prop)[:5], strict=True):
        if name and not value >= 0.0:
            raise InputError(f"{prop.type} {prop.pid}: {name} = {value:g} is negative", where=where)


def section(prop: Any) -> tuple[float, ...]:
    """Area, I1, I2, I12, J, K1 and K2 of a bar property; infinite K where shear does not deform."""
    if prop.type == "PBARL":
        return SECTIONS[prop.beam_type](*prop.dim)
    if prop.type == "PBEAML":
        return SECTIONS[prop.beam_type](*prop.dim[0])
    if prop.type == "PBEAM":
        values = (prop.A[0], prop.i1[0], prop.i2[0], prop.i12[0], prop.j[0])
    else:
        values = (prop.A, prop.i1, prop.i2, prop.i12, prop.j)
    # None where the section has no area: such a bar does not stretch, as in Nastran.
    shear = (k if k is not None and 0.0 < k < _RIGID_IN_SHEAR else np.inf for k in (prop.k1, prop.k2))
    return tuple(float(value) for value in (*values, *shear))
