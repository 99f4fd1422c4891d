"""Plates and shells: mass per area at their nodes, and its distance from the grids (Nastran Quick Reference Guide)."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from tedm_cli.arrays import FloatArray, IntArray
from tedm_cli.errors import InputError
from tedm_cli.fem.shapes import Shape
from tedm_cli.nastran.masses.spread import Spread, density_of

_LEVEL = 1e-9  # of a laminate's thickness: rounding of its ply positions


@dataclass(frozen=True)
class _Plate:
    """A property: mass per area (structural; non-structural), thickness, distance of the mass from the grids' surface.

    density : kg/m³ where the elements' corner thicknesses apply, else None.
    """

    per_area: float
    nonstructural: float
    thickness: float
    shift: float
    density: float | None = None


@dataclass(frozen=True)
class Plates:
    """Plates of one shape: properties [E], the cards of these by id, ZOFFS [E], and by their rows those with an
    object of their own, which may have corner thicknesses. `name` gives card and id of a row."""

    property_id: IntArray
    properties: Mapping[int, Any]
    offset: FloatArray
    own: Mapping[int, Any]
    name: Callable[[int], str]


def plate_spread(elements: Plates, shape: Shape, position: FloatArray, where: str) -> Spread:
    """Mass of plates of one shape whose nodes are at `position` [E, n, 3].

    Corner thicknesses (T1 to T4; TFLAG 1: relative to the property's) vary linearly, and half way on midside nodes.
    ZOFFS and the position of a laminate's mass act along the normal at the middle of the corners.

    Raises
    ------
    InputError : a property of a kind that is not read, a plate without thickness.
    """
    ids, first, number = np.unique(elements.property_id, return_index=True, return_inverse=True)
    known = {k: _plate(elements.properties[int(ids[k])], where) for k in np.argsort(first).tolist()}
    plates = [known[k] for k in range(len(ids))]
    count = len(number)

    def of_each(values: list[float]) -> FloatArray:
        return np.array(values)[number]

    thickness = np.repeat(of_each([p.thickness for p in plates])[:, None], shape.nodes, axis=1)
    structural = np.repeat(of_each([p.per_area for p in plates])[:, None], shape.nodes, axis=1)
    shift = of_each([p.shift for p in plates]) + elements.offset
    for i, element in elements.own.items():
        plate = plates[number[i]]
        if plate.density is not None:
            corners = [getattr(element, f"T{c + 1}", None) for c in range(shape.corners)]
            if any(t is not None for t in corners):
                thickness[i] = _at_nodes(element, corners, plate.thickness, shape)
                structural[i] = plate.density * thickness[i]
                if thickness[i].min() < 0.0:
                    fact = f"a thickness of {thickness[i].min():.4g} is negative"
                    raise InputError(f"{element.type} {element.eid}: {fact}", where=where)
    hollow = np.flatnonzero((of_each([p.density or 0.0 for p in plates]) != 0.0) & ~thickness.all(axis=1))
    if hollow.size:
        raise InputError(f"{elements.name(int(hollow[0]))}: has no thickness in places", where=where)
    lever = np.zeros((count, shape.nodes, 3))
    off = np.flatnonzero(shift)
    if off.size:
        lever[off] = (shift[off, None] * _normals(position[off], shape.corners))[:, None]
    return Spread(
        structural=structural,
        nonstructural=np.repeat(of_each([p.nonstructural for p in plates])[:, None], shape.nodes, axis=1),
        axis=np.zeros_like(lever),
        structural_lever=lever,
        nonstructural_lever=lever,
        section=thickness[:, : shape.corners].mean(axis=1),
    )


def _at_nodes(element: Any, corners: list[float | None], thickness: float, shape: Shape) -> FloatArray:
    """Thickness at the nodes from that at the corners, [n]."""
    scale = thickness if element.tflag == 1 else 1.0
    at = np.array([thickness if t is None else float(t) * scale for t in corners])
    return np.concatenate([at, *(at[list(edge)].mean(keepdims=True) for edge in shape.edges)])


def _plate(prop: Any, where: str) -> _Plate:
    name = f"{prop.type} {prop.pid}"
    if prop.type == "PSHELL":
        thickness = float(prop.t or 0.0)
        # a plate of bending alone has its mass by MID2
        material = prop.mid1_ref if prop.mid1_ref is not None else prop.mid2_ref
        density = density_of(material, name, where)
        return _Plate(density * thickness, float(prop.nsm or 0.0), thickness, 0.0, density)
    if prop.type == "PSHEAR":
        thickness = float(prop.t)
        return _Plate(density_of(prop.mid_ref, name, where) * thickness, float(prop.nsm or 0.0), thickness, 0.0)
    if prop.type in ("PCOMP", "PCOMPG"):
        return _laminate(prop, name, where)
    raise InputError(f"{name}: plates with this property are not read", where=where)


def _laminate(prop: Any, name: str, where: str) -> _Plate:
    """Plies from the bottom surface up, mirrored above the middle where LAM is SYM.

    Z0 is the bottom surface, minus half of the whole thickness unless given.
    """
    thickness = np.array([float(t) for t in prop.thicknesses])
    density = np.array([density_of(m, name, where) for m in prop.mids_ref])
    if prop.lam == "SYM":
        thickness, density = np.concatenate([thickness, thickness[::-1]]), np.concatenate([density, density[::-1]])
    whole = float(thickness.sum())
    per_area = float(density @ thickness)
    level = float(prop.z0) + np.concatenate([[0.0], np.cumsum(thickness)])
    centre = float((density * thickness) @ (level[1:] + level[:-1]) / 2.0 / per_area) if per_area else 0.0
    shift = centre if abs(centre) > _LEVEL * whole else 0.0
    return _Plate(per_area, float(prop.nsm or 0.0), whole, shift)


def _normals(position: FloatArray, corners: int) -> FloatArray:
    """Unit normals [E, 3]: across the diagonals of a quadrilateral, the sides of a triangle."""
    a, b, c = (position[:, i] for i in range(3))
    normal = np.cross(c - a, position[:, 3] - b) if corners == 4 else np.cross(b - a, c - a)
    return np.asarray(normal / np.linalg.norm(normal, axis=1, keepdims=True))
