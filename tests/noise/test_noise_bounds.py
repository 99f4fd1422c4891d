import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from tedm_cli.noise.areas import AreaTable
from tedm_cli.noise.bounds import (
    BOUNDS,
    correlation_bounds,
    extremal_block_vectors,
    extremal_matrix,
    extremal_vectors,
    matrix_at,
)
from tedm_cli.noise.correlation import Correlation, CorrelationCase, correlation, full_blocks
from tedm_cli.noise.correlation_check import check_correlation
from tedm_cli.noise.propagation import OutputNoise, TemperatureNoise, output_psd
from tedm_cli.noise.selection import BlockSelector
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
    for case_id in config.ids_of_areas:
        found = correlation(config.case(case_id), areas)
        psd = TemperatureNoise(model, found).psd(rows, F)
        bounds = correlation_bounds(OutputNoise(rows, TemperatureNoise(model, found), F))
        amplitude, most = np.sqrt(psd), np.sqrt(bounds.maximum)
        # Sums of signed terms are known to rounding of the sum of their sizes.
        rounding = 1e-13 * most
        assert np.all(amplitude <= np.sqrt(bounds.known_blocks) + rounding)
        assert np.all(amplitude <= np.sqrt(bounds.maximum_non_negative) + rounding)
        assert np.all(amplitude >= np.sqrt(bounds.minimum) - rounding)
        assert np.all(amplitude >= np.sqrt(bounds.known_blocks_minimum) - rounding)
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
    bounds = correlation_bounds(OutputNoise(rows, TemperatureNoise(model, full_blocks([np.arange(k)], k)), F))
    assert np.all(psd <= bounds.maximum * (1 + 1e-10))
    assert np.all(psd >= bounds.minimum - 1e-10 * bounds.maximum)
    if non_negative:
        assert np.all(psd <= bounds.maximum_non_negative * (1 + 1e-10))


def single(h):
    return np.array([h]), TemperatureModel.from_spectra([WhiteSpectrum(1.0)] * len(h))


def attained(found, rows, model, which, o, f):
    """PSD of output `o` at frequency `f` with the extremal correlation of a bound, which is checked to be one."""
    h = rows[o] * model.amplitudes(np.array([f]))[:, 0]
    if which.startswith("known_blocks"):
        vectors = extremal_block_vectors(h, found, f, smallest=which.endswith("minimum"))
        block = np.full(len(h), -1)
        for b, index in enumerate(found.blocks):
            block[index] = b
        matrix = extremal_matrix(vectors, block, matrix_at(found.matrix(), found.delay_s, f))
    else:
        matrix = extremal_matrix(extremal_vectors(h * found.active, which))
    matrix = matrix * np.outer(found.active, found.active)
    check_correlation(matrix, found.active)
    if which == "maximum_non_negative":
        assert matrix.min() >= 0.0
    return output_psd(rows[o : o + 1], model, matrix, np.array([f]))[0, 0]


@pytest.mark.parametrize("case_id", ["1", "2", "3", "4b", "5", "8", "10", "10b"])
def test_every_bound_is_reached_by_a_real_correlation_matrix(areas, config, case_id):
    """So complex correlations, which include the real ones, reach no less and (below) no more."""
    rng = np.random.default_rng(8)
    rows, model = rng.normal(size=(2, len(areas))), model_of(rng, len(areas))
    found = correlation(config.case(case_id), areas)
    bounds = correlation_bounds(OutputNoise(rows, TemperatureNoise(model, found), F))
    for which in BOUNDS:
        psd = [[attained(found, rows, model, which, o, f) for f in F[::3]] for o in range(2)]
        expected = getattr(bounds, which)[:, ::3]
        assert np.all(np.abs(np.sqrt(psd) - np.sqrt(expected)) <= 1e-7 * np.sqrt(bounds.maximum[:, ::3]))


@settings(max_examples=40, deadline=None)
@given(seed=st.integers(0, 2**32 - 1), k=st.integers(3, 8))
def test_known_blocks_with_delays_and_coefficients(seed, k):
    """Any joint correlation that keeps the blocks stays within the bounds, and some reach them."""
    rng = np.random.default_rng(seed)
    names = np.array([f"A{i}" for i in range(k)])
    areas = AreaTable(names, *(np.array([v] * k) for v in ("g", "inside", "mid")))
    cut = int(rng.integers(1, k))
    parts = [tuple(names[:cut].tolist()), tuple(names[cut:].tolist())]
    selectors = tuple(BlockSelector(areas=p, rho=float(rng.uniform(-0.1, 1))) for p in parts)
    delays = tuple((BlockSelector(areas=(n,)), float(rng.uniform(0, 300))) for n in names.tolist())
    found = correlation(CorrelationCase("x", "", selectors, delays=delays), areas)
    rows, model = rng.normal(size=(1, k)), model_of(rng, k)
    bounds = correlation_bounds(OutputNoise(rows, TemperatureNoise(model, found), F))
    for which in ("known_blocks", "known_blocks_minimum"):
        psd = np.array([attained(found, rows, model, which, 0, f) for f in F])
        assert np.all(np.abs(np.sqrt(psd) - np.sqrt(getattr(bounds, which)[0])) <= 1e-6 * np.sqrt(bounds.maximum[0]))
    # Drive the second block by any contraction of the first one's noise: F2 = B K + the rest.
    first, second = found.factor[:, found.column_block == 0], found.factor[:, found.column_block == 1]
    mix = rng.normal(size=(second.shape[1], first.shape[1]))
    mix *= rng.random() / np.linalg.norm(mix, 2)
    rest = np.linalg.cholesky(np.eye(len(mix)) - mix @ mix.T + 1e-15 * np.eye(len(mix)))
    joint = np.hstack([first + second @ mix, second @ rest])
    psd = TemperatureNoise(model, Correlation.of_factor(joint, found.delay_s)).psd(rows, F)
    slack = 1e-9 * np.sqrt(bounds.maximum)
    assert np.all(np.sqrt(psd) <= np.sqrt(bounds.known_blocks) + slack)
    assert np.all(np.sqrt(psd) >= np.sqrt(bounds.known_blocks_minimum) - slack)


def test_bounds_by_hand():
    h = np.array([3.0, -1.0, 0.5, -2.5, 4.0])
    rows, model = single(h)
    found = full_blocks([np.array([0, 1]), np.array([2, 3]), np.array([4])], 5)
    bounds = correlation_bounds(OutputNoise(rows, TemperatureNoise(model, found), AT))
    assert bounds.maximum[0, 0] == pytest.approx(11.0**2)
    assert bounds.maximum_non_negative[0, 0] == pytest.approx(7.5**2 + 3.5**2)
    assert bounds.minimum[0, 0] == 0.0
    # Block sums 2, -2 and 4: arrows that just close.
    assert bounds.known_blocks[0, 0] == pytest.approx(8.0**2)
    assert bounds.known_blocks_minimum[0, 0] == 0.0
    assert extremal_vectors(h, "maximum")[:, 0].tolist() == [1, -1, 1, -1, 1]
    assert extremal_block_vectors(h, found, 1e-3).tolist() == [[1, 0], [1, 0], [-1, 0], [-1, 0], [1, 0]]
    opposed = extremal_vectors(np.array([3.0, -1.0, 0.5, -12.0]), "minimum")
    np.testing.assert_allclose(opposed, [[-1, 0], [1, 0], [-1, 0], [-1, 0]], atol=1e-15)


@settings(max_examples=50, deadline=None)
@given(seed=st.integers(0, 2**32 - 1), k=st.integers(3, 9))
def test_the_minimum_is_zero_where_no_area_dominates(seed, k):
    rng = np.random.default_rng(seed)
    h = rng.normal(size=k)
    assume(2 * np.abs(h).max() < 0.99 * np.abs(h).sum())
    rows, model = single(h)
    found = full_blocks([np.arange(k)], k)
    assert correlation_bounds(OutputNoise(rows, TemperatureNoise(model, found), AT)).minimum[0, 0] == 0.0
    assert attained(found, rows, model, "minimum", 0, 1e-3) < 1e-12 * np.abs(h).sum() ** 2


def test_signs_alone_do_not_reach_the_minimum():
    """Areas with or against each other leave 1 of three equal arrows; a real matrix of rank two leaves nothing."""
    rows, model = single(np.ones(3))
    signs = [np.array([1.0, a, b]) for a in (-1, 1) for b in (-1, 1)]
    assert min(output_psd(rows, model, np.outer(s, s), AT)[0, 0] for s in signs) == pytest.approx(1.0)
    found = full_blocks([np.arange(3)], 3)
    assert attained(found, rows, model, "minimum", 0, 1e-3) == pytest.approx(0.0, abs=1e-14)


def test_silent_areas_do_not_count(areas, config):
    rows = np.ones((1, len(areas)))
    bounds = correlation_bounds(
        OutputNoise(rows, TemperatureNoise(thesis_model(areas), correlation(config.case("5"), areas)), AT)
    )
    assert bounds.maximum[0, 0] == pytest.approx((12 * 1e-3) ** 2, rel=1e-12, abs=0)
