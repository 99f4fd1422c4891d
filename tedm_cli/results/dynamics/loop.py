"""The drag-free loop and the cases in it, as dynamics.h5 and the simulation files tell them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from types import MappingProxyType

import numpy as np

from tedm_cli.arrays import ComplexArray, FloatArray
from tedm_cli.contracts import DYNAMICS, SIMULATION
from tedm_cli.dynamics.controller import ATTITUDE, DRAG_FREE, SUSPENSION
from tedm_cli.dynamics.judging import THERMAL
from tedm_cli.dynamics.signals import DELTA_G, kind
from tedm_cli.files.store import Reader
from tedm_cli.results.cases.deciding import LIKELY, deciding, possible_of, worst_of
from tedm_cli.results.cases.noise import Limit
from tedm_cli.results.dynamics.in_time import LoopInTime, read_loop_in_time

#: Families of the default loops; those of a controller of one's own are broken at the read-outs.
FAMILIES = {"drag-free": DRAG_FREE, "suspension": SUSPENSION, "attitude": ATTITUDE}
BUDGET_DEPTH = 1e-4  # lowest amplitude of a budget over the smallest of total and limit
AT_READ_OUTS = "broken at the read-outs"


@dataclass(frozen=True, eq=False)
class ControlLoop:
    """One loop, broken while the others are closed.

    Parameters
    ----------
    crossover_hz : highest frequency of gain 1; NaN where there is none.
    phase_deg, gain_db, reduction_db : margins; infinite where any change is borne.
    peak_sensitivity : largest 1 / |1 + L|.
    open_loop : L [F].
    """

    name: str
    family: str
    crossover_hz: float
    phase_deg: float
    gain_db: float
    reduction_db: float
    peak_sensitivity: float
    open_loop: ComplexArray

    @property
    def crosses(self) -> bool:
        """Whether its gain is 1 anywhere."""
        return bool(np.isfinite(self.crossover_hz))


@dataclass(frozen=True, eq=False)
class LoopStability:
    """The loops of a controller at `frequency_hz` [F]; `slowest_rad_s` is the largest real part of the poles."""

    origin: str
    frequency_hz: FloatArray
    loops: tuple[ControlLoop, ...]
    poles: int
    slowest_rad_s: float

    def families(self) -> dict[str, list[ControlLoop]]:
        """Loops by what they do, in the order of the file."""
        return {
            name: [x for x in self.loops if x.family == name] for name in dict.fromkeys(x.family for x in self.loops)
        }


@dataclass(frozen=True, eq=False)
class LoopOutput:
    """One output of a case in closed loop against one requirement.

    Parameters
    ----------
    unit : before "per √Hz". ratio : largest safety factor × noise / limit; binding_hz : where.
    asd : [F], amplitude spectral density without the safety factor; group_asd : [F] of each group of sources, the
        temperatures last.
    gravity_asd, incoherent_asd : [F], of the temperatures by gravity alone, and by gravity and read-out without phases.
    share, silenced, factor : by group: part of the PSD at the binding frequency, ratio without the group, and the
        factor on its amplitude that just meets the requirement (infinite: not felt; NaN: not by it alone).
    together, together_factor, together_silenced : groups that meet a violated requirement together, in the order of
        their shares, the factor on their amplitudes that just does it (NaN: it is met), and the ratio without them.
    source_share, area_share : parts of the PSD there of each source, and signed of each thermal area.
    disturbance_share, disturbance_factor : of the disturbances of a thermal network: part of the PSD there, and the
        factor on the level of each that just meets the requirement, as `factor`; empty of other cases.
    incoherent : PSD of the temperatures there without the phases of gravity and read-out over with them; NaN: none.
    """

    output: str
    kind: str
    unit: str
    requirement: str
    ratio: float
    binding_hz: float
    noise: float
    limit: float
    passed: bool
    asd: FloatArray
    group_asd: dict[str, FloatArray]
    gravity_asd: FloatArray
    incoherent_asd: FloatArray
    share: dict[str, float]
    silenced: dict[str, float]
    factor: dict[str, float]
    together: tuple[str, ...]
    together_factor: float
    together_silenced: float
    source_share: dict[str, float]
    area_share: dict[str, float]
    incoherent: float
    disturbance_share: dict[str, float] = field(default_factory=dict)
    disturbance_factor: dict[str, float] = field(default_factory=dict)

    @property
    def thermal_asd(self) -> FloatArray:
        """[F], of the temperatures, gravity and read-out with their phases."""
        return self.group_asd[THERMAL]

    @property
    def feels_temperatures(self) -> bool:
        """Whether there is anything of the temperatures in it."""
        return bool(self.thermal_asd.any() or self.incoherent_asd.any())

    def largest(self, most: int, least: float) -> list[tuple[str, float]]:
        """The groups of the largest shares, those of at least `least`."""
        order = sorted(self.share.items(), key=lambda item: -item[1])[:most]
        return [(name, share) for name, share in order if share >= least]


@dataclass(frozen=True, eq=False)
class SimulatedCase:
    """One case in closed loop, at `frequency_hz` [F]."""

    id: str
    title: str
    role: str
    safety_factor: float
    temperature: str
    read_out_set: str
    frequency_hz: FloatArray
    judged: tuple[LoopOutput, ...]
    limits: tuple[Limit, ...]

    def limits_of(self, output: str) -> list[Limit]:
        """Limits that judge one output."""
        names = {j.requirement for j in self.judged if j.output == output}
        return [q for q in self.limits if q.name in names]

    def budget_range(self, j: LoopOutput) -> tuple[float, float]:
        """Amplitudes that a budget of the output shows, the safety factor included."""
        curves = [
            self.safety_factor * j.asd,
            *(q.amplitude[np.isfinite(q.amplitude)] for q in self.limits_of(j.output)),
        ]
        values = np.concatenate(curves)
        values = values[values > 0.0]
        if not values.size:
            return 1e-3, 1.0
        return float(values.min() * BUDGET_DEPTH), float(2.0 * values.max())

    def seen_groups(self, j: LoopOutput) -> list[str]:
        """Groups of sources that rise into the range of the output's budget."""
        low, _ = self.budget_range(j)
        return [name for name, asd in j.group_asd.items() if self.safety_factor * asd.max() > low]


@dataclass(frozen=True, eq=False)
class ClosedLoop:
    """The loop of a project and its cases in it, those that have been simulated."""

    stability: LoopStability
    cases: tuple[SimulatedCase, ...]
    in_time: LoopInTime = field(default_factory=LoopInTime)

    def pairs(self) -> dict[tuple[str, str], list[tuple[SimulatedCase, LoopOutput]]]:
        """By (output, requirement), the verdicts of all cases."""
        found: dict[tuple[str, str], list[tuple[SimulatedCase, LoopOutput]]] = {}
        for case in self.cases:
            for j in case.judged:
                found.setdefault((j.output, j.requirement), []).append((case, j))
        return found

    def worst_likely(self) -> dict[str, tuple[SimulatedCase, LoopOutput]]:
        """By output, its largest ratio to any requirement: in the likely cases, or in all where none is likely."""
        found: dict[str, list[tuple[SimulatedCase, LoopOutput]]] = {}
        for (output, _), pairs in self.pairs().items():
            found.setdefault(output, []).extend(pairs)
        return {
            output: worst_of([p for p in pairs if p[0].role == LIKELY] or possible_of(pairs))
            for output, pairs in found.items()
        }

    def deciding_delta_g(self) -> tuple[SimulatedCase, LoopOutput] | None:
        """The verdict on Δg of the largest ratio in the cases that decide; None where it is not judged."""
        pairs = [p for (output, _), found in self.pairs().items() if output in DELTA_G for p in found]
        return deciding(pairs) if pairs else None

    def told_first(self) -> tuple[SimulatedCase, LoopOutput] | None:
        """The verdict on Δg that decides; where Δg is not judged, the worst of those that do; None without any."""
        pairs = [deciding(pairs) for pairs in self.pairs().values()]
        return self.deciding_delta_g() or (worst_of(pairs) if pairs else None)


def read_closed_loop(
    dynamics: Reader | None, simulations: Sequence[Reader], series: Mapping[str, Reader] = MappingProxyType({})
) -> ClosedLoop | None:
    """The loop and its cases, from their open files; None where they have not been made."""
    if dynamics is None:
        return None
    cases = tuple(read_simulation(file) for file in simulations)
    return ClosedLoop(read_stability(dynamics), cases, read_loop_in_time(simulations, series))


def read_stability(file: Reader) -> LoopStability:
    """Loops and margins of an open dynamics file."""
    own = not file.has(DYNAMICS.MATRIX_ACTUATION)
    family = {} if own else {name: title for title, names in FAMILIES.items() for name in names}
    numbers = zip(
        file.strings(DYNAMICS.LOOP_NAME),
        file.array(DYNAMICS.LOOP_CROSSOVER),
        file.array(DYNAMICS.LOOP_PHASE_MARGIN),
        file.array(DYNAMICS.LOOP_GAIN_MARGIN),
        file.array(DYNAMICS.LOOP_GAIN_REDUCTION),
        file.array(DYNAMICS.LOOP_PEAK_SENSITIVITY),
        file.array(DYNAMICS.LOOP_OPEN_REAL) + 1j * file.array(DYNAMICS.LOOP_OPEN_IMAGINARY),
        strict=True,
    )
    loops = [
        ControlLoop(
            name,
            family.get(name, AT_READ_OUTS),
            float(crossover),
            float(phase),
            float(gain),
            float(less),
            float(peak),
            x,
        )
        for name, crossover, phase, gain, less, peak, x in numbers
    ]
    poles = file.array(DYNAMICS.POLE_REAL)
    return LoopStability(
        file.string(DYNAMICS.CONTROLLER_ORIGIN),
        file.array(DYNAMICS.LOOP_FREQUENCY),
        tuple(loops),
        len(poles),
        float(poles.max()),
    )


def read_simulation(file: Reader) -> SimulatedCase:
    """Setting, judged outputs and limits of an open simulation file."""
    f = file.array(SIMULATION.FREQUENCY)
    return SimulatedCase(
        id=file.string(SIMULATION.CASE_ID),
        title=file.string(SIMULATION.CASE_TITLE),
        role=file.string(SIMULATION.CASE_ROLE),
        safety_factor=file.number(SIMULATION.CASE_SAFETY_FACTOR),
        temperature=file.string(SIMULATION.TEMPERATURE_MODEL).replace("sqrt(Hz)", "√Hz"),
        read_out_set=file.string(SIMULATION.READ_OUT_SET),
        frequency_hz=f,
        judged=_read_judged(file),
        limits=_read_limits(file, f),
    )


def _read_limits(file: Reader, frequency_hz: FloatArray) -> tuple[Limit, ...]:
    """Limits that were applied; the edges of their bands are among the frequencies."""
    limits = []
    for name, source, unit, amplitude in zip(
        file.strings(SIMULATION.REQUIREMENT_NAME),
        file.strings(SIMULATION.REQUIREMENT_SOURCE),
        file.strings(SIMULATION.REQUIREMENT_UNIT),
        file.array(SIMULATION.REQUIREMENT_AMPLITUDE),
        strict=True,
    ):
        inside = frequency_hz[np.isfinite(amplitude)]
        band = (float(inside[0]), float(inside[-1])) if inside.size else (np.nan, np.nan)
        limits.append(Limit(name, source, unit.removesuffix("/sqrt(Hz)"), band, amplitude))
    return tuple(limits)


def _read_judged(file: Reader) -> tuple[LoopOutput, ...]:
    unit = dict(zip(file.strings(SIMULATION.OUTPUT_LABEL), file.strings(SIMULATION.OUTPUT_UNIT), strict=True))
    groups, sources = file.strings(SIMULATION.GROUP_NAME), file.strings(SIMULATION.SOURCE_NAME)
    areas = file.strings(SIMULATION.AREA_NAME)
    ratio, binding_hz, noise, limit, passed, incoherent = (
        file.array(d)
        for d in (
            SIMULATION.VERDICT_RATIO,
            SIMULATION.VERDICT_BINDING_FREQUENCY,
            SIMULATION.VERDICT_NOISE,
            SIMULATION.VERDICT_LIMIT,
            SIMULATION.VERDICT_PASSED,
            SIMULATION.VERDICT_INCOHERENT,
        )
    )
    share, silenced, factor = (
        file.array(d)
        for d in (SIMULATION.VERDICT_GROUP_SHARE, SIMULATION.IMPROVEMENT_SILENCED, SIMULATION.IMPROVEMENT_FACTOR)
    )
    together, together_factor, together_silenced = (
        file.array(d)
        for d in (
            SIMULATION.IMPROVEMENT_TOGETHER,
            SIMULATION.IMPROVEMENT_TOGETHER_FACTOR,
            SIMULATION.IMPROVEMENT_TOGETHER_SILENCED,
        )
    )
    source_share, area_share = file.array(SIMULATION.VERDICT_SOURCE_SHARE), file.array(SIMULATION.VERDICT_AREA_SHARE)
    disturbances: list[str] = []
    disturbance_share = disturbance_factor = np.empty((len(ratio), 0))
    if file.has(SIMULATION.DISTURBANCE_NAME):
        disturbances = file.strings(SIMULATION.DISTURBANCE_NAME)
        disturbance_share = file.array(SIMULATION.VERDICT_DISTURBANCE_SHARE)
        disturbance_factor = file.array(SIMULATION.IMPROVEMENT_DISTURBANCE_FACTOR)
    pairs = zip(file.strings(SIMULATION.VERDICT_OUTPUT), file.strings(SIMULATION.VERDICT_REQUIREMENT), strict=True)
    return tuple(
        LoopOutput(
            output=output,
            kind=kind(output),
            unit=unit[output],
            requirement=requirement,
            ratio=float(ratio[v]),
            binding_hz=float(binding_hz[v]),
            noise=float(noise[v]),
            limit=float(limit[v]),
            passed=bool(passed[v]),
            asd=_asd(file, SIMULATION.PSD.of(output)),
            group_asd={g: _asd(file, SIMULATION.CONTRIBUTION.of(g, output)) for g in groups},
            gravity_asd=_asd(file, SIMULATION.THERMAL_GRAVITY.of(output)),
            incoherent_asd=_asd(file, SIMULATION.THERMAL_INCOHERENT.of(output)),
            share=_by_name(groups, share[v]),
            silenced=_by_name(groups, silenced[v]),
            factor=_by_name(groups, factor[v]),
            together=tuple(groups[g] for g in np.argsort(-share[v], kind="stable") if together[v, g]),
            together_factor=float(together_factor[v]),
            together_silenced=float(together_silenced[v]),
            source_share=_by_name(sources, source_share[v]),
            area_share=_by_name(areas, area_share[v]),
            incoherent=float(incoherent[v]),
            disturbance_share=_by_name(disturbances, disturbance_share[v]),
            disturbance_factor=_by_name(disturbances, disturbance_factor[v]),
        )
        for v, (output, requirement) in enumerate(pairs)
    )


def _asd(file: Reader, path: str) -> FloatArray:
    asd: FloatArray = np.sqrt(file.array(path))
    return asd


def _by_name(names: Sequence[str], values: FloatArray) -> dict[str, float]:
    return dict(zip(names, (float(x) for x in values), strict=True))
