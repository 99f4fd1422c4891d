"""What is wrong with the file of a trade is told before anything runs; projects with keys of another value."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

import pytest
from border_tools import CONFIGS, SMALL
from hypothesis import given
from hypothesis import strategies as st
from trade_project import Bricks

from tedm_cli.config.base import Form
from tedm_cli.config.cases import load_cases
from tedm_cli.config.dynamics.loop import load_dynamics
from tedm_cli.config.loads import load_loads
from tedm_cli.config.model.file import load_model
from tedm_cli.config.overlay import FILES, overlay
from tedm_cli.config.project import Project, load_project
from tedm_cli.config.reference import tables
from tedm_cli.config.trade import CriterionTable
from tedm_cli.errors import ConfigError
from tedm_cli.stages.trade import criteria as readers
from tedm_cli.trade.criteria import KINDS

ONE = '[[variant]]\nname = "base"\nproject = "bricks"\n'
NOISE = '[[criterion]]\nname = "noise"\nkind = "noise_ratio"\n'

WRONG = {
    "two of one name": (ONE + ONE.replace("base", "BASE"), NOISE, "variant[1].name: has the name of variant[0]"),
    "criteria of one name": (ONE, NOISE + NOISE, "criterion[1].name: has the name of criterion[0]"),
    "no variant": ("", NOISE, "variant: missing"),
    "no criterion": (ONE, "", "criterion: missing"),
    "name that is no folder": (ONE.replace("base", "../base"), NOISE, "variant[0].name: must be made of letters"),
    "no such project": (ONE.replace("bricks", "brick"), NOISE, "variant[0].project: names 'brick', but there is no"),
    "folder without project": (ONE.replace('"bricks"', '"."'), NOISE, "variant[0].project: names '.', but there is no"),
    "unknown key": (ONE + "sets = {}\n", NOISE, "variant[0].sets: unknown key; did you mean set?"),
    "unknown kind": (ONE, NOISE.replace("_ratio", "_ration"), "unknown kind 'noise_ration'; did you mean noise_ratio?"),
    "no kind at all": (ONE, NOISE.replace("noise_ratio", "xyz"), "unknown kind 'xyz'; there are noise_ratio, "),
    "key of another kind": (ONE, NOISE + 'subsystem = "IS"\n', "a criterion of the kind noise_ratio has no subsystem"),
    "noise of nothing": (ONE, NOISE.replace("_ratio", ""), "a criterion of the kind noise needs outputs"),
    "unknown quantity": (
        ONE,
        NOISE.replace("noise_ratio", "rest_ratio") + 'quantities = ["a_w"]\n',
        "criterion[0].quantities[0]: must be 'gamma_xx'",
    ),
    "unknown case": (ONE, NOISE + 'case = "11"\n', "criterion[0].case: no variant has a case '11'; did you mean 1?"),
    "unknown output": (
        ONE,
        NOISE + 'outputs = ["TM1_ax"]\n',
        "criterion[0].outputs: no variant has a judged output 'TM1_ax'; did you mean TM1_a_x?",
    ),
    "unknown requirement": (
        ONE,
        NOISE + 'requirement = "lpf_selfgravity"\n',
        "no variant has a requirement 'lpf_selfgravity'; did you mean lpf_selfgravity_ltp?",
    ),
    "negative weight": (ONE, NOISE + "weight = -1\n", "criterion[0].weight: weight -1 is outside 0 to"),
    "no file of a project": (
        ONE + 'set = { "case.safety_factor" = 1 }\n',
        NOISE,
        'variant[0].set."case.safety_factor": begins with no file of a project; did you mean cases?',
    ),
    "no such key": (
        ONE + 'set = { "cases.safety_factr" = 1 }\n',
        NOISE,
        'set."cases.safety_factr": unknown key; did you mean safety_factor?',
    ),
    "no such value": (
        ONE + 'set = { "cases.safety_factor" = -1 }\n',
        NOISE,
        'set."cases.safety_factor": safety factor -1 is outside',
    ),
    "no such entry": (
        ONE + 'set = { "model.test_mass.TM2.mass_kg" = 1 }\n',
        NOISE,
        "set.\"model.test_mass.TM2.mass_kg\": test_mass has no entry 'TM2'; did you mean TM1?",
    ),
    "through a number": (ONE + 'set = { "cases.frequency.points.a" = 1 }\n', NOISE, "frequency.points is no table"),
    "a file alone": (ONE + 'set = { "cases" = 1 }\n', NOISE, 'set."cases": names no key of it'),
    "no optics": (ONE + 'set = { "optics.element" = [] }\n', NOISE, 'set."optics": the project has no optics'),
    "two ways at once": (
        ONE + 'set = { "project.cases" = "cases.toml", "cases.safety_factor" = 1 }\n',
        NOISE,
        'set."project.cases": keys of the cases file are changed, too',
    ),
}


@pytest.mark.parametrize(("variants", "criteria", "fact"), WRONG.values(), ids=WRONG)
def test_bad_files(bricks: Bricks, variants: str, criteria: str, fact: str) -> None:
    bricks.write(variants, criteria).run().refused(3, fact)
    assert not (bricks.out / "trade.h5").exists()
    assert not list(bricks.out.rglob("*.h5"))


def test_all_problems_at_once(bricks: Bricks) -> None:
    text = ONE + 'set = { "cases.a" = 1, "model.b" = 2 }\n' + ONE.replace("bricks", "none").replace("base", "other")
    bricks.write(text, NOISE).run().refused(3, 'variant[0].set."cases.a"', 'variant[0].set."model.b"')
    outcome = bricks.run()
    assert "variant[1].project" in outcome.err
    assert len(outcome.err.splitlines()) == 3


def test_no_such_file(bricks: Bricks) -> None:
    bricks.file.unlink()
    bricks.run().refused(4, "variants.toml: cannot read", hint="name the file of the trade")


def test_every_kind_is_read_and_documented() -> None:
    assert set(readers._KINDS) == set(KINDS)
    page = (CONFIGS.parent / "docs" / "how-to" / "trade.md").read_text(encoding="utf-8")
    assert [kind for kind in KINDS if f"`{kind}`" not in page] == []
    keys = {key for kind in KINDS.values() for key in kind.keys}
    assert keys <= set(CriterionTable.model_fields)
    assert all(set(kind.needed) <= set(kind.keys) for kind in KINDS.values())


def test_verdicts_by_the_limit() -> None:
    def criterion(**keys: Any) -> CriterionTable:
        return CriterionTable(**({"name": "c", "kind": "noise_ratio"} | keys))

    assert [criterion().passes(v) for v in (0.9, 1.0, 1.1)] == [True, True, False]
    assert [criterion(limit=2.0).passes(v) for v in (2.0, 2.1)] == [True, False]
    assert criterion(kind="mass").passes(5.0) is None
    assert [criterion(kind="mass", goal="max", limit=5.0).passes(v) for v in (4.0, 5.0)] == [False, True]
    assert criterion(goal="max").passes(5.0) is None, "the limit of a kind is one for less"


# --- projects with other values ---


def written(base: Project, values: dict[str, Any], folder: Path) -> Project:
    for name, text in overlay(base, values, folder).texts.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(text, encoding="utf-8")
    return load_project(folder / "tedm.toml", base.build_dir)


@pytest.fixture
def small() -> Project:
    """The small sample where it is; its layout and its cases lie in another folder."""
    return load_project(SMALL / "tedm.toml", Path("build"))


def test_one_value_is_another_and_all_else_is_as_it_was(small: Project, tmp_path: Path) -> None:
    changed = written(small, {"cases.safety_factor": 1, "model.test_mass.TM2": {"mass_kg": 2.5}}, tmp_path / "a" / "b")
    before, after = load_cases(small.cases)[1], load_cases(changed.cases)[1]
    assert after.safety_factor == 1.0
    assert after.model_copy(update={"safety_factor": before.safety_factor}) == before
    model, other = load_model(small.model)[1], load_model(changed.model)[1]
    assert [t.mass_kg for t in other.test_mass] == [model.test_mass[0].mass_kg, 2.5]
    assert changed.title == small.title
    assert changed.optics is not None
    assert changed.optics.samefile(CONFIGS / "optics.toml"), "what is not changed is not copied"
    assert not (tmp_path / "a" / "b" / "optics.toml").exists()
    names = [changed.resolve(name) for name in (other.model.bdf, other.model.areas_csv, *other.model.op2) if name]
    assert [n.resolve() for n in names] == [
        SMALL / n for n in ("ltp_small.bdf", "ltp_small_areas.csv", "unit_loads.op2")
    ]


def test_names_in_the_build_folder_stay_there(tmp_path: Path) -> None:
    sample = load_project(CONFIGS / "tedm.toml", tmp_path / "build")
    changed = written(sample, {"model.model.uniform_label": "X", "dynamics.spacecraft.mass_kg": 500.0}, tmp_path / "c")
    model = load_model(changed.model)[1]
    assert model.model.bdf == "{build_dir}/ltp.bdf"
    assert changed.resolve(model.model.bdf) == tmp_path / "build" / "ltp.bdf"
    assert load_dynamics(changed.dynamics)[1].spacecraft.mass_kg == 500.0
    assert changed.thermal is not None
    assert changed.thermal.samefile(CONFIGS / "thermal.toml")
    assert changed.balance is not None
    assert changed.balance.samefile(CONFIGS / "balance.toml")
    own = written(sample, {"loads.foot.FOOT.motions": ["uz"]}, tmp_path / "d").loads
    assert own is not None
    assert load_loads(own)[1].foot[0].motions == ["uz"]


def test_a_file_that_the_project_does_not_have_and_needs_not(tmp_path: Path, small: Project) -> None:
    assert small.dynamics is None
    changed = written(small, {"dynamics.spacecraft.mass_kg": 500.0}, tmp_path)
    assert load_dynamics(changed.dynamics)[1].spacecraft.mass_kg == 500.0


def test_other_files_of_the_project(tmp_path: Path, small: Project) -> None:
    changed = written(small, {"project.title": "other", "project.thermal": "thermal.toml"}, tmp_path)
    assert changed.title == "other"
    assert changed.thermal is not None
    assert changed.thermal.samefile(SMALL / "thermal.toml")
    with pytest.raises(ConfigError, match=r"project\.titel: unknown key; did you mean title"):
        overlay(small, {"project.titel": "x"}, tmp_path)


def test_a_file_that_is_broken_already_says_so_itself(tmp_path: Path) -> None:
    (tmp_path / "tedm.toml").write_text('title = "t"\n')
    (tmp_path / "model.toml").write_text("[model]\n")
    (tmp_path / "cases.toml").write_text("safety = 1\n")
    project = load_project(tmp_path / "tedm.toml", tmp_path)
    with pytest.raises(ConfigError) as caught:
        overlay(project, {"cases.safety_factor": 1.0}, tmp_path / "x")
    assert caught.value.where == str(tmp_path / "cases.toml")


def test_every_name_of_a_file_is_led_to_the_same_file(tmp_path: Path) -> None:
    """Of every key that holds names of files, in whichever table of whichever form."""
    from tedm_cli.config.overlay import _leading, _rebased

    found = 0
    for root in FILES.values():
        for table in tables(root):
            for name, field in table.model_fields.items():
                said = [*field.metadata, *_forms(field.annotation)]
                if not any(isinstance(part, Form) and part.words == "file name" for part in said):
                    continue
                found += 1
                is_list = "list" in str(field.annotation)
                value: Any = ["a/b.csv"] if is_list else "a/b.csv"
                moved = _rebased(
                    table, {field.alias or name: value}, _leading(tmp_path / "old", tmp_path / "n" / "new")
                )
                assert moved == {field.alias or name: ["../../old/a/b.csv"] if is_list else "../../old/a/b.csv"}, table
    assert found >= 20


def _forms(annotation: Any) -> list[Any]:
    found = list(getattr(annotation, "__metadata__", ()))
    for argument in getattr(annotation, "__args__", ()):
        found += _forms(argument)
    return found


def test_tables_within_tables_of_several_forms(tmp_path: Path, small: Project) -> None:
    """The spectra of temperatures are one of several tables; a table of theirs is in a list of overrides."""
    (tmp_path / "s.csv").write_text("frequency_hz,all\n1e-5,1e-4\n1.0,1e-4\n")
    text = (CONFIGS / "cases.toml").read_text(encoding="utf-8")
    override = '[[temperature.override]]\ngroups = ["OB"]\npreset = "table"\ntable = "s.csv"\n\n[frequency]'
    (tmp_path / "cases.toml").write_text(text.replace("[frequency]", override, 1), encoding="utf-8")
    project = load_project(SMALL / "tedm.toml", Path("build"))
    own = written(project, {"project.cases": str(tmp_path / "cases.toml")}, tmp_path / "x")
    changed = written(own, {"cases.safety_factor": 3.0}, tmp_path / "y" / "z")
    data = tomllib.loads(changed.cases.read_text(encoding="utf-8"))
    assert data["temperature"]["override"][0]["table"] == "../../s.csv"


@given(st.dictionaries(st.sampled_from(["safety_factor", "temperature.inside_K", "frequency.points"]), st.just(50)))
def test_dots_and_tables_are_the_same(values: dict[str, int]) -> None:
    from tedm_cli.config.overlay import _flat

    dotted = {f"cases.{key}": value for key, value in values.items()}
    nested: dict[str, Any] = {}
    for key, value in values.items():
        here = nested
        for part in (parts := key.split("."))[:-1]:
            here = here.setdefault(part, {})
        here[parts[-1]] = value
    assert sorted(_flat(dotted)) == sorted(_flat({"cases": nested} if nested else {}))
