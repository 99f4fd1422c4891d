"""What balance.h5 says: the field at rest before and after, the blocks, and what each requirement costs."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tedm_cli.arrays import FloatArray, IntArray
from tedm_cli.balance.yields import Yield
from tedm_cli.contracts import BALANCE
from tedm_cli.files.store import Reader
from tedm_cli.gravity.requirements import DcVerdict


@dataclass(frozen=True, eq=False)
class ToleranceResults:
    """Sources of deviation: names [s], change of each value by a standard deviation [s, r], how they are summed."""

    name: list[str]
    change: FloatArray
    sum: str
    sigmas: float

    def largest(self, row: int) -> str:
        """The source that changes a value most."""
        return self.name[int(np.abs(self.change[:, row]).argmax())]


@dataclass(frozen=True, eq=False)
class ThermalPrice:
    """[S_SG] without the blocks and what tied ones add, [n, k], with their rows, units and areas."""

    row: list[str]
    unit: list[str]
    area: list[str]
    without: FloatArray
    added: FloatArray

    @property
    def root_sum_squares(self) -> FloatArray:
        """[2, n], over the areas, without the blocks and with them: areas that are independent and alike."""
        return np.sqrt([(self.without**2).sum(axis=1), ((self.without + self.added) ** 2).sum(axis=1)])

    @property
    def sums(self) -> FloatArray:
        """[2, n], over the areas, without the blocks and with them: areas that warm together."""
        return np.array([self.without.sum(axis=1), (self.without + self.added).sum(axis=1)])


@dataclass(frozen=True, eq=False)
class BalanceResults:
    """The balance of r requirements by b blocks of c candidates.

    Parameters
    ----------
    name : of each requirement. before, after : their verdicts without the blocks and with them.
    off : [r], how far values may be off by their tolerances, SI. cap, blocking, reached, price_kg : see the contract.
    conflict_ratio, conflict_weight, conflict_beside, conflict_gain : [n], [n, r], [n, r], [n, c].
    candidate, box, images : of each candidate its name, its box, and how many blocks it is.
    full_kg, relaxed_kg, mass_kg, shims, room : [c].
    effect : [r, c], per kg.
    mass_before_kg, shims_before : [c], of a re-trim what there was.
    block : names; block_candidate [b]; centre, size [b, 3] m; axes [b, 3, 3]; block_kg [b]; group, tie.
    """

    name: list[str]
    before: list[DcVerdict]
    after: list[DcVerdict]
    off: FloatArray
    cap: FloatArray
    blocking: IntArray
    reached: IntArray
    price_kg: FloatArray
    conflict_ratio: FloatArray
    conflict_weight: FloatArray
    conflict_beside: FloatArray
    conflict_gain: FloatArray
    candidate: list[str]
    box: list[str]
    images: IntArray
    full_kg: FloatArray
    relaxed_kg: FloatArray
    mass_kg: FloatArray
    shims: IntArray
    room: FloatArray
    effect: FloatArray
    block: list[str]
    block_candidate: IntArray
    centre: FloatArray
    size: FloatArray
    axes: FloatArray
    block_kg: FloatArray
    group: list[str]
    tie: list[str]
    margin: float
    total_kg: float
    total_relaxed_kg: float
    bound_kg: float
    beyond: float
    could_be_met: int
    tolerances: ToleranceResults | None
    drawn: Yield | None
    thermal: ThermalPrice | None
    mass_before_kg: FloatArray | None
    shims_before: IntArray | None

    @property
    def met(self) -> int:
        """Number of requirements that are met."""
        return sum(v.passed for v in self.after)

    @property
    def has_steps(self) -> bool:
        """Whether any mass is a whole number of shims or steps."""
        return bool((self.shims >= 0).any())

    def off_ratio(self, row: int) -> float:
        """What a value may be off, over the limit on its side."""
        return float(self.off[row] / abs(self.after[row].limit))

    def by_box(self) -> dict[str, FloatArray]:
        """By box: mass, relaxed mass and largest mass (kg) of all its blocks."""
        sums: dict[str, FloatArray] = {}
        for row, box in enumerate(self.box):
            own = np.array([self.mass_kg[row], self.relaxed_kg[row], self.full_kg[row]])
            sums[box] = sums.get(box, np.zeros(3)) + own
        return sums

    def helpful(self, row: int, most: int = 3) -> list[tuple[str, float]]:
        """The boxes whose mass brings a value nearer to 0, by how much of its limit a gram of each moves it."""
        v = self.after[row]
        way = -np.sign(v.value) * self.effect[row] / abs(v.limit) * 1e-3
        best = {box: max(float(way[i]) for i, b in enumerate(self.box) if b == box) for box in dict.fromkeys(self.box)}
        ranked = sorted(best.items(), key=lambda item: -item[1])
        return [(box, gain) for box, gain in ranked[:most] if gain > 0.0]


def read_balance(file: Reader) -> BalanceResults:
    """What the file says."""
    k = BALANCE
    names = [file.strings(path) for path in (k.TEST_MASS, k.QUANTITY, k.SUBSYSTEM)]
    ends = [file.array(path).tolist() for path in (k.LOWER, k.UPPER)]
    more = [file.strings(path) for path in (k.MINUS, k.REQUIREMENT, k.SOURCE)]
    whole = file.array(k.WHOLE).astype(bool).tolist()

    def verdicts(path: str) -> list[DcVerdict]:
        return [DcVerdict(*row) for row in zip(*names, file.array(path).tolist(), *ends, *more, whole, strict=True)]

    return BalanceResults(
        name=file.strings(k.REQUIREMENT_NAME),
        before=verdicts(k.BEFORE),
        after=verdicts(k.AFTER),
        off=file.array(k.OFF),
        cap=file.array(k.CAP),
        blocking=file.array(k.BLOCKING),
        reached=file.array(k.REACHED),
        price_kg=file.array(k.PRICE),
        conflict_ratio=file.array(k.CONFLICT_RATIO),
        conflict_weight=file.array(k.CONFLICT_WEIGHT),
        conflict_beside=file.array(k.CONFLICT_BESIDE),
        conflict_gain=file.array(k.CONFLICT_GAIN),
        candidate=file.strings(k.CANDIDATE_NAME),
        box=file.strings(k.CANDIDATE_BOX),
        images=file.array(k.CANDIDATE_IMAGES),
        full_kg=file.array(k.CANDIDATE_FULL),
        relaxed_kg=file.array(k.CANDIDATE_RELAXED),
        mass_kg=file.array(k.CANDIDATE_MASS),
        shims=file.array(k.CANDIDATE_SHIMS),
        room=file.array(k.CANDIDATE_ROOM),
        effect=file.array(k.EFFECT),
        block=file.strings(k.BLOCK_NAME),
        block_candidate=file.array(k.BLOCK_CANDIDATE),
        centre=file.array(k.BLOCK_CENTRE),
        size=file.array(k.BLOCK_SIZE),
        axes=file.array(k.BLOCK_AXES),
        block_kg=file.array(k.BLOCK_MASS),
        group=file.strings(k.BLOCK_GROUP),
        tie=file.strings(k.BLOCK_TIE),
        margin=float(file.array(k.MARGIN)),
        total_kg=float(file.array(k.MASS)),
        total_relaxed_kg=float(file.array(k.RELAXED)),
        bound_kg=float(file.array(k.BOUND)),
        beyond=float(file.array(k.BEYOND)),
        could_be_met=int(file.array(k.COULD_BE_MET)),
        tolerances=_tolerances(file) if file.has(k.TOLERANCE_NAME) else None,
        drawn=_drawn(file) if file.has(k.YIELD_DRAWS) else None,
        thermal=_thermal(file) if file.has(k.S_ADDED) else None,
        mass_before_kg=file.array(k.MASS_BEFORE) if file.has(k.MASS_BEFORE) else None,
        shims_before=file.array(k.SHIMS_BEFORE) if file.has(k.SHIMS_BEFORE) else None,
    )


def _tolerances(file: Reader) -> ToleranceResults:
    k = BALANCE
    return ToleranceResults(
        file.strings(k.TOLERANCE_NAME),
        file.array(k.TOLERANCE_CHANGE),
        file.string(k.TOLERANCE_SUM),
        float(file.array(k.TOLERANCE_SIGMAS)),
    )


def _thermal(file: Reader) -> ThermalPrice:
    k = BALANCE
    rows, units, areas = (file.strings(path) for path in (k.PRICE_ROW, k.PRICE_UNIT, k.PRICE_AREA))
    return ThermalPrice(rows, units, areas, file.array(k.S_WITHOUT), file.array(k.S_ADDED))


def _drawn(file: Reader) -> Yield:
    k = BALANCE
    low, high = file.array(k.YIELD_INTERVAL).tolist()
    draws, met = int(file.array(k.YIELD_DRAWS)), int(file.array(k.YIELD_MET))
    each, ratio, error = file.array(k.YIELD_EACH), file.array(k.YIELD_RATIO), float(file.array(k.YIELD_ERROR))
    return Yield(draws, met, low, high, each, ratio, error)
