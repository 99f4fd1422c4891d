"""Gains of the thermal network at frequencies that thermal.h5 does not have, from the network that it holds."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tedm_cli.arrays import ComplexArray, FloatArray, IndexArray
from tedm_cli.config.project import Project
from tedm_cli.config.thermal.file import ThermalConfig
from tedm_cli.errors import InputError
from tedm_cli.files.store import Reader
from tedm_cli.noise.network_system import NetworkSystem
from tedm_cli.noise.temperature import Spectrum
from tedm_cli.results.thermal.disturbed_network import read_steady_network
from tedm_cli.thermal.linear import LinearNetwork, rows_of
from tedm_cli.thermal.stepping import SMALL, eliminated
from tedm_cli.thermal.transfer import transfer


@dataclass(frozen=True, eq=False)
class NetworkGains:
    """The network about its steady state, as far as some of its nodes [n_m] feel it.

    Parameters
    ----------
    free : which of the n_m nodes are no boundaries; row : their rows in `linear`, as many.
    given : [n_m, u], of boundaries the temperatures that they are given; 0 of others.
    spectra : [u], of the disturbances.
    """

    linear: LinearNetwork
    free: IndexArray
    row: IndexArray
    given: FloatArray
    spectra: tuple[Spectrum, ...]

    def driven(self, frequency_hz: FloatArray) -> ComplexArray:
        """Gain times amplitude spectral density of each disturbance, D [n_m, F, u] in K/√Hz."""
        asd = self.amplitudes(frequency_hz)
        found: ComplexArray = np.zeros((len(self.given), len(frequency_hz), len(self.spectra)), dtype=np.complex128)
        found[:] = self.given[:, None, :]
        found[self.free] = transfer(self.linear, frequency_hz, self.row).transpose(1, 0, 2)
        found *= asd.T
        return found

    def linear_system(self, where: str) -> NetworkSystem:
        """The same as a linear system; `InputError` that names `where` for too many nodes."""
        reduced = eliminated(self.linear)
        n, u = reduced.disturbed.shape
        if n > SMALL:
            raise InputError(
                f"the thermal network has {n:,} nodes with a heat capacity, each of them a state; at most {SMALL} are"
                " taken",
                where=where,
                hint="its spectra are exact for any number: leave this out, or join nodes",
            )
        c, d = np.zeros((len(self.given), n)), self.given.copy()
        by_state, at_once = (
            reduced.all_nodes(np.eye(n), np.zeros((u, n))),
            reduced.all_nodes(np.zeros((n, u)), np.eye(u)),
        )
        c[self.free], d[self.free] = by_state[self.row], at_once[self.row]
        per_capacity = 1.0 / reduced.capacity[:, None]
        return NetworkSystem(
            -per_capacity * reduced.conductance.toarray(), per_capacity * reduced.disturbed, c, d, self.spectra
        )

    def amplitudes(self, frequency_hz: FloatArray) -> FloatArray:
        """Amplitude spectral densities [u, F] of the disturbances, K/√Hz or W/√Hz."""
        return np.stack([spectrum.amplitude(frequency_hz) for spectrum in self.spectra])


def network_gains(file: Reader, project: Project, config: ThermalConfig, nodes: Sequence[str]) -> NetworkGains:
    """The network of an open thermal.h5 that was made with `config`; `nodes` are all in it."""
    assert project.thermal is not None
    where = project.thermal

    def path_of(name: str) -> Path:
        return project.beside(where, name)

    steady = read_steady_network(file)
    at = rows_of(steady.network.name, nodes)
    fixed = steady.network.boundary[at]
    free = np.flatnonzero(~fixed)
    return NetworkGains(
        steady.linear,
        free,
        rows_of(steady.linear.name, [nodes[i] for i in free]),
        np.where(fixed[:, None], steady.share[:, at].T, 0.0),
        tuple(d.own_spectrum(path_of) for d in config.disturbances),
    )
