"""Figures of the thermal network: what they show, and that they can be read with any number of names of any length."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from figure_texts import drawn, faults
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from tedm_cli.arrays import ComplexArray
from tedm_cli.figures.model.temperature_map import _of_elements
from tedm_cli.figures.model.views import Mesh
from tedm_cli.figures.thermal.disturbances import shares_figure, spectra_figure, stability_figure
from tedm_cli.figures.thermal.gains import gains_figure
from tedm_cli.figures.thermal.low_passes import low_passes_figure
from tedm_cli.figures.thermal.steady_temperatures import temperatures_figure
from tedm_cli.report.document import plain
from tedm_cli.report.thermal import _low_pass_words, stability_words
from tedm_cli.results.cases.noise import CaseNoise, JudgedDisturbances
from tedm_cli.results.thermal.disturbances import all_together, strictest_of
from tedm_cli.results.thermal.groups import GroupGains, GroupTemperatures
from tedm_cli.results.wording import rounded_down
from tedm_cli.stages.reporting.plot_thermal import GAINS, LOW_PASSES
from tedm_cli.thermal.low_pass import fitted, low_pass_shape

LONG = "A_NAME_THAT_IS_AS_LONG_AS_ONE_MAY_BE_IN_A_MODEL_"
F = np.geomspace(1e-4, 0.1, 41)


def names(n: int, long: bool) -> tuple[str, ...]:
    return tuple(f"{LONG if long else 'N'}{i}" for i in range(n))


def gains(groups: int, disturbances: int, *, long: bool = False, kind: str = "power") -> GroupGains:
    """Low-passes of known order and corner, one pole after the other; the last group of more has none."""
    corner = 2e-4 * 1.3 ** np.arange(groups)[:, None] * 1.1 ** np.arange(disturbances)
    order = 1 + np.arange(groups)[:, None] % 4 + np.zeros(disturbances)
    gain: ComplexArray = np.asarray(
        10.0 ** -np.arange(groups)[:, None] / (1.0 + 1j * F[:, None, None] / corner) ** order, dtype=np.complex128
    )
    if groups > 2:
        gain[:, -1] = 0.0
    exact = low_pass_shape(F[:, None, None], order, corner) * (np.abs(gain[:1]) > 0.0)
    noise = np.abs(gain).sum(axis=2)
    return GroupGains(
        names(groups, long), (3,) * groups, names(disturbances, long), (kind,) * disturbances, F, gain,
        fitted(exact.astype(complex), F), noise, fitted(noise.astype(complex), F),
        np.array([order / 1.5, corner / 2.0]), np.array([order * 1.5, corner * 2.0]), 0, gain.size,
    )  # fmt: skip


def temperatures(groups: int, *, long: bool = False, on: bool = True) -> GroupTemperatures:
    mean = 293.0 + 2.0 * np.arange(groups)
    inside = (np.arange(groups) % 2 == 0) & on
    return GroupTemperatures(names(groups, long), inside, (2,) * groups, mean - 1.0, mean, mean + 1.0)


def disturbed(case: CaseNoise, u: int, *, long: bool = False, scale: float = 1.0) -> CaseNoise:
    """The case as if `u` disturbances made its noise, some of them against others; the first cannot meet the limits,
    the second is not felt."""
    rng = np.random.default_rng(u)
    judged = []
    for j in case.judged:
        share = rng.normal(size=u) if u > 1 else np.ones(1)
        factor = scale * rng.uniform(0.5, 50.0, u)
        factor[: min(2, u - 1)] = [np.nan, np.inf][: min(2, u - 1)]
        asd = rng.uniform(0.1, 1.0, (u, 1)) * j.asd
        of = JudgedDisturbances(names(u, long), share / share.sum(), share / share.sum(), factor, asd)
        judged.append(dataclasses.replace(j, disturbances=of))
    return dataclasses.replace(case, judged=tuple(judged), thermal=True, id="T")


@pytest.mark.parametrize(("groups", "disturbances", "long"), [(1, 1, False), (12, GAINS, True), (13, 3, False)])
def test_gains_can_be_read(groups: int, disturbances: int, long: bool) -> None:
    found = gains(groups, disturbances, long=long)
    assert faults(drawn(gains_figure(found, range(disturbances)))) == []


@pytest.mark.parametrize(("groups", "disturbances", "long"), [(1, 1, False), (12, LOW_PASSES, True), (12, 4, False)])
def test_low_passes_can_be_read(groups: int, disturbances: int, long: bool) -> None:
    found = gains(groups, disturbances, long=long)
    assumed = [] if groups == 1 else [(2.0, 1e-3), (3.0, 1e-4)]
    assert faults(drawn(low_passes_figure(found, range(disturbances), assumed))) == []


@pytest.mark.parametrize(("groups", "long", "on"), [(1, False, False), (24, True, True)])
def test_temperatures_can_be_read(groups: int, long: bool, on: bool) -> None:
    assert faults(drawn(temperatures_figure(temperatures(groups, long=long, on=on)))) == []


@pytest.mark.parametrize(("u", "long", "scale"), [(1, False, 1.0), (7, False, 0.01), (40, True, 1.0)])
def test_disturbances_can_be_read(cases: list[CaseNoise], u: int, long: bool, scale: float) -> None:
    case = disturbed(cases[0], u, long=long, scale=scale)
    for figure in (
        shares_figure(case),
        stability_figure(case, strictest_of(case), all_together(case)),
        spectra_figure(case),
    ):
        assert faults(drawn(figure)) == []


def curves(figure: Figure, panel: int) -> list[Line2D]:
    return list(figure.axes[panel].get_lines())


def test_gains_are_those_of_the_file_and_so_are_their_fits() -> None:
    found = gains(3, 2, kind="temperature")
    figure = gains_figure(found, [0, 1])
    for d in range(2):
        lines = curves(figure, 2 * d)
        assert len(lines) == 4, "a group that feels nothing has no curve"
        for g in range(2):
            np.testing.assert_array_equal(lines[2 * g].get_xdata(), 1e3 * F)
            np.testing.assert_allclose(np.asarray(lines[2 * g].get_ydata()), np.abs(found.gain[:, g, d]), rtol=1e-14)
            np.testing.assert_allclose(np.asarray(lines[2 * g + 1].get_ydata()), found.fit[:, g, d], rtol=1e-14)
        phase = np.asarray(curves(figure, 2 * d + 1)[0].get_ydata())
        np.testing.assert_allclose(phase, np.degrees(np.angle(found.gain[:, 0, d])), atol=1e-9)
    assert figure.axes[0].get_ylabel() == "gain (K/K)"
    assert gains_figure(gains(1, 1), [0]).axes[0].get_ylabel() == "gain (K/W)"


def test_low_passes_stand_at_their_order_and_corner_beside_the_assumed_ones() -> None:
    found = gains(2, 1)
    noise, panel = low_passes_figure(found, [0], [(2.0, 1e-3)]).axes
    marks = [line for line in panel.get_lines() if line.get_linestyle() == "None"]
    at = [(np.asarray(m.get_xdata())[0], np.asarray(m.get_ydata())[0]) for m in marks]
    assert at == [(pytest.approx(0.2, rel=1e-3), pytest.approx(1.0, rel=1e-3)),
                  (pytest.approx(0.26, rel=1e-3), pytest.approx(2.0, rel=1e-3))]  # fmt: skip
    dashed = [line for line in panel.get_lines() if line.get_color() == "black" and len(line.get_xdata()) == 2]
    assert {tuple(np.asarray(line.get_ydata())) for line in dashed} >= {(2.0, 2.0)}
    assert {tuple(np.asarray(line.get_xdata())) for line in dashed} >= {(1.0, 1.0)}
    assert noise.get_title(loc="left") == "temperature noise, all together"
    flat = dataclasses.replace(found, low_pass=fitted(np.ones_like(found.gain), F))
    _, panel = low_passes_figure(flat, [0], []).axes
    marks = [line for line in panel.get_lines() if line.get_linestyle() == "None"]
    assert {m.get_markerfacecolor() for m in marks} == {"white"}, "no corner among the frequencies"
    low, high = panel.get_xlim()
    assert all(low < np.asarray(m.get_xdata())[0] < high for m in marks)


def test_bars_are_the_ranges_of_groups_and_celsius_goes_with_kelvin() -> None:
    found = temperatures(3)
    axes, celsius = temperatures_figure(found).axes
    bars = [(p.get_x(), p.get_x() + p.get_width()) for p in axes.patches]
    assert bars == [(pytest.approx(a), pytest.approx(b)) for a, b in zip(found.least, found.most, strict=True)]
    assert [bool(bar.get_hatch()) for bar in axes.patches] == [False, True, False]
    assert celsius.get_xlim() == pytest.approx([v - 273.15 for v in axes.get_xlim()])


def test_elements_have_the_mean_of_their_grids() -> None:
    mesh = Mesh(position=np.zeros((4, 3)), card=["CBAR", "CTRIA3", "CONM2"], node_offset=np.array([0, 2, 5, 5]),
                node_index=np.array([0, 1, 1, 2, 3]), boxes=[], centre=np.zeros(3))  # fmt: skip
    mean = _of_elements(mesh, np.array([1.0, 2.0, 6.0, np.nan]))
    np.testing.assert_array_equal(mean, [1.5, np.nan, np.nan])


def test_stacks_sum_to_all_of_the_noise(cases: list[CaseNoise]) -> None:
    """Positive parts less negative ones are 100 %, with those that are told together."""
    for u in (3, 40):
        axes = shares_figure(disturbed(cases[0], u)).axes[0]
        rows = {round(p.get_y() + p.get_height() / 2) for p in axes.patches}
        assert len(rows) == len(axes.get_yticklabels())
        for place in rows:
            mine = [p for p in axes.patches if round(p.get_y() + p.get_height() / 2) == place]
            assert sum(p.get_width() for p in mine) == pytest.approx(100.0, abs=0.05 * u)


def test_the_strictest_output_of_each_disturbance_comes_first(cases: list[CaseNoise]) -> None:
    case = disturbed(cases[0], 6)
    found = strictest_of(case)
    assert (found[0].name, found[-1].name) == ("N0", "N1")
    assert np.isnan(found[0].factor)
    assert np.isinf(found[-1].factor)
    factors = {s.name: s.factor for s in found}
    for d in range(2, 6):
        assert factors[f"N{d}"] == min(j.disturbances.level_factor[d] for j in case.judged if j.disturbances)
    assert sorted(list(factors.values())[1:-1]) == list(factors.values())[1:-1]


def test_what_is_said_of_a_case_is_computed(cases: list[CaseNoise]) -> None:
    case = disturbed(cases[0], 3, scale=1e-3)
    worst = max(j.ratio for j in case.judged)
    words = plain(stability_words(case, str))
    assert "However quiet N0 became, alone" in words
    assert "N2 must have at most" in words
    assert f"All together must have at most {rounded_down(1.0 / worst)} times" in words
    alone = disturbed(cases[0], 1, scale=3.0)
    assert "N0 may have" in plain(stability_words(alone, str))
    silent = dataclasses.replace(
        alone,
        judged=tuple(
            dataclasses.replace(j, disturbances=dataclasses.replace(j.disturbances, level_factor=np.array([np.inf])))
            for j in alone.judged
            if j.disturbances is not None
        ),
    )
    assert plain(stability_words(silent, str)) == "No judged output feels a disturbance."


def test_what_is_said_of_low_passes_is_counted() -> None:
    """Corners 0.2, 0.26 and 0.338 mHz of orders 1, 2 and, of nothing, none."""
    words = _low_pass_words(gains(3, 1), [(2.5, 3e-4)])
    assert "Of 3 gains to groups, 2 have a corner" in words
    assert "0.23 mHz in the median (0.2 to 0.26 mHz), at order 1.5 (1 to 2)" in words
    assert "2 of these corners are lower, and 0 of the orders are higher" in words
    flat = dataclasses.replace(gains(1, 1), low_pass=fitted(np.ones((len(F), 1, 1), dtype=complex), F))
    assert _low_pass_words(flat, []) == "No gain to a group has a corner among the frequencies."
