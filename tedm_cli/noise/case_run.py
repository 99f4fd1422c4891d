"""One correlation case, end to end: noise of every output, its bounds, verdicts and contributors."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tedm_cli.errors import ConfigError, InputError
from tedm_cli.noise.areas import AreaTable
from tedm_cli.noise.bounds import BOUNDS, Bounds, correlation_bounds, extremal_block_vectors, extremal_vectors
from tedm_cli.noise.contributions import amplitude_contributions, path_shares, shares_at, shares_over, sum_by
from tedm_cli.noise.correlation import Correlation, CorrelationCase, correlation
from tedm_cli.noise.differences import terms
from tedm_cli.noise.filter_sensitivity import FilterSensitivity, filter_sensitivity
from tedm_cli.noise.improvement import Improvement, improvement
from tedm_cli.noise.propagation import output_psd_from_factor
from tedm_cli.noise.requirements import (
    REFERENCE_HZ,
    UNITS,
    AppliedRequirement,
    Requirement,
    Verdict,
    in_band,
    judge,
    mismatches,
)
from tedm_cli.noise.selection import Indices
from tedm_cli.noise.temperature import TemperatureModel

Array = NDArray[np.float64]
Judged = Sequence[tuple[Requirement, int]]


@dataclass(frozen=True, eq=False)
class Contributions:
    """Where the noise of n_out outputs comes from. Shares of an output sum to 1, or are 0 where it has no noise.

    Parameters
    ----------
    frequency_hz : [n_out], the binding frequency of the worst verdict, 1 mHz for an output without one.
    amplitude : [n_out, k], signed amplitudes there, unit/√Hz, zero for silent areas.
    share : [n_out, k], each area's part of the PSD there.
    band_hz : [n_out, 2], band of the worst verdict, all frequencies for an output without one.
    band_share : [n_out, k], each area's part of the power in that band.
    path_names : [p]; path_share, path_band_share : by label of an output that is a sum over these paths, the same.
    extremal : for each of `BOUNDS`, V [n_out, k, 2] whose V_i · V_j is a correlation that reaches it at `frequency_hz`
        (for known blocks: between areas of different blocks); zero for silent areas.
    """

    frequency_hz: Array
    amplitude: Array
    share: Array
    band_hz: Array
    band_share: Array
    path_names: tuple[str, ...]
    path_share: dict[str, Array]
    path_band_share: dict[str, Array]
    extremal: dict[str, Array]

    def by(self, labels: NDArray[Any]) -> tuple[NDArray[Any], Array, Array]:
        """Distinct labels [q] of areas with `labels` [k], and sums [n_out, q] of share and of band_share over them."""
        names, share = sum_by(self.share, labels)
        return names, share, sum_by(self.band_share, labels)[1]


@dataclass(frozen=True, eq=False)
class CaseResult:
    """Noise of n_out outputs in one correlation case. PSDs are one-sided and without the safety factor.

    Parameters
    ----------
    case, areas : the case and its areas; correlation : what the case makes of them.
    labels, kinds, units : [n_out], of the outputs; units before "per √Hz".
    frequency_hz : [F].
    temperature : the model; temperature_set : [k], which spectrum of temperature_asd [q, F], K/√Hz, each area has.
    psd : [n_out, F], unit²/Hz; bounds : what other correlations of the active areas would give.
    verdicts : in the order of the requirements and their outputs; safety_factor : on amplitudes, in verdicts only.
    bound_ratio : [verdicts, 5], the ratio each of `BOUNDS` would have.
    filter_sensitivity : verdict ratios for other orders and corners; None where no spectrum is low-pass.
    improvements : of each verdict; groups : [G], of their group_factor.
    contributions : where the noise comes from.
    """

    case: CorrelationCase
    areas: AreaTable
    correlation: Correlation
    labels: tuple[str, ...]
    kinds: tuple[str, ...]
    units: tuple[str, ...]
    frequency_hz: Array
    temperature: TemperatureModel
    temperature_set: Indices
    temperature_asd: Array
    psd: Array
    bounds: Bounds
    verdicts: tuple[Verdict, ...]
    safety_factor: float
    bound_ratio: Array
    filter_sensitivity: FilterSensitivity | None
    improvements: tuple[Improvement, ...]
    groups: tuple[str, ...]
    contributions: Contributions = field(repr=False)

    @property
    def blocks(self) -> tuple[Indices, ...]:
        """Column indices of each block."""
        return self.correlation.blocks

    @property
    def active(self) -> NDArray[np.bool_]:
        """Areas [k] in a block."""
        return self.correlation.active


def run_case(
    case: CorrelationCase,
    areas: AreaTable,
    temperature: TemperatureModel,
    rows: Array,
    labels: Sequence[str],
    kinds: Sequence[str],
    frequency_hz: Array,
    requirements: Sequence[AppliedRequirement] = (),
    safety_factor: float = 1.0,
    paths: Mapping[str, Array] | None = None,
    path_names: Sequence[str] = (),
) -> CaseResult:
    """Noise of outputs with sensitivities `rows` [n_out, k], in their unit per kelvin, in one correlation case.

    Parameters
    ----------
    labels, kinds : [n_out], name and quantity (a key of `UNITS`) of each output.
    frequency_hz : [F], increasing, with the band edges of the requirements (see `frequency_grid`).
    requirements : which outputs to judge by what.
    safety_factor : multiplies noise amplitudes in verdicts (Montemurro 2004, section 3.5, recommends 2).
    paths : by label, the rows [p, k] that an output is the sum of; path_names : [p].

    Raises
    ------
    ConfigError : the case does not fit the areas; a requirement names an unknown output, one of another quantity, a
        difference where it limits a single test mass, or a band outside the frequencies. All of a sort at once.
    PhysicsError : the matrix of the case is none of a correlation.
    InputError : the shapes disagree, or a sensitivity is not finite.
    """
    _check_rows(rows, labels, kinds, areas)
    judged = _judged(requirements, labels, kinds, frequency_hz)
    found = correlation(case, areas)
    psd = output_psd_from_factor(rows, temperature, found.factor, frequency_hz, found.delay_s)
    bounds = correlation_bounds(rows, temperature, found, frequency_hz)
    verdicts = [
        judge(np.sqrt(psd[o]), frequency_hz, requirement, safety_factor, kind=kinds[o], output=labels[o])
        for requirement, o in judged
    ]
    groups = tuple(dict.fromkeys(areas.group[found.active].tolist()))
    masks = [areas.group == group for group in groups]
    improvements = []
    for (requirement, o), verdict in zip(judged, verdicts, strict=True):
        f = frequency_hz[in_band(requirement, frequency_hz)]
        limit = requirement.amplitude(f) / safety_factor
        binding = int(np.searchsorted(f, verdict.binding_hz))
        improvements.append(improvement(rows[o], temperature, found, f, binding, limit, masks))
    temperature_set, temperature_asd = temperature.distinct(frequency_hz)
    return CaseResult(
        case=case,
        areas=areas,
        correlation=found,
        labels=tuple(labels),
        kinds=tuple(kinds),
        units=tuple(UNITS[kind] for kind in kinds),
        frequency_hz=frequency_hz,
        temperature=temperature,
        temperature_set=temperature_set,
        temperature_asd=temperature_asd,
        psd=psd,
        bounds=bounds,
        verdicts=tuple(verdicts),
        safety_factor=safety_factor,
        bound_ratio=_bound_ratios(bounds, frequency_hz, judged, safety_factor),
        filter_sensitivity=filter_sensitivity(rows, temperature, found, frequency_hz, judged, safety_factor),
        improvements=tuple(improvements),
        groups=groups,
        contributions=_contributions(
            rows, labels, temperature, found, frequency_hz, judged, verdicts, paths or {}, path_names
        ),
    )


def _bound_ratios(bounds: Bounds, frequency_hz: Array, judged: Judged, safety_factor: float) -> Array:
    """Ratio [verdicts, 5] to the requirement of each of `BOUNDS`."""
    ratio = np.empty((len(judged), len(BOUNDS)))
    for v, (requirement, o) in enumerate(judged):
        inside = in_band(requirement, frequency_hz)
        limit = requirement.amplitude(frequency_hz[inside])
        for b, name in enumerate(BOUNDS):
            ratio[v, b] = (safety_factor * np.sqrt(getattr(bounds, name)[o, inside]) / limit).max()
    return ratio


def _contributions(
    rows: Array,
    labels: Sequence[str],
    temperature: TemperatureModel,
    found: Correlation,
    frequency_hz: Array,
    judged: Judged,
    verdicts: Sequence[Verdict],
    paths: Mapping[str, Array],
    path_names: Sequence[str],
) -> Contributions:
    at_hz = np.full(len(rows), REFERENCE_HZ)
    band_hz = np.tile(frequency_hz[[0, -1]], (len(rows), 1))
    inside = np.ones((len(rows), len(frequency_hz)), dtype=bool)
    worst = np.full(len(rows), -1.0)
    for (requirement, o), verdict in zip(judged, verdicts, strict=True):
        if verdict.ratio > worst[o]:
            worst[o], at_hz[o], band_hz[o] = verdict.ratio, verdict.binding_hz, requirement.band_hz
            inside[o] = in_band(requirement, frequency_hz)
    share, band_share = np.empty_like(rows), np.empty_like(rows)
    for o in range(len(rows)):
        share[o] = shares_at(rows[o : o + 1], temperature, found, at_hz[o])[0]
        band_share[o] = shares_over(rows[o : o + 1], temperature, found, frequency_hz[inside[o]])[0]
    amplitude = amplitude_contributions(rows, temperature, at_hz) * found.active
    place = {label: o for o, label in enumerate(labels) if label in paths}
    extremal = {
        name: np.stack([extremal_vectors(h, name) for h in amplitude])
        for name in ("minimum", "maximum_non_negative", "maximum")
    }
    for name, smallest in (("known_blocks_minimum", True), ("known_blocks", False)):
        extremal[name] = np.stack(
            [
                extremal_block_vectors(h, found, f, smallest=smallest)
                for h, f in zip(amplitude, at_hz.tolist(), strict=True)
            ]
        )
    return Contributions(
        frequency_hz=at_hz,
        amplitude=amplitude,
        share=share,
        band_hz=band_hz,
        band_share=band_share,
        path_names=tuple(path_names),
        path_share={
            label: path_shares(paths[label], temperature, found, at_hz[o : o + 1]) for label, o in place.items()
        },
        path_band_share={
            label: path_shares(paths[label], temperature, found, frequency_hz[inside[o]]) for label, o in place.items()
        },
        extremal=extremal,
    )


def _check_rows(rows: Array, labels: Sequence[str], kinds: Sequence[str], areas: AreaTable) -> None:
    if rows.shape != (len(labels), len(areas)) or len(kinds) != len(labels):
        fact = f"{rows.shape} for {len(labels)} labels, {len(kinds)} quantities and {len(areas)} thermal areas"
        raise InputError(f"sensitivities have shape {fact}", where="noise")
    bad = np.flatnonzero(~np.isfinite(rows).all(axis=1))
    if bad.size:
        raise InputError(f"the sensitivity of {labels[bad[0]]} has values that are not finite", where="noise")
    unknown = sorted(set(kinds) - UNITS.keys())
    if unknown:
        raise InputError(f"quantity {unknown[0]!r}; known: {', '.join(UNITS)}", where="noise")


def _judged(
    requirements: Sequence[AppliedRequirement], labels: Sequence[str], kinds: Sequence[str], frequency_hz: Array
) -> list[tuple[Requirement, int]]:
    """(requirement, index of output) of every verdict to be."""
    problems: list[tuple[str, str]] = []
    judged: list[tuple[Requirement, int]] = []
    for number, applied in enumerate(requirements):
        for label in applied.outputs:
            path = f"requirement[{number}].outputs"
            if label not in labels:
                problems.append((path, f"there is no output {label!r}; there are: {', '.join(labels)}"))
                continue
            o = list(labels).index(label)
            facts = mismatches(applied.requirement, kinds[o], frequency_hz)
            of = "single" if terms(label) is None else "differential"
            if applied.requirement.applies_to != of:
                fact = f"is for {applied.requirement.applies_to} outputs; set applies_to = {of!r} if it is for this one"
                facts.append(fact)
            problems += [(path, f"{label}: {applied.requirement.name} {fact}") for fact in facts]
            judged.append((applied.requirement, o))
    if problems:
        raise ConfigError(problems, where="requirements")
    return judged
