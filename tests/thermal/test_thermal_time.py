"""Thermal networks in time: against formulas, against their gains, and against their spectra."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from thermal_models import at, linear, network, random_network

from tedm_cli.noise.spectral_estimate import Welch
from tedm_cli.thermal import stepping
from tedm_cli.thermal.linear import LinearNetwork
from tedm_cli.thermal.spectra import cross_spectra, node_factor
from tedm_cli.thermal.stepping import NetworkInTime, slowest_s
from tedm_cli.thermal.transfer import static_gain, transfer

THREE = [at("temperature", "B0"), at("temperature", "B1"), at("power", "N5")]


class Stepped:
    """A series stepped in blocks that end anywhere."""

    def __init__(self, network: LinearNetwork, u: np.ndarray, step_s: float, *, settled: bool = True) -> None:
        steps = NetworkInTime(network, step_s, settled=settled)
        ends = [0, 1, *range(7, u.shape[1], 4096), u.shape[1]]
        blocks = [steps.advance(u[:, a:b]) for a, b in itertools.pairwise(ends) if b > a]
        self.temperature_K, self.error_K = np.concatenate(blocks, axis=1), steps.error_K


def stepped(network: LinearNetwork, u: np.ndarray, step_s: float) -> Stepped:
    return Stepped(network, u, step_s)


@pytest.fixture(scope="module")
def net() -> LinearNetwork:
    whole, boundaries = random_network(24, radiation=True)
    return linear(whole, boundaries, THREE)


def test_one_node_follows_a_ramp_as_the_formula_does() -> None:
    tau, step = 500.0 / 0.8, 70.0
    one = network([("B", "boundary", 0.0), ("N", "diffusive", 500.0)], [("B", "N", 0.8, 0.0)])
    t = step * np.arange(60)
    found = stepped(linear(one, {"B": 290.0}, [at("temperature", "B")]), 1e-3 * t[None], step)
    assert found.temperature_K[0, 1:] == pytest.approx(1e-3 * (t - tau * (1.0 - np.exp(-t / tau)))[1:], rel=1e-11)
    assert (found.error_K == 0.0).all()


def test_a_constant_disturbance_keeps_the_steady_state(net: LinearNetwork) -> None:
    u = np.tile([[1.0], [2.0], [-0.5]], 30)
    expected = static_gain(net) @ u
    assert np.abs(stepped(net, u, 100.0).temperature_K - expected).max() < 1e-11


def test_a_sine_comes_out_with_the_gain_of_its_frequency(net: LinearNetwork) -> None:
    """But for what straight lines between samples make of it: sinc² of the sine itself, and its aliases."""
    step, f, n = 200.0, 3.7e-4, 6000
    t = step * np.arange(n)
    u = np.zeros((3, n))
    u[0] = np.sin(2.0 * np.pi * f * t)
    found = stepped(net, u, step).temperature_K[:, n // 2 :]
    basis = np.exp(-2j * np.pi * f * t[n // 2 :])
    columns = np.stack([basis.real, -basis.imag], axis=1)
    fit = np.linalg.lstsq(columns, found.T, rcond=None)[0]
    aliases = f + np.arange(-400, 401) / step
    gains = transfer(net, np.abs(aliases))[:, :, 0]
    gains = np.where(aliases[:, None] < 0.0, np.conj(gains), gains)
    expected = (gains * np.sinc(aliases * step)[:, None] ** 2).sum(axis=0)
    assert np.abs((fit[1] + 1j * fit[0]) / expected - 1.0).max() < 1e-5


def test_implicit_steps_are_of_third_order_and_know_their_error(
    net: LinearNetwork, monkeypatch: pytest.MonkeyPatch
) -> None:
    rng = np.random.default_rng(3)
    knots = rng.standard_normal((3, 41))
    errors, told = [], []
    for pieces in (2, 4, 8):
        fine = np.linspace(0.0, 40.0, 40 * pieces + 1)
        u = np.stack([np.interp(fine, np.arange(41.0), row) for row in knots])
        monkeypatch.setattr(stepping, "SMALL", 400)
        exact = stepped(net, u, 40.0 / pieces).temperature_K
        monkeypatch.setattr(stepping, "SMALL", 0)
        found = stepped(net, u, 40.0 / pieces)
        errors.append(np.abs(found.temperature_K - exact).max(axis=1))
        told.append(found.error_K)
    arithmetic = net.capacity == 0.0
    assert arithmetic.any()
    order = np.log2(np.array(errors[:-1]) / np.array(errors[1:]))
    assert np.median(order[-1]) == pytest.approx(3.0, abs=0.4)
    assert (errors[-1] < 2.0 * told[-1] + 1e-13).all()
    assert (told[-1] < 10.0 * errors[-1] + 1e-13).all()


def test_the_spectra_of_a_stepped_series_are_those_of_the_gains(net: LinearNetwork) -> None:
    """Within the interval of the estimate at 99.9 %, for as many frequencies as it promises."""
    rng = np.random.default_rng(2026)
    step, n, segment = 50.0, 1 << 17, 4096
    R = np.array([[1.0, 0.6, 0.0], [0.6, 1.0, -0.3], [0.0, -0.3, 1.0]])
    factor = np.linalg.cholesky(R)
    white = factor @ rng.standard_normal((3, n))
    # Noise that is steep where straight lines between the samples would differ from it: two poles at 0.1 mHz.
    pole = np.exp(-2.0 * np.pi * 1e-4 * step)
    u = white.copy()
    for _ in range(2):
        for k in range(1, n):
            u[:, k] += pole * u[:, k - 1]
    found = stepped(net, u, step).temperature_K[:, 4000:]
    welch = Welch(len(found), 1.0 / step, segment)
    welch.add(found)
    estimate = welch.estimate()
    inside = estimate.frequency_hz < 1.5e-3
    f = estimate.frequency_hz[inside]
    asd = np.abs(1.0 - pole * np.exp(-2j * np.pi * f * step)) ** -2 * np.sqrt(2.0 * step)
    S = cross_spectra(node_factor(transfer(net, f), np.tile(asd, (3, 1)), factor))
    exact = np.einsum("fii->if", S).real * np.sinc(f * step) ** 4
    low, high = (factor_of[inside] for factor_of in estimate.interval(0.999))
    ratio = exact / estimate.psd[:, inside]
    heard = (ratio >= low) & (ratio <= high)
    assert len(f) > 100
    assert heard.mean() > 0.99
    assert np.median(ratio) == pytest.approx(1.0, abs=0.05)
    wrong = np.einsum("fii->if", cross_spectra(node_factor(transfer(net, 1.2 * f), np.tile(asd, (3, 1)), factor))).real
    assert ((wrong / estimate.psd[:, inside] >= low) & (wrong / estimate.psd[:, inside] <= high)).mean() < 0.9


def test_the_slowest_time_constant_is_that_of_the_dense_problem(net: LinearNetwork) -> None:
    """After arithmetic nodes are eliminated by hand."""
    K, free = net.conductance.toarray(), net.capacity > 0.0
    still = ~free
    reduced = K[np.ix_(free, free)] - K[np.ix_(free, still)] @ np.linalg.solve(
        K[np.ix_(still, still)], K[np.ix_(still, free)]
    )
    rates = np.linalg.eigvals(reduced / net.capacity[free][:, None])
    assert slowest_s(net) == pytest.approx(1.0 / rates.real.min(), rel=1e-3)
    assert slowest_s(net) >= (1.0 - 1e-9) / rates.real.min()


def test_it_begins_without_disturbances_or_settled_to_the_first(net: LinearNetwork) -> None:
    u = np.tile([[1.0], [2.0], [-0.5]], 20)
    diffusive = net.capacity > 0.0
    cold = Stepped(net, u, slowest_s(net), settled=False).temperature_K
    assert (cold[diffusive, 0] == 0.0).all()
    left = np.abs(cold - static_gain(net) @ u)
    assert left[diffusive, 1].max() > 0.1
    assert left[:, -1].max() < 1e-6
    assert left[:, -1].max() > 1e-12  # by exp(-19) of the slowest
