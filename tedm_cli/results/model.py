"""The model and its distortion in few numbers, as unit_loads.h5 and distortion.h5 tell them."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import PurePosixPath

import numpy as np

from tedm_cli.arrays import FloatArray
from tedm_cli.contracts import DISTORTION, UNIT_LOADS
from tedm_cli.files.store import Reader
from tedm_cli.noise.areas import AreaTable
from tedm_cli.results.areas import plane_words, read_areas


@dataclass(frozen=True, eq=False)
class ModelSize:
    """Size and mass (kg) of a finite-element model.

    centre_of_gravity_m : [3], basic frame. symmetry_plane : in words, and where it is from.
    areas, area_mass_kg : the k thermal areas and the lumped mass [k] of each.
    mean_step : [k], the share of its step that each area's own elements receive, NaN of gradients; None where the file
        does not say.
    card, element_mass_kg : of every element. concentrated_kg : of every concentrated mass.
    """

    grids: int
    mass_kg: float
    centre_of_gravity_m: FloatArray
    symmetry_plane: str
    areas: AreaTable
    area_mass_kg: FloatArray
    mean_step: FloatArray | None
    card: list[str]
    element_mass_kg: FloatArray
    concentrated_kg: FloatArray


def read_model_size(unit_loads: Reader) -> ModelSize:
    """Counts and masses in unit_loads.h5."""
    areas = read_areas(unit_loads)
    layout = PurePosixPath(unit_loads.string(UNIT_LOADS.PLANE_LAYOUT)).name
    return ModelSize(
        grids=unit_loads.dataset(UNIT_LOADS.GRID_ID).shape[0],
        mass_kg=unit_loads.number(UNIT_LOADS.MASS_TOTAL),
        centre_of_gravity_m=unit_loads.array(UNIT_LOADS.MASS_CENTRE_OF_GRAVITY),
        symmetry_plane=plane_words(areas.plane, unit_loads.string(UNIT_LOADS.PLANE_ORIGIN), layout),
        areas=areas,
        area_mass_kg=unit_loads.array(UNIT_LOADS.AREA_MASS),
        mean_step=unit_loads.array(UNIT_LOADS.AREA_MEAN_STEP) if unit_loads.has(UNIT_LOADS.AREA_MEAN_STEP) else None,
        card=unit_loads.strings(UNIT_LOADS.ELEMENT_TYPE),
        element_mass_kg=unit_loads.array(UNIT_LOADS.ELEMENT_MASS),
        concentrated_kg=unit_loads.array(UNIT_LOADS.MASS_CONCENTRATED),
    )


@dataclass(frozen=True, eq=False)
class DistortionSize:
    """How a model deforms.

    areas : the k areas. largest, rigid : [k], per kelvin of each the largest translation of any grid, and that of the
    best-fit rigid motion at the centre of gravity, m/K, of gradients m/(K/m). superposition_translation,
    superposition_optics : residuals of the sum over the means against the uniform load, of translations and of the
    optical elements' rotations, relative; None where there is no uniform load.
    """

    areas: AreaTable
    largest: FloatArray
    rigid: FloatArray
    superposition_translation: float | None
    superposition_optics: float | None

    def most(self, values: FloatArray) -> list[tuple[str, float, str]]:
        """Of `largest` or `rigid`, by means and by gradients as far as there are any: unit of the areas' temperatures,
        largest value, and the area that has it."""
        found = []
        for mask in (~self.areas.gradient, self.areas.gradient):
            if mask.any():
                row = int(np.flatnonzero(mask)[values[mask].argmax()])
                found.append((self.areas.unit[row], float(values[row]), str(self.areas.name[row])))
        return found


def read_distortion_size(distortion: Reader) -> DistortionSize:
    """The checks in distortion.h5."""

    def known(path: str) -> float | None:
        return distortion.number(path) if distortion.has(path) else None

    return DistortionSize(
        areas=read_areas(distortion),
        largest=distortion.array(DISTORTION.CHECK_MAX_TRANSLATION),
        rigid=np.linalg.norm(distortion.array(DISTORTION.CHECK_RIGID_TRANSLATION), axis=1),
        superposition_translation=known(DISTORTION.CHECK_SUPERPOSITION_TRANSLATION),
        superposition_optics=known(DISTORTION.CHECK_SUPERPOSITION_OPTICS),
    )
