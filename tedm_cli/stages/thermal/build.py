"""build-thermal: steady state, gains and spectra of the thermal network, and what its nodes do to the outputs."""

from __future__ import annotations

import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tedm_cli.config.project import Project
from tedm_cli.config.thermal.file import ThermalConfig, load_thermal
from tedm_cli.contracts import THERMAL as KIND
from tedm_cli.errors import ConfigError, PhysicsError
from tedm_cli.files.build_folder import THERMAL_FILE, provenance
from tedm_cli.files.store import Writer, create, open_checked
from tedm_cli.progress import Step
from tedm_cli.results.thermal.file import ThermalResults, read_thermal
from tedm_cli.stages.common import out_path
from tedm_cli.stages.thermal.map import NodeSensitivity, node_sensitivity
from tedm_cli.stages.thermal.map_names import names_of_both
from tedm_cli.stages.thermal.network import Disturbed, SolvedNetwork, solved_network

_NOTHING = "give the network, the map on the model, or both"


@dataclass(frozen=True, eq=False)
class ThermalSummary:
    """The file, what it says, the time that it took, and sentences on what it lacks."""

    path: Path
    results: ThermalResults
    seconds: float
    notes: tuple[str, ...]


def build_thermal(project: Project, output: Path | None, step: Step) -> ThermalSummary:
    """Write thermal.h5 with all that the configuration has the makings of.

    Raises
    ------
    ConfigError : the project has no thermal model, or one of which nothing can be made.
    InputError, PhysicsError : as `solved_network` and `node_sensitivity` do.
    """
    begin = time.perf_counter()
    path = project.required_thermal()
    file, config = load_thermal(path)
    solved = None
    if config.network is not None:
        try:
            solved = solved_network(project, path, config.network, config, step)
        except PhysicsError as error:  # the solver knows nodes, and no file
            error.where = error.where or str(path)
            raise
    mapped = node_sensitivity(project, config)
    if solved is None and mapped is None:
        raise ConfigError([("", "there is no [network] and no [map]")], where=str(path), hint=_NOTHING)
    notes = []
    if mapped is not None and mapped.why:
        notes.append(f"no outputs per kelvin of the thermal nodes: {mapped.why}")
    if solved is not None and mapped is not None and mapped.node:
        notes += names_of_both(solved.given.network.name, mapped.node)
    inputs = [*(project.beside(path, name) for name in config.file_names()), *(() if mapped is None else mapped.inputs)]
    configs = [file, *(() if solved is None else solved.configs), *(() if mapped is None else mapped.configs)]
    out = out_path(project, THERMAL_FILE, output)
    with create(out, KIND, provenance(configs, inputs)) as writer:
        if solved is not None:
            _write_network(writer, solved)
            if solved.disturbed is not None:
                _write_disturbed(writer, config, solved.disturbed)
        if mapped is not None and mapped.node:
            _write_mapped(writer, mapped)
        if solved is not None and mapped is not None:
            _write_warmed(writer, solved, mapped)
    with open_checked(out, KIND) as written:
        results = read_thermal(written)
    return ThermalSummary(out, results, time.perf_counter() - begin, tuple(notes))


def _write_network(writer: Writer, solved: SolvedNetwork) -> None:
    network = solved.given.network
    writer.write(KIND.NODE_NAME, list(network.name))
    writer.write(KIND.NODE_KIND, network.kind.tolist())
    writer.write(KIND.NODE_CAPACITY, np.where(network.boundary, 0.0, network.capacity))
    writer.write(KIND.NODE_POWER, network.power)
    writer.write(KIND.NODE_NET_HEAT, solved.steady.net_heat)
    writer.write(KIND.STEADY_K, solved.steady.temperature_K)
    writer.write(KIND.NODE_SOLVED, solved.steady.solved.astype(np.int64))
    writer.write(KIND.CONDUCTOR_A, network.node_a)
    writer.write(KIND.CONDUCTOR_B, network.node_b)
    writer.write(KIND.CONDUCTOR_GL, network.linear)
    writer.write(KIND.CONDUCTOR_GR, network.radiative)
    writer.write(KIND.NODE_FREE, solved.kept)
    writer.write(KIND.NODE_FREE_NAME, [network.name[row] for row in solved.kept])
    if np.isfinite(solved.given.place).any():
        writer.write(KIND.NODE_POSITION, solved.given.place)


def _write_disturbed(writer: Writer, config: ThermalConfig, found: Disturbed) -> None:
    writer.write(KIND.DISTURBANCE_NAME, [d.name for d in config.disturbances])
    writer.write(KIND.DISTURBANCE_KIND, [d.kind for d in config.disturbances])
    writer.write(KIND.DISTURBANCE_SPECTRUM, [spectrum.words() for spectrum in found.spectra])
    writer.write(KIND.DISTURBANCE_SHARE, found.share)
    writer.write(KIND.DISTURBANCE_ASD, found.asd)
    writer.write(KIND.DISTURBANCE_CORRELATION, found.correlation)
    writer.write(KIND.FREQUENCY, found.frequency_hz)
    writer.write(KIND.TRANSFER, found.transfer)
    writer.write(KIND.STATIC_GAIN, found.static)
    writer.write(KIND.FILTER_ORDER, found.low_pass.order)
    writer.write(KIND.FILTER_CORNER, found.low_pass.corner_hz)
    writer.write(KIND.FILTER_ERROR, found.low_pass.error)
    if found.psd is not None:
        writer.write(KIND.PSD, found.psd)


def _write_mapped(writer: Writer, mapped: NodeSensitivity) -> None:
    writer.write(KIND.MAP_NODE, mapped.node)
    writer.write(KIND.MAP_AREA, mapped.area)
    if mapped.why:
        return
    writer.write(KIND.ROW_LABEL, mapped.label)
    writer.write(KIND.ROW_UNIT, mapped.unit)
    writer.write(KIND.SENSITIVITY, mapped.value, units="see /row/unit")


def _write_warmed(writer: Writer, solved: SolvedNetwork, mapped: NodeSensitivity) -> None:
    """The steady state on the grids, where every node of the map is in the network."""
    row = solved.given.network.row
    if mapped.through is not None and all(name in row for name in mapped.node):
        tau = solved.steady.temperature_K[[row[name] for name in mapped.node]]
        writer.write(KIND.MAP_GRID, mapped.grid_id)
        writer.write(KIND.MAP_STEADY_K, mapped.through.temperatures(tau[:, None])[:, 0])
