import tracemalloc
from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import trapezoid

from tedm_cli.errors import InputError
from tedm_cli.noise.correlation import Correlation, block_factor, blocks, correlation_factor
from tedm_cli.noise.propagation import OutputNoise, TemperatureNoise
from tedm_cli.noise.realisation import Plan, expected_psd, realise, resolved, temperature_blocks
from tedm_cli.noise.spectral_estimate import Window, kaiser, segment_length
from tedm_cli.noise.temperature import FlightSpectrum, ShapedSpectrum, Spectrum, TemperatureModel, WhiteSpectrum

SHIPPED = ["1", "2", "3", "4", "4b", "5", "6", "7", "8", "9", "10", "10b"]
PLAN = Plan(rate_hz=0.1, samples=200_000, seed=5, low_hz=5e-4, high_hz=0.04, lowest_hz=2e-3)


def noise_of(model, factor, delay_s=None):
    return TemperatureNoise(model, Correlation.of_factor(factor, delay_s))


def mean_ratio(rows, model, factor, plan):
    """Mean over the band of estimate over exact PSD [n_out], and its relative standard deviation."""
    estimate = realise(rows, noise_of(model, factor), plan)
    band = resolved(estimate.frequency_hz, plan)
    f = estimate.frequency_hz[band]
    ratio = estimate.psd[:, band] / noise_of(model, factor).psd(rows, f)
    window = kaiser(4096)
    bins = 4096 * np.sum(window**2) / np.sum(window) ** 2  # of the window's noise bandwidth
    deviation = 1 / np.sqrt(estimate.degrees_of_freedom[0] / 2 * band.sum() / bins)
    return ratio.mean(axis=1), deviation


def test_no_shipped_case_is_left_out(config):
    assert set(config.ids_of_areas) == set(SHIPPED)


@pytest.mark.parametrize("case_id", SHIPPED)
def test_every_case_has_its_exact_spectrum(areas, config, case_id):
    factor = block_factor(blocks(config.case(case_id), areas), len(areas))
    rows = np.random.default_rng(1).normal(size=(2, len(areas)))
    ratio, deviation = mean_ratio(rows, config.temperature.model(areas), factor, PLAN)
    assert deviation < 0.0035
    np.testing.assert_allclose(ratio, 1.0, atol=0.01)


def test_shapes_of_all_sorts_that_move_together():
    spectra: list[Spectrum] = [
        ShapedSpectrum(1e-3, order=4),
        WhiteSpectrum(1e-6),
        FlightSpectrum(),
        ShapedSpectrum(1e-4, order=1),
    ]
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
    series = np.concatenate(
        list(temperature_blocks(noise_of(model, correlation_factor(matrix)), PLAN)),
        axis=1,
    )
    one, two = np.fft.rfft(series, axis=1)[:, 5000:60_000]
    found = np.mean(one * two.conj()) / np.sqrt(np.mean(np.abs(one) ** 2) * np.mean(np.abs(two) ** 2))
    assert found == pytest.approx(0.8j, abs=0.015)


def test_a_seed_gives_one_series_whatever_its_length(areas, config):
    factor = block_factor(blocks(config.case("4"), areas), len(areas))
    model = config.temperature.model(areas)

    def series(plan):
        return np.concatenate(list(temperature_blocks(noise_of(model, factor), plan)), axis=1)

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
        series = np.concatenate(list(temperature_blocks(noise_of(model, np.eye(1)), plan)), axis=1)[0]
        assert series.var() == pytest.approx(9.0 * rate / 2, rel=4 * np.sqrt(2 / 400_000))
    plan = replace(PLAN, samples=50)
    many = TemperatureModel.from_spectra([ShapedSpectrum(1.0)] * 300)
    variance = next(temperature_blocks(noise_of(many, np.eye(300)), plan)).var(axis=0)
    f = np.linspace(0.0, 0.05, 20_001)
    power = trapezoid(many.amplitudes(np.clip(f, 5e-4, 0.04))[0] ** 2, f)
    np.testing.assert_allclose(variance, power, rtol=4 * np.sqrt(2 / 300))


def test_memory_does_not_grow_with_the_length(areas, config):
    factor = block_factor(blocks(config.case("4"), areas), len(areas))
    rows, model = np.ones((2, len(areas))), config.temperature.model(areas)
    peak = []
    delay_s = np.where(areas.group == "IS1", 612.5, 0.0)
    for samples in (100_000, 1_000_000):
        tracemalloc.start()
        realise(rows, noise_of(model, factor, delay_s), replace(PLAN, samples=samples))
        peak.append(tracemalloc.get_traced_memory()[1])
        tracemalloc.stop()
    assert peak[1] < 1.02 * peak[0]


def test_temperatures_of_all_areas_are_never_held(areas, config):
    """Not even of the samples that a filter of 128 periods of a low frequency is long."""
    factor = block_factor(blocks(config.case("4"), areas), len(areas))
    plan = replace(PLAN, samples=130_000, low_hz=1e-4, lowest_hz=1e-4)
    tracemalloc.start()
    realise(np.ones((2, len(areas))), noise_of(config.temperature.model(areas), factor), plan)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 8 * len(areas) * 128 * plan.rate_hz / plan.lowest_hz


def series_of(model, factor, plan, delay_s=None):
    return np.concatenate(list(temperature_blocks(noise_of(model, factor, delay_s), plan)), axis=1)


def test_whole_samples_of_delay_repeat_the_series(areas, config):
    """T_i(t) = T_0(t - τ), across blocks and beyond them; a block of 78 areas is 13,443 samples long."""
    model = TemperatureModel.from_spectra([ShapedSpectrum(1.0)] * 78)
    later = np.r_[0, 1, 777, 30_001, np.arange(74)]
    series = series_of(model, np.ones((78, 1)), replace(PLAN, samples=60_000), later / PLAN.rate_hz - 250.0)
    for i in range(1, 78):
        np.testing.assert_allclose(series[i, later[i] :], series[0, : -later[i] or None], atol=1e-12 * series.std())


def test_fractions_of_a_sample_turn_the_phase():
    """One noise in three areas: their transforms differ by exp(-2πi f τ) where the filter ends do not matter."""
    model = TemperatureModel.from_spectra([ShapedSpectrum(1.0)] * 3)
    delay_s = np.array([-31.0, 0.0, 1234.5])  # 3.1 and 123.45 samples
    series = series_of(model, np.ones((3, 1)), PLAN, delay_s)
    found = np.fft.rfft(series * kaiser(PLAN.samples), axis=1)
    f = np.fft.rfftfreq(PLAN.samples, 1 / PLAN.rate_hz)
    band = (f > 1e-3) & (f < 0.045)
    for first, last in ((1e-3, 4e-3), (4e-3, 0.02), (0.02, 0.045)):
        band = (f > first) & (f < last)
        for i in (0, 2):
            turned = found[i, band] * np.exp(2j * np.pi * f[band] * delay_s[i])
            gain = np.vdot(found[1, band], turned) / np.sum(np.abs(found[1, band]) ** 2)
            assert gain == pytest.approx(1.0, abs=5e-4)


@pytest.mark.parametrize("delay_s", [(0.0, 37.0, -14.2), (600.0, 0.0, -634.5), (0.0, 12_345.6, 30_000.0)])
def test_areas_that_cancel_and_add_along_the_frequency_do_so_in_the_realisation(delay_s):
    model = TemperatureModel.from_spectra([ShapedSpectrum(1.0), ShapedSpectrum(1.0), WhiteSpectrum(0.3)])
    factor = np.array([[1.0, 0.0], [1.0, 0.0], [0.8, 0.6]])
    rows = np.array([[1.0, 1.0, 0.0], [1.0, -1.0, 0.0], [1.0, -1.0, 2.0]])
    estimate = realise(rows, noise_of(model, factor, np.array(delay_s)), PLAN)
    band = resolved(estimate.frequency_hz, PLAN)
    f = estimate.frequency_hz[band]
    expected = expected_psd(OutputNoise(rows, noise_of(model, factor, np.array(delay_s)), f), PLAN)
    ratio = estimate.psd[:, band] / expected
    np.testing.assert_allclose(ratio.mean(axis=1), 1.0, atol=0.01)
    low, high = (side[band] for side in estimate.interval(0.95))
    assert np.mean((ratio * low <= 1.0) & (ratio * high >= 1.0)) > 0.88
    # Sum and difference of the first two give the real part of their coherence: cos(2πfτ), less what the window rounds.
    plus, minus = estimate.psd[:2, band]
    apart = abs(delay_s[0] - delay_s[1])
    stripes = np.cos(2 * np.pi * f * apart)
    seen = np.exp(-((2 * np.pi * apart * PLAN.lowest_hz / 30) ** 2) / 2)
    coherence = (plus - minus) / (plus + minus)
    np.testing.assert_allclose(coherence, seen * stripes, atol=0.002 if apart < 50 else 0.2)
    assert coherence @ stripes / (stripes @ stripes) == pytest.approx(seen, abs=0.01)


def test_delays_in_common_or_of_silent_areas_change_no_bit():
    model = TemperatureModel.from_spectra([ShapedSpectrum(1.0)] * 3)
    factor, plan = np.array([[1.0], [0.0], [1.0]]), replace(PLAN, samples=5000)
    plain = series_of(model, factor, plan)
    for delay_s in ([0.0, 0.0, 0.0], [17.3, 17.3, 17.3], [-5.0, 1e9, -5.0]):
        np.testing.assert_array_equal(series_of(model, factor, plan, np.array(delay_s)), plain)


def test_delays_that_cannot_be_held_are_refused():
    model = TemperatureModel.from_spectra([ShapedSpectrum(1.0)] * 2)
    for factor, most in ((np.eye(2), "8,388,608"), (np.ones((2, 1)), "16,777,216")):
        delay_s = np.array([-20.0, 10.0 * int(most.replace(",", ""))])
        with pytest.raises(InputError, match=rf"samples at 0\.1 Hz; .* at most {most} can be held") as caught:
            next(temperature_blocks(noise_of(model, factor, delay_s), PLAN))
        assert "lower rate_hz" in caught.value.hint


def test_expectation_is_the_exact_spectrum_through_the_window():
    """By the lags: the window's autocorrelation times the covariance, here of white noise and of its delayed copy."""
    model = TemperatureModel.from_spectra([WhiteSpectrum(1.0)] * 2)
    window = kaiser(segment_length(PLAN.rate_hz, PLAN.lowest_hz))
    f = np.array([2e-3, 7.7e-3, 0.03])
    for later in (0, 3, 100, 700, 1599, 1600, 5000):
        shared = np.sum(window[later:] * window[: len(window) - later]) / np.sum(window**2) if later < 1600 else 0.0
        found = expected_psd(
            OutputNoise(
                np.ones((1, 2)),
                noise_of(model, np.ones((2, 1)), np.array([0.0, 10.0 * later])),
                f,
            ),
            PLAN,
        )[0]
        np.testing.assert_allclose(found, 2 + 2 * shared * np.cos(2 * np.pi * f * 10.0 * later), atol=1e-4)


def test_expectation_without_delays_is_the_exact_spectrum_but_where_it_is_steep():
    """f^-4 through a window of width σ: 1 + 10 (σ/f)², σ a thirtieth of the lowest frequency."""
    model = TemperatureModel.from_spectra([ShapedSpectrum(1.0, corner_hz=1e-5, order=2)])
    f = np.array([2e-3, 4e-3, 0.03])
    exact = noise_of(model, np.eye(1)).psd(np.ones((1, 1)), f)[0]
    excess = expected_psd(OutputNoise(np.ones((1, 1)), noise_of(model, np.eye(1)), f), PLAN)[0] / exact - 1
    assert excess == pytest.approx(10 * (2e-3 / 30 / f) ** 2, rel=0.03, abs=0)


def test_expectation_through_windows_of_a_width_for_each_frequency():
    """By the window's own transform, here of segments that get shorter with frequency, f^-4."""
    beta, rate = 25.4, PLAN.rate_hz
    model = TemperatureModel.from_spectra([ShapedSpectrum(1.0, corner_hz=1e-5, order=2)])
    f, segment = np.array([2e-3, 6e-3, 0.02]), np.array([800, 400, 160])
    found = expected_psd(
        OutputNoise(np.ones((1, 1)), noise_of(model, np.eye(1)), f),
        PLAN,
        Window(rate / segment, beta),
    )[0]
    for at, length, value in zip(f, segment, found, strict=True):
        taps = np.kaiser(length + 1, beta)[:length]
        near = at + np.linspace(-9, 9, 3001) * rate / length
        power = np.abs(np.exp(-2j * np.pi * np.outer(near - at, np.arange(length)) / rate) @ taps) ** 2
        exact = noise_of(model, np.eye(1)).psd(np.ones((1, 1)), np.clip(near, PLAN.low_hz, PLAN.high_hz))[0]
        assert value == pytest.approx(trapezoid(power * exact, near) / trapezoid(power, near), rel=2e-4, abs=0)
