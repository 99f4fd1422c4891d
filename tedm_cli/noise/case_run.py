"""One correlation case, end to end: noise of every output, its bounds, verdicts and contributors."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from tedm_cli.arrays import BoolArray, FloatArray, IndexArray
from tedm_cli.errors import ConfigError, InputError
from tedm_cli.noise.areas import AreaTable
from tedm_cli.noise.bounds import BOUNDS, Bounds, correlation_bounds
from tedm_cli.noise.case_contributions import Contributions, Judged, contributions
from tedm_cli.noise.contributions import ReadOutParts
from tedm_cli.noise.correlation import Correlation, CorrelationCase, correlation
from tedm_cli.noise.differences import no_output, terms
from tedm_cli.noise.filter_sensitivity import FilterSensitivity, filter_sensitivity
from tedm_cli.noise.improvement import Improvement, improvement
from tedm_cli.noise.propagation import output_psd_from_factor
from tedm_cli.noise.requirements import (
    UNITS,
    AppliedRequirement,
    Requirement,
    Verdict,
    in_band,
    judge,
    mismatches,
)
from tedm_cli.noise.temperature import TemperatureModel


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
    distortion_ratio : [verdicts], the ratio of a read-out if the bench did not move as one; NaN for other outputs.
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
    frequency_hz: FloatArray
    temperature: TemperatureModel
    temperature_set: IndexArray
    temperature_asd: FloatArray
    psd: FloatArray
    bounds: Bounds
    verdicts: tuple[Verdict, ...]
    safety_factor: float
    bound_ratio: FloatArray
    distortion_ratio: FloatArray
    filter_sensitivity: FilterSensitivity | None
    improvements: tuple[Improvement, ...]
    groups: tuple[str, ...]
    contributions: Contributions = field(repr=False)

    @property
    def blocks(self) -> tuple[IndexArray, ...]:
        """Column indices of each block."""
        return self.correlation.blocks

    @property
    def active(self) -> BoolArray:
        """Areas [k] in a block."""
        return self.correlation.active


def run_case(
    case: CorrelationCase,
    areas: AreaTable,
    temperature: TemperatureModel,
    rows: FloatArray,
    labels: Sequence[str],
    kinds: Sequence[str],
    frequency_hz: FloatArray,
    requirements: Sequence[AppliedRequirement] = (),
    safety_factor: float = 1.0,
    parts_of_read_outs: Mapping[str, ReadOutParts] | None = None,
    found: Correlation | None = None,
) -> CaseResult:
    """Noise of outputs with sensitivities `rows` [n_out, k], in their unit per kelvin, in one correlation case.

    Parameters
    ----------
    labels, kinds : [n_out], name and quantity (a key of `UNITS`) of each output.
    frequency_hz : [F], increasing, with the band edges of the requirements (see `frequency_grid`).
    requirements : which outputs to judge by what.
    safety_factor : multiplies noise amplitudes in verdicts (Montemurro 2004, section 3.5, recommends 2).
    parts_of_read_outs : by label, what read-outs are made of.
    found : the correlation of the case, where it has been found already.

    Raises
    ------
    ConfigError : the case does not fit the areas; a requirement names an unknown output, one of another quantity, a
        difference where it limits a single test mass, or a band outside the frequencies. All of a sort at once.
    PhysicsError : the matrix of the case is none of a correlation.
    InputError : the shapes disagree, or a sensitivity is not finite.
    """
    _check_rows(rows, labels, kinds, areas)
    judged = judged_outputs(requirements, labels, kinds, frequency_hz)
    found = correlation(case, areas) if found is None else found
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
        distortion_ratio=_distortion_ratios(
            parts_of_read_outs or {}, labels, temperature, found, frequency_hz, judged, safety_factor
        ),
        filter_sensitivity=filter_sensitivity(rows, temperature, found, frequency_hz, judged, safety_factor),
        improvements=tuple(improvements),
        groups=groups,
        contributions=contributions(
            rows, labels, temperature, found, frequency_hz, judged, verdicts, parts_of_read_outs or {}
        ),
    )


def _bound_ratios(bounds: Bounds, frequency_hz: FloatArray, judged: Judged, safety_factor: float) -> FloatArray:
    """Ratio [verdicts, 5] to the requirement of each of `BOUNDS`."""
    ratio = np.empty((len(judged), len(BOUNDS)))
    for v, (requirement, o) in enumerate(judged):
        inside = in_band(requirement, frequency_hz)
        limit = requirement.amplitude(frequency_hz[inside])
        for b, name in enumerate(BOUNDS):
            ratio[v, b] = (safety_factor * np.sqrt(getattr(bounds, name)[o, inside]) / limit).max()
    return ratio


def _distortion_ratios(
    parts_of_read_outs: Mapping[str, ReadOutParts],
    labels: Sequence[str],
    temperature: TemperatureModel,
    found: Correlation,
    frequency_hz: FloatArray,
    judged: Judged,
    safety_factor: float,
) -> FloatArray:
    """Ratio [verdicts] of the read-outs without the motion of the bench as one."""
    ratio = np.full(len(judged), np.nan)
    for v, (requirement, o) in enumerate(judged):
        if labels[o] in parts_of_read_outs:
            f = frequency_hz[in_band(requirement, frequency_hz)]
            psd = output_psd_from_factor(
                parts_of_read_outs[labels[o]].distortion[None], temperature, found.factor, f, found.delay_s
            )[0]
            ratio[v] = (safety_factor * np.sqrt(psd) / requirement.amplitude(f)).max()
    return ratio


def _check_rows(rows: FloatArray, labels: Sequence[str], kinds: Sequence[str], areas: AreaTable) -> None:
    if rows.shape != (len(labels), len(areas)) or len(kinds) != len(labels):
        fact = f"{rows.shape} for {len(labels)} labels, {len(kinds)} quantities and {len(areas)} thermal areas"
        raise InputError(f"sensitivities have shape {fact}", where="noise")
    bad = np.flatnonzero(~np.isfinite(rows).all(axis=1))
    if bad.size:
        raise InputError(f"the sensitivity of {labels[bad[0]]} has values that are not finite", where="noise")
    unknown = sorted(set(kinds) - UNITS.keys())
    if unknown:
        raise InputError(f"quantity {unknown[0]!r}; known: {', '.join(UNITS)}", where="noise")


def judged_outputs(
    requirements: Sequence[AppliedRequirement], labels: Sequence[str], kinds: Sequence[str], frequency_hz: FloatArray
) -> list[tuple[Requirement, int]]:
    """(requirement, index of output) of every verdict to be; `ConfigError` as `run_case` raises it."""
    problems: list[tuple[str, str]] = []
    judged: list[tuple[Requirement, int]] = []
    for number, applied in enumerate(requirements):
        for label in applied.outputs:
            path = f"requirement[{number}].outputs"
            if label not in labels:
                problems.append((path, no_output(label, labels)))
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
