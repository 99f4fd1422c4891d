"""build-adjoint: what every temperature and every material does to every output, by one factorisation."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tedm_cli.adjoint.agreement import Agreement, agreement
from tedm_cli.adjoint.areas import Temperatures, gradient_sensitivity, temperatures
from tedm_cli.adjoint.density import GravitySum
from tedm_cli.adjoint.linear_fields import area_shapes
from tedm_cli.adjoint.materials import MaterialUse
from tedm_cli.adjoint.temperature_field import AreaError
from tedm_cli.arrays import FloatArray
from tedm_cli.config.model.file import ModelConfig
from tedm_cli.config.project import Project
from tedm_cli.contracts import ADJOINT, UNIT_LOADS
from tedm_cli.errors import InputError, PhysicsError, TedmError
from tedm_cli.fem.adjoint import TemperatureSensitivity
from tedm_cli.fem.structure import Structure
from tedm_cli.files.build_folder import ADJOINT_FILE
from tedm_cli.files.store import Reader, Writer, create, open_checked
from tedm_cli.nastran.structure.material_use import material_cards, material_use
from tedm_cli.progress import Step
from tedm_cli.results.adjoint.file import AdjointResults, read_adjoint
from tedm_cli.stages.adjoint.even_field import even_field_error, write_error
from tedm_cli.stages.adjoint.materials import MaterialChanges, gravity_of, material_changes, unit_motions
from tedm_cli.stages.adjoint.model import WarmedModel, coupled_structure, warmed_model
from tedm_cli.stages.adjoint.solved import Solved, adjoint_results, solved_elsewhere, solved_here
from tedm_cli.stages.common import copy_areas, out_path
from tedm_cli.stages.output_inputs import OutputInputs, output_inputs
from tedm_cli.stages.outputs import Outputs

_HINT = "are the results of another solver, whose elements differ from those of `tedm solve`, or of another deck?"
_HINT_ELSEWHERE = (
    "was the adjoint deck written before the unit-load deck or the matrices changed? were both decks solved by one"
    " solver? do its elements differ from those of `tedm solve`?"
)


@dataclass(frozen=True, eq=False)
class Adjoint:
    """What was found of r outputs and k areas.

    of : sensitivities by the temperatures of the model. sums : [r, k], over the areas. cancellation : [r, k], as in
    adjoint.h5. use, cards, changes : of its materials, with card and properties by id. field : of an even temperature
    field, where it was found.
    """

    model: WarmedModel
    outputs: Outputs
    of: Temperatures
    solved: Solved
    sums: FloatArray
    agreement: Agreement
    cancellation: FloatArray
    use: MaterialUse
    cards: dict[int, tuple[str, str]]
    changes: MaterialChanges
    field: AreaError | None


@dataclass(frozen=True, eq=False)
class AdjointSummary:
    """What was made.

    results : what the file says, or why there is no adjoint. no_read_outs : why these are not among the outputs; empty
    where they are. solved : the solutions, where there are some.
    """

    path: Path
    results: AdjointResults | str
    no_read_outs: str
    solved: Solved | None


def build_adjoint(
    project: Project,
    output: Path | None,
    step: Step,
    *,
    or_say_why: bool = False,
    results: Sequence[Path] = (),
    area_error: bool = False,
) -> AdjointSummary:
    """Solve one problem for each acceleration and read-out, and hold the sums over the areas against S_SG and N.

    Read-outs are there where optics.h5 is. With `or_say_why` a model that has no adjoint here, or whose results are not
    those of its elements here, makes a file that says so. With `area_error` the areas are held against a temperature
    field however large the model is.

    Parameters
    ----------
    results : of the deck of `write-deck --adjoint`, solved elsewhere; where none are given, those that the
        configuration names, and where it names none, the embedded solver solves.

    Raises
    ------
    ConfigError : the model has no test masses.
    InputError : a file that is missing or stale; cards that the embedded solver does not model; results of other
        outputs or of another model.
    PhysicsError : the structure is not held; sums that are not those of the unit loads.
    """
    out = out_path(project, ADJOINT_FILE, output)
    files = adjoint_results(project, results, out)
    with output_inputs(project, "the adjoint", files) as given:
        found = _found(given, files, step, area_error=area_error)
        if isinstance(found, TedmError) and not or_say_why:
            raise found
        with create(out, ADJOINT, given.trace) as writer:
            copy_areas(given.sensitivity, writer)
            if isinstance(found, TedmError):
                writer.write(ADJOINT.REFUSAL, [found.fact])
            else:
                _write(writer, found)
    with open_checked(out, ADJOINT) as written:
        results_there = read_adjoint(written)
    of = None if isinstance(found, TedmError) else found.solved
    return AdjointSummary(out, results_there, given.no_read_outs, of)


def _found(
    given: OutputInputs, results: Sequence[Path], step: Step, *, area_error: bool
) -> Adjoint | InputError | PhysicsError:
    """The adjoint of a model that `ingest` has read; or why there is none here."""
    if not given.unit.has(UNIT_LOADS.TRANSLATION):
        absent = given.unit.absent(UNIT_LOADS.TRANSLATION)
        return InputError(f"{given.unit.path.name} {absent.fact}", where=str(given.unit.path), hint=absent.hint)
    try:
        structure = coupled_structure(given.raw, given.deck, superelements=bool(given.config.superelement))
    except InputError as exc:
        return exc
    use, cards = material_use(given.raw), material_cards(given.raw)
    model = warmed_model(given.raw, structure, given.files, given.config.model.uniform_label)
    outputs = given.outputs(structure.grid_id)
    try:
        solved = (
            solved_elsewhere(results, outputs, model, given, step) if results else solved_here(outputs, model, step)
        )
    except PhysicsError as exc:  # the solver knows elements and grids, and no file
        return PhysicsError(exc.fact, where=exc.where or str(given.deck), hint=exc.hint)
    of = temperatures(solved.sensitivity, model.own)
    sums = of.sums(model.areas)
    rounding = outputs.rounding + solved.rounding
    agreed = agreement(sums + outputs.direct, outputs.wanted, rounding, outputs.block, model.gradient)
    wrong = _disagreement(agreed, model, outputs, given.deck, results)
    if wrong is not None:
        return wrong  # and no material changes what is not that of these elements
    changes = _changes(structure, use, solved.sensitivity, model, given.config, given.unit, step)
    field = even_field_error(of, outputs.direct, model, step, however_many=area_error)
    return Adjoint(
        model,
        outputs,
        of,
        solved,
        sums,
        agreed,
        of.cancellation(model.areas),
        use,
        cards,
        changes,
        field,
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


def _disagreement(
    agreed: Agreement, model: WarmedModel, outputs: Outputs, deck: Path, results: Sequence[Path]
) -> PhysicsError | None:
    """What is wrong with sums that differ from the unit loads."""
    row, column = agreed.worst
    off = int((agreed.difference > agreed.allowed).sum())
    if not off:
        return None
    return PhysicsError(
        f"the adjoint's sum over area '{model.name[column]}' differs from its unit load in {outputs.label[row]} by"
        f" {agreed.difference[row, column]:.2g} of the largest of {outputs.block[row]}; allowed"
        f" {agreed.allowed[row, column]:.1e} ({off} of {agreed.difference.size} sums)",
        where=", ".join(map(str, results or [deck])),
        hint=_HINT_ELSEWHERE if results else _HINT,
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
    writer.write(ADJOINT.MAP_ELEMENT, found.solved.sensitivity.whole_id)
    writer.write(ADJOINT.MAP_VOLUME, model.volume)
    writer.write(ADJOINT.MAP_S, found.solved.sensitivity.whole, units=per_kelvin)
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
    writer.write(ADJOINT.CHECK_RESIDUAL, found.solved.residual)


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
