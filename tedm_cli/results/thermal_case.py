"""What a case of the thermal network is made of: its nodes on the model as columns, and their noise."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import scipy

from tedm_cli.arrays import ComplexArray, FloatArray, IndexArray
from tedm_cli.config.cases import CasesConfig
from tedm_cli.config.project import Project
from tedm_cli.config.thermal.file import ThermalConfig, load_thermal
from tedm_cli.contracts import THERMAL
from tedm_cli.errors import ConfigError, InputError
from tedm_cli.files.store import Reader
from tedm_cli.noise.areas import AreaTable
from tedm_cli.noise.correlation_check import correlation_factor
from tedm_cli.noise.network import NetworkNoise, places_of
from tedm_cli.noise.selection import listed
from tedm_cli.noise.temperature import TemperatureModel
from tedm_cli.results.noise import NETWORK
from tedm_cli.results.outputs import ModelOutputs
from tedm_cli.results.thermal_nodes import REBUILD, left_out, open_nodes, outputs_by_nodes
from tedm_cli.results.wording import count


@dataclass(frozen=True, eq=False)
class ThermalColumns:
    """Outputs by thermal nodes, and last by the areas that the map leaves out, and the noise of these temperatures.

    area : [k], the area of the model that each column is in; -1: none. sources : the files read.
    """

    outputs: ModelOutputs
    noise: NetworkNoise
    area: IndexArray
    sources: tuple[Path, ...]


def thermal_columns(
    project: Project, config: CasesConfig, case_id: str, outputs: ModelOutputs, temperature: TemperatureModel
) -> ThermalColumns:
    """The columns of a case of the thermal network.

    Parameters
    ----------
    outputs, temperature : of the model's areas, without differences.

    Raises
    ------
    ConfigError : the project has no thermal model, or one without network, disturbances or map; effects of the user's
        own and gradients within areas, which follow areas.
    InputError : thermal.h5 is missing or stale, or lacks frequencies, outputs or nodes.
    """
    case = next(number for number, table in enumerate(config.cases) if table.id == case_id)
    if project.thermal is None:
        fact = 'the project has no thermal model (thermal = "thermal.toml" in its file)'
        raise ConfigError([(f"case[{case}].thermal", fact)], where=str(project.cases))
    thermal = load_thermal(project.thermal)[1]
    _require_possible(project, config, thermal, case_id)
    with open_nodes(project, outputs, f"case {case_id}") as (thermal, file):
        if not file.has(THERMAL.TRANSFER):
            raise InputError("has no gains", where=str(file.path), hint=f"rebuild it with {REBUILD}")
        return _columns(file, config, thermal, outputs, temperature)


def _require_possible(project: Project, config: CasesConfig, thermal: ThermalConfig, case_id: str) -> None:
    assert project.thermal is not None
    lacking = [
        what
        for what, there in (
            ("[network]", thermal.network),
            ("[[disturbance]]", thermal.disturbances),
            ("[map]", thermal.map),
        )
        if not there
    ]
    if lacking:
        fact = f"has no {' and no '.join(lacking)}, which case {case_id} is made of"
        raise ConfigError([("", fact)], where=str(project.thermal))
    within = config.within(case_id)
    if within:
        fact = f"case {case_id} has the thermal network, whose nodes tell gradients; name the `cases` of this table"
        raise ConfigError([(f"temperature.within[{n}]", fact) for n in within], where=str(project.cases))


def _columns(
    file: Reader,
    config: CasesConfig,
    thermal: ThermalConfig,
    outputs: ModelOutputs,
    temperature: TemperatureModel,
) -> ThermalColumns:
    assert thermal.map is not None
    frequency = config.frequency_hz()
    place = _places(file, frequency)
    nodes = file.strings(THERMAL.MAP_NODE)
    left = left_out(thermal, outputs.areas, temperature.heard)
    by_nodes, area = outputs_by_nodes(file, outputs, left)
    own = temperature.amplitudes(frequency)[left]
    noise = _noise(file, nodes, place, frequency, own, outputs.areas.name[left].tolist(), by_nodes.areas)
    return ThermalColumns(by_nodes, noise, area, (file.path,))


def _places(file: Reader, wanted: FloatArray) -> IndexArray:
    """Where the frequencies of the cases are among those of the file."""
    have = file.array(THERMAL.FREQUENCY)
    place, missing = places_of(wanted, have)
    if missing.size:
        raise InputError(
            f"has no gains at {count(len(missing), 'frequency', 'frequencies')} of the cases, the first"
            f" {missing[0]:g} Hz; it has {len(have)} from {have[0]:g} to {have[-1]:g} Hz",
            where=str(file.path),
            hint="leave [frequency] out of the thermal model's file: then it has those of the cases; rebuild it with"
            f" {REBUILD}",
        )
    return place


def _noise(
    file: Reader,
    nodes: Sequence[str],
    place: IndexArray,
    frequency: FloatArray,
    own: FloatArray,
    own_names: Sequence[str],
    areas: AreaTable,
) -> NetworkNoise:
    """Noise of the nodes, and of areas with amplitudes `own` [n, F]."""
    asd = file.array(THERMAL.DISTURBANCE_ASD)[:, place]
    names, correlation = file.strings(THERMAL.DISTURBANCE_NAME), file.array(THERMAL.DISTURBANCE_CORRELATION)
    gain = _gains(file, nodes, place)
    u, n, k = len(names), len(own), len(areas)
    driven: ComplexArray = np.zeros((k, len(frequency), u + n), dtype=np.complex128)
    driven[: len(nodes), :, :u] = gain * asd.T
    for i, amplitude in enumerate(own):
        driven[len(nodes) + i, :, u + i] = amplitude
    whole = np.eye(u + n)
    whole[:u, :u] = correlation
    blocks, factor, column_block = _blocks(driven, whole)
    told = f"{NETWORK}: {count(len(nodes), 'node')} on the model, {count(u, 'disturbance')} ({', '.join(names)})"
    if n:
        told += f"; {count(n, 'area')} that the map leaves out with a spectrum of its own each: {listed(own_names)}"
    return NetworkNoise(
        driven, frequency, (*names, *own_names), factor, blocks, column_block, np.asarray(areas.gradient), told
    )


def _gains(file: Reader, nodes: Sequence[str], place: IndexArray) -> ComplexArray:
    """H [n_m, F, u] of the nodes on the model; boundaries follow the temperatures that are given to them."""
    kept = {name: row for row, name in enumerate(file.strings(THERMAL.NODE_FREE_NAME))}
    known = file.strings(THERMAL.NODE_NAME)
    kind = dict(zip(known, file.strings(THERMAL.NODE_KIND), strict=True))
    unknown = [name for name in nodes if name not in kind]
    if unknown:
        fact = f"{count(len(unknown), 'node')} of the map not in the network: {listed(unknown)}"
        raise InputError(fact, where=str(file.path), hint="name the nodes of [map] as the network does")
    silent = [name for name in nodes if name not in kept and kind[name] != "boundary"]
    if silent:
        fact = f"has no gains of {count(len(silent), 'node')} of the map: {listed(silent)}"
        raise InputError(fact, where=str(file.path), hint="add them to [output] nodes of the thermal model")
    share = file.array(THERMAL.DISTURBANCE_SHARE)
    transfer = file.array(THERMAL.TRANSFER)[place]
    gain = np.empty((len(nodes), len(place), transfer.shape[2]), dtype=np.complex128)
    for i, name in enumerate(nodes):
        gain[i] = transfer[:, kept[name]] if name in kept else share[:, known.index(name)]
    return gain


def _blocks(driven: ComplexArray, correlation: FloatArray) -> tuple[tuple[IndexArray, ...], FloatArray, IndexArray]:
    """Columns that are driven together, L with R = L Lᵀ, and the block that each column of L drives."""
    k, u = len(driven), driven.shape[2]
    drives = driven.any(axis=1)
    links = np.block([[np.zeros((k, k)), drives], [np.zeros((u, k)), correlation != 0.0]])
    label = scipy.sparse.csgraph.connected_components(scipy.sparse.csr_array(links), directed=False)[1]
    felt = [b for b in dict.fromkeys(label[:k].tolist()) if (label[k:] == b).any()]
    # A disturbance that no column feels is in no block; it has no part in any output.
    factor = np.zeros((u, 0))
    column_block: list[int] = []
    for number, b in enumerate(felt):
        mine = np.flatnonzero(label[k:] == b)
        found = correlation_factor(correlation[np.ix_(mine, mine)]) if len(mine) > 1 else np.ones((1, 1))
        part = np.zeros((u, found.shape[1]))
        part[mine] = found
        factor = np.concatenate([factor, part], axis=1)
        column_block += [number] * part.shape[1]
    blocks = tuple(np.flatnonzero(label[:k] == b) for b in felt)
    return blocks, factor, np.array(column_block, dtype=np.intp)
