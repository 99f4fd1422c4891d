"""`tedm suggest-areas` on the small sample: areas that the chain takes, errors that are told, and refusals."""

from __future__ import annotations

import json
import re
import shutil
from pathlib import Path

import numpy as np
import pytest
from border_tools import SMALL, Project, replace
from matplotlib.figure import Figure

from tedm_cli.areas.csv_file import read_area_csv
from tedm_cli.cli.printing.suggest import _errors
from tedm_cli.contracts import CASE
from tedm_cli.figures.model.areas import AreaModel
from tedm_cli.files.store import open_checked

FEW = ("--length-mm", 20, "--length-mm", 500)


@pytest.fixture(scope="module")
def suggested(chain: Project, tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, dict]:
    """The CSV of 40 areas, and what was said of them."""
    path = tmp_path_factory.mktemp("suggested") / "areas.csv"
    return path, json.loads(chain.run("suggest-areas", "--count", 40, *FEW, "--json", "-o", path).ok().out)


def test_the_areas_are_a_partition_that_cases_take(suggested, chain: Project) -> None:
    path, said = suggested
    found, now = read_area_csv(path), read_area_csv(chain.folder / "ltp_small_areas.csv")
    assert len(found) == 40 == said["count"]
    assert {name: len(ids) for name, ids in found.items()} == said["areas"]
    assert sorted(np.concatenate(list(found.values()))) == sorted(np.concatenate(list(now.values())))
    assert said["notes"] == []
    group = {int(grid): name.split("_")[0] for name, ids in now.items() for grid in ids}
    for name, ids in found.items():
        assert {group[int(grid)] for grid in ids} == {name.split("_")[0]}


def test_more_areas_are_nearer_and_fit_better_than_those_there_are(suggested) -> None:
    _, said = suggested
    assert said["length_mm"] == [20.0, 500.0]
    error = {one["count"]: np.abs(np.array(one["ratio"]) - 1.0).max() for one in said["curve"]}
    now = np.abs(np.array(said["present"]["ratio"]) - 1.0).max()
    assert said["present"]["count"] == 28
    as_many = max(count for count in error if count <= 28)  # the one below where a mirror image would lack
    assert as_many >= 27
    assert error[as_many] < 0.5 * now
    assert error[200] < error[40] < error[said["fewest"]]
    assert error[40] == pytest.approx(np.abs(np.array(said["ratio"]) - 1.0).max())
    share = [one["share"] for one in said["present"]["coarsest"]]
    assert share == sorted(share, reverse=True)
    assert 0.0 < sum(share) <= 1.0


def built(small: Project) -> None:
    """The unit loads of the areas as they are now, solved here, up to the adjoint."""
    shutil.copy(SMALL / "ltp_small.bdf", small.folder)
    replace(small.model, 'deck = "unit_loads.bdf"\nop2 = ["unit_loads.op2"]\n', "")
    stages = ("write-deck", "solve", "ingest", "build-distortion", "build-sensitivity", "build-optics", "build-adjoint")
    for command in stages:
        small.run(command).ok()


def test_the_chain_takes_them_and_tells_their_error(suggested, small: Project) -> None:
    """With the areas in place of the old ones: their error is what was said of them before."""
    path, said = suggested
    (small.folder / "ltp_small_areas.csv").write_bytes(path.read_bytes())
    built(small)
    small.run("run-case", "10b").ok()
    again = json.loads(small.run("suggest-areas", "--count", 40, *FEW, "--json").ok().out)
    assert again["present"]["count"] == 40
    # The amplitudes are those of the temperatures, at the frequencies where the outputs are judged, which stay.
    assert np.array(again["present"]["ratio"]) == pytest.approx(np.array(said["ratio"]), rel=2e-3)


def test_areas_of_elements_and_gradients_stay(small: Project, tmp_path: Path) -> None:
    areas = small.folder / "ltp_small_areas.csv"
    areas.write_text("".join(line for line in areas.read_text().splitlines(True) if "STRUT" not in line))
    table = '[[areas.define]]\nname = "STRUT_{}"\nproperty = 10\n{}\n'
    sides = [
        f'box = {{ y_m = [{low}, {high}] }}\ncarrier = "elements"' for low, high in (("0.0", "inf"), ("-inf", "0.0"))
    ]
    define = [table.format(n, how) for n, how in zip("ABC", [*sides, 'kind = "gradient"\nplane = 1'], strict=True)]
    replace(small.model, "[[test_mass]]", "".join(define) + "[[test_mass]]")
    built(small)
    out = tmp_path / "areas.csv"
    said = json.loads(small.run("suggest-areas", "--count", 30, *FEW, "--json", "-o", out).ok().out)
    assert said["present"]["count"] == 22  # 20 of grids, and the two of elements
    assert said["count"] == 30
    assert {"STRUT_A", "STRUT_B"} & {one["area"] for one in said["present"]["coarsest"]}
    found, before = read_area_csv(out), read_area_csv(areas)
    assert len(found) == 28
    assert not any(name.startswith("STRUT") for name in found)
    assert sorted(np.concatenate(list(found.values()))) == sorted(np.concatenate(list(before.values())))
    assert said["notes"] == ["areas of elements and gradients stay as they are defined: STRUT_A, STRUT_B, STRUT_C"]
    areas.write_bytes(out.read_bytes())
    small.run("areas").ok()


@pytest.fixture
def defined(small: Project) -> Project:
    """Two areas of elements and the rest of the grids by definitions, and a CSV of three areas; solved and built."""
    areas = small.folder / "ltp_small_areas.csv"
    rows = "".join(line for line in areas.read_text().splitlines(True) if "STRUT" not in line and "OB_" not in line)
    areas.write_text(re.sub(r"(FLANGE|IS1|IS2)_\w+", r"\1_ALL", rows))
    table = '[[areas.define]]\nname = "STRUT_{}"\nproperty = 10\ncarrier = "elements"\nbox = {{ y_m = [{}] }}\n'
    rest = '[[areas.define]]\nname = "OB_Rest"\nremainder = true\n'
    define = [table.format("A", "0.0, inf"), table.format("B", "-inf, 0.0"), rest]
    replace(small.model, "[[test_mass]]", "".join(define) + "[[test_mass]]")
    built(small)
    return small


def test_areas_that_are_defined(defined: Project, tmp_path: Path) -> None:
    """What has to follow is said and is enough; present areas that are enough are called so; an error out of reach."""
    out, length = tmp_path / "areas.csv", ("--length-mm", 500)
    told = defined.run("suggest-areas", "--error", 0.9, "--length-mm", 1e6).ok().out
    assert "the 6 present areas are enough" in told
    assert "* 6 areas, those that there are\n" in told
    told = defined.run("suggest-areas", "--error", 0.5, *length).ok().out
    assert "are enough" not in told
    assert "* 7 areas, 2 of them new, of 50 grids;" in told  # the flanges, two by two

    refusal = defined.run("suggest-areas", "--error", 1e-6, "--length-mm", 20)
    refusal.refused(2, "--error 1e-06 is not reached: ", "an area of elements, which is not divided here")
    where = re.search(r"areas leave 0\.\d+, of ([AB]_TM[12]_x) at 20 mm, most by (STRUT_[AB]), an area", refusal.err)
    assert where, refusal.err
    output, area = where.groups()
    hint = f"hint: divide {area} in [areas] define (`tedm explain {output} --grids` shows where)\n"
    assert refusal.err.endswith(hint)
    defined.run("explain", output, "--grids").ok()

    told = defined.run("suggest-areas", "--count", 30, *length, "-o", out).ok().out
    remove = "with the CSV, remove OB_Rest from [areas] define (its grids are in the CSV); the other entries stay"
    assert f"note: {remove}\n" in told
    text = out.read_text()
    (defined.folder / "ltp_small_areas.csv").write_text(
        text.replace("OB_REST", "OB_PART").replace("OB_Rest", "OB_PART")
    )
    defined.run("areas").refused(
        3, "area 'OB_Rest' has no grid: nothing is left", hint="remove areas.define[2] (OB_Rest)"
    )
    (defined.folder / "ltp_small_areas.csv").write_text(text)
    replace(defined.model, '[[areas.define]]\nname = "OB_Rest"\nremainder = true\n', "")
    defined.run("areas").ok()


def test_an_even_field_is_the_case_of_all_areas_correlated(small: Project) -> None:
    """Where nothing decorrelates: the ratios of case 1, with the temperatures of the cases file."""
    said = json.loads(small.run("suggest-areas", "--count", 30, "--length-mm", 1e9, "--json").ok().out)
    small.run("run-case", 1).ok()
    with open_checked(small.build / "case01.h5", CASE) as file:
        verdict = dict(zip(file.strings(CASE.VERDICT_OUTPUT), file.array(CASE.VERDICT_RATIO), strict=True))
    found = dict(zip(said["outputs"], said["field_ratio"][0], strict=True))
    assert found.keys() == verdict.keys()
    for output in ("TM1_a_x", "TM2_a_x"):  # in read-outs grids cancel to more digits than 1e9 mm leave
        assert found[output] == pytest.approx(verdict[output], rel=1e-4)


def test_as_few_as_an_error_allows(chain: Project) -> None:
    said = json.loads(chain.run("suggest-areas", "--error", 0.05, *FEW, "--even", "--json").ok().out)
    assert np.abs(np.array(said["ratio"]) - 1.0).max() <= 0.05
    assert said["amplitude"] == "even"
    for one in said["curve"]:
        if one["count"] > said["count"]:
            assert np.abs(np.array(one["ratio"]) - 1.0).max() <= 0.05


def test_lines_and_figure(chain: Project, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    drawn = []

    def empty(model: AreaModel, title: str) -> Figure:
        drawn.append((model, title))
        return Figure()

    monkeypatch.setattr("tedm_cli.figures.model.areas.area_figure", empty)
    figure, curve = tmp_path / "areas.svg", tmp_path / "curve.svg"
    options = ("--count", 30, "--length-mm", 100, "--top", 2, "--figure", figure, "--curve", curve)
    out = chain.run("suggest-areas", *options).ok().out
    assert "28 now" in out
    assert "30 *" in out
    assert out.count(" %") > 20
    assert "-o writes them" in out
    ((model, title),) = drawn
    assert title.endswith("30 suggested thermal areas of unit_loads.bdf")
    assert figure.read_text().startswith("<?xml")
    assert "error by number of thermal areas" in curve.read_text()
    assert len(model.name) == len(model.group) == 30
    assert np.unique(model.label).tolist() == list(range(30))
    assert {g for n, g in zip(model.name, model.group, strict=True) if n.startswith("STRUT")} == {"struts"}


def test_no_error_has_no_sign() -> None:
    ratio = np.array([[0.9997, 1.0002], [0.9, 1.05], [1.2, 0.9]])
    assert _errors(ratio) == ["0.0 %", "-10.0 %", "+20.0 %"]
    assert _errors(np.array([[0.99948]])) == ["-0.1 %"]


@pytest.mark.parametrize(
    ("options", "code", "fact"),
    [
        ((), 2, "give --count or --error, one of the two"),
        (("--count", 30, "--error", 0.1), 2, "give --count or --error, one of the two"),
        (("--count", 3), 2, "--count 3: at least"),
        (("--count", 1900), 2, "--count 1,900: at most"),
        (("--error", 0), 2, "relative error 0 is outside"),
        (("--error", "nan"), 2, "relative error nan is outside"),
        (("--count", 30, "--length-mm", -1), 2, "correlation length -1 is outside"),
        (("--count", 30, "--figure", "areas.pdf"), 2, "--figure areas.pdf: must end in .svg or .png"),
        (("--count", 30, "--curve", "c.pdf"), 2, "--curve c.pdf: must end in .svg or .png"),
    ],
)
def test_what_cannot_be_suggested(chain: Project, options: tuple, code: int, fact: str) -> None:
    chain.run("suggest-areas", *options).refused(code, fact)


def test_without_an_adjoint(small: Project) -> None:
    (small.build / "adjoint.h5").unlink()
    small.run("suggest-areas", "--count", 30).refused(4, "no such file", hint="tedm build-adjoint")


def test_with_an_adjoint_of_other_files(small: Project) -> None:
    replace(small.model, "mid_half_width_m = 0.005", "mid_half_width_m = 0.006")
    small.run("suggest-areas", "--count", 30).refused(4, "stale", hint="tedm build-adjoint")


def test_with_nothing_judged(small: Project) -> None:
    text = (small.folder / "cases.toml").read_text()
    first, rest = text.split("[[requirement]]", 1)
    kept = "# Correlation cases" + rest.split("# Correlation cases", 1)[1]
    (small.folder / "cases.toml").write_text(first + kept)
    small.run("suggest-areas", "--count", 30).refused(3, "there is none: nothing is judged")
