"""What the temperature sets of a unit-load deck give to elements, and whether such loads sum to the uniform one."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from tedm_cli.arrays import BoolArray, FloatArray, IntArray
from tedm_cli.deck_units import TEMPERATURE_GRADIENT
from tedm_cli.errors import InputError
from tedm_cli.nastran.geometry import ModelGeometry, id_list
from tedm_cli.nastran.loads.area_loads import GRADIENT_DIGITS, none
from tedm_cli.nastran.loads.element_temperatures import element_temperatures
from tedm_cli.nastran.loads.temperatures import Field, Selection, error_in_single_precision, step


@dataclass(frozen=True, eq=False)
class ElementSteps:
    """Rows of a model's elements with temperatures of their own in one load.

    loaded [m], ascending, and gradient [m, 2]: those that have the load; the gradient of a mean load is zero. A bar has
    it in planes 1 and 2 (K/m), a shell along its normal. held : those that a card keeps at rest.
    """

    loaded: IntArray = field(default_factory=none)
    held: IntArray = field(default_factory=none)
    gradient: FloatArray = field(default_factory=lambda: np.zeros((0, 2)))


def element_steps(
    model: Any, sets: Selection, initial: Field, geometry: ModelGeometry, place: str
) -> tuple[ElementSteps, FloatArray, float]:
    """What TEMPP1 and TEMPRB of the selected set give to elements, above the `initial` temperatures of their grids.

    Returns
    -------
    The elements; the mean step [m] of those that are loaded, in degrees of the deck; its largest relative error where a
    solver holds temperatures in single precision.

    Raises
    ------
    InputError : initial temperatures of elements, or of grids that differ over one of these; a temperature or a
        gradient that changes from end to end of a bar; what `element_temperatures` refuses.
    """
    first = None if sets.initial is None else element_temperatures(model, sets.initial)
    if first is not None:
        listed = id_list(first.element_id)
        raise InputError(
            f"TEMPERATURE(INITIAL) = {sets.initial} gives elements temperatures of their own: {listed}",
            where=place,
            hint="an initial temperature is that of grids: write TEMPD and TEMP",
        )
    own = None if sets.load is None else element_temperatures(model, sets.load)
    if own is None:
        return ElementSteps(), np.zeros(0), 0.0
    ids, e = own.element_id, geometry.elements
    size = np.abs(own.gradient).max(axis=(1, 2))
    uneven = (own.mean[:, 0] != own.mean[:, 1]) | (
        np.abs(own.gradient[:, 0] - own.gradient[:, 1]).max(axis=1) > GRADIENT_DIGITS * size
    )
    if uneven.any():
        raise InputError(
            f"the temperatures of bars change from end to end: {id_list(ids[uneven])}",
            where=place,
            hint="a unit load has one step, or one gradient, in all of its elements",
        )
    rows = np.searchsorted(e.id, ids)
    counts = np.diff(e.node_offset)[rows]
    starts = np.cumsum([0, *counts])[:-1]
    nodes = np.repeat(e.node_offset[rows] - starts, counts) + np.arange(counts.sum())
    cold = initial.on(geometry.grid_id)[e.node_index[nodes]]
    low, high = np.minimum.reduceat(cold, starts), np.maximum.reduceat(cold, starts)
    if (low != high).any():
        raise InputError(
            f"TEMPERATURE(INITIAL) differs over elements with temperatures of their own: {id_list(ids[low != high])}",
            where=place,
        )
    warm, rest = Field(ids, own.mean[:, 0], float("nan")), Field(ids, low, float("nan"))
    mean = step(warm, rest, ids)
    gradient = geometry.units.factor(TEMPERATURE_GRADIENT) * own.gradient[:, 0]
    loaded = (mean != 0.0) | gradient.any(axis=1)
    error = error_in_single_precision(warm, rest, ids, mean)
    return ElementSteps(rows[loaded], rows[~loaded], gradient[loaded]), mean[loaded], error


def owned_elements(loads: Sequence[tuple[str, ElementSteps]], ids: IntArray, where: str) -> BoolArray:
    """Elements [E] that have temperatures of their own in some area; `InputError` names those of two."""
    owner = np.full(len(ids), -1)
    for number, (label, elements) in enumerate(loads):
        twice = elements.loaded[owner[elements.loaded] >= 0]
        if twice.size:
            raise InputError(
                f"{twice.size} elements are in more than one thermal area: {id_list(ids[twice])} (the first in"
                f" {loads[owner[twice[0]]][0]}, {label})",
                where=where,
            )
        owner[elements.loaded] = number
    return np.asarray(owner >= 0)


def check_superposition(
    elements: ElementSteps, rows: IntArray, owned: BoolArray, geometry: ModelGeometry, place: str
) -> None:
    """Refuse an area that does not warm what it should, so that the areas sum to another load than the uniform one.

    Its warm grids `rows` must not warm elements that have temperatures of their own (`owned`, [E]), and all others.
    """
    if not owned.any() and not elements.held.size:
        return
    ids, mesh = geometry.elements.id, geometry.mesh
    warm = np.zeros(len(geometry.grid_id), dtype=bool)
    warm[rows] = True
    named, held = (np.zeros(len(ids), dtype=bool) for _ in range(2))
    named[elements.loaded] = named[elements.held] = held[elements.held] = True
    touched = mesh.touching(warm)
    leaking, idle = ids[touched & owned & ~named], ids[touched & held & ~owned]
    if leaking.size:
        raise InputError(
            f"warms grids of {leaking.size} elements whose temperature is their own in another area, and no card keeps"
            f" them at rest: {id_list(leaking)}",
            where=place,
            hint="give them TEMPP1 or TEMPRB with the reference temperature, as `tedm write-deck` does",
        )
    if idle.size:
        raise InputError(
            f"keeps {idle.size} elements at rest that no area warms by a card: {id_list(idle)}",
            where=place,
            hint="remove their TEMPP1 or TEMPRB: they take the temperatures of their grids",
        )
