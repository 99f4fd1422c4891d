"""build-optics: layout and motion of the optical elements to S_BW, P, O_ideal, D and the noise matrices N."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tedm_cli.config.model.file import load_model
from tedm_cli.config.optics.layout import load_optics
from tedm_cli.config.project import Project
from tedm_cli.contracts import DISTORTION, OPTICS
from tedm_cli.errors import InputError
from tedm_cli.files.build_folder import DISTORTION_FILE, OPTICS_FILE, provenance
from tedm_cli.files.store import Writer, create, open_checked
from tedm_cli.optics.benches import benches
from tedm_cli.optics.chain import optics_chain
from tedm_cli.optics.expansion import face_motion
from tedm_cli.optics.labels import input_labels, laser_labels, output_labels, read_out_labels
from tedm_cli.optics.layout_checks import Finding, check_layout, failures
from tedm_cli.optics.matrix_checks import BlockDifference, Judged
from tedm_cli.optics.plates import INDEX, THICKNESS, PlateEffect, plate_effect
from tedm_cli.optics.sensitivity import reference_offsets
from tedm_cli.results.areas import read_areas
from tedm_cli.results.optics import read_bench_motion
from tedm_cli.results.sides import require_plane
from tedm_cli.stages.common import copy_areas, copy_places, out_path
from tedm_cli.stages.layout_match import match_layout
from tedm_cli.stages.optics.layout import refuse_failures
from tedm_cli.stages.optics.matrices import optical_matrices


@dataclass(frozen=True)
class OpticsSummary:
    path: Path
    shape: tuple[int, int]
    rank: int
    conditions: dict[str, float]
    judged: tuple[Judged, ...]
    origins: tuple[str, str]  # of S_BW and of P
    differences: tuple[BlockDifference, ...]  # of an imported S_BW from the traced one, largest first
    largest_offset_m: float
    benches: dict[str, list[str]]  # elements of each
    warnings: tuple[Finding, ...]
    notes: tuple[str, ...]


def build_optics(project: Project, output: Path | None) -> OpticsSummary:
    """Checks of the layout, S_BW traced or imported and judged, then the chain for every set.

    Raises
    ------
    ConfigError : the project has no optics.
    """
    path = project.required_optics()
    config = load_optics(path)
    layout = config.layout
    findings = check_layout(layout) if layout.has_geometry else ()
    refuse_failures(findings, path)
    _, model = load_model(project.model)
    source = project.build_dir / DISTORTION_FILE
    out = out_path(project, OPTICS_FILE, output)
    with (
        open_checked(source, DISTORTION) as distortion,
        create(out, OPTICS, provenance([config.file], [source, *config.matrices])) as writer,
    ):
        names = [e.name for e in layout.bench]
        bench = read_bench_motion(distortion)
        if bench.element != names:
            raise InputError(
                "holds other optical elements than the layout",
                where=str(source),
                hint="rebuild it with `tedm build-distortion`, or `tedm run`",
            )
        position = bench.position_m
        match = match_layout(layout, path, model, project.model, position)
        match.require()
        require_plane(distortion, project, model)
        matrices = optical_matrices(config, position)
        matrix, judged = matrices.S_BW, matrices.judged
        areas = read_areas(distortion)
        by_area = areas.name.tolist(), areas.name[areas.gradient].tolist()
        try:
            face, plates = face_motion(layout, *by_area), plate_effect(layout, *by_area, bench.areas)
        except InputError as exc:
            raise InputError(exc.fact, where=f"{path}: {exc.where}", hint=exc.hint) from exc
        chain = optics_chain(layout, matrix, bench.motion, position, face, matrices.P, plates)
        offsets = reference_offsets(layout, position)
        copy_areas(distortion, writer)
        copy_places(distortion, writer)
        inputs, outputs, laser, read_out = (
            input_labels(layout),
            output_labels(layout),
            laser_labels(layout),
            read_out_labels(layout),
        )
        writer.write(OPTICS.S_BW, matrix, units="m or rad per m or rad, see /label")
        writer.write(OPTICS.P, chain.P, units="m or rad per m or rad, see /label")
        writer.write(OPTICS.O_IDEAL, chain.O_ideal, units="m or rad per m or rad, see /label")
        writer.write(OPTICS.D, chain.D, units="m/K or rad/K, see /label/laser_output_unit")
        writer.write(OPTICS.MOTION, chain.motion, units="m/K or rad/K, see /label/element_dof")
        writer.write(OPTICS.RIGID_MOTION, chain.rigid.motion, units="m/K or rad/K, see /label/element_dof")
        writer.write(OPTICS.COMMON_MODE_MOTION, chain.rigid.amplitude, units="m/K (three), rad/K (three)")
        writer.write(OPTICS.COMMON_MODE_ABOUT, chain.rigid.about.reshape(-1))
        writer.write(OPTICS.BENCH_NAME, list(chain.rigid.benches))
        per_kelvin = "m/K or rad/K, see /label/read_out_unit"
        for read in chain.sets:
            writer.write(OPTICS.N.of(read.name), read.N, units=per_kelvin)
            writer.write(OPTICS.N_RIGID.of(read.name), read.N_rigid, units=per_kelvin)
            writer.write(OPTICS.N_DISTORTION.of(read.name), read.N_distortion, units=per_kelvin)
            if plates is not None:
                writer.write(OPTICS.N_PLATES.of(read.name), read.N_plates, units=per_kelvin)
            writer.write(OPTICS.INVERSE.of(read.name), read.inverse, units="m or rad per m or rad, see /label")
            writer.write(OPTICS.GAIN.of(read.name), read.gain, units="m or rad per m or rad, see /label")
        if plates is not None:
            _write_plates(writer, plates)
        writer.write(OPTICS.LABEL_RAY_OUTPUT, outputs.names)
        writer.write(OPTICS.LABEL_RAY_OUTPUT_UNIT, outputs.units)
        writer.write(OPTICS.LABEL_ELEMENT_DOF, inputs.names)
        writer.write(OPTICS.LABEL_LASER_OUTPUT, laser.names)
        writer.write(OPTICS.LABEL_LASER_OUTPUT_UNIT, laser.units)
        writer.write(OPTICS.LABEL_TEST_MASS_DOF, input_labels(layout, layout.test_masses).names)
        writer.write(OPTICS.LABEL_READ_OUT, read_out.names)
        writer.write(OPTICS.LABEL_READ_OUT_UNIT, read_out.units)
        writer.write(OPTICS.SET_NAME, [read.name for read in chain.sets])
        writer.write(OPTICS.SET_CONDITION, [read.law.condition for read in chain.sets])
        writer.write(OPTICS.RANK, chain.rank)
        writer.write(OPTICS.SINGULAR_VALUES, chain.singular_values)
        writer.write(OPTICS.RESIDUAL_NAME, [j.name for j in judged])
        writer.write(OPTICS.RESIDUAL_VALUE, [j.value for j in judged])
        writer.write(OPTICS.RESIDUAL_LIMIT, [j.limit for j in judged])
        writer.write(OPTICS.ORIGIN_S_BW, matrices.origins[0])
        writer.write(OPTICS.ORIGIN_P, matrices.origins[1])
        members = {name: [e.name for e in elements] for name, elements in benches(layout).items()}
        on = {element: name for name, elements in members.items() for element in elements}
        writer.write(OPTICS.ELEMENT_NAME, [e.name for e in layout.elements])
        writer.write(OPTICS.ELEMENT_BENCH, [on.get(e.name, "") for e in layout.elements])
        writer.write(OPTICS.TEST_MASS_NAME, [e.name for e in layout.test_masses])
        writer.write(OPTICS.TEST_MASS_AXES, layout.test_mass_axes)
        writer.write(OPTICS.ELEMENT_PIVOT, layout.pivots_m(position))
        writer.write(OPTICS.OPTICAL_NAME, names)
        writer.write(OPTICS.REFERENCE_POINT_OFFSET, offsets)
        warnings = failures(findings, "warning")
        odd = [f.line for f in warnings] + match.remarks
        if odd:
            writer.write(OPTICS.NOTE, [f"{path.name}: {line}" for line in odd])
    return OpticsSummary(
        out,
        (matrix.shape[0], matrix.shape[1]),
        chain.rank,
        {read.name: read.law.condition for read in chain.sets},
        judged,
        matrices.origins,
        matrices.differences,
        float(np.linalg.norm(offsets, axis=1).max()),
        members,
        warnings,
        tuple(match.notes),
    )


def _write_plates(writer: Writer, plates: PlateEffect) -> None:
    per = "m or rad per {}, see /label/ray_output_unit"
    writer.write(OPTICS.PLATE_NAME, [plate.name for plate in plates.plates])
    writer.write(OPTICS.PLATE_BY_INDEX, plates.sensitivity[:, :, INDEX], units=per.format("unit of the index"))
    writer.write(OPTICS.PLATE_BY_THICKNESS, plates.sensitivity[:, :, THICKNESS], units=per.format("m"))
    writer.write(OPTICS.PLATE_INDEX_CHANGE, plates.change[:, INDEX])
    writer.write(OPTICS.PLATE_THICKNESS_CHANGE, plates.change[:, THICKNESS])
