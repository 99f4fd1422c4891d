"""Arrays as text of a page: displacements in 16 bits, numbers in full, deflated where that is worth it."""

from __future__ import annotations

import base64
import zlib
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tedm_cli.arrays import AnyArray, FloatArray

STEPS = 32767  # of the largest value, on either side of zero


@dataclass(frozen=True, eq=False)
class Quantised:
    """Rows of numbers in 16 bits: `scale` [k] times `step` [k, m]. A row of zeros has the scale 0."""

    scale: FloatArray
    step: NDArray[np.int16]

    def values(self) -> FloatArray:
        """The numbers [k, m] that these stand for."""
        return self.scale[:, None] * self.step


def quantised(values: FloatArray) -> Quantised:
    """Rows [k, m], each to within half a step, a step being 1/32767 of the row's largest value."""
    scale = np.abs(values).max(axis=1, initial=0.0) / STEPS
    steps = np.divide(values, scale[:, None], out=np.zeros_like(values), where=scale[:, None] > 0.0)
    return Quantised(scale, np.rint(steps).astype(np.int16))


def numbers(values: AnyArray) -> dict[str, Any]:
    """Numbers as they are, for arithmetic that must not lose a digit: little-endian 64-bit floats."""
    array = np.ascontiguousarray(values, dtype="<f8")
    return {"shape": list(array.shape), "float64": _text(array.tobytes())}


def steps(values: NDArray[np.int16]) -> dict[str, Any]:
    """16-bit rows [k, m], deflated: differences along a row, low bytes apart from high ones, which are mostly zero."""
    change = np.diff(values, axis=1, prepend=np.int16(0)).astype("<i2")
    planes = np.ascontiguousarray(np.moveaxis(change.view(np.uint8).reshape(*change.shape, 2), -1, 0))
    return {"shape": list(values.shape), "int16": _deflated(planes.tobytes())}


def places(values: AnyArray) -> dict[str, Any]:
    """Rows of tables, and -1 for none: 32-bit integers, deflated."""
    array = np.ascontiguousarray(values, dtype="<i4")
    planes = np.ascontiguousarray(np.moveaxis(array.view(np.uint8).reshape(*array.shape, 4), -1, 0))
    return {"shape": list(array.shape), "int32": _deflated(planes.tobytes())}


def coordinates(values: FloatArray) -> dict[str, Any]:
    """Positions for drawing: 32-bit floats, deflated."""
    array = np.ascontiguousarray(values, dtype="<f4")
    planes = np.ascontiguousarray(np.moveaxis(array.view(np.uint8).reshape(*array.shape, 4), -1, 0))
    return {"shape": list(array.shape), "float32": _deflated(planes.tobytes())}


def _deflated(raw: bytes) -> str:
    return _text(zlib.compress(raw, 9))


def _text(raw: bytes) -> str:
    return base64.b64encode(raw).decode("ascii")
