"""The published allocations add up as printed, and verdicts follow from them."""

from typing import Any

import numpy as np
import pytest

from tedm_cli.gravity.requirements import AT_REST_UNITS, allocation, dc_quantities, judge_at_rest

SUBSYSTEMS = ("IS", "LTP", "S/C")
# Montemurro 2004, tables 4.2 to 4.4 as printed: IS, LTP, S/C and total, in units of the first number.
PUBLISHED: dict[str, tuple[Any, ...]] = {
    "gamma_xx": (1e-7, (-1, 2), (-2, 3), (-2, 3), (-5, 8)),
    "a_x": (1e-9, 0.35, 0.40, 0.35, 1.1),
    "a_y": (1e-9, 0.55, 0.60, 0.55, 1.7),
    "a_z": (1e-9, 1.1, 1.1, 1.0, 3.2),
    "omegadot_phi": (1e-9, 6.0, 4.0, 4.0, 14.0),
    "omegadot_eta": (1e-9, 8.0, 5.0, 5.0, 18.0),
    "omegadot_theta": (1e-9, 9.0, 7.0, 7.0, 23.0),
}


@pytest.mark.parametrize("quantity", AT_REST_UNITS)
def test_allocations_are_those_of_the_printed_tables(quantity):
    """Every entry, and the totals: contributions add linearly."""
    unit, *columns = PUBLISHED[quantity]
    for entry, subsystems in zip(columns, [*((name,) for name in SUBSYSTEMS), SUBSYSTEMS], strict=True):
        lower, upper = entry if isinstance(entry, tuple) else (-entry, entry)
        found = allocation(quantity, *subsystems)
        assert found == pytest.approx((unit * lower, unit * upper), rel=1e-12, abs=0), subsystems


@pytest.mark.parametrize("quantity", AT_REST_UNITS)
@pytest.mark.parametrize("side", [-1, 1])
def test_a_verdict_turns_at_the_limit(quantity, side):
    """Just inside and just outside, at either end, of the allocation of each part and of both together."""
    row, unit = list(AT_REST_UNITS).index(quantity), PUBLISHED[quantity][0]
    ends = []
    for entry in PUBLISHED[quantity][1:3]:
        lower, upper = entry if isinstance(entry, tuple) else (-entry, entry)
        ends.append(unit * (lower if side < 0 else upper))
    for share, passed in ((0.999, True), (1.001, False)):
        sensor, total = np.zeros(7), np.zeros(7)
        sensor[row], total[row] = share * ends[0], share * sum(ends)
        found = {v.subsystem: v for v in judge_at_rest("TM1", total, sensor) if v.quantity == quantity}
        assert {name: v.passed for name, v in found.items()} == dict.fromkeys(("IS", "LTP", "IS+LTP"), passed)
        for v in found.values():
            assert v.ratio == pytest.approx(share, rel=1e-9)


def test_ltp_share_of_the_force_along_x():
    """Eq. 7.3: 0.75e-9 m/s² for the whole LTP."""
    assert allocation("a_x", "IS", "LTP")[1] == pytest.approx(0.75e-9)


def test_quantities_are_in_the_order_of_their_names():
    gamma = np.diag([3.0, -1.0, -2.0])
    found = dict(zip(AT_REST_UNITS, dc_quantities([10.0, 11.0, 12.0], [20.0, 21.0, 22.0], gamma), strict=True))
    assert found == {
        "gamma_xx": 3.0,
        "a_x": 10.0,
        "a_y": 11.0,
        "a_z": 12.0,
        "omegadot_theta": 20.0,
        "omegadot_eta": 21.0,
        "omegadot_phi": 22.0,
    }


def test_verdicts_on_each_side_of_a_range():
    sensor = np.array([-1.5e-7, 0.35e-9, 0.0, -2.2e-9, 0.0, 0.0, 0.0])
    total = np.array([1.5e-7, 0.30e-9, 0.0, 0.0, 0.0, 0.0, 9.9e-9])
    found = {(v.quantity, v.subsystem): v for v in judge_at_rest("TM1", total, sensor)}
    assert len(found) == 21
    # the range of the stiffness is lopsided: -1..2 for IS, -2..3 for the rest
    assert found["gamma_xx", "IS"].ratio == pytest.approx(1.5)
    assert not found["gamma_xx", "IS"].passed
    assert found["gamma_xx", "LTP"].ratio == pytest.approx(1.0)
    assert found["gamma_xx", "IS+LTP"].ratio == pytest.approx(1.5 / 5.0)
    assert found["a_x", "IS"].passed
    assert found["a_x", "LTP"].value == pytest.approx(-0.05e-9)
    assert found["a_x", "LTP"].limit == -0.40e-9
    assert found["a_z", "IS"].ratio == pytest.approx(2.0)
    assert found["a_z", "IS+LTP"].passed
    assert found["omegadot_phi", "IS+LTP"].ratio == pytest.approx(0.99)


def test_without_a_known_sensor_only_the_sum_is_judged():
    verdicts = judge_at_rest("TM2", np.full(7, 1e-10), None)
    assert [v.subsystem for v in verdicts] == ["IS+LTP"] * 7
    assert {v.test_mass for v in verdicts} == {"TM2"}
