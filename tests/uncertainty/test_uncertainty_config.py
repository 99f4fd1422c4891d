"""What may be uncertain in a configuration, and what is refused: each problem with place, fact and a way out."""

from __future__ import annotations

from pathlib import Path

import pytest

from tedm_cli.config.base import validate
from tedm_cli.config.cases import load_cases
from tedm_cli.config.model.file import load_model
from tedm_cli.config.uncertainty import CasesUncertainty, ModelUncertainty
from tedm_cli.errors import ConfigError

ROOT = Path(__file__).parents[2]
SIGMA = {"relative_sigma": 0.1}


def material(**keys: object) -> dict[str, object]:
    deviation = {} if any("sigma" in k or "width" in k for k in keys) else SIGMA
    return {"name": "a", "material": 1, "of": "expansion", "source": "-", **deviation, **keys}


def shell(name: str = "s", **keys: object) -> dict[str, object]:
    return {"name": name, "property": 7, "relative_half_width": 0.1, "source": "-", **keys}


def place(name: str = "p", **keys: object) -> dict[str, object]:
    return {"name": name, "test_mass": "TM1", "absolute_sigma_m": 1e-4, "source": "-", **keys}


def model(**tables: object) -> ModelUncertainty:
    return validate(ModelUncertainty, tables, where="model.toml")


def test_a_key_says_what_its_number_is() -> None:
    """Sigma: one standard deviation, normal or lognormal; half width: uniform. The unit is in the key."""
    for keys, wanted in (
        ({}, ("normal", "standard deviation", 0.1, "1")),
        ({"distribution": "lognormal"}, ("lognormal", "standard deviation", 0.1, "1")),
        ({"relative_half_width": 0.3}, ("uniform", "half width", 0.3, "1")),
        ({"relative_half_width": 0.3, "distribution": "uniform"}, ("uniform", "half width", 0.3, "1")),
        ({"absolute_sigma_per_K": 2e-8}, ("normal", "standard deviation", 2e-8, "1/K")),
        ({"absolute_half_width_per_K": 2e-8}, ("uniform", "half width", 2e-8, "1/K")),
    ):
        found = model(material=[material(**keys)]).material[0].parameter("MAT1 1")
        assert (found.distribution, found.measure, found.deviation, found.unit) == wanted
    moved = model(test_mass=[place(absolute_half_width_m=1e-3, absolute_sigma_m=None)]).test_mass[0]
    assert moved.parameter("TM1 along y", "p_y").unit == "m"
    assert moved.names() == ["p_x", "p_y", "p_z"]


@pytest.mark.parametrize(
    ("tables", "path", "fact"),
    [
        ({"material": [material(relative_sigma=-0.1)]}, "material[0].relative_sigma", "-0.1 is outside 0 to 10"),
        ({"material": [material(relative_sigma=float("nan"))]}, "material[0].relative_sigma", "finite number"),
        ({"material": [material(relative_sigma=float("inf"))]}, "material[0].relative_sigma", "finite number"),
        ({"material": [material(absolute_sigma_per_K=-1e-8)]}, "material[0].absolute_sigma_per_K", "is outside 0 to"),
        ({"shell": [shell(relative_half_width=-0.1)]}, "shell[0].relative_half_width", "is outside 0 to 10"),
        ({"test_mass": [place(absolute_sigma_m=-1e-4)]}, "test_mass[0].absolute_sigma_m", "is outside 0 to 0.1 m"),
        (
            {"material": [material(relative_sigma=0.1, absolute_sigma_per_K=1e-8)]},
            "material[0]",
            "give one of relative_sigma, relative_half_width, absolute_sigma_per_K, absolute_half_width_per_K",
        ),
        ({"material": [material(relative_sigma=None)]}, "material[0]", "(found none)"),
        ({"material": [material(distribution="uniform")]}, "material[0]", "needs a half width, found relative_sigma"),
        (
            {"material": [material(relative_half_width=0.1, distribution="normal")]},
            "material[0]",
            "needs a sigma, found relative_half_width",
        ),
        (
            {"material": [material(absolute_sigma_per_K=1e-8, distribution="lognormal")]},
            "material[0]",
            "is of the logarithm, and relative",
        ),
        (
            {"material": [material(of="modulus", absolute_sigma_per_K=1e-8)]},
            "material[0]",
            "the deviation of a modulus is relative",
        ),
        ({"material": [material(of="density", relative_sigma=0.3)]}, "material[0]", "make the density negative"),
        ({"shell": [shell(relative_half_width=1.0)]}, "shell[0]", "make the thickness negative: it must be below 1"),
        ({"material": [material(material=None)]}, "material[0]", "needs either material or property"),
        ({"material": [material(property=4)]}, "material[0]", "needs either material or property"),
        ({"material": [material(of="poisson")]}, "material[0].of", "'expansion', 'modulus' or 'density'"),
        ({"material": [material(sigma=0.1)]}, "material[0].sigma", "unknown key"),
        ({"test_mass": [place(axes=["x", "x"])]}, "test_mass[0].axes", "an axis is there twice"),
        ({"material": [material(source=" ")]}, "material[0].source", "must not be blank"),
    ],
)
def test_a_table_that_cannot_be_is_refused(tables: dict[str, object], path: str, fact: str) -> None:
    with pytest.raises(ConfigError) as caught:
        model(**tables)
    assert [problem[0] for problem in caught.value.problems] == [path]
    assert fact in caught.value.problems[0][1]


def test_expansions_may_deviate_by_all_of_them() -> None:
    """An expansion may be negative; what is lognormal may be wide."""
    model(material=[material(relative_sigma=2.0)])
    model(material=[material(of="modulus", relative_sigma=2.0, distribution="lognormal")])


@pytest.mark.parametrize(
    ("tables", "path", "fact"),
    [
        (
            {"material": [material(), material(of="modulus")]},
            "uncertainty.material[1].name",
            "'a' is the name of a parameter already, in uncertainty.material[0].name",
        ),
        ({"material": [material(name="p_x")], "test_mass": [place()]}, "uncertainty.test_mass[0].name", "'p_x' is the"),
        ({"shell": [shell("mesh")]}, "uncertainty.shell[0].name", "'mesh' is the name of the error by the mesh"),
        ({"test_mass": [place(test_mass="TM3")]}, "uncertainty.test_mass[0].test_mass", "there are: TM1, TM2"),
        (
            {"test_mass": [place("p", axes=["x", "y"]), place("q", axes=["y"])]},
            "uncertainty.test_mass[1].axes",
            "position of TM1 along y is uncertain already in uncertainty.test_mass[0]",
        ),
        (
            {"shell": [shell("s"), shell("t")], "correlation": [{"parameters": ["s", "u"], "rho": 0.5}]},
            "uncertainty.correlation[0].parameters",
            "there is no parameter 'u'; there are: s, t",
        ),
        (
            {"shell": [shell("s")], "correlation": [{"parameters": ["s", "s"], "rho": 0.5}]},
            "uncertainty.correlation[0].parameters",
            "'s' is there twice",
        ),
        (
            {
                "shell": [shell("s"), shell("t")],
                "correlation": [{"parameters": ["s", "t"], "rho": 0.5}, {"parameters": ["t", "s"], "rho": 0.6}],
            },
            "uncertainty.correlation[1].parameters",
            "correlated already in uncertainty.correlation[0]",
        ),
        (
            {"shell": [shell(n) for n in "stu"], "correlation": [{"parameters": ["s", "t", "u"], "rho": -0.6}]},
            "uncertainty.correlation",
            "s, t, u cannot be correlated so: not positive semidefinite",
        ),
    ],
)
def test_tables_that_contradict_each_other_are_refused(tables: dict[str, object], path: str, fact: str) -> None:
    found = model(**tables)
    problems = found.problems(["TM1", "TM2"])
    assert [problem[0] for problem in problems] == [path]
    assert fact in problems[0][1]
    if "correlation" in tables:
        levels = [{"name": n, "areas": ["*"], **SIGMA, "source": "-"} for n in "stu"[: len(found.shell)]]
        cases = validate(CasesUncertainty, {"level": levels, "correlation": tables["correlation"]}, where="cases.toml")
        assert [problem[0] for problem in cases.problems()] == [path]


def test_correlations_that_agree_are_taken() -> None:
    pairs = model(shell=[shell(n) for n in "stu"], correlation=[{"parameters": ["s", "t", "u"], "rho": -0.5}])
    assert pairs.problems([]) == []
    assert pairs.pairs() == {("s", "t"): -0.5, ("s", "u"): -0.5, ("t", "u"): -0.5}


def test_they_are_told_with_the_files_other_problems(tmp_path: Path) -> None:
    shipped = (ROOT / "configs" / "model.toml").read_text(encoding="utf-8")
    path = tmp_path / "model.toml"
    path.write_text(shipped.replace('test_mass = "TM2"', 'test_mass = "TM9"'), encoding="utf-8")
    with pytest.raises(ConfigError, match=r"uncertainty.test_mass\[1\].test_mass: there is no test mass 'TM9'"):
        load_model(path)
    cases = (ROOT / "configs" / "cases.toml").read_text(encoding="utf-8")
    path.write_text(cases.replace('name = "level_inside"', 'name = "level_outside"'), encoding="utf-8")
    with pytest.raises(ConfigError, match=r"uncertainty.level\[1\].name: 'level_outside' is the name"):
        load_cases(path)


def test_shipped_values_say_where_they_are_from() -> None:
    """From a catalogue, or assumed and said so."""
    tables = load_model(ROOT / "configs" / "model.toml")[1].uncertainty
    levels = load_cases(ROOT / "configs" / "cases.toml")[1].uncertainty.level
    sources = [t.source for t in (*tables.material, *tables.shell, *tables.test_mass, *levels)]
    assert len(sources) == 16
    assert sum(source.startswith("SCHOTT") for source in sources) == 1
    assert all(source.startswith(("SCHOTT", "assumption (example)")) for source in sources)
    assert tables.of_structure


def test_the_other_mesh_is_beside_the_cases_file(tmp_path: Path) -> None:
    cases = (ROOT / "configs" / "cases.toml").read_text(encoding="utf-8")
    path = tmp_path / "cases.toml"
    path.write_text(cases + '\n[uncertainty.mesh]\nother = "fine/tedm.toml"\n', encoding="utf-8")
    mesh = load_cases(path)[1].uncertainty.mesh
    assert mesh is not None
    assert (mesh.other, mesh.order, mesh.sigma, mesh.refinement) == (str(tmp_path / "fine/tedm.toml"), 2.0, 1.0, None)
