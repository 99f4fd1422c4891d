"""The optics section of the report, and refusals of results that do not belong to the bench."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from report_project import ODD, write_matrices

from tedm_cli.config.project import Project
from tedm_cli.contracts import OPTICS
from tedm_cli.errors import InputError
from tedm_cli.figures.drawing.spec import FigureSpec
from tedm_cli.files.store import open_checked
from tedm_cli.progress import silent
from tedm_cli.results.build_folder import open_results
from tedm_cli.results.optics import read_read_outs
from tedm_cli.results.titles import output_title
from tedm_cli.results.wording import capital, sci
from tedm_cli.stages.noise.case import run_cases
from tedm_cli.stages.reporting.plot import plot
from tedm_cli.stages.reporting.plot_optics import optics_specs
from tedm_cli.stages.reporting.report import report


@pytest.fixture(scope="module")
def section(finished: Project, tmp_path_factory: pytest.TempPathFactory) -> str:
    text = report(finished, tmp_path_factory.mktemp("optics") / "page.html")[1].read_text(encoding="utf-8")
    start = text.index('<section id="optics">')
    return text[start : text.index("</section>", start)]


def specs_of(project: Project) -> list[FigureSpec]:
    with open_results(project) as results:
        return optics_specs(results)


def test_every_figure_of_the_optics_is_in_its_section(finished: Project, section: str) -> None:
    captions = [re.sub("<[^>]*>", "", c) for c in re.findall(r"<figcaption>(.*?)</figcaption>", section, re.DOTALL)]
    specs = specs_of(finished)
    assert len(captions) == len(specs) == section.count("<svg")
    for caption, spec in zip(captions, specs, strict=True):
        assert (
            re.sub(r"^Figure A\d+\. ", "", caption)[:60]
            == spec.caption.replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;")[:60]
        )
    loads = sum(s.section == "load" for s in specs)
    assert loads >= 2, "the made-up motions must have several worst areas"
    assert section.count("<details>") == loads - 1, "the first is seen at once"


def test_what_is_odd_in_the_layout_is_told(finished: Project, tmp_path: Path) -> None:
    """On the first page, among the assumptions, and in the annex, which names the element with the longest lever."""
    page, annex = (path.read_text(encoding="utf-8") for path in report(finished, tmp_path / "page.md"))
    decision, _, rest = page.partition("## Assumptions")
    assert "1 thing to look at in the optical layout, listed under Assumptions." in decision
    assert f"To look at: {ODD}" in rest
    assert ODD in annex
    with open_checked(finished.build_dir / "optics.h5", OPTICS) as file:
        lever = np.linalg.norm(file.array(OPTICS.REFERENCE_POINT_OFFSET), axis=1)
        farthest = file.strings(OPTICS.OPTICAL_NAME)[int(lever.argmax())]
    assert f"from their finite-element grids ({farthest})" in annex.replace("\\_", "_")


def test_worst_areas_are_those_of_n(finished: Project, section: str) -> None:
    with open_checked(finished.build_dir / "optics.h5", OPTICS) as file:
        noise, areas = {s: file.array(f"/N/{s}") for s in ("A", "B")}, file.strings("/area/name")
        read_outs = file.strings("/label/read_out")
    start = section.index("Worst area of each read-out")
    body = section[start : section.index("</table>", start)]
    rows = [re.findall(r"<td[^>]*>(.*?)</td>", row) for row in re.findall(r"<tr>(.*?)</tr>", body)]
    rows = [row for row in rows if len(row) == 6]
    labels = [f"{s}_{r}" for s in noise for r in read_outs]
    named = [f'{capital(output_title(label))} <span class="label">{label}</span>' for label in labels]
    assert [row[0] for row in rows] == named

    def number(text: str) -> float:
        return float(text.translate(str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹−", "-0123456789-")).replace(" × 10", "e"))

    for row, values in zip(rows, np.concatenate(list(noise.values())), strict=True):
        worst = int(np.abs(values).argmax())
        assert row[1] == areas[worst].replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;")
        shown = [number(cell) for cell in row[2:5]]
        np.testing.assert_allclose(shown, [values[worst], values.sum(), np.linalg.norm(values)], rtol=6e-3)


def test_each_read_out_is_named_under_its_worst_area(finished: Project) -> None:
    captions = " ".join(s.caption for s in specs_of(finished) if s.section == "load")
    named = re.findall(r"read-out of (x|η|φ), test mass(?:es)? (1 and 2|1|2), set A", captions)
    found = [(dof, mass) for dof, masses in named for mass in masses.split(" and ")]
    assert sorted(found) == [(dof, mass) for dof in "xηφ" for mass in "12"]


def test_figures_of_another_bench_are_refused(copy: Project) -> None:
    text = copy.required_optics().read_text(encoding="utf-8")
    copy.required_optics().write_text(
        text.replace("wavelength_m = 1.064e-6", "wavelength_m = 1.55e-6"), encoding="utf-8"
    )
    for stage in (lambda: plot(copy, None, silent), lambda: report(copy, None)):
        with pytest.raises(InputError, match=r"stale: not made from .*optics\.toml as it is now") as caught:
            stage()
        assert caught.value.where.endswith(("sensitivity.h5", "optics.h5"))
        assert "tedm build-optics" in caught.value.hint


def test_motions_that_the_optics_were_not_made_of_are_refused(copy: Project, tmp_path: Path) -> None:
    """Sensitivities and optics agree with each other, but the distortion has been made anew since."""
    files = {name: (copy.build_dir / name).read_bytes() for name in ("sensitivity.h5", "optics.h5", "unit_loads.h5")}
    write_matrices(copy, seed=2)
    for name, data in files.items():
        (copy.build_dir / name).write_bytes(data)
    run_cases(copy, ["1", "2", "4b"], None, silent)
    with pytest.raises(InputError, match=r"stale: made from another version of .*distortion\.h5") as caught:
        plot(copy, None, silent)
    assert caught.value.where.endswith(("sensitivity.h5", "optics.h5"))


def test_parts_of_read_outs_have_their_table_where_plates_warm_up(finished: Project, section: str) -> None:
    with open_checked(finished.build_dir / "optics.h5", OPTICS) as file:
        size = np.linalg.norm(read_read_outs(file).N_plates("A"), axis=1)
    start = section.index("the glass of the plates W1 and BS3")
    body = section[start : section.index("</table>", start)]
    rows = [re.findall(r"<td[^>]*>(.*?)</td>", row) for row in re.findall(r"<tr>(.*?)</tr>", body)]
    rows = [row for row in rows if len(row) == 6]
    assert len(rows) == 12
    assert [row[3] for row in rows[:6]] == [sci(float(s), 3) if s > 0.0 else "0" for s in size]
