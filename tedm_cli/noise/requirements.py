"""Noise requirements, the frequency grid that meets their bands, and the verdict on an output.

Amplitudes are amplitude spectral densities (square roots of one-sided PSDs) in SI units per √Hz.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tedm_cli.errors import ConfigError

Array = NDArray[np.float64]

UNITS = {"acceleration": "m s^-2", "angular_acceleration": "rad s^-2", "displacement": "m", "angle": "rad"}
REFERENCE_HZ = 1e-3

# A frequency given twice may differ in its last digits; neighbours on a grid never come this close.
_SAME_HZ = 1e-9


@dataclass(frozen=True)
class Requirement:
    """An upper limit on an amplitude spectral density over a band.

    Parameters
    ----------
    name : as in a configuration.
    kind : quantity, a key of `UNITS`.
    unit : of the quantity; the amplitude is in this unit per √Hz.
    band_hz : lower and upper edge, both included.
    amplitude : from frequency [F] in Hz to the limit [F].
    source : document and equation the limit is from.
    applies_to : what the limit is on, such as a single test mass.
    kinks_hz : frequencies at which the limit has a kink; a frequency grid should hold them.
    """

    name: str
    kind: str
    unit: str
    band_hz: tuple[float, float]
    amplitude: Callable[[Array], Array]
    source: str
    applies_to: str
    kinks_hz: tuple[float, ...] = ()

    @property
    def grid_hz(self) -> tuple[float, ...]:
        """Frequencies that a grid must hold to judge by this requirement: band edges and kinks."""
        return (self.band_hz[0], *self.kinks_hz, self.band_hz[1])


@dataclass(frozen=True)
class AppliedRequirement:
    """A requirement and the labels of the outputs it judges."""

    requirement: Requirement
    outputs: tuple[str, ...]


@dataclass(frozen=True)
class Verdict:
    """One output against one requirement.

    Parameters
    ----------
    output, requirement : names.
    ratio : largest safety_factor × noise / limit over the band.
    margin : 1 / ratio, the factor by which the noise may still grow (infinite without noise).
    binding_hz : the (lowest) frequency of that ratio.
    noise, limit : amplitude spectral densities there, unit per √Hz, the noise before the safety factor.
    safety_factor : applied to the noise amplitude.
    passed : ratio <= 1.
    """

    output: str
    requirement: str
    ratio: float
    margin: float
    binding_hz: float
    noise: float
    limit: float
    safety_factor: float
    passed: bool


def frequency_grid(f_min: float, f_max: float, n: int, bands: Iterable[Sequence[float]] = ()) -> Array:
    """Logarithmic grid of `n` frequencies in Hz, plus exactly those of `bands` and, where inside, 1 mHz.

    Raises `ConfigError` for an empty range, fewer than two points, or a band outside the range.
    """
    bands = [tuple(band) for band in bands]
    problems = []
    if not 0.0 < f_min < f_max:
        problems.append(("frequency", f"range from {f_min:g} to {f_max:g} Hz is not positive and increasing"))
    if n < 2:
        problems.append(("frequency.points", f"{n} frequencies are not a grid"))
    for band in bands:
        if min(band) < f_min or max(band) > f_max:
            fact = f"range {f_min:g} to {f_max:g} Hz does not hold the band {min(band):g} to {max(band):g} Hz"
            problems.append(("frequency", fact))
    if problems:
        raise ConfigError(problems, where="frequency grid")
    exact = {f_min, f_max, *(f for band in bands for f in band)}
    if f_min <= REFERENCE_HZ <= f_max:
        exact.add(REFERENCE_HZ)
    held = np.array(sorted(exact))
    log_grid = np.geomspace(f_min, f_max, n)
    apart = np.abs(log_grid[:, None] - held).min(axis=1) > _SAME_HZ * log_grid
    return np.sort(np.concatenate([log_grid[apart], held]))


def judge(
    asd: Array,
    frequency_hz: Array,
    requirement: Requirement,
    safety_factor: float,
    *,
    kind: str,
    output: str = "",
) -> Verdict:
    """Compare the amplitude spectral density `asd` [F] of one output, of quantity `kind`, to a requirement.

    Raises
    ------
    ConfigError : `kind` is not the requirement's, or an edge of its band is not among `frequency_hz` [F].
    """
    problems = mismatches(requirement, kind, frequency_hz)
    if problems:
        where = f"requirement {requirement.name}" + (f" on {output}" if output else "")
        raise ConfigError([("", fact) for fact in problems], where=where)
    low, high = requirement.band_hz
    inside = (frequency_hz >= low * (1.0 - _SAME_HZ)) & (frequency_hz <= high * (1.0 + _SAME_HZ))
    limit = requirement.amplitude(frequency_hz[inside])
    ratios = safety_factor * asd[inside] / limit
    # Noise parallel to its limit ties up to rounding: take the lowest frequency.
    binding = int(np.flatnonzero(ratios >= ratios.max() * (1.0 - 1e-12))[0])
    ratio = float(ratios.max())
    return Verdict(
        output=output,
        requirement=requirement.name,
        ratio=ratio,
        margin=1.0 / ratio if ratio > 0.0 else np.inf,
        binding_hz=float(frequency_hz[inside][binding]),
        noise=float(asd[inside][binding]),
        limit=float(limit[binding]),
        safety_factor=safety_factor,
        passed=ratio <= 1.0,
    )


def mismatches(requirement: Requirement, kind: str, frequency_hz: Array) -> list[str]:
    """Why a requirement cannot judge an output of quantity `kind` at `frequency_hz` [F]; empty when it can."""
    facts = []
    if kind != requirement.kind:
        facts.append(f"limits {requirement.kind} ({requirement.unit}), not {kind} ({UNITS.get(kind, '?')})")
    missing = [f for f in requirement.band_hz if np.abs(frequency_hz - f).min() > _SAME_HZ * f]
    if missing:
        edges = " and ".join(f"{f:g}" for f in missing)
        facts.append(
            f"band edge {edges} Hz is not among the frequencies {frequency_hz[0]:g} to {frequency_hz[-1]:g} Hz"
        )
    return facts


def _lpf_acceleration_shape(f: Array) -> Array:
    return 1.0 + (f / 3e-3) ** 2


def _lpf_readout_shape(f: Array) -> Array:
    return np.maximum(1.0, (3e-3 / f) ** 2)


def _lisa_acceleration(f: Array) -> Array:
    amplitude: Array = 3e-15 * np.sqrt(1.0 + (0.4e-3 / f) ** 2) * np.sqrt(1.0 + (f / 8e-3) ** 4)
    return amplitude


def _lisa_oms(f: Array) -> Array:
    amplitude: Array = 15e-12 * np.sqrt(1.0 + (2e-3 / f) ** 4)
    return amplitude


_LPF_BAND = (1e-3, 30e-3)
_LISA_BAND = (1e-4, 0.1)

PRESETS: dict[str, Requirement] = {
    r.name: r
    for r in (
        Requirement(
            "lpf_acceleration",
            "acceleration",
            "m s^-2",
            _LPF_BAND,
            lambda f: 3e-14 * _lpf_acceleration_shape(f),
            "Montemurro 2004, eq. 4.4",
            "single test mass",
        ),
        Requirement(
            "lpf_selfgravity_ltp",
            "acceleration",
            "m s^-2",
            _LPF_BAND,
            lambda f: 2.12e-15 * _lpf_acceleration_shape(f),
            "Montemurro 2004, table 4.1, share of the LTP in self-gravity noise",
            "single test mass",
        ),
        Requirement(
            "lpf_readout_item",
            "displacement",
            "m",
            _LPF_BAND,
            lambda f: 1e-12 * _lpf_readout_shape(f),
            "Montemurro 2004, eq. 10.12, one noise source of the interferometer",
            "single test mass",
            (3e-3,),
        ),
        Requirement(
            "lpf_readout",
            "displacement",
            "m",
            _LPF_BAND,
            lambda f: 10e-12 * _lpf_readout_shape(f),
            "Montemurro 2004, eq. 9.1",
            "single test mass",
            (3e-3,),
        ),
        Requirement(
            "lisa_acceleration",
            "acceleration",
            "m s^-2",
            _LISA_BAND,
            _lisa_acceleration,
            "LISA Science Requirements Document 2018, single test mass acceleration",
            "single test mass",
        ),
        Requirement(
            "lisa_oms",
            "displacement",
            "m",
            _LISA_BAND,
            _lisa_oms,
            "LISA Science Requirements Document 2018, optical metrology system",
            "single link",
        ),
    )
}
