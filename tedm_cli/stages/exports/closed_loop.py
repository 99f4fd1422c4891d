"""export-state-space --loop: the drag-free loop as a linear system with named inputs and outputs."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from tedm_cli.contracts import DYNAMICS
from tedm_cli.errors import InputError
from tedm_cli.exports.closed_loop import NOTES, closed_loop_matrices
from tedm_cli.exports.write import write_matrices
from tedm_cli.files.build_folder import DYNAMICS_FILE, require_up_to_date
from tedm_cli.files.store import open_checked
from tedm_cli.matrix_files.named import Format
from tedm_cli.stages.exports.case import destination

STEM = "closed_loop_state_space"


@dataclass(frozen=True)
class ExportedLoop:
    """The files, and the size of the system in them."""

    paths: tuple[Path, ...]
    states: int
    inputs: int
    outputs: int


def export_closed_loop(build_dir: Path, fmt: Format, output: Path | None, number: int = 1) -> ExportedLoop:
    """Write the loop of dynamics.h5, one of `number` systems that go to `output`.

    Raises
    ------
    UsageError : one file for several systems.
    InputError : dynamics.h5 is missing or stale, or its controller is sampled.
    """
    place = destination(build_dir, STEM, fmt, output, number)
    path = build_dir / DYNAMICS_FILE
    if not path.exists():
        raise InputError("no such file", where=str(path), hint="make it with `tedm build-dynamics`, or `tedm run`")
    with open_checked(path, DYNAMICS) as file:
        require_up_to_date(file)
        matrices = closed_loop_matrices(file)
    paths = write_matrices(*place, matrices, fmt, NOTES)
    sizes = {m.name: m.values.shape for m in matrices}
    return ExportedLoop(tuple(paths), sizes["A"][0], sizes["B"][1], sizes["C"][0])
