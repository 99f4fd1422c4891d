"""The programme of candidates against the field of everything else, and its solutions."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from tedm_cli.arrays import FloatArray
from tedm_cli.balance.boxes import stacked
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
from tedm_cli.config.balance import BalanceConfig
from tedm_cli.gravity.compensation import CompensationMass, field_of_compensation_masses
from tedm_cli.gravity.field import SelfGravity
from tedm_cli.gravity.requirements import DcVerdict
from tedm_cli.gravity.testmass import TestMass
from tedm_cli.progress import Step, counter
from tedm_cli.stages.balance.candidates import Candidates
from tedm_cli.stages.balance.rest import Rest, field_of_each
from tedm_cli.threads import side_by_side


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
    """The relaxed solution and its conflicts; that of whole shims, and by what part they are above their caps.

    Both have room for what everything may be off.
    """

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


def verdicts_of(rest: Rest, blocks: Sequence[CompensationMass]) -> list[DcVerdict]:
    """The balanced field, of the blocks as they are: stacks of shims as one block each."""
    return rest.verdicts(blocks, field_of_each(rest.config, rest.test_masses, blocks))


def tied(config: BalanceConfig, found: Candidates) -> dict[str, tuple[int, FloatArray]]:
    """By name of a block, to how many grids it is tied, and where they are sought."""
    wanted: dict[str, tuple[int, FloatArray]] = {}
    for part, number in zip(found.parts, found.box, strict=True):
        if (count := config.box[number].nearest_grids) is not None:
            wanted |= {part.name + image.suffix: (count, image.point(part.base_m)) for image in part.images}
    return wanted


def could_be_met(programme: Programme, conflicts: Sequence[Conflict], config: BalanceConfig) -> int:
    """How many of the limits that masses reach could be met together; all of them where none is in conflict."""
    reached = int(programme.reached.sum())
    return int(most_met(programme, config.time_limit_s).sum()) if conflicts else reached
