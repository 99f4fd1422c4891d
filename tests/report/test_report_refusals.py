"""Results that do not fit together are refused with the file and the command that mends them."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from pathlib import Path
from unittest import mock

import pytest
from report_project import close_loop, write_matrices

from tedm_cli.config.project import Project
from tedm_cli.errors import InputError
from tedm_cli.figures.drawing.fonts import font_folder
from tedm_cli.progress import silent
from tedm_cli.report.document import Document, Figure, Section
from tedm_cli.report.pdf import to_pdf
from tedm_cli.results.build_folder import open_results
from tedm_cli.results.dynamics.loop import read_simulation
from tedm_cli.stages.dynamics.build import build_dynamics
from tedm_cli.stages.dynamics.simulate import simulate
from tedm_cli.stages.noise.case import run_cases
from tedm_cli.stages.reporting.plot import plot
from tedm_cli.stages.reporting.report import report

Stage = Callable[[Project], object]


def draw(project: Project) -> object:
    return plot(project, None, silent)


def page(project: Project) -> object:
    return report(project, None, ["html"])


STAGES = pytest.mark.parametrize("stage", [draw, page])


@STAGES
def test_missing_case(copy: Project, stage: Stage) -> None:
    (copy.build_dir / "case4b.h5").unlink()
    with pytest.raises(InputError) as caught:
        stage(copy)
    assert caught.value.where.endswith("case4b.h5")
    assert "tedm run-case 4b" in caught.value.hint


@STAGES
def test_no_case_at_all(copy: Project, stage: Stage) -> None:
    for path in copy.build_dir.glob("case*.h5"):
        path.unlink()
    with pytest.raises(InputError) as caught:
        stage(copy)
    assert "1, 2, 4b" in caught.value.fact
    assert "tedm run-case all" in caught.value.hint


@STAGES
def test_case_of_other_sensitivities(copy: Project, stage: Stage) -> None:
    write_matrices(copy, seed=2)
    run_cases(copy, ["1"], None, silent)
    with pytest.raises(InputError) as caught:
        stage(copy)
    assert caught.value.where.endswith("case02.h5")
    assert "sensitivity.h5" in caught.value.fact
    assert "tedm run-case 2" in caught.value.hint


@STAGES
def test_case_of_another_configuration(copy: Project, stage: Stage) -> None:
    copy.cases.write_text(copy.cases.read_text(encoding="utf-8").replace("= 2.0", "= 3.0"), encoding="utf-8")
    with pytest.raises(InputError) as caught:
        stage(copy)
    assert caught.value.where.endswith("case01.h5")
    assert "cases.toml" in caught.value.fact


@STAGES
def test_case_under_the_name_of_another(copy: Project, stage: Stage) -> None:
    (copy.build_dir / "case02.h5").write_bytes((copy.build_dir / "case01.h5").read_bytes())
    with pytest.raises(InputError, match="holds case 1, not 2"):
        stage(copy)


def test_missing_figure(copy: Project) -> None:
    (copy.build_dir / "figures" / "case02.svg").unlink()
    with pytest.raises(InputError) as caught:
        page(copy)
    assert caught.value.where.endswith("case02.svg")
    assert "tedm plot" in caught.value.hint


def test_figures_of_earlier_results(copy: Project) -> None:
    write_matrices(copy, seed=2)
    run_cases(copy, ["1", "2", "4b"], None, silent)
    close_loop(copy)
    with pytest.raises(InputError) as caught:
        page(copy)
    assert caught.value.where.endswith(".svg")
    assert "tedm plot" in caught.value.hint


def test_distortion_of_other_unit_loads(copy: Project, finished: Project, tmp_path: Path) -> None:
    kept = (copy.build_dir / "distortion.h5").read_bytes()
    write_matrices(copy, seed=2)
    (copy.build_dir / "distortion.h5").write_bytes(kept)
    for name in ("sensitivity.h5", "optics.h5"):
        (copy.build_dir / name).write_bytes((finished.build_dir / name).read_bytes())
    with pytest.raises(InputError) as caught:
        page(copy)
    assert caught.value.where.endswith("distortion.h5")
    assert "tedm build-distortion" in caught.value.hint


def test_a_refusal_leaves_the_report_that_was_there(copy: Project) -> None:
    before = report(copy, None)[0].read_bytes()
    (copy.build_dir / "case02.h5").unlink()
    with pytest.raises(InputError):
        page(copy)
    assert (copy.build_dir / "report.html").read_bytes() == before


@pytest.mark.parametrize(
    ("added", "fact"),
    [
        ('<image href="https://example.org/logo.png" width="9" height="9"/>', "'https://example.org/logo.png'"),
        ('<image xmlns:x="http://www.w3.org/1999/xlink" x:href="file:///etc/hosts"/>', "'file:///etc/hosts'"),
        ('<image href="logo.png" width="9" height="9"/>', "'logo.png'"),
        ('<rect style="fill: url(https://example.org/a#b)"/>', "url(https://example.org"),
        ("<style>@import 'x.css'</style>", "@import"),
        ("<script>alert(1)</script>", "holds a script"),
        ('<rect onclick="alert(1)"/>', "holds a script (onclick)"),
        ("<rect", "is no SVG figure"),
    ],
)
def test_a_figure_that_asks_for_what_is_outside_of_it(copy: Project, added: str, fact: str) -> None:
    """A logo pasted in with an editor: the page would ask for it whenever it is read, and no PDF can be set with it."""
    path = copy.build_dir / "figures" / "case02.svg"
    text = path.read_text(encoding="utf-8")
    path.write_text(text.replace("</svg>", f"{added}</svg>"), encoding="utf-8")
    with pytest.raises(InputError) as caught:
        page(copy)
    assert caught.value.where == str(path)
    assert fact in caught.value.fact
    assert "tedm plot" in caught.value.hint


def test_what_the_typesetter_refuses_is_one_error() -> None:
    svg = '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 9 9"><image href="https://example.org/a.png"/></svg>'
    document = Document("t", "s", "1", (Section("a", "A", "A", (Figure("f1", "caption", svg, "a.svg"),)),))
    with pytest.raises(InputError, match=r"the PDF cannot be set: .*example\.org"):
        to_pdf(document, font_folder())


def touched(path: Path) -> None:
    path.write_text(path.read_text(encoding="utf-8") + "# changed\n", encoding="utf-8")


@STAGES
def test_a_loop_of_other_sensitivities(copy: Project, stage: Stage) -> None:
    write_matrices(copy, seed=2)
    run_cases(copy, ["1", "2", "4b"], None, silent)
    with pytest.raises(InputError) as caught:
        stage(copy)
    assert caught.value.where.endswith("dynamics.h5")
    assert "sensitivity.h5 as it is now" in caught.value.fact
    assert "tedm build-dynamics" in caught.value.hint


@STAGES
def test_a_loop_of_another_configuration(copy: Project, stage: Stage) -> None:
    """The project names a dynamics file, or another, or none any more, since the loop was closed."""
    file = copy.build_dir.parent / "dynamics.toml"
    file.write_text("[read_out]\nset = 'A'\n", encoding="utf-8")
    named = dataclasses.replace(copy, dynamics=file)
    with pytest.raises(InputError, match=r"dynamics\.toml as it is now") as caught:
        stage(named)
    assert "tedm build-dynamics" in caught.value.hint
    build_dynamics(named, None)
    simulate(named, ["1", "2", "4b"], None, silent)
    with pytest.raises(InputError, match="no longer names") as caught:
        stage(copy)
    assert caught.value.where.endswith("dynamics.h5")
    assert "tedm build-dynamics" in caught.value.hint


@STAGES
def test_a_simulation_in_another_loop(copy: Project, stage: Stage) -> None:
    """The same loop built by another command line is another file."""
    with mock.patch("sys.argv", ["tedm", "build-dynamics", "--anew"]):
        build_dynamics(copy, None)
    simulate(copy, ["1"], None, silent)
    with pytest.raises(InputError, match=r"dynamics\.h5 as it is now") as caught:
        stage(copy)
    assert caught.value.where.endswith("simulation02.h5")
    assert "tedm simulate 2`" in caught.value.hint


@STAGES
def test_a_simulation_of_another_cases_file(copy: Project, stage: Stage) -> None:
    touched(copy.cases)
    run_cases(copy, ["1", "2", "4b"], None, silent)
    with pytest.raises(InputError, match=r"cases\.toml as it is now") as caught:
        stage(copy)
    assert caught.value.where.endswith("simulation01.h5")
    assert "tedm simulate 1`, or all cases with `tedm simulate all`" in caught.value.hint


def test_a_loop_that_is_not_closed_is_no_fault(copy: Project) -> None:
    """Without dynamics.h5, simulations of any age are not looked at."""
    (copy.build_dir / "dynamics.h5").unlink()
    with open_results(copy) as results:
        assert not results.no_loop
        assert results.dynamics is None
        assert results.simulations == []


def test_cases_that_have_not_been_simulated_are_not_there(copy: Project) -> None:
    (copy.build_dir / "simulation02.h5").unlink()
    with open_results(copy) as results:
        assert [read_simulation(file).id for file in results.simulations] == ["1", "4b"]
