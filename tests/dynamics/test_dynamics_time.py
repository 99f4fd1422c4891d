"""The loop in time against the loop at single frequencies, and against the equations of rigid bodies."""

from __future__ import annotations

import numpy as np
import pytest
from dynamics_models import controlled, example_plant
from scipy import integrate

from tedm_cli.dynamics.budget import budget
from tedm_cli.dynamics.closed_loop import responses
from tedm_cli.dynamics.in_time import (
    free_response,
    noise_drive,
    realise,
    respond,
    stationary_factor,
    time_loop,
    together,
)
from tedm_cli.dynamics.signals import COORDINATES, DISTURBANCES, OUTPUTS
from tedm_cli.dynamics.sources import NoiseSource, PowerLaw
from tedm_cli.noise.shaping.sampled_filter import transition
from tedm_cli.noise.spectral_estimate import Welch, segment_length

LABELS = ["TM1_x", "meas_TM2_y", "TM2_a_x", "u_TM2_Fx", "delta_g", "delta_g_full"]
SOURCES = [
    NoiseSource("optical", "optical", {"n_TM1_x": 1.0, "n_TM2_x": 1.0}, PowerLaw(3e-12)),
    NoiseSource("optical_12", "optical", {"n_TM2_x": 1.0}, PowerLaw(2e-12)),
    NoiseSource("capacitive", "capacitive", {"n_TM2_y": 1.0}, PowerLaw(1.8e-9, 1e-3, 1.0)),
    NoiseSource("thruster", "thruster", {"w_SC_Fx": 1.0}, PowerLaw(2.4e-7)),
    NoiseSource("stray", "stray", {"s_TM2_a_x": 1.0}, PowerLaw(3e-13, 0.63e-3, 2.0)),
]


def exact_of_samples(f: np.ndarray, rate: float) -> np.ndarray:
    """PSD [n, F] of means over samples: the loop through sinc, with what lies above half the rate folded back."""
    plant = example_plant()
    control = controlled(plant)
    total = np.zeros((len(f), len(LABELS)))
    rows = [OUTPUTS.index(label) for label in LABELS]
    for alias in range(-25, 26):
        shifted = np.abs(f + alias * rate)
        h = np.concatenate([x[:, rows] for _, x in responses(plant, control, shifted, difference_s=1.0 / rate)])
        for source in SOURCES:
            column = sum(gain * h[:, :, DISTURBANCES.index(name)] for name, gain in source.gains.items())
            total += np.abs(column) ** 2 * (source.spectrum.psd(shifted) * np.sinc(shifted / rate) ** 2)[:, None]
    return total.T


def test_realisation_has_the_exact_spectrum() -> None:
    """Mean ratio within 1 %, and each value as χ² has it."""
    rate, lowest = 0.5, 2e-3
    loop = time_loop(example_plant(), controlled(example_plant()), LABELS)
    drive = noise_drive(SOURCES, (1e-5, 1.0), 3e-3)
    welch = Welch(len(LABELS), rate, segment_length(rate, lowest))
    for block in realise(loop, drive, rate, 300_000, seed=4):
        welch.add(block)
    estimate = welch.estimate()
    inside = (estimate.frequency_hz > lowest) & (estimate.frequency_hz < 0.4 * rate)
    grid = np.geomspace(0.99 * lowest, 0.42 * rate, 60)  # between these the spectra are smooth
    table = np.log(exact_of_samples(grid, rate))
    exact = np.exp([np.interp(np.log(estimate.frequency_hz[inside]), np.log(grid), row) for row in table])
    ratio = estimate.psd[:, inside] / exact
    assert np.abs(ratio.mean(axis=1) - 1.0).max() < 0.01, dict(zip(LABELS, ratio.mean(axis=1), strict=True))
    spread = ratio.std(axis=1) * np.sqrt(estimate.degrees_of_freedom[0] / 2.0)
    assert (np.abs(spread - 1.0) < 0.15).all()


def test_realisation_is_stationary_and_streamed() -> None:
    """The covariance that a series begins with is the one that a step leaves as it is; blocks make one series."""
    felt = ["SC_phi", "TM1_x", "TM1_y", "TM2_theta", "u_SC_Fx", "u_SC_Lz", "u_TM2_Fx", "u_TM2_Lx"]
    drive = noise_drive(SOURCES[2:4], (1e-5, 1.0), 1e-2)
    whole = time_loop(example_plant(), controlled(example_plant()), felt).continuous.after(drive.system)
    factor = stationary_factor(whole)
    phi, kick = transition(whole.a, whole.b, 1.0)
    # of outputs: states of the delays lie eighteen decades below others, where a step leaves no digits
    start = whole.c @ factor @ factor.T @ whole.c.T
    after = whole.c @ (phi @ factor @ factor.T @ phi.T + kick @ kick.T) @ whole.c.T
    scale = np.sqrt(np.diag(start))
    assert (scale > 0.0).all()
    np.testing.assert_allclose(after / np.outer(scale, scale), start / np.outer(scale, scale), atol=1e-7)
    loop = time_loop(example_plant(), controlled(example_plant()), ["TM1_x"])
    blocks = list(realise(loop, drive, 1.0, 10_000, 1))
    assert [b.shape[1] for b in blocks] == [4096, 4096, 1808]
    again = np.concatenate(list(realise(loop, drive, 1.0, 10_000, 1)), axis=1)
    np.testing.assert_array_equal(np.concatenate(blocks, axis=1), again)


def test_independent_drives_add() -> None:
    parts = [noise_drive([s], (1e-4, 1.0), 1e-2) for s in SOURCES[:2]]
    both, at_once = together(parts).system, noise_drive(SOURCES[:2], (1e-4, 1.0), 1e-2).system
    np.testing.assert_allclose(both.d, at_once.d, rtol=1e-14)


@pytest.mark.parametrize("frequency", [1e-3, 2e-2])
def test_a_sinusoid_of_temperature_makes_what_the_transfer_function_says(frequency: float) -> None:
    plant = example_plant()
    control, rate, k = controlled(plant), 1.0, DISTURBANCES.index("n_TM1_x")
    labels = ["TM1_x", "TM2_a_x", "delta_g"]
    v = np.zeros((45, 1))
    v[k], v[DISTURBANCES.index("s_TM2_a_x")] = 1e-7, 2e-13
    samples = int(rate * 1e5)
    t = np.arange(samples) / rate
    signal = np.sin(2 * np.pi * frequency * t)[None, :]
    blocks = (signal[:, i : i + 9999] for i in range(0, samples, 9999))
    got = np.concatenate(list(respond(time_loop(plant, control, labels), v, blocks, rate)), axis=1)
    tail = slice(-int(5 * rate / frequency), None)  # whole periods, after what began with a step has died
    when = t[1 : 1 + got.shape[1]][tail]
    wave = np.stack([np.sin(2 * np.pi * frequency * when), np.cos(2 * np.pi * frequency * when)], axis=1)
    fit = np.linalg.lstsq(wave, got[:, tail].T, rcond=None)[0]
    h = next(responses(plant, control, np.array([frequency]), difference_s=1.0 / rate))[1][0]
    wanted = h[[OUTPUTS.index(x) for x in labels]] @ v[:, 0]
    size = np.abs(wanted)
    # straight between samples, a sinusoid keeps sinc² of its amplitude
    kept = np.sinc(frequency / rate) ** 2
    np.testing.assert_allclose(fit[0] / size, wanted.real / size, atol=1.5 * (1 - kept) + 1e-3)
    np.testing.assert_allclose(fit[1] / size, wanted.imag / size, atol=1.5 * (1 - kept) + 1e-3)


def test_free_response_begins_where_it_is_put() -> None:
    plant = example_plant()
    p0 = np.zeros(15)
    p0[COORDINATES.index("TM1_x")] = 1e-6
    path = free_response(plant, controlled(plant), p0, np.array([0.0, 1e-3, 1e5]))
    np.testing.assert_allclose(path[:, 0], p0)
    assert np.abs(path[:, 2]).max() < 1e-8


def test_variance_of_all_sources_is_that_of_their_filters() -> None:
    plant = example_plant()
    f = np.geomspace(1e-6, 30.0, 4000)
    psd = budget(plant, controlled(plant), SOURCES[3:4], None, f, ["TM1_x"]).total[:, 0]
    loop = time_loop(plant, controlled(plant), ["TM1_x"])
    whole = loop.continuous.after(noise_drive(SOURCES[3:4], (1e-6, 30.0), 1e-2).system)
    factor = whole.c[0] @ stationary_factor(whole)
    np.testing.assert_allclose(factor @ factor, integrate.trapezoid(psd, f), rtol=2e-3)
