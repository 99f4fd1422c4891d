"""Draws and shares of variance against distributions that are known, and ratios against the propagation itself."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import scipy

from tedm_cli.errors import PhysicsError
from tedm_cli.noise.correlation import Correlation
from tedm_cli.noise.propagation import OutputNoise, TemperatureNoise
from tedm_cli.noise.temperature import ShapedSpectrum, TemperatureModel, WhiteSpectrum
from tedm_cli.uncertainty.parameters import Parameter, Parameters
from tedm_cli.uncertainty.response import Effects, Ratio
from tedm_cli.uncertainty.sampling import latin_hypercube
from tedm_cli.uncertainty.verdicts import CaseUncertainty, Chance, Draws, Judged, uncertainty

F = np.array([1e-3])
ONE = WhiteSpectrum(1.0)


def noise_of(rows: np.ndarray, spectra: list, factor: np.ndarray, delay: np.ndarray | None = None) -> OutputNoise:
    source = TemperatureNoise(TemperatureModel.from_spectra(spectra), Correlation.of_factor(factor, delay))
    return OutputNoise(rows, source, F)


def together(row: list[float]) -> OutputNoise:
    """One output of areas that move as one, 1 K/√Hz at every frequency: its ASD is |sum of the row|."""
    return noise_of(np.array([row]), [ONE] * len(row), np.ones((len(row), 1)))


def parameter(name: str, deviation: float, distribution: str = "normal", quantity: str = "expansion") -> Parameter:
    return Parameter(name, quantity, "", deviation, distribution)


def effects(parameters: Parameters, change: list, level: list | None = None) -> Effects:
    rows = np.array(change, dtype=float)[:, None]
    return Effects(
        parameters, rows, np.zeros(rows[:, 0].shape, dtype=bool) if level is None else np.array(level, dtype=bool)
    )


def drawn(found: Effects, row: list[float], limit: float, factor: float = 1.0, **draws: int) -> CaseUncertainty:
    noise = together(row)
    ratio = Ratio(found.response(noise.rows[0], 0), noise, F, np.array([limit / factor]))
    nominal = factor * abs(sum(row)) / limit
    return uncertainty(found.parameters, [Judged("o", "r", nominal, ratio)], factor, Draws(**draws))


def within(chance: Chance, probability: float) -> bool:
    """Three standard errors of independent draws; a Latin hypercube of one variable is far better."""
    return abs(chance.probability - probability) < 3.0 * np.sqrt(probability * (1.0 - probability) / 10_000)


def test_one_normal_parameter() -> None:
    """|1 + 0.2 z| of a limit of 1.3: the probability, the moments and the percentiles of a normal distribution."""
    found = drawn(effects(Parameters.of((parameter("a", 0.2),)), [[1.0]]), [1.0], 1.3, factor=1.1)
    one = found.verdicts[0]
    assert within(one.violated, scipy.stats.norm.sf(1.0, 1.1 / 1.3, 0.22 / 1.3))
    assert within(one.violated_bare, scipy.stats.norm.sf(1.3, 1.0, 0.2))
    assert one.violated.probability > one.violated_bare.probability
    assert one.mean == pytest.approx(1.1 / 1.3, rel=1e-4)
    assert one.deviation == pytest.approx(0.22 / 1.3, rel=1e-2)
    for percent in (5, 50, 95):
        wanted = scipy.stats.norm.ppf(percent / 100.0, 1.1 / 1.3, 0.22 / 1.3)
        assert one.percentile(percent) == pytest.approx(wanted, rel=2e-3)
    assert one.share_first == pytest.approx([1.0], abs=0.02)
    assert one.share_total == pytest.approx([1.0], abs=0.02)
    assert found.any_violated == one.violated == found.outputs[0].violated


def test_two_independent_parameters_share_the_variance() -> None:
    """Of a sum the shares are those of the variances, alone and in total."""
    pair = Parameters.of((parameter("a", 0.03), parameter("b", 0.04, "uniform")))
    one = drawn(effects(pair, [[2.0, 0.0], [0.0, 1.0]]), [2.0, 1.0], 3.0).verdicts[0]
    parts = np.array([(2.0 * 0.03) ** 2, 0.04**2 / 3.0])
    assert one.share_first == pytest.approx(parts / parts.sum(), abs=0.01)
    assert one.share_total == pytest.approx(parts / parts.sum(), abs=0.01)
    assert one.deviation == pytest.approx(np.sqrt(parts.sum()) / 3.0, rel=1e-2)


def test_a_lognormal_level_has_its_percentiles() -> None:
    level = Parameters.of((parameter("level", 0.3, "lognormal", "level"),))
    one = drawn(effects(level, [[0.0, 0.0]], [[True, True]]), [1.0, 0.5], 1.5).verdicts[0]
    for percent in (5, 50, 95):
        assert one.percentile(percent) == pytest.approx(np.exp(0.3 * scipy.stats.norm.ppf(percent / 100.0)), rel=2e-3)
    assert within(one.violated, 0.5)


def test_level_and_material_multiply() -> None:
    """Of a product L (1 + x) the total shares are the first-order ones and the interaction, which both have."""
    both = Parameters.of((parameter("level", 0.8, "uniform", "level"), parameter("a", 0.5)))
    one = drawn(effects(both, [[0.0], [1.0]], [[True], [False]]), [1.0], 0.7).verdicts[0]
    level, material = 0.8**2 / 3.0, 0.5**2
    whole = (1.0 + level) * (1.0 + material) - 1.0
    assert one.share_first == pytest.approx([level / whole, material / whole], abs=0.03)
    assert one.share_total == pytest.approx(
        [level * (1.0 + material) / whole, material * (1.0 + level) / whole], abs=0.03
    )
    assert one.share_first.sum() < 0.97 < 1.03 < one.share_total.sum()


@pytest.mark.parametrize(("rho", "size"), [(1.0, 0.3), (0.0, np.hypot(0.1, 0.2)), (-0.5, np.sqrt(0.03)), (-1.0, 0.1)])
def test_correlated_parameters_are_one_source(rho: float, size: float) -> None:
    pair = Parameters.of((parameter("a", 0.1), parameter("b", 0.1)), {("a", "b"): rho})
    one = drawn(effects(pair, [[1.0, 0.0], [0.0, 2.0]]), [1.0, 2.0], 3.0).verdicts[0]
    assert pair.sources == (["a", "b"] if rho == 0.0 else ["a + b"])
    assert one.deviation == pytest.approx(size / 3.0, rel=2e-2)
    assert one.share_first.sum() == pytest.approx(1.0, abs=0.02)


def test_what_contradicts_itself_is_no_correlation() -> None:
    items = tuple(parameter(name, 0.1) for name in ("a", "other", "b", "c"))
    pairs = {("a", "b"): 0.9, ("b", "c"): 0.9, ("a", "c"): -0.9}
    with pytest.raises(PhysicsError, match="a, b, c cannot be correlated so: not positive semidefinite") as caught:
        Parameters.of(items, pairs)
    assert "other" not in str(caught.value)
    assert Parameters.of(items, {**pairs, ("a", "c"): 0.7}).sources == ["a + b + c", "other"]


@pytest.mark.parametrize("distribution", ["normal", "uniform", "lognormal"])
@pytest.mark.parametrize(("limit", "chance"), [(0.99, 1.0), (1.01, 0.0)])
def test_without_deviations_a_verdict_is_sure(distribution: str, limit: float, chance: float) -> None:
    still = Parameters.of((parameter("a", 0.0, distribution), parameter("level", 0.0, distribution, "level")))
    one = drawn(effects(still, [[1.0], [0.0]], [[False], [True]]), [1.0], limit).verdicts[0]
    assert one.violated.probability == chance
    assert one.violated.error == 0.0
    assert one.quantile == pytest.approx(np.full(99, one.nominal), rel=1e-12)
    assert not one.share_first.any()
    assert not one.share_total.any()


def test_without_parameters_there_is_the_verdict() -> None:
    none = Effects(Parameters.of(()), np.zeros((0, 1, 1)), np.zeros((0, 1), dtype=bool))
    found = drawn(none, [2.0], 1.0)
    assert found.verdicts[0].violated.probability == 1.0
    assert (found.verdicts[0].quantile == 2.0).all()
    assert found.sources == []


def test_moduli_go_by_their_logarithm() -> None:
    """y + ln(1 + x) ∂y/∂ln E, of a lognormal parameter a normal distribution; expansions by x itself, exactly."""
    x = np.array([-0.1, 0.0, 0.3])
    for quantity, wanted in (("modulus", np.log1p(x)), ("thickness", np.log1p(x)), ("density", x), ("expansion", x)):
        np.testing.assert_array_equal(parameter("a", 0.1, quantity=quantity).coefficient(x), wanted)
    stiff = parameter("a", 0.4, "lognormal", "modulus")
    z = np.linspace(-3.0, 3.0, 7)
    np.testing.assert_allclose(stiff.coefficient(stiff.deviations(z)), 0.4 * z, rtol=1e-12, atol=1e-15)


def test_what_is_positive_stays_so() -> None:
    z = np.array([-40.0, -4.0, 0.0, 4.0, 40.0])
    for quantity in ("modulus", "density", "thickness", "level"):
        x = parameter("a", 0.2, quantity=quantity).deviations(z)
        assert (x > -1.0).all()
        np.testing.assert_allclose(x[1:4], 0.2 * z[1:4])
    assert parameter("a", 0.2).deviations(z)[0] == pytest.approx(-8.0)


def test_draws_follow_their_seed_and_fill_every_stratum() -> None:
    found = latin_hypercube(100, 3, 5)
    np.testing.assert_array_equal(found, latin_hypercube(100, 3, 5))
    assert not np.array_equal(found, latin_hypercube(100, 3, 6))
    np.testing.assert_array_equal(np.sort((found * 100).astype(int), axis=0), np.tile(np.arange(100)[:, None], 3))


def test_intervals_of_what_never_happened() -> None:
    """Wilson's: z² / (n + z²) at the other end."""
    never, always = Chance.of(np.zeros(10_000, dtype=bool)), Chance.of(np.ones(10_000, dtype=bool))
    z = scipy.stats.norm.ppf(0.975)
    assert never.probability == 0.0
    assert never.low == pytest.approx(0.0, abs=1e-12)
    assert never.high == pytest.approx(z**2 / (10_000 + z**2), rel=1e-9)
    assert always.low == pytest.approx(1.0 - never.high, rel=1e-12)


@pytest.mark.parametrize("shapes", [1, 2, 3])
@pytest.mark.parametrize("delayed", [False, True])
def test_ratios_are_those_of_the_propagation(shapes: int, delayed: bool) -> None:
    """Of each draw: levels multiplied into the temperatures, changes added to the rows, and all propagated anew."""
    rng = np.random.default_rng(10 * shapes + delayed)
    k, p, n = 9, 5, 6
    kinds = [ShapedSpectrum(1e-3), WhiteSpectrum(1e-4), ShapedSpectrum(5e-4, order=1.0, corner_hz=4e-3)][:shapes]
    spectra = [kinds[i % shapes] for i in range(k)]
    factor = rng.normal(size=(k, 4))
    factor /= np.linalg.norm(factor, axis=1, keepdims=True)
    delay = rng.uniform(0.0, 300.0, k) * (np.arange(k) > 5) if delayed else np.zeros(k)
    f = np.geomspace(1e-4, 0.1, 400)
    limit = 1e-3 * (1.0 + (2e-3 / f) ** 2) / (1.0 + (4e-3 / f) ** rng.integers(1, 3))
    names = ("low", "all", "a", "b", "e")
    quantities = ("level", "level", "expansion", "density", "modulus")
    items = tuple(parameter(name, 0.2, quantity=quantity) for name, quantity in zip(names, quantities, strict=True))
    level = np.array([np.arange(k) < 4, np.ones(k), np.zeros(k), np.zeros(k), np.zeros(k)], dtype=bool)
    change = rng.normal(size=(p, 2, k)) * ~level.any(axis=1)[:, None, None]
    rows = rng.normal(size=(2, k))
    parameters = Parameters.of(items, {("low", "all"): 0.4})
    x = parameters.deviations(rng.uniform(size=(n, p)))
    noise = replace(noise_of(rows, spectra, factor, delay), frequency_hz=f)
    for o in range(2):
        found, at = Ratio(Effects(parameters, change, level).response(rows[o], o), noise, f, limit).worst(x)
        for draw in range(n):
            delta = np.array([item.coefficient(x[draw, i]) for i, item in enumerate(items)])
            row = (rows[o] + delta @ change[:, o]) * np.prod(1.0 + level * x[draw][:, None], axis=0)
            ratios = np.sqrt(noise.of(row[None]).psd()[0]) / limit
            assert found[draw] == pytest.approx(ratios.max(), rel=1e-9)
            assert ratios[at[draw]] == pytest.approx(ratios.max(), rel=1e-9)


def test_cross_spectra_hold_the_psd_of_every_combination() -> None:
    rng = np.random.default_rng(4)
    spectra = [ShapedSpectrum(1e-3), WhiteSpectrum(1e-4), ShapedSpectrum(1e-3)]
    noise = noise_of(rng.normal(size=(4, 3)), spectra, np.eye(3) + 0.5j, np.array([0.0, 50.0, 200.0]))
    noise = noise.at(np.geomspace(1e-4, 0.1, 7))
    found, weights = noise.cross_spectra(), rng.normal(size=4)
    assert found.shape == (7, 4, 4)
    np.testing.assert_allclose(found, found.conj().transpose(0, 2, 1), rtol=1e-12, atol=1e-30)
    assert np.abs(found.imag).max() > 1e-3 * np.abs(found.real).max(), "or the case says nothing of phases"
    np.testing.assert_allclose(np.diagonal(found, axis1=1, axis2=2).real.T, noise.psd(), rtol=1e-12)
    combined = np.einsum("i,fij,j->f", weights, found, weights).real
    np.testing.assert_allclose(combined, noise.of(weights[None] @ noise.rows).psd()[0], rtol=1e-12)


def test_areas_that_cancel_keep_their_digits() -> None:
    """Two groups that cancel to a part in 10^5: the nominal ratio is as exact as the propagation has it."""
    row = [1.0, -1.0 + 1e-5]
    levels = Parameters.of(tuple(parameter(name, 1e-7, quantity="level") for name in "ab"))
    found = effects(levels, np.zeros((2, 2)).tolist(), np.eye(2).tolist())
    noise = together(row)
    ratio = Ratio(found.response(noise.rows[0], 0), noise, F, np.ones(1))
    assert ratio.of(np.zeros((1, 2)))[0] == pytest.approx(1e-5, rel=1e-11)
    x = np.array([[1e-7, -1e-7]])
    assert ratio.of(x)[0] == pytest.approx(1e-5 + 1e-7 * (1.0 - row[1]), rel=1e-6)
