"""Gradient areas in the noise of every case: silent unless they have a spectrum in K/m/√Hz, apart from the means."""

from pathlib import Path

import numpy as np
import pytest

from tedm_cli.config.cases import CasesConfig, load_cases
from tedm_cli.config.temperature.spectrum import SpectrumColumns
from tedm_cli.errors import ConfigError, InputError
from tedm_cli.noise.areas import AreaTable
from tedm_cli.noise.bounds import BOUNDS, correlation_bounds, extremal_matrix
from tedm_cli.noise.case_run import run_case
from tedm_cli.noise.columns import NodeWeights, parts_of_columns
from tedm_cli.noise.correlation import CorrelationCase, LabelledMatrix, correlation
from tedm_cli.noise.outputs import Outputs
from tedm_cli.noise.propagation import OutputNoise, TemperatureNoise
from tedm_cli.noise.realisation import Plan, realise
from tedm_cli.noise.requirement_presets import PRESETS
from tedm_cli.noise.requirements import AppliedRequirement, Criteria
from tedm_cli.noise.selection import BlockSelector
from tedm_cli.noise.shaping.state_space import noise_model
from tedm_cli.noise.temperature import WhiteSpectrum, thesis_model

CASES = ("1", "2", "3", "4", "4b", "5", "6", "7", "8", "9", "10", "10b")
WHITE = 'temperature.gradient = [{ preset = "white", level_K_per_m = 2e-2 }]\n'
ALL = '[[case]]\nid = "1"\ntitle = "all"\nblocks = [{ areas = ["*"] }]\n'
F = np.geomspace(1e-4, 0.1, 7)
LEVEL = 2e-2


@pytest.fixture(scope="module")
def mixed(areas: AreaTable) -> AreaTable:
    """The areas of the published model with a gradient beside every third of them, in between the others.

    Outside these are mirror images, as case 10b pairs them.
    """
    order = np.array([i for i in range(len(areas)) for _ in range(2 if i % 6 < 2 else 1)])
    again = np.array([n > 0 and order[n - 1] == i for n, i in enumerate(order)])
    assert areas.centroid_m is not None
    return AreaTable(
        np.array([f"GRAD_{n}" if g else n for n, g in zip(areas.name[order], again, strict=True)]),
        areas.group[order], areas.shield[order], areas.side[order], areas.centroid_m[order],
        kind=np.where(again, "gradient", "mean"),
    )  # fmt: skip


@pytest.fixture(scope="module")
def rows(mixed: AreaTable) -> np.ndarray:
    return np.random.default_rng(3).normal(size=(4, len(mixed))) * 1e-11


def tiny() -> AreaTable:
    """Two means and two gradients, one of each on either side of the shield."""
    return AreaTable(
        np.array(["A", "B", "GA", "GB"]), np.array(["g", "h"] * 2), np.array(["inside", "outside"] * 2),
        np.array(["+y", "-y"] * 2), kind=np.array(["mean", "mean", "gradient", "gradient"]),
    )  # fmt: skip


def configured(tmp_path: Path, text: str) -> CasesConfig:
    (tmp_path / "cases.toml").write_text(text + ALL)
    return load_cases(tmp_path / "cases.toml")[1]


@pytest.mark.parametrize("case_id", CASES)
def test_without_a_spectrum_the_spectra_are_those_of_the_model_without_gradients_to_the_bit(
    case_id: str, config: CasesConfig, areas: AreaTable, mixed: AreaTable, rows: np.ndarray
) -> None:
    case = config.case(case_id)
    means = ~mixed.gradient
    alone, held = mixed.only(means), config.temperature.model(mixed)
    np.testing.assert_array_equal(alone.name, areas.name)
    np.testing.assert_array_equal(held.heard, means)
    plain = TemperatureNoise(config.temperature.model(alone), correlation(case, alone))
    silent = TemperatureNoise(held, correlation(case, mixed, held.heard))
    assert not silent.correlation.active[mixed.gradient].any()
    np.testing.assert_array_equal(silent.psd(rows, F), plain.psd(rows[:, means], F))
    for one, other in zip(silent.correlation.blocks, plain.correlation.blocks, strict=True):
        np.testing.assert_array_equal(mixed.name[one], alone.name[other])


@pytest.mark.parametrize("case_id", CASES)
def test_with_a_spectrum_they_follow_the_case_among_themselves_and_add_to_the_power_of_the_means(
    case_id: str, config: CasesConfig, mixed: AreaTable, rows: np.ndarray, tmp_path: Path
) -> None:
    case = config.case(case_id)
    model = configured(tmp_path, WHITE).temperature.model(mixed)
    assert model.heard.all()
    found = correlation(case, mixed, model.heard)
    matrix = found.matrix()
    assert not matrix[np.ix_(mixed.gradient, ~mixed.gradient)].any()
    # Each is beside a mean, and moves with the other gradients as that mean does with other means.
    beside = np.flatnonzero(mixed.gradient) - 1
    wanted = matrix[np.ix_(beside, beside)]
    np.testing.assert_array_equal(matrix[np.ix_(mixed.gradient, mixed.gradient)], wanted)
    psd = TemperatureNoise(model, found).psd(rows, F)
    g = rows[:, mixed.gradient] * LEVEL
    by_hand = np.einsum("oi,ij,oj->o", g, wanted, g)
    means = mixed.only(~mixed.gradient)
    of_means = TemperatureNoise(config.temperature.model(means), correlation(case, means)).psd(
        rows[:, ~mixed.gradient], F
    )
    np.testing.assert_allclose(psd, of_means + by_hand[:, None], rtol=1e-12)


def test_one_gradient_alone_is_its_sensitivity_times_its_spectrum(tmp_path: Path) -> None:
    table = tiny()
    text = '[[temperature.gradient]]\nareas = ["GA"]\nlevel_K_per_m = 3e-3\norder = 1\n'
    model = configured(tmp_path, text).temperature.model(table)
    np.testing.assert_array_equal(model.heard, [True, True, True, False])
    s_g = np.array([[0.0, 0.0, 5e-9, 7e-9]])
    source = TemperatureNoise(
        model, correlation(CorrelationCase("1", "", (BlockSelector(areas=("*",)),)), table, model.heard)
    )
    amplitude = 3e-3 * np.sqrt(2.0 / (1.0 + (F / 1e-3) ** 2))
    np.testing.assert_allclose(source.psd(s_g, F)[0], (5e-9 * amplitude) ** 2, rtol=1e-12)


def test_the_whole_case_tells_groups_apart_and_shares_sum_to_one(tmp_path: Path) -> None:
    table = tiny()
    config = configured(tmp_path, WHITE)
    row = np.array([[1e-10, -2e-10, 3e-9, 4e-9]])
    outputs = Outputs(table, row, ("TM1_a_x",), ("acceleration",))
    case = config.case("1")
    result = run_case(case, outputs, config.temperature.model(table), F)
    assert result.groups == ("g", "h", "g (gradients)", "h (gradients)")
    assert [b.tolist() for b in result.blocks] == [[0, 1], [2, 3]]
    share = result.contributions.share[0]
    assert share.sum() == pytest.approx(1.0)
    assert share[2:].sum() == pytest.approx((7e-9 * LEVEL) ** 2 / result.psd[0, np.abs(F - 1e-3).argmin()], rel=1e-6)
    assert "0.02 K/m/sqrt(Hz), white" in config.temperature.model(table).words()
    assert "2 gradient areas silent" in configured(tmp_path, "").temperature.model(table).words()


def test_blocks_of_gradients_are_matched_with_none(tmp_path: Path) -> None:
    """Without gradients the same blocks are matched, and their ratios rise by the power of the gradients alone."""
    table = AreaTable(
        np.array([*"ABCG"]), np.array(["g"] * 4), np.array(["inside"] * 4), np.array(["mid"] * 4),
        kind=np.array(["mean"] * 3 + ["gradient"]),
    )  # fmt: skip
    config = configured(tmp_path, WHITE)
    alone = BlockSelector(areas=("*",), partition="none")
    case = CorrelationCase("2", "", (alone,))
    row = np.array([1e-10, -0.9e-10, 2e-12, -3e-12])
    applied = (AppliedRequirement(PRESETS["lpf_selfgravity_ltp"], ("TM1_a_x",)),)
    f = np.geomspace(1e-3, 3e-2, 5)
    found = []
    for kept in (np.ones(4, dtype=bool), ~table.gradient):
        outputs = Outputs(table.only(kept), row[None, kept], ("TM1_a_x",), ("acceleration",))
        model = (config if kept.all() else configured(tmp_path, "")).temperature.model(table.only(kept))
        found.append(run_case(case, outputs, model, f, Criteria(applied)))
    with_gradient, without = (r.improvements[0] for r in found)
    np.testing.assert_array_equal(with_gradient.match, without.match)
    assert with_gradient.match[:2].tolist() == [0, 1]
    assert (with_gradient.matched > without.matched).all()


def six() -> AreaTable:
    """Three means and three gradients, in turn."""
    return AreaTable(
        np.array([*"ABCDEF"]), np.array(["g", "h"] * 3), np.array(["inside", "outside"] * 3), np.array(["+y"] * 6),
        kind=np.array(["mean", "gradient"] * 3),
    )  # fmt: skip


ONE_ROW = np.array([[3e-8, 2e-10, -6e-8, 3e-10, 4.5e-8, -4e-10]])


def test_bounds_are_over_means_and_gradients_together_and_are_reached_by_a_matrix(tmp_path: Path) -> None:
    config, table, f = configured(tmp_path, WHITE), six(), np.array([1e-3])
    model = config.temperature.model(table)
    outputs = Outputs(table, ONE_ROW, ("TM1_a_x",), ("acceleration",))
    result = run_case(config.case("1"), outputs, model, np.array([1e-3, 2e-3]))
    h = ONE_ROW[0] * model.amplitudes(f)[:, 0]
    size, kinds = np.abs(h), [h[table.gradient == kind] for kind in (False, True)]
    blocks = np.abs([part.sum() for part in kinds])  # case 1 moves each kind as one
    expected = {
        "minimum": max(0.0, 2.0 * size.max() - size.sum()) ** 2,
        "known_blocks_minimum": (blocks[0] - blocks[1]) ** 2,
        "known_blocks": blocks.sum() ** 2,
        "maximum_non_negative": h[h > 0.0].sum() ** 2 + h[h < 0.0].sum() ** 2,
        "maximum": size.sum() ** 2,
    }
    assert result.psd[0, 0] == pytest.approx((blocks**2).sum())
    assert expected["maximum"] > sum(np.abs(part).sum() ** 2 for part in kinds) * 1.1
    for bound in BOUNDS:
        assert getattr(result.bounds, bound)[0, 0] == pytest.approx(expected[bound], rel=1e-12, abs=1e-33)
        known = (table.gradient.astype(int), result.source.correlation_at(1e-3).matrix()) if "known" in bound else ()
        matrix = extremal_matrix(result.contributions.extremal[bound][0], *known)
        assert np.abs(matrix[np.ix_(table.gradient, ~table.gradient)]).max() > 0.1
        own = CorrelationCase("x", "", (), matrix=LabelledMatrix(tuple(table.name.tolist()), matrix))
        reached = TemperatureNoise(model, correlation(own, table, model.heard)).psd(ONE_ROW, f)[0, 0]
        assert abs(np.sqrt(reached) - np.sqrt(expected[bound])) < 1e-7 * size.sum(), bound


def test_no_correlation_of_means_with_gradients_leaves_the_bounds(tmp_path: Path) -> None:
    config, table, f = configured(tmp_path, WHITE), six(), np.array([1e-3])
    model, rng = config.temperature.model(table), np.random.default_rng(11)
    names = tuple(table.name.tolist())
    bounds = correlation_bounds(
        OutputNoise(ONE_ROW, TemperatureNoise(model, correlation(config.case("1"), table, model.heard)), f)
    )
    apart = sum(
        (np.abs(ONE_ROW[0] * model.amplitudes(f)[:, 0])[table.gradient == kind]).sum() ** 2 for kind in (False, True)
    )
    beyond = 0
    for rank in (1, 2, 6) * 20:
        mixing = rng.normal(size=(6, rank))
        mixing /= np.linalg.norm(mixing, axis=1, keepdims=True)
        mixing[:, 0] = np.sign(ONE_ROW[0]) * np.abs(mixing[:, 0])
        own = CorrelationCase("x", "", (), matrix=LabelledMatrix(names, mixing @ mixing.T))
        psd = TemperatureNoise(model, correlation(own, table, model.heard)).psd(ONE_ROW, f)[0, 0]
        assert bounds.minimum[0, 0] * (1 - 1e-9) <= psd <= bounds.maximum[0, 0] * (1 + 1e-9)
        beyond += psd > apart
    assert beyond > 0  # so that bounds of each kind by itself would fail here


@pytest.mark.parametrize("rho", [1.0, 0.6, -0.2])
def test_a_block_across_kinds_correlates_means_with_gradients(tmp_path: Path, rho: float) -> None:
    text = f'[[case]]\nid = "own"\ntitle = "own"\nblocks = [{{ areas = ["*"], across_kinds = true, rho = {rho} }}]\n'
    config, f = configured(tmp_path, WHITE + text), np.array([1e-3])
    for heard in (True, False):
        model = (config if heard else configured(tmp_path, text)).temperature.model(six())
        found = correlation(config.case("own"), six(), model.heard)
        assert [block.tolist() for block in found.blocks] == [np.flatnonzero(model.heard).tolist()]
        wanted = np.where(np.eye(6, dtype=bool), 1.0, rho) * np.outer(model.heard, model.heard)
        np.testing.assert_allclose(found.matrix(), wanted, atol=1e-15)
        h = ONE_ROW[0] * model.amplitudes(f)[:, 0]
        psd = TemperatureNoise(model, found).psd(ONE_ROW, f)[0, 0]
        assert psd == pytest.approx(h @ wanted @ h)


def test_a_partition_across_kinds_divides_both_alike(tmp_path: Path) -> None:
    text = '[[case]]\nid = "own"\ntitle = "own"\npartition = "group"\n'
    heard = np.ones(6, dtype=bool)
    apart = correlation(configured(tmp_path, text).case("own"), six(), heard).blocks
    assert [block.tolist() for block in apart] == [[0, 2, 4], [1, 3, 5]]
    table = AreaTable(
        six().name, np.array([*"ggghhh"]), six().shield, six().side, kind=six().kind
    )  # each group has both kinds
    apart = correlation(configured(tmp_path, text).case("own"), table, heard).blocks
    assert [block.tolist() for block in apart] == [[0, 2], [4], [1], [3, 5]]
    joined = configured(tmp_path, text + "across_kinds = true\n").case("own")
    assert [block.tolist() for block in correlation(joined, table, heard).blocks] == [[0, 1, 2], [3, 4, 5]]


def test_realisation_and_state_space_leave_out_the_silent_and_hold_the_heard(tmp_path: Path) -> None:
    table, case = tiny(), CorrelationCase("1", "", (BlockSelector(areas=("*",)),))
    row = np.array([[1e-3, 2e-3, 3.0, 4.0]])
    plan = Plan(rate_hz=0.2, samples=20_000, seed=1, low_hz=1e-3, high_hz=0.1, lowest_hz=1e-2)
    for text in ("", WHITE):
        model = configured(tmp_path, 'temperature.preset = "white"\n' + text).temperature.model(table)
        source = TemperatureNoise(model, correlation(case, table, model.heard))
        exact = source.psd(row, np.array([0.02]))
        estimate = realise(row, source, plan)
        middle = (estimate.frequency_hz > 0.015) & (estimate.frequency_hz < 0.08)
        assert estimate.psd[0, middle].mean() == pytest.approx(exact[0, 0], rel=0.1)
        state = noise_model(row, source, (1e-3, 0.1), 0.01, "case 1")
        np.testing.assert_allclose(state.psd(np.array([0.02])), exact, rtol=1e-6)


@pytest.mark.parametrize(
    ("text", "fact"),
    [
        ('[[temperature.gradient]]\nlevel_K = 1e-3\n', "level_K is in K/sqrt(Hz), the unit of mean temperatures; give"),
        ('[[temperature.override]]\nareas = ["A"]\nlevel_K_per_m = 1.0\n', "level_K_per_m is of gradients"),
        ('[[temperature.gradient]]\npreset = "lpf_flight"\n', "lpf_flight is in K/sqrt(Hz) and cannot"),
        ('[[temperature.gradient]]\npreset = "white"\n', "needs level_K_per_m, in K/m/sqrt(Hz)"),
        ('[[temperature.gradient]]\nlevel_K_per_m = -1.0\n', "level of a temperature gradient"),
        (
            '[temperature]\npreset = "table"\ntable = "t.csv"\n[[temperature.gradient]]\npreset = "table"\n'
            'table = "t.csv"\n',
            "t.csv is given for temperatures and for gradients",
        ),
    ],
)  # fmt: skip
def test_tables_with_the_keys_of_the_other_kind_are_refused(tmp_path: Path, text: str, fact: str) -> None:
    with pytest.raises(ConfigError) as caught:
        configured(tmp_path, text)
    assert any(fact in said for _, said in caught.value.problems), caught.value.problems


@pytest.mark.parametrize(
    ("text", "path", "fact"),
    [
        ('areas = ["GA"]\nlevel_K = 1.0\n', "override[0].areas", "'GA' has gradient areas alone, no mean area"),
        ('areas = ["A"]\nlevel_K_per_m = 1.0\n', "gradient[0].areas", "'A' has mean areas alone, no gradient area"),
        ('areas = ["X"]\nlevel_K_per_m = 1.0\n', "gradient[0].areas", "no thermal area has 'X'"),
        ('groups = ["k"]\nlevel_K_per_m = 1.0\n', "gradient[0].groups", "no thermal area is of group 'k'"),
    ],
)
def test_spectra_for_areas_of_the_other_kind_are_refused(tmp_path: Path, text: str, path: str, fact: str) -> None:
    config = configured(tmp_path, f"[[temperature.{path.partition('[')[0]}]]\n{text}")
    with pytest.raises(ConfigError) as caught:
        config.temperature.model(tiny())
    assert dict(caught.value.problems)[f"temperature.{path}"].startswith(fact)


def test_a_gradient_spectrum_of_a_model_without_gradients_is_refused(tmp_path: Path, areas: AreaTable) -> None:
    with pytest.raises(ConfigError, match="the model has no gradient area"):
        configured(tmp_path, WHITE).temperature.model(areas)


def test_tables_of_spectra_are_each_of_one_unit(tmp_path: Path) -> None:
    text = '[[temperature.gradient]]\npreset = "table"\ntable = "g.csv"\n'
    config, f = configured(tmp_path, text), np.array([1e-4, 0.1])
    found = config.temperature.model(tiny(), {"g.csv": SpectrumColumns("g.csv", ["all"], f, np.full((2, 1), 0.5))})
    np.testing.assert_allclose(found.amplitudes(np.array([1e-3]))[2:, 0], 0.5)
    wrong = {"g.csv": SpectrumColumns("g.csv", ["GA", "GB", "A"], f, np.full((2, 3), 0.5))}
    with pytest.raises(InputError, match=r"column 'A' names the area of a mean temperature, in K; .* in K/m/sqrt"):
        config.temperature.model(tiny(), wrong)
    kelvin = configured(tmp_path, '[temperature]\npreset = "table"\ntable = "t.csv"\n')
    with pytest.raises(InputError, match=r"column 'GA' names the area of a gradient, in K/m; .* in K/sqrt"):
        kelvin.temperature.model(tiny(), {"t.csv": SpectrumColumns("t.csv", ["all", "GA"], f, np.ones((2, 2)))})
    with pytest.raises(InputError, match="no column for 1 of 2 gradient areas: GB"):
        config.temperature.model(tiny(), {"g.csv": SpectrumColumns("g.csv", ["GA"], f, np.ones((2, 1)))})


def test_a_matrix_may_correlate_the_two_kinds() -> None:
    def case(names: tuple[str, ...], value: list[list[complex]]) -> CorrelationCase:
        return CorrelationCase("9", "", (), matrix=LabelledMatrix(names, np.array(value), "r.csv"))

    heard = np.ones(4, dtype=bool)
    mixed = correlation(case(("GA", "B"), [[1.0, 0.3j], [-0.3j, 1.0]]), tiny(), heard)
    assert [b.tolist() for b in mixed.blocks] == [[1, 2]]
    np.testing.assert_allclose(mixed.matrix()[np.ix_([1, 2], [1, 2])], [[1.0, -0.3j], [0.3j, 1.0]], atol=1e-15)
    both = case(("GB", "A", "GA"), [[1.0, 0.2, 0.5], [0.2, 1.0, 0.0], [0.5, 0.0, 1.0]])
    found = correlation(both, tiny(), heard)
    assert [b.tolist() for b in found.blocks] == [[0, 2, 3]]
    wanted = [[1.0, 0.0, 0.2], [0.0, 1.0, 0.5], [0.2, 0.5, 1.0]]
    np.testing.assert_allclose(found.matrix()[np.ix_([0, 2, 3], [0, 2, 3])], wanted, atol=1e-15)
    np.testing.assert_array_equal(correlation(both, tiny()).active, [True, False, False, False])
    with pytest.raises(ConfigError, match="GA is of gradients without a spectrum, and silent"):
        correlation(case(("GA",), [[1.0]]), tiny())


def test_a_delay_of_a_silent_gradient_turns_nothing() -> None:
    late = ((BlockSelector(areas=("GA", "B")), 600.0),)
    case = CorrelationCase("9", "", (BlockSelector(areas=("*",)),), delays=late)
    np.testing.assert_array_equal(correlation(case, tiny()).delay_s, [0.0, 600.0, 0.0, 0.0])
    np.testing.assert_array_equal(correlation(case, tiny(), np.ones(4, dtype=bool)).delay_s, [0.0, 600.0, 600.0, 0.0])


def test_a_block_of_silent_gradients_is_refused() -> None:
    case = CorrelationCase("9", "", (BlockSelector(areas=("A",)), BlockSelector(areas=("G*",))))
    with pytest.raises(ConfigError, match=r"GA, GB are of gradients without a spectrum.*\[\[temperature.gradient\]\]"):
        correlation(case, tiny())
    assert len(correlation(case, tiny(), np.ones(4, dtype=bool)).blocks) == 2


def test_columns_of_a_series_feed_gradients_by_their_own_name_alone() -> None:
    everywhere = np.ones(4, dtype=bool)
    parts = parts_of_columns(["g", "all", "GB"], tiny(), everywhere, where="t.csv")
    np.testing.assert_array_equal(parts, [[1, 0, 0], [0, 1, 0], [0, 0, 0], [0, 0, 1]])
    np.testing.assert_array_equal(parts_of_columns(["all", "GB"], tiny(), ~tiny().gradient, where="t.csv")[3], [0, 0])
    with pytest.raises(InputError, match="a gradient, which is no mean of nodes: GA"):
        nodes = NodeWeights({"GA": {"N1": 1.0}}, "n.csv")
        parts_of_columns(["N1", "all"], tiny(), everywhere, where="t.csv", nodes=nodes)


def test_thesis_and_filter_leave_gradients_silent(mixed: AreaTable) -> None:
    model = thesis_model(mixed).with_filter(3.0, 2e-3)
    assert not model.amplitudes(F)[mixed.gradient].any()
    index, asd = model.distinct(F)
    assert set(index[mixed.gradient]) == {len(asd) - 1}
    assert not asd[-1].any()
    assert WhiteSpectrum(1.0) not in model.shapes


def test_a_kind_that_is_none_is_refused() -> None:
    words = np.array(["A"])
    with pytest.raises(InputError, match="kind is 'slope'"):
        AreaTable(words, words, np.array(["inside"]), np.array(["mid"]), kind=np.array(["slope"]))
