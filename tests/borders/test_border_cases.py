"""Cases from files, through the command line: what is stored, printed and refused."""

from __future__ import annotations

import json
from typing import Any

import h5py
import numpy as np
import pytest
from border_tools import Project, edited, replace, tedm, untouched

from tedm_cli.config.project import load_project
from tedm_cli.errors import ConfigError
from tedm_cli.noise import correlation
from tedm_cli.progress import silent
from tedm_cli.results.outputs import read_outputs
from tedm_cli.stages.noise.case import run_cases

MATRIX = "area,STRUT_1,STRUT_2,FLANGE_1\nSTRUT_2,{0},1,{0}\nSTRUT_1,1,{0},{0}\nFLANGE_1,{0},{0},1\n"
TABLE = "frequency_hz,amplitude\n1e-3,1e-14\n3e-2,1e-13\n"
ADDED = """
[[requirement]]
name = "budget"
table = "budget.csv"
quantity = "acceleration"
outputs = ["TM1_a_x-TM2_a_x"]
applies_to = "differential"

[[case]]
id = "own"
title = "Three areas by a matrix, one of them late"
matrix = "r.csv"
delays = [{ areas = ["STRUT_2"], delay_s = 300.0 }]
"""


def add_case(small: Project, coefficient: str) -> None:
    (small.folder / "r.csv").write_text(MATRIX.format(coefficient))
    (small.folder / "budget.csv").write_text(TABLE)
    cases = small.folder / "cases.toml"
    cases.write_text(cases.read_text() + ADDED)


def test_a_matrix_a_delay_and_a_difference_end_to_end(small: Project) -> None:
    add_case(small, "0.25")
    shown = small.run("run-case", "own", "-v").ok().out
    for piece in ("TM1_a_x-TM2_a_x", "sensitivity of the verdicts", "optical elements: ", "all together x"):
        assert piece in shown
    with h5py.File(small.build / "caseown.h5") as file:
        names = [n.decode() for n in file["/area/name"][:]]
        late, early, flange = (names.index(n) for n in ("STRUT_2", "STRUT_1", "FLANGE_1"))
        assert file["/correlation/delay"][late] == 300.0
        assert abs(file["/correlation/real"][late, early] - 0.25) < 1e-14
        f = file["/frequency"][:]
        level = file["/temperature/asd"][:][file["/temperature/spectrum"][:]]
        with h5py.File(small.build / "sensitivity.h5") as source:
            g = source["/S"][0] - source["/S"][3]
            assert [source["/row/label"][i].decode() for i in (0, 3)] == ["TM1_a_x", "TM2_a_x"]
        h = {i: g[i] * level[i] for i in (late, early, flange)}
        turn = np.cos(2 * np.pi * f * 300.0)
        expected = sum(v**2 for v in h.values()) + 0.5 * (
            h[early] * h[flange] + turn * h[late] * (h[early] + h[flange])
        )
        np.testing.assert_allclose(file["/psd/TM1_a_x-TM2_a_x"][:], expected, rtol=1e-9)
        assert file["/requirement/applies_to"][-1] == b"differential"
        for share in ("share", "band_share"):
            assert abs(file[f"/path/{share}/A_TM1_x"][:].sum() - 1.0) < 1e-9
        # The vectors that reach the maximum have the signs of the contributions.
        h_x = file["/contribution/amplitude/TM1_a_x"][:]
        np.testing.assert_array_equal(file["/extremal/maximum"][0][:, 0], np.sign(h_x))
    sensitivity = json.loads(small.run("run-case", "own", "--json").ok().out)[0]["sensitivity"]
    assert sensitivity[-1]["bound_ratio"]["minimum"] <= sensitivity[-1]["bound_ratio"]["maximum"]
    # The files of a case are inputs: a change makes it stale.
    (small.folder / "r.csv").write_text(MATRIX.format("0.5"))
    checked = tedm("check", "-d", small.build)
    assert "r.csv" in checked.out


def test_the_parts_by_optical_element_sum_to_the_read_out_noise(small: Project) -> None:
    outputs = read_outputs(load_project(small.folder / "tedm.toml", small.build))
    assert set(outputs.parts_of_read_outs) == {label for label in outputs.labels if label[:2] in ("A_", "B_")}
    for label, parts_of_read_outs in outputs.parts_of_read_outs.items():
        parts, whole = parts_of_read_outs.by_element, outputs.rows[outputs.labels.index(label)]
        assert len(parts) == len(parts_of_read_outs.names) == 24
        assert np.all(np.abs(parts.sum(axis=0) - whole) <= 1e-13 * np.abs(parts).sum(axis=0))


def test_distortion_alone_is_what_explain_calls_so(small: Project) -> None:
    """Uncorrelated areas of one level: its noise is the root of the sum of squares that `explain` prints."""
    small.run("run-case", "6").ok()
    explained = json.loads(small.run("explain", "TM1_x", "--json").ok().out)
    row = read_outputs(load_project(small.folder / "tedm.toml", small.build)).parts_of_read_outs["A_TM1_x"].distortion
    assert row is not None
    assert np.linalg.norm(row) == pytest.approx(explained["read_outs"][0]["distortion"]["size"], rel=1e-12, abs=0)
    with h5py.File(small.build / "case06.h5") as file:
        output = [v.decode() for v in file["/verdict/output"]]
        found = dict(zip(output, file["/verdict/distortion_ratio"][:], strict=True))
        level = file["/temperature/asd"][:, np.searchsorted(file["/frequency"][:], 3e-3)]
        active = file["/case/block"][:] >= 0
        amplitude = level[file["/temperature/spectrum"][:]][active]
    assert np.isnan(found["TM1_a_x"])
    noise = float(np.sqrt(np.sum((row[active] * amplitude) ** 2)))
    assert found["A_TM1_x"] == pytest.approx(2.0 * noise / 1e-12, rel=1e-9), "binds at 3 mHz, as steep spectra do"


def test_role_and_reason_are_printed_and_stored(small: Project) -> None:
    shown = small.run("run-case", "5").ok().out.splitlines()
    assert shown[0].startswith("case 5 (diagnostic): Struts and flanges only, correlated (")
    assert shown[1] == "Isolates what the mounting does when it moves as one."
    printed = json.loads(small.run("run-case", "2", "10", "--json").ok().out)
    assert [case["role"] for case in printed] == ["possible", "likely"]
    for case, name in zip(printed, ("case02.h5", "case10.h5"), strict=True):
        with h5py.File(small.build / name) as file:
            assert file["/case/role"][()].decode() == case["role"]
            assert file["/case/reason"][()].decode() == case["reason"] != ""
    # Matching ends where no further block brings relief, and its ratio falls until there.
    for verdict in printed[0]["sensitivity"]:
        matched = list(verdict["ratio_with_blocks_matched"].values())
        assert 2 <= len(verdict["matched_blocks"]) <= 10
        assert all(len(block) == 1 for block in verdict["matched_blocks"]), "areas stand alone in case 2"
        assert matched[0] == matched[1] > matched[2] >= matched[-1]


def test_an_impossible_matrix(small: Project) -> None:
    add_case(small, "-0.6")
    with untouched(small.build):
        small.run("run-case", "own").refused(
            5, "r.csv", "eigenvalue -0.2", "STRUT_1", "FLANGE_1", hint="multiply the entries off the diagonal by 0.8333"
        )


def test_a_case_that_does_not_fit_the_model_keeps_no_other_from_running(small: Project) -> None:
    """10b on a model without mirror symmetry: all other cases are there, then the refusal, as if it had been alone."""
    replace(small.folder / "cases.toml", 'partition = "mirror"', 'partition = "mirror", mirror_names = ["_A", "_B"]')
    ids = ["1", "2", "3", "4", "4b", "5", "6", "7", "8", "9", "10"]
    facts = ("cases.toml: case 10b: blocks[1]: without a mirror image", "STRUT_3", "change mirror_names, or delete the")
    small.run("run-case", "10b").refused(3, *facts)
    ran = small.run("run-case", "10b", *ids)
    ran.refused(3, *facts)
    assert [line.split()[1] for line in ran.out.splitlines() if line.startswith("case ")] == ids
    assert all((small.build / f"case{i:0>2}.h5").exists() for i in ids)
    assert not (small.build / "case10b.h5").exists()
    # What was asked for is printed for programs too, and a violation does not hide the refusal.
    ran = small.run("run-case", "3", "10b", "--json", "--fail-on-violation")
    ran.refused(3, *facts)
    assert [case["case"] for case in json.loads(ran.out)] == ["3"]


def test_several_cases_that_do_not_fit_are_refused_together(small: Project) -> None:
    add_case(small, "-0.6")
    cases = small.folder / "cases.toml"
    replace(cases, 'groups = ["struts", "flanges"] }, { groups = ["IS1"]', 'groups = ["strut"] }, { groups = ["IS1"]')
    replace(cases, 'partition = "mirror"', 'partition = "mirror", mirror_names = ["_A", "_B"]')
    facts = ("case 4: blocks[0].groups: no thermal area has 'strut'", "case 10b: blocks[1]: without a mirror image")
    small.run("run-case", "4", "10b", "3").refused(3, *facts)
    assert (small.build / "case03.h5").exists()
    small.run("run-case", "own", "4").refused(5, "r.csv", "eigenvalue", hint="refused too: case 4")
    small.run("run-case", "own", "4").refused(5, "r.csv", hint="no thermal area has 'strut'")


def test_all_problems_of_all_cases_are_told_before_the_first_is_run(small: Project) -> None:
    cases = small.folder / "cases.toml"
    replace(cases, 'groups = ["struts", "flanges"] }, { groups = ["IS1"]', 'groups = ["strut"] }, { groups = ["IS1"]')
    replace(cases, 'partition = "mirror"', 'partition = "mirror", mirror_names = ["_A", "_B"]')
    happened: list[str] = []
    with pytest.raises(ConfigError) as caught:
        run_cases(
            load_project(small.folder / "tedm.toml", small.build),
            ["3", "4", "1", "10b"],
            None,
            silent,
            lambda one: happened.append(one.path.name),
            lambda error: happened.append(str(error)),
        )
    told, *files = happened
    assert files == ["case03.h5", "case01.h5"]
    assert told == str(caught.value)
    assert "case 4: blocks[0].groups: no thermal area has 'strut'" in told
    assert "case 10b: blocks[1]: without a mirror image" in told
    lines = small.run("run-case", "3", "4", "10b").err.splitlines()
    assert len(lines) == len(set(lines)), "each problem once"


def test_the_correlation_of_a_case_is_found_once(small: Project, monkeypatch: pytest.MonkeyPatch) -> None:
    """Its matrix may have thousands of areas, and its eigenvalues take the longest."""
    add_case(small, "0.25")
    checked, check = [], correlation.check_correlation

    def counted(*args: Any, **more: Any) -> None:
        checked.append(1)
        check(*args, **more)

    monkeypatch.setattr(correlation, "check_correlation", counted)
    small.run("run-case", "own").ok()
    assert len(checked) == 1


def test_requirements_are_refused_before_any_case_is_run(small: Project) -> None:
    """They are the same for all: also where no case would run."""
    add_case(small, "-0.6")
    replace(small.folder / "cases.toml", '"A_TM2_x"', '"A_TM9_x"')
    with untouched(small.build):
        small.run("run-case", "own", "3").refused(3, "cases.toml", "requirement[", "there is no output 'A_TM9_x'")


def test_files_that_are_not_there(small: Project) -> None:
    add_case(small, "0.25")
    (small.folder / "r.csv").unlink()
    small.run("run-case", "own").refused(4, "r.csv", "cannot be read")
    small.run("run-case", "3").ok()  # another case does not need it
    (small.folder / "budget.csv").unlink()
    small.run("run-case", "3").refused(4, "budget.csv", "cannot be read")


def test_a_case_of_groups_that_are_not_there(small: Project) -> None:
    replace(small.folder / "cases.toml", 'groups = ["struts", "flanges"]', 'groups = ["struts", "flange"]')
    small.run("run-case", "4").refused(3, "cases.toml", "no thermal area has 'flange'; did you mean flanges?")


@pytest.mark.parametrize(
    ("name", "dataset", "labels"),
    [("sensitivity.h5", "/S", "/row/label"), ("optics.h5", "/N/A", "/label/read_out")],
)
@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_rows_that_are_not_finite(small: Project, name: str, dataset: str, labels: str, value: float) -> None:
    with edited(small.build / name) as file:
        file[dataset][1, 3] = value
        label = file[labels].asstr()[1]
    small.run("run-case", "3").refused(4, name, f"{dataset} is {value:g} in row {label}", hint="build the file again")
