"""build-adjoint: what every temperature and every material does to every output, by one factorisation."""

from __future__ import annotations

import contextlib
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from tedm_cli.adjoint.agreement import Agreement, agreement
from tedm_cli.adjoint.areas import Temperatures, gradient_sensitivity, temperatures
from tedm_cli.adjoint.density import GravitySum
from tedm_cli.adjoint.linear_fields import area_shapes
from tedm_cli.adjoint.materials import MaterialUse
from tedm_cli.adjoint.temperature_field import AreaError
from tedm_cli.arrays import FloatArray, IntArray
from tedm_cli.config.model import ModelConfig, load_model
from tedm_cli.config.optics import load_layout
from tedm_cli.config.project import Project
from tedm_cli.contracts import ADJOINT, DISTORTION, OPTICS, SENSITIVITY, UNIT_LOADS
from tedm_cli.errors import InputError, PhysicsError, TedmError
from tedm_cli.fem.adjoint import TemperatureSensitivity
from tedm_cli.fem.static import StaticReport, StaticSolution
from tedm_cli.fem.structure import Structure
from tedm_cli.files.build_folder import (
    ADJOINT_FILE,
    DISTORTION_FILE,
    OPTICS_FILE,
    SENSITIVITY_FILE,
    UNIT_LOADS_FILE,
    provenance,
    require_configuration,
    require_input,
    require_same_areas,
)
from tedm_cli.files.provenance import ConfigFile
from tedm_cli.files.store import Reader, Writer, create, open_checked
from tedm_cli.nastran.reading import deck_files, read_deck
from tedm_cli.nastran.structure.material_use import material_cards, material_use
from tedm_cli.optics.layout import OpticalLayout
from tedm_cli.progress import Step
from tedm_cli.results.adjoint import AdjointResults, read_adjoint
from tedm_cli.stages.adjoint.even_field import even_field_error, write_error
from tedm_cli.stages.adjoint.materials import MaterialChanges, gravity_of, material_changes, unit_motions
from tedm_cli.stages.adjoint.model import WarmedModel, coupled_structure, warmed_model
from tedm_cli.stages.adjoint.outputs import Outputs, accelerations, read_outs
from tedm_cli.stages.common import copy_areas, out_path


@dataclass(frozen=True, eq=False)
class Adjoint:
    """What was found of r outputs and k areas.

    of : sensitivities by the temperatures of the model. whole : by those of whole elements, [r, E], as is `whole_id`
    [E]. sums : [r, k], over the areas. cancellation : [r, k], as in adjoint.h5. use, cards, changes : of its
    materials, with card and properties by id. field : of an even temperature field, where it was found.
    """

    model: WarmedModel
    outputs: Outputs
    of: Temperatures
    whole_id: IntArray
    whole: FloatArray
    sums: FloatArray
    agreement: Agreement
    cancellation: FloatArray
    use: MaterialUse
    cards: dict[int, tuple[str, str]]
    changes: MaterialChanges
    field: AreaError | None
    static: StaticReport


@dataclass(frozen=True, eq=False)
class AdjointSummary:
    """What was made.

    results : what the file says, or why there is no adjoint. no_read_outs : why these are not among the outputs; empty
    where they are. seconds, factor_seconds, solver : of the solution.
    """

    path: Path
    results: AdjointResults | str
    no_read_outs: str
    seconds: float = 0.0
    factor_seconds: float = 0.0
    solver: str = ""


@dataclass(frozen=True)
class _Optics:
    """optics.h5, and the layout that it is of, in its file."""

    path: Path
    file: ConfigFile
    layout: OpticalLayout


def build_adjoint(
    project: Project, output: Path | None, step: Step, *, or_say_why: bool = False, area_error: bool = False
) -> AdjointSummary:
    """Solve one problem for each acceleration and read-out, and hold the sums over the areas against S_SG and N.

    Read-outs are there where optics.h5 is. With `or_say_why` a model that has no adjoint here, or whose results are not
    those of its elements here, makes a file that says so. With `area_error` the areas are held against a temperature
    field however large the model is.

    Raises
    ------
    ConfigError : the model has no test masses.
    InputError : a file that is missing or stale; cards that the embedded solver does not model.
    PhysicsError : the structure is not held; sums that are not those of the unit loads.
    """
    config_file, config = load_model(project.model)
    config.required_test_masses(project.model)
    table, build = config.model, project.build_dir
    deck = project.resolve(table.deck)
    raw = read_deck(
        deck, cross_reference=False, allow_missing_enddata=table.allow_missing_enddata, units=table.deck_units()
    )
    files = deck_files(raw, deck)
    optics, no_read_outs = _optics(project)
    configs = [config_file, *([] if optics is None else [optics.file])]
    own = [build / name for name in (UNIT_LOADS_FILE, DISTORTION_FILE, SENSITIVITY_FILE)]
    used = [*own, *([] if optics is None else [optics.path]), *files]
    trace = provenance(configs, used)
    out = out_path(project, ADJOINT_FILE, output)
    with contextlib.ExitStack() as stack:
        unit = stack.enter_context(open_checked(own[0], UNIT_LOADS))
        distortion = stack.enter_context(open_checked(own[1], DISTORTION))
        sensitivity = stack.enter_context(open_checked(own[2], SENSITIVITY))
        read_out = None if optics is None else stack.enter_context(open_checked(optics.path, OPTICS))
        require_configuration(sensitivity, project.model)
        for item in trace.inputs[:2]:
            require_input(sensitivity, item)
        for item in trace.inputs[len(used) - len(files) :]:
            require_input(unit, item)
        if optics is not None and read_out is not None:
            require_configuration(read_out, optics.file.path)
            require_input(read_out, trace.inputs[1])
        require_same_areas(sensitivity, distortion, *([] if read_out is None else [read_out]))
        gravity = accelerations(sensitivity, distortion)
        found = _found(raw, files, config, gravity, unit, read_out, optics, step, area_error=area_error)
        if isinstance(found, TedmError) and not or_say_why:
            raise found
        with create(out, ADJOINT, trace) as writer:
            copy_areas(sensitivity, writer)
            if isinstance(found, TedmError):
                writer.write(ADJOINT.REFUSAL, [found.fact])
            else:
                _write(writer, found)
    with open_checked(out, ADJOINT) as written:
        results = read_adjoint(written)
    if isinstance(found, TedmError):
        return AdjointSummary(out, results, no_read_outs)
    static = found.static
    return AdjointSummary(out, results, no_read_outs, static.solve_seconds, static.factor_seconds, static.solver)


def _optics(project: Project) -> tuple[_Optics | None, str]:
    """The read-outs there are, or why there are none."""
    path = project.build_dir / OPTICS_FILE
    if project.optics is None:
        return None, "the project has no optics"
    if not path.exists():
        return None, f"{path} is not there: `{OPTICS.made_by}` makes it"
    return _Optics(path, *load_layout(project.optics)), ""


def _found(
    raw: Any,
    files: list[Path],
    config: ModelConfig,
    outputs: Outputs,
    unit: Reader,
    read_out: Reader | None,
    optics: _Optics | None,
    step: Step,
    *,
    area_error: bool,
) -> Adjoint | InputError | PhysicsError:
    """The adjoint of a model that `ingest` has read, of `outputs` and those of optics.h5; or why there is none here."""
    deck = files[0]
    try:
        structure = coupled_structure(raw, deck)
    except InputError as exc:
        return exc
    use, cards = material_use(raw), material_cards(raw)
    model = warmed_model(raw, structure, files, config.model.uniform_label)
    if optics is not None and read_out is not None:
        outputs += read_outs(read_out, optics.layout, optics.file.path, structure.grid_id)
    try:
        solution = StaticSolution(structure, progress=step)
        by_temperature = solution.adjoint(outputs.force, outputs.label)
    except PhysicsError as exc:  # the solver knows elements and grids, and no file
        return PhysicsError(exc.fact, where=exc.where or str(deck), hint=exc.hint)
    of = temperatures(by_temperature, model.own)
    sums = of.sums(model.areas)
    agreed = agreement(sums + outputs.direct, outputs.wanted, outputs.rounding, outputs.block, model.gradient)
    wrong = _disagreement(agreed, model, outputs, deck)
    if wrong is not None:
        return wrong  # and no material changes what is not that of these elements
    changes = _changes(structure, use, by_temperature, model, config, unit, step)
    field = even_field_error(of, outputs.direct, model, step, however_many=area_error)
    return Adjoint(
        model,
        outputs,
        of,
        by_temperature.whole_id,
        by_temperature.whole,
        sums,
        agreed,
        of.cancellation(model.areas),
        use,
        cards,
        changes,
        field,
        solution.report,
    )


def _changes(
    structure: Structure,
    use: MaterialUse,
    found: TemperatureSensitivity,
    model: WarmedModel,
    config: ModelConfig,
    unit: Reader,
    step: Step,
) -> MaterialChanges:
    """By the displacements in unit_loads.h5; parts of the model that stand for test masses have no mass there."""
    settings = config.gravity
    how = GravitySum(
        test_masses=config.test_masses(),
        tolerance=settings.quadrature_tolerance,
        constant=settings.gravitational_constant_m3_kg_s2,
        lumped=settings.mass_model == "lumped",
    )
    gravity = gravity_of(model.geometry, use, unit.array(UNIT_LOADS.ELEMENT_MASS) != 0.0, how, step)
    return material_changes(structure, use, found, model.own, model.areas, gravity, unit_motions(unit))


def _disagreement(agreed: Agreement, model: WarmedModel, outputs: Outputs, deck: Path) -> PhysicsError | None:
    """What is wrong with sums that differ from the unit loads."""
    row, column = agreed.worst
    off = int((agreed.difference > agreed.allowed).sum())
    if not off:
        return None
    return PhysicsError(
        f"the adjoint's sum over area '{model.name[column]}' differs from its unit load in {outputs.label[row]} by"
        f" {agreed.difference[row, column]:.2g} of the largest of {outputs.block[row]}; allowed"
        f" {agreed.allowed[row, column]:.1e} ({off} of {agreed.difference.size} sums)",
        where=str(deck),
        hint="are the results of another solver, whose elements differ from those of `tedm solve`, or of another deck?",
    )


def _write(writer: Writer, found: Adjoint) -> None:
    model, outputs, of = found.model, found.outputs, found.of
    per_kelvin, per_area = "per K, see /row/unit", "per /area/unit, see /row/unit"
    writer.write(ADJOINT.ROW_LABEL, outputs.label)
    writer.write(ADJOINT.ROW_UNIT, outputs.unit)
    writer.write(ADJOINT.GRID_ID, model.structure.grid_id)
    writer.write(ADJOINT.GRID_VOLUME, model.places.grid_volume)
    writer.write(ADJOINT.S, of.grid, units=per_kelvin)
    writer.write(ADJOINT.ELEMENT_ID, model.element_id)
    writer.write(ADJOINT.ELEMENT_OWN, of.own.astype(np.int64))
    writer.write(ADJOINT.ELEMENT_VOLUME, model.places.element_volume)
    writer.write(ADJOINT.ELEMENT_MEAN, of.mean, units=per_kelvin)
    writer.write(ADJOINT.ELEMENT_GRADIENT, of.gradient, units="per K/m, see /row/unit")
    writer.write(ADJOINT.MAP_ELEMENT, found.whole_id)
    writer.write(ADJOINT.MAP_VOLUME, model.volume)
    writer.write(ADJOINT.MAP_S, found.whole, units=per_kelvin)
    writer.write(ADJOINT.DIRECT, outputs.direct, units=per_area)
    writer.write(ADJOINT.AREA_SUM, found.sums, units=per_area)
    writer.write(ADJOINT.AREA_CANCELLATION, found.cancellation)
    writer.write(
        ADJOINT.AREA_GRADIENT, gradient_sensitivity(of, model.areas, model.places), units="per K/m, see /row/unit"
    )
    shapes = area_shapes(model.areas, model.places)
    writer.write(ADJOINT.AREA_MIDDLE, shapes.middle)
    writer.write(ADJOINT.AREA_VOLUME, shapes.volume)
    writer.write(ADJOINT.AREA_LOW, shapes.low)
    writer.write(ADJOINT.AREA_HIGH, shapes.high)
    if found.field is not None:
        write_error(writer, found.field)
    _write_materials(writer, found, per_area)
    writer.write(ADJOINT.CHECK_BLOCK, outputs.block)
    writer.write(ADJOINT.CHECK_DIFFERENCE, found.agreement.difference)
    writer.write(ADJOINT.CHECK_ALLOWED, found.agreement.allowed)
    writer.write(ADJOINT.CHECK_RESIDUAL, found.static.max_relative_residual)


def _write_materials(writer: Writer, found: Adjoint, per_area: str) -> None:
    use, changes = found.use, found.changes
    writer.write(ADJOINT.MATERIAL_ID, use.material_id)
    writer.write(ADJOINT.MATERIAL_CARD, [found.cards[mid][0] for mid in use.material_id.tolist()])
    writer.write(ADJOINT.MATERIAL_USED_BY, [found.cards[mid][1] for mid in use.material_id.tolist()])
    writer.write(ADJOINT.MATERIAL_EXPANSION, use.expansion)
    writer.write(ADJOINT.DS_DLNE, changes.dlne, units=per_area)
    writer.write(ADJOINT.DS_DLNALPHA, changes.dlnalpha, units=per_area)
    writer.write(ADJOINT.DS_DALPHA, changes.dalpha, units=f"per 1/K and {per_area}")
    writer.write(ADJOINT.DS_DLNRHO, changes.dlnrho, units=per_area)
    writer.write(ADJOINT.SHELL_PROPERTY_ID, use.shell_property_id)
    writer.write(ADJOINT.DS_DLNT, changes.dlnt, units=per_area)
