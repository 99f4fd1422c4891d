"""What is uncertain of a case of the thermal network: materials, thicknesses, positions, and levels of disturbances."""

from __future__ import annotations

from fnmatch import fnmatchcase
from pathlib import Path

import numpy as np

from tedm_cli.arrays import FloatArray
from tedm_cli.config.cases import CasesConfig
from tedm_cli.config.model.file import ModelConfig
from tedm_cli.config.project import Project
from tedm_cli.config.uncertainty import AXES
from tedm_cli.contracts import SENSITIVITY, THERMAL
from tedm_cli.errors import ConfigError
from tedm_cli.files.build_folder import ADJOINT_FILE, SENSITIVITY_FILE, THERMAL_FILE
from tedm_cli.files.store import Reader, open_checked
from tedm_cli.noise.case_run import CaseResult, judged_outputs
from tedm_cli.noise.differences import rows_of
from tedm_cli.noise.disturbances import OutputsByClass
from tedm_cli.noise.network import NetworkNoise
from tedm_cli.noise.requirements import Criteria, in_band
from tedm_cli.noise.selection import listed
from tedm_cli.results.adjoint.derivatives import (
    Derivatives,
    read_node_derivatives,
    read_node_positions,
    read_position_rows,
)
from tedm_cli.results.outputs import read_outputs
from tedm_cli.stages.noise.uncertainty import NO_ADJOINT, Found, add_structure, among, read_of_areas
from tedm_cli.uncertainty.parameters import Parameters
from tedm_cli.uncertainty.response import Effects, Ratio
from tedm_cli.uncertainty.verdicts import CaseUncertainty, Draws, Judged, uncertainty

_NO_CHANGES = (
    "{path} has no changes by them of outputs by thermal nodes: `tedm build-thermal` makes them where the embedded"
    " solver finds the displacements under the nodes"
)
_NO_POSITIONS = "{path} has none of them: `tedm build-sensitivity`, then `tedm build-thermal`, make them"
_OF_MESH = "the other mesh tells of thermal areas, not of the fields of thermal nodes"
_LEVELS = "levels of areas, where temperatures follow disturbances ([[uncertainty.disturbance]])"


def require_disturbances(source: NetworkNoise, cases: CasesConfig, where: Path) -> None:
    """Raise `ConfigError` for patterns that no disturbance of a case matches; `where`: the cases file."""
    names = source.disturbances
    problems = [
        (f"uncertainty.disturbance[{i}].disturbances", f"no disturbance matches {pattern!r}; there are {listed(names)}")
        for i, table in enumerate(cases.uncertainty.disturbance)
        for pattern in table.disturbances
        if not any(fnmatchcase(name, pattern) for name in names)
    ]
    if problems:
        raise ConfigError(problems, where=str(where))


def of_network(
    project: Project, result: CaseResult, criteria: Criteria, model: ModelConfig, cases: CasesConfig
) -> CaseUncertainty | None:
    """What uncertain materials, thicknesses, positions and levels of disturbances make of the verdicts of a case.

    None where nothing of these is uncertain. An output is a sum over the classes of disturbances with the same levels:
    to the propagation of levels it is one of as many times its columns, those of a class under the disturbances of that
    class alone.

    Raises
    ------
    ConfigError : as `uncertain`. InputError : adjoint.h5 is stale.
    """
    source, tables = result.source, cases.uncertainty.disturbance
    assert isinstance(source, NetworkNoise)
    found, left_out = _of_model(project, result, model)
    left_out += _left_out(result.case.id, cases)
    if not tables and not found.items:
        return None
    names = source.disturbances
    acts = np.array([[any(fnmatchcase(n, p) for p in t.disturbances) for n in names] for t in tables], dtype=bool)
    levels, class_of = np.unique(acts.reshape(len(tables), len(names)).T, axis=0, return_inverse=True)
    class_of = class_of.reshape(-1)
    of_levels = {table.name for table in tables}
    parameters = Parameters.of(
        tuple(found.items), among(model.uncertainty.pairs(), {item.name for item in found.items})
    )
    parameters += Parameters.of(
        tuple(table.parameter(table.words) for table in tables), among(cases.uncertainty.pairs(), of_levels)
    )
    k, c = len(result.areas), len(levels)
    rows = np.tile(result.outputs.rows, (1, c))
    none = np.zeros((len(found.items), c * k), dtype=bool)
    effects = Effects(
        parameters,
        np.concatenate([np.tile(found.changes(), (1, 1, c)), np.zeros((len(tables), *rows.shape))]),
        np.concatenate([none, np.repeat(levels.T, k, axis=1)]),
    )
    f, factor = result.frequency_hz, result.safety_factor
    noise = OutputsByClass(rows, source, class_of, f)
    judged = []
    for (requirement, o), verdict in zip(judged_outputs(criteria, result.outputs, f), result.verdicts, strict=True):
        band = f[in_band(requirement, f)]
        limit = requirement.amplitude(band) / factor
        ratio = Ratio(effects.response(rows[o], o), noise, band, limit)
        judged.append(Judged(verdict.output, verdict.requirement, verdict.ratio, ratio))
    draws = Draws(cases.uncertainty.samples, cases.uncertainty.seed)
    return uncertainty(parameters, judged, factor, draws, left_out)


def _of_model(project: Project, result: CaseResult, model: ModelConfig) -> tuple[Found, list[str]]:
    """Uncertain materials, thicknesses and positions, and what of them does not act, and why."""
    found, of_model = Found(result.outputs), model.uncertainty
    left_out: list[str] = []
    if not (of_model.of_structure or of_model.test_mass):
        return found, left_out
    path = project.build_dir / THERMAL_FILE
    with open_checked(path, THERMAL) as file:
        if of_model.of_structure:
            by = _derivatives(project, file, result, model)
            if isinstance(by, str):
                left_out.append(f"{listed(of_model.names_of_structure)} in case {result.case.id}: {by}")
            else:
                add_structure(found, model, by, project.model)
        positions = read_node_positions(file)
    if of_model.test_mass and (positions is None or not _add_positions(found, project, result, model, positions)):
        names = [name for table in of_model.test_mass for name in table.names()]
        left_out.append(f"{listed(names)} in case {result.case.id}: {_NO_POSITIONS.format(path=path)}")
    return found, left_out


def _derivatives(project: Project, file: Reader, result: CaseResult, model: ModelConfig) -> Derivatives | str:
    """By the columns of a case, of thermal.h5 by nodes, of adjoint.h5 by areas behind them; or why there are none."""
    if not model.test_mass:
        return NO_ADJOINT
    outputs = read_outputs(project)
    of_areas = read_of_areas(project, project.build_dir / ADJOINT_FILE, outputs)
    if isinstance(of_areas, str):
        return of_areas
    names = outputs.areas.name.tolist()
    n = len(file.strings(THERMAL.MAP_NODE))
    left = [names.index(name) for name in result.areas.name.tolist()[n:]]
    by = read_node_derivatives(file, of_areas, left)
    return _NO_CHANGES.format(path=file.path) if by is None else by


def _add_positions(
    found: Found, project: Project, result: CaseResult, model: ModelConfig, positions: dict[str, FloatArray]
) -> bool:
    """Positions of test masses by the changes [6, n] of thermal.h5; whether it has them all."""
    labels = result.outputs.labels
    single = [label for label in labels if "-" not in label]
    areas = read_outputs(project).areas.name.tolist()
    with open_checked(project.build_dir / SENSITIVITY_FILE, SENSITIVITY) as file:
        for table in model.uncertainty.test_mass:
            for axis, name in zip(table.axes, table.names(), strict=True):
                change = positions.get(f"{table.test_mass}_{axis}")
                of_areas = read_position_rows(file, table.test_mass, AXES.index(axis))
                if change is None or of_areas is None:
                    return False
                n = change.shape[1]
                left = [areas.index(area) for area in result.areas.name.tolist()[n:]]
                own = [
                    label for label in file.strings(SENSITIVITY.ROW_LABEL) if label.startswith(f"{table.test_mass}_")
                ]
                known = {label: np.zeros(n + len(left)) for label in single}
                known |= {o: np.concatenate([row, of_areas[o][left]]) for o, row in zip(own, change, strict=True)}
                item = table.parameter(f"{table.test_mass} along {axis}", name)
                found.add(item, rows_of(labels, {label: known[label] for label in single}))
    return True


def _left_out(case_id: str, cases: CasesConfig) -> list[str]:
    """What is uncertain of areas alone, and why it does not act here."""
    levels = [table.name for table in cases.uncertainty.level]
    told = [f"the error of the mesh in case {case_id}: {_OF_MESH}"] if cases.uncertainty.mesh is not None else []
    return told + ([f"{listed(levels)} in case {case_id}: {_LEVELS}"] if levels else [])
