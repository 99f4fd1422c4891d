"""Whether the sides of the thermal areas in a file are those that the project gives them now."""

from __future__ import annotations

from tedm_cli.config.model.file import ModelConfig
from tedm_cli.config.project import Project
from tedm_cli.config.symmetry_plane import project_plane
from tedm_cli.errors import InputError
from tedm_cli.files.store import Reader
from tedm_cli.results.areas import read_plane


def require_plane(file: Reader, project: Project, config: ModelConfig) -> None:
    """Refuse areas with the sides of another symmetry plane than the project has now."""
    used, now = read_plane(file), project_plane(project, config)
    if not now.plane.is_same(used):
        raise InputError(
            f"is stale: the sides of its areas are those of {used.words}; the symmetry plane is {now.plane.words} now",
            where=str(file.path),
            hint="begin again with `tedm ingest`, or with `tedm run`",
        )
