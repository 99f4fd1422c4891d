"""Gradients within areas in cases: columns, noise and verdicts of linear temperature fields solved as loads."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from test_chain_adjoint import agree, by_motion

from tedm_cli.config.cases import load_cases
from tedm_cli.config.project import Project
from tedm_cli.contracts import ADJOINT, CASE, UNIT_LOADS
from tedm_cli.errors import ConfigError
from tedm_cli.fem.static import StaticSolution
from tedm_cli.fem.structure import LoadCase
from tedm_cli.files.store import open_checked
from tedm_cli.nastran.structure.deck import read_solver_deck
from tedm_cli.noise.case_run import run_case
from tedm_cli.noise.outputs import Outputs
from tedm_cli.noise.temperature import TemperatureModel, WhiteSpectrum
from tedm_cli.progress import silent
from tedm_cli.results.adjoint.within import NOT_TOLD, case_gradients, with_gradients
from tedm_cli.results.areas import read_areas
from tedm_cli.results.cases.file import read_case, read_correlation
from tedm_cli.results.cases.temperatures import read_temperatures
from tedm_cli.results.outputs import read_outputs
from tedm_cli.stages.noise.case import run_cases

BODY, ALONE = ["OB_BENCH_MINUS_Y", "OB_BENCH_PLUS_Y"], "STRUT_5"
LEVEL = 3e-3  # K/m/√Hz
CASES = f"""
[[temperature.within]]
name = "bench"
areas = ["OB_BENCH_*"]
level_K_per_m = {LEVEL}
preset = "white"
cases = ["alone", "with means"]

[[temperature.within]]
areas = ["{ALONE}"]
axes = ["z", "x"]
across_K = 1e-4
preset = "white"
cases = ["across*", "with means"]

[[case]]
id = "means"
title = "Means alone"
blocks = [{{ areas = ["*"] }}]

[[case]]
id = "alone"
title = "Gradients of the bench, each by itself"
blocks = [{{ areas = ["* grad *"], each_alone = true }}]

[[case]]
id = "with means"
title = "All there is"
blocks = [{{ areas = ["*"] }}]

[[case]]
id = "across"
title = "All there is, together"
blocks = [{{ areas = ["*"], across_kinds = true }}]

[[requirement]]
name = "lpf_selfgravity_ltp"
outputs = ["TM1_a_x", "TM2_a_x"]

[[requirement]]
name = "lpf_readout_item"
outputs = ["A_TM1_x", "A_TM2_x"]
"""


@pytest.fixture(scope="module")
def project(small: Project, tmp_path_factory: pytest.TempPathFactory) -> Project:
    path = tmp_path_factory.mktemp("within") / "cases.toml"
    path.write_text(CASES.replace('"with means"', '"with_means"'), encoding="utf-8")
    return replace(small, cases=path)


@pytest.fixture(scope="module")
def files(project: Project) -> dict[str, Path]:
    """The file of each case."""
    done = {}
    for case_id in load_cases(project.cases)[1].ids:
        done[case_id] = project.cases.parent / f"{case_id}.h5"
        run_cases(project, [case_id], done[case_id], silent)
    return done


@pytest.fixture(scope="module")
def explicit(project: Project) -> tuple[np.ndarray, np.ndarray]:
    """Columns [r, 3] of T = x - x̄ along x, y, z on the grids of the bench, solved as loads; and its extent [3], m."""
    with (
        open_checked(project.build_dir / "adjoint.h5", ADJOINT) as adjoint,
        open_checked(project.build_dir / "unit_loads.h5", UNIT_LOADS) as unit,
    ):
        names, volume = unit.strings(UNIT_LOADS.AREA_NAME), adjoint.array(ADJOINT.GRID_VOLUME)
        position = unit.array(UNIT_LOADS.GRID_POSITION)
        offset = unit.array(UNIT_LOADS.AREA_NODE_OFFSET)
        members = np.split(unit.array(UNIT_LOADS.AREA_NODE_INDEX), offset[1:-1])
    grids = np.concatenate([members[names.index(name)] for name in BODY])
    middle = volume[grids] @ position[grids] / volume[grids].sum()
    structure, loads = read_solver_deck(Path(project.resolve("unit_loads.bdf")))
    fields, first = [], loads[0].temperature
    assert first is not None
    for axis in range(3):
        temperature = np.full(structure.n_grids, first.min())
        temperature[grids] += position[grids, axis] - middle[axis]
        fields.append(LoadCase(id=900 + axis, label="", temperature=temperature))
    motion = np.array([u for _, u in StaticSolution(structure).solve(fields)])
    return by_motion(project, motion), np.ptp(position[grids], axis=0)


def test_a_body_of_areas_is_a_linear_field_of_its_grids(project: Project, explicit: tuple) -> None:
    """Column by column, in double precision; means of its areas are in it, since their centroids are not the body's."""
    outputs = read_outputs(project)
    found = case_gradients(project, load_cases(project.cases)[1], outputs).of("alone")
    assert found is not None
    assert found.areas.name.tolist() == ["bench grad x", "bench grad y", "bench grad z"]
    assert found.areas.kind.tolist() == ["gradient_x", "gradient_y", "gradient_z"]
    assert set(found.areas.group) == {"OB"}
    assert found.areas.side.tolist() == ["mid"] * 3
    np.testing.assert_allclose(found.extent_m, explicit[1], rtol=1e-12)
    columns = np.array([found.rows[label] for label in outputs.labels])
    agree(columns, explicit[0], 1e-10)
    more = with_gradients(outputs, found)
    np.testing.assert_array_equal(more.rows, np.hstack([outputs.rows, columns]))
    assert len(set(more.area_id.tolist())) == len(more.areas) == len(outputs.areas) + 3


def test_levels_act_on_them(project: Project, tmp_path: Path) -> None:
    """By name, or by what they share with means: a ratio of gradients alone is lognormal as its level is."""
    level = """
[uncertainty]
samples = 1000
[[uncertainty.level]]
name = "stability"
{}
relative_sigma = 0.3
distribution = "lognormal"
source = "-"
"""
    for number, (selected, means_too) in enumerate(
        [('areas = ["bench grad ?"]', False), ('shield = ["inside"]', True)]
    ):
        path = tmp_path / f"{number}.toml"
        path.write_text(project.cases.read_text(encoding="utf-8") + level.format(selected), encoding="utf-8")
        changed = replace(project, cases=path)
        for case_id, wanted in (("alone", True), ("means", means_too)):
            run_cases(changed, [case_id], tmp_path / "x.h5", silent)
            with open_checked(tmp_path / "x.h5", CASE) as file:
                case = read_case(file)
            assert case.uncertainty is not None
            assert not case.uncertainty.left_out, "with levels alone, all is known"
            for d in case.uncertainty.verdicts:
                spread = np.log(d.percentile(95) / d.percentile(5))
                if case_id == "alone":
                    assert spread == pytest.approx(2.0 * 1.645 * 0.3, rel=0.02)
                    assert d.percentile(50) == pytest.approx(d.nominal, rel=0.01)
                else:
                    assert bool(spread > 0.01) is wanted
    path.write_text(path.read_text(encoding="utf-8").replace('["inside"]\nrel', '["inside"]\nareas = ["b grad"]\nrel'))
    with pytest.raises(ConfigError, match=r"no thermal area has 'b grad'.*bench grad"):
        run_cases(replace(project, cases=path), ["alone"], tmp_path / "x.h5", silent)


def test_their_noise_and_verdicts_are_those_of_loads(project: Project, files: dict[str, Path], explicit: tuple) -> None:
    """Of the same fields as areas with unit loads of their own: spectra, ratios, bounds and contributions."""
    config = load_cases(project.cases)[1]
    outputs = read_outputs(project)
    found = case_gradients(project, config, outputs).of("alone")
    assert found is not None
    loads = Outputs(found.areas, explicit[0], outputs.labels, outputs.kinds)
    temperature = TemperatureModel.from_spectra([WhiteSpectrum(LEVEL)] * 3, np.ones(3, dtype=bool))
    wanted = run_case(config.case("alone"), loads, temperature, config.frequency_hz(), config.criteria())
    with open_checked(files["alone"], CASE) as file:
        case, psd = read_case(file), np.array([file.array(CASE.PSD.of(label)) for label in outputs.labels])
        maximum = np.array([file.array(CASE.BOUNDS_MAXIMUM.of(label)) for label in outputs.labels])
        assert file.string(CASE.TEMPERATURE_MODEL).endswith("; 0.003 K/m/sqrt(Hz), white")
    assert [j.ratio for j in case.judged] == pytest.approx([v.ratio for v in wanted.verdicts], rel=1e-8)
    assert all(j.ratio > 0.0 for j in case.judged)
    noisy = wanted.psd > 1e-16 * wanted.psd.max(axis=0)
    np.testing.assert_allclose(psd[noisy], wanted.psd[noisy], rtol=1e-6)
    np.testing.assert_allclose(maximum[noisy], wanted.bounds.maximum[noisy], rtol=1e-6)
    for judged in case.judged:
        row = outputs.labels.index(judged.output)
        np.testing.assert_allclose(judged.share[-3:], wanted.contributions.share[row], atol=1e-8)
        np.testing.assert_array_equal(judged.share[:-3], 0.0)


def test_what_moves_in_a_read_out_is_not_told(files: dict[str, Path]) -> None:
    """By what optical element: the adjoint has whole read-outs. So neither is it without the motion of the bench."""
    with open_checked(files["alone"], CASE) as file:
        judged = read_case(file).judged
    for j in (j for j in judged if j.kind == "displacement"):
        assert j.path is not None
        assert j.path[NOT_TOLD] == pytest.approx(1.0)
        assert j.distortion_ratio is None
    with open_checked(files["means"], CASE) as file:
        of_means = [j for j in read_case(file).judged if j.kind == "displacement"]
    assert of_means
    assert all(j.path is not None and NOT_TOLD not in j.path and j.distortion_ratio is not None for j in of_means)


def test_cases_without_them_are_as_they_were(small: Project, files: dict[str, Path]) -> None:
    """They have the areas of the model alone."""
    with open_checked(files["means"], CASE) as file, open_checked(small.build_dir / "case01.h5", CASE) as before:
        assert read_areas(file).name.tolist() == read_areas(before).name.tolist()
        for output in ("TM1_a_x", "A_TM2_x"):
            np.testing.assert_array_equal(file.array(CASE.PSD.of(output)), before.array(CASE.PSD.of(output)))
        np.testing.assert_array_equal(file.array(CASE.CORRELATION_REAL), before.array(CASE.CORRELATION_REAL))


def test_blocks_part_means_and_gradients_unless_they_are_across_kinds(files: dict[str, Path]) -> None:
    with open_checked(files["with_means"], CASE) as file, open_checked(files["means"], CASE) as means:
        areas, block = read_areas(file), read_correlation(file).block
        assert areas.name[areas.within].tolist() == [
            *("bench grad x", "bench grad y", "bench grad z"),
            *("STRUT_5 grad x", "STRUT_5 grad z"),
        ]
        assert set(block[~areas.within]) == {0}
        assert set(block[areas.within]) == {1}
        together, alone = (f.array(CASE.PSD.of("A_TM1_x")) for f in (file, means))
        shares = file.array(CASE.CONTRIBUTION_SHARE)[file.strings(CASE.OUTPUT_LABEL).index("A_TM1_x")]
        at = np.abs(file.array(CASE.FREQUENCY) - 3e-3).argmin()
        assert alone[at] / together[at] == pytest.approx(1.0 - shares[areas.within].sum(), rel=1e-9)
        spectra = read_temperatures([means, file])
        assert "bench grad x, bench grad y, bench grad z" in spectra.name
        assert spectra.unit.count("K/m") == 3
    with open_checked(files["across"], CASE) as file:
        assert set(read_correlation(file).block) == {0}
        assert read_areas(file).within.sum() == 2


def test_a_level_across_an_area_is_over_its_extent(project: Project, files: dict[str, Path]) -> None:
    """Along each of its axes."""
    with open_checked(project.build_dir / "adjoint.h5", ADJOINT) as adjoint:
        i = adjoint.strings(ADJOINT.AREA_NAME).index(ALONE)
        extent = adjoint.array(ADJOINT.AREA_HIGH)[i] - adjoint.array(ADJOINT.AREA_LOW)[i]
    with open_checked(files["across"], CASE) as file:
        level = file.array(CASE.TEMPERATURE_ASD)[file.array(CASE.TEMPERATURE_SPECTRUM)[-2:]]
    np.testing.assert_allclose(level[:, 0], 1e-4 / extent[[0, 2]], rtol=1e-12)
