"""The published allocations add up as printed, and verdicts follow from them."""

import numpy as np
import pytest

from tedm_cli.gravity.requirements import AT_REST_UNITS, allocation, dc_quantities, judge_at_rest


@pytest.mark.parametrize(
    ("quantity", "lower", "upper"),
    [
        ("gamma_xx", -5e-7, 8e-7),
        ("a_x", -1.1e-9, 1.1e-9),
        ("a_y", -1.7e-9, 1.7e-9),
        ("a_z", -3.2e-9, 3.2e-9),
        ("omegadot_phi", -14e-9, 14e-9),
        ("omegadot_eta", -18e-9, 18e-9),
        ("omegadot_theta", -23e-9, 23e-9),
    ],
)
def test_subsystems_sum_to_the_printed_totals(quantity, lower, upper):
    assert allocation(quantity, "IS", "LTP", "S/C") == pytest.approx((lower, upper), rel=1e-12)


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
