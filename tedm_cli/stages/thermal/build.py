"""build-thermal: steady state, gains and spectra of the thermal network, and what its nodes do to the outputs."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from tedm_cli.config.project import Project
from tedm_cli.config.thermal.file import load_thermal
from tedm_cli.contracts import THERMAL as KIND
from tedm_cli.files.build_folder import THERMAL_FILE, provenance
from tedm_cli.files.store import Writer, create
from tedm_cli.stages.common import out_path
from tedm_cli.stages.thermal.map import NodeSensitivity, node_sensitivity


@dataclass(frozen=True, eq=False)
class ThermalSummary:
    """The file, and what is in it."""

    path: Path
    mapped: NodeSensitivity | None


def build_thermal(project: Project, output: Path | None) -> ThermalSummary:
    """Write thermal.h5 with all that the configuration has the makings of."""
    path = project.required_thermal()
    file, config = load_thermal(path)
    mapped = node_sensitivity(project, config)
    inputs = [*(path.parent / name for name in config.file_names()), *(() if mapped is None else mapped.inputs)]
    configs = [file, *(() if mapped is None else mapped.configs)]
    out = out_path(project, THERMAL_FILE, output)
    with create(out, KIND, provenance(configs, inputs)) as writer:
        if mapped is not None:
            _write_mapped(writer, mapped)
    return ThermalSummary(out, mapped)


def _write_mapped(writer: Writer, mapped: NodeSensitivity) -> None:
    writer.write(KIND.ROW_LABEL, mapped.label)
    writer.write(KIND.ROW_UNIT, mapped.unit)
    writer.write(KIND.MAP_NODE, mapped.node)
    writer.write(KIND.SENSITIVITY, mapped.value, units="see /row/unit")
