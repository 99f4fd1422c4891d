"""Thermal expansion of the test masses themselves, which moves the faces that the beams meet but not the centres."""

from __future__ import annotations

import difflib
from collections.abc import Sequence

import numpy as np

from tedm_cli.arrays import FloatArray
from tedm_cli.errors import InputError
from tedm_cli.optics.layout import OpticalLayout


def face_motion(layout: OpticalLayout, areas: Sequence[str], gradients: Sequence[str] = ()) -> FloatArray:
    """How far the face of each test mass moves along its normal per kelvin of each of the `areas`, [n_tm, k] m/K.

    The areas that are `gradients` move none of them.

    A body of uniform temperature expands about its centre: a face at the distance `front_offset_m` from it moves by
    `expansion_per_K * front_offset_m`. Test masses without an entry in `layout.expansions` keep their size.

    Raises
    ------
    InputError : there is no such thermal area, it is a gradient, or the layout does not say where the faces look.
    """
    names = [mass.name for mass in layout.test_masses]
    out = np.zeros((len(names), len(areas)))
    if layout.expansions and not layout.has_geometry:
        raise InputError(
            "an expanding test mass needs the geometry of the layout",
            where="test_mass_expansion",
            hint="give the elements their normals and the paths their steps, or leave the expansion out",
        )
    for e in layout.expansions:
        if e.area not in areas:
            near = difflib.get_close_matches(e.area, areas, n=1, cutoff=0.5)
            raise InputError(
                f"the temperature of {e.test_mass} follows the thermal area {e.area!r}, which does not exist",
                where="test_mass_expansion",
                hint=f"did you mean {near[0]}?" if near else "`tedm areas` lists them",
            )
        if e.area in gradients:
            raise InputError(
                f"the temperature of {e.test_mass} follows {e.area!r}, which is a gradient in K/m, not a temperature",
                where="test_mass_expansion",
                hint="name an area of a mean temperature",
            )
        place = names.index(e.test_mass)
        out[place, areas.index(e.area)] = e.expansion_per_K * layout.test_masses[place].front_offset_m
    return out
