"""Disturbances of the thermal network over time: as users give them, or as realisations of their spectra."""

from __future__ import annotations

import difflib
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tedm_cli.arrays import FloatArray
from tedm_cli.errors import InputError
from tedm_cli.noise.correlation import Correlation
from tedm_cli.noise.propagation import TemperatureNoise
from tedm_cli.noise.realisation import Plan, temperature_blocks
from tedm_cli.noise.selection import listed
from tedm_cli.noise.stamps import Stamps
from tedm_cli.noise.temperature import Spectrum, TabulatedSpectrum, TemperatureModel, WhiteSpectrum
from tedm_cli.quantities import HEAT, TEMPERATURE, TIME_STAMP
from tedm_cli.tables.wide_table import open_wide
from tedm_cli.thermal.linear import TEMPERATURE as OF_BOUNDARIES

_PER_DECADE = 400  # points of a spectrum that is tabulated
_PIECE = 1 << 14  # samples that are stepped at once


@dataclass(frozen=True, eq=False)
class GivenDisturbances:
    """Those of a table: their blocks [u, T] at regular stamps from `first_s` on; constant ones have no column."""

    blocks: Iterator[FloatArray]
    first_s: float
    step_s: float
    constant: list[str]


@contextmanager
def given_disturbances(path: Path, names: Sequence[str], kinds: Sequence[str]) -> Iterator[GivenDisturbances]:
    """A CSV or HDF5 table of `time_s` and a column for each disturbance, in K or W about the steady state.

    Raises
    ------
    InputError : a table that is refused, a column that is no disturbance, stamps that are not regular, one row.
    """
    powers = {name: HEAT for name, kind in zip(names, kinds, strict=True) if kind != OF_BOUNDARIES}
    with open_wide(path, "time_s", TIME_STAMP, TEMPERATURE, powers) as wide:
        unknown = [name for name in wide.columns if name not in names]
        if unknown:
            near = difflib.get_close_matches(unknown[0], names, n=1)
            hint = f"did you mean {near[0]}? " if near else ""
            raise InputError(
                f"columns that are no disturbance: {listed(unknown)}",
                where=str(path),
                hint=f"{hint}there are {listed(names, 12)}",
            )
        place = [names.index(name) for name in wide.columns]
        stamps = Stamps(wide.place, regular=True)
        blocks = wide.blocks(_PIECE)

        def next_block() -> FloatArray | None:
            block = next(blocks, None)
            if block is None:
                return None
            try:
                stamps.add(block.key, block.places)
            except InputError as error:
                hint = "disturbances are straight between their stamps, which must be equally far apart"
                raise InputError(error.fact, where=error.where, hint=hint) from None
            u = np.zeros((len(names), len(block.key)))
            u[place] = block.values.T
            return u

        first = next_block()
        if first is None or first.shape[1] < 2:
            raise InputError("needs two rows or more", where=str(path))

        def following() -> Iterator[FloatArray]:
            block: FloatArray | None = first
            while block is not None:
                yield block
                block = next_block()

        constant = [name for name in names if name not in wide.columns]
        yield GivenDisturbances(following(), stamps.first_s, stamps.mean_step_s, constant)


def realised_disturbances(
    spectra: Sequence[Spectrum], factor: FloatArray, frequency_hz: FloatArray, plan: Plan
) -> Iterator[FloatArray]:
    """Blocks [u, T] of disturbances with these spectra and the correlation R = L Lᵀ of `factor` [u, m].

    The straight lines between the samples have the spectra, not the samples: these are drawn larger by 1/sinc²(f step).

    Raises
    ------
    InputError : filters of the lowest frequency that do not fit into memory.
    """
    low, high = float(frequency_hz[0]), float(frequency_hz[-1])
    grid = np.geomspace(low, high, max(2, int(np.ceil(_PER_DECADE * np.log10(high / low)))))
    grid[[0, -1]] = low, high
    shapes = tuple(_drawn(spectrum, grid, plan.rate_hz) for spectrum in spectra)
    model = TemperatureModel(np.ones(len(shapes)), np.arange(len(shapes)), shapes)
    for block in temperature_blocks(TemperatureNoise(model, Correlation.of_factor(factor)), plan):
        for first in range(0, block.shape[1], _PIECE):
            yield block[:, first : first + _PIECE]


def _drawn(spectrum: Spectrum, grid: FloatArray, rate_hz: float) -> Spectrum:
    if isinstance(spectrum, TabulatedSpectrum):
        own = np.array(spectrum.frequency_hz)
        grid = np.union1d(grid, own[(own > grid[0]) & (own < grid[-1])])
    amplitude = spectrum.amplitude(grid)
    if not amplitude.any():
        return WhiteSpectrum(0.0)
    return TabulatedSpectrum.of(grid, amplitude / np.sinc(grid / rate_hz) ** 2, spectrum.words())
