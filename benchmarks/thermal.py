"""Gains of thermal networks: time and memory by the number of nodes, with local conductors and with far radiation.

python -m benchmarks.thermal [NODES ...]: panels of 16 x 16 nodes in a stack, each conducting in its plane, joined to
the next at its edges and radiating to the nodes that face it; with far radiation, that many links more between any two.
"""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import scipy

from benchmarks.process import memory
from benchmarks.timing import Result, timed
from tedm_cli.thermal.linear import LinearNetwork, Place, linearised, shares
from tedm_cli.thermal.low_pass import fitted
from tedm_cli.thermal.network import ThermalNetwork
from tedm_cli.thermal.solving import factorised
from tedm_cli.thermal.steady import steady_state
from tedm_cli.thermal.transfer import transfer

NODES, FREQUENCIES, DISTURBANCES = 5000, 300, 20
_SIDE = 16


@dataclass(frozen=True)
class Line:
    """Seconds of a piece of work, of the clock and of the processor, and the peak of memory since the beginning."""

    work: str
    nodes: int
    seconds: float
    processor_s: float
    peak_mb: float


def stack(nodes: int, far: int = 0) -> ThermalNetwork:
    """About `nodes` free nodes, and a boundary at each end of the stack."""
    panels = max(2, round(nodes / _SIDE**2))
    at = np.arange(panels * _SIDE**2).reshape(panels, _SIDE, _SIDE)
    n = at.size
    rng = np.random.default_rng(1)
    edges = np.zeros((_SIDE, _SIDE), dtype=bool)
    edges[[0, -1]] = edges[:, [0, -1]] = True
    local = [(at[:, 1:], at[:, :-1]), (at[:, :, 1:], at[:, :, :-1]), (at[1:, edges], at[:-1, edges])]
    facing = [(at[1:], at[:-1]), (at[0], np.full_like(at[0], n)), (at[-1], np.full_like(at[0], n + 1))]
    pairs = [np.stack([a.ravel(), b.ravel()]) for a, b in (*local, *facing)]
    links = rng.integers(0, n, (2, far))
    ends = np.concatenate([*pairs, links[:, links[0] != links[1]]], axis=1)
    conducting = sum(p.shape[1] for p in pairs[: len(local)])
    linear, radiative = np.zeros(ends.shape[1]), np.zeros(ends.shape[1])
    linear[:conducting] = 10.0 ** rng.uniform(-2.0, 0.0, conducting)
    radiative[conducting:] = 10.0 ** rng.uniform(-4.0, -2.0, ends.shape[1] - conducting)
    kind = np.array(["diffusive"] * n + ["boundary"] * 2)
    capacity = np.concatenate([10.0 ** rng.uniform(0.0, 3.0, n), np.zeros(2)])
    power = np.concatenate([rng.uniform(0.0, 0.02, n), np.zeros(2)])
    return ThermalNetwork(
        tuple(f"N{i}" for i in range(n + 2)), kind, capacity, power, ends[0], ends[1], linear, radiative
    )


def disturbed(network: ThermalNetwork) -> LinearNetwork:
    """The network about its steady state, with both boundaries and powers of blocks of nodes as disturbances."""
    n = len(network) - 2
    given = np.full(n + 2, np.nan)
    given[n:] = 293.0, 3.0
    temperature = steady_state(network, given, np.full(n + 2, np.nan), where="stack").temperature_K
    blocks = np.array_split(np.arange(n), DISTURBANCES - 2)
    places = [Place("temperature", (f"N{n + i}",), (1.0,)) for i in (0, 1)]
    places += [Place("power", tuple(f"N{i}" for i in b), (1.0 / len(b),) * len(b)) for b in blocks]
    return linearised(network, temperature, shares(network, places, where="stack"))


def lines(nodes: int) -> Iterator[Line]:
    """Steady state, gains at all frequencies, the low-passes, and one factorisation with far radiation."""
    f = np.geomspace(1e-5, 0.1, FREQUENCIES)
    clock = _Clock()
    network = disturbed(stack(nodes))
    count = len(network.name)
    yield clock.line("steady state", count)
    clock = _Clock()
    gains = transfer(network, f)
    yield clock.line(f"gains, {FREQUENCIES} frequencies", count)
    clock = _Clock()
    fitted(gains, f)
    yield clock.line("low-passes", count)
    del gains
    for far in (nodes // 5, nodes):
        dense = disturbed(stack(nodes, far))
        matrix = dense.conductance + 2e-3j * np.pi * scipy.sparse.diags_array(dense.capacity).tocsc()
        clock = _Clock()
        factorised(matrix)
        yield clock.line(f"one factorisation, {far:,} far links", count)


class _Clock:
    def __init__(self) -> None:
        self._start, self._processor = time.perf_counter(), time.process_time()

    def line(self, work: str, nodes: int) -> Line:
        seconds, processor = time.perf_counter() - self._start, time.process_time() - self._processor
        return Line(work, nodes, seconds, processor, memory()["VmHWM"] / 1e3)


def against_default_order(frequencies: int = 5) -> Result:
    """Gains of some 5,000 nodes from 20 disturbances, against SciPy's solver in the order that it takes by itself."""
    network = disturbed(stack(NODES))
    f = np.geomspace(1e-5, 0.1, frequencies)
    diagonal = scipy.sparse.diags_array(network.capacity).tocsc()
    right = network.disturbed.astype(np.complex128)

    def peer() -> object:
        return [scipy.sparse.linalg.splu(network.conductance + 2j * np.pi * x * diagonal).solve(right) for x in f]

    return timed(lambda: transfer(network, f), peer, runs=3, each=(frequencies, "frequency"))


def main() -> None:
    numbers = [int(word) for word in sys.argv[1:]] or [1250, 2500, 5000, 10000]
    print(f"{'':42} {'nodes':>6} {'seconds':>9} {'processor':>9} {'peak MB':>9} {'load':>5}", flush=True)
    for nodes in numbers:
        for line in lines(nodes):
            told = f"{line.nodes:6} {line.seconds:9.2f} {line.processor_s:9.2f} {line.peak_mb:9.0f}"
            print(f"{line.work:42} {told} {os.getloadavg()[0]:5.1f}", flush=True)


if __name__ == "__main__":
    main()
