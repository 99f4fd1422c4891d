"""ingest: a unit-load deck and its results to unit_loads.h5."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from tedm_cli.areas.mean_step import MeanStep
from tedm_cli.arrays import FloatArray
from tedm_cli.config.model.file import load_model
from tedm_cli.config.project import Project
from tedm_cli.config.symmetry_plane import ProjectPlane
from tedm_cli.contracts import UNIT_LOADS
from tedm_cli.deck_units import DeckUnits
from tedm_cli.distortion import Precision
from tedm_cli.files.blocks import PrecisionLossError
from tedm_cli.files.build_folder import UNIT_LOADS_FILE
from tedm_cli.files.provenance import input_files, relative_name
from tedm_cli.files.store import Writer, create
from tedm_cli.gravity.mass_properties import MassProperties
from tedm_cli.nastran.displacements import Findings
from tedm_cli.nastran.geometry import ModelGeometry
from tedm_cli.nastran.loads.unit_loads import UnitLoad, UnitLoads
from tedm_cli.nastran.result_files import require_whole
from tedm_cli.progress import Step
from tedm_cli.results.areas import write_areas
from tedm_cli.results.gravity.ties import Ties
from tedm_cli.stages.common import out_path, refuse_own_place
from tedm_cli.stages.model.read import MassSummary, ModelRead, read_model


@dataclass(frozen=True)
class IngestSummary:
    """What was read, of a deck in which `units`.

    gradients : number of the areas that are under a gradient. mean_step : of the areas' own elements, by area.
    coarsest : the unit load whose step suffers most where a solver has temperatures of 4 bytes. precision : of the
    displacements.
    """

    path: Path
    grids: int
    elements: int
    areas: int
    gradients: int
    plane: ProjectPlane
    masses: MassSummary
    has_uniform: bool
    partial: list[int]
    notes: list[str]
    mean_step: list[MeanStep]
    coarsest: UnitLoad
    units: DeckUnits
    precision: Precision


def ingest(project: Project, output: Path | None, step: Step) -> IngestSummary:
    """Read geometry, masses, areas and displacements, check them, and write them in SI and the basic frame."""
    results = own_results(project)
    for path in results:
        require_whole(path)
    read = read_model(project, results)
    loads, geometry = read.loads, read.geometry
    out = out_path(project, UNIT_LOADS_FILE, output)
    trace, findings = replace(read.trace, inputs=(*read.trace.inputs, *input_files(results))), Findings()

    def write(single: bool) -> None:
        with create(out, UNIT_LOADS, trace) as writer:
            write_model(writer, read, out)
            motions = read.displacements.motions(results, findings)
            write_motions(writer, motions, loads, len(geometry.grid_id), single, step)
            writer.write(UNIT_LOADS.RESULTS_PRECISION, _precision(findings))

    try:
        write(single=True)
    except PrecisionLossError:  # results in double precision, or grids in other frames: known from the first subcase on
        write(single=False)
    by_number = [f"{p} has no labels: its subcases are taken by the deck's numbers" for p in findings.by_number]
    return IngestSummary(
        out,
        len(geometry.grid_id),
        len(geometry.elements.id),
        len(loads.areas),
        len(loads.areas) - len(loads.means),
        read.plane,
        read.masses,
        loads.uniform is not None,
        geometry.elements.partial,
        read.notes + by_number,
        read.steps,
        max(read.wanted, key=lambda load: load.single_error),
        read.units,
        _precision(findings),
    )


def own_results(project: Project) -> list[Path]:
    """The result files that the configuration names; `ConfigError` where one is in the place of unit_loads.h5."""
    _, config = load_model(project.model)
    results = [project.resolve(p) for p in config.model.op2]
    refuse_own_place(project, results)
    return results


def _precision(findings: Findings) -> Precision:
    """Of all displacements: the coarser one where they differ."""
    return "single" if findings.single else "double"


def write_motions(
    writer: Writer,
    motions: Iterable[tuple[UnitLoad, FloatArray, FloatArray]],
    loads: UnitLoads,
    n_nodes: int,
    single: bool,
    step: Step,
) -> None:
    """Write the displacements of one subcase after the other, in whatever order the results hold them."""
    shape = (len(loads.areas), n_nodes, 3)
    translation = writer.allocate(UNIT_LOADS.TRANSLATION, shape, single=single)
    rotation = writer.allocate(UNIT_LOADS.ROTATION, shape, single=single)
    number = {a.label: i for i, a in enumerate(loads.areas)}
    count = len(loads.areas) + (loads.uniform is not None)
    for done, (load, t, r) in enumerate(motions, start=1):
        if load is loads.uniform:
            writer.write(UNIT_LOADS.UNIFORM_TRANSLATION, t, single=single)
            writer.write(UNIT_LOADS.UNIFORM_ROTATION, r, single=single)
            writer.write(UNIT_LOADS.UNIFORM_LOAD_K, load.load_K)
        else:
            translation[number[load.label]], rotation[number[load.label]] = t, r
        step(done, count, "reading displacements")


def write_model(writer: Writer, read: ModelRead, out: Path) -> None:
    """All of unit_loads.h5 but what is from the results; `out`: where it will be."""
    _write_geometry(writer, read.geometry)
    _write_masses(writer, read.geometry, read.masses.properties)
    _write_ties(writer, read.ties)
    _write_loads(writer, read)
    write_areas(writer, read.table, np.array([a.subcase for a in read.loads.areas]))
    _write_plane(writer, read.plane, out)


def _write_geometry(writer: Writer, geometry: ModelGeometry) -> None:
    e = geometry.elements
    writer.write(UNIT_LOADS.GRID_ID, geometry.grid_id)
    writer.write(UNIT_LOADS.GRID_POSITION, geometry.position_m)
    writer.write(UNIT_LOADS.ELEMENT_ID, e.id)
    writer.write(UNIT_LOADS.ELEMENT_TYPE, e.type)
    writer.write(UNIT_LOADS.ELEMENT_PROPERTY_ID, e.property_id)
    writer.write(UNIT_LOADS.ELEMENT_NODE_OFFSET, e.node_offset)
    writer.write(UNIT_LOADS.ELEMENT_NODE_INDEX, e.node_index)
    writer.write(UNIT_LOADS.ELEMENT_LEVER, e.lever)
    writer.write(UNIT_LOADS.ELEMENT_WEIGHT, e.weight)
    writer.write(UNIT_LOADS.ELEMENT_MASS, e.mass_kg)
    writer.write(UNIT_LOADS.ELEMENT_DENSITY, e.density)
    writer.write(UNIT_LOADS.ELEMENT_EXPANSION, e.expansion)
    writer.write(UNIT_LOADS.ELEMENT_SECTION, e.section)


def _write_masses(writer: Writer, geometry: ModelGeometry, properties: MassProperties) -> None:
    writer.write(UNIT_LOADS.MASS_LUMPED, geometry.lumped_kg)
    writer.write(UNIT_LOADS.MASS_CONCENTRATED_CARD, geometry.concentrated.card)
    writer.write(UNIT_LOADS.MASS_CONCENTRATED_ID, geometry.concentrated.id)
    writer.write(UNIT_LOADS.MASS_CONCENTRATED, geometry.concentrated.kg)
    writer.write(UNIT_LOADS.MASS_CONCENTRATED_NODE, geometry.concentrated.node)
    writer.write(UNIT_LOADS.MASS_CONCENTRATED_LEVER, geometry.concentrated.lever)
    writer.write(UNIT_LOADS.MASS_TOTAL, properties.mass_kg)
    writer.write(UNIT_LOADS.MASS_CENTRE_OF_GRAVITY, properties.centre_m)
    writer.write(UNIT_LOADS.MASS_INERTIA, properties.inertia_kg_m2)


def _write_ties(writer: Writer, ties: Ties) -> None:
    writer.write(UNIT_LOADS.TIE_BLOCK, ties.block)
    writer.write(UNIT_LOADS.TIE_TO, ties.to)
    writer.write(UNIT_LOADS.TIE_NODE_OFFSET, ties.offset)
    writer.write(UNIT_LOADS.TIE_NODE_INDEX, ties.index)


def _write_loads(writer: Writer, read: ModelRead) -> None:
    areas, members = read.loads.areas, read.members
    writer.write(UNIT_LOADS.AREA_LOAD_K, [a.load_K for a in areas])
    writer.write(UNIT_LOADS.AREA_MASS, read.area_kg)
    writer.write(UNIT_LOADS.AREA_CENTROID, read.centroids)
    writer.write(UNIT_LOADS.AREA_NODE_OFFSET, np.cumsum([0, *(len(rows) for rows in members)]))
    writer.write(UNIT_LOADS.AREA_NODE_INDEX, np.concatenate(members))
    writer.write(UNIT_LOADS.AREA_ELEMENT_OFFSET, np.cumsum([0, *(len(a.elements.loaded) for a in areas)]))
    writer.write(UNIT_LOADS.AREA_ELEMENT_INDEX, np.concatenate([a.elements.loaded for a in areas]))
    writer.write(UNIT_LOADS.AREA_MEAN_STEP, [step.share for step in read.steps])


def _write_plane(writer: Writer, used: ProjectPlane, out: Path) -> None:
    writer.write(UNIT_LOADS.PLANE_POINT, used.plane.point_m)
    writer.write(UNIT_LOADS.PLANE_NORMAL, used.plane.normal)
    writer.write(UNIT_LOADS.PLANE_ORIGIN, used.origin)
    writer.write(UNIT_LOADS.PLANE_LAYOUT, "" if used.layout is None else relative_name(used.layout, out.parent))
