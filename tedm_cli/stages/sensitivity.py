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
from tedm_cli.gravity.cuboid_source import field_of_other_test_mass
from tedm_cli.gravity.field import SelfGravity, acceleration_by_source, self_gravity
from tedm_cli.gravity.operator import contract, lumped_operator, sensitivity_row_labels, sensitivity_row_units
from tedm_cli.gravity.testmass import TestMass
from tedm_cli.progress import Step
from tedm_cli.stages.common import (
    BLOCK_NODES,
    DISTORTION,
    SENSITIVITY,
    UNIT_LOADS,
    FloatArray,
    IntArray,
    copy_areas,
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
    ids, position, mass = unit.array("/grid/id"), unit.array("/grid/position"), unit.array("/mass/lumped")
    copy_areas(distortion, writer)
    writer.write("/grid/id", ids)
    writer.write("/test_mass/name", [t.name for t in test_masses])
    writer.write("/test_mass/position", [t.position_m for t in test_masses])
    writer.write("/test_mass/side", [t.side_m for t in test_masses])
    writer.write("/test_mass/mass", [t.mass_kg for t in test_masses])
    writer.write("/test_mass/axes", [t.axes for t in test_masses])
    heavy = mass > 0
    structure = [self_gravity(position[heavy], mass[heavy], t, G=g, node_ids=ids[heavy]) for t in test_masses]
    other, error = _other_test_masses(test_masses, g, config.gravity.other_test_mass_points)
    fields = list(zip(structure, other, strict=True))  # [test mass][source]
    writer.write("/source/name", SOURCES)
    writer.write("/source/quadrature_error", np.stack([np.zeros(len(test_masses)), error], axis=1))
    acceleration = _stack(fields, "acceleration")
    angular = _stack(fields, "angular_acceleration")
    writer.write("/dc/acceleration", acceleration)
    writer.write("/dc/angular_acceleration", angular)
    for name in STIFFNESS:
        writer.write(f"/stiffness/{name}", _stack(fields, name))
    writer.write("/area_contribution/acceleration", _by_area(unit, position, mass, ids, test_masses, g))
    labels, units = sensitivity_row_labels(test_masses), sensitivity_row_units(test_masses)
    writer.write("/row/label", labels)
    writer.write("/row/unit", units)
    sensitivity = _sensitivity(unit, distortion, writer, test_masses, g, step)
    writer.write("/S", sensitivity, units="m/s^2/K or rad/s^2/K, see /row/unit")
    names = distortion.strings("/area/name")
    largest = [(names[int(np.abs(row).argmax())], float(row[int(np.abs(row).argmax())])) for row in sensitivity]
    return SensitivitySummary(
        out, test_masses, SOURCES, acceleration, angular, _stack(fields, "gamma_lin"), labels, units, largest
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


def _by_area(
    unit: Reader, position: FloatArray, mass: FloatArray, ids: IntArray, test_masses: list[TestMass], g: float
) -> FloatArray:
    offset, index = unit.array("/area/node_offset"), unit.array("/area/node_index")
    out = np.zeros((len(test_masses), len(offset) - 1, 3))
    for t, tm in enumerate(test_masses):
        acceleration = acceleration_by_source(position, mass, tm, G=g, node_ids=ids)
        for a in range(len(offset) - 1):
            out[t, a] = acceleration[index[offset[a] : offset[a + 1]]].sum(axis=0)
    return out


def _sensitivity(
    unit: Reader, distortion: Reader, writer: Writer, test_masses: list[TestMass], g: float, step: Step
) -> FloatArray:
    ids, position, mass = unit.array("/grid/id"), unit.array("/grid/position"), unit.array("/mass/lumped")
    d = distortion.dataset("/D/translation")
    n_rows, n_areas = 6 * len(test_masses), d.shape[0]
    target = writer.allocate(
        "/operator/G", (n_rows, len(ids), 3), units="1/s^2 (a) or 1/(m s^2) (omegadot), see /row/label"
    )
    total = np.zeros((n_rows, n_areas))
    for start in range(0, len(ids), BLOCK_NODES):
        block = slice(start, min(start + BLOCK_NODES, len(ids)))
        g_block = lumped_operator(position[block], mass[block], test_masses, G=g, node_ids=ids[block])
        target[:, block] = g_block
        total += contract(g_block, d[:, block])
        step(block.stop, len(ids), "contracting S = -G D")
    return total
