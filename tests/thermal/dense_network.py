"""A thermal network solved densely with NumPy alone, from the CSV tables and the equations, apart from tedm's code.

Heat from i to j: GL (Ti - Tj) + sigma GR (Ti^4 - Tj^4). Temperatures in K, powers in W, capacities in J/K.
"""

from __future__ import annotations

import csv
import tomllib
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np

SIGMA = 5.670374419e-8  # W m^-2 K^-4


def rows(path: Path) -> list[dict[str, str]]:
    with path.open(encoding="ascii", newline="") as lines:
        return list(csv.DictReader(lines))


@dataclass
class DenseNetwork:
    """Names [n], capacities [n], boundaries [n] (nan where free), GL and GR [n, n] symmetric, powers [n]."""

    name: list[str]
    capacity: np.ndarray
    boundary: np.ndarray
    gl: np.ndarray
    gr: np.ndarray
    power: np.ndarray

    @property
    def free(self) -> np.ndarray:
        return np.flatnonzero(np.isnan(self.boundary))

    @property
    def fixed(self) -> np.ndarray:
        return np.flatnonzero(~np.isnan(self.boundary))

    def heat(self, temperature: np.ndarray) -> np.ndarray:
        """Heat [n, n] that flows from i to j."""
        t, t4 = temperature, SIGMA * temperature**4
        return self.gl * (t[:, None] - t[None, :]) + self.gr * (t4[:, None] - t4[None, :])

    def conduction(self, temperature: np.ndarray) -> np.ndarray:
        """K [n, n]: derivative of the heat that leaves each node."""
        slope = self.gl + 4 * SIGMA * self.gr * temperature**3  # of column j
        return np.diag((self.gl + 4 * SIGMA * self.gr * (temperature**3)[:, None]).sum(axis=1)) - slope

    @cached_property
    def steady(self) -> np.ndarray:
        """Temperatures [n] by Newton's method."""
        t = np.where(np.isnan(self.boundary), np.nanmean(self.boundary), self.boundary)
        f = self.free
        for _ in range(50):
            lost = (self.heat(t).sum(axis=1) - self.power)[f]
            step = np.linalg.solve(self.conduction(t)[np.ix_(f, f)], lost)
            t[f] -= step
            if np.abs(step).max() < 1e-11:
                return t
        raise AssertionError("no steady state")

    def inputs(self, disturbances: list[dict]) -> np.ndarray:
        """B [free, disturbances]."""
        k, at = self.conduction(self.steady), {name: i for i, name in enumerate(self.name)}
        out = np.zeros((len(self.name), len(disturbances)))
        for u, given in enumerate(disturbances):
            nodes = [at[n] for n in given["nodes"]]
            if given["kind"] == "temperature":
                out[:, u] = -k[:, nodes].sum(axis=1)
            else:
                out[nodes, u] = given.get("weights", [1 / len(nodes)] * len(nodes))
        return out[self.free]

    def transfer(self, frequency: np.ndarray, disturbances: list[dict]) -> np.ndarray:
        """H [F, free, disturbances]."""
        f, b = self.free, self.inputs(disturbances)
        k = self.conduction(self.steady)[np.ix_(f, f)]
        return np.array([np.linalg.solve(k + 2j * np.pi * hz * np.diag(self.capacity[f]), b) for hz in frequency])


def read_network(nodes: Path, conductors: Path, powers: Path) -> DenseNetwork:
    table = rows(nodes)
    name = [row["node"] for row in table]
    at = {n: i for i, n in enumerate(name)}
    gl, gr, power = np.zeros((len(at), len(at))), np.zeros((len(at), len(at))), np.zeros(len(at))
    for row in rows(conductors):
        i, j = at[row["node_a"]], at[row["node_b"]]
        for matrix, key in ((gl, "GL_W_K"), (gr, "GR_m2")):
            matrix[i, j] += float(row[key])
            matrix[j, i] += float(row[key])
    for row in rows(powers):
        power[at[row["node"]]] += float(row["power_W"])
    boundary = [float(row["temperature_K"]) if row["kind"] == "boundary" else np.nan for row in table]
    capacity = [float(row["capacity_J_K"]) for row in table]
    return DenseNetwork(name, np.array(capacity), np.array(boundary), gl, gr, power)


def amplitude(given: dict, frequency: np.ndarray) -> np.ndarray:
    """Amplitude spectral density [F] of a disturbance with the preset "thesis" or "white"."""
    level = given.get("level_K", given.get("level_W"))
    if given["preset"] == "white":
        return np.full(len(frequency), level)
    assert given["preset"] == "thesis"
    n, corner, at = 2 * given.get("order", 2), given.get("corner_hz", 1e-3), given.get("reference_hz", 1e-3)
    return level * np.sqrt((1 + (at / corner) ** n) / (1 + (frequency / corner) ** n))


@dataclass
class DenseSpectra:
    """Of a thermal.toml: frequency [F], H [F, free, u], S_u [F, u, u]; `psd` is S_T [F, free, free], one-sided."""

    frequency: np.ndarray
    disturbance: list[str]
    transfer: np.ndarray
    source: np.ndarray

    @property
    def psd(self) -> np.ndarray:
        return self.transfer @ self.source @ self.transfer.conj().transpose(0, 2, 1)


def correlation(tables: dict) -> np.ndarray:
    """R [u, u] of the disturbances."""
    names = [d["name"] for d in tables["disturbance"]]
    r = np.eye(len(names))
    for given in tables.get("correlation", []):
        for a in given["disturbances"]:
            for b in given["disturbances"]:
                if a != b:
                    r[names.index(a), names.index(b)] = given["rho"]
    return r


def spectra(net: DenseNetwork, thermal: Path, frequency: np.ndarray) -> DenseSpectra:
    tables = tomllib.loads(thermal.read_text(encoding="utf-8"))
    given = tables["disturbance"]
    a = np.array([amplitude(d, frequency) for d in given]).T
    source = a[:, :, None] * correlation(tables) * a[:, None, :]
    return DenseSpectra(frequency, [d["name"] for d in given], net.transfer(frequency, given), source)
