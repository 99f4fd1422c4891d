"""build-optics: layout and motion of the optical elements to S_BW, P, O_ideal, D and the noise matrices N."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tedm_cli.config.optics import load_layout
from tedm_cli.config.project import Project
from tedm_cli.contracts import DISTORTION as DISTORTION_KIND
from tedm_cli.contracts import OPTICS as KIND
from tedm_cli.errors import InputError, PhysicsError
from tedm_cli.optics.chain import noise_by_element, optics_chain
from tedm_cli.optics.invariances import invariance_residuals
from tedm_cli.optics.labels import input_labels, laser_labels, output_labels, read_out_labels
from tedm_cli.optics.layout_checks import Finding, check_layout, failures
from tedm_cli.optics.sensitivity import move_reference_points, reference_offsets, sensitivity_matrix
from tedm_cli.stages.common import DISTORTION, OPTICS, copy_areas, out_path, provenance
from tedm_cli.stages.layout import refuse_failures
from tedm_cli.store import create, open_checked

RESIDUAL_LIMIT = 1e-9  # rigid motions through an exact matrix leave rounding, about 1e-14


@dataclass(frozen=True)
class OpticsSummary:
    path: Path
    shape: tuple[int, int]
    rank: int
    conditions: dict[str, float]
    residuals: dict[str, float]
    largest_offset_m: float
    warnings: tuple[Finding, ...]


def build_optics(project: Project, output: Path | None) -> OpticsSummary:
    """Checks of the layout, its ray trace with the derivative, moved to the grids, then the chain for every set."""
    optics_file, layout = load_layout(project.optics)
    findings = check_layout(layout)
    refuse_failures(findings, project.optics)
    source = project.build_dir / DISTORTION
    out = out_path(project, OPTICS, output)
    with (
        open_checked(source, DISTORTION_KIND) as distortion,
        create(out, KIND, provenance([optics_file], [source])) as writer,
    ):
        names = [e.name for e in layout.bench]
        if distortion.strings("/optical/name") != names:
            raise InputError(
                "holds other optical elements than the layout",
                where=str(source),
                hint="rebuild it with `tedm build-distortion`",
            )
        position = distortion.array("/optical/position")
        motion = np.concatenate([distortion.array("/D_opt/translation"), distortion.array("/D_opt/rotation")], axis=2)
        matrix = move_reference_points(sensitivity_matrix(layout), layout, position)
        residuals = invariance_residuals(layout, matrix, position).named()
        chain = optics_chain(layout, matrix, motion)
        offsets = reference_offsets(layout, position)
        copy_areas(distortion, writer)
        inputs, outputs, laser, read_out = (
            input_labels(layout),
            output_labels(layout),
            laser_labels(layout),
            read_out_labels(layout),
        )
        writer.write("/S_BW", matrix, units="m or rad per m or rad, see /label")
        writer.write("/P", chain.P, units="m or rad per m or rad, see /label")
        writer.write("/O_ideal", chain.O_ideal, units="m or rad per m or rad, see /label")
        writer.write("/D", chain.D, units="m/K or rad/K, see /label/laser_output_unit")
        for read in chain.sets:
            writer.write(f"/N/{read.name}", read.N, units="m/K or rad/K, see /label/read_out_unit")
            parts = noise_by_element(layout, read, motion)
            writer.write(f"/N_by_element/{read.name}", parts, units="m/K or rad/K, see /label/read_out_unit")
        writer.write("/label/ray_output", outputs.names)
        writer.write("/label/ray_output_unit", outputs.units)
        writer.write("/label/element_dof", inputs.names)
        writer.write("/label/laser_output", laser.names)
        writer.write("/label/laser_output_unit", laser.units)
        writer.write("/label/test_mass_dof", input_labels(layout, layout.test_masses).names)
        writer.write("/label/read_out", read_out.names)
        writer.write("/label/read_out_unit", read_out.units)
        writer.write("/set/name", [read.name for read in chain.sets])
        writer.write("/set/condition", [read.law.condition for read in chain.sets])
        writer.write("/rank", chain.rank)
        writer.write("/singular_values", chain.singular_values)
        writer.write("/residual/name", list(residuals))
        writer.write("/residual/value", list(residuals.values()))
        writer.write("/optical/name", names)
        writer.write("/reference_point_offset", offsets)
        _judge(residuals, str(project.optics))
    return OpticsSummary(
        out,
        (matrix.shape[0], matrix.shape[1]),
        chain.rank,
        {read.name: read.law.condition for read in chain.sets},
        residuals,
        float(np.abs(offsets).max()),
        failures(findings, "warning"),
    )


def _judge(residuals: dict[str, float], where: str) -> None:
    # Photodiode columns are not judged: they are rounding only where both beams meet at the photodiode's centre.
    bad = {k: v for k, v in residuals.items() if k != "photodiode_columns" and v > RESIDUAL_LIMIT}
    if bad:
        listed = ", ".join(f"{k} {v:.2g}" for k, v in bad.items())
        raise PhysicsError(f"invariances of the optical sensitivity matrix fail: {listed}", where=where)
