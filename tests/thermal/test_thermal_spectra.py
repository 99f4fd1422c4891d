"""Spectra of nodes, their coherence, and the low-pass that fits a gain."""

from __future__ import annotations

import numpy as np
import pytest
from thermal_models import at, linear, network, random_network

from tedm_cli.noise.correlation_check import correlation_factor
from tedm_cli.noise.temperature import ShapedSpectrum
from tedm_cli.thermal.linear import Place
from tedm_cli.thermal.low_pass import fitted, searched_hz
from tedm_cli.thermal.spectra import coherence, cross_spectra, node_factor
from tedm_cli.thermal.transfer import transfer

FREQUENCY = np.geomspace(1e-5, 0.1, 60)


def spectra(places: list[Place], R: np.ndarray, radiation: bool = True) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    net, boundaries = random_network(20, radiation=radiation)
    H = transfer(linear(net, boundaries, places), FREQUENCY)
    asd = np.stack([(1.0 + i) * 1e-3 * (FREQUENCY / 1e-3) ** -i for i in range(len(places))])
    return H, asd, cross_spectra(node_factor(H, asd, correlation_factor(R)))


THREE = [at("temperature", "B0"), at("temperature", "B1"), at("power", "N5")]


def test_spectra_are_h_s_h() -> None:
    R = np.array([[1.0, 0.3, -0.5], [0.3, 1.0, 0.0], [-0.5, 0.0, 1.0]])
    H, asd, S = spectra(THREE, R)
    source = asd.T[:, :, None] * R * asd.T[:, None, :]
    expected = H @ source @ np.conj(H.transpose(0, 2, 1))
    scale = np.sqrt(np.einsum("fii->fi", expected).real)
    assert np.abs((S - expected) / (scale[:, :, None] * scale[:, None, :])).max() < 1e-13
    assert (np.conj(S.transpose(0, 2, 1)) == S).all()
    assert (np.einsum("fii->fi", S).imag == 0.0).all()
    assert (np.einsum("fii->fi", S).real > 0.0).all()


def test_one_cause_makes_all_nodes_coherent() -> None:
    """The first of the ten cases; so do several that are wholly correlated."""
    for places, R in ((THREE[:1], np.eye(1)), (THREE[1:], np.ones((2, 2)))):
        _, _, S = spectra(places, R)
        assert np.abs(np.abs(coherence(S)) - 1.0).max() < 1e-12


def test_a_boundary_for_each_node_and_nothing_between_makes_none_coherent() -> None:
    """The second of the ten cases."""
    nodes = [(f"B{i}", "boundary", 0.0) for i in range(4)] + [(f"N{i}", "diffusive", 10.0 + i) for i in range(4)]
    net = network(nodes, [(f"B{i}", f"N{i}", 0.1, 0.01) for i in range(4)])
    places = [at("temperature", f"B{i}") for i in range(4)]
    H = transfer(linear(net, {f"B{i}": 290.0 + i for i in range(4)}, places), FREQUENCY)
    S = cross_spectra(node_factor(H, np.ones((4, len(FREQUENCY))), np.eye(4)))
    assert (np.abs(coherence(S) - np.eye(4)) < 1e-15).all()


def test_coherence_is_between_nought_and_one_and_tells_which_is_later() -> None:
    _, _, S = spectra(THREE, np.eye(3))
    found = coherence(S)
    assert np.abs(found).max() <= 1.0 + 1e-12
    assert np.abs(found[:, 0, -1]).min() < 0.999
    _, _, alone = spectra(THREE[:1], np.eye(1))
    assert (np.angle(coherence(alone)[20, 0, 1:12]) > 0.0).any()  # N0 stands next to the boundary: others are later
    alone[:, 0, :] = alone[:, :, 0] = 0.0
    assert (coherence(alone)[:, 0] == 0.0).all()


@pytest.mark.parametrize("order", [0.3, 1.0, 2.0, 5.5])
@pytest.mark.parametrize("corner", [3e-6, 1e-4, 1e-3, 0.05])
def test_the_shape_of_the_cases_is_found_again(order: float, corner: float) -> None:
    gain = ShapedSpectrum(0.37, 1e-3, corner, order).amplitude(FREQUENCY)
    phase = np.exp(1j * np.linspace(0.0, 9.0, len(gain)))
    found = fitted((gain * phase)[:, None], FREQUENCY)
    # A corner well below the frequencies bends the gain too little to be found.
    exact = (FREQUENCY[0] / corner) ** (2.0 * order) < 1.0
    assert found.order[0] == pytest.approx(order, rel=1e-5 if exact else 0.03)
    assert found.corner_hz[0] == pytest.approx(corner, rel=1e-5) or not exact
    assert found.error[0] < 1e-6 if exact else found.error[0] < 1e-3


def test_one_node_is_of_first_order_with_the_corner_of_its_time_constant() -> None:
    net = network([("B", "boundary", 0.0), ("N", "diffusive", 500.0)], [("B", "N", 0.8, 0.0)])
    found = fitted(transfer(linear(net, {"B": 290.0}, [at("temperature", "B")]), FREQUENCY), FREQUENCY)
    assert found.order.shape == (1, 1)
    assert found.order[0, 0] == pytest.approx(1.0, rel=1e-7)
    assert found.corner_hz[0, 0] == pytest.approx(0.8 / 500.0 / (2.0 * np.pi), rel=1e-7)


def test_no_fit_is_better() -> None:
    """The fit is the least squares: no neighbour of it is better, whatever the gain."""
    net, boundaries = random_network(20, radiation=True)
    H = transfer(linear(net, boundaries, THREE), FREQUENCY)
    found = fitted(H, FREQUENCY)
    log = np.log(np.abs(H))
    low, high = searched_hz(FREQUENCY)

    def error(order: np.ndarray, corner: np.ndarray) -> np.ndarray:
        shape = log + 0.5 * np.logaddexp(0.0, 2.0 * order * np.log(FREQUENCY[:, None, None] / corner))
        return np.asarray(shape.std(axis=0))

    assert found.error == pytest.approx(error(found.order, found.corner_hz), rel=1e-9, abs=1e-12)
    for by in (0.97, 1.03):
        assert (error(found.order * by, found.corner_hz) >= found.error - 1e-9).all()
        corner = np.clip(found.corner_hz * by, low, high)
        assert (error(found.order, corner) >= found.error - 1e-9).all()


def test_gains_without_a_low_pass() -> None:
    flat = np.full((len(FREQUENCY), 2), 0.5 + 0.0j)
    flat[7, 1] = 0.0
    found = fitted(flat, FREQUENCY)
    assert found.corner_hz[0] == pytest.approx(searched_hz(FREQUENCY)[1], rel=1e-12)
    assert np.isnan([found.order[1], found.corner_hz[1], found.error[1]]).all()
    assert np.isnan(fitted(flat[:3], FREQUENCY[:3]).order).all()  # too few frequencies for three unknowns
