"""build-sensitivity --no-store: each result file is read once, in this process, and no displacements are kept."""

from __future__ import annotations

from typing import Any

from tedm_cli.config.project import Project
from tedm_cli.nastran.result_files import require_whole
from tedm_cli.progress import Step, counter
from tedm_cli.stages.model.ingest import own_results
from tedm_cli.stages.model.merge import MergeSummary, SensitivityOf, assemble
from tedm_cli.stages.model.parts import ReductionOf, part_of, prepare
from tedm_cli.stages.model.read import read_model


def reduce_here(project: Project, reduction_of: ReductionOf, sensitivity_of: Any, step: Step) -> MergeSummary:
    """The files of the chain from all result files of model.op2, one after the other.

    `sensitivity_of(pulls)` is the `SensitivityOf` of what was summed for the operator.

    Raises
    ------
    ConfigError, InputError, PhysicsError : what `read_model`, `part_of` and `assemble` refuse.
    """
    results = own_results(project)
    for path in results:
        require_whole(path)
    read = read_model(project, results)
    prepared, _, pulls = prepare(project, read, reduction_of, step)
    advance = counter(step, len(read.wanted), "reducing results")
    parts = [part_of(prepared, path, name, advance) for path, name in zip(results, read.config.model.op2, strict=True)]
    finish: SensitivityOf = sensitivity_of(pulls)
    return assemble(project, read, parts, (), finish, step)
