"""run-case: sensitivities and temperature noise to spectra, bounds, verdicts and contributions of one case."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tedm_cli.arrays import FloatArray, IndexArray
from tedm_cli.config.cases import CasesConfig, load_cases
from tedm_cli.config.differences import require_parallel
from tedm_cli.config.halves import halves_of
from tedm_cli.config.model.file import ModelConfig, load_model
from tedm_cli.config.project import Project
from tedm_cli.config.temperature.spectrum import SpectrumColumns
from tedm_cli.config.temperature.tables import table_paths, temperature_model
from tedm_cli.config.uncertainty import MeshDeviation
from tedm_cli.contracts import CASE
from tedm_cli.errors import ConfigError, InputError, TedmError
from tedm_cli.files.build_folder import case_file_name, provenance
from tedm_cli.files.provenance import ConfigFile
from tedm_cli.files.store import create
from tedm_cli.noise.case_run import CaseResult, case_of, judged_outputs
from tedm_cli.noise.correlation import Correlation, CorrelationCase, correlation
from tedm_cli.noise.log_spectrum import require_speckit
from tedm_cli.noise.network import NetworkNoise
from tedm_cli.noise.propagation import TemperatureNoise
from tedm_cli.noise.requirements import REFERENCE_HZ, Criteria
from tedm_cli.noise.resemblance import resemblance
from tedm_cli.noise.sources import AnySource
from tedm_cli.noise.temperature import TemperatureModel
from tedm_cli.progress import Step
from tedm_cli.results.adjoint.within import CaseGradients, and_spectra, case_gradients, with_gradients
from tedm_cli.results.cases.file import write_case
from tedm_cli.results.cases.uncertainty import write_uncertainty
from tedm_cli.results.outputs import ModelOutputs, read_outputs
from tedm_cli.results.thermal.case import thermal_columns
from tedm_cli.results.thermal.comparison import Comparison, comparison, write_comparison
from tedm_cli.stages.noise.network_uncertainty import of_network, require_disturbances
from tedm_cli.stages.noise.realisation import Realised, realise_case, write_realisation
from tedm_cli.stages.noise.uncertainty import Uncertain, uncertain
from tedm_cli.uncertainty.verdicts import CaseUncertainty

_REFUSED_TOO = "; refused too: "


@dataclass(frozen=True, eq=False)
class ReadyCase:
    """A case that fits the model: its outputs, without differences and with all its columns, and their noise.

    sources : files that it alone is made from. area : [k], of a case of the thermal network the area of the model that
    each column is in, -1 for none; None of others.
    """

    case: CorrelationCase
    outputs: ModelOutputs
    source: AnySource
    sources: tuple[Path, ...]
    area: IndexArray | None = None


@dataclass(frozen=True, eq=False)
class CaseSetting:
    """What all cases of a project share: `file`, the cases file, as `config`; the outputs, and what judges them.

    `temperature` is of the areas of the outputs, which are the model's; frequency_hz : [F]. gradients : within areas,
    as far as the cases have them. `uncertain`: what is; None where nothing is.
    """

    project: Project
    model: ModelConfig
    file: ConfigFile
    config: CasesConfig
    outputs: ModelOutputs
    temperature: TemperatureModel
    frequency_hz: FloatArray
    criteria: Criteria
    gradients: CaseGradients
    uncertain: Uncertain | None

    @property
    def all_outputs(self) -> ModelOutputs:
        """The outputs and their differences, of the model's areas."""
        return self.outputs.with_differences(self.criteria.requirements)

    def ready(self, case: CorrelationCase) -> ReadyCase:
        """A case with the columns of what it has beside the model's areas, or with thermal nodes in their place.

        Raises what `thermal_columns` does, `require_disturbances`, and `noise.correlation.correlation`.
        """
        if case.thermal:
            found = thermal_columns(self.project, self.config, case.id, self.outputs, self.temperature)
            require_disturbances(found.noise, self.config, self.project.cases)
            return ReadyCase(case, found.outputs, found.noise, found.sources, found.area)
        gradients = self.gradients.of(case.id)
        outputs, temperature = with_gradients(self.outputs, gradients), and_spectra(self.temperature, gradients)
        source = TemperatureNoise(temperature, correlation(case, outputs.areas, temperature.heard))
        return ReadyCase(case, outputs, source, tuple(self.gradients.sources(case.id)))

    def run(self, ready: ReadyCase) -> CaseResult:
        """One case, its outputs with their differences."""
        outputs = ready.outputs.with_differences(self.criteria.requirements)
        return case_of(ready.case, outputs, ready.source, self.frequency_hz, self.criteria)

    def comparison(self, ready: ReadyCase, result: CaseResult) -> Comparison | None:
        """A case of the thermal network beside the assumed ones at 1 mHz; None of other cases.

        Without cases that do not fit or that silence some of the nodes, and without diagnostic ones.
        """
        if ready.area is None or not isinstance(ready.source, NetworkNoise):
            return None
        within = np.flatnonzero(ready.area >= 0)
        area = ready.area[within]
        at = np.array([REFERENCE_HZ])
        found = resemblance(
            ready.source.correlation_at(REFERENCE_HZ).matrix()[np.ix_(within, within)],
            area,
            self._assumed(),
            REFERENCE_HZ,
            ready.outputs.areas.group_by_unit[within].tolist(),
            ready.source.amplitudes(at)[within, 0],
            self.temperature.amplitudes(at)[area, 0],
        )
        return comparison(result, ready.sources[0], found)

    def _assumed(self) -> dict[str, Correlation]:
        """The cases of areas that fit the model and are not diagnostic, by id."""
        found = {}
        for case_id in self.config.ids_of_areas:
            try:
                case = self.config.case(case_id, where=str(self.project.cases))
                assumed = correlation(case, self.outputs.areas, self.temperature.heard)
            except TedmError:  # told where that case is run
                continue
            if case.role != "diagnostic":
                found[case_id] = assumed
        return found

    def uncertainty(self, result: CaseResult) -> CaseUncertainty | None:
        """How sure the verdicts of a case are; None where nothing is uncertain, or nothing judged.

        Of a case of the thermal network: as far as levels of its disturbances are uncertain.
        """
        if not result.verdicts:
            return None
        if result.case.thermal:
            return of_network(result, self.criteria, self.model, self.config)
        if self.uncertain is None:
            return None
        return self.uncertain.of_case(result, self.criteria)


def case_setting(
    project: Project,
    file: ConfigFile,
    config: CasesConfig,
    tables: Mapping[str, SpectrumColumns] | None = None,
    compare: MeshDeviation | None = None,
) -> CaseSetting:
    """Gather what cases need from the build folder and the configuration, and hold these against each other.

    `tables` are spectra that the configuration names and that are in no file; `compare` is another mesh, in place of
    the one that it may name.

    Raises
    ------
    ConfigError : a requirement that no output of the project fits, a temperature of areas that are not there.
    InputError : a file of the build folder is missing or stale, a table of spectra does not fit the areas.

    And what `uncertain` raises.
    """
    if config.realisation is not None and config.realisation.spectrum == "log":
        require_speckit()
    criteria = config.criteria()
    model = load_model(project.model)[1]
    halves_of(project, model).require_judgeable(criteria.requirements, where=project.cases)
    require_parallel(project, criteria.requirements, model)
    outputs = read_outputs(project)
    temperature = temperature_model(project, config, outputs.areas, tables)
    frequency = config.frequency_hz()
    judged = outputs.with_differences(criteria.requirements)
    try:  # what is wrong with requirements is wrong in every case
        judged_outputs(criteria, judged, frequency)
    except ConfigError as error:
        raise ConfigError(error.problems, where=str(project.cases)) from None
    gradients = case_gradients(project, config, outputs, tables)
    found = uncertain(project, model, config, judged, gradients, compare)
    return CaseSetting(project, model, file, config, outputs, temperature, frequency, criteria, gradients, found)


@dataclass(frozen=True, eq=False)
class CaseDone:
    """A case that was run: its file, its result, and with it a realisation and how sure it is, where these are.

    comparison : of a case of the thermal network, with the assumed ones.
    """

    path: Path
    result: CaseResult
    realised: Realised | None
    uncertainty: CaseUncertainty | None
    comparison: Comparison | None = None


def run_cases(
    project: Project,
    case_ids: Sequence[str],
    output: Path | None,
    step: Step,
    done: Callable[[CaseDone], None] = lambda of_case: None,
    tell: Callable[[TedmError], None] = lambda error: None,
    compare: MeshDeviation | None = None,
) -> None:
    """Run the cases and write one file each; `done` is told of each. `compare`: see `case_setting`.

    All are held against the model before the first is run. Those that do not fit keep no other from being run: `tell`
    is told of all their problems at once, before, and the same is raised at the end.
    """
    setting = case_setting(project, *load_cases(project.cases), compare=compare)
    config, criteria = setting.config, setting.criteria
    fitting, refused = _checked(setting, case_ids, project.cases)
    known = len(refused)
    problem = _together(refused, project.cases) if refused else None
    if problem is not None and fitting:
        tell(problem)
    for number, ready in enumerate(fitting):
        case = ready.case
        step(number, len(fitting), "running cases")
        result = setting.run(ready)
        path = output if output is not None else project.build_dir / case_file_name(case.id)
        try:
            realised = realise_case(result, config, step, path)
        except InputError as error:
            refused[case.id] = error
            continue
        matrix = config.case_table(case.id).matrix
        sure, beside = setting.uncertainty(result), setting.comparison(ready, result)
        more = () if setting.uncertain is None else setting.uncertain.sources
        used = [*setting.outputs.sources, *ready.sources, *more]
        tables = [*table_paths(project, config), *config.tables, *([Path(matrix)] if matrix else [])]
        inputs = list(dict.fromkeys([*used, *tables]))
        with create(path, CASE, provenance([setting.file], inputs)) as writer:
            write_case(writer, result, ready.outputs.area_id, [r.requirement for r in criteria.requirements])
            if realised is not None:
                write_realisation(writer, realised)
            if sure is not None:
                write_uncertainty(writer, sure)
            if beside is not None:
                write_comparison(writer, beside)
        done(CaseDone(path, result, realised, sure, beside))
    step(len(fitting), len(fitting), "running cases")
    if len(refused) > known:
        problem = _together(refused, project.cases)
    if problem is not None:
        raise problem


def _checked(
    setting: CaseSetting, case_ids: Sequence[str], where: Path
) -> tuple[list[ReadyCase], dict[str, TedmError]]:
    """The cases that fit the model, and what is wrong with each of the others, by id."""
    fitting: list[ReadyCase] = []
    refused: dict[str, TedmError] = {}
    for case_id in case_ids:
        try:
            case = setting.config.case(case_id, where=str(where))
            fitting.append(setting.ready(case))
        except TedmError as error:
            refused[case_id] = error
    return fitting, refused


def _together(refused: dict[str, TedmError], where: Path) -> TedmError:
    """One error for all cases that were refused: all problems of a configuration, or the first error and the rest."""
    first, *others = refused.values()
    if not others:
        return first
    configuration = {i: e for i, e in refused.items() if isinstance(e, ConfigError)}
    if len(configuration) == len(refused):
        problems = [(f"case {i}: {path}", fact) for i, e in configuration.items() for path, fact in e.problems]
        return ConfigError(problems, where=str(where))
    more = "; ".join(f"case {i}: {' '.join(e.placed.split())}" for i, e in list(refused.items())[1:])
    own = first.hint.split(_REFUSED_TOO)[0]
    first.hint = f"{own}{_REFUSED_TOO}{more}" if own else f"{_REFUSED_TOO}{more}".removeprefix("; ")
    return first
