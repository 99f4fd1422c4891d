"""simulate --series: a temperature time series through the closed loop, gravity and read-out together and apart.

The temperatures are read, checked and resampled as for run-series, as disturbances of the loop in place of outputs. It
is linear: the part that gravity makes and the part that the read-outs make are advanced side by side, and their sum is
the output. Memory does not grow with the length of the series.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import IO

import numpy as np

from tedm_cli.arrays import FloatArray
from tedm_cli.config.project import Project
from tedm_cli.config.series import SeriesTable
from tedm_cli.contracts import SIMULATED_SERIES as KIND
from tedm_cli.dynamics.in_time import TimeLoop, respond, time_loop
from tedm_cli.dynamics.signals import DISTURBANCES, N_COORDINATES, N_INPUTS, kind, unit
from tedm_cli.errors import InputError, PhysicsError
from tedm_cli.files.build_folder import provenance, simulated_series_file_name
from tedm_cli.files.scratch import scratch_file
from tedm_cli.files.store import create
from tedm_cli.noise.log_spectrum import require_speckit
from tedm_cli.noise.spectral_estimate import Estimate
from tedm_cli.progress import Step, counter
from tedm_cli.results.areas import write_areas
from tedm_cli.results.outputs import read_outputs
from tedm_cli.results.thermal.nodes import node_outputs
from tedm_cli.stages.dynamics.loop import Loop
from tedm_cli.stages.dynamics.prepared import Prepared, prepare
from tedm_cli.stages.series_result import Regular, SeriesResult, judge_all, store, welch_segment, write_result
from tedm_cli.stages.temperature_series import (
    Sampled,
    Scratch,
    SeriesColumns,
    run_each,
    sample_series,
    series_files,
    treatment_words,
)

_ALWAYS = ("delta_g", "delta_g_full", "TM1_x")
_FELT = slice(N_INPUTS, len(DISTURBANCES))  # read-outs, then accelerations
_READ_OUT, _GRAVITY = range(N_COORDINATES), range(N_COORDINATES, len(DISTURBANCES) - N_INPUTS)


@dataclass(frozen=True, eq=False)
class SimulatedSeries:
    """A temperature series through the loop: `total`, and root mean squares [n] of its two parts."""

    total: SeriesResult
    gravity_rms: FloatArray
    read_out_rms: FloatArray
    read_out_set: str


def simulate_series(
    project: Project,
    names: Sequence[str],
    output: Path | None,
    step: Step,
    done: Callable[[SimulatedSeries], None] = lambda result: None,
) -> None:
    """Run the series of these names through the loop and write one file each; `done` is told of each.

    A series that is refused does not keep the others from being run: the first refusal is raised at the end.

    Raises
    ------
    InputError : dynamics.h5 is missing or stale; a series that is refused, or whose samples do not fit a sampled
        controller.
    ConfigError : requirements that do not fit, all at once.
    """
    ready = prepare(project)
    always = [label for label in _ALWAYS if label in ready.loop.plant.outputs]
    labels = tuple(dict.fromkeys([label for _, label in ready.judged] + always))
    in_time = time_loop(ready.loop.plant, ready.loop.controller, labels)

    def run(table: SeriesTable) -> None:
        path = output if output is not None else project.build_dir / simulated_series_file_name(table.name)
        where = f"{project.cases}: series {table.name}"
        done(_simulate(project, ready, in_time, table, path, where, step))

    run_each(ready.config, names, run, step, "simulating series")


def _simulate(
    project: Project, ready: Prepared, in_time: TimeLoop, table: SeriesTable, path: Path, where: str, step: Step
) -> SimulatedSeries:
    labels, rows, columns = in_time.labels, ready.rows, SeriesColumns(ready.rows.areas)
    n, of_nodes = len(labels), list[Path]()
    if table.of == "nodes":
        by_nodes = node_outputs(project, read_outputs(project), f"series {table.name}")
        rows, of_nodes = rows.by(by_nodes.outputs), [by_nodes.source]
        columns = SeriesColumns(rows.areas, by_nodes.network)
    if table.spectrum == "log":
        require_speckit()
    source, *weights = series_files(project, table)
    trace = provenance(ready.configs, [*ready.inputs, source, *weights, *of_nodes])
    path.parent.mkdir(parents=True, exist_ok=True)
    with scratch_file(path) as felt, scratch_file(path) as made:
        by_area = np.concatenate([rows.read_out, rows.acceleration])
        sampled = sample_series(project, table, columns, by_area, where, felt)
        segment = welch_segment(sampled.samples - 2, sampled.step_s, sampled.highest_hz, table, ready.lowest_hz, source)
        with create(path, KIND, trace) as writer:
            kept = _through(ready.loop, in_time, sampled, table, made, where, step)
            series = Regular(
                kept.blocks, 3 * n, kept.samples, sampled.first_s + sampled.step_s, sampled.step_s, sampled.highest_hz
            )
            units, kinds = [unit(label) for label in labels], [kind(label) for label in labels]
            targets = [
                (family.of(label), one)
                for family in (KIND.SERIES, KIND.GRAVITY_SERIES, KIND.READ_OUT_SERIES)
                for label, one in zip(labels, units, strict=True)
            ]
            rms, peak, found = store(writer, series, targets, table.spectrum, segment)
            estimate = Estimate(found.frequency_hz, found.psd[:n], found.degrees_of_freedom)
            config = ready.config
            verdicts, unjudged = judge_all(estimate, labels, kinds, ready.requirements, config.safety_factor)
            total = SeriesResult(
                path, table.name, source, list(labels), units, kinds, rms[:n], peak[:n], series.first_s, series.step_s,
                series.samples, estimate, verdicts, unjudged, config.safety_factor, table.confidence,
                treatment_words(table, columns, sampled),
            )  # fmt: skip
            write_areas(writer, rows.areas, rows.area_id)
            write_result(writer, total, sampled.column)
            writer.write(KIND.READ_OUT_SET, rows.set_name)
            parts = ((KIND.GRAVITY_RMS, KIND.GRAVITY_PSD), (KIND.READ_OUT_RMS, KIND.READ_OUT_PSD))
            for g, (rms_of, psd_of) in enumerate(parts, start=1):
                writer.write(rms_of, rms[g * n : (g + 1) * n], units="see /output/unit")
                for o, (label, one) in enumerate(zip(labels, units, strict=True)):
                    writer.write(psd_of.of(label), found.psd[g * n + o], units=f"({one})^2/Hz")
    return SimulatedSeries(total, rms[n : 2 * n], rms[2 * n :], rows.set_name)


def _through(
    loop: Loop, in_time: TimeLoop, sampled: Sampled, table: SeriesTable, file: IO[bytes], where: str, step: Step
) -> Scratch:
    """Outputs [3 n] of every sample but the first and the last: together, of gravity, of the read-outs."""
    kept = Scratch(file, 3 * len(in_time.labels))
    advance = counter(step, sampled.samples - 2, f"series {table.name} through the loop")

    def signals() -> Iterator[FloatArray]:
        for _, block in sampled.blocks(table.remove):
            yield block.T

    try:
        for gravity, read_out in respond(
            in_time, np.eye(len(DISTURBANCES))[:, _FELT], signals(), sampled.step_s, (_GRAVITY, _READ_OUT)
        ):
            kept.add(np.concatenate([gravity + read_out, gravity, read_out]).T)
            advance(gravity.shape[1])
    except PhysicsError as error:  # samples that do not fit the periods of a sampled controller
        hint = f"{error.hint}: resample_s in {where}"
        raise InputError(f"{error.fact} ({loop.where})", where=where, hint=hint) from error
    return kept
