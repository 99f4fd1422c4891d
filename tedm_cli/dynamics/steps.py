"""Linear systems advanced from sample to sample without error: under white noise, and under straight signals."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
import scipy

from tedm_cli.arrays import FloatArray
from tedm_cli.dynamics.loops import StateSpace
from tedm_cli.noise.shaping.sampled_filter import lower_factor, transition

_BLOCK = 4096  # samples at once
_MEMORIES = 20.0  # of the slowest state, after which noise is stationary to e^-40


@dataclass(frozen=True, eq=False)
class NoiseSteps:
    """x[k+1] = step x[k] + kick e[k]; sample k = mean x[k] + mean_kick e[k]; e independent standard normal numbers.

    step [n, n], kick [n, r], mean [q, n], mean_kick [q, r]; x[0] = `start` [n, m] times standard normal numbers.
    """

    step: FloatArray
    kick: FloatArray
    mean: FloatArray
    mean_kick: FloatArray
    start: FloatArray

    def blocks(self, samples: int, seed: int) -> Iterator[FloatArray]:
        """Samples [q, B], block after block; memory does not grow with their number."""
        rng = np.random.default_rng(seed)
        x = self.start @ rng.standard_normal(self.start.shape[1])
        while samples > 0:
            size = min(_BLOCK, samples)
            white = rng.standard_normal((self.kick.shape[1], size))
            kicks, states = (self.kick @ white).T, np.empty((size, len(x)))
            for k in range(size):
                states[k] = x
                x = self.step @ x + kicks[k]
            samples -= size
            yield self.mean @ states.T + self.mean_kick @ white


@dataclass(frozen=True, eq=False)
class StraightSteps:
    """x[k+1] = step x[k] + before d[k] + after d[k+1]; value at sample k = c x[k] + d d[k].

    step [n, n], before, after [n, m], c [q, n], d [q, m].
    """

    step: FloatArray
    before: FloatArray
    after: FloatArray
    c: FloatArray
    d: FloatArray

    def at_rest(self, signals: FloatArray) -> FloatArray:
        """The state [n, g] that signals [m, g] which never change leave as it is."""
        matrix = np.eye(len(self.step)) - self.step
        x: FloatArray = scipy.linalg.solve(matrix, (self.before + self.after) @ signals)
        return x

    def blocks(
        self, signals: Iterator[FloatArray], parts: Sequence[Sequence[int]], start: FloatArray | None = None
    ) -> Iterator[FloatArray]:
        """Values [g, q, B] under signals [m, B], block after block.

        Parameters
        ----------
        parts : places among the m signals of each of the g parts that are told apart.
        start : [n, g], the states at the first sample; at rest under its signals where left out.
        """
        masks = np.zeros((len(parts), self.before.shape[1]))
        for mask, places in zip(masks, parts, strict=True):
            mask[list(places)] = 1.0
        x, last = start, None
        for block in signals:
            for first in range(0, block.shape[1], _BLOCK):
                now = masks[:, :, None] * block[None, :, first : first + _BLOCK]  # [g, m, B]
                if x is None:
                    x = self.at_rest(now[:, :, 0].T)
                states = np.empty((now.shape[2], *x.shape))
                done = 0
                if last is None:
                    states[0], last, done = x, now[:, :, 0], 1
                earlier = np.concatenate([last[:, :, None], now[:, :, done:-1]], axis=2)[:, :, : now.shape[2] - done]
                kicks = (self.before @ earlier + self.after @ now[:, :, done:]).transpose(2, 1, 0)
                for k, kick in enumerate(kicks, start=done):
                    x = self.step @ x + kick
                    states[k] = x
                last = now[:, :, -1]
                yield self.c @ states.transpose(2, 1, 0) + self.d @ now


def straight(system: StateSpace, step_s: float) -> StraightSteps:
    """A continuous system under signals that are straight between samples `step_s` apart.

    The exponential of the system with the signals and their slope as states.
    """
    phi, early, late = straight_gains(system.a, system.b, step_s)
    return StraightSteps(phi, early, late, system.c, system.d)


def straight_gains(a: FloatArray, b: FloatArray, step_s: float) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Φ [n, n], and what signals [m] at the beginning and at the end of a step add [n, m]."""
    n, k = b.shape
    wide = np.zeros((n + 2 * k, n + 2 * k))
    wide[:n, :n], wide[:n, n : n + k] = a * step_s, b * step_s
    wide[n : n + k, n + k :] = np.eye(k)
    step = scipy.linalg.expm(wide)[:n]
    late = step[:, n + k :]
    return np.ascontiguousarray(step[:, :n]), step[:, n : n + k] - late, late


def under_noise(system: StateSpace, step_s: float) -> NoiseSteps:
    """A stable system driven by white noises of one-sided PSD 1/Hz; samples are means over the step that ends there."""
    n, q = len(system.a), len(system.c)
    wide = np.block([[system.a, np.zeros((n, q))], [system.c, np.zeros((q, q))]])
    phi, factor = balanced_transition(wide, np.concatenate([system.b, system.d]), step_s)
    return NoiseSteps(
        np.ascontiguousarray(phi[:n, :n]), factor[:n], phi[n:, :n] / step_s, factor[n:] / step_s,
        stationary_factor(system),
    )  # fmt: skip


def balanced_transition(a: FloatArray, b: FloatArray, step_s: float) -> tuple[FloatArray, FloatArray]:
    """`transition` with states of one size: the shorter the first step, the fewer digits it leaves to slow poles."""
    _, (size, _) = scipy.linalg.matrix_balance(a, permute=False, separate=True)
    phi, factor = transition(a * size / size[:, None], b / size[:, None], step_s)
    return phi * size[:, None] / size, factor * size[:, None]


def stationary_factor(system: StateSpace) -> FloatArray:
    """[n, r] with F Fᵀ the stationary covariance of x: what white noise has made of it in many times its memory.

    Lyapunov's equation has the same solution, but loses the small states beside the large ones.
    """
    if not len(system.a):
        return np.zeros((0, 0))
    slowest = float(np.abs(np.linalg.eigvals(system.a).real).min())
    return balanced_transition(system.a, system.b, _MEMORIES / slowest)[1]


def repeated(step: FloatArray, kick: FloatArray, times: int) -> tuple[FloatArray, FloatArray]:
    """So many steps of x[k+1] = step x[k] + kick e[k] as one: its matrix, and a factor of the noise it gathers."""
    total, gathered = np.eye(len(step)), np.zeros((len(step), 0))
    while times:
        if times % 2:
            total, gathered = step @ total, lower_factor(np.hstack([step @ gathered, kick]))
        times //= 2
        if times:
            kick = lower_factor(np.hstack([step @ kick, kick]))
            step = step @ step
    return total, gathered


def stationary_steps(step: FloatArray, kick: FloatArray) -> FloatArray:
    """`stationary_factor` of x[k+1] = step x[k] + kick e[k]."""
    slowest = float(-np.log(np.abs(np.linalg.eigvals(step)).max()))
    return repeated(step, kick, 1 << int(np.ceil(np.log2(_MEMORIES / slowest))))[1]
