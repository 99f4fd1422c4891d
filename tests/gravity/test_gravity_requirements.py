"""The published limits are those that are printed, entry by entry, and verdicts follow from them."""

import numpy as np
import pytest

from tedm_cli.gravity.requirement_presets import lpf_limits
from tedm_cli.gravity.requirements import (
    ALL,
    AT_REST_UNITS,
    AtRestLimit,
    axes_of,
    dc_quantities,
    judge_at_rest,
    narrowest,
)

MASSES = ("TM1", "TM2")
# Typed from Montemurro 2004, tables 4.2 to 4.4 and equations 4.7 to 4.12, with sums as printed in the column "Total".
PUBLISHED = [
    ("gamma_xx", "IS", -1e-7, 2e-7),
    ("gamma_xx", "LTP", -2e-7, 3e-7),
    ("gamma_xx", "S/C", -2e-7, 3e-7),
    ("gamma_xx", "IS+LTP+S/C", -5e-7, 8e-7),
    ("a_x", "IS", -0.35e-9, 0.35e-9),
    ("a_x", "LTP", -0.40e-9, 0.40e-9),
    ("a_x", "S/C", -0.35e-9, 0.35e-9),
    ("a_x", "IS+LTP+S/C", -1.1e-9, 1.1e-9),
    ("a_x", "all", -1.3e-9, 1.3e-9),
    ("a_y", "IS", -0.55e-9, 0.55e-9),
    ("a_y", "LTP", -0.60e-9, 0.60e-9),
    ("a_y", "S/C", -0.55e-9, 0.55e-9),
    ("a_y", "IS+LTP+S/C", -1.7e-9, 1.7e-9),
    ("a_y", "all", -2.2e-9, 2.2e-9),
    ("a_z", "IS", -1.1e-9, 1.1e-9),
    ("a_z", "LTP", -1.1e-9, 1.1e-9),
    ("a_z", "S/C", -1.0e-9, 1.0e-9),
    ("a_z", "IS+LTP+S/C", -3.2e-9, 3.2e-9),
    ("a_z", "all", -3.7e-9, 3.7e-9),
    ("omegadot_phi", "IS", -6.0e-9, 6.0e-9),
    ("omegadot_phi", "LTP", -4.0e-9, 4.0e-9),
    ("omegadot_phi", "S/C", -4.0e-9, 4.0e-9),
    ("omegadot_phi", "IS+LTP+S/C", -14.0e-9, 14.0e-9),
    ("omegadot_phi", "all", -16.0e-9, 16.0e-9),
    ("omegadot_eta", "IS", -8.0e-9, 8.0e-9),
    ("omegadot_eta", "LTP", -5.0e-9, 5.0e-9),
    ("omegadot_eta", "S/C", -5.0e-9, 5.0e-9),
    ("omegadot_eta", "IS+LTP+S/C", -18.0e-9, 18.0e-9),
    ("omegadot_eta", "all", -23.0e-9, 23.0e-9),
    ("omegadot_theta", "IS", -9.0e-9, 9.0e-9),
    ("omegadot_theta", "LTP", -7.0e-9, 7.0e-9),
    ("omegadot_theta", "S/C", -7.0e-9, 7.0e-9),
    ("omegadot_theta", "IS+LTP+S/C", -23.0e-9, 23.0e-9),
    ("omegadot_theta", "all", -27.0e-9, 27.0e-9),
]


def by_name(limits: list[AtRestLimit]) -> dict[tuple[str, str], AtRestLimit]:
    found = {(limit.quantity, "+".join(limit.subsystems) or ALL): limit for limit in limits}
    assert len(found) == len(limits)
    return found


@pytest.mark.parametrize(("quantity", "subsystem", "lower", "upper"), PUBLISHED)
def test_every_limit_is_the_printed_one(quantity: str, subsystem: str, lower: float, upper: float) -> None:
    limit = by_name(lpf_limits(("IS", "LTP", "S/C"), MASSES))[quantity, subsystem]
    assert (limit.lower, limit.upper) == pytest.approx((lower, upper), rel=1e-12, abs=0)
    assert limit.is_difference == (quantity != "gamma_xx"), "stiffness is of each test mass, the rest a difference"
    assert limit.test_masses == MASSES
    where = {"g": "table 4.2", "a": "table 4.3", "o": "table 4.4"}[quantity[0]]
    assert limit.source == f"Montemurro 2004, {'eq. 4.7 to 4.12' if subsystem == ALL else where}"


def test_there_are_no_other_limits() -> None:
    found = by_name(lpf_limits(("IS", "LTP", "S/C"), MASSES))
    assert set(found) == {(quantity, subsystem) for quantity, subsystem, *_ in PUBLISHED}


@pytest.mark.parametrize(
    ("known", "judged"),
    [
        (("IS", "LTP"), {"IS", "LTP", "IS+LTP", "all"}),
        (("LTP", "antenna", "IS"), {"IS", "LTP", "IS+LTP", "all"}),
        (("IS",), {"IS", "all"}),
        (("antenna",), {"all"}),
        ((), {"IS+LTP", "all"}),
    ],
)
def test_what_is_not_in_the_model_is_not_judged(known: tuple[str, ...], judged: set[str]) -> None:
    """The allocation of the spacecraft is left to it; a model of no subsystems is all of the LTP (eq. 7.3)."""
    found = by_name(lpf_limits(known, MASSES))
    assert {subsystem for _, subsystem in found} == judged
    if "IS+LTP" in judged:
        assert found["a_x", "IS+LTP"].upper == pytest.approx(0.75e-9, rel=1e-12)
        assert found["omegadot_phi", "IS+LTP"].upper == pytest.approx(1.0e-8, rel=1e-12)
        assert found["gamma_xx", "IS+LTP"].lower == pytest.approx(-3e-7, rel=1e-12)


def test_tables_on_each_test_mass_where_that_is_asked_for() -> None:
    found = by_name(lpf_limits(("IS", "LTP"), MASSES, is_difference=False))
    assert len(found) == 7 * 3
    assert not any(limit.is_difference for limit in found.values())


def field(**values: float) -> np.ndarray:
    return np.array([values.get(name, 0.0) for name in AT_REST_UNITS])


def limit(quantity: str, *subsystems: str, difference: bool = False, masses: tuple[str, ...] = MASSES) -> AtRestLimit:
    return AtRestLimit("own", quantity, subsystems, -1e-9, 2e-9, masses, difference, "here")


@pytest.mark.parametrize("quantity", AT_REST_UNITS)
@pytest.mark.parametrize("side", [-1, 1])
def test_a_verdict_turns_at_the_limit(quantity: str, side: int) -> None:
    """Just inside and just outside, at either end, of a part, of parts together, and of everything."""
    end = -1e-9 if side < 0 else 2e-9
    for share, passed in ((0.999, True), (1.001, False)):
        fields = {"TM1": {ALL: field(**{quantity: share * end}), "A": field(**{quantity: share * end}), "B": field()}}
        limits = [limit(quantity, *names, masses=("TM1",)) for names in ((), ("A",), ("A", "B"))]
        found = judge_at_rest(limits, fields)
        assert [v.subsystem for v in found] == [ALL, "A", "A+B"]
        assert [v.passed for v in found] == [passed] * 3
        assert [v.ratio for v in found] == pytest.approx([share] * 3, rel=1e-9)


def test_a_difference_is_the_second_minus_the_first() -> None:
    """Both pulled alike pass, however hard; both pulled together by half the limit are at it."""
    alike = {name: {ALL: field(a_z=-3.3e-9, a_x=sign * 1e-9)} for name, sign in zip(MASSES, (-1, 1), strict=True)}
    limits = [limit(q, difference=d) for q in ("a_z", "a_x") for d in (True, False)]
    found = {(v.quantity, v.place): v for v in judge_at_rest(limits, alike)}
    assert found["a_z", "TM2-TM1"].value == 0.0
    assert found["a_z", "TM1"].ratio == pytest.approx(3.3)
    assert found["a_x", "TM2-TM1"].value == pytest.approx(2e-9)
    assert found["a_x", "TM2-TM1"].ratio == pytest.approx(1.0)
    assert (found["a_x", "TM2-TM1"].test_mass, found["a_x", "TM2-TM1"].minus) == ("TM2", "TM1")
    turned = judge_at_rest([limit("a_x", difference=True, masses=("TM2", "TM1"))], alike)[0]
    assert turned.place == "TM1-TM2"
    assert turned.value == pytest.approx(-2e-9)


def test_parts_and_the_whole() -> None:
    """Parts together are their sum; all of them, where one is the rest, are everything in the model to the bit."""
    parts = {"A": field(a_y=0.1), "B": field(a_y=0.2), "rest": field(a_y=0.4)}
    fields = {"TM1": {ALL: field(a_y=0.7), **parts}}
    limits = [limit("a_y", *names, masses=("TM1",)) for names in (("A", "B"), ("A", "B", "rest"), ())]
    found = judge_at_rest(limits, fields, "rest")
    assert [v.whole for v in found] == [False, True, True]
    assert [v.value for v in found] == [pytest.approx(0.3), 0.7, 0.7]
    assert not judge_at_rest(limits[1:2], fields)[0].whole, "without a rest something may be in none of them"


def test_the_narrowest_limit_on_everything_in_the_model() -> None:
    all_of = narrowest(lpf_limits(("IS", "LTP"), MASSES), "TM1", ("IS", "LTP"), "LTP")
    found = dict(zip(AT_REST_UNITS, all_of, strict=True))
    assert found["gamma_xx"] == pytest.approx(3e-7), "the narrower side of -3 to 5"
    assert found["a_x"] == pytest.approx(0.75e-9), "IS and LTP together, narrower than eq. 4.7"
    assert found["omegadot_phi"] == pytest.approx(10e-9)
    assert np.isnan(found["gamma_xy"])
    parts = narrowest(lpf_limits(("IS", "LTP"), MASSES), "TM1", ("IS", "LTP", "antenna"), "antenna")
    assert parts[list(AT_REST_UNITS).index("a_x")] == pytest.approx(1.3e-9), "IS and LTP are not all of it"
    own = [limit("a_x", masses=("TM2",))]
    assert np.isnan(narrowest(own, "TM1")).all()
    assert narrowest(own, "TM2")[6] == 1e-9


def test_quantities_are_in_the_order_of_their_names() -> None:
    gamma = np.array([[3.0, 4.0, 5.0], [4.0, -1.0, 6.0], [5.0, 6.0, -2.0]])
    found = dict(zip(AT_REST_UNITS, dc_quantities([10.0, 11.0, 12.0], [20.0, 21.0, 22.0], gamma), strict=True))
    assert found == {
        "gamma_xx": 3.0, "gamma_xy": 4.0, "gamma_xz": 5.0, "gamma_yy": -1.0, "gamma_yz": 6.0, "gamma_zz": -2.0,
        "a_x": 10.0, "a_y": 11.0, "a_z": 12.0, "omegadot_theta": 20.0, "omegadot_eta": 21.0, "omegadot_phi": 22.0,
    }  # fmt: skip


def test_the_axes_that_a_quantity_is_told_along() -> None:
    assert [axes_of(q) for q in ("gamma_xx", "gamma_xz", "a_y", "omegadot_theta", "omegadot_eta", "omegadot_phi")] == [
        (0,), (0, 2), (1,), (0,), (1,), (2,)]  # fmt: skip
