"""The symmetry plane of a project: what the model's configuration says, else the layout's frame, else basic y = 0."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np

from tedm_cli.arrays import FloatArray
from tedm_cli.config.base import read_toml, validate
from tedm_cli.config.model.file import ModelConfig
from tedm_cli.config.optics.tables import FrameTable
from tedm_cli.config.project import Project
from tedm_cli.errors import ConfigError
from tedm_cli.symmetry_plane import BASIC_PLANE, SymmetryPlane

_TOUCHES_M = 1e-6  # a plane that is flush with a model does not miss it

PlaneOrigin = Literal["configured", "layout", "basic"]


@dataclass(frozen=True)
class ProjectPlane:
    """The plane, and where it is from; `layout`: the layout file, where the plane is that of its frame."""

    plane: SymmetryPlane
    origin: PlaneOrigin
    layout: Path | None = None

    def notes(self, position_m: FloatArray) -> list[str]:
        """A remark where the plane misses the thermal areas, whose grids are at `position_m` [n, 3], basic frame."""
        off = self.plane.distance(position_m)
        low, high = float(off.min()), float(off.max())
        if low <= _TOUCHES_M and high >= -_TOUCHES_M:
            return []
        side, near, far = ("+y", low, high) if low > 0.0 else ("-y", -high, -low)
        return [
            f"the symmetry plane ({self.plane.words}) misses the thermal areas, which are {near:.4g} to {far:.4g} m off"
            f" on its side {side}: none has a mirror image; [areas] symmetry_plane gives another, in metres"
        ]


def project_plane(project: Project, config: ModelConfig) -> ProjectPlane:
    """The symmetry plane of a project's thermal areas.

    Raises
    ------
    ConfigError : there is a layout, but no telling what its frame is.
    """
    table, layout = config.areas.symmetry_plane, project.optics
    if table is not None:
        return ProjectPlane(SymmetryPlane(np.array(table.point_m), np.array(table.normal)), "configured")
    # A bench that is not there yet does not keep gravity from being looked at; what it changes is noticed later.
    if layout is None or not layout.exists():
        return ProjectPlane(BASIC_PLANE, "basic")
    return ProjectPlane(plane_of_frame(layout), "layout", layout)


def plane_of_frame(layout: Path) -> SymmetryPlane:
    """The x-z plane of a layout's frame; of the file only its table `[frame]` need be sound."""
    data = read_toml(layout)[1]
    hint = "the sides of thermal areas follow it; [areas] symmetry_plane in the model's configuration may give them"
    if not isinstance(data.get("frame"), dict):
        raise ConfigError([("frame", "missing, or no table")], where=str(layout), hint=hint)
    try:
        frame = validate(FrameTable, data["frame"], where=str(layout))
    except ConfigError as exc:
        problems = [(f"frame.{key}" if key else "frame", fact) for key, fact in exc.problems]
        raise ConfigError(problems, where=str(layout), hint=hint) from None
    return SymmetryPlane(np.array(frame.origin_m), np.array(frame.axes[1]))
