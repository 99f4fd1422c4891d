"""A link to a heading, in any document, names one that is there, and no link shows the name of a file of text."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
DOCUMENTS = [*sorted(ROOT.glob("*.md")), *sorted((ROOT / "docs").rglob("*.md"))]


def headings(text: str) -> set[str]:
    """Anchors of the headings, as sites for Markdown make them; lines of code are no headings."""
    text = re.sub(r"^```.*?^```", "", text, flags=re.M | re.S)
    plain = (re.sub(r"\[([^]]*)\]\([^)]*\)", r"\1", h) for h in re.findall(r"^#+ +(.*?) *$", text, flags=re.M))
    return {re.sub(r"[^\w\- ]", "", h.lower()).replace(" ", "-") for h in plain}


@pytest.mark.parametrize("document", DOCUMENTS, ids=lambda path: path.name)
def test_links_to_headings(document: Path) -> None:
    for target, place in re.findall(r"\]\(([^)#\s]*)#([^)\s]+)\)", document.read_text(encoding="utf-8")):
        if not target.startswith("http"):
            page = document.parent / target if target else document
            assert place in headings(page.read_text(encoding="utf-8")), f"{document.name}: {target}#{place}"


def test_links_show_titles() -> None:
    """A reader of the site has pages, with titles; names such as project.md are of the repository."""
    shown = [
        (document.name, words)
        for document in DOCUMENTS
        for words in re.findall(r"\[([^]]+)\]\([^)]+\)", document.read_text(encoding="utf-8"))
    ]
    assert len(shown) > 200
    files = [(page, words) for page, words in shown if re.search(r"\.(md|ipynb)$", words)]
    assert [named for named in files if named[0] != "CHANGELOG.md"] == []
