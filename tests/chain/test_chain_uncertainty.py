"""Uncertainty of verdicts on the small sample: rows against solutions and fields anew, its file, and refusals."""

from __future__ import annotations

import json
import shutil
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from offset_mass import changed_small

from benchmarks.uncertainty import TABLES, Materials

sys.path.append(str(Path(__file__).parents[1] / "borders"))

from border_tools import Outcome, edited, tedm

from tedm_cli.chain.graph import chain_of
from tedm_cli.config.cases import load_cases
from tedm_cli.config.model.file import load_model
from tedm_cli.config.project import Project, load_project
from tedm_cli.config.uncertainty import MeshDeviation
from tedm_cli.contracts import CASE, SENSITIVITY, UNIT_LOADS
from tedm_cli.errors import ConfigError, InputError
from tedm_cli.files.store import open_checked
from tedm_cli.progress import silent
from tedm_cli.results.adjoint.derivatives import Derivatives
from tedm_cli.results.cases.file import read_case
from tedm_cli.results.cases.noise import CaseNoise
from tedm_cli.stages.adjoint.build import build_adjoint
from tedm_cli.stages.chain.project_files import chain_files
from tedm_cli.stages.gravity.sensitivity import build_sensitivity
from tedm_cli.stages.model.distortion import build_distortion
from tedm_cli.stages.model.ingest import ingest
from tedm_cli.stages.noise import other_mesh as mesh_room
from tedm_cli.stages.noise import uncertainty as room
from tedm_cli.stages.noise.case import CaseSetting, case_setting, run_cases
from tedm_cli.stages.optics.build import build_optics
from tedm_cli.stages.uncertain_files import build_folder_of
from tedm_cli.uncertainty.verdicts import CaseUncertainty

POSITION = """
[[uncertainty.test_mass]]
name = "TM1_place"
test_mass = "TM1"
axes = ["z"]
absolute_sigma_m = 1e-3
source = "-"
"""
DIFFERENCE = """
[[requirement]]
name = "lisa_acceleration_differential"
outputs = ["TM1_a_x-TM2_a_x"]
applies_to = "differential"
"""


@pytest.fixture(scope="module")
def built(tmp_path_factory: pytest.TempPathFactory) -> Project:
    """The small sample with uncertain materials and a position, up to case 3; not to be changed."""
    folder = tmp_path_factory.mktemp("uncertain")
    project = changed_small(folder, tables=TABLES + POSITION)
    cases = project.cases.read_text(encoding="utf-8") + DIFFERENCE
    (folder / "cases.toml").write_text(cases, encoding="utf-8")
    text = project.file.path.read_text(encoding="utf-8")
    text = text.replace(str(project.cases), "cases.toml")
    assert '"cases.toml"' in text
    project.file.path.write_text(text, encoding="utf-8")
    project = load_project(folder / "tedm.toml", folder / "build")
    ingest(project, None, silent)
    build_distortion(project, None, silent)
    build_sensitivity(project, None, silent)
    build_optics(project, None)
    build_adjoint(project, None, silent)
    run_cases(project, ["3"], None, silent)
    return project


@pytest.fixture(scope="module")
def setting(built: Project) -> CaseSetting:
    return case_setting(built, *load_cases(built.cases))


@pytest.fixture(scope="module")
def case(built: Project) -> CaseNoise:
    with open_checked(built.build_dir / "case03.h5", CASE) as file:
        return read_case(file)


def copied(project: Project, folder: Path) -> Project:
    """The project with its build folder, to be changed."""
    where = folder / "project"
    shutil.copytree(project.file.path.parent, where)
    return load_project(where / "tedm.toml", where / "build")


def command(project: Project, *args: object) -> Outcome:
    return tedm(*args, "-c", project.file.path, "-d", project.build_dir)


def changed(path: Path, old: str, new: str) -> None:
    text = path.read_text(encoding="utf-8")
    assert old in text
    path.write_text(text.replace(old, new, 1), encoding="utf-8")


def found_in(case: CaseNoise) -> CaseUncertainty:
    assert case.uncertainty is not None
    return case.uncertainty


def test_nominal_ratios_are_the_verdicts(case: CaseNoise, setting: CaseSetting) -> None:
    """In the file exactly; and by the quadratic form of the parameters, at their nominal values."""
    found = found_in(case)
    assert [(d.output, d.requirement, d.nominal) for d in found.verdicts] == [
        (j.output, j.requirement, j.ratio) for j in case.judged
    ]
    assert not found.left_out
    assert [item.name for item in found.parameters.items][-3:] == ["TM1_place_z", "level_outside", "level_inside"]
    assert setting.uncertain is not None
    still = replace(setting.uncertain.draws, samples=100)
    items = tuple(replace(item, deviation=0.0) for item in setting.uncertain.effects.parameters.items)
    parameters = replace(setting.uncertain.effects.parameters, items=items)
    one = setting.config.case("3")
    result = setting.run(setting.ready(one))
    exact = replace(setting.uncertain, draws=still, effects=replace(setting.uncertain.effects, parameters=parameters))
    for d in exact.of_case(result, setting.criteria).verdicts:
        assert d.quantile == pytest.approx(np.full(99, d.nominal), rel=1e-9)
        assert d.violated.probability == float(d.nominal > 1.0)


def test_the_file_says_what_was_found(built: Project, case: CaseNoise, setting: CaseSetting) -> None:
    one = setting.config.case("3")
    wanted = setting.uncertainty(setting.run(setting.ready(one)))
    found = found_in(case)
    assert wanted is not None
    assert found.parameters.items == wanted.parameters.items
    assert found.sources == wanted.sources
    assert (found.draws, found.any_violated, found.outputs) == (wanted.draws, wanted.any_violated, wanted.outputs)
    for d, w in zip(found.verdicts, wanted.verdicts, strict=True):
        assert (d.violated, d.violated_bare, d.mean, d.deviation) == (
            w.violated, w.violated_bare, w.mean, w.deviation,
        )  # fmt: skip
        for name in ("quantile", "share_first", "share_total"):
            np.testing.assert_array_equal(getattr(d, name), getattr(w, name))
    fibre = found.parameters.items[5]
    assert (fibre.name, fibre.distribution, fibre.deviation) == ("glass_fibre_modulus", "lognormal", 0.15)
    assert (fibre.measure, fibre.unit, fibre.of) == ("standard deviation", "1", "MAT1 6")


def test_differences_follow_their_terms(setting: CaseSetting) -> None:
    """Rows of changes as the outputs' own: by each parameter the difference of the two test masses."""
    assert setting.uncertain is not None
    labels, change = setting.all_outputs.labels, setting.uncertain.effects.change
    one, two, both = (labels.index(label) for label in ("TM1_a_x", "TM2_a_x", "TM1_a_x-TM2_a_x"))
    np.testing.assert_array_equal(change[:, both], change[:, one] - change[:, two])
    assert np.abs(change[:, both]).max(axis=1)[:8].all()


def test_rows_by_positions_are_those_of_moved_test_masses(built: Project, setting: CaseSetting, tmp_path: Path) -> None:
    """Of a project whose test mass is 0.4 mm to either side; other test masses and read-outs do not change."""
    assert setting.uncertain is not None
    effects = setting.uncertain.effects
    names = [item.name for item in effects.parameters.items]
    with open_checked(built.build_dir / "sensitivity.h5", SENSITIVITY) as file:
        nominal = file.array(SENSITIVITY.S)
    ends = []
    for shift in (-4e-4, 4e-4):
        moved = copied(built, tmp_path / f"{shift}")
        changed(moved.model, "position_m = [-0.188, 0.0, 0.0]", f"position_m = [-0.188, 0.0, {shift}]")
        changed(moved.model, POSITION, "")
        moved = load_project(moved.file.path, moved.build_dir)
        build_sensitivity(moved, None, silent)
        with open_checked(moved.build_dir / "sensitivity.h5", SENSITIVITY) as file:
            ends.append(file.array(SENSITIVITY.S))
            assert not file.has(SENSITIVITY.DS_DPOSITION), "there where positions are uncertain"
    wanted = (ends[1] - ends[0]) / 8e-4
    change = effects.change[names.index("TM1_place_z"), : len(nominal)]
    for rows in (slice(0, 3), slice(6, 9)):
        size = np.abs(wanted[rows]).max()
        assert np.abs(change[rows] - wanted[rows]).max() < 1e-2 * size, "the quadrature cuts elements of 30 mm anew"
        assert size > 3.0 * np.abs(nominal[rows]).max(), "per m: by a tenth of a metre it all changes"
    assert not change[3:6].any()
    assert not change[9:].any()


@pytest.mark.slow
def test_rows_by_materials_are_those_of_solutions_anew(built: Project) -> None:
    """Expansions exactly; all together at half a standard deviation to a few parts in a hundred of their change."""
    materials = Materials.of(built)
    items = materials.effects.parameters.items
    nominal = materials.linear_rows(np.zeros(len(items)))
    signs = np.array([1.0, -1.0, 1.0, 1.0, 1.0, -1.0, 1.0])
    draws = np.array([item.deviation for item in items]) * signs
    expansions = np.array([item.quantity == "expansion" for item in items])
    assert expansions.sum() == 3
    for x, digits in ((draws * expansions, 1e-4), (0.5 * draws, 0.06)):
        linear, solved = materials.linear_rows(x), materials.solved_rows(x)
        for part in (slice(6), slice(6, 12), [12, 15, 18, 21], [13, 14, 16, 17, 19, 20, 22, 23]):
            size = np.abs(solved[part] - nominal[part]).max()
            assert np.abs(linear[part] - solved[part]).max() < digits * size
            assert size > 0.003 * np.abs(nominal[part]).max()


def test_it_is_printed_and_shown(built: Project) -> None:
    out = command(built, "run-case", "3", "-o", built.build_dir / "again.h5").ok().out
    assert "uncertainty: 10 parameters, 10,000 draws, seed 1" in out
    assert "A_TM1_x, B_TM1_x" in out, "redundant read-outs share a row"
    assert "level_outside" in out
    again = built.build_dir / "again.h5"
    shown = tedm("show", again).ok().out
    assert "P(violated)" in shown.splitlines()[1]
    assert "by 10 uncertain parameters" in shown
    told = json.loads(tedm("show", again, "--json").ok().out)["uncertainty"]
    with open_checked(again, CASE) as file:
        chance = file.array(CASE.VIOLATED)[:, 0, 0]
    assert [v["violated"]["probability"] for v in told["verdicts"]] == chance.tolist()
    again.unlink()
    explained = command(built, "explain", "lpf_selfgravity_ltp").ok().out.splitlines()
    rows = [line.split() for line in explained if line.startswith("TM1_a_x")]
    assert rows[-1][:7] == ["TM1_a_x", "lpf_selfgravity_ltp", "3", "<", "0.0004", "<", "0.0004"], "as everywhere else"
    told = json.loads(command(built, "explain", "lpf_selfgravity_ltp", "--json").ok().out)
    assert '"violated": 0.0' in json.dumps(told), "numbers for programs"


def test_what_is_left_out_is_said(built: Project, tmp_path: Path) -> None:
    """Without an adjoint, or with its refusal: levels and positions alone, by the same draws as they would have."""
    project = copied(built, tmp_path)
    path = project.build_dir / "adjoint.h5"
    path.unlink()
    out = command(project, "run-case", "3").ok().out
    assert "left out of the uncertainty: zerodur_expansion, titanium_expansion" in out
    assert "tedm build-adjoint" in out
    with open_checked(project.build_dir / "case03.h5", CASE) as file:
        found = found_in(read_case(file))
    assert [item.quantity for item in found.parameters.items] == ["position", "level", "level"]
    assert len(found.left_out) == 1
    assert "left out" in tedm("show", project.build_dir / "case03.h5").ok().out
    changed(project.model, TABLES + POSITION, "")
    project = load_project(project.file.path, project.build_dir)
    build_sensitivity(project, None, silent)
    assert "left out" not in command(project, "run-case", "3").ok().out


def test_a_stale_adjoint_is_refused(built: Project, tmp_path: Path) -> None:
    project = copied(built, tmp_path)
    changed(project.model, "relative_sigma = 0.02", "relative_sigma = 0.03")
    project = load_project(project.file.path, project.build_dir)
    build_sensitivity(project, None, silent)
    before = (project.build_dir / "case03.h5").read_bytes()
    refused = command(project, "run-case", "3")
    refused.refused(4, "adjoint.h5: is stale", hint="tedm build-adjoint")
    assert (project.build_dir / "case03.h5").read_bytes() == before


def test_the_chain_has_the_adjoint_before_its_cases(built: Project, small: Project) -> None:
    """Where materials are uncertain; elsewhere cases do not wait for it."""
    for project, waits in ((built, True), (small, False)):
        steps = chain_of(chain_files(project))
        case_step = next(step for step in steps if step.words == "run-case 3")
        assert (project.build_dir / "adjoint.h5" in case_step.inputs) is waits
        made = [step.stage for step in steps]
        assert made.index("build-adjoint") < made.index("run-case")


@pytest.mark.parametrize(
    ("old", "new", "facts"),
    [
        ("material = 6\n", "material = [6, 77]\n", ["uncertainty.material[2].material", "no material 77", "1, 2, 6"]),
        ("material = 6\n", 'property = "70:79"\n', ["uncertainty.material[2].property", "no property 70:79"]),
        (
            "material = 6\n",
            "material = 2\n",
            ["material 2 is uncertain already in uncertainty.material[1]"],
        ),
    ],
)
def test_what_the_deck_lacks_is_refused(built: Project, tmp_path: Path, old: str, new: str, facts: list[str]) -> None:
    """Against adjoint.h5, whose deck it is; here without its staleness, which would be told first."""
    model = load_model(built.model)[1]
    text = built.model.read_text(encoding="utf-8").replace(old, new, 1)
    path = tmp_path / "model.toml"
    path.write_text(text, encoding="utf-8")
    asked = load_model(path)[1]
    assert asked.uncertainty != model.uncertainty
    outputs = case_setting(built, *load_cases(built.cases)).all_outputs
    derivatives = room._derivatives(built, built.build_dir / "adjoint.h5", outputs)
    assert isinstance(derivatives, Derivatives)
    with pytest.raises(ConfigError) as caught:
        room._add_structure(room._Found(outputs), asked, derivatives, path)
    for fact in facts:
        assert fact in str(caught.value)
    nothing = replace(derivatives, expansion=np.array([2e-8, 0.0, np.nan]))
    with pytest.raises(ConfigError, match=r"material 2 has no expansion .* give absolute_sigma_per_K"):
        room._add_structure(room._Found(outputs), model, nothing, path)


def test_shells_and_properties_are_found_by_their_ids(built: Project, setting: CaseSetting, tmp_path: Path) -> None:
    """Of shells the sum over the properties that deviate together; of a property all materials that it names."""
    outputs = setting.all_outputs
    derivatives = room._derivatives(built, built.build_dir / "adjoint.h5", outputs)
    assert isinstance(derivatives, Derivatives)
    rng = np.random.default_rng(3)
    rates = rng.normal(size=(3, *derivatives.by_expansion.shape[1:]))
    with_shells = replace(derivatives, shell_id=np.array([4, 7, 11]), by_thickness=rates)
    tables = """
[[uncertainty.shell]]
name = "skins"
property = [4, "10:20"]
relative_half_width = 0.1
source = "-"
[[uncertainty.material]]
name = "frames"
property = 2
of = "density"
relative_sigma = 0.1
source = "-"
"""
    path = tmp_path / "model.toml"
    path.write_text(built.model.read_text(encoding="utf-8").replace(TABLES + POSITION, tables), encoding="utf-8")
    found = room._Found(outputs)
    room._add_structure(found, load_model(path)[1], with_shells, path)
    frames, skins = found.items
    assert (skins.of, skins.distribution, skins.measure) == ("PSHELL 4, PSHELL 11", "uniform", "half width")
    row = outputs.labels.index("A_TM2_x")
    np.testing.assert_allclose(found.changes()[1, row], rates[0, row] + rates[2, row], rtol=1e-12)
    assert frames.of == "MAT1 2"
    np.testing.assert_array_equal(found.changes()[0, 0], derivatives.by_logarithm["density"][1, 0])


def test_names_are_unique_over_both_files(built: Project, tmp_path: Path) -> None:
    project = copied(built, tmp_path)
    changed(project.cases, 'name = "level_inside"', 'name = "titanium_modulus"')
    command(project, "run-case", "3").refused(
        3, "cases.toml", "'titanium_modulus' is the name of a parameter of the model"
    )
    changed(project.cases, 'name = "titanium_modulus"\nshield = ["inside"]', 'name = "i"\ngroups = ["panels"]')
    command(project, "run-case", "3").refused(3, "uncertainty.level[1].groups", "no thermal area has 'panels'")


def test_another_mesh_estimates_the_error(
    built: Project, setting: CaseSetting, case: CaseNoise, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Outputs of which the other mesh has 1.3 times as much: (1 - 1.3) / (2^2 - 1) is what this one lacks."""
    other = copied(built, tmp_path)
    read = mesh_room.outputs_in
    monkeypatch.setattr(mesh_room, "outputs_in", lambda *of: _scaled(read(*of), 1.3))
    table = MeshDeviation(other=str(other.file.path), refinement=2.0, order=2.0, sigma=0.5)
    found = case_setting(built, *load_cases(built.cases), compare=table)
    assert found.uncertain is not None
    assert found.uncertain.mesh is not None
    np.testing.assert_allclose(found.uncertain.mesh.estimate, -0.1 * setting.all_outputs.rows, rtol=1e-9, atol=1e-40)
    run_cases(built, ["3"], tmp_path / "case03.h5", silent, compare=table)
    with open_checked(tmp_path / "case03.h5", CASE) as file:
        sure = found_in(read_case(file))
    nominal = np.array([j.ratio for j in case.judged])
    assert sure.mesh is not None
    assert (sure.mesh.refinement, sure.mesh.order, sure.mesh.other) == (2.0, 2.0, str(other.build_dir))
    np.testing.assert_allclose(sure.mesh.extrapolated_ratio, 0.9 * nominal, rtol=1e-9)
    np.testing.assert_allclose(sure.mesh.other_ratio, 1.3 * nominal, rtol=1e-9)
    item = sure.parameters.items[-1]
    assert (item.name, item.quantity, item.deviation, item.distribution) == ("mesh", "mesh", 0.5, "normal")
    np.testing.assert_array_equal([d.nominal for d in sure.verdicts], nominal)


def test_another_mesh_is_named_by_its_project_or_its_build_folder(tmp_path: Path) -> None:
    """As everywhere: a project's results are in `build`, in its folder, which may have its files in `configs`."""
    flat, nested = tmp_path / "flat", tmp_path / "nested"
    for folder in (flat, nested / "configs"):
        folder.mkdir(parents=True)
        (folder / "tedm.toml").touch()
    for named in (flat, flat / "tedm.toml"):
        assert build_folder_of(named) == flat / "build"
    for named in (nested, nested / "configs", nested / "configs" / "tedm.toml"):
        assert build_folder_of(named) == nested / "build"
    assert build_folder_of(tmp_path / "results") == tmp_path / "results"


def _scaled(outputs, factor):
    return replace(outputs, rows=factor * outputs.rows)


def test_meshes_that_cannot_be_compared_are_refused(
    built: Project, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    command(built, "run-case", "3", "--compare-mesh", tmp_path, "-o", tmp_path / "x.h5").refused(4, "sensitivity.h5")
    same = command(built, "run-case", "3", "--compare-mesh", built.build_dir, "-o", tmp_path / "x.h5")
    same.refused(4, "as fine as each other, or nearly: ratio of element sizes 1", hint="by a tenth at least")
    read = mesh_room.outputs_in
    for change, fact in (
        (lambda o: replace(o, labels=("TM9_a_x", *o.labels[1:])), "different outputs: the other has no TM1_a_x"),
        (lambda o: replace(o, areas=_renamed(o.areas)), "different thermal areas: the other has no "),
    ):
        monkeypatch.setattr(mesh_room, "outputs_in", lambda *of, change=change: change(read(*of)))
        with pytest.raises(InputError, match=fact):
            case_setting(built, *load_cases(built.cases), compare=MeshDeviation(other=str(built.build_dir)))


def _renamed(areas):
    return replace(areas, name=np.array(["ELSEWHERE", *areas.name.tolist()[1:]]))


def test_sizes_of_elements_follow_from_their_numbers(built: Project, tmp_path: Path) -> None:
    """A quarter of the solids called bars: elements of the rest are larger by the cube root; else it has to be said."""
    other = copied(built, tmp_path)
    with edited(other.build_dir / "unit_loads.h5") as file:
        cards = file[UNIT_LOADS.ELEMENT_TYPE][()]
        solids = np.flatnonzero(np.char.startswith(cards.astype(str), "CHEXA"))
        cards[solids[: len(solids) // 4]] = b"CBAR"
        file[UNIT_LOADS.ELEMENT_TYPE][()] = cards
    kept = len(solids) - len(solids) // 4
    found = mesh_room._refinement(built.build_dir, other.build_dir)
    assert found == pytest.approx((len(solids) / kept) ** (1.0 / 3.0), rel=1e-12)
    assert mesh_room._refinement(other.build_dir, built.build_dir) == pytest.approx(1.0 / found, rel=1e-12)
    (other.build_dir / "unit_loads.h5").unlink()
    with pytest.raises(InputError) as caught:
        mesh_room._refinement(built.build_dir, other.build_dir)
    assert "refinement" in caught.value.hint


def test_a_file_that_contradicts_itself_is_refused(built: Project, tmp_path: Path) -> None:
    path = tmp_path / "case03.h5"
    shutil.copy(built.build_dir / "case03.h5", path)
    with edited(path) as file:
        file[CASE.UNCERTAIN_CORRELATION][0, 1] = file[CASE.UNCERTAIN_CORRELATION][1, 0] = 0.5
    with open_checked(path, CASE) as file, pytest.raises(InputError, match="/uncertainty/source/name are not those of"):
        read_case(file)
    with edited(path) as file:
        file[CASE.UNCERTAIN_CORRELATION][0, 1] = file[CASE.UNCERTAIN_CORRELATION][1, 0] = 1.5
    with open_checked(path, CASE) as file, pytest.raises(InputError, match="cannot be correlated so"):
        read_case(file)
