"""Figures of time series and realisations: nothing between the samples is lost, and nothing is added."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from report_project import CASES, make_project, sketch

from tedm_cli.config.project import Project
from tedm_cli.contracts import CASE, SERIES
from tedm_cli.errors import InputError
from tedm_cli.figures.cases.series import series_figure
from tedm_cli.figures.cases.spectra import case_figure
from tedm_cli.files.seal import sha256_of
from tedm_cli.files.store import open_checked
from tedm_cli.progress import silent
from tedm_cli.results.build_folder import open_results
from tedm_cli.results.cases.file import read_case
from tedm_cli.results.cases.noise import Spectrum
from tedm_cli.results.cases.series import MOST_PIECES, piece_starts, read_series, thinned
from tedm_cli.results.titles import output_title
from tedm_cli.results.wording import capital, ratio_text
from tedm_cli.stages.noise.case import run_cases
from tedm_cli.stages.noise.series import run_series
from tedm_cli.stages.reporting.plot_series import series_specs
from tedm_cli.stages.reporting.report import report

EXTRA = """
[realisation]
seed = 1
samples = 30000

[[series]]
name = "warm"
file = "warm.csv"
remove = "mean"

[[series]]
name = "idle"
file = "none.csv"
remove = "mean"
"""
SAMPLES = 12_000


@pytest.fixture(scope="module")
def project(tmp_path_factory: pytest.TempPathFactory) -> Project:
    """One case with a realisation, and one of its two series run."""
    folder = tmp_path_factory.mktemp("series")
    rng = np.random.default_rng(5)
    walk = np.cumsum(rng.normal(size=(SAMPLES, 3)), axis=0)
    table = np.column_stack([10.0 * np.arange(SAMPLES), 293.0 + 1e-5 * walk])
    np.savetxt(folder / "warm.csv", table, delimiter=",", header="time_s,struts,OB,IS1", comments="", fmt="%.12g")
    one = CASES[: CASES.index("[[case]]", CASES.index("[[case]]") + 1)]
    made = make_project(folder, one + EXTRA)
    run_series(made, ["warm"], None, silent)
    return made


def test_a_series_without_spectrum_and_one_that_is_judged_in_part(project: Project) -> None:
    with open_results(project) as results:
        requirements = results.config.applied_requirements()
        drawn = read_series(results.series["warm"], requirements, 0.95)
    nothing = Spectrum(*(np.empty(0) for _ in range(4)))
    bare = replace(drawn, outputs=tuple(replace(o, spectrum=nothing, verdict=None) for o in drawn.outputs))
    figure = series_figure(bare)
    words = [t.get_text() for axes in figure.axes for t in axes.texts]
    assert words == ["too short for a spectrum"] * len(bare.outputs)
    assert all("not judged" in text.get_text() for text in figure.texts[: len(bare.outputs)])
    first = drawn.outputs[0]
    assert first.verdict is not None
    part = replace(first.verdict, judged_hz=(4e-3, 30e-3), whole_band=False)
    figure = series_figure(replace(drawn, outputs=(replace(first, verdict=part),)))
    assert " over 4 to 30 mHz only" in figure.texts[0].get_text().replace("\n", " ")


@given(st.lists(st.floats(1e-9, 1e9), min_size=1, max_size=3000), st.booleans())
def test_thinned_spectra_keep_every_extreme(values: list[float], logarithmic: bool) -> None:
    asd = np.array(values)
    n = len(asd)
    f = np.geomspace(1e-4, 1.0, n) if logarithmic else 1e-4 * np.arange(1, n + 1)
    thin = thinned(Spectrum(f, asd, 0.5 * asd, 2.0 * asd))
    assert len(thin.frequency_hz) <= MOST_PIECES
    assert np.all(np.diff(thin.frequency_hz) > 0)
    assert (thin.least.min(), thin.most.max()) == (asd.min(), asd.max())
    assert (thin.low.min(), thin.high.max()) == (0.5 * asd.min(), 2.0 * asd.max())
    if n <= MOST_PIECES:
        np.testing.assert_array_equal(thin.least, asd)
        np.testing.assert_array_equal(thin.most, asd)


@given(st.integers(1, 10**8))
def test_pieces_cover_the_series(samples: int) -> None:
    start = piece_starts(samples)
    assert start[0] == 0
    width = np.diff(np.append(start, samples))
    assert width.min() >= 1
    assert width.max() - width.min() <= 1


def test_series_are_drawn_where_they_have_been_run(project: Project) -> None:
    with open_results(project) as results:
        specs = series_specs(results)
        assert [s.name for s in specs] == ["series_warm.svg"]
        assert specs[0].section == "series"
        assert specs[0].sources[0].startswith("series_warm.h5 ")


def test_envelope_and_spectrum_are_those_of_the_file(project: Project) -> None:
    with open_results(project) as results:
        data = read_series(results.series["warm"], results.config.applied_requirements(), 0.95)
    figure = series_figure(data)
    with open_checked(project.build_dir / "series_warm.h5", SERIES) as file:
        judged = dict(zip(file.strings("/verdict/output"), file.array("/verdict/ratio"), strict=True))
        worst = {"acceleration": ("TM1_a_x", "TM2_a_x"), "displacement": ("A_TM1_x", "B_TM2_x")}
        for row, o in enumerate(data.outputs):
            assert judged[o.output] == max(judged[name] for name in worst[o.kind])
            series, psd = file.array(f"/series/{o.output}"), file.array(f"/psd/{o.output}")
            parts = np.split(series, piece_starts(SAMPLES)[1:])
            np.testing.assert_array_equal(o.low, [p.min() for p in parts])
            np.testing.assert_array_equal(o.high, [p.max() for p in parts])
            time, right = figure.axes[2 * row], figure.axes[2 * row + 1]
            drawn = time.collections[0].get_paths()[0].vertices[:, 1]
            scale = np.abs(drawn).max() / np.abs(series).max()
            assert np.log10(scale) == pytest.approx(round(np.log10(scale)), abs=1e-9), "a power of ten"
            assert (drawn.min(), drawn.max()) == pytest.approx((scale * series.min(), scale * series.max()))
            line = np.asarray(right.get_lines()[2].get_ydata())
            assert line.max() == pytest.approx(2.0 * np.sqrt(psd.max()), rel=1e-12, abs=0)
            assert line.min() == pytest.approx(2.0 * np.sqrt(psd.min()), rel=1e-12, abs=0)


def test_a_series_of_other_results_is_refused(project: Project) -> None:
    text = project.cases.read_text(encoding="utf-8")
    kept = {p: p.read_bytes() for p in project.build_dir.glob("case*.h5")}
    try:
        project.cases.write_text(text + "\n# another\n", encoding="utf-8")
        run_cases(project, ["1"], None, silent)
        with pytest.raises(InputError) as caught, open_results(project):
            pass
        assert caught.value.where.endswith("series_warm.h5")
        assert "tedm run-series warm" in caught.value.hint
    finally:
        project.cases.write_text(text, encoding="utf-8")
        for path, data in kept.items():
            path.write_bytes(data)


def test_a_realised_case_shows_its_estimate_over_the_exact_curve(project: Project) -> None:
    with open_results(project) as results:
        case = read_case(results.cases[0])
    figure = case_figure(case)
    kinds = list(dict.fromkeys(j.kind for j in case.judged))
    assert len(figure.axes) == 2 * len(kinds)
    with open_checked(project.build_dir / "case01.h5", CASE) as file:
        labels = file.strings("/output/label")
        ratio = np.sqrt(file.array("/realisation/psd") / file.array("/realisation/exact"))
    for kind, axes in zip(kinds, figure.axes[len(kinds) :], strict=True):
        wanted = ratio[labels.index(case.worst(kind).output)]
        line = np.asarray(axes.get_lines()[0].get_ydata())
        assert (line.min(), line.max()) == pytest.approx((wanted.min(), wanted.max()), rel=1e-12)
        edge = axes.collections[0].get_paths()[0].vertices[:, 1]
        assert edge.min() < line.min()
        assert edge.max() > line.max()
        assert axes.get_xlabel() == "frequency (mHz)"


def test_the_report_tells_of_series_and_where_they_come_from(project: Project) -> None:
    sketch(project)
    text = report(project, project.build_dir / "r.md")[1].read_text(encoding="utf-8")
    section = text[text.index("## Time series") :]
    section = section[: section.index("\n## ", 5)]
    with open_checked(project.build_dir / "series_warm.h5", SERIES) as file:
        ratio = dict(zip(file.strings("/verdict/output"), file.array("/verdict/ratio"), strict=True))
        assert file.string("/temperature/source") in section
    for output, value in ratio.items():
        assert f"{capital(output_title(output))} ({output}) | " in section
        assert ratio_text(float(value)) in section
    assert sha256_of(project.build_dir / "series_warm.h5") in text
