"""Temperature spectra: presets from flight, tables, overrides."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tedm_cli.config.base import validate
from tedm_cli.config.temperature.noise import TemperatureTable
from tedm_cli.config.temperature.spectrum import SpectrumColumns
from tedm_cli.errors import ConfigError, InputError
from tedm_cli.noise.temperature import FlightSpectrum, ShapedSpectrum, TabulatedSpectrum, TemperatureModel

AT = np.array([1e-3, 5e-3, 30e-3])


def configured(**table):
    return validate(TemperatureTable, table, where="cases.toml")


def test_flight_goes_through_what_was_measured():
    """1 K/√Hz at 10 µHz; 10 µK/√Hz from 1 to 30 mHz; a slope of -3 between, and never rising with frequency."""
    at_10_uhz, *floor = FlightSpectrum().amplitude(np.array([1e-5, 1e-3, 10e-3, 30e-3]))
    assert at_10_uhz == pytest.approx(1.0, rel=1e-6)
    np.testing.assert_allclose(floor, 1e-5, rtol=0.006)
    f = np.geomspace(1e-5, 0.1, 500)
    assert np.all(np.diff(FlightSpectrum().amplitude(f)) <= 0.0)
    low, high = FlightSpectrum().amplitude(np.array([1e-5, 2e-5]))
    assert np.log2(low / high) == pytest.approx(3.0, abs=1e-6)


@given(slope=st.floats(-5, 2), level=st.floats(1e-8, 1.0), f=st.floats(1e-4, 0.1))
def test_a_table_of_a_power_law_is_the_power_law(slope, level, f):
    points = np.geomspace(1e-4, 0.1, 5)
    table = TabulatedSpectrum.of(points, level * (points / 1e-3) ** slope, "t")
    assert table.amplitude(np.array([f]))[0] == pytest.approx(level * (f / 1e-3) ** slope, rel=1e-9, abs=0)


def test_columns_that_differ_in_level_only_are_one_shape():
    points = np.array([1e-4, 1e-3, 0.1])
    one, two = (TabulatedSpectrum.of(points, level * np.array([4.0, 1.0, 0.5]), "t") for level in (1.0, 2.0))
    model = TemperatureModel.from_spectra([one, two, ShapedSpectrum(1.0)])
    assert len(model.shapes) == 2
    assert model.scale.tolist() == [1.0, 2.0, 1.0]
    assert (
        model.words()
        == "2 and 1 K/sqrt(Hz), table t, 0.0001 to 0.1 Hz, level at 1 mHz; 1 K/sqrt(Hz), " + ShapedSpectrum(1.0).words()
    )


@pytest.mark.parametrize(
    ("points", "at"), [([1e-4, 7e-4, 0.1], "0.7"), ([3e-3, 1e-2, 0.1], "3"), ([1e-5, 2e-4], "0.2"), ([1e-4, 1e-3], "1")]
)
def test_the_level_of_a_table_is_named_with_its_frequency(points, at):
    """That of the point nearest to 1 mHz: what is printed is the amplitude there."""
    table = TabulatedSpectrum.of(np.array(points), np.linspace(1.0, 2.0, len(points)), "t")
    words = TemperatureModel.from_spectra([table]).words()
    assert words == f"{table.level_K:g} K/sqrt(Hz), table t, {points[0]:g} to {points[-1]:g} Hz, level at {at} mHz"
    assert table.amplitude(np.array([1e-3 * float(at)]))[0] == pytest.approx(table.level_K, rel=1e-12)


def test_outside_a_table_nothing_is_assumed():
    table = TabulatedSpectrum.of(np.array([1e-3, 1e-2]), np.array([1.0, 1.0]), "IS1 of t.csv")
    with pytest.raises(InputError, match=r"0.001 to 0.01 Hz, but 0.0101 Hz is asked for") as caught:
        table.amplitude(np.array([5e-3, 1.01e-2]))
    assert caught.value.where == "spectrum IS1 of t.csv"
    assert "narrow [frequency]" in caught.value.hint


@pytest.mark.parametrize(
    ("f", "a", "fact"),
    [
        ([1e-3], [1.0], "1 frequencies are not a table"),
        ([1e-3, 1e-2, 1e-2], [1.0] * 3, "frequency 3 is 0.01 Hz, not above 0.01 Hz before it"),
        ([0.0, 1e-2], [1.0] * 2, "frequency 1 is 0 Hz, not above 0"),
        ([1e-3, 1e-2], [1.0, 0.0], r"0 K/sqrt\(Hz\) at 0.01 Hz"),
        ([1e-3, 1e-2], [-1.0, 1.0], r"-1 K/sqrt\(Hz\) at 0.001 Hz"),
    ],
)
def test_impossible_tables_are_refused(f, a, fact):
    with pytest.raises(InputError, match=fact):
        TabulatedSpectrum.of(np.array(f), np.array(a), "t")


def test_overrides_of_groups_shields_and_areas_the_last_one_counting(areas):
    model = configured(
        preset="lpf_flight",
        override=[
            {"shield": ["outside"], "preset": "thesis", "level_K": 2e-3, "order": 1.0},
            {"groups": ["struts"], "preset": "white", "level_K": 5e-4},
            {"areas": ["STRUTS_1", "OB_*"], "preset": "white", "level_K": 7e-4},
        ],
    ).model(areas)
    found = dict(zip(areas.name.tolist(), model.amplitudes(AT), strict=True))
    np.testing.assert_allclose(found["IS1_4"], FlightSpectrum().amplitude(AT), rtol=1e-12)
    np.testing.assert_allclose(found["FLANGES_2"], ShapedSpectrum(2e-3, order=1.0).amplitude(AT), rtol=1e-12)
    np.testing.assert_allclose(found["STRUTS_2"], 5e-4)
    np.testing.assert_allclose(found["STRUTS_1"], 7e-4)
    np.testing.assert_allclose(found["OB_14"], 7e-4)
    for words in ("order 1, corner 1 mHz", "white", "upper limit in flight"):
        assert words in model.words()


def columns(names, asd):
    return SpectrumColumns("t.csv", names, np.array([1e-4, 1e-3, 0.1]), np.array(asd, dtype=float))


def test_a_table_for_areas_and_groups_and_a_preset_for_the_rest(areas):
    table = columns(["IS1", "inside"], [[1.0, 2.0], [1.0, 2.0], [1.0, 2.0]])
    config = configured(
        preset="table", table="t.csv", override=[{"shield": ["outside"], "preset": "white", "level_K": 3.0}]
    )
    assert config.table_names() == ["t.csv"]
    level = config.model(areas, {"t.csv": table}).amplitudes(AT)[:, 0]
    wanted = np.where(areas.shield == "outside", 3.0, np.where(areas.group == "IS1", 1.0, 2.0))
    np.testing.assert_allclose(level, wanted)


def test_areas_without_a_spectrum_are_named(areas):
    with pytest.raises(InputError, match="no column for 12 of 78 thermal areas: STRUTS_1, STRUTS_2"):
        configured(preset="table", table="t.csv").model(areas, {"t.csv": columns(["inside"], [[1], [1], [1]])})


@pytest.mark.parametrize(
    ("table", "fact"),
    [
        ({"preset": "lpf_flight", "outside_K": 1.0}, "lpf_flight has its own levels, but outside_K given"),
        ({"preset": "lpf_flight", "order": 2.0}, "no low-pass filter, but order given"),
        ({"preset": "table"}, "preset table needs table"),
        ({"table": "t.csv"}, 'preset is thesis; set preset = "table"'),
        ({"override": [{"preset": "white", "level_K": 1.0}]}, "selects nothing"),
        ({"override": [{"groups": ["struts"]}]}, "preset thesis needs level_K"),
        ({"override": [{"groups": ["struts"], "preset": "lpf_flight", "level_K": 1.0}]}, "own levels, but level_K"),
        ({"overrides": []}, "unknown key; did you mean override"),
    ],
)
def test_contradictions_are_refused(table, fact):
    with pytest.raises(ConfigError) as caught:
        configured(**table)
    assert fact in str(caught.value)


def test_overrides_of_what_is_not_there(areas):
    config = configured(
        override=[
            {"groups": ["strut"], "level_K": 1.0},
            {"areas": ["X_*"], "level_K": 1.0},
            {"groups": ["IS1"], "shield": ["outside"], "level_K": 1.0},
        ]
    )
    with pytest.raises(ConfigError) as caught:
        config.model(areas, where="cases.toml")
    assert caught.value.where == "cases.toml"
    assert [path for path, _ in caught.value.problems] == [
        "temperature.override[0].groups",
        "temperature.override[1].areas",
    ]
