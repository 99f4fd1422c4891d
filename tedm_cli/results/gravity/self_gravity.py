"""The self-gravity sensitivities as sensitivity.h5 tells them."""

from __future__ import annotations

from dataclasses import dataclass

from tedm_cli.arrays import FloatArray
from tedm_cli.contracts import SENSITIVITY
from tedm_cli.files.store import Reader
from tedm_cli.results.areas import AreaMap
from tedm_cli.results.units import units_of


@dataclass(frozen=True, eq=False)
class GravitySensitivity:
    """[S_SG]: S [n, k] of n outputs per kelvin of k areas, frames of the test masses; `unit` with "/K"."""

    label: list[str]
    unit: list[str]
    S: FloatArray


def read_self_gravity(file: Reader) -> GravitySensitivity:
    """[S_SG] with its labels; `InputError` where a unit is not of its output."""
    label = file.strings(SENSITIVITY.ROW_LABEL)
    wanted = ["m/s^2/K" if "_a_" in name else "rad/s^2/K" for name in label]
    return GravitySensitivity(label, units_of(file, SENSITIVITY.ROW_UNIT, label, wanted), file.array(SENSITIVITY.S))


def gravity_maps(file: Reader) -> list[AreaMap]:
    """S_SG as one panel for each unit."""
    gravity = read_self_gravity(file)
    maps = []
    for unit in dict.fromkeys(gravity.unit):
        rows = [i for i, u in enumerate(gravity.unit) if u == unit]
        maps.append(AreaMap("|S_SG|", unit, [gravity.label[i] for i in rows], gravity.S[rows]))
    return maps
