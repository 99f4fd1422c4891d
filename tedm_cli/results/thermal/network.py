"""The thermal network of a project, as far as a report tells of it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tedm_cli.arrays import FloatArray
from tedm_cli.contracts import THERMAL
from tedm_cli.files.store import Reader
from tedm_cli.noise.areas import AreaTable
from tedm_cli.noise.temperature import REFERENCE_HZ
from tedm_cli.results.thermal.file import ThermalResults, read_thermal
from tedm_cli.results.thermal.groups import (
    GroupGains,
    GroupTemperatures,
    SteadyNodes,
    read_group_gains,
    read_group_temperatures,
    read_off_model,
)


@dataclass(frozen=True, eq=False)
class ThermalNetwork:
    """What thermal.h5 says, and what the cases assume.

    groups, gains : None where the project has no network, or nothing that disturbs it. off_model : nodes that do not
    lie on the model. on_grids : least and largest temperature of the steady state on the model, K; None where it is not
    known. level : [u], amplitude spectral density of each disturbance at level_hz, K/√Hz or W/√Hz. assumed : (order,
    corner in Hz) of the low-passes of the cases.
    """

    results: ThermalResults
    groups: GroupTemperatures | None
    off_model: SteadyNodes | None
    on_grids: tuple[float, float] | None
    gains: GroupGains | None
    level: FloatArray
    level_hz: float
    assumed: tuple[tuple[float, float], ...]


def read_thermal_network(file: Reader, areas: AreaTable, assumed: Sequence[tuple[float, float]]) -> ThermalNetwork:
    """Read an open thermal.h5."""
    gains, level, at = read_group_gains(file, areas), np.zeros(0), REFERENCE_HZ
    if gains is not None:
        nearest = int(np.argmin(np.abs(np.log(gains.frequency_hz / REFERENCE_HZ))))
        level, at = file.array(THERMAL.DISTURBANCE_ASD)[:, nearest], float(gains.frequency_hz[nearest])
    groups = read_group_temperatures(file, areas)
    on_grids = None
    if file.has(THERMAL.MAP_STEADY_K):
        temperature = file.array(THERMAL.MAP_STEADY_K)
        on_grids = float(np.nanmin(temperature)), float(np.nanmax(temperature))
    return ThermalNetwork(
        read_thermal(file),
        groups,
        None if groups is None else read_off_model(file),
        on_grids,
        gains,
        level,
        at,
        tuple(assumed),
    )
