"""Figures of the closed loop: margins, budgets and the part of the temperatures are those of the files."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Circle

from tedm_cli.config.project import Project
from tedm_cli.dynamics.controller import LOOPS
from tedm_cli.figures.drawing.spec import FigureSpec
from tedm_cli.figures.drawing.style import style
from tedm_cli.figures.dynamics import budget_figure, loops_figure, thermal_figure
from tedm_cli.results.build_folder import open_results
from tedm_cli.results.dynamics.loop import AT_READ_OUTS, ClosedLoop, LoopOutput, SimulatedCase, read_closed_loop
from tedm_cli.stages.reporting.plot_dynamics import budget_words, dynamics_specs, loop_words


def loop_of(project: Project) -> ClosedLoop:
    with open_results(project) as results:
        found = read_closed_loop(results.dynamics, results.simulations)
    assert found is not None
    return found


def specs_of(project: Project) -> dict[str, FigureSpec]:
    with open_results(project) as results:
        return {spec.name: spec for spec in dynamics_specs(results)}


@pytest.fixture(scope="module")
def closed(finished: Project) -> ClosedLoop:
    return loop_of(finished)


@pytest.fixture(scope="module")
def drawn(finished: Project) -> dict[str, tuple[FigureSpec, Figure]]:
    return {name: (spec, spec.draw()) for name, spec in specs_of(finished).items()}


def curves(axes: Axes) -> dict[str, Line2D]:
    return {str(line.get_label()): line for line in axes.get_lines()}


def height(line: Line2D) -> np.ndarray:
    return np.asarray(line.get_ydata(), dtype=float)


def worst(closed: ClosedLoop) -> Iterator[tuple[SimulatedCase, LoopOutput]]:
    return iter(closed.worst_likely().values())


def test_groups_add_to_the_total(closed: ClosedLoop) -> None:
    """Sources are independent: powers of the groups sum to the power of the output."""
    for case in closed.cases:
        for j in case.judged:
            power = sum(asd**2 for asd in j.group_asd.values())
            np.testing.assert_allclose(power, j.asd**2, rtol=1e-9)
            assert sum(j.share.values()) == pytest.approx(1.0)
            assert sum(j.area_share.values()) == pytest.approx(j.share["thermal"], rel=1e-6, abs=1e-15)


def test_the_budget_shows_the_verdict(closed: ClosedLoop) -> None:
    """Height of the total over height of the limit at the frequency that binds is the ratio of the file."""
    for case, j in worst(closed):
        found = curves(budget_figure(case, j).axes[0])
        total = found["total"]
        at = int(np.abs(case.frequency_hz - j.binding_hz).argmin())
        limit = next(q for q in case.limits if q.name == j.requirement)
        assert height(total)[at] / limit.amplitude[at] == pytest.approx(j.ratio, rel=1e-9)
        black = [line for label, line in found.items() if label.startswith("requirement")]
        assert len(black) == len(case.limits_of(j.output))


def test_each_group_that_is_seen_has_a_line_and_the_others_are_named(closed: ClosedLoop) -> None:
    for case, j in worst(closed):
        figure = budget_figure(case, j)
        found, low = curves(figure.axes[0]), figure.axes[0].get_ylim()[0]
        said = " ".join(text.get_text() for text in figure.texts)
        for name, asd in j.group_asd.items():
            if case.safety_factor * asd.max() > low:
                np.testing.assert_array_equal(height(found[name]), case.safety_factor * asd)
            else:
                assert name not in found
                assert name in said[said.index("Below the axis") :]


def test_open_loops_cross_one_at_their_crossovers(closed: ClosedLoop) -> None:
    """The dot of each loop is where its curve is at gain 1, its phase is above -180° by its margin."""
    figure = loops_figure(closed.stability)
    f = closed.stability.frequency_hz
    names = []
    for number, (family, loops) in enumerate(closed.stability.families().items()):
        gain, phase, near = figure.axes[3 * number : 3 * number + 3]
        dots, angles = ([x for x in axes.get_lines() if x.get_marker() == "o"] for axes in (gain, phase))
        assert len(dots) == len(angles) == len(loops), family
        for x, dot, angle in zip(loops, dots, angles, strict=True):
            names.append(x.name)
            at = float(np.asarray(dot.get_xdata())[0]) / 1e3
            assert np.exp(np.interp(np.log(at), np.log(f), np.log(np.abs(x.open_loop)))) == pytest.approx(1.0, abs=0.02)
            assert height(angle)[0] + 180.0 == pytest.approx(x.phase_deg, abs=1.5)
        circle = next(patch for patch in near.patches if isinstance(patch, Circle))
        nearest = min(np.abs(1.0 + x.open_loop).min() for x in loops)
        assert circle.get_radius() == pytest.approx(nearest, rel=0.02)
    assert sorted(names) == sorted(LOOPS)


def test_temperatures_are_drawn_with_and_without_phases(closed: ClosedLoop) -> None:
    case, j = closed.worst_likely()["delta_g"]
    found = curves(thermal_figure(case, j).axes[0])
    factor = case.safety_factor
    np.testing.assert_array_equal(height(found["gravity and read-out together"]), factor * j.thermal_asd)
    np.testing.assert_array_equal(height(found["gravity and read-out without phases"]), factor * j.incoherent_asd)
    np.testing.assert_array_equal(height(found["gravity alone"]), factor * j.gravity_asd)
    at = int(np.abs(case.frequency_hz - j.binding_hz).argmin())
    assert (j.incoherent_asd[at] / j.thermal_asd[at]) ** 2 == pytest.approx(j.incoherent)


def test_captions_are_true_of_what_is_drawn(drawn: dict[str, tuple[FigureSpec, Figure]], closed: ClosedLoop) -> None:
    for case, j in worst(closed):
        spec, figure = drawn[f"budget_{j.output}_case{int(case.id):02d}.svg"]
        found = curves(figure.axes[0])
        assert ("temperatures among them" in spec.caption) == ("thermal" in found)
        several = sum(label.startswith("requirement") for label in found) > 1
        assert ("requirements with their bands" in spec.caption) == several
        assert f"safety factor {case.safety_factor:g}," in spec.caption
    spec, figure = drawn["loop_margins.svg"]
    assert "(drag-free, suspension and attitude)" in spec.caption
    titles = {text.get_text() for text in figure.texts}
    assert titles >= {"Drag-free", "Suspension", "Attitude"}
    assert "Legends: phase margin." in spec.caption


def test_a_caption_of_temperatures_below_the_axis_does_not_name_them(closed: ClosedLoop) -> None:
    """Quiet temperatures leave the budget, and its caption."""
    case, j = closed.worst_likely()["delta_g"]
    quiet = replace(j, group_asd={**j.group_asd, "thermal": 1e-30 * j.asd})
    assert "temperatures" not in budget_words(case, quiet)
    assert "thermal" not in curves(budget_figure(case, quiet).axes[0])
    loud = replace(j, group_asd={**j.group_asd, "thermal": j.asd})
    assert "temperatures" in budget_words(case, loud)
    assert "thermal" in curves(budget_figure(case, loud).axes[0])


def test_loops_of_a_controller_of_ones_own_are_one_family(closed: ClosedLoop) -> None:
    """They are broken at the read-outs; some of them never cross gain 1, and have no dot."""
    loops = [replace(x, family=AT_READ_OUTS) for x in closed.stability.loops]
    loops[0] = replace(loops[0], crossover_hz=np.nan, phase_deg=np.inf)
    own = replace(closed.stability, loops=tuple(loops))
    figure = loops_figure(own)
    assert len(figure.axes) == 3
    assert sum(line.get_marker() == "o" for line in figure.axes[0].get_lines()) == len(loops) - 1
    assert all(line.get_linewidth() > 0.0 for axes in figure.axes for line in axes.get_lines())
    assert "drag-free" not in loop_words(own)
    assert "dot" in loop_words(own)
    quiet = replace(own, loops=tuple(replace(x, crossover_hz=np.nan, phase_deg=np.inf) for x in loops))
    assert "dot at" not in loop_words(quiet)
    assert "phase margin" not in loop_words(quiet)
    for stability in (own, quiet):
        figure = loops_figure(stability)
        with style():
            box = figure.get_tightbbox()
        width, tall = figure.get_size_inches()
        assert (box.x0 >= 0, box.y0 >= 0, box.x1 <= width, box.y1 <= tall) == (True,) * 4


def test_one_case_in_closed_loop_is_drawn_and_one_without_temperatures_has_no_figure_of_them(copy: Project) -> None:
    for name in ("simulation01.h5", "simulation02.h5"):
        (copy.build_dir / name).unlink()
    names = set(specs_of(copy))
    assert {"loop_margins.svg", "budget_delta_g_case4b.svg", "closed_loop_thermal_case4b.svg"} <= names
    _, j = loop_of(copy).worst_likely()["delta_g"]
    nothing = np.zeros_like(j.asd)
    assert j.feels_temperatures
    assert not replace(j, group_asd={**j.group_asd, "thermal": nothing}, incoherent_asd=nothing).feels_temperatures


def test_a_loop_that_has_not_been_simulated_has_no_figures(copy: Project) -> None:
    (copy.build_dir / "dynamics.h5").unlink()
    assert specs_of(copy) == {}


def test_nothing_is_cut_off_with_long_names(closed: ClosedLoop) -> None:
    case, j = closed.worst_likely()["delta_g"]
    named = replace(j, group_asd={f"{name}_and_a_long_name_of_ones_own": asd for name, asd in j.group_asd.items()})
    for figure in (budget_figure(case, named), thermal_figure(case, j), loops_figure(closed.stability)):
        with style():
            box = figure.get_tightbbox()
        width, tall = figure.get_size_inches()
        assert (box.x0 >= 0, box.y0 >= 0, box.x1 <= width, box.y1 <= tall) == (True,) * 4
