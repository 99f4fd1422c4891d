"""The noise of correlation cases as their files tell it: spectra, verdicts, limits, and what they are made of."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from tedm_cli.arrays import BoolArray, FloatArray, IntArray
from tedm_cli.noise.areas import AreaTable, unit_of_group
from tedm_cli.noise.spectral_estimate import Estimate
from tedm_cli.results.ranking import all_largest, first_largest
from tedm_cli.results.thermal.comparison import Comparison
from tedm_cli.results.titles import requirement_title
from tedm_cli.uncertainty.verdicts import CaseUncertainty

REALISATION_CONFIDENCE = 0.95  # of the intervals drawn around estimates from realisations
SILENCED, QUIETER, MATCHED = "silenced", "quieter", "matched"
#: What temperatures that are of the thermal network begin with, in words.
NETWORK = "thermal network"
#: What can be done to areas: as a verb, and as a word.
WAYS = {
    SILENCED: ("silencing", "silent"),
    QUIETER: ("a tenth of the noise in", "at a tenth"),
    MATCHED: ("one common temperature of", "matched"),
}


@dataclass(frozen=True, eq=False)
class Limit:
    """A requirement: `amplitude` [F] in `unit` per √Hz, NaN outside `band_hz`; `source` says who asks for it.

    `title` is its own in the configuration, or empty.
    """

    name: str
    source: str
    unit: str
    band_hz: tuple[float, float]
    amplitude: FloatArray
    title: str = ""

    @property
    def plain(self) -> str:
        """What readers are told it is."""
        return self.title or requirement_title(self.name, {})


def titled(limits: Sequence[Limit], titles: Mapping[str, str]) -> tuple[Limit, ...]:
    """The limits with their titles, by name; those without keep what they have."""
    return tuple(replace(limit, title=titles.get(limit.name, limit.title)) for limit in limits)


def limit_named(limits: Sequence[Limit], name: str) -> Limit:
    """The one of that name."""
    return next(limit for limit in limits if limit.name == name)


@dataclass(frozen=True, eq=False)
class NamedImprovement:
    """What would bring one ratio down: `noise.improvement.Improvement` with names in place of rows of the areas.

    Parameters
    ----------
    count : [c], numbers of areas improved, or of blocks matched.
    ratio : by what is done to them (a key of `WAYS`), the ratio [c] with each number of them.
    chosen : by the same, names of the areas (of blocks, where areas are matched) in the order they are chosen, without
        those that bring no relief.
    group_factor : by group, the factor on its temperatures that just meets the requirement; infinite where the output
        does not feel it, NaN where this group alone cannot do it.
    group_level : by group, its temperature ASD at the binding frequency, K/√Hz, or K/m/√Hz of a group of gradients; NaN
        where its areas differ.
    all_factor : `group_factor` of all groups together.
    """

    count: IntArray
    ratio: dict[str, FloatArray]
    chosen: dict[str, list[str]]
    group_factor: dict[str, float]
    group_level: dict[str, float]
    all_factor: float

    def enough(self, way: str) -> int:
        """The smallest number of areas, or blocks, that meets the requirement; 0 where none that was tried does."""
        chosen = len(self.chosen[way])
        tried = zip(self.count.tolist(), self.ratio[way].tolist(), strict=True)
        return next((min(n, chosen) for n, ratio in tried if ratio <= 1.0), 0)

    def after(self, way: str, n: int) -> float:
        """The ratio with `n` areas, or blocks, of those chosen: as many as were tried, or all that help."""
        chosen = len(self.chosen[way])
        return float(self.ratio[way][[min(k, chosen) for k in self.count.tolist()].index(n)])


@dataclass(frozen=True, eq=False)
class Spectrum:
    """An estimated amplitude spectral density [F], unit/√Hz or a ratio, and the ends of its interval of confidence."""

    frequency_hz: FloatArray
    asd: FloatArray
    low: FloatArray
    high: FloatArray


@dataclass(frozen=True, eq=False)
class JudgedDisturbances:
    """Of one verdict the u disturbances: `names`; share, band_share, level_factor : [u], asd : [u, F], see the case
    file."""

    names: tuple[str, ...]
    share: FloatArray
    band_share: FloatArray
    level_factor: FloatArray
    asd: FloatArray


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
    improvement : what would bring the ratio down.
    realised : estimate from a realisation with its 95 % interval, over the exact spectrum; None where there is none.
    disturbances : of the thermal network; None of a case of areas.
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
    improvement: NamedImprovement
    realised: Spectrum | None
    disturbances: JudgedDisturbances | None = None

    @property
    def correlation_ratio(self) -> tuple[float, float]:
        """Smallest and largest `ratio` over all correlations of the active areas."""
        return self.bound_ratio["minimum"], self.bound_ratio["maximum"]


@dataclass(frozen=True, eq=False)
class CaseNoise:
    """One correlation case: its setting, judged outputs, and the limits they were judged by.

    `areas` are its k areas: those of the model, and behind them gradients within areas where the case has any. `role`
    is likely, possible or diagnostic; `reason` says why the case is there, empty where nothing is said.
    `block` is [k], the correlated block of each area, -1 for silent ones. `filter_order` and
    `filter_corner_hz` are the axes of each `filter_ratio`, empty where there is no low-pass. `uncertainty` says how
    sure the verdicts are; None where nothing is configured to be uncertain. `thermal`: the temperatures are those
    of the thermal network, and `areas` its nodes, and behind them areas that its map leaves out. `comparison`: then,
    these temperatures beside those of the assumed cases.
    """

    id: str
    title: str
    role: str
    reason: str
    safety_factor: float
    temperature: str
    areas: AreaTable
    block: IntArray
    frequency_hz: FloatArray
    judged: tuple[JudgedOutput, ...]
    limits: tuple[Limit, ...]
    filter_order: FloatArray
    filter_corner_hz: FloatArray
    uncertainty: CaseUncertainty | None = None
    thermal: bool = False
    comparison: Comparison | None = None

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

    @property
    def limit_names(self) -> list[str]:
        """Names of all limits."""
        return [limit.name for limit in self.limits]

    def limits_of(self, kind: str) -> list[Limit]:
        """Limits that judge outputs of one quantity."""
        names = {j.requirement for j in self.of_kind(kind)}
        return [q for q in self.limits if q.name in names]

    def worst(self, kind: str) -> JudgedOutput:
        """The judged output of one quantity with the largest ratio."""
        return first_largest(self.of_kind(kind), [j.ratio for j in self.of_kind(kind)])

    def worst_outputs(self, kind: str) -> list[str]:
        """Names of all outputs of one quantity with the largest ratio: redundant read-outs tie, and so may others."""
        judged = self.of_kind(kind)
        return list(dict.fromkeys(j.output for j in all_largest(judged, [j.ratio for j in judged])))


@dataclass(frozen=True, eq=False)
class TemperatureSpectra:
    """Distinct temperature spectra `asd` [q, F], in words which areas have each, and its unit before "per √Hz": K of
    mean temperatures, K/m of gradients."""

    frequency_hz: FloatArray
    asd: FloatArray
    name: list[str]
    unit: list[str]


def temperature_words(of_case: Mapping[str, str]) -> str:
    """Levels and shapes of the temperatures by case, told once.

    Those with gradients within areas have more of them, those of the thermal network other ones.
    """
    every = list(of_case.values())
    common = min((w for w in every if not w.startswith(NETWORK)), key=len, default=every[0])
    said = [
        f"in case {i} also {words.removeprefix(f'{common}; ')}" if words.startswith(common) else f"in case {i}: {words}"
        for i, words in of_case.items()
        if words != common
    ]
    return "; ".join([common, *said])


def level_unit(groups: Iterable[str]) -> str:
    """Unit of the levels of groups, as heads of tables say it: of gradients it is another."""
    units = dict.fromkeys(sorted(unit_of_group(group) for group in groups))
    return ", gradients ".join(f"{unit}/√Hz" for unit in units) if "K" in units else "K/m/√Hz"


def kinds_of(cases: Sequence[CaseNoise]) -> list[str]:
    """Quantities that are judged in any of the cases, in the order of the requirements."""
    return list(dict.fromkeys(j.kind for c in cases for j in c.judged))


def spectra_of(estimate: Estimate, confidence: float) -> list[Spectrum]:
    """Amplitude spectral densities of all series of an estimate, with intervals."""
    low, high = estimate.interval(confidence)
    return [Spectrum(estimate.frequency_hz, np.sqrt(p), np.sqrt(p * low), np.sqrt(p * high)) for p in estimate.psd]
