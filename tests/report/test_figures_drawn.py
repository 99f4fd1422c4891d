"""What the figures show: the data of the files, with units, and nothing cut off."""

from __future__ import annotations

import dataclasses
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from figure_texts import cells
from hypothesis import given
from hypothesis import strategies as st
from matplotlib import rcParams
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure

from tedm_cli.config.project import Project
from tedm_cli.figures.cases.contributors import contributors_figure
from tedm_cli.figures.cases.overlay import overlay_figure
from tedm_cli.figures.cases.spectra import case_figure
from tedm_cli.figures.drawing.cells import size_colours
from tedm_cli.figures.drawing.pages import CELL, MapPage, map_pages
from tedm_cli.figures.drawing.style import style, svg
from tedm_cli.figures.model.area_maps import map_figure
from tedm_cli.noise.areas import AreaTable
from tedm_cli.noise.flight_results import flight_results
from tedm_cli.report.inline import figure_sources
from tedm_cli.results.areas import AreaMap
from tedm_cli.results.build_folder import open_results
from tedm_cli.results.cases.deciding import worth_showing
from tedm_cli.results.cases.noise import CaseNoise, kinds_of
from tedm_cli.results.ranking import first_largest
from tedm_cli.results.wording import ratio_text, unit_text
from tedm_cli.stages.reporting.plot import figure_specs

OPTICS = {"bench.svg", "s_bw.svg", "read_out_by_area.svg", "shares_displacement.svg", "shares_angle.svg"}

QUANTITIES = ("acceleration", "displacement")


def of_the_optics(name: str) -> bool:
    return name in OPTICS or name.startswith("bench_area")


def one_page(panel: AreaMap, areas: AreaTable) -> tuple[MapPage, AreaTable]:
    (page,) = map_pages([panel], areas, CELL)
    return page, areas


def test_all_figures_of_the_results(figures: dict[str, Figure]) -> None:
    assert set(figures) >= OPTICS
    assert {name for name in figures if not of_the_optics(name)} == {
        "ratios.svg",
        "all_acceleration.svg",
        "all_displacement.svg",
        *(f"{figure}_{kind}.svg" for figure in ("cases", "certainty") for kind in QUANTITIES),
        *(f"{figure}_{kind}_case01.svg" for figure in ("contributors", "improvement") for kind in QUANTITIES),
        "field_at_rest.svg",
        "temperature.svg",
        "self_gravity_by_area.svg",
        "case01.svg",
        "case02.svg",
        "case4b.svg",
        "loop_margins.svg",
        *(f"budget_{output}_case01.svg" for output in ("delta_g", "TM1_a_x", "TM2_a_x", "TM1_x")),
        "closed_loop_thermal_case01.svg",
    }


def test_every_figure_is_documented_by_its_name(figures: dict[str, Figure]) -> None:
    docs = Path(__file__).parents[2] / "docs"
    text = "".join((docs / name).read_text(encoding="utf-8") for name in ("reference/figures.md", "how-to/optics.md"))
    stands_for = {"QUANTITY": f"({'|'.join(QUANTITIES)}|angle)", "NN": r"\w+", "NAME": r"\w+", "OUTPUT": r"\w+"}
    forms = [re.escape(name) for name in re.findall(r"`(\w+\.svg)`", text)]
    for word, pattern in stands_for.items():
        forms = [form.replace(word, pattern) for form in forms]
    assert [name for name in figures if not any(re.fullmatch(form, name) for form in forms)] == []


def test_spectra_and_bars_have_units_on_their_axes(figures: dict[str, Figure]) -> None:
    unit = re.compile(r"\((mHz|K/√Hz|m/√Hz|m s⁻²/√Hz|1|%|10[⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+ (m|m s⁻²)/√Hz)\)$")
    for name, figure in figures.items():
        if "by_area" in name or of_the_optics(name):
            continue
        for axes in figure.axes:
            # Panels that share an axis with others have its numbers, and its label, once.
            if axes.xaxis.get_tick_params().get("labelbottom", True):
                assert unit.search(axes.get_xlabel()), (name, axes.get_xlabel())
            if axes.get_yscale() == "log" and axes.yaxis.get_tick_params().get("labelleft", True):
                assert unit.search(axes.get_ylabel()), (name, axes.get_ylabel())


def test_maps_have_a_unit_on_each_colour_scale(figures: dict[str, Figure]) -> None:
    found = {
        name: [a.get_xlabel() for a in figures[name].axes if a.get_xlabel()]
        for name in ("self_gravity_by_area.svg", "read_out_by_area.svg")
    }
    assert found == {
        "self_gravity_by_area.svg": ["|S_SG| (m/s²/K)", "|S_SG| (rad/s²/K)"],
        "read_out_by_area.svg": ["N (pm/K)", "N (nrad/K)"],
    }


def test_nothing_is_cut_off(figures: dict[str, Figure]) -> None:
    for name, figure in figures.items():
        with style():
            box = figure.get_tightbbox()
        width, height = figure.get_size_inches()
        assert box.x0 >= 0, name
        assert box.y0 >= 0, name
        assert box.x1 <= width, name
        assert box.y1 <= height, name


def test_long_names_are_not_cut_off(cases: list[CaseNoise], areas: AreaTable) -> None:
    long = dataclasses.replace(cases[1], title="A title that goes on and on " * 9)
    named = dataclasses.replace(areas, name=np.array([f"{n}_AND_A_LONG_NAME_TOO" for n in areas.name]))
    case, j = worth_showing(cases, "displacement")[0]
    maps = AreaMap("|N|", "m/K", ["ONE_LONG_OUTPUT_x", "u"], np.ones((2, 5)))
    for figure in (
        case_figure(long),
        contributors_figure(dataclasses.replace(case, areas=named), j),
        map_figure(*one_page(maps, named), "m"),
    ):
        with style():
            box = figure.get_tightbbox()
        assert box.x0 >= 0
        assert box.y0 >= 0
        assert box.x1 <= figure.get_size_inches()[0]
        assert box.y1 <= figure.get_size_inches()[1]


def test_legends_do_not_cover_curves(figures: dict[str, Figure]) -> None:
    seen = 0
    for name, figure in figures.items():
        for axes in figure.axes:
            for legend in (axes.get_legend(), *figure.legends):
                if legend is not None:
                    seen += 1
                    assert not legend.get_window_extent().overlaps(axes.bbox), name
    assert seen


def test_curves_are_the_noise_times_the_safety_factor(cases: list[CaseNoise]) -> None:
    case = cases[1]
    figure = case_figure(case)
    for axes, kind in zip(figure.axes, kinds_of([case]), strict=True):
        drawn = {str(line.get_label()): line for line in axes.get_lines()}
        for j in case.of_kind(kind):
            line = drawn[f"2 × {j.output}"]
            np.testing.assert_array_equal(line.get_xdata(), case.frequency_hz * 1e3)
            np.testing.assert_array_equal(line.get_ydata(), 2.0 * j.asd)


def test_curve_over_limit_at_the_ring_is_the_ratio(cases: list[CaseNoise]) -> None:
    """The figure alone gives the verdict of the file: height of the ring over height of the limit below it."""
    for case in cases:
        figure = case_figure(case)
        for axes, kind in zip(figure.axes, kinds_of([case]), strict=True):
            worst = case.worst(kind)
            ring = next(line for line in axes.get_lines() if line.get_marker() == "o")
            limit = next(line for line in axes.get_lines() if str(line.get_label()).startswith("requirement"))
            at, height = np.asarray(ring.get_xdata())[0], np.asarray(ring.get_ydata())[0]
            x, y = np.asarray(limit.get_xdata()), np.asarray(limit.get_ydata())
            assert x.min() == pytest.approx(1.0)
            assert x.max() == pytest.approx(30.0)
            assert height / y[np.flatnonzero(x == at)[0]] == pytest.approx(worst.ratio, rel=1e-12)


def test_bounds_hold_the_curve_they_belong_to(cases: list[CaseNoise]) -> None:
    for case in cases:
        for j in case.judged:
            assert np.all(j.asd <= j.bound_high * (1 + 1e-9))
            assert np.all(j.asd >= j.bound_low * (1 - 1e-9))
            assert j.correlation_ratio[0] <= j.ratio * (1 + 1e-9)
            assert j.correlation_ratio[1] >= j.ratio * (1 - 1e-9)


def test_overlay_shows_what_was_measured_in_flight(cases: list[CaseNoise]) -> None:
    """Where it was measured: the free fall of LISA Pathfinder from 0.7 to 20 mHz, its read-out above 60 mHz."""
    for kind, level, ends in (("acceleration", 5.2e-15, (0.7, 20.0)), ("displacement", 34.8e-15, (60.0, 100.0))):
        axes = overlay_figure(cases, kind).axes[0]
        (line,) = [line for line in axes.get_lines() if "in flight" in str(line.get_label())]
        assert tuple(line.get_xdata()) == pytest.approx(ends, rel=1e-12)
        assert set(line.get_ydata()) == {level}
        assert axes.get_ylim()[0] < level < axes.get_ylim()[1]
    named = ["lisa_oms", "lpf_readout"]
    assert [r.amplitude for r, _ in flight_results("displacement", 0.1, 1.0, named)] == [34.8e-15, 32.0e-15]
    assert not flight_results("angle", 1e-4, 1.0, named)


def test_overlay_of_another_mission_shows_nothing_from_flight(finished: Project, cases: list[CaseNoise]) -> None:
    """Neither its level nor its name; the limits are all of another name."""
    others = [
        dataclasses.replace(
            case,
            judged=tuple(dataclasses.replace(j, requirement="lisa_oms") for j in case.judged),
            limits=tuple(dataclasses.replace(limit, name="lisa_oms") for limit in case.limits),
        )
        for case in cases
    ]
    for kind in ("acceleration", "displacement"):
        lines = overlay_figure(others, kind).axes[0].get_lines()
        assert lines
        assert not [line for line in lines if "in flight" in str(line.get_label())]
    with open_results(finished) as results:
        for shown, told in ((cases, True), (others, False)):
            captions = [s.caption for s in figure_specs(results, shown) if s.name.startswith("all_")]
            assert captions
            assert all(("For orientation" in caption) == told for caption in captions)


def test_overlay_names_the_likely_cases_in_the_order_of_the_curves_and_the_others_in_the_key(
    cases: list[CaseNoise],
) -> None:
    roles = dict(zip(("1", "2", "4b"), ("likely", "diagnostic", "likely"), strict=True))
    cases = [dataclasses.replace(c, role=roles[c.id]) for c in cases]
    figure = overlay_figure(cases, "displacement")
    axes = figure.axes[0]
    heights = {t.get_text().split(":")[0]: t.get_position()[1] for t in axes.texts}
    assert set(heights) == {"case 1", "case 4b"}
    ends = {f"case {c.id}": c.worst("displacement").asd[-1] for c in cases if c.role == "likely"}
    assert sorted(heights, key=heights.__getitem__) == sorted(ends, key=ends.__getitem__)
    assert "diagnostic: case 2" in {t.get_text() for t in figure.legends[0].get_texts()}
    lines = {str(line.get_label()): line for line in axes.get_lines()}
    grey = to_rgb(lines["case 2"].get_color())
    assert max(grey) == min(grey)
    for name in heights:
        assert lines[name].get_linewidth() > 2 * lines["case 2"].get_linewidth()
        assert max(to_rgb(lines[name].get_color())) > min(to_rgb(lines[name].get_color()))


def test_overlay_without_likely_cases_names_those_that_can_occur(cases: list[CaseNoise]) -> None:
    roles = dict(zip(("1", "2", "4b"), ("possible", "diagnostic", "possible"), strict=True))
    figure = overlay_figure([dataclasses.replace(c, role=roles[c.id]) for c in cases], "displacement")
    assert {t.get_text().split(":")[0] for t in figure.axes[0].texts} == {"case 1", "case 4b"}
    figure = overlay_figure([dataclasses.replace(c, role="diagnostic") for c in cases], "displacement")
    assert len(figure.axes[0].texts) == 3


def test_map_shows_each_area_in_the_row_of_its_name(areas: AreaTable) -> None:
    value = np.array([[1e-3, 2e-3, 3e-3, 4e-3, 5e-3], [-6e-3, 7e-3, -8e-3, 9e-3, 1e-2]])
    figure = map_figure(*one_page(AreaMap("|N|", "m/K", ["u", "v"], value), areas), "map")
    axes, shade = figure.axes[0], size_colours(np.abs(value)).hex(np.abs(value))
    shown = cells(axes)
    assert len(shown) == value.size
    for label, place in zip(axes.get_yticklabels(), axes.get_yticks(), strict=True):
        area = areas.name.tolist().index(label.get_text())
        assert [shown[int(place), output] for output in (0, 1)] == shade[:, area].tolist()
        above = [t for t in axes.texts if t.get_position()[1] < place]
        assert max(above, key=lambda t: t.get_position()[1]).get_text() == areas.group[area]
    assert len(set(shade.reshape(-1))) == value.size, "all sizes differ, so do their colours"


def test_map_of_an_output_without_sensitivity(areas: AreaTable) -> None:
    figure = map_figure(*one_page(AreaMap("|N|", "m/K", ["u"], np.zeros((1, 5))), areas), "nothing")
    assert svg(figure, "nothing", []).startswith(b"<?xml")


@pytest.mark.parametrize("name", ["self_gravity_by_area.svg", "read_out_by_area.svg", "s_bw.svg"])
def test_maps_hold_no_picture_that_a_viewer_could_smear(finished: Project, name: str) -> None:
    assert "<image" not in (finished.build_dir / "figures" / name).read_text(encoding="utf-8")


def test_silent_case_is_drawn(cases: list[CaseNoise]) -> None:
    silent = dataclasses.replace(
        cases[0],
        judged=tuple(
            dataclasses.replace(j, asd=0 * j.asd, bound_low=0 * j.asd, bound_high=0 * j.asd, ratio=0.0)
            for j in cases[0].judged
        ),
    )
    assert svg(case_figure(silent), "silent", []).startswith(b"<?xml")
    assert svg(overlay_figure([silent], "acceleration"), "silent", []).startswith(b"<?xml")


def test_bytes_do_not_depend_on_the_users_matplotlib(cases: list[CaseNoise]) -> None:
    first = svg(case_figure(cases[0]), "t", ["a b"])
    before = rcParams["font.size"], rcParams["lines.linewidth"]
    try:
        rcParams["font.size"], rcParams["lines.linewidth"] = 20.0, 7.0
        assert svg(case_figure(cases[0]), "t", ["a b"]) == first
    finally:
        rcParams["font.size"], rcParams["lines.linewidth"] = before
    assert b"dc:date" not in first


def test_sources_can_be_read_back(cases: list[CaseNoise]) -> None:
    text = svg(overlay_figure(cases, "acceleration"), "t <1>", ["case & 1.h5 abc", "case2.h5 def"]).decode()
    assert figure_sources(text) == "case & 1.h5 abc; case2.h5 def"


def test_pyplot_stays_out() -> None:
    code = (
        "import sys; import tedm_cli.figures.cases.spectra, tedm_cli.figures.model.area_maps;"
        " sys.exit('matplotlib.pyplot' in sys.modules)"
    )
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


@given(st.floats(0.9, 1.1))
def test_a_printed_ratio_lies_on_its_side_of_one(ratio: float) -> None:
    shown = float(ratio_text(ratio))
    assert (shown > 1.0) == (ratio > 1.0)
    assert shown == pytest.approx(ratio, rel=5e-3)


def test_rounding_does_not_choose_between_twins() -> None:
    assert first_largest(["a", "b", "c"], [1.0, 2.0, 2.0 * (1 + 1e-15)]) == "b"


@pytest.mark.parametrize(
    ("written", "shown"), [("m s^-2", "m s⁻²"), ("rad/s^2/K", "rad/s²/K"), ("1/(m s^2)", "1/(m s²)"), ("m", "m")]
)
def test_units_in_print(written: str, shown: str) -> None:
    assert unit_text(written) == shown
