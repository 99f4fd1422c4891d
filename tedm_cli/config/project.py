"""The project file: which configuration describes the model, the optics and the cases, and the title block."""

from __future__ import annotations

import datetime
import os
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from pydantic import Field

from tedm_cli.config.base import Bounded, FileName, OneLine, Strict, load
from tedm_cli.errors import ConfigError
from tedm_cli.files.provenance import ConfigFile
from tedm_cli.quantities import ISSUE


class ReportTable(Strict):
    """What the title block of the report says."""

    title: OneLine | None = Field(default=None, description="Title of the report. Else one that says what it judges.")
    mission: OneLine | None = Field(default=None, description="Name of the mission.")
    issue: OneLine | Annotated[int, Bounded(ISSUE)] | None = Field(
        default=None, description='Issue of the document: a number, or text such as "2.1 draft".'
    )
    date: OneLine | datetime.date | None = Field(
        default=None,
        description="Date of the document, as a TOML date or as text. It is never taken from a clock: the "
        "same results give the same report.",
    )
    prepared_by: OneLine | None = Field(default=None, description="Who made it.")


OPTICS = "optics.toml"
NO_OPTICS = "the project has no optics: its file names none, and there is no optics.toml beside it"


class ProjectTable(Strict):
    """The project: which file describes what. Paths are relative to this file."""

    title: str = Field(description="Name of the project, in prints and in the report.")
    model: FileName = Field(
        default="model.toml", description="The file that describes the model, the thermal areas and the test masses."
    )
    optics: FileName | None = Field(
        default=None,
        description="The optical layout. Else optics.toml beside the project file, where there is one; "
        "without both the project has no optics.",
    )
    cases: FileName = Field(
        default="cases.toml", description="The file that describes temperatures, correlation cases and requirements."
    )
    dynamics: FileName | None = Field(
        default=None,
        description="The file that describes the drag-free loop. Without it the default loop is taken, where "
        "there can be one.",
    )
    thermal: FileName | None = Field(
        default=None,
        description="The file that describes the thermal network and how it lies on the model. Without it the project "
        "has none.",
    )
    balance: FileName | None = Field(
        default=None,
        description="The file that says where compensation masses may be, for `tedm balance`. No step of the chain "
        "reads it.",
    )
    loads: FileName | None = Field(
        default=None,
        description="The file that describes loads other than temperature, for `tedm build-loads`. Without it the "
        "project has none.",
    )
    report: ReportTable = Field(
        default=ReportTable(), description="Title block of the report. It shows a missing issue or date as not given."
    )


@dataclass(frozen=True)
class Project:
    """A project as the stages see it: its configuration files and the folder that holds their results.

    `optics` is None where the project has self-gravity alone, `thermal` where it has no thermal model, `balance` where
    it does not say where compensation masses may be, `loads` where it has temperatures alone.
    """

    file: ConfigFile
    title: str
    model: Path
    optics: Path | None
    cases: Path
    dynamics: Path | None
    thermal: Path | None
    balance: Path | None
    loads: Path | None
    build_dir: Path
    report: ReportTable

    def resolve(self, text: str) -> Path:
        """A path written in the model configuration: relative to that file, `{build_dir}` replaced."""
        return self.beside(self.model, text)

    def beside(self, file: Path, text: str) -> Path:
        """A path written in this configuration file: relative to it, `{build_dir}` replaced."""
        if "{build_dir}" in text:
            return Path(text.replace("{build_dir}", str(self.build_dir)))
        return file.parent / text

    def required_optics(self) -> Path:
        """The layout, for what cannot be done without; `ConfigError` where there is none."""
        if self.optics is None:
            raise self.lacks_optics()
        return self.optics

    def required_thermal(self) -> Path:
        """The file of the thermal model; `ConfigError` where the project names none."""
        if self.thermal is None:
            fact = "the project has no thermal model: its file names none"
            hint = 'name it: thermal = "thermal.toml"'
            raise ConfigError([("thermal", fact)], where=str(self.file.path), hint=hint)
        return self.thermal

    def required_loads(self) -> Path:
        """The file of loads other than temperature; `ConfigError` where the project names none."""
        if self.loads is None:
            fact = "the project has no loads but temperatures: its file names none"
            raise ConfigError([("loads", fact)], where=str(self.file.path), hint='name them: loads = "loads.toml"')
        return self.loads

    def required_balance(self) -> Path:
        """The file on where compensation masses may be; `ConfigError` where the project names none."""
        if self.balance is None:
            fact = "the project does not say where compensation masses may be: its file names none for that"
            raise ConfigError([("balance", fact)], where=str(self.file.path), hint='name it: balance = "balance.toml"')
        return self.balance

    def lacks_optics(self) -> ConfigError:
        """That something was asked for which only a project with optics has."""
        hint = 'name the optical layout: optics = "optics.toml"; self-gravity needs none'
        return ConfigError([("optics", NO_OPTICS)], where=str(self.file.path), hint=hint)


def load_project(path: Path, build_dir: Path) -> Project:
    """Read the project file.

    Raises
    ------
    InputError : there is no such file.
    ConfigError : what is wrong in it, and every file that it names and that is not there.
    """
    file, table = load(ProjectTable, path, hint="give the path of the project file with --config")
    folder = path.parent
    _require_named(table, path)
    optics = table.optics or (OPTICS if os.path.lexists(folder / OPTICS) else None)
    return Project(
        file=file,
        title=table.title,
        model=folder / table.model,
        optics=None if optics is None else folder / optics,
        cases=folder / table.cases,
        dynamics=None if table.dynamics is None else folder / table.dynamics,
        thermal=None if table.thermal is None else folder / table.thermal,
        balance=None if table.balance is None else folder / table.balance,
        loads=None if table.loads is None else folder / table.loads,
        build_dir=build_dir,
        report=table.report,
    )


def _require_named(table: ProjectTable, path: Path) -> None:
    """Refuse names of files that are not there, all at once; what nothing names is missed where it is needed."""
    problems = []
    for key in ("model", "optics", "cases", "dynamics", "thermal", "balance", "loads"):
        name = getattr(table, key) if key in table.model_fields_set else None
        if name is not None and not _is_there(path.parent / name):
            problems.append((key, f"names {name!r}, but there is no file {path.parent / name}"))
    if problems:
        optional = [key for key, _ in problems if key in ("optics", "dynamics", "thermal", "balance", "loads")]
        without = f"; a project without {' and '.join(optional)} leaves the key out" if optional else ""
        raise ConfigError(problems, where=str(path), hint=f"names are relative to the project file{without}")


def _is_there(path: Path) -> bool:
    """Whether something has this name; what cannot be looked at is told of where it is read."""
    try:
        os.stat(path)
    except (FileNotFoundError, NotADirectoryError, ValueError):  # ValueError: a null character
        return False
    except OSError:
        return True
    return True
