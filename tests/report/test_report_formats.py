"""The same document as page, PDF and Markdown."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pypdf import PdfReader
from pypdfium2 import PdfDocument

from tedm_cli.config.project import Project
from tedm_cli.errors import UsageError
from tedm_cli.figures.drawing.fonts import font_folder
from tedm_cli.report.document import (
    Cell,
    Columns,
    Document,
    Facts,
    FileLink,
    Folded,
    Heading,
    Label,
    Link,
    Listing,
    Paragraph,
    Ref,
    Section,
    Strong,
    Table,
    VerdictCard,
    columns,
    row,
)
from tedm_cli.report.html import to_html
from tedm_cli.report.markdown import to_markdown
from tedm_cli.report.numbering import numbered
from tedm_cli.report.pdf import to_pdf
from tedm_cli.stages.reporting.report import report

NASTY = "a <b>&amp; | `x` *y* _z_ #1 $m$ [l](u) @ref \\ ~ = //"
TABLE = Table(
    columns("Name", "Value\n(m)", text=(0,)),
    (
        row("Case 1", NASTY, "note", kind="head"),
        row(Cell(NASTY, label=NASTY), Cell("1.5 FAIL", "violated")),
        row("all", Cell("0", rounding=True), kind="sum"),
    ),
    NASTY,
    key="t",
)
OTHER = "a b#&.html"
PLAIN = Document(
    "Title " + NASTY,
    "Subject",
    "0.0",
    (
        Section("first", "First", "First", (
            VerdictCard("open", "At risk", "name", (Strong(NASTY), " and ", Link("x", "second")), (("Fact", NASTY),)),
            Paragraph((Label(NASTY), FileLink(NASTY, OTHER), Ref("t"))), Paragraph(NASTY), Heading("Heading"),
            Facts((("Key", (Strong("value"),)),)), Columns((TABLE, TABLE)),
        )),
        Section("second", "Second", "Second", (Folded("More", (Listing("```\n" + NASTY + "\n\n  indented"),)),)),
    ),
    (("In short, ", Strong("bad"), "."),),
    (("Mission", NASTY),),
)  # fmt: skip
DOCUMENT = numbered([PLAIN])[0]


def text_of(pdf: bytes) -> str:
    return "\n".join(page.get_textpage().get_text_range() for page in PdfDocument(pdf))


@pytest.mark.parametrize(
    ("which", "words_of", "figures"),
    [
        (0, ("Decision", "What to do", "Evidence: how sure the verdicts are", "Assumptions", "lpf_readout_item"), 8),
        (1, ("Each requirement", "What would change it", "Other assumptions", "lpf_readout_item", "STRUT_1"), 10),
    ],
)
def test_all_three_are_written_and_say_the_same(
    finished: Project, tmp_path: Path, which: int, words_of: tuple[str, ...], figures: int
) -> None:
    html, pdf, md = (report(finished, tmp_path / f"r.{fmt}")[which] for fmt in ("html", "pdf", "md"))
    page, printed, marked = html.read_text(), text_of(pdf.read_bytes()), md.read_text()
    for words in words_of:
        assert words in page
        assert words in re.sub(r"\s+", " ", printed.replace("\u200b", ""))
        assert words in marked
    assert page.count("<figure ") == marked.count("![") > figures
    rows = len(re.findall(r"<tr(?: class=\"(?:failed|sum)\")?>", page))
    rulers = len(re.findall(r"^\| -", marked, re.MULTILINE))
    assert len(re.findall(r"^\|", marked, re.MULTILINE)) - rulers == rows
    for name in re.findall(r"!\[[^\n]*\]\(([^)]*)\)", marked):
        assert (tmp_path / name).resolve().is_file(), "figures are found from where the Markdown is"


def test_pdf_has_bookmarks_pages_and_fonts_of_its_own(finished: Project, tmp_path: Path) -> None:
    path = report(finished, tmp_path / "r.pdf")[0]
    reader = PdfReader(path)
    titles = [item.title for item in reader.outline if not isinstance(item, list)]
    assert titles[:4] == [
        "Decision",
        "What to do",
        "Evidence: every case",
        "Evidence: what the noise comes from",
    ]
    assert "Decision" in reader.pages[0].extract_text()
    assert all(abs(float(p.mediabox.width) - 595.28) < 0.1 for p in reader.pages), "A4"
    fonts = {
        str(f["/BaseFont"]) for p in reader.pages for f in (v.get_object() for v in p["/Resources"]["/Font"].values())
    }
    assert fonts
    assert all("DejaVu" in f for f in fonts), "text and figures in one family, whatever the machine has"
    assert reader.trailer["/Root"]["/MarkInfo"]["/Marked"], "tagged for screen readers"


def test_same_document_same_bytes() -> None:
    assert to_pdf(DOCUMENT, font_folder()) == to_pdf(DOCUMENT, font_folder())
    assert to_html(DOCUMENT, OTHER) == to_html(DOCUMENT, OTHER)
    assert to_markdown(DOCUMENT, "f", OTHER) == to_markdown(DOCUMENT, "f", OTHER)


def test_signs_of_the_formats_come_out_as_text() -> None:
    printed = text_of(to_pdf(DOCUMENT, font_folder())).replace("\u200b", "")
    assert re.sub(r"\s+", "", printed).count(re.sub(r"\s+", "", NASTY)) >= 12
    page = to_html(DOCUMENT, OTHER)
    assert page.count("a &lt;b&gt;&amp;amp; | `x`") == 17
    assert "<b>" not in page
    marked = to_markdown(DOCUMENT, "f", OTHER)
    assert r"a \<b\>\&amp; \| \`x\` \*y\* \_z\_ \#1 \$m\$ \[l\](u)" in marked
    assert "\n````\n```\n" in marked, "a fence that the text does not close"


@given(st.lists(st.text(st.characters(exclude_categories=("Cs", "Cc"))), min_size=1, max_size=4))
def test_no_name_breaks_a_table_of_markdown(names: list[str]) -> None:
    table = Table(columns("A", "B"), tuple(row(n, "1") for n in names))
    text = to_markdown(Document("t", "s", "0", (Section("a", "A", "A", (table,)),)), "f", OTHER)
    rows = [line for line in text.split("\n") if line.startswith("|")]
    assert len(rows) == len(names) + 2
    assert all(len(re.findall(r"(?<!\\)(?:\\\\)*\|", line)) == 3 for line in rows)


@pytest.mark.parametrize(
    ("name", "formats"), [("r.docx", ()), ("report", ()), ("r.pdf", ("html",)), ("r.html", ("html", "pdf"))]
)
def test_files_that_cannot_take_the_report(
    finished: Project, tmp_path: Path, name: str, formats: tuple[str, ...]
) -> None:
    with pytest.raises(UsageError, match="cannot take the report") as caught:
        report(finished, tmp_path / name, formats)  # type: ignore[arg-type]
    assert ".html, .pdf or .md" in caught.value.hint
    assert list(tmp_path.iterdir()) == []
