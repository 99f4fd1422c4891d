"""The closed loop in time: realisations of all its noise, temperature series, and free motion.

The loop and the filters that shape every noise are one linear system driven by white noises, advanced from sample to
sample without error (transition matrix and noise covariance by doubling of a short step). A sample is the mean over the
interval before it, since white noise has no value at a time; that takes sinc²(f/rate) off a spectrum. Second
derivatives of read-outs, in Δg, are second differences of samples, as a satellite's ground segment makes them.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from scipy import linalg

from tedm_cli.arrays import FloatArray
from tedm_cli.dynamics.closed_loop import OutputMap, output_map
from tedm_cli.dynamics.controller import Controller
from tedm_cli.dynamics.loops import StateSpace
from tedm_cli.dynamics.plant import Plant
from tedm_cli.dynamics.signals import DISTURBANCES, N_COORDINATES, N_INPUTS, OUTPUTS
from tedm_cli.dynamics.sources import NoiseSource, PowerLaw, columns
from tedm_cli.dynamics.state_space import loop_system
from tedm_cli.noise.shaping.sampled_filter import transition
from tedm_cli.noise.shaping.shaping_filter import ShapingFilter, shaping_filter
from tedm_cli.noise.temperature import TabulatedSpectrum, WhiteSpectrum

_BLOCK = 4096  # samples at once
_FIT_POINTS = 241
_MEMORIES = 20.0  # of the slowest state, after which noise is stationary to e^-40


@dataclass(frozen=True, eq=False)
class WhiteDriven:
    """Disturbances [45] as a system driven by m white noises of one-sided PSD 1/Hz."""

    system: StateSpace


def noise_drive(sources: Sequence[NoiseSource], band_hz: tuple[float, float], tolerance: float) -> WhiteDriven:
    """Shaping filters of all sources, each within `tolerance` of its spectrum over `band_hz`, level beyond.

    Raises `PhysicsError` for a spectrum that no filter reaches.
    """
    filters = [_filter(source, band_hz, tolerance) for source in sources]
    gains = columns(sources)
    if not filters:
        return WhiteDriven(StateSpace.gain(np.zeros((len(DISTURBANCES), 0))))
    return WhiteDriven(
        StateSpace(
            linalg.block_diag(*(f.a for f in filters)),
            linalg.block_diag(*(f.b[:, None] for f in filters)).reshape(-1, len(filters)),
            gains @ linalg.block_diag(*(f.c for f in filters)),
            gains @ np.diag([float(f.d[0]) for f in filters]),
        )
    )


def _filter(source: NoiseSource, band_hz: tuple[float, float], tolerance: float) -> ShapingFilter:
    spectrum = source.spectrum
    if isinstance(spectrum, PowerLaw) and (spectrum.corner_hz == 0.0 or spectrum.slope == 0.0):
        level = float(np.sqrt(spectrum.psd(np.array([1.0]))[0]))
        return shaping_filter((WhiteSpectrum(level),), band_hz, tolerance)
    f = np.geomspace(*band_hz, _FIT_POINTS)
    table = TabulatedSpectrum.of(f, np.sqrt(spectrum.psd(f)), source.name)
    return shaping_filter((table,), band_hz, tolerance)


def together(drives: Sequence[WhiteDriven]) -> WhiteDriven:
    """Independent drives as one."""
    parts = [d.system for d in drives]
    c, d = (np.concatenate([getattr(p, name) for p in parts], axis=1) for name in "cd")
    a, b = (linalg.block_diag(*(getattr(p, name) for p in parts)) for name in "ab")
    states, inputs = sum(len(p.a) for p in parts), d.shape[1]
    return WhiteDriven(StateSpace(a.reshape(states, states), b.reshape(states, inputs), c, d))


@dataclass(frozen=True, eq=False)
class TimeLoop:
    """The closed loop with chosen outputs in time.

    `continuous`: inputs are `DISTURBANCES` [45]; outputs are the `labels` without second derivatives, then what is to
    be differentiated twice for those in `second` (places in `labels`).
    """

    labels: tuple[str, ...]
    continuous: StateSpace
    second: tuple[int, ...]


def time_loop(plant: Plant, controller: Controller | None, labels: Sequence[str]) -> TimeLoop:
    """The loop of a continuous controller with the outputs `labels`."""
    whole = loop_system(plant, controller).system
    outputs = output_map(plant)
    rows = [OUTPUTS.index(label) for label in labels]
    second = tuple(k for k, row in enumerate(rows) if outputs.by_p2[row].any() or outputs.by_d2[row].any())
    m = len(DISTURBANCES)
    c, d = _without_derivatives(whole, outputs)
    twice = [rows[k] for k in second]
    c2 = np.zeros((len(twice), len(whole.a)))
    c2[:, :N_COORDINATES] = outputs.by_p2[twice]
    system = StateSpace(
        whole.a, whole.b[:, :m], np.concatenate([c[rows], c2]), np.concatenate([d[rows], outputs.by_d2[twice]])
    )
    return TimeLoop(tuple(labels), system, second)


def _without_derivatives(whole: StateSpace, outputs: OutputMap) -> tuple[FloatArray, FloatArray]:
    """C and D of all outputs without their second derivatives of coordinates and read-outs."""
    m, acceleration = len(DISTURBANCES), slice(N_COORDINATES, 2 * N_COORDINATES)
    c = whole.c - outputs.by_p2 @ whole.a[acceleration]
    d = whole.d[:, :m] - outputs.by_p2 @ whole.b[acceleration, :m]
    return c, d


def realise(loop: TimeLoop, drive: WhiteDriven, rate_hz: float, samples: int, seed: int) -> Iterator[FloatArray]:
    """Series [n, B] of the loop's outputs, block after block, stationary from the first sample.

    Memory does not grow with `samples`. The first two samples of outputs with second differences are made, not given.
    """
    whole = loop.continuous.after(drive.system)
    n, q, dt = len(whole.a), len(whole.c), 1.0 / rate_hz
    wide = np.block([[whole.a, np.zeros((n, q))], [whole.c, np.zeros((q, q))]])
    phi, factor = _transition(wide, np.concatenate([whole.b, whole.d]), dt)
    step, mean = np.ascontiguousarray(phi[:n, :n]), phi[n:, :n] / dt
    noise, mean_noise = factor[:n], factor[n:] / dt
    rng = np.random.default_rng(seed)
    x = stationary_factor(whole) @ rng.standard_normal(n)
    before = np.zeros((q, 0))
    extra = 2 if loop.second else 0
    left = samples + extra
    while left > 0:
        size = min(_BLOCK, left)
        white = rng.standard_normal((factor.shape[1], size))
        kicks, states = (noise @ white).T, np.empty((size, n))
        for k in range(size):
            states[k] = x
            x = step @ x + kicks[k]
        block = np.concatenate([before, mean @ states.T + mean_noise @ white], axis=1)
        left -= size
        if block.shape[1] > extra:
            yield _differenced(loop, block, dt)
            before = block[:, block.shape[1] - extra :] if extra else np.zeros((q, 0))
        else:
            before = block


def _differenced(loop: TimeLoop, block: FloatArray, dt: float) -> FloatArray:
    """Outputs of samples [q, B + 2], second differences put in; [n, B] about the middle ones (all without them)."""
    n = len(loop.labels)
    if not loop.second:
        return block[:n]
    out: FloatArray = block[:n, 1:-1].copy()
    twice = block[n:]
    out[list(loop.second)] += (twice[:, 2:] - 2.0 * twice[:, 1:-1] + twice[:, :-2]) / dt**2
    return out


def _transition(a: FloatArray, b: FloatArray, step_s: float) -> tuple[FloatArray, FloatArray]:
    """`transition` with states of one size: the shorter the first step, the fewer digits it leaves to slow poles."""
    _, (size, _) = linalg.matrix_balance(a, permute=False, separate=True)
    phi, factor = transition(a * size / size[:, None], b / size[:, None], step_s)
    return phi * size[:, None] / size, factor * size[:, None]


def stationary_factor(system: StateSpace) -> FloatArray:
    """[n, r] with F Fᵀ the stationary covariance of x: what white noise has made of it in many times its memory.

    Lyapunov's equation has the same solution, but loses the small states beside the large ones.
    """
    if not len(system.a):
        return np.zeros((0, 0))
    slowest = float(np.abs(np.linalg.eigvals(system.a).real).min())
    return _transition(system.a, system.b, _MEMORIES / slowest)[1]


def respond(
    loop: TimeLoop, disturbances: FloatArray, blocks: Iterator[FloatArray], rate_hz: float
) -> Iterator[FloatArray]:
    """Outputs [n, B] under signals that are straight between their samples, from rest; exact for such signals.

    Parameters
    ----------
    disturbances : V [45, k], what a unit of each signal adds to the disturbances.
    blocks : signals [k, B] at `rate_hz`, block after block.

    Outputs are values at the samples; those with second derivatives lose the first and the last sample.
    """
    system, dt = loop.continuous, 1.0 / rate_hz
    n, k = len(system.a), disturbances.shape[1]
    b, d = system.b @ disturbances, system.d @ disturbances
    # x over a step with u straight from u0 to u1: the exponential of the system with u and its slope as states
    wide = np.zeros((n + 2 * k, n + 2 * k))
    wide[:n, :n], wide[:n, n : n + k] = system.a * dt, b * dt
    wide[n : n + k, n + k :] = np.eye(k)
    step = linalg.expm(wide)[:n]
    phi, gain_1 = np.ascontiguousarray(step[:, :n]), step[:, n + k :]
    gain_0 = step[:, n : n + k] - gain_1
    x, last = np.zeros(n), None
    before, extra = np.zeros((len(system.c), 0)), 2 if loop.second else 0
    for signals in blocks:
        states = np.empty((signals.shape[1], n))
        for j in range(signals.shape[1]):
            now = signals[:, j]
            if last is not None:
                x = phi @ x + gain_0 @ last + gain_1 @ now
            states[j], last = x, now
        block = np.concatenate([before, system.c @ states.T + d @ signals], axis=1)
        if block.shape[1] > extra:
            yield _differenced(loop, block, dt)
            before = block[:, block.shape[1] - extra :] if extra else np.zeros((len(system.c), 0))
        else:
            before = block


def free_response(plant: Plant, controller: Controller | None, p0: FloatArray, time_s: FloatArray) -> FloatArray:
    """Coordinates [15, T] at `time_s` from p0 [15], all rates and the controller at rest."""
    a = loop_system(plant, controller).system.a
    start = np.zeros(len(a))
    start[:N_COORDINATES] = p0
    return np.stack([(linalg.expm(a * t) @ start)[:N_COORDINATES] for t in time_s], axis=1)


def thermal_columns(acceleration: FloatArray, read_out: FloatArray) -> FloatArray:
    """V [45, k]: disturbances per kelvin of S [12, k] and N [15, k]."""
    return np.concatenate([np.zeros((N_INPUTS, acceleration.shape[1])), read_out, acceleration])
