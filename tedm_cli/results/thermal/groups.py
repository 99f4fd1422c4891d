"""What thermal.h5 says of groups of nodes: their temperatures, and how disturbances reach them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from tedm_cli.arrays import BoolArray, ComplexArray, FloatArray, IndexArray
from tedm_cli.contracts import THERMAL, UNIT_LOADS
from tedm_cli.errors import InputError
from tedm_cli.files.store import Reader
from tedm_cli.noise.areas import AreaTable
from tedm_cli.noise.correlation_check import correlation_factor
from tedm_cli.thermal.low_pass import LowPass, fitted, low_pass_shape, within
from tedm_cli.thermal.spectra import node_factor

MOST_GROUPS = 12  # that are told apart; the smallest of more are told together
_BLOCK = 1 << 22  # gains that are read at once


@dataclass(frozen=True, eq=False)
class GroupGains:
    """Gains of u disturbances to g groups: of the mean over the nodes of a group, weighted by heat capacity.

    Parameters
    ----------
    group, nodes : [g], names and numbers of nodes. disturbance, kind : [u]. frequency_hz : [F].
    gain : [F, g, u], K/K or K/W. low_pass : of these [g, u]. noise : [F, g], amplitude spectral density of the mean
        temperature, K/√Hz, of all disturbances together; noise_low_pass : of it [g].
    least, most : order and corner in Hz [2, g, u] of the nodes' own low-passes, their ends; NaN where none has a corner
        among the frequencies. without : number of the nodes' gains without such a corner, of all_gains.
    """

    group: tuple[str, ...]
    nodes: tuple[int, ...]
    disturbance: tuple[str, ...]
    kind: tuple[str, ...]
    frequency_hz: FloatArray
    gain: ComplexArray
    low_pass: LowPass
    noise: FloatArray
    noise_low_pass: LowPass
    least: FloatArray
    most: FloatArray
    without: int
    all_gains: int

    def of_kind(self, kind: str) -> list[int]:
        """Disturbances of one kind."""
        return [d for d, found in enumerate(self.kind) if found == kind]

    @cached_property
    def fit(self) -> FloatArray:
        """The fitted low-passes [F, g, u] at the level of the gains; NaN where there is none."""
        f = self.frequency_hz[:, None, None]
        with np.errstate(invalid="ignore"):  # NaN where there is no low-pass
            shape = low_pass_shape(f, self.low_pass.order, self.low_pass.corner_hz)
        size = np.abs(self.gain)
        ratio = np.divide(size, shape, out=np.full_like(shape, np.nan), where=(size > 0.0) & (shape > 0.0))
        return np.asarray(shape * np.exp(np.log(ratio).mean(axis=0)))

    @cached_property
    def phase_deg(self) -> FloatArray:
        """Phases [F, g, u] in degrees, without jumps.

        At the lowest frequency it is not known how often the phase has gone round. Of conductors and capacities it is
        about 90° for each power of f that the gain falls with there (Bode's relation), so the nearest to that is taken.
        """
        phase = np.unwrap(np.angle(self.gain), axis=0)
        size = np.abs(self.gain)
        slope = np.zeros(size.shape[1:])
        if len(size) > 1:
            there = (size[:2] > 0.0).all(axis=0)
            fall = np.log(np.divide(size[1], size[0], out=np.ones_like(slope), where=there))
            slope = fall / np.log(self.frequency_hz[1] / self.frequency_hz[0])
        turns = np.round((phase[0] - slope * np.pi / 2.0) / (2.0 * np.pi))
        return np.asarray(np.degrees(phase - 2.0 * np.pi * turns))


@dataclass(frozen=True, eq=False)
class GroupTemperatures:
    """Temperatures of the steady state, K: `least` and `most` of each group, and its mean; `nodes` are its numbers of
    nodes. on_model : the groups of nodes that lie on the model; the others are beside it."""

    group: tuple[str, ...]
    on_model: BoolArray
    nodes: tuple[int, ...]
    least: FloatArray
    mean: FloatArray
    most: FloatArray


@dataclass(frozen=True, eq=False)
class SteadyNodes:
    """Names, kinds and temperatures, K, of nodes that do not lie on the model, the warmest first."""

    name: tuple[str, ...]
    kind: tuple[str, ...]
    temperature: FloatArray


def read_group_gains(file: Reader, areas: AreaTable) -> GroupGains | None:
    """Gains to groups; None where nothing disturbs the network."""
    if not file.has(THERMAL.TRANSFER):
        return None
    node, free = file.strings(THERMAL.NODE_FREE_NAME), file.array(THERMAL.NODE_FREE)
    capacity = file.array(THERMAL.NODE_CAPACITY)[free]
    group, member = _few(_groups(file, node, areas), capacity)
    weight = np.array([_weights(capacity, member == g) for g in range(len(group))])
    frequency = file.array(THERMAL.FREQUENCY)
    gain = _mean_gains(file, weight)
    asd, correlation = file.array(THERMAL.DISTURBANCE_ASD), file.array(THERMAL.DISTURBANCE_CORRELATION)
    drive = node_factor(gain, asd, correlation_factor(correlation))
    noise = np.sqrt(np.sum(drive.real**2 + drive.imag**2, axis=2))
    order, corner = file.array(THERMAL.FILTER_ORDER), file.array(THERMAL.FILTER_CORNER)
    sound = within(corner, frequency)
    ends = [
        np.array(
            [
                [end(np.where(sound[member == g], of[member == g], empty), axis=0) for g in range(len(group))]
                for of in (order, corner)
            ]
        )
        for end, empty in ((np.min, np.inf), (np.max, -np.inf))
    ]
    least, most = (np.where(np.isfinite(e), e, np.nan) for e in ends)
    return GroupGains(
        group,
        tuple(int((member == g).sum()) for g in range(len(group))),
        tuple(file.strings(THERMAL.DISTURBANCE_NAME)),
        tuple(file.strings(THERMAL.DISTURBANCE_KIND)),
        frequency,
        gain,
        fitted(gain, frequency),
        noise,
        fitted(noise.astype(np.complex128), frequency),
        least,
        most,
        int((~sound).sum()),
        sound.size,
    )


def read_group_temperatures(file: Reader, areas: AreaTable) -> GroupTemperatures | None:
    """Steady temperatures by group, those on the model first; None where there is no network."""
    if not file.has(THERMAL.STEADY_K):
        return None
    name, temperature = file.strings(THERMAL.NODE_NAME), file.array(THERMAL.STEADY_K)
    on = _on_model(file, name)
    rows = []
    for inside in (True, False):
        mine = np.flatnonzero(on == inside)
        group, member = _few(_groups(file, [name[i] for i in mine], areas), file.array(THERMAL.NODE_CAPACITY)[mine])
        for g, title in enumerate(group):
            of = temperature[mine[member == g]]
            rows.append((title, inside, len(of), of.min(), of.mean(), of.max()))
    group_, inside_, nodes, *ends = zip(*rows, strict=True)
    return GroupTemperatures(group_, np.array(inside_), nodes, *(np.array(e) for e in ends))


def read_off_model(file: Reader) -> SteadyNodes:
    """The nodes of a network that do not lie on the model; all of one without map."""
    name, kind, temperature = (
        file.strings(THERMAL.NODE_NAME),
        file.strings(THERMAL.NODE_KIND),
        file.array(THERMAL.STEADY_K),
    )
    off = np.flatnonzero(~_on_model(file, name))
    off = off[np.argsort(-temperature[off], kind="stable")]
    return SteadyNodes(tuple(name[i] for i in off), tuple(kind[i] for i in off), temperature[off])


def has_mapped_temperatures(file: Reader) -> bool:
    """Whether the steady state is known on the grids of the model."""
    return file.has(THERMAL.MAP_STEADY_K)


def read_mapped_temperatures(file: Reader, unit: Reader) -> FloatArray:
    """The steady state [N] of the grids of unit_loads.h5, K; NaN where it is not mapped.

    Raises
    ------
    InputError : unit_loads.h5 has other grids.
    """
    ids = unit.array(UNIT_LOADS.GRID_ID)
    if not np.array_equal(ids, file.array(THERMAL.MAP_GRID)):
        hint = f"rebuild it with `{THERMAL.made_by}`"
        raise InputError(f"is of other grids than {unit.path.name}", where=str(file.path), hint=hint)
    return file.array(THERMAL.MAP_STEADY_K)


def _on_model(file: Reader, name: Sequence[str]) -> BoolArray:
    return np.isin(name, file.strings(THERMAL.MAP_NODE) if file.has(THERMAL.MAP_NODE) else [])


def _groups(file: Reader, node: Sequence[str], areas: AreaTable) -> list[str]:
    """The group of each node: that of the area that most of it is in, or else what its name begins with."""
    of_area = dict(zip(areas.name.tolist(), areas.group.tolist(), strict=True))
    of_node: dict[str, str] = {}
    if file.has(THERMAL.MAP_NODE):
        pairs = zip(file.strings(THERMAL.MAP_NODE), file.strings(THERMAL.MAP_AREA), strict=True)
        of_node = {name: of_area[area] for name, area in pairs if area in of_area}
    return [of_node.get(name) or name.split("_")[0] or name for name in node]


def _few(group: Sequence[str], capacity: FloatArray) -> tuple[tuple[str, ...], IndexArray]:
    """At most `MOST_GROUPS` groups in their order, and the number of that of each node.

    Of more, those with the least heat capacity are one, which comes last.
    """
    names = list(dict.fromkeys(group))
    row = np.array([names.index(g) for g in group], dtype=np.intp)
    if len(names) <= MOST_GROUPS:
        return tuple(names), row
    heat = np.bincount(row, capacity, len(names))
    kept = np.sort(np.argsort(-heat, kind="stable")[: MOST_GROUPS - 1])
    new = np.full(len(names), len(kept))
    new[kept] = np.arange(len(kept))
    return (*(names[i] for i in kept), f"{len(names) - len(kept)} other groups"), new[row]


def _weights(capacity: FloatArray, mine: BoolArray) -> FloatArray:
    """Weights [n] of a mean over some nodes: by heat capacity, or all the same where none has one."""
    weight = np.where(mine, capacity, 0.0)
    weight = weight if weight.sum() > 0.0 else mine.astype(np.float64)
    return np.asarray(weight / weight.sum())


def _mean_gains(file: Reader, weight: FloatArray) -> ComplexArray:
    """Gains [F, g, u] of weighted means [g, n]; read in parts, for those of all nodes may be gigabytes."""
    transfer = file.dataset(THERMAL.TRANSFER)
    frequencies, nodes, disturbances = transfer.shape
    step = max(1, _BLOCK // max(1, nodes * disturbances))
    parts = [weight @ np.asarray(transfer[i : i + step]) for i in range(0, frequencies, step)]
    return np.concatenate(parts)
