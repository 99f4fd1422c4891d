"""Gradients within areas on the command line: what takes them, what does not and says so, and refusals."""

from __future__ import annotations

import json
import os
import re
import shutil

import h5py
import numpy as np
import pytest
from border_tools import Project, edited, tedm, untouched

from tedm_cli.chain.graph import Step, chain_of
from tedm_cli.config.cases import load_cases
from tedm_cli.config.model.file import load_model
from tedm_cli.config.project import load_project
from tedm_cli.contracts import ADJOINT, CASE, SENSITIVITY, SIMULATION
from tedm_cli.dynamics.signals import COORDINATES, STRAY
from tedm_cli.files.build_folder import provenance
from tedm_cli.files.store import create, open_checked
from tedm_cli.progress import silent
from tedm_cli.results.adjoint.within import case_gradients
from tedm_cli.results.build_folder import open_results
from tedm_cli.results.cases.file import read_case
from tedm_cli.results.outputs import read_outputs
from tedm_cli.stages.chain.project_files import chain_files
from tedm_cli.stages.common import copy_areas
from tedm_cli.stages.dynamics.thermal import thermal_rows
from tedm_cli.stages.reporting import draw
from tedm_cli.stages.reporting.plot import figure_specs
from tedm_cli.stages.reporting.view_cases import case_views

HEAD = """
[[requirement]]
name = "lpf_readout_item"
outputs = ["A_TM1_x", "A_TM2_x"]

[[case]]
id = "3"
title = "Correlated inside and outside"
blocks = [{ shield = ["outside"] }, { shield = ["inside"] }]

[[case]]
id = "gradients"
title = "Across the bench"
blocks = [{ areas = ["* grad *"], each_alone = true }]
"""
BENCH = """
[[temperature.within]]
name = "bench"
areas = ["OB_BENCH_*"]
across_K = 1e-4
cases = ["gradients*"]
"""


@pytest.fixture(scope="module")
def bench(chain: Project, tmp_path_factory: pytest.TempPathFactory) -> Project:
    """Both cases run. Not to be changed: copy it."""
    made = chain.copy(tmp_path_factory.mktemp("bench") / "small")
    (made.folder / "cases.toml").write_text(HEAD + BENCH)
    made.run("run-case", "all").ok()
    return made


@pytest.fixture
def copied(bench: Project, tmp_path) -> Project:
    return bench.copy(tmp_path / "copied")


def test_run_case_tells_them_as_any_area(bench: Project, tmp_path) -> None:
    said = bench.run("run-case", "gradients", "-v", "-o", tmp_path / "one.h5").ok().out
    assert "3 of 31 areas in 3 blocks" in said
    assert "bench grad " in said
    assert "OB (gradients)" in said
    assert "K/m/sqrt(Hz)" in said


def test_explain_tells_what_each_does(bench: Project) -> None:
    said = json.loads(bench.run("explain", "bench grad y", "--json").ok().out)
    text = json.dumps(said)
    assert "gradient within areas" in text
    assert "in case gradients" in text
    outputs = read_outputs(load_project(bench.folder / "tedm.toml", bench.build))
    with h5py.File(bench.build / "adjoint.h5") as file:
        assert all(label in text for label in file["row/label"].asstr()[()])
    assert "bench grad y" not in outputs.areas.name
    assert "with gradients within areas: bench grad x, bench grad y, bench grad z" in bench.run(
        "explain", "gradients"
    ).ok().out.replace("\n ", "")
    bench.run("explain", "bench grad").refused(2, hint="bench grad")


def test_figures_and_page_take_the_case(bench: Project) -> None:
    """On the page nothing moves by them, and the case says so."""
    project = load_project(bench.folder / "tedm.toml", bench.build)
    with open_results(project) as results:
        cases = [read_case(file) for file in results.cases]
        specs = {s.name: s for s in figure_specs(results, cases)}
        assert "K/m/√Hz" in specs["temperature.svg"].caption
        assert "in case gradients also" in specs["temperature.svg"].caption
        figure = draw.contributors(cases[1], cases[1].judged[0])
        named = [text.get_text() for text in figure.axes[1].get_yticklabels()]
        assert set(named) >= {"bench grad x", "bench grad y", "bench grad z"}
        outputs = read_outputs(project)
        three, of = case_views(project, results, outputs, silent)
        assert "move nothing on this page" in of.reason
        assert "page" not in three.reason
        assert len(of.silent) == len(outputs.areas) == 28
        assert all(len(v.typical) == len(v.worst) == 28 and not v.typical.any() for v in of.verdicts)
        assert all(v.typical.any() for v in three.verdicts)
        assert of.film is not None
        assert of.verdicts[0].ratio == cases[1].judged[0].ratio > 0.0


def test_exports_take_the_case_or_say_why_not(bench: Project, tmp_path) -> None:
    """No displacements belong to them: nothing of the case can be shown on the mesh."""
    said = bench.run("export-state-space", "gradients", "-o", tmp_path / "system.npz", "--format", "npz").ok().out
    assert "3 white noises" in said
    with np.load(tmp_path / "system.npz", allow_pickle=False) as file:
        names = " ".join(str(file[name]) for name in file.files)
    assert "bench grad z" in names
    tedm("export-case", "gradients", "-d", bench.build, "-o", tmp_path).ok()
    tedm("export-extremal", "gradients", "-d", bench.build, "-o", tmp_path / "extremal").ok()
    assert "bench grad x" in (tmp_path / "extremal" / "A_TM1_x_maximum.csv").read_text()
    out = tmp_path / "model.vtu"
    refused = tedm("export-vtu", "-d", bench.build, "-o", out, "--case", "gradients", "--of", "A_TM1_x")
    refused.refused(2, "has gradients within areas (bench grad x, bench grad y, bench grad z)", hint="without")
    tedm("export-vtu", "-d", bench.build, "-o", out).ok()


def test_the_correlations_of_extremes_are_cases_again(copied: Project) -> None:
    """Their ids are those of the case and more: `cases` may be a pattern."""
    folder = copied.folder / "extremal"
    tedm("export-extremal", "gradients", "-d", copied.build, "-o", folder).ok()
    path = copied.folder / "cases.toml"
    path.write_text(path.read_text() + (folder / "cases.toml").read_text())
    copied.run("run-case", "gradients_A_TM1_x_maximum").ok()
    with (
        open_checked(copied.build / "casegradients_A_TM1_x_maximum.h5", CASE) as file,
        open_checked(copied.build / "casegradients.h5", CASE) as of,
    ):
        at = int(np.abs(file.array(CASE.FREQUENCY) - 3e-3).argmin())
        wanted = of.array(CASE.BOUNDS_MAXIMUM.of("A_TM1_x"))[at]
        assert file.array(CASE.PSD.of("A_TM1_x"))[at] == pytest.approx(wanted, rel=1e-6)


def test_the_chain_makes_the_adjoint_first(copied: Project) -> None:
    """Where a case takes something of it, and only there."""
    project = load_project(copied.folder / "tedm.toml", copied.build)
    files = chain_files(project)
    assert files.case_adjoint == copied.build / "adjoint.h5"
    assert all(files.case_adjoint in s.inputs for s in _steps(copied) if s.stage == "run-case")
    path = copied.folder / "cases.toml"
    path.write_text(path.read_text().replace('cases = ["gradients*"]', 'cases = ["3"]'))
    assert chain_files(project).case_needs_adjoint
    path.write_text(HEAD.replace("* grad *", "OB_*"))
    assert chain_files(project).case_adjoint is None
    assert all(copied.build / "adjoint.h5" not in s.inputs for s in _steps(copied) if s.stage == "run-case")
    copied.run("make-rules").ok()
    assert re.search(r"(?m)^CASE_ADJOINT :=$", (copied.build / "rules.mk").read_text())


def _steps(project: Project) -> tuple[Step, ...]:
    return chain_of(chain_files(load_project(project.folder / "tedm.toml", project.build)))


def test_spectra_from_a_table(copied: Project) -> None:
    """By the name of a gradient, or for all of its group; in K/m."""
    path = copied.folder / "cases.toml"
    path.write_text(path.read_text().replace("across_K = 1e-4", 'preset = "table"\ntable = "spectra.csv"'))
    (copied.folder / "spectra.csv").write_text("frequency_hz,bench grad y,OB\n1e-5,4e-3,1e-3\n1,4e-3,1e-3\n")
    copied.run("run-case", "gradients").ok()
    with open_checked(copied.build / "casegradients.h5", CASE) as file:
        level = file.array(CASE.TEMPERATURE_ASD)[file.array(CASE.TEMPERATURE_SPECTRUM)[-3:], 0]
        assert "spectra.csv" in [item.path.name for item in file.provenance().inputs]
    np.testing.assert_allclose(level, [1e-3, 4e-3, 1e-3], rtol=1e-12)
    (copied.folder / "spectra.csv").write_text("frequency_hz,bench grad y\n1e-5,4e-3\n1,4e-3\n")
    copied.run("run-case", "gradients").refused(3, "no column for 2 of 3 gradient areas: bench grad x, bench grad z")


def test_the_loop_feels_them(copied: Project) -> None:
    """By the rows of the adjoint, in the order of the loop."""
    copied.run("build-dynamics").ok()
    copied.run("simulate", "gradients").ok()
    project = load_project(copied.folder / "tedm.toml", copied.build)
    found = case_gradients(project, load_cases(project.cases)[1], read_outputs(project)).of("gradients")
    assert found is not None
    rows = thermal_rows(project, "B")
    more = rows.with_gradients(found)
    at = STRAY.index("TM2_omegadot_y"), COORDINATES.index("TM1_eta")
    np.testing.assert_array_equal(more.acceleration[at[0], 28:], found.rows["TM2_omegadot_y"])
    np.testing.assert_array_equal(more.read_out[at[1], 28:], found.rows["B_TM1_eta"])
    np.testing.assert_array_equal(more.acceleration[:, :28], rows.acceleration)
    np.testing.assert_array_equal(more.read_out[COORDINATES.index("TM1_y")], 0.0)
    with open_checked(copied.build / "simulationgradients.h5", SIMULATION) as file:
        names = file.strings(SIMULATION.AREA_NAME)
        share = file.array(SIMULATION.VERDICT_AREA_SHARE)
        inputs = [item.path.name for item in file.provenance().inputs]
    assert names[28:] == found.areas.name.tolist()
    assert "adjoint.h5" in inputs
    assert not share[:, :28].any()
    assert (np.abs(share[:, 28:]).max(axis=1) > 0.0).all()


@pytest.mark.parametrize(
    ("old", "new", "fact"),
    [
        (
            'areas = ["OB_BENCH_*"]',
            'areas = ["OB_BANK_*"]',
            "within[0].areas: no thermal area has 'OB_BANK_*'",
        ),
        ('areas = ["OB_BENCH_*"]', 'groups = ["bench"]', "no thermal area is of group 'bench'"),
        ('areas = ["OB_BENCH_*"]', "", "selects nothing: give groups, shield or areas"),
        ("across_K = 1e-4", "", "preset thesis needs either level_K_per_m, in K/m/sqrt(Hz), or across_K: neither is"),
        ("across_K = 1e-4", "across_K = 1e-4\nlevel_K_per_m = 1e-3", "across_K: both are given"),
        ("across_K = 1e-4", "level_K = 1e-4", "level_K is of mean temperatures; give level_K_per_m or across_K"),
        ("across_K = 1e-4", 'preset = "lpf_flight"', "cannot be used for gradients"),
        (
            "across_K = 1e-4",
            'preset = "table"\ntable = "t.csv"\nacross_K = 1.0',
            "its own levels, but across_K given",
        ),
        ('cases = ["gradients*"]', 'cases = ["grads"]', "there is no case 'grads'; there are: 3, gradients"),
        ('cases = ["gradients*"]', 'axes = ["x", "x"]', "has an axis twice"),
        ('cases = ["gradients*"]', 'axes = ["u"]', "temperature.within[0].axes[0]"),
        ('name = "bench"', 'name = "the*bench"', "a name of an area must begin with a letter"),
        ('areas = ["OB_BENCH_*"]', 'areas = ["*"]', "the areas of one body are of 5 groups"),
        ('areas = ["OB_BENCH_*"]', 'shield = ["outside", "inside"]', "of 2 sides of the shield: inside, outside"),
        (
            "[[temperature.within]]",
            BENCH + "[[temperature.within]]",
            "has 'bench grad x' of another table",
        ),
    ],
)
def test_what_cannot_be(copied: Project, old: str, new: str, fact: str) -> None:
    """Each in one error with its place; files stay."""
    path = copied.folder / "cases.toml"
    assert old in path.read_text()
    path.write_text(path.read_text().replace(old, new))
    with untouched(copied.build):
        copied.run("run-case", "gradients").refused(3, fact)


def test_an_area_flat_along_an_axis_has_no_gradient_there(copied: Project) -> None:
    """Left out where no axes are named; refused by name where they are. Nor is there one about no centroid."""
    with edited(copied.build / "adjoint.h5") as file:
        names = list(file["area/name"].asstr()[()])
        chosen = [names.index(f"OB_BENCH_{side}_Y") for side in ("MINUS", "PLUS")]
        file["area/low"][chosen, 2] = file["area/high"][chosen, 2] = -0.03
    copied.run("run-case", "gradients").ok()
    with open_checked(copied.build / "casegradients.h5", CASE) as made:
        assert made.strings(CASE.AREA_NAME)[-2:] == ["bench grad x", "bench grad y"]
    path = copied.folder / "cases.toml"
    path.write_text(path.read_text().replace("across_K", 'axes = ["z"]\nacross_K'))
    copied.run("run-case", "gradients").refused(3, "temperature.within[0].axes: bench has no extent along z")
    with edited(copied.build / "adjoint.h5") as file:
        file["area/volume"][chosen[0]] = -1e-9
    copied.run("run-case", "gradients").refused(3, "OB_BENCH_MINUS_Y has no volume in the elements, so no centroid")


def test_without_an_adjoint_the_other_cases_run(copied: Project) -> None:
    adjoint = copied.build / "adjoint.h5"
    kept = copied.folder / "kept.h5"
    shutil.move(adjoint, kept)
    copied.run("run-case", "3").ok()
    said = copied.run("run-case", "gradients")
    said.refused(4, "temperature.within[0] of", hint="tedm build-adjoint")
    assert "adjoint.h5: no such file" in said.err
    copied.run("explain", "bench grad x").refused(2, hint="adjoint.h5 is not there, and may have it")
    shutil.copy(kept, adjoint)
    config = load_model(copied.model)[0]
    trace = provenance([config], [copied.build / "sensitivity.h5", copied.build / "optics.h5"])
    with (
        open_checked(copied.build / "sensitivity.h5", SENSITIVITY) as gravity,
        create(adjoint, ADJOINT, trace) as writer,
    ):
        copy_areas(gravity, writer)
        writer.write(ADJOINT.REFUSAL, ["CROD 7 is odd"])
    copied.run("run-case", "gradients").refused(4, "has no gradients within areas: CROD 7 is odd")
    shutil.copy(kept, adjoint)
    os.utime(copied.model)
    copied.model.write_text(copied.model.read_text() + "\n# another\n")
    copied.run("run-case", "gradients").refused(4, "is stale")


def test_other_areas_of_a_case_than_those_of_the_model_are_refused(copied: Project) -> None:
    """More may be behind them; these are the same."""
    with edited(copied.build / "casegradients.h5") as file:
        sides = file["area/shield"].asstr()[()]
        sides[0] = "inside" if sides[0] == "outside" else "outside"
        file["area/shield"][...] = sides
    copied.run("plot").refused(4, "hold different thermal areas (/area/shield)")
