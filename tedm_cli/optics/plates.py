"""What the glass of plates does to the beams when its temperature changes and nothing moves.

A plate of index n and thickness t on a beam changes the optical path by the change of either, and shifts and bends the
beam where it is met at an angle; at normal incidence `dopl = (n - 1) dt + t dn`. The middle plane of the glass keeps
its place, which is that of the element: of a growth dt each face moves out by dt / 2.
"""

from __future__ import annotations

import difflib
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tedm_cli.arrays import FloatArray
from tedm_cli.errors import InputError
from tedm_cli.optics.layout import N_OUTPUTS, Element, OpticalLayout
from tedm_cli.optics.sensitivity import DIRECTION, OPL, SHIFT, linearised_paths
from tedm_cli.optics.trace import Hit, nominal_poses

INDEX, THICKNESS = 0, 1  # places of what changes of a plate


@dataclass(frozen=True, eq=False)
class PlateEffect:
    """The p plates whose glass changes with temperature.

    plates : in layout order. sensitivity : [5 * n_paths, p, 2], outputs of the beams (m, rad) by index (1) and
    thickness (m) of each. change : [p, 2, k], of both per kelvin of each thermal area (1/K, m/K).
    """

    plates: tuple[Element, ...]
    sensitivity: FloatArray
    change: FloatArray

    @property
    def outputs(self) -> FloatArray:
        """Outputs of the beams by all plates together, [5 * n_paths, k] (m/K, rad/K)."""
        return np.asarray(np.einsum("rpc,pck->rk", self.sensitivity, self.change))


def plate_effect(
    layout: OpticalLayout, areas: Sequence[str], gradients: Sequence[str], grid_areas: dict[str, tuple[str, ...]]
) -> PlateEffect | None:
    """The plates of a layout that change with temperature, None where there are none.

    A plate has one temperature: that of a thermal area. Here is the place for any other law of it.

    Parameters
    ----------
    areas : names of the k thermal areas; gradients : those of them that are gradients and warm no plate.
    grid_areas : by element, the areas of a mean temperature that its grid is in.

    Raises
    ------
    InputError : a plate whose area is not there, is a gradient, or does not follow from its grid; a layout without
        geometry.
    PhysicsError : a nominal ray misses an element.
    """
    plates = layout.changing_plates
    if not plates:
        return None
    if not layout.has_geometry:
        raise InputError(
            f"{plates[0].name} changes with temperature, which needs the geometry of the layout",
            where="element",
            hint="give the elements their normals and the paths their steps, or leave dn_dT_1_K and expansion_1_K out",
        )
    change = np.zeros((len(plates), 2, len(areas)))
    for place, plate in enumerate(plates):
        at = areas.index(_area_of(plate, areas, gradients, grid_areas.get(plate.name, ())))
        change[place, INDEX, at] = plate.dn_dT_per_K
        change[place, THICKNESS, at] = plate.expansion_per_K * plate.thickness_m
    return PlateEffect(plates, plate_sensitivity(layout, plates), change)


def _area_of(plate: Element, areas: Sequence[str], gradients: Sequence[str], of_grid: Sequence[str]) -> str:
    if plate.area is None:
        if len(of_grid) == 1:
            return of_grid[0]
        several = f"is in several thermal areas ({', '.join(of_grid)})" if of_grid else "is in no thermal area"
        raise InputError(
            f"the temperature of the plate {plate.name} is not known: its grid {plate.grid} {several}",
            where=f"element {plate.name}",
            hint='name the thermal area of its glass: area = "..."; `tedm areas` lists them',
        )
    if plate.area not in areas:
        near = difflib.get_close_matches(plate.area, areas, n=1, cutoff=0.5)
        raise InputError(
            f"the temperature of the plate {plate.name} follows the thermal area {plate.area!r}, which does not exist",
            where=f"element {plate.name}",
            hint=f"did you mean {near[0]}?" if near else "`tedm areas` lists them",
        )
    if plate.area in gradients:
        raise InputError(
            f"the temperature of the plate {plate.name} follows {plate.area!r}, which is a gradient in K/m, not a"
            " temperature",
            where=f"element {plate.name}",
            hint="name an area of a mean temperature",
        )
    return plate.area


def plate_sensitivity(layout: OpticalLayout, plates: Sequence[Element]) -> FloatArray:
    """Outputs x, y, opl (m), z1, z2 (rad) of all beams by index (1) and thickness (m) of plates, [5 * n_paths, p, 2].

    Raises
    ------
    PhysicsError : a nominal ray misses an element.
    """
    place = {layout.index(plate.name): i for i, plate in enumerate(plates)}
    normal = np.real(nominal_poses(layout).normal)
    out = np.zeros((N_OUTPUTS * len(layout.paths), len(plates), 2))
    for path in linearised_paths(layout):
        rows = out[layout.rows(path.path)]  # a view
        steps = [0, *(hit.step for hit in path.hits), 0]  # hits of one step but the last are inside the plate
        for i, hit in enumerate(path.hits):
            if hit.element in place:
                inside = (steps[i] == hit.step, steps[i + 2] == hit.step)
                faces = path.by_motion[i][:, SHIFT] @ normal[hit.element] / (2.0 if hit.face == "front" else -2.0)
                rows[:, place[hit.element], INDEX] += path.outputs[i] @ _by_index(hit, *inside)
                rows[:, place[hit.element], THICKNESS] += path.outputs[i] @ faces
    return out


def _by_index(hit: Hit, before: bool, behind: bool) -> FloatArray:
    """State [7] of the ray behind a hit by the index of the plate, which is before it, behind it, or both.

    The ray has come `dopl = t dn` where it was inside. Refracted, with c1, c2 the cosines before and behind,

        d' = mu d + (mu c1 - c2) n,   c2^2 = 1 - mu^2 (1 - c1^2):   dd' = (d + (c1 + mu (1 - c1^2) / c2) n) dmu
    """
    state = np.zeros(7)
    if before:
        state[OPL] = hit.distance
    if hit.kind == "refract":
        mu = hit.index_in / hit.index_out
        by_mu = before / hit.index_out - behind * mu / hit.index_out
        c1 = -float(hit.direction @ hit.normal)
        c2 = np.sqrt(1 - mu**2 * (1 - c1**2))
        state[DIRECTION] = by_mu * (hit.direction + (c1 + mu * (1 - c1**2) / c2) * hit.normal)
    return state
