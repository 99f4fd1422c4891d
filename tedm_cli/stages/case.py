"""run-case: sensitivities and temperature noise to spectra, bounds, verdicts and contributions of one case."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tedm_cli.config.cases import CasesConfig, load_cases
from tedm_cli.config.project import Project
from tedm_cli.contracts import CASE as KIND
from tedm_cli.contracts import OPTICS as OPTICS_KIND
from tedm_cli.contracts import SENSITIVITY as SENSITIVITY_KIND
from tedm_cli.errors import InputError
from tedm_cli.noise.areas import AreaTable
from tedm_cli.noise.case_run import CaseResult, run_case
from tedm_cli.progress import Step
from tedm_cli.stages.common import (
    DISTORTION,
    OPTICS,
    SENSITIVITY,
    FloatArray,
    IntArray,
    case_file_name,
    provenance,
    read_areas,
    require_same_input,
)
from tedm_cli.stages.realisation import realise_case, write_realisation
from tedm_cli.stages.temperature import table_paths, temperature_model
from tedm_cli.store import Writer, create, open_checked

_READ_OUT_KIND = {"m": "displacement", "rad": "angle"}


@dataclass(frozen=True)
class Outputs:
    """All outputs as rows per kelvin [n_out, k], with their labels and quantities, and the areas of the columns."""

    areas: AreaTable
    area_id: IntArray
    rows: FloatArray
    labels: list[str]
    kinds: list[str]


def select_cases(project: Project, wanted: Sequence[str]) -> list[str]:
    """Case ids for what the user typed, `all` included; `UsageError` lists what exists."""
    _, config = load_cases(project.cases)
    if list(wanted) == ["all"]:
        return config.ids
    return list(dict.fromkeys(config.case(case_id, where=str(project.cases)).id for case_id in wanted))


def run_cases(
    project: Project, case_ids: Sequence[str], output: Path | None, step: Step
) -> list[tuple[Path, CaseResult]]:
    """Run the cases and write one file each."""
    file, config = load_cases(project.cases)
    sources = [project.build_dir / SENSITIVITY, project.build_dir / OPTICS]
    trace = provenance([file], [*sources, *table_paths(project, config)])
    outputs = read_outputs(*sources)
    temperature = temperature_model(project, config, outputs.areas)
    frequency = config.frequency_hz()
    done = []
    for number, case_id in enumerate(case_ids, start=1):
        case = config.case(case_id, where=str(project.cases))
        result = run_case(
            case,
            outputs.areas,
            temperature,
            outputs.rows,
            outputs.labels,
            outputs.kinds,
            frequency,
            config.applied_requirements(),
            config.safety_factor,
        )
        path = output if output is not None else project.build_dir / case_file_name(case_id)
        realised = realise_case(outputs.rows, result, config, step)
        with create(path, KIND, trace) as writer:
            _write(writer, result, outputs, config)
            if realised is not None:
                write_realisation(writer, realised)
        done.append((path, result))
        step(number, len(case_ids), "running cases")
    return done


def read_outputs(sensitivity: Path, optics: Path) -> Outputs:
    """Gather the rows of both families; refuse files that stem from different distortion matrices."""
    with open_checked(sensitivity, SENSITIVITY_KIND) as s, open_checked(optics, OPTICS_KIND) as o:
        require_same_input(DISTORTION, s, o)
        areas = read_areas(s)
        if o.strings("/area/name") != s.strings("/area/name"):
            raise InputError("hold different thermal areas", where=f"{sensitivity} and {optics}")
        rows = [s.array("/S")]
        labels = s.strings("/row/label")
        kinds = ["angular_acceleration" if u.startswith("rad") else "acceleration" for u in s.strings("/row/unit")]
        read_out, units = o.strings("/label/read_out"), o.strings("/label/read_out_unit")
        for name in o.strings("/set/name"):
            rows.append(o.array(f"/N/{name}"))
            labels += [f"{name}_{label}" for label in read_out]
            kinds += [_READ_OUT_KIND[u] for u in units]
        return Outputs(areas, s.array("/area/id"), np.concatenate(rows), labels, kinds)


def _write(writer: Writer, r: CaseResult, outputs: Outputs, config: CasesConfig) -> None:
    areas = outputs.areas
    writer.write("/area/id", outputs.area_id)
    for column in ("name", "group", "shield", "side"):
        writer.write(f"/area/{column}", [str(v) for v in getattr(areas, column)])
    block = np.full(len(areas), -1)
    for number, members in enumerate(r.blocks):
        block[members] = number
    writer.write("/case/id", r.case.id)
    writer.write("/case/title", r.case.title)
    writer.write("/case/safety_factor", r.safety_factor)
    writer.write("/case/block", block)
    writer.write("/frequency", r.frequency_hz)
    writer.write("/temperature/spectrum", r.temperature_set)
    writer.write("/temperature/asd", r.temperature_asd)
    writer.write("/temperature/model", r.temperature.words())
    writer.write("/output/label", r.labels)
    writer.write("/output/unit", r.units)
    writer.write("/output/kind", r.kinds)
    for i, (label, unit) in enumerate(zip(r.labels, r.units, strict=True)):
        power = f"({unit})^2/Hz"
        writer.write(f"/psd/{label}", r.psd[i], units=power)
        writer.write(f"/bounds/maximum/{label}", r.bounds.maximum[i], units=power)
        writer.write(f"/bounds/maximum_non_negative/{label}", r.bounds.maximum_non_negative[i], units=power)
        writer.write(f"/bounds/known_blocks/{label}", r.bounds.known_blocks[i], units=power)
        writer.write(f"/bounds/minimum/{label}", r.bounds.minimum[i], units=power)
        writer.write(f"/contribution/amplitude/{label}", r.contribution[i], units=f"{unit}/sqrt(Hz)")
    writer.write("/contribution/frequency", r.contribution_hz)
    writer.write("/contribution/share", r.share)
    writer.write("/contribution/band", r.band_hz)
    writer.write("/contribution/band_share", r.band_share)
    _write_verdicts(writer, r, config)


def _write_verdicts(writer: Writer, r: CaseResult, config: CasesConfig) -> None:
    writer.write("/verdict/requirement", [v.requirement for v in r.verdicts])
    writer.write("/verdict/output", [v.output for v in r.verdicts])
    writer.write("/verdict/ratio", [v.ratio for v in r.verdicts])
    writer.write("/verdict/binding_frequency", [v.binding_hz for v in r.verdicts])
    writer.write("/verdict/passed", [int(v.passed) for v in r.verdicts])
    if r.filter_sensitivity is not None:
        writer.write("/filter_sensitivity/order", r.filter_sensitivity.order)
        writer.write("/filter_sensitivity/corner", r.filter_sensitivity.corner_hz)
        writer.write("/filter_sensitivity/ratio", r.filter_sensitivity.ratio)
    requirements = [a.requirement for a in config.applied_requirements()]
    writer.write("/requirement/name", [q.name for q in requirements])
    writer.write("/requirement/source", [q.source for q in requirements])
    writer.write("/requirement/unit", [f"{q.unit}/sqrt(Hz)" for q in requirements])
    writer.write("/requirement/band", np.array([q.band_hz for q in requirements]).reshape(-1, 2))
    f = r.frequency_hz
    amplitude = np.full((len(requirements), len(f)), np.nan)
    for i, q in enumerate(requirements):
        inside = (f >= q.band_hz[0] * (1 - 1e-9)) & (f <= q.band_hz[1] * (1 + 1e-9))
        amplitude[i, inside] = q.amplitude(f[inside])
    writer.write("/requirement/amplitude", amplitude, units="see /requirement/unit")
