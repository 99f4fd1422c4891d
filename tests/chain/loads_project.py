"""A project with a file of loads."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from tedm_cli.config.project import Project


def with_loads(project: Project, folder: Path, text: str) -> Project:
    path = folder / "loads.toml"
    path.write_text(text, encoding="utf-8")
    return replace(project, loads=path)
