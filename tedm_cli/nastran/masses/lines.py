"""Rods, tubes, bars and beams: mass per length at their ends, their offsets and tapers (Nastran Quick Reference Guide).

The element lies between its ends A and B, which are its grids plus WA and WB; its length is that between the ends. On a
CBEAM that is the axis of shear centres: the structural mass lies (N1, N2), the non-structural mass (M1, M2) off it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from tedm_cli.arrays import FloatArray
from tedm_cli.errors import InputError
from tedm_cli.nastran.masses.spread import Spread, ToBasic, density_of

_BARS = ("CBAR", "CBEAM")


def _nothing() -> FloatArray:
    return np.zeros((2, 2))


@dataclass(frozen=True)
class _Line:
    """A property: mass per length at ends A and B (structural; non-structural), mean section.

    neutral, loads : [end, (1, 2)], of the structural and the non-structural mass from the axis, along the element's y
    and z, m.
    """

    structural: FloatArray
    nonstructural: FloatArray
    section: float
    neutral: FloatArray = field(default_factory=_nothing)
    loads: FloatArray = field(default_factory=_nothing)


def line_spread(elements: Sequence[Any], position: FloatArray, to_basic: ToBasic, where: str) -> Spread:
    """Mass of line elements whose grids are at `position` [E, 2, 3].

    Raises
    ------
    InputError : a property or an offset of a kind that is not read, an orientation along the element.
    """
    known: dict[int, _Line] = {}
    lines = []
    for element in elements:
        key = int(element.eid) if element.type == "CONROD" else int(element.pid)
        if key not in known:
            known[key] = _conrod(element, where) if element.type == "CONROD" else _line(element.pid_ref, where)
        lines.append(known[key])
    axis = np.zeros((len(elements), 2, 3))
    neutral, loads = np.zeros_like(axis), np.zeros_like(axis)
    if elements[0].type in _BARS:
        for i, (element, line) in enumerate(zip(elements, lines, strict=True)):
            axis[i] = _offsets(element, position[i], to_basic, where)
            if line.neutral.any() or line.loads.any():
                frame = line_frame(element, position[i], to_basic, where)
                neutral[i], loads[i] = line.neutral @ frame[1:], line.loads @ frame[1:]
    return Spread(
        structural=np.array([line.structural for line in lines]),
        nonstructural=np.array([line.nonstructural for line in lines]),
        axis=axis,
        structural_lever=axis + neutral,
        nonstructural_lever=axis + loads,
        section=np.array([line.section for line in lines]),
    )


def _conrod(element: Any, where: str) -> _Line:
    density = density_of(element.mid_ref, f"CONROD {element.eid}", where)
    if float(element.A) < 0.0:
        raise InputError(f"CONROD {element.eid}: a section of {float(element.A):.4g} is negative", where=where)
    return _even(density, float(element.A), float(element.nsm or 0.0))


def _even(density: float, area: float, nonstructural: float) -> _Line:
    return _Line(np.full(2, density * area), np.full(2, nonstructural), area)


def _line(prop: Any, where: str) -> _Line:
    name = f"{prop.type} {prop.pid}"
    if prop.type not in ("PROD", "PTUBE", "PBAR", "PBARL", "PBEAM", "PBEAML", "PBCOMP"):
        raise InputError(f"{name}: line elements with this property are not read", where=where)
    density = density_of(prop.mid_ref, name, where)
    if prop.type in ("PROD", "PBAR", "PBARL"):
        return _even(density, float(prop.Area()), float(prop.nsm or 0.0))
    if prop.type == "PTUBE":
        area = np.array([_ring(float(d), float(prop.t)) for d in (prop.OD1, prop.OD2)])
        return _Line(density * area, np.full(2, float(prop.nsm or 0.0)), float(area.mean()))
    if prop.type == "PBCOMP":
        line = _even(density, float(prop.A), float(prop.nsm or 0.0))
        return _Line(line.structural, line.nonstructural, line.section, *_both_ends(prop))
    station = np.asarray(prop.xxb, dtype=float)
    nonstructural = np.asarray(prop.nsm, dtype=float)
    area = np.asarray(prop.A, dtype=float) if prop.type == "PBEAM" else _library_area(prop)
    order = np.argsort(station, kind="stable")
    ends = [_ends(station[order], value[order]) for value in (area, nonstructural)]
    neutral, loads = _both_ends(prop) if prop.type == "PBEAM" else (_nothing(), _nothing())
    return _Line(density * ends[0], ends[1], float(ends[0].mean()), neutral, loads)


def _ring(diameter: float, wall: float) -> float:
    """Area of a tube; solid where the wall reaches the middle or is not given."""
    inner = max(diameter - 2.0 * wall, 0.0) if wall else 0.0
    return float(np.pi * (diameter**2 - inner**2) / 4.0)


def _library_area(prop: Any) -> FloatArray:
    """Areas of a PBEAML at its stations."""
    from pyNastran.bdf.cards.properties.bars import _bar_areaL

    return np.array([float(_bar_areaL("PBEAML", prop.beam_type, dim, prop)[0]) for dim in prop.dim])


def _both_ends(prop: Any) -> tuple[FloatArray, FloatArray]:
    """(N1, N2) and (M1, M2) at both ends; PBCOMP has one pair for both."""

    def pair(letter: str, end: str) -> list[float]:
        return [float(getattr(prop, f"{letter}{i}{end}") or 0.0) for i in (1, 2)]

    ends = ("", "") if prop.type == "PBCOMP" else ("a", "b")
    return np.array([pair("n", e) for e in ends]), np.array([pair("m", e) for e in ends])


def _ends(station: FloatArray, value: FloatArray) -> FloatArray:
    """Values at ends A and B of the linear distribution with the integral and the first moment of a polygon.

    With M0 and M1 of the polygon over [0, 1] these are 4 M0 - 6 M1 and 6 M1 - 2 M0: a line keeps its ends, intermediate
    stations leave mass and centre of gravity exact.
    """
    if len(station) == 1:
        return np.repeat(value, 2)
    if len(station) == 2:
        return value
    low, high, step = station[:-1], station[1:], np.diff(station)
    a, b = value[:-1], value[1:]
    whole = float((step * (a + b)).sum() / 2.0)
    first = float((step * (a * (2.0 * low + high) + b * (low + 2.0 * high))).sum() / 6.0)
    return np.array([4.0 * whole - 6.0 * first, 6.0 * first - 2.0 * whole])


def _offsets(element: Any, position: FloatArray, to_basic: ToBasic, where: str) -> FloatArray:
    """WA and WB in the basic frame, [2, 3].

    OFFT gives their frames: G, the displacement frame of the grid; O, the offset frame of the element: x from grid A to
    grid B, z normal to it and to the orientation vector v (z = x × v), y = z × x.
    """
    ends = np.array([element.wa, element.wb], dtype=float)
    if not ends.any():
        return ends
    code = _code(element, where)
    out = np.zeros((2, 3))
    for i, grid in enumerate((element.ga, element.gb)):
        if code[1 + i] == "G":
            out[i] = to_basic(int(grid), ends[i])
        else:
            out[i] = ends[i] @ _frame(element, position[1] - position[0], position, to_basic, where)
    return out


def _code(element: Any, where: str) -> str:
    code = "GGG" if element.offt is None else str(element.offt).upper()
    if len(code) != 3 or code[0] not in "GB" or not set(code[1:]) <= set("GO"):
        raise InputError(f"{element.type} {element.eid}: OFFT {code} is not read", where=where)
    return code


def line_frame(element: Any, position: FloatArray, to_basic: ToBasic, where: str) -> FloatArray:
    """Unit vectors x, y, z (rows, basic frame) of a CBAR or CBEAM between its ends, with grids at `position` [2, 3].

    Raises
    ------
    InputError : an offset of a kind that is not read, an orientation along the element.
    """
    ends = position + _offsets(element, position, to_basic, where)
    return _frame(element, ends[1] - ends[0], position, to_basic, where)


def _frame(element: Any, along: FloatArray, position: FloatArray, to_basic: ToBasic, where: str) -> FloatArray:
    """Unit vectors (rows) x along `along`, y in the plane of x and the orientation vector, z."""
    name = f"{element.type} {element.eid}"
    if element.g0:
        v = np.asarray(element.g0_ref.get_position(), dtype=float) - position[0]
    else:
        v = np.asarray(element.x, dtype=float)
        if _code(element, where)[0] == "G":
            v = to_basic(int(element.ga), v)
    x = along / np.linalg.norm(along) if np.any(along) else along
    z = np.cross(x, v)
    size = float(np.linalg.norm(z))
    if not size > 1e-9 * float(np.linalg.norm(v)):
        raise InputError(f"{name}: its orientation vector lies along the element", where=where)
    z /= size
    return np.stack([x, np.cross(z, x), z])
