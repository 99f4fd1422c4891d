"""Shaping filters and state spaces: their spectra, their stationarity, their sampled form, what cannot be one."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.integrate
import scipy.signal
from hypothesis import given, settings
from hypothesis import strategies as st

from tedm_cli.config.cases import CasesConfig
from tedm_cli.errors import InputError, PhysicsError
from tedm_cli.noise.areas import AreaTable
from tedm_cli.noise.correlation import Correlation, correlation
from tedm_cli.noise.propagation import TemperatureNoise
from tedm_cli.noise.shaping.rational_fit import Form, Roots
from tedm_cli.noise.shaping.sampled_filter import sampled, transition
from tedm_cli.noise.shaping.shaping_filter import ShapingFilter, shaping_filter
from tedm_cli.noise.shaping.state_space import NoiseModel, noise_model
from tedm_cli.noise.temperature import (
    FlightSpectrum,
    ShapedSpectrum,
    Spectrum,
    TabulatedSpectrum,
    TemperatureModel,
    WhiteSpectrum,
    thesis_model,
)

BAND = (1e-4, 0.1)
F = np.geomspace(*BAND, 151)
TABLE = TabulatedSpectrum.of(np.array([1e-4, 1e-3, 0.1]), np.array([2e-3, 1e-3, 1e-7]), "of a test")
LOW_PASS = ShapedSpectrum(1e-3)
SHAPES: dict[str, tuple[Spectrum, ...]] = {
    "order 1": (ShapedSpectrum(1e-3, order=1.0),),
    "order 2": (LOW_PASS,),
    "order 7": (ShapedSpectrum(1e-3, order=7.0, corner_hz=5e-3),),
    "order 0.5": (ShapedSpectrum(1e-3, order=0.5),),
    "order 1.5": (ShapedSpectrum(1e-3, order=1.5),),
    "white": (WhiteSpectrum(1e-3),),
    "flight": (FlightSpectrum(),),
    "table": (TABLE,),
    "two": (LOW_PASS, WhiteSpectrum(1e-4)),
    "two falling": (LOW_PASS, ShapedSpectrum(1e-4, order=1.0)),
}
STATES = {"order 1": 1, "order 2": 2, "order 7": 7, "white": 0, "flight": 3}


@pytest.fixture(scope="module")
def filters() -> dict[str, ShapingFilter]:
    return {name: shaping_filter(spectra, BAND, 0.01) for name, spectra in SHAPES.items()}


@pytest.mark.filterwarnings("ignore::scipy.signal.BadCoefficients")
@pytest.mark.parametrize("name", SHAPES)
def test_response_is_the_spectrum_and_the_filter_is_stable(filters: dict[str, ShapingFilter], name: str) -> None:
    """Against scipy's own frequency response, at frequencies between those of the fit."""
    found = filters[name]
    n = len(found.b)
    for q, spectrum in enumerate(SHAPES[name]):
        if name == "order 7":  # scipy goes by way of zeros, those at infinity included, and loses them
            h = found.response(F)[q]
        elif n:
            system = scipy.signal.StateSpace(found.a, found.b[:, None], found.c[q : q + 1], found.d[q : q + 1, None])
            h = scipy.signal.freqresp(system, 2 * np.pi * F)[1]
        else:
            h = np.full(len(F), found.d[q])
        off = np.abs(np.abs(h) / spectrum.amplitude(F) - 1.0).max()
        assert off <= (1e-12 if found.deviation[q] == 0.0 else 0.0105)
    assert np.all(np.linalg.eigvals(found.a).real < 0.0)
    assert n == STATES.get(name, n)
    assert n <= (24 if len(SHAPES[name]) == 1 else 64)


@pytest.mark.filterwarnings("ignore::scipy.signal.BadCoefficients")
@pytest.mark.parametrize("name", ["order 0.5", "order 1.5", "flight", "table"])
def test_single_filters_have_minimum_phase(filters: dict[str, ShapingFilter], name: str) -> None:
    found = filters[name]
    z, _, _ = scipy.signal.ss2zpk(found.a, found.b[:, None], found.c, found.d[:, None])
    band = z[np.abs(z) < 2e2]  # what ss2zpk makes of zeros at infinity
    assert np.all(band.real < 0.0)


def test_parameters_of_a_rational_function() -> None:
    """The vector says which root is which: size by the complex response, derivative by differences, and back again."""
    zeros, poles = Roots(((2.0, 0.3),), (5.0,)), Roots(((1.0, 0.7), (0.2, 3.0)), (9.0,))
    theta, form, omega = Form.parameters(4.0, zeros, poles), Form.of(zeros, poles), np.geomspace(0.05, 50.0, 31)
    assert (len(theta), form) == (9, Form((1, 1), (2, 1)))
    s = 1j * omega

    def response(roots: Roots) -> np.ndarray:
        pairs = [1 + 2 * z * s / w + (s / w) ** 2 for w, z in roots.pairs]
        return np.prod([*pairs, *(1 + s / w for w in roots.single)], axis=0)

    size, slope = form.log_size(theta, omega)
    np.testing.assert_allclose(np.exp(size), np.abs(4.0 * response(zeros) / response(poles)), rtol=1e-13)
    for i, step in enumerate(1e-6 * np.eye(len(theta))):
        difference = (form.log_size(theta + step, omega)[0] - form.log_size(theta - step, omega)[0]) / 2e-6
        np.testing.assert_allclose(slope[:, i], difference, rtol=0, atol=1e-8)
    back = form.rational(theta, 0.0)
    np.testing.assert_allclose(Form.parameters(back.gain, back.zeros, back.poles), theta, rtol=0, atol=1e-15)


@pytest.mark.parametrize("name", SHAPES)
def test_entries_are_of_the_size_of_the_corners(filters: dict[str, ShapingFilter], name: str) -> None:
    a = filters[name].a
    if a.size:
        assert np.abs(a[a != 0.0]).min() > 1e-9


@pytest.mark.parametrize("name", ["two", "two falling"])
def test_filters_of_one_noise_are_in_phase(filters: dict[str, ShapingFilter], name: str) -> None:
    """Their cross-spectrum is the product of the amplitudes, as in the temperature model; minimum phase does not do."""
    h = filters[name].response(F)
    product = np.prod([s.amplitude(F) for s in SHAPES[name]], axis=0)
    np.testing.assert_allclose((h[0] * h[1].conj()) / product, 1.0, rtol=0, atol=0.02)
    alone = [shaping_filter((s,), BAND, 0.01).response(F)[0] for s in SHAPES[name]]
    assert np.abs(alone[0] * alone[1].conj() / product - 1.0).max() > 0.5


@pytest.mark.parametrize("name", ["order 1", "order 2", "order 7", "order 1.5", "table"])
def test_variance_is_the_integral_of_the_spectrum(filters: dict[str, ShapingFilter], name: str) -> None:
    found = filters[name]
    f = np.geomspace(1e-7, 1e3, 40_001)
    psd = np.abs(found.response(f)[0]) ** 2
    integral = scipy.integrate.trapezoid(psd, f)
    variance = (found.c @ found.covariance() @ found.c.T)[0, 0]
    assert variance == pytest.approx(integral, rel=2e-3, abs=0)


@pytest.mark.parametrize("rate_hz", [0.03, 0.5, 20.0])
@pytest.mark.parametrize("name", SHAPES)
def test_sampled_form_keeps_the_covariance(filters: dict[str, ShapingFilter], name: str, rate_hz: float) -> None:
    """P = Φ P Φᵀ + L Lᵀ with P from Lyapunov's equation of the continuous filter, in units of its diagonal."""
    found = filters[name]
    step, covariance = sampled(found, 1.0 / rate_hz), found.covariance()
    scale = np.sqrt(np.diag(covariance))
    off = step.a @ covariance @ step.a.T + step.b @ step.b.T - covariance
    assert np.abs(off / np.outer(scale, scale)).max(initial=0.0) < 1e-7


@pytest.mark.parametrize("name", ["order 2", "order 7", "order 1.5", "flight", "two"])
def test_sampled_spectrum(filters: dict[str, ShapingFilter], name: str) -> None:
    """At 2 Hz the spectra up to 0.1 Hz are those of the continuous filter, sinc² = 0.992 at the end."""
    found = filters[name]
    step = sampled(found, 0.5)
    z = np.exp(2j * np.pi * F * 0.5)
    resolvent = z[:, None, None] * np.eye(len(found.b)) - step.a
    h = step.c @ np.linalg.solve(resolvent, np.broadcast_to(step.b, (len(F), *step.b.shape))) + step.d
    psd = np.sum(np.abs(h) ** 2, axis=2).T  # of numbers whose one-sided PSD is 2 / rate = 1
    np.testing.assert_allclose(psd, np.abs(found.response(F)) ** 2, rtol=0.01, atol=0)


def test_white_noise_sampled_is_white_of_the_same_level() -> None:
    step = sampled(shaping_filter((WhiteSpectrum(3.0),), BAND, 0.01), 0.25)
    assert step.a.shape == (0, 0)
    assert np.sum(step.d**2) == pytest.approx(9.0 * 4.0 / 2.0, rel=1e-14, abs=0)


def test_transition_of_an_integrator_chain() -> None:
    """Integrated white noise, known in closed form: ½ [[h³/3, h²/2], [h²/2, h]]."""
    for h in (1e-3, 1.0, 1e3):
        step, factor = transition(np.array([[0.0, 1.0], [0.0, 0.0]]), np.array([0.0, 1.0]), h)
        np.testing.assert_allclose(step, [[1.0, h], [0.0, 1.0]], rtol=1e-12)
        np.testing.assert_allclose(factor @ factor.T, 0.5 * np.array([[h**3 / 3, h**2 / 2], [h**2 / 2, h]]), rtol=1e-9)


@settings(max_examples=5)
@given(order=st.floats(0.3, 4.0), corner=st.floats(3e-4, 3e-2))
def test_any_order_and_corner_is_realised(order: float, corner: float) -> None:
    spectrum = ShapedSpectrum(1.0, corner_hz=corner, order=order)
    found = shaping_filter((spectrum,), BAND, 0.02)
    assert np.abs(np.abs(found.response(F)[0]) / spectrum.amplitude(F) - 1.0).max() <= 0.021
    assert np.all(np.linalg.eigvals(found.a).real < 0.0)
    assert len(found.b) <= 12


def test_a_tighter_tolerance_takes_more_states_and_an_impossible_one_is_refused() -> None:
    spectra = (ShapedSpectrum(1.0, order=1.5),)
    sizes = [len(shaping_filter(spectra, BAND, t).b) for t in (0.1, 0.01, 0.002)]
    assert sizes[0] < sizes[1] < sizes[2] <= 12
    f = np.geomspace(1e-4, 0.1, 41)
    comb = TabulatedSpectrum.of(f, np.where(np.arange(41) % 2, 1e-3, 1e-5), "a comb")
    with pytest.raises(PhysicsError, match=r"of up to 24 states comes within \d+(\.\d+)? % of it, not 1 %"):
        shaping_filter((comb,), BAND, 0.01)


def model_of(
    areas: AreaTable, config: CasesConfig, case: str, temperature: TemperatureModel
) -> tuple[NoiseModel, Correlation, np.ndarray]:
    rows = np.random.default_rng(4).standard_normal((5, len(areas)))
    found = correlation(config.case(case), areas)
    return noise_model(rows, TemperatureNoise(temperature, found), BAND, 0.01, "here"), found, rows


@pytest.mark.parametrize(("case", "states"), [("1", 2), ("2", 156), ("3", 4), ("10", 6), ("6", 24)])
def test_systems_of_cases(areas: AreaTable, config: CasesConfig, case: str, states: int) -> None:
    """As few states as there are: the areas of a block share a filter, whatever their level."""
    temperature = thesis_model(areas)
    model, found, rows = model_of(areas, config, case, temperature)
    exact = TemperatureNoise(temperature, found).psd(rows, F)
    np.testing.assert_allclose(model.psd(F), exact, rtol=1e-11, atol=0)
    assert model.states == states
    system = model.continuous()
    assert system.a.shape == (states, states)
    covariance = system.x0 @ system.x0.T
    off = system.a @ covariance + covariance @ system.a.T + 0.5 * system.b @ system.b.T
    assert np.abs(off).max() < 1e-12 * np.abs(system.b @ system.b.T).max()
    np.testing.assert_allclose(rows @ system.temperature_c, system.c, rtol=0, atol=1e-12 * np.abs(system.c).max())
    at = np.array([2e-3])
    h = system.temperature_c @ np.linalg.solve(2j * np.pi * at[0] * np.eye(states) - system.a, system.b)
    want = temperature.amplitudes(at)[:, 0] * found.active
    np.testing.assert_allclose(np.linalg.norm(h + system.temperature_d, axis=1), want, rtol=1e-11, atol=0)


def test_two_shapes_in_one_block(areas: AreaTable, config: CasesConfig) -> None:
    """An amplitude is off by at most the tolerance of its terms, also where terms of different spectra cancel."""
    temperature = TemperatureModel.by_shield(areas, outside=LOW_PASS, inside=ShapedSpectrum(1e-4, order=1.0))
    model, found, rows = model_of(areas, config, "1", temperature)
    exact = TemperatureNoise(temperature, found).psd(rows, F)
    assert model.deviation <= 0.01
    assert len(model.inputs) == 1
    terms = [
        np.abs(rows[:, mask] @ temperature.amplitudes(F)[mask])
        for mask in (areas.shield == "outside", areas.shield == "inside")
    ]
    off = np.abs(np.sqrt(model.psd(F)) - np.sqrt(exact))
    assert np.all(off <= 0.0105 * (terms[0] + terms[1]))
    assert off.max() > 0.0


def test_simulated_noise_has_the_spectrum(areas: AreaTable, config: CasesConfig) -> None:
    """The sampled system run by scipy, from a stationary start: Welch's estimate within its interval of 99.9 %."""
    temperature = thesis_model(areas)
    model, found, rows = model_of(areas, config, "3", temperature)
    rate, samples, segment = 0.2, 150_000, 8192
    system = model.discrete(rate)
    rng = np.random.default_rng(20)
    noise = rng.standard_normal((samples, system.b.shape[1]))
    x0 = system.x0 @ rng.standard_normal(len(system.x0))
    y = scipy.signal.dlsim((system.a, system.b, system.c, system.d, 1.0 / rate), noise, x0=x0)[1].T
    f, psd = scipy.signal.welch(y, rate, ("kaiser", 22.0), segment, segment * 3 // 4)
    inside = (f > 8e-4) & (f < 0.03)
    exact = TemperatureNoise(temperature, found).psd(rows, f[inside])
    ratio = psd[:, inside] / exact
    averages = 0.89 * (4 * samples // segment - 3)  # independent ones of segments that overlap by 3/4
    bins = 5  # neighbours within the window's main lobe are alike
    mean = ratio[:, : ratio.shape[1] // bins * bins].reshape(len(rows), -1, bins).mean(axis=2)
    assert np.abs(mean - 1.0).max() < 4.5 / np.sqrt(averages)
    assert abs(ratio.mean() - 1.0) < 0.02


def test_delays(areas: AreaTable, config: CasesConfig) -> None:
    """One that all areas of a noise have changes nothing; one between them is refused."""
    found = correlation(config.case("3"), areas)
    temperature, rows = thesis_model(areas), np.eye(len(areas))[:3]
    late = np.where(areas.shield == "inside", 600.0, 0.0)
    model = noise_model(
        rows,
        TemperatureNoise(temperature, Correlation(found.blocks, found.factor, found.column_block, late)),
        BAND,
        0.01,
        "",
    )
    np.testing.assert_array_equal(
        model.psd(F), noise_model(rows, TemperatureNoise(temperature, found), BAND, 0.01, "").psd(F)
    )
    late = np.where(areas.group == "struts", 600.0, 0.0)
    with pytest.raises(InputError, match="follow each other by 600 s; a delay has no state space"):
        noise_model(
            rows,
            TemperatureNoise(temperature, Correlation(found.blocks, found.factor, found.column_block, late)),
            BAND,
            0.01,
            "",
        )


def test_complex_correlation_is_refused_and_a_real_one_of_complex_numbers_is_not(areas: AreaTable) -> None:
    k = len(areas)
    for turn, fine in ((0.5 + 0.0j, True), (0.5j, False)):
        factor = np.zeros((k, 2), dtype=complex)
        factor[:2] = np.linalg.cholesky(np.array([[1.0, np.conj(turn)], [turn, 1.0]]))
        case = Correlation((np.arange(2),), factor, np.zeros(2, dtype=np.intp), np.zeros(k))
        if fine:
            model = noise_model(np.ones((1, k)), TemperatureNoise(thesis_model(areas), case), BAND, 0.01, "")
            exact = TemperatureNoise(thesis_model(areas), Correlation.of_factor(factor)).psd(np.ones((1, k)), F)
            np.testing.assert_allclose(model.psd(F), exact, rtol=1e-12, atol=0)
        else:
            with pytest.raises(InputError, match="correlation is complex"):
                noise_model(np.ones((1, k)), TemperatureNoise(thesis_model(areas), case), BAND, 0.01, "")


def test_silent_areas_take_no_states(areas: AreaTable, config: CasesConfig) -> None:
    temperature = TemperatureModel.by_shield(areas, outside=LOW_PASS, inside=WhiteSpectrum(0.0))
    model, _, _ = model_of(areas, config, "1", temperature)
    assert model.states == 2
