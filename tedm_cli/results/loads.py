"""Loads other than temperature, as loads.h5 tells them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tedm_cli.arrays import BoolArray, FloatArray
from tedm_cli.contracts import LOADS
from tedm_cli.files.store import Reader

MOTION = "motion"
ROUNDING = 1e-6
"""Share of a motion below which distortion is rounding: of all supports as one, or of a foot of an isostatic mount."""


@dataclass(frozen=True, eq=False)
class Margins:
    """Checks of the layout: what, where, of which element, [m] each; limits and values in `unit`.

    before : [m]; after : [m, k], by each load; NaN of motions, and where a beam no longer comes.
    """

    check: list[str]
    where: list[str]
    element: list[str]
    unit: list[str]
    limit: FloatArray
    before: FloatArray
    after: FloatArray

    @property
    def left_before(self) -> FloatArray:
        """Share of each limit that is left, [m], in the layout as it is."""
        return np.asarray(1.0 - self.before / self.limit)

    def left_after(self, load: int) -> FloatArray:
        """The same after a load; minus infinity of a beam that no longer comes."""
        left = 1.0 - self.after[:, load] / self.limit
        return np.where(np.isnan(left), -np.inf, left)

    def least(self, load: int) -> int:
        """The check that has least left after a load."""
        return int(self.left_after(load).argmin())

    def most_lost(self, load: int) -> int:
        """The check that loses most by it."""
        return int((self.left_after(load) - self.left_before).argmin())


@dataclass(frozen=True, eq=False)
class Modes:
    """Natural frequencies [m] in Hz, their effective masses [m, 6] and those of the structure as one [6], kg and kg m².

    rigid : motions that nothing holds, which are not among them.
    """

    frequency_hz: FloatArray
    effective_mass: FloatArray
    mass: FloatArray
    rigid: list[str]

    @property
    def share(self) -> FloatArray:
        """Of the mass of the structure that moves with each mode, along x, y, z, [m, 3]."""
        return np.asarray(self.effective_mass[:, :3] / self.mass[:3])


@dataclass(frozen=True, eq=False)
class LoadResults:
    """What k loads do, per unit of each.

    name, kind, unit, foot : [k], as in loads.h5. largest, distortion : [k], m, of any grid, whole and without the
    motion of the structure as one.
    bench : [k], m, of any optical element, without the motion of its bench as one; None without read-outs.
    label, row_unit : [r], outputs. output, by_distortion : [r, k].
    beam, beam_unit : names and units of what beams do, beam_shift [b, k]; empty without read-outs.
    margins : None of layouts that are not traced. modes : None where none were asked for.
    interface : largest share of distortion in motions of all supports as one. residual : of the solutions.
    """

    name: list[str]
    kind: list[str]
    unit: list[str]
    foot: list[str]
    largest: FloatArray
    distortion: FloatArray
    bench: FloatArray | None
    label: list[str]
    row_unit: list[str]
    output: FloatArray
    by_distortion: FloatArray
    beam: list[str]
    beam_unit: list[str]
    beam_shift: FloatArray
    margins: Margins | None
    modes: Modes | None
    interface: float
    residual: float

    def of_unit(self, unit: str) -> list[int]:
        """Outputs in a unit."""
        return [row for row, u in enumerate(self.row_unit) if u == unit]

    def largest_output(self, values: FloatArray, unit: str, load: int) -> tuple[str, float] | None:
        """The output in a unit that a load changes most, of `values` [r, k]; None where there is none."""
        rows = self.of_unit(unit)
        if not rows:
            return None
        row = max(rows, key=lambda r: abs(values[r, load]))
        return self.label[row], float(values[row, load])

    @property
    def ranked(self) -> FloatArray:
        """What loads are ranked by: how they distort the benches, or else the structure, [k]."""
        return self.distortion if self.bench is None else self.bench

    @property
    def bench_as_one(self) -> BoolArray:
        """Whether benches move as one by a motion, to rounding, [k]; never by releases, nor without read-outs.

        Against the largest of all motions: a foot that turns in a joint moves nothing to measure by.
        """
        found = np.zeros(len(self.name), dtype=bool)
        if self.bench is None:
            return found
        found[self.motions] = self.bench[self.motions] <= ROUNDING * self.largest[self.motions].max(initial=0.0)
        return found

    @property
    def motions(self) -> list[int]:
        return [k for k, kind in enumerate(self.kind) if kind == MOTION]

    @property
    def releases(self) -> list[int]:
        return [k for k, kind in enumerate(self.kind) if kind != MOTION]


def read_loads(file: Reader) -> LoadResults:
    """What an open file says."""
    loads = len(file.strings(LOADS.LOAD_NAME))
    with_beams = file.has(LOADS.BEAM_SHIFT)
    return LoadResults(
        name=file.strings(LOADS.LOAD_NAME),
        kind=file.strings(LOADS.LOAD_KIND),
        unit=file.strings(LOADS.LOAD_UNIT),
        foot=file.strings(LOADS.LOAD_FOOT),
        largest=file.array(LOADS.LARGEST),
        distortion=file.array(LOADS.LARGEST_DISTORTION),
        bench=file.array(LOADS.BENCH_DISTORTION) if with_beams else None,
        label=file.strings(LOADS.ROW_LABEL),
        row_unit=file.strings(LOADS.ROW_UNIT),
        output=file.array(LOADS.OUTPUT),
        by_distortion=file.array(LOADS.OUTPUT_DISTORTION),
        beam=file.strings(LOADS.LABEL_RAY_OUTPUT) if with_beams else [],
        beam_unit=file.strings(LOADS.LABEL_RAY_OUTPUT_UNIT) if with_beams else [],
        beam_shift=file.array(LOADS.BEAM_SHIFT) if with_beams else np.zeros((0, loads)),
        margins=_margins(file) if file.has(LOADS.MARGIN_CHECK) else None,
        modes=_modes(file) if file.has(LOADS.MODE_FREQUENCY) else None,
        interface=file.number(LOADS.CHECK_INTERFACE),
        residual=file.number(LOADS.CHECK_RESIDUAL),
    )


def _margins(file: Reader) -> Margins:
    return Margins(
        check=file.strings(LOADS.MARGIN_CHECK),
        where=file.strings(LOADS.MARGIN_WHERE),
        element=file.strings(LOADS.MARGIN_ELEMENT),
        unit=file.strings(LOADS.MARGIN_UNIT),
        limit=file.array(LOADS.MARGIN_LIMIT),
        before=file.array(LOADS.MARGIN_BEFORE),
        after=file.array(LOADS.MARGIN_AFTER),
    )


def _modes(file: Reader) -> Modes:
    return Modes(
        file.array(LOADS.MODE_FREQUENCY),
        file.array(LOADS.MODE_EFFECTIVE_MASS),
        file.array(LOADS.MODE_MASS),
        file.strings(LOADS.MODE_RIGID),
    )
