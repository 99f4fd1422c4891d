"""The loop in time against the loop at single frequencies, and against the equations of rigid bodies."""

from __future__ import annotations

import numpy as np
import pytest
from dynamics_models import controlled, example_plant
from scipy import integrate, linalg

from tedm_cli.dynamics.budget import budget
from tedm_cli.dynamics.closed_loop import responses
from tedm_cli.dynamics.in_time import ContinuousTimeLoop, realise, released, respond, time_loop
from tedm_cli.dynamics.noise_drive import noise_drive, together
from tedm_cli.dynamics.signals import COORDINATES, DISTURBANCES, OUTPUTS
from tedm_cli.dynamics.sources import NoiseSource, PowerLaw
from tedm_cli.dynamics.steps import stationary_factor
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
    loop = time_loop(example_plant(), controlled(example_plant()), felt)
    assert isinstance(loop, ContinuousTimeLoop)
    whole = loop.continuous.after(drive.system)
    factor = stationary_factor(whole)
    phi, kick = transition(whole.a, whole.b, 1.0)
    # of outputs: states of the delays lie eighteen decades below others, where a step leaves no digits
    start = whole.c @ factor @ factor.T @ whole.c.T
    after = whole.c @ (phi @ factor @ factor.T @ phi.T + kick @ kick.T) @ whole.c.T
    scale = np.sqrt(np.diag(start))
    assert (scale > 0.0).all()
    # how many digits the slowest poles leave depends on LAPACK: 3e-7 with the one of SciPy for Python 3.13
    np.testing.assert_allclose(after / np.outer(scale, scale), start / np.outer(scale, scale), atol=1e-6)
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
def test_a_sinusoid_makes_what_the_transfer_function_says(frequency: float) -> None:
    """To eight digits: straight between its samples, a sinusoid is one at every f + k/T too, at sinc² of each."""
    plant = example_plant()
    control, step_s = controlled(plant), 5.0
    labels = ["TM1_x", "TM2_a_x", "u_TM2_Fx", "delta_g", "delta_g_full"]
    v = np.zeros((45, 2))
    v[DISTURBANCES.index("n_TM1_x"), 0], v[DISTURBANCES.index("s_TM2_a_x"), 1] = 1e-7, 2e-13
    samples = 75_000
    t = step_s * np.arange(samples)
    signal = np.sin(2 * np.pi * frequency * t) * np.ones((2, 1))
    blocks = (signal[:, i : i + 9999] for i in range(0, samples, 9999))
    loop = time_loop(plant, control, labels)
    got = np.concatenate(list(respond(loop, v, blocks, step_s, ([0], [1]))), axis=2)
    assert got.shape == (2, len(labels), samples - 2)
    tail = slice(-int(5 / frequency / step_s), None)  # whole periods, after what its beginning left has died
    wave = np.exp(2j * np.pi * frequency * t[1:-1][tail])
    found = 2j * (got[:, :, tail] @ wave.conj()) / len(wave)
    rows = [OUTPUTS.index(x) for x in labels]

    def transfer(f: np.ndarray) -> np.ndarray:
        h = np.concatenate([x[:, rows] @ v for _, x in responses(plant, control, np.abs(f), difference_s=step_s)])
        return np.where((f < 0)[:, None, None], h.conj(), h)

    nu = frequency + np.arange(-200, 201) / step_s
    direct = transfer(np.array([frequency + 1e7 / step_s]))[0]  # what does not fall with frequency: sinc² add to 1
    wanted = direct + np.einsum("f,fnk->kn", np.sinc(nu * step_s) ** 2, transfer(nu) - direct).T
    np.testing.assert_allclose(found.T / np.abs(wanted), wanted / np.abs(wanted), atol=3e-8)


def test_signals_in_blocks_of_any_length_from_rest_on() -> None:
    """Parts add up, blocks make one series, and temperatures that never change leave the loop at rest."""
    plant = example_plant()
    loop = time_loop(plant, controlled(plant), ["TM1_x", "delta_g"])
    v = np.random.default_rng(1).normal(size=(45, 3)) * 1e-9
    signal = 1.0 + 0.1 * np.random.default_rng(2).normal(size=(3, 700))

    def run(signals: np.ndarray, size: int, *parts: list[int]) -> np.ndarray:
        blocks = (signals[:, i : i + size] for i in range(0, signals.shape[1], size))
        return np.concatenate(list(respond(loop, v, blocks, 10.0, parts)), axis=2)

    whole = run(signal, 700, [0, 1, 2])
    scale = np.abs(whole).max(axis=2, keepdims=True)
    for size in (1, 2, 3, 699):
        np.testing.assert_allclose(run(signal, size, [0, 1, 2]) / scale, whole / scale, atol=1e-12)
    apart = run(signal, 100, [0], [1, 2])
    np.testing.assert_allclose(apart.sum(axis=0) / scale[0], whole[0] / scale[0], atol=1e-12)
    still = run(np.ones((3, 500)), 100, [0, 1, 2])[0]
    np.testing.assert_allclose(still / still[:, :1], 1.0, atol=1e-9)
    h = next(responses(plant, controlled(plant), np.array([1e-9])))[1][0].real @ v.sum(axis=1)
    np.testing.assert_allclose(still[:, -1], h[[OUTPUTS.index("TM1_x"), OUTPUTS.index("delta_g")]], rtol=1e-6)


def test_coordinates_that_are_let_go() -> None:
    """The exponential of the loop's matrix, sample after sample; all is back at rest in the end."""
    plant = example_plant()
    labels = ["TM1_x", "TM2_y", "SC_phi"]
    loop = time_loop(plant, controlled(plant), labels)
    assert isinstance(loop, ContinuousTimeLoop)
    offset = {"TM1_x": 1e-6, "SC_phi": -1e-7}
    path = np.concatenate(list(released(loop, offset, 0.5, 9000)), axis=1)
    np.testing.assert_allclose(path[:, 0], [1e-6, 0.0, -1e-7], atol=1e-20)
    start = np.zeros(len(loop.continuous.a))
    start[[COORDINATES.index(name) for name in offset]] = list(offset.values())
    for k in (1, 37, 5000):
        wanted = loop.continuous.c @ (linalg.expm(loop.continuous.a * 0.5 * k) @ start)
        np.testing.assert_allclose(path[:, k], wanted, rtol=1e-6, atol=1e-15)
    late = np.concatenate(list(released(loop, offset, 1000.0, 300)), axis=1)
    assert np.abs(late[:, -1]).max() < 1e-12


def test_variance_of_all_sources_is_that_of_their_filters() -> None:
    plant = example_plant()
    f = np.geomspace(1e-6, 30.0, 4000)
    psd = budget(plant, controlled(plant), SOURCES[3:4], None, f, ["TM1_x"]).total[:, 0]
    loop = time_loop(plant, controlled(plant), ["TM1_x"])
    assert isinstance(loop, ContinuousTimeLoop)
    whole = loop.continuous.after(noise_drive(SOURCES[3:4], (1e-6, 30.0), 1e-2).system)
    factor = whole.c[0] @ stationary_factor(whole)
    np.testing.assert_allclose(factor @ factor, integrate.trapezoid(psd, f), rtol=2e-3)
