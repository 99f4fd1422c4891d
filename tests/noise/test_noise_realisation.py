import tracemalloc
from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import trapezoid

from tedm_cli.noise.correlation import block_factor, blocks, correlation_factor
from tedm_cli.noise.propagation import output_psd_from_factor
from tedm_cli.noise.realisation import Plan, in_band, realise, temperature_blocks
from tedm_cli.noise.spectral_estimate import kaiser
from tedm_cli.noise.temperature import FlightSpectrum, ShapedSpectrum, TemperatureModel, WhiteSpectrum

PLAN = Plan(rate_hz=0.1, samples=200_000, seed=5, low_hz=5e-4, high_hz=0.04, lowest_hz=2e-3)


def mean_ratio(rows, model, factor, plan):
    """Mean over the band of estimate over exact PSD [n_out], and its relative standard deviation."""
    estimate = realise(rows, model, factor, plan)
    band = in_band(estimate.frequency_hz, plan)
    f = estimate.frequency_hz[band]
    ratio = estimate.psd[:, band] / output_psd_from_factor(rows, model, factor, f)
    window = kaiser(4096)
    bins = 4096 * np.sum(window**2) / np.sum(window) ** 2  # of the window's noise bandwidth
    deviation = 1 / np.sqrt(estimate.degrees_of_freedom[0] / 2 * band.sum() / bins)
    return ratio.mean(axis=1), deviation


@pytest.mark.parametrize("case_id", ["1", "2", "3", "4", "4b", "5", "6", "7", "8", "9", "10"])
def test_every_case_has_its_exact_spectrum(areas, config, case_id):
    factor = block_factor(blocks(config.case(case_id), areas), len(areas))
    rows = np.random.default_rng(1).normal(size=(2, len(areas)))
    ratio, deviation = mean_ratio(rows, config.temperature.model(areas), factor, PLAN)
    assert deviation < 0.0035
    np.testing.assert_allclose(ratio, 1.0, atol=0.01)


def test_shapes_of_all_sorts_that_move_together():
    spectra = [ShapedSpectrum(1e-3, order=4), WhiteSpectrum(1e-6), FlightSpectrum(), ShapedSpectrum(1e-4, order=1)]
    model = TemperatureModel.from_spectra(spectra)
    factor = np.array([[1.0, 0.0], [1.0, 0.0], [0.6, 0.8], [0.0, 1.0]])
    rows = np.array([[1.0, 1.0, 1.0, 1.0], [1.0, -1.0, 2.0, -0.5], [1.0, 0.0, 0.0, 0.0]])
    ratio, deviation = mean_ratio(rows, model, factor, PLAN)
    # The steepest, f^-8, is smoothed by the window: 36 (σ/f)² with σ a thirtieth of the lowest frequency.
    np.testing.assert_allclose(ratio, 1.0, atol=4 * deviation + 0.004)


@pytest.mark.parametrize("degrees", [90.0, 50.0, -130.0])
def test_a_phase_between_areas_is_realised(degrees):
    phase = np.exp(1j * np.radians(degrees))
    factor = correlation_factor(np.array([[1.0, 0.9 * phase], [0.9 * np.conj(phase), 1.0]]))
    model = TemperatureModel.from_spectra([ShapedSpectrum(1.0), ShapedSpectrum(1.0)])
    rows = np.array([[1.0, 1.0], [1.0, -1.0], [0.0, 1.0]])
    ratio, deviation = mean_ratio(rows, model, factor, PLAN)
    np.testing.assert_allclose(ratio, 1.0, atol=4 * deviation + 0.002)


def test_cross_spectrum_has_the_sign_of_its_phase():
    """E[T_1 T_2*] = R_12 at positive frequencies, by the sum over the series' transform."""
    matrix = np.array([[1.0, 0.8j], [-0.8j, 1.0]])
    model = TemperatureModel.from_spectra([WhiteSpectrum(1.0)] * 2)
    series = np.concatenate(list(temperature_blocks(model, correlation_factor(matrix), PLAN)), axis=1)
    one, two = np.fft.rfft(series, axis=1)[:, 5000:60_000]
    found = np.mean(one * two.conj()) / np.sqrt(np.mean(np.abs(one) ** 2) * np.mean(np.abs(two) ** 2))
    assert found == pytest.approx(0.8j, abs=0.015)


def test_a_seed_gives_one_series_whatever_its_length(areas, config):
    factor = block_factor(blocks(config.case("4"), areas), len(areas))
    model = config.temperature.model(areas)

    def series(plan):
        return np.concatenate(list(temperature_blocks(model, factor, plan)), axis=1)

    short, long = replace(PLAN, samples=15_000), replace(PLAN, samples=40_000)
    first = series(short)
    assert first.shape == (78, 15_000)
    np.testing.assert_array_equal(first, series(short))
    np.testing.assert_array_equal(first, series(long)[:, :15_000])
    assert np.abs(np.corrcoef(first[0], series(replace(short, seed=6))[0])[0, 1]) < 0.5


def test_white_noise_variance_and_level():
    """One-sided PSD A² up to half the rate: variance A² rate / 2, from the first sample on, without a transient."""
    model = TemperatureModel.from_spectra([WhiteSpectrum(3.0)])
    for rate in (0.1, 0.4):
        plan = replace(PLAN, rate_hz=rate, samples=400_000)
        series = np.concatenate(list(temperature_blocks(model, np.eye(1), plan)), axis=1)[0]
        assert series.var() == pytest.approx(9.0 * rate / 2, rel=4 * np.sqrt(2 / 400_000))
    plan = replace(PLAN, samples=50)
    many = TemperatureModel.from_spectra([ShapedSpectrum(1.0)] * 300)
    variance = next(temperature_blocks(many, np.eye(300), plan)).var(axis=0)
    f = np.linspace(0.0, 0.05, 20_001)
    power = trapezoid(many.amplitudes(np.clip(f, 5e-4, 0.04))[0] ** 2, f)
    np.testing.assert_allclose(variance, power, rtol=4 * np.sqrt(2 / 300))


def test_memory_does_not_grow_with_the_length(areas, config):
    factor = block_factor(blocks(config.case("4"), areas), len(areas))
    rows, model = np.ones((2, len(areas))), config.temperature.model(areas)
    peak = []
    for samples in (100_000, 1_000_000):
        tracemalloc.start()
        realise(rows, model, factor, replace(PLAN, samples=samples))
        peak.append(tracemalloc.get_traced_memory()[1])
        tracemalloc.stop()
    assert peak[1] < 1.02 * peak[0]
