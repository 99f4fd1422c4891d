"""What is uncertain of a case of the thermal network: the levels of its disturbances."""

from __future__ import annotations

from fnmatch import fnmatchcase
from pathlib import Path

import numpy as np

from tedm_cli.config.cases import CasesConfig
from tedm_cli.config.model.file import ModelConfig
from tedm_cli.errors import ConfigError
from tedm_cli.noise.case_run import CaseResult, judged_outputs
from tedm_cli.noise.disturbances import OutputsByClass
from tedm_cli.noise.network import NetworkNoise
from tedm_cli.noise.requirements import Criteria, in_band
from tedm_cli.noise.selection import listed
from tedm_cli.uncertainty.parameters import Parameters
from tedm_cli.uncertainty.response import Effects, Ratio
from tedm_cli.uncertainty.verdicts import CaseUncertainty, Draws, Judged, uncertainty

_OF_AREAS = "what they do is known of thermal areas, not of the fields of thermal nodes"
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
    result: CaseResult, criteria: Criteria, model: ModelConfig, cases: CasesConfig
) -> CaseUncertainty | None:
    """What uncertain levels of disturbances make of the verdicts of a case; None where none is uncertain.

    An output is a sum over the classes of disturbances with the same levels: to the propagation of levels it is one of
    as many times its columns, those of a class under the disturbances of that class alone.

    """
    source, tables = result.source, cases.uncertainty.disturbance
    assert isinstance(source, NetworkNoise)
    if not tables:
        return None
    names = source.disturbances
    acts = np.array([[any(fnmatchcase(n, p) for p in t.disturbances) for n in names] for t in tables])  # [p, u]
    levels, class_of = np.unique(acts.T, axis=0, return_inverse=True)
    class_of = class_of.reshape(-1)
    own = {table.name for table in tables}
    pairs = {pair: rho for pair, rho in cases.uncertainty.pairs().items() if own.issuperset(pair)}
    parameters = Parameters.of(tuple(table.parameter(table.words) for table in tables), pairs)
    k, c = len(result.areas), len(levels)
    rows = np.tile(result.outputs.rows, (1, c))
    effects = Effects(parameters, np.zeros((len(tables), *rows.shape)), np.repeat(levels.T, k, axis=1))
    f, factor = result.frequency_hz, result.safety_factor
    noise = OutputsByClass(rows, source, class_of, f)
    judged = []
    for (requirement, o), verdict in zip(judged_outputs(criteria, result.outputs, f), result.verdicts, strict=True):
        band = f[in_band(requirement, f)]
        limit = requirement.amplitude(band) / factor
        ratio = Ratio(effects.response(rows[o], o), noise, band, limit)
        judged.append(Judged(verdict.output, verdict.requirement, verdict.ratio, ratio))
    draws = Draws(cases.uncertainty.samples, cases.uncertainty.seed)
    return uncertainty(parameters, judged, factor, draws, _left_out(result.case.id, model, cases))


def _left_out(case_id: str, model: ModelConfig, cases: CasesConfig) -> list[str]:
    """What is uncertain of areas, and why it does not act here."""
    of_model, mesh = model.uncertainty, cases.uncertainty.mesh
    names = [*of_model.names_of_structure, *(name for table in of_model.test_mass for name in table.names())]
    names += [] if mesh is None else ["the error of the mesh"]
    levels = [table.name for table in cases.uncertainty.level]
    told = [f"{listed(names)} in case {case_id}: {_OF_AREAS}"] if names else []
    return told + ([f"{listed(levels)} in case {case_id}: {_LEVELS}"] if levels else [])
