"""What no structure has: bounds on its size, densities, thicknesses and expansion, wide of every real material.

Satellites and their parts lie inside of these by a wide margin; what does not is a slip, a damaged file, or in
millimetres, tonnes or pounds.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from typing import Any

import numpy as np

from tedm_cli.arrays import FloatArray
from tedm_cli.errors import InputError
from tedm_cli.nastran.masses.elements import Elements
from tedm_cli.nastran.temperatures import expansion_coefficients

_EXTENT_M = (1e-3, 1e2)
_DENSEST = (1e2, 3e4)  # kg/m3; every structure has some solid metal, glass or laminate
_MOST_KG = 1e6
_LEAST_KG_PER_CUBED_EXTENT = 1e-4
_THICKEST = 1e2  # m, of plates, tubes and their diameters; of what is as large as the model, and no unit is wrong
_MOST_EXPANSION = 1e-2  # 1/K; polymers have 3e-4
_LIGHTEST = 10.0  # kg/m3; honeycomb has 16 and more
_STRUCTURE = ("CHEXA", "CPENTA", "CTETRA", "CPYRAM", "CQUAD", "CTRIA", "CBAR", "CBEAM", "CROD", "CONROD", "CTUBE")
_ROUNDING = 1e-6  # of an inertia: what has no width has no inertia about its length
_ROUNDING_OF_LEVER = 1e-3  # of a mass on a lever: small fields have as few as four digits
_SI = "lengths must be in metres, masses in kilograms"


def check_plausible(model: Any, where: str) -> None:
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
        largest = max((abs(a) for a in expansion_coefficients(material)), default=0.0)
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
            check_size(size, f"{prop.type} {pid}", what, where)


def anisotropic_stiffness(material: Any) -> FloatArray:
    """Stiffness [6, 6] of a MAT9 in its own axes, in the units of the card."""
    upper = np.zeros((6, 6))
    for i in range(6):
        for j in range(i, 6):
            upper[i, j] = getattr(material, f"G{i + 1}{j + 1}")
    return upper + np.triu(upper, 1).T


def check_size(size: float, name: str, what: str, where: str) -> None:
    """Refuse a negative thickness or area, or one that is larger than any model."""
    if not 0.0 <= size <= _THICKEST:
        fact = "is negative" if size < 0.0 else "is larger than any model"
        raise InputError(f"{name}: a {what} of {size:.4g} {fact}", where=where, hint=_SI)


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


def check_units(position: FloatArray, elements: Elements, total_kg: float, where: str) -> None:
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


def is_mass_tensor(inertia: FloatArray, scale: float = 0.0) -> bool:
    """Whether an inertia [3, 3] is that of a body: no axis about which it is negative, but for rounding.

    `scale`: of what the inertia may be a small difference, kg m2.
    """
    values = np.linalg.eigvalsh(inertia)
    return bool(values[0] >= -max(_ROUNDING * float(values[-1]), _ROUNDING_OF_LEVER * scale, 0.0))
