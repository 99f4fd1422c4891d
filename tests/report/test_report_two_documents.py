"""Report and annex: nothing is lost between them, numbers and references hold, and the first page decides."""

from __future__ import annotations

import html
import re
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pypdf import PdfReader
from report_project import close_loop, sketch

from tedm_cli.config.project import Project, load_project
from tedm_cli.contracts import CASE, SENSITIVITY
from tedm_cli.errors import ConfigError
from tedm_cli.files.store import open_checked
from tedm_cli.gravity.requirements import DcVerdict
from tedm_cli.progress import silent
from tedm_cli.report.document import (
    Block,
    Columns,
    Document,
    Folded,
    Heading,
    Link,
    Paragraph,
    Ref,
    Section,
    Table,
    columns,
    plain,
    row,
)
from tedm_cli.report.numbering import numbered
from tedm_cli.report.remedy import remedy_section
from tedm_cli.report.verdicts import noise_judgements, worst_first
from tedm_cli.results.build_folder import open_results
from tedm_cli.results.cases.deciding import deciding
from tedm_cli.results.cases.file import read_case
from tedm_cli.results.cases.noise import WAYS, CaseNoise
from tedm_cli.results.dynamics.loop import ClosedLoop, read_closed_loop
from tedm_cli.results.titles import output_title
from tedm_cli.results.wording import and_text, capital, clause, ratio_text, rounded_down
from tedm_cli.stages.noise.case import run_cases
from tedm_cli.stages.reporting.plot import figure_specs
from tedm_cli.stages.reporting.report import report

MADE_UP = ("case01.h5", "case02.h5", "case4b.h5")


@pytest.fixture(scope="module")
def written(finished: Project, tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    folder = tmp_path_factory.mktemp("two")
    paths = [p for fmt in ("html", "md") for p in report(finished, folder / f"r.{fmt}")]
    return {path.name: path.read_text(encoding="utf-8") for path in paths}


def words(page: str) -> str:
    """What a reader sees of a page, figures and labels aside."""
    body = page[page.index("<body>") :]
    for pattern in (r"<svg.*?</svg>", r'<span class="label">.*?</span>', r"<pre>.*?</pre>"):
        body = re.sub(pattern, " ", body, flags=re.DOTALL)
    return re.sub(r"\s+", " ", html.unescape(re.sub(r"<[^>]*>", " ", body)))


def test_every_figure_is_in_one_of_the_two(finished: Project, written: dict[str, str]) -> None:
    with open_results(finished) as results:
        names = [spec.name for spec in figure_specs(results, list(map(read_case, results.cases)))]
    shown = [re.findall(r"!\[[^\n]*\]\(\S*/([^/)]*)\)", written[name]) for name in ("r.md", "r_annex.md")]
    assert sorted(shown[0] + shown[1]) == sorted(names)
    assert {"ratios.svg", "field_at_rest.svg", "budget_delta_g_case01.svg"} <= set(shown[0])
    assert len(shown[0]) < len(shown[1])


@pytest.mark.parametrize(("name", "mark"), [("r.html", ""), ("r_annex.html", "A")])
def test_figures_and_tables_are_numbered_in_order_and_have_captions(
    written: dict[str, str], name: str, mark: str
) -> None:
    for kind in ("Figure", "Table"):
        found = re.findall(rf"<strong>{kind} ({mark}\d+)\.</strong> (\S+)", written[name])
        assert [number for number, _ in found] == [f"{mark}{n}" for n in range(1, len(found) + 1)]
        assert len(found) > 4
    assert len(re.findall(r"<figure ", written[name])) == len(re.findall(r"<strong>Figure ", written[name]))


def test_every_number_that_is_referred_to_exists(written: dict[str, str]) -> None:
    have = {
        which: set(re.findall(r"<strong>((?:Figure|Table) A?\d+)\.", written[name]))
        for which, name in (("report", "r.html"), ("annex", "r_annex.html"))
    }
    seen = 0
    for name, own in (("r.html", "report"), ("r_annex.html", "annex")):
        text = words(written[name]).split("is in the annex, by section:")[0]  # that list has a test of its own
        for kind, number, other in re.findall(r"\b(table|figure) (A?\d+)\b(?!\.\d)(?: of the (annex|report))?", text):
            assert f"{capital(kind)} {number}" in have[other or own]
            seen += 1
    assert seen > 8


def test_decision_first_then_what_to_do(written: dict[str, str]) -> None:
    titles = re.findall(r"^## (.*)$", written["r.md"], re.MULTILINE)
    assert titles[:2] == ["Decision", "What to do"]
    assert re.findall(r"<h2>(.*?)</h2>", written["r.html"])[:2] == titles[:2]
    before = written["r.md"].split("## What to do")[0]
    assert "Table 1" in before
    assert "parameters that decide" in before


def test_the_first_table_has_the_numbers_of_the_files(finished: Project, written: dict[str, str]) -> None:
    """Of every judged output the worst case that can occur, with its ratio, margin, frequency and verdict."""
    table = written["r.md"].split("**Table 1.**")[1].split("**Table 2.**")[0]
    rows = [line.strip("| ").split(" | ") for line in table.splitlines() if line.startswith("| Noise by")]
    worst: dict[str, tuple[float, float, str]] = {}
    for name in MADE_UP:
        with open_checked(finished.build_dir / name, CASE) as file:
            outputs, ratios = file.strings("/verdict/output"), file.array("/verdict/ratio")
            for output, ratio, at in zip(outputs, ratios, file.array("/verdict/binding_frequency"), strict=True):
                here = (float(ratio), float(at), file.string("/case/id"))
                worst[output] = max(worst.get(output, here), here)
    assert len(worst) == 4
    for output, (ratio, at, case_id) in worst.items():
        cells = next(r for r in rows if re.search(rf"\b{output}\b", r[1]))
        assert cells[1].startswith(capital(output_title(output))[:12])
        plain_cells = [c.replace("*", "") for c in cells]
        margin = 1.0 / float(plain_cells[5])
        assert plain_cells[3] == ("met" if ratio <= 1.0 else "VIOLATED")
        assert plain_cells[4] == ratio_text(ratio)
        assert margin == pytest.approx(ratio, rel=6e-3)
        assert plain_cells[6:] == [f"{at * 1e3:.3g} mHz", f"case {case_id}"]


def test_no_label_stands_without_its_title(finished: Project, written: dict[str, str]) -> None:
    """Labels of outputs and requirements are in small type behind a title, and nowhere in the sentences."""
    with open_checked(finished.build_dir / "case01.h5", CASE) as file:
        labels = {*file.strings("/output/label"), *file.strings("/requirement/name"), "delta_g"}
    text = words(written["r.html"])
    assert [label for label in labels if re.search(rf"(?<![\w]){re.escape(label)}(?![\w])", text)] == []
    assert 'class="label">TM1_a_x' in written["r.html"]


def test_no_percentage_is_above_the_whole(written: dict[str, str]) -> None:
    for name in ("r.html", "r_annex.html"):
        shares = [float(n) for n in re.findall(r"([\d.]+) %", words(written[name]))]
        assert shares
        assert max(shares) <= 100.0


def test_the_field_at_rest_says_how_much_must_be_taken_up(finished: Project, written: dict[str, str]) -> None:
    with open_checked(finished.build_dir / "sensitivity.h5", SENSITIVITY) as file:
        value, lower, upper = (file.array(f"/dc_verdict/{c}") for c in ("value", "lower", "upper"))
        part = file.array("/dc_verdict/whole") == 1
    beyond = np.where(value > 0.0, value - upper, value - lower)[part & ((value > upper) | (value < lower))]
    table = written["r.md"].split("the minimum to be compensated.")[1].split("**Table")[0]
    cells = [
        line.split(" | ")[4].strip("*")
        for line in table.splitlines()
        if line.startswith("| ") and "To compensate" not in line
    ]
    shown = [float(c.replace("−", "-").replace(" × 10", "e").translate(str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "-0123456789")))
             for c in cells if c != "---:"]  # fmt: skip
    np.testing.assert_allclose(sorted(shown), np.sort(beyond), rtol=6e-3)


@pytest.fixture(scope="module")
def closed(finished: Project) -> ClosedLoop:
    with open_results(finished) as results:
        found = read_closed_loop(results.dynamics, results.simulations)
    assert found is not None
    return found


def test_the_remedy_of_the_loop_meets_the_requirement_and_no_more(closed: ClosedLoop, written: dict[str, str]) -> None:
    """The budget with the factor applied touches its limit, and the report says just that."""
    several = 0
    for case in closed.cases:
        for j in (j for j in case.judged if not j.passed):
            limit = next(q for q in case.limits if q.name == j.requirement)
            factors = dict.fromkeys(j.together, j.together_factor)
            power = sum((factors.get(g, 1.0) * asd) ** 2 for g, asd in j.group_asd.items())
            assert np.nanmax(case.safety_factor * np.sqrt(power) / limit.amplitude) == pytest.approx(1.0, rel=1e-9)
            assert j.together_silenced < 1.0
            several += len(j.together) > 1
    assert several, "the made-up loop must need more than one group somewhere"
    for _, j in (deciding(pairs) for pairs in closed.pairs().values()):
        if not j.passed:
            assert f"| {and_text(j.together)} | {rounded_down(j.together_factor)} |" in written["r.md"]


def test_nothing_to_do_where_all_is_met(cases: list[CaseNoise], closed: ClosedLoop) -> None:
    dc = [DcVerdict("TM1", "a_x", "IS+LTP", 1e-10, -1e-9, 1e-9)]
    met = [
        replace(c, judged=tuple(replace(j, passed=True, ratio=0.5, filter_ratio=None) for j in c.judged)) for c in cases
    ]
    loop = replace(
        closed,
        cases=tuple(replace(c, judged=tuple(replace(j, passed=True) for j in c.judged)) for c in closed.cases),
    )
    found = remedy_section(met, dc, loop, str, [])
    assert [plain(b.text) for b in found.blocks if isinstance(b, Paragraph)] == [
        "Nothing has to be done: all judged requirements are met in every case that can occur."
    ]
    found = remedy_section(cases, dc, loop, str, [])
    assert [b.text for b in found.blocks if isinstance(b, Heading)] == ["Temperatures"]


def test_the_remedy_of_every_output_that_fails_is_told(cases: list[CaseNoise]) -> None:
    """The worst first, the next in a sentence each: with their case, how far off they are, and what is allowed."""
    worse = [replace(c, judged=tuple(replace(j, passed=False, ratio=3.0) for j in c.judged)) for c in cases]
    first, *others = worst_first(noise_judgements(worse))
    section = remedy_section(worse, [], None, str, [])
    text = next(plain(b.text) for b in section.blocks if isinstance(b, Paragraph))
    assert output_title(first.output) in text.split("For the ")[0]
    assert len(others) > 1
    for told, found in zip(text.split("For the ")[1:], others[:2], strict=True):
        case, j = found.decides
        assert told.startswith(f"{clause(output_title(found.output))} in case {case.id} (3.00 times its limit): ")
        assert f"no more than {ratio_text(j.improvement.all_factor)} of the temperature noise in all areas. " in told
        assert ("which leaves" in told) == any(j.improvement.enough(way) for way in WAYS)


def test_the_end_of_the_report_says_where_in_the_annex_what_is(written: dict[str, str]) -> None:
    """Section by section the first and the last number of its tables and figures."""
    parts = re.split(r"^## (.*)$", written["r_annex.md"], flags=re.MULTILINE)[3:]
    assert len(parts) > 16
    last = written["r.md"].split("## What the annex holds")[1]
    said = dict(re.findall(r"^- (.*): \[(.*)\]\(r_annex\.md\)$", last, flags=re.MULTILINE))
    assert list(said) == parts[::2]
    for title, body in zip(parts[::2], parts[1::2], strict=True):
        for kind in ("Table", "Figure"):
            there = re.findall(rf"^\*\*{kind} (A\d+)\.", body, flags=re.MULTILINE)
            named = re.findall(rf"{kind.lower()}s? (A\d+)(?: (?:to|and) (A\d+))?", said[title])
            assert [n for pair in named for n in pair if n] == list(dict.fromkeys([*there[:1], *there[-1:]])), title


FRONT = """
[report]
title = "Thermal <b>stability</b> of the bench"
mission = "Made-up Pathfinder"
issue = 3
date = 2031-02-28
prepared_by = "A. Reader & B. Writer"
"""


def test_the_title_block_is_the_users(copy: Project) -> None:
    """Given in [report] of the project file; nothing is taken from a clock, and what is not given is said so."""
    bare = [path.read_text(encoding="utf-8") for path in report(copy, None, ["md"])]
    for text in bare:
        assert "- Issue: not given\n- Date: not given\n- Made by: tedm " in text
    with open(copy.file.path, "a", encoding="utf-8") as file:
        file.write(FRONT)
    copy = load_project(copy.file.path, copy.build_dir)
    for fmt in ("md", "html"):
        for path in report(copy, None, [fmt]):
            text = html.unescape(path.read_text(encoding="utf-8").replace("\\", ""))
            for given_text in (*re.findall(r'= "(.*)"', FRONT), "2031-02-28"):
                assert given_text in text
            assert re.search(r"Issue(: |</dt><dd>)3\b", text)
    pdf = report(copy, None, ["pdf"])
    printed = PdfReader(pdf[0]).pages[0].extract_text()
    assert "2031-02-28" in printed
    assert "Annex to: Thermal <b>stability</b>" in PdfReader(pdf[1]).pages[0].extract_text()


@pytest.mark.parametrize(
    ("line", "fact"),
    [
        ("issue = 1.2", "report.issue: must be a valid string or must be a valid integer"),
        ("issue = 10000", "report.issue: issue 10,000 is outside 0 to 9,999"),
        ("date = 2031-02-28T10:00:00", "report.date: must be a valid string or must be a valid date"),
        ('mission = " "', "report.mission: must not be blank"),
        ('prepared_by = "a\\nb"', "report.prepared_by: must be one line of printable text"),
        (f'title = "{"x" * 201}"', "report.title: must have at most 200 characters"),
        ('dat = "x"', "report.dat: unknown key; did you mean date?"),
    ],
)
def test_a_bad_title_block_is_refused(tmp_path: Path, line: str, fact: str) -> None:
    path = tmp_path / "tedm.toml"
    path.write_text(f'title = "x"\n[report]\n{line}\n', encoding="utf-8")
    with pytest.raises(ConfigError, match=re.escape(fact)):
        load_project(path, tmp_path / "build")


def test_a_title_of_a_requirement_is_used(copy: Project) -> None:
    text = copy.cases.read_text(encoding="utf-8")
    copy.cases.write_text(text.replace('name = "lpf_readout_item"', 'name = "lpf_readout_item"\ntitle = "Our *item*"'))
    run_cases(copy, ["1", "2", "4b"], None, silent)
    close_loop(copy)
    sketch(copy)
    with open_results(copy) as results:
        specs = {spec.name: spec for spec in figure_specs(results, list(map(read_case, results.cases)))}
        drawn = specs["all_displacement.svg"].draw()
    assert "requirement: Our *item*" in [t.get_text() for t in drawn.legends[0].get_texts()]
    text = report(copy, None, ["md"])[0].read_text(encoding="utf-8")
    assert r"Our \*item\*" in text
    assert "one noise source of the read-out" not in text


def test_the_view_of_the_model_is_linked_where_it_lies_beside_the_report(finished: Project, tmp_path: Path) -> None:
    for there in (False, True):
        if there:
            (tmp_path / "view.html").write_text("<p>view</p>")
        for path in report(finished, tmp_path / "r.html"):
            assert ('href="view.html"' in path.read_text(encoding="utf-8")) == there


BLOCKS = st.recursive(
    st.sampled_from([Table(columns("A"), (row("1"),), c) for c in ("", "caption")] + [Paragraph("text")]),
    lambda inner: (
        st.builds(lambda b: Folded("f", tuple(b)), st.lists(inner, max_size=3))
        | st.builds(lambda b: Columns(tuple(b)), st.lists(inner, max_size=3))
    ),
    max_leaves=6,
)


def count_of(blocks: Sequence[Block]) -> int:
    """Tables with captions, however deep."""
    inner = sum(count_of(b.blocks) for b in blocks if isinstance(b, Folded | Columns))
    return inner + sum(isinstance(b, Table) and bool(b.caption) for b in blocks)


@given(st.lists(BLOCKS, max_size=4), st.lists(BLOCKS, max_size=4))
def test_references_lead_to_either_document(own: list[Block], other: list[Block]) -> None:
    """The table that is referred to is the last of its document: its number is the count of those before it."""
    last = Table(columns("A"), (row("1"),), "caption", key="last")
    text = Paragraph(("See ", Ref("last"), " and ", Link("there", "s2")))
    one = Document("t", "s", "0", (Section("s1", "S", "S", (*own, text)),))
    two = Document("t", "s", "0", (Section("s2", "S", "S", (*other, text, last)),), mark="A")
    for document, away in zip(numbered([one, two]), (True, False), strict=True):
        said = next(b for b in reversed(document.sections[0].blocks) if isinstance(b, Paragraph) and b.text != "text")
        number = f"table A{count_of(other) + 1}"
        assert plain(said.text) == f"See {number}{' of the annex' if away else ''} and there"
        assert [p.away for p in said.text if isinstance(p, Link)] == [away, away]
    with pytest.raises(KeyError):
        numbered([one])
