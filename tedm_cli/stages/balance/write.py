"""The datasets of balance.h5, of a balance or of a re-trim."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from tedm_cli.arrays import FloatArray
from tedm_cli.balance.deviations import Deviations
from tedm_cli.balance.programme import Conflict, Programme, Solution
from tedm_cli.balance.yields import Yield
from tedm_cli.config.balance import BalanceConfig
from tedm_cli.contracts import BALANCE
from tedm_cli.files.store import Writer
from tedm_cli.gravity.compensation import CompensationMass
from tedm_cli.gravity.requirements import AT_REST_UNITS, DcVerdict
from tedm_cli.stages.balance.candidates import Candidates


def write_requirements(
    writer: Writer,
    before: Sequence[DcVerdict],
    after: Sequence[DcVerdict],
    programme: Programme,
    solution: Solution,
    conflicts: Sequence[Conflict],
) -> None:
    """The limits with their values before and after, and what the programme says of them."""
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


def write_candidates(
    writer: Writer,
    config: BalanceConfig,
    found: Candidates,
    programme: Programme,
    relaxed: Solution,
    solution: Solution,
    conflicts: Sequence[Conflict],
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


def off_of(off: Deviations | None, solution: Solution, requirements: int) -> FloatArray:
    """[r], how far values may be off by all tolerances."""
    return np.zeros(requirements) if off is None else off.off(solution.units)


def write_tolerances(writer: Writer, off: Deviations, solution: Solution, found: Yield) -> None:
    """What may deviate, and the builds that were drawn."""
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
    writer.write(k.YIELD_ERROR, found.error)
    writer.write(k.YIELD_EACH, found.each)
    writer.write(k.YIELD_RATIO, found.ratio)


def write_blocks(writer: Writer, found: Candidates, blocks: Sequence[CompensationMass]) -> None:
    """The blocks that are there."""
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


def write_totals(
    writer: Writer,
    config: BalanceConfig,
    programme: Programme,
    relaxed: Solution,
    solution: Solution,
    beyond: float,
    could_be_met: int,
) -> None:
    """Sums over all blocks."""
    writer.write(BALANCE.COULD_BE_MET, could_be_met)
    writer.write(BALANCE.MARGIN, config.margin)
    writer.write(BALANCE.MASS, solution.mass_kg(programme))
    writer.write(BALANCE.RELAXED, relaxed.mass_kg(programme))
    writer.write(BALANCE.BOUND, solution.bound_kg)
    writer.write(BALANCE.BEYOND, beyond)
