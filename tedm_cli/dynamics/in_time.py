"""The closed loop in time: realisations of all its noise, temperature series, and free motion.

The loop and the filters that shape every noise are one linear system driven by white noises, advanced from sample to
sample without error (transition matrix and noise covariance by doubling of a short step). A sample of noise is the mean
over the interval before it, since white noise has no value at a time; that takes sinc²(f/rate) off a spectrum. Second
derivatives of read-outs, in Δg, are second differences of samples, as a satellite's ground segment makes them.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from tedm_cli.arrays import FloatArray
from tedm_cli.dynamics.closed_loop import OutputMap, output_map
from tedm_cli.dynamics.controller import Controller
from tedm_cli.dynamics.loops import StateSpace
from tedm_cli.dynamics.noise_drive import WhiteDriven
from tedm_cli.dynamics.own_controller import StateSpaceController
from tedm_cli.dynamics.plant import Plant
from tedm_cli.dynamics.sampled_loop import SampledTimeLoop, sampled_time_loop
from tedm_cli.dynamics.signals import COORDINATES, DISTURBANCES, N_COORDINATES, N_INPUTS, OUTPUTS
from tedm_cli.dynamics.state_space import loop_system
from tedm_cli.dynamics.steps import NoiseSteps, StraightSteps, straight, under_noise


class TimeLoop(Protocol):
    """The closed loop with chosen outputs in time.

    Outputs of its steps are the `labels` without second derivatives, then what is to be differentiated twice for those
    in `second` (places in `labels`).
    """

    @property
    def labels(self) -> tuple[str, ...]: ...

    @property
    def second(self) -> tuple[int, ...]: ...

    def under_noise(self, drive: WhiteDriven, step_s: float) -> NoiseSteps:
        """Steps under noise, samples `step_s` apart."""

    def under_signals(self, disturbances: FloatArray, step_s: float) -> StraightSteps:
        """Steps under k signals that are straight between samples; `disturbances` [45, k] by a unit of each."""

    def let_go(self, coordinates: FloatArray) -> FloatArray:
        """The states [n] of those steps with the coordinates [15] somewhere, and all else at rest."""


@dataclass(frozen=True, eq=False)
class ContinuousTimeLoop:
    """`TimeLoop` of a continuous controller; `continuous` has the `DISTURBANCES` [45] as inputs."""

    labels: tuple[str, ...]
    continuous: StateSpace
    second: tuple[int, ...]

    def under_noise(self, drive: WhiteDriven, step_s: float) -> NoiseSteps:
        return under_noise(self.continuous.after(drive.system), step_s)

    def under_signals(self, disturbances: FloatArray, step_s: float) -> StraightSteps:
        s = self.continuous
        return straight(StateSpace(s.a, s.b @ disturbances, s.c, s.d @ disturbances), step_s)

    def let_go(self, coordinates: FloatArray) -> FloatArray:
        return np.concatenate([coordinates, np.zeros(len(self.continuous.a) - len(coordinates))])


def time_loop(
    plant: Plant, controller: Controller | None, labels: Sequence[str]
) -> ContinuousTimeLoop | SampledTimeLoop:
    """The loop with the outputs `labels`."""
    if isinstance(controller, StateSpaceController) and controller.dt_s is not None:
        return sampled_time_loop(plant, controller, labels)
    whole = loop_system(plant, controller).system
    outputs = output_map(plant)
    rows = [OUTPUTS.index(label) for label in labels]
    second = outputs.differentiated(rows)
    m = len(DISTURBANCES)
    c, d = _without_derivatives(whole, outputs)
    twice = [rows[k] for k in second]
    c2 = np.zeros((len(twice), len(whole.a)))
    c2[:, :N_COORDINATES] = outputs.by_p2[twice]
    system = StateSpace(
        whole.a, whole.b[:, :m], np.concatenate([c[rows], c2]), np.concatenate([d[rows], outputs.by_d2[twice]])
    )
    return ContinuousTimeLoop(tuple(labels), system, second)


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
    step_s = 1.0 / rate_hz
    made = loop.under_noise(drive, step_s).blocks(samples + (2 if loop.second else 0), seed)
    for block in _differenced(loop, (b[None] for b in made), step_s):
        yield block[0]


def respond(
    loop: TimeLoop,
    disturbances: FloatArray,
    blocks: Iterator[FloatArray],
    step_s: float,
    parts: Sequence[Sequence[int]],
) -> Iterator[FloatArray]:
    """Outputs [g, n, B] under signals that are straight between their samples; exact for such signals.

    Parameters
    ----------
    disturbances : V [45, k], what a unit of each signal adds to the disturbances.
    blocks : signals [k, B], samples `step_s` apart, block after block.
    parts : places among the k signals of each of the g parts that are told apart.

    The loop begins at rest, as if the signals had never been other than at their first sample. Outputs are values at
    the samples, of a sampled controller means over its period before them; where any of them has second derivatives,
    all lose the first and the last sample.
    """
    steps = loop.under_signals(disturbances, step_s)
    yield from _differenced(loop, steps.blocks(blocks, parts), step_s)


def _differenced(loop: TimeLoop, blocks: Iterator[FloatArray], step_s: float) -> Iterator[FloatArray]:
    """Outputs [g, n, B] of samples [g, q, B], second differences put in about the middle ones."""
    n, second = len(loop.labels), list(loop.second)
    if not second:
        yield from blocks
        return
    held: FloatArray | None = None
    for new in blocks:
        held = new if held is None else np.concatenate([held, new], axis=2)
        if held.shape[2] > 2:
            out: FloatArray = held[:, :n, 1:-1].copy()
            twice = held[:, n:]
            out[:, second] += (twice[:, :, 2:] - 2.0 * twice[:, :, 1:-1] + twice[:, :, :-2]) / step_s**2
            yield out
            held = held[:, :, -2:]


def released(loop: TimeLoop, offset: dict[str, float], step_s: float, samples: int) -> Iterator[FloatArray]:
    """Outputs [n, B] after the coordinates are let go at `offset` (m, rad), all rates and the controller at rest."""
    steps = loop.under_signals(np.zeros((len(DISTURBANCES), 1)), step_s)
    start = loop.let_go(np.array([offset.get(name, 0.0) for name in COORDINATES]))[:, None]
    none = (np.zeros((1, min(4096, samples - first))) for first in range(0, samples, 4096))
    for block in _differenced(loop, steps.blocks(none, [[0]], start), step_s):
        yield block[0]


def thermal_columns(acceleration: FloatArray, read_out: FloatArray) -> FloatArray:
    """V [45, k]: disturbances per kelvin of S [12, k] and N [15, k]."""
    return np.concatenate([np.zeros((N_INPUTS, acceleration.shape[1])), read_out, acceleration])
