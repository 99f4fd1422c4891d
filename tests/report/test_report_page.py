"""The report as a reader and a browser meet it."""

from __future__ import annotations

import re
from collections.abc import Callable
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest
from report_project import AREAS, CASES, make_project, sketch

from tedm_cli.config.project import Project
from tedm_cli.contracts import CASE, SENSITIVITY
from tedm_cli.files.seal import sha256_of
from tedm_cli.files.store import open_checked
from tedm_cli.progress import silent
from tedm_cli.results.titles import at_rest_title, by_subsystem, output_title, requirement_title
from tedm_cli.results.wording import capital, clause, ratio_text
from tedm_cli.stages.reporting.plot import plot
from tedm_cli.stages.reporting.report import report

VOID = {"meta", "br", "link", "img", "input", "hr"}
ONE_CASE = CASES[: CASES.index("[[case]]", CASES.index("[[case]]") + 1)]
CASE_FILES = {"1": "case01.h5", "2": "case02.h5", "4b": "case4b.h5"}


class Page(HTMLParser):
    """Elements, ids, references, texts of table rows, and elements left open."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.tags: set[str] = set()
        self.ids: list[str] = []
        self.references: list[str] = []
        self.rows: list[list[str]] = []
        self.open: list[str] = []
        self.text = ""
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.add(tag)
        for name, value in attrs:
            if name == "id":
                self.ids.append(value or "")
            if name in ("src", "href", "xlink:href", "srcset", "action", "data", "poster"):
                self.references.append(value or "")
            self.references += re.findall(r"url\(['\"]?([^)'\"]*)", value or "")
        if tag == "tr":
            self.rows.append([])
        if tag in ("td", "th"):
            self.rows[-1].append("")
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.handle_starttag(tag, attrs)
        self.handle_endtag(tag)

    def handle_endtag(self, tag: str) -> None:
        if tag not in VOID:
            assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        self.text += data
        if "style" in self.open:
            self.references += re.findall(r"(?:url\(|@import)\s*['\"]?([^)'\"\s]*)", data)
        if {"td", "th"} & set(self.open[-3:]):
            self.rows[-1][-1] += data


@pytest.fixture(scope="module")
def sources(finished: Project, tmp_path_factory: pytest.TempPathFactory) -> list[str]:
    """The report and its annex."""
    paths = report(finished, tmp_path_factory.mktemp("page") / "page.html")
    assert [path.name for path in paths] == ["page.html", "page_annex.html"]
    return [path.read_text(encoding="utf-8") for path in paths]


@pytest.fixture(scope="module")
def first(sources: list[str]) -> Page:
    return Page(sources[0])


@pytest.fixture(scope="module")
def page(sources: list[str]) -> Page:
    """The annex, which holds every number."""
    return Page(sources[1])


def verdicts(project: Project, name: str) -> list[tuple[str, str, float, float, bool]]:
    with open_checked(project.build_dir / name, CASE) as file:
        return list(
            zip(
                file.strings("/verdict/output"),
                file.strings("/verdict/requirement"),
                (float(v) for v in file.array("/verdict/ratio")),
                (float(v) for v in file.array("/verdict/binding_frequency")),
                (bool(v) for v in file.array("/verdict/passed")),
                strict=True,
            )
        )


def test_same_inputs_give_the_same_bytes(copy: Project) -> None:
    """Also where the copy lies in another folder, and where figures and report are made anew."""
    before = [path.read_bytes() for path in report(copy, None)]
    names = sorted(p.name for p in (copy.build_dir / "figures").iterdir())
    figures = [(copy.build_dir / "figures" / n).read_bytes() for n in names]
    plot(copy, None, silent)
    assert [(copy.build_dir / "figures" / n).read_bytes() for n in names] == figures
    assert [path.read_bytes() for path in report(copy, None)] == before


def test_a_copy_in_another_folder_gives_the_same_report(copy: Project, sources: list[str]) -> None:
    written = [path.read_text(encoding="utf-8") for path in report(copy, None, ["html"])]
    assert [text.replace("report_annex.html", "page_annex.html").replace("report.html", "page.html") for text in written
            ] == sources  # fmt: skip


def test_pages_need_nothing_but_themselves_and_lead_to_each_other(sources: list[str], first: Page, page: Page) -> None:
    for source, one, other in ((sources[0], first, "page_annex.html"), (sources[1], page, "page.html")):
        assert one.references, "the figures refer to their own parts"
        away = {r for r in one.references if not r.startswith(("#", "data:image/png;base64,"))}
        assert {r.partition("#")[0] for r in away} == {other}
        assert not one.tags & {"script", "link", "img", "iframe", "object", "embed"}
        addresses = set(re.findall(r"https?://[^\s\"'<>)]*", source))
        assert addresses <= {"http://www.w3.org/2000/svg", "http://www.w3.org/1999/xlink"}


def test_ids_are_unique_and_every_reference_finds_one(first: Page, page: Page) -> None:
    for one, other in ((first, page), (page, first)):
        assert len(one.ids) == len(set(one.ids))
        assert {r[1:] for r in one.references if r.startswith("#")} <= set(one.ids)
        away = {r.partition("#")[2] for r in one.references if r.startswith("page") and "#" in r}
        assert away
        assert away <= set(other.ids)
        assert one.open == []


def row_of(page: Page, case_id: str, label: str) -> list[str]:
    """The row of an output in the table of every verdict; outputs that say the same share one."""
    head = next(i for i, row in enumerate(page.rows) if row[:2] == ["Output", "Verdict"])
    start = next(i for i, row in enumerate(page.rows) if i > head and row[0].startswith(f"Case {case_id} "))
    return next(row for row in page.rows[start + 1 :] if re.search(rf"(?<!\w){label}(?!\w)", row[0]))


def test_every_verdict_is_a_row_with_its_plain_title(finished: Project, page: Page) -> None:
    seen = set()
    for case_id, name in CASE_FILES.items():
        for output, requirement, ratio, at, passed in verdicts(finished, name):
            row = row_of(page, case_id, output)
            assert row[0].startswith(capital(output_title(output)))
            shown = [
                "pass" if passed else "FAIL",
                ratio_text(ratio),
                f"{at * 1e3:.3g}",
                requirement_title(requirement, {}),
            ]
            assert row[1:5] == shown
            seen.add(passed)
    assert seen == {True, False}


def test_first_sentence_of_a_requirement_counts_its_cases(finished: Project, page: Page) -> None:
    text = re.sub(r"\s+", " ", page.text)
    seen = set()
    for requirement in ("lpf_selfgravity_ltp", "lpf_readout_item"):
        by_case = [[v for v in verdicts(finished, n) if v[1] == requirement] for n in CASE_FILES.values()]
        met = sum(all(v[4] for v in case) for case in by_case)
        worst = max((v for case in by_case for v in case), key=lambda v: v[2])
        sentence = text[text.index(f": {requirement_title(requirement, {})} {requirement} for ") :][:500]
        said = "met in all 3 cases that can occur" if met == 3 else f"violated in {3 - met} of 3 cases"
        assert f"is {said}" in sentence
        assert f"the {clause(output_title(worst[0]))} reaches {ratio_text(worst[2])} times the limit" in sentence
        assert f"at {worst[3] * 1e3:.3g} mHz" in sentence
        assert "safety factor of 2" in sentence
        seen.add(met == 3)
    assert seen == {True, False}, "the made-up matrices must show both outcomes"


def test_filter_range_is_that_of_the_file(finished: Project, page: Page) -> None:
    with open_checked(finished.build_dir / "case02.h5", CASE) as file:
        ratio, outputs = file.array("/filter_sensitivity/ratio"), file.strings("/verdict/output")
    for output, values in zip(outputs, ratio, strict=True):
        ends = row_of(page, "2", output)[5].split(" to ")
        assert (ends[0], ends[-1]) == (ratio_text(values.min()), ratio_text(values.max()))


def number(text: str) -> float:
    """A number of the page."""
    return float(text.translate(str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹−", "-0123456789-")).replace(" × 10", "e"))


def test_field_at_rest_is_summed_over_sources(finished: Project, page: Page) -> None:
    with open_checked(finished.build_dir / "sensitivity.h5", SENSITIVITY) as file:
        by_source = np.concatenate([file.array("/dc/acceleration"), file.array("/dc/angular_acceleration")], axis=2)
        points, error = file.array("/source/points"), file.array("/source/quadrature_error")
    whole = by_source.sum(axis=1)
    for t, name in enumerate(("TM1", "TM2")):
        start = next(i for i, row in enumerate(page.rows) if row[:2] == [name, "structure"])
        rows = page.rows[start : start + 4]
        assert [row[1] for row in rows] == ["structure", "other test mass", "compensation masses", "sum"]
        for row, values in zip(rows, [*by_source[t], whole[t]], strict=True):
            assert row[3] == "0", "y is rounding"
            np.testing.assert_allclose(
                [number(c) for c in row[2:8]], np.where([0, 1, 0, 0, 0, 0], 0, values), rtol=1e-3
            )
        assert [int(row[8].replace(",", "")) for row in rows[:3]] == list(points[t])
        np.testing.assert_allclose([number(row[9]) for row in rows[:3]], error[t], rtol=0.06)


def test_what_compensation_masses_follow_is_told(sources: list[str]) -> None:
    said = "2 follow the structure (name_0: tie_0; name_1: tie_1) and are in S_SG."
    assert sum(said in text for text in sources) == 1


def test_every_verdict_at_rest_is_a_row(finished: Project, sources: list[str], page: Page) -> None:
    with open_checked(finished.build_dir / "sensitivity.h5", SENSITIVITY) as file:
        names = [file.strings(f"/dc_verdict/{c}") for c in ("test_mass", "quantity", "subsystem", "minus")]
        value, ratio, passed = (file.array(f"/dc_verdict/{c}") for c in ("value", "ratio", "passed"))
    rows = [row for row in page.rows if len(row) == 6 and row[1] in ("IS", "LTP", "IS+LTP", "all")]
    assert len(rows) == len(value) == 30
    assert 0 < passed.sum() < 30, "the made-up field must show both outcomes"
    assert sources[1].count('<tr class="failed">') == 30 - passed.sum()
    for row, quantity, subsystem, v, r, p in zip(rows, *names[1:3], value, ratio, passed, strict=True):
        assert row[0].startswith(quantity.replace("gamma", "Γ").replace("omegadot", "ω̇") + " (")
        assert (row[1], row[2]) == (subsystem, "pass" if p else "FAIL")
        if quantity == "a_y":
            assert (row[4], row[3]) == ("0", "< 10⁻⁹")
        else:
            assert number(row[4]) == pytest.approx(v, rel=1e-3)
            assert row[3] == ratio_text(r)
    assert [row[5] for row in rows[:3]] == ["(−1 to 2) × 10⁻⁷", "(−2 to 3) × 10⁻⁷", "(−3 to 5) × 10⁻⁷"]
    assert [row[5] for row in rows[6:10]] == ["±3.5 × 10⁻¹⁰", "±4 × 10⁻¹⁰", "±7.5 × 10⁻¹⁰", "±1.3 × 10⁻⁹"]
    worst = int(np.argmax(ratio))
    sentence = re.sub(r"\s+", " ", page.text)
    sentence = sentence[sentence.index("field at rest exceeds its limits") :][:400]
    whole = [bool(p) for s, p in zip(names[2], passed, strict=True) if s in ("IS+LTP", "all")]
    assert f"exceeds its limits in {30 - passed.sum()} of 30 quantities ({14 - sum(whole)} of 14 for" in sentence
    place = "-".join(filter(None, (names[0][worst], names[3][worst])))
    title = at_rest_title(names[1][worst], place)
    assert f"the worst is the {title} by {by_subsystem(names[2][worst])}," in sentence
    assert "TM2 − TM1" in page.text
    assert f"which is {ratio_text(ratio[worst])} times its limit" in sentence


def test_the_symmetry_plane_is_told_with_where_it_is_from(first: Page, page: Page) -> None:
    words = "y = 0.125 m in the basic frame ([areas] symmetry_plane)"
    assert ["Symmetry plane of sides and mirror pairs", words] in first.rows
    assert words in page.text


def test_equations_of_motion_are_a_table(finished: Project, page: Page) -> None:
    with open_checked(finished.build_dir / "sensitivity.h5", SENSITIVITY) as file:
        k, outputs = file.array("/stiffness/linearised"), file.strings("/label/tm_output")
    rows = [row for row in page.rows if len(row) == 13]
    assert [row[0] for row in rows] == ["", *(f"{n} ({'m' if '_a_' in n else 'rad'}/s²)" for n in outputs)]
    assert rows[0][1] == "TM1_x(m)"
    np.testing.assert_allclose([[number(c) for c in row[1:]] for row in rows[1:]], k, rtol=6e-3)


def test_weak_coupling_of_test_masses_is_not_rounding(tmp_path: Path) -> None:
    """Torques by the other test mass are far below those by the structure: each block is compared with itself."""
    k = np.ones((12, 12))
    k[3:6, 9:12] = 1e-12 * np.array([[1.0, 1e-10, 1.0], [1.0, 1.0, 1.0], [1.0, 1.0, 0.0]])
    project = make_project(tmp_path, ONE_CASE, {"/stiffness/linearised": k})
    sketch(project)
    page = Page(report(project, None, ["html"])[1].read_text(encoding="utf-8"))
    assert [row[10:13] for row in page.rows if len(row) == 13][4:7] == [
        ["1.00 × 10⁻¹²", "0", "1.00 × 10⁻¹²"],
        ["1.00 × 10⁻¹²"] * 3,
        ["1.00 × 10⁻¹²", "1.00 × 10⁻¹²", "0"],
    ]


def test_lumped_masses_have_no_error_estimate(tmp_path: Path) -> None:
    error = np.array([[np.nan, 1e-14, 1e-10]] * 2)
    project = make_project(tmp_path, ONE_CASE, {"/source/mass_model": "lumped", "/source/quadrature_error": error})
    sketch(project)
    page = Page(report(project, None, ["html"])[1].read_text(encoding="utf-8"))
    assert "Mass model of the structure: lumped" in page.text
    rows = [row for row in page.rows if row[1:2] == ["structure"]]
    assert [row[9] for row in rows] == ["no estimate"] * 2


def test_names_of_the_user_come_out_as_text(first: Page, page: Page) -> None:
    assert "b" not in page.tags | first.tags
    assert "Made up & <small>" in first.text
    for name in (*AREAS["/area/name"], "All correlated: 5 < 7 & $x$", "Made up & <small>"):  # type: ignore[misc]
        assert str(name) in page.text
    assert CASES in page.text
    assert "# model of <nothing> & all" in page.text


def test_provenance_names_every_file_with_its_hash(finished: Project, page: Page) -> None:
    pairs = {tuple(row) for row in page.rows if len(row) == 2}
    for path in finished.build_dir.glob("*.h5"):
        assert (path.name, sha256_of(path)) in pairs
        assert path.name.startswith(("case", "dynamics", "simulation")) or (path.name, "tedm made up") in pairs


def test_project_without_requirements(with_cases: Callable[[str], Project]) -> None:
    kept = re.sub(r"\[\[requirement\]\]\nname.*\noutputs.*\n", "", ONE_CASE)
    project = with_cases(kept)
    sketch(project)
    text = report(project, None, ["html"])[0].read_text(encoding="utf-8")
    assert "no requirement on noise: nothing is judged" in text


def test_white_temperature_has_no_filter_to_vary(with_cases: Callable[[str], Project]) -> None:
    project = with_cases(ONE_CASE.replace('preset = "thesis"', 'preset = "white"'))
    sketch(project)
    text = " ".join(Page(path.read_text(encoding="utf-8")).text for path in report(project, None, ["html"]))
    assert "no low-pass" in text
    assert "low-pass temperature filter are assumed" not in text
    assert "range over filter" not in text


def test_report_goes_where_it_is_told(finished: Project, tmp_path: Path) -> None:
    folder = tmp_path / "deep"
    assert report(finished, folder / "r.html") == [folder / "r.html", folder / "r_annex.html"]
    assert not (finished.build_dir / "report.html").exists()
