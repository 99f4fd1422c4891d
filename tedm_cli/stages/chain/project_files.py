"""The files of a project's chain, by its configuration: for Make, and for `tedm run`."""

from __future__ import annotations

from pathlib import Path

import tedm_cli
from tedm_cli.areas.configured import area_csv
from tedm_cli.chain.graph import ChainFiles, Named
from tedm_cli.config.cases import CasesConfig, load_cases
from tedm_cli.config.differences import require_parallel
from tedm_cli.config.dynamics.loop import load_dynamics
from tedm_cli.config.halves import halves_of
from tedm_cli.config.model.compensation import compensation_file, compensation_masses
from tedm_cli.config.model.file import load_model
from tedm_cli.config.model.superelement import superelement_files
from tedm_cli.config.optics.layout import load_optics
from tedm_cli.config.project import Project
from tedm_cli.config.symmetry_plane import project_plane
from tedm_cli.config.temperature.tables import table_paths
from tedm_cli.config.thermal.file import load_thermal
from tedm_cli.files.build_folder import (
    ADJOINT_FILE,
    DISTORTION_FILE,
    DYNAMICS_FILE,
    LOADS_FILE,
    OPTICS_FILE,
    SENSITIVITY_FILE,
    THERMAL_FILE,
    UNIT_LOADS_FILE,
    case_file_name,
    series_file_name,
    simulated_series_file_name,
    simulation_file_name,
)
from tedm_cli.results.cases.effects import effect_files
from tedm_cli.results.dynamics.no_loop import why_no_loop
from tedm_cli.results.thermal.case import require_thermal_model
from tedm_cli.stages.temperature_series import series_files
from tedm_cli.stages.uncertain_files import uncertainty_sources


def chain_files(project: Project) -> ChainFiles:
    """What the configuration of a project names.

    Raises
    ------
    ConfigError : a configuration that cannot be read; a project with neither half of the chain, or with requirements
        on the half that it has not, or on a difference of test masses that has no meaning; a case of the thermal
        network without one.
    InputError : a configuration file that is not there.
    """
    _, model = load_model(project.model)
    _, cases = load_cases(project.cases)
    halves = halves_of(project, model)
    halves.require_judgeable(cases.applied_requirements(), where=project.cases)
    require_parallel(project, cases.applied_requirements(), model)
    require_thermal_model(project, cases, *cases.ids)
    dynamics = load_dynamics(project.dynamics)[1]
    beside = Path() if project.dynamics is None else project.dynamics.parent
    compensation = compensation_file(project, model)
    closed = not why_no_loop(project, model)
    build = project.build_dir
    thermal = () if project.thermal is None else (build / THERMAL_FILE,)
    series = {
        table.name: (*series_files(project, table), *(thermal if table.of == "nodes" else ())) for table in cases.series
    }
    return ChainFiles(
        build_dir=build,
        project=project.file.path,
        model=project.model,
        optics=project.optics,
        cases=project.cases,
        dynamics=project.dynamics,
        thermal=project.thermal,
        loads=project.loads,
        bdf=None if model.model.bdf is None else project.resolve(model.model.bdf),
        areas=area_csv(project, model),
        superelements=tuple(superelement_files(project, model.superelement)),
        deck=project.resolve(model.model.deck),
        results=tuple(project.resolve(p) for p in model.model.op2),
        solved_here=all("{build_dir}" in p for p in (model.model.deck, *model.model.op2)),
        unit_loads=build / UNIT_LOADS_FILE,
        distortion=build / DISTORTION_FILE,
        sensitivity=build / SENSITIVITY_FILE if halves.gravity else None,
        read_out=build / OPTICS_FILE if halves.read_out else None,
        adjoint=build / ADJOINT_FILE if halves.gravity else None,
        adjoint_results=tuple(project.resolve(p) for p in model.model.adjoint_op2) if halves.gravity else (),
        case_needs_adjoint=cases.needs_adjoint,
        loop=build / DYNAMICS_FILE if closed else None,
        network=thermal[0] if thermal else None,
        other_loads=build / LOADS_FILE if project.loads is not None and halves.gravity else None,
        gravity_sources=(*([] if compensation is None else [compensation]), *map(project.resolve, model.body_files())),
        effects=tuple(effect_files(project, model)),
        optics_sources=() if project.optics is None else tuple(load_optics(project.optics).matrices),
        dynamics_sources=tuple(beside / name for name in dynamics.file_names()),
        thermal_sources=thermal_sources(project, cases, build / ADJOINT_FILE if halves.gravity else None),
        case_sources=(*cases.tables, *cases.matrices),
        spectra=tuple(table_paths(project, cases)),
        uncertainty_sources=uncertainty_sources(project, model, cases),
        runs=tuple(
            Named(c.id, build / case_file_name(c.id), thermal if c.thermal is not None else ()) for c in cases.cases
        ),
        simulations=tuple(
            Named(c.id, build / simulation_file_name(c.id), thermal if c.thermal is not None else ())
            for c in cases.cases
            if closed
        ),
        series=tuple(Named(n, build / series_file_name(n), tables) for n, tables in series.items()),
        simulated_series=tuple(
            Named(n, build / simulated_series_file_name(n), tables) for n, tables in series.items() if closed
        ),
        older_series=tuple(sorted(build.glob(series_file_name("*")))),
        plane=project_plane(project, model).plane.key,
        ties="".join(f"{b.name}: {b.tie.words}\n" for b in compensation_masses(project, model) if b.tie is not None),
        code=_newest_code(),
    )


def thermal_sources(project: Project, cases: CasesConfig, adjoint: Path | None) -> tuple[Path, ...]:
    """What the thermal model is made from besides its own file; the cases where it has no frequencies of its own."""
    if project.thermal is None:
        return ()
    _, thermal = load_thermal(project.thermal)
    names = [*thermal.file_names(), *(() if thermal.map is None else thermal.map.file_names())]
    return (
        *(project.beside(project.thermal, name) for name in names),
        *((project.cases, *cases.tables) if thermal.disturbances and thermal.frequency is None else ()),
        *((adjoint,) if thermal.map is not None and adjoint is not None else ()),
    )


def _newest_code() -> Path:
    """The file of the program that was changed last: modules, and what the report and the page are made with."""
    package = Path(tedm_cli.__file__).parent
    files = [p for p in package.rglob("*") if p.suffix == ".py" or p.parent.name in ("templates", "page")]
    return max((p for p in files if p.is_file()), key=lambda p: p.stat().st_mtime_ns)
