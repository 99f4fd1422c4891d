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
from tedm_cli.noise.network_system import NetworkSystem
from tedm_cli.noise.selection import listed
from tedm_cli.noise.temperature import TemperatureModel
from tedm_cli.results.cases.noise import NETWORK
from tedm_cli.results.outputs import ModelOutputs
from tedm_cli.results.thermal.gains import NetworkGains, network_gains
from tedm_cli.results.thermal.nodes import REBUILD, left_out, open_nodes, outputs_by_nodes
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
    require_thermal_model(project, config, case_id)
    assert project.thermal is not None
    _require_possible(project, config, load_thermal(project.thermal)[1], case_id)
    with open_nodes(project, outputs, f"case {case_id}") as (thermal, file):
        if not file.has(THERMAL.TRANSFER):
            raise InputError("has no gains", where=str(file.path), hint=f"rebuild it with {REBUILD}")
        return _columns(file, project, config, thermal, outputs, temperature)


def require_thermal_model(project: Project, config: CasesConfig, *case_ids: str) -> None:
    """Refuse those of the cases that are of the thermal network, where the project has none: `ConfigError`."""
    if project.thermal is not None:
        return
    fact = 'the project has no thermal model (thermal = "thermal.toml" in its file)'
    problems = [
        (f"case[{number}].thermal", fact)
        for number, table in enumerate(config.cases)
        if table.id in case_ids and table.thermal is not None
    ]
    if problems:
        raise ConfigError(problems, where=str(project.cases), hint="name one, or delete the case")


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
    project: Project,
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
    known = _gains(file, nodes, place) * file.array(THERMAL.DISTURBANCE_ASD)[:, place].T
    gains = network_gains(file, project, thermal, nodes)
    network = _WithAreas(gains, temperature, left, outputs.areas.name[left].tolist())
    noise = _noise(file, known, frequency, network, by_nodes.areas)
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


@dataclass(frozen=True, eq=False)
class _WithAreas:
    """The network, and areas [n] of the model with a spectrum of their own, uncorrelated with all else, behind it."""

    gains: NetworkGains
    temperature: TemperatureModel
    area: IndexArray
    names: Sequence[str]

    def driven(self, frequency_hz: FloatArray) -> ComplexArray:
        """D [n_m + n, F, u + n] in K/√Hz."""
        return self.beside(self.gains.driven(frequency_hz), frequency_hz)

    def amplitudes(self, frequency_hz: FloatArray) -> FloatArray:
        """Amplitude spectral densities [u + n, F] of the disturbances."""
        return np.concatenate([self.gains.amplitudes(frequency_hz), self._own(frequency_hz)])

    def linear_system(self, where: str) -> NetworkSystem:
        """As a linear system, each area a disturbance of its own."""
        of, n = self.gains.linear_system(where), len(self.area)
        k, u = of.d.shape
        spectra = tuple(self.temperature.spectrum(i) for i in self.area.tolist())
        return NetworkSystem(
            of.a,
            np.pad(of.b, ((0, 0), (0, n))),
            np.pad(of.c, ((0, n), (0, 0))),
            np.block([[of.d, np.zeros((k, n))], [np.zeros((n, u)), np.eye(n)]]),
            (*of.spectra, *spectra),
        )

    def beside(self, driven: ComplexArray, frequency_hz: FloatArray) -> ComplexArray:
        """D [n_m + n, F, u + n] of the areas behind the nodes' [n_m, F, u]."""
        (m, f, u), n = driven.shape, len(self.area)
        whole: ComplexArray = np.zeros((m + n, f, u + n), dtype=np.complex128)
        whole[:m, :, :u] = driven
        for i, amplitude in enumerate(self._own(frequency_hz)):
            whole[m + i, :, u + i] = amplitude
        return whole

    def _own(self, frequency_hz: FloatArray) -> FloatArray:
        return self.temperature.amplitudes(frequency_hz)[self.area]


def _noise(
    file: Reader, known: ComplexArray, frequency: FloatArray, network: _WithAreas, areas: AreaTable
) -> NetworkNoise:
    """Noise of the nodes, driven as `known` [n_m, F, u], and of areas with spectra of their own."""
    names, correlation = file.strings(THERMAL.DISTURBANCE_NAME), file.array(THERMAL.DISTURBANCE_CORRELATION)
    u, n = len(names), len(network.area)
    driven = network.beside(known, frequency)
    whole = np.eye(u + n)
    whole[:u, :u] = correlation
    blocks, factor, column_block = _blocks(driven, whole)
    told = f"{NETWORK}: {count(len(known), 'node')} on the model, {count(u, 'disturbance')} ({', '.join(names)})"
    if n:
        told += f"; {count(n, 'area')} that the map leaves out with a spectrum of its own each: {listed(network.names)}"
    return NetworkNoise(
        driven, frequency, (*names, *network.names), factor, blocks, column_block, np.asarray(areas.gradient), told,
        network,
    )  # fmt: skip


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
