"""What each kind of criterion reads of a variant's results, and which commands of the chain make these."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import numpy as np

from tedm_cli.arrays import FloatArray
from tedm_cli.config.loads import INTERFACE
from tedm_cli.config.project import NO_OPTICS
from tedm_cli.config.trade import ONE_MHZ, CriterionTable
from tedm_cli.dynamics.signals import DELTA_G
from tedm_cli.gravity.requirements import AT_REST_UNITS, DcVerdict, dc_quantities
from tedm_cli.results.cases.deciding import worst_of
from tedm_cli.results.cases.noise import CaseNoise, JudgedOutput, limit_named
from tedm_cli.results.dynamics.loop import LoopOutput, SimulatedCase
from tedm_cli.results.gravity.field import FieldAtRest, place_text, symbol, worst_at_rest
from tedm_cli.results.model import ModelSize
from tedm_cli.results.ranking import first_largest
from tedm_cli.results.wording import and_text, count, mhz_text
from tedm_cli.stages.trade.found import LacksError, VariantResults


@dataclass(frozen=True)
class Measured:
    """The value of a criterion, its unit, what it is of, and its parts by contributor (`CriterionKind.parts`)."""

    value: float
    of: str
    unit: str = "1"
    parts: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True)
class _Kind:
    """How a criterion is read, and the stage whose files it is read from; `of_case`: of each of its cases one.

    `in_loop`: these are the cases that can be simulated.
    """

    read: Callable[[CriterionTable, VariantResults], Measured]
    stage: str
    of_case: bool = False
    in_loop: bool = False


def measured(criterion: CriterionTable, of: VariantResults) -> Measured:
    """The value of a criterion for a variant whose chain has run.

    Raises
    ------
    LacksError : the variant lacks it, and why.
    InputError : a file of it cannot be read.
    """
    return _KINDS[criterion.kind].read(criterion, of)


def commands(criterion: CriterionTable, of: VariantResults) -> list[tuple[str, ...]]:
    """The commands that make what a criterion is read from; none where the variant lacks it."""
    kind = _KINDS[criterion.kind]
    if not kind.of_case:
        return [(kind.stage,)]
    try:
        return [(kind.stage, case_id) for case_id in of.case_ids(criterion, in_loop=kind.in_loop)]
    except LacksError:
        return []


def _judged(criterion: CriterionTable, of: VariantResults) -> list[tuple[CaseNoise, JudgedOutput]]:
    """What a criterion means of what cases judge."""
    cases = [of.noise(case_id) for case_id in of.case_ids(criterion)]
    pairs = [(case, j) for case in cases for j in case.judged if _is_meant(criterion, j.output, j.requirement)]
    if not pairs:
        raise of.why_no(criterion, [name for case in cases for j in case.judged for name in (j.output, j.requirement)])
    return pairs


def _is_meant(criterion: CriterionTable, output: str, requirement: str) -> bool:
    is_output = criterion.outputs is None or output in criterion.outputs
    return is_output and criterion.requirement in (None, requirement)


def _noise_ratio(criterion: CriterionTable, of: VariantResults) -> Measured:
    case, j = worst_of(_judged(criterion, of))
    names = case.areas.group_by_unit if criterion.contributors == "groups" else case.areas.name
    parts: dict[str, float] = {}
    for name, share in zip(map(str, names), j.share.tolist(), strict=True):
        parts[name] = parts.get(name, 0.0) + share * j.ratio**2
    return Measured(j.ratio, _place(j.output, case.id, j.binding_hz), parts=_not_nothing(parts))


def _distortion_ratio(criterion: CriterionTable, of: VariantResults) -> Measured:
    found = [(case, j, j.distortion_ratio) for case, j in _judged(criterion, of) if j.distortion_ratio is not None]
    if not found:
        raise LacksError("judges no read-out")
    case, j, ratio = first_largest(found, [ratio for *_, ratio in found])
    return Measured(ratio, f"{j.output}, case {case.id}")


def _bound_ratio(criterion: CriterionTable, of: VariantResults) -> Measured:
    pairs = _judged(criterion, of)
    case, j = first_largest(pairs, [j.correlation_ratio[1] for _, j in pairs])
    return Measured(j.correlation_ratio[1], f"{j.output}, case {case.id}")


def _noise(criterion: CriterionTable, of: VariantResults) -> Measured:
    f = ONE_MHZ if criterion.frequency_hz is None else criterion.frequency_hz
    found = []
    for case_id in of.case_ids(criterion):
        noise = of.noise_at(case_id)
        wanted = [o for o, label in enumerate(noise.label) if label in (criterion.outputs or ())]
        if not wanted:
            raise of.why_no(criterion, noise.label)
        found += [(noise.at(o, f), noise.unit[o], _place(noise.label[o], case_id, f)) for o in wanted]
    if len(units := sorted({unit for _, unit, _ in found})) > 1:
        raise LacksError(f"has these outputs in {' and '.join(units)}: no one of them is the largest")
    if any(np.isnan(value) for value, *_ in found):
        raise LacksError(f"has no noise at {mhz_text(f)}: [frequency] does not reach there")
    value, unit, where = first_largest(found, [value for value, *_ in found])
    return Measured(value, where, f"{unit}/√Hz")


def _closed_loop(criterion: CriterionTable, of: VariantResults) -> list[tuple[SimulatedCase, LoopOutput]]:
    """What a criterion means of what is judged in closed loop: Δg, where it names nothing."""
    cases = [of.simulation(case_id) for case_id in of.case_ids(criterion, in_loop=True)]
    judged: list[tuple[SimulatedCase, LoopOutput]] = [(case, j) for case in cases for j in case.judged]
    if criterion.outputs is None and criterion.requirement is None:
        pairs = [(case, j) for case, j in judged if j.output in DELTA_G]
        if not pairs:
            raise LacksError("does not judge Δg in closed loop")
    else:
        pairs = [(case, j) for case, j in judged if _is_meant(criterion, j.output, j.requirement)]
    if not pairs:
        raise of.why_no(criterion, [name for _, j in judged for name in (j.output, j.requirement)])
    return pairs


def _closed_loop_ratio(criterion: CriterionTable, of: VariantResults) -> Measured:
    case, j = worst_of(_closed_loop(criterion, of))
    parts = {group: share * j.ratio**2 for group, share in j.share.items()}
    return Measured(j.ratio, _place(j.output, case.id, j.binding_hz), parts=_not_nothing(parts))


def _closed_loop_thermal_ratio(criterion: CriterionTable, of: VariantResults) -> Measured:
    found = []
    for case, j in _closed_loop(criterion, of):
        limit = limit_named(case.limits, j.requirement).amplitude
        ratio = case.safety_factor * np.where(np.isnan(limit), 0.0, j.thermal_asd / limit)
        at = int(ratio.argmax())
        found.append((float(ratio[at]), _place(j.output, case.id, float(case.frequency_hz[at]))))
    value, where = first_largest(found, [value for value, _ in found])
    return Measured(value, where)


def _probability(criterion: CriterionTable, of: VariantResults) -> Measured:
    found = []
    for case_id in of.case_ids(criterion):
        uncertainty = of.noise(case_id).uncertainty
        if uncertainty is None:
            raise LacksError("says of nothing how uncertain it is")
        if criterion.outputs is None:
            found.append((uncertainty.any_violated.probability, f"any verdict of case {case_id}"))
            continue
        wanted = [chance for chance in uncertainty.outputs if chance.output in criterion.outputs]
        if not wanted:
            raise of.why_no(criterion, [chance.output for chance in uncertainty.outputs])
        found += [(chance.violated.probability, f"{chance.output}, case {case_id}") for chance in wanted]
    value, where = first_largest(found, [value for value, _ in found])
    return Measured(value, where)


def _at_rest(criterion: CriterionTable, of: VariantResults) -> list[DcVerdict]:
    verdicts = of.field.verdicts
    if not verdicts:
        raise LacksError("has no limits on the field at rest")
    meant = [
        v
        for v in verdicts
        if (criterion.quantities is None or v.quantity in criterion.quantities)
        and criterion.subsystem in (None, v.subsystem)
        and criterion.requirement in (None, v.requirement)
    ]
    if not meant:
        subsystems = ", ".join(dict.fromkeys(v.subsystem for v in verdicts))
        requirements = ", ".join(dict.fromkeys(v.requirement for v in verdicts))
        raise LacksError(f"judges nothing of this at rest (subsystems {subsystems}; requirements {requirements})")
    return meant


def _rest_ratio(criterion: CriterionTable, of: VariantResults) -> Measured:
    worst = worst_at_rest(_at_rest(criterion, of))
    where = f"{symbol(worst.quantity)} of {place_text(worst.place)}, {worst.subsystem}"
    return Measured(worst.ratio, where, parts=_sources(of.field, worst))


def _rest_violations(criterion: CriterionTable, of: VariantResults) -> Measured:
    meant = _at_rest(criterion, of)
    return Measured(float(sum(not v.passed for v in meant)), f"of {count(len(meant), 'limit')}")


def _sources(at_rest: FieldAtRest, verdict: DcVerdict) -> dict[str, float]:
    """By source its part of the ratio of a verdict; nothing where it is on a part of the model."""
    if not verdict.whole:
        return {}
    stiffness = at_rest.stiffness["Γ_lin"].value
    place = list(AT_REST_UNITS).index(verdict.quantity)

    def by_source(name: str) -> FloatArray:
        t = at_rest.test_mass.index(name)
        of_source = zip(at_rest.acceleration[t], at_rest.angular_acceleration[t], stiffness[t], strict=True)
        return np.array([dc_quantities(*one)[place] for one in of_source])

    value = by_source(verdict.test_mass) - (by_source(verdict.minus) if verdict.minus else 0.0)
    return dict(zip(at_rest.source, (value / verdict.limit).tolist(), strict=True))


def _mass(criterion: CriterionTable, of: VariantResults) -> Measured:
    size = of.model
    return Measured(size.mass_kg, "finite-element model", "kg", _by_group(size))


def _by_group(size: ModelSize) -> dict[str, float]:
    """The mass by group of areas; what is in none of them is by itself."""
    found: dict[str, float] = {}
    for group, gradient, mass in zip(size.areas.group, size.areas.gradient, size.area_mass_kg.tolist(), strict=True):
        if not gradient:
            found[str(group)] = found.get(str(group), 0.0) + mass
    rest = size.mass_kg - sum(found.values())
    return _not_nothing(found | ({"outside of the areas": rest} if abs(rest) > 1e-6 * size.mass_kg else {}))


def _compensation_mass(criterion: CriterionTable, of: VariantResults) -> Measured:
    blocks = of.field.blocks
    masses = dict(zip(blocks.name, blocks.mass_kg.tolist(), strict=True))
    return Measured(sum(masses.values()), count(len(masses), "block"), "kg", masses)


def _first_frequency(criterion: CriterionTable, of: VariantResults) -> Measured:
    modes = of.loads.modes
    if modes is None:
        raise LacksError("its file of loads asks for no natural frequencies")
    share = modes.effective_mass[0] / modes.mass
    most = int(share.argmax())
    what = "mass along" if most < 3 else "inertia about"
    return Measured(float(modes.frequency_hz[0]), f"{share[most]:.0%} of the {what} {'xyz'[most % 3]}", "Hz")


def _transmission(criterion: CriterionTable, of: VariantResults) -> Measured:
    """All supports as one move everything as one: they are no foot. Rounding is 0, or it would order variants."""
    loads, moved = of.loads, "rad" if criterion.motion == "rotation" else "m"
    feet = list(dict.fromkeys(foot for foot in loads.foot if foot not in ("", INTERFACE)))
    meant = feet if criterion.feet is None else criterion.feet
    if strange := [foot for foot in meant if foot not in feet]:
        raise LacksError(f"has no foot {and_text(strange)}")
    columns = [k for k in loads.motions if loads.foot[k] in meant and loads.unit[k] == moved]
    if not columns:
        raise LacksError(f"has no {criterion.motion or 'translation'} of a foot among its loads")
    as_one = loads.bench_as_one
    if criterion.outputs is None:
        if loads.bench is None:
            raise LacksError(f"has no optical bench ({NO_OPTICS})")
        size = np.where(as_one, 0.0, loads.bench)[columns]
        at = int(size.argmax())
        return Measured(float(size[at]), loads.name[columns[at]] if size[at] else _RIGID, f"m/{moved}")
    rows = [r for r, label in enumerate(loads.label) if label in criterion.outputs]
    if not rows:
        raise of.why_no(criterion, loads.label)
    if len(units := sorted({loads.row_unit[r] for r in rows})) > 1:
        raise LacksError(f"has these outputs in {' and '.join(units)}: no one of them is the largest")
    size = np.abs(loads.by_distortion[np.ix_(rows, columns)])
    if units[0] in ("m", "rad"):  # of a bench; what a test mass is pulled by is the whole structure, struts as well
        size = np.where(as_one[columns], 0.0, size)
        if not size.any():
            return Measured(0.0, _RIGID, f"{units[0]}/{moved}")
    row, column = np.unravel_index(int(size.argmax()), size.shape)
    unit = f"({units[0]})/{moved}" if "/" in units[0] else f"{units[0]}/{moved}"
    return Measured(float(size[row, column]), f"{loads.label[rows[row]]}, {loads.name[columns[column]]}", unit)


_RIGID = "rigid motion only"


def _place(output: str, case_id: str, frequency_hz: float) -> str:
    return f"{output}, case {case_id}, {mhz_text(frequency_hz)}"


def _not_nothing(parts: Mapping[str, float]) -> dict[str, float]:
    return {name: part for name, part in parts.items() if part != 0.0}


_KINDS = {
    "noise_ratio": _Kind(_noise_ratio, "run-case", of_case=True),
    "distortion_ratio": _Kind(_distortion_ratio, "run-case", of_case=True),
    "bound_ratio": _Kind(_bound_ratio, "run-case", of_case=True),
    "noise": _Kind(_noise, "run-case", of_case=True),
    "closed_loop_ratio": _Kind(_closed_loop_ratio, "simulate", of_case=True, in_loop=True),
    "closed_loop_thermal_ratio": _Kind(_closed_loop_thermal_ratio, "simulate", of_case=True, in_loop=True),
    "probability": _Kind(_probability, "run-case", of_case=True),
    "rest_ratio": _Kind(_rest_ratio, "build-sensitivity"),
    "rest_violations": _Kind(_rest_violations, "build-sensitivity"),
    "mass": _Kind(_mass, "ingest"),
    "compensation_mass": _Kind(_compensation_mass, "build-sensitivity"),
    "first_frequency": _Kind(_first_frequency, "build-loads"),
    "transmission": _Kind(_transmission, "build-loads"),
}
