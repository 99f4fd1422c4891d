"""Small thermal networks, and networks made of plain lists."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from tedm_cli.thermal.linear import LinearNetwork, Place, linearised, shares
from tedm_cli.thermal.network import ThermalNetwork
from tedm_cli.thermal.state import GivenNetwork
from tedm_cli.thermal.steady import SteadyState, steady_state

Node = tuple[str, str, float]  # name, kind, capacity
Conductor = tuple[str, str, float, float]  # a, b, GL, GR


def network(
    nodes: Sequence[Node], conductors: Sequence[Conductor], powers: dict[str, float] | None = None
) -> ThermalNetwork:
    names = tuple(name for name, _, _ in nodes)
    row = {name: i for i, name in enumerate(names)}
    power = np.zeros(len(names))
    for name, value in (powers or {}).items():
        power[row[name]] = value
    return ThermalNetwork(
        names,
        np.array([kind for _, kind, _ in nodes]),
        np.array([capacity for _, _, capacity in nodes]),
        power,
        np.array([row[a] for a, _, _, _ in conductors]),
        np.array([row[b] for _, b, _, _ in conductors]),
        np.array([c[2] for c in conductors], dtype=np.float64),
        np.array([c[3] for c in conductors], dtype=np.float64),
    )


def steady(net: ThermalNetwork, boundaries: dict[str, float]) -> SteadyState:
    given = np.full(len(net), np.nan)
    for name, value in boundaries.items():
        given[net.row[name]] = value
    return steady_state(net, given, np.full(len(net), np.nan), where="here")


def linear(net: ThermalNetwork, boundaries: dict[str, float], places: Sequence[Place]) -> LinearNetwork:
    return linearised(net, steady(net, boundaries).temperature_K, shares(net, places, where="here"))


def at(kind: str, *nodes: str, share: Sequence[float] = ()) -> Place:
    return Place(kind, nodes, tuple(share) or (1.0,) * len(nodes))


def random_network(n: int, *, radiation: bool, seed: int = 1) -> tuple[ThermalNetwork, dict[str, float]]:
    """A tree of `n` free nodes with some more conductors, two boundaries at different temperatures, and powers."""
    rng = np.random.default_rng(seed)
    nodes: list[Node] = [("B0", "boundary", 0.0), ("B1", "boundary", 0.0)]
    nodes += [(f"N{i}", "arithmetic" if i % 7 == 3 else "diffusive", 0.0 if i % 7 == 3 else 10.0 ** rng.uniform(0, 3))
              for i in range(n)]  # fmt: skip
    conductors: list[Conductor] = [
        ("B0", "N0", 0.3, 0.01 * radiation),
        ("B1", f"N{n - 1}", 0.0 if radiation else 0.2, 0.05 * radiation),
    ]
    for i in range(1, n):
        conductors.append((f"N{rng.integers(i)}", f"N{i}", 10.0 ** rng.uniform(-2, 0), 0.0))
        a = int(rng.integers(n))
        if a != i:
            conductors.append((f"N{i}", f"N{a}", 0.0, 10.0 ** rng.uniform(-3, -1)) if radiation
                              else (f"N{i}", f"N{a}", 10.0 ** rng.uniform(-3, -1), 0.0))  # fmt: skip
    powers = {f"N{i}": float(rng.uniform(0, 2)) for i in range(0, n, 3)}
    return network(nodes, conductors, powers), {"B0": 293.15, "B1": 150.0}


def given(net: ThermalNetwork, boundaries: dict[str, float]) -> GivenNetwork:
    temperature = np.full(len(net), np.nan)
    for name, value in boundaries.items():
        temperature[net.row[name]] = value
    nothing = np.full(len(net), np.nan)
    return GivenNetwork(net, temperature, nothing, np.full((len(net), 3), np.nan), "here")
