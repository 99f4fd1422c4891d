"""Coefficients, delays, mirror pairs, partitions and matrices: what they must come to, and what is refused."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tedm_cli.config.cases import load_cases
from tedm_cli.errors import ConfigError, InputError, PhysicsError
from tedm_cli.noise.areas import AreaTable
from tedm_cli.noise.correlation import CorrelationCase, LabelledMatrix, correlation
from tedm_cli.noise.correlation_check import check_correlation
from tedm_cli.noise.propagation import TemperatureNoise
from tedm_cli.noise.selection import BlockSelector
from tedm_cli.noise.temperature import ShapedSpectrum, TemperatureModel, WhiteSpectrum

EVERYTHING = BlockSelector(areas=("*",))


def table(k, **columns):
    names = np.array([f"A{i}" for i in range(k)])
    given = {"group": ["g"] * k, "shield": ["inside"] * k, "side": ["mid"] * k} | columns
    centroid = given.pop("centroid_m", None)
    group, shield, side = (np.array(given[c]) for c in ("group", "shield", "side"))
    return AreaTable(names, group, shield, side, centroid)


def psd_of(case, areas, rows, model, f):
    found = correlation(case, areas)
    return TemperatureNoise(model, found).psd(rows, f)


@settings(max_examples=60, deadline=None)
@given(k=st.integers(2, 12), part=st.floats(0, 1), seed=st.integers(0, 2**32 - 1))
def test_coefficient_of_a_block(k, part, seed):
    """R = ρ J + (1 - ρ) I for every ρ a block of k areas can have, and S = ρ S_correlated + (1 - ρ) S_uncorrelated."""
    rho = -1 / (k - 1) + part * (1 + 1 / (k - 1))
    areas = table(k)
    case = CorrelationCase("r", "", (BlockSelector(areas=("*",), rho=rho),))
    matrix = correlation(case, areas).matrix()
    np.testing.assert_allclose(matrix, rho * np.ones((k, k)) + (1 - rho) * np.eye(k), atol=1e-14)
    rng = np.random.default_rng(seed)
    rows, f = rng.normal(size=(2, k)), np.array([1e-3, 1e-2])
    model = TemperatureModel.from_spectra(
        [WhiteSpectrum(1e-3) if rng.random() < 0.5 else ShapedSpectrum(1e-4) for _ in range(k)]
    )
    h = rows[:, :, None] * model.amplitudes(f)
    expected = rho * h.sum(axis=1) ** 2 + (1 - rho) * (h**2).sum(axis=1)
    np.testing.assert_allclose(psd_of(case, areas, rows, model, f), expected, atol=1e-13 * (h**2).sum(axis=1).max())


def test_a_coefficient_below_what_the_block_can_have_is_refused():
    case = CorrelationCase("r", "", (BlockSelector(areas=("*",), rho=-0.3),), "cases.toml")
    correlation(case, table(4))  # -1/3 is the least
    with pytest.raises(ConfigError, match=r"5 areas cannot all be correlated with -0.3 .* at least -1/4 = -0.25") as e:
        correlation(case, table(5))
    assert e.value.problems[0][0] == "blocks[0].rho"
    least = CorrelationCase("r", "", (BlockSelector(areas=("*",), rho=-1 / 6),))
    assert np.linalg.eigvalsh(correlation(least, table(7)).matrix())[0] == pytest.approx(0, abs=1e-14)


@pytest.mark.parametrize("rho", [1.0, 0.4, 0.0, -0.7])
def test_two_areas_with_a_delay_and_a_coefficient_by_hand(rho):
    """S = h1² + h2² + 2 ρ h1 h2 cos 2πf(τ1 - τ2): at the comb's zeros, its peaks, and between."""
    areas = table(2)
    case = CorrelationCase(
        "d",
        "",
        (BlockSelector(areas=("*",), rho=rho),),
        delays=((BlockSelector(areas=("A0",)), 40.0), (BlockSelector(areas=("A1",)), 140.0)),
    )
    model = TemperatureModel.from_spectra([WhiteSpectrum(1e-3), ShapedSpectrum(1e-4, 1e-3, 1e-3, 1)])
    f = np.array([1e-3, 2.5e-3, 5e-3, 7e-3, 1e-2])
    h1, h2 = 3e-3, -20.0 * 1e-4 * np.sqrt(2 / (1 + (f / 1e-3) ** 2))
    expected = h1**2 + h2**2 + 2 * rho * h1 * h2 * np.cos(2 * np.pi * f * 100.0)
    np.testing.assert_allclose(psd_of(case, areas, np.array([[3.0, -20.0]]), model, f)[0], expected, rtol=1e-12)


@settings(max_examples=30, deadline=None)
@given(seed=st.integers(0, 2**32 - 1), k=st.integers(2, 8))
def test_delays_turn_the_correlation_at_each_frequency(seed, k):
    rng = np.random.default_rng(seed)
    areas, f = table(k), np.geomspace(1e-4, 0.1, 9)
    mixing = rng.normal(size=(k, 3)) * np.exp(2j * np.pi * rng.random((k, 3)))
    mixing /= np.linalg.norm(mixing, axis=1, keepdims=True)
    value, delay_s = mixing @ mixing.conj().T, rng.uniform(-500, 500, k)
    case = CorrelationCase(
        "m",
        "",
        (),
        matrix=LabelledMatrix(tuple(areas.name), value),
        delays=tuple((BlockSelector(areas=(name,)), t) for name, t in zip(areas.name.tolist(), delay_s, strict=True)),
    )
    model = TemperatureModel.from_spectra(
        [WhiteSpectrum(1e-3) if rng.random() < 0.5 else ShapedSpectrum(1e-4) for _ in range(k)]
    )
    rows = rng.normal(size=(2, k))
    psd, amplitude = psd_of(case, areas, rows, model, f), model.amplitudes(f)
    for j, frequency in enumerate(f):
        turned = value * np.exp(-2j * np.pi * frequency * (delay_s[:, None] - delay_s))
        expected = np.einsum("oi,ij,oj->o", rows * amplitude[:, j], turned, rows * amplitude[:, j]).real
        assert np.all(np.abs(psd[:, j] - expected) < 1e-11 * np.sum((rows * amplitude[:, j]) ** 2))


def test_a_delay_common_to_all_areas_changes_nothing(areas, config):
    rng = np.random.default_rng(2)
    rows, f = rng.normal(size=(2, 78)), np.geomspace(1e-4, 0.1, 9)
    plain = config.case("4")
    late = CorrelationCase("4", "", plain.blocks, delays=((EVERYTHING, 1234.5),))
    model = config.temperature.model(areas)
    np.testing.assert_allclose(psd_of(late, areas, rows, model, f), psd_of(plain, areas, rows, model, f), rtol=1e-11)


def test_an_area_with_two_delays_or_none_of_that_name_is_refused(areas):
    delays = ((BlockSelector(groups=("IS1",)), 5.0), (BlockSelector(areas=("IS1_3", "IS9")), 6.0))
    with pytest.raises(ConfigError) as caught:
        correlation(CorrelationCase("d", "", (EVERYTHING,), delays=delays), areas)
    facts = dict(caught.value.problems)
    assert "no thermal area has 'IS9'; did you mean IS" in facts["delays[1].areas"]
    assert "IS1_3 is already in delays[0]" in facts["delays[1]"]


MIRROR = BlockSelector(areas=("*",), partition="mirror")
CENTROIDS = np.array([[1.0, 0.3, 0], [1.02, -0.3, 0], [2.0, 0.3, 0], [2.0, -0.31, 0], [0, 0, 0]])
SIDES = ["+y", "-y", "+y", "-y", "mid"]


def test_mirror_pairs_by_centroid_and_by_name():
    for areas, selector in (
        (table(5, side=SIDES, centroid_m=CENTROIDS), MIRROR),
        (
            AreaTable(
                np.array(["S_P1", "S_M1", "S_P2", "S_M2", "T"]),
                *(np.array(v) for v in (["g"] * 5, ["inside"] * 5, SIDES)),
            ),
            BlockSelector(areas=("*",), partition="mirror", mirror_names=("_P", "_M")),
        ),
    ):
        found = correlation(CorrelationCase("10b", "", (selector,)), areas)
        assert [b.tolist() for b in found.blocks] == [[0, 1], [2, 3], [4]]


def test_areas_without_a_mirror_image_are_refused():
    moved = CENTROIDS + np.array([[0, 0, 0], [0, 0, 0], [0, 0, 0], [0.5, 0, 0], [0, 0, 0]])
    case = CorrelationCase("10b", "", (MIRROR,))
    with pytest.raises(
        ConfigError, match=r"case 10b.*no area near its mirrored centroid\): A2, A3; pair .* mirror_names, or delete"
    ):
        correlation(case, table(5, side=SIDES, centroid_m=moved))
    with pytest.raises(ConfigError, match="matched by centroids, which these areas do not have; rebuild"):
        correlation(case, table(5, side=SIDES))
    named = CorrelationCase("10b", "", (BlockSelector(areas=("*",), partition="mirror", mirror_names=("0", "3")),))
    with pytest.raises(ConfigError, match=r"no name with '3'\): A2, A1; change mirror_names, or delete the case"):
        correlation(named, table(5, side=SIDES))


ONE = '[[case]]\nid = "x"\ntitle = "t"\n'


def case_of(tmp_path, text, areas):
    path = tmp_path / "cases.toml"
    path.write_text(ONE + text, encoding="utf-8")
    return correlation(load_cases(path)[1].case("x", where=str(path)), areas)


@pytest.mark.parametrize(
    ("text", "sizes"),
    [
        ('partition = "all"', [78]),
        ('partition = "none"', [1] * 78),
        ('partition = "group"', [8, 4, 26, 26, 14]),
        ('partition = "shield"', [12, 66]),
        ('partition = "side"\ngroups = ["struts", "flanges"]', [6, 6]),
        ('partition = "group"\ngroups = ["IS2", "OB"]\nrho = 0.3', [26, 14]),
        ('blocks = [{ areas = ["*"], partition = "shield", rho = -0.01 }]', [12, 66]),
    ],
)
def test_partitions_of_groups(tmp_path, areas, text, sizes):
    found = case_of(tmp_path, text, areas)
    assert [len(b) for b in found.blocks] == sizes
    check_correlation(found.matrix(), found.active)


@pytest.mark.parametrize(
    ("text", "piece"),
    [
        (
            'partition = "all"\nmatrix = "r.csv"',
            "give one of blocks, partition, matrix and thermal (found partition and matrix)",
        ),
        ('groups = ["OB"]\nmatrix = "r.csv"', "groups needs a partition"),
        ('matrix = "r.csv"\nrho = 0.5', "rho cannot be used with matrix"),
        ('partition = "all"\nrho = 1.5', "rho: correlation coefficient 1.5 is outside -1 to 1"),
        ('blocks = [{ areas = ["*"], each_alone = true, rho = 0.5 }]', "each area is alone"),
        ('blocks = [{ areas = ["*"], each_alone = true, partition = "side" }]', "give one of the two"),
        ('blocks = [{ areas = ["*"], mirror_names = ["P", "M"] }]', "mirror_names needs partition = 'mirror'"),
        ('blocks = [{ areas = ["*"], each_alone = true, across_kinds = true }]', "each area is alone"),
        ('partition = "mirror"\nacross_kinds = true', "across_kinds cannot be used with mirror"),
        ('matrix = "r.csv"\nacross_kinds = true', "across_kinds needs a partition"),
        ('partition = "group"\ngroups = ["strut"]', "no thermal area has 'strut'; did you mean struts?"),
    ],
)
def test_cases_that_contradict_themselves_are_refused(tmp_path, areas, text, piece):
    with pytest.raises(ConfigError) as caught:
        case_of(tmp_path, text, areas)
    assert piece in str(caught.value)
    assert caught.value.exit_code == 3


CSV = "area,IS1_2,OB_1,STRUTS_1\nOB_1,0.5-0.2i,1,0\nIS1_2,1,0.5+0.2j,0\nSTRUTS_1,0,0,1\n"


@pytest.mark.parametrize("form", ["csv", "npz"])
def test_a_matrix_from_a_file(tmp_path, areas, form):
    """Areas in any order; others are silent; areas that nothing connects are different blocks."""
    path = tmp_path / f"r.{form}"
    if form == "csv":
        path.write_text(CSV, encoding="utf-8")
    else:
        value = np.array([[1, 0.5 + 0.2j, 0], [0.5 - 0.2j, 1, 0], [0, 0, 1]])
        np.savez(path, area=["IS1_2", "OB_1", "STRUTS_1"], R=value)
    found = case_of(tmp_path, f'matrix = "r.{form}"', areas)
    strut, is1, ob = (areas.name.tolist().index(n) for n in ("STRUTS_1", "IS1_2", "OB_1"))
    assert [b.tolist() for b in found.blocks] == [[strut], [is1, ob]]
    matrix = found.matrix()
    assert matrix[is1, ob] == pytest.approx(0.5 + 0.2j)
    assert matrix[ob, is1] == pytest.approx(0.5 - 0.2j)
    assert np.flatnonzero(found.active).tolist() == [strut, is1, ob]


def test_an_impossible_matrix_names_its_areas_and_what_would_be_possible(tmp_path, areas):
    """Three areas at -0.6 to each other: eigenvalues 1.6, 1.6, -0.2; at most -0.5 = 0.8333 (-0.6) is possible."""
    names = ["OB_1", "OB_2", "OB_3", "IS1_1"]
    value = np.eye(4)
    value[:3, :3] = 1.6 * np.eye(3) - 0.6
    np.savez(tmp_path / "r.npz", area=names, R=value)
    with pytest.raises(PhysicsError, match=r"r\.npz: not positive semidefinite: eigenvalue -0.2 \(largest 1.6\)") as e:
        case_of(tmp_path, 'matrix = "r.npz"', areas)
    assert e.value.exit_code == 5
    assert sorted(e.value.fact.rpartition("carried by ")[2].split(", ")) == ["OB_1", "OB_2", "OB_3"]
    factor = float(e.value.hint.split("by ")[1].split()[0])
    assert factor == 0.8333
    check_correlation(np.eye(4) + factor * (value - np.eye(4)))


@pytest.mark.parametrize(
    ("text", "error", "piece"),
    [
        (
            CSV.replace("0.5-0.2i", "0.5"),
            PhysicsError,
            "not Hermitian: entries [IS1_2, OB_1] and [OB_1, IS1_2] are 0.5+",
        ),
        (CSV.replace("STRUTS_1,0,0,1", "STRUTS_1,0,0,1.1"), PhysicsError, "diagonal entry [STRUTS_1, STRUTS_1] is 1.1"),
        (CSV.replace("STRUTS_1", "STRUT_1"), ConfigError, "no thermal area has 'STRUT_1'; did you mean STRUTS_1?"),
        (CSV.replace("STRUTS_1,0,0,1\n", ""), InputError, "area 'STRUTS_1' has no row"),
        (CSV.replace("0.5-0.2i", "half"), InputError, "r.csv:2: IS1_2 must be a finite number, real or complex"),
        (CSV.replace("STRUTS_1,0,0,1", "STRUTS_1,0,1"), InputError, "r.csv:4: 3 fields, wanted 4"),
        (CSV.replace("IS1_2,1", "OB_1,1"), InputError, "r.csv:3: area 'OB_1' has two rows"),
        ("name,A\nA,1\n", InputError, "r.csv:1: must begin with the header area,NAME"),
        ("area,OB_1,OB_1\nOB_1,1,1\n", ConfigError, "area 'OB_1' is named 2 times"),
    ],
)
def test_matrix_files_that_are_refused(tmp_path, areas, text, error, piece):
    (tmp_path / "r.csv").write_text(text, encoding="utf-8")
    with pytest.raises(error) as caught:
        case_of(tmp_path, 'matrix = "r.csv"', areas)
    assert piece in str(caught.value)


def test_archives_that_are_refused(tmp_path, areas):
    with pytest.raises(InputError, match="does not exist or is not a file"):
        case_of(tmp_path, 'matrix = "r.npz"', areas)
    (tmp_path / "r.npz").write_bytes(b"no archive")
    with pytest.raises(InputError, match="not a readable NPZ"):
        case_of(tmp_path, 'matrix = "r.npz"', areas)
    np.savez(tmp_path / "r.npz", names=["OB_1"], R=np.eye(1))
    with pytest.raises(InputError, match="holds no array 'area', only names, R"):
        case_of(tmp_path, 'matrix = "r.npz"', areas)
    np.savez(tmp_path / "r.npz", area=["OB_1"], R=np.eye(2))
    with pytest.raises(InputError, match=r"R is float64 \(2, 2\) for 1 areas"):
        case_of(tmp_path, 'matrix = "r.npz"', areas)
