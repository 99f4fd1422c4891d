"""The error that each element of a mesh leaves in the field at rest, its gradient and the sensitivities.

Every element is summed three times: lumped to its nodes, by the quadrature in use, and by a quadrature a hundred times
finer, which stands for the truth.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from tedm_cli.arrays import FloatArray, IntArray
from tedm_cli.gravity.cells import size_and_gap
from tedm_cli.gravity.constants import G_CODATA_2018
from tedm_cli.gravity.masses import ElementBlock, MassDistribution
from tedm_cli.gravity.quadrature import QuadraturePoints, element_sources, point_sources
from tedm_cli.gravity.structure import COLUMNS, pull_back
from tedm_cli.gravity.testmass import TestMass, to_test_mass_frame

MODELS = ("lumped", "quadrature")
_FINER = 1e-2
_BLOCK = 1024
_PAIRS = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))
_GRADIENT = [list(zip(*np.triu_indices(3), strict=True)).index(pair) for pair in _PAIRS]  # in `dc_quantities`
_KINDS = (slice(0, 3), slice(3, 6), slice(6, 12))  # of a test mass: acceleration, angular acceleration, gradient

Motion = Callable[[IntArray, FloatArray], FloatArray]
"""Displacement per kelvin of nodes with levers: rows [E, n] and levers [E, n, 3] to [k, E, n, 3], m/K."""


@dataclass(frozen=True, eq=False, kw_only=True)
class MeshAudit:
    """Errors of E elements in Q quantities.

    element_id, card : [E]; size : [E], longest extent, m; gap : [T, E], lower bound of the distance from each test
    mass, m.
    label, unit : [Q]. Sensitivities are judged by their norm over the areas of `motion` (over all grids,
    moved in the worst way by a metre, where no displacements are given).
    value : [Q], by the finer quadrature. requirement : [Q], nan where there is none. reference : [Q], the requirement,
    or the largest value of its kind on the test mass where there is none (of sensitivities the value itself).
    error : [2, Q, E], of `MODELS`, each less the finer quadrature; norms, without sign, for sensitivities.
    total : [2, Q], error of the sum over all elements.
    """

    element_id: IntArray
    card: list[str]
    size: FloatArray
    gap: FloatArray
    label: list[str]
    unit: list[str]
    value: FloatArray
    requirement: FloatArray
    reference: FloatArray
    error: FloatArray
    total: FloatArray

    @property
    def allowance(self) -> FloatArray:
        """1 % of the reference, [Q]."""
        return 0.01 * self.reference

    @property
    def score(self) -> FloatArray:
        """Largest ratio of each element's error to the allowance, [2, E]."""
        allowance = np.where(self.allowance > 0.0, self.allowance, np.inf)
        return np.asarray((np.abs(self.error) / allowance[:, None]).max(axis=1, initial=0.0))


def audit_mesh(
    distribution: MassDistribution,
    test_masses: Sequence[TestMass],
    motion: Motion | None,
    *,
    tolerance: float,
    limits: Sequence[FloatArray] | None = None,
    G: float = G_CODATA_2018,
    advance: Callable[[int], None] = lambda _: None,
) -> MeshAudit:
    """Compare lumped masses and quadrature with a finer quadrature, element by element.

    Parameters
    ----------
    distribution : the model's mass, spread over its elements (not lumped).
    test_masses : t test masses.
    motion : displacement of nodes per kelvin of each area, or None.
    tolerance : of the quadrature in use.
    limits : [t][12], magnitude to which the field at rest is limited, as `narrowest` has it; None for no limits.
        Components of the gradient without a limit take that of xx.
    advance : called with the number of elements done since the last call, every element once per test mass.

    Raises
    ------
    PhysicsError
        As `quadrature_points`.
    """
    count = sum(len(b.id) for b in distribution.elements)
    labels = [name for tm in test_masses for name in _labels(tm.name)]
    units = _units(motion is not None) * len(test_masses)
    q = len(labels) // max(len(test_masses), 1)
    error = np.zeros((2, len(labels), count))
    total, value = np.zeros((2, len(labels))), np.zeros(len(labels))
    gap, size = np.zeros((len(test_masses), count)), np.zeros(count)
    for t, tm in enumerate(test_masses):
        rows = slice(q * t, q * (t + 1))
        sums = [_Sum() for _ in range(3)]
        for points in point_sources(distribution, tm):
            coefficients = pull_back(points, tm)[1]
            sums[2].add(_effects(coefficients, points.nodes, points.lever, tm, G, motion))
        first = 0
        for block in distribution.elements:
            for start in range(0, len(block.id), _BLOCK):
                part = slice(start, min(start + _BLOCK, len(block.id)))
                here = slice(first + part.start, first + part.stop)
                nodes, lever = block.nodes[part], block.offset[part]
                local = to_test_mass_frame(tm, distribution.position[nodes] + lever)
                size[here], gap[t, here] = size_and_gap(block.shape, local, tm)
                fine = _coefficients(element_sources(distribution.position, block, part, tm, _FINER * tolerance),
                                     block, part, tm)  # fmt: skip
                used = _coefficients(element_sources(distribution.position, block, part, tm, tolerance),
                                     block, part, tm)  # fmt: skip
                lumped = pull_back(_lumps(block, part, local), tm)[1]
                sums[2].add(_effects(fine, nodes, lever, tm, G, motion))
                for m, coarse in enumerate((lumped, used)):
                    effect = _effects(coarse - fine, nodes, lever, tm, G, motion)
                    sums[m].add(effect)
                    error[m, rows, here] = _by_element(effect)
                advance(part.stop - part.start)
            first += len(block.id)
        total[:, rows] = [_by_element(s.effects)[:, 0] for s in sums[:2]]
        value[rows] = _by_element(sums[2].effects)[:, 0]
    none = np.full(len(_GRADIENT) + 6, np.nan)
    required = [_required(limit) for limit in (limits if limits is not None else [none] * len(test_masses))]
    reference = np.concatenate([_reference(r, v) for r, v in zip(required, value.reshape(-1, q), strict=True)])
    return MeshAudit(
        element_id=np.concatenate([np.zeros(0, dtype=np.int64), *(b.id for b in distribution.elements)]),
        card=[b.card for b in distribution.elements for _ in b.id],
        size=size,
        gap=gap,
        label=labels,
        unit=units,
        value=value,
        requirement=np.concatenate(required),
        reference=reference,
        error=error,
        total=total,
    )


def _required(limit: FloatArray) -> FloatArray:
    """Limits [12] of `narrowest` in the order of the quantities of one test mass; sensitivities have none."""
    gradient = limit[_GRADIENT]
    gradient = np.where(np.isnan(gradient), gradient[0], gradient)
    return np.concatenate([limit[6:9], limit[9:], gradient, np.full(6, np.nan)])


def _reference(required: FloatArray, value: FloatArray) -> FloatArray:
    """What 1 % is taken of: of one test mass."""
    largest = np.abs(value)
    for kind in _KINDS:
        largest[kind] = largest[kind].max()
    return np.where(np.isnan(required), largest, required)


def _labels(name: str) -> list[str]:
    axes = "xyz"
    return [
        *(f"{name}_a_{c}" for c in axes),
        *(f"{name}_omegadot_{c}" for c in axes),
        *(f"{name}_gamma_{axes[i]}{axes[j]}" for i, j in _PAIRS),
        *(f"{name}_S_a_{c}" for c in axes),
        *(f"{name}_S_omegadot_{c}" for c in axes),
    ]


def _units(per_kelvin: bool) -> list[str]:
    motion = ("m/s^2/K", "rad/s^2/K") if per_kelvin else ("m/s^2/m", "rad/s^2/m")
    return [*["m/s^2"] * 3, *["rad/s^2"] * 3, *["1/s^2"] * 6, *[motion[0]] * 3, *[motion[1]] * 3]


def _coefficients(sources: Iterable[QuadraturePoints], block: ElementBlock, part: slice, tm: TestMass) -> FloatArray:
    """Coefficients at the nodes of each element, [E, n, 24]."""
    out = np.zeros((part.stop - part.start, block.shape.nodes, COLUMNS))
    for points in sources:
        np.add.at(out, points.owner - part.start, pull_back(points, tm)[1])
    return out


def _lumps(block: ElementBlock, part: slice, local: FloatArray) -> QuadraturePoints:
    """The elements' masses shared equally among their nodes."""
    n = block.shape.nodes
    mass = np.repeat(block.mass[part, None] / n, n, axis=1)
    owner = np.arange(part.start, part.stop)
    return QuadraturePoints(owner, local, mass, np.eye(n)[None], block.nodes[part], block.offset[part])


def _effects(
    coefficients: FloatArray, nodes: IntArray, lever: FloatArray, tm: TestMass, G: float, motion: Motion | None
) -> tuple[FloatArray, FloatArray]:
    """Field [E, 12] (a, angular acceleration, Γ) and sensitivities [E, 6, k] of coefficients [E, n, 24]."""
    scaled = G * coefficients
    omega = scaled[..., 9:18]
    scaled[..., 9:18] = tm.per_inertia(omega.reshape(*omega.shape[:-1], 3, 3), -2).reshape(omega.shape)
    scaled[..., 21:] = tm.per_inertia(scaled[..., 21:])
    whole = scaled.sum(axis=1)
    gamma = whole[:, :9].reshape(-1, 3, 3) @ tm.axes.T
    field = np.concatenate([whole[:, 18:], np.stack([gamma[:, i, j] for i, j in _PAIRS], axis=1)], axis=1)
    operator = scaled[..., :18].reshape(*scaled.shape[:2], 6, 3)
    if motion is None:
        return field, np.linalg.norm(operator, axis=3).sum(axis=1)[:, :, None]
    return field, -np.einsum("enrc,kenc->erk", operator, motion(nodes, lever), optimize=True)


def _by_element(effects: tuple[FloatArray, FloatArray]) -> FloatArray:
    """Field, and norms of the sensitivities over the areas, [18, E]."""
    field, sensitivity = effects
    return np.asarray(np.concatenate([field, np.linalg.norm(sensitivity, axis=2)], axis=1).T)


class _Sum:
    """Effects summed over elements."""

    def __init__(self) -> None:
        self.effects: tuple[FloatArray, FloatArray] = (np.zeros((1, 12)), np.zeros((1, 6, 1)))

    def add(self, effects: tuple[FloatArray, FloatArray]) -> None:
        field, sensitivity = self.effects
        self.effects = (
            field + effects[0].sum(axis=0, keepdims=True),
            sensitivity + effects[1].sum(axis=0, keepdims=True),
        )
