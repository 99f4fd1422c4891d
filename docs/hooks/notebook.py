"""Notebooks as pages, with the outputs that are stored in them: nothing is executed.

The notebook itself is beside its page.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import nbformat
from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files


def _fenced(text: str, language: str) -> str:
    return f"~~~~~~ {language}\n{text.rstrip()}\n~~~~~~"


def _output(output: Any) -> str:
    """One output, in the richest of its forms that a page without scripts can show."""
    if output.output_type == "stream":
        return _fenced(output.text, "text")
    if "image/png" in output.data:
        picture = output.data["image/png"].replace("\n", "")
        return f'<img alt="what the cell above draws" src="data:image/png;base64,{picture}">'
    if "text/html" in output.data:
        table = re.sub(r"<style.*?</style>", "", output.data["text/html"], flags=re.DOTALL)
        return "\n".join(line for line in re.sub(r"<table[^>]*>", "<table>", table).splitlines() if line.strip())
    return _fenced(output.data["text/plain"], "text")


def _markdown(path: Path) -> str:
    parts = []
    for cell in nbformat.read(path, as_version=4).cells:
        if cell.cell_type == "markdown":
            parts.append(cell.source)
        else:
            parts += [_fenced(cell.source, "python"), *map(_output, cell.outputs)]
    # HTML, because a link of Markdown would lead to the page again (repository.py).
    parts.insert(1, f'<a href="{path.name}" download>Download this notebook</a>')
    return "\n\n".join(parts) + "\n"


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """A page for each notebook."""
    for file in [file for file in files if file.src_uri.endswith(".ipynb")]:
        page = file.src_uri.removesuffix(".ipynb") + ".md"
        files.append(File.generated(config, page, content=_markdown(Path(str(file.abs_src_path)))))
    return files
