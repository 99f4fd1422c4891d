"""simulate: noise of all outputs of the closed loop in a case, its budget, verdicts and what would help."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tedm_cli.arrays import FloatArray
from tedm_cli.config.project import Project
from tedm_cli.config.temperature.tables import table_paths, temperature_model
from tedm_cli.contracts import SIMULATION as KIND
from tedm_cli.dynamics.budget import Budget, budget
from tedm_cli.dynamics.judging import JudgedOutput, by_group, groups_of, judge_outputs
from tedm_cli.dynamics.signals import unit
from tedm_cli.dynamics.sources import NoiseSource
from tedm_cli.files.build_folder import provenance, simulation_file_name
from tedm_cli.files.store import Writer, create
from tedm_cli.noise.correlation import CorrelationCase, correlation
from tedm_cli.noise.network import NetworkNoise
from tedm_cli.noise.propagation import TemperatureNoise
from tedm_cli.noise.requirements import Requirement, in_band
from tedm_cli.noise.sources import AnySource
from tedm_cli.noise.temperature import TemperatureModel
from tedm_cli.progress import Step, counter
from tedm_cli.results.adjoint.within import CaseGradients, and_spectra, case_gradients
from tedm_cli.results.areas import write_areas
from tedm_cli.results.outputs import ModelOutputs, read_outputs
from tedm_cli.results.thermal.case import thermal_columns
from tedm_cli.stages.dynamics.loop import Loop
from tedm_cli.stages.dynamics.prepared import Prepared, prepare
from tedm_cli.stages.dynamics.realisation import RealisedLoop, realise_loop, write_realisation
from tedm_cli.stages.dynamics.thermal import ThermalRows


@dataclass(frozen=True, eq=False)
class Simulation:
    """One case in closed loop: budget at `frequency_hz` [F] and verdicts.

    `groups` of noise sources, the temperatures last, are the columns of what verdicts say of groups.
    """

    case: CorrelationCase
    loop: Loop
    rows: ThermalRows
    source: AnySource
    frequency_hz: FloatArray
    budget: Budget
    judged: tuple[JudgedOutput, ...]
    safety_factor: float
    realised: RealisedLoop | None = None

    @property
    def groups(self) -> tuple[str, ...]:
        return groups_of(self.loop.sources)

    @property
    def disturbances(self) -> tuple[str, ...]:
        """Of the thermal network; none of other cases."""
        return self.source.disturbances if isinstance(self.source, NetworkNoise) else ()

    @property
    def sources(self) -> tuple[NoiseSource, ...]:
        return self.loop.sources


def simulate(
    project: Project,
    case_ids: Sequence[str],
    output: Path | None,
    step: Step,
    in_time: bool = False,
    done: Callable[[Path, Simulation], None] = lambda path, result: None,
) -> None:
    """Run the cases in closed loop and write one file each; `done` is told of each. `in_time`: realise them as well.

    Raises
    ------
    InputError : dynamics.h5 is missing or stale, or adjoint.h5 where a case has gradients within areas, or thermal.h5
        where it is of the thermal network.
    ConfigError : requirements that do not fit, all at once.
    """
    ready = prepare(project)
    loop, frequency, config = ready.loop, ready.frequency_hz, ready.config
    outputs = tuple(dict.fromkeys(label for _, label in ready.judged))
    temperatures = _Temperatures.of(project, ready)
    cases = [config.case(case_id, where=str(project.cases)) for case_id in case_ids]
    fluctuating = [temperatures.of_case(case) for case in cases]  # what is refused is so before the first is run
    for number, (case, (rows, source, made_of)) in enumerate(zip(cases, fluctuating, strict=True)):
        thermal = rows.driven_by(source, frequency)
        step(number, len(case_ids), "closed loop")
        found = budget(loop.plant, loop.controller, loop.sources, thermal, frequency, areas_of=outputs)
        verdicts = judge_outputs(found, loop.sources, ready.judged, frequency, config.safety_factor)
        realised = None
        if in_time:
            advance = counter(step, loop.config.time.samples, f"realising case {case.id}")
            band = (ready.lowest_hz, float(frequency[-1]))
            realised = realise_loop(loop, rows, source, outputs, band, f"case {case.id}", advance)
        result = Simulation(case, loop, rows, source, frequency, found, tuple(verdicts), config.safety_factor, realised)
        path = output if output is not None else project.build_dir / simulation_file_name(case.id)
        matrix = config.case_table(case.id).matrix
        used = [*ready.inputs, *made_of]
        inputs = [*used, *table_paths(project, config), *([Path(matrix)] if matrix else [])]
        with create(path, KIND, provenance(ready.configs, inputs)) as writer:
            write_simulation(writer, result, [r.requirement for r in ready.requirements])
            if realised is not None:
                write_realisation(writer, realised)
        done(path, result)


@dataclass(frozen=True, eq=False)
class _Temperatures:
    """What the temperatures of all cases of a project are made of."""

    project: Project
    ready: Prepared
    outputs: ModelOutputs
    of_areas: TemperatureModel
    gradients: CaseGradients

    @classmethod
    def of(cls, project: Project, ready: Prepared) -> _Temperatures:
        outputs = read_outputs(project)
        of_areas = temperature_model(project, ready.config, ready.rows.areas)
        return cls(project, ready, outputs, of_areas, case_gradients(project, ready.config, outputs))

    def of_case(self, case: CorrelationCase) -> tuple[ThermalRows, AnySource, Sequence[Path]]:
        """Rows and noise of the temperatures of a case, and the files that it alone is made from."""
        rows = self.ready.rows
        if case.thermal:
            columns = thermal_columns(self.project, self.ready.config, case.id, self.outputs, self.of_areas)
            return rows.of_network(columns), columns.noise, columns.sources
        more = self.gradients.of(case.id)
        rows, temperature = rows.with_gradients(more), and_spectra(self.of_areas, more)
        source = TemperatureNoise(temperature, correlation(case, rows.areas, temperature.heard))
        return rows, source, self.gradients.sources(case.id)


def write_simulation(writer: Writer, r: Simulation, requirements: Sequence[Requirement]) -> None:
    """Write the result of a case in closed loop; `requirements` are all that were applied."""
    b = r.budget
    write_areas(writer, r.rows.areas, r.rows.area_id)
    writer.write(KIND.CASE_ID, r.case.id)
    writer.write(KIND.CASE_TITLE, r.case.title)
    writer.write(KIND.CASE_ROLE, r.case.role)
    writer.write(KIND.CASE_SAFETY_FACTOR, r.safety_factor)
    writer.write(KIND.TEMPERATURE_MODEL, r.source.words())
    writer.write(KIND.READ_OUT_SET, r.rows.set_name)
    writer.write(KIND.FREQUENCY, r.frequency_hz)
    writer.write(KIND.OUTPUT_LABEL, list(b.labels))
    writer.write(KIND.OUTPUT_UNIT, [unit(label) for label in b.labels])
    writer.write(KIND.GROUP_NAME, list(r.groups))
    groups = by_group(b, r.sources)
    for o, label in enumerate(b.labels):
        power = f"({unit(label)})^2/Hz"
        writer.write(KIND.PSD.of(label), b.total[:, o], units=power)
        for g, group in enumerate(r.groups):
            writer.write(KIND.CONTRIBUTION.of(group, label), groups[:, o, g], units=power)
        writer.write(KIND.THERMAL_INCOHERENT.of(label), b.incoherent[:, o], units=power)
        writer.write(KIND.THERMAL_GRAVITY.of(label), b.gravity[:, o], units=power)
    writer.write(KIND.SOURCE_NAME, [s.name for s in r.sources])
    writer.write(KIND.SOURCE_GROUP, [s.group for s in r.sources])
    _write_verdicts(writer, r)
    writer.write(KIND.REQUIREMENT_NAME, [q.name for q in requirements])
    writer.write(KIND.REQUIREMENT_SOURCE, [q.source for q in requirements])
    writer.write(KIND.REQUIREMENT_UNIT, [f"{q.unit}/sqrt(Hz)" for q in requirements])
    amplitude = np.full((len(requirements), len(r.frequency_hz)), np.nan)
    for i, q in enumerate(requirements):
        inside = in_band(q, r.frequency_hz)
        amplitude[i, inside] = q.amplitude(r.frequency_hz[inside])
    writer.write(KIND.REQUIREMENT_AMPLITUDE, amplitude, units="see /requirement/unit")


def _write_verdicts(writer: Writer, r: Simulation) -> None:
    verdicts, n = [j.verdict for j in r.judged], len(r.judged)
    writer.write(KIND.VERDICT_REQUIREMENT, [v.requirement for v in verdicts])
    writer.write(KIND.VERDICT_OUTPUT, [v.output for v in verdicts])
    writer.write(KIND.VERDICT_RATIO, [v.ratio for v in verdicts])
    writer.write(KIND.VERDICT_BINDING_FREQUENCY, [v.binding_hz for v in verdicts])
    writer.write(KIND.VERDICT_NOISE, [v.noise for v in verdicts], units="see /output/unit, per sqrt(Hz)")
    writer.write(KIND.VERDICT_LIMIT, [v.limit for v in verdicts], units="see /output/unit, per sqrt(Hz)")
    writer.write(KIND.VERDICT_PASSED, [int(v.passed) for v in verdicts])
    writer.write(KIND.VERDICT_INCOHERENT, [j.incoherent for j in r.judged])
    together = [j.together for j in r.judged]
    writer.write(KIND.IMPROVEMENT_TOGETHER, np.array([t.groups for t in together], int).reshape(n, len(r.groups)))
    writer.write(KIND.IMPROVEMENT_TOGETHER_FACTOR, [t.factor for t in together])
    writer.write(KIND.IMPROVEMENT_TOGETHER_SILENCED, [t.silenced for t in together])
    for dataset, key, size in (
        (KIND.VERDICT_GROUP_SHARE, "share", len(r.groups)),
        (KIND.VERDICT_SOURCE_SHARE, "source_share", len(r.sources)),
        (KIND.VERDICT_AREA_SHARE, "area_share", len(r.rows.areas)),
        (KIND.IMPROVEMENT_SILENCED, "silenced", len(r.groups)),
        (KIND.IMPROVEMENT_FACTOR, "factor", len(r.groups)),
    ):
        writer.write(dataset, np.array([getattr(j, key) for j in r.judged]).reshape(n, size))
    if names := r.disturbances:
        writer.write(KIND.DISTURBANCE_NAME, list(names))
        for dataset, key in (
            (KIND.VERDICT_DISTURBANCE_SHARE, "disturbance_share"),
            (KIND.IMPROVEMENT_DISTURBANCE_FACTOR, "disturbance_factor"),
        ):
            writer.write(dataset, np.array([getattr(j, key) for j in r.judged]).reshape(n, len(names)))
