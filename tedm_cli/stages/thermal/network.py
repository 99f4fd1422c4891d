"""The thermal network of a project: its steady state, gains from the disturbances, and spectra of its nodes."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tedm_cli.arrays import ComplexArray, FloatArray, IndexArray
from tedm_cli.config.cases import load_cases
from tedm_cli.config.project import Project
from tedm_cli.config.thermal.file import NetworkTable, ThermalConfig
from tedm_cli.config.thermal.network import read_network
from tedm_cli.errors import ConfigError, InputError
from tedm_cli.files.provenance import ConfigFile
from tedm_cli.noise.correlation_check import check_correlation, correlation_factor
from tedm_cli.noise.temperature import Spectrum
from tedm_cli.progress import Step, counter
from tedm_cli.thermal.linear import LinearNetwork, linearised, near_name, rows_of, shares
from tedm_cli.thermal.low_pass import LowPass, fitted
from tedm_cli.thermal.network import BOUNDARY
from tedm_cli.thermal.spectra import cross_spectra, node_factor
from tedm_cli.thermal.state import GivenNetwork
from tedm_cli.thermal.steady import SteadyState
from tedm_cli.thermal.transfer import static_gain, transfer

MOST_NODES = 200  # free nodes of which all spectra are kept
_MOST_BYTES = 2_000_000_000  # of gains, or of spectra


@dataclass(frozen=True, eq=False)
class Disturbed:
    """What disturbances do to the nodes.

    Parameters
    ----------
    share : [u, n]. spectra : u of them. frequency_hz : [F]. asd : [u, F]. correlation : [u, u].
    transfer : [F, o, u], K/K or K/W. static : [o, u]. low_pass : each [o, u].
    psd : [F, o, o] in K²/Hz, None of too many nodes.
    """

    share: FloatArray
    spectra: tuple[Spectrum, ...]
    frequency_hz: FloatArray
    asd: FloatArray
    correlation: FloatArray
    transfer: ComplexArray
    static: FloatArray
    low_pass: LowPass
    psd: ComplexArray | None


@dataclass(frozen=True, eq=False)
class SolvedNetwork:
    """The network, its steady state, and what disturbs it.

    kept : [o], rows of the nodes whose gains are kept. configs : read besides the file of the thermal model.
    """

    given: GivenNetwork
    steady: SteadyState
    linear: LinearNetwork
    kept: IndexArray
    disturbed: Disturbed | None
    configs: tuple[ConfigFile, ...]


def solved_network(
    project: Project,
    file: Path,
    table: NetworkTable,
    config: ThermalConfig,
    step: Step,
) -> SolvedNetwork:
    """Read the network of `file`, find its steady state, and the gains of its disturbances at every frequency.

    Raises
    ------
    InputError : what is wrong in tables; nodes of disturbances or outputs that are not there.
    PhysicsError : no steady state; correlations that are not positive semidefinite.
    """

    def path_of(name: str) -> Path:
        return project.beside(file, name)

    where = str(file)
    given = read_network(table, path_of)
    steady = given.steady()
    network = given.network
    share = shares(network, [d.place() for d in config.disturbances], where=where)
    linear = linearised(network, steady.temperature_K, share)
    kept = _kept(given, config, where)
    if not config.disturbances:
        return SolvedNetwork(given, steady, linear, kept, None, ())
    configs: tuple[ConfigFile, ...] = ()
    if config.frequency is not None:
        frequency = config.frequency.frequency_hz()
    else:
        cases_file, cases = load_cases(project.cases)
        frequency, configs = cases.frequency_hz(), (cases_file,)
    low, high = float(frequency[0]), float(frequency[-1])
    facts = [(f"disturbance[{i}].order", d.implausible(low, high)) for i, d in enumerate(config.disturbances)]
    if problems := [(at, fact) for at, fact in facts if fact]:
        raise ConfigError(problems, where=where)
    names = [d.name for d in config.disturbances]
    correlation = config.correlation()
    check_correlation(correlation, names=names, where=f"{where}: [[correlation]]")
    spectra = tuple(d.own_spectrum(path_of) for d in config.disturbances)
    asd = np.stack([spectrum.amplitude(frequency) for spectrum in spectra])
    outputs = rows_of(linear.name, [network.name[row] for row in kept])
    _require_room(len(frequency) * len(kept) * len(names), "gains", len(kept), where)
    gains = transfer(linear, frequency, outputs, counter(step, len(frequency), "gains"))
    psd = None
    if len(kept) <= MOST_NODES:
        _require_room(len(frequency) * len(kept) ** 2, "spectra", len(kept), where)
        psd = cross_spectra(node_factor(gains, asd, correlation_factor(correlation)))
    static, low_pass = static_gain(linear, outputs), fitted(gains, frequency)
    disturbed = Disturbed(share, spectra, frequency, asd, correlation, gains, static, low_pass, psd)
    return SolvedNetwork(given, steady, linear, kept, disturbed, configs)


def _kept(given: GivenNetwork, config: ThermalConfig, where: str) -> IndexArray:
    """All free nodes, or, of a large network, those of [output]."""
    network = given.network
    wanted = () if config.output is None else config.output.nodes
    for number, name in enumerate(wanted):
        row = network.row.get(name)
        at = f"output.nodes[{number}]"
        if row is None:
            raise InputError(f"{at}: no node is called {name!r}", where=where, hint=near_name(name, network.name))
        if network.kind[row] == BOUNDARY:
            fact = f"{at}: {name!r} is a boundary: its temperature is no output"
            raise InputError(fact, where=where, hint="leave it out")
    if not wanted or len(network.free) <= MOST_NODES:
        return network.free
    return np.array([network.row[name] for name in wanted], dtype=np.intp)


def _require_room(numbers: int, what: str, nodes: int, where: str) -> None:
    size = 16 * numbers
    if size > _MOST_BYTES:
        raise InputError(
            f"the {what} of {nodes:,} nodes take {size / 1e9:.3g} GB; at most {_MOST_BYTES / 1e9:g} GB are kept",
            where=where,
            hint="name fewer nodes in [output], or give fewer frequencies in [frequency]",
        )
