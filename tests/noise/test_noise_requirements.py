import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tedm_cli.errors import ConfigError
from tedm_cli.noise.requirement_presets import PRESETS
from tedm_cli.noise.requirements import UNITS, frequency_grid, judge

LPF = [PRESETS["lpf_readout_item"].grid_hz]


@pytest.mark.parametrize(
    ("name", "frequency_hz", "value"),
    [
        ("lpf_acceleration", 1e-3, 3e-14 * 10 / 9),
        ("lpf_acceleration", 30e-3, 3e-14 * 101),
        ("lpf_selfgravity_ltp", 3e-3, 4.24e-15),
        ("lpf_selfgravity_ltp", 30e-3, 2.1412e-13),
        ("lpf_readout_item", 1e-3, 9e-12),
        ("lpf_readout_item", 3e-3, 1e-12),
        ("lpf_readout_item", 20e-3, 1e-12),
        ("lpf_readout", 1e-3, 9e-11),
        ("lpf_readout", 20e-3, 1e-11),
        ("lisa_acceleration", 0.4e-3, 3e-15 * np.sqrt(2 * (1 + 0.05**4))),
        ("lisa_acceleration", 8e-3, 3e-15 * np.sqrt((1 + 0.05**2) * 2)),
        ("lisa_acceleration", 1e-4, 1.23693e-14),
        ("lisa_oms", 2e-3, 15e-12 * np.sqrt(2)),
        ("lisa_oms", 1e-4, 6.0e-9),
        ("taiji_acceleration", 1e-4, 1.23693e-14),
        ("taiji_oms", 2e-3, 8e-12 * np.sqrt(2)),
        ("tianqin_acceleration", 1e-4, 1e-15 * np.sqrt(2)),
        ("tianqin_acceleration", 0.1, 1.0005e-15),
        ("tianqin_oms", 1e-4, 1e-12),
    ],
)
def test_presets_at_spot_frequencies(name, frequency_hz, value):
    assert PRESETS[name].amplitude(np.array([frequency_hz]))[0] == pytest.approx(value, rel=1e-5, abs=0)


def test_presets_are_what_they_say():
    assert {name: r.kind for name, r in PRESETS.items()} == {
        "lpf_acceleration": "acceleration",
        "lpf_selfgravity_ltp": "acceleration",
        "lpf_readout_item": "displacement",
        "lpf_readout": "displacement",
        "lisa_acceleration": "acceleration",
        "lisa_acceleration_differential": "acceleration",
        "lpf_jitter": "displacement",
        "lisa_oms": "displacement",
        "taiji_acceleration": "acceleration",
        "taiji_oms": "displacement",
        "tianqin_acceleration": "acceleration",
        "tianqin_oms": "displacement",
    }
    for name, requirement in PRESETS.items():
        assert requirement.name == name
        assert requirement.unit == UNITS[requirement.kind]
        assert requirement.band_hz == ((1e-3, 30e-3) if name.startswith("lpf") else (1e-4, 0.1))


def test_self_gravity_shares_add_up_to_the_allocation():
    """Table 4.1: inertial sensor 0.10, LTP and spacecraft equal, total 3.0e-15 in quadrature."""
    ltp = PRESETS["lpf_selfgravity_ltp"].amplitude(np.array([1e-9]))[0]
    assert np.sqrt(0.10e-15**2 + 2 * ltp**2) == pytest.approx(3.0e-15, rel=1e-3, abs=0)


@given(low=st.floats(1e-6, 9e-4), high=st.floats(0.031, 10.0), n=st.integers(2, 500), nudge=st.sampled_from([0, 1e-13]))
def test_grid_holds_every_edge_and_1_mhz_exactly(low, high, n, nudge):
    grid = frequency_grid(low, high, n, [(1e-3 * (1 + nudge), 3e-3, 30e-3)])
    assert {low, high, 1e-3, 3e-3, 30e-3} <= set(grid.tolist())
    gaps = np.diff(np.log(grid))
    assert np.all(gaps > 0)
    assert gaps.max() <= np.log(high / low) / (n - 1) * (1 + 1e-9)


def test_grid_does_not_repeat_what_the_logarithmic_grid_has_already():
    assert len(frequency_grid(1e-4, 0.1, 4, [(1e-3, 1e-2)])) == 4


def test_grid_refuses_a_band_it_does_not_reach():
    with pytest.raises(ConfigError, match=r"0.002 to 0.1 Hz does not hold the band 0.001 to 0.03 Hz"):
        frequency_grid(2e-3, 0.1, 100, LPF)
    with pytest.raises(ConfigError) as caught:
        frequency_grid(0.1, 0.01, 1)
    assert len(caught.value.problems) == 2


def test_noise_at_half_its_limit_is_just_allowed_by_a_factor_of_two():
    f = frequency_grid(1e-4, 0.1, 301, LPF)
    requirement = PRESETS["lpf_readout_item"]
    verdict = judge(requirement.amplitude(f) / 2, f, requirement, 2.0, kind="displacement", output="A_TM1_x")
    assert verdict.ratio == pytest.approx(1.0, rel=1e-15, abs=0)
    assert verdict.passed
    assert verdict.binding_hz == 1e-3  # all of the band ties: the lowest frequency is named
    assert (verdict.output, verdict.requirement) == ("A_TM1_x", "lpf_readout_item")
    parallel = requirement.amplitude(f) * 0.51
    parallel[f > 20e-3] *= 1 + 1e-15
    louder = judge(parallel, f, requirement, 2.0, kind="displacement")
    assert not louder.passed
    assert louder.binding_hz == 1e-3
    assert louder.margin == pytest.approx(1 / 1.02)


def test_white_noise_binds_at_the_kink_of_the_readout_limit():
    f = frequency_grid(1e-4, 0.1, 301, LPF)
    verdict = judge(np.full(len(f), 4e-13), f, PRESETS["lpf_readout_item"], 1.5, kind="displacement")
    assert verdict.binding_hz == 3e-3
    assert verdict.ratio == pytest.approx(0.6)
    assert verdict.margin == pytest.approx(5 / 3)
    assert (verdict.noise, verdict.limit, verdict.safety_factor) == (4e-13, 1e-12, 1.5)


def test_only_the_band_counts():
    f = frequency_grid(1e-4, 0.1, 301, LPF)
    asd = np.where((f < 1e-3) | (f > 30e-3), 1.0, 0.0)
    verdict = judge(asd, f, PRESETS["lpf_readout_item"], 2.0, kind="displacement")
    assert verdict.ratio == 0.0
    assert verdict.margin == np.inf
    asd[f == 30e-3] = 1e-12
    assert judge(asd, f, PRESETS["lpf_readout_item"], 2.0, kind="displacement").binding_hz == 30e-3


def test_judge_refuses_another_quantity_and_frequencies_without_the_band():
    f = frequency_grid(1e-4, 0.1, 301, LPF)
    with pytest.raises(ConfigError, match=r"limits displacement \(m\), not acceleration \(m s\^-2\)"):
        judge(np.ones(len(f)), f, PRESETS["lpf_readout_item"], 2.0, kind="acceleration")
    short = np.geomspace(1e-3, 20e-3, 50)
    with pytest.raises(ConfigError, match=r"band edge 0.03 Hz is not among the frequencies 0.001 to 0.02 Hz"):
        judge(np.ones(50), short, PRESETS["lpf_readout_item"], 2.0, kind="displacement")


@pytest.mark.parametrize(("quantity", "level"), [("oms", 8 / 15), ("acceleration", 1.0)])
def test_taiji_has_the_shapes_of_lisa(quantity, level):
    f = np.geomspace(1e-4, 0.1, 50)
    lisa = PRESETS[f"lisa_{quantity}"].amplitude(f)
    np.testing.assert_allclose(PRESETS[f"taiji_{quantity}"].amplitude(f), level * lisa, rtol=1e-14)


def test_what_was_chosen_and_not_found_is_in_the_source():
    chosen = {name for name, r in PRESETS.items() if "band chosen as LISA's" in r.source}
    assert chosen == {"taiji_acceleration", "taiji_oms", "tianqin_acceleration", "tianqin_oms"}
    assert "taken as white" in PRESETS["tianqin_oms"].source
    assert not any("{" in r.source for r in PRESETS.values())
