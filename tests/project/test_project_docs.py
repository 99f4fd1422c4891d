"""What the documents say is what the code does."""

from __future__ import annotations

import re
from pathlib import Path

from tedm_cli.contracts import markdown

ROOT = Path(__file__).parents[2]


def test_file_documentation_is_printed_from_the_contracts() -> None:
    assert (ROOT / "docs" / "reference" / "files.md").read_text(encoding="utf-8") == markdown(), (
        "run python -m tedm_cli.contracts > docs/reference/files.md"
    )


def test_links_in_documents_lead_somewhere() -> None:
    for document in [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").rglob("*.md"))]:
        for target in re.findall(r"\]\(([^)#]+)\)", document.read_text(encoding="utf-8")):
            assert (document.parent / target).exists(), f"{document.name}: {target}"


def test_readme_names_every_command() -> None:
    from typer.main import get_command

    from tedm_cli.cli.commands import app

    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    for name, command in get_command(app).commands.items():  # type: ignore[attr-defined]
        if not command.hidden:
            assert f"tedm {name}" in readme, name
