"""build-sensitivity --partial: what one result file leaves in the matrices, in a file of its own."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from tedm_cli.arrays import FloatArray, IntArray
from tedm_cli.columns import Reduction, reduced
from tedm_cli.config.model.file import ModelConfig
from tedm_cli.config.optics.layout import load_layout
from tedm_cli.config.project import Project
from tedm_cli.contracts import PARTIAL, UNIT_LOADS
from tedm_cli.errors import UsageError
from tedm_cli.files.build_folder import UNIT_LOADS_FILE, partial_file_names
from tedm_cli.files.in_memory import in_memory
from tedm_cli.files.provenance import InputFile, Provenance, command_line
from tedm_cli.files.seal import sha256_of
from tedm_cli.files.store import Reader, Writer, create
from tedm_cli.gravity.operator import sensitivity_row_labels
from tedm_cli.nastran.displacements import Findings
from tedm_cli.nastran.result_files import require_whole
from tedm_cli.progress import Step
from tedm_cli.results.parts import Part, PartLabels, UniformLoad, write_part
from tedm_cli.stages.common import gravity_files
from tedm_cli.stages.model.distortion import bench_on
from tedm_cli.stages.model.ingest import own_results, write_model
from tedm_cli.stages.model.read import DisplacementsOf, ModelRead, read_model
from tedm_cli.threads import one_thread

#: What displacements are reduced by, from unit_loads.h5 and the rows of optical elements; and what it was made from.
ReductionOf = Callable[[Project, ModelConfig, Reader, IntArray, Step], tuple[Reduction, Any]]


@dataclass(frozen=True, eq=False)
class Prepared:
    """All that a result file is reduced with: no deck and no configuration is needed, and it can be sent elsewhere."""

    displacements: DisplacementsOf
    reduction: Reduction


@dataclass(frozen=True)
class PartSummary:
    """What was made: of which result file, areas in it of all, whether the uniform load is there."""

    path: Path
    results: Path
    areas: list[str]
    of: int
    uniform: bool


def part_of(prepared: Prepared, path: Path, name: str, advance: Callable[[int], None] = lambda _: None) -> Part:
    """Reduce one result file, which the configuration calls `name`: the same bits wherever and whenever it is done.

    `advance` is told of every subcase. A few are held at a time. Products are made by one thread: how many there are
    changes their last bits.

    Raises
    ------
    InputError : what `unit_load_displacements` refuses of one of several files.
    PhysicsError : motions that the rigid elements of the deck do not allow.
    """
    require_whole(path)
    findings = Findings()
    areas: list[str] = []
    uniform: list[tuple[FloatArray, FloatArray]] = []
    whole = prepared.displacements.wanted[-1] if prepared.displacements.uniform else None

    def motions() -> Iterator[tuple[float, bool, FloatArray, FloatArray]]:
        for load, t, r in prepared.displacements.motions([path], findings, whole=False):
            advance(1)
            if load is whole:
                uniform.append((t, r))
            else:
                areas.append(load.label)
                yield load.load_K, load.kind == "mean", t, r

    with ThreadPoolExecutor(1) as beside, one_thread():
        summed = beside.submit(sha256_of, path)  # a third of the time where it is not beside the rest
        columns, sums = reduced(motions(), prepared.reduction)
        digest = summed.result()
    number = {load.label: subcase for _, subcase, load in findings.taken}
    return Part(
        results=name,
        sha256=digest,
        areas=areas,
        subcases=[number[area] for area in areas],
        columns=columns,
        sums=sums,
        uniform=UniformLoad(number[whole.label], *uniform[0]) if whole is not None and uniform else None,
        by_number=bool(findings.by_number),
        single=findings.single,
    )


def build_part(project: Project, given: Path, reduction_of: ReductionOf, step: Step) -> PartSummary:
    """Reduce one of the result files of model.op2 and write its part into the build folder.

    Raises
    ------
    ConfigError : the model has no test masses; what `read_model` refuses.
    UsageError : `given` is none of these files.
    InputError, PhysicsError : what `part_of` refuses.
    """
    place, path = listed(project, given)
    require_whole(path)
    read = read_model(project, [path])
    prepared, labels, _ = prepare(project, read, reduction_of, step)
    part = part_of(prepared, path, read.config.model.op2[place])
    out = project.build_dir / partial_file_names(own_results(project))[place]
    with create(out, PARTIAL, origin(project, read, InputFile(path, part.sha256))) as writer:
        write_part(writer, part, labels)
    return PartSummary(out, path, part.areas, len(read.loads.areas), part.uniform is not None)


def listed(project: Project, given: Path) -> tuple[int, Path]:
    """The place of a file in model.op2, and the file; a copy elsewhere is told by its name."""
    results, here = own_results(project), given.resolve()
    same = [i for i, path in enumerate(results) if path.resolve() == here]
    named = same or [i for i, path in enumerate(results) if path.name == given.name]
    if len(named) == 1:
        return named[0], given
    known = ", ".join(str(path) for path in results[:5]) + (" ..." if len(results) > 5 else "")
    fact = "is one of several of this name" if named else "is no result file of this project"
    raise UsageError(
        f"{given} {fact}", hint=f"{project.model} lists under model.op2: {known}; all parts together are these"
    )


def prepare(
    project: Project, read: ModelRead, reduction_of: ReductionOf, step: Step
) -> tuple[Prepared, PartLabels, Any]:
    """What parts are made with, their labels, and what pulls on the test masses."""
    config = read.config
    config.required_test_masses(project.model)
    layout = None if project.optics is None else load_layout(project.optics)[1]
    bench = bench_on(project, layout, config, read.geometry.grid_id, read.geometry.position_m)

    def write(writer: Writer) -> None:
        write_model(writer, read, project.build_dir / UNIT_LOADS_FILE)
        writer.write(UNIT_LOADS.RESULTS_PRECISION, "single")  # of no displacements

    with in_memory(UNIT_LOADS, (read.config_file,), command_line(), write) as unit:
        reduction, pulls = reduction_of(project, config, unit, bench.rows, step)
    labels = PartLabels(
        grid_id=read.geometry.grid_id,
        levers=reduction.levers,
        rows=sensitivity_row_labels(config.test_masses()),
        optics=bench.names,
        ties=read.ties.block,
        areas=read.table,
        area_id=np.array([a.subcase for a in read.loads.areas]),
    )
    return Prepared(read.displacements, reduction), labels, pulls


def origin(project: Project, read: ModelRead, *results: InputFile) -> Provenance:
    """What a part of a model is made from: all that the matrices are, and then the result file."""
    layout = () if project.optics is None else (load_layout(project.optics)[0],)
    more = [InputFile(path, sha256_of(path)) for path in gravity_files(project, read.config)]
    return replace(read.trace, configs=(*read.trace.configs, *layout), inputs=(*read.trace.inputs, *more, *results))
