"""Links from the pages to files of the repository that are no pages: in the site, each such file is a page as well.

So a link has one form, which a browser of the repository follows too. Such a page is under `repository/`. A program of
docs/ is in the site as a file as well, and its page has a link that downloads it.
"""

from __future__ import annotations

import re
from pathlib import Path
from posixpath import dirname, join, normpath, relpath

from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files
from mkdocs.structure.pages import Page

_ROOM = "repository/"
_PROJECT = ("CHANGELOG.md", "CONTRIBUTING.md", "README.md")  # pages whether or not another page names them
_LINK = re.compile(r"(\]\()([^)#\s]+)((?:#[^)\s]*)?\))")
_KEPT = (".md", ".ipynb", ".svg", ".png")  # what is itself in the site, where it is in docs/
_LIST = re.compile(r"(?<=\n\n)([A-Za-z].*)\n(?=[-*] )")  # behind a line of text, where Python's Markdown sees none
_LANGUAGES = {".py": "python", ".toml": "toml", ".csv": "text", ".json": "text"}


def _origin(uri: str) -> str:
    """The path in the repository of a page of the site."""
    return uri.removeprefix(_ROOM) if uri.startswith(_ROOM) else f"docs/{uri}"


def _address(path: str) -> str:
    """The address in the site of a file of the repository."""
    if path.startswith("docs/") and path.endswith(_KEPT):
        return re.sub(r"\.ipynb$", ".md", path.removeprefix("docs/"))
    return f"{_ROOM}{path}" + ("" if path.endswith(_KEPT) else ".md")


def _targets(markdown: str, origin: str) -> list[str]:
    """The files of the repository that a text links to."""
    links = [match[2] for match in _LINK.finditer(markdown) if "://" not in match[2]]
    return [normpath(join(dirname(origin), link)) for link in links]


def _text(path: Path, name: str) -> str:
    """A file as a page."""
    text = path.read_text(encoding="utf-8")
    if path.suffix == ".md":
        return text
    language = _LANGUAGES.get(path.suffix, "text")
    above = ""
    if name.startswith("docs/"):
        address = relpath(name.removeprefix("docs/"), dirname(_address(name)))
        above = f'<a href="{address}" download>Download this file</a>\n\n'
    return f"---\nsearch:\n  exclude: true\n---\n# {name}\n\n{above}~~~~~~ {language}\n{text.rstrip()}\n~~~~~~\n"


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Add a page for every file of the repository that a page links to, and for those that these link to."""
    root = Path(config.docs_dir).parent
    pages = [file for file in files.documentation_pages() if file.src_uri.endswith(".md")]
    todo = [*_PROJECT]
    for file in pages:
        todo += _targets(file.content_string, _origin(file.src_uri))
    while todo:
        name = todo.pop()
        address = _address(name)
        # What is not there, or is a folder, is left for the check of links to report.
        if not address.startswith(_ROOM) or files.get_file_from_path(address) or not (root / name).is_file():
            continue
        text = _text(root / name, name)
        files.append(File.generated(config, address, content=text))
        todo += _targets(text, name) if name.endswith(".md") else []
    return files


def on_page_markdown(markdown: str, page: Page, config: MkDocsConfig, files: Files) -> str:
    """Turn links between files of the repository into links between pages of the site, and let lists begin anywhere."""
    origin, here = _origin(page.file.src_uri), dirname(page.file.src_uri)

    def turned(match: re.Match[str]) -> str:
        if "://" in match[2]:
            return match[0]
        address = _address(normpath(join(dirname(origin), match[2])))
        return f"{match[1]}{relpath(address, here or '.')}{match[3]}"

    return _LINK.sub(turned, _LIST.sub(r"\1\n\n", markdown))
