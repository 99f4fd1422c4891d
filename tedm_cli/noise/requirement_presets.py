"""Published requirements on acceleration noise and read-out noise, by name."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from tedm_cli.arrays import FloatArray
from tedm_cli.noise.requirements import UNITS, Requirement

Shape = Callable[[FloatArray], FloatArray]

_LPF_BAND = (1e-3, 30e-3)
_LISA_BAND = (1e-4, 0.1)
_LISA_SOURCE = "LISA Science Requirements Document 2018"
_BAND_CHOSEN = "band chosen as LISA's"
_TAIJI_SOURCE = (
    "level: Luo Z. et al., Results in Physics 16 (2020) 102918; shape (LISA's): Liu C. et al., Phys. Rev. D 107 (2023)"
    f" 064021, eq. {{}}; {_BAND_CHOSEN}"
)
_TIANQIN_SOURCE = "level: Luo J. et al., Class. Quantum Grav. 33 (2016) 035010, table 1"

#: Plain titles, for readers who do not know the names.
_TITLE = {
    "lpf_acceleration": "LISA Pathfinder, acceleration noise",
    "lpf_selfgravity_ltp": "LISA Pathfinder, self-gravity noise of the LTP",
    "lpf_readout_item": "LISA Pathfinder, one noise source of the read-out",
    "lpf_readout": "LISA Pathfinder, read-out noise",
    "lisa_acceleration": "LISA, acceleration noise of one test mass",
    "lisa_acceleration_differential": "LISA, differential acceleration noise",
    "lpf_jitter": "LISA Pathfinder, jitter between test mass and spacecraft",
    "lisa_oms": "LISA, optical metrology of one link",
    "taiji_acceleration": "Taiji, acceleration noise of one test mass",
    "taiji_oms": "Taiji, optical metrology of one link",
    "tianqin_acceleration": "TianQin, acceleration noise of one test mass",
    "tianqin_oms": "TianQin, optical metrology of one link",
}


def _scaled(level: float, shape: Shape) -> Shape:
    return lambda f: level * shape(f)


def _lpf_acceleration(f: FloatArray) -> FloatArray:
    return 1.0 + (f / 3e-3) ** 2


def _lpf_readout(f: FloatArray) -> FloatArray:
    return np.maximum(1.0, (3e-3 / f) ** 2)


def _lisa_acceleration(f: FloatArray) -> FloatArray:
    amplitude: FloatArray = np.sqrt(1.0 + (0.4e-3 / f) ** 2) * np.sqrt(1.0 + (f / 8e-3) ** 4)
    return amplitude


def _lisa_oms(f: FloatArray) -> FloatArray:
    amplitude: FloatArray = np.sqrt(1.0 + (2e-3 / f) ** 4)
    return amplitude


def _tianqin_acceleration(f: FloatArray) -> FloatArray:
    amplitude: FloatArray = np.sqrt(1.0 + 1e-4 / f)
    return amplitude


def _preset(
    name: str,
    kind: str,
    band_hz: tuple[float, float],
    level: float,
    shape: Shape,
    source: str,
    kinks_hz: tuple[float, ...] = (),
) -> Requirement:
    return Requirement(
        name, kind, UNITS[kind], band_hz, _scaled(level, shape), source, "single", kinks_hz, _TITLE[name]
    )


PRESETS: dict[str, Requirement] = {
    r.name: r
    for r in (
        _preset("lpf_acceleration", "acceleration", _LPF_BAND, 3e-14, _lpf_acceleration, "Montemurro 2004, eq. 4.4"),
        _preset(
            "lpf_selfgravity_ltp",
            "acceleration",
            _LPF_BAND,
            2.12e-15,
            _lpf_acceleration,
            "Montemurro 2004, table 4.1, share of the LTP in self-gravity noise",
        ),
        _preset(
            "lpf_readout_item",
            "displacement",
            _LPF_BAND,
            1e-12,
            _lpf_readout,
            "Montemurro 2004, eq. 10.12, one noise source of the interferometer",
            (3e-3,),
        ),
        _preset("lpf_readout", "displacement", _LPF_BAND, 10e-12, _lpf_readout, "Montemurro 2004, eq. 9.1", (3e-3,)),
        _preset(
            "lisa_acceleration",
            "acceleration",
            _LISA_BAND,
            3e-15,
            _lisa_acceleration,
            f"{_LISA_SOURCE}, single test mass acceleration",
        ),
        replace(
            _preset(
                "lisa_acceleration_differential",
                "acceleration",
                _LISA_BAND,
                math.sqrt(2.0) * 3e-15,
                _lisa_acceleration,
                f"{_LISA_SOURCE}, single test mass acceleration, times the square root of 2 for two test masses",
            ),
            applies_to="differential",
        ),
        _preset(
            "lpf_jitter",
            "displacement",
            _LPF_BAND,
            5e-9,
            np.ones_like,
            "Montemurro 2004, eq. 4.6, jitter between test mass and spacecraft",
        ),
        _preset(
            "lisa_oms",
            "displacement",
            _LISA_BAND,
            15e-12,
            _lisa_oms,
            f"{_LISA_SOURCE}, optical metrology system, single link",
        ),
        _preset("taiji_acceleration", "acceleration", _LISA_BAND, 3e-15, _lisa_acceleration, _TAIJI_SOURCE.format(2)),
        _preset("taiji_oms", "displacement", _LISA_BAND, 8e-12, _lisa_oms, _TAIJI_SOURCE.format(1)),
        _preset(
            "tianqin_acceleration",
            "acceleration",
            _LISA_BAND,
            1e-15,
            _tianqin_acceleration,
            f"{_TIANQIN_SOURCE}; shape: Wang H.-T. et al., Phys. Rev. D 100 (2019) 043003; {_BAND_CHOSEN}",
        ),
        _preset(
            "tianqin_oms",
            "displacement",
            _LISA_BAND,
            1e-12,
            np.ones_like,
            f"{_TIANQIN_SOURCE}, taken as white; {_BAND_CHOSEN}",
        ),
    )
}
