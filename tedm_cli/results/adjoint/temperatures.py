"""What adjoint.h5 says of the temperatures of grids, and of thermal areas, for maps of other temperatures on them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tedm_cli.arrays import BoolArray, FloatArray, IntArray
from tedm_cli.contracts import ADJOINT
from tedm_cli.files.store import Reader
from tedm_cli.noise.areas import AreaTable
from tedm_cli.results.areas import read_areas


@dataclass(frozen=True, eq=False, kw_only=True)
class TemperatureEffects:
    """What temperatures do to r outputs.

    label, unit : [r]. grid_id : [N]. grid : [r, N], per kelvin of a grid, of what takes the temperatures of its grids.
    own_id, own : [L] and [r, L], elements that have temperatures of their own in an area, per kelvin of them.
    areas : k of them. of_area : [r, k], their columns of S_SG and N. direct : [r, k], the part of these that does not
    pass through the structure.
    """

    label: list[str]
    unit: list[str]
    grid_id: IntArray
    grid: FloatArray
    own_id: IntArray
    own: FloatArray
    areas: AreaTable
    of_area: FloatArray
    direct: FloatArray


def read_temperature_effects(file: Reader) -> TemperatureEffects | None:
    """What adjoint.h5 says; None where it says why there is no adjoint."""
    if file.has(ADJOINT.REFUSAL):
        return None
    own: BoolArray = file.array(ADJOINT.ELEMENT_OWN) == 1
    direct = file.array(ADJOINT.DIRECT)
    return TemperatureEffects(
        label=file.strings(ADJOINT.ROW_LABEL),
        unit=file.strings(ADJOINT.ROW_UNIT),
        grid_id=file.array(ADJOINT.GRID_ID),
        grid=file.array(ADJOINT.S),
        own_id=file.array(ADJOINT.ELEMENT_ID)[own],
        own=file.array(ADJOINT.ELEMENT_MEAN)[:, own],
        areas=read_areas(file),
        of_area=np.asarray(file.array(ADJOINT.AREA_SUM) + direct),
        direct=direct,
    )
