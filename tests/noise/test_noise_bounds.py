import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from tedm_cli.noise.bounds import correlation_bounds
from tedm_cli.noise.correlation import block_factor, blocks
from tedm_cli.noise.propagation import output_psd, output_psd_from_factor
from tedm_cli.noise.temperature import ShapedSpectrum, TemperatureModel, WhiteSpectrum, thesis_model

F = np.geomspace(1e-4, 0.1, 7)
AT = np.array([1e-3])


def model_of(rng, k):
    return TemperatureModel.from_spectra(
        [
            ShapedSpectrum(10 ** rng.uniform(-5, -3), 1e-3, 1e-3, 2)
            if rng.random() < 0.5
            else WhiteSpectrum(10 ** rng.uniform(-5, -3))
            for _ in range(k)
        ]
    )


@settings(max_examples=20, deadline=None)
@given(seed=st.integers(0, 2**32 - 1))
def test_bounds_hold_every_shipped_case(areas, config, seed):
    rng = np.random.default_rng(seed)
    rows, model = rng.normal(size=(2, len(areas))), model_of(rng, len(areas))
    for case_id in config.ids:
        found = blocks(config.case(case_id), areas)
        psd = output_psd_from_factor(rows, model, block_factor(found, len(areas)), F)
        bounds = correlation_bounds(rows, model, found, F)
        amplitude, most = np.sqrt(psd), np.sqrt(bounds.maximum)
        # Sums of signed terms are known to rounding of the sum of their sizes.
        rounding = 1e-13 * most
        assert np.all(amplitude <= np.sqrt(bounds.known_blocks) + rounding)
        assert np.all(amplitude <= np.sqrt(bounds.maximum_non_negative) + rounding)
        assert np.all(amplitude >= np.sqrt(bounds.minimum) - rounding)
        assert np.all(np.sqrt(bounds.maximum_non_negative) <= most + rounding)
        assert np.all(np.sqrt(bounds.known_blocks) <= most + rounding)
        if case_id == "1":  # one block: nothing is left unknown between blocks
            assert np.all(np.abs(np.sqrt(bounds.known_blocks) - amplitude) <= rounding)


@settings(max_examples=100, deadline=None)
@given(seed=st.integers(0, 2**32 - 1), k=st.integers(2, 7), complex_r=st.booleans(), non_negative=st.booleans())
def test_bounds_hold_any_correlation(seed, k, complex_r, non_negative):
    rng = np.random.default_rng(seed)
    mixing = rng.normal(size=(k, rng.integers(1, k + 1)))
    if non_negative:
        mixing = np.abs(mixing)
    elif complex_r:
        mixing = mixing * np.exp(2j * np.pi * rng.random(mixing.shape))
    mixing = mixing / np.linalg.norm(mixing, axis=1, keepdims=True)
    rows, model = rng.normal(size=(2, k)) * 10 ** rng.uniform(-1, 1, k), model_of(rng, k)
    psd = output_psd(rows, model, mixing @ mixing.conj().T, F)
    bounds = correlation_bounds(rows, model, [np.arange(k)], F)
    assert np.all(psd <= bounds.maximum * (1 + 1e-10))
    assert np.all(psd >= bounds.minimum - 1e-10 * bounds.maximum)
    if non_negative:
        assert np.all(psd <= bounds.maximum_non_negative * (1 + 1e-10))


def rank_one(phasors):
    return np.outer(phasors, np.conj(phasors))


def closing_phases(sizes):
    """Phases at which arrows of these lengths add up to zero; the longest is shorter than all others together."""
    order = np.argsort(sizes)[::-1]
    sums, member = np.zeros(3), np.empty(len(sizes), dtype=int)
    for i in order:  # the shortest of three sides gets the next arrow: they then meet the triangle inequality
        member[i] = sums.argmin()
        sums[member[i]] += sizes[i]
    a, b, c = sums
    gamma = np.arccos((a**2 + b**2 - c**2) / (2 * a * b))
    beta = np.arccos((a**2 + c**2 - b**2) / (2 * a * c))
    return np.array([0.0, np.pi - gamma, np.pi + beta])[member]


def single(h):
    return np.array([h]), TemperatureModel.from_spectra([WhiteSpectrum(1.0)] * len(h))


def test_the_maxima_are_attained():
    h = np.array([3.0, -1.0, 0.5, -2.5, 4.0])
    rows, model = single(h)
    bounds = correlation_bounds(rows, model, [np.array([0, 1]), np.array([2, 3]), np.array([4])], AT)
    signs = np.sign(h)
    worst = output_psd(rows, model, rank_one(signs), AT)
    assert worst[0, 0] == pytest.approx(11.0**2) == bounds.maximum[0, 0]
    same_sign = (rank_one(signs) > 0).astype(float)
    assert output_psd(rows, model, same_sign, AT)[0, 0] == pytest.approx(7.5**2 + 3.5**2)
    assert bounds.maximum_non_negative[0, 0] == pytest.approx(7.5**2 + 3.5**2)
    # Block sums 2, -2 and 4: blocks aligned by turning the second one round.
    aligned = output_psd(rows, model, rank_one(np.array([1.0, 1, -1, -1, 1])), AT)
    assert aligned[0, 0] == pytest.approx(8.0**2) == bounds.known_blocks[0, 0]


def test_the_minimum_is_attained_where_one_area_dominates():
    h = np.array([3.0, -1.0, 0.5, -12.0])
    rows, model = single(h)
    bounds = correlation_bounds(rows, model, [np.arange(4)], AT)
    opposed = np.sign(h) * np.array([1, 1, 1, -1])
    assert output_psd(rows, model, rank_one(opposed), AT)[0, 0] == pytest.approx(7.5**2) == bounds.minimum[0, 0]


@settings(max_examples=50, deadline=None)
@given(seed=st.integers(0, 2**32 - 1), k=st.integers(3, 9))
def test_the_minimum_is_attained_where_none_dominates(seed, k):
    rng = np.random.default_rng(seed)
    h = rng.normal(size=k)
    assume(2 * np.abs(h).max() < 0.99 * np.abs(h).sum())
    rows, model = single(h)
    bounds = correlation_bounds(rows, model, [np.arange(k)], AT)
    phasors = np.sign(h) * np.exp(1j * closing_phases(np.abs(h)))
    assert bounds.minimum[0, 0] == 0.0
    for matrix in (rank_one(phasors), rank_one(phasors).real):  # the real part is a correlation matrix just as well
        assert output_psd(rows, model, matrix, AT)[0, 0] < 1e-12 * bounds.maximum[0, 0]


def test_silent_areas_do_not_count(areas, config):
    rows = np.ones((1, len(areas)))
    bounds = correlation_bounds(rows, thesis_model(areas), blocks(config.case("5"), areas), AT)
    assert bounds.maximum[0, 0] == pytest.approx((12 * 1e-3) ** 2, rel=1e-12, abs=0)
