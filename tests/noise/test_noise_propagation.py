import mpmath
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import signal

from tedm_cli.errors import PhysicsError
from tedm_cli.noise.correlation import Correlation, block_factor, blocks, correlation_matrix
from tedm_cli.noise.propagation import TemperatureNoise, output_psd
from tedm_cli.noise.temperature import ShapedSpectrum, TemperatureModel, WhiteSpectrum, thesis_model

F = np.geomspace(1e-4, 0.1, 25)


def mixed_model(rng, k):
    """k areas with random levels and four different shapes."""
    shapes = [lambda a: WhiteSpectrum(a), *(lambda a, n=n: ShapedSpectrum(a, 1e-3, n * 1e-3, n) for n in (1, 2, 4))]
    return TemperatureModel.from_spectra([shapes[rng.integers(4)](10 ** rng.uniform(-5, -3)) for _ in range(k)])


@settings(max_examples=20, deadline=None)
@given(seed=st.integers(0, 2**32 - 1))
def test_cases_that_split_into_others_add_their_powers(areas, config, seed):
    rng = np.random.default_rng(seed)
    rows, model = rng.normal(size=(3, len(areas))), mixed_model(rng, len(areas))
    ids = config.ids_of_areas
    psd = {i: output_psd(rows, model, correlation_matrix(config.case(i), areas)[0], F) for i in ids}
    # Sums of signed terms are known to rounding of the sum of their sizes, here through the eigenvectors of R.
    rounding = 1e-13 * (np.abs(rows) @ model.amplitudes(F))
    for whole, parts in (("2", ("6", "8")), ("3", ("5", "7")), ("4", ("5", "9"))):
        assert np.all(np.abs(np.sqrt(psd[whole]) - np.sqrt(psd[parts[0]] + psd[parts[1]])) <= rounding)


@settings(max_examples=25, deadline=None)
@given(seed=st.integers(0, 2**32 - 1), k=st.integers(1, 9), complex_r=st.booleans())
def test_agrees_with_the_quadratic_form_at_each_frequency(seed, k, complex_r):
    rng = np.random.default_rng(seed)
    mixing = rng.normal(size=(k, k)) + (1j * rng.normal(size=(k, k)) if complex_r else 0)
    mixing /= np.linalg.norm(mixing, axis=1, keepdims=True)
    matrix = mixing @ mixing.conj().T
    rows, model = rng.normal(size=(2, k)), mixed_model(rng, k)
    psd = output_psd(rows, model, matrix, F)
    amplitude = model.amplitudes(F)
    for j in range(len(F)):
        cross = np.diag(amplitude[:, j]) @ matrix @ np.diag(amplitude[:, j])
        expected = np.einsum("oi,ij,oj->o", rows, cross, rows).real
        scale = (np.abs(rows) @ amplitude[:, j]) ** 2
        assert np.all(np.abs(psd[:, j] - expected) < 1e-13 * k * scale)


def test_an_output_is_the_same_to_the_bit_whichever_others_there_are():
    rng = np.random.default_rng(7)
    k = 1000  # a product of matrices of this size rounds by how many rows it has
    source = TemperatureNoise(mixed_model(rng, k), Correlation.of_factor(rng.normal(size=(k, 3))))
    rows = rng.normal(size=(24, k))
    whole = source.psd(rows, F)
    for some in (slice(0, 1), slice(0, 6), slice(5, 18)):
        assert source.psd(rows[some], F).tobytes() == whole[some].tobytes()


def test_scaling_laws(areas, config):
    rng = np.random.default_rng(5)
    rows, model = rng.normal(size=(2, len(areas))), mixed_model(rng, len(areas))
    factor = block_factor(blocks(config.case("4"), areas), len(areas))
    psd = TemperatureNoise(model, Correlation.of_factor(factor)).psd(rows, F)
    hotter = TemperatureModel(3.0 * model.scale, model.shape_index, model.shapes)
    np.testing.assert_allclose(
        TemperatureNoise(hotter, Correlation.of_factor(factor)).psd(rows, F), 9.0 * psd, rtol=1e-12
    )
    np.testing.assert_allclose(
        TemperatureNoise(model, Correlation.of_factor(factor)).psd(-0.5 * rows, F), 0.25 * psd, rtol=1e-12
    )
    equal, half = np.ones((1, 78)), thesis_model(areas)
    correlated = TemperatureNoise(half, Correlation.of_factor(np.ones((78, 1)))).psd(equal, F)
    apart = TemperatureNoise(half, Correlation.of_factor(np.eye(78))).psd(equal, F)
    # k equal areas: amplitudes add as k when correlated, as √k when not. Here 12 at 1e-3 and 66 at 1e-4.
    np.testing.assert_allclose(correlated / apart, (12 + 6.6) ** 2 / (12 + 0.66), rtol=1e-12)


@pytest.mark.parametrize("rho", [-1.0, -0.3, 0.0, 0.7, 1.0])
def test_two_areas_by_hand(rho):
    model = TemperatureModel.from_spectra([WhiteSpectrum(1e-3), ShapedSpectrum(1e-4, 1e-3, 1e-3, 1)])
    psd = output_psd(np.array([[3.0, -20.0]]), model, np.array([[1, rho], [rho, 1]]), np.array([1e-3, 7e-3]))
    # h = (3e-3, -2e-3) at 1 mHz; at 7 mHz the second falls by sqrt(2/50) = 0.2 to -0.4e-3.
    expected = [1e-6 * (9 + 4 - 12 * rho), 1e-6 * (9 + 0.16 - 2.4 * rho)]
    np.testing.assert_allclose(psd[0], expected, rtol=1e-12)


def test_a_delay_between_areas_is_coherent():
    """ΔT2(t) = ΔT1(t - τ) seen with gains 1 and 1: the comb 2 + 2 cos 2πfτ, with zeros, not the flat sum of powers."""
    delay_s = 100.0
    model = TemperatureModel.from_spectra([WhiteSpectrum(1e-3)] * 2)
    for f in (1e-3, 2.5e-3, 4e-3, 5e-3, 10e-3):
        phase = np.exp(-2j * np.pi * f * delay_s)
        psd = output_psd(np.ones((1, 2)), model, np.array([[1, phase.conj()], [phase, 1]]), np.array([f]))[0, 0]
        assert psd == pytest.approx(1e-6 * (2 + 2 * np.cos(2 * np.pi * f * delay_s)), rel=1e-12, abs=1e-20)


def test_the_sign_of_a_phase_does_not_matter_to_real_gains():
    rng = np.random.default_rng(11)
    mixing = rng.normal(size=(6, 6)) + 1j * rng.normal(size=(6, 6))
    mixing /= np.linalg.norm(mixing, axis=1, keepdims=True)
    matrix = mixing @ mixing.conj().T
    rows, model = rng.normal(size=(3, 6)), mixed_model(rng, 6)
    there, back = (output_psd(rows, model, r, F) for r in (matrix, matrix.conj()))
    np.testing.assert_allclose(there, back, rtol=1e-11)


@pytest.mark.parametrize(("through", "tolerance"), [("factor", 1e-6), ("matrix", 1e-5)])
def test_cancelling_areas_keep_their_accuracy(through, tolerance):
    """78 correlated areas whose sum is 1e-7 of its terms: the quadratic form would return rounding noise."""
    rng = np.random.default_rng(7)
    rows = rng.normal(size=(1, 78))
    rows[0, -1] = -rows[0, :-1].sum() + 1e-7
    model = TemperatureModel.from_spectra([WhiteSpectrum(1.0)] * 78)
    f = np.array([1e-3])
    if through == "factor":
        psd = TemperatureNoise(model, Correlation.of_factor(np.ones((78, 1)))).psd(rows, f)[0, 0]
    else:
        psd = output_psd(rows, model, np.ones((78, 78)), f)[0, 0]
    exact = mpmath.fsum(mpmath.mpf(float(x)) for x in rows[0]) ** 2
    assert abs(float(psd / exact) - 1.0) < tolerance


def test_output_psd_refuses_a_matrix_that_is_no_correlation():
    model = TemperatureModel.from_spectra([WhiteSpectrum(1.0)] * 2)
    with pytest.raises(PhysicsError, match="eigenvalue -1"):
        output_psd(np.ones((1, 2)), model, np.array([[1.0, 2.0], [2.0, 1.0]]), F)


def test_a_realisation_in_the_time_domain_has_the_exact_spectrum(areas, config):
    """Case 4 as seeded Gaussian series, Welch's estimate against the exact PSD over 1 to 30 mHz.

    The window must keep four decades of spectrum from leaking: Kaiser, β = 22. Relative standard deviation of the mean
    ratio: 1/√(segments × bins / noise bandwidth in bins), segments overlapping by half taken as independent, which at
    this β they nearly are. Four of those, plus the window's smoothing of a spectrum f^-4, at most 10 (σ/f)² with σ the
    rms width of its squared transform.
    """
    rng = np.random.default_rng(20041)
    fs, n, n_seg = 0.2, 2**19, 2**14
    block_list = blocks(config.case("4"), areas)
    rows = rng.normal(size=(2, len(areas)))
    model = thesis_model(areas, order=2, corner_hz=1e-3)
    frequency = np.fft.rfftfreq(n, 1 / fs)
    shape = model.shape_values(frequency)[0]
    drive = np.fft.rfft(rng.normal(size=(len(block_list), n)) * np.sqrt(fs / 2))
    driven = np.fft.irfft(drive * shape, n)
    temperature = model.scale[:, None] * (block_factor(block_list, len(areas)) @ driven)
    series = rows @ temperature

    window = signal.windows.kaiser(n_seg, 22.0, sym=False)
    f, estimate = signal.welch(series, fs, window, n_seg, n_seg // 2, detrend=False)
    band = (f >= 1e-3) & (f <= 30e-3)
    exact = TemperatureNoise(model, Correlation.of_factor(block_factor(block_list, len(areas)))).psd(rows, f[band])
    mean_ratio = (estimate[:, band] / exact).mean(axis=1)

    noise_bins = n_seg * np.sum(window**2) / np.sum(window) ** 2
    segments = 2 * n // n_seg - 1
    statistical = 1 / np.sqrt(segments * band.sum() / noise_bins)
    response = np.abs(np.fft.fft(window)) ** 2
    bins = np.fft.fftfreq(n_seg, 1 / n_seg)
    smoothing = np.mean(10 * np.sum(response * bins**2) / np.sum(response) * (fs / n_seg / f[band]) ** 2)
    assert statistical < 0.005
    assert smoothing < 1e-3
    assert np.all(np.abs(mean_ratio - 1.0) < 4 * statistical + smoothing)
