"""build-sensitivity: masses and [D] to the self-gravity field, its stiffness and the sensitivity matrix [S_SG]."""

from __future__ import annotations

import functools
import itertools
import operator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tedm_cli.arrays import FloatArray
from tedm_cli.config.compensation import compensation_file, compensation_masses
from tedm_cli.config.model import ModelConfig, load_model
from tedm_cli.config.project import Project
from tedm_cli.contracts import DISTORTION, SENSITIVITY, UNIT_LOADS
from tedm_cli.files.build_folder import (
    DISTORTION_FILE,
    SENSITIVITY_FILE,
    UNIT_LOADS_FILE,
    provenance,
    require_input,
    require_same_areas,
)
from tedm_cli.files.store import Reader, Writer, create, open_checked
from tedm_cli.gravity.body_source import field_of_other_test_mass
from tedm_cli.gravity.compensation import BlockQuadrature, CompensationMass, field_of_compensation_masses
from tedm_cli.gravity.field import COMPENSATION, OTHER_TEST_MASS, STRUCTURE, SelfGravity, self_gravity
from tedm_cli.gravity.motion import linearised_motion, motion_labels
from tedm_cli.gravity.operator import sensitivity_row_labels, sensitivity_row_units
from tedm_cli.gravity.requirements import DcVerdict
from tedm_cli.gravity.structure import StructureGravity, structure_gravity
from tedm_cli.gravity.testmass import TestMass
from tedm_cli.progress import Step, counter
from tedm_cli.results.at_rest import BY_AREA, by_group
from tedm_cli.results.sides import require_plane
from tedm_cli.results.ties import Ties, require_ties
from tedm_cli.results.unit_loads import area_of_grids, mass_of
from tedm_cli.stages.common import check_test_masses, copy_areas, copy_places, out_path
from tedm_cli.stages.gravity.at_rest import verdicts_at_rest, write_verdicts
from tedm_cli.stages.gravity.contraction import self_gravity_sensitivity
from tedm_cli.stages.gravity.positions import position_sensitivity
from tedm_cli.stages.gravity.tied_blocks import tied_operators, write_blocks
from tedm_cli.threads import side_by_side


@dataclass(frozen=True)
class SensitivitySummary:
    path: Path
    test_masses: list[TestMass]
    sources: tuple[str, ...]
    acceleration: FloatArray
    angular_acceleration: FloatArray
    gamma_lin: FloatArray
    row_labels: list[str]
    row_units: list[str]
    largest: list[tuple[str, float]]
    blocks: list[CompensationMass]
    block_quadrature: list[BlockQuadrature]
    verdicts: list[DcVerdict]
    mass_model: str
    points: list[int]
    subsystems: list[str]


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


def build_sensitivity(project: Project, output: Path | None, step: Step) -> SensitivitySummary:
    """Field of structure, other test mass and compensation masses on each test mass, and S = -G D, streamed.

    In G are the structure and the compensation masses that are tied to its grids; others stay still.

    Raises
    ------
    ConfigError : the model has no test masses.
    """
    config_file, config = load_model(project.model)
    config.required_test_masses(project.model)
    blocks, block_file = compensation_masses(project, config), compensation_file(project, config)
    masses_file, distortion_file = project.build_dir / UNIT_LOADS_FILE, project.build_dir / DISTORTION_FILE
    out = out_path(project, SENSITIVITY_FILE, output)
    files = [*([] if block_file is None else [block_file]), *map(project.resolve, config.body_files())]
    trace = provenance([config_file], [masses_file, distortion_file, *dict.fromkeys(files)])
    with (
        open_checked(masses_file, UNIT_LOADS) as unit,
        open_checked(distortion_file, DISTORTION) as distortion,
        create(out, SENSITIVITY, trace) as writer,
    ):
        require_input(distortion, trace.inputs[0])
        require_same_areas(unit, distortion)
        require_plane(distortion, project, config)
        ties = require_ties(unit, blocks)
        return _build(config, blocks, ties, unit, distortion, writer, out, project, step)


def _write_bodies(writer: Writer, test_masses: list[TestMass]) -> None:
    writer.write(SENSITIVITY.TEST_MASS_POSITION, [t.position_m for t in test_masses])
    writer.write(SENSITIVITY.TEST_MASS_SHAPE, [t.body.words for t in test_masses])
    writer.write(SENSITIVITY.TEST_MASS_SIDE, [t.side_m for t in test_masses])
    writer.write(SENSITIVITY.TEST_MASS_BOX_CENTRE, [t.box_centre_m for t in test_masses])
    writer.write(SENSITIVITY.TEST_MASS_MASS, [t.mass_kg for t in test_masses])
    writer.write(SENSITIVITY.TEST_MASS_INERTIA, [t.inertia_kg_m2 for t in test_masses])
    writer.write(SENSITIVITY.TEST_MASS_AXES, [t.axes for t in test_masses])
    surfaces = [t.surface() for t in test_masses]
    writer.write(SENSITIVITY.TEST_MASS_SURFACE, np.concatenate(surfaces))
    owner = np.repeat(np.arange(len(surfaces)), [len(surface) for surface in surfaces])
    writer.write(SENSITIVITY.TEST_MASS_SURFACE_OWNER, owner)


def _build(
    config: ModelConfig,
    blocks: list[CompensationMass],
    ties: Ties,
    unit: Reader,
    distortion: Reader,
    writer: Writer,
    out: Path,
    project: Project,
    step: Step,
) -> SensitivitySummary:
    test_masses = config.test_masses()
    g = config.gravity.gravitational_constant_m3_kg_s2
    copy_areas(distortion, writer)
    copy_places(distortion, writer)
    writer.write(SENSITIVITY.GRID_ID, unit.array(UNIT_LOADS.GRID_ID))
    writer.write(SENSITIVITY.TEST_MASS_NAME, [t.name for t in test_masses])
    _write_bodies(writer, test_masses)
    model, tolerance = config.gravity.mass_model, config.gravity.quadrature_tolerance
    check_test_masses(test_masses, unit.array(UNIT_LOADS.GRID_POSITION), where=str(project.model))
    masses = mass_of(unit, lumped=model == "lumped")
    elements = sum(len(block.id) for block in masses.elements)
    advance = counter(step, len(test_masses) * elements, "summing the structure")
    found = side_by_side(
        lambda tm, on: structure_gravity(masses, tm, tolerance=tolerance, G=g, advance=on), test_masses, advance
    )
    mutual = _mutual(test_masses, g, config.gravity.other_test_mass_points)
    sources = _sources(found, test_masses, blocks, mutual, config)
    writer.write(SENSITIVITY.SOURCE_NAME, sources.names)
    writer.write(SENSITIVITY.SOURCE_QUADRATURE_ERROR, np.array(sources.error).T)
    writer.write(SENSITIVITY.SOURCE_POINTS, np.array(sources.points).T)
    writer.write(SENSITIVITY.SOURCE_MASS_MODEL, model)
    writer.write(SENSITIVITY.DC_ACCELERATION, sources.stack("acceleration"))
    writer.write(SENSITIVITY.DC_ANGULAR_ACCELERATION, sources.stack("angular_acceleration"))
    writer.write(SENSITIVITY.STIFFNESS_GAMMA_LIN, sources.stack("gamma_lin"))
    writer.write(SENSITIVITY.STIFFNESS_OMEGA_LIN, sources.stack("omega_lin"))
    writer.write(SENSITIVITY.STIFFNESS_GAMMA_ANG, sources.stack("gamma_ang"))
    writer.write(SENSITIVITY.STIFFNESS_OMEGA_ANG, sources.stack("omega_ang"))
    _write_motion(writer, test_masses, sources, mutual)
    by_area = _by_area(unit, found)
    writer.write(SENSITIVITY.AREA_CONTRIBUTION_ACCELERATION, by_area["acceleration"])
    writer.write(SENSITIVITY.AREA_CONTRIBUTION_ANGULAR_ACCELERATION, by_area["angular_acceleration"])
    writer.write(SENSITIVITY.AREA_CONTRIBUTION_GAMMA_LIN, by_area["gamma_lin"])
    pulls = {name: sources.stack(name) for name in BY_AREA}
    groups, of_blocks = distortion.strings(DISTORTION.AREA_GROUP), by_group(blocks, sources.of_blocks(blocks))
    verdicts = verdicts_at_rest(config, sources.names, pulls, by_area, groups, of_blocks)
    write_verdicts(writer, verdicts)
    labels, units = sensitivity_row_labels(test_masses), sensitivity_row_units(test_masses)
    writer.write(SENSITIVITY.ROW_LABEL, labels)
    writer.write(SENSITIVITY.ROW_UNIT, units)
    write_blocks(writer, blocks, ties, distortion, masses.position)
    tied = tied_operators(test_masses, blocks, sources.block_quadrature, ties, masses.position, masses.lever_node)
    sensitivity = self_gravity_sensitivity(found, tied, masses.lever_node, distortion, writer, step)
    writer.write(SENSITIVITY.S, sensitivity, units="m/s^2/K or rad/s^2/K, see /row/unit")
    if config.uncertainty.test_mass:
        rates, moved = position_sensitivity(config, masses, blocks, ties, distortion, step)
        writer.write(SENSITIVITY.DS_DPOSITION, rates, units="per m and per /area/unit, see /row/unit")
        if project.thermal is not None:  # displacements under its nodes are not those under the areas
            writer.write(SENSITIVITY.MOVED_NAME, moved.name)
            writer.write(SENSITIVITY.MOVED_OPERATOR, np.array(moved.operator))
            writer.write(SENSITIVITY.MOVED_ROTATION, np.array(moved.rotation))
    names = distortion.strings(DISTORTION.AREA_NAME)
    largest = [(names[int(np.abs(row).argmax())], float(row[int(np.abs(row).argmax())])) for row in sensitivity]
    return SensitivitySummary(
        out,
        test_masses,
        sources.names,
        sources.stack("acceleration"),
        sources.stack("angular_acceleration"),
        sources.stack("gamma_lin"),
        labels,
        units,
        largest,
        blocks,
        sources.block_quadrature,
        verdicts,
        model,
        [s.sources for s in found],
        list(config.gravity.subsystems),
    )


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


def _write_motion(
    writer: Writer,
    test_masses: list[TestMass],
    sources: Sources,
    mutual: dict[tuple[int, int], tuple[SelfGravity, float]],
) -> None:
    """The equations of motion: what moves with the satellite is structure and compensation masses."""
    rest = [
        functools.reduce(
            operator.add, (f[t] for n, f in zip(sources.names, sources.fields, strict=True) if n != OTHER_TEST_MASS)
        )
        for t in range(len(test_masses))
    ]
    stiffness = linearised_motion(test_masses, rest, {pair: field for pair, (field, _) in mutual.items()})
    outputs, motions = motion_labels(test_masses)
    writer.write(
        SENSITIVITY.STIFFNESS_LINEARISED, stiffness, units="1/s^2, m/s^2/rad, 1/(m s^2) or 1/(s^2 rad), by the labels"
    )
    writer.write(SENSITIVITY.LABEL_TM_OUTPUT, outputs)
    writer.write(SENSITIVITY.LABEL_TM_OUTPUT_UNIT, ["m/s^2" if "_a_" in name else "rad/s^2" for name in outputs])
    writer.write(SENSITIVITY.LABEL_TM_MOTION, motions)
    writer.write(
        SENSITIVITY.LABEL_TM_MOTION_UNIT, ["m" if name[-2:] in ("_x", "_y", "_z") else "rad" for name in motions]
    )


def _by_area(unit: Reader, found: list[StructureGravity]) -> dict[str, FloatArray]:
    """Field at rest by the mass that each area's grids carry, by quantity, [test mass, area, ...]; 0 of gradients."""
    label, areas = area_of_grids(unit), len(unit.strings(UNIT_LOADS.AREA_NAME))
    order = np.argsort(label, kind="stable")
    edges = np.searchsorted(label[order], np.arange(areas + 1))
    grids = [order[start:stop] for start, stop in itertools.pairwise(edges)]

    def sums(share: FloatArray) -> list[FloatArray]:
        return [share[rows].sum(axis=0) for rows in grids]

    return {name: np.array([sums(s.nodal(name)) for s in found]) for name in BY_AREA}
