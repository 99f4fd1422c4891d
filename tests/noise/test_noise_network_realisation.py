"""Series of a thermal network: their spectra within confidence, their phases, and the gains between frequencies."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import scipy
from network_models import ROWS, network

from tedm_cli.errors import InputError
from tedm_cli.noise.network import NetworkNoise
from tedm_cli.noise.network_realisation import gains_between, network_blocks, network_expected
from tedm_cli.noise.realisation import Plan, estimated, resolved

PLAN = Plan(rate_hz=0.25, samples=400_000, seed=3, low_hz=3e-4, high_hz=0.1, lowest_hz=1e-3)


@pytest.fixture(scope="module")
def source() -> NetworkNoise:
    return network(correlated=True, fed=True)


def test_gains_between_frequencies_are_those_of_the_network(source: NetworkNoise) -> None:
    """At frequencies that are none of the spline's, where an output's nodes cancel too."""
    f = np.geomspace(3.1e-4, 0.099, 173)
    assert source.network is not None
    wanted = np.einsum("ok,kfu->ofu", ROWS, source.network.driven(f)) @ source.factor
    found = gains_between(ROWS, source, 3e-4, 0.1).fields(f)
    size = np.abs(wanted).max(axis=2, keepdims=True)
    np.testing.assert_allclose(found / size, wanted / size, atol=2e-6)


def test_estimates_lie_within_their_confidence(source: NetworkNoise) -> None:
    """99 % of the estimates, at frequencies that share no samples of the spectrum, in their 99.9 % interval."""
    done: list[int] = []
    estimate = estimated(network_blocks(ROWS, source, PLAN), len(ROWS), PLAN, done.append)
    assert sum(done) == PLAN.samples
    inside = resolved(estimate.frequency_hz, PLAN)
    f = estimate.frequency_hz[inside]
    expected = network_expected(source.outputs(ROWS, f), PLAN)
    low, high = estimate.interval(0.999)
    ratio = expected / estimate.psd[:, inside]
    within = (ratio >= low[inside]) & (ratio <= high[inside])
    assert within.mean() > 0.985
    assert np.abs(ratio.mean(axis=1) - 1.0).max() < 0.02
    # what the window takes from the spectra is little, except for steep ones at the lowest frequency
    exact = source.at(f).outputs(ROWS, f).psd()
    assert np.abs(expected / exact - 1.0).max() < 0.02
    # and without correlation the spectra are others, which this would see
    other = network(correlated=False, fed=True).at(f).outputs(ROWS, f).psd()
    assert np.abs(other / exact - 1.0).max() > 0.1


def test_phases_between_outputs_are_those_of_the_network(source: NetworkNoise) -> None:
    """The cross-spectrum of the two outputs, by SciPy, against H S Hᴴ: a gain whose phase was lost would be real."""
    series = np.concatenate(list(network_blocks(ROWS, source, PLAN)), axis=1)
    f, cross = scipy.signal.csd(series[1], series[0], PLAN.rate_hz, nperseg=4096)  # E[y0 y1*]
    chosen = np.flatnonzero((f > 1.5e-3) & (f < 2e-2))[::8]
    wanted = source.at(f[chosen]).outputs(ROWS, f[chosen]).cross_spectra()
    coherence = wanted[:, 0, 1] / np.sqrt(wanted[:, 0, 0].real * wanted[:, 1, 1].real)
    power = [scipy.signal.welch(y, PLAN.rate_hz, nperseg=4096)[1][chosen] for y in series]
    found = cross[chosen] / np.sqrt(power[0] * power[1])
    assert np.abs(found - coherence).max() < 0.15  # 195 segments: 0.05 of a coherence of 0.7
    assert np.abs(found - coherence).mean() < 0.05
    assert np.abs(coherence.imag).max() > 0.2


def test_the_same_seed_makes_the_same_series(source: NetworkNoise) -> None:
    one, again = (
        np.concatenate(list(network_blocks(ROWS, source, replace(PLAN, samples=50_000))), axis=1) for _ in range(2)
    )
    np.testing.assert_array_equal(one, again)
    assert one.shape == (2, 50_000)
    other = next(network_blocks(ROWS, source, replace(PLAN, samples=50_000, seed=4)))
    assert np.abs(one[:, : other.shape[1]] - other).max() > 0.0


def test_refusals(source: NetworkNoise) -> None:
    with pytest.raises(InputError, match="known at some frequencies alone"):
        next(network_blocks(ROWS, replace(source, network=None), PLAN))
    with pytest.raises(InputError, match="are held"):
        next(network_blocks(ROWS, source, replace(PLAN, rate_hz=10.0, lowest_hz=1e-5)))
