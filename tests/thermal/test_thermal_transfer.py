"""Gains of thermal networks against formulas, against differences of steady states, and by what they must keep."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from thermal_models import at, linear, network, random_network, steady

from tedm_cli.errors import InputError
from tedm_cli.thermal.transfer import static_gain, transfer

FREQUENCY = np.geomspace(1e-6, 1.0, 40)


def test_a_ladder_of_two_nodes_is_the_formula() -> None:
    c1, c2, g0, g1 = 120.0, 45.0, 0.31, 0.07
    net = network(
        [("B", "boundary", 0.0), ("N1", "diffusive", c1), ("N2", "diffusive", c2)],
        [("B", "N1", g0, 0.0), ("N1", "N2", g1, 0.0)],
    )
    found = transfer(linear(net, {"B": 290.0}, [at("temperature", "B"), at("power", "N2")]), FREQUENCY)
    s = 2j * np.pi * FREQUENCY
    det = (g0 + g1 + s * c1) * (g1 + s * c2) - g1**2
    expected = np.array([[g0 * (g1 + s * c2) / det, g1 / det], [g0 * g1 / det, (g0 + g1 + s * c1) / det]])
    assert np.abs(found / expected.transpose(2, 0, 1) - 1.0).max() < 2e-15


def test_a_common_boundary_moves_all_alike_when_slow() -> None:
    """Without radiation, whatever the powers; with it only from an isothermal state."""
    net, boundaries = random_network(50, radiation=False)
    both = [at("temperature", "B0", "B1")]
    assert static_gain(linear(net, boundaries, both)) == pytest.approx(1.0, rel=1e-12)
    hot, boundaries = random_network(50, radiation=True)
    assert np.ptp(static_gain(linear(hot, boundaries, both))) > 0.1
    hot.power[:] = 0.0
    same = dict.fromkeys(boundaries, 273.0)
    assert static_gain(linear(hot, same, both)) == pytest.approx(1.0, rel=1e-12)
    slow = transfer(linear(hot, same, both), np.array([1e-12]))
    assert np.abs(slow - 1.0).max() < 1e-5


def test_gains_of_radiation_are_differences_of_the_steady_state() -> None:
    net, boundaries = random_network(40, radiation=True)
    places = [at("temperature", "B0"), at("temperature", "B0", "B1"), at("power", "N3", "N8", share=(0.25, 0.75))]
    found = static_gain(linear(net, boundaries, places))
    step = 0.05

    def moved(number: int, by: float) -> np.ndarray:
        place = places[number]
        if place.kind == "temperature":
            return steady(net, {k: v + by * (k in place.nodes) for k, v in boundaries.items()}).temperature_K
        before = net.power.copy()
        for name, share in zip(place.nodes, place.share, strict=True):
            net.power[net.row[name]] += by * share
        temperature = steady(net, boundaries).temperature_K
        net.power[:] = before
        return temperature

    for number in range(3):
        # Two central differences, from which the error of second order drops out.
        near, far = ((moved(number, h) - moved(number, -h)) / (2.0 * h) for h in (step, 2.0 * step))
        difference = (4.0 * near - far) / 3.0
        assert np.abs(difference[net.free] - found[:, number]).max() < 1e-9 * np.abs(found[:, number]).max()


def test_reciprocity_without_radiation() -> None:
    """Power here and temperature there may be exchanged; radiation between different temperatures breaks that."""
    for radiation in (False, True):
        net, boundaries = random_network(25, radiation=radiation)
        names = [net.name[i] for i in net.free]
        found = transfer(linear(net, boundaries, [at("power", name) for name in names]), FREQUENCY[::8])
        scale = np.abs(found).max(axis=(1, 2), keepdims=True)
        off = (np.abs(found - found.transpose(0, 2, 1)) / scale).max()
        assert (off > 1e-3) if radiation else (off < 1e-13)


def test_few_outputs_are_solved_for_by_the_transposed_matrix() -> None:
    net, boundaries = random_network(60, radiation=True)
    places = [at("power", net.name[i]) for i in net.free[:10]]
    small = linear(net, boundaries, places)
    rows = np.array([40, 3, 17])
    whole, few = transfer(small, FREQUENCY), transfer(small, FREQUENCY, rows)
    assert np.abs(few / whole[:, rows] - 1.0).max() < 1e-11
    assert (static_gain(small, rows) == static_gain(small)[rows]).all()


def test_an_arithmetic_node_is_its_conductors_in_series() -> None:
    ends = [("B", "boundary", 0.0), ("N", "diffusive", 80.0)]
    through = network([*ends, ("J", "arithmetic", 0.0)], [("B", "J", 0.3, 0.0), ("J", "N", 0.6, 0.0)])
    direct = network(ends, [("B", "N", 0.15, 0.0), ("N", "B", 0.05, 0.0)])  # two in parallel, one the other way round
    one, other = (transfer(linear(net, {"B": 290.0}, [at("temperature", "B")]), FREQUENCY) for net in (through, direct))
    assert np.abs(one[:, 0, 0] / other[:, 0, 0] - 1.0).max() < 1e-14


def rod(n: int, frequency: np.ndarray) -> np.ndarray:
    """|Gain - formula| at the insulated end of a rod of `n` nodes, relative; 0.2 m of aluminium, driven at x = 0."""
    length, k, rho_c = 0.2, 167.0, 2.43e6
    dx = length / n
    names = [f"N{i:04d}" for i in range(n)]
    nodes = [("B", "boundary", 0.0), *((name, "diffusive", rho_c * dx) for name in names)]
    inner = [(a, b, k / dx, 0.0) for a, b in itertools.pairwise(names)]
    net = network(nodes, [("B", names[0], 2.0 * k / dx, 0.0), *inner])
    found = transfer(linear(net, {"B": 293.0}, [at("temperature", "B")]), frequency)[:, :, 0]
    q = np.sqrt(2j * np.pi * frequency * rho_c / k)[:, None]
    x = (np.arange(n) + 0.5) * dx
    return np.abs(found - np.cosh(q * (length - x)) / np.cosh(q * length)).max(axis=1)


def test_a_rod_converges_to_the_solution_with_the_square_of_its_nodes() -> None:
    frequency = np.array([1e-4, 1e-3, 1e-2])
    errors = np.array([rod(n, frequency) for n in (20, 40, 80, 160)])
    order = np.log2(errors[:-1] / errors[1:])
    assert errors[-1].max() < 2e-4
    assert order[-1] == pytest.approx(2.0, abs=0.03)


def test_where_a_disturbance_cannot_act() -> None:
    net, boundaries = random_network(5, radiation=False)
    for place, fact, hint in (
        (at("temperature", "N0"), "'N0' is diffusive", "make the node a boundary"),
        (at("power", "B0"), "'B0' is a boundary", 'kind = "temperature"'),
        (at("power", "n0"), "no node is called 'n0'", "there is 'N0', whose case differs"),
        (at("power", "zebra"), "no node is called 'zebra'", ""),
    ):
        with pytest.raises(InputError, match=fact) as refused:
            linear(net, boundaries, [place])
        assert hint in refused.value.hint
