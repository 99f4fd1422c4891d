"""The project file: which configuration describes the model, the optics and the cases, and the title block."""

from __future__ import annotations

import datetime
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from tedm_cli.config.base import Bounded, FileName, OneLine, Strict, load
from tedm_cli.files.provenance import ConfigFile
from tedm_cli.quantities import ISSUE


class ReportTable(Strict):
    """What the title block of the report says.

    A date is given, never taken from a clock: the same results give the same report.
    """

    title: OneLine | None = None
    mission: OneLine | None = None
    issue: OneLine | Annotated[int, Bounded(ISSUE)] | None = None
    date: OneLine | datetime.date | None = None
    prepared_by: OneLine | None = None


class ProjectTable(Strict):
    """Paths are relative to the project file."""

    title: str
    model: FileName = "model.toml"
    optics: FileName = "optics.toml"
    cases: FileName = "cases.toml"
    dynamics: FileName | None = None
    report: ReportTable = ReportTable()


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
    report: ReportTable

    def resolve(self, text: str) -> Path:
        """A path written in the model configuration: relative to that file, `{build_dir}` replaced."""
        if "{build_dir}" in text:
            return Path(text.replace("{build_dir}", str(self.build_dir)))
        return self.model.parent / text


def load_project(path: Path, build_dir: Path) -> Project:
    """Read the project file."""
    file, table = load(ProjectTable, path, hint="give the path of the project file with --config")
    folder = path.parent
    return Project(
        file=file,
        title=table.title,
        model=folder / table.model,
        optics=folder / table.optics,
        cases=folder / table.cases,
        dynamics=None if table.dynamics is None else folder / table.dynamics,
        build_dir=build_dir,
        report=table.report,
    )
