"""Forces of a strain that is given, such as that of moisture: as of a temperature, by a coefficient of its own."""

from __future__ import annotations

import numpy as np

from tedm_cli.arrays import IntArray
from tedm_cli.fem.assembly import assemble
from tedm_cli.fem.parts import of_elements, with_unit_expansion
from tedm_cli.fem.structure import OnFreedoms, Structure


def swelling_force(structure: Structure, element_id: IntArray, strain: float) -> OnFreedoms:
    """Nodal forces of a strain in all directions of some elements; rigid elements and offsets do not swell."""
    part = with_unit_expansion(of_elements(structure, element_id))
    force = np.asarray(assemble(part).thermal.coupling.sum(axis=1)).ravel()
    dof = np.flatnonzero(force)
    return OnFreedoms(dof, strain * force[dof])


def added(*forces: OnFreedoms) -> OnFreedoms:
    """Several forces together."""
    return OnFreedoms(np.concatenate([f.dof for f in forces]), np.concatenate([f.value for f in forces]))
