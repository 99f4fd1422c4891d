"""Places and sizes of blocks that are smaller than their boxes: sought, with the programme of the masses inside."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from tedm_cli.arrays import FloatArray
from tedm_cli.balance.boxes import Box, columns_of
from tedm_cli.balance.programme import Programme
from tedm_cli.balance.search import objective_of, searched
from tedm_cli.config.balance import BalanceConfig
from tedm_cli.gravity.compensation import field_of_compensation_masses
from tedm_cli.progress import Step, counter
from tedm_cli.stages.balance.candidates import Candidates
from tedm_cli.stages.balance.rest import Rest
from tedm_cli.stages.balance.solve import programme_of

_TOLERANCE = 1e-5  # of the fields in the search; what it finds has the field of all others


@dataclass(frozen=True, eq=False)
class Sought:
    """How many numbers were sought, and how many programmes were solved for that."""

    numbers: int
    programmes: int


def with_places(rest: Rest, found: Candidates, config: BalanceConfig, step: Step) -> tuple[Candidates, Sought | None]:
    """Candidates whose blocks are where, and as large as, the least total mass or the least worst ratio wants them.

    Shims and steps need not be whole in the search, and nothing is off by tolerances.
    """
    sought = [row for row, part in enumerate(found.parts) if part.sought]
    if not any(part.inner_m is not None for part in found.parts):
        return found, None
    fixed_parts = [part for row, part in enumerate(found.parts) if row not in sought]
    fixed = _programme(rest, replace(found, parts=fixed_parts, columns=columns_of(fixed_parts)), config, step)
    counts = [found.parts[row].sought for row in sought]
    ends = np.cumsum([0, *counts])
    largest = float(fixed.unit_kg @ fixed.most) + sum(
        found.parts[row].full().mass_kg * len(found.parts[row].images) for row in sought
    )

    def boxes(numbers: FloatArray) -> list[Box]:
        return [found.parts[row].placed(numbers[ends[n] : ends[n + 1]]) for n, row in enumerate(sought)]

    def objective(numbers: FloatArray) -> float:
        return objective_of(_joined(rest, fixed, boxes(numbers)), largest)

    total = int(ends[-1])
    parts = {row: p.placed(np.zeros(p.sought)) for row, p in enumerate(found.parts) if p.inner_m is not None}
    evaluations = 0
    if total:
        table = config.search
        most = (table.generations + 1) * table.population * total + 30 * total
        advance = counter(step, most, "seeking places")
        best = searched(
            objective, np.zeros(total), np.ones(total), seed=table.seed, generations=table.generations,
            population=table.population, advance=advance,
        )  # fmt: skip
        evaluations = best.evaluations
        parts |= dict(zip(sought, boxes(best.parameter), strict=True))
    chosen = [parts.get(row, part) for row, part in enumerate(found.parts)]
    return replace(found, parts=chosen, columns=columns_of(chosen)), Sought(total, evaluations)


def _programme(rest: Rest, found: Candidates, config: BalanceConfig, step: Step) -> Programme:
    """That of the boxes whose places are given; of none, one without unknowns."""
    if found.columns:
        return programme_of(rest, found, config, step)[0]
    none, count = np.zeros(0), len(rest.before)
    return Programme(
        rest=np.array([v.value for v in rest.before]),
        lower=np.array([v.lower for v in rest.before]),
        upper=np.array([v.upper for v in rest.before]),
        effect=np.zeros((count, 0)),
        unit_kg=none,
        least=none,
        most=none,
        whole=np.zeros(0, dtype=bool),
        matrix=np.zeros((0, 0)),
        bound=none,
        margin=config.margin,
    )


def _joined(rest: Rest, fixed: Programme, boxes: list[Box]) -> Programme:
    """The programme with one more unknown for each of these boxes."""
    columns = columns_of(boxes)
    gravity = rest.config.gravity
    effects = []
    for column in columns:
        fields = [
            [
                how.field
                for how in field_of_compensation_masses(
                    tm, column.blocks, gravity.gravitational_constant_m3_kg_s2, tolerance=_TOLERANCE
                )[2]
            ]
            for tm in rest.test_masses
        ]
        effects.append(rest.effect(column.blocks, fields))
    more = len(columns)
    return replace(
        fixed,
        effect=np.hstack([fixed.effect, np.array(effects).T]),
        unit_kg=np.append(fixed.unit_kg, [c.unit_kg for c in columns]),
        least=np.append(fixed.least, np.zeros(more)),
        most=np.append(fixed.most, [c.most for c in columns]),
        whole=np.append(fixed.whole, np.zeros(more, dtype=bool)),
        matrix=np.hstack([fixed.matrix, np.zeros((len(fixed.matrix), more))]),
    )
