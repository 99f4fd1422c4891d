"""The report as a reader and a browser meet it."""

from __future__ import annotations

import re
from collections.abc import Callable
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest
from report_project import AREAS, CASES

from tedm_cli.config.project import Project
from tedm_cli.contracts import CASE, SENSITIVITY
from tedm_cli.figures.data import ratio_text
from tedm_cli.progress import silent
from tedm_cli.provenance import sha256_of
from tedm_cli.stages.plot import plot
from tedm_cli.stages.report import report
from tedm_cli.store import open_checked

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
        if (self.open and self.open[-1] in ("td", "th")) or "th" in self.open[-3:]:
            self.rows[-1][-1] += data


@pytest.fixture(scope="module")
def source(finished: Project, tmp_path_factory: pytest.TempPathFactory) -> str:
    path = report(finished, tmp_path_factory.mktemp("page") / "page.html")
    return path.read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def page(source: str) -> Page:
    return Page(source)


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
    first = report(copy, None).read_bytes()
    names = sorted(p.name for p in (copy.build_dir / "figures").iterdir())
    figures = [(copy.build_dir / "figures" / n).read_bytes() for n in names]
    plot(copy, None, silent)
    assert [(copy.build_dir / "figures" / n).read_bytes() for n in names] == figures
    assert report(copy, None).read_bytes() == first


def test_a_copy_in_another_folder_gives_the_same_report(copy: Project, source: str) -> None:
    assert report(copy, None).read_text(encoding="utf-8") == source


def test_page_needs_nothing_but_itself(source: str, page: Page) -> None:
    assert page.references, "the figures refer to their own parts"
    assert [r for r in page.references if not r.startswith(("#", "data:image/png;base64,"))] == []
    assert not page.tags & {"script", "link", "img", "iframe", "object", "embed"}
    addresses = set(re.findall(r"https?://[^\s\"'<>)]*", source))
    assert addresses <= {"http://www.w3.org/2000/svg", "http://www.w3.org/1999/xlink"}


def test_ids_are_unique_and_every_reference_finds_one(page: Page) -> None:
    assert len(page.ids) == len(set(page.ids))
    assert {r[1:] for r in page.references if r.startswith("#")} <= set(page.ids)
    assert page.open == []


def test_every_verdict_is_a_row(finished: Project, page: Page) -> None:
    section = [i for i, row in enumerate(page.rows) if row and row[0].startswith("Case ")]
    for number, (case_id, name) in enumerate(CASE_FILES.items()):
        start = section[number]
        assert page.rows[start][0].startswith(f"Case {case_id} ")
        expected = verdicts(finished, name)
        assert {passed for *_, passed in expected} <= {True, False}
        for row, (output, requirement, ratio, at, passed) in zip(page.rows[start + 1 :], expected, strict=False):
            shown = [output, "pass" if passed else "FAIL", ratio_text(ratio), f"{at * 1e3:.3g}", requirement]
            assert row[:5] == shown


def test_first_sentence_of_a_requirement_counts_its_cases(finished: Project, page: Page) -> None:
    text = re.sub(r"\s+", " ", page.text)
    seen = set()
    for requirement in ("lpf_selfgravity_ltp", "lpf_readout_item"):
        by_case = [[v for v in verdicts(finished, n) if v[1] == requirement] for n in CASE_FILES.values()]
        met = sum(all(v[4] for v in case) for case in by_case)
        worst = max((v for case in by_case for v in case), key=lambda v: v[2])
        sentence = text[text.index(f": {requirement} (") :][:500]
        assert f"is met in {met} of 3 cases" in sentence
        assert f"{worst[0]} reaches {ratio_text(worst[2])} times the limit at {worst[3] * 1e3:.3g} mHz" in sentence
        assert "safety factor of 2" in sentence
        assert "assumed temperature filter" in sentence
        seen.add(met == 3)
    assert seen == {True, False}, "the made-up matrices must show both outcomes"


def test_filter_range_is_that_of_the_file(finished: Project, page: Page) -> None:
    with open_checked(finished.build_dir / "case02.h5", CASE) as file:
        ratio = file.array("/filter_sensitivity/ratio")
    start = next(i for i, row in enumerate(page.rows) if row and row[0].startswith("Case 2 "))
    for row, values in zip(page.rows[start + 1 :], ratio, strict=False):
        ends = row[5].split(" to ")
        assert (ends[0], ends[-1]) == (ratio_text(values.min()), ratio_text(values.max()))


def test_field_at_rest_is_summed_over_sources(finished: Project, page: Page) -> None:
    with open_checked(finished.build_dir / "sensitivity.h5", SENSITIVITY) as file:
        total = file.array("/dc/acceleration").sum(axis=1)
    sums = [row for row in page.rows if len(row) == 9 and row[1] == "sum"]
    digits = str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹−", "-0123456789-")
    shown = [[float(c.translate(digits).replace(" × 10", "e")) for c in row[2:5]] for row in sums]
    np.testing.assert_allclose(shown, total, rtol=1e-3)


def test_names_of_the_user_come_out_as_text(source: str, page: Page) -> None:
    assert "b" not in page.tags
    for name in (*AREAS["/area/name"], "All correlated: 5 < 7 & $x$", "Made up & <small>"):  # type: ignore[misc]
        assert str(name) in page.text
    assert CASES in page.text
    assert "# model of <nothing> & all" in page.text


def test_provenance_names_every_file_with_its_hash(finished: Project, page: Page) -> None:
    pairs = {tuple(row) for row in page.rows if len(row) == 2}
    for path in finished.build_dir.glob("*.h5"):
        assert (path.name, sha256_of(path)) in pairs
        assert path.name.startswith("case") or (path.name, "tedm made up") in pairs


def test_project_without_requirements(with_cases: Callable[[str], Project]) -> None:
    kept = re.sub(r"\[\[requirement\]\]\nname.*\noutputs.*\n", "", ONE_CASE)
    project = with_cases(kept)
    plot(project, None, silent)
    text = report(project, None).read_text(encoding="utf-8")
    assert "nothing is judged" in text


def test_white_temperature_has_no_filter_to_vary(with_cases: Callable[[str], Project]) -> None:
    project = with_cases(ONE_CASE.replace('preset = "thesis"', 'preset = "white"'))
    plot(project, None, silent)
    text = Page(report(project, None).read_text(encoding="utf-8")).text
    assert "no low-pass" in text
    assert "assumed temperature filter" not in text
    assert "range over filter" not in text


def test_report_goes_where_it_is_told(finished: Project, tmp_path: Path) -> None:
    assert report(finished, tmp_path / "deep" / "r.html") == tmp_path / "deep" / "r.html"
    assert not (finished.build_dir / "report.html").exists()
