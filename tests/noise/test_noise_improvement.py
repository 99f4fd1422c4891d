"""What would bring a verdict down, against direct propagation with the changed amplitudes."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tedm_cli.cli.printing.contributors import _capped
from tedm_cli.noise.contributions import path_shares
from tedm_cli.noise.correlation import Correlation, full_blocks
from tedm_cli.noise.correlation_check import correlation_factor
from tedm_cli.noise.improvement import COUNTS, improvement
from tedm_cli.noise.propagation import OutputNoise, TemperatureNoise
from tedm_cli.noise.temperature import ShapedSpectrum, Spectrum, TemperatureModel, WhiteSpectrum

F = np.geomspace(1e-3, 3e-2, 21)


def worst_ratio(row, model, found, limit):
    psd = TemperatureNoise(model, found).psd(row[None], F)[0]
    return (np.sqrt(psd) / limit).max()


def random_problem(seed, k):
    rng = np.random.default_rng(seed)
    mixing = rng.normal(size=(k, rng.integers(1, k + 1)))
    mixing /= np.linalg.norm(mixing, axis=1, keepdims=True)
    factor = correlation_factor(mixing @ mixing.T)
    delay_s = rng.uniform(0, 200, k) * rng.integers(2)
    found = Correlation((np.arange(k),), factor, np.zeros(factor.shape[1], dtype=int), delay_s)
    shapes: list[Spectrum] = [WhiteSpectrum(1.0), ShapedSpectrum(1.0)]
    model = TemperatureModel.from_spectra([shapes[rng.integers(2)] for _ in range(k)])
    return rng, rng.normal(size=k), model, found


@settings(max_examples=50, deadline=None)
@given(seed=st.integers(0, 2**32 - 1), k=st.integers(2, 9))
def test_factors_of_groups_just_meet_the_limit(seed, k):
    rng, row, model, found = random_problem(seed, k)
    limit = np.full(len(F), 10 ** rng.uniform(-0.7, 0.7)) * (1 + F / 3e-3)
    member = rng.integers(0, 2, k)
    groups = [member == g for g in (0, 1) if (member == g).any()]
    found_factors = improvement(
        OutputNoise(row[None], TemperatureNoise(model, found), F), 0, limit, groups
    ).group_factor
    for mask, factor in zip(groups, found_factors, strict=True):

        def ratio(s, mask=mask):
            return worst_ratio(np.where(mask, s * row, row), model, found, limit)

        if np.isnan(factor):
            # No amplitude from silence up to the present one would do.
            assert min(ratio(s) for s in np.linspace(0, 1, 201)) > 1.0
        else:
            assert ratio(factor) == pytest.approx(1.0, rel=1e-7, abs=0)
            assert ratio(factor * 1.01) > 1.0
            assert ratio(1.0) <= 1.0 or factor < 1.0


@settings(max_examples=30, deadline=None)
@given(seed=st.integers(0, 2**32 - 1), k=st.integers(2, 12))
def test_silencing_is_what_propagation_without_these_areas_gives(seed, k):
    rng, row, model, found = random_problem(seed, k)
    limit, binding = np.ones(len(F)), int(rng.integers(len(F)))
    result = improvement(
        OutputNoise(row[None], TemperatureNoise(model, found), F), binding, limit, [np.ones(k, dtype=bool)]
    )
    worst = result.worst[result.worst >= 0]
    assert len(set(worst.tolist())) == len(worst)
    for n, count in enumerate(COUNTS):
        for scale, ratios in ((0.0, result.silenced), (0.1, result.quieter)):
            changed = row.copy()
            changed[worst[:count]] *= scale
            assert ratios[n] == pytest.approx(worst_ratio(changed, model, found, limit), rel=1e-9, abs=1e-12)
    # Each next area is the best choice there is at the binding frequency.
    f = F[binding : binding + 1]

    def power(silent):
        left = np.where(np.isin(np.arange(k), silent), 0.0, row)
        return TemperatureNoise(model, found).psd(left[None], f)[0, 0]

    for n in range(len(worst)):
        tried = [power([*worst[:n], i]) for i in range(k) if i not in worst[:n]]
        assert power(worst[: n + 1]) <= min(tried) + 1e-9 * power([])
        assert power(worst[: n + 1]) < power(worst[:n])


def test_by_hand():
    """h = 3, -1 in one block, 2 alone, limit 2: S = (3 - 1)² + 2² = 8. Silence the 3 first: 1 + 4; then the 2: 1."""
    model = TemperatureModel.from_spectra([WhiteSpectrum(1.0)] * 3)
    found = full_blocks([np.array([0, 1]), np.array([2])], 3)
    groups = [np.array(m) for m in ([True, False, False], [False, True, False], [False, False, True])]
    result = improvement(
        OutputNoise(np.array([[3.0, -1.0, 2.0]]), TemperatureNoise(model, found), F), 0, np.full(len(F), 2.0), groups
    )
    # The 2 alone brings 4 of relief, the 3 brings 8 - 5 = 3: the 2 is first, then 4 - 1 = 3 by the 3, then the -1.
    assert result.worst[:4].tolist() == [2, 0, 1, -1]
    np.testing.assert_allclose(result.silenced[:4], np.sqrt([8, 4, 1, 0]) / 2, atol=1e-15)
    # (3 s - 1)² + 4 <= 4 for s = 1/3 alone; (3 - s)² + 4 <= 4 only by three times the noise; 4 + 4 s² <= 4 for s = 0.
    assert result.group_factor[0] == pytest.approx(1 / 3)
    assert np.isnan(result.group_factor[1])
    assert result.group_factor[2] == 0.0


@pytest.mark.parametrize(("limit", "factor"), [(0.3, np.nan), (0.6, 2.1)])
def test_a_group_is_not_asked_to_be_noisier_until_it_cancels(limit, factor):
    """|1.5 - s| <= 0.3 from s = 1.2 on only, so no quieter group does it; <= 0.6 at s = 1 already, and up to 2.1."""
    model = TemperatureModel.from_spectra([WhiteSpectrum(1.0)] * 2)
    found = full_blocks([np.array([0, 1])], 2)
    second = [np.array([False, True])]
    result = improvement(
        OutputNoise(np.array([[1.5, -1.0]]), TemperatureNoise(model, found), F), 0, np.full(len(F), limit), second
    )
    assert result.group_factor[0] == pytest.approx(factor, nan_ok=True)


@settings(max_examples=30, deadline=None)
@given(seed=st.integers(0, 2**32 - 1), k=st.integers(2, 8), p=st.integers(1, 5))
def test_path_shares_are_the_derivative_of_the_power(seed, k, p):
    rng, _, model, found = random_problem(seed, k)
    paths = rng.normal(size=(p, k))
    f = F[:1]
    share = path_shares(OutputNoise(paths, TemperatureNoise(model, found), f))
    assert share.sum() == pytest.approx(1.0)

    def psd(change):
        row = ((1 + change)[:, None] * paths).sum(axis=0)
        return TemperatureNoise(model, found).psd(row[None], f)[0, 0]

    for i in range(p):
        step = 1e-4 * (np.arange(p) == i)
        slope = (psd(step) - psd(-step)) / (4e-4 * psd(0 * step))
        assert slope == pytest.approx(share[i], rel=1e-6, abs=1e-8 * np.abs(share).max())


def random_blocks(seed, k):
    """A random problem in which every area is in one of some blocks, correlated at random inside of them, or silent."""
    rng, row, model, found = random_problem(seed, k)
    owner = rng.integers(0, rng.integers(1, k + 1), k)
    owner[rng.random(k) < 0.2] = -1
    members = [np.flatnonzero(owner == b) for b in np.unique(owner[owner >= 0])]
    factors = [correlation_factor((found.factor @ found.factor.T)[np.ix_(m, m)]) for m in members]
    factor = np.zeros((k, sum(f.shape[1] for f in factors)))
    column = 0
    for m, f in zip(members, factors, strict=True):
        factor[m, column : column + f.shape[1]] = f
        column += f.shape[1]
    width = [f.shape[1] for f in factors]
    blocks = Correlation(tuple(members), factor, np.repeat(np.arange(len(members)), width), found.delay_s)
    return rng, row, model, blocks


def matched_directly(row, model, found, limit, blocks):
    """Ratio with the areas of the blocks following one fluctuation, none later than another, apart from all others."""
    k = len(row)
    inside = np.isin(np.arange(k), [i for b in blocks for i in found.blocks[b]])
    factor = np.hstack([np.where(inside[:, None], 0.0, found.factor), inside[:, None]])
    own = Correlation((np.arange(k),), factor, np.zeros(factor.shape[1], dtype=int), np.where(inside, 0, found.delay_s))
    return worst_ratio(row, model, own, limit)


@settings(max_examples=40, deadline=None)
@given(seed=st.integers(0, 2**32 - 1), k=st.integers(1, 12))
def test_matching_is_propagation_with_these_blocks_as_one(seed, k):
    rng, row, model, found = random_blocks(seed, k)
    limit, binding = np.ones(len(F)), int(rng.integers(len(F)))
    result = improvement(OutputNoise(row[None], TemperatureNoise(model, found), F), binding, limit, [found.active])
    match = result.match[result.match >= 0]
    assert len(match) != 1
    assert len(set(match.tolist())) == len(match)
    for n, count in enumerate(COUNTS):
        expected = matched_directly(row, model, found, limit, match[:count] if count > 1 else [])
        assert result.matched[n] >= 0.0
        assert result.matched[n] == pytest.approx(expected, rel=1e-9, abs=1e-12)
    np.testing.assert_array_equal(result.matched[:2], result.silenced[:1].repeat(2))

    # The first pair is the best of all pairs at the binding frequency, and each next area the best there is.
    def power(blocks):
        f = F[binding : binding + 1]
        inside = np.isin(np.arange(k), [i for b in blocks for i in found.blocks[b]])
        out = TemperatureNoise(model, found).psd(np.where(inside, 0, row)[None], f)[0, 0]
        return out + (np.where(inside, row, 0) @ model.amplitudes(f)[:, 0]) ** 2

    whole, felt = power([]), range(len(found.blocks))
    small = 1e-9 * (whole + np.sum((row * model.amplitudes(F[binding : binding + 1])[:, 0]) ** 2))
    pairs = [power([i, j]) for i in felt for j in felt if i < j]
    if len(match):
        assert power(match[:2]) <= min(pairs) + small
        assert power(match[:2]) < whole
    else:
        assert min(pairs, default=whole) >= whole - small
    for n in range(3, len(match) + 1):
        assert power(match[:n]) < power(match[: n - 1])
        assert power(match[:n]) <= min(power([*match[: n - 1], i]) for i in felt if i not in match[: n - 1]) + small


def of_areas_alone(amplitudes, spectrum):
    """The areas' improvement when each stands alone, against a limit of 1."""
    row = np.array(amplitudes)
    model = TemperatureModel.from_spectra([spectrum] * len(row))
    found = full_blocks([np.array([i]) for i in range(len(row))], len(row))
    return improvement(
        OutputNoise(row[None], TemperatureNoise(model, found), F), 0, np.ones(len(F)), [np.ones(len(row), dtype=bool)]
    )


def test_matching_by_hand():
    """h = 3, -2, 1: 9 + 4 + 1 = 14. 3 and -2 as one: 1 + 1 = 2. All three: 2² = 4, no relief."""
    result = of_areas_alone([3.0, -2.0, 1.0], WhiteSpectrum(1.0))
    assert result.match.tolist() == [0, 1, *[-1] * 8]
    np.testing.assert_allclose(result.matched, np.sqrt([14, 14, 2, 2, 2, 2]), rtol=1e-14)
    # 5 and -3 as one leave 4 + 4; the -2 then cancels the rest.
    result = of_areas_alone([5.0, -3.0, -2.0], WhiteSpectrum(1.0))
    assert result.match[:4].tolist() == [0, 1, 2, -1]
    np.testing.assert_allclose(result.matched, np.sqrt([38, 38, 8, 0, 0, 0]), atol=1e-14)
    # The two loudest add: they are the first to silence, and no partners.
    result = of_areas_alone([5.0, 4.9, -3.0, -2.0], WhiteSpectrum(1.0))
    assert result.worst[:2].tolist() == [0, 1]
    assert result.match[:4].tolist() == [0, 2, 3, -1]
    np.testing.assert_allclose(result.matched[2:4], np.sqrt([4 + 4.9**2 + 4, 4.9**2]), rtol=1e-14)


def test_equal_and_opposite_areas_that_are_matched_cancel():
    result = of_areas_alone([0.7, -0.7], ShapedSpectrum(1e-3))
    assert result.matched[0] > 1e-4
    assert not result.matched[2:].any()


def test_all_areas_matched_turn_every_area_alone_into_all_correlated():
    """Case 2 with all areas matched is case 1, here where the sum is small enough for every area to join."""
    row = [8.0, -7.0, 6.0, -5.0, 4.0, -3.0, 2.0, -1.5, -1.7, -1.75]
    result = of_areas_alone(row, ShapedSpectrum(1e-3))
    assert sorted(result.match.tolist()) == list(range(10))
    model = TemperatureModel.from_spectra([ShapedSpectrum(1e-3)] * 10)
    one = full_blocks([np.arange(10)], 10)
    assert result.matched[-1] == pytest.approx(worst_ratio(np.array(row), model, one, np.ones(len(F))), rel=1e-12)


def test_matching_joins_whole_blocks():
    """Blocks {3, -1} and {-2}, {0.5}: 4 + 4 + 0.25. The first two as one cancel; nothing is taken out of a block."""
    row = np.array([3.0, -1.0, -2.0, 0.5])
    model = TemperatureModel.from_spectra([WhiteSpectrum(1.0)] * 4)
    found = full_blocks([np.array([0, 1]), np.array([2]), np.array([3])], 4)
    result = improvement(
        OutputNoise(row[None], TemperatureNoise(model, found), F), 0, np.ones(len(F)), [np.ones(4, dtype=bool)]
    )
    assert result.match.tolist() == [0, 1, *[-1] * 8]
    np.testing.assert_allclose(result.matched, np.sqrt([8.25, 8.25, 0.25, 0.25, 0.25, 0.25]), rtol=1e-14)


@pytest.mark.parametrize(
    ("most", "shown"),
    [(12, [0, 1, 2, 3, 5, 10]), (10, [0, 1, 2, 3, 5, 10]), (8, [0, 1, 2, 3, 5, 8]), (3, [0, 1, 2, 3]), (0, [0, 1])],
)
def test_no_more_areas_are_told_of_than_there_are(most: int, shown: list[int]) -> None:
    capped = _capped(COUNTS, most)
    assert [n for _, n in capped] == shown
    assert [k for k, _ in capped] == list(range(len(shown)))
