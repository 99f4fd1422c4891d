"""merge: parts of several result files to unit_loads.h5, distortion.h5 and sensitivity.h5, as of one machine."""

from __future__ import annotations

import functools
import operator
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from tedm_cli import __version__
from tedm_cli.columns import Columns, joined
from tedm_cli.config.model.file import load_model
from tedm_cli.config.project import Project
from tedm_cli.contracts import PARTIAL, UNIT_LOADS
from tedm_cli.errors import InputError
from tedm_cli.files.build_folder import UNIT_LOADS_FILE, partial_file_names
from tedm_cli.files.provenance import InputFile, Provenance
from tedm_cli.files.seal import sha256_of
from tedm_cli.files.store import create, open_checked
from tedm_cli.nastran.displacements import check_numbers
from tedm_cli.nastran.loads.unit_loads import UnitLoad
from tedm_cli.nastran.result_files import open_result_file
from tedm_cli.progress import Step
from tedm_cli.results.parts import Part, read_part
from tedm_cli.stages.model.distortion import DistortionSummary, GivenMotions, build_distortion
from tedm_cli.stages.model.ingest import own_results, write_model
from tedm_cli.stages.model.parts import origin
from tedm_cli.stages.model.read import ModelRead, read_model

#: Writes sensitivity.h5 of the columns of all areas and the files that they are from.
SensitivityOf = Callable[[Columns, Sequence[Path]], Any]
_SHOWN = 5


@dataclass(frozen=True)
class MergeSummary:
    """What was made of how many parts; `sensitivity` as `build-sensitivity` tells it. unused : parts left aside."""

    parts: int
    unit_loads: Path
    distortion: DistortionSummary
    sensitivity: Any
    unused: list[Path]


def merge(project: Project, into: Project, sensitivity_of: SensitivityOf, step: Step) -> MergeSummary:
    """Put the parts in the build folder together, one of each result file of model.op2.

    `into`: the project with the build folder that the files are written to; `sensitivity_of` writes there too.

    Raises
    ------
    InputError : a part that is missing, or was made of other contents of a file than there are now, or by another
        version; areas in no part, or in two.
    PhysicsError : the areas do not add up to the uniform load; what `build_distortion` judges besides.
    """
    load_model(project.model)[1].required_test_masses(project.model)
    results = own_results(project)
    files = [project.build_dir / name for name in partial_file_names(results)]
    _require_all(files, results)
    found = [_open(file) for file in files]
    read = read_model(project, [path for path in results if path.exists()])
    for file, path, (_, made) in zip(files, results, found, strict=True):
        _require_same(file, path, made, origin(project, read))
    unused = sorted(set(project.build_dir.glob("partial_*.h5")) - set(files))
    return assemble(into, read, [part for part, _ in found], files, sensitivity_of, step, unused)


def assemble(
    project: Project,
    read: ModelRead,
    parts: Sequence[Part],
    files: Sequence[Path],
    sensitivity_of: SensitivityOf,
    step: Step,
    unused: Sequence[Path] = (),
) -> MergeSummary:
    """The files of the chain from parts in the order of model.op2, whatever the order in which they were made.

    `files`: those that the parts are from, if there are any.

    Raises
    ------
    InputError, PhysicsError : as `merge`, of parts of this model.
    """
    results = own_results(project)
    places = _places(read, parts, results)
    columns = joined([(place, part.columns) for place, part in zip(places, parts, strict=True)])
    sums = functools.reduce(operator.add, (part.sums for part in parts))
    made_of = [InputFile(path, part.sha256) for path, part in zip(results, parts, strict=True)]
    trace = replace(read.trace, inputs=(*read.trace.inputs, *made_of))
    out = project.build_dir / UNIT_LOADS_FILE
    with create(out, UNIT_LOADS, trace) as writer:
        write_model(writer, read, out)
        single = any(part.single for part in parts)
        writer.write(UNIT_LOADS.RESULTS_PRECISION, "single" if single else "double")
        uniform = next((part.uniform for part in parts if part.uniform is not None), None)
        if uniform is not None and read.loads.uniform is not None:
            writer.write(UNIT_LOADS.UNIFORM_TRANSLATION, uniform.translation)
            writer.write(UNIT_LOADS.UNIFORM_ROTATION, uniform.rotation)
            writer.write(UNIT_LOADS.UNIFORM_LOAD_K, read.loads.uniform.load_K)
    distortion = build_distortion(project, None, step, GivenMotions(columns, sums, files))
    return MergeSummary(len(parts), out, distortion, sensitivity_of(columns, files), list(unused))


def _require_all(files: Sequence[Path], results: Sequence[Path]) -> None:
    missing = [(file, path) for file, path in zip(files, results, strict=True) if not file.exists()]
    if not missing:
        return
    named = "; ".join(f"{file.name} of {path}{_areas_in(path)}" for file, path in missing[:_SHOWN])
    more = f"; and {len(missing) - _SHOWN} more" if len(missing) > _SHOWN else ""
    raise InputError(
        f"{len(missing)} of {len(files)} parts are missing: {named}{more}",
        where=str(files[0].parent),
        hint=f"make {'it' if len(missing) == 1 else 'each'} with `tedm build-sensitivity --partial {missing[0][1]}`",
    )


def _areas_in(path: Path) -> str:
    """What a result file holds, where it is here and can be read."""
    try:
        with open_result_file(path) as (tables, _):
            names = [table.label or f"subcase {table.subcase}" for table in tables]
    except InputError:
        return ""
    return f" (with {', '.join(names[:_SHOWN])}{' ...' if len(names) > _SHOWN else ''})"


def _open(file: Path) -> tuple[Part, Provenance]:
    with open_checked(file, PARTIAL) as opened:
        made_with = str(opened.attributes["tedm_version"])
        part = read_part(opened)
        if made_with != __version__:
            raise InputError(
                f"was made by tedm {made_with}, this is {__version__}",
                where=str(file),
                hint=f"make it again with `tedm build-sensitivity --partial {part.results}`, of one version everywhere",
            )
        return part, opened.provenance()


def _require_same(file: Path, path: Path, made: Provenance, now: Provenance) -> None:
    """Refuse a part that was not made of what the project has now: by sums and names, wherever that was."""

    def sums(of: Provenance, inputs: Sequence[InputFile]) -> list[tuple[str, str]]:
        configs = [(one.path.name, one.sha256) for one in of.configs]
        return configs + [(one.path.name, one.sha256) for one in inputs]

    *theirs, results = made.inputs
    then, present = sums(made, theirs), sums(now, now.inputs)
    again = f"make it again with `tedm build-sensitivity --partial {path}`"
    if then != present:
        changed = [name for name, _ in sorted(set(then) ^ set(present))]
        raise InputError(
            f"is of another model or configuration: its {', '.join(dict.fromkeys(changed))}"
            " is not that of this project",
            where=str(file),
            hint=f"{again}, where the project is the same",
        )
    if path.exists() and sha256_of(path) != results.sha256:
        raise InputError(f"is stale: made from another version of {path}", where=str(file), hint=again)


def _places(read: ModelRead, parts: Sequence[Part], results: Sequence[Path]) -> list[np.ndarray[Any, Any]]:
    """The places of the areas of each part, after every load was found once."""
    loads = {load.label: (place, load) for place, load in enumerate(read.loads.areas)}
    owner: dict[str, Path] = {}
    taken: list[tuple[Path, int, UnitLoad]] = []
    uniform = read.loads.uniform
    for part, path in zip(parts, results, strict=True):
        mine = [(area, subcase, loads[area][1]) for area, subcase in zip(part.areas, part.subcases, strict=True)]
        if part.uniform is not None and uniform is not None:
            mine.append((uniform.label, part.uniform.subcase, uniform))
        for label, subcase, load in mine:
            if label in owner:
                raise InputError(f"area '{label}' was already in {owner[label]}", where=str(path))
            owner[label] = path
            taken.append((path, subcase, load))
    missing = [load for load in read.wanted if load.label not in owner]
    if missing:
        names = ", ".join(f"'{m.label}' (subcase {m.subcase})" for m in missing[:_SHOWN])
        more = f" and {len(missing) - _SHOWN} more" if len(missing) > _SHOWN else ""
        raise InputError(
            f"no displacements for {len(missing)} of {len(read.wanted)} unit loads: {names}{more}",
            where=", ".join(map(str, results)),
            hint="is a result file missing from model.op2, or did the solver stop before its last subcase?",
        )
    if not read.config.model.subcases:
        check_numbers(taken, read.wanted)
    return [np.array([loads[area][0] for area in part.areas], dtype=np.int64) for part in parts]
