"""The project file: which configuration describes the model, the optics and the cases."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from tedm_cli.config.base import FileName, Strict, load
from tedm_cli.files.provenance import ConfigFile


class ProjectTable(Strict):
    """Paths are relative to the project file."""

    title: str
    model: FileName = "model.toml"
    optics: FileName = "optics.toml"
    cases: FileName = "cases.toml"
    dynamics: FileName | None = None


@dataclass(frozen=True)
class Project:
    """A project as the stages see it: its configuration files and the folder that holds their results."""

    file: ConfigFile
    title: str
    model: Path
    optics: Path
    cases: Path
    dynamics: Path | None
    build_dir: Path

    def resolve(self, text: str) -> Path:
        """A path written in the model configuration: relative to that file, `{build_dir}` replaced."""
        if "{build_dir}" in text:
            return Path(text.replace("{build_dir}", str(self.build_dir)))
        return self.model.parent / text


def load_project(path: Path, build_dir: Path) -> Project:
    """Read the project file."""
    file, table = load(ProjectTable, path, hint="give the path of the project file with --config")
    folder = path.parent
    dynamics = None if table.dynamics is None else folder / table.dynamics
    return Project(
        file, table.title, folder / table.model, folder / table.optics, folder / table.cases, dynamics, build_dir
    )
