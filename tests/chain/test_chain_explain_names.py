"""`tedm explain NAME` for every name that report and prints use, and what it says of the self-gravity."""

from __future__ import annotations

import json
import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from test_chain_explain import explained

from tedm_cli.cli.printing.as_json import plain
from tedm_cli.cli.printing.explained import told_dict, told_lines
from tedm_cli.config.project import Project
from tedm_cli.contracts import CASE, OPTICS, SENSITIVITY
from tedm_cli.errors import ConfigError, InputError, UsageError
from tedm_cli.files.store import open_checked
from tedm_cli.results.areas import read_areas
from tedm_cli.results.explained import Told, row_tables
from tedm_cli.stages.explain.name import Load, explain_name, known_names


def told(project: Project, name: str) -> Told:
    (found,) = explain_name(project, name, Load())
    assert isinstance(found, Told)
    return found


def table(found: Told, name: str) -> list[dict[str, object]]:
    rows = plain(told_dict(found, None))["tables"][name]
    assert isinstance(rows, list)
    return rows


def test_every_name_is_explained(small: Project) -> None:
    """Whatever the result files name is known, and something is said of each."""
    known = known_names(small)
    with open_checked(small.build_dir / "case03.h5", CASE) as case:
        named = [*case.strings("/output/label"), *case.strings("/area/name"), *case.strings("/area/group")]
        named += [*case.strings("/requirement/name"), *case.strings("/path/name")]
    with open_checked(small.build_dir / "sensitivity.h5", SENSITIVITY) as file:
        named += [*file.strings("/test_mass/name"), *file.strings("/dc_verdict/requirement")]
        named += [part for name in file.strings("/dc_verdict/subsystem") for part in name.split("+") if part != "all"]
    assert not set(named) - set(known)
    for name in [n for i, n in enumerate(dict.fromkeys(named)) if i % 7 == 0]:  # each sort is in a test of its own
        for one in explain_name(small, name, Load()):
            assert one.tables or one.facts if isinstance(one, Told) else one.read_outs


def test_an_output_of_the_self_gravity(small: Project) -> None:
    found = told(small, "TM2_omegadot_y")
    with open_checked(small.build_dir / "sensitivity.h5", SENSITIVITY) as file:
        row = file.array("/S")[file.strings("/row/label").index("TM2_omegadot_y")]
        names, sources = file.strings("/area/name"), file.strings("/source/name")
        at_rest = file.array("/dc/angular_acceleration")[1, :, 1]
        motion = file.strings("/label/tm_motion")
        stiffness = file.array("/stiffness/linearised")[file.strings("/label/tm_output").index("TM2_omegadot_y")]
    assert (found.sort, found.title) == ("output of the self-gravity", "angular acceleration of test mass 2 about y")
    areas = table(found, "areas")
    assert [a["area"] for a in areas[:5]] == [names[i] for i in np.argsort(-np.abs(row))[:5]]
    assert {str(a["area"]): a["value"] for a in areas} == pytest.approx(dict(zip(names, row.tolist(), strict=True)))
    assert sum(float(str(a["share"])) for a in areas) == pytest.approx(1.0)
    assert sum(float(str(g["sum"])) for g in table(found, "groups")) == pytest.approx(row.sum())
    assert {str(r["at_rest,_source"]): r["field"] for r in table(found, "at_rest")} == pytest.approx(
        dict(zip(sources, at_rest.tolist(), strict=True))
    )
    wanted = {m: v for m, v in zip(motion, stiffness.tolist(), strict=True) if v}
    assert {str(r["test_mass_moves"]): r["stiffness"] for r in table(found, "stiffness")} == pytest.approx(wanted)
    ((moving, share),) = ((r["what_moves"], r["share"]) for r in table(found, "moving"))
    assert (moving, share) == ("structure", pytest.approx(1.0))
    lines = told_lines(found, 2)
    assert f"size {np.linalg.norm(row):.3e} rad/s^2/K over {len(names)} areas" in "\n".join(lines)
    assert f"and {len(names) - 2} more (--top 0: all)" in lines


def test_differences(small: Project) -> None:
    """Of two outputs of one quantity, self-gravity or read-out, whether or not a requirement judges them."""
    with open_checked(small.build_dir / "sensitivity.h5", SENSITIVITY) as file:
        label, S = file.strings("/row/label"), file.array("/S")
        wanted = S[label.index("TM2_a_x")] - S[label.index("TM1_a_x")]
        at_rest = file.array("/dc/acceleration").sum(axis=1)
    found = told(small, "TM2_a_x-TM1_a_x")
    assert found.title == "acceleration of test mass 2 along x minus that of test mass 1"
    assert [abs(float(str(a["value"]))) for a in table(found, "areas")] == pytest.approx(sorted(np.abs(wanted))[::-1])
    assert f"at rest {at_rest[1, 0] - at_rest[0, 0]:.4e} m/s^2" in found.facts
    found = told(small, "A_TM2_x-A_TM1_x")
    with open_checked(small.build_dir / "optics.h5", OPTICS) as file:
        label, N = file.strings("/label/read_out"), file.array("/N/A")
    wanted = N[label.index("TM2_x")] - N[label.index("TM1_x")]
    assert sum(float(str(g["sum"])) for g in table(found, "groups")) == pytest.approx(wanted.sum())
    assert sum(float(str(e["share"])) for e in table(found, "elements")) == pytest.approx(1.0)
    for pair in ("TM1_a_x-TM1_omegadot_x", "A_TM1_x-TM1_a_x"):
        with pytest.raises(UsageError, match="is a difference of"):
            told(small, pair)


def test_a_requirement_says_what_it_judges(small: Project) -> None:
    found = told(small, "lpf_selfgravity_ltp")
    assert "judges TM1_a_x, TM2_a_x: acceleration of test masses 1 and 2 along x" in found.facts
    rows = table(found, "cases")
    assert [r["ratio"] for r in rows] == sorted((float(str(r["ratio"])) for r in rows), reverse=True)
    with open_checked(small.build_dir / "case03.h5", CASE) as case:
        pairs = zip(case.strings("/verdict/output"), case.array("/verdict/ratio").tolist(), strict=True)
        of_case = {output: ratio for output, ratio in pairs if output.startswith("TM")}
    assert {str(r["output"]): r["ratio"] for r in rows if r["case"] == "3"} == of_case
    assert told(small, "lpf").title == "LISA Pathfinder, static self-gravity"
    assert {r["field_of"] for r in table(told(small, "lpf"), "at_rest")} >= {"IS", "LTP"}
    assert all("IS" in str(r["field_of"]) for r in table(told(small, "IS"), "at_rest"))


def test_areas_groups_and_elements_say_what_they_do(small: Project) -> None:
    with open_checked(small.build_dir / "sensitivity.h5", SENSITIVITY) as file:
        areas, label, S = read_areas(file), file.strings("/row/label"), file.array("/S")
    name = str(areas.name[3])
    of_area = {str(r["output"]): r for r in table(told(small, name), "outputs")}
    row = S[label.index("TM1_a_x")]
    assert of_area["TM1_a_x"]["value"] == pytest.approx(row[3])
    assert of_area["TM1_a_x"]["rank"] == 1 + int((np.abs(row) > abs(row[3])).sum())
    assert of_area["TM1_a_x"]["share"] == pytest.approx(row[3] ** 2 / (row @ row))
    assert {"A_TM1_x", "B_TM2_eta"} <= of_area.keys()
    group = str(areas.group[3])
    own = areas.group == group
    of_group = {str(r["output"]): r for r in table(told(small, group), "outputs")}
    assert of_group["TM1_a_x"]["sum"] == pytest.approx(row[own].sum())
    total: dict[str, float] = {}
    with open_checked(small.build_dir / "optics.h5", OPTICS) as file:
        elements = [n for n in dict.fromkeys(x.rpartition("_")[0] for x in file.strings("/label/element_dof"))]
    for element in elements:
        found = told(small, element)
        for r in table(found, "read_outs") if found.sort == "optical element" and found.tables else []:
            total[str(r["output"])] = total.get(str(r["output"]), 0.0) + float(str(r["share"]))
    # Test masses, which do not grow here, carry nothing of their own: the others make up all of it.
    assert total == pytest.approx(dict.fromkeys(total, 1.0))
    assert len(total) == 12
    assert {r["output"] for r in table(told(small, "TM1"), "outputs")} >= {"TM1_a_x", "A_TM1_eta"}


def test_what_cancels_is_nought() -> None:
    """A sum of rounding is printed as 0."""
    from tedm_cli.noise.areas import AreaTable

    one = np.array(["a", "b", "c"])
    areas = AreaTable(one, np.array(["g"] * 3), np.array(["inside"] * 3), np.array(["mid"] * 3))
    groups = row_tables(np.array([0.1, 0.2, -0.3]), "m", areas)[1]
    assert groups.rows[0][2] == 0.0


def test_one_half_is_enough(small: Project, tmp_path: Path) -> None:
    """Either file alone says what is in it, and of what is not there which command makes it."""
    for kept, name, lost, gone in (
        ("sensitivity.h5", "TM1_a_x", "TM2_eta", "optics.h5"),
        ("optics.h5", "A_TM2_eta", "TM1_omegadot_x", "sensitivity.h5"),
    ):
        folder = tmp_path / kept
        folder.mkdir()
        shutil.copy(small.build_dir / kept, folder)
        project = replace(small, build_dir=folder)
        assert explain_name(project, name, Load())
        assert explain_name(project, None, Load())
        assert explain_name(project, "IS1_EH_UP", Load())
        with pytest.raises(UsageError, match=f"nothing is called '{lost}'") as caught:
            explain_name(project, lost, Load())
        assert f"{gone} is not there, and may have it" in caught.value.hint
    alone = replace(small, optics=None)
    for name in ("TM1_x", "B_TM2_eta"):
        with pytest.raises(ConfigError, match="the project has no optics"):
            explain_name(alone, name, Load())
    with pytest.raises(UsageError, match="nothing is called 'TM1_a_q'"):
        explain_name(alone, "TM1_a_q", Load())
    with pytest.raises(InputError, match="no such file"):
        explain_name(replace(small, build_dir=tmp_path / "empty"), "TM1_a_x", Load())


def test_names_that_there_are_not_and_options_that_do_not_fit(small: Project) -> None:
    with pytest.raises(UsageError, match="nothing is called 'tm1_a_q'") as caught:
        explain_name(small, "tm1_a_q", Load())
    assert "TM1_a_x" in caught.value.hint
    with pytest.raises(UsageError, match="--uniform is for read-outs"):
        explain_name(small, "TM1_a_x", Load(uniform=True))
    with pytest.raises(UsageError, match="A_TM1_x is of set A, and --set asks for B"):
        explain_name(small, "A_TM1_x", Load(set_name="B"))


def test_a_read_out_by_its_set(small: Project) -> None:
    found = json.loads(explained(small, "B_TM2_eta", "--json"))
    assert (found["set"], [r["label"] for r in found["read_outs"]]) == ("B", ["TM2_eta"])
    everything = json.loads(explained(small, "--json", "--top", "1"))
    assert [e.get("name", "read-outs") for e in everything][:2] == ["read-outs", "TM1_a_x"]
    assert len(everything) == 13


def test_changed_configuration_is_told(small: Project, tmp_path: Path) -> None:
    model = tmp_path / "model.toml"
    model.write_text(small.model.read_text(encoding="utf-8") + "\n# changed\n", encoding="utf-8")
    with pytest.raises(InputError, match="is stale"):
        explain_name(replace(small, model=model), "TM1_a_x", Load())
