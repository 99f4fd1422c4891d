"""The thermal network as thermal.h5 has it, about its steady state: for gains, steps in time, comparisons."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tedm_cli.arrays import ComplexArray, FloatArray, IndexArray
from tedm_cli.contracts import THERMAL
from tedm_cli.files.store import Reader
from tedm_cli.noise.correlation_check import correlation_factor
from tedm_cli.thermal.linear import LinearNetwork, linearised, rows_of
from tedm_cli.thermal.network import ThermalNetwork
from tedm_cli.thermal.spectra import node_factor


@dataclass(frozen=True, eq=False)
class SteadyNetwork:
    """A network about its steady state.

    network, steady_K : [n] nodes. share : [u, n], of each disturbance. linear : of its free nodes.
    """

    network: ThermalNetwork
    steady_K: FloatArray
    share: FloatArray
    linear: LinearNetwork

    @property
    def boundary_share(self) -> FloatArray:
        """[b, u]: what each boundary follows of each disturbance."""
        return self.share[:, self.network.boundary].T


@dataclass(frozen=True, eq=False)
class DisturbedNetwork(SteadyNetwork):
    """A network about its steady state, and what disturbs it.

    Parameters
    ----------
    disturbance, kind : [u], names, and temperature (K) or power (W). factor : [u, m], of their correlation R = L Lᵀ.
    kept : [o], rows in `linear` of the nodes whose gains are known. frequency_hz : [F]. asd : [u, F].
    transfer : [F, o, u].
    """

    disturbance: list[str]
    kind: list[str]
    factor: FloatArray
    kept: IndexArray
    frequency_hz: FloatArray
    asd: FloatArray
    transfer: ComplexArray

    @property
    def psd(self) -> FloatArray:
        """Power spectral densities [o, F] of the kept nodes, K²/Hz."""
        driven = node_factor(self.transfer, self.asd, self.factor)
        return np.asarray(np.sum(driven.real**2 + driven.imag**2, axis=2).T)


def read_steady_network(file: Reader) -> SteadyNetwork:
    """The network of an open thermal.h5 that has gains, without them."""
    network = ThermalNetwork(
        tuple(file.strings(THERMAL.NODE_NAME)),
        np.array(file.strings(THERMAL.NODE_KIND)),
        file.array(THERMAL.NODE_CAPACITY),
        file.array(THERMAL.NODE_POWER),
        file.array(THERMAL.CONDUCTOR_A),
        file.array(THERMAL.CONDUCTOR_B),
        file.array(THERMAL.CONDUCTOR_GL),
        file.array(THERMAL.CONDUCTOR_GR),
    )
    steady, share = file.array(THERMAL.STEADY_K), file.array(THERMAL.DISTURBANCE_SHARE)
    return SteadyNetwork(network, steady, share, linearised(network, steady, share))


def read_network(file: Reader) -> DisturbedNetwork:
    """The network of an open thermal.h5 that has gains."""
    of = read_steady_network(file)
    return DisturbedNetwork(
        of.network,
        of.steady_K,
        of.share,
        of.linear,
        file.strings(THERMAL.DISTURBANCE_NAME),
        file.strings(THERMAL.DISTURBANCE_KIND),
        correlation_factor(file.array(THERMAL.DISTURBANCE_CORRELATION)),
        rows_of(of.linear.name, file.strings(THERMAL.NODE_FREE_NAME)),
        file.array(THERMAL.FREQUENCY),
        file.array(THERMAL.DISTURBANCE_ASD),
        file.array(THERMAL.TRANSFER),
    )
