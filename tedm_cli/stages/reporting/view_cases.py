"""view, the cases: spectra and limits of what is judged, patterns that stand for a case, and a realisation to play."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from tedm_cli.arrays import FloatArray
from tedm_cli.config.cases import CasesConfig
from tedm_cli.config.project import Project
from tedm_cli.config.temperature.tables import temperature_model
from tedm_cli.contracts import CASE
from tedm_cli.errors import InputError
from tedm_cli.files.store import Reader
from tedm_cli.noise.bounds import matrix_at
from tedm_cli.noise.correlation import correlation
from tedm_cli.noise.outputs import Outputs
from tedm_cli.noise.propagation import TemperatureNoise
from tedm_cli.noise.realisation import Plan, temperature_blocks
from tedm_cli.noise.temperature import TemperatureModel
from tedm_cli.progress import Step
from tedm_cli.results.adjoint.within import and_spectra, case_gradients, with_gradients
from tedm_cli.results.build_folder import Results
from tedm_cli.results.cases.file import read_case, read_correlation
from tedm_cli.results.cases.noise import CaseNoise, titled
from tedm_cli.results.outputs import ModelOutputs
from tedm_cli.results.thermal.case_shares import of_network
from tedm_cli.results.wording import mhz_text
from tedm_cli.view.patterns import typical_pattern
from tedm_cli.view.payload import CaseView, Film, Limits, VerdictView

SAMPLES = 256
FILM_NUMBERS = 2_000_000  # of all cases: 4 MB before they are deflated; of many areas and cases there are fewer samples
_FEWEST = 16
SEED = 1
_NOT_SHOWN = "Its gradients within areas are in its spectra and ratios, but move nothing on this page."
_PER_PERIOD = 16  # samples in a period of the lowest frequency of the requirements
_RESOLVED = 16  # the filters of a realisation, 128 periods long, resolve the lowest frequency over this


def limits_of(cases: Sequence[Reader], titles: Mapping[str, str]) -> Limits:
    """Frequencies and requirements of the cases, which are the same in all files of one configuration."""
    first = read_case(cases[0])
    limits = titled(first.limits, titles)
    amplitude = np.array([q.amplitude for q in limits]).reshape(-1, len(first.frequency_hz))
    return Limits(first.frequency_hz, [q.name for q in limits], [q.plain for q in limits], amplitude)


def case_views(project: Project, results: Results, outputs: ModelOutputs, step: Step) -> list[CaseView]:
    """Every case but those of the thermal network, of the areas of the model: these alone move it.

    With a realisation where its noise can be held.
    """
    of_areas = temperature_model(project, results.config, outputs.areas)
    gradients = case_gradients(project, results.config, outputs)
    k = len(outputs.areas)
    cases = [file for file in results.cases if not of_network(file)]  # thermal nodes are no areas that would move
    films = k * max(1, len(cases))
    samples = max(_FEWEST, min(SAMPLES, FILM_NUMBERS // films))
    views = []
    for number, file in enumerate(cases):
        step(number, len(cases), "realising cases")
        case = read_case(file)
        more = gradients.of(case.id)
        own = with_gradients(outputs, more).with_differences(results.config.applied_requirements())
        temperature = and_spectra(of_areas, more)
        views.append(
            CaseView(
                id=case.id,
                title=case.title,
                role=case.role,
                reason=case.reason if more is None else f"{case.reason} {_NOT_SHOWN}".strip(),
                safety_factor=case.safety_factor,
                temperature=case.temperature,
                silent=np.flatnonzero(~case.active[:k]),
                verdicts=_verdicts(file, case, own, k),
                film=_realisation(project, results.config, case.id, temperature, own, k, samples),
            )
        )
    step(len(cases), len(cases), "realising cases")
    return views


def _verdicts(file: Reader, case: CaseNoise, outputs: Outputs, k: int) -> list[VerdictView]:
    """The verdicts of a case, and temperatures of the first k areas that go with them."""
    found = read_correlation(file)
    spectrum, asd = file.array(CASE.TEMPERATURE_SPECTRUM), file.array(CASE.TEMPERATURE_ASD)
    extremal = file.array(CASE.EXTREMAL.of("maximum"))
    names = [q.name for q in case.limits]
    labels = file.strings(CASE.OUTPUT_LABEL)
    views = []
    for judged in case.judged:
        output = outputs.labels.index(judged.output)
        f = int(np.abs(case.frequency_hz - judged.contribution_hz).argmin())
        amplitude = asd[spectrum, f]  # silent areas have no correlation, and no sign
        real = matrix_at(found.matrix.astype(np.complex128), found.delay_s, float(case.frequency_hz[f]))
        sign = extremal[labels.index(judged.output), :, 0]
        views.append(
            VerdictView(
                output=output,
                limit=names.index(judged.requirement),
                ratio=judged.ratio,
                hz=judged.binding_hz,
                asd=judged.asd,
                pattern_hz=float(case.frequency_hz[f]),
                typical=typical_pattern(outputs.rows[output], amplitude, real, float(judged.asd[f]))[:k],
                worst=(sign * amplitude)[:k],  # all contributions add up: the bound
            )
        )
    return views


def _realisation(
    project: Project,
    config: CasesConfig,
    case_id: str,
    temperature: TemperatureModel,
    outputs: Outputs,
    k: int,
    samples: int,
) -> Film | None:
    """A few periods of the lowest frequency that is judged, sampled finely enough to be played; of the first areas."""
    case = config.case(case_id, where=str(project.cases))
    source = TemperatureNoise(temperature, correlation(case, outputs.areas, temperature.heard))
    lowest = config.lowest_band_hz()
    rate = _PER_PERIOD * lowest
    low = max(config.frequency.min_hz, lowest / _RESOLVED)
    high = min(config.frequency.max_hz, rate / 2.0)
    try:
        blocks = list(temperature_blocks(source, Plan(rate, samples, SEED, low, high, lowest)))
    except InputError:  # delays of more past noise than is held; the case is shown without a realisation
        return None
    values: FloatArray = np.concatenate(blocks, axis=1)[:k]
    words = (
        f"one realisation of the temperatures of this case, seed {SEED}: {samples} samples, {1.0 / rate:.4g} s apart,"
        f" with the case's spectrum from {mhz_text(low)}, below which it is level, to {mhz_text(high)}"
    )
    return Film.of(np.arange(samples) / rate, values, words)
