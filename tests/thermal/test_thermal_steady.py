"""Steady states of thermal networks: by hand, by their balance of heat, and where there is none."""

from __future__ import annotations

import numpy as np
import pytest
from thermal_models import at, given, linear, network, random_network, steady

from tedm_cli.errors import InputError, PhysicsError
from tedm_cli.thermal.linear import linearised, shares
from tedm_cli.thermal.network import STEFAN_BOLTZMANN
from tedm_cli.thermal.steady import steady_state
from tedm_cli.thermal.transfer import static_gain

RADIATOR = [("SPACE", "boundary", 0.0), ("PLATE", "diffusive", 100.0)]


@pytest.mark.parametrize("space_K", [0.0, 2.725, 290.0])
@pytest.mark.parametrize("power_W", [1e-9, 1.0, 1e6])
def test_a_radiator_has_the_temperature_of_its_power(space_K: float, power_W: float) -> None:
    found = steady(network(RADIATOR, [("PLATE", "SPACE", 0.0, 0.4)], {"PLATE": power_W}), {"SPACE": space_K})
    expected = (power_W / (STEFAN_BOLTZMANN * 0.4) + space_K**4) ** 0.25
    assert found.temperature_K[1] == pytest.approx(expected, rel=1e-13)


def test_a_chain_divides_a_difference_by_its_resistances() -> None:
    nodes = [("HOT", "boundary", 0.0), ("A", "diffusive", 1.0), ("J", "arithmetic", 0.0), ("COLD", "boundary", 0.0)]
    net = network(nodes, [("HOT", "A", 2.0, 0.0), ("A", "J", 0.5, 0.0), ("J", "COLD", 1.0, 0.0)])
    found = steady(net, {"HOT": 300.0, "COLD": 265.0})
    assert found.temperature_K[1:3] == pytest.approx([295.0, 275.0], rel=1e-14)
    assert found.net_heat[[0, 3]] == pytest.approx([-10.0, 10.0], rel=1e-12)  # out of the hot one into the cold one


@pytest.mark.parametrize("radiation", [False, True])
def test_energy_is_in_balance(radiation: bool) -> None:
    """At every node that was solved for, and of the whole: powers leave through the boundaries."""
    net, boundaries = random_network(60, radiation=radiation)
    found = steady(net, boundaries)
    gross = net.gross_heat(found.temperature_K)
    assert np.all(np.abs(found.net_heat[net.free]) <= 1e-14 * gross[net.free])
    assert found.net_heat[net.boundary].sum() == pytest.approx(net.power.sum(), rel=1e-10)
    assert found.imbalance < 1e-12
    low, high = found.temperature_K.min(), found.temperature_K.max()
    assert low >= 150.0
    assert high > 293.15  # there are powers


def test_without_powers_one_boundary_makes_all_as_warm_as_itself() -> None:
    net, _ = random_network(40, radiation=True)
    alone = network(
        [(n, "diffusive" if k == "boundary" and n != "B0" else k, 5.0 if k != "arithmetic" and n != "B0" else 0.0)
         for n, k in zip(net.name, net.kind, strict=True)],
        [(net.name[a], net.name[b], gl, gr)
         for a, b, gl, gr in zip(net.node_a, net.node_b, net.linear, net.radiative, strict=True)],
    )  # fmt: skip
    assert steady(alone, {"B0": 251.5}).temperature_K == pytest.approx(251.5, rel=1e-13)


def test_given_temperatures_are_kept_and_others_follow_them() -> None:
    net = network([*RADIATOR, ("BOX", "diffusive", 10.0)], [("PLATE", "SPACE", 0.0, 0.4), ("PLATE", "BOX", 1.0, 0.0)])
    wanted = np.array([3.0, 280.0, np.nan])
    found = steady_state(net, wanted, np.full(3, np.nan), where="here")
    assert found.temperature_K[:2].tolist() == [3.0, 280.0]
    assert found.temperature_K[2] == pytest.approx(280.0, rel=1e-14)
    assert found.solved.tolist() == [False, False, True]
    assert found.net_heat[1] == pytest.approx(-STEFAN_BOLTZMANN * 0.4 * (280.0**4 - 3.0**4), rel=1e-12)
    everything = steady_state(net, np.array([3.0, 280.0, 281.0]), np.full(3, np.nan), where="here")
    assert everything.iterations == 0
    assert everything.net_heat[2] == pytest.approx(-1.0)


def test_temperatures_to_begin_from_lead_to_the_same_state() -> None:
    net, boundaries = random_network(30, radiation=True)
    from_above = steady(net, boundaries).temperature_K
    read = given(net, boundaries)
    begun = read.given_K.copy()
    begun[net.free] = np.linspace(60.0, 900.0, len(net.free))
    read = type(read)(net, begun, read.start_K, read.place, "here").as_start()
    assert read.steady().temperature_K == pytest.approx(from_above, rel=1e-12)


def test_more_power_taken_than_can_come_has_no_steady_state() -> None:
    net = network(RADIATOR, [("PLATE", "SPACE", 0.0, 0.4)], {"PLATE": -200.0})
    with pytest.raises(PhysicsError, match=r"no steady state .* heat of node PLATE is out of balance") as refused:
        steady(net, {"SPACE": 290.0})
    assert "more power is taken" in refused.value.hint


def test_a_boundary_without_a_temperature_is_refused() -> None:
    with pytest.raises(InputError, match="boundary SPACE has no temperature"):
        steady(network(RADIATOR, [("PLATE", "SPACE", 1.0, 0.0)]), {})


@pytest.mark.parametrize("joint", [1e4, 1e8])
def test_a_strong_joint_is_solved_for(joint: float) -> None:
    nodes = [*RADIATOR, ("A", "diffusive", 1.0), ("C", "diffusive", 1.0)]
    conductors = [("PLATE", "SPACE", 0.0, 0.4), ("PLATE", "A", 1e-2, 0.0), ("A", "C", joint, 0.0)]
    net = network(nodes, conductors, {"C": 0.3})
    found = steady(net, {"SPACE": 3.0}).temperature_K
    assert found[2] - found[1] == pytest.approx(30.0, rel=1e-5)
    gain = static_gain(linear(net, {"SPACE": 3.0}, [at("power", "C")]))
    assert gain[1, 0] - gain[0, 0] == pytest.approx(100.0, rel=1e-5)


def test_gains_that_are_lost_in_rounding_are_refused() -> None:
    """A joint of 1e12 W/K, and a way to the boundary of 1e-3 W/K: 15 decades."""
    nodes = [*RADIATOR, ("A", "diffusive", 1.0), ("C", "diffusive", 1.0)]
    conductors = [("PLATE", "SPACE", 1.0, 0.0), ("PLATE", "A", 1e-3, 0.0), ("A", "C", 1e12, 0.0)]
    net = network(nodes, conductors, {"C": 0.3})
    found = steady(net, {"SPACE": 3.0}).temperature_K  # each step begins from the balance itself, and mends the last
    assert found == pytest.approx([3.0, 3.3, 303.3, 303.3], rel=1e-7)
    with pytest.raises(PhysicsError, match="lost in rounding") as refused:
        static_gain(linear(net, {"SPACE": 3.0}, [at("power", "C")]))
    assert "make one node" in refused.value.hint


def test_a_radiating_node_at_absolute_zero_has_no_gain() -> None:
    net = network(RADIATOR, [("PLATE", "SPACE", 0.0, 0.4)])
    cold = linearised(net, np.zeros(2), shares(net, [at("power", "PLATE")], where="here"))
    with pytest.raises(PhysicsError, match="at 0 K"):
        static_gain(cold)
