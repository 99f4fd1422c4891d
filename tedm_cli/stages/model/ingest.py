"""ingest: a unit-load deck and its results to unit_loads.h5."""

from __future__ import annotations

import difflib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from tedm_cli.areas.attributes import area_attributes
from tedm_cli.areas.configured import area_csv, configured_areas, defines_areas, require_agreement
from tedm_cli.areas.materials import judge_materials
from tedm_cli.areas.mean_step import MeanStep, mean_steps
from tedm_cli.areas.places import area_centroids, area_masses, area_points
from tedm_cli.arrays import FloatArray, IntArray
from tedm_cli.config.model.compensation import compensation_masses
from tedm_cli.config.model.file import ModelConfig, load_model
from tedm_cli.config.model.superelement import superelement_files
from tedm_cli.config.project import Project
from tedm_cli.config.symmetry_plane import ProjectPlane, project_plane
from tedm_cli.contracts import UNIT_LOADS
from tedm_cli.deck_units import DeckUnits
from tedm_cli.distortion import Precision
from tedm_cli.errors import ConfigError, PhysicsError
from tedm_cli.files.blocks import PrecisionLossError
from tedm_cli.files.build_folder import UNIT_LOADS_FILE, provenance
from tedm_cli.files.provenance import relative_name
from tedm_cli.files.store import Writer, create
from tedm_cli.gravity.mass_properties import MassProperties
from tedm_cli.nastran.displacements import Findings, unit_load_displacements
from tedm_cli.nastran.geometry import ModelGeometry, model_geometry
from tedm_cli.nastran.loads.unit_loads import UnitLoad, UnitLoads, deck_unit_loads
from tedm_cli.nastran.masses.audit import SampleCheck, check_sample
from tedm_cli.nastran.parameter_values import number_parameter
from tedm_cli.nastran.plausible import is_mass_tensor, light_elements
from tedm_cli.nastran.reading import deck_files, passed_over, read_deck
from tedm_cli.nastran.result_files import require_whole
from tedm_cli.nastran.rigid import check_rigidity, rigid_links
from tedm_cli.progress import Step
from tedm_cli.results.areas import write_areas
from tedm_cli.results.gravity.ties import Ties
from tedm_cli.stages.common import check_test_masses, out_path, refuse_own_place
from tedm_cli.stages.model.masses import check_grids_outside, check_weight_tables, properties_of, without_test_masses
from tedm_cli.stages.model.superelements import AreasElsewhere, Recovery, reduced_on, require_own_areas
from tedm_cli.stages.model.ties import ties_on


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


@dataclass(frozen=True)
class MassSummary:
    """Mass properties of the structure, what they were checked against, and the test masses' own parts of the model.

    weight_tables : files whose grid point weight table agrees; test_mass_kg : by test mass with parts in the model.
    """

    properties: MassProperties
    sample: SampleCheck
    weight_tables: list[Path]
    test_mass_kg: dict[str, float]


def ingest(project: Project, output: Path | None, step: Step) -> IngestSummary:
    """Read geometry, masses, areas and displacements, check them, and write them in SI and the basic frame."""
    config_file, config = load_model(project.model)
    plane = project_plane(project, config)
    deck = project.resolve(config.model.deck)
    results = [project.resolve(p) for p in config.model.op2]
    refuse_own_place(project, results)
    for path in results:
        require_whole(path)
    units = config.model.deck_units()
    model = read_deck(deck, allow_missing_enddata=config.model.allow_missing_enddata, units=units)
    files = deck_files(model, deck)
    listed = area_csv(project, config)
    given = superelement_files(project, config.superelement)
    trace = provenance([config_file], [*files, *([listed] if listed else []), *given, *results])
    geometry, masses, whole = _masses(model, files, results, config, project.model)
    ties, tie_notes = ties_on(compensation_masses(project, config), config, model, whole)
    check_test_masses(config.test_masses(), geometry.position_m[geometry.lumped_kg > 0], where=str(project.model))
    check_grids_outside(config.test_masses(), geometry)
    reduced = reduced_on(project, config, geometry)
    recoveries = [Recovery.of(one, geometry) for one in reduced]
    elsewhere = AreasElsewhere.of([one.given for one in reduced])
    loads = deck_unit_loads(model, geometry, config.model.uniform_label, elsewhere.own if reduced else None)
    areas = loads.areas
    on = {a.label: a.area_load(geometry) for a in areas}
    elsewhere.require(on, str(deck))
    selected: dict[str, IntArray] = {}
    if defines_areas(config):
        defined = configured_areas(project, config, model, geometry)
        there = {name: load for name, load in on.items() if name.upper() not in elsewhere.own}
        require_own_areas(reduced, there, str(deck))
        require_agreement(defined, there, geometry, where=str(deck))
        labels = {a.label.upper(): a.label for a in areas}
        selected = {labels[name.upper()]: ids for name, ids in defined.selected.items()}
    wanted = [*areas, *([loads.uniform] if loads.uniform else [])]
    _check_subcase_table(config.model.subcases, [load.label for load in wanted], where=str(project.model))
    centroids = elsewhere.placed(on, area_centroids(geometry, on.values()))
    kinds = {a.label: a.kind for a in areas}
    table = area_attributes(kinds, centroids, config.areas, plane.plane, where=str(project.model))
    steps = mean_steps(geometry, on, selected)
    out = out_path(project, UNIT_LOADS_FILE, output)
    links, findings = rigid_links(model, geometry), Findings()

    def motions() -> Iterator[tuple[UnitLoad, FloatArray, FloatArray]]:
        for load, t, r in unit_load_displacements(
            results, wanted, geometry, config.model.subcases, model.spoints, findings
        ):
            labels = [a.label for a in loads.means] if load is loads.uniform else [load.label]
            for recovery in recoveries:
                recovery.put_into(labels, load.load_K, t, r, single=findings.single)
            check_rigidity(links, geometry.grid_id, t, r, where=f"{deck}: subcase {load.subcase} (area '{load.label}')")
            yield load, t, r

    def write(single: bool) -> None:
        with create(out, UNIT_LOADS, trace) as writer:
            _write_geometry(writer, geometry)
            _write_masses(writer, geometry, masses.properties)
            _write_ties(writer, ties)
            masses_of = elsewhere.weighed(on, area_masses(geometry, on.values()))
            _write_loads(writer, areas, elsewhere.members(areas, geometry.grid_id), centroids, masses_of, steps)
            write_areas(writer, table, np.array([a.subcase for a in areas]))
            _write_plane(writer, plane, out)
            write_motions(writer, motions(), loads, len(geometry.grid_id), single, step)
            writer.write(UNIT_LOADS.RESULTS_PRECISION, _precision(findings))

    try:
        write(single=True)
    except PrecisionLossError:  # results in double precision, or grids in other frames: known from the first subcase on
        write(single=False)
    return IngestSummary(
        out,
        len(geometry.grid_id),
        len(geometry.elements.id),
        len(areas),
        len(areas) - len(loads.means),
        plane,
        masses,
        loads.uniform is not None,
        geometry.elements.partial,
        config.model.unit_notes()
        + _scale_notes(wanted, units)
        + plane.notes(area_points(geometry, on.values()))
        + [f"{p} has no labels: its subcases are taken by the deck's numbers" for p in findings.by_number]
        + passed_over(model)
        + light_elements(geometry.elements)
        + judge_materials(model, geometry, on).lines
        + tie_notes,
        steps,
        max(wanted, key=lambda load: load.single_error),
        units,
        _precision(findings),
    )


def _precision(findings: Findings) -> Precision:
    """Of all displacements: the coarser one where they differ."""
    return "single" if findings.single else "double"


def _scale_notes(loads: Sequence[UnitLoad], units: DeckUnits) -> list[str]:
    """A remark on steps that would be of 1 K in another scale: expansions may be per degree of it too."""
    steps = np.array([load.load_K for load in loads])
    per_kelvin = float(units.degrees_per_kelvin)
    if per_kelvin != 1.0 and np.allclose(per_kelvin * steps, 1.0, rtol=1e-9):
        return [
            f"every step is 1 {units.temperature} ({steps[0]:.3g} K): are the temperatures of the deck in kelvin? then"
            ' set temperature = "K"'
        ]
    if per_kelvin == 1.0 and np.allclose(steps, 1.8, rtol=1e-9):
        return [
            'every step is 1.8 K: are the temperatures of the deck in degrees Fahrenheit? then set temperature = "degF"'
        ]
    return []


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


def _masses(
    model: Any, files: list[Path], results: list[Path], config: ModelConfig, where: Path
) -> tuple[ModelGeometry, MassSummary, ModelGeometry]:
    """Geometry and masses, checked against pyNastran and the solver, and then without the test masses' own parts; with
    them too."""
    whole = model_geometry(model, files)
    sample = check_sample(model, whole)
    wtmass = number_parameter(model, "WTMASS", 1.0, str(files[0]))
    tables = check_weight_tables(results, whole, wtmass)
    geometry, removed = without_test_masses(whole, config, where)
    properties = properties_of(geometry)
    if not is_mass_tensor(properties.inertia_kg_m2):
        values = ", ".join(f"{v:.4g}" for v in np.linalg.eigvalsh(properties.inertia_kg_m2))
        raise PhysicsError(
            f"no body can have its moments of inertia: {values} kg m2 about the principal axes",
            where=str(files[0]),
            hint="are concentrated or non-structural masses negative?",
        )
    names = [t.name for t in config.test_mass]
    parts = {name: kg for name, kg in zip(names, removed.tolist(), strict=True) if kg}
    return geometry, MassSummary(properties, sample, [t.file for t in tables], parts), whole


def _check_subcase_table(table: Mapping[str, int], labels: Sequence[str], *, where: str) -> None:
    """The explicit map of areas to subcases: every name is a unit load of the deck, every number is used once."""
    known = {label.upper() for label in labels}
    first: dict[int, str] = {}
    problems = []
    for area, number in table.items():
        path = f"model.subcases.{area}"
        if area.upper() not in known:
            near = difflib.get_close_matches(area.upper(), known, n=1)
            problems.append((path, "the deck has no such unit load" + (f"; did you mean {near[0]}?" if near else "")))
        if first.setdefault(number, path) != path:
            problems.append((path, f"subcase {number} is that of {first[number]} already"))
    if problems:
        raise ConfigError(problems, where=where)


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


def _write_loads(
    writer: Writer,
    areas: Sequence[UnitLoad],
    members: Sequence[IntArray],
    centroids: FloatArray,
    masses: FloatArray,
    steps: Sequence[MeanStep],
) -> None:
    writer.write(UNIT_LOADS.AREA_LOAD_K, [a.load_K for a in areas])
    writer.write(UNIT_LOADS.AREA_MASS, masses)
    writer.write(UNIT_LOADS.AREA_CENTROID, centroids)
    writer.write(UNIT_LOADS.AREA_NODE_OFFSET, np.cumsum([0, *(len(rows) for rows in members)]))
    writer.write(UNIT_LOADS.AREA_NODE_INDEX, np.concatenate(members))
    writer.write(UNIT_LOADS.AREA_ELEMENT_OFFSET, np.cumsum([0, *(len(a.elements.loaded) for a in areas)]))
    writer.write(UNIT_LOADS.AREA_ELEMENT_INDEX, np.concatenate([a.elements.loaded for a in areas]))
    writer.write(UNIT_LOADS.AREA_MEAN_STEP, [step.share for step in steps])


def _write_plane(writer: Writer, used: ProjectPlane, out: Path) -> None:
    writer.write(UNIT_LOADS.PLANE_POINT, used.plane.point_m)
    writer.write(UNIT_LOADS.PLANE_NORMAL, used.plane.normal)
    writer.write(UNIT_LOADS.PLANE_ORIGIN, used.origin)
    writer.write(UNIT_LOADS.PLANE_LAYOUT, "" if used.layout is None else relative_name(used.layout, out.parent))
