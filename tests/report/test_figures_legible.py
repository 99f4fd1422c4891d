"""Every figure at its size on the page: texts whole and clear of each other, keys told apart without colour."""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Callable

import numpy as np
import pytest
from figure_texts import drawn, faults
from matplotlib.figure import Figure

from tedm_cli.config.project import Project
from tedm_cli.figures.at_rest import at_rest_figure
from tedm_cli.figures.cases.overlay import overlay_figure
from tedm_cli.figures.cases.small_multiples import cases_figure
from tedm_cli.figures.cases.spectra import case_figure
from tedm_cli.figures.drawing.cells import signed_colours
from tedm_cli.figures.drawing.fit import text_width, wrapped
from tedm_cli.figures.drawing.pages import CELL, NUMBER, line_count, map_pages, without_twins
from tedm_cli.figures.drawing.spec import PAGE_HEIGHT, PAGE_WIDTH
from tedm_cli.figures.drawing.style import DASHES, KEY, SMALL
from tedm_cli.figures.model.area_maps import map_figure, noise_map
from tedm_cli.figures.optics.shares import ReadOutShares, shares_figure
from tedm_cli.gravity.requirements import DcVerdict
from tedm_cli.noise.areas import AreaTable
from tedm_cli.report.pdf import _width_pt
from tedm_cli.results.areas import AreaMap
from tedm_cli.results.cases.noise import CaseNoise
from tedm_cli.results.titles import outputs_title

LEAST_PT = 6.8  # on the page


def test_every_figure_can_be_read(figures: dict[str, Figure]) -> None:
    found = {name: faults(figure) for name, figure in figures.items()}
    assert {name: f for name, f in found.items() if f} == {}


def test_small_type_is_large_enough_on_the_page(finished: Project) -> None:
    """The size at which the report sets a figure, of those that are drawn and of the largest that may be."""
    largest = f'<svg viewBox="0 0 {72 * PAGE_WIDTH} {72 * PAGE_HEIGHT}">'
    svgs = [path.read_text(encoding="utf-8") for path in (finished.build_dir / "figures").glob("*.svg")]
    assert len(svgs) > 20
    for svg in [largest, *svgs]:
        width = re.search(r'viewBox="\S+ \S+ (\S+) \S+"', svg)
        assert width is not None
        assert SMALL * _width_pt(svg) / float(width[1]) >= LEAST_PT


def many_areas(number: int, letters: int) -> AreaTable:
    """So many areas in seven groups, with names of so many letters."""
    names = [f"A{i:03d}_" + "WIDE_NAME_OF_AN_AREA_THAT_GOES_ON"[: letters - 5] for i in range(number)]
    groups = [f"group {7 * i // number}" for i in range(number)]
    shield, side = (np.array([word] * number) for word in ("inside", "mid"))
    return AreaTable(name=np.array(names), group=np.array(groups), shield=shield, side=side, centroid_m=None)


@pytest.mark.parametrize(("number", "letters"), [(200, 12), (200, 30), (1, 30), (1, 6)])
def test_maps_of_many_and_of_few_areas(number: int, letters: int) -> None:
    areas = many_areas(number, letters)
    rng = np.random.default_rng(3)
    labels = [[f"TM{t}_{kind}_{axis}" for t in (1, 2) for axis in "xyz"] for kind in ("a", "omegadot")]
    sizes = [AreaMap("|S|", unit, names, 10.0 ** rng.uniform(-18, -12, (6, number)))
             for unit, names in zip(("m/s^2/K", "rad/s^2/K"), labels, strict=True)]  # fmt: skip
    signed = [dataclasses.replace(m, value=rng.normal(0, 1e4, m.value.shape)) for m in sizes]
    for maps, cell, draw in ((sizes, CELL, map_figure), (signed, NUMBER, noise_map)):
        pages = map_pages(maps, areas, cell)
        for panel in maps:  # every area once with every output
            rows = np.concatenate([part for page in pages if panel in page.maps for part in page.blocks])
            assert sorted(rows.tolist()) == list(range(number))
        if draw is map_figure or letters == 30:  # thousands of numbers take their time
            assert faults(drawn(draw(pages[0], areas, "A map"))) == []


def test_headings_are_in_plain_words_and_labels_in_small_type(
    figures: dict[str, Figure], cases: list[CaseNoise]
) -> None:
    """Of figures of one judged output; keys name requirements as the report does."""
    labels = {j.output for c in cases for j in c.judged} | {q.name for c in cases for q in c.limits} | {"delta_g"}
    of_one = [name for name in figures if re.match("contributors|improvement|budget|closed_loop_thermal", name)]
    assert len(of_one) > 8
    for name in of_one:
        heading, small, *_ = (t.get_text() for t in figures[name].texts)
        assert [label for label in labels if label in heading] == []
        assert re.search(r"Labels: \w+[^.]*;\s\w+\.", small), name
    for name, figure in figures.items():
        keys = " ".join(t.get_text() for legend in figure.legends for t in legend.get_texts())
        assert [q.name for c in cases for q in c.limits if q.name in keys] == [], name


def test_zero_is_white_and_signs_are_alike() -> None:
    colours = signed_colours(np.array([-3.0, 2.0]))
    assert colours.hex(np.array([0.0])).tolist() == ["#ffffff"]
    assert colours.place(-3.0) == pytest.approx(0.0)
    assert colours.place(0.02) + colours.place(-0.02) == pytest.approx(1.0)


def test_parts_of_a_map_end_with_groups_where_that_is_near() -> None:
    areas = many_areas(100, 10)
    areas = dataclasses.replace(areas, group=np.array(["one"] * 54 + ["two"] * 46))
    (page,) = map_pages([AreaMap("|S|", "m", ["x"], np.ones((1, 100)))], areas, CELL)
    assert [len(part) for part in page.blocks] == [54, 46]
    assert [line_count(areas, part) for part in page.blocks] == [55, 47]


def test_outputs_that_are_equal_share_a_column() -> None:
    value = np.array([[1.0, -2.0], [1.0, -2.0 * (1 + 1e-14)], [1.0, 2.0]])
    merged = without_twins(AreaMap("N", "pm/K", ["A_x", "B_x", "A_y"], value))
    assert merged.labels == ["A_x, B_x", "A_y"]
    np.testing.assert_array_equal(merged.value, value[[0, 2]])


@pytest.mark.parametrize("draw", [overlay_figure, cases_figure])
def test_outputs_of_one_ratio_are_all_named(
    cases: list[CaseNoise], draw: Callable[[list[CaseNoise], str], Figure]
) -> None:
    def tied(case: CaseNoise, factor: float) -> CaseNoise:
        first, *others = case.of_kind("displacement")
        rest = [dataclasses.replace(j, ratio=first.ratio * factor) for j in others]
        return dataclasses.replace(case, judged=(first, *rest), role="likely")

    outputs = [j.output for j in cases[0].of_kind("displacement")]
    assert len(outputs) > 1
    for factor, named in ((1 - 1e-12, outputs), (0.99, outputs[:1])):
        figure = draw([tied(c, factor) for c in cases], "displacement")
        words = " ".join(" ".join(t.get_text().split()) for t in figure.axes[0].texts)
        if draw is overlay_figure:
            assert outputs_title(named) in words
            assert outputs_title(outputs[1:]) not in words.replace(outputs_title(named), "")
        else:
            assert [name for name in outputs if name in words] == named
        assert faults(drawn(figure)) == []
    case = tied(cases[0], 1.0)
    titles = " ".join(a.get_title(loc="left") for a in case_figure(case).axes)
    assert all(name in titles for name in outputs)


def test_one_test_mass_at_rest(at_rest: list[DcVerdict]) -> None:
    figure = at_rest_figure([v for v in at_rest if v.place == "TM1"])
    assert len(figure.axes) == 1
    assert faults(drawn(figure)) == []
    third = [dataclasses.replace(v, test_mass="TM3") for v in at_rest if v.place == "TM1"]
    assert faults(drawn(at_rest_figure([*at_rest, *third]))) == []


def test_other_subsystems_at_rest(at_rest: list[DcVerdict]) -> None:
    """Seven subsystems of long names, by test mass alone: two panels side by side."""
    alone = [dataclasses.replace(v, minus="", test_mass=n) for v in at_rest if v.minus for n in ("TM1", "TM2")]
    names = ["antenna", "power_control_unit", "IS+LTP", "all", "tank_1", "tank_2", "propulsion.thruster_cluster"]
    many = [dataclasses.replace(v, subsystem=names[i % 7]) for i, v in enumerate(alone)]
    figure = at_rest_figure(many)
    assert len({axes.get_position().y0 for axes in figure.axes}) == 1
    assert faults(drawn(figure)) == []
    assert faults(drawn(at_rest_figure([*many, *at_rest]))) == [], "singles and differences of all on one page"


def test_colours_at_rest_mean_one_thing(at_rest: list[DcVerdict]) -> None:
    """The colour of a mark is its verdict and its shape its subsystem, whatever the other is."""
    figure = at_rest_figure(at_rest)
    seen: dict[tuple[str, str], set[tuple[str, bool]]] = {}
    for axes, mass in zip(figure.axes, dict.fromkeys(v.place for v in at_rest), strict=True):
        marks = [line for line in axes.get_lines() if line.get_linestyle() == "None"]
        for mark, v in zip(marks, [v for v in at_rest if v.place == mass], strict=True):
            if mark.get_markerfacecolor() != "white":
                seen.setdefault(("colour", str(mark.get_markerfacecolor())), set()).add(("passed", v.passed))
            seen.setdefault(("shape", str(mark.get_marker())), set()).add((v.subsystem, True))
    assert all(len(meanings) == 1 for meanings in seen.values()), seen
    assert sum(what == "shape" for what, _ in seen) == len({v.subsystem for v in at_rest})
    assert sum(what == "colour" for what, _ in seen) == len({v.passed for v in at_rest})


def test_shares_of_long_names() -> None:
    rng = np.random.default_rng(7)
    areas = many_areas(30, 30).name.tolist()
    elements = [f"BEAMSPLITTER_{i}" for i in range(22)]
    share = ReadOutShares("TM1_x", "pm", 1e4 * rng.normal(size=30), 11, 1e4 * rng.normal(size=(22, 6)))
    assert faults(drawn(shares_figure([share] * 3, areas, elements, "Shares"))) == []


def test_a_sample_of_a_key_shows_two_periods_of_any_dashes() -> None:
    for dashes in DASHES[1:]:
        assert 2 * 1.6 * sum(dashes[1]) - 1.6 * dashes[1][-1] <= KEY * SMALL, "of a line of 1.6 points"
    assert len({str(d) for d in DASHES}) == len(DASHES)


@pytest.mark.parametrize("inches", [0.3, 0.9, 2.0, 9.0])
@pytest.mark.parametrize(
    "text", ["All areas correlated", "A_NAME_WITHOUT_ANY_SPACE_IN_IT", "W" * 60, "a b", "TM1_a_x, TM2_a_x"]
)
def test_wrapped_texts_fit_and_lose_nothing(text: str, inches: float) -> None:
    lines = wrapped(text, inches, SMALL).split("\n")
    assert "".join(lines).replace(" ", "") == text.replace(" ", "")
    assert all(text_width(line, SMALL) <= inches or len(line) == 1 for line in lines)
