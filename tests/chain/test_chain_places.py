"""Where temperatures act: `tedm explain OUTPUT --grids`, the figures, and the report's section, on the small sample."""

from __future__ import annotations

import re
import shutil
from dataclasses import replace
from pathlib import Path

import h5py
import numpy as np
import pytest
from matplotlib.figure import Figure

from tedm_cli.cli.printing.as_json import plain
from tedm_cli.cli.printing.explained import told_dict, told_lines
from tedm_cli.config.project import Project
from tedm_cli.errors import InputError, UsageError
from tedm_cli.figures.drawing.style import svg
from tedm_cli.results.build_folder import open_results
from tedm_cli.results.cases.file import read_case
from tedm_cli.stages.explain.name import Load, explain_places
from tedm_cli.stages.reporting.plot import figure_specs
from tedm_cli.stages.reporting.report import report


def tables(project: Project, name: str, load: Load = Load()) -> dict[str, list[dict[str, float]]]:
    found = plain(told_dict(explain_places(project, name, load), None))["tables"]
    assert isinstance(found, dict)
    return found


@pytest.mark.parametrize(
    ("name", "load", "rows"),
    [
        ("TM1_a_x", Load(), {"TM1_a_x": 1.0}),
        ("A_TM1_x", Load(), {"A_TM1_x": 1.0}),
        ("TM1_x", Load(set_name="B"), {"B_TM1_x": 1.0}),
        ("TM2_a_x-TM1_a_x", Load(), {"TM2_a_x": 1.0, "TM1_a_x": -1.0}),
    ],
)
def test_places_and_grids_are_all_of_the_output(small: Project, name: str, load: Load, rows: dict[str, float]) -> None:
    found = tables(small, name, load)
    with h5py.File(small.build_dir / "adjoint.h5") as file, h5py.File(small.build_dir / "unit_loads.h5") as unit:
        labels, ids = file["/row/label"].asstr()[()].tolist(), file["/grid/id"][()]
        s, whole = (sum(f * file[p][labels.index(r)] for r, f in rows.items()) for p in ("/s", "/map/s"))
        place = dict(zip(unit["/grid/id"][()].tolist(), unit["/grid/position"][()], strict=True))
        volume = file["/map/volume"][()].sum()
    places, grids = found["places"], found["grids"]
    assert sum(p["share"] for p in places) == pytest.approx(1.0, rel=1e-12)
    assert sum(p["value"] for p in places) == pytest.approx(whole.sum(), abs=1e-12 * np.abs(whole).sum())
    assert sum(p["volume"] for p in places) == pytest.approx(1e6 * volume, rel=0.02)
    worst = int(np.abs(s).argmax())
    assert (grids[0]["grid"], grids[0]["value"]) == (ids[worst], s[worst])
    assert grids[0]["share"] == pytest.approx(np.abs(s).max() / np.abs(s).sum(), rel=1e-12)
    np.testing.assert_allclose([grids[0][axis] for axis in "xyz"], 1e3 * place[int(ids[worst])], atol=1e-9)


def test_as_text_the_largest_come_first(small: Project) -> None:
    lines = told_lines(explain_places(small, "TM1_a_x", Load()), 3)
    assert "1 K everywhere" in lines[2]
    assert len([line for line in lines if line.startswith("and ")]) == 2
    head = next(i for i, line in enumerate(lines) if line.startswith("place in area"))
    assert "  share of all %  " in lines[head]
    assert "  share of grids %  " in next(line for line in lines if line.startswith("grid  "))
    assert (
        len([line for line in lines[head + 2 : head + 5] if re.search(r" -?\d+\.\d +-?\d+\.\d +-?\d+\.\d ", line)]) == 3
    )


@pytest.mark.parametrize(
    ("name", "load", "fact"),
    [
        (None, Load(), "takes the name of an output"),
        ("STRUT_1", Load(), "no output is called 'STRUT_1'"),
        ("TM1_ax", Load(), "no output is called 'TM1_ax'"),
        ("TM1_a_x-A_TM1_x", Load(), "is a difference of m/s^2 and m"),
        ("TM1_a_x", Load(set_name="A"), "--set is for read-outs"),
        ("TM1_x", Load(uniform=True), "--uniform and --grids ask for different things"),
    ],
)
def test_what_it_does_not_take(small: Project, name: str | None, load: Load, fact: str) -> None:
    with pytest.raises(UsageError) as error:
        explain_places(small, name, load)
    assert fact in error.value.fact


@pytest.fixture(scope="module")
def own(small: Project, tmp_path_factory: pytest.TempPathFactory) -> Project:
    """The same build folder, to be changed; its figures are empty but for those of the adjoint."""
    build = tmp_path_factory.mktemp("places") / "build"
    shutil.copytree(small.build_dir, build)
    project = replace(small, build_dir=build)
    with open_results(project) as results:
        for spec in figure_specs(results, [read_case(file) for file in results.cases]):
            figure = spec.draw() if spec.section == "where" else Figure(figsize=(4.0, 3.0))
            (build / "figures").mkdir(exist_ok=True)
            (build / "figures" / spec.name).write_bytes(svg(figure, spec.caption, spec.sources))
    return project


def test_figures_and_report_show_where(own: Project) -> None:
    """A figure of each judged output; that of the one that binds is in the report, with its largest place."""
    with open_results(own) as results:
        cases = [read_case(file) for file in results.cases]
        specs = {s.name: s for s in figure_specs(results, cases) if s.section == "where"}
    judged = {j.output for case in cases for j in case.judged}
    assert {name.removeprefix("adjoint_").removesuffix(".svg") for name in specs} - {"areas_against_a_field"} <= judged
    (first,) = [name for name, spec in specs.items() if spec.decides]
    text = (own.build_dir / "figures" / first).read_text(encoding="utf-8")
    assert "sensitivity per volume (" in text
    assert "per m³)" in text
    assert text.count("<image") == 4
    decision, annex = (path.read_text(encoding="utf-8") for path in report(own, None, ["md"]))
    assert f"figures/{first}" in decision
    assert all(f"figures/{name}" in annex for name in specs if name != first)
    largest = tables(own, first.removeprefix("adjoint_").removesuffix(".svg"))["places"][0]
    row = next(
        line for line in decision.split("Places with the largest shares")[1].splitlines() if "%" in line and "|" in line
    )
    assert row.startswith(f"| {largest['place_in_area']} | {100 * largest['share']:.1f} %")
    docs = Path(__file__).parents[2] / "docs" / "reference" / "figures.md"
    assert "`adjoint_OUTPUT.svg`" in docs.read_text(encoding="utf-8")


def test_without_an_adjoint_it_is_said(own: Project) -> None:
    (own.build_dir / "adjoint.h5").unlink()  # the last test of this module
    with open_results(own) as results:
        assert not [s for s in figure_specs(results, [read_case(f) for f in results.cases]) if s.section == "where"]
    decision = report(own, None, ["md"])[0].read_text(encoding="utf-8")
    assert "temperatures act has not been found: tedm build-adjoint has not been run." in decision
    with pytest.raises(InputError, match=r"adjoint\.h5: no such file"):
        explain_places(own, "TM1_a_x", Load())
