"""The outputs of a build folder as nodal forces, with what its matrices say of them."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tedm_cli.adjoint.outputs import acceleration_outputs, read_out_outputs
from tedm_cli.arrays import FloatArray, IntArray
from tedm_cli.contracts import DISTORTION, SENSITIVITY
from tedm_cli.distortion import ROUNDING
from tedm_cli.errors import InputError
from tedm_cli.files.blocks import node_blocks
from tedm_cli.files.store import Reader
from tedm_cli.optics.layout import OpticalLayout
from tedm_cli.results.optics import read_read_outs


@dataclass(frozen=True, eq=False, kw_only=True)
class Outputs:
    """r outputs of a structure of N grids, with k thermal areas.

    label, unit, block : [r], as in adjoint.h5.
    force : [6 N, r], each output as nodal forces and moments by m and rad, basic frame.
    wanted : [r, k], its column of S_SG or N by the unit loads.
    direct : [r, k], the part of it that is not by the motion of grids.
    rounding : [r, k], how far it may be off because the displacements of the unit loads are in single precision.
    """

    label: list[str]
    unit: list[str]
    block: list[str]
    force: FloatArray
    wanted: FloatArray
    direct: FloatArray
    rounding: FloatArray

    def __add__(self, other: Outputs) -> Outputs:
        return Outputs(
            label=self.label + other.label,
            unit=self.unit + other.unit,
            block=self.block + other.block,
            force=np.concatenate([self.force, other.force], axis=1),
            wanted=np.concatenate([self.wanted, other.wanted]),
            direct=np.concatenate([self.direct, other.direct]),
            rounding=np.concatenate([self.rounding, other.rounding]),
        )


def accelerations(file: Reader, distortion: Reader) -> Outputs:
    """Of the test masses, by sensitivity.h5; offset and tied compensation masses are in its operator."""
    unit = file.strings(SENSITIVITY.ROW_UNIT)
    wanted = file.array(SENSITIVITY.S)
    operator, rotation = file.array(SENSITIVITY.OPERATOR_G), file.array(SENSITIVITY.OPERATOR_G_ROTATION)
    terms = _sizes(operator, distortion, DISTORTION.D_TRANSLATION)
    terms += _sizes(rotation, distortion, DISTORTION.D_ROTATION)
    return Outputs(
        label=file.strings(SENSITIVITY.ROW_LABEL),
        unit=unit,
        block=[f"S_SG, {u}" for u in unit],
        force=acceleration_outputs(operator, file.array(SENSITIVITY.OPERATOR_OFFSET_NODE), rotation),
        wanted=wanted,
        direct=np.zeros_like(wanted),
        rounding=ROUNDING * terms,
    )


def _sizes(operator: FloatArray, distortion: Reader, path: str) -> FloatArray:
    """Sums of |G_n| |D_n| [r, k] over the grids n of an operator [r, n, 3] and its dataset of [D], read in parts."""
    d, size = distortion.dataset(path), np.linalg.norm(operator, axis=2)
    out = np.zeros((len(operator), d.shape[0]))
    for area in range(d.shape[0]):
        for block in node_blocks(d.shape[1]):
            out[:, area] += size[:, block] @ np.linalg.norm(d[area, block], axis=1)
    return out


def read_outs(file: Reader, layout: OpticalLayout, where: Path, grid_id: IntArray) -> Outputs:
    """Of every set of photodiodes, by optics.h5; direct is what faces of test masses and the glass of plates do.

    Raises
    ------
    InputError : a grid of an optical element of the layout in the file `where` is not among `grid_id` [N].
    """
    found = read_read_outs(file)
    bench, faces = layout.columns_of(layout.bench), layout.columns_of(layout.test_masses)
    wanted = np.array([e.grid for e in layout.bench], dtype=np.int64)
    node = np.searchsorted(grid_id, wanted).clip(max=len(grid_id) - 1)
    absent = [f"{e.name} (grid {e.grid})" for e, n in zip(layout.bench, node, strict=True) if grid_id[n] != e.grid]
    if absent:
        raise InputError(f"optical elements whose grid the model lacks: {', '.join(absent)}", where=str(where))
    gain = np.concatenate([found.gain[name] for name in found.sets])
    unit = [f"{u}/K" for _ in found.sets for u in found.unit]
    return Outputs(
        label=found.names,
        unit=unit,
        block=[f"N of set {name}, {u}/K" for name in found.sets for u in found.unit],
        force=read_out_outputs(gain[:, bench], layout.axes, node, len(grid_id)),
        wanted=np.concatenate([found.N[name] for name in found.sets]),
        direct=gain[:, faces] @ found.motion[faces] + np.concatenate([found.N_plates(name) for name in found.sets]),
        rounding=ROUNDING * (_by_three(gain[:, bench]) @ _by_three(found.motion[bench].T).T),
    )


def _by_three(values: FloatArray) -> FloatArray:
    """Sizes [m, n] of the vectors in [m, 3 n]: translations and rotations, in any frame."""
    return np.asarray(np.linalg.norm(values.reshape(len(values), -1, 3), axis=2))
