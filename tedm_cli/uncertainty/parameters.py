"""Uncertain parameters: distributions, correlations, and the independent sources that they make.

A parameter has a deviation x, which is 0 at its nominal value. In units of the deviation d that is given, with z a
standard normal variable,

    normal      x = d z                  d: one standard deviation
    uniform     x = d (2 Φ(z) - 1)       d: half the width, x in [-d, d]
    lognormal   x = exp(d z) - 1         d: one standard deviation of the logarithm

Relative parameters are p (1 + x), absolute ones p + x. What is positive by nature (moduli, densities, thicknesses and
levels) must stay so: of a normal distribution d is at most `LARGEST_NORMAL`, and z is cut off at `_LAST`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy

from tedm_cli.arrays import FloatArray, IntArray
from tedm_cli.errors import PhysicsError
from tedm_cli.noise.correlation_check import check_correlation, correlation_factor

NORMAL, UNIFORM, LOGNORMAL = "normal", "uniform", "lognormal"
EXPANSION, MODULUS, DENSITY, THICKNESS = "expansion", "modulus", "density", "thickness"
POSITION, LEVEL, MESH = "position", "level", "mesh"
POSITIVE = (MODULUS, DENSITY, THICKNESS, LEVEL)
BY_LOGARITHM = (MODULUS, THICKNESS)
STANDARD_DEVIATION, HALF_WIDTH = "standard deviation", "half width"
LARGEST_NORMAL = 0.2
_LAST = 4.9  # standard deviations; beyond are 1e-6 of a normal variable
_JOIN = " + "


@dataclass(frozen=True)
class Parameter:
    """One uncertain parameter.

    Parameters
    ----------
    name : unique. quantity : what is uncertain, one of the words above.
    of : of which materials, properties, test mass or areas, in words.
    deviation : d, relative where `unit` is "1", else in `unit`: 1/K or m.
    distribution : of x, see the module.
    source : where the deviation is from.
    """

    name: str
    quantity: str
    of: str
    deviation: float
    distribution: str
    unit: str = "1"
    source: str = ""

    @property
    def measure(self) -> str:
        """What `deviation` is of the distribution."""
        return HALF_WIDTH if self.distribution == UNIFORM else STANDARD_DEVIATION

    def deviations(self, z: FloatArray) -> FloatArray:
        """x [n] of standard normal variables z [n]."""
        d = self.deviation
        if self.distribution == UNIFORM:
            x: FloatArray = d * (2.0 * scipy.special.ndtr(z) - 1.0)
        elif self.distribution == LOGNORMAL:
            x = np.expm1(d * z)
        else:
            x = d * (np.clip(z, -_LAST, _LAST) if self.quantity in POSITIVE else z)
        return x

    def coefficient(self, x: FloatArray) -> FloatArray:
        """δ [n], by which the derivative of an output is multiplied, of deviations x [n].

        Outputs are linear in expansions, densities and positions: δ = x. They are not in moduli and thicknesses, of
        which the derivative is by the logarithm: δ = ln(1 + x) whatever the distribution, so that of a lognormal
        parameter it is normal.
        """
        return np.log1p(x) if self.quantity in BY_LOGARITHM else x


@dataclass(frozen=True, eq=False)
class Parameters:
    """p parameters with the correlation [p, p] of the normal variables behind them (a Gaussian copula).

    Of normal parameters it is the correlation of their deviations, of lognormal ones that of their logarithms.

    Raises
    ------
    PhysicsError : a matrix that is no correlation matrix.
    """

    items: tuple[Parameter, ...]
    correlation: FloatArray

    def __post_init__(self) -> None:
        _ = self.factor

    @classmethod
    def of(cls, items: tuple[Parameter, ...], pairs: Mapping[tuple[str, str], float] = {}) -> Parameters:
        """Of the correlation coefficients of pairs of names; others are uncorrelated."""
        place = {item.name: row for row, item in enumerate(items)}
        matrix = np.eye(len(items))
        for (one, two), rho in pairs.items():
            matrix[place[one], place[two]] = matrix[place[two], place[one]] = rho
        return cls(items, matrix)

    def __add__(self, other: Parameters) -> Parameters:
        return Parameters(
            self.items + other.items, np.asarray(scipy.linalg.block_diag(self.correlation, other.correlation))
        )

    def __len__(self) -> int:
        return len(self.items)

    @cached_property
    def block(self) -> IntArray:
        """[p], the independent source that each parameter belongs to, in order of first appearance."""
        related = self.correlation != 0.0
        if np.array_equal(related, np.eye(len(self), dtype=bool)):  # most often, and what finds blocks is slow to load
            return np.arange(len(self), dtype=np.int64)
        linked = scipy.sparse.csr_array(related)
        label = scipy.sparse.csgraph.connected_components(linked, directed=False)[1]
        first = {number: place for place, number in enumerate(dict.fromkeys(label.tolist()))}
        return np.array([first[number] for number in label.tolist()], dtype=np.int64)

    @property
    def sources(self) -> list[str]:
        """Names of the independent sources: of their parameters, joined."""
        block = self.block.tolist()
        return [
            _JOIN.join(item.name for item, mine in zip(self.items, block, strict=True) if mine == number)
            for number in dict.fromkeys(block)
        ]

    @cached_property
    def factor(self) -> FloatArray:
        """F [p, p] with F Fᵀ the correlation; the columns of a source are those of its parameters."""
        out = np.zeros_like(self.correlation)
        for number in range(int(self.block.max(initial=-1)) + 1):
            mine = np.flatnonzero(self.block == number)
            matrix, names = self.correlation[np.ix_(mine, mine)], [self.items[i].name for i in mine]
            try:
                check_correlation(matrix, names=names)
            except PhysicsError as error:
                raise PhysicsError(
                    f"{', '.join(names)} cannot be correlated so: {error.fact}",
                    hint="coefficients nearer to 0 can be; those of parameters with one common cause agree",
                ) from None
            part = correlation_factor(matrix)
            out[np.ix_(mine, mine[: part.shape[1]])] = part
        return out

    def deviations(self, uniform: FloatArray) -> FloatArray:
        """x [n, p] of independent variables [n, p] that are uniform in (0, 1)."""
        tiny = np.finfo(np.float64).tiny
        scores = scipy.special.ndtri(np.clip(uniform, tiny, 1.0 - np.finfo(np.float64).epsneg))
        z: FloatArray = scores @ self.factor.T
        x = np.empty_like(z)
        for i, item in enumerate(self.items):
            x[:, i] = item.deviations(z[:, i])
        return x
