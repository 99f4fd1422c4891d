"""The thermal nodes that lie on the finite elements, and what a kelvin of each does to the outputs."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from tedm_cli.arrays import FloatArray
from tedm_cli.config.project import Project
from tedm_cli.config.thermal.file import ThermalConfig
from tedm_cli.files.provenance import ConfigFile


@dataclass(frozen=True, eq=False)
class NodeSensitivity:
    """Outputs per kelvin of each thermal node of the map.

    node : [n_m] names. label, unit : [r], of the outputs. value : [r, n_m]. configs, inputs : what it is made of, for
    the provenance of the file.
    """

    node: list[str]
    label: list[str]
    unit: list[str]
    value: FloatArray
    configs: tuple[ConfigFile, ...]
    inputs: tuple[Path, ...]


def node_sensitivity(project: Project, config: ThermalConfig) -> NodeSensitivity | None:
    """The sensitivities, None where the project has no map or no adjoint."""
    return None
