"""A case of the thermal network as a linear system: its spectra, its stationarity, its sampled form."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import scipy
from network_models import BAND, ROWS, SPECTRA, F, network

from tedm_cli.errors import InputError
from tedm_cli.noise.network import NetworkNoise
from tedm_cli.noise.shaping.models import model_of
from tedm_cli.noise.shaping.network_model import NetworkModel
from tedm_cli.noise.temperature import FlightSpectrum


def modelled(noise: NetworkNoise) -> NetworkModel:
    found = model_of(ROWS, noise, BAND, 1e-3, "case T")
    assert isinstance(found, NetworkModel)
    return found


@pytest.mark.parametrize("fed", [False, True])
def test_its_spectra_are_those_of_the_gains(fed: bool) -> None:
    """By the model, and by the matrices that are exported; exact, for these filters are."""
    noise = network(correlated=False, fed=fed)
    model, wanted = modelled(noise), noise.outputs(ROWS, F).psd()
    np.testing.assert_allclose(model.psd(F), wanted, rtol=1e-10)
    s = model.continuous()
    h = s.c @ np.linalg.solve(2j * np.pi * F[:, None, None] * np.eye(model.states) - s.a, s.b[None]) + s.d
    np.testing.assert_allclose((np.abs(h) ** 2).sum(axis=2).T, wanted, rtol=1e-10)
    np.testing.assert_array_equal(s.c, ROWS @ s.temperature_c)
    assert model.states == 2 + 1 + 2
    assert model.noises == 2
    assert model.direct is False


def test_correlated_disturbances_keep_their_correlation() -> None:
    """Of spectra that a filter fits: amplitudes and cross-spectrum, within what the filters are off."""
    noise = network(correlated=True, fed=False)
    model = modelled(noise)
    np.testing.assert_allclose(model.psd(F), noise.outputs(ROWS, F).psd(), rtol=1e-2)
    apart = network(correlated=False, fed=False).outputs(ROWS, F).psd()
    assert np.abs(model.psd(F) / apart - 1.0).max() > 0.1


@pytest.mark.parametrize("white", [False, True])
def test_sampled_form_has_the_covariance_of_the_continuous_one(white: bool) -> None:
    """Of states, and without direct feed of outputs. With it these are means over the step, by what folds."""
    spectra = (FlightSpectrum(), SPECTRA[1]) if white else SPECTRA  # which ends flat: a filter that feeds through
    model, rate = modelled(network(spectra, correlated=False, fed=True)), 0.05
    assert model.direct is white
    s, z = model.continuous(), model.discrete(rate)
    p = s.x0 @ s.x0.T
    np.testing.assert_allclose(s.a @ p + p @ s.a.T, -0.5 * s.b @ s.b.T, atol=1e-12 * np.abs(s.b @ s.b.T).max())
    found = scipy.linalg.solve_discrete_lyapunov(z.a, z.b @ z.b.T)
    np.testing.assert_allclose(found, p, rtol=1e-8, atol=1e-12 * np.abs(p).max())
    if not white:
        np.testing.assert_allclose(z.c @ found @ z.c.T, s.c @ p @ s.c.T, rtol=1e-8)
        return
    # of the sampled outputs: the spectrum through sinc², and what it folds; here next to nothing but of white noise
    f = np.geomspace(1e-4, 2e-3, 9)
    e = np.exp(2j * np.pi * f / rate)
    h = z.c @ np.linalg.solve(e[:, None, None] * np.eye(model.states) - z.a, z.b[None]) + z.d
    psd = 2.0 / rate * (np.abs(h) ** 2).sum(axis=2).T
    folded = sum(model.psd(np.abs(f + n * rate)) * np.sinc((f + n * rate) / rate) ** 2 for n in range(-400, 401))
    np.testing.assert_allclose(psd, folded, rtol=2e-3)


def test_no_network_behind_the_gains_has_no_states() -> None:
    with pytest.raises(InputError, match="has gains alone"):
        model_of(ROWS, replace(network(correlated=False, fed=False), network=None), BAND, 1e-3, "case T")
