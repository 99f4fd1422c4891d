import numpy as np
import pytest

from tedm_cli.config.cases import load_cases
from tedm_cli.errors import ConfigError, InputError, UsageError
from tedm_cli.noise.temperature import ShapedSpectrum, WhiteSpectrum

ONE_CASE = '[[case]]\nid = 3\ntitle = "all"\nblocks = [{ areas = ["*"] }]\n'


def write(tmp_path, text):
    path = tmp_path / "cases.toml"
    path.write_text(text, encoding="utf-8")
    return path


def problems(tmp_path, text):
    with pytest.raises(ConfigError) as caught:
        load_cases(write(tmp_path, text))
    assert caught.value.where.endswith("cases.toml")
    return dict(caught.value.problems)


def test_shipped_file(config, areas):
    assert config.ids == ["1", "2", "3", "4", "4b", "5", "6", "7", "8", "9", "10", "10b", "T"]
    assert config.ids_of_areas == config.ids[:-1]
    assert all(table.reason for table in config.cases)
    roles = {role: [c.id for c in config.cases if c.role == role] for role in ("likely", "possible", "diagnostic")}
    assert roles == {
        "likely": ["3", "10"],
        "possible": ["1", "2", "4", "4b", "10b", "T"],
        "diagnostic": ["5", "6", "7", "8", "9"],
    }
    for table in config.cases:
        case = config.case(table.id)
        assert (case.role, case.reason) == (table.role, table.reason)
    assert config.safety_factor == 2.0
    assert {1e-3, 3e-3, 30e-3} <= set(config.frequency_hz().tolist())
    applied = {a.requirement.name: a.outputs for a in config.applied_requirements()}
    assert applied == {
        "lpf_selfgravity_ltp": ("TM1_a_x", "TM2_a_x"),
        "lpf_readout_item": ("A_TM1_x", "A_TM2_x", "B_TM1_x", "B_TM2_x"),
    }
    assert config.temperature.model(areas).shapes == (ShapedSpectrum(1.0, 1e-3, 1e-3, 2),)


def test_defaults_and_numeric_ids(tmp_path):
    file, config = load_cases(write(tmp_path, ONE_CASE))
    assert file.text == ONE_CASE
    assert config.ids == ["3"]
    assert config.case("3").title == "all"
    assert (config.case("3").role, config.case("3").reason) == ("possible", "")
    assert config.safety_factor == 2.0
    assert config.applied_requirements() == []


def test_roles_are_three(tmp_path):
    found = problems(tmp_path, ONE_CASE + 'role = "unlikely"\n')
    assert "'likely', 'possible' or 'diagnostic'" in found["case[0].role"]


def test_white_preset(tmp_path, areas):
    _, config = load_cases(write(tmp_path, '[temperature]\npreset = "white"\ninside_K = 5e-5\n' + ONE_CASE))
    model = config.temperature.model(areas)
    assert model.shapes == (WhiteSpectrum(1.0),)
    np.testing.assert_array_equal(model.scale, np.where(areas.shield == "outside", 1e-3, 5e-5))


@pytest.mark.parametrize(("asked", "near"), [("4c", "4"), ("case10", "10"), ("04b", "4b"), ("x", "")])
def test_unknown_case_lists_what_exists(config, asked, near):
    with pytest.raises(UsageError, match="1, 2, 3, 4, 4b, 5, 6, 7, 8, 9, 10, 10b") as caught:
        config.case(asked, where="cases.toml")
    assert caught.value.hint == (f"did you mean {near}?" if near else "")
    assert caught.value.where == "cases.toml"


def test_every_problem_of_a_file_at_once(tmp_path):
    found = problems(
        tmp_path,
        """
safety_factor = -1.0
[temperature]
corner_mhz = 1.0
order = "2"
[frequency]
min_hz = 0.1
max_hz = 0.01
[[case]]
id = "a b"
title = ""
blocks = [{ group = ["IS1"] }, {}, { side = ["left"] }, { areas = [] }, "all"]
[[case]]
id = true
title = "no blocks"
[[case]]
id = 5
title = "no blocks"
[[requirement]]
name = "lpf_selfgravity"
outputs = []
""",
    )
    expected = {
        "safety_factor": "safety factor -1 is outside",
        "temperature.corner_mhz": "unknown key; did you mean corner_hz?",
        "temperature.order": "valid number",
        "frequency": "min_hz 0.1 is not below max_hz 0.01",
        "case[0].id": "made of letters",
        "case[0].title": "at least 1 character",
        "case[0].blocks[0].group": "unknown key; did you mean groups?",
        "case[0].blocks[1]": 'areas = ["*"] for all',
        "case[0].blocks[2].side[0]": "'mid'",
        "case[0].blocks[3].areas": "at least 1 item",
        "case[0].blocks[4]": "must be a table (found 'all')",
        "case[1].id": "valid string",
        "case[2]": "give one of blocks, partition, matrix and thermal (found none)",
        "requirement[0].name": "did you mean lpf_selfgravity_ltp?",
        "requirement[0].outputs": "at least 1 item",
    }
    assert set(found) == set(expected)
    for path, fact in expected.items():
        assert fact in found[path], path


def test_every_problem_between_tables_at_once(tmp_path):
    found = problems(
        tmp_path,
        "[frequency]\nmin_hz = 1e-3\n"
        + ONE_CASE
        + ONE_CASE.replace("id = 3", 'id = "3"')
        + '[[requirement]]\nname = "lisa_oms"\noutputs = ["A_TM1_x"]\n'
        + '[[requirement]]\nname = "lpf_readout"\noutputs = ["A_TM1_x", "B_TM1_x", "A_TM1_x"]\n',
    )
    assert found == {
        "case[1].id": "'3' names the same case file as the id '3' of case[0]",
        "requirement[0].name": "its band 0.0001 to 0.1 Hz is outside [frequency] 0.001 to 0.1 Hz",
        "requirement[1].outputs[2]": "lpf_readout judges A_TM1_x already in requirement[1].outputs[0]",
    }


def test_a_filter_given_to_white_noise_is_refused(tmp_path):
    found = problems(tmp_path, '[temperature]\npreset = "white"\norder = 2\n' + ONE_CASE)
    assert "preset white has no low-pass filter, but order given" in found["temperature"]


def test_no_cases(tmp_path):
    assert problems(tmp_path, "safety_factor = 1.0\n") == {"case": "missing"}


def test_missing_file(tmp_path):
    with pytest.raises(InputError):
        load_cases(tmp_path / "absent.toml")
