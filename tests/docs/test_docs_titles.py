"""What the program says names pages of the documentation by title: a wheel has no files of them."""

from __future__ import annotations

import ast
import re
from pathlib import Path

import pytest

from tedm_cli.documentation import Page

ROOT = Path(__file__).parents[2]
PACKAGE = ROOT / "tedm_cli"
TITLES = {
    line.removeprefix("# ")
    for page in sorted((ROOT / "docs").rglob("*.md"))
    for line in page.read_text(encoding="utf-8").splitlines()[:1]
}
# What these say is written into a page, beside the others.
PRINTS_A_PAGE = {
    *("cli/reference.py", "config/reference.py", "contracts/document.py", "contracts/__init__.py"),
    *("contracts/__main__.py",),
}
SAID = [p for p in sorted(PACKAGE.rglob("*.py")) if p.relative_to(PACKAGE).as_posix() not in PRINTS_A_PAGE]
A_FILE = re.compile(r"\bdocs/|\b[\w-]+\.md\b|\bREADME\b")
MADE_HERE = {"report.md", "annex.md", "report_annex.md"}


def literals(path: Path) -> list[tuple[int, str]]:
    """Every text in the program, docstrings and parts of f-strings with the rest."""
    nodes = ast.walk(ast.parse(path.read_text(encoding="utf-8")))
    return [(n.lineno, n.value) for n in nodes if isinstance(n, ast.Constant) and isinstance(n.value, str)]


def test_no_text_of_the_program_names_a_file_of_the_documentation() -> None:
    assert len(SAID) > 500
    found = [
        f"{path.relative_to(ROOT)}:{line}: {named[0]}"
        for path in SAID
        for line, text in literals(path)
        for named in A_FILE.finditer(text)
        if named[0] not in MADE_HERE
    ]
    assert not found, "name the page by its title (tedm_cli.documentation): " + "; ".join(found)


def test_what_is_searched_for_is_found() -> None:
    text = "see docs/how-to/optics.md, solver.md, the README; report.md is made here"
    assert [m[0] for m in A_FILE.finditer(text)] == ["docs/", "optics.md", "solver.md", "README", "report.md"]


@pytest.mark.parametrize("path", sorted((ROOT / folder).as_posix() for folder in ("configs", "sample_models")))
def test_nor_do_the_files_of_a_new_project(path: str) -> None:
    """Comments of the samples go into every wheel."""
    for file in sorted(Path(path).rglob("*")):
        if file.suffix in (".toml", ".py"):
            assert not re.search(r"\bdocs/[\w/-]+\.md", file.read_text(encoding="utf-8")), file


def test_the_titles_are_those_of_pages() -> None:
    assert len(TITLES) > 20
    for page in Page:
        named = re.fullmatch(r'documentation: "(.+)"', page)
        assert named is not None
        assert named[1] in TITLES
    for path in sorted((PACKAGE / "library").rglob("*.py")):
        for _, text in literals(path):
            for named in re.findall(r'"([^"]+)"\s+(?:in the documentation|what is in each)', text):
                assert named in TITLES, path
