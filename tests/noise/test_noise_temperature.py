import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tedm_cli.errors import InputError
from tedm_cli.noise.areas import AreaTable
from tedm_cli.noise.requirement_presets import PRESETS
from tedm_cli.noise.temperature import (
    ShapedSpectrum,
    Spectrum,
    TemperatureModel,
    WhiteSpectrum,
    thesis_model,
    white_model,
)


@given(order=st.floats(0.5, 8), corner=st.floats(1e-5, 1.0), reference=st.floats(1e-5, 1.0), level=st.floats(1e-8, 1.0))
def test_level_holds_at_the_reference_frequency(order, corner, reference, level):
    spectrum = ShapedSpectrum(level, reference, corner, order)
    assert spectrum.amplitude(np.array([reference]))[0] == pytest.approx(level, rel=1e-12, abs=0)


@pytest.mark.parametrize("order", [1, 2, 3.5])
def test_slope_far_above_the_corner_and_half_power_at_it(order):
    spectrum = ShapedSpectrum(1.0, 1e-3, 1e-3, order)
    flat, corner, f1, f2 = spectrum.amplitude(np.array([1e-9, 1e-3, 1.0, 10.0]))
    assert corner / flat == pytest.approx(np.sqrt(0.5), rel=1e-9, abs=0)
    assert np.log10(f2 / f1) == pytest.approx(-order, abs=1e-5)


def test_thesis_levels_and_shared_shape(areas):
    model = thesis_model(areas)
    at_1_mhz = model.amplitudes(np.array([1e-3]))[:, 0]
    np.testing.assert_allclose(at_1_mhz, np.where(areas.shield == "outside", 1e-3, 1e-4), rtol=1e-12)
    assert len(model.shapes) == 1
    index, asd = model.distinct(np.array([1e-3, 1e-2]))
    assert asd.shape == (2, 2)
    np.testing.assert_allclose(asd[index], model.amplitudes(np.array([1e-3, 1e-2])), rtol=1e-14)


def test_amplitudes_of_mixed_shapes_are_those_of_each_spectrum():
    spectra: list[Spectrum] = [
        ShapedSpectrum(2.0),
        WhiteSpectrum(3.0),
        ShapedSpectrum(5.0),
        ShapedSpectrum(2.0, corner_hz=2e-3),
    ]
    model = TemperatureModel.from_spectra(spectra)
    f = np.geomspace(1e-4, 0.1, 17)
    assert len(model.shapes) == 3
    np.testing.assert_allclose(model.amplitudes(f), [s.amplitude(f) for s in spectra], rtol=1e-14)


@pytest.mark.parametrize(
    ("order", "corner_hz", "growth"), [(1, 1e-3, 4.02), (1, 1e-5, 3.0), (2, 1e-3, 1.406), (2, 1e-5, 1.0)]
)
def test_assumed_filter_decides_the_worst_readout_ratio(areas, order, corner_hz, growth):
    """Worst noise over limit against its value at 1 mHz, by hand: 9 sqrt[(1 + x^2n)/(1 + (3x)^2n)], x = f0/fc."""
    f = np.geomspace(1e-3, 30e-3, 2001)
    ratio = thesis_model(areas, order=order, corner_hz=corner_hz).shape_values(f)[0]
    ratio = ratio / PRESETS["lpf_readout_item"].amplitude(f)
    assert ratio.max() / ratio[0] == pytest.approx(growth, rel=2e-3, abs=0)


def test_white_noise_is_worst_ninefold_above_1_mhz(areas):
    f = np.geomspace(1e-3, 30e-3, 2001)
    ratio = white_model(areas).amplitudes(f)[0] / PRESETS["lpf_readout_item"].amplitude(f)
    assert ratio.max() / ratio[0] == pytest.approx(9.0, rel=1e-12, abs=0)


def test_with_filter_moves_low_pass_shapes_alone():
    model = TemperatureModel.from_spectra([ShapedSpectrum(2.0), WhiteSpectrum(3.0)]).with_filter(4.0, 5e-3)
    f = np.array([1e-3, 2e-2])
    expected = [ShapedSpectrum(2.0, 1e-3, 5e-3, 4.0).amplitude(f), np.full(2, 3.0)]
    np.testing.assert_allclose(model.amplitudes(f), expected, rtol=1e-14)


@pytest.mark.parametrize(
    "make",
    [
        lambda: ShapedSpectrum(-1.0),
        lambda: ShapedSpectrum(1.0, corner_hz=0.0),
        lambda: ShapedSpectrum(1.0, order=np.nan),
        lambda: WhiteSpectrum(np.inf),
    ],
)
def test_impossible_spectra_are_refused(make):
    with pytest.raises(InputError):
        make()


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"name": np.array(["A", "A"])}, "used 2 times"),
        ({"shield": np.array(["inside", "between"])}, "'between'; known: inside, outside"),
        ({"side": np.array(["+y", "y"])}, "thermal area B"),
        ({"group": np.array(["IS1"])}, "lengths"),
    ],
)
def test_area_table_refuses_what_it_cannot_mean(change, message):
    columns = {"name": ["A", "B"], "group": ["IS1", "IS2"], "shield": ["inside", "outside"], "side": ["+y", "mid"]}
    with pytest.raises(InputError, match=message.replace("+", r"\+")):
        AreaTable(**({key: np.array(value) for key, value in columns.items()} | change))
