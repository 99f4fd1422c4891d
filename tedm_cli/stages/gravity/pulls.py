"""What pulls on the test masses of a project, and what displacements are reduced by for [S_SG]."""

from __future__ import annotations

import functools
import itertools
import operator
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tedm_cli.arrays import FloatArray, IntArray
from tedm_cli.columns import FollowedGrids, Reduction
from tedm_cli.config.model.compensation import compensation_masses
from tedm_cli.config.model.file import ModelConfig
from tedm_cli.config.project import Project
from tedm_cli.contracts import UNIT_LOADS
from tedm_cli.distortion import RigidFit
from tedm_cli.files.store import Reader
from tedm_cli.gravity.body_source import field_of_other_test_mass
from tedm_cli.gravity.compensation import BlockQuadrature, CompensationMass, field_of_compensation_masses
from tedm_cli.gravity.field import COMPENSATION, OTHER_TEST_MASS, STRUCTURE, SelfGravity, self_gravity
from tedm_cli.gravity.masses import MassDistribution
from tedm_cli.gravity.structure import StructureGravity, stack_rows, structure_gravity
from tedm_cli.gravity.testmass import TestMass
from tedm_cli.gravity.ties import TiedOperator, follower, needs_rotations
from tedm_cli.progress import Step, counter
from tedm_cli.results.gravity.ties import Ties, require_ties
from tedm_cli.results.unit_loads import mass_of
from tedm_cli.stages.common import check_test_masses
from tedm_cli.stages.gravity.positions import moved_operators
from tedm_cli.stages.gravity.tied_blocks import tied_operators
from tedm_cli.threads import side_by_side


@dataclass(frozen=True)
class Sources:
    """What pulls on the test masses: fields, and the error and points of each quadrature, all [source][test mass]."""

    names: tuple[str, ...]
    fields: list[list[SelfGravity]]
    error: list[list[float]]
    points: list[list[int]]
    block_quadrature: list[BlockQuadrature]

    def stack(self, name: str) -> FloatArray:
        """One quantity of all fields, [test mass, source, ...]."""
        return np.array([[getattr(f, name) for f in row] for row in self.fields], dtype=float).swapaxes(0, 1)

    def of_blocks(self, blocks: list[CompensationMass]) -> list[list[SelfGravity]]:
        """The field of each block, [test mass][block]."""
        count = max(len(blocks), 1)
        found = [how.field for how in self.block_quadrature]
        return [found[start : start + count] for start in range(0, len(found), count)]


@dataclass(frozen=True, eq=False)
class Pulls:
    """Masses of a model and their pull on each test mass; `tied`: what tied blocks add to the operator of each.

    mutual : field of test mass j on i and the error of its quadrature, by (i, j).
    """

    masses: MassDistribution
    blocks: list[CompensationMass]
    ties: Ties
    structure: list[StructureGravity]
    mutual: dict[tuple[int, int], tuple[SelfGravity, float]]
    sources: Sources
    tied: list[TiedOperator]


def pulls_on(project: Project, config: ModelConfig, unit: Reader, step: Step) -> Pulls:
    """Sum all that pulls on the test masses, by the geometry and masses in unit_loads.h5.

    Raises
    ------
    ConfigError : test masses that the structure cannot hold. InputError : blocks tied to something else since.
    """
    blocks = compensation_masses(project, config)
    ties, test_masses = require_ties(unit, blocks), config.test_masses()
    check_test_masses(test_masses, unit.array(UNIT_LOADS.GRID_POSITION), where=str(project.model))
    g, tolerance = config.gravity.gravitational_constant_m3_kg_s2, config.gravity.quadrature_tolerance
    masses = mass_of(unit, lumped=config.gravity.mass_model == "lumped")
    elements = sum(len(block.id) for block in masses.elements)
    advance = counter(step, len(test_masses) * elements, "summing the structure")
    found = side_by_side(
        lambda tm, on: structure_gravity(masses, tm, tolerance=tolerance, G=g, advance=on), test_masses, advance
    )
    mutual = _mutual(test_masses, g, config.gravity.other_test_mass_points)
    sources = _sources(found, test_masses, blocks, mutual, config)
    tied = tied_operators(test_masses, blocks, sources.block_quadrature, ties, masses.position, masses.lever_node)
    return Pulls(masses, blocks, ties, found, mutual, sources, tied)


def reduction_of(
    project: Project, config: ModelConfig, unit: Reader, optics: IntArray, step: Step
) -> tuple[Reduction, Pulls]:
    """What displacements are reduced by: the operator, then its changes by uncertain positions, as rows; grids.

    optics : rows [E] of the grids of optical elements.
    """
    pulls = pulls_on(project, config, unit, step)
    rows, turns = operator_rows(pulls.structure, pulls.tied)
    changes = [rates for _, _, rates in moved_operators(config, pulls.masses, pulls.blocks, pulls.ties, step)]
    position = pulls.masses.position
    reduction = Reduction(
        operator=np.ascontiguousarray(np.concatenate([rows, *(own for own, _ in changes)])),
        rotation=np.ascontiguousarray(np.concatenate([turns, *(own for _, own in changes)])),
        levers=pulls.masses.lever_node,
        optics=optics,
        blocks=tuple(_followed(block, pulls, position) for block in pulls.blocks if block.tie is not None),
        fit=RigidFit(position, unit.array(UNIT_LOADS.MASS_LUMPED), unit.array(UNIT_LOADS.MASS_CENTRE_OF_GRAVITY)),
    )
    return reduction, pulls


def operator_rows(structure: Sequence[StructureGravity], tied: Sequence[TiedOperator]) -> tuple[FloatArray, FloatArray]:
    """G [6 t, N, 3] by translations and [6 t, L, 3] by rotations, of structure and tied blocks."""
    rows, turns = stack_rows([s.operator for s in structure]), stack_rows([s.rotation for s in structure])
    rows[:, tied[0].row] += stack_rows([t.operator for t in tied])
    turns[:, tied[0].lever] += stack_rows([t.rotation for t in tied])
    return rows, turns


def _followed(block: CompensationMass, pulls: Pulls, position: FloatArray) -> FollowedGrids:
    nodes = pulls.ties.rows(block.name)
    turning = nodes if needs_rotations(position[nodes]) else nodes[:0]
    places = np.searchsorted(pulls.masses.lever_node, turning)
    return FollowedGrids(nodes, follower(position[nodes], block.centre_m), places)


def _sources(
    structure: list[StructureGravity],
    test_masses: list[TestMass],
    blocks: list[CompensationMass],
    mutual: dict[tuple[int, int], tuple[SelfGravity, float]],
    config: ModelConfig,
) -> Sources:
    none = self_gravity(np.zeros((0, 3)), np.zeros(0), test_masses[0])
    count = range(len(test_masses))
    other = [functools.reduce(operator.add, (f for (i, _), (f, _) in mutual.items() if i == t), none) for t in count]
    other_error = [max((e for (i, _), (_, e) in mutual.items() if i == t), default=0.0) for t in count]
    own_error = np.nan if config.gravity.mass_model == "lumped" else config.gravity.quadrature_tolerance
    other_points = (len(test_masses) - 1) * config.gravity.other_test_mass_points**3
    sources = Sources(
        (STRUCTURE, OTHER_TEST_MASS),
        [[s.field for s in structure], other],
        [[own_error] * len(test_masses), other_error],
        [[s.sources for s in structure], [other_points] * len(test_masses)],
        [],
    )
    if not blocks:
        return sources
    g, tolerance = config.gravity.gravitational_constant_m3_kg_s2, config.gravity.compensation_tolerance
    done = [field_of_compensation_masses(tm, blocks, g, tolerance=tolerance) for tm in test_masses]
    return Sources(
        (*sources.names, COMPENSATION),
        [*sources.fields, [field for field, _, _ in done]],
        [*sources.error, [error for _, error, _ in done]],
        [*sources.points, [sum(how.points for how in quadrature) for _, _, quadrature in done]],
        [how for _, _, quadrature in done for how in quadrature],
    )


def _mutual(test_masses: list[TestMass], g: float, points: int) -> dict[tuple[int, int], tuple[SelfGravity, float]]:
    """Field on test mass i of test mass j and the error of its quadrature, by (i, j)."""
    pairs = itertools.permutations(range(len(test_masses)), 2)
    return {(i, j): field_of_other_test_mass(test_masses[i], test_masses[j], G=g, n=points) for i, j in pairs}
