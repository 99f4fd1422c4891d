"""export-state-space: the noise of a case as a linear system driven by white noise, for end-to-end simulators."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tedm_cli.arrays import FloatArray
from tedm_cli.config.cases import CasesConfig, load_cases, select_cases
from tedm_cli.config.project import Project
from tedm_cli.config.temperature.tables import temperature_model
from tedm_cli.contracts import CASE
from tedm_cli.errors import UsageError
from tedm_cli.exports.state_space import CONTINUOUS, Labels, sampled_notes, state_space_matrices
from tedm_cli.exports.write import write_matrices
from tedm_cli.files.build_folder import case_file_name
from tedm_cli.files.provenance import ConfigFile, input_files
from tedm_cli.files.store import open_checked
from tedm_cli.matrix_files.named import Format, NamedMatrix
from tedm_cli.noise.correlation import CorrelationCase, correlation
from tedm_cli.noise.propagation import TemperatureNoise
from tedm_cli.noise.shaping.models import AnyModel, model_of
from tedm_cli.noise.sources import AnySource
from tedm_cli.noise.temperature import TemperatureModel
from tedm_cli.results.adjoint.within import CaseGradients, and_spectra, case_gradients, with_gradients
from tedm_cli.results.build_folder import require_current
from tedm_cli.results.cases.file import read_psd
from tedm_cli.results.outputs import ModelOutputs, read_outputs
from tedm_cli.results.thermal.case import thermal_columns
from tedm_cli.stages.exports.case import destination

DEFAULT_TOLERANCE = 0.01


@dataclass(frozen=True)
class Wanted:
    """What to export: relative `tolerance` of the spectra, the sampling rate of the sampled form, C_T and D_T."""

    tolerance: float = DEFAULT_TOLERANCE
    rate_hz: float | None = None
    temperatures: bool = False


@dataclass(frozen=True, eq=False)
class _Inputs:
    """What all cases have in common: the project, its cases file as read, the outputs and the temperatures' model; and
    what each has of gradients within areas."""

    project: Project
    file: ConfigFile
    config: CasesConfig
    outputs: ModelOutputs
    temperature: TemperatureModel
    gradients: CaseGradients

    def of_case(self, case: CorrelationCase) -> tuple[ModelOutputs, AnySource, Sequence[Path]]:
        """The outputs by what fluctuates in a case, its noise, and the files that it alone is made from."""
        if case.thermal:
            found = thermal_columns(self.project, self.config, case.id, self.outputs, self.temperature)
            return found.outputs, found.noise, found.sources
        more = self.gradients.of(case.id)
        outputs, temperature = with_gradients(self.outputs, more), and_spectra(self.temperature, more)
        source = TemperatureNoise(temperature, correlation(case, outputs.areas, temperature.heard))
        return outputs, source, self.gradients.sources(case.id)


@dataclass(frozen=True)
class ExportedSystem:
    """One case's files, its size, the largest relative deviations of the ASDs and what the outputs' are compared to."""

    case_id: str
    paths: tuple[Path, ...]
    states: int
    inputs: int
    filter_deviation: float
    output_deviation: float
    compared_with: str


def export_state_space(
    project: Project, case_ids: Sequence[str], fmt: Format, output: Path | None, wanted: Wanted
) -> list[ExportedSystem]:
    """Write the state-space form of the cases, one file (for CSV one folder) each.

    Raises
    ------
    UsageError : an unknown case, a tolerance or a rate that is not positive, or one file for several cases.
    InputError : sensitivities are missing, the case file is stale, or the case has delays or a complex correlation.
    PhysicsError : the tolerance cannot be reached.
    """
    if not 0.0 < wanted.tolerance < 1.0:
        raise UsageError(f"--tolerance {wanted.tolerance:g} is not between 0 and 1", hint="0.01 is one per cent")
    if wanted.rate_hz is not None and not 0.0 < wanted.rate_hz < np.inf:
        raise UsageError(f"--rate-hz {wanted.rate_hz:g} is not a positive frequency")
    ids = select_cases(project.cases, case_ids)
    places = [destination(project.build_dir, f"{_stem(i)}_state_space", fmt, output, len(ids)) for i in ids]
    file, config = load_cases(project.cases)
    outputs = read_outputs(project)
    temperature = temperature_model(project, config, outputs.areas)
    inputs = _Inputs(project, file, config, outputs, temperature, case_gradients(project, config, outputs))
    return [_export(inputs, case_id, fmt, place, wanted) for case_id, place in zip(ids, places, strict=True)]


def _stem(case_id: str) -> str:
    return Path(case_file_name(case_id)).stem


def _export(inputs: _Inputs, case_id: str, fmt: Format, place: tuple[Path, str], wanted: Wanted) -> ExportedSystem:
    project, config = inputs.project, inputs.config
    case = config.case(case_id, where=str(project.cases))
    of_case, source, made_of = inputs.of_case(case)
    outputs = of_case.with_differences(config.applied_requirements())
    band = (config.frequency.min_hz, config.frequency.max_hz)
    where = f"{project.cases}: case {case_id}"
    model = model_of(outputs.rows, source, band, wanted.tolerance, where)
    frequency = config.frequency_hz()
    path = project.build_dir / case_file_name(case_id)
    if path.exists():
        psd, compared = _stored(inputs, made_of, case_id, path, outputs.labels), path.name
    else:
        psd = source.outputs(outputs.rows, frequency).psd()
        compared = "the exact spectra"
    deviation = _deviation(model.psd(frequency), psd)
    labels = Labels(list(outputs.labels), list(outputs.units), outputs.areas.name.tolist(), outputs.areas.unit)
    validity = NamedMatrix(
        "validity",
        np.array([[*band, wanted.tolerance, model.deviation, deviation]]),
        [],
        ["lowest_frequency", "highest_frequency", "tolerance", "filter_deviation", "output_deviation"],
        [],
        ["Hz", "Hz", "1", "1", "1"],
        f"band of validity, and largest relative deviations in it: filters' ASDs, ASDs of y against {compared}",
    )
    matrices = state_space_matrices(
        model, labels, temperatures=wanted.temperatures, rate_hz=wanted.rate_hz, band=validity
    )
    notes = _notes(case_id, case.title, model, source.words(), band, deviation, compared)
    if wanted.rate_hz is not None:
        notes += sampled_notes(wanted.rate_hz, model.direct)
    paths = write_matrices(*place, matrices, fmt, notes)
    return ExportedSystem(case_id, tuple(paths), model.states, model.noises, model.deviation, deviation, compared)


def _notes(
    case_id: str,
    title: str,
    model: AnyModel,
    temperature: str,
    band: tuple[float, float],
    deviation: float,
    compared: str,
) -> list[str]:
    shared = "; filters that share a white noise have one common phase, so that cross-spectra are right" * model.shared
    return [
        f"tedm: noise of correlation case {case_id}: {title}",
        f"{model.states} states, {model.noises} white noises, {len(model.gain)} outputs y; SI units, y = G times"
        " temperatures; no safety factor.",
        *CONTINUOUS,
        f"temperatures: {temperature}",
        f"Valid from {band[0]:g} to {band[1]:g} Hz. Largest relative deviation of a filter's ASD from the"
        f" configured one there: {model.deviation:.2g}; of the ASDs of y from {compared}: {deviation:.2g}{shared}.",
    ]


def _stored(inputs: _Inputs, made_of: Sequence[Path], case_id: str, path: Path, labels: Sequence[str]) -> FloatArray:
    """The PSDs [n_out, F] of a case file, which must be of the present sensitivities and configuration."""
    with open_checked(path, CASE) as stored:
        used = [*inputs.outputs.sources, *made_of]
        require_current(stored, case_id, input_files(used), [inputs.file])
        return read_psd(stored, labels)


def _deviation(psd: FloatArray, wanted: FloatArray) -> float:
    """Largest relative deviation of the amplitudes, of outputs that have noise."""
    ratio = np.divide(psd, wanted, out=np.ones_like(psd), where=wanted > 0.0)
    return float(np.abs(np.sqrt(ratio) - 1.0).max())
