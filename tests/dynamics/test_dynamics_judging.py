"""What would help: factors that just meet a requirement, of one group and of those that are needed together."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace

import h5py
import numpy as np
import pytest
from border_tools import Project

from tedm_cli.dynamics.budget import Budget
from tedm_cli.dynamics.judging import judge_outputs, judged_labels, needed_together
from tedm_cli.dynamics.signals import DISTURBANCES, OUTPUTS, kind, unit
from tedm_cli.dynamics.sources import NoiseSource, PowerLaw
from tedm_cli.errors import ConfigError
from tedm_cli.noise.requirements import AppliedRequirement, Requirement
from tedm_cli.results.wording import rounded_down


def highest(power: np.ndarray) -> float:
    return float(power.sum(axis=1).max())


def test_groups_needed_together_by_hand() -> None:
    found = needed_together(np.array([[3.0, 0.5, 0.1], [0.2, 2.0, 0.1]]))
    assert found.groups.tolist() == [True, True, False]
    assert found.factor == pytest.approx(np.sqrt(0.9 / 3.5))
    assert found.silenced == pytest.approx(np.sqrt(0.1))
    met = needed_together(np.array([[0.3, 0.5], [0.2, 0.1]]))
    assert not met.groups.any()
    assert np.isnan(met.factor)
    assert met.silenced == pytest.approx(np.sqrt(0.8))


def test_a_group_that_others_make_needless_is_dropped() -> None:
    """The first helps most, but is not enough; the two that are needed besides do without it."""
    assert needed_together(np.array([[0.6, 1.2, 0.0], [0.6, 0.0, 1.2]])).groups.tolist() == [False, True, True]


def test_the_factor_is_exact_and_no_group_can_be_left_out() -> None:
    rng = np.random.default_rng(0)
    sizes = set()
    for _ in range(300):
        power = 10.0 ** rng.uniform(-4.0, 0.6, (3, 5)) * (rng.uniform(size=(3, 5)) > 0.2)
        found = needed_together(power)
        if highest(power) <= 1.0:
            assert not found.groups.any()
            continue
        quieter = np.where(found.groups, found.factor**2, 1.0)
        assert highest(power * quieter) == pytest.approx(1.0, rel=1e-12)
        assert 0.0 <= found.factor < 1.0
        assert highest(power * ~found.groups) == pytest.approx(found.silenced**2, rel=1e-12)
        for g in np.flatnonzero(found.groups):
            others = found.groups & (np.arange(5) != g)
            assert highest(power * ~others) > 1.0
        sizes.add(int(found.groups.sum()))
    assert sizes >= {1, 2, 3}


def judged(part: np.ndarray, safety: float = 2.0):
    """One output with two groups of power `part` [3, 2] per Hz against 1 m/s²/√Hz from the second frequency on."""
    f = np.array([1e-3, 2e-3, 4e-3])
    limit = Requirement("one", "acceleration", "m s^-2", (2e-3, 4e-3), lambda x: np.where(x > 3e-3, 2.0, 1.0), "")
    sources = [NoiseSource(name, name, {"s_TM1_a_x": 1.0}, PowerLaw(1.0)) for name in ("a", "b")]
    zero = np.zeros((3, 1))
    found = Budget(
        ("TM1_a_x",), part.sum(axis=1)[:, None], part[:, None, :], zero, zero, zero, {"TM1_a_x": np.zeros((3, 4))}
    )
    (j,) = judge_outputs(found, sources, [(limit, "TM1_a_x")], f, safety)
    return j


def test_one_group_alone_inside_the_band() -> None:
    """By hand: limits on the power of 1/4 and 1 with the safety factor; the first frequency is outside the band."""
    j = judged(np.array([[90.0, 9.0], [0.5, 0.1], [0.8, 0.4]]))
    assert j.verdict.ratio == pytest.approx(2.0 * np.sqrt(0.6))
    np.testing.assert_allclose(j.share, [0.5 / 0.6, 0.1 / 0.6, 0.0])
    np.testing.assert_allclose(j.source_share, [0.5 / 0.6, 0.1 / 0.6])
    np.testing.assert_allclose(j.silenced, [np.sqrt(0.4), np.sqrt(2.0), np.sqrt(2.4)])
    # a: at 2 mHz (1/4 - 0.1) / 0.5, at 4 mHz (1 - 0.4) / 0.8; b cannot; the temperatures are not felt
    assert j.factor[0] == pytest.approx(np.sqrt(0.3))
    assert np.isnan(j.factor[1])
    assert j.together.groups.tolist() == [True, False, False]
    assert j.together.factor == pytest.approx(j.factor[0])
    assert np.isnan(j.incoherent)


def test_units_and_quantities_of_all_signals() -> None:
    """15 coordinates twice, 18 commands, accelerations of three bodies and two housings, three differential ones."""
    assert Counter(map(unit, OUTPUTS)) == {"m": 12, "rad": 18, "N": 9, "N m": 9, "m s^-2": 18, "rad s^-2": 9}
    assert Counter(map(unit, DISTURBANCES)) == {"N": 9, "N m": 9, "m": 6, "rad": 9, "m s^-2": 6, "rad s^-2": 6}
    assert [kind(name) for name in ("TM2_phi", "meas_TM1_x", "delta_g", "TM1_omegadot_y", "u_SC_Fz", "u_TM1_Lx")] == [
        "angle", "displacement", "acceleration", "angular_acceleration", "force", "torque",
    ]  # fmt: skip


def test_a_requirement_of_one_test_mass_does_not_judge_a_difference() -> None:
    f = np.array([2e-3, 4e-3])
    single = Requirement("one", "acceleration", "m s^-2", (2e-3, 4e-3), np.ones_like, "")
    difference = replace(single, applies_to="differential")
    assert judged_labels([AppliedRequirement(single, ("TM1_a_x",)), AppliedRequirement(difference, ("delta_g",))], f)
    for requirement, label in ((single, "delta_g"), (difference, "TM1_a_x"), (single, "TM1_x"), (single, "nothing")):
        with pytest.raises(ConfigError, match=label):
            judged_labels([AppliedRequirement(requirement, (label,))], f)


def test_a_requirement_that_is_met_needs_nothing() -> None:
    j = judged(np.array([[90.0, 9.0], [0.05, 0.1], [0.2, 0.4]]))
    assert j.verdict.passed
    assert not j.together.groups.any()
    assert j.factor[0] == pytest.approx(np.sqrt(3.0))


def test_what_the_file_says_of_groups_together(built: Project) -> None:
    """Quieter by the factor, the groups named meet every requirement of the sample just so."""
    with h5py.File(built.build / "simulation03.h5") as file:
        names = file["group/name"].asstr()[()]
        requirements = list(file["requirement/name"].asstr()[()])
        safety = file["case/safety_factor"][()]
        needed, factor = file["improvement/together"][()], file["improvement/together_factor"][()]
        passed = file["verdict/passed"][()]
        assert not passed.all()
        for v, output in enumerate(file["verdict/output"].asstr()[()]):
            limit = file["requirement/amplitude"][requirements.index(file["verdict/requirement"].asstr()[v])]
            if passed[v]:
                assert not needed[v].any()
                continue
            power = sum(
                file[f"contribution/{name}/{output}"][()] * (factor[v] ** 2 if needed[v, g] else 1.0)
                for g, name in enumerate(names)
            )
            assert np.nanmax(safety * np.sqrt(power) / limit) == pytest.approx(1.0, rel=1e-9), output


@pytest.mark.parametrize(
    ("factor", "text"),
    [
        (0.4199, "0.41"),
        (0.25, "0.25"),
        (0.0369, "0.036"),
        (0.998, "0.99"),
        (1.3e-4, "0.00013"),
        (0.0, "0"),
        (0.3, "0.3"),
    ],
)
def test_factors_are_rounded_so_that_they_suffice(factor: float, text: str) -> None:
    assert rounded_down(factor) == text
