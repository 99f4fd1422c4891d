"""build-sensitivity: masses and [D] to the self-gravity field, its stiffness and the sensitivity matrix [S_SG]."""

from __future__ import annotations

import functools
import operator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tedm_cli.config.model import ModelConfig, load_model
from tedm_cli.config.project import Project
from tedm_cli.contracts import DISTORTION as DISTORTION_KIND
from tedm_cli.contracts import SENSITIVITY as KIND
from tedm_cli.contracts import UNIT_LOADS as UNIT_KIND
from tedm_cli.errors import InputError
from tedm_cli.gravity.cuboid_source import field_of_other_test_mass
from tedm_cli.gravity.field import SelfGravity, self_gravity
from tedm_cli.gravity.masses import MassDistribution
from tedm_cli.gravity.operator import contract, sensitivity_row_labels, sensitivity_row_units
from tedm_cli.gravity.structure import StructureGravity, stack_rows, structure_gravity
from tedm_cli.gravity.testmass import TestMass
from tedm_cli.progress import Step
from tedm_cli.stages.common import (
    BLOCK_NODES,
    DISTORTION,
    SENSITIVITY,
    UNIT_LOADS,
    FloatArray,
    copy_areas,
    mass_of,
    out_path,
    provenance,
    require_input,
)
from tedm_cli.store import Reader, Writer, create, open_checked

SOURCES = ("structure", "other test mass")
STIFFNESS = ("gamma_lin", "omega_lin", "gamma_ang", "omega_ang")


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
    mass_model: str
    points: list[int]


def build_sensitivity(project: Project, output: Path | None, step: Step) -> SensitivitySummary:
    """Field of the structure and of the other test mass on each test mass, and S = -G D, streamed over the grids."""
    config_file, config = load_model(project.model)
    masses_file, distortion_file = project.build_dir / UNIT_LOADS, project.build_dir / DISTORTION
    out = out_path(project, SENSITIVITY, output)
    trace = provenance([config_file], [masses_file, distortion_file])
    with (
        open_checked(masses_file, UNIT_KIND) as unit,
        open_checked(distortion_file, DISTORTION_KIND) as distortion,
        create(out, KIND, trace) as writer,
    ):
        require_input(distortion, trace.inputs[0])
        return _build(config, unit, distortion, writer, out, step)


def _build(
    config: ModelConfig, unit: Reader, distortion: Reader, writer: Writer, out: Path, step: Step
) -> SensitivitySummary:
    test_masses = config.test_masses()
    g = config.gravity.gravitational_constant_m3_kg_s2
    copy_areas(distortion, writer)
    writer.write("/grid/id", unit.array("/grid/id"))
    writer.write("/test_mass/name", [t.name for t in test_masses])
    writer.write("/test_mass/position", [t.position_m for t in test_masses])
    writer.write("/test_mass/side", [t.side_m for t in test_masses])
    writer.write("/test_mass/mass", [t.mass_kg for t in test_masses])
    writer.write("/test_mass/axes", [t.axes for t in test_masses])
    model, tolerance = config.gravity.mass_model, config.gravity.quadrature_tolerance
    masses = mass_of(unit, lumped=model == "lumped")
    found = []
    for done, tm in enumerate(test_masses, start=1):
        found.append(structure_gravity(masses, tm, tolerance=tolerance, G=g))
        step(done, len(test_masses), "summing the structure")
    other, error = _other_test_masses(test_masses, g, config.gravity.other_test_mass_points)
    fields = list(zip((s.field for s in found), other, strict=True))  # [test mass][source]
    points = [s.sources for s in found]
    own = np.full(len(test_masses), np.nan if model == "lumped" else tolerance)
    others = (len(test_masses) - 1) * config.gravity.other_test_mass_points**3
    writer.write("/source/name", SOURCES)
    writer.write("/source/quadrature_error", np.stack([own, error], axis=1))
    writer.write("/source/points", [[n, others] for n in points])
    writer.write("/source/mass_model", model)
    acceleration = _stack(fields, "acceleration")
    angular = _stack(fields, "angular_acceleration")
    writer.write("/dc/acceleration", acceleration)
    writer.write("/dc/angular_acceleration", angular)
    for name in STIFFNESS:
        writer.write(f"/stiffness/{name}", _stack(fields, name))
    writer.write("/area_contribution/acceleration", _by_area(unit, [s.nodal_acceleration for s in found]))
    labels, units = sensitivity_row_labels(test_masses), sensitivity_row_units(test_masses)
    writer.write("/row/label", labels)
    writer.write("/row/unit", units)
    sensitivity = _sensitivity(masses, found, distortion, writer, step)
    writer.write("/S", sensitivity, units="m/s^2/K or rad/s^2/K, see /row/unit")
    names = distortion.strings("/area/name")
    largest = [(names[int(np.abs(row).argmax())], float(row[int(np.abs(row).argmax())])) for row in sensitivity]
    return SensitivitySummary(
        out,
        test_masses,
        SOURCES,
        acceleration,
        angular,
        _stack(fields, "gamma_lin"),
        labels,
        units,
        largest,
        model,
        points,
    )


def _other_test_masses(test_masses: list[TestMass], g: float, points: int) -> tuple[list[SelfGravity], list[float]]:
    """Summed field of all other test masses on each one, and the worst quadrature error among them."""
    fields, errors = [], []
    for tm in test_masses:
        parts = [field_of_other_test_mass(tm, other, G=g, n=points) for other in test_masses if other is not tm]
        none = self_gravity(np.zeros((0, 3)), np.zeros(0), tm)
        fields.append(functools.reduce(operator.add, (field for field, _ in parts), none))
        errors.append(max((error for _, error in parts), default=0.0))
    return fields, errors


def _stack(fields: list[tuple[SelfGravity, SelfGravity]], name: str) -> FloatArray:
    return np.array([[getattr(field, name) for field in row] for row in fields], dtype=float)


def _by_area(unit: Reader, nodal: list[FloatArray]) -> FloatArray:
    """Acceleration at rest by the mass that each area's grids carry, [test mass, area, 3]."""
    offset, index = unit.array("/area/node_offset"), unit.array("/area/node_index")
    areas = np.arange(len(offset) - 1)
    return np.array([[part[index[offset[a] : offset[a + 1]]].sum(axis=0) for a in areas] for part in nodal])


def _sensitivity(
    masses: MassDistribution, found: list[StructureGravity], distortion: Reader, writer: Writer, step: Step
) -> FloatArray:
    """S = -G D, with D read in blocks of grids; the operator itself is held, 24 numbers per grid and test mass."""
    units = "1/s^2 (a) or 1/(m s^2) (omegadot), see /row/label"
    offset_nodes = distortion.array("/D/offset_node")
    if not np.array_equal(offset_nodes, masses.lever_node):
        raise InputError(
            "lacks the rotations of the grids that carry offset masses",
            where=str(distortion.path),
            hint=f"rebuild it with `{distortion.kind.made_by}`",
        )
    turning = stack_rows([s.rotation for s in found])
    writer.write("/operator/offset_node", offset_nodes)
    writer.write("/operator/G_rotation", turning, units="m/s^2 (a) or 1/s^2 (omegadot) per rad, see /row/label")
    total = contract(turning, distortion.array("/D/rotation"))
    d = distortion.dataset("/D/translation")
    n_nodes = len(masses.position)
    target = writer.allocate("/operator/G", (len(total), n_nodes, 3), units=units)
    for start in range(0, n_nodes, BLOCK_NODES):
        block = slice(start, min(start + BLOCK_NODES, n_nodes))
        g_block = stack_rows([s.operator[:, :, block] for s in found])
        target[:, block] = g_block
        total += contract(g_block, d[:, block])
        step(block.stop, n_nodes, "contracting S = -G D")
    return total
