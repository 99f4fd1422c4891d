"""A thermal network linearised about a state, and what disturbs it.

    C dδT/dt = -K δT + B u

with u the temperatures of boundaries (B from -K) and powers. Disturbances d with shares of each: u = W d.
"""

from __future__ import annotations

import difflib
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy

from tedm_cli.arrays import FloatArray, IndexArray
from tedm_cli.errors import InputError
from tedm_cli.thermal.network import DIFFUSIVE, ThermalNetwork, selected

TEMPERATURE, POWER = "temperature", "power"


@dataclass(frozen=True)
class Place:
    """Where a disturbance acts.

    Parameters
    ----------
    kind : temperature (K, the same on all its boundaries) or power (W, shared by the nodes).
    nodes : names. share : of the power, as many, with sum 1; of a temperature all 1.
    """

    kind: str
    nodes: tuple[str, ...]
    share: tuple[float, ...]


@dataclass(frozen=True, eq=False)
class LinearNetwork:
    """The network about a state, of its free nodes.

    Parameters
    ----------
    name : [n_free]. capacity : [n_free], J/K, 0 of arithmetic nodes.
    conductance : K [n_free, n_free], W/K. disturbed : B [n_free, u], W per K or W of each disturbance.
    to_boundaries : [n_free], W/K that each node gives to boundaries: the sums of the columns of K, without rounding.
    """

    name: tuple[str, ...]
    capacity: FloatArray
    conductance: scipy.sparse.csc_array
    disturbed: FloatArray
    to_boundaries: FloatArray


def shares(network: ThermalNetwork, places: Sequence[Place], *, where: str) -> FloatArray:
    """W [u, n]: the share of each node in each disturbance.

    Raises
    ------
    InputError : a node that is not there; a temperature of a node that is no boundary, a power of one that is.
    """
    found = np.zeros((len(places), len(network)))
    for number, place in enumerate(places):
        for name, share in zip(place.nodes, place.share, strict=True):
            at = f"disturbance[{number}].nodes"
            row = network.row.get(name)
            if row is None:
                raise InputError(f"{at}: no node is called {name!r}", where=where, hint=near_name(name, network.name))
            is_boundary = bool(network.boundary[row])
            if place.kind == TEMPERATURE and not is_boundary:
                fact = f"{at}: {name!r} is {network.kind[row]}: the temperatures of boundaries alone are given"
                raise InputError(fact, where=where, hint='give a power, kind = "power", or make the node a boundary')
            if place.kind == POWER and is_boundary:
                fact = f"{at}: {name!r} is a boundary, whose temperature no power changes"
                raise InputError(fact, where=where, hint='give its temperature, kind = "temperature"')
            found[number, row] = share
    return found


def linearised(network: ThermalNetwork, temperature_K: FloatArray, share: FloatArray) -> LinearNetwork:
    """The network about `temperature_K` [n], disturbed by `share` [u, n] of `shares`."""
    free = network.free
    fixed = np.flatnonzero(network.boundary)
    whole = network.conductance(temperature_K)
    from_boundaries = selected(whole, free, fixed) @ share[:, fixed].T
    return LinearNetwork(
        tuple(network.name[i] for i in free),
        np.where(network.kind == DIFFUSIVE, network.capacity, 0.0)[free],
        selected(whole, free, free),
        np.asarray(share[:, free].T - from_boundaries),
        np.asarray(-selected(whole, fixed, free).sum(axis=0)),
    )


def near_name(name: str, known: Sequence[str]) -> str:
    """What a name that is not known may have meant."""
    folded = {k.casefold(): k for k in known}
    if same := folded.get(name.casefold()):
        return f"there is {same!r}, whose case differs"
    near = difflib.get_close_matches(name.casefold(), folded, n=1, cutoff=0.6)
    return f"did you mean {folded[near[0]]!r}?" if near else ""


def rows_of(names: Sequence[str], wanted: Sequence[str]) -> IndexArray:
    """Places [w] of names that are all there."""
    place = {name: row for row, name in enumerate(names)}
    return np.array([place[name] for name in wanted], dtype=np.intp)
