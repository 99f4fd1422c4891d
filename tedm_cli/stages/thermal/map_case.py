"""Temperatures of thermal nodes that go with the noise of an output in a case of the thermal network."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tedm_cli.arrays import FloatArray
from tedm_cli.config.cases import load_cases
from tedm_cli.config.project import Project
from tedm_cli.config.temperature.tables import temperature_model
from tedm_cli.contracts import CASE
from tedm_cli.errors import InputError, UsageError
from tedm_cli.files.build_folder import case_file_name, require_input
from tedm_cli.files.provenance import input_files
from tedm_cli.files.store import open_checked
from tedm_cli.noise.network import NetworkOutputs
from tedm_cli.results.outputs import read_outputs
from tedm_cli.results.thermal.case import thermal_columns
from tedm_cli.results.thermal.case_shares import of_network
from tedm_cli.stages.common import known_name
from tedm_cli.stages.thermal.map_tau import Given

TYPICAL = "typical"
PATTERN_UNIT = "K/√Hz"


@dataclass(frozen=True)
class OfCase:
    """A case of the thermal network, and one of its outputs; without one, that of its worst verdict."""

    case: str
    output: str | None


@dataclass(frozen=True, eq=False)
class Pattern:
    """Sets of temperatures of `node`, K/√Hz, of which files they are, and what they are in words."""

    node: list[str]
    given: Given
    inputs: list[Path]
    words: str

    def of(self, nodes: list[str]) -> Given:
        """The sets of the nodes of a map, which are all there; areas with a spectrum of their own are not."""
        row = {name: i for i, name in enumerate(self.node)}
        return Given(self.given.name, self.given.tau[[row[name] for name in nodes]])


def case_pattern(project: Project, of: OfCase) -> Pattern:
    """Temperatures that go with one standard amplitude σ of an output, on average, and the disturbances' parts in them.

    E[ΔT | y = σ] is the sum over disturbances of Re(D_d (R yᴴ)_d)/σ, with y = s D of the output, in K/√Hz, at the
    frequency that the case file has for the output. What a part makes of the output is the disturbance's in the PSD,
    over σ.

    Raises
    ------
    UsageError : a case of areas, an output that there is not, or one without noise.
    InputError : the case has not been run, or not on the network that there is.
    """
    path = project.build_dir / case_file_name(of.case)
    config = load_cases(project.cases)[1]
    config.case_table(of.case, where=str(project.cases))
    if not path.exists():
        hint = f"make it with `tedm run-case {of.case}`, or `tedm run`"
        raise InputError("no such file", where=str(path), hint=hint)
    outputs = read_outputs(project)
    with open_checked(path, CASE) as file:
        if not of_network(file):
            fact = f"case {of.case} is of areas: their temperatures are no fields of thermal nodes"
            raise UsageError(fact, hint="name a case of the thermal network")
        labels, worst = file.strings(CASE.OUTPUT_LABEL), file.array(CASE.VERDICT_RATIO)
        first = file.strings(CASE.VERDICT_OUTPUT)[int(worst.argmax())] if worst.size else labels[0]
        label = known_name(f"output of {path.name}", of.output or first, labels)
        hz = file.array(CASE.CONTRIBUTION_FREQUENCY)[[labels.index(label)]]
        temperature = temperature_model(project, config, outputs.areas)
        columns = thermal_columns(project, config, of.case, outputs, temperature)
        for used in input_files(columns.sources):
            require_input(file, used)
    found = columns.outputs.with_differences(config.applied_requirements())
    known_name(f"output of {project.cases}", label, found.labels)  # a difference that is required no more is none
    rows = found.rows[[found.labels.index(label)]]
    parts = _parts(columns.noise.at(hz).outputs(rows, hz))
    if not parts.any():
        raise UsageError(f"{label} has no noise in case {of.case}")
    causes = list(columns.noise.disturbances)
    names = [TYPICAL if TYPICAL not in causes else f"{TYPICAL}_of_all", *causes]
    at = f"{1e3 * hz[0]:.4g} mHz"
    words = f"temperatures that go with one amplitude of {label} in case {of.case} at {at}, {PATTERN_UNIT}"
    tau = np.concatenate([parts.sum(axis=1, keepdims=True), parts], axis=1)
    return Pattern(found.areas.name.tolist(), Given(names, tau), [path, *columns.sources], words)


def _parts(noise: NetworkOutputs) -> FloatArray:
    """[k, u] of one output at one frequency."""
    drive = noise.source.driven[:, 0]
    asd = float(np.sqrt(noise.psd()[0, 0]))
    if asd == 0.0:
        return np.zeros(drive.shape)
    together = noise.source.factor @ noise.fields[0, 0].conj()  # R yᴴ [u]
    return np.asarray((drive * together).real / asd)
