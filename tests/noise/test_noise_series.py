from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tedm_cli.errors import InputError
from tedm_cli.noise.columns import columns_of_areas
from tedm_cli.noise.requirement_presets import PRESETS
from tedm_cli.noise.resample import LinearResampler, PolyphaseResampler
from tedm_cli.noise.series import Trend, judge_estimate, rows_by_column
from tedm_cli.noise.spectral_estimate import Estimate
from tedm_cli.noise.stamps import Stamps


def pieces(n, cuts):
    edges = sorted({0, n, *(c % (n + 1) for c in cuts)})
    return [slice(a, b) for a, b in pairwise(edges)]


def pushed(resampler, time, values, parts):
    return np.concatenate([resampler.push(time[p], values[p]) for p in parts])


CUTS = st.lists(st.integers(0, 10**6), max_size=8)


@settings(max_examples=40, deadline=None)
@given(cuts=CUTS, step=st.floats(0.05, 0.9), seed=st.integers(0, 10**6))
def test_straight_lines_between_irregular_stamps_in_blocks_of_any_length(cuts, step, seed):
    rng = np.random.default_rng(seed)
    time = 7.0 + np.cumsum(rng.uniform(0.5, 1.5, 60))
    values = rng.normal(size=(60, 2))
    found = pushed(LinearResampler(step), time, values, pieces(60, cuts))
    wanted = np.minimum(time[0] + step * np.arange(len(found)), time[-1])
    assert 0 <= time[-1] - wanted[-1] < step * (1 + 1e-9)
    for c in range(2):
        np.testing.assert_allclose(found[:, c], np.interp(wanted, time, values[:, c]), rtol=1e-9, atol=1e-12)


@settings(max_examples=40, deadline=None)
@given(cuts=CUTS, to=st.sampled_from([0.25, 0.4, 1.0, 1.5, 2.0, 7.0]))
def test_polyphase_keeps_what_is_slow_in_blocks_of_any_length(cuts, to):
    """A sine in the pass band comes out as the same sine at the new stamps, a constant as itself."""
    slow = max(1.0, to)
    n = int(150 * slow)
    time, f = np.arange(n) * 1.0, 0.5 * 0.6 / slow
    values = np.stack([np.sin(2 * np.pi * f * time + 0.3), np.full(n, 5.0)], axis=1)
    resampler = PolyphaseResampler(1.0, to)
    found = pushed(resampler, time, values, pieces(n, cuts))
    wanted = (resampler.first + np.arange(len(found))) * to
    assert wanted[0] >= 24 * slow - 1e-9 > wanted[0] - to
    assert wanted[-1] <= time[-1] - 24 * slow + 1e-9 < wanted[-1] + to
    np.testing.assert_allclose(found[:, 0], np.sin(2 * np.pi * f * wanted + 0.3), atol=1e-5)
    np.testing.assert_allclose(found[:, 1], 5.0, rtol=1e-5)


def test_polyphase_keeps_aliases_out():
    time = np.arange(4000.0)
    for f in (0.13, 0.2, 0.37):  # above the new Nyquist frequency, 0.125 Hz
        found = PolyphaseResampler(1.0, 4.0).push(time, np.sin(2 * np.pi * f * time)[:, None])
        assert np.abs(found).max() < 3e-6
        aliased = LinearResampler(4.0).push(time, np.sin(2 * np.pi * f * time)[:, None])
        assert np.abs(aliased).max() > 0.5


def test_polyphase_refuses_what_is_no_ratio():
    with pytest.raises(InputError, match="ratio of two whole numbers"):
        PolyphaseResampler(1.0, np.pi)  # 355/113 to 1e-7


def stamps(time, regular=True, size=3, **more):
    watch = Stamps(lambda n: f"t.csv:{n}", regular=regular, **more)
    for start in range(0, len(time), size):
        part = np.asarray(time[start : start + size], dtype=float)
        watch.add(part, np.arange(start + 2, start + 2 + len(part)))
    return watch


def test_stamps_printed_with_few_digits_are_regular():
    watch = stamps(np.round(5.0 + np.arange(1000) / 3.0, 4), size=100)
    assert watch.mean_step_s == pytest.approx(1 / 3, rel=1e-6)


@pytest.mark.parametrize("size", [1, 2, 3, 100])
@pytest.mark.parametrize(
    ("time", "line", "fact"),
    [
        ([0, 1, 2, 3, 3, 4], 6, "time_s is 3 after 3"),
        ([0, 1, 2, 3, 2.5, 4], 6, "time_s is 2.5 after 3"),
        ([0, 1, 2, 3, 4, 9, 10], 7, "a gap of 5 s, some 4 samples of 1 s"),
        ([0, 1, 2, 3, 4.25, 5], 6, r"a step of 1.25 s among steps of 1 s \(\+0.25\)"),
    ],
)
def test_irregular_stamps_are_refused_where_they_begin(time, line, fact, size):
    with pytest.raises(InputError, match=fact) as caught:
        stamps(time, size=size)
    assert caught.value.where == f"t.csv:{line}"
    assert caught.value.hint


def test_gaps_that_are_too_long_to_interpolate():
    time = [0, 1.1, 1.9, 3.0, 5.5, 6.4]
    assert stamps(time, regular=False).count == 6
    with pytest.raises(InputError, match=r"a gap of 2.5 s .* \(at most 2 s\)") as caught:
        stamps(time, regular=False, max_gap_s=2.0)
    assert caught.value.where == "t.csv:6"


@settings(max_examples=30, deadline=None)
@given(cuts=CUTS, seed=st.integers(0, 10**6))
def test_trends_are_those_of_least_squares(cuts, seed):
    values = np.random.default_rng(seed).normal([0.0, 10.0, -4.0], size=(200, 3))
    trend = Trend(3)
    for part in pieces(200, cuts):
        trend.add(values[part])
    number = np.arange(200.0)
    start, slope = trend.line("linear")
    np.testing.assert_allclose(np.stack([slope, start]), np.polyfit(number, values, 1), rtol=1e-6, atol=1e-9)
    np.testing.assert_allclose(trend.line("mean")[0], values.mean(axis=0), rtol=1e-12)
    assert not np.any(trend.line("nothing"))


def test_the_narrowest_column_speaks_for_an_area(areas):
    index = columns_of_areas(["all", "inside", "IS2", "OB_3"], areas, np.ones(78, dtype=bool), where="t.csv")
    assert index[areas.name.tolist().index("OB_3")] == 3
    assert index[areas.name.tolist().index("OB_4")] == 1
    assert set(index[areas.group == "IS2"].tolist()) == {2}
    assert set(index[areas.shield == "outside"].tolist()) == {0}
    temperature, rows = np.array([1.0, 2.0, 4.0, 8.0]), np.random.default_rng(1).normal(size=(2, 78))
    found = rows_by_column(rows, index, ["all", "inside", "IS2", "OB_3"]) @ temperature
    np.testing.assert_allclose(found, rows @ temperature[index], rtol=1e-12)


@pytest.mark.parametrize(
    ("columns", "fact", "hint"),
    [
        (["inside"], "no column for 12 of 78 thermal areas: STRUTS_1, .* and 6 more", "for inside or outside"),
        (["all", "OB_33"], "column 'OB_33' names no thermal area", "did you mean OB_3"),
    ],
)
def test_columns_that_do_not_fit_the_areas(areas, columns, fact, hint):
    with pytest.raises(InputError, match=fact) as caught:
        columns_of_areas(columns, areas, np.ones(78, dtype=bool), where="t.csv")
    assert hint in caught.value.hint
    assert caught.value.where == "t.csv"


def test_band_rms_and_worst_ratio_of_an_estimate():
    """White noise of 1e-12 m/√Hz over 29 mHz against the read-out's limit, whose integral is known."""
    f = np.linspace(0.9e-3, 40e-3, 4001)
    estimate = Estimate(f, np.full((1, 4001), 1e-24), np.full(4001, 50.0))
    requirement = PRESETS["lpf_readout_item"]
    found = judge_estimate(estimate, 0, requirement, 2.0, kind="displacement", output="A_TM1_x")
    assert not isinstance(found, str)
    assert found.band_rms == pytest.approx(1e-12 * np.sqrt(29e-3), rel=1e-9, abs=0)
    limit = 27e-3 + 3e-3**4 / 3 * (1e-3**-3 - 3e-3**-3)  # ∫ (3 mHz/f)^4 below 3 mHz and 1 above
    assert found.band_limit == pytest.approx(1e-12 * np.sqrt(limit), rel=1e-4, abs=0)
    assert found.worst.ratio == pytest.approx(2.0, rel=1e-2)
    assert found.worst.binding_hz == pytest.approx(3e-3, rel=1e-2)
    short = Estimate(f[f < 0.02], estimate.psd[:, f < 0.02], estimate.degrees_of_freedom[f < 0.02])
    fact = judge_estimate(short, 0, requirement, 2.0, kind="displacement", output="A_TM1_x")
    assert isinstance(fact, str)
    assert "0.001 to 0.03 Hz, the estimate over 0.0009 to 0.01999 Hz" in fact
