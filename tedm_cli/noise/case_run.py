"""One correlation case, end to end: noise of every output, its bounds, verdicts and contributors."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from tedm_cli.arrays import BoolArray, FloatArray, IndexArray
from tedm_cli.errors import ConfigError
from tedm_cli.noise.areas import AreaTable
from tedm_cli.noise.bounds import BOUNDS, Bounds, correlation_bounds
from tedm_cli.noise.case_contributions import Contributions, Judged, contributions
from tedm_cli.noise.correlation import Correlation, CorrelationCase, correlation
from tedm_cli.noise.differences import no_output, terms
from tedm_cli.noise.disturbances import DisturbanceContributions, disturbance_contributions
from tedm_cli.noise.filter_sensitivity import FilterSensitivity, filter_sensitivity
from tedm_cli.noise.improvement import Improvement, improvement
from tedm_cli.noise.network import NetworkOutputs
from tedm_cli.noise.outputs import Outputs
from tedm_cli.noise.propagation import OutputNoise, TemperatureNoise
from tedm_cli.noise.requirements import Criteria, Requirement, Verdict, in_band, judge, mismatches
from tedm_cli.noise.sources import AnyNoise, AnySource
from tedm_cli.noise.temperature import TemperatureModel


@dataclass(frozen=True, eq=False)
class CaseResult:
    """Noise of n_out outputs in one correlation case. PSDs are one-sided and without the safety factor.

    Parameters
    ----------
    case : of correlation.
    outputs : with their thermal areas, labels, quantities and units (before "per √Hz").
    source : the noise of the temperatures: their model, and the correlation that the case makes of the areas.
    frequency_hz : [F].
    temperature_set : [k], which spectrum of temperature_asd [q, F] each area has, K/√Hz or of gradients K/m/√Hz.
    psd : [n_out, F], unit²/Hz; bounds : what other correlations of the active areas would give.
    verdicts : in the order of the requirements and their outputs; safety_factor : on amplitudes, in verdicts only.
    bound_ratio : [verdicts, 5], the ratio each of `BOUNDS` would have.
    distortion_ratio : [verdicts], the ratio of a read-out if the bench did not move as one; NaN for other outputs, and
        where gradients within areas act.
    filter_sensitivity : verdict ratios for other orders and corners; None where no spectrum is low-pass.
    improvements : of each verdict; groups : [G], of their group_factor, as `AreaTable.group_by_unit`.
    contributions : where the noise comes from; disturbances : which of a thermal network; None of other cases.
    """

    case: CorrelationCase
    outputs: Outputs
    source: AnySource
    frequency_hz: FloatArray
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
    disturbances: DisturbanceContributions | None = field(default=None, repr=False)

    @property
    def areas(self) -> AreaTable:
        """The thermal areas of the outputs."""
        return self.outputs.areas

    @property
    def blocks(self) -> tuple[IndexArray, ...]:
        """Column indices of each block."""
        return self.source.blocks

    @property
    def active(self) -> BoolArray:
        """Areas [k] in a block."""
        return self.source.active


def run_case(
    case: CorrelationCase,
    outputs: Outputs,
    temperature: TemperatureModel,
    frequency_hz: FloatArray,
    criteria: Criteria = Criteria(),
    known: Correlation | None = None,
) -> CaseResult:
    """Noise of the outputs in one correlation case.

    Parameters
    ----------
    frequency_hz : [F], increasing, with the band edges of the requirements (see `frequency_grid`).
    criteria : which outputs to judge by what; by default none.
    known : the correlation of the case, where it has been found already.

    Raises
    ------
    ConfigError : the case does not fit the areas; a requirement names an unknown output, one of another quantity, a
        difference where it limits a single test mass, or a band outside the frequencies. All of a sort at once.
    PhysicsError : the matrix of the case is not a correlation matrix.
    """
    found = correlation(case, outputs.areas, temperature.heard) if known is None else known
    return case_of(case, outputs, TemperatureNoise(temperature, found), frequency_hz, criteria)


def case_of(
    case: CorrelationCase,
    outputs: Outputs,
    source: AnySource,
    frequency_hz: FloatArray,
    criteria: Criteria = Criteria(),
) -> CaseResult:
    """Noise of the outputs in one case whose temperatures are known; parameters and errors as of `run_case`."""
    judged, safety_factor = judged_outputs(criteria, outputs, frequency_hz), criteria.safety_factor
    areas = outputs.areas
    noise = source.outputs(outputs.rows, frequency_hz)
    psd, bounds = noise.psd(), correlation_bounds(noise)
    verdicts = [
        judge(
            np.sqrt(psd[o]),
            frequency_hz,
            requirement,
            safety_factor,
            kind=outputs.kinds[o],
            output=outputs.labels[o],
        )
        for requirement, o in judged
    ]
    by_unit = areas.group_by_unit
    groups = tuple(dict.fromkeys(by_unit[source.active].tolist()))
    masks = [by_unit == group for group in groups]
    improvements = []
    for (requirement, o), verdict in zip(judged, verdicts, strict=True):
        f = frequency_hz[in_band(requirement, frequency_hz)]
        limit = requirement.amplitude(f) / safety_factor
        binding = int(np.searchsorted(f, verdict.binding_hz))
        improvements.append(improvement(noise.of(outputs.rows[o : o + 1]).at(f), binding, limit, masks))
    found = contributions(noise, outputs, judged, verdicts)
    disturbances = None
    if isinstance(noise, NetworkOutputs):
        disturbances = disturbance_contributions(noise, found, judged, safety_factor)
    temperature_set, temperature_asd = source.distinct(frequency_hz)
    return CaseResult(
        case=case,
        outputs=outputs,
        source=source,
        frequency_hz=frequency_hz,
        temperature_set=temperature_set,
        temperature_asd=temperature_asd,
        psd=psd,
        bounds=bounds,
        verdicts=tuple(verdicts),
        safety_factor=safety_factor,
        bound_ratio=_bound_ratios(bounds, frequency_hz, judged, safety_factor),
        distortion_ratio=_distortion_ratios(noise, outputs, judged, safety_factor),
        filter_sensitivity=filter_sensitivity(noise, judged, safety_factor) if isinstance(noise, OutputNoise) else None,
        improvements=tuple(improvements),
        groups=groups,
        contributions=found,
        disturbances=disturbances,
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


def _distortion_ratios(noise: AnyNoise, outputs: Outputs, judged: Judged, safety_factor: float) -> FloatArray:
    """Ratio [verdicts] of the read-outs without the motion of the bench as one; NaN where that is not known."""
    ratio = np.full(len(judged), np.nan)
    for v, (requirement, o) in enumerate(judged):
        parts = outputs.parts_of_read_outs.get(outputs.labels[o])
        if parts is None or parts.distortion is None:
            continue
        unknown = np.isnan(parts.distortion)
        if not (unknown & noise.source.active).any():
            f = noise.frequency_hz[in_band(requirement, noise.frequency_hz)]
            psd = noise.of(np.where(unknown, 0.0, parts.distortion)[None]).at(f).psd()[0]
            ratio[v] = (safety_factor * np.sqrt(psd) / requirement.amplitude(f)).max()
    return ratio


def judged_outputs(criteria: Criteria, outputs: Outputs, frequency_hz: FloatArray) -> list[tuple[Requirement, int]]:
    """(requirement, index of output) of every verdict to be; `ConfigError` as `run_case` raises it."""
    problems: list[tuple[str, str]] = []
    judged: list[tuple[Requirement, int]] = []
    for number, applied in enumerate(criteria.requirements):
        for label in applied.outputs:
            path = f"requirement[{number}].outputs"
            if label not in outputs.labels:
                problems.append((path, no_output(label, outputs.labels)))
                continue
            o = outputs.labels.index(label)
            facts = mismatches(applied.requirement, outputs.kinds[o], frequency_hz)
            of = "single" if terms(label) is None else "differential"
            if applied.requirement.applies_to != of:
                fact = f"is for {applied.requirement.applies_to} outputs; set applies_to = {of!r} if it is for this one"
                facts.append(fact)
            problems += [(path, f"{label}: {applied.requirement.name} {fact}") for fact in facts]
            judged.append((applied.requirement, o))
    if problems:
        raise ConfigError(problems, where="requirements")
    return judged
