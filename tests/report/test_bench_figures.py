"""Figures of the optics: every beam and element is there, to scale, named legibly, and matrices keep their numbers."""

from __future__ import annotations

import dataclasses
import itertools
from pathlib import Path

import numpy as np
import pytest
from figure_texts import cells, drawn
from matplotlib.axes import Axes
from matplotlib.colors import to_hex, to_rgb
from matplotlib.figure import Figure
from matplotlib.patches import PathPatch, Polygon
from report_project import LAYOUT

from tedm_cli.arrays import FloatArray
from tedm_cli.config.optics.layout import load_layout
from tedm_cli.config.project import Project
from tedm_cli.errors import UsageError
from tedm_cli.figures.drawing.cells import signed_colours
from tedm_cli.figures.drawing.labels import crossing
from tedm_cli.figures.drawing.pages import NUMBER, map_pages, without_twins
from tedm_cli.figures.drawing.style import COLOURS
from tedm_cli.figures.model.area_maps import noise_map
from tedm_cli.figures.optics.bench import (
    GHOST,
    INK,
    SHARED,
    bench_figure,
    exaggerated_figure,
    factor_text,
    length_text,
    tint,
)
from tedm_cli.figures.optics.bench_shapes import interferometers, outline
from tedm_cli.figures.optics.matrix import sensitivity_map
from tedm_cli.figures.optics.shares import ReadOutShares, shares_figure
from tedm_cli.optics.bodies import body
from tedm_cli.optics.exaggerated import ExaggeratedBench, exaggerated_bench, traced_bench
from tedm_cli.optics.invariances import scaled_matrix
from tedm_cli.optics.layout import OpticalLayout
from tedm_cli.optics.sensitivity import optical_sensitivity
from tedm_cli.optics.trace import nominal_poses
from tedm_cli.progress import silent
from tedm_cli.results.areas import read_areas
from tedm_cli.results.build_folder import open_results
from tedm_cli.results.optics import read_out_maps
from tedm_cli.results.wording import number_text
from tedm_cli.stages.reporting.plot import plot
from tedm_cli.stages.reporting.plot_optics import worst_area


@pytest.fixture(scope="module")
def layout() -> OpticalLayout:
    return load_layout(LAYOUT)[1]


@pytest.fixture(scope="module")
def loaded(layout: OpticalLayout) -> ExaggeratedBench:
    motion = 1e-7 * np.random.default_rng(1).normal(size=(len(layout.elements), 6))
    motion[:2] = 0.0  # test masses
    return exaggerated_bench(layout, motion)


@pytest.fixture(scope="module")
def bench(layout: OpticalLayout) -> Figure:
    return drawn(bench_figure(layout, traced_bench(layout)))


@pytest.fixture(scope="module")
def under_load(layout: OpticalLayout, loaded: ExaggeratedBench) -> Figure:
    return drawn(exaggerated_figure(layout, loaded, "1 K on IS1_$a$_b", ["set A reads nothing"]))


def pieces(axes: Axes, gid: str) -> FloatArray:
    """Segments [n, 2, 2] (mm) of what is drawn under a name."""
    found = [p for p in axes.patches if p.get_label() == gid]
    assert len(found) == 1
    assert isinstance(found[0], PathPatch)
    return np.asarray(found[0].get_path().vertices).reshape(-1, 2, 2)


def bodies(axes: Axes) -> dict[str, Polygon]:
    return {str(p.get_label()): p for p in axes.get_children() if isinstance(p, Polygon) and p.get_label()}


def test_photodiodes_of_one_recombiner_are_one_interferometer(layout: OpticalLayout) -> None:
    assert interferometers(layout) == [("PD1A", "PD1B"), ("PD12A", "PD12B")]


def test_every_segment_of_every_beam_is_drawn_once(layout: OpticalLayout, bench: Figure) -> None:
    axes, traced = bench.axes[0], traced_bench(layout)
    for beam in ("meas", "ref"):
        shown = np.concatenate([pieces(axes, f"{beam} {owner}") for owner in (-1, 0, 1)])
        keys = {tuple(np.round(s.reshape(-1), 6)) for s in shown}
        assert len(keys) == len(shown)
        wanted = set()
        for i, path in enumerate(layout.paths):
            if path.beam == beam:
                corners = 1e3 * traced.beam(i)[:, :2]
                wanted |= {tuple(np.round(np.concatenate(s), 6)) for s in itertools.pairwise(corners)}
        assert keys == wanted


def test_shared_beams_are_those_before_the_splitters(layout: OpticalLayout, bench: Figure) -> None:
    """The measurement beam is split by BS3 and the reference beam by BS6; before, both interferometers share it."""
    axes = bench.axes[0]
    ends = {"meas": "BS3", "ref": "BS6"}
    for beam, splitter in ends.items():
        last = pieces(axes, f"{beam} -1")[-1, 1]
        shape = outline(1e3 * body(layout, layout.index(splitter), nominal_poses(layout))[:, :2])
        assert np.linalg.norm(last - shape.mean(axis=0)) < 5.0


def test_bodies_have_their_real_sizes(layout: OpticalLayout, bench: Figure) -> None:
    """Sides of test masses, thickness and clear width of plates, seen edge-on from above."""
    shapes = bodies(bench.axes[0])
    assert set(shapes) == {e.name for e in layout.elements}
    for e in layout.elements:
        corners = np.asarray(shapes[e.name].get_xy())
        normal = np.array(e.normal[:2])
        across, along = (corners @ axis for axis in (normal, np.array([-normal[1], normal[0]])))
        if e.kind == "test_mass":
            assert np.ptp(across) == pytest.approx(46.0)
            assert np.ptp(along) == pytest.approx(46.0)
            assert across.max() == pytest.approx(1e3 * (np.array(e.ref_m[:2]) @ normal + e.front_offset_m))
        elif e.kind in ("window", "beamsplitter"):
            assert isinstance(e.aperture_m, float)
            assert np.ptp(across) == pytest.approx(1e3 * e.thickness_m)
            assert np.ptp(along) == pytest.approx(2e3 * e.aperture_m, rel=1e-3)


def test_names_stand_clear_of_each_other(bench: Figure, under_load: Figure, layout: OpticalLayout) -> None:
    for figure in (bench, under_load):
        for number, axes in enumerate(figure.axes):
            names = [t for t in axes.texts if t.get_text() in {e.name for e in layout.elements}]
            assert len(names) == (24 if number == 0 else 8)
            boxes = [t.get_window_extent() for t in names]
            for a, b in itertools.combinations(boxes, 2):
                assert not a.overlaps(b)
            for box in boxes:
                assert axes.bbox.x0 <= box.x0
                assert box.x1 <= axes.bbox.x1
                assert axes.bbox.y0 <= box.y0
                assert box.y1 <= axes.bbox.y1


def test_names_of_photodiodes_lie_on_no_beam(bench: Figure, layout: OpticalLayout) -> None:
    axes = bench.axes[0]
    lines = np.concatenate([pieces(axes, f"{beam} {owner}") for beam in ("meas", "ref") for owner in (-1, 0, 1)])
    for text in axes.texts:
        if text.get_text() in layout.photodiodes:
            box = text.get_window_extent().transformed(axes.transData.inverted())
            assert not crossing(lines, np.array([[box.x0, box.y0]]), np.array([[box.x1, box.y1]])).any(), (
                text.get_text()
            )


def test_a_segment_crosses_a_box_where_points_of_it_lie_inside() -> None:
    rng = np.random.default_rng(2)
    segments = rng.uniform(-2, 2, size=(400, 2, 2))
    segments[:40, 1, 0] = segments[:40, 0, 0]  # upright
    segments[40:80, 1, 1] = segments[40:80, 0, 1]  # level
    t = np.linspace(0, 1, 4001)[:, None, None]
    points = segments[:, 0] + t * (segments[:, 1] - segments[:, 0])
    dense = np.all(np.abs(points) < 1.0, axis=-1).any(axis=0)
    exact = crossing(segments, np.array([[-1.0, -1.0]]), np.array([[1.0, 1.0]]))[0]
    assert 100 < dense.sum() < 350
    assert not (dense & ~exact).any()
    assert (exact & ~dense).sum() <= 2, "only where a corner is cut by less than the points are apart"


def test_colours_are_those_that_all_can_tell_apart(bench: Figure, under_load: Figure) -> None:
    safe = {to_hex(c) for c in (*COLOURS, SHARED, GHOST, INK, "#ffffff")}
    safe |= {to_hex(tint(c, w)) for c in (*COLOURS, SHARED) for w in (0.4, 0.6, 0.7)}
    for figure in (bench, under_load):
        for axes in figure.axes:
            for patch in axes.get_children():
                if isinstance(patch, PathPatch | Polygon):
                    for colour in (patch.get_facecolor(), patch.get_edgecolor()):
                        assert np.asarray(colour)[3] == 0.0 or to_hex(colour) in safe
    first, second = (to_rgb(COLOURS[i]) for i in (0, 1))
    assert np.abs(np.subtract(first, second)).max() > 0.5


def test_legends_and_units(bench: Figure, under_load: Figure) -> None:
    wanted = {f"{word} beam{whose}" for word in ("measurement", "reference")
              for whose in (" to PD1A, PD1B", " to PD12A, PD12B", ", shared")}  # fmt: skip
    wanted |= {"test mass", "window or beam-splitter", "mirror", "injector", "photodiode"}
    assert {t.get_text() for t in bench.legends[0].get_texts()} == wanted
    assert {t.get_text() for t in under_load.legends[0].get_texts()} == wanted | {"before", "motion of an element"}
    assert [(a.get_xlabel(), a.get_ylabel()) for a in bench.axes] == [("x (mm)", "y (mm)")]
    assert [(a.get_xlabel(), a.get_ylabel()) for a in under_load.axes] == [("x (mm)", "y (mm)"), ("x (mm)", "z (mm)")]
    for figure in (bench, under_load):
        box = figure.get_tightbbox()
        assert box.x0 >= 0
        assert box.y0 >= 0
        assert box.x1 <= figure.get_size_inches()[0]
        assert box.y1 <= figure.get_size_inches()[1]
        assert figure.legends[0].get_window_extent().y1 <= min(a.get_tightbbox().y0 for a in figure.axes)


def test_scale_bar_is_as_long_as_it_says(bench: Figure, under_load: Figure, loaded: ExaggeratedBench) -> None:
    for figure in (bench, under_load):
        bar = next(line for line in figure.axes[0].get_lines() if line.get_label() == "scale")
        length = float(np.ptp(np.asarray(bar.get_xdata())))
        text = next(t.get_text() for t in figure.axes[0].texts if f"{length:g} mm" in t.get_text())
        if figure is under_load:
            assert text == f"bench {length:g} mm, motion {length_text(1e-3 * length / loaded.factor)}"


def test_load_is_drawn_before_and_after(layout: OpticalLayout, loaded: ExaggeratedBench, under_load: Figure) -> None:
    texts = [t.get_text() for t in under_load.texts]
    assert texts == [f"1 K on IS1_$a$_b: motions × {factor_text(loaded.factor)}", "set A reads nothing"]
    for axes, rows in zip(under_load.axes, ([0, 1], [0, 2]), strict=True):
        ghost = pieces(axes, "before: beams")
        after = np.concatenate([pieces(axes, f"{b} {o}") for b in ("meas", "ref") for o in (-1, 0, 1)])
        for shown, traced in ((ghost, loaded.before), (after, loaded.after)):
            keys = {tuple(np.round(s.reshape(-1), 6)) for s in shown}
            for i in range(len(layout.paths)):
                corners = 1e3 * traced.beam(i)[:, rows]
                assert {tuple(np.round(np.concatenate(s), 6)) for s in itertools.pairwise(corners)} <= keys
        arrows = axes.collections[-1]
        moved = 1e3 * (loaded.after.poses.ref - loaded.before.poses.ref)[2:, rows]
        np.testing.assert_allclose(np.stack([arrows.U, arrows.V], axis=1), moved, atol=1e-12)


def test_unknown_sizes_are_dotted(layout: OpticalLayout) -> None:
    bare = dataclasses.replace(layout, elements=tuple(dataclasses.replace(e, aperture_m=None) for e in layout.elements))
    figure = bench_figure(bare, traced_bench(bare))
    looks = {name: p.get_linestyle() for name, p in bodies(figure.axes[0]).items()}
    assert {name for name, look in looks.items() if look == ":"} == {e.name for e in layout.bench}
    assert "dotted: size not given" in {t.get_text() for t in figure.legends[0].get_texts()}


def test_a_bench_out_of_plane_is_seen_from_the_side(layout: OpticalLayout) -> None:
    """The same bench stood on edge: what was y is z, and the view from the side is the old one from above."""

    def turned(v: tuple[float, float, float]) -> tuple[float, float, float]:
        return (v[0], -v[2], v[1])

    upright = dataclasses.replace(
        layout,
        elements=tuple(
            dataclasses.replace(
                e, ref_m=turned(e.ref_m), normal=turned(e.normal), local_y=e.local_y and turned(e.local_y)
            )
            for e in layout.elements
        ),
    )
    figure = bench_figure(upright, traced_bench(upright))
    assert [a.get_title(loc="left") for a in figure.axes] == ["from above", "from the side"]
    flat = bench_figure(layout, traced_bench(layout))
    np.testing.assert_allclose(pieces(figure.axes[1], "meas 1"), pieces(flat.axes[0], "meas 1"), atol=1e-9)


def test_each_of_two_benches_is_seen_from_the_side_by_itself() -> None:
    """With the names, beams and colours that it has from above; nothing is shared, and nothing is called so."""
    two = load_layout(LAYOUT.parent / "lisa_like" / "optics.toml")[1]
    motion = 1e-7 * np.random.default_rng(1).normal(size=(len(two.elements), 6))
    figure = drawn(exaggerated_figure(two, exaggerated_bench(two, motion), "1 K", ["nothing"]))
    above, *sides = figure.axes
    assert [a.get_title(loc="left").split(",")[0] for a in sides] == ["OB1 from the side", "OB2 from the side"]
    for number, (axes, mark) in enumerate(zip(sides, "12", strict=True)):
        names = {e.name for e in two.elements if mark in e.name}
        assert set(bodies(axes)) == names
        assert {t.get_text() for t in axes.texts} < names
        assert len(pieces(axes, f"meas {number}")) == len(pieces(above, f"meas {number}")) > 5
        assert len(pieces(axes, f"ref {number}")) == len(pieces(above, f"ref {number}")) > 3
        assert f"meas {1 - number}" not in {p.get_label() for p in axes.patches}
    assert set(bodies(above)) == {e.name for e in two.elements}
    assert not [t for t in figure.legends[0].get_texts() if "shared" in t.get_text()]


def test_map_of_s_bw_holds_the_matrix(layout: OpticalLayout) -> None:
    matrix = optical_sensitivity(layout)
    figure = drawn(sensitivity_map(layout, matrix))
    panels = [a for a in figure.axes if cells(a)]
    value = scaled_matrix(layout, matrix)
    shade, columns = signed_colours(value).hex(value), 0
    for axes in panels:
        shown = cells(axes)
        wide = 6 * len(axes.get_xticklabels())
        for (row, column), colour in np.ndenumerate(shade[:, columns : columns + wide]):
            assert shown.get((row, column), "#ffffff") == colour
        columns += wide
    assert columns == value.shape[1]
    assert [t.get_text() for a in panels for t in a.get_xticklabels()] == [e.name for e in layout.elements]
    for axes in panels:
        assert [t.get_text() for t in axes.get_yticklabels()] == [p.label for p in layout.paths]
    block = next(a for a in figure.axes if a.get_ylabel() == "every block:")
    assert [t.get_text() for t in block.get_yticklabels()] == ["x", "y", "opl", "z1", "z2"]
    assert [t.get_text() for t in block.get_xticklabels()] == ["ux", "uy", "uz", "rx", "ry", "rz"]


def test_signs_of_s_bw_are_told_without_colour(layout: OpticalLayout) -> None:
    """A bar in every negative cell, and in no other."""
    matrix = optical_sensitivity(layout)
    value = scaled_matrix(layout, matrix)
    figure = sensitivity_map(layout, matrix)
    columns = 0
    for axes in (a for a in figure.axes if cells(a)):
        bars = [p for p in axes.get_children() if isinstance(p, PathPatch) and not p.get_fill()]
        ends = np.concatenate([np.asarray(p.get_path().vertices).reshape(-1, 2, 2) for p in bars])
        shown = {(int(row), int(column)) for column, row in ends.mean(axis=1)}
        wide = 6 * len(axes.get_xticklabels())
        part = value[:, columns : columns + wide]
        assert shown == {tuple(place) for place in np.argwhere(part < -1e-4 * np.abs(value).max())}
        columns += wide


def test_map_of_n_holds_all_sets_with_their_signs(finished: Project) -> None:
    with open_results(finished) as results:
        assert results.read_out is not None
        optics = results.read_out.reader
        maps = read_out_maps(optics)
        areas = read_areas(optics)
        noise = {name: optics.array(f"/N/{name}") for name in ("A", "B")}
    assert [m.unit for m in maps] == ["pm/K", "nrad/K"]
    read_outs = [f"{tm}_{c}" for tm in ("TM1", "TM2") for c in ("x", "eta", "phi")]
    seen = []
    for page in map_pages([without_twins(m) for m in maps], areas, NUMBER):
        figure = drawn(noise_map(page, areas, "N"))
        panels = [a for a in figure.axes if cells(a) or len(a.texts) > len(areas)]
        rows = [(int(y), areas.name.tolist().index(t.get_text()))
                for y, t in zip(panels[0].get_yticks(), panels[0].get_yticklabels(), strict=True)]  # fmt: skip
        for axes in panels:
            told = {t.get_position(): t.get_text() for t in axes.texts}
            for column, label in enumerate(axes.get_xticklabels()):
                for name in label.get_text().split(", "):  # equal read-outs share a column
                    seen.append(name)
                    row = noise[name[0]][read_outs.index(name[2:])]
                    scale = 1e12 if name.endswith("_x") else 1e9
                    for line, area in rows:
                        assert told[column + 0.5, line + 0.5] == number_text(float(scale * row[area])), name
    assert sorted(seen) == sorted(f"{s}_{r}" for s in "AB" for r in read_outs)


def test_bars_sum_to_the_read_out() -> None:
    rng = np.random.default_rng(7)
    by_element = rng.normal(size=(22, 6))
    by_area = rng.normal(size=30)
    by_area[11] = by_element.sum()
    share = ReadOutShares("TM1_x", "pm", by_area, 11, by_element)
    areas, elements = [f"AREA_{i}" for i in range(30)], [f"E{i}" for i in range(22)]
    figure = drawn(shares_figure([share, share], areas, elements, "Shares"))
    left, right = figure.axes[:2]
    assert sum(p.get_width() for p in right.patches) == pytest.approx(by_element.sum(), abs=1e-12)
    assert [t.get_text() for t in right.get_yticklabels()][-1] == "14 others, sum"
    top = [t.get_text() for t in left.get_yticklabels()][:-1]
    assert top == [areas[i] for i in np.argsort(-np.abs(by_area))[:8]]
    assert [p.get_width() for p in left.patches][:8] == [by_area[areas.index(n)] for n in top]
    rest = [v for n, v in zip(areas, by_area, strict=True) if n not in top]
    assert left.patches[8].get_width() == pytest.approx(np.linalg.norm(rest), rel=1e-12)
    assert "TM1_x under AREA_11 by element" in right.get_title(loc="left")
    for axes in (left, right):  # no bar and no marker is cut off
        low, high = axes.get_xlim()
        ends = [x for p in axes.patches for x in (p.get_x(), p.get_x() + p.get_width())]
        assert low < min(ends)
        assert max(ends) < high


def test_worst_area_is_the_first_of_equals() -> None:
    assert worst_area(np.array([1.0, -2.0, 2.0 * (1 + 1e-14)]), np.ones(3, dtype=bool)) == 1


def test_bench_under_a_named_area(finished: Project, tmp_path: Path) -> None:
    paths = plot(finished, tmp_path, silent, ["STRUT_2", "OB <b>&", "STRUT_2"])
    assert [p.name for p in paths] == ["bench_area02_STRUT_2.svg", "bench_area03_OB_b_.svg"]
    text = paths[1].read_text(encoding="utf-8")
    assert "1 K on OB &lt;b&gt;&amp;: motions ×" in text
    assert "sets A and B read TM1_x" in text, "both sets read the same with plane waves"


def test_an_unknown_area_is_refused(finished: Project, tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="no thermal area is called STRUT_9") as caught:
        plot(finished, tmp_path, silent, ["STRUT_1", "STRUT_9"])
    assert caught.value.hint.startswith("did you mean STRUT_")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("value", "shown"),
    [(0.0, "0"), (-0.0001, "0"), (-35453.2, "−35453"), (48.16, "48.2"), (1.204, "1.20"), (-0.054, "−0.054")],
)
def test_numbers_in_narrow_cells(value: float, shown: str) -> None:
    assert number_text(value) == shown


@pytest.mark.parametrize(
    ("factor", "shown"), [(1.0, "1"), (20000.0, "20\N{NO-BREAK SPACE}000"), (3e9, "3 × 10⁹"), (0.05, "5 × 10⁻²")]
)
def test_factors_in_print(factor: float, shown: str) -> None:
    assert factor_text(factor) == shown
