"""What figures and report are made from: the results of a build folder, open and found to fit together."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from tedm_cli.config.cases import CasesConfig, load_cases
from tedm_cli.config.dynamics.loop import load_dynamics
from tedm_cli.config.halves import halves_of
from tedm_cli.config.model.file import load_model
from tedm_cli.config.optics.layout import load_layout
from tedm_cli.config.project import Project
from tedm_cli.config.thermal.file import load_thermal
from tedm_cli.contracts import (
    ADJOINT,
    CASE,
    DISTORTION,
    DYNAMICS,
    IMPOSED,
    OPTICS,
    SENSITIVITY,
    SERIES,
    SIMULATED_SERIES,
    SIMULATION,
    THERMAL,
)
from tedm_cli.errors import InputError
from tedm_cli.files.build_folder import (
    ADJOINT_FILE,
    DISTORTION_FILE,
    DYNAMICS_FILE,
    IMPOSED_FILE,
    OPTICS_FILE,
    SENSITIVITY_FILE,
    THERMAL_FILE,
    case_file_name,
    require_areas_and_more,
    require_configuration,
    require_input,
    require_same_areas,
    require_same_input,
    series_file_name,
    simulated_series_file_name,
    simulation_file_name,
)
from tedm_cli.files.provenance import ConfigFile, InputFile, input_files
from tedm_cli.files.store import Reader, open_checked
from tedm_cli.noise.areas import AreaTable
from tedm_cli.noise.requirements import AppliedRequirement
from tedm_cli.optics.layout import OpticalLayout
from tedm_cli.results.areas import read_areas
from tedm_cli.results.dynamics.no_loop import why_no_loop
from tedm_cli.results.thermal.case_shares import of_network
from tedm_cli.results.thermal.file import require_thermal
from tedm_cli.results.wording import GRAVITY_ALONE, READ_OUT_ALONE, count

_HALVES = (SENSITIVITY_FILE, OPTICS_FILE)


@dataclass(frozen=True)
class Matrices:
    """The file with the outputs of one half of the chain per kelvin: open, and the hash of what it holds."""

    reader: Reader
    file: InputFile

    @property
    def source(self) -> str:
        """Name and hash, as figures bear them."""
        return f"{self.file.path.name} {self.file.sha256}"


@dataclass(frozen=True)
class ReadOutMatrices(Matrices):
    """optics.h5, and the layout that it was made from."""

    layout: OpticalLayout


@dataclass(frozen=True)
class Results:
    """Results that fit together, open, what they were made with, and the hashes of what is drawn.

    `gravity` is None of a project without test masses, `read_out` of one without optics; one of them is there. `series`
    are those of the configuration that have been run, by name. `no_loop` says why there can be no drag-free loop, and
    is empty where there can. `dynamics` is None where there can be none, or where the loop or its cases have not been
    made; `simulations` are the cases that have, in the order of the configuration, `simulated_series` the series that
    have been through the loop, by name. `imposed`, `adjoint` and `thermal` are None where they have not been
    made.
    """

    distortion: Reader
    distortion_file: InputFile
    gravity: Matrices | None
    read_out: ReadOutMatrices | None
    cases: list[Reader]
    case_files: list[InputFile]
    config: CasesConfig
    series: dict[str, Reader]
    series_files: dict[str, InputFile]
    no_loop: str
    dynamics: Reader | None
    dynamics_file: InputFile | None
    simulations: list[Reader]
    simulation_files: list[InputFile]
    imposed: Reader | None
    imposed_file: InputFile | None
    adjoint: Reader | None
    adjoint_file: InputFile | None
    thermal: Reader | None
    thermal_file: InputFile | None
    simulated_series: dict[str, Reader]
    simulated_series_files: dict[str, InputFile]
    loop_requirements: list[AppliedRequirement]

    @property
    def matrices(self) -> list[Matrices]:
        """The halves of the chain that there are, in its order."""
        return [m for m in (self.gravity, self.read_out) if m is not None]

    @property
    def half(self) -> str:
        """In a sentence what is not there of a project with one half of the chain; empty of one with both."""
        return GRAVITY_ALONE if self.read_out is None else READ_OUT_ALONE if self.gravity is None else ""

    @property
    def areas(self) -> AreaTable:
        """The thermal areas, which are the same in all files."""
        return read_areas(self.matrices[0].reader)

    @property
    def requirement_titles(self) -> dict[str, str]:
        """Plain titles of the requirements that have one, by name: what the configuration calls them, or the preset."""
        applied = [*self.config.applied_requirements(), *self.loop_requirements]
        return {r.requirement.name: r.requirement.title for r in applied if r.requirement.title}


@contextlib.contextmanager
def open_results(project: Project) -> Iterator[Results]:
    """Open distortion, sensitivities, optics and all cases of the configuration; refuse what is missing or unfit.

    Sensitivities and optics are those that the project has; a file of a half that it has no longer is passed over.
    """
    _, model = load_model(project.model)
    halves = halves_of(project, model)
    file, config = load_cases(project.cases)
    build = project.build_dir
    paths = [build / case_file_name(i) for i in config.ids]
    missing = [(i, p) for i, p in zip(config.ids, paths, strict=True) if not p.exists()]
    if missing:
        what = missing[0][0] if len(missing) == 1 else "all"
        names = ", ".join(i for i, _ in missing)
        raise InputError(
            f"no such file; {count(len(missing), 'case')} of {project.cases} not run yet: {names}",
            where=str(missing[0][1]),
            hint=f"make it with `tedm run-case {what}`, or `tedm run`",
        )
    with contextlib.ExitStack() as stack:
        gravity = _gravity(project, stack) if halves.gravity else None
        read_out = _read_out(project.optics, build / OPTICS_FILE, stack) if project.optics is not None else None
        matrices: list[Matrices] = [m for m in (gravity, read_out) if m is not None]
        require_same_input(DISTORTION_FILE, *(m.reader for m in matrices))
        distortion = stack.enter_context(open_checked(build / DISTORTION_FILE, DISTORTION))
        distortion_file = input_files([build / DISTORTION_FILE])[0]
        for made in matrices:
            require_input(made.reader, distortion_file)
        used = [m.file for m in matrices]
        adjoint = None if gravity is None else _adjoint(build / ADJOINT_FILE, used, stack)
        adjoint_file = None if adjoint is None else input_files([adjoint.path])[0]
        thermal = _thermal(project, stack)
        cases = []
        for case_id, path in zip(config.ids, paths, strict=True):
            case = stack.enter_context(open_checked(path, CASE))
            made_of = [*used_by_case(used, adjoint_file, config, case_id), *_network(build, config, case_id)]
            require_current(case, case_id, made_of, [file])
            cases.append(case)
        series = {}
        for name in (table.name for table in config.series if (build / series_file_name(table.name)).exists()):
            series[name] = stack.enter_context(open_checked(build / series_file_name(name), SERIES))
            hint = f"rebuild it with `tedm run-series {name}`, or delete it"
            _require_made_from(series[name], [*used, *nodes_of_series(project, config, name)], [file], hint)
        imposed = None
        if gravity is not None and (build / IMPOSED_FILE).exists():
            imposed = stack.enter_context(open_checked(build / IMPOSED_FILE, IMPOSED))
            _require_made_from(imposed, [gravity.file], [], f"rebuild it with `{IMPOSED.made_by}`, or delete it")
        no_loop = why_no_loop(project, model)
        loop = _Loop(None, [], {}, []) if no_loop else _open_dynamics(project, config, used, adjoint_file, file, stack)
        of_areas = {table.name for table in config.series if table.of == "areas"}
        in_time = [reader for found in (series, loop.series) for name, reader in found.items() if name in of_areas]
        require_same_areas(distortion, *(m.reader for m in matrices), *in_time)
        require_areas_and_more(distortion, *(case for case in (*cases, *loop.simulations) if not of_network(case)))
        yield Results(
            distortion, distortion_file, gravity, read_out, cases, list(input_files(paths)),
            config, series, {name: input_files([reader.path])[0] for name, reader in series.items()},
            no_loop, loop.dynamics, None if loop.dynamics is None else input_files([loop.dynamics.path])[0],
            loop.simulations, list(input_files([reader.path for reader in loop.simulations])),
            imposed, None if imposed is None else input_files([imposed.path])[0],
            adjoint, adjoint_file, thermal, None if thermal is None else input_files([thermal.path])[0],
            loop.series, {name: input_files([reader.path])[0] for name, reader in loop.series.items()},
            loop.requirements,
        )  # fmt: skip


def _gravity(project: Project, stack: contextlib.ExitStack) -> Matrices:
    """The sensitivities; refused when they were made with another model."""
    path = project.build_dir / SENSITIVITY_FILE
    reader = stack.enter_context(open_checked(path, SENSITIVITY))
    require_configuration(reader, project.model)
    return Matrices(reader, input_files([path])[0])


def _read_out(layout_file: Path, path: Path, stack: contextlib.ExitStack) -> ReadOutMatrices:
    """The optical matrices and the project's layout; refused when they were made with another one."""
    reader = stack.enter_context(open_checked(path, OPTICS))
    _, layout = load_layout(layout_file)
    require_configuration(reader, layout_file)
    return ReadOutMatrices(reader, input_files([path])[0], layout)


def _adjoint(path: Path, used: Sequence[InputFile], stack: contextlib.ExitStack) -> Reader | None:
    """What every temperature does, where it has been made; refused where it is of other matrices than there are."""
    if not path.exists():
        return None
    reader = stack.enter_context(open_checked(path, ADJOINT))
    for one in used:
        require_input(reader, one)
    return reader


def _thermal(project: Project, stack: contextlib.ExitStack) -> Reader | None:
    """The thermal model, where the project has one and it has been made; refused where it is of other files."""
    path = project.build_dir / THERMAL_FILE
    if project.thermal is None or not path.exists():
        return None
    reader = stack.enter_context(open_checked(path, THERMAL))
    require_thermal(reader, project, load_thermal(project.thermal)[1])
    used = {config.path.name for config in reader.provenance().configs}
    for other in (project.model, project.cases):  # where it has a map, and the frequencies of the cases
        if other.name in used:
            require_configuration(reader, other)
    return reader


@dataclass(frozen=True)
class _Loop:
    """What has been made of the drag-free loop, open."""

    dynamics: Reader | None
    simulations: list[Reader]
    series: dict[str, Reader]
    requirements: list[AppliedRequirement]


def _open_dynamics(
    project: Project,
    cases: CasesConfig,
    used: Sequence[InputFile],
    adjoint: InputFile | None,
    config: ConfigFile,
    stack: contextlib.ExitStack,
) -> _Loop:
    """The loop, the cases and series in it, as far as they have been made; refused where not from what is there.

    `used` are the sensitivities and the optics, `config` is the cases file.
    """
    path = project.build_dir / DYNAMICS_FILE
    paths = {i: path.with_name(simulation_file_name(i)) for i in cases.ids}
    paths = {i: p for i, p in paths.items() if p.exists()}
    if not path.exists() or not paths:
        return _Loop(None, [], {}, [])
    own, dynamics_config = load_dynamics(project.dynamics)
    configs = [own] if own else []
    tables = [own.path.parent / name for name in dynamics_config.file_names()] if own else []
    dynamics = stack.enter_context(open_checked(path, DYNAMICS))
    used = [*used, *input_files(tables)]
    hint = f"rebuild it with `{DYNAMICS.made_by}`, or `tedm run`"
    _require_made_from(dynamics, used, configs, hint)
    if not configs and (named := dynamics.provenance().configs):
        raise InputError(
            f"is stale: made from {named[0].path}, which the project no longer names", where=str(path), hint=hint
        )
    used = [*used[: len(_HALVES)], *input_files([path])]
    simulations = []
    for case_id, made in paths.items():
        simulations.append(stack.enter_context(open_checked(made, SIMULATION)))
        made_of = [*used_by_case(used, adjoint, cases, case_id), *_network(project.build_dir, cases, case_id)]
        require_current(simulations[-1], case_id, made_of, [*configs, config])
    series = {}
    for name in (table.name for table in cases.series):
        made = path.with_name(simulated_series_file_name(name))
        if made.exists():
            series[name] = stack.enter_context(open_checked(made, SIMULATED_SERIES))
            hint = f"rebuild it with `{SIMULATED_SERIES.made_by} {name}`, or delete it"
            made_of = [*used, *nodes_of_series(project, cases, name)]
            _require_made_from(series[name], made_of, [*configs, config], hint)
    return _Loop(dynamics, simulations, series, dynamics_config.applied_requirements())


def nodes_of_series(project: Project, config: CasesConfig, name: str) -> list[InputFile]:
    """thermal.h5, where a series is of its nodes and it is there."""
    of = next(table.of for table in config.series if table.name == name)
    path = project.build_dir / THERMAL_FILE
    return list(input_files([path])) if of == "nodes" and path.exists() else []


def used_by_case(
    used: Sequence[InputFile], adjoint: InputFile | None, config: CasesConfig, case_id: str
) -> list[InputFile]:
    """What a case is made from: what all are, and the adjoint where the case takes something of it."""
    return [*used, *([adjoint] if adjoint is not None and config.within(case_id) else [])]


def _network(build: Path, config: CasesConfig, case_id: str) -> list[InputFile]:
    """The thermal network that a case is made from, where it is of one that is there."""
    path = build / THERMAL_FILE
    return list(input_files([path])) if config.case_table(case_id).thermal and path.exists() else []


def require_current(case: Reader, case_id: str, used: Sequence[InputFile], configs: Sequence[ConfigFile]) -> None:
    """Refuse a case that was run on other results or with other configurations, or that is another case.

    It is a case by itself or in closed loop.
    """
    hint = f"rebuild it with `{case.kind.made_by} {case_id}`"
    _require_made_from(case, used, configs, f"{hint}, or all cases with `{case.kind.made_by} all`")
    if case.string(CASE.CASE_ID) != case_id:
        raise InputError(f"holds case {case.string(CASE.CASE_ID)}, not {case_id}", where=str(case.path), hint=hint)


def _require_made_from(file: Reader, used: Sequence[InputFile], configs: Sequence[ConfigFile], hint: str) -> None:
    """Refuse a file that was made from other inputs, or with other configurations, than those there now.

    And one that was made from both halves of the chain, when the project has one of them left.
    """
    provenance = file.provenance()
    names = {i.path.name for i in used}
    for item in provenance.inputs:
        if item.path.name in _HALVES and item.path.name not in names:
            fact = f"is stale: made from {item.path.name}, which is no part of the project any more"
            raise InputError(fact, where=str(file.path), hint=hint)
    made_from = {(i.path.name, i.sha256) for i in provenance.inputs}
    made_from |= {(c.path.name, c.sha256) for c in provenance.configs}
    now = {i.path: i.sha256 for i in used} | {c.path: c.sha256 for c in configs}
    for path, sha256 in now.items():
        if (path.name, sha256) not in made_from:
            raise InputError(f"is stale: not made from {path} as it is now", where=str(file.path), hint=hint)
