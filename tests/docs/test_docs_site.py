"""The documentation as a site: built without a network and without a warning, and whole."""

from __future__ import annotations

import html
import json
import re
import socket
from collections.abc import Iterator
from html.parser import HTMLParser
from pathlib import Path
from typing import Any
from urllib.parse import unquote, urlsplit

import nbformat
import pytest
from mkdocs.commands.build import build
from mkdocs.config import load_config

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"
_FETCHED = {"script": "src", "img": "src", "iframe": "src", "source": "src", "link": "href"}

pytestmark = pytest.mark.slow


class Page(HTMLParser):
    """What a page refers to, what it fetches when it is opened, and where it may be entered."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.links: list[str] = []
        self.fetched: list[str] = []
        self.anchors = {"", "__top"}
        self.classes: set[str] = set()
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        given = {key: value or "" for key, value in attrs}
        self.anchors |= {given[key] for key in ("id", "name") if key in given}
        self.classes |= set(given.get("class", "").split())
        self.links += [given[key] for key in ("href", "src") if key in given]
        if (key := _FETCHED.get(tag)) in given:
            self.fetched.append(given[str(key)])


def _no_network(*_: Any, **__: Any) -> Any:
    raise AssertionError("the site asks for a network")


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("site")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(socket.socket, "connect", _no_network)
        patch.setattr(socket, "getaddrinfo", _no_network)
        patch.setenv("NO_MKDOCS_2_WARNING", "1")
        patch.chdir(folder)
        # Strict: a warning ends it. A page out of the order, a link or anchor that leads nowhere are warnings.
        build(load_config(str(ROOT / "mkdocs.yml"), site_dir=str(folder), strict=True))
    return folder


@pytest.fixture(scope="module")
def pages(site: Path) -> dict[Path, Page]:
    return {path: Page(path.read_text(encoding="utf-8")) for path in sorted(site.rglob("*.html"))}


def nav_pages(part: Any) -> Iterator[str]:
    """The pages in the order of mkdocs.yml."""
    for inner in part.values() if isinstance(part, dict) else part:
        if isinstance(inner, str):
            yield inner
        else:
            yield from nav_pages(inner)


def test_every_page_is_in_the_order_and_in_the_site(site: Path) -> None:
    in_order = list(nav_pages(load_config(str(ROOT / "mkdocs.yml")).nav))
    assert len(set(in_order)) == len(in_order)
    there = {p.relative_to(DOCS).with_suffix(".md").as_posix() for e in ("md", "ipynb") for p in DOCS.rglob(f"*.{e}")}
    assert {name for name in in_order if not name.startswith("repository/")} == there
    for name in in_order:
        assert (site / re.sub(r"(README|index)\.md$", "index.md", name)).with_suffix(".html").is_file(), name
    programs = {path.relative_to(DOCS) for path in DOCS.glob("examples/*.py")}
    assert {path.relative_to(site) for path in site.rglob("*.py")} == programs


def test_every_link_and_anchor_leads_somewhere(site: Path, pages: dict[Path, Page]) -> None:
    followed = 0
    for path, page in pages.items():
        for link in page.links:
            parts = urlsplit(link)
            if parts.scheme or parts.netloc:
                continue
            name = unquote(parts.path)
            target = site / name.lstrip("/") if name.startswith("/") else path.parent / name if name else path
            target = (target / "index.html" if target.is_dir() else target).resolve()
            assert target.is_file(), f"{path.relative_to(site)}: {link}"
            if target.suffix == ".html":
                assert unquote(parts.fragment) in pages[target].anchors, f"{path.relative_to(site)}: {link}"
            followed += 1
    assert followed > 1000


def test_nothing_comes_from_another_host(site: Path, pages: dict[Path, Page]) -> None:
    for path, page in pages.items():
        assert page.fetched
        assert not [f for f in page.fetched if "//" in f and not f.startswith("data:")], path.relative_to(site)
        # What the theme's program would fetch something for: drawings, and the repository's counts.
        assert not page.classes & {"mermaid", "md-source"}, path.relative_to(site)
    for sheet in site.rglob("*.css"):
        assert not re.findall(r"(?:url\(|@import)\s*[\"']?(?:https?:)?//", sheet.read_text(encoding="utf-8")), sheet


def test_the_search_works_from_files(site: Path, pages: dict[Path, Page]) -> None:
    """Its index is a program that a page may load without a server, and so is what stands for its worker."""
    text = (site / "search" / "search_index.js").read_text(encoding="utf-8")
    index = json.loads(text.removeprefix("var __index = "))
    found = {entry["location"] for entry in index["docs"] if "quadrature_tolerance" in entry["text"]}
    assert "reference/configuration.html#gravity" in found
    assert not any(entry["location"].startswith("repository/configs/") for entry in index["docs"])
    for path, page in pages.items():
        assert any(f.endswith("site/iframe-worker.js") for f in page.fetched), path.relative_to(site)


def test_a_file_that_is_no_page_is_one_in_the_site(site: Path, pages: dict[Path, Page]) -> None:
    configuration = pages[site / "reference" / "configuration.html"]
    assert "../repository/configs/model.toml.html" in configuration.links
    shown = re.sub(r"<[^>]+>", "", (site / "repository" / "configs" / "model.toml.html").read_text(encoding="utf-8"))
    original = (ROOT / "configs" / "model.toml").read_text(encoding="utf-8")
    assert original.strip() in html.unescape(shown)
    assert "../repository/docs/examples/bimetal_strip.py.html" in pages[site / "examples" / "index.html"].links
    page = pages[site / "repository" / "docs" / "examples" / "bimetal_strip.py.html"]
    assert "../../../examples/bimetal_strip.py" in page.links
    program = Path("examples") / "bimetal_strip.py"
    assert (site / program).read_bytes() == (DOCS / program).read_bytes()


def test_the_notebook_is_shown_as_it_is_stored(site: Path, pages: dict[Path, Page]) -> None:
    text = (site / "tutorial" / "notebook.html").read_text(encoding="utf-8")
    plain = html.unescape(re.sub(r"<[^>]+>", "", text))
    outputs = [o for c in nbformat.read(DOCS / "tutorial" / "notebook.ipynb", 4).cells for o in c.get("outputs", [])]
    streams = [output.text for output in outputs if output.output_type == "stream"]
    pictures = [o.data["image/png"].replace("\n", "") for o in outputs if "image/png" in o.get("data", {})]
    assert len(streams) > 2
    assert pictures
    assert all(stream.strip() in plain for stream in streams)
    assert "notebook.ipynb" in pages[site / "tutorial" / "notebook.html"].links
    assert (site / "tutorial" / "notebook.ipynb").read_bytes() == (DOCS / "tutorial" / "notebook.ipynb").read_bytes()
    assert all(f"data:image/png;base64,{picture}" in text for picture in pictures)
    assert text.count("<table>") == sum("text/html" in output.get("data", {}) for output in outputs)


def test_markdown_means_in_the_site_what_it_means_elsewhere(site: Path, pages: dict[Path, Page]) -> None:
    """No list or table that is a paragraph, no link or fence that is text."""
    for path in pages:
        text = path.read_text(encoding="utf-8")
        for part in re.findall(r"<(?:p|li)>(.*?)</(?:p|li)>", text, re.DOTALL):
            words = re.sub(r"<code.*?</code>", "", part, flags=re.DOTALL)
            assert not re.search(r"\n\s*(?:[*-]|\d+\.) |\|---|```|~~~|\]\(", words), f"{path.relative_to(site)}: {part}"


def test_docstrings_are_rendered(site: Path, pages: dict[Path, Page]) -> None:
    path = site / "reference" / "python.html"
    text = path.read_text(encoding="utf-8")
    assert {"tedm.run_case", "tedm.Build.sensitivity", "tedm.TestMass", "tedm.Error"} <= pages[path].anchors
    assert "<code>safety_factor</code>: on amplitudes when judged." in text
    assert "Raises\n---" not in text
