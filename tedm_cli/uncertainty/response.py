"""Ratios of outputs to their limits as functions of uncertain parameters, at the cost of a few products each.

An output of nominal row s [k] becomes, with areas in classes c of a common factor m_c on their temperatures, and with
rows D_p [k] of its change by parameter p and coefficients δ_p,

    row = Σ_c m_c 1_c (s + Σ_p δ_p D_p) = s + Σ_c (m_c - 1) s 1_c + Σ_cp m_c δ_p D_p 1_c

so it is a combination w of rows Z that do not depend on the draw, and its PSD is wᵀ M(f) w, M = Re Z C Zᴴ the
cross-spectra of the rows. Levels and model multiply: their product is kept. Of the model the changes by several
parameters add up: products of them are not kept, nor squares of what is not linear. The first row is the nominal one,
whose PSD has all the digits that the propagation gives it.

Nothing is asked of the noise but these cross-spectra. Where M(f) at many frequencies is a combination of those at a few
(temperatures of c shapes: c (c + 1) / 2), only these are evaluated.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Protocol, Self

import numpy as np
import scipy

from tedm_cli.arrays import AnyArray, BoolArray, FloatArray, IndexArray
from tedm_cli.uncertainty.parameters import Parameters

_RANK = 1e-13  # of cross-spectra over the frequencies, relative
_FREQUENCIES = 256  # at most, whose cross-spectra are held at a time
_ENTRIES = 16_000_000  # of cross-spectra that are held at a time
_VALUES = 4_000_000  # ratios and weights that are held at a time


class Noise(Protocol):
    """Noise of linear outputs at some frequencies, whatever makes it."""

    def of(self, rows: FloatArray) -> Self:
        """Of other outputs [n, k]."""

    def at(self, frequency_hz: FloatArray) -> Self:
        """At other frequencies [F]."""

    def cross_spectra(self) -> AnyArray:
        """One-sided cross-spectral densities of the outputs, [F, n, n]."""


@dataclass(frozen=True, eq=False)
class Effects:
    """What p parameters do to n outputs of k areas.

    Parameters
    ----------
    parameters : p of them.
    change : [p, n, k], of the rows by each coefficient δ; 0 of levels.
    level : [p, k], areas whose temperatures are multiplied by 1 + x; none of parameters that are no levels.
    """

    parameters: Parameters
    change: FloatArray
    level: BoolArray

    def __add__(self, other: Effects) -> Effects:
        return Effects(
            self.parameters + other.parameters,
            np.concatenate([self.change, other.change]),
            np.concatenate([self.level, other.level]),
        )

    def and_areas(self, level: BoolArray) -> Effects:
        """With more areas behind the others, of which only levels are known: which of these [p, m] act on them."""
        change = np.pad(self.change, ((0, 0), (0, 0), (0, level.shape[1])))
        return Effects(self.parameters, change, np.concatenate([self.level, level], axis=1))

    def response(self, row: FloatArray, output: int) -> Response:
        """Output number `output`, whose nominal row is `row` [k]."""
        return Response(self.parameters, row, self.change[:, output], self.level)


@dataclass(frozen=True, eq=False)
class Response:
    """One output under p parameters: `row` [k], `change` [p, k], `level` [p, k], see `Effects`."""

    parameters: Parameters
    row: FloatArray
    change: FloatArray
    level: BoolArray

    @cached_property
    def classes(self) -> tuple[BoolArray, BoolArray]:
        """Areas with the same levels: which parameters multiply each class [c, p], and its areas [c, k]."""
        if not len(self.level):
            return np.zeros((1, 0), dtype=bool), np.ones((1, len(self.row)), dtype=bool)
        which, of_area = np.unique(self.level.T, axis=0, return_inverse=True)
        members = of_area.reshape(-1) == np.arange(len(which))[:, None]
        return which, members

    @cached_property
    def _terms(self) -> list[tuple[FloatArray, int, int]]:
        """Rows [k] with their class, and their parameter; -1: the nominal row of the class."""
        which, members = self.classes
        terms = []
        for c, mine in enumerate(members):
            if which[c].any():
                terms.append((np.where(mine, self.row, 0.0), c, -1))
            terms += [(np.where(mine, change, 0.0), c, p) for p, change in enumerate(self.change)]
        return [term for term in terms if term[0].any()]

    @cached_property
    def rows(self) -> FloatArray:
        """Z [b, k], the nominal row first."""
        return np.array([self.row, *(row for row, _, _ in self._terms)])

    def weights(self, x: FloatArray) -> FloatArray:
        """w [n, b] of deviations x [n, p]."""
        items = self.parameters.items
        delta = [item.coefficient(x[:, p]) for p, item in enumerate(items)]
        which, _ = self.classes
        factor = [np.prod(1.0 + x[:, mine], axis=1) for mine in which]
        columns = [factor[c] - 1.0 if p < 0 else factor[c] * delta[p] for _, c, p in self._terms]
        return np.stack([np.ones(len(x)), *columns], axis=1)


@dataclass(frozen=True, eq=False)
class Ratio:
    """The largest ratio of an output's amplitude spectral density to a limit [F], over F frequencies.

    noise : of any rows, at any frequencies.
    """

    response: Response
    noise: Noise
    frequency_hz: FloatArray
    limit: FloatArray

    def at(self, index: IndexArray) -> Ratio:
        """At some of the frequencies."""
        return Ratio(self.response, self.noise, self.frequency_hz[index], self.limit[index])

    def worst(self, x: FloatArray) -> tuple[FloatArray, IndexArray]:
        """The ratio [n] at deviations x [n, p], and the number [n] of the frequency where it is."""
        square, where = np.full(len(x), -np.inf), np.zeros(len(x), dtype=np.intp)
        step = max(1, _VALUES // max(_FREQUENCIES, len(self.response.rows)))
        for first in range(0, len(x), step):
            some = slice(first, first + step)
            w = self.response.weights(x[some])
            for start, forms, mix in self._forms:
                values = np.stack([((w @ form) * w).sum(axis=1) for form in forms], axis=1) @ mix.T
                highest = values.argmax(axis=1)
                top = values[np.arange(len(values)), highest]
                better = top > square[some]
                square[some] = np.where(better, top, square[some])
                where[some] = np.where(better, start + highest, where[some])
        return np.sqrt(np.maximum(square, 0.0)), where

    def of(self, x: FloatArray) -> FloatArray:
        """The ratio [n] at deviations x [n, p]."""
        return self.worst(x)[0]

    @cached_property
    def _forms(self) -> list[tuple[int, FloatArray, FloatArray]]:
        """Of some frequencies in turn: the first, a few forms [r, b, b], and how all are made of them [f, r]."""
        rows = self.response.rows
        noise = self.noise.of(rows)
        out = []
        step = min(_FREQUENCIES, max(1, _ENTRIES // len(rows) ** 2))
        for start in range(0, len(self.frequency_hz), step):
            some = slice(start, start + step)
            spectra = noise.at(self.frequency_hz[some]).cross_spectra().real
            forms = spectra / self.limit[some, None, None] ** 2
            kept, mix = _few(forms)
            out.append((start, forms[kept], mix))
        return out


def _few(forms: FloatArray) -> tuple[IndexArray, FloatArray]:
    """Numbers of r forms of [F, b, b] that all are combinations of, and these, [F, r]."""
    upper = np.triu_indices(forms.shape[1])
    flat = forms[:, upper[0], upper[1]]
    size = np.sqrt(np.abs(np.diagonal(forms, axis1=1, axis2=2)).max(axis=0, initial=0.0))
    size[size == 0.0] = 1.0
    flat = flat / (size[upper[0]] * size[upper[1]])  # every row of the output counts, however little it does
    largest = int(np.abs(flat).max(axis=1).argmax())
    one = flat[largest]
    part = flat @ one / max(float(one @ one), np.finfo(np.float64).tiny)
    if np.abs(flat - part[:, None] * one).max() <= _RANK * np.abs(one).max():  # one shape of all temperatures
        return np.array([largest]), part[:, None]
    triangle, order = scipy.linalg.qr(flat.T, mode="r", pivoting=True)
    diagonal = np.abs(np.diag(triangle))
    rank = int((diagonal > _RANK * diagonal[0]).sum())
    mix = np.zeros((len(forms), rank))
    mix[order[:rank]] = np.eye(rank)
    if rank < len(order):
        rest = scipy.linalg.solve_triangular(triangle[:rank, :rank], triangle[:rank, rank:])
        mix[order[rank:]] = np.asarray(rest).T
    return order[:rank], mix
