"""Titles, reasons, groups, sources and names that are code to something: text everywhere, or refused by place."""

from __future__ import annotations

import csv
import html.parser
import os
import random
import re
import shutil
import xml.etree.ElementTree as ET
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pypdf
import pytest
from border_tools import Project, replace, tedm, untouched
from markdown_it import MarkdownIt

from tedm_cli.errors import InputError
from tedm_cli.matrix_files.csv_file import read_csv, write_csv
from tedm_cli.matrix_files.named import NamedMatrix
from tedm_cli.nastran.bulk_lines import kept_bulk
from tedm_cli.nastran.deck_lines import read_sections
from tedm_cli.report.inline import read_figure
from tedm_cli.tables.csv_table import csv_line, csv_lines

#: what is code to a shell, Make, HTML, SVG, Markdown, Typst, TeX, a spreadsheet, a template or a format
PAYLOADS = [
    "$(touch pwned)", "`touch pwned`", "; touch pwned #", "${HOME}", "$(shell touch pwned)", "%.o: ; touch pwned",
    "<script>alert(1)</script>", "<img src=x onerror=alert(1)>", "</title><script>alert(1)</script>", "--><b>", "]]>",
    "\" onmouseover=\"alert(1)", "' onclick='alert(1)", "&lt;script&gt;", "&#60;script&#62;", "<svg/onload=alert(1)>",
    "<!--", "<![CDATA[<script>]]>", "<?php exit ?>", "<style>*{display:none}</style>", "javascript:alert(1)",
    "[x](javascript:alert(1))", "![x](http://example.org/x.png)", "# heading", "- item", "1. item", "> quote", "***",
    "---", "===", "```", "~~~", "| a | b |", "**bold**", "_under_ __under__", "<http://example.org>", "\\", "\\\\|",
    "[ref]: http://example.org", "line\nend", "two\n\n# blocks", "tab\there", "    code", "$x^2$", "$$",
    "\\input{/etc/passwd}",
    "#eval(\"1\")", "#read(\"/etc/passwd\")", "#image(\"/etc/passwd\")", "@label", "*strong*", "<label>", "{{ 7*7 }}",
    "{% include '/etc/passwd' %}", "{0.__class__}", "%s%n%x", "=cmd|' /C calc'!A0", "=HYPERLINK(\"http://example.org\")",
    "+1+1", "-2+3", "@SUM(A1)", "'=1", "''=1", "\uff1d1", "a,b", "\"quoted\"", "a;b", "שלום", "مرحبا", "漢字", "Жук",
    "🛰️", "e\u0301", "\ufeffbom", "\u200fmark", "a\u00a0b", "NaN", "null", "../../etc/passwd", "a" * 3000,
]  # fmt: skip
SEEDS = range(1, 1 + int(os.environ.get("TEDM_HOSTILE_SEEDS", "1")))
CONTROLS = ["\x00", "\x07", "\x08", "\r", "\x1b[31m", "\x1b]0;x\x07", "\x7f", "\x9b31m", "\u2028", "\u202e", "\u2066"]


def mixed(rng: random.Random) -> str:
    """One to three payloads, with or without words between them."""
    parts = rng.sample(PAYLOADS, rng.randint(1, 3))
    return rng.choice(["", " ", " word "]).join(parts) or "-"


def printable(text: str) -> str:
    """What a text of one line may be."""
    return "".join(c for c in text if c.isprintable())[:200].strip() or "-"


def quoted(text: str) -> str:
    """As a basic string of TOML."""
    return '"' + "".join(c if c.isalnum() and c.isascii() else f"\\U{ord(c):08x}" for c in text) + '"'


class Tags(html.parser.HTMLParser):
    """Elements and attributes of a page."""

    def __init__(self) -> None:
        super().__init__()
        self.seen: set[tuple[str, str]] = set()
        self.links: set[str] = set()

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.seen |= {(tag, ""), *((tag, name) for name, _ in attrs)}
        self.links |= {str(v)[:22] for name, v in attrs if name in ("href", "src", "xlink:href", "action")}


def tags(path: Path) -> Tags:
    found = Tags()
    found.feed(path.read_text(encoding="utf-8"))
    return found


def tokens(path: Path) -> Iterator[tuple[str, str]]:
    """Kinds and targets of all that Markdown makes of a file."""
    for token in MarkdownIt("commonmark").enable("table").parse(path.read_text(encoding="utf-8")):
        for t in (token, *(token.children or ())):
            yield t.type, str(t.attrs.get("href", t.attrs.get("src", "")))


def shortened(project: Project) -> Project:
    """With three cases of all."""
    cases = project.folder / "cases.toml"
    cases.write_text("[[case]]".join(cases.read_text().split("[[case]]")[:4]))
    return project


def built(project: Project, *commands: str) -> Project:
    for command in (*commands, "run-case all", "plot", "report"):
        project.run(*command.split(), "-q").ok()
    return project


@pytest.fixture(scope="module")
def plain(chain: Project, tmp_path_factory: pytest.TempPathFactory) -> Project:
    """Its chain is built; the cases, figures and documents are not."""
    return built(shortened(chain.copy(tmp_path_factory.mktemp("plain") / "small")))


@pytest.mark.slow
@pytest.mark.parametrize("seed", SEEDS)
def test_a_project_full_of_it(chain: Project, plain: Project, tmp_path: Path, seed: int) -> None:
    rng = random.Random(seed)
    project = shortened(chain.copy(tmp_path / "small"))
    front = "".join(f"{key} = {quoted(printable(mixed(rng)))}\n" for key in ("title", "mission", "issue", "date"))
    (project.folder / "tedm.toml").write_text(f"title = {quoted(mixed(rng))}\n[report]\n{front}")
    layout, cases = project.folder / "optics.toml", project.folder / "cases.toml"
    layout.write_text(re.sub("^title = .*", lambda _: f"title = {quoted(mixed(rng))}", layout.read_text(), flags=re.M))
    text = re.sub("^(title|reason) = .*", lambda m: f"{m[1]} = {quoted(mixed(rng))}", cases.read_text(), flags=re.M)
    (project.folder / "budget.csv").write_text("frequency_hz,amplitude\n1e-3,1e-14\n3e-2,1e-14\n")
    text += "".join(
        f"\n[[requirement]]\nname = {quoted(mixed(rng))}\ntitle = {quoted(printable(mixed(rng)))}\n"
        'table = "budget.csv"\nquantity = "acceleration"\n'
        f'outputs = ["{output}"]\nsource = {quoted(mixed(rng))}\n'
        for output in ("TM1_a_y", "TM2_a_y")
    )
    cases.write_text(text)
    groups = {name: mixed(rng) for name in ("struts", "flanges", "OB")}
    for name, group in groups.items():
        replace(project.model, f'group = "{name}"', f"group = {quoted(group)}")
        cases.write_text(cases.read_text().replace(f'"{name}"', quoted(group)))
    built(project, "ingest", "build-distortion", "build-sensitivity", "build-optics", "build-adjoint")
    assert not list(tmp_path.rglob("pwned"))

    for name, other in (("report", "report_annex"), ("report_annex", "report")):
        page, reference = tags(project.build / f"{name}.html"), tags(plain.build / f"{name}.html")
        assert page.seen <= reference.seen
        away = {v.partition("#")[0] for v in page.links if not v.startswith(("#", "data:image/png;base64,"))}
        assert away == {f"{other}.html"}

        kinds = {kind for kind, _ in tokens(plain.build / f"{name}.md")}
        found = list(tokens(project.build / f"{name}.md"))
        assert {kind for kind, _ in found} <= kinds | {"text_special"}
        targets = {target for _, target in found if target}
        assert all(re.fullmatch(rf"figures/[\w.-]+|{other}\.md", target) for target in targets)

        for page_of_pdf in pypdf.PdfReader(project.build / f"{name}.pdf").pages:
            for note in page_of_pdf.get("/Annots", []):
                assert "/URI" not in (note.get_object().get("/A") or {})

    for figure in (project.build / "figures").glob("*.svg"):
        names = {element.tag.rpartition("}")[2] for element in ET.parse(figure).iter()}
        assert not names & {"script", "foreignObject", "a", "iframe", "animate", "set"}

    tedm("export-case", "--format", "csv", "-d", project.build, "-q").ok()
    tedm("export-case", "3", "--format", "npz", "-d", project.build, "-q").ok()
    tables = list((project.build / "export").rglob("*.csv"))
    assert len(tables) > 12
    for table in tables:
        with open(table, newline="", encoding="utf-8") as stream:
            for cell in (cell for row in csv.reader(stream) for cell in row):
                assert not re.match("[=+@\t\r\n\uff0b\uff0d\uff1d\uff20-]", cell) or np.isreal(float(cell))
    limits = np.load(project.build / "export" / "case03.npz")["requirement_asd.columns"].tolist()
    head = csv_lines(project.build / "export" / "case03" / "requirement_asd.csv")[0][1]
    assert head == [name.strip() for name in limits]

    shown = [project.run("run-case", "all", "-v"), project.run("explain", "TM1_x"), tedm("check", "-d", project.build)]
    shown += [tedm("show", path) for path in project.build.glob("*.h5")]
    for outcome in shown:
        assert not re.search("[\x00-\x08\x0b-\x1f\x7f-\x9f\u202a-\u202e\u2066-\u2069]", outcome.ok().out + outcome.err)


@pytest.mark.parametrize("sign", CONTROLS)
@pytest.mark.parametrize("place", ["title", "case", "group", "key"])
def test_control_characters_are_refused_by_place(small: Project, sign: str, place: str) -> None:
    text = quoted(f"a{sign}b")
    if place == "title":
        (small.folder / "tedm.toml").write_text(f"title = {text}\n")
        where = "title"
    elif place == "case":
        replace(small.folder / "cases.toml", 'title = "All areas correlated"', f"title = {text}")
        where = "case[0].title"
    elif place == "group":
        replace(small.model, 'group = "struts"', f"group = {text}")
        where = "areas.rule[0].group"
    else:
        replace(small.model, "[gravity.subsystems]", f"[gravity.subsystems]\n{text} = []")
        where = f"gravity.subsystems.a?{sign[1:].replace(chr(7), '?')}b"
    command = "ingest" if place in ("group", "key") else "run-case"
    fact = f"{'the key ' * (place == 'key')}holds the control character U+{ord(sign[0]):04X}"
    with untouched(small.folder):
        small.stage(command).refused(3, f"{where}: {fact}", hint="delete")


def test_labels_come_back_from_a_csv(tmp_path: Path) -> None:
    """Every payload is a label; nothing is a formula to a spreadsheet, and all come back as they went."""
    labels = [*(p for p in PAYLOADS if p == p.strip()), "-5", "+y", "\t=x", "'", "''", "'a"]
    n = len(labels)
    matrix = NamedMatrix(
        "M", np.arange(n * n, dtype=float).reshape(n, n) - 7.5, labels, labels, ["m"] * n, ["K"] * n, ""
    )
    write_csv(tmp_path / "M.csv", matrix)
    found = read_csv(tmp_path / "M.csv", "M")
    assert found.declared["rows"] == labels
    assert found.declared["columns"] == labels
    np.testing.assert_array_equal(found.values, matrix.values)
    with open(tmp_path / "M.csv", newline="", encoding="utf-8") as stream:
        cells = [cell for row in csv.reader(stream) for cell in row]
    assert {c for c in cells if re.match("[=+@\t\r-]", c)} == {c for c in cells if re.fullmatch(r"-\d+(\.\d+)?", c)}


def test_a_line_of_csv_is_what_the_standard_writer_makes(tmp_path: Path) -> None:
    cells = ["a", "b,c", 'd"e', "", "1.5", "-2e-3", "f\ng", " h "]
    path = tmp_path / "t.csv"
    path.write_text(csv_line(cells) + csv_line([""]))
    with open(tmp_path / "s.csv", "w", newline="") as stream:
        csv.writer(stream, lineterminator="\n").writerows([cells, [""]])
    assert path.read_bytes() == (tmp_path / "s.csv").read_bytes()
    assert csv_lines(path)[0][1] == [c.strip() for c in cells]


@pytest.mark.parametrize(
    "name",
    ["model\nGRID,99,,0.,0.,0..bdf", "model\r\nENDDATA.bdf", "模型.bdf", "a\x1b[31mb.bdf", "$x.bdf", "ENDDATA.bdf"],
)
def test_the_name_of_a_deck_is_a_comment(tiny: Project, name: str) -> None:
    (tiny.folder / "model.bdf").rename(tiny.folder / name)
    before = len(kept_bulk(read_sections(tiny.deck).bulk)[0])
    link = tiny.folder / "main.bdf"
    link.write_bytes((tiny.folder / name).read_bytes())
    tiny.run("write-deck", "-q").refused(4, "no such model")
    replace(tiny.model, '"model.bdf"', quoted(name) if name.isprintable() else '"main.bdf"')
    if not name.isprintable():  # a configuration cannot name it, an INCLUDE or a library can
        from tedm_cli.stages.model import deck as stage

        original = stage.read_source
        source = lambda path, *more, **keys: original(tiny.folder / name, *more, **keys)  # noqa: E731
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(stage, "read_source", source)
            tiny.run("write-deck", "-q").ok()
    else:
        tiny.run("write-deck", "-q").ok()
    assert len(kept_bulk(read_sections(tiny.deck).bulk)[0]) == before
    assert tiny.deck.read_bytes().isascii()


SVG = '<svg xmlns="http://www.w3.org/2000/svg" xmlns:xlink="http://www.w3.org/1999/xlink" viewBox="0 0 1 1">{}</svg>'
ACTIVE = [
    "<script>alert(1)</script>", '<g onload="alert(1)"/>', '<a href="javascript:alert(1)"><text>x</text></a>',
    '<a xlink:href="http://example.org"/>', "<foreignObject><p>x</p></foreignObject>", '<image href="file:///etc/passwd"/>',
    '<use xlink:href="http://example.org/x.svg#a"/>', '<set attributeName="href" to="javascript:alert(1)"/>',
    "<style>@import 'http://example.org/x.css';</style>", '<rect style="fill: url(http://example.org/x)"/>',
    "<!--><script>alert(1)</script>-->", "<title><p>x</p></title>", "<text>", "<![CDATA[<script>]]>",
    '<x:script xmlns:x="y"/>',
]  # fmt: skip


@pytest.mark.parametrize("content", ACTIVE)
def test_a_figure_that_does_something_is_not_put_into_a_page(tmp_path: Path, content: str) -> None:
    figure = tmp_path / "f.svg"
    figure.write_text(SVG.format('<g id="a"><path d="M 0 0"/></g><use xlink:href="#a"/>'))
    read_figure(figure, [])
    figure.write_text(SVG.format(content))
    with pytest.raises(InputError, match=r"which no figure of tedm does|outside of it|holds a|is no SVG"):
        read_figure(figure, [])


def test_a_changed_figure_is_refused_by_the_report(plain: Project, tmp_path: Path) -> None:
    folder = tmp_path / "small"
    shutil.copytree(plain.folder, folder)
    project = Project(folder)
    figure = next(iter(sorted((project.build / "figures").glob("ratios*.svg"))))
    figure.write_text(figure.read_text().replace("</svg>", "<script>alert(1)</script></svg>"))
    with untouched(project.folder):
        project.run("report").refused(4, figure.name, "holds a script", hint="tedm plot")
