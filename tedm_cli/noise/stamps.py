"""Whether the stamps of a time series, read block by block, are those of a regular sampling."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from tedm_cli.arrays import FloatArray, IntArray
from tedm_cli.errors import InputError

STEP_TOLERANCE = 1e-3  # of the step: stamps printed with few digits are regular still
_GAP = 1.5  # steps from which on samples are missing


class Stamps:
    """Watches over the stamps of a series; fed with them in order.

    Parameters
    ----------
    regular : refuse steps that differ from the median of the first block by more than `STEP_TOLERANCE`.
    max_gap_s : longest step, s, that irregular stamps may have; by default three times that median.
    place : names a row for messages.
    """

    def __init__(self, place: Callable[[int], str], *, regular: bool, max_gap_s: float | None = None) -> None:
        self._place, self._regular, self._max_gap_s = place, regular, max_gap_s
        self.count = 0
        self.first_s = self.last_s = np.nan
        self.step_s = np.nan

    def add(self, time_s: FloatArray, places: IntArray) -> None:
        """Take the stamps [B] of a block, in s, and the places [B] of its rows.

        Raises
        ------
        InputError : time that does not increase, a gap, or a step that is not the regular one; names the first place,
            and by how much.
        """
        before = np.concatenate([[self.last_s] if self.count else [], time_s])
        step = np.diff(before)
        where = places[len(places) - len(step) :]
        wrong = np.flatnonzero(~(step > 0.0))
        if wrong.size:
            n = int(wrong[0])
            raise InputError(
                f"time_s is {before[n + 1]:.15g} after {before[n]:.15g}",
                where=self._place(int(where[n])),
                hint="stamps must increase from row to row: sort the table, and drop what is there twice",
            )
        if step.size and not np.isfinite(self.step_s):
            self.step_s = float(np.median(step))
        if self._regular:
            self._refuse_irregular(step, where)
        else:
            self._refuse_gaps(step, where)
        self.count += len(time_s)
        self.first_s = self.first_s if np.isfinite(self.first_s) else float(time_s[0])
        self.last_s = float(time_s[-1])

    @property
    def mean_step_s(self) -> float:
        """Step of a regular series over all of it, which the print of single stamps does not round, s."""
        return (self.last_s - self.first_s) / (self.count - 1)

    def _refuse_irregular(self, step: FloatArray, places: IntArray) -> None:
        wrong = np.flatnonzero(np.abs(step - self.step_s) > STEP_TOLERANCE * self.step_s)
        if not wrong.size:
            return
        n = int(wrong[0])
        if step[n] > _GAP * self.step_s:
            fact = f"a gap of {step[n]:.9g} s, some {step[n] / self.step_s - 1:.0f} samples of {self.step_s:.9g} s"
        else:
            fact = f"a step of {step[n]:.9g} s among steps of {self.step_s:.9g} s ({step[n] / self.step_s - 1:+.2g})"
        raise InputError(
            fact,
            where=self._place(int(places[n])),
            hint=f'stamps must be regular, or be made so: resample_s = {self.step_s:.6g} and method = "linear"',
        )

    def _refuse_gaps(self, step: FloatArray, places: IntArray) -> None:
        allowed = self._max_gap_s if self._max_gap_s is not None else 3.0 * self.step_s
        wrong = np.flatnonzero(step > allowed * (1.0 + STEP_TOLERANCE))
        if wrong.size:
            n = int(wrong[0])
            raise InputError(
                f"a gap of {step[n]:.9g} s is too long to interpolate (at most {allowed:.6g} s)",
                where=self._place(int(places[n])),
                hint="cut the series there, or set max_gap_s",
            )
