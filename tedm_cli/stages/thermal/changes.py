"""What uncertain materials, thicknesses and positions of test masses change of the outputs by thermal nodes."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from tedm_cli.adjoint.areas import Warmed
from tedm_cli.adjoint.density import GravitySum
from tedm_cli.arrays import FloatArray
from tedm_cli.contracts import ADJOINT, SENSITIVITY, UNIT_LOADS
from tedm_cli.contracts import THERMAL as KIND
from tedm_cli.fem.adjoint import TemperatureSensitivity
from tedm_cli.fem.structure import Structure
from tedm_cli.files.store import Reader, Writer
from tedm_cli.nastran.structure.material_use import material_use
from tedm_cli.progress import Step
from tedm_cli.stages.material_changes import MaterialChanges, gravity_of, material_changes
from tedm_cli.stages.output_inputs import OutputInputs
from tedm_cli.stages.thermal.map_build import Mapping


def changes_here(
    given: OutputInputs,
    structure: Structure,
    mapping: Mapping,
    fields: FloatArray,
    found: TemperatureSensitivity,
    motions: Iterator[FloatArray],
    step: Step,
) -> tuple[MaterialChanges, list[int], list[int]]:
    """Changes by materials and thicknesses under each node, and the ids of these materials and properties of shells.

    Parameters
    ----------
    fields : [N, n], of the grids per kelvin of each node. found : the adjoint of the same outputs. motions : under the
    nodes in order, some at a time, [6 N, m].
    """
    settings, unit = given.config.gravity, given.unit
    how = GravitySum(
        test_masses=given.config.test_masses(),
        tolerance=settings.quadrature_tolerance,
        constant=settings.gravitational_constant_m3_kg_s2,
        lumped=settings.mass_model == "lumped",
    )
    use = material_use(given.raw)
    gravity = gravity_of(mapping.fem.geometry, use, unit.array(UNIT_LOADS.ELEMENT_MASS) != 0.0, how, step)
    rows, none = np.arange(len(fields)), np.zeros(0, dtype=np.int64)
    nodes = [Warmed(grid=rows, element=none, step=fields[:, i]) for i in range(fields.shape[1])]
    own = np.zeros(len(found.element_id), dtype=bool)
    made = material_changes(structure, use, found, own, nodes, gravity, motions)
    return made, use.material_id.tolist(), use.shell_property_id.tolist()


def changes_of_areas(
    adjoint: Reader, columns: list[int], weights: FloatArray
) -> tuple[MaterialChanges, list[int], list[int]]:
    """The same of weighted areas, whose numbers in adjoint.h5 are `columns`."""

    def of(path: str) -> FloatArray:
        return np.asarray(adjoint.array(path)[:, :, columns] @ weights)

    made = MaterialChanges(
        dlne=of(ADJOINT.DS_DLNE),
        dlnalpha=of(ADJOINT.DS_DLNALPHA),
        dalpha=of(ADJOINT.DS_DALPHA),
        dlnrho=of(ADJOINT.DS_DLNRHO),
        dlnt=of(ADJOINT.DS_DLNT),
    )
    return made, adjoint.array(ADJOINT.MATERIAL_ID).tolist(), adjoint.array(ADJOINT.SHELL_PROPERTY_ID).tolist()


def write_changes(writer: Writer, changes: MaterialChanges, materials: list[int], shells: list[int]) -> None:
    """Put them into thermal.h5."""
    writer.write(KIND.CHANGE_MATERIAL, np.array(materials, dtype=np.int64))
    writer.write(KIND.CHANGE_SHELL, np.array(shells, dtype=np.int64))
    writer.write(KIND.CHANGE_DLNE, changes.dlne)
    writer.write(KIND.CHANGE_DLNALPHA, changes.dlnalpha)
    writer.write(KIND.CHANGE_DALPHA, changes.dalpha)
    writer.write(KIND.CHANGE_DLNRHO, changes.dlnrho)
    writer.write(KIND.CHANGE_DLNT, changes.dlnt)


@dataclass(eq=False)
class PositionChanges:
    """-dG D [6, n] of each uncertain position, node by node; sensitivity.h5 has dG where its project has a network."""

    sensitivity: Reader
    found: dict[int, FloatArray] = field(default_factory=dict)

    def __post_init__(self) -> None:
        file = self.sensitivity
        self.name = file.strings(SENSITIVITY.MOVED_NAME) if file.has(SENSITIVITY.MOVED_NAME) else []
        if self.name:
            self._operator = file.array(SENSITIVITY.MOVED_OPERATOR)
            self._rotation = file.array(SENSITIVITY.MOVED_ROTATION)
            self._lever = file.array(SENSITIVITY.OPERATOR_OFFSET_NODE)

    def add(self, k: int, motion: FloatArray) -> None:
        """The motion [N, 6] under 1 K of node k."""
        if self.name:
            moved = np.einsum("mrnc,nc->mr", self._operator, motion[:, :3])
            self.found[k] = -moved - np.einsum("mrlc,lc->mr", self._rotation, motion[self._lever, 3:])

    def write(self, writer: Writer) -> None:
        """Put them into thermal.h5."""
        if self.name:
            writer.write(KIND.MOVED_NAME, self.name)
            change = np.stack([self.found[k] for k in range(len(self.found))], axis=2)
            writer.write(KIND.MOVED_CHANGE, change)
