"""What materials and thicknesses do to the outputs: their shares, and the displacements of the unit loads."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from tedm_cli.adjoint.areas import Warmed
from tedm_cli.adjoint.density import GravitySum, gravity_share
from tedm_cli.adjoint.materials import MaterialUse, material_work
from tedm_cli.arrays import BoolArray, FloatArray
from tedm_cli.contracts import UNIT_LOADS
from tedm_cli.fem.adjoint import TemperatureSensitivity
from tedm_cli.fem.parts import NodalForces
from tedm_cli.fem.structure import Structure
from tedm_cli.files.store import Reader
from tedm_cli.gravity.masses import ElementMasses
from tedm_cli.nastran.geometry import ModelGeometry
from tedm_cli.progress import Step, counter

_BATCH = 16  # areas whose displacements are held at a time


@dataclass(frozen=True, eq=False, kw_only=True)
class MaterialChanges:
    """Changes of r outputs under k areas by m materials, and by q thicknesses of shells; as in adjoint.h5."""

    dlne: FloatArray
    dlnalpha: FloatArray
    dalpha: FloatArray
    dlnrho: FloatArray
    dlnt: FloatArray


def material_changes(
    structure: Structure,
    use: MaterialUse,
    found: TemperatureSensitivity,
    own: BoolArray,
    areas: Sequence[Warmed],
    gravity: list[tuple[int, int, NodalForces]],
    motions: Iterator[FloatArray],
) -> MaterialChanges:
    """Put the shares of the materials together.

    Parameters
    ----------
    found, own : as of `material_work`; the first rows are accelerations.
    gravity : rows of the material and of the thickness, and -G of the mass that has both; see `gravity_of`.
    motions : of all k areas in order, some at a time, [6 N, n] per unit of the area.
    """
    work = material_work(structure, use, found, own, areas)
    dlne, dlnt = (
        np.array([s.by_force for s in shares]).reshape(len(shares), len(found.grid), len(areas))
        for shares in (work.modulus, work.thickness)
    )
    dlnrho = np.zeros_like(dlne)
    start = 0
    for motion in motions:
        some = slice(start, start + motion.shape[1])
        start = some.stop
        for out, shares in ((dlne, work.modulus), (dlnt, work.thickness)):
            for row, share in enumerate(shares):
                out[row, :, some] -= share.elastic.work(motion)
        for material, thickness, mass in gravity:
            pulled = mass.work(motion)
            dlnrho[material, : len(pulled), some] += pulled
            if thickness >= 0:
                dlnt[thickness, : len(pulled), some] += pulled
    return MaterialChanges(dlne=dlne, dlnalpha=work.dlnalpha, dalpha=work.dalpha, dlnrho=dlnrho, dlnt=dlnt)


def gravity_of(
    geometry: ModelGeometry, use: MaterialUse, heavy: BoolArray, how: GravitySum, step: Step
) -> list[tuple[int, int, NodalForces]]:
    """-G of the mass of materials, by rows of the material and of the thickness (-1: none) of its elements.

    Parameters
    ----------
    heavy : [E], elements of the model that count, those of the test masses themselves left out.
    """
    e = geometry.elements
    masses = ElementMasses(
        id=e.id,
        card=e.type,
        mass=e.structural_kg,
        node_offset=e.node_offset,
        node_index=e.node_index,
        lever=e.structural_lever,
        section=e.section,
        weight=e.structural_weight,
    )
    out = []
    heavy = heavy & (e.structural_kg != 0.0) & (use.mass >= 0)
    advance = counter(step, len(how.test_masses) * int(heavy.sum()), "summing the materials")
    for material, thickness in np.unique(np.stack([use.mass, use.thickness], axis=1)[heavy], axis=0):
        members = heavy & (use.mass == material) & (use.thickness == thickness)
        out.append((int(material), int(thickness), gravity_share(geometry.position_m, masses, members, how, advance)))
    return out


def unit_motions(unit: Reader) -> Iterator[FloatArray]:
    """Displacements [6 N, n] under the unit loads, per unit of their areas, some areas at a time."""
    load = unit.array(UNIT_LOADS.AREA_LOAD_K)
    translation, rotation = unit.dataset(UNIT_LOADS.TRANSLATION), unit.dataset(UNIT_LOADS.ROTATION)
    for start in range(0, len(load), _BATCH):
        some = slice(start, start + _BATCH)
        motion = np.concatenate([translation[some], rotation[some]], axis=2, dtype=np.float64)
        yield np.ascontiguousarray((motion / load[some, None, None]).reshape(len(motion), -1).T)
