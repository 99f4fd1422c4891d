"""Temperature noise of the thermal areas: amplitude spectral densities in K/√Hz, square roots of one-sided PSDs.

Those of gradient areas are in K/m/√Hz, wherever K/√Hz is written here; one that is given no spectrum is silent.

Published for the LISA Technology Package (Montemurro 2004, section 3.4): 1e-3 K/√Hz outside and 1e-4 K/√Hz inside the
thermal shield at 1 mHz, from low-pass filtered white noise. The order and the corner of that filter were **not**
published. `DEFAULT_ORDER` and `DEFAULT_CORNER_HZ` are an assumption: the corner at the lower end of the measurement
band, where the level is specified, and the lower of the two orders that suit the axes of figures 3.6 and 3.7 (they end
six to seven decades below the level at 1 mHz; from there to 0.1 Hz order 2 falls by 3.9 decades, order 3 by 5.9). They
matter: relative to its value at 1 mHz, the ratio of the read-out noise to its requirement grows up to 9-fold inside the
band for white noise, 3- to 4-fold for order 1, and at most 1.4-fold for order 2, for corners at or below 1 mHz.

Measured in flight (Armano et al. 2019, arXiv:1905.09060): some 1 K/√Hz at 10 µHz, falling to the noise of the sensors,
10 µK/√Hz, which hides the temperatures down to 1 mHz. `FlightSpectrum` draws a line through the two.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from tedm_cli.arrays import BoolArray, FloatArray, IndexArray
from tedm_cli.errors import InputError
from tedm_cli.noise.areas import AreaTable

OUTSIDE_LEVEL_K = 1e-3
INSIDE_LEVEL_K = 1e-4
REFERENCE_HZ = 1e-3
DEFAULT_ORDER = 2.0
DEFAULT_CORNER_HZ = 1e-3
FLIGHT_FLOOR_K = 1e-5
FLIGHT_KNEE_HZ = 4.64158883e-4  # 10 µHz times the cube root of 1e5: the level is 1 K/√Hz at 10 µHz
_SAME_HZ = 1e-9  # frequencies this close, relatively, are one


@dataclass(frozen=True)
class ShapedSpectrum:
    """Low-pass spectrum of given level at a reference frequency.

    A(f) = A0 sqrt[(1 + (f0/fc)^2n) / (1 + (f/fc)^2n)]

    Parameters
    ----------
    level_K : A0, K/√Hz at `reference_hz`.
    reference_hz, corner_hz : f0 and fc, Hz.
    order : n, the order of the low-pass filter (slope f^-n far above the corner).
    """

    level_K: float
    reference_hz: float = REFERENCE_HZ
    corner_hz: float = DEFAULT_CORNER_HZ
    order: float = DEFAULT_ORDER

    def __post_init__(self) -> None:
        _check_level(self.level_K)
        for key in ("reference_hz", "corner_hz", "order"):
            value = getattr(self, key)
            if not (np.isfinite(value) and value > 0.0):
                raise InputError(f"{key} is {value:g}, not positive", where="temperature spectrum")

    def amplitude(self, frequency_hz: FloatArray) -> FloatArray:
        """Amplitude spectral density [F] in K/√Hz at `frequency_hz` [F]."""
        exponent = 2.0 * self.order
        top = 1.0 + (self.reference_hz / self.corner_hz) ** exponent
        amplitude: FloatArray = self.level_K * np.sqrt(top / (1.0 + (frequency_hz / self.corner_hz) ** exponent))
        return amplitude

    def words(self) -> str:
        """The shape and its parameters."""
        corner, reference = self.corner_hz * 1e3, self.reference_hz * 1e3
        return f"low-pass of order {self.order:g}, corner {corner:g} mHz, level at {reference:g} mHz"


@dataclass(frozen=True)
class WhiteSpectrum:
    """The same amplitude spectral density `level_K`, K/√Hz, at every frequency."""

    level_K: float

    def __post_init__(self) -> None:
        _check_level(self.level_K)

    def amplitude(self, frequency_hz: FloatArray) -> FloatArray:
        """Amplitude spectral density [F] in K/√Hz at `frequency_hz` [F]."""
        return np.full(np.shape(frequency_hz), self.level_K)

    def words(self) -> str:
        """The shape."""
        return "white"


@dataclass(frozen=True)
class FlightSpectrum:
    """What LISA Pathfinder's thermometers read: an upper limit where their own noise is the floor.

    A(f) = A0 sqrt[1 + (fk/f)^6]

    Parameters
    ----------
    level_K : A0, K/√Hz, the floor at 1 to 30 mHz.

    Measured are the floor and some 1 K/√Hz at 10 µHz (Armano et al. 2019). Assumed are the slope between them, f^-3,
    the lowest whole power that leaves the floor free at 1 mHz (0.5 % above it there), and the same floor above 30 mHz.
    """

    level_K: float = FLIGHT_FLOOR_K

    def __post_init__(self) -> None:
        _check_level(self.level_K)

    def amplitude(self, frequency_hz: FloatArray) -> FloatArray:
        """Amplitude spectral density [F] in K/√Hz at `frequency_hz` [F] (positive)."""
        amplitude: FloatArray = self.level_K * np.sqrt(1.0 + (FLIGHT_KNEE_HZ / frequency_hz) ** 6)
        return amplitude

    def words(self) -> str:
        """The shape and its parameters."""
        return "upper limit in flight, f^-3 below 0.46 mHz"


@dataclass(frozen=True)
class TabulatedSpectrum:
    """Amplitude spectral density from a table, straight lines between its points on logarithmic axes.

    Parameters
    ----------
    level_K : K/√Hz at `level_hz`, where `relative` is 1.
    frequency_hz, relative : [N], the points.
    name : of the table, for messages.
    """

    level_K: float
    level_hz: float
    frequency_hz: tuple[float, ...]
    relative: tuple[float, ...]
    name: str

    @classmethod
    def of(cls, frequency_hz: FloatArray, asd: FloatArray, name: str) -> TabulatedSpectrum:
        """Spectrum through `asd` [N] in K/√Hz at `frequency_hz` [N] in Hz; its level is that nearest to 1 mHz.

        Raises
        ------
        InputError : fewer than two points, frequencies that do not increase from above 0, or a level not above 0.
        """
        where = f"spectrum {name}"
        if len(frequency_hz) < 2:
            raise InputError(f"{len(frequency_hz)} frequencies are not a table", where=where)
        wrong = np.flatnonzero(~(np.diff(frequency_hz, prepend=0.0) > 0.0))
        if wrong.size:
            n = int(wrong[0])
            before = f"{frequency_hz[n - 1]:g} Hz before it" if n else "0"
            raise InputError(f"frequency {n + 1} is {frequency_hz[n]:g} Hz, not above {before}", where=where)
        wrong = np.flatnonzero(~((asd > 0.0) & np.isfinite(asd)))
        if wrong.size:
            raise InputError(
                f"{asd[wrong[0]]:g} K/sqrt(Hz) at {frequency_hz[wrong[0]]:g} Hz is not a positive level",
                where=where,
                hint="leave silent areas out of the case instead",
            )
        nearest = int(np.argmin(np.abs(np.log(frequency_hz / REFERENCE_HZ))))
        level = float(asd[nearest])
        return cls(
            level, float(frequency_hz[nearest]), tuple(frequency_hz.tolist()), tuple((asd / level).tolist()), name
        )

    def __post_init__(self) -> None:
        _check_level(self.level_K)

    def amplitude(self, frequency_hz: FloatArray) -> FloatArray:
        """Amplitude spectral density [F] in K/√Hz at `frequency_hz` [F]; `InputError` for one outside the table."""
        low, high = self.frequency_hz[0], self.frequency_hz[-1]
        outside = (frequency_hz < low * (1.0 - _SAME_HZ)) | (frequency_hz > high * (1.0 + _SAME_HZ))
        if np.any(outside):
            raise InputError(
                f"holds {low:g} to {high:g} Hz, but {frequency_hz[outside][0]:g} Hz is asked for",
                where=f"spectrum {self.name}",
                hint="nothing is assumed outside a table: extend it, or narrow [frequency] in the cases file",
            )
        log = np.interp(np.log(frequency_hz), np.log(self.frequency_hz), np.log(self.relative))
        amplitude: FloatArray = self.level_K * np.exp(log)
        return amplitude

    def words(self) -> str:
        """The table, its range, and where its level is."""
        low, high = self.frequency_hz[0], self.frequency_hz[-1]
        return f"table {self.name}, {low:g} to {high:g} Hz, level at {self.level_hz * 1e3:g} mHz"


Spectrum = ShapedSpectrum | WhiteSpectrum | FlightSpectrum | TabulatedSpectrum


@dataclass(frozen=True, eq=False)
class TemperatureModel:
    """Amplitude spectral density of every thermal area as a scale times one of a few distinct shapes.

    Parameters
    ----------
    scale : [k], K/√Hz, of gradient areas K/m/√Hz; 0 of those without a spectrum.
    shape_index : [k], the shape of each area; -1 of those without a spectrum.
    shapes : the s distinct spectra, each of level 1.
    gradient_shapes : of these, the ones of gradient areas; a shape is never of both kinds.
    """

    scale: FloatArray
    shape_index: IndexArray
    shapes: tuple[Spectrum, ...]
    gradient_shapes: frozenset[int] = frozenset()

    @classmethod
    def from_spectra(cls, spectra: Sequence[Spectrum | None], gradient: BoolArray | None = None) -> TemperatureModel:
        """Model of k areas from one spectrum each; spectra that differ in level only share a shape.

        `gradient` [k] are the areas whose spectrum is in K/m/√Hz, by default none. An area of None is silent.
        """
        of_gradient = [False] * len(spectra) if gradient is None else gradient.tolist()
        shapes: dict[tuple[Spectrum, bool], int] = {}
        index = [
            -1 if spectrum is None else shapes.setdefault((replace(spectrum, level_K=1.0), kind), len(shapes))
            for spectrum, kind in zip(spectra, of_gradient, strict=True)
        ]
        scale = np.array([0.0 if spectrum is None else spectrum.level_K for spectrum in spectra])
        return cls(
            scale,
            np.array(index, dtype=np.intp),
            tuple(spectrum for spectrum, _ in shapes),
            frozenset(number for (_, kind), number in shapes.items() if kind),
        )

    @classmethod
    def by_shield(cls, areas: AreaTable, *, outside: Spectrum, inside: Spectrum) -> TemperatureModel:
        """Model with one spectrum outside and one inside the thermal shield; gradient areas are silent."""
        return cls.from_spectra(
            [
                None if gradient else outside if shield == "outside" else inside
                for shield, gradient in zip(areas.shield, areas.gradient, strict=True)
            ]
        )

    def and_gradients(self, spectra: Sequence[Spectrum]) -> TemperatureModel:
        """With more areas behind these, of spectra in K/m/√Hz."""
        more = TemperatureModel.from_spectra(spectra, np.ones(len(spectra), dtype=bool))
        first = len(self.shapes)
        return TemperatureModel(
            np.concatenate([self.scale, more.scale]),
            np.concatenate([self.shape_index, first + more.shape_index]),
            (*self.shapes, *more.shapes),
            self.gradient_shapes | {first + number for number in more.gradient_shapes},
        )

    @property
    def gradient(self) -> BoolArray:
        """[k]: the areas whose spectrum is in K/m/√Hz."""
        return np.isin(self.shape_index, list(self.gradient_shapes))

    @property
    def heard(self) -> BoolArray:
        """[k]: the areas that have a spectrum; all but gradient areas that were given none."""
        return np.asarray(self.shape_index >= 0)

    def spectrum(self, area: int) -> Spectrum:
        """The spectrum of an area that has one."""
        shape: Spectrum = self.shapes[int(self.shape_index[area])]
        return replace(shape, level_K=float(self.scale[area]))

    def shape_values(self, frequency_hz: FloatArray) -> FloatArray:
        """The distinct shapes [s, F] at `frequency_hz` [F]."""
        return np.stack([shape.amplitude(frequency_hz) for shape in self.shapes])

    def amplitudes(self, frequency_hz: FloatArray) -> FloatArray:
        """Amplitude spectral density [k, F] of every area, K/√Hz."""
        amplitude: FloatArray = self.scale[:, None] * self.shape_values(frequency_hz)[self.shape_index]
        return amplitude

    def distinct(self, frequency_hz: FloatArray) -> tuple[IndexArray, FloatArray]:
        """Areas of equal spectrum: the set [k] each area is in, and one amplitude spectral density per set [q, F].

        Areas without a spectrum are the last set, whose density is zero.
        """
        shape_index, scale = self.shape_index[self.heard], self.scale[self.heard]
        keys = np.stack([shape_index.astype(np.float64), scale], axis=1)
        rows, first, index = np.unique(keys, axis=0, return_index=True, return_inverse=True)
        values = rows[:, 1:] * self.shape_values(frequency_hz)[shape_index[first]]
        sets = np.full(len(self.scale), len(rows), dtype=np.intp)
        sets[self.heard] = index.reshape(-1)
        if not self.heard.all():
            values = np.concatenate([values, np.zeros((1, len(frequency_hz)))])
        return sets, values

    def with_filter(self, order: float, corner_hz: float) -> TemperatureModel:
        """The same levels with every low-pass shape given another order and corner; other shapes stay."""
        shapes = tuple(
            replace(s, order=order, corner_hz=corner_hz) if isinstance(s, ShapedSpectrum) else s for s in self.shapes
        )
        return replace(self, shapes=shapes)

    def words(self) -> str:
        """Levels and shapes, with the parameters that decide verdicts."""
        parts: list[str] = []
        for number, shape in enumerate(self.shapes):
            levels = sorted({float(v) for v in self.scale[self.shape_index == number]}, reverse=True)
            shown = " and ".join(f"{v:g}" for v in levels) if len(levels) < 4 else f"{levels[-1]:g} to {levels[0]:g}"
            unit = "K/m" if number in self.gradient_shapes else "K"
            parts.append(f"{shown} {unit}/sqrt(Hz), {shape.words()}")
        if silent := int((~self.heard).sum()):
            parts.append(f"{silent} gradient area{'s' if silent > 1 else ''} silent")
        return "; ".join(parts)


def thesis_model(
    areas: AreaTable,
    *,
    outside_K: float = OUTSIDE_LEVEL_K,
    inside_K: float = INSIDE_LEVEL_K,
    reference_hz: float = REFERENCE_HZ,
    order: float = DEFAULT_ORDER,
    corner_hz: float = DEFAULT_CORNER_HZ,
) -> TemperatureModel:
    """Low-pass noise of the published levels in K/√Hz (Montemurro 2004, section 3.4); the filter is an assumption."""
    outside = ShapedSpectrum(outside_K, reference_hz, corner_hz, order)
    return TemperatureModel.by_shield(areas, outside=outside, inside=replace(outside, level_K=inside_K))


def white_model(
    areas: AreaTable, *, outside_K: float = OUTSIDE_LEVEL_K, inside_K: float = INSIDE_LEVEL_K
) -> TemperatureModel:
    """The levels published for 1 mHz, in K/√Hz, held over all frequencies: conservative above 1 mHz."""
    return TemperatureModel.by_shield(areas, outside=WhiteSpectrum(outside_K), inside=WhiteSpectrum(inside_K))


def _check_level(level_K: float) -> None:
    if not (np.isfinite(level_K) and level_K >= 0.0):
        raise InputError(f"level_K is {level_K:g}, not a finite amplitude", where="temperature spectrum")
