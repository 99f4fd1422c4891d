import numpy as np
import pytest

from tedm_cli.errors import ConfigError, PhysicsError
from tedm_cli.noise.areas import AreaTable
from tedm_cli.noise.correlation import CorrelationCase, blocks, correlation_matrix
from tedm_cli.noise.correlation_check import check_correlation, correlation_factor
from tedm_cli.noise.selection import BlockSelector

EVERYTHING = BlockSelector(areas=("*",))


def case(*selectors):
    return CorrelationCase("7c", "trial", selectors, "cases.toml")


SIZES = {
    "1": [78],
    "2": [1] * 78,
    "3": [12, 66],
    "4": [12, 26, 26, 14],
    "4b": [8, 4, 26, 26, 14],
    "5": [12],
    "6": [1] * 12,
    "7": [66],
    "8": [1] * 66,
    "9": [26, 26, 14],
    "10": [66, 6, 6],
    "10b": [66] + [2] * 6,
}


@pytest.mark.parametrize("case_id", SIZES)
def test_published_cases_have_the_published_blocks(areas, config, case_id):
    found = blocks(config.case(case_id), areas)
    assert [len(index) for index in found] == SIZES[case_id]
    matrix, active = correlation_matrix(config.case(case_id), areas)
    assert active.sum() == sum(SIZES[case_id])
    check_correlation(matrix, active)
    # A direct sum of matrices of ones has its block sizes as eigenvalues.
    eigenvalues = np.linalg.eigvalsh(matrix)
    np.testing.assert_allclose(eigenvalues[-len(found) :], sorted(SIZES[case_id]), atol=1e-12)
    assert np.abs(eigenvalues[: -len(found)]).max(initial=0.0) < 1e-12


def test_every_shipped_case_is_tested(config):
    assert set(config.ids_of_areas) == set(SIZES)


def test_keys_narrow_and_values_widen(areas):
    found = blocks(case(BlockSelector(groups=("struts", "flanges"), side=("-y",), areas=("*_2", "*_4"))), areas)
    assert areas.name[found[0]].tolist() == ["STRUTS_2", "STRUTS_4", "FLANGES_2", "FLANGES_4"]


@pytest.mark.parametrize(
    ("selectors", "path", "fact"),
    [
        ([BlockSelector(groups=("strutz",))], "blocks[0].groups", "did you mean struts?; there are: IS1, IS2, OB"),
        ([EVERYTHING, BlockSelector(areas=("LID_*",))], "blocks[1].areas", "no thermal area has 'LID_*'"),
        ([BlockSelector(groups=("IS1",), shield=("outside",))], "blocks[0]", "selects none of the 78"),
        ([BlockSelector(groups=("OB",)), EVERYTHING], "blocks[1]", "OB_1, OB_2, OB_3, OB_4 and 10 more are already"),
    ],
)
def test_selectors_that_do_not_fit_the_areas_are_refused(areas, selectors, path, fact):
    with pytest.raises(ConfigError, match=r"cases\.toml: case 7c") as caught:
        blocks(case(*selectors), areas)
    assert path in dict(caught.value.problems)
    assert fact in dict(caught.value.problems)[path]


def test_all_problems_of_a_case_at_once(areas):
    selectors = [BlockSelector(groups=("X",)), EVERYTHING, BlockSelector(groups=("OB",)), BlockSelector(areas=("Q",))]
    with pytest.raises(ConfigError) as caught:
        blocks(case(*selectors), areas)
    assert [path for path, _ in caught.value.problems] == ["blocks[0].groups", "blocks[3].areas", "blocks[2]"]


def with_flange_in_the_middle(areas):
    side = areas.side.copy()
    side[[8, 11]] = "mid"
    return AreaTable(areas.name, areas.group, areas.shield, side)


def test_case_10_asks_where_areas_on_neither_side_belong(areas, config):
    with pytest.raises(ConfigError, match="FLANGES_1, FLANGES_4 are on neither side and would be silent") as caught:
        blocks(config.case("10"), with_flange_in_the_middle(areas))
    assert caught.value.problems[0][0] == "blocks[1].side"


def test_case_10_takes_areas_in_the_middle_where_told(areas):
    told = case(
        BlockSelector(shield=("inside",)),
        BlockSelector(shield=("outside",), side=("+y", "mid")),
        BlockSelector(shield=("outside",), side=("-y",)),
    )
    found = blocks(told, with_flange_in_the_middle(areas))
    assert [len(index) for index in found] == [66, 7, 5]
    assert {8, 11} <= set(found[1].tolist())


@pytest.mark.parametrize(
    ("matrix", "message"),
    [
        (np.array([[1, 0.5], [0.4, 1]]), r"not Hermitian: entries \[0, 1\] and \[1, 0\] are 0.5 and 0.4"),
        (np.array([[1, 1j], [1j, 1]]), "not Hermitian"),
        (np.array([[1, 0.2], [0.2, 1.1]]), r"diagonal entry \[1, 1\] is 1.1, not 1"),
        (np.array([[1, 1.5], [1.5, 1]]), r"eigenvalue -0.5 \(largest 2.5\)"),
        # Three areas cannot all be opposed to each other: eigenvalues 1 + 2ρ, 1 - ρ, 1 - ρ.
        (np.eye(3) * 1.6 - 0.6, r"eigenvalue -0.2 \(largest 1.6\)"),
        (np.array([[1, np.nan], [np.nan, 1]]), "2 entries are not finite"),
        (np.ones((2, 3)), "not square"),
    ],
)
def test_matrices_that_are_no_correlation_are_refused(matrix, message):
    with pytest.raises(PhysicsError, match=message):
        check_correlation(matrix)


def test_a_silent_area_needs_a_zero_row():
    check_correlation(np.diag([1.0, 0.0]), np.array([True, False]))
    with pytest.raises(PhysicsError, match=r"diagonal entry \[1, 1\] is 0, not 1"):
        check_correlation(np.diag([1.0, 0.0]))


def test_factor_reproduces_real_and_complex_matrices():
    rng = np.random.default_rng(3)
    for phases in (np.zeros(9), rng.uniform(0, 2 * np.pi, 9)):
        mixing = rng.normal(size=(9, 4)) * np.exp(1j * phases[:, None]) if phases.any() else rng.normal(size=(9, 4))
        mixing /= np.linalg.norm(mixing, axis=1, keepdims=True)
        matrix = mixing @ mixing.conj().T
        factor = correlation_factor(matrix)
        assert factor.shape == (9, 4)
        np.testing.assert_allclose(factor @ factor.conj().T, matrix, atol=1e-13)
