"""What the figures of the noise cases are drawn from; arrays and names only, so that it imports no matplotlib."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeVar

import numpy as np

from tedm_cli.arrays import BoolArray, FloatArray, IntArray

T = TypeVar("T")

SUPERSCRIPT = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
REALISATION_CONFIDENCE = 0.95  # of the intervals drawn around estimates from realisations
SILENCED, MATCHED = "silenced", "matched"
#: What can be done to areas: as a verb, and as a word.
WAYS = {
    SILENCED: ("silencing", "silent"),
    "quieter": ("a tenth of the noise in", "at a tenth"),
    MATCHED: ("one common temperature of", "matched"),
}
QUANTITY = {
    "acceleration": "self-gravity acceleration",
    "angular_acceleration": "self-gravity angular acceleration",
    "displacement": "read-out displacement",
    "angle": "read-out angle",
}


@dataclass(frozen=True, eq=False)
class Limit:
    """A requirement: `amplitude` [F] in `unit` per √Hz, NaN outside `band_hz`; `source` says who asks for it."""

    name: str
    source: str
    unit: str
    band_hz: tuple[float, float]
    amplitude: FloatArray


@dataclass(frozen=True, eq=False)
class Mending:
    """What would bring one ratio down.

    Parameters
    ----------
    count : [c], numbers of areas improved, or of blocks matched.
    ratio : by what is done to them (a key of `WAYS`), the ratio [c] with each number of them.
    chosen : by the same, names of the areas (of blocks, where areas are matched) in the order they are chosen, without
        those that bring no relief.
    group_factor : by group, the factor on its temperatures that just meets the requirement; infinite where the output
        does not feel it, NaN where this group alone cannot do it.
    group_level : by group, its temperature ASD at the binding frequency, K/√Hz; NaN where its areas differ.
    all_factor : `group_factor` of all groups together.
    """

    count: IntArray
    ratio: dict[str, FloatArray]
    chosen: dict[str, list[str]]
    group_factor: dict[str, float]
    group_level: dict[str, float]
    all_factor: float


@dataclass(frozen=True, eq=False)
class Spectrum:
    """An estimated amplitude spectral density [F], unit/√Hz or a ratio, and the ends of its interval of confidence."""

    frequency_hz: FloatArray
    asd: FloatArray
    low: FloatArray
    high: FloatArray


@dataclass(frozen=True, eq=False)
class JudgedOutput:
    """One output of one case against one requirement.

    Parameters
    ----------
    output, kind, unit, requirement : names; `unit` before "per √Hz".
    ratio : largest safety factor × noise / limit; binding_hz : where; passed : ratio <= 1.
    asd : [F], amplitude spectral density without the safety factor, unit/√Hz.
    bound_low, bound_high : [F], the same over all correlations of the case's active areas.
    bound_ratio : `ratio` at each of the five bounds, by name as in the case files.
    distortion_ratio : `ratio` if the bench did not move as one; None for what is no read-out.
    filter_ratio : [orders, corners], `ratio` with other temperature filters; None where there is no low-pass.
    contribution_hz : frequency of `contribution` and `share`; band_hz : of `band_share`.
    contribution : [k], signed sensitivity × temperature of each area, unit/√Hz.
    share, band_share : [k], each area's part of the power; negative where it cancels others.
    path, path_band : the same parts by optical element; None for what is no read-out.
    mending : what would bring the ratio down.
    realised : estimate from a realisation with its 95 % interval, over the exact spectrum; None where there is none.
    """

    output: str
    kind: str
    unit: str
    requirement: str
    ratio: float
    binding_hz: float
    passed: bool
    asd: FloatArray
    bound_low: FloatArray
    bound_high: FloatArray
    bound_ratio: dict[str, float]
    distortion_ratio: float | None
    filter_ratio: FloatArray | None
    contribution_hz: float
    band_hz: tuple[float, float]
    contribution: FloatArray
    share: FloatArray
    band_share: FloatArray
    path: dict[str, float] | None
    path_band: dict[str, float] | None
    mending: Mending
    realised: Spectrum | None

    @property
    def correlation_ratio(self) -> tuple[float, float]:
        """Smallest and largest `ratio` over all correlations of the active areas."""
        return self.bound_ratio["minimum"], self.bound_ratio["maximum"]


@dataclass(frozen=True, eq=False)
class CaseNoise:
    """One correlation case: its setting, judged outputs, and the limits they were judged by.

    `role` is likely, possible or diagnostic; `reason` says why the case is there, empty where nothing is said.
    `block` is [k], the correlated block of each area, -1 for silent ones. `filter_order` and
    `filter_corner_hz` are the axes of each `filter_ratio`, empty where there is no low-pass.
    """

    id: str
    title: str
    role: str
    reason: str
    safety_factor: float
    temperature: str
    block: IntArray
    frequency_hz: FloatArray
    judged: tuple[JudgedOutput, ...]
    limits: tuple[Limit, ...]
    filter_order: FloatArray
    filter_corner_hz: FloatArray

    @property
    def active(self) -> BoolArray:
        """Areas [k] that are not silent."""
        return self.block >= 0

    @property
    def blocks(self) -> int:
        """Number of correlated blocks."""
        return int(self.block.max()) + 1

    def of_kind(self, kind: str) -> list[JudgedOutput]:
        """Judged outputs of one quantity."""
        return [j for j in self.judged if j.kind == kind]

    def limits_of(self, kind: str) -> list[Limit]:
        """Limits that judge outputs of one quantity."""
        names = {j.requirement for j in self.of_kind(kind)}
        return [q for q in self.limits if q.name in names]

    def worst(self, kind: str) -> JudgedOutput:
        """The judged output of one quantity with the largest ratio."""
        return first_largest(self.of_kind(kind), [j.ratio for j in self.of_kind(kind)])


@dataclass(frozen=True, eq=False)
class SeriesOutput:
    """One output of a time series.

    Parameters
    ----------
    output, kind, unit : names; rms : in `unit`.
    time_s, low, high : [b], smallest and largest value of the samples around each time.
    spectrum : estimate with its interval, without the safety factor.
    limit_hz, limits : those that judge it, and the frequencies they are given at.
    verdict : requirement, ratio, its frequency (Hz), whether it is met, of the worst; None where it is not judged.
    """

    output: str
    kind: str
    unit: str
    rms: float
    time_s: FloatArray
    low: FloatArray
    high: FloatArray
    spectrum: Spectrum
    limit_hz: FloatArray
    limits: tuple[Limit, ...]
    verdict: tuple[str, float, float, bool] | None


@dataclass(frozen=True, eq=False)
class SeriesNoise:
    """What became of a temperature series: the output of each quantity that is worst."""

    source: str
    treatment: str
    safety_factor: float
    confidence: float
    outputs: tuple[SeriesOutput, ...]


@dataclass(frozen=True)
class RestVerdict:
    """One quantity of one subsystem on one test mass: value over the end of its range; subsystem in words."""

    test_mass: str
    quantity: str
    subsystem: str
    ratio: float
    passed: bool


@dataclass(frozen=True, eq=False)
class Areas:
    """Names, groups and shields of the k thermal areas, in the order of every array over areas."""

    name: list[str]
    group: list[str]
    shield: list[str]

    def by_group(self) -> IntArray:
        """Order of the areas with groups together: groups as they first appear, areas by name inside."""
        first = list(dict.fromkeys(self.group))
        return np.array(sorted(range(len(self.name)), key=lambda i: (first.index(self.group[i]), self.name[i])))


@dataclass(frozen=True, eq=False)
class TemperatureSpectra:
    """Distinct temperature spectra `asd` [q, F] in K/√Hz, and in words which areas have each."""

    frequency_hz: FloatArray
    asd: FloatArray
    name: list[str]


@dataclass(frozen=True, eq=False)
class AreaMap:
    """|value| [rows, k] of outputs per kelvin of each area; one panel of a map, so all rows share one unit."""

    title: str
    unit: str
    labels: list[str]
    value: FloatArray


def kinds_of(cases: Sequence[CaseNoise]) -> list[str]:
    """Quantities that are judged in any of the cases, in the order of the requirements."""
    return list(dict.fromkeys(j.kind for c in cases for j in c.judged))


def quantity(kind: str, outputs: Sequence[str]) -> str:
    """Title of a family of outputs; names the axis where they share one, as TM1_a_x and TM2_a_x do."""
    axes = {o.rsplit("_", 1)[-1] for o in outputs}
    axis = axes.pop() if len(axes) == 1 else ""
    along = "about" if "ang" in kind else "along"
    text = QUANTITY.get(kind, kind)
    return f"{text} {along} {axis}" if axis in ("x", "y", "z") else text


def first_largest(items: Sequence[T], values: Sequence[float]) -> T:
    """The first of the items whose value is largest; symmetric models tie up to rounding, which must not choose."""
    return items[next(i for i, v in enumerate(values) if v >= max(values) * (1 - 1e-9))]


def ratio_text(ratio: float) -> str:
    """A ratio with three digits, and with more where three would hide on which side of 1 it lies."""
    if ratio == 0.0:
        return "0"
    if ratio >= 1e3:
        return f"{ratio:.0f}" if ratio < 1e6 else power_text(ratio, 3)
    for digits in (3, 5, 8, 12):
        text = f"{ratio:#.{digits}g}".removesuffix(".")
        if float(text) != 1.0 or ratio == 1.0:
            return text
    return f"{ratio!r}"


def number_text(value: float) -> str:
    """About three digits, for a narrow cell."""
    size = abs(value)
    digits = 0 if size >= 100 else 1 if size >= 10 else 2 if size >= 1 else 3
    text = f"{value:.{digits}f}"
    return "0" if float(text) == 0.0 else text.replace("-", "−")


def capital(text: str) -> str:
    return text[:1].upper() + text[1:]


def shortened(text: str, most: int) -> str:
    """A text of at most `most` characters, with an ellipsis in the middle of what is longer: ends tell names apart."""
    if len(text) <= most:
        return text
    head = (most - 1) // 2
    return f"{text[:head].rstrip()}…{text[len(text) - (most - 1 - head) :].lstrip()}"


def power_text(value: float, digits: int = 2) -> str:
    """A positive number as 2.4 × 10⁻¹³, plain where it is of everyday size."""
    if 0.01 <= value < 1e4:
        return f"{value:.{digits}g}" if value < 10**digits else f"{value:.0f}"
    mantissa, exponent = f"{value:.{digits - 1}e}".split("e")
    return f"{mantissa} × 10{str(int(exponent)).translate(SUPERSCRIPT)}"


def mhz_text(frequency_hz: float) -> str:
    return f"{frequency_hz * 1e3:.3g} mHz"


def unit_text(unit: str) -> str:
    """A unit with its powers raised: `1/(m s^2)` to 1/(m s²)."""
    return re.sub(r"\^(-?\d+)", lambda m: m[1].translate(SUPERSCRIPT), unit)
