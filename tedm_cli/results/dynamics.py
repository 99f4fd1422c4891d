"""The drag-free loop and the cases in it, as dynamics.h5 and the simulation files tell them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tedm_cli.arrays import ComplexArray, FloatArray
from tedm_cli.contracts import DYNAMICS, SIMULATION
from tedm_cli.dynamics.controller import ATTITUDE, DRAG_FREE, SUSPENSION
from tedm_cli.dynamics.judging import THERMAL
from tedm_cli.dynamics.signals import DELTA_G, kind
from tedm_cli.files.store import Reader
from tedm_cli.results.deciding import LIKELY, deciding, possible_of, worst_of
from tedm_cli.results.noise import Limit

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
    source_share, area_share : parts of the PSD there of each source, and signed of each thermal area.
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
    source_share: dict[str, float]
    area_share: dict[str, float]
    incoherent: float

    @property
    def thermal_asd(self) -> FloatArray:
        """[F], of the temperatures, gravity and read-out with their phases."""
        return self.group_asd[THERMAL]

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


def read_stability(file: Reader) -> LoopStability:
    """Loops and margins of an open dynamics file."""
    own = not file.has(DYNAMICS.MATRIX_ACTUATION)
    family = {} if own else {name: title for title, names in FAMILIES.items() for name in names}
    names = file.strings(DYNAMICS.LOOP_NAME)
    columns = [
        file.array(d).tolist()
        for d in (
            DYNAMICS.LOOP_CROSSOVER,
            DYNAMICS.LOOP_PHASE_MARGIN,
            DYNAMICS.LOOP_GAIN_MARGIN,
            DYNAMICS.LOOP_GAIN_REDUCTION,
            DYNAMICS.LOOP_PEAK_SENSITIVITY,
        )
    ]
    open_loop = file.array(DYNAMICS.LOOP_OPEN_REAL) + 1j * file.array(DYNAMICS.LOOP_OPEN_IMAGINARY)
    loops = [
        ControlLoop(name, family.get(name, AT_READ_OUTS), *numbers, response)
        for name, numbers, response in zip(names, zip(*columns, strict=True), open_loop, strict=True)
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
    number = {
        key: file.array(dataset)
        for key, dataset in {
            "ratio": SIMULATION.VERDICT_RATIO,
            "binding_hz": SIMULATION.VERDICT_BINDING_FREQUENCY,
            "noise": SIMULATION.VERDICT_NOISE,
            "limit": SIMULATION.VERDICT_LIMIT,
            "incoherent": SIMULATION.VERDICT_INCOHERENT,
        }.items()
    }
    named = {
        key: (names, file.array(dataset))
        for key, (names, dataset) in {
            "share": (groups, SIMULATION.VERDICT_GROUP_SHARE),
            "silenced": (groups, SIMULATION.IMPROVEMENT_SILENCED),
            "factor": (groups, SIMULATION.IMPROVEMENT_FACTOR),
            "source_share": (sources, SIMULATION.VERDICT_SOURCE_SHARE),
            "area_share": (areas, SIMULATION.VERDICT_AREA_SHARE),
        }.items()
    }
    passed = file.array(SIMULATION.VERDICT_PASSED)
    judged = []
    pairs = zip(file.strings(SIMULATION.VERDICT_OUTPUT), file.strings(SIMULATION.VERDICT_REQUIREMENT), strict=True)
    for v, (output, requirement) in enumerate(pairs):
        judged.append(
            LoopOutput(
                output=output,
                kind=kind(output),
                unit=unit[output],
                requirement=requirement,
                passed=bool(passed[v]),
                asd=_asd(file, SIMULATION.PSD.of(output)),
                group_asd={g: _asd(file, SIMULATION.CONTRIBUTION.of(g, output)) for g in groups},
                gravity_asd=_asd(file, SIMULATION.THERMAL_GRAVITY.of(output)),
                incoherent_asd=_asd(file, SIMULATION.THERMAL_INCOHERENT.of(output)),
                **{key: float(values[v]) for key, values in number.items()},
                **{key: _by_name(names, values[v]) for key, (names, values) in named.items()},
            )
        )
    return tuple(judged)


def _asd(file: Reader, path: str) -> FloatArray:
    return np.sqrt(file.array(path))


def _by_name(names: Sequence[str], values: FloatArray) -> dict[str, float]:
    return dict(zip(names, (float(x) for x in values), strict=True))
