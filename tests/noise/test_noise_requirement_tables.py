"""Requirements of the user's own, and differences of outputs."""

import numpy as np
import pytest

from tedm_cli.config.cases import load_cases
from tedm_cli.errors import ConfigError, InputError
from tedm_cli.noise.case_run import run_case
from tedm_cli.noise.outputs import Outputs
from tedm_cli.noise.requirement_presets import PRESETS
from tedm_cli.noise.requirements import AppliedRequirement, Criteria, frequency_grid, judge, tabulated

CASE = '[[case]]\nid = 1\ntitle = "all"\npartition = "all"\n'
LABELS = ("TM1_a_x", "TM2_a_x", "TM1_omegadot_x")
KINDS = ("acceleration", "acceleration", "angular_acceleration")


def test_straight_lines_in_log_log_are_power_laws():
    points = np.array([1e-4, 1e-3, 1e-1])
    table = tabulated("mine", "displacement", points, 1e-12 * np.array([100.0, 1.0, 1.0]))
    f = np.geomspace(1e-4, 1e-1, 31)
    np.testing.assert_allclose(table.amplitude(f), 1e-12 * np.maximum(1.0, (1e-3 / f) ** 2), rtol=1e-12)
    assert (table.band_hz, table.grid_hz, table.unit) == ((1e-4, 1e-1), (1e-4, 1e-3, 1e-1), "m")
    narrow = tabulated("mine", "displacement", points, np.ones(3), band_hz=(2e-4, 5e-4))
    assert narrow.grid_hz == (2e-4, 5e-4)


def test_a_table_of_a_preset_gives_the_verdict_of_the_preset():
    preset = PRESETS["lisa_acceleration"]
    points = np.geomspace(1e-4, 0.1, 2001)
    table = tabulated("copy", "acceleration", points, preset.amplitude(points))
    f = frequency_grid(1e-5, 1.0, 500, [preset.grid_hz, table.grid_hz])
    asd = 1e-15 / (1 + (f / 2e-3) ** 2) + 1e-16 * (f / 1e-2)
    own, copied = (judge(asd, f, q, 2.0, kind="acceleration") for q in (preset, table))
    assert copied.ratio == pytest.approx(own.ratio, rel=1e-6, abs=0)
    assert copied.binding_hz == own.binding_hz


@pytest.mark.parametrize(
    ("points", "amplitude", "band", "error", "piece"),
    [
        ([1e-3], [1.0], None, InputError, "1 point is no table"),
        ([1e-3, 1e-2, 5e-3], [1, 1, 1], None, InputError, "do not ascend: 0.005 Hz follows 0.01 Hz"),
        ([1e-3, 1e-2], [1.0, 0.0], None, InputError, "amplitude of point 2 is 0, not positive"),
        ([0.0, 1e-2], [1.0, 1.0], None, InputError, "frequency of point 1 is 0, not positive"),
        ([1e-3, 1e-2], [1, 1], (1e-4, 1e-2), ConfigError, "0.0001 to 0.01 Hz is outside the table, 0.001 to 0.01 Hz"),
    ],
)
def test_tables_that_are_refused(points, amplitude, band, error, piece):
    with pytest.raises(error, match=r"limits\.csv") as caught:
        tabulated("t", "angle", np.array(points), np.array(amplitude, dtype=float), band_hz=band, where="limits.csv")
    assert piece in str(caught.value)


def write(tmp_path, requirement, table="frequency_hz,amplitude\n1e-3,2e-12\n3e-2,1e-12\n"):
    (tmp_path / "limits.csv").write_text(table, encoding="utf-8")
    path = tmp_path / "cases.toml"
    path.write_text(CASE + "[[requirement]]\n" + requirement, encoding="utf-8")
    return path


OWN = 'name = "own"\ntable = "limits.csv"\nquantity = "displacement"\noutputs = ["A_TM1_x"]\n'


def test_a_table_beside_the_configuration(tmp_path):
    _, config = load_cases(write(tmp_path, OWN))
    (applied,) = config.applied_requirements()
    assert applied.requirement.amplitude(np.array([1e-3, 3e-2])).tolist() == pytest.approx(
        [2e-12, 1e-12], rel=1e-12, abs=0
    )
    assert applied.requirement.source == "table limits.csv"
    assert config.tables == [tmp_path / "limits.csv"]
    assert {1e-3, 3e-2} <= set(config.frequency_hz().tolist())


@pytest.mark.parametrize(
    ("requirement", "piece"),
    [
        (OWN.replace('"own"', '"lisa_oms"'), "lisa_oms is the name of a preset"),
        (OWN.replace('quantity = "displacement"\n', ""), "a table needs its quantity"),
        (OWN + "band_hz = [1e-2, 1e-3]\n", "0.01 to 0.001 does not increase"),
        (OWN + "band_hz = [1e-3, 1e-1]\n", "is outside the table"),
        (
            'name = "lisa_oms"\noutputs = ["A_TM1_x"]\nband_hz = [1e-3, 1e-2]\n',
            "of the preset lisa_oms cannot be changed",
        ),
        ('name = "lisa_osm"\noutputs = ["A_TM1_x"]\n', "did you mean lisa_oms?"),
        (OWN + "\n[frequency]\nmin_hz = 2e-3\n", "its band 0.001 to 0.03 Hz is outside [frequency] 0.002 to 0.1 Hz"),
    ],
)
def test_requirements_that_contradict_themselves(tmp_path, requirement, piece):
    with pytest.raises(ConfigError) as caught:
        load_cases(write(tmp_path, requirement))
    assert piece in str(caught.value)


@pytest.mark.parametrize(
    ("table", "piece"),
    [
        ("f,amplitude\n1,1\n", "limits.csv:1: must begin with the header frequency_hz,amplitude"),
        ("frequency_hz,amplitude\n1e-3,one\n", "limits.csv:2: amplitude must be a finite number"),
    ],
)
def test_a_table_that_cannot_be_read(tmp_path, table, piece):
    with pytest.raises(InputError) as caught:
        load_cases(write(tmp_path, OWN, table))
    assert piece in str(caught.value)


def applied(name, label, applies_to):
    requirement = tabulated(name, "acceleration", np.array([1e-3, 3e-2]), np.full(2, 1e-14), applies_to=applies_to)
    return AppliedRequirement(requirement, (label,))


def test_a_difference_is_coherent(areas, config):
    """Common noise cancels in it: S of g1 - g2 is not S1 + S2; in case 1 it is the square of the difference."""
    rng = np.random.default_rng(4)
    rows = rng.normal(size=(3, 78)) * 1e-13
    rows[1] = rows[0] + 0.01 * rows[1]
    requirements = [applied("single", "TM1_a_x", "single"), applied("both", "TM1_a_x-TM2_a_x", "differential")]
    outputs = Outputs(areas, rows, LABELS, KINDS).with_differences(requirements)
    assert (outputs.labels[3], outputs.kinds[3]) == ("TM1_a_x-TM2_a_x", "acceleration")
    np.testing.assert_array_equal(outputs.rows[3], rows[0] - rows[1])  # a time series has its sign
    f, model = config.frequency_hz(), config.temperature.model(areas)
    for case_id in ("1", "2", "4"):
        result = run_case(config.case(case_id), outputs, model, f, Criteria(tuple(requirements), 2.0))
        h = (rows[0] - rows[1])[:, None] * model.amplitudes(f)
        expected = sum(h[index].sum(axis=0) ** 2 for index in result.blocks)
        np.testing.assert_allclose(result.psd[3], expected, rtol=1e-9)
        assert np.all(result.psd[3] < 1e-2 * (result.psd[0] + result.psd[1]))
        assert [v.output for v in result.verdicts] == ["TM1_a_x", "TM1_a_x-TM2_a_x"]


def test_single_and_differential_are_not_mixed_up(areas, config):
    wrong = [
        applied("a", "TM1_a_x-TM2_a_x", "single"),
        applied("b", "TM1_a_x", "differential"),
        applied("c", "TM1_a_x-TM1_omegadot_x", "differential"),
    ]
    outputs = Outputs(areas, np.ones((3, 78)), LABELS, KINDS).with_differences(wrong)
    assert outputs.labels == (*LABELS, "TM1_a_x-TM2_a_x")
    with pytest.raises(ConfigError) as caught:
        run_case(
            config.case("1"), outputs, config.temperature.model(areas), config.frequency_hz(), Criteria(tuple(wrong))
        )
    facts = [fact for _, fact in caught.value.problems]
    assert "a is for single outputs; set applies_to = 'differential'" in facts[0]
    assert "b is for differential outputs; set applies_to = 'single'" in facts[1]
    assert "there is no output 'TM1_a_x-TM1_omegadot_x'" in facts[2]
