"""What no structure has: bounds on its size, densities, thicknesses and expansion, wide of every real material.

Satellites and their parts lie inside of these by a wide margin; what does not is a slip, a damaged file, or in other
units than the configuration says.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from tedm_cli.arrays import FloatArray
from tedm_cli.deck_units import AREA, DENSITY, EXPANSION, LENGTH, MASS, STRESS, SYSTEMS, DeckUnits
from tedm_cli.errors import InputError
from tedm_cli.nastran.bulk.columns import columns_of
from tedm_cli.nastran.loads.temperatures import expansion_coefficients
from tedm_cli.nastran.masses.elements import Elements
from tedm_cli.nastran.parameter_values import number_parameter

_EXTENT_M = (1e-3, 1e2)
_DENSEST = (1e2, 3e4)  # kg/m3; every structure has some solid metal, glass or laminate
_LIKELY_M, _LIKELY = (2e-2, 5e1), (1e3, 2.2e4)  # narrower, m and kg/m3: what is advised must look like an instrument
_MOST_KG = 1e6
_LEAST_KG_PER_CUBED_EXTENT = 1e-4
_THICKEST = 1e2  # m, of plates, tubes and their diameters; of what is as large as the model, and no unit is wrong
_MOST_EXPANSION = 1e-2  # 1/K; polymers have 3e-4
_STIFFNESS = (1e6, 2e12)  # Pa; rubber has 1e6, diamond 1.2e12; the cores of sandwiches are soft in some directions only
_MODULI = ("e", "g", "e11", "e22", "e1", "e2", "e3", "ex", "eth", "ez", *(f"G{i}{i}" for i in range(1, 7)))
_LIGHTEST = 10.0  # kg/m3; honeycomb has 16 and more
_STRUCTURE = ("CHEXA", "CPENTA", "CTETRA", "CPYRAM", "CQUAD", "CTRIA", "CBAR", "CBEAM", "CROD", "CONROD", "CTUBE")
_ROUNDING = 1e-6  # of an inertia: what has no width has no inertia about its length
_ROUNDING_OF_LEVER = 1e-3  # of a mass on a lever: small fields have as few as four digits
_WEIGHTS = ("m-kg-s", "mm-t-s", "in-lbf-s")  # systems in which densities are given as weights, for PARAM,WTMASS


def check_plausible(model: Any, where: str, units: DeckUnits) -> None:
    """Refuse materials and properties that no structure has, of a model that need not be cross-referenced.

    Raises
    ------
    InputError : a negative density, thickness or area; a thickness of more than 100 m; an expansion of more than
        0.01 1/K; a MAT9 whose stiffness is not positive definite.
    """
    for mid, material in sorted(model.materials.items()):
        name = f"{material.type} {mid}"
        density = getattr(material, "rho", None)
        if density is not None and float(density) < 0.0:
            raise InputError(f"{name}: a density of {float(density):.4g} is negative", where=where)
        largest = units.factor(EXPANSION) * max((abs(a) for a in expansion_coefficients(material)), default=0.0)
        if largest > _MOST_EXPANSION:
            raise InputError(
                f"{name}: an expansion of {largest:.4g} per kelvin, which no solid has",
                where=where,
                hint=f"at most {_MOST_EXPANSION:g}; steel has 1.2e-5",
            )
        if material.type == "MAT9" and not np.linalg.eigvalsh(anisotropic_stiffness(material)).min() > 0.0:
            raise InputError(f"{name}: the stiffness is not positive definite", where=where)
    for pid, prop in sorted(model.properties.items()):
        for what, size in _sizes(prop):
            name, in_si = f"{prop.type} {pid}: a {what} of", units.factor(AREA if what == "section" else LENGTH) * size
            if in_si < 0.0:
                raise InputError(f"{name} {in_si:.4g} is negative", where=where)
            if not in_si <= _THICKEST:
                unit = "m2" if what == "section" else "m"
                fact = f"{name} {in_si:.4g} {unit} is larger than any model"
                raise InputError(fact, where=where, hint=_advice_of_cards(model, units, where))


def anisotropic_stiffness(material: Any) -> FloatArray:
    """Stiffness [6, 6] of a MAT9 in its own axes, in the units of the card."""
    upper = np.zeros((6, 6))
    for i in range(6):
        for j in range(i, 6):
            upper[i, j] = getattr(material, f"G{i + 1}{j + 1}")
    return upper + np.triu(upper, 1).T


def _sizes(prop: Any) -> Iterator[tuple[str, float]]:
    """Thicknesses and areas that a property gives."""
    if prop.type in ("PSHELL", "PSHEAR", "PTUBE") and prop.t is not None:
        yield "thickness", float(prop.t)
    if prop.type == "PTUBE":
        yield from (("diameter", float(d)) for d in (prop.OD1, prop.OD2) if d is not None)
    if prop.type in ("PCOMP", "PCOMPG"):
        yield from (("ply thickness", float(t)) for t in prop.thicknesses if t is not None)
    if prop.type in ("PROD", "PBAR", "PBEAM"):
        yield from (("section", float(a)) for a in np.atleast_1d(prop.A))


@dataclass(frozen=True)
class _Model:
    """Length (m), densest element (id; kg/m3, 0 where none has a density) and mass (kg, NaN: unknown) of a model."""

    extent_m: float
    densest_id: int
    densest: float
    total_kg: float

    def fault(self) -> str:
        """What no model has; empty where nothing is. Any of the four can look right while another does not."""
        if not _EXTENT_M[0] <= self.extent_m <= _EXTENT_M[1]:
            return f"the model is {self.extent_m:.4g} m long"
        if self.densest and not _DENSEST[0] <= self.densest <= _DENSEST[1]:
            return f"the densest element ({self.densest_id}) has {self.densest:.4g} kg/m3, which no solid has"
        if self.total_kg > _MOST_KG:
            return f"the model has a mass of {self.total_kg:.4g} kg"
        if self.total_kg < _LEAST_KG_PER_CUBED_EXTENT * self.extent_m**3:
            return f"the model has {self.total_kg:.4g} kg on a length of {self.extent_m:.4g} m"
        return ""

    def is_likely(self) -> bool:
        """Whether it looks like an instrument or a satellite of metals and glasses."""
        return (
            not self.fault()
            and _LIKELY_M[0] <= self.extent_m <= _LIKELY_M[1]
            and (not self.densest or _LIKELY[0] <= self.densest <= _LIKELY[1])
            and not self.total_kg > _LIKELY[1] * self.extent_m**3
        )

    def if_in(self, units: DeckUnits, said: DeckUnits, per_mass: float) -> _Model:
        """The same deck in other units than those that were said, its masses times `per_mass`."""
        length, mass, density = (units.factor(d) / said.factor(d) for d in (LENGTH, MASS, DENSITY))
        return _Model(
            length * self.extent_m,
            self.densest_id,
            density * per_mass * self.densest,
            mass * per_mass * self.total_kg,
        )

    def __str__(self) -> str:
        densest = f", its densest element of {self.densest:,.4g} kg/m3" if self.densest else ""
        mass = "" if np.isnan(self.total_kg) else f" and of {self.total_kg:.3g} kg"
        return f"{self.extent_m:.3g} m long{mass}{densest}"


def check_units(
    position: FloatArray, elements: Elements, total_kg: float, where: str, units: DeckUnits, wtmass: float
) -> None:
    """Refuse models that cannot be in the units that the configuration says, and say in which they could be.

    Parameters
    ----------
    position, elements, total_kg : of the model, in SI, with PARAM,WTMASS (`wtmass`) in its masses.
    units : what they were taken to be in.
    """
    density = np.nan_to_num(elements.density)
    densest = int(density.argmax()) if density.any() else -1
    model = _Model(
        float(np.ptp(position, axis=0).max()),
        int(elements.id[densest]) if density.any() else 0,
        float(density[densest]) if density.any() else 0.0,
        total_kg,
    )
    if not total_kg > 0:
        raise InputError("the model has no mass", where=where, hint="set the density of its materials")
    fault = model.fault()
    if fault:
        raise InputError(fault, where=where, hint=_advice(model, units, wtmass))


def _advice(model: _Model, said: DeckUnits, wtmass: float) -> str:
    """The system in which a model would be like others; else what may be wrong with PARAM,WTMASS."""

    def likely(per_mass: float, name: str) -> _Model | None:
        seen = model.if_in(DeckUnits(*SYSTEMS[name], said.temperature), said, per_mass)
        return seen if seen.is_likely() else None

    found = {name: seen for name in SYSTEMS if (seen := likely(1.0, name)) is not None}
    if len(found) == 1:
        ((name, seen),) = found.items()
        return f'set [model] units = "{name}": the model would be {seen}'
    if found:
        listed = "; ".join(f'"{name}": {seen}' for name, seen in found.items())
        return f"set [model] units to those of the deck; it could be {listed}"
    # the masses times what: without PARAM,WTMASS, and with the one of each system
    unweighted = {name: 1.0 / wtmass for name in SYSTEMS} if wtmass != 1.0 else {}
    for name, per_mass in unweighted.items():
        if (seen := likely(per_mass, name)) is not None:
            return (
                f"PARAM,WTMASS = {wtmass:g} multiplies densities that seem to be masses already: without it, and with"
                f' [model] units = "{name}", the model would be {seen}'
            )
    for name in _WEIGHTS:
        proper = 1.0 / DeckUnits(*SYSTEMS[name]).gravity
        if (seen := likely(proper / wtmass, name)) is not None:
            return (
                f'are densities weights? with PARAM,WTMASS = {proper:.6g}, and with [model] units = "{name}", the'
                f" model would be {seen}"
            )
    return _set_units(said)


def _advice_of_cards(model: Any, said: DeckUnits, where: str) -> str:
    """The same before anything is weighed: from the grids in the basic frame, and the densest material."""
    grid = columns_of(model).grid
    place = grid.xyz[grid.cp == 0]
    wtmass = number_parameter(model, "WTMASS", 1.0, where)
    dense = max((float(getattr(m, "rho", 0.0) or 0.0) for m in model.materials.values()), default=0.0)
    if len(place) < 2 or not dense * wtmass > 0.0:
        return _set_units(said)
    extent = float(np.ptp(place, axis=0).max())
    rough = _Model(said.factor(LENGTH) * extent, 0, said.factor(DENSITY) * wtmass * dense, float("nan"))
    if rough.is_likely():
        return f"the rest of the model looks right in {said.name}: is it one digit or exponent that is wrong?"
    return _advice(rough, said, wtmass)


def _set_units(said: DeckUnits) -> str:
    return (
        f"set [model] units to those of the deck ({', '.join(SYSTEMS)}), which is read as {said.name}; lengths and"
        " densities of two systems, such as mm and kg/m3, have to be made one"
    )


def light_elements(elements: Elements) -> list[str]:
    """Remarks on elements that weigh nothing, or less than any material of a structure; one for each property.

    They may be meant so, with their mass elsewhere; a density left out or in g/cm3 looks the same.
    """
    heavy = (elements.density >= _LIGHTEST) | np.isnan(elements.density) | (elements.added_kg > 0.0)
    light = [i for i in np.flatnonzero(~heavy) if elements.type[i].startswith(_STRUCTURE)]
    groups = Counter(
        (int(elements.property_id[i]), elements.type[i], float(elements.density[i]))
        for i in light
        if elements.density[i] > 0.0 or not elements.mass_kg[i] > 0.0  # the mass may be non-structural
    )
    return [
        f"{number:,} {card} of property {pid} "
        + (f"have a density of {density:.4g} kg/m3" if density else "weigh nothing: their material has no density")
        for (pid, card, density), number in sorted(groups.items())
    ]


def odd_stiffness(materials: Iterable[Any], units: DeckUnits) -> list[str]:
    """Remarks on materials that are softer than rubber in all directions, or stiffer than diamond.

    Dummies may be meant so; a modulus in MPa, or with one digit or exponent wrong, looks the same.
    """
    notes = []
    for material in materials:
        given = [v for name in _MODULI if (v := getattr(material, name, None)) is not None]
        largest = units.factor(STRESS) * max((float(v) for v in given), default=0.0)
        if given and not _STIFFNESS[0] <= largest <= _STIFFNESS[1]:
            notes.append(
                f"{material.type} {material.mid}: a largest modulus of {largest:.4g} Pa is"
                f" {'softer than rubber' if largest < _STIFFNESS[0] else 'stiffer than diamond'} (structures:"
                f" {_STIFFNESS[0]:g} to {_STIFFNESS[1]:g} Pa): is it in the unit of the deck?"
            )
    return notes


def is_mass_tensor(inertia: FloatArray, scale: float = 0.0) -> bool:
    """Whether an inertia [3, 3] is that of a body: no axis about which it is negative, but for rounding.

    `scale`: of what the inertia may be a small difference, kg m2.
    """
    values = np.linalg.eigvalsh(inertia)
    return bool(values[0] >= -max(_ROUNDING * float(values[-1]), _ROUNDING_OF_LEVER * scale, 0.0))
