"""build-sensitivity: masses and [D] to the self-gravity field, its stiffness and the sensitivity matrix [S_SG]."""

from __future__ import annotations

import functools
import itertools
import operator
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tedm_cli.arrays import FloatArray
from tedm_cli.columns import Columns
from tedm_cli.config.model.compensation import compensation_masses
from tedm_cli.config.model.file import ModelConfig, load_model
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
from tedm_cli.gravity.compensation import BlockQuadrature, CompensationMass
from tedm_cli.gravity.field import OTHER_TEST_MASS, SelfGravity
from tedm_cli.gravity.motion import linearised_motion, motion_labels
from tedm_cli.gravity.operator import sensitivity_row_labels, sensitivity_row_units
from tedm_cli.gravity.requirements import DcVerdict
from tedm_cli.gravity.structure import StructureGravity
from tedm_cli.gravity.testmass import TestMass
from tedm_cli.progress import Step
from tedm_cli.results.gravity.at_rest import BY_AREA, by_group
from tedm_cli.results.gravity.ties import require_ties
from tedm_cli.results.sides import require_plane
from tedm_cli.results.unit_loads import area_of_grids
from tedm_cli.stages.common import copy_areas, copy_places, gravity_files, out_path
from tedm_cli.stages.gravity.at_rest import verdicts_at_rest, write_verdicts
from tedm_cli.stages.gravity.contraction import self_gravity_sensitivity, write_operator
from tedm_cli.stages.gravity.positions import position_columns, position_sensitivity
from tedm_cli.stages.gravity.pulls import Pulls, Sources, operator_rows, pulls_on
from tedm_cli.stages.gravity.tied_blocks import write_blocks


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


@dataclass(frozen=True, eq=False)
class GivenColumns:
    """Columns of [S_SG] that were made of results in parts, where there is no [D] to contract.

    columns : of all areas, rows as `reduction_of` has them. parts : the files that they are from. pulls : where these
    were summed already.
    """

    columns: Columns
    parts: Sequence[Path] = ()
    pulls: Pulls | None = None


def build_sensitivity(
    project: Project, output: Path | None, step: Step, given: GivenColumns | None = None
) -> SensitivitySummary:
    """Field of structure, other test mass and compensation masses on each test mass, and S = -G D, streamed.

    In G are the structure and the compensation masses that are tied to its grids; others stay still.

    Raises
    ------
    ConfigError : the model has no test masses.
    """
    config_file, config = load_model(project.model)
    config.required_test_masses(project.model)
    masses_file, distortion_file = project.build_dir / UNIT_LOADS_FILE, project.build_dir / DISTORTION_FILE
    out = out_path(project, SENSITIVITY_FILE, output)
    files = gravity_files(project, config)
    parts = () if given is None else given.parts
    trace = provenance([config_file], [masses_file, distortion_file, *files, *parts])
    with (
        open_checked(masses_file, UNIT_LOADS) as unit,
        open_checked(distortion_file, DISTORTION) as distortion,
        create(out, SENSITIVITY, trace) as writer,
    ):
        require_input(distortion, trace.inputs[0])
        require_same_areas(unit, distortion)
        require_plane(distortion, project, config)
        require_ties(unit, compensation_masses(project, config))
        return _build(project, config, unit, distortion, writer, out, given, step)


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
    project: Project,
    config: ModelConfig,
    unit: Reader,
    distortion: Reader,
    writer: Writer,
    out: Path,
    given: GivenColumns | None,
    step: Step,
) -> SensitivitySummary:
    test_masses, model = config.test_masses(), config.gravity.mass_model
    copy_areas(distortion, writer)
    copy_places(distortion, writer)
    writer.write(SENSITIVITY.GRID_ID, unit.array(UNIT_LOADS.GRID_ID))
    writer.write(SENSITIVITY.TEST_MASS_NAME, [t.name for t in test_masses])
    _write_bodies(writer, test_masses)
    pulls = pulls_on(project, config, unit, step) if given is None or given.pulls is None else given.pulls
    found, sources, blocks = pulls.structure, pulls.sources, pulls.blocks
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
    _write_motion(writer, test_masses, sources, pulls.mutual)
    by_area = _by_area(unit, found)
    writer.write(SENSITIVITY.AREA_CONTRIBUTION_ACCELERATION, by_area["acceleration"])
    writer.write(SENSITIVITY.AREA_CONTRIBUTION_ANGULAR_ACCELERATION, by_area["angular_acceleration"])
    writer.write(SENSITIVITY.AREA_CONTRIBUTION_GAMMA_LIN, by_area["gamma_lin"])
    pulled = {name: sources.stack(name) for name in BY_AREA}
    groups, of_blocks = distortion.strings(DISTORTION.AREA_GROUP), by_group(blocks, sources.of_blocks(blocks))
    verdicts = verdicts_at_rest(config, sources.names, pulled, by_area, groups, of_blocks)
    write_verdicts(writer, verdicts)
    labels, units = sensitivity_row_labels(test_masses), sensitivity_row_units(test_masses)
    writer.write(SENSITIVITY.ROW_LABEL, labels)
    writer.write(SENSITIVITY.ROW_UNIT, units)
    moved = None if given is None else given.columns.blocks
    write_blocks(writer, blocks, pulls.ties, distortion, pulls.masses.position, moved)
    levers = pulls.masses.lever_node
    if given is None:
        sensitivity = self_gravity_sensitivity(found, pulls.tied, levers, distortion, writer, step)
    else:
        write_operator(writer, *operator_rows(found, pulls.tied), levers)
        sensitivity = given.columns.columns[: len(labels)]
    writer.write(SENSITIVITY.S, sensitivity, units="m/s^2/K or rad/s^2/K, see /row/unit")
    if config.uncertainty.test_mass:
        if given is None:
            rates = position_sensitivity(config, pulls.masses, blocks, pulls.ties, distortion, step)
        else:
            rates = position_columns(config, given.columns.columns[len(labels) :])
        writer.write(SENSITIVITY.DS_DPOSITION, rates, units="per m and per /area/unit, see /row/unit")
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
