"""The loop of a sampled controller in time: against its exact spectra with all that sampling folds, and itself."""

from __future__ import annotations

import numpy as np
import pytest
from dynamics_models import example_plant
from scipy import signal

from tedm_cli.dynamics.closed_loop import responses
from tedm_cli.dynamics.controller import ScalarLoops, default_loops
from tedm_cli.dynamics.in_time import realise, released, respond, time_loop
from tedm_cli.dynamics.loops import Loop, StateSpace
from tedm_cli.dynamics.noise_drive import noise_drive
from tedm_cli.dynamics.own_controller import StateSpaceController
from tedm_cli.dynamics.plant import Plant
from tedm_cli.dynamics.sampled_spectra import sampled_psd
from tedm_cli.dynamics.signals import COORDINATES, DISTURBANCES, INPUTS, OUTPUTS
from tedm_cli.dynamics.sources import NoiseSource, PowerLaw
from tedm_cli.dynamics.stability import stability
from tedm_cli.dynamics.thermal_input import ThermalInput
from tedm_cli.errors import PhysicsError
from tedm_cli.noise.spectral_estimate import Welch, segment_length

LABELS = ["TM1_x", "meas_TM2_y", "TM2_a_x", "SC_a_x", "u_TM2_Fx", "u_SC_Fx", "delta_g", "delta_g_full"]
SOURCES = [
    NoiseSource("optical", "optical", {"n_TM1_x": 1.0, "n_TM2_x": 1.0}, PowerLaw(3e-12)),
    NoiseSource("capacitive", "capacitive", {"n_TM2_y": 1.0}, PowerLaw(1.8e-9, 1e-3, 2.0)),
    NoiseSource("thruster", "thruster", {"w_SC_Fx": 1.0}, PowerLaw(2.4e-7)),
    NoiseSource("stray", "stray", {"s_TM2_a_x": 1.0, "n_TM2_x": 1e2}, PowerLaw(3e-13, 0.63e-3, 2.0)),
]


def controller(plant: Plant, dt_s: float, delay_s: float = 0.2) -> StateSpaceController:
    s = ScalarLoops(plant, [Loop(x.name, x.crossover_hz, 0.0) for x in default_loops()]).state_space()
    a, b, c, d, _ = signal.cont2discrete((s.a, s.b, -s.c, -s.d), dt_s, "bilinear")
    return StateSpaceController(StateSpace(a, b, c, d), COORDINATES, INPUTS, delay_s, dt_s)


def silent(f: np.ndarray) -> ThermalInput:
    return ThermalInput(np.zeros((12, 1)), np.zeros((15, 1)), np.eye(1), np.zeros((1, len(f))))


@pytest.mark.parametrize(("dt_s", "periods"), [(0.2, 1), (0.1, 6)])
def test_realisations_have_the_spectrum_that_sampling_folds(dt_s: float, periods: int) -> None:
    plant = example_plant()
    own = controller(plant, dt_s)
    assert stability(plant, own).largest_real_part < 0.0
    rate = 1.0 / (periods * dt_s)
    lowest = 0.02 * rate
    welch = Welch(len(LABELS), rate, segment_length(rate, lowest))
    drive = noise_drive(SOURCES, (0.1 * lowest, 4.0), 1e-3)
    for block in realise(time_loop(plant, own, LABELS), drive, rate, 120_000, seed=1):
        welch.add(block)
    estimate = welch.estimate()
    inside = (estimate.frequency_hz > lowest) & (estimate.frequency_hz < 0.2 * rate)
    grid = np.geomspace(0.98 * lowest, 0.22 * rate, 40)
    table = np.log(sampled_psd(plant, own, SOURCES, silent, grid, LABELS, periods))
    f = estimate.frequency_hz[inside]
    exact = np.exp([np.interp(np.log(f), np.log(grid), row) for row in table])
    ratio = (estimate.psd[:, inside] / exact).mean(axis=1)
    # 120,000 samples over 0.18 of their rate: 0.7 % of scatter
    assert np.abs(ratio - 1.0).max() < 0.02, dict(zip(LABELS, ratio, strict=True))


@pytest.mark.parametrize("periods", [1, 4])
def test_spectra_of_single_frequencies_agree_well_below_the_sampling_rate(periods: int) -> None:
    """They know neither aliases nor means over samples: within 1 % up to a fiftieth of the rate of the samples.

    Not of outputs that the loop presses far below what they have at high frequencies, which means fold down.
    """
    plant = example_plant()
    own = controller(plant, 0.1)
    sample = 0.1 * periods
    f = np.geomspace(1e-3 / sample, 0.02 / sample, 12)
    rows = [OUTPUTS.index(label) for label in LABELS]
    h = np.concatenate([x[:, rows] for _, x in responses(plant, own, f)])
    plain = np.zeros((len(LABELS), len(f)))
    sources = [*SOURCES[:3], NoiseSource("stray", "stray", {"s_TM2_a_x": 1.0}, PowerLaw(3e-13, 0.63e-3, 2.0))]
    for source in sources:
        column = sum(gain * h[:, :, DISTURBANCES.index(name)] for name, gain in source.gains.items())
        plain += (np.abs(column) ** 2 * source.spectrum.psd(f)[:, None]).T
    folded = sampled_psd(plant, own, sources, silent, f, LABELS, periods)
    off = dict(zip(LABELS, np.abs(folded / plain - 1.0).max(axis=1), strict=True))
    assert max(off[name] for name in ("TM1_x", "TM2_a_x", "u_TM2_Fx", "delta_g", "delta_g_full")) < 0.01, off


def test_many_periods_are_one_sample() -> None:
    """Under a signal that is straight over four periods, every fourth sample is that of single periods."""
    plant = example_plant()
    loop = time_loop(plant, controller(plant, 0.5), ["TM1_x", "u_SC_Fx", "TM2_a_x"])
    v = np.random.default_rng(1).normal(size=(45, 2)) * 1e-9
    coarse = np.random.default_rng(2).normal(size=(2, 200))
    fine = np.stack([np.interp(np.arange(797) / 4, np.arange(200), row) for row in coarse])
    one = np.concatenate(list(respond(loop, v, iter([coarse]), 2.0, ([0], [1]))), axis=2)
    each = np.concatenate(list(respond(loop, v, iter([fine]), 0.5, ([0], [1]))), axis=2)
    scale = np.abs(one).max(axis=2, keepdims=True)
    np.testing.assert_allclose(one / scale, each[:, :, ::4] / scale, atol=1e-10)


def test_a_slow_sinusoid_makes_what_the_transfer_function_says() -> None:
    """Held commands and the delay are in it: without either it is off by more than allowed."""
    plant, f, step_s = example_plant(), 0.03, 0.1
    labels = ["TM1_x", "u_SC_Fx", "TM2_a_x"]
    v = np.zeros((45, 1))
    v[DISTURBANCES.index("n_TM1_x")], v[DISTURBANCES.index("w_SC_Fx")] = 1e-7, 1e-6
    t = step_s * np.arange(30_000)
    rows = [OUTPUTS.index(label) for label in labels]

    def made(own: StateSpaceController) -> np.ndarray:
        wave = np.exp(2j * np.pi * f * t[-10_000:])
        parts = [*respond(time_loop(plant, own, labels), v, iter([np.sin(2 * np.pi * f * t)[None]]), step_s, ([0],))]
        got = np.concatenate(parts, axis=2)[0]
        return 2j * (got[:, -10_000:] @ wave.conj()) / 10_000 / np.sinc(f * step_s) ** 2

    own = controller(plant, 0.1)
    wanted = (next(responses(plant, own, np.array([f])))[1][0, rows] @ v)[:, 0]
    wanted *= np.exp(-1j * np.pi * f * 0.1) * np.sinc(f * 0.1)  # means over the period before
    np.testing.assert_allclose(made(own) / np.abs(wanted), wanted / np.abs(wanted), atol=2e-3)
    early = made(controller(plant, 0.1, delay_s=0.0))
    assert np.abs(early / wanted - 1.0).max() > 2e-2


def test_released_coordinates_come_back() -> None:
    plant = example_plant()
    loop = time_loop(plant, controller(plant, 0.1), ["TM1_x", "u_SC_Fx"])
    path = np.concatenate(list(released(loop, {"TM1_x": 1e-6}, 1.0, 400)), axis=1)
    assert path[0, 0] == 1e-6
    assert abs(path[1, 1]) > 1e-6, "the controller has heard it"
    assert np.abs(path[0, -50:]).max() < 1e-7


def test_samples_that_are_no_whole_number_of_periods_are_refused() -> None:
    plant = example_plant()
    loop = time_loop(plant, controller(plant, 0.3), ["TM1_x"])
    with pytest.raises(
        PhysicsError, match=r"samples of 2 s are no whole number of the controller's periods of 0\.3 s"
    ) as e:
        next(realise(loop, noise_drive(SOURCES[:1], (1e-3, 1.0), 1e-2), 0.5, 100, 1))
    assert "2.1 s" in e.value.hint
