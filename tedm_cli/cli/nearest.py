"""The project of the folder in which a command is typed: there, or in the nearest folder above (as of git)."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path

_NAMES = (Path("tedm.toml"), Path("configs/tedm.toml"))


@dataclass(frozen=True)
class Found:
    """A project file, and the folder that is the project's, both as seen from here."""

    folder: Path
    file: Path


def nearest_project() -> Found | None:
    """The project of this folder or of the nearest above; None where there is none."""
    here = Path.cwd()
    for height, folder in enumerate((here, *here.parents)):
        for name in _NAMES:
            if os.path.lexists(folder / name):
                up = Path(*[os.pardir] * height)
                return Found(up, up / name)
    return None
