"""The project of a folder: in it, or in the nearest folder above (as of git)."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path

_FOLDER = "configs"
_FILE = "tedm.toml"
BUILD = "build"  # in the folder of the project, where its results are
NO_PROJECT = "there is no project, no tedm.toml, here or in a folder above"


@dataclass(frozen=True)
class Found:
    """A project file, and the folder that is the project's, both as seen from here."""

    folder: Path
    file: Path


def nearest_project() -> Found | None:
    """The project of this folder or of the nearest above; None where there is none."""
    here = Path.cwd()
    for height in range(len(here.parts)):
        found = project_in(Path(*[os.pardir] * height))
        if found is not None:
            return found
    return None


def project_in(folder: Path) -> Found | None:
    """The project of this folder alone; None where it has none. A folder `configs` is part of the one above."""
    if os.path.lexists(folder / _FILE):
        if Path(os.path.abspath(folder)).name != _FOLDER:
            return Found(folder, folder / _FILE)
        return Found(folder.parent if folder.name == _FOLDER else folder / os.pardir, folder / _FILE)
    file = folder / _FOLDER / _FILE
    return Found(folder, file) if os.path.lexists(file) else None
