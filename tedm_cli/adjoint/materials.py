"""What the moduli, expansions and densities of materials and the thickness of shells do to the outputs.

With y = g u, K u = f(T), K λ = gᵀ, and of a material m the parts K_m of the stiffness and f_m of the thermal forces,

    ∂y/∂ln E_m = λᵀ (f_m - K_m u)         E and G grow together: the Poisson ratio stays
    ∂y/∂ln α_m = λᵀ f_m                   the forces of its expansion: Σ_m is y
    ∂y/∂ln ρ_m = -G_m u                   G_m the gravity of its mass

The displacements u are those under the unit loads of the areas, so that nothing is solved for a material.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tedm_cli.adjoint.areas import Warmed, temperatures
from tedm_cli.arrays import BoolArray, FloatArray, IntArray
from tedm_cli.fem.adjoint import TemperatureSensitivity
from tedm_cli.fem.parts import (
    NodalForces,
    of_elements,
    part_work,
    shell_ids,
    with_law_rates,
    with_shell_expansion,
    with_unit_expansion,
)
from tedm_cli.fem.structure import Structure

NONE = -1
"""Row of no material."""
# Of membrane, bending and transverse shear stiffness by the logarithm of a shell's thickness.
_BY_THICKNESS = np.array([1.0, 3.0, 1.0])


@dataclass(frozen=True, eq=False, kw_only=True)
class MaterialUse:
    """What E elements are made of: m materials, and q properties of shells that have a thickness.

    material_id : [m], ascending. expansion : [m], 1/K, NaN of those that are not the same in all directions.
    shell_property_id : [q], ascending.
    element_id : [E], ascending.
    law : [E, 3], rows of the materials of membrane, bending and transverse shear of a shell, `NONE` where it has none;
        of other elements three times the same.
    mass : [E], row of the material whose density it has, or `NONE`.
    thickness : [E], row of the shell property whose thickness it has, or `NONE`.
    """

    material_id: IntArray
    expansion: FloatArray
    shell_property_id: IntArray
    element_id: IntArray
    law: IntArray
    mass: IntArray
    thickness: IntArray

    def laws_of(self, ids: IntArray) -> IntArray:
        """`law` [n, 3] of elements."""
        return np.asarray(self.law[np.searchsorted(self.element_id, ids)])


@dataclass(frozen=True, eq=False, kw_only=True)
class ThermalShare:
    """Changes of r outputs under k areas by forces alone, and the stiffness that the change of displacements lacks.

    by_force : [r, k], λᵀ ∂f/∂p. elastic : its work over the displacements under the areas is to be taken off.
    """

    by_force: FloatArray
    elastic: NodalForces


@dataclass(frozen=True, eq=False, kw_only=True)
class MaterialWork:
    """Of m materials and q thicknesses, r outputs and k areas, all that needs no displacements.

    dalpha : [m, r, k], by an expansion of 1/K in all directions. dlnalpha : [m, r, k].
    modulus, thickness : m and q shares, by ln E and by ln t.
    """

    dalpha: FloatArray
    dlnalpha: FloatArray
    modulus: list[ThermalShare]
    thickness: list[ThermalShare]


def material_work(
    structure: Structure, use: MaterialUse, found: TemperatureSensitivity, own: BoolArray, areas: Sequence[Warmed]
) -> MaterialWork:
    """Work of the materials' forces over the solutions of an adjoint.

    Parameters
    ----------
    found : the adjoint of the structure. own : [L], see `temperatures`.
    """

    def share(part: Structure) -> ThermalShare:
        thermal, elastic = part_work(part, found.motion, found)
        return ThermalShare(by_force=temperatures(thermal, own).sums(areas), elastic=elastic)

    modulus, dalpha, dlnalpha = [], [], []
    for row, expansion in enumerate(use.expansion):
        part = of_elements(structure, use.element_id[(use.law == row).any(axis=1)])
        mine = use.laws_of(shell_ids(part)) == row
        modulus.append(share(with_law_rates(part, mine.astype(np.float64))))
        expanding = with_shell_expansion(part, mine[:, :2])
        dlnalpha.append(modulus[-1].by_force if mine.all() else share(expanding).by_force)
        if np.isfinite(expansion) and expansion != 0.0:
            dalpha.append(dlnalpha[-1] / expansion)
        else:
            dalpha.append(share(with_shell_expansion(with_unit_expansion(part), mine[:, :2])).by_force)
    thickness = []
    for row in range(len(use.shell_property_id)):
        part = of_elements(structure, use.element_id[use.thickness == row])
        thickness.append(share(with_law_rates(part, np.tile(_BY_THICKNESS, (len(shell_ids(part)), 1)))))
    shape = (len(use.material_id), len(found.grid), len(areas))
    return MaterialWork(
        dalpha=np.array(dalpha).reshape(shape),
        dlnalpha=np.array(dlnalpha).reshape(shape),
        modulus=modulus,
        thickness=thickness,
    )
