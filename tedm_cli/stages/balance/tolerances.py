"""Tolerances of blocks and parts: what each may change, for margins of the programme, and builds drawn from them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from tedm_cli.arrays import FloatArray
from tedm_cli.balance.deviations import Deviations, Source
from tedm_cli.balance.yields import Yield, by_shift, changes_by_shift, judged_draws
from tedm_cli.config.balance import BalanceConfig, ToleranceTable
from tedm_cli.config.model.as_built import PartTolerance, read_tolerances
from tedm_cli.files.store import Reader
from tedm_cli.gravity.compensation import CompensationMass
from tedm_cli.progress import Step, counter
from tedm_cli.results.gravity.at_rest import of_field
from tedm_cli.stages.balance.candidates import Candidates
from tedm_cli.stages.balance.parts import PartField, Parts
from tedm_cli.stages.balance.rest import Rest, field_of_each
from tedm_cli.threads import side_by_side

_STEP_M = 2e-5  # of a block to either side
_AXES = "xyz"
_CHECKED = 5  # builds whose field is computed as that of the model


@dataclass(frozen=True, eq=False)
class Tolerances:
    """What the configuration says, and the parts of its table with their fields."""

    table: ToleranceTable
    parts: list[PartTolerance]
    fields: list[PartField]


def read_all(path: Path | None, config: BalanceConfig, unit: Reader, rest: Rest, step: Step) -> Tolerances | None:
    """The tolerances of the configuration, with the table of parts at `path`."""
    if config.tolerance is None:
        return None
    parts = [] if path is None else read_tolerances(path)
    return Tolerances(config.tolerance, parts, Parts(unit, rest).fields([p.part for p in parts], step))


def deviations(
    found: Tolerances, rest: Rest, candidates: Candidates, effects: Sequence[Sequence[FloatArray]], step: Step
) -> Deviations:
    """What one standard deviation of everything does to the limited quantities.

    Each block has a mass and a place of its own, also images; of a stack all shims have the same.

    Parameters
    ----------
    effects : [r] of every block of every column, [column][block].
    """
    table, none = found.table, np.zeros(0, dtype=np.int64)
    nothing = np.zeros(len(rest.before))
    columns = candidates.columns
    sources = []
    moved = _by_shift(rest, candidates, step) if table.block_position_m else []
    for row, part in enumerate(candidates.parts):
        own = np.array([i for i, column in enumerate(columns) if column.box == row], dtype=np.int64)
        for number, image in enumerate(part.images):
            name = part.name + image.suffix
            if table.block_mass:
                by_unit = table.block_mass * np.array([effects[i][number] for i in own]).T
                sources.append(Source(f"{name}, mass", own, by_unit, nothing))
            for axis in range(3) if table.block_position_m else ():
                by_unit = table.block_position_m * np.array([moved[i][number][axis] for i in own]).T
                sources.append(Source(f"{name}, {_AXES[axis]}", own, by_unit, nothing))
    for tolerance, field in zip(found.parts, found.fields, strict=True):
        no_unit = np.zeros((len(nothing), 0))
        if tolerance.mass:
            sources.append(Source(f"{field.name}, mass", none, no_unit, tolerance.mass * field.value))
        for axis in range(3) if tolerance.position_m else ():
            change = tolerance.position_m * field.by_shift[axis]
            sources.append(Source(f"{field.name}, {_AXES[axis]}", none, no_unit, change))
    return Deviations(sources, table.sum, table.sigmas)


def _by_shift(rest: Rest, candidates: Candidates, step: Step) -> list[list[FloatArray]]:
    """Change per metre [3, r] of the limited quantities by each block of each column, [column][block]."""
    g = rest.config.gravity.gravitational_constant_m3_kg_s2
    shifts = np.concatenate([way * _STEP_M * np.eye(3) for way in (1.0, -1.0)])

    def of_test_mass(t: int, on: Callable[[int], None]) -> list[list[FloatArray]]:
        found = []
        for column in candidates.columns:
            changes = [changes_by_shift(rest.test_masses[t], b, shifts, g) for b in column.blocks]
            found.append(
                [
                    (c[:3] - c[3:]) / (2.0 * _STEP_M) @ rest.functional(t, b.group).T
                    for c, b in zip(changes, column.blocks, strict=True)
                ]
            )
            on(1)
        return found

    count = len(rest.test_masses)
    advance = counter(step, count * len(candidates.columns), "moving the candidates")
    first, *others = side_by_side(of_test_mass, range(count), advance)
    for other in others:
        first = [[a + b for a, b in zip(x, y, strict=True)] for x, y in zip(first, other, strict=True)]
    return first


def drawn(found: Tolerances, rest: Rest, blocks: Sequence[CompensationMass], step: Step) -> Yield:
    """Builds drawn from the tolerances, all independent and normal.

    What moves changes the field to the second order of its shift, parts of the model along each axis. Some builds are
    compared with the field of their blocks as build-sensitivity computes it.
    """
    table = found.table
    draws, rng = table.draws, np.random.default_rng(table.seed)
    values = np.tile([v.value for v in rest.before], (draws, 1))
    mass = 1.0 + table.block_mass * rng.standard_normal((draws, len(blocks)))
    shift = table.block_position_m * rng.standard_normal((draws, len(blocks), 3))
    for tolerance, field in zip(found.parts, found.fields, strict=True):
        values += field.change(
            tolerance.mass * rng.standard_normal(draws), tolerance.position_m * rng.standard_normal((draws, 3))
        )
    own = _of_blocks(rest, blocks, mass, shift, 2.0 * table.block_position_m, step)
    lower, upper = (np.array([getattr(v, end) for v in rest.before]) for end in ("lower", "upper"))
    error = 0.0
    for n in range(min(_CHECKED, draws)):
        built = [
            replace(b, mass_kg=b.mass_kg * m, centre_m=b.centre_m + s)
            for b, m, s in zip(blocks, mass[n], shift[n], strict=True)
        ]
        exact = rest.effect(built, field_of_each(rest.config, rest.test_masses, built))
        error = max(error, float((np.abs(exact - own[n]) / np.minimum(upper, -lower)).max()))
    values += own
    return judged_draws(np.maximum(values / upper, values / lower), error)


def _of_blocks(
    rest: Rest, blocks: Sequence[CompensationMass], mass: FloatArray, shift: FloatArray, step_m: float, step: Step
) -> FloatArray:
    """What blocks of so much of their mass [d, b], at shifts [d, b, 3] (m), add to the limited quantities [d, r]."""
    g = rest.config.gravity.gravitational_constant_m3_kg_s2
    fields = field_of_each(rest.config, rest.test_masses, blocks)

    def of_test_mass(t: int, on: Callable[[int], None]) -> FloatArray:
        total = np.zeros((len(mass), len(rest.before)))
        for b, block in enumerate(blocks):
            field = np.tile(of_field(fields[t][b]), (len(mass), 1))
            if step_m:
                field += by_shift(rest.test_masses[t], block, step_m, g).of(shift[:, b])
            total += mass[:, b, None] * (field @ rest.functional(t, block.group).T)
            on(1)
        return total

    count = range(len(rest.test_masses))
    advance = counter(step, len(blocks) * len(count), "drawing builds")
    return np.asarray(sum(side_by_side(of_test_mass, count, advance)))
