"""Noise requirements, the frequency grid that meets their bands, and the verdict on an output.

Amplitudes are amplitude spectral densities (square roots of one-sided PSDs) in SI units per √Hz.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from tedm_cli.arrays import BoolArray, FloatArray
from tedm_cli.errors import ConfigError, InputError

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
    applies_to : `single` for one test mass, `differential` for the difference of two.
    kinks_hz : frequencies at which the limit has a kink; a frequency grid should hold them.
    title : in plain words; empty where there is none but the name.
    """

    name: str
    kind: str
    unit: str
    band_hz: tuple[float, float]
    amplitude: Callable[[FloatArray], FloatArray]
    source: str
    applies_to: str = "single"
    kinks_hz: tuple[float, ...] = ()
    title: str = ""

    @property
    def grid_hz(self) -> tuple[float, ...]:
        """Frequencies that a grid must hold to judge by this requirement: band edges and kinks."""
        return (self.band_hz[0], *self.kinks_hz, self.band_hz[1])


def tabulated(
    name: str,
    kind: str,
    table_hz: FloatArray,
    amplitude: FloatArray,
    *,
    band_hz: tuple[float, float] | None = None,
    applies_to: str = "single",
    source: str = "",
    where: str = "requirement",
) -> Requirement:
    """A requirement given by points: straight lines between them in log-log, the band all of them unless given.

    Parameters
    ----------
    table_hz, amplitude : [n], Hz ascending and unit of the quantity per √Hz, both positive; n >= 2.

    Raises
    ------
    InputError : fewer than two points, frequencies that do not ascend, or values that are not positive.
    ConfigError : a band outside the table.
    """
    if len(table_hz) < 2:
        raise InputError(f"{len(table_hz)} point is no table; two or more are needed", where=where)
    for what, values in (("frequency", table_hz), ("amplitude", amplitude)):
        bad = np.flatnonzero(~(np.isfinite(values) & (values > 0.0)))
        if bad.size:
            raise InputError(f"{what} of point {bad[0] + 1} is {values[bad[0]]:g}, not positive", where=where)
    back = np.flatnonzero(np.diff(table_hz) <= 0.0)
    if back.size:
        fact = f"frequencies do not ascend: {table_hz[back[0] + 1]:g} Hz follows {table_hz[back[0]]:g} Hz"
        raise InputError(fact, where=where, hint="sort the table by frequency; give a step as two near frequencies")
    band = (float(table_hz[0]), float(table_hz[-1])) if band_hz is None else band_hz
    if band[0] < table_hz[0] * (1.0 - _SAME_HZ) or band[1] > table_hz[-1] * (1.0 + _SAME_HZ):
        fact = f"band {band[0]:g} to {band[1]:g} Hz is outside the table, {table_hz[0]:g} to {table_hz[-1]:g} Hz"
        raise ConfigError([("band_hz", fact)], where=where)
    log_f, log_a = np.log(table_hz), np.log(amplitude)

    def interpolated(f: FloatArray) -> FloatArray:
        limit: FloatArray = np.exp(np.interp(np.log(f), log_f, log_a))
        return limit

    kinks = tuple(float(f) for f in table_hz if band[0] < f < band[1])
    return Requirement(name, kind, UNITS[kind], band, interpolated, source, applies_to, kinks)


def in_band(requirement: Requirement, frequency_hz: FloatArray) -> BoolArray:
    """Which of `frequency_hz` [F] are in the requirement's band, edges included."""
    low, high = requirement.band_hz
    inside: BoolArray = (frequency_hz >= low * (1.0 - _SAME_HZ)) & (frequency_hz <= high * (1.0 + _SAME_HZ))
    return inside


@dataclass(frozen=True)
class AppliedRequirement:
    """A requirement and the labels of the outputs it judges."""

    requirement: Requirement
    outputs: tuple[str, ...]


@dataclass(frozen=True)
class Criteria:
    """What outputs are judged by.

    Parameters
    ----------
    requirements : with the outputs each of them is applied to.
    safety_factor : multiplies noise amplitudes in verdicts (Montemurro 2004, section 3.5, recommends 2).
    """

    requirements: tuple[AppliedRequirement, ...] = ()
    safety_factor: float = 1.0


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


def frequency_grid(f_min: float, f_max: float, n: int, bands: Iterable[Sequence[float]] = ()) -> FloatArray:
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
    after = np.searchsorted(held, log_grid)
    near = held[np.clip(np.stack([after - 1, after]), 0, len(held) - 1)]
    apart = np.abs(log_grid - near).min(axis=0) > _SAME_HZ * log_grid
    return np.sort(np.concatenate([log_grid[apart], held]))


def judge(
    asd: FloatArray,
    frequency_hz: FloatArray,
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
    inside = in_band(requirement, frequency_hz)
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


def mismatches(requirement: Requirement, kind: str, frequency_hz: FloatArray) -> list[str]:
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
