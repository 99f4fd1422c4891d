"""One correlation case, end to end: noise of every output, its bounds, verdicts and contributors."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tedm_cli.errors import ConfigError, InputError
from tedm_cli.noise.areas import AreaTable
from tedm_cli.noise.bounds import Bounds, correlation_bounds
from tedm_cli.noise.contributions import amplitude_contributions, shares_at, shares_over, sum_by
from tedm_cli.noise.correlation import CorrelationCase, Indices, block_factor, blocks
from tedm_cli.noise.filter_sensitivity import FilterSensitivity, filter_sensitivity
from tedm_cli.noise.propagation import output_psd_from_factor
from tedm_cli.noise.requirements import REFERENCE_HZ, UNITS, AppliedRequirement, Requirement, Verdict, judge, mismatches
from tedm_cli.noise.temperature import TemperatureModel

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class CaseResult:
    """Noise of n_out outputs in one correlation case. PSDs are one-sided and without the safety factor.

    Parameters
    ----------
    case : the case; blocks : column indices of each of its fully correlated blocks.
    active : [k], areas in a block.
    labels, kinds, units : [n_out], of the outputs; units before "per √Hz".
    frequency_hz : [F].
    temperature : the model; temperature_set : [k], which spectrum of temperature_asd [q, F], K/√Hz, each area has.
    psd : [n_out, F], unit²/Hz; bounds : what other correlations of the active areas would give.
    verdicts : in the order of the requirements and their outputs; safety_factor : on amplitudes, in verdicts only.
    filter_sensitivity : verdict ratios for other orders and corners; None where no spectrum is low-pass.
    contribution_hz : [n_out], the binding frequency of the worst verdict, 1 mHz for an output without one.
    contribution : [n_out, k], signed amplitudes there, unit/√Hz, zero for silent areas.
    share : [n_out, k], each area's part of the PSD there; they sum to 1, or are 0 for an output without noise.
    band_hz : [n_out, 2], band of the worst verdict, all frequencies for an output without one.
    band_share : [n_out, k], each area's part of the power in that band.
    groups : [G]; group_share, group_band_share : [n_out, G], sums of the shares over the groups.
    """

    case: CorrelationCase
    blocks: tuple[Indices, ...]
    active: NDArray[np.bool_]
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
    filter_sensitivity: FilterSensitivity | None
    contribution_hz: Array
    contribution: Array
    share: Array
    band_hz: Array
    band_share: Array
    groups: NDArray[Any]
    group_share: Array
    group_band_share: Array


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
) -> CaseResult:
    """Noise of outputs with sensitivities `rows` [n_out, k], in their unit per kelvin, in one correlation case.

    Parameters
    ----------
    labels, kinds : [n_out], name and quantity (a key of `UNITS`) of each output.
    frequency_hz : [F], increasing, with the band edges of the requirements (see `frequency_grid`).
    requirements : which outputs to judge by what.
    safety_factor : multiplies noise amplitudes in verdicts (Montemurro 2004, section 3.5, recommends 2).

    Raises
    ------
    ConfigError : the case does not fit the areas; a requirement names an unknown output, one of another quantity, or
        a band outside the frequencies. All problems of a sort at once.
    InputError : the shapes disagree, or a sensitivity is not finite.
    """
    _check_rows(rows, labels, kinds, areas)
    judged = _judged(requirements, labels, kinds, frequency_hz)
    block_list = blocks(case, areas)
    factor = block_factor(block_list, len(areas))
    active = factor.any(axis=1)

    psd = output_psd_from_factor(rows, temperature, factor, frequency_hz)
    verdicts = [
        judge(np.sqrt(psd[o]), frequency_hz, requirement, safety_factor, kind=kinds[o], output=labels[o])
        for requirement, o in judged
    ]

    at_hz = np.full(len(rows), REFERENCE_HZ)
    band_hz = np.tile(frequency_hz[[0, -1]], (len(rows), 1))
    worst = np.full(len(rows), -1.0)
    for (requirement, o), verdict in zip(judged, verdicts, strict=True):
        if verdict.ratio > worst[o]:
            worst[o], at_hz[o], band_hz[o] = verdict.ratio, verdict.binding_hz, requirement.band_hz
    share, band_share = np.empty_like(rows), np.empty_like(rows)
    for o in range(len(rows)):
        row = rows[o : o + 1]
        inside = (frequency_hz >= band_hz[o, 0] * (1 - 1e-9)) & (frequency_hz <= band_hz[o, 1] * (1 + 1e-9))
        share[o] = shares_at(row, temperature, factor, at_hz[o])[0]
        band_share[o] = shares_over(row, temperature, factor, frequency_hz[inside])[0]
    groups, group_share = sum_by(share, areas.group)
    temperature_set, temperature_asd = temperature.distinct(frequency_hz)

    return CaseResult(
        case=case,
        blocks=tuple(block_list),
        active=active,
        labels=tuple(labels),
        kinds=tuple(kinds),
        units=tuple(UNITS[kind] for kind in kinds),
        frequency_hz=frequency_hz,
        temperature=temperature,
        temperature_set=temperature_set,
        temperature_asd=temperature_asd,
        psd=psd,
        bounds=correlation_bounds(rows, temperature, block_list, frequency_hz),
        verdicts=tuple(verdicts),
        safety_factor=safety_factor,
        filter_sensitivity=filter_sensitivity(rows, kinds, temperature, factor, frequency_hz, judged, safety_factor),
        contribution_hz=at_hz,
        contribution=amplitude_contributions(rows, temperature, at_hz) * active,
        share=share,
        band_hz=band_hz,
        band_share=band_share,
        groups=groups,
        group_share=group_share,
        group_band_share=sum_by(band_share, areas.group)[1],
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
            problems += [(path, f"{label}: {applied.requirement.name} {fact}") for fact in facts]
            judged.append((applied.requirement, o))
    if problems:
        raise ConfigError(problems, where="requirements")
    return judged
