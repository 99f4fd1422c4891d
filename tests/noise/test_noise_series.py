from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tedm_cli.config.temperature.node_weights import read_node_weights
from tedm_cli.errors import InputError
from tedm_cli.noise.columns import NodeWeights, columns_of_areas, part_words, parts_of_columns
from tedm_cli.noise.requirement_presets import PRESETS
from tedm_cli.noise.resample import LinearResampler, PolyphaseResampler
from tedm_cli.noise.series import Trend, judge_estimate
from tedm_cli.noise.spectral_estimate import Estimate, Welch, longest_segment
from tedm_cli.noise.stamps import Stamps
from tedm_cli.quantities import CELSIUS, TEMPERATURE, TIME_STAMP
from tedm_cli.tables.wide_table import open_wide


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
    parts = parts_of_columns(["all", "inside", "IS2", "OB_3"], areas, np.ones(78, dtype=bool), where="t.csv")
    found = rows @ parts @ temperature
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
    assert found.whole
    assert found.left_out == []


def part_of_band(chosen, spike_hz=0.0):
    """White noise of 1e-13 m/√Hz, and 1e-10 in a spike, as an estimate of some frequencies sees it."""
    f = 1e-5 * np.arange(10, 10001)
    psd = np.where(np.abs(f - spike_hz) < 2e-5, 1e-20, 1e-26)
    kept = chosen(f)
    estimate = Estimate(f[kept], psd[None, kept], np.full(kept.sum(), 50.0))
    return judge_estimate(estimate, 0, PRESETS["lpf_readout_item"], 2.0, kind="displacement", output="A_TM1_x")


def test_what_overlaps_of_band_and_estimate_is_judged():
    """The band is 1 to 30 mHz; the estimate begins at 5, or ends at 20, and is judged by what it has."""
    for chosen, judged, missing in (
        (lambda f: f > 4.999e-3, (5e-3, 30e-3), "0.001 to 0.005 Hz, below the estimate"),
        (lambda f: f <= 20.001e-3, (1e-3, 20e-3), "0.02 to 0.03 Hz, above the estimate"),
    ):
        found = part_of_band(chosen)
        assert found.judged_hz == pytest.approx(judged, rel=1e-3)
        assert not found.whole
        assert found.left_out == [f"lpf_readout_item over {missing}"]
        assert found.band_rms == pytest.approx(1e-13 * np.sqrt(judged[1] - judged[0]), rel=1e-3, abs=0)
        assert found.worst.passed
        assert found.worst.ratio == pytest.approx(0.2, rel=1e-2)


def test_a_tone_fails_where_it_is_judged_and_nowhere_else():
    def upwards(f):
        return f >= 5e-3

    failed = part_of_band(upwards, 10e-3)
    assert not failed.worst.passed
    assert failed.worst.ratio == pytest.approx(200.0, rel=1e-2)
    assert failed.worst.binding_hz == pytest.approx(10e-3, rel=3e-3)
    assert part_of_band(upwards, 2e-3).worst.passed, "in the band and below the estimate: it is said to be left out"
    assert part_of_band(upwards, 50e-3).worst.passed, "above the band"


def test_estimates_beside_the_band_or_of_nothing_judge_nothing():
    fact = part_of_band(lambda f: f > 30.999e-3)
    assert fact == "lpf_readout_item is over 0.001 to 0.03 Hz, the estimate over 0.031 to 0.1 Hz"
    assert part_of_band(lambda f: f > 1.0) == "lpf_readout_item, as there is no spectrum"
    assert part_of_band(lambda f: (f > 29.99e-3) & (f < 30.02e-3)).judged_hz == pytest.approx((30e-3, 30e-3), rel=1e-3)


@pytest.mark.parametrize("samples", [0, 100, 135, 136, 1000, 4003])
def test_the_longest_segment_of_a_short_series_is_averaged(samples):
    segment = longest_segment(samples)
    assert (segment > 0) == (samples >= 136)
    if segment:
        welch = Welch(1, 1.0, segment)
        welch.add(np.random.default_rng(1).normal(size=(1, samples)))
        assert welch.segments >= 5
        assert len(welch.estimate().frequency_hz) >= 2
        assert samples / 2 - 4 < segment <= samples / 2


NODES = {"OB_1": {"N1": 0.25, "N2": 0.75}, "OB_2": {"N2": 1.0}}


def test_areas_follow_the_mean_of_their_nodes(areas):
    """Beside them the narrowest column speaks, and nodes that no area needs may be there."""
    columns = ["N2", "all", "N9", "N1", "IS2"]
    needed = np.array([name != "OB_3" for name in areas.name])
    parts = parts_of_columns(columns, areas, needed, where="t.csv", nodes=NodeWeights(NODES, "n.csv"))
    temperature = parts @ [1.0, 2.0, 4.0, 8.0, 16.0]
    found = dict(zip(areas.name.tolist(), temperature, strict=True))
    assert (found["OB_1"], found["OB_2"], found["OB_3"], found["OB_4"]) == (2.75, 1.0, 0.0, 2.0)
    assert set(temperature[areas.group == "IS2"]) == {16.0}
    words = dict(zip(areas.name.tolist(), part_words(parts, columns), strict=True))
    assert (words["OB_1"], words["OB_2"], words["OB_3"], words["OB_4"]) == ("0.75 N2 + 0.25 N1", "N2", "", "all")


def test_nodes_and_areas_that_are_not_there_are_one_error(areas):
    nodes = NodeWeights({"OB_1": {"N1": 1.0}, "OB_99": {"N7": 0.5, "N8": 0.5}, "OB_2": {"N1": 1.0}}, "n.csv")
    needed = np.array([name != "OB_2" for name in areas.name])
    with pytest.raises(InputError) as caught:
        parts_of_columns(["N1", "all"], areas, needed, where="t.csv", nodes=nodes)
    assert caught.value.fact == ("no thermal area: OB_99; no column of t.csv: N7, N8; said to be constant: OB_2")
    assert caught.value.where == "n.csv"
    with pytest.raises(InputError, match="no column for 77 of 78 thermal areas"):
        parts_of_columns(["N1"], areas, np.ones(78, dtype=bool), where="t.csv",
                         nodes=NodeWeights({"OB_1": {"N1": 1.0}}, "n.csv"))  # fmt: skip


@pytest.mark.parametrize(
    ("text", "place", "fact"),
    [
        ("node,area,weight\nN1,A,0.5\nN2,A,0.499998\nN1,B,1\n", "n.csv", r"1 of 2 areas do not .* 1: A \(0.999998\)"),
        ("node,area,weight\nN1,A,0.5\nN1,A,0.5\n", "n.csv:3", "node 'N1' of area 'A' is there twice"),
        ("node,area,weight\nN1,A,1.5\nN2,A,-0.5\n", "n.csv:2", "weight 1.5 is outside 0 to 1"),
        ("node,area,weight\nN1,,1\n", "n.csv:2", "area is empty"),
        ("node,area,weight\nN1,A,half\n", "n.csv:2", "weight must be a finite number, found 'half'"),
        ("area,node,weight\nN1,A,1\n", "n.csv:1", "must begin with the header node,area,weight"),
        ("node;area;weight\nN1;A;0,5\nN2;A\n", "n.csv:3", "2 fields, wanted 3"),
        ("node,area,weight\n", "n.csv", "holds a header and nothing else"),
    ],
)  # fmt: skip
def test_tables_of_weights_that_are_refused(tmp_path, text, place, fact):
    (tmp_path / "n.csv").write_text(text)
    with pytest.raises(InputError, match=fact) as caught:
        read_node_weights(tmp_path / "n.csv")
    assert caught.value.where == str(tmp_path / place)


def test_weights_with_commas_or_semicolons_are_the_same(tmp_path):
    (tmp_path / "n.csv").write_text("node,area,weight\nN1,A,0.25\nN2,A,0.7500001\n\nN1,B,1\n")
    (tmp_path / "m.csv").write_text("\ufeffnode;area;weight\nN1;A;0,25\nN2;A;0.7500001\n\nN1;B;1\n", encoding="utf-8")
    first, second = (read_node_weights(tmp_path / name).weights for name in ("n.csv", "m.csv"))
    assert first == second == {"A": {"N1": 0.25, "N2": 0.7500001}, "B": {"N1": 1.0}}


@pytest.mark.parametrize(
    ("text", "values"),
    [
        ("time_s,all\n0,293.5\n1,2.9e2\n", [293.5, 290.0]),
        ("time_s;all\n0;293.5\n1;2.9e2\n", [293.5, 290.0]),
        ("time_s;all\r\n0,0;293,5\r\n1,0;2,9e2\r\n", [293.5, 290.0]),
        ("all; time_s\n293,5;0\n290;1\n", [293.5, 290.0]),
        ('"time_s";"a,b"\n0;293,5\n1;290\n', [293.5, 290.0]),
    ],
)
def test_semicolons_and_decimal_commas(tmp_path, text, values):
    (tmp_path / "t.csv").write_bytes(text.encode())
    with open_wide(tmp_path / "t.csv", "time_s", TIME_STAMP, TEMPERATURE) as wide:
        blocks = list(wide.blocks())
    assert np.concatenate([b.values for b in blocks])[:, 0].tolist() == values
    assert np.concatenate([b.key for b in blocks]).tolist() == [0.0, 1.0]


@pytest.mark.parametrize(
    ("text", "place", "fact"),
    [
        ("time_s;all\n0;1.234,5\n", "t.csv:2", "all must be a number, found '1.234,5'"),
        ("time_s;all\n0;1,2\n1,3\n", "t.csv:3", "1 fields, wanted 2"),
        ("time_s;all\n0;-274,15\n", "t.csv:2", "all: temperature -274.15 is outside -273.15 to 10000 degC"),
        ("time;all\n0;1\n", "t.csv:1", "there is no column time_s; there are: time, all"),
        ("time_s,all\n0,1,5\n", "t.csv:2", "3 fields, wanted 2"),
    ],
)
def test_semicolons_that_are_refused(tmp_path, text, place, fact):
    (tmp_path / "t.csv").write_text(text)
    with (
        pytest.raises(InputError, match=fact) as caught,
        open_wide(tmp_path / "t.csv", "time_s", TIME_STAMP, CELSIUS) as wide,
    ):
        list(wide.blocks())
    assert caught.value.where == str(tmp_path / place)


@pytest.mark.parametrize(
    ("text", "fact", "hint"),
    [
        ("time_s,all\n0,0,293,5\n", "4 fields, wanted 2", "divide the columns by semicolons"),
        ("time_s,all\n0,293,5\n", "3 fields, wanted 2", "divide the columns by semicolons"),
        ("time_s,all\n0,293.5,\n", "3 fields, wanted 2", ""),
        ("time_s,all\n0\n", "1 fields, wanted 2", ""),
        ("time_s;all\n0;1;2\n", "3 fields, wanted 2", ""),
        ("time_s\tall\n0\t293.5\n", "the columns are divided by tabs", "by commas, or by semicolons"),
        ("node,area,weight\nN1,A,0,5\n", "4 fields, wanted 3", "divide the columns by semicolons"),
        ("node,area,weight\nN1,A,1,\n", "4 fields, wanted 3", ""),
        ("node;area;weight\nN1;A;0;5\n", "4 fields, wanted 3", ""),
        ("node\tarea\tweight\nN1\tA\t1\n", "the columns are divided by tabs", "by commas, or by semicolons"),
    ],
)
def test_tables_divided_by_other_signs_get_a_hint(tmp_path, text, fact, hint):
    """Series are read in blocks, and tables of nodes as a whole, by another reader."""
    path = tmp_path / "t.csv"
    path.write_text(text)
    with pytest.raises(InputError, match=fact) as caught:
        if text.startswith("node"):
            read_node_weights(path)
        else:
            with open_wide(path, "time_s", TIME_STAMP, CELSIUS) as wide:
                list(wide.blocks())
    assert hint in caught.value.hint
    assert bool(caught.value.hint) == bool(hint)
