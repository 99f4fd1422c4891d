"""Grids, elements and masses of a deck as plain arrays in SI and the basic frame."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tedm_cli.errors import InputError
from tedm_cli.fem.shapes import corner_count, shape_of
from tedm_cli.nastran.frames import local_basis
from tedm_cli.nastran.levers import conm2_lever, element_levers
from tedm_cli.nastran.rigid import tied_grids

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

# Satellites and their parts lie inside of these by a wide margin; what does not is in millimetres, tonnes or pounds.
_EXTENT_M = (1e-3, 1e2)
_DENSEST = (1e2, 3e4)  # kg/m3; every structure has some solid metal, glass or laminate
_MOST_KG = 1e6
_LEAST_KG_PER_CUBED_EXTENT = 1e-4
_SI = "lengths must be in metres, masses in kilograms"


@dataclass(frozen=True)
class Elements:
    """Elements with mass or stiffness; ragged connectivity as offsets [E+1] and rows of the grid table.

    lever : [M, 3], offset of the element's mass from each of its nodes, basic frame, m.
    partial : ids of elements that lack some of their midside nodes; only their corners are kept.
    """

    id: IntArray
    type: list[str]
    property_id: IntArray
    node_offset: IntArray
    node_index: IntArray
    mass_kg: FloatArray
    density: FloatArray
    expansion: FloatArray
    section: FloatArray
    lever: FloatArray
    partial: list[int]


@dataclass(frozen=True)
class Concentrated:
    """CONM2: ids, rows of the grid table, masses (kg), and levers from the grids [C, 3] (basic frame, m)."""

    id: IntArray
    node: IntArray
    kg: FloatArray
    lever: FloatArray


@dataclass(frozen=True)
class Grids:
    """Grid ids [N] ascending, which of them are corners of elements, and which are in rigid elements or MPCs.

    `files`: the deck and its includes.
    """

    files: list[Path]
    grid_id: IntArray
    structural: NDArray[np.bool_]
    tied: NDArray[np.bool_]


@dataclass(frozen=True)
class ModelGeometry(Grids):
    """Geometry and mass of a finite-element model.

    grid_id [N] ascending; position_m [N,3] in the basic frame; lumped_kg [N]: every element's mass shared equally
    among its corners, plus concentrated masses; `files`: the deck and its includes.
    """

    position_m: FloatArray
    displacement_frame: IntArray
    frames: dict[int, tuple[str, FloatArray, FloatArray]]
    elements: Elements
    concentrated: Concentrated
    lumped_kg: FloatArray
    reference_mass_kg: float

    @property
    def total_kg(self) -> float:
        return float(self.lumped_kg.sum())

    @property
    def centre_of_gravity_m(self) -> FloatArray:
        e, c = self.elements, self.concentrated
        counts = np.diff(e.node_offset)
        shift = np.repeat(e.mass_kg / counts, counts) @ e.lever + c.kg @ c.lever
        return np.asarray((self.lumped_kg @ self.position_m + shift) / self.lumped_kg.sum())


def rows_of(grid_id: IntArray, wanted: IntArray, *, where: str, what: str) -> IntArray:
    """Row of each wanted grid id in the ascending table `grid_id`; `InputError` names those that are missing."""
    rows = np.searchsorted(grid_id, wanted)
    rows[rows == len(grid_id)] = 0
    missing = wanted[grid_id[rows] != wanted]
    if missing.size:
        raise InputError(f"{what} names {missing.size} grids that do not exist: {id_list(missing)}", where=where)
    return np.asarray(rows, dtype=np.int64)


def id_list(ids: Any, most: int = 8) -> str:
    """`1, 2, 3 and 40 more` for messages."""
    ids = [int(i) for i in ids]
    shown = ", ".join(f"{i}" for i in ids[:most])
    return shown + (f" and {len(ids) - most} more" if len(ids) > most else "")


def grids(model: Any, files: list[Path]) -> Grids:
    """Grids of a model that need not be cross-referenced; `InputError` where it holds no grids or no elements."""
    where = str(files[0])
    if not model.nodes or not model.elements:
        raise InputError("holds no grids or no elements", where=where)
    ids = np.array(sorted(model.nodes), dtype=np.int64)
    corners = {int(n) for e in model.elements.values() for n in e.node_ids if n}
    rows = rows_of(ids, np.array(sorted(corners), dtype=np.int64), where=where, what="an element")
    structural = np.zeros(len(ids), dtype=bool)
    structural[rows] = True
    return Grids(files, ids, structural, np.isin(ids, tied_grids(model)))


def model_geometry(model: Any, files: list[Path]) -> ModelGeometry:
    """Turn a cross-referenced pyNastran model into arrays.

    Raises
    ------
    InputError : no grids or no elements, units far from SI, unreadable offsets, non-positive total mass.
    """
    from pyNastran.bdf.mesh_utils.mass_properties import mass_properties

    basic = grids(model, files)
    where, ids = str(files[0]), basic.grid_id
    position = np.array([model.nodes[i].get_position() for i in ids], dtype=float)
    factor = float(model.params["WTMASS"].values[0]) if "WTMASS" in model.params else 1.0
    frames = _frames(model)
    elements = _elements(model, ids, factor, frames, where)
    concentrated = _concentrated(model, ids, factor, where)
    lumped = np.zeros(len(ids))
    counts = np.diff(elements.node_offset)
    np.add.at(lumped, elements.node_index, np.repeat(elements.mass_kg / counts, counts))
    np.add.at(lumped, concentrated.node, concentrated.kg)
    _check_units(position, elements, float(lumped.sum()), where)
    total, *_ = mass_properties(model, sym_axis="no")
    return ModelGeometry(
        files=files,
        grid_id=ids,
        position_m=position,
        displacement_frame=np.array([int(model.nodes[i].Cd()) for i in ids], dtype=np.int64),
        frames=frames,
        elements=elements,
        concentrated=concentrated,
        lumped_kg=lumped,
        reference_mass_kg=float(total),
        structural=basic.structural,
        tied=basic.tied,
    )


def _check_units(position: FloatArray, elements: Elements, total_kg: float, where: str) -> None:
    """Refuse models that cannot be in metres and kilograms. Any of the four can look right while another does not."""
    extent = float(np.ptp(position, axis=0).max())
    if not _EXTENT_M[0] <= extent <= _EXTENT_M[1]:
        raise InputError(f"the model is {extent:.4g} m long", where=where, hint=_SI)
    if not total_kg > 0:
        raise InputError("the model has no mass", where=where, hint="set the density of its materials")
    density = np.nan_to_num(elements.density)
    if density.any():
        densest = int(density.argmax())
        if not _DENSEST[0] <= density[densest] <= _DENSEST[1]:
            raise InputError(
                f"the densest element ({elements.id[densest]}) has {density[densest]:.4g} kg/m3, which no solid has",
                where=where,
                hint=f"{_SI}; set PARAM,WTMASS where densities are weights",
            )
    if total_kg > _MOST_KG:
        raise InputError(
            f"the model has a mass of {total_kg:.4g} kg",
            where=where,
            hint=f"{_SI}; millimetres with densities in kg/m3 make masses 1e9 times too large",
        )
    if total_kg < _LEAST_KG_PER_CUBED_EXTENT * extent**3:
        raise InputError(f"the model has {total_kg:.4g} kg on a length of {extent:.4g} m", where=where, hint=_SI)


def _elements(
    model: Any, ids: IntArray, factor: float, frames: dict[int, tuple[str, FloatArray, FloatArray]], where: str
) -> Elements:
    eids, types, pids, masses, rho, alpha, section = [], [], [], [], [], [], []
    nodes: list[int] = []
    levers, partial = [], []

    def to_basic(grid: int, vector: FloatArray) -> FloatArray:
        node = model.nodes[grid]
        kind, origin, axes = frames[int(node.Cd())]
        local = (np.asarray(node.get_position(), dtype=float) - origin) @ axes.T
        return np.asarray(axes.T @ local_basis(kind, local[None])[0] @ vector)

    offsets = [0]
    for eid in sorted(model.elements):
        element = model.elements[eid]
        corners = [int(n) for n in element.node_ids if n]
        least = corner_count(str(element.type))
        if least is not None and shape_of(str(element.type), len(corners)) is None:
            partial.append(eid)
            corners = corners[:least]
        eids.append(eid)
        types.append(str(element.type))
        pids.append(int(element.Pid()) if hasattr(element, "pid") else 0)
        masses.append(float(element.Mass()) * factor)
        density, expansion, size = _material(element)
        rho.append(density * factor)
        alpha.append(expansion)
        section.append(size)
        nodes += corners
        levers.append(element_levers(element, len(corners), to_basic, where))
        offsets.append(len(nodes))
    return Elements(
        id=np.array(eids, dtype=np.int64),
        type=types,
        property_id=np.array(pids, dtype=np.int64),
        node_offset=np.array(offsets, dtype=np.int64),
        node_index=rows_of(ids, np.array(nodes, dtype=np.int64), where=where, what="an element"),
        mass_kg=np.array(masses),
        density=np.array(rho),
        expansion=np.array(alpha),
        section=np.array(section),
        lever=np.concatenate(levers),
        partial=partial,
    )


def _material(element: Any) -> tuple[float, float, float]:
    """Density, expansion and section of an element; NaN where the property has no single material."""
    prop = getattr(element, "pid_ref", None)
    material = getattr(prop, "mid_ref", None) or getattr(prop, "mid1_ref", None) or getattr(element, "mid_ref", None)
    section = 0.0
    if hasattr(prop, "Thickness"):
        section = float(prop.Thickness() or 0.0)  # type: ignore[union-attr]
    elif hasattr(prop, "Area"):
        section = float(prop.Area())  # type: ignore[union-attr]
    if material is None or not hasattr(material, "rho"):
        return float("nan"), float("nan"), section
    expansion = getattr(material, "a", None)
    return float(material.rho or 0.0), float(expansion) if isinstance(expansion, float) else float("nan"), section


def _concentrated(model: Any, ids: IntArray, factor: float, where: str) -> Concentrated:
    nodes, masses, levers = [], [], []
    for eid in sorted(model.masses):
        mass = model.masses[eid]
        if mass.type != "CONM2":
            raise InputError(f"{mass.type} {eid}: only CONM2 concentrated masses are read", where=where)
        nodes.append(int(mass.Nid()))
        masses.append(float(mass.Mass()) * factor)
        levers.append(conm2_lever(mass, where))
    return Concentrated(
        id=np.array(sorted(model.masses), dtype=np.int64),
        node=rows_of(ids, np.array(nodes, dtype=np.int64), where=where, what="a CONM2"),
        kg=np.array(masses, dtype=float),
        lever=np.array(levers, dtype=float).reshape(-1, 3),
    )


def _frames(model: Any) -> dict[int, tuple[str, FloatArray, FloatArray]]:
    """Type, origin [3] and axes [3,3] (rows, basic frame) of every coordinate system."""
    return {
        int(cid): (str(c.Type), np.array(c.origin, dtype=float), np.array(c.beta(), dtype=float))
        for cid, c in model.coords.items()
    }
