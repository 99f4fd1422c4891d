"""balance: masses in the boxes of the configuration that bring the field at rest within its limits."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tedm_cli.arrays import FloatArray
from tedm_cli.balance.boxes import blocks_of, stacked
from tedm_cli.balance.deviations import Deviations, with_room
from tedm_cli.balance.programme import (
    Conflict,
    Programme,
    Solution,
    balanced,
    most_met,
    on_each_other,
    whole_units,
)
from tedm_cli.balance.yields import Yield
from tedm_cli.config.balance import BalanceConfig, load_balance
from tedm_cli.config.compensation import csv_text
from tedm_cli.config.model import load_model
from tedm_cli.config.project import Project
from tedm_cli.contracts import BALANCE, SENSITIVITY, UNIT_LOADS
from tedm_cli.files.build_folder import BALANCE_FILE, SENSITIVITY_FILE, UNIT_LOADS_FILE, provenance, require_input
from tedm_cli.files.store import Writer, create, open_checked, replacing
from tedm_cli.gravity.compensation import CompensationMass, field_of_compensation_masses
from tedm_cli.gravity.field import SelfGravity
from tedm_cli.gravity.requirements import AT_REST_UNITS, DcVerdict
from tedm_cli.gravity.testmass import TestMass
from tedm_cli.progress import Step, counter
from tedm_cli.results.balance import BalanceResults, read_balance
from tedm_cli.stages.balance.candidates import Candidates, candidates, with_ties
from tedm_cli.stages.balance.rest import Rest, field_of_each, read_rest
from tedm_cli.stages.balance.tolerances import deviations, drawn, read_all
from tedm_cli.stages.common import out_path
from tedm_cli.threads import side_by_side

CSV_FILE = "balance_masses.csv"


@dataclass(frozen=True, eq=False)
class BalanceSummary:
    """The files, what the first says, parts of boxes that were left out, compensation masses that stay, and the time.

    csv : the compensation masses of a balanced model. kept : how many of them are not of the balance.
    """

    path: Path
    csv: Path
    results: BalanceResults
    left_out: dict[str, int]
    kept: int
    replaced: bool
    seconds: float


def balance(project: Project, output: Path | None, csv: Path | None, step: Step) -> BalanceSummary:
    """Write balance.h5 and the CSV of compensation masses.

    Raises
    ------
    ConfigError : the project says nothing of boxes, or something wrong; nothing is limited.
    InputError : sensitivity.h5 or unit_loads.h5 is missing or stale.
    PhysicsError : no whole shims were found.
    """
    begin = time.perf_counter()
    path = project.required_balance()
    model_file, model = load_model(project.model)
    model.required_test_masses(project.model)
    file, config = load_balance(path, model.test_masses(), {rule.group for rule in model.areas.rule})
    sources = [project.build_dir / SENSITIVITY_FILE, project.build_dir / UNIT_LOADS_FILE]
    out, table = out_path(project, BALANCE_FILE, output), csv or project.build_dir / CSV_FILE
    parts = None if config.tolerance is None or config.tolerance.parts is None else path.parent / config.tolerance.parts
    trace = provenance([model_file, file], [*sources, *([] if parts is None else [parts])])
    with open_checked(sources[0], SENSITIVITY) as sensitivity, open_checked(sources[1], UNIT_LOADS) as unit:
        require_input(sensitivity, trace.inputs[1])
        rest = read_rest(project, model, sensitivity, config.subsystems, keep=config.existing == "keep", where=path)
        found = candidates(project, model, config, unit, rest.kept, path)
        programme, effects = programme_of(rest, found, config, step)
        tolerances = read_all(parts, config, unit, rest, step)
        off = None if tolerances is None else deviations(tolerances, rest, found, effects, step)
        relaxed, conflicts, solution, beyond = solved(programme, off, config)
        blocks = blocks_of(found.parts, found.columns, solution.units)
        blocks = with_ties(blocks, _tied(config, found), unit)
    before, after = rest.before, _verdicts(rest, blocks)
    with create(out, BALANCE, trace) as writer:
        _write_requirements(writer, before, after, programme, solution, conflicts)
        writer.write(BALANCE.OFF, _off(off, solution, len(before)), units="see /requirement/unit")
        _write_candidates(writer, rest, config, found, programme, relaxed, solution, conflicts, step)
        _write_blocks(writer, found, blocks)
        writer.write(BALANCE.MARGIN, config.margin)
        writer.write(BALANCE.MASS, solution.mass_kg(programme))
        writer.write(BALANCE.RELAXED, relaxed.mass_kg(programme))
        writer.write(BALANCE.BOUND, solution.bound_kg)
        writer.write(BALANCE.BEYOND, beyond)
        if off is not None and tolerances is not None:
            _write_tolerances(writer, off, solution, drawn(tolerances, rest, blocks, step))
    with replacing(table) as temporary:
        temporary.write_text(csv_text([*rest.csv, *blocks]), encoding="utf-8", newline="")
    with open_checked(out, BALANCE) as written:
        results = read_balance(written)
    replaced = config.existing == "replace" and bool(model.compensation_mass or model.gravity.compensation_masses)
    return BalanceSummary(out, table, results, found.left_out, len(rest.kept), replaced, time.perf_counter() - begin)


def programme_of(
    rest: Rest, found: Candidates, config: BalanceConfig, step: Step
) -> tuple[Programme, list[list[FloatArray]]]:
    """The programme of the unknowns, and what each block of a unit of each adds to the limited values [r]."""
    columns = found.columns
    fields = fields_of([column.blocks for column in columns], rest, step, "field of the candidates")
    effects = [
        [rest.effect([block], [[of[b]] for of in field]) for b, block in enumerate(column.blocks)]
        for column, field in zip(columns, fields, strict=True)
    ]
    verdicts = rest.before
    matrix, bound = on_each_other(stacked(columns), len(columns))
    programme = Programme(
        rest=np.array([v.value for v in verdicts]),
        lower=np.array([v.lower for v in verdicts]),
        upper=np.array([v.upper for v in verdicts]),
        effect=np.array([np.sum(own, axis=0) for own in effects]).T,
        unit_kg=np.array([c.unit_kg for c in columns]),
        least=np.array([c.least for c in columns]),
        most=np.array([c.most for c in columns]),
        whole=np.array([c.whole for c in columns]),
        matrix=matrix,
        bound=bound,
        margin=config.margin,
    )
    return programme, effects


def solved(
    programme: Programme, off: Deviations | None, config: BalanceConfig
) -> tuple[Solution, list[Conflict], Solution, float]:
    """The relaxed solution and its conflicts; that of whole shims, and by what part they are above their caps."""

    def of_any(p: Programme) -> tuple[FloatArray, FloatArray, tuple[Solution, list[Conflict]]]:
        keep = most_met(p, config.time_limit_s) if config.goal == "most met" else None
        relaxed, conflicts = balanced(p, keep)
        return relaxed.units, relaxed.cap, (relaxed, conflicts)

    programme, (relaxed, conflicts) = with_room(programme, off, of_any)

    def of_whole(p: Programme) -> tuple[FloatArray, FloatArray, tuple[Solution, float]]:
        solution, beyond = whole_units(p, relaxed, config.time_limit_s)
        return solution.units, solution.cap, (solution, beyond)

    _, (solution, beyond) = with_room(programme, off, of_whole)
    return relaxed, conflicts, solution, beyond


def fields_of(
    sets: Sequence[Sequence[CompensationMass]], rest: Rest, step: Step, what: str
) -> list[list[list[SelfGravity]]]:
    """The field of every set of blocks, [set][test mass][block]."""
    gravity = rest.config.gravity
    g, tolerance = gravity.gravitational_constant_m3_kg_s2, gravity.compensation_tolerance

    def of_test_mass(tm: TestMass, on: Callable[[int], None]) -> list[list[SelfGravity]]:
        found = []
        for blocks in sets:
            found.append([h.field for h in field_of_compensation_masses(tm, blocks, g, tolerance=tolerance)[2]])
            on(1)
        return found

    advance = counter(step, len(rest.test_masses) * len(sets), what)
    by_mass = side_by_side(of_test_mass, rest.test_masses, advance)
    return [list(of) for of in zip(*by_mass, strict=True)]


def _verdicts(rest: Rest, blocks: Sequence[CompensationMass]) -> list[DcVerdict]:
    """The balanced field, of the blocks as they are: stacks of shims as one block each."""
    return rest.verdicts(blocks, field_of_each(rest.config, rest.test_masses, blocks))


def _tied(config: BalanceConfig, found: Candidates) -> dict[str, tuple[int, FloatArray]]:
    """By name of a block, to how many grids it is tied, and where they are sought."""
    wanted: dict[str, tuple[int, FloatArray]] = {}
    for part, number in zip(found.parts, found.box, strict=True):
        if (count := config.box[number].nearest_grids) is not None:
            wanted |= {part.name + image.suffix: (count, image.point(part.base_m)) for image in part.images}
    return wanted


def _write_requirements(
    writer: Writer,
    before: Sequence[DcVerdict],
    after: Sequence[DcVerdict],
    programme: Programme,
    solution: Solution,
    conflicts: Sequence[Conflict],
) -> None:
    k = BALANCE
    writer.write(k.REQUIREMENT_NAME, [f"{v.place} {v.quantity}, {v.subsystem}, {v.requirement}" for v in before])
    writer.write(k.TEST_MASS, [v.test_mass for v in before])
    writer.write(k.MINUS, [v.minus for v in before])
    writer.write(k.QUANTITY, [v.quantity for v in before])
    writer.write(k.SUBSYSTEM, [v.subsystem for v in before])
    writer.write(k.WHOLE, [int(v.whole) for v in before])
    writer.write(k.REQUIREMENT, [v.requirement for v in before])
    writer.write(k.SOURCE, [v.source for v in before])
    writer.write(k.UNIT, [AT_REST_UNITS[v.quantity] for v in before])
    for path, values in (
        (k.LOWER, [v.lower for v in before]),
        (k.UPPER, [v.upper for v in before]),
        (k.BEFORE, [v.value for v in before]),
        (k.AFTER, [v.value for v in after]),
    ):
        writer.write(path, np.array(values, dtype=np.float64), units="see /requirement/unit")
    writer.write(k.CAP, solution.cap)
    writer.write(k.BLOCKING, solution.blocking.astype(np.int64))
    writer.write(k.REACHED, programme.reached.astype(np.int64))
    writer.write(k.PRICE, solution.price_kg * solution.cap)
    writer.write(k.CONFLICT_RATIO, np.array([c.ratio for c in conflicts]))
    writer.write(k.CONFLICT_WEIGHT, np.array([c.weight for c in conflicts]).reshape(-1, len(before)))
    writer.write(k.CONFLICT_BESIDE, np.array([c.beside for c in conflicts]).reshape(-1, len(before)))


def _write_candidates(
    writer: Writer,
    rest: Rest,
    config: BalanceConfig,
    found: Candidates,
    programme: Programme,
    relaxed: Solution,
    solution: Solution,
    conflicts: Sequence[Conflict],
    step: Step,
) -> None:
    """The parts of the boxes, the shims of a stack summed."""
    k, columns = BALANCE, found.columns
    parts = [[i for i, column in enumerate(columns) if column.box == row] for row in range(len(found.parts))]

    def sums(of_column: FloatArray) -> FloatArray:
        return np.array([of_column[own].sum() for own in parts])

    full = sums(programme.unit_kg * programme.most)
    effect = np.array([(programme.effect[:, own] * programme.most[own]).sum(axis=1) for own in parts]).T
    steps = [columns[own[0]].whole for own in parts]
    writer.write(k.CANDIDATE_NAME, [part.name for part in found.parts])
    writer.write(k.CANDIDATE_BOX, [config.box[number].name for number in found.box])
    writer.write(k.CANDIDATE_IMAGES, [len(part.images) for part in found.parts])
    writer.write(k.CANDIDATE_FULL, full)
    writer.write(k.CANDIDATE_RELAXED, sums(programme.unit_kg * relaxed.units))
    writer.write(k.CANDIDATE_MASS, sums(programme.unit_kg * solution.units))
    writer.write(k.CANDIDATE_SHIMS, np.where(steps, sums(solution.units).round(), -1).astype(np.int64))
    # Of a stack the last shim says what one more would.
    writer.write(k.CANDIDATE_ROOM, np.array([relaxed.room_kg[own[-1]] for own in parts]))
    writer.write(k.EFFECT, effect / full, units="unit of the requirement per kg")
    gain = np.array([[c.gain[own[-1]] for own in parts] for c in conflicts])
    writer.write(k.CONFLICT_GAIN, gain.reshape(-1, len(parts)))


def _off(off: Deviations | None, solution: Solution, requirements: int) -> FloatArray:
    return np.zeros(requirements) if off is None else off.off(solution.units)


def _write_tolerances(writer: Writer, off: Deviations, solution: Solution, found: Yield) -> None:
    k = BALANCE
    if off.sources:
        writer.write(k.TOLERANCE_NAME, [source.name for source in off.sources])
        change = off.changes(solution.units)
        writer.write(k.TOLERANCE_CHANGE, change, units="see /requirement/unit")
        writer.write(k.TOLERANCE_SUM, off.sum)
        writer.write(k.TOLERANCE_SIGMAS, off.sigmas)
    writer.write(k.YIELD_DRAWS, found.draws)
    writer.write(k.YIELD_MET, found.met)
    writer.write(k.YIELD_INTERVAL, np.array([found.low, found.high]))
    writer.write(k.YIELD_EACH, found.each)
    writer.write(k.YIELD_RATIO, found.ratio)


def _write_blocks(writer: Writer, found: Candidates, blocks: Sequence[CompensationMass]) -> None:
    k = BALANCE
    row = {part.name + image.suffix: n for n, part in enumerate(found.parts) for image in part.images}
    writer.write(k.BLOCK_NAME, [b.name for b in blocks])
    writer.write(k.BLOCK_CANDIDATE, np.array([row[b.name] for b in blocks], dtype=np.int64))
    writer.write(k.BLOCK_CENTRE, np.array([b.centre_m for b in blocks]).reshape(-1, 3))
    writer.write(k.BLOCK_SIZE, np.array([b.size_m for b in blocks]).reshape(-1, 3))
    writer.write(k.BLOCK_AXES, np.array([b.axes for b in blocks]).reshape(-1, 3, 3))
    writer.write(k.BLOCK_MASS, np.array([b.mass_kg for b in blocks], dtype=np.float64))
    writer.write(k.BLOCK_GROUP, [b.group for b in blocks])
    writer.write(k.BLOCK_TIE, ["" if b.tie is None else b.tie.words for b in blocks])
