"""Results in several files: reduced one by one, wherever, and put together; against the chain on one machine."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import h5py
import numpy as np
import pytest
from border_tools import tedm
from parts_project import FILES, parts_project, rewritten
from shared_folder import shared

from tedm_cli.columns import Reduction, joined, reduced
from tedm_cli.config.project import Project, load_project
from tedm_cli.contracts import DISTORTION, UNIT_LOADS
from tedm_cli.distortion import RigidFit
from tedm_cli.errors import InputError, PhysicsError, UsageError
from tedm_cli.files.build_folder import partial_file_names
from tedm_cli.files.provenance import InputFile
from tedm_cli.files.store import open_checked
from tedm_cli.progress import silent
from tedm_cli.stages.chain.check import check_folder
from tedm_cli.stages.chain.make_rules import remember
from tedm_cli.stages.chain.plan import plan_chain
from tedm_cli.stages.chain.project_files import chain_files
from tedm_cli.stages.gravity.pulls import reduction_of
from tedm_cli.stages.gravity.sensitivity import GivenColumns, build_sensitivity
from tedm_cli.stages.model import merge as merging
from tedm_cli.stages.model.distortion import build_distortion
from tedm_cli.stages.model.ingest import ingest
from tedm_cli.stages.model.merge import MergeSummary, merge
from tedm_cli.stages.model.parts import build_part
from tedm_cli.stages.optics.build import build_optics

NAMES = ("unit_loads.h5", "distortion.h5", "sensitivity.h5")
KEPT_NOWHERE = {"/translation", "/rotation", "/D/translation", "/D/rotation"}


def merged(project: Project) -> MergeSummary:
    remember(chain_files(project).remembered())
    return merge(
        project,
        project,
        lambda found, parts: build_sensitivity(project, None, silent, GivenColumns(found, parts)),
        silent,
    )


def with_parts(folder: Path) -> Project:
    project = parts_project(folder)
    for name in FILES:
        build_part(project, folder / name, reduction_of, silent)
    return project


def project_in(folder: Path) -> Project:
    return load_project(folder / "tedm.toml", folder / "build")


@pytest.fixture(scope="module")
def parts(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A project with its eight parts. Not to be changed."""
    return shared(tmp_path_factory, "eight_parts", with_parts)


@pytest.fixture
def copy(parts: Path, tmp_path: Path) -> Project:
    shutil.copytree(parts, tmp_path / "p")
    return project_in(tmp_path / "p")


def values(path: Path) -> dict[str, np.ndarray]:
    """The numbers of a file by dataset, those that label its dimensions too."""
    found = {}
    with h5py.File(path) as file:
        file.visititems(lambda n, o: found.update({f"/{n}": o[()]}) if isinstance(o, h5py.Dataset) else None)
    return {name: data for name, data in found.items() if data.dtype.kind in "iuf"}


@pytest.fixture(scope="module")
def both(parts: Path, tmp_path_factory: pytest.TempPathFactory) -> tuple[Project, Project, MergeSummary]:
    """The merged project, and the same project whose chain was run on one machine; both with their optics."""
    folder = tmp_path_factory.mktemp("both")
    for name in ("merged", "serial"):
        shutil.copytree(parts, folder / name)
    one, two = project_in(folder / "merged"), project_in(folder / "serial")
    done = merged(one)
    for stage in (ingest, build_distortion, build_sensitivity):
        stage(two, None, silent)
    for project in (one, two):
        build_optics(project, None)
    return one, two, done


def test_parts_make_the_files_of_one_machine(both: tuple[Project, Project, MergeSummary]) -> None:
    """Every number to 1e-14 of the largest of its dataset: S_SG, its changes, tied masses, optics, checks, rest."""
    one, two, done = both
    assert (done.parts, done.unused, done.distortion.areas) == (8, [], 28)
    assert done.distortion.superposition is not None
    for name in (*NAMES, "optics.h5"):
        ours, wanted = values(one.build_dir / name), values(two.build_dir / name)
        absent = {path for path in set(wanted) - set(ours) if h5_has_units(two.build_dir / name, path)}
        assert absent <= KEPT_NOWHERE, name
        for path, data in ours.items():
            scale = np.nanmax(np.abs(wanted[path]), initial=0.0)
            np.testing.assert_allclose(data, wanted[path], rtol=0, atol=1e-14 * scale, err_msg=f"{name}{path}")
    assert np.abs(values(one.build_dir / NAMES[2])["/compensation/translation"][:, 0]).min() > 0.0
    assert np.abs(values(one.build_dir / NAMES[2])["/test_mass/dS_dposition"]).max() > 0.0


def h5_has_units(path: Path, name: str) -> bool:
    """Datasets of the contract, not the scales of dimensions."""
    with h5py.File(path) as file:
        return "units" in file[name].attrs and "CLASS" not in file[name].attrs


def test_the_chain_goes_on_from_there(both: tuple[Project, Project, MergeSummary]) -> None:
    """`tedm check` finds nothing, and `tedm run` begins behind the matrices; the results are known by their sums."""
    one, two, _ = both
    assert [c.path.name for c in check_folder(one.build_dir) if c.problems] == []
    assert {step.stage for step in plan_chain(one, "run-case").stale} == {"build-adjoint", "build-thermal", "run-case"}
    sums = [
        [i.sha256 for i in open_inputs(project.build_dir / "unit_loads.h5") if i.path.suffix == ".op2"]
        for project in (one, two)
    ]
    assert sums[0] == sums[1]
    assert len(sums[0]) == 8


def open_inputs(path: Path) -> tuple[InputFile, ...]:
    with open_checked(path, UNIT_LOADS) as file:
        return file.provenance().inputs


def test_what_needs_the_displacements_of_grids_says_so(both: tuple[Project, Project, MergeSummary]) -> None:
    one, _, _ = both
    with open_checked(one.build_dir / "distortion.h5", DISTORTION) as file:
        assert not file.has(DISTORTION.D_TRANSLATION)
    with pytest.raises(InputError, match=r"has no displacements of grids \(/D/translation\): its results were reduced"):
        build_sensitivity(one, None, silent)
    config = ["-c", one.file.path]
    for command in (["export-vtu", "-o", one.build_dir / "m.vtu"], ["build-adjoint", *config]):
        found = tedm(*command, "-d", one.build_dir)
        assert found.code == 4
        assert "has no displacements of grids (/" in found.err
        assert "`tedm ingest` and `tedm build-distortion` keep them" in found.err


def test_a_part_has_the_same_bytes_wherever_the_project_is(parts: Path, copy: Project) -> None:
    name = "partial_batch5.h5"
    (copy.build_dir / name).unlink()
    build_part(copy, copy.build_dir.parent / FILES[4], reduction_of, silent)
    assert (copy.build_dir / name).read_bytes() == (parts / "build" / name).read_bytes()


def test_a_missing_part_is_named_with_its_file_and_its_areas(copy: Project) -> None:
    for name in (1, 4):
        (copy.build_dir / f"partial_batch{name}.h5").unlink()
    (copy.build_dir.parent / FILES[0]).unlink()
    with pytest.raises(
        InputError,
        match=r"2 of 8 parts are missing: .*batch1.op2; partial_batch4.h5 of .*batch4.op2 \(with .*STRUT_8\)",
    ):
        merged(copy)
    assert not (copy.build_dir / "unit_loads.h5").exists()


def test_results_elsewhere_need_not_be_here(copy: Project) -> None:
    """On a machine without the OP2 files; their sums are those that the parts say."""
    shutil.rmtree(copy.build_dir.parent / "results")
    other = copy.build_dir.with_name("other")  # and written elsewhere
    found = tedm("merge", "-c", copy.file.path, "-d", copy.build_dir, "-o", other, "--json")
    assert json.loads(found.ok().out)["parts"] == 8
    assert sorted(path.name for path in other.iterdir()) == sorted(NAMES)
    assert not (copy.build_dir / "unit_loads.h5").exists()
    assert len([i for i in open_inputs(other / "unit_loads.h5") if i.path.suffix == ".op2"]) == 8


def test_a_part_of_another_model(copy: Project) -> None:
    """Another thickness: no number of the results would tell."""
    deck = copy.build_dir.parent / "unit_loads.bdf"
    text = deck.read_text()
    deck.write_text(text + "$ changed\n")
    build_part(copy, copy.build_dir.parent / FILES[2], reduction_of, silent)
    deck.write_text(text)
    found = tedm("merge", "-c", copy.file.path, "-d", copy.build_dir)
    assert found.code == 4
    assert "partial_batch3.h5: is of another model or configuration: its unit_loads.bdf is not that of" in found.err
    assert "hint: make it again with `tedm build-sensitivity --partial" in found.err


def test_a_part_of_another_configuration_or_of_older_results(copy: Project) -> None:
    folder = copy.build_dir.parent
    rewritten(folder / FILES[6], lambda number, label, motion: (number, label, 1.0000001 * motion))
    with pytest.raises(InputError, match=r"partial_batch7.h5: is stale: made from another version of .*batch7.op2"):
        merged(copy)
    model = folder / "model.toml"
    model.write_text(model.read_text().replace("mass_kg = 0.5", "mass_kg = 0.4"))
    with pytest.raises(InputError, match=r"partial_batch1.h5: is of another model or configuration: its model.toml is"):
        merged(copy)


def test_a_part_of_another_version(copy: Project, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(merging, "__version__", "9.9")
    with pytest.raises(InputError, match=r"partial_batch1.h5: was made by tedm .*, this is 9.9"):
        merged(copy)


def test_an_area_in_two_files_or_in_none(copy: Project) -> None:
    folder = copy.build_dir.parent
    rewritten(folder / FILES[1], lambda n, label, motion: (n, "STRUT_5" if label == "STRUT_6" else label, motion))
    build_part(copy, folder / FILES[1], reduction_of, silent)
    with pytest.raises(InputError, match=r"batch2.op2: area 'STRUT_5' was already in .*batch1.op2"):
        merged(copy)
    rewritten(folder / FILES[1], lambda n, label, motion: None if label == "STRUT_5" else (n, label, motion))
    build_part(copy, folder / FILES[1], reduction_of, silent)
    with pytest.raises(InputError, match=r"no displacements for 1 of 29 unit loads: 'STRUT_6' \(subcase \d+\)"):
        merged(copy)


def test_labels_that_changed_places_between_files(copy: Project) -> None:
    """Their sum is that of the right ones: the deck's numbers tell, over all files together."""
    folder, swap = copy.build_dir.parent, {"STRUT_5": "STRUT_6", "STRUT_6": "STRUT_5"}
    for name in FILES[:2]:
        rewritten(folder / name, lambda n, label, motion: (n, swap.get(label, label), motion))
        build_part(copy, folder / name, reduction_of, silent)
    with pytest.raises(InputError, match=r"is labelled 'STRUT_6', and 'STRUT_5' in the deck \(2 of 29 subcases\)"):
        merged(copy)


def test_superposition_is_judged_over_all_parts(copy: Project) -> None:
    folder = copy.build_dir.parent
    rewritten(folder / FILES[3], lambda n, label, motion: (n, label, motion * (1.001 if label == "STRUT_8" else 1.0)))
    build_part(copy, folder / FILES[3], reduction_of, silent)
    with pytest.raises(PhysicsError, match="do not add up to the uniform load"):
        merged(copy)


def test_what_is_no_result_file_of_the_project(copy: Project) -> None:
    folder = copy.build_dir.parent
    shutil.copy(folder / FILES[0], folder / "other.op2")
    with pytest.raises(UsageError, match=r"other.op2 is no result file of this project"):
        build_part(copy, folder / "other.op2", reduction_of, silent)
    found = tedm("build-sensitivity", "--partial", "x.op2", "--scheduler", "tcp://h:1", "-c", copy.file.path)
    assert (found.code, found.err) == (2, "error: --no-store, --partial, --scheduler and --output exclude each other\n")
    (folder / "elsewhere").mkdir()
    shutil.move(folder / FILES[0], folder / "elsewhere" / "batch1.op2")  # on a disk of its own, by its name
    (copy.build_dir / "partial_batch1.h5").unlink()
    assert build_part(copy, folder / "elsewhere" / "batch1.op2", reduction_of, silent).path.exists()


def test_parts_of_files_with_one_name() -> None:
    assert partial_file_names([Path("a/x.op2"), Path("y.op2")]) == ["partial_x.h5", "partial_y.h5"]
    assert partial_file_names([Path("a/x.op2"), Path("b/X.op2")]) == ["partial_1_x.h5", "partial_2_X.h5"]


def test_columns_are_sums_over_grids_and_parts_can_be_in_any_order() -> None:
    rng = np.random.default_rng(5)
    n, k, levers, optics = 70_000, 7, np.array([3, 66_000]), np.array([69_999, 0])
    g, turning = rng.normal(size=(6, n, 3)), rng.normal(size=(6, 2, 3))
    t, r, load = rng.normal(size=(k, n, 3)), rng.normal(size=(k, n, 3)), rng.uniform(0.5, 2.0, k)
    position, mean = rng.normal(size=(n, 3)), np.arange(k) != 2
    fit = RigidFit(position, np.ones(n), position.mean(axis=0))
    by = Reduction(operator=g, rotation=turning, levers=levers, optics=optics, blocks=(), fit=fit)
    d, turn = t / load[:, None, None], r / load[:, None, None]
    wanted = -np.einsum("rnc,knc->rk", g, d) - np.einsum("rlc,klc->rk", turning, turn[:, levers])
    found = {}
    for some in ([0, 3], [6, 2, 1], [5, 4], []):
        motions = ((load[i], bool(mean[i]), t[i], r[i]) for i in some)
        found[tuple(some)] = reduced(motions, by)
    parts = [(np.array(some, dtype=np.int64), columns) for some, (columns, _) in found.items()]
    whole, other = joined(parts), joined(parts[::-1])
    np.testing.assert_allclose(whole.columns, wanted, rtol=0, atol=1e-13 * np.abs(wanted).max())
    np.testing.assert_array_equal(whole.columns, other.columns)
    np.testing.assert_array_equal(whole.optical_rotation, turn[:, optics])
    np.testing.assert_allclose(whole.largest, np.linalg.norm(d, axis=2).max(axis=1), rtol=1e-15)
    sums = [sums for _, sums in found.values()]
    np.testing.assert_allclose((sums[0] + sums[1] + sums[2] + sums[3]).total, d[mean].sum(axis=0), atol=1e-12)
    assert sums[1].moving.all()
    assert not sums[3].moving.any()
