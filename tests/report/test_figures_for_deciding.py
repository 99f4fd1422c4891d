"""The figures that a decision rests on: their marks are the numbers of the files, and their texts can be read."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np
import pytest
from figure_texts import drawn, overlaps, shown_texts
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from tedm_cli.config.project import Project
from tedm_cli.contracts import CASE, SENSITIVITY
from tedm_cli.figures.at_rest import at_rest_figure
from tedm_cli.figures.cases.certainty import certainty_figure
from tedm_cli.figures.cases.contributors import contributors_figure
from tedm_cli.figures.cases.improvement import improvement_figure
from tedm_cli.figures.cases.overlay import overlay_figure
from tedm_cli.figures.cases.small_multiples import cases_figure
from tedm_cli.figures.cases.spectra import case_figure
from tedm_cli.figures.drawing.labels import apart
from tedm_cli.figures.drawing.style import SMALL, pdf, style
from tedm_cli.files.store import open_checked
from tedm_cli.gravity.requirements import DcVerdict
from tedm_cli.noise.areas import AreaTable
from tedm_cli.results.cases.deciding import worth_showing
from tedm_cli.results.cases.noise import CaseNoise, JudgedOutput

KINDS = ("acceleration", "displacement")


def long_names(cases: Sequence[CaseNoise]) -> list[CaseNoise]:
    """The cases with titles, outputs, requirements and groups three times as long."""

    def longer(j: JudgedOutput) -> JudgedOutput:
        m = j.improvement
        factor, level = ({3 * f"{g}_": v for g, v in d.items()} for d in (m.group_factor, m.group_level))
        path = None if j.path is None else {3 * f"{n}_": v for n, v in j.path.items()}
        return dataclasses.replace(
            j, output=3 * j.output, requirement=3 * j.requirement, path=path, path_band=path,
            improvement=dataclasses.replace(m, group_factor=factor, group_level=level),
        )  # fmt: skip

    return [
        dataclasses.replace(
            c,
            title=" ".join(3 * [c.title]),
            judged=tuple(map(longer, c.judged)),
            limits=tuple(dataclasses.replace(q, name=3 * q.name) for q in c.limits),
        )
        for c in cases
    ]


def figures_of(cases: Sequence[CaseNoise], kind: str) -> dict[str, Figure]:
    case, j = worth_showing(cases, kind)[0]
    return {
        "cases": cases_figure(cases, kind),
        "certainty": certainty_figure(cases, kind),
        "contributors": contributors_figure(case, j),
        "improvement": improvement_figure(case, j),
        "all": overlay_figure(cases, kind),
        "case": case_figure(case),
    }


@pytest.mark.parametrize(
    ("setting", "kind"),
    [
        ("as it is", "acceleration"),
        ("one case", "displacement"),
        ("15 cases", "displacement"),
        ("long names", "displacement"),
    ],
)
def test_texts_are_whole_and_clear_of_each_other(
    cases: list[CaseNoise], areas: AreaTable, at_rest: list[DcVerdict], kind: str, setting: str
) -> None:
    if setting == "one case":
        cases = cases[:1]
    if setting == "15 cases":
        cases = [dataclasses.replace(c, id=f"{i}{c.id}") for i in range(5) for c in cases]
    if setting == "long names":
        cases = long_names(cases)
        longer = [np.array([3 * f"{v}_" for v in column]) for column in (areas.name, areas.group)]
        areas = dataclasses.replace(areas, name=longer[0], group=longer[1])
        cases = [dataclasses.replace(c, areas=areas) for c in cases]
        at_rest = [dataclasses.replace(v, test_mass=9 * v.test_mass) for v in at_rest]
    for name, figure in {**figures_of(cases, kind), "at rest": at_rest_figure(at_rest)}.items():
        assert overlaps(drawn(figure)) == [], name
        width, height = figure.get_size_inches()
        assert width == 7.0
        with style():
            box = figure.get_tightbbox()
        assert min(box.x0, box.y0) >= 0.0, name
        assert box.x1 <= width, name
        assert box.y1 <= height, name
        assert min(t.get_fontsize() for t in shown_texts(figure)) >= SMALL, name
        assert "…" not in "".join(t.get_text() for t in shown_texts(figure)), name


def test_four_quantities_in_the_figure_of_a_case(cases: list[CaseNoise]) -> None:
    other = {"acceleration": "angular_acceleration", "displacement": "angle"}
    four = (*cases[0].judged, *(dataclasses.replace(j, kind=other[j.kind]) for j in cases[0].judged))
    figure = case_figure(dataclasses.replace(cases[0], judged=four))
    assert len(figure.axes) == 4
    assert overlaps(drawn(figure)) == []


def curve(axes: Axes, label: str) -> tuple[np.ndarray, np.ndarray]:
    line = next(line for line in axes.get_lines() if line.get_label() == label)
    return np.asarray(line.get_xdata()), np.asarray(line.get_ydata())


@pytest.mark.parametrize("kind", KINDS)
def test_every_case_has_a_panel_with_its_worst_output_and_verdict(cases: list[CaseNoise], kind: str) -> None:
    figure = cases_figure(cases, kind)
    assert len({(a.get_xlim(), a.get_ylim()) for a in figure.axes}) == 1
    for axes, case in zip(figure.axes, cases, strict=True):
        worst = case.worst(kind)
        x, y = curve(axes, worst.output)
        np.testing.assert_array_equal(x, case.frequency_hz * 1e3)
        np.testing.assert_array_equal(y, case.safety_factor * worst.asd)
        words = [t.get_text() for t in axes.texts]
        assert any(w.strip().startswith(case.id) for w in words)
        assert any(w.endswith("pass" if worst.passed else "FAIL") for w in words)
        thick = {float(s.get_linewidth()) > 2.0 for s in axes.spines.values()}
        assert thick == {not worst.passed}, "not by colour alone"


@pytest.mark.parametrize("kind", KINDS)
def test_ranges_are_the_bounds_of_the_files(finished: Project, cases: list[CaseNoise], kind: str) -> None:
    axes = certainty_figure(cases, kind).axes[0]
    low = axes.get_xlim()[0]
    for row, case in enumerate(cases):
        j = case.worst(kind)
        names = {"1": "case01.h5", "2": "case02.h5", "4b": "case4b.h5"}
        with open_checked(finished.build_dir / names[case.id], CASE) as file:
            v = list(zip(file.strings("/verdict/output"), file.strings("/verdict/requirement"), strict=True)).index(
                (j.output, j.requirement)
            )
            ratio = file.array("/bound_ratio/ratio")[v]
            bound = dict(zip(file.strings("/bound_ratio/bound"), ratio, strict=True))
        lines = [line for line in axes.get_lines() if np.all(np.asarray(line.get_ydata()) == row)]
        spans = {
            float(line.get_linewidth()): np.asarray(line.get_xdata())
            for line in lines
            if np.size(line.get_xdata()) == 2
        }
        np.testing.assert_array_equal(spans[1.3], np.maximum([bound["minimum"], bound["maximum"]], low))
        np.testing.assert_array_equal(
            spans[8.0], np.maximum([bound["known_blocks_minimum"], bound["known_blocks"]], low)
        )
        dot = next(line for line in lines if line.get_label() == "ratio")
        assert np.asarray(dot.get_xdata())[0] == pytest.approx(max(j.ratio, low), rel=1e-12)
        assert spans[8.0][0] <= j.ratio * (1 + 1e-9)
        assert j.ratio <= spans[8.0][1] * (1 + 1e-9)


def test_shares_of_every_panel_sum_to_the_whole(cases: list[CaseNoise]) -> None:
    for kind, panels in zip(KINDS, (2, 3), strict=True):
        case, j = worth_showing(cases, kind)[0]
        figure = contributors_figure(case, j)
        assert len(figure.axes) == panels, "optical elements for read-outs alone"
        # The made-up gains and motions do not fit together, so elements do not make up the whole of the noise.
        wholes = [(1.0, 1.0), (1.0, 1.0)]
        if j.path is not None and j.path_band is not None:
            wholes.append((sum(j.path.values()), sum(j.path_band.values())))
        for axes, (at, in_band) in zip(figure.axes, wholes, strict=True):
            assert sum(bar.get_width() for bar in axes.patches) == pytest.approx(100.0 * at)
            band = [float(np.asarray(line.get_xdata())[0]) for line in axes.get_lines() if line.get_marker() == "D"]
            assert sum(band) == pytest.approx(100.0 * in_band)
        names = [t.get_text() for t in figure.axes[1].get_yticklabels()]
        for name, bar in zip(names, figure.axes[1].patches, strict=True):
            assert bar.get_width() == pytest.approx(100 * j.share[case.areas.name.tolist().index(name)])
            assert bool(bar.get_hatch()) == (bar.get_width() < 0.0)


def test_improvement_shows_the_ratios_and_factors(cases: list[CaseNoise]) -> None:
    case, j = worth_showing(cases, "displacement")[0]
    groups = dict(zip(j.improvement.group_factor, (np.nan, np.inf, 0.25), strict=True))
    matched = {**j.improvement.ratio, "matched": 0.5 * j.improvement.ratio["silenced"]}
    improvement = dataclasses.replace(j.improvement, group_factor=groups, ratio=matched, all_factor=0.5)
    upper, lower = improvement_figure(case, dataclasses.replace(j, improvement=improvement)).axes
    for name, ratio in matched.items():
        x, y = curve(upper, name)
        most = max(map(len, improvement.chosen.values()))
        np.testing.assert_array_equal(x, np.minimum(improvement.count[: len(x)], most))
        assert x[-1] == min(most, improvement.count[-1]), "no more areas than there are to improve"
        assert len(set(x.tolist())) == len(x)
        np.testing.assert_allclose(y, np.maximum(ratio[: len(y)], 1e-4 * j.ratio))
        assert y[0] == pytest.approx(j.ratio * (0.5 if name == "matched" else 1.0))
    words = [t.get_text() for t in lower.texts]
    assert "cannot meet it alone" in words[0]
    assert "not felt" in words[1]
    ends = [bar.get_x() + bar.get_width() for bar in lower.patches]
    assert ends[1:] == pytest.approx([0.25, 0.5])
    assert ends[0] == pytest.approx(lower.get_xlim()[1]), "not felt: as far as the axis goes"


def test_level_times_factor_is_the_temperature_noise_of_the_group(
    finished: Project, cases: list[CaseNoise], areas: AreaTable
) -> None:
    with open_checked(finished.build_dir / "case02.h5", CASE) as file:
        at = int(np.abs(file.array("/frequency") - cases[1].worst("displacement").binding_hz).argmin())
        asd = file.array("/temperature/asd")[file.array("/temperature/spectrum"), at]
    for group, level in cases[1].worst("displacement").improvement.group_level.items():
        found = set(asd[areas.group == group])
        assert found == {level}


def test_marks_at_rest_are_values_over_limits(finished: Project, at_rest: list[DcVerdict]) -> None:
    with open_checked(finished.build_dir / "sensitivity.h5", SENSITIVITY) as file:
        value, lower, upper = (file.array(f"/dc_verdict/{c}") for c in ("value", "lower", "upper"))
        pairs = zip(*(file.strings(f"/dc_verdict/{c}") for c in ("test_mass", "minus")), strict=True)
    masses = np.array(["-".join(filter(None, pair)) for pair in pairs])
    wanted = np.where(value >= 0, value / upper, value / lower)
    figure = at_rest_figure(at_rest)
    for axes, mass in zip(figure.axes, dict.fromkeys(masses), strict=True):
        marks = [line for line in axes.get_lines() if line.get_marker() in "osD^"]
        assert len(marks) == int((masses == mass).sum())
        shown = [float(np.asarray(line.get_xdata())[0]) for line in marks]
        np.testing.assert_allclose(shown, np.maximum(wanted[masses == mass], axes.get_xlim()[0]))
        failed = [t.get_text() for t in axes.texts if "FAIL" in t.get_text()]
        assert len(failed) == int((wanted[masses == mass] > 1.0).sum())


def test_places_keep_apart_and_in_the_room() -> None:
    places = apart([0.5, 0.49, 2.0, 0.51], 0.15, 2.0)
    assert np.all(np.diff(np.sort(places)) >= 0.15 - 1e-12)
    assert max(places) <= 2.0
    assert np.argsort(places).tolist() == [1, 0, 3, 2]


def test_pdf_is_the_same_every_time_and_embeds_truetype(cases: list[CaseNoise]) -> None:
    first = pdf(certainty_figure(cases, "displacement"), "title", ["case01.h5 abc"])
    assert pdf(certainty_figure(cases, "displacement"), "title", ["case01.h5 abc"]) == first
    assert b"/FontFile2" in first
    assert b"/Type3" not in first
    assert b"case01.h5 abc" in first
