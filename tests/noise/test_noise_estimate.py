import numpy as np
import pytest
from scipy import signal, stats

from tedm_cli.errors import InputError
from tedm_cli.noise.spectral_estimate import (
    LOWEST_BIN,
    Welch,
    averages_wanted,
    independent_averages,
    kaiser,
    samples_wanted,
    segment_length,
)


def estimate(series, rate, segment, blocks=(10**9,), window=None):
    welch = Welch(len(series), rate, segment, window)
    start = 0
    for size in np.resize(blocks, 10**4):
        welch.add(series[:, start : start + size])
        start += size
        if start >= series.shape[1]:
            break
    return welch.estimate()


@pytest.mark.parametrize("blocks", [(10**9,), (1,), (7, 300, 2), (128,)])
def test_blocks_of_any_length_give_what_scipy_gives_at_once(blocks):
    series = np.random.default_rng(1).normal(size=(2, 1500))
    found = estimate(series, 2.0, 128, blocks)
    f, psd = signal.welch(series, 2.0, signal.windows.kaiser(128, 22.0, sym=False), 128, 96, detrend=False)
    part = slice(LOWEST_BIN, 64)
    np.testing.assert_allclose(found.frequency_hz, f[part], rtol=1e-14)
    np.testing.assert_allclose(found.psd, psd[:, part], rtol=1e-10)


def test_steep_noise_leaks_through_hann_and_not_through_kaiser():
    """Order 4 with its corner at 1 mHz falls 8 decades in power a decade of frequency: 10^-16 at 0.1 Hz."""
    rate, n, segment = 0.4, 2**18, 2**10
    rng = np.random.default_rng(2)
    f = np.fft.rfftfreq(n, 1 / rate)
    exact = 1.0 / (1.0 + (f / 1e-3) ** 8)
    series = np.fft.irfft(np.fft.rfft(rng.normal(size=n)) * np.sqrt(exact * rate / 2), n)[None]
    worst = {}
    for name, window in (("kaiser", kaiser(segment)), ("hann", signal.windows.hann(segment, sym=False))):
        found = estimate(series, rate, segment, window=window)
        high = found.frequency_hz > 0.1
        worst[name] = np.mean(found.psd[0, high] * (1.0 + (found.frequency_hz[high] / 1e-3) ** 8))
    assert worst["kaiser"] == pytest.approx(1.0, abs=0.02)
    assert worst["hann"] > 5.0


def test_spread_of_estimates_is_that_of_their_degrees_of_freedom():
    """White noise in 400 series: each bin is chi-square with the stated degrees of freedom, and its interval holds."""
    found = estimate(np.random.default_rng(3).normal(size=(400, 2048)), 1.0, 256)
    at = found.psd[:, 30] / 2.0  # bins far apart are independent, one is enough
    nu = found.degrees_of_freedom[30]
    assert nu == pytest.approx(2 * independent_averages(29, kaiser(256)), rel=1e-12)
    # 400 values know their variance to 1/sqrt(200), and their mean to sqrt(2/nu/400).
    assert at.var() == pytest.approx(2.0 / nu, rel=4 / np.sqrt(200))
    assert at.mean() == pytest.approx(1.0, abs=4 * np.sqrt(2.0 / nu / 400))
    assert stats.kstest(at * nu, stats.chi2(nu).cdf).pvalue > 1e-3
    low, high = (v[30] for v in found.interval(0.9))
    inside = np.mean((at * low <= 1.0) & (at * high >= 1.0))
    assert inside == pytest.approx(0.9, abs=4 * np.sqrt(0.09 / 400))


def test_overlapping_segments_count_nearly_in_full():
    """At β = 22 a segment shares little with the next at 3/4 overlap: 0.89 independent ones for each."""
    assert independent_averages(1, kaiser(64)) == 1.0
    assert independent_averages(10**6, kaiser(4096)) / 1e6 == pytest.approx(0.8943, rel=1e-3)


@pytest.mark.parametrize(("tolerance", "confidence", "averages"), [(0.1, 0.95, 384.15), (0.05, 0.6827, 400.1)])
def test_length_for_a_tolerance(tolerance, confidence, averages):
    assert averages_wanted(tolerance, confidence) == pytest.approx(averages, rel=1e-3)
    n, segment = samples_wanted(0.25, 1e-3, tolerance, confidence), segment_length(0.25, 1e-3)
    assert segment == 32 * 250
    for samples, enough in ((n, True), (n - 1, False)):
        segments = 1 + (samples - segment) // (segment // 4)
        assert (independent_averages(segments, kaiser(segment)) >= averages) is enough


def test_less_than_a_segment_is_refused():
    with pytest.raises(InputError, match="99 samples are less than one segment of 128"):
        estimate(np.zeros((1, 99)), 1.0, 128)
