"""Thermal areas and unit loads of a deck: what each subcase warms, by how much, under which label."""

from __future__ import annotations

from collections.abc import Callable, Collection
from dataclasses import dataclass, field
from functools import cache, partial
from typing import Any

import numpy as np

from tedm_cli.area_names import area_name_fact
from tedm_cli.arrays import BoolArray, FloatArray, IntArray
from tedm_cli.errors import InputError
from tedm_cli.nastran.geometry import ModelGeometry, id_list
from tedm_cli.nastran.loads.area_loads import GRADIENT_DIGITS, AreaLoad
from tedm_cli.nastran.loads.element_steps import ElementSteps, check_superposition, element_steps, owned_elements
from tedm_cli.nastran.loads.temperatures import (
    Field,
    error_in_single_precision,
    reference_temperatures,
    selection,
    step,
    temperature_dependent,
    temperature_field,
)
from tedm_cli.nastran.loads.unit_load_control import check_unit_load_control
from tedm_cli.nastran.units import units_of

_RENAME = "change the LABEL; the label in the results need not change where model.subcases gives their numbers"


@dataclass(frozen=True)
class UnitLoad:
    """One subcase: its label, the rows of the grids it warms, and the temperature step (K; K/m of a gradient).

    `output`: what DISPLACEMENT asks for, ALL, NONE or the number of a set; empty where the deck does not say.
    `single_error`: relative error of the step where a solver holds temperatures in single precision.
    `elements`: what its cards give to elements.
    """

    subcase: int
    label: str
    rows: IntArray
    load_K: float
    output: str = ""
    single_error: float = 0.0
    elements: ElementSteps = field(default_factory=ElementSteps)

    @property
    def kind(self) -> str:
        """`mean`, or `gradient` where elements have gradients."""
        return "gradient" if self.elements.gradient.any() else "mean"

    def area_load(self, geometry: ModelGeometry) -> AreaLoad:
        """The load by ids of grids and elements, gradients per its step."""
        ids, e = geometry.elements.id, self.elements
        slope = e.gradient / self.load_K if self.kind == "gradient" else None
        return AreaLoad(geometry.grid_id[self.rows], ids[e.loaded], ids[e.held], slope)


@dataclass(frozen=True)
class UnitLoads:
    """The unit loads of the areas, and the uniform load where the deck has one."""

    areas: list[UnitLoad]
    uniform: UnitLoad | None

    @property
    def means(self) -> list[UnitLoad]:
        """Those of a mean temperature, which sum to the uniform load."""
        return [load for load in self.areas if load.kind == "mean"]


def deck_unit_loads(
    model: Any, geometry: ModelGeometry, uniform_label: str, superelements: Collection[str] | None = None
) -> UnitLoads:
    """Read the areas from the subcases' temperatures, against TEMPERATURE(INITIAL) or TREF.

    TEMP and TEMPD give those of grids, TEMPP1 and TEMPRB those of elements. Areas of `superelements`, names in upper
    case, warm nothing of the deck; their step is 1 K. None: there are no superelements.

    Raises
    ------
    InputError : what `check_unit_load_control` refuses; a subcase without label or temperatures, uneven steps, a step
        on the rest of the model, materials with different TREF and no TEMPERATURE(INITIAL), properties that change with
        temperature, two subcases with one label, a label that no area may have, grids or elements in two areas, grids
        in none, a uniform load that leaves something out; what `element_steps` and `check_superposition` refuse.
    """
    where = str(geometry.files[0])
    control = model.case_control_deck
    if control is None:
        raise InputError(
            "has no case control, so no unit loads", where=where, hint="make a deck with `tedm write-deck`"
        )
    subcases = {n: s for n, s in sorted(control.subcases.items()) if n != 0}
    check_unit_load_control(model, geometry.files[0], superelements=superelements is not None)
    elsewhere = frozenset(superelements or ())
    references = cache(partial(reference_temperatures, model))  # of all elements, whatever the number of subcases
    loads = [_unit_load(model, geometry, n, s, where, elsewhere, references) for n, s in subcases.items()]
    labels: dict[str, int] = {}
    for load in loads:
        if load.label.upper() in labels:
            raise InputError(
                f"subcases {labels[load.label.upper()]} and {load.subcase} have the same label '{load.label}'",
                where=where,
            )
        labels[load.label.upper()] = load.subcase
    areas = [load for load in loads if load.label.upper() != uniform_label.upper()]
    uniform = next((load for load in loads if load.label.upper() == uniform_label.upper()), None)
    if not areas:
        raise InputError(
            "has no subcase that warms a thermal area", where=where, hint="make a unit-load deck with `tedm write-deck`"
        )
    found = UnitLoads(areas, uniform)
    _check_names(areas, where)
    if uniform is not None and uniform.kind != "mean":
        raise InputError(
            f"the uniform load '{uniform.label}' is a gradient", where=f"{where}: subcase {uniform.subcase}"
        )
    owned = owned_elements([(a.label, a.elements) for a in found.means], geometry.elements.id, where)
    _check_partition(found.means, geometry, owned, where)
    for load in found.means:
        place = f"{where}: subcase {load.subcase} (area '{load.label}')"
        check_superposition(load.elements, load.rows, owned, geometry, place)
    if uniform is not None:
        _check_uniform(uniform, found.means, geometry, owned, where)
    return found


def _unit_load(
    model: Any,
    geometry: ModelGeometry,
    number: int,
    subcase: Any,
    where: str,
    elsewhere: Collection[str],
    references: Callable[[], dict[float, str]],
) -> UnitLoad:
    label = " ".join(str(subcase.get_parameter("LABEL")[0]).split()) if "LABEL" in subcase.params else ""
    if not label:
        raise InputError("has no LABEL, so its thermal area has no name", where=f"{where}: subcase {number}")
    place = f"{where}: subcase {number} (area '{label}')"
    sets = selection(subcase, place)
    if sets.load is None:
        raise InputError("selects no temperatures", where=place, hint="add TEMPERATURE(LOAD) = <set id>")
    changing = temperature_dependent(model) if sets.material is not None else []
    if changing:
        raise InputError(
            f"evaluates properties at temperature set {sets.material}, and {changing[0]} depends on temperature"
            + (f" (and {len(changing) - 1} more)" if len(changing) > 1 else ""),
            where=place,
            hint="write TEMPERATURE(LOAD) alone: unit loads add up only when properties stay as they are",
        )
    loaded = temperature_field(model, sets.load, geometry.grid_id, place)
    if sets.initial is None:
        initial, name = _tref(model, references(), loaded, place), "the materials' TREF is"
    else:
        initial, name = temperature_field(model, sets.initial, geometry.grid_id, place), "TEMPERATURE(INITIAL) is"
    steps = step(loaded, initial, geometry.grid_id)
    _check_rest(steps, loaded, initial, geometry, name, place)
    degrees = float(geometry.units.degrees_per_kelvin)
    warm = np.nonzero(np.nan_to_num(steps))[0]
    elements, mean, error = element_steps(model, sets, initial, geometry, place)
    output = str(subcase.get_parameter("DISPLACEMENT")[0]) if "DISPLACEMENT" in subcase.params else ""
    if elements.gradient.any():
        if warm.size or mean.any():
            raise InputError(
                "loads both a mean temperature and a gradient",
                where=place,
                hint="make two subcases of it, each with a LABEL of its own: they are two areas",
            )
        size = np.linalg.norm(elements.gradient, axis=1)
        if np.ptp(size) > GRADIENT_DIGITS * size.max():
            listed = f"{size.min():.6g} to {size.max():.6g} K/m"
            raise InputError(f"has gradients of {listed} in its elements; a unit load has one", where=place)
        return UnitLoad(number, label, warm, float(f"{size.mean():.8g}"), output, error, elements)
    every = np.concatenate([steps[warm], mean])
    if not every.size and label.upper() in elsewhere:
        return UnitLoad(number, label, warm, 1.0, output)
    if not every.size:
        raise InputError(f"warms nothing (temperature set {sets.load})", where=place)
    low, high = float(every.min()), float(every.max())
    if high - low > 1e-9 * max(abs(low), abs(high)):
        listed = f"{low / degrees:.9g} to {high / degrees:.9g} K"
        what = "its grids and elements" if mean.size else "its grids"
        raise InputError(f"warms {what} by {listed}; a unit load has one step", where=place)
    error = max(error, error_in_single_precision(loaded, initial, geometry.grid_id, steps))
    return UnitLoad(number, label, warm, float(every[0]) / degrees, output, error, elements)


def _tref(model: Any, found: dict[float, str], loaded: Field, place: str) -> Field:
    """The reference temperature of the materials as a field; of a model that does not expand, the rest of the load.

    `found`: what `reference_temperatures` finds.
    """
    if len(found) > 1:
        unit = units_of(model).temperature
        listed = ", ".join(f"{t:g} {unit} ({owner})" for t, owner in sorted(found.items())[:4])
        raise InputError(
            f"the materials' TREF differ: {listed}",
            where=place,
            hint="set every TREF to one temperature, or give TEMPERATURE(INITIAL): a unit load starts from one state",
        )
    tref = next(iter(found), 0.0 if np.isnan(loaded.rest) else loaded.rest)
    return Field(np.zeros(0, dtype=np.int64), np.zeros(0), tref)


def _check_rest(
    steps: FloatArray, loaded: Field, initial: Field, geometry: ModelGeometry, name: str, place: str
) -> None:
    """The grids that no TEMP names must have no step, unless the whole model has the same."""
    unknown = geometry.grid_id[np.isnan(steps) & geometry.structural]
    if unknown.size:
        raise InputError(
            f"{unknown.size} structural grids have no temperature: {id_list(unknown)}",
            where=place,
            hint="add a TEMPD card to the temperature set: it holds for all grids without TEMP",
        )
    rest = ~np.isin(geometry.grid_id, loaded.grid_id)
    moved = rest & (np.nan_to_num(steps) != 0.0)
    if moved.any() and np.ptp(steps[~np.isnan(steps)]) > 0.0:
        first = int(np.argmax(moved))
        cold, unit = initial.on(geometry.grid_id)[first], geometry.units.temperature
        raise InputError(
            f"rests at {loaded.rest:.15g} {unit} (TEMPD), but {name} {cold:.15g} {unit}",
            where=place,
            hint="set TEMPD to the reference temperature, or the rest of the model expands too",
        )


def _check_names(areas: list[UnitLoad], where: str) -> None:
    facts = [(a.subcase, fact) for a in areas if (fact := area_name_fact(a.label))]
    if facts:
        others = f" (and {len(facts) - 1} more subcases)" if len(facts) > 1 else ""
        raise InputError(
            f"its LABEL names no area: {facts[0][1]}{others}", where=f"{where}: subcase {facts[0][0]}", hint=_RENAME
        )


def _check_partition(areas: list[UnitLoad], geometry: ModelGeometry, owned: BoolArray, where: str) -> None:
    count = np.zeros(len(geometry.grid_id), dtype=int)
    for area in areas:
        count[area.rows] += 1
    twice = geometry.grid_id[count > 1]
    if twice.size:
        both = [a.label for a in areas if np.isin(twice[0], geometry.grid_id[a.rows])]
        raise InputError(
            f"{twice.size} of {len(count)} grids are in more than one thermal area: {id_list(twice)}"
            f" (the first in {', '.join(both)})",
            where=where,
        )
    left = geometry.grid_id[(count == 0) & geometry.mesh.followed(owned)]
    if left.size:
        raise InputError(
            f"{left.size} of {geometry.structural.sum()} structural grids are in no thermal area: {id_list(left)}",
            where=where,
            hint="is a subcase missing, or an area without its TEMP cards?",
        )


def _check_uniform(
    uniform: UnitLoad, areas: list[UnitLoad], geometry: ModelGeometry, owned: BoolArray, where: str
) -> None:
    """The uniform load has to give its step to all grids and elements of all areas: superposition is against it."""
    place = f"{where}: subcase {uniform.subcase} (uniform load '{uniform.label}')"
    hint = "a uniform load is the step on all areas together: add them to its temperature cards, or remove it"
    for area in areas:
        cold = area.rows[~np.isin(area.rows, uniform.rows)]
        if cold.size:
            raise InputError(
                f"does not warm {cold.size} of {area.rows.size} grids of area '{area.label}':"
                f" {id_list(geometry.grid_id[cold])}",
                where=place,
                hint=hint,
            )
    grids = np.zeros(len(geometry.grid_id), dtype=bool)
    grids[uniform.rows] = True
    warm = geometry.mesh.within(grids)
    warm[uniform.elements.loaded], warm[uniform.elements.held] = True, False
    wanted = owned.copy()
    wanted[uniform.elements.held] = True
    cold = np.flatnonzero(wanted & ~warm)
    if cold.size:
        raise InputError(f"does not warm elements {id_list(geometry.elements.id[cold])}", where=place, hint=hint)
