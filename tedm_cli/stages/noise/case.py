"""run-case: sensitivities and temperature noise to spectra, bounds, verdicts and contributions of one case."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from tedm_cli.config.cases import load_cases
from tedm_cli.config.project import Project
from tedm_cli.config.temperature_tables import table_paths, temperature_model
from tedm_cli.contracts import CASE as KIND
from tedm_cli.errors import ConfigError, InputError, TedmError
from tedm_cli.files.build_folder import OPTICS, SENSITIVITY, case_file_name, provenance
from tedm_cli.files.store import create
from tedm_cli.noise.case_run import CaseResult, run_case
from tedm_cli.noise.correlation import correlation
from tedm_cli.progress import Step
from tedm_cli.results.case_file import write_case
from tedm_cli.results.outputs import read_outputs
from tedm_cli.stages.noise.log_spectrum import require_speckit
from tedm_cli.stages.noise.realisation import Realised, realise_case, write_realisation


def run_cases(
    project: Project,
    case_ids: Sequence[str],
    output: Path | None,
    step: Step,
    done: Callable[[Path, CaseResult, Realised | None], None] = lambda path, result, realised: None,
) -> None:
    """Run the cases and write one file each; `done` is told of each, with its realisation where one is asked for.

    A case that does not fit the model does not keep the others from being run: what it raises is raised at the end.
    """
    file, config = load_cases(project.cases)
    if config.realisation is not None and config.realisation.spectrum == "log":
        require_speckit()
    sources = [project.build_dir / SENSITIVITY, project.build_dir / OPTICS]
    requirements = config.applied_requirements()
    outputs = read_outputs(*sources).with_differences(requirements)
    temperature = temperature_model(project, config, outputs.areas)
    frequency = config.frequency_hz()
    refused: dict[str, TedmError] = {}
    for number, case_id in enumerate(case_ids, start=1):
        step(number - 1, len(case_ids), "running cases")
        try:
            case = config.case(case_id, where=str(project.cases))
            correlation(case, outputs.areas)
        except TedmError as error:
            refused[case_id] = error
            continue
        try:
            result = run_case(
                case,
                outputs.areas,
                temperature,
                outputs.rows,
                outputs.labels,
                outputs.kinds,
                frequency,
                requirements,
                config.safety_factor,
                outputs.parts_of_read_outs,
            )
        except ConfigError as error:  # of the requirements, which are the same for every case
            raise ConfigError(error.problems, where=str(project.cases)) from error
        path = output if output is not None else project.build_dir / case_file_name(case.id)
        try:
            realised = realise_case(outputs.rows, result, config, step, path.parent)
        except InputError as error:
            refused[case_id] = error
            continue
        matrix = config.case_table(case.id).matrix
        inputs = [*sources, *table_paths(project, config), *config.tables, *([Path(matrix)] if matrix else [])]
        with create(path, KIND, provenance([file], inputs)) as writer:
            write_case(writer, result, outputs.area_id, [r.requirement for r in requirements])
            if realised is not None:
                write_realisation(writer, realised)
        done(path, result, realised)
    step(len(case_ids), len(case_ids), "running cases")
    if refused:
        raise _together(refused, project.cases)


def _together(refused: dict[str, TedmError], where: Path) -> TedmError:
    """One error for all cases that were refused: every problem of a configuration, else the first error."""
    first, *others = refused.values()
    if not others:
        return first
    configuration = {i: e for i, e in refused.items() if isinstance(e, ConfigError)}
    if len(configuration) == len(refused):
        problems = [(f"case {i}: {path}", fact) for i, e in configuration.items() for path, fact in e.problems]
        return ConfigError(problems, where=str(where))
    first.hint = f"{first.hint}; refused too: case {', '.join(list(refused)[1:])}".removeprefix("; ")
    return first
