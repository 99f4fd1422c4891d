"""The distinct temperature spectra of case files, in words which areas have each."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from tedm_cli.arrays import FloatArray
from tedm_cli.contracts import CASE
from tedm_cli.files.store import Reader
from tedm_cli.noise.areas import AreaTable
from tedm_cli.noise.selection import listed
from tedm_cli.results.areas import read_areas
from tedm_cli.results.cases.noise import TemperatureSpectra
from tedm_cli.results.thermal.case_shares import of_network
from tedm_cli.results.wording import count


def read_temperatures(files: Sequence[Reader]) -> TemperatureSpectra:
    """Distinct spectra of the cases of one configuration: what all have, and of each the gradients within areas."""
    found = [read_temperature(file) for file in files]
    first, asd, name, unit = found[0], [*found[0].asd], [*found[0].name], [*found[0].unit]
    for more in found[1:]:
        for one, words, of in zip(more.asd, more.name, more.unit, strict=True):
            if words not in name:
                asd, name, unit = [*asd, one], [*name, words], [*unit, of]
    return TemperatureSpectra(first.frequency_hz, np.array(asd), name, unit)


def read_temperature(file: Reader) -> TemperatureSpectra:
    """Distinct spectra of a case file, each named by the shield sides and the number of its areas; not of silent
    gradients. Those of gradients within areas are named by these."""
    index, asd, areas = file.array(CASE.TEMPERATURE_SPECTRUM), file.array(CASE.TEMPERATURE_ASD), read_areas(file)
    if of_network(file):
        return _spread_of_nodes(file.array(CASE.FREQUENCY), asd, areas)
    kept, names, units = [], [], []
    for q in range(len(asd)):
        gradient = bool(areas.gradient[index == q].any())
        if gradient and not asd[q].any():
            continue
        within = areas.within & (index == q)
        if within.any():
            kept.append(q)
            names.append(listed(areas.name[within].tolist(), 3))
            units.append("K/m")
            continue
        sides, counts = np.unique(areas.shield[index == q], return_counts=True)
        what = "gradient area" if gradient else "area"
        parts = [f"{side} the thermal shield ({count(n, what)})" for side, n in zip(sides, counts, strict=True)]
        kept.append(q)
        names.append(", ".join(parts) or "no area")
        units.append("K/m" if gradient else "K")
    return TemperatureSpectra(file.array(CASE.FREQUENCY), asd[kept], names, units)


def _spread_of_nodes(frequency_hz: FloatArray, asd: FloatArray, areas: AreaTable) -> TemperatureSpectra:
    """Of thermal nodes, each with a spectrum of its own: the root mean square over each side of the shield."""
    kept, names = [], []
    for side in dict.fromkeys(areas.shield.tolist()):
        mine = (areas.shield == side) & ~areas.gradient
        if mine.any():
            kept.append(np.sqrt(np.mean(asd[mine] ** 2, axis=0)))
            names.append(f"{side} the thermal shield ({count(int(mine.sum()), 'thermal node')}, root mean square)")
    return TemperatureSpectra(frequency_hz, np.array(kept), names, ["K"] * len(kept))
