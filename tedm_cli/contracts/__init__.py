"""One class per kind of HDF5 file: its datasets, their dimensions, type, unit, frame and meaning.

A dataset's path is written here alone: `file.array(CASE.VERDICT_RATIO)`, `CASE.PSD.of(output)`.

The reader and the writer in `tedm_cli.files.store` check against them; `docs/reference/files.md` is printed from them.
A path with a name in braces (`/psd/{output}`) stands for one dataset per name. A unit of `None` is given by the writer.
Changing one in a way that older files do not fit raises the kind's `version`.
"""

from __future__ import annotations

from tedm_cli.contracts.adjoint import ADJOINT
from tedm_cli.contracts.balance import BALANCE
from tedm_cli.contracts.case import CASE
from tedm_cli.contracts.distortion import DISTORTION
from tedm_cli.contracts.document import document
from tedm_cli.contracts.dynamics import DYNAMICS
from tedm_cli.contracts.imposed import IMPOSED
from tedm_cli.contracts.loads import LOADS
from tedm_cli.contracts.optics import OPTICS
from tedm_cli.contracts.partial import PARTIAL
from tedm_cli.contracts.release import RELEASE
from tedm_cli.contracts.sensitivity import SENSITIVITY
from tedm_cli.contracts.series import SERIES, SIMULATED_SERIES, SeriesDatasets
from tedm_cli.contracts.simulation import SIMULATION
from tedm_cli.contracts.spec import AreaDatasets, AreaPlaces, Dataset, FileKind, GridDatasets
from tedm_cli.contracts.temperatures import TEMPERATURES
from tedm_cli.contracts.thermal import THERMAL
from tedm_cli.contracts.trade import TRADE
from tedm_cli.contracts.unit_loads import UNIT_LOADS

__all__ = [
    "ADJOINT",
    "BALANCE",
    "CASE",
    "DISTORTION",
    "DYNAMICS",
    "IMPOSED",
    "KINDS",
    "LOADS",
    "OPTICS",
    "PARTIAL",
    "RELEASE",
    "SENSITIVITY",
    "SERIES",
    "SIMULATED_SERIES",
    "SIMULATION",
    "TEMPERATURES",
    "THERMAL",
    "TRADE",
    "UNIT_LOADS",
    "AreaDatasets",
    "AreaPlaces",
    "Dataset",
    "FileKind",
    "GridDatasets",
    "SeriesDatasets",
    "markdown",
]

KINDS = {
    kind.name: kind
    for kind in (
        UNIT_LOADS, DISTORTION, SENSITIVITY, OPTICS, ADJOINT, CASE, SERIES, DYNAMICS, SIMULATION, SIMULATED_SERIES,
        RELEASE, IMPOSED, THERMAL, TEMPERATURES, LOADS, BALANCE, TRADE, PARTIAL,
    )
}  # fmt: skip


def markdown() -> str:
    """The tables as the text of docs/reference/files.md."""
    return document(KINDS.values())
