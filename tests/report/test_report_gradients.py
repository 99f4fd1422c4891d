"""Gradient areas in all that is written of a project: with their own unit, and never in a sum of kelvins."""

import dataclasses
import json
import re
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from report_project import CASES, close_loop, make_project, sketch

from tedm_cli.cli.printing.explain import explain_dict, explain_lines
from tedm_cli.config.cases import load_cases
from tedm_cli.config.optics.layout import load_layout
from tedm_cli.config.project import Project
from tedm_cli.contracts import CASE, DISTORTION, DYNAMICS, OPTICS, SENSITIVITY, UNIT_LOADS
from tedm_cli.contracts import SERIES as SERIES_FILE
from tedm_cli.errors import InputError
from tedm_cli.exports.case import case_matrices
from tedm_cli.exports.closed_loop import closed_loop_matrices
from tedm_cli.exports.tables import TABLES
from tedm_cli.figures.cases.improvement import improvement_figure
from tedm_cli.figures.cases.spectra import temperature_figure
from tedm_cli.figures.drawing.pages import map_pages
from tedm_cli.figures.model.area_maps import map_figure
from tedm_cli.files.store import open_checked
from tedm_cli.noise.bounds import BOUNDS
from tedm_cli.noise.correlation import correlation
from tedm_cli.noise.propagation import TemperatureNoise
from tedm_cli.optics.expansion import face_motion
from tedm_cli.optics.layout import MassExpansion
from tedm_cli.progress import silent
from tedm_cli.results.areas import maps_by_kind, read_areas
from tedm_cli.results.build_folder import open_results
from tedm_cli.results.cases.file import read_case
from tedm_cli.results.cases.temperatures import read_temperature
from tedm_cli.results.gravity.self_gravity import gravity_maps
from tedm_cli.results.optics import read_read_outs
from tedm_cli.results.outputs import read_outputs
from tedm_cli.results.unit_loads import area_of_elements, area_of_grids
from tedm_cli.results.wording import sci
from tedm_cli.stages.explain.read_outs import explain
from tedm_cli.stages.exports.extremal import export_extremal
from tedm_cli.stages.exports.mesh import UNIFORM, _of_load, _weights
from tedm_cli.stages.exports.state_space import Wanted, export_state_space
from tedm_cli.stages.noise.series import run_series
from tedm_cli.stages.reporting.plot import figure_specs
from tedm_cli.stages.reporting.report import report
from tedm_cli.stages.reporting.view_cases import case_views

KINDS = ("mean", "mean", "mean", "gradient", "gradient")
MEANS = np.array([True, True, True, False, False])
SERIES = '[[series]]\nname = "warm"\nfile = "warm.csv"\nremove = "mean"\nunit = "degC"\n'
WHITE = '[[temperature.gradient]]\npreset = "white"\nlevel_K_per_m = 1e-3\n\n'
HEARD = CASES.replace("[frequency]", f"{WHITE}[frequency]") + SERIES


@pytest.fixture(scope="module")
def project(tmp_path_factory: pytest.TempPathFactory) -> Project:
    """The made-up project, two of whose areas are gradients that have a spectrum."""
    folder = tmp_path_factory.mktemp("gradients")
    t = np.arange(400.0)
    table = np.column_stack([10.0 * t, 20.0 + np.sin(t), -400.0 + np.cos(t)])
    np.savetxt(folder / "warm.csv", table, delimiter=",", header="time_s,all,IS1_OUTER", comments="")
    return make_project(folder, HEARD, kinds=KINDS)


@pytest.fixture(scope="module")
def text(project: Project) -> str:
    """What report and annex say, without their markup."""
    close_loop(project, ("2",))
    sketch(project)
    report(project, None, ("html",))
    found = "".join(p.read_text() for p in sorted(project.build_dir.glob("report*.html")))
    return re.sub(r"\s+", " ", re.sub(r"<[^>]+>", " ", found))


def test_the_report_says_the_unit_of_gradients_and_sums_means_alone(project: Project, text: str) -> None:
    with open_checked(project.build_dir / "optics.h5", OPTICS) as file:
        n = file.array(OPTICS.N.of("A"))[0]
    assert f"m per K/m of {'IS1_$a$_b' if abs(n[3]) > abs(n[4]) else 'IS1_OUTER'}" in text
    assert f"{sci(float(n[MEANS].sum()), 3)} m per kelvin of all mean temperatures together" in text
    assert "m/(K/m)" in text
    assert "Worst gradient of each read-out." in text
    assert "Gradients, per K/m, have their own table and are not part of the sums per kelvin." in text
    assert "IS1 (gradients)" in text
    assert "K/√Hz, gradients K/m/√Hz" in text
    assert "1e-03" not in text
    assert "0.001 K/m/√Hz, white" in text
    assert re.search(r"below 80 % in 3 areas: .* their own distortion is computed too small by as much", text)


def test_captions_and_files_of_maps_keep_the_kinds_apart(project: Project) -> None:
    with open_results(project) as results:
        cases = [read_case(case) for case in results.cases]
        specs = {s.name: s.caption for s in figure_specs(results, cases)}
        assert "to each thermal area" in specs["self_gravity_by_area.svg"]
        assert "to each gradient area" in specs["self_gravity_by_area_gradients.svg"]
        assert "per kelvin of each thermal area" in specs["read_out_by_area.svg"]
        assert "per K/m of each gradient area" in specs["read_out_by_area_gradients.svg"]
        assert not [name for name in specs if name.startswith("bench_area") and "IS1" in name]
        (_, _, maps, own), (_, _, steep, apart) = maps_by_kind(gravity_maps(results.matrices[0].reader), results.areas)
        assert [m.unit for m in maps] == ["m/s^2/K", "rad/s^2/K"]
        with open_checked(project.build_dir / "sensitivity.h5", SENSITIVITY) as file:
            s = file.array(SENSITIVITY.S)
        np.testing.assert_array_equal(np.vstack([m.value for m in maps]), s[:, MEANS])
        np.testing.assert_array_equal(np.vstack([m.value for m in steep]), s[:, ~MEANS])
        assert [m.unit for m in steep] == ["m/s^2/(K/m)", "rad/s^2/(K/m)"]
        assert [own.name.tolist(), apart.name.tolist()] == [
            ["STRUT_1", "STRUT_2", "OB <b>&"],
            ["IS1_$a$_b", "IS1_OUTER"],
        ]
        figure = map_figure(map_pages(steep, apart, 0.14)[0], apart, "gradients")
        shown = " ".join(t.get_text() for axes in figure.axes for t in (*axes.texts, axes.xaxis.label, axes.title))
        assert "IS1 (gradients)" in shown
        assert "m/s²/(K/m)" in shown


def test_figures_of_spectra_and_of_remedies_say_both_units(project: Project) -> None:
    with open_checked(project.build_dir / "case02.h5", CASE) as file:
        spectra, case = read_temperature(file), read_case(file)
    assert sorted(spectra.unit) == ["K", "K", "K/m"]
    figure = temperature_figure(spectra)
    assert [axes.get_ylabel() for axes in figure.axes] == ["temperature (K/√Hz)", "temperature gradient (K/m/√Hz)"]
    np.testing.assert_allclose(figure.axes[1].lines[0].get_ydata(), 1e-3)
    judged = case.worst("displacement")
    assert list(judged.improvement.group_level) == ["struts", "OB", "IS1 (gradients)"]
    assert judged.improvement.group_level["IS1 (gradients)"] == pytest.approx(1e-3)
    drawn = improvement_figure(case, judged)
    assert "K/√Hz, gradients K/m/√Hz" in " ".join(t.get_text().replace("\n", " ") for t in drawn.texts)


def test_explain_adds_means_alone_and_lists_gradients_with_their_unit(project: Project) -> None:
    with open_checked(project.build_dir / "optics.h5", OPTICS) as file:
        n = file.array(OPTICS.GAIN.of("A")) @ file.array(OPTICS.MOTION) + read_read_outs(file).N_plates("A")
    done = explain(project)
    first = done.read_outs[0]
    assert first.total == pytest.approx(n[0][MEANS].sum())
    assert first.size == pytest.approx(np.linalg.norm(n[0][MEANS]))
    assert dict(first.gradients) == pytest.approx({"IS1_$a$_b": n[0][3], "IS1_OUTER": n[0][4]})
    assert explain(project, uniform=True).read_outs[0].total == pytest.approx(n[0][MEANS].sum())
    one = explain(project, area="IS1_OUTER").read_outs[0]
    assert one.unit == "m/(K/m)"
    assert one.total == pytest.approx(n[0][4])
    said = "\n".join(explain_lines(done, 5))
    assert "over 3 areas" in said
    assert "m/(K/m)" in said
    assert "gradients, per K/m, are in no size, sum or share" in said
    assert explain_dict(done, 5)["read_outs"][0]["gradients"][0]["unit"] == "m/(K/m)"
    assert json.dumps(explain_dict(done, 5))


def test_exported_matrices_have_the_unit_of_each_column(project: Project, text: str) -> None:
    units = ["K", "K", "K", "K/m", "K/m"]
    for stem in ("optics", "sensitivity", "distortion"):
        kind, tables = TABLES[stem]
        with open_checked(project.build_dir / f"{stem}.h5", kind) as file:
            by_area = [m for m in tables(file) if len(m.columns) == 5]
            assert by_area
            for matrix in by_area:
                assert matrix.column_units == units
                assert "per K/m of a gradient area, per kelvin of any other" in matrix.description
    with open_checked(project.build_dir / "case02.h5", CASE) as file:
        (asd,) = [m for m in case_matrices(file) if m.name == "temperature_asd"]
    assert asd.column_units == ["Hz", *(f"{u}/sqrt(Hz)" for u in units)]
    with open_checked(project.build_dir / "dynamics.h5", DYNAMICS) as file:
        (v,) = [m for m in closed_loop_matrices(file) if m.name == "V"]
    assert v.column_units == units
    (system,) = export_state_space(project, ["2"], "npz", None, Wanted(temperatures=True))
    held = np.load(next(p for p in system.paths if p.suffix == ".npz"))
    assert held["G.column_units"].tolist() == units
    assert held["C_T.row_units"].tolist() == units


def test_bounds_of_means_and_gradients_are_reached_by_the_matrices_that_are_exported(
    project: Project, tmp_path: Path
) -> None:
    """As a user does it: export, append to a copy of the cases, and load each case with its matrix."""
    done = export_extremal(project.build_dir, "1", ["TM1_a_x"], tmp_path)
    assert len(done) == len(BOUNDS)
    cases = tmp_path / "all.toml"
    cases.write_text(HEARD + (tmp_path / "cases.toml").read_text())
    config, outputs = load_cases(cases)[1], read_outputs(project)
    model = config.temperature.model(outputs.areas)
    row = outputs.rows[outputs.labels.index("TM1_a_x")]
    between = []
    for one in done:
        found = correlation(config.case(one.id), outputs.areas, model.heard)
        between.append(np.abs(found.matrix()[np.ix_(MEANS, ~MEANS)]).max())
        psd = TemperatureNoise(model, found).psd(row[None], np.array([one.frequency_hz]))[0, 0]
        most = max(other.amplitude for other in done)
        assert abs(np.sqrt(psd) - one.amplitude) < 1e-7 * most, one.bound
    assert max(between) == pytest.approx(1.0)


def test_a_uniform_load_of_the_mesh_is_of_means(project: Project) -> None:
    with open_checked(project.build_dir / "distortion.h5", DISTORTION) as file:
        areas = read_areas(file)
    np.testing.assert_array_equal(_weights(UNIFORM, areas), [1, 1, 1, 0, 0])
    assert _of_load(UNIFORM, areas) == ("K", "per kelvin of all mean temperatures together")
    assert _of_load("IS1_OUTER", areas) == ("K/m", "per K/m of area IS1_OUTER")
    assert _of_load("STRUT_1", areas) == ("K", "per kelvin of area STRUT_1")


def test_shares_of_a_case_are_told_by_group_and_unit(project: Project) -> None:
    with open_checked(project.build_dir / "case02.h5", CASE) as file:
        assert file.strings(CASE.IMPROVEMENT_GROUP) == ["struts", "OB", "IS1"]
        assert file.strings(CASE.IMPROVEMENT_GROUP_UNIT) == ["K", "K", "K/m"]
        psd = file.array(CASE.PSD.of("TM1_a_x"))
        frequency = file.array(CASE.FREQUENCY)
        asd = file.array(CASE.TEMPERATURE_ASD)[file.array(CASE.TEMPERATURE_SPECTRUM)]
    with open_checked(project.build_dir / "sensitivity.h5", SENSITIVITY) as file:
        s = file.array(SENSITIVITY.S)[0]
    np.testing.assert_allclose(asd[3:], np.full((2, len(frequency)), 1e-3))
    np.testing.assert_allclose(psd, (s**2) @ asd**2, rtol=1e-12)


def test_a_series_feeds_a_gradient_by_its_own_column_in_kelvin_per_metre(project: Project) -> None:
    """Also of degrees Celsius, where -400 would be no temperature; the gradient without a column is named as silent."""
    with open_checked(project.build_dir / "sensitivity.h5", SENSITIVITY) as file:
        s = file.array(SENSITIVITY.S)[0]
    run_series(project, ["warm"], None, silent)
    t = np.arange(400.0)
    means, gradient = np.sin(t), np.cos(t)
    with open_checked(project.build_dir / "series_warm.h5", SERIES_FILE) as file:
        y = file.array(SERIES_FILE.SERIES.of("TM1_a_x"))
        assert file.strings(SERIES_FILE.TEMPERATURE_COLUMN) == ["all", "all", "all", "", "IS1_OUTER"]
        assert "silent gradients, which have no column: IS1_$a$_b" in file.string(SERIES_FILE.TEMPERATURE_TREATMENT)
    wanted = s[MEANS].sum() * (means - means.mean()) + s[4] * (gradient - gradient.mean())
    np.testing.assert_allclose(y, wanted, rtol=0, atol=1e-9 * np.abs(wanted).max())


def test_a_pattern_at_its_worst_moves_the_output_by_the_bound_over_means_and_gradients(project: Project) -> None:
    with open_results(project) as results, open_checked(project.build_dir / "case02.h5", CASE) as file:
        outputs = read_outputs(project)
        views = case_views(project, results, outputs, silent)
        shown = next(view for view in views if view.id == "2").verdicts
        frequency = file.array(CASE.FREQUENCY)
        assert shown
        for verdict in shown:
            most = file.array(CASE.BOUNDS_MAXIMUM.of(outputs.labels[verdict.output]))
            row = outputs.rows[verdict.output]
            assert np.abs((row * verdict.worst)[~MEANS]).max() > 0.0
            reached = (row @ verdict.worst) ** 2
            assert reached == pytest.approx(most[np.abs(frequency - verdict.pattern_hz).argmin()], rel=1e-9)


def test_a_test_mass_does_not_expand_by_a_gradient(project: Project) -> None:
    layout = load_layout(project.required_optics())[1]
    name = layout.test_masses[0].name
    layout = dataclasses.replace(layout, expansions=(MassExpansion(name, 1e-5, "G"),))
    assert face_motion(layout, ["A", "G"])[0, 1] != 0.0
    with pytest.raises(InputError, match="follows 'G', which is a gradient in K/m"):
        face_motion(layout, ["A", "G"], ["G"])


def test_grids_and_elements_are_of_means_alone() -> None:
    arrays = {
        UNIT_LOADS.GRID_ID: np.arange(6), UNIT_LOADS.ELEMENT_ID: np.arange(3),
        UNIT_LOADS.AREA_NODE_OFFSET: np.array([0, 2, 2, 4]), UNIT_LOADS.AREA_NODE_INDEX: np.array([0, 1, 4, 5]),
        UNIT_LOADS.AREA_ELEMENT_OFFSET: np.array([0, 0, 1, 2]), UNIT_LOADS.AREA_ELEMENT_INDEX: np.array([1, 2]),
        UNIT_LOADS.ELEMENT_NODE_OFFSET: np.array([0, 2, 4, 6]),
        UNIT_LOADS.ELEMENT_NODE_INDEX: np.array([0, 1, 1, 2, 4, 5]),
    }  # fmt: skip
    kinds = ["mean", "mean", "gradient"]
    file = SimpleNamespace(array=arrays.get, dataset=arrays.get, strings={UNIT_LOADS.AREA_KIND: kinds}.get)
    assert area_of_elements(file).tolist() == [-1, 1, -1]  # type: ignore[arg-type]
    assert area_of_grids(file).tolist() == [0, 0, 1, -1, -1, -1]  # type: ignore[arg-type]
