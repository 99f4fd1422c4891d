"""From the units of a deck to SI: what has been read of a model, by the dimension of each of its fields.

Nothing is converted on the cards. What follows from them (a mass, a lever, a stiffness) is made of numbers of one
system and has a dimension, whichever cards it came from; what has none, such as 12I/T**3 and the angles of cylindrical
frames, is not touched. A field without a dimension here is an error, not a number that stays as it is.
"""

from __future__ import annotations

from dataclasses import fields, replace
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from tedm_cli import deck_units as u
from tedm_cli.arrays import FloatArray, IntArray
from tedm_cli.deck_units import DeckUnits, Dimension
from tedm_cli.fem.shapes import corner_count, shape_of
from tedm_cli.fem.structure import (
    BarBlock,
    ElementTemperatures,
    LoadCase,
    Mpc,
    OnFreedoms,
    RodBlock,
    ShellBlock,
    SolidMaterials,
    Structure,
)
from tedm_cli.nastran.masses.concentrated import Concentrated
from tedm_cli.nastran.masses.elements import Elements
from tedm_cli.nastran.positions import Frames

if TYPE_CHECKING:
    from _typeshed import DataclassInstance

T = TypeVar("T", bound="DataclassInstance")

_SAME = u.NUMBER  # ids, names, directions, ratios
_LINE = {
    **dict.fromkeys(("element_id", "connectivity"), _SAME),
    "area": u.AREA,
    "torsion_constant": u.AREA_MOMENT,
    **dict.fromkeys(("youngs_modulus", "shear_modulus"), u.STRESS),
    "expansion": u.EXPANSION,
    "reference_temperature": u.TEMPERATURE,
}
DIMENSIONS: dict[type, dict[str, Dimension]] = {
    Elements: {
        **dict.fromkeys(("id", "type", "property_id", "node_offset", "node_index", "partial"), _SAME),
        **dict.fromkeys(("weight", "structural_weight"), _SAME),
        **dict.fromkeys(("mass_kg", "added_kg", "structural_kg"), u.MASS),
        "density": u.DENSITY,
        "expansion": u.EXPANSION,
        **dict.fromkeys(("lever", "structural_lever"), u.LENGTH),
        "section": _SAME,  # a thickness or an area, by element: see `elements_in_si`
    },
    Concentrated: {
        **dict.fromkeys(("card", "id", "node"), _SAME),
        "kg": u.MASS,
        "lever": u.LENGTH,
        "inertia": u.INERTIA,
    },
    SolidMaterials: {
        "stiffness": u.STRESS,
        "expansion": u.EXPANSION,
        "reference_temperature": u.TEMPERATURE,
    },
    RodBlock: _LINE,
    BarBlock: {
        **_LINE,
        **dict.fromkeys(("inertia_1", "inertia_2", "inertia_12"), u.AREA_MOMENT),
        **dict.fromkeys(("shear_factor", "orientation", "released"), _SAME),
        "offset": u.LENGTH,
    },
    ShellBlock: {
        **dict.fromkeys(("element_id", "connectivity", "law_rates"), _SAME),
        **dict.fromkeys(("membrane_stiffness", "shear_stiffness", "drilling_stiffness"), u.FORCE_PER_LENGTH),
        "bending_stiffness": u.MOMENT,  # per length, over a curvature
        "offset": u.LENGTH,
        **dict.fromkeys(("expansion", "bending_expansion"), u.EXPANSION),
        "reference_temperature": u.TEMPERATURE,
    },
    Structure: {
        **dict.fromkeys(("grid_id", "displacement_frame", "spc_grid", "spc_component", "rbe2", "rbe3"), _SAME),
        **dict.fromkeys(("solids", "bars", "rods", "quads", "trias", "mpc"), _SAME),  # see `structure_in_si`
        "position": u.LENGTH,
        "initial_temperature": u.TEMPERATURE,
        "direct": _SAME,  # see `structure_in_si`
    },
    LoadCase: {
        **dict.fromkeys(("id", "label"), _SAME),
        "temperature": u.TEMPERATURE,
        **dict.fromkeys(("elements", "force", "enforced"), _SAME),  # see `load_case_in_si`
        "acceleration": u.ACCELERATION,
    },
    ElementTemperatures: {"element_id": _SAME, "mean": u.TEMPERATURE, "gradient": u.TEMPERATURE_GRADIENT},
}
"""Dimension of every field of what is read of a deck."""


def units_of(model: Any) -> DeckUnits:
    """The units of a model from `read_deck`."""
    units: DeckUnits = model.tedm_units
    return units


def in_si(read: T, units: DeckUnits) -> T:
    """A dataclass of `DIMENSIONS` with its fields in SI; `KeyError` for a class or a field that is not there."""
    dimensions = DIMENSIONS[type(read)]
    changed = {}
    for field in fields(read):
        factor, value = units.factor(dimensions[field.name]), getattr(read, field.name)
        if factor != 1.0 and value is not None:
            changed[field.name] = factor * value
    return replace(read, **changed) if changed else read


def elements_in_si(elements: Elements, units: DeckUnits) -> Elements:
    """Elements of a deck in SI; `section` is a thickness of plates and an area of lines."""
    of_card = {}
    for card in set(elements.type):
        shape = shape_of(card, corner_count(card) or 0)
        dimension = {1: u.AREA, 2: u.LENGTH}.get(0 if shape is None else shape.dimension, u.NUMBER)
        of_card[card] = units.factor(dimension)
    section = elements.section * np.array([of_card[card] for card in elements.type])
    return replace(in_si(elements, units), section=section)


def frames_in_si(frames: Frames, units: DeckUnits) -> Frames:
    """Coordinate systems with their origins in m."""
    return {cid: (kind, units.length_m * origin, axes) for cid, (kind, origin, axes) in frames.items()}


def structure_in_si(structure: Structure, units: DeckUnits) -> Structure:
    """What the embedded solver solves, in SI."""
    tables = {id(b.materials): in_si(b.materials, units) for b in structure.solids}
    return replace(
        in_si(structure, units),
        solids=tuple(replace(b, materials=tables[id(b.materials)]) for b in structure.solids),
        bars=in_si(structure.bars, units),
        rods=in_si(structure.rods, units),
        quads=in_si(structure.quads, units),
        trias=in_si(structure.trias, units),
        mpc=tuple(_equation_in_si(mpc, units) for mpc in structure.mpc),
        direct=replace(
            structure.direct,
            matrix=_per_motion(
                _per_motion(structure.direct.matrix, structure.direct.dof, units).T, structure.direct.dof, units
            )
            * units.factor(u.MOMENT),
        ),
    )


def load_case_in_si(case: LoadCase, units: DeckUnits) -> LoadCase:
    """A load case in SI, with the temperatures of its elements, forces and motions."""
    own = None if case.elements is None else in_si(case.elements, units)
    force = _on_freedoms_in_si(case.force, units.factor(u.FORCE), units.factor(u.MOMENT))
    enforced = _on_freedoms_in_si(case.enforced, units.length_m, 1.0)
    return replace(in_si(case, units), elements=own, force=force, enforced=enforced)


def _on_freedoms_in_si(given: OnFreedoms | None, along: float, about: float) -> OnFreedoms | None:
    """Values along axes and about axes, each with its factor."""
    return given and replace(given, value=np.where(given.dof % 6 < 3, along, about) * given.value)


def _per_motion(values: FloatArray, dof: IntArray, units: DeckUnits) -> FloatArray:
    """Rows of `values` [n, ...] over the deck's unit of the motion of each freedom: forces are work over motions."""
    size = np.where(dof % 6 < 3, units.length_m, 1.0)
    return np.asarray(values / size.reshape(-1, *([1] * (values.ndim - 1))))


def _equation_in_si(mpc: Mpc, units: DeckUnits) -> Mpc:
    """A sum of lengths, in which the coefficient of a rotation is a lever; of rotations alone all have one factor."""
    return replace(mpc, coefficients=np.where(mpc.components > 3, units.length_m, 1.0) * mpc.coefficients)
