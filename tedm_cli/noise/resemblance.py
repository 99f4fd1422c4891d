"""How the assumed correlations compare with the one that a thermal network gives."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from tedm_cli.arrays import AnyArray, FloatArray, IndexArray
from tedm_cli.noise.bounds import matrix_at
from tedm_cli.noise.correlation import Correlation


@dataclass(frozen=True, eq=False)
class Resemblance:
    """The correlation of n nodes at one frequency beside that of c assumed cases, over the pairs of different nodes.

    Parameters
    ----------
    cases : [c] ids, the most alike first. deviation : [c], see `deviation`.
    groups : [g], in the order of the areas. coherence, computed : [g, g], means of |C| and Re C over the pairs with one
        node in each group; NaN where there is no pair. assumed : [c, g, g], the same mean of Re R of each case.
    asd : [g], root mean square of the temperatures of the nodes at the frequency, K/√Hz; assumed_asd : of those that
        the cases assume for the areas of the same nodes.
    """

    cases: tuple[str, ...]
    deviation: FloatArray
    groups: tuple[str, ...]
    coherence: FloatArray
    computed: FloatArray
    assumed: FloatArray
    asd: FloatArray
    assumed_asd: FloatArray


def resemblance(
    coherence: AnyArray,
    area: IndexArray,
    assumed: Mapping[str, Correlation],
    frequency_hz: float,
    group: Sequence[str],
    asd: FloatArray,
    assumed_asd: FloatArray,
) -> Resemblance | None:
    """Compare the nodes with the cases that have noise in the areas of all of them; None where there is none.

    Parameters
    ----------
    coherence, area : as of `deviation`. assumed : by id. group, asd, assumed_asd : [n], of the nodes.
    """
    far = {name: deviation(coherence, area, case, frequency_hz) for name, case in assumed.items()}
    cases = sorted((name for name in far if np.isfinite(far[name])), key=far.__getitem__)
    if not cases:
        return None
    groups = list(dict.fromkeys(group[i] for i in np.argsort(area, kind="stable")))
    member = np.array([[g == name for g in group] for name in groups], dtype=float)
    weight = member / member.sum(axis=1, keepdims=True)
    return Resemblance(
        tuple(cases),
        np.array([far[name] for name in cases]),
        tuple(groups),
        _means(np.abs(coherence), member),
        _means(coherence.real, member),
        np.array([_means(_on_nodes(assumed[name], area, frequency_hz).real, member) for name in cases]),
        np.sqrt(weight @ asd**2),
        np.sqrt(weight @ assumed_asd**2),
    )


def deviation(coherence: AnyArray, area: IndexArray, assumed: Correlation, frequency_hz: float) -> float:
    """Root mean square of |C_ij - R_ij| over all pairs of nodes; NaN where the assumed case silences one of them.

    Amplitudes have no part in it. Nodes of one area have the correlation 1 in the assumed case.

    Parameters
    ----------
    coherence : C [n, n], correlation of the nodes at the frequency, complex.
    area : [n], the area that each node is in, columns of the assumed case.
    """
    one, other = np.triu_indices(len(area), 1)
    if not assumed.active[area].all() or not one.size:
        return float("nan")
    difference = (coherence - _on_nodes(assumed, area, frequency_hz))[one, other]
    return float(np.sqrt(np.mean(difference.real**2 + difference.imag**2)))


def _on_nodes(assumed: Correlation, area: IndexArray, frequency_hz: float) -> AnyArray:
    """R [n, n] of the nodes."""
    matrix = matrix_at(assumed.matrix().astype(np.complex128), assumed.delay_s, frequency_hz)
    return np.asarray(matrix[np.ix_(area, area)])


def _means(values: FloatArray, member: FloatArray) -> FloatArray:
    """Means [g, g] of values [n, n] over pairs of different nodes, by the groups [g, n] of both; NaN without a pair."""
    apart = 1.0 - np.eye(len(values))
    total, pairs = member @ (values * apart) @ member.T, member @ apart @ member.T
    return np.divide(total, pairs, out=np.full(total.shape, np.nan), where=pairs > 0.0)
