"""The thermal network from a file of ESATAN-TMS."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from tedm_cli.arrays import AnyArray, FloatArray
from tedm_cli.errors import InputError
from tedm_cli.files.tmd import INACTIVE, TmdModel, read_tmd
from tedm_cli.quantities import ABSOLUTE_TEMPERATURE, CONDUCTANCE, HEAT, HEAT_CAPACITY, RADIATIVE_AREA, Quantity
from tedm_cli.thermal.network import ARITHMETIC, BOUNDARY, DIFFUSIVE, ThermalNetwork
from tedm_cli.thermal.state import GivenNetwork

_ZERO_CELSIUS = 273.15  # K
_KINDS = {"D": DIFFUSIVE, "A": ARITHMETIC, "B": BOUNDARY}


def tmd_network(path: Path, time_s: float | None, unit: str | None) -> GivenNetwork:
    """The network of a `.TMD` file at one of its times; inactive nodes are left out.

    Its nodes are called by their numbers. Diffusive ones of capacity 0 are arithmetic, as ESATAN-TMS has it.

    Raises
    ------
    InputError : as `read_tmd`; a kind of node that is not known, a number twice, a value beyond its bounds, and
        temperatures of a unit that neither the file nor the configuration tells.
    """
    model = read_tmd(path, time_s)
    where = str(path)
    found = unit_of_tmd(model.offset_K, unit, where, "[network]")
    offset = model.offset_K if model.offset_K is not None else _ZERO_CELSIUS if found == "degC" else 0.0
    active = np.array([kind != INACTIVE for kind in model.kind])
    names = [str(n) for n in model.number.tolist()]
    for name, kind in zip(names, model.kind, strict=True):
        if kind not in (*_KINDS, INACTIVE):
            fact = (
                f"node {name} is of kind {kind!r}; D (diffusive), A (arithmetic), B (boundary), X (inactive) are known"
            )
            raise InputError(fact, where=where)
    kept = [name for name, is_active in zip(names, active, strict=True) if is_active]
    if twice := next((name for name in kept if kept.count(name) > 1), None) if len(set(kept)) < len(kept) else None:
        raise InputError(f"node {twice} is there twice", where=where)
    capacity = _bounded(HEAT_CAPACITY, model.capacity[active], kept, where)
    kinds = np.array([_KINDS[k] for k in model.kind if k != INACTIVE], dtype=np.dtype("U10"))  # room for arithmetic
    kinds[(kinds == DIFFUSIVE) & (capacity == 0.0)] = ARITHMETIC
    if (odd := np.flatnonzero((kinds == ARITHMETIC) & (capacity != 0.0))).size:
        raise InputError(
            f"node {kept[odd[0]]} is arithmetic, but its capacity is {capacity[odd[0]]:g} J/K", where=where
        )
    temperature = _bounded(ABSOLUTE_TEMPERATURE, model.temperature[active] + offset, kept, where)
    power = _bounded(HEAT, model.power[active], kept, where)
    network = ThermalNetwork(tuple(kept), kinds, capacity, power, *_conductors(model, active, names, where))
    nothing = np.full(len(kept), np.nan)
    return GivenNetwork(network, temperature, nothing, np.full((len(kept), 3), np.nan), where)


def unit_of_tmd(offset_K: float | None, unit: str | None, where: str, table: str) -> str:
    """K or degC: as the file's offset says, or else the configuration, in `table`.

    Raises
    ------
    InputError : neither says it, both say it and differ, or an offset of neither unit.
    """
    if offset_K is None:
        if unit is None:
            fact = "does not say whether its temperatures are in K or degC: it has no attribute TAbs"
            raise InputError(fact, where=where, hint=f'say it: unit = "degC" (or "K") in {table}')
        return unit
    is_celsius = abs(offset_K - _ZERO_CELSIUS) < 0.1
    if not is_celsius and offset_K != 0.0:
        raise InputError(f"attribute TAbs is {offset_K:g}: temperatures are neither in K nor in degC", where=where)
    found = "degC" if is_celsius else "K"
    if unit not in (None, found):
        fact = f"temperatures are in {found} by the attribute TAbs, but unit is {unit}"
        raise InputError(fact, where=where, hint=f"leave unit out of {table}")
    return found


def _conductors(
    model: TmdModel, active: AnyArray, names: list[str], where: str
) -> tuple[AnyArray, AnyArray, FloatArray, FloatArray]:
    """Ends by their rows among the active nodes, GL and GR."""
    row = np.cumsum(active) - 1
    ends, linear, radiative = [], [], []
    for quantity, (pairs, values) in ((CONDUCTANCE, model.GL), (RADIATIVE_AREA, model.GR)):
        used = active[pairs].all(axis=1) if len(pairs) else np.zeros(0, dtype=bool)
        between = [f"{names[a]} to {names[b]}" for a, b in pairs[used].tolist()]
        value = _bounded(quantity, values[used], between, where)
        own = pairs[used][:, 0] == pairs[used][:, 1]
        ends.append(row[pairs[used][~own]])
        zero = np.zeros(int((~own).sum()))
        linear.append(value[~own] if quantity is CONDUCTANCE else zero)
        radiative.append(value[~own] if quantity is RADIATIVE_AREA else zero)
    joined = np.concatenate(ends)
    return joined[:, 0].copy(), joined[:, 1].copy(), np.concatenate(linear), np.concatenate(radiative)


def _bounded(quantity: Quantity, values: FloatArray, of: list[str], where: str) -> FloatArray:
    """The values, where all are within the bounds of their quantity."""
    if (at := quantity.first_outside(values)) is not None:
        raise InputError(f"{of[at[0]]}: {quantity.fact(float(values[at]))}", where=where)
    return values
