"""Few points for long curves: the smallest and largest value in each of many pieces, so that no peak is lost."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tedm_cli.arrays import FloatArray, IntArray
from tedm_cli.results.noise import Spectrum

MOST = 400  # pieces along an axis; a printed panel has no more dots to tell apart


@dataclass(frozen=True, eq=False)
class ThinSpectrum:
    """A spectrum in pieces of its frequencies [p]: ends of the estimate, and of its interval."""

    frequency_hz: FloatArray
    least: FloatArray
    most: FloatArray
    low: FloatArray
    high: FloatArray

    def trace(self) -> tuple[FloatArray, FloatArray]:
        """A line [2 p] through both ends of every piece, which looks like the whole curve."""
        return np.repeat(self.frequency_hz, 2), np.stack([self.least, self.most], axis=1).reshape(-1)


def thinned(s: Spectrum) -> ThinSpectrum:
    """At most `MOST` pieces, equal on a logarithmic axis of frequency."""
    f = s.frequency_hz
    start = np.arange(len(f))
    if len(f) > MOST:
        edges = np.geomspace(f[0], f[-1], MOST + 1)[:-1]
        start = np.unique(np.searchsorted(f, edges * (1 + 1e-12)))
        start[0] = 0
    width = np.diff(np.append(start, len(f)))
    middle = np.exp(np.add.reduceat(np.log(f), start) / width)
    return ThinSpectrum(
        middle,
        np.minimum.reduceat(s.asd, start),
        np.maximum.reduceat(s.asd, start),
        np.minimum.reduceat(s.low, start),
        np.maximum.reduceat(s.high, start),
    )


def piece_starts(samples: int, most: int = MOST) -> IntArray:
    """First sample of each of at most `most` equal pieces of a series; pieces of one sample where there are few."""
    pieces = min(samples, most)
    return np.arange(pieces, dtype=np.int64) * samples // pieces
