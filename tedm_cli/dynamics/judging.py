"""Verdicts on outputs of the closed loop: what dominates them, and which source would have to be how much quieter."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tedm_cli.arrays import BoolArray, FloatArray
from tedm_cli.dynamics.budget import Budget
from tedm_cli.dynamics.signals import DELTA_G, OUTPUTS, kind
from tedm_cli.dynamics.sources import NoiseSource
from tedm_cli.errors import ConfigError
from tedm_cli.noise.differences import no_output
from tedm_cli.noise.improvement import scale_to_meet
from tedm_cli.noise.requirements import AppliedRequirement, Requirement, Verdict, in_band, judge, mismatches

THERMAL = "thermal"
#: Outputs that are differences of the test masses; all others are of one body.
DIFFERENTIAL = ("delta_g", "delta_g_full", "delta_g_true")


@dataclass(frozen=True, eq=False)
class JudgedOutput:
    """One output of the closed loop against one requirement.

    Parameters
    ----------
    verdict : with the binding frequency.
    share : [g], part of each group of sources, the temperatures last, in the PSD at the binding frequency.
    silenced : [g], the ratio without the group.
    factor : [g], factor on the amplitude of the group that just meets the requirement; infinite where the output does
        not feel it, NaN where this group alone cannot do it.
    source_share : [sources], part of each source in the PSD at the binding frequency.
    area_share : [k], the same of each thermal area, signed: their sum is the share of the temperatures.
    disturbance_share : [u], the same of each disturbance of a thermal network; None without one. disturbance_factor :
        [u], factor on its level alone that just meets the requirement; infinite where it is not felt, NaN where it
        cannot do it.
    incoherent : PSD of the temperatures over gravity and read-out apart, over their PSD together, at the binding
        frequency; NaN without temperatures.
    together : the groups that meet a violated requirement together when they are quieter.
    """

    verdict: Verdict
    share: FloatArray
    silenced: FloatArray
    factor: FloatArray
    source_share: FloatArray
    area_share: FloatArray
    incoherent: float
    together: Together
    disturbance_share: FloatArray | None = None
    disturbance_factor: FloatArray | None = None


@dataclass(frozen=True, eq=False)
class Together:
    """Groups of sources none of which can be left out to meet a requirement that is violated.

    They are taken one after another, each the one that helps most after those before it, as many as are needed; then
    any that the others have made needless is dropped.

    Parameters
    ----------
    groups : [g], which they are; none where the requirement is met.
    factor : on all their amplitudes, the other groups unchanged, that just meets the requirement; NaN where it is met.
    silenced : the ratio without them.
    """

    groups: BoolArray
    factor: float
    silenced: float


def groups_of(sources: Sequence[NoiseSource]) -> tuple[str, ...]:
    """Groups of the sources in their order, the temperatures last."""
    return (*dict.fromkeys(source.group for source in sources), THERMAL)


def by_group(budget: Budget, sources: Sequence[NoiseSource]) -> FloatArray:
    """One-sided PSDs [F, n, g] of the groups of `groups_of`."""
    groups = groups_of(sources)
    of = np.array([groups.index(source.group) for source in sources], dtype=int)
    parts = [budget.by_source[:, :, of == g].sum(axis=2) for g in range(len(groups) - 1)]
    return np.stack([*parts, budget.thermal], axis=2)


def judged_labels(
    requirements: Sequence[AppliedRequirement], frequency_hz: FloatArray, outputs: Sequence[str] = OUTPUTS
) -> list[tuple[Requirement, str]]:
    """(requirement, output) of every verdict to be, among the `outputs` of the plant.

    Raises
    ------
    ConfigError : an unknown output, one of another quantity, a requirement for single test masses on a difference or
        the reverse, or a band outside the frequencies; all at once.
    """
    problems: list[tuple[str, str]] = []
    out = []
    for number, applied in enumerate(requirements):
        for label in applied.outputs:
            where = f"requirement[{number}].outputs"
            if label not in outputs:
                is_delta_g = label in DELTA_G
                fact = f"{label} is of test masses whose x axes are parallel, and these are not" if is_delta_g else ""
                problems.append((where, fact or no_output(label, outputs)))
                continue
            facts = mismatches(applied.requirement, kind(label), frequency_hz)
            wanted = "differential" if label in DIFFERENTIAL else "single"
            if applied.requirement.applies_to != wanted:
                facts.append(f"is for {applied.requirement.applies_to} outputs; set applies_to = {wanted!r} if it is")
            problems += [(where, f"{label}: {applied.requirement.name} {fact}") for fact in facts]
            out.append((applied.requirement, label))
    if problems:
        raise ConfigError(problems, where="requirements")
    return out


def judge_outputs(
    budget: Budget,
    sources: Sequence[NoiseSource],
    judged: Sequence[tuple[Requirement, str]],
    frequency_hz: FloatArray,
    safety_factor: float,
) -> list[JudgedOutput]:
    """Verdicts on the outputs of a budget at `frequency_hz` [F], `safety_factor` on all amplitudes."""
    groups = by_group(budget, sources)
    out = []
    for requirement, label in judged:
        o = budget.labels.index(label)
        total = budget.total[:, o]
        verdict = judge(np.sqrt(total), frequency_hz, requirement, safety_factor, kind=kind(label), output=label)
        at = int(np.abs(frequency_hz - verdict.binding_hz).argmin())
        inside = in_band(requirement, frequency_hz)
        limit = (requirement.amplitude(frequency_hz[inside]) / safety_factor) ** 2
        part = groups[inside, o]
        rest = np.maximum(total[inside, None] - part, 0.0)
        silenced = np.sqrt((rest / limit[:, None]).max(axis=0))
        with np.errstate(divide="ignore", invalid="ignore"):
            room = np.where(part > 0.0, (limit[:, None] - rest) / part, np.inf).min(axis=0)
            factor = np.where(room >= 0.0, np.sqrt(np.maximum(room, 0.0)), np.nan)
        power = total[at] if total[at] > 0.0 else np.inf
        heat = budget.thermal[at, o]
        out.append(
            JudgedOutput(
                verdict,
                groups[at, o] / power,
                silenced,
                factor,
                budget.by_source[at, o] / power,
                budget.area[label][at] / power,
                float(budget.incoherent[at, o] / heat) if heat > 0.0 else np.nan,
                needed_together(part / limit[:, None]),
                *_of_disturbances(budget, label, at, inside, np.sqrt(limit)),
            )
        )
    return out


def _of_disturbances(
    budget: Budget, label: str, at: int, inside: BoolArray, limit: FloatArray
) -> tuple[FloatArray | None, FloatArray | None]:
    """Share [u] of each disturbance in the PSD at place `at`, and the factor on its level that just meets `limit`."""
    if label not in budget.disturbance:
        return None, None
    found, o = budget.disturbance[label], budget.labels.index(label)
    total = budget.total[at, o]
    share = found.parts()[at] / (total if total > 0.0 else np.inf)
    components = found.components()[:, :, inside]  # [u, m, F]
    everything = components.sum(axis=0)
    others = np.sqrt(np.maximum(budget.total - budget.thermal, 0.0))[inside, o]  # independent of the temperatures
    silent = np.zeros_like(others)
    factor = [
        scale_to_meet(np.vstack([own, silent]), np.vstack([everything - own, others]), limit) for own in components
    ]
    return share, np.array(factor)


def needed_together(power: FloatArray) -> Together:
    """Groups that meet a limit together, from their power [F, g] over that of the limit."""
    kept = np.ones(power.shape[1], dtype=bool)

    def highest(groups: BoolArray) -> float:
        return float(power[:, groups].sum(axis=1).max())

    if highest(kept) <= 1.0:
        return Together(~kept, np.nan, np.sqrt(highest(kept)))
    taken: list[int] = []
    while highest(kept) > 1.0:
        without = {g: highest(kept & (np.arange(len(kept)) != g)) for g in np.flatnonzero(kept)}
        taken.append(min(without, key=lambda g: without[g]))
        kept[taken[-1]] = False
    for g in taken[:-1]:  # without the last they were not enough
        kept[g] = True
        kept[g] = highest(kept) <= 1.0
    part, rest = power[:, ~kept].sum(axis=1), power[:, kept].sum(axis=1)
    felt = part > 0.0
    factor = np.sqrt(((1.0 - rest[felt]) / part[felt]).min())
    return Together(~kept, float(factor), np.sqrt(highest(kept)))
