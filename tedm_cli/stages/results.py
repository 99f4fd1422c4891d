"""What figures and report are made from: the results of a build folder, open and found to fit together."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from tedm_cli.config.cases import load_cases
from tedm_cli.config.optics import load_layout
from tedm_cli.config.project import Project
from tedm_cli.contracts import CASE, DISTORTION, OPTICS, SENSITIVITY
from tedm_cli.errors import InputError
from tedm_cli.figures.data import Areas, Array, CaseNoise, JudgedOutput, Limit, TemperatureSpectra
from tedm_cli.optics.layout import OpticalLayout
from tedm_cli.provenance import ConfigFile, InputFile, input_files
from tedm_cli.stages.common import DISTORTION as DISTORTION_FILE
from tedm_cli.stages.common import OPTICS as OPTICS_FILE
from tedm_cli.stages.common import SENSITIVITY as SENSITIVITY_FILE
from tedm_cli.stages.common import case_file_name, require_input, require_same_input
from tedm_cli.store import Reader, open_checked


@dataclass(frozen=True)
class Results:
    """Results that fit together, open, the layout they were made with, and the hashes of what is drawn."""

    distortion: Reader
    sensitivity: Reader
    optics: Reader
    layout: OpticalLayout
    cases: list[Reader]
    distortion_file: InputFile
    sensitivity_file: InputFile
    optics_file: InputFile
    case_files: list[InputFile]


@contextlib.contextmanager
def open_results(project: Project) -> Iterator[Results]:
    """Open distortion, sensitivities, optics and all cases of the configuration; refuse what is missing or unfit."""
    file, config = load_cases(project.cases)
    build = project.build_dir
    paths = [build / case_file_name(i) for i in config.ids]
    missing = [(i, p) for i, p in zip(config.ids, paths, strict=True) if not p.exists()]
    if missing:
        what = missing[0][0] if len(missing) == 1 else "all"
        names = ", ".join(i for i, _ in missing)
        raise InputError(
            f"no such file; of the cases in {project.cases} not run yet: {names}",
            where=str(missing[0][1]),
            hint=f"make it with `tedm run-case {what}`",
        )
    sources = [build / SENSITIVITY_FILE, build / OPTICS_FILE]
    with contextlib.ExitStack() as stack:
        sensitivity = stack.enter_context(open_checked(sources[0], SENSITIVITY))
        optics = stack.enter_context(open_checked(sources[1], OPTICS))
        require_same_input("distortion.h5", sensitivity, optics)
        distortion = stack.enter_context(open_checked(build / DISTORTION_FILE, DISTORTION))
        distortion_file = input_files([build / DISTORTION_FILE])[0]
        require_input(optics, distortion_file)
        layout = _layout(project, optics)
        used = input_files(sources)
        cases = []
        for case_id, path in zip(config.ids, paths, strict=True):
            case = stack.enter_context(open_checked(path, CASE))
            require_current(case, case_id, used, file)
            cases.append(case)
        yield Results(
            distortion, sensitivity, optics, layout, cases, distortion_file, used[0], used[1], list(input_files(paths))
        )


def _layout(project: Project, optics: Reader) -> OpticalLayout:
    """The project's layout; refused when the matrices were made with another one."""
    file, layout = load_layout(project.optics)
    if file.sha256 not in {c.sha256 for c in optics.provenance().configs}:
        raise InputError(
            f"is stale: not made from {project.optics} as it is now",
            where=str(optics.path),
            hint=f"rebuild it with `{optics.kind.made_by}`",
        )
    return layout


def require_current(case: Reader, case_id: str, used: Sequence[InputFile], config: ConfigFile) -> None:
    """Refuse a case that was run on other sensitivities, or with another configuration, than those there now."""
    provenance = case.provenance()
    made_from = {(i.path.name, i.sha256) for i in provenance.inputs}
    made_from |= {(c.path.name, c.sha256) for c in provenance.configs}
    now = {i.path: i.sha256 for i in used} | {config.path: config.sha256}
    for path, sha256 in now.items():
        if (path.name, sha256) not in made_from:
            raise InputError(
                f"is stale: not made from {path} as it is now",
                where=str(case.path),
                hint=f"rebuild it with `tedm run-case {case_id}`, or all cases with `tedm run-case all`",
            )
    if case.string("/case/id") != case_id:
        raise InputError(
            f"holds case {case.string('/case/id')}, not {case_id}",
            where=str(case.path),
            hint=f"rebuild it with `tedm run-case {case_id}`",
        )


def read_case(file: Reader) -> CaseNoise:
    """Setting, judged outputs and limits of an open case file."""
    limits = tuple(
        Limit(name, source, unit.removesuffix("/sqrt(Hz)"), (float(band[0]), float(band[1])), amplitude)
        for name, source, unit, band, amplitude in zip(
            file.strings("/requirement/name"),
            file.strings("/requirement/source"),
            file.strings("/requirement/unit"),
            file.array("/requirement/band"),
            file.array("/requirement/amplitude"),
            strict=True,
        )
    )
    has_filter = file.has("/filter_sensitivity/ratio")
    block = file.array("/case/block")
    return CaseNoise(
        id=file.string("/case/id"),
        title=file.string("/case/title"),
        safety_factor=file.number("/case/safety_factor"),
        temperature=file.string("/temperature/model").replace("sqrt(Hz)", "√Hz"),
        active=block >= 0,
        blocks=int(block.max()) + 1,
        frequency_hz=file.array("/frequency"),
        judged=_read_judged(file, {q.name: q for q in limits}),
        limits=limits,
        filter_order=file.array("/filter_sensitivity/order") if has_filter else np.empty(0),
        filter_corner_hz=file.array("/filter_sensitivity/corner") if has_filter else np.empty(0),
    )


def _read_judged(file: Reader, limits: dict[str, Limit]) -> tuple[JudgedOutput, ...]:
    labels, kinds, units = (file.strings(f"/output/{c}") for c in ("label", "kind", "unit"))
    factor = file.number("/case/safety_factor")
    has_filter = file.has("/filter_sensitivity/ratio")
    filter_ratio = file.array("/filter_sensitivity/ratio") if has_filter else None
    ratio, at, passed = (file.array(f"/verdict/{c}") for c in ("ratio", "binding_frequency", "passed"))
    share, band, band_share = (file.array(f"/contribution/{c}") for c in ("share", "band", "band_share"))
    judged = []
    pairs = zip(file.strings("/verdict/output"), file.strings("/verdict/requirement"), strict=True)
    for v, (output, requirement) in enumerate(pairs):
        o = labels.index(output)
        low, high = (np.sqrt(file.array(f"/bounds/{b}/{output}")) for b in ("minimum", "maximum"))
        limit = limits[requirement].amplitude
        judged.append(
            JudgedOutput(
                output=output,
                kind=kinds[o],
                unit=units[o],
                requirement=requirement,
                ratio=float(ratio[v]),
                binding_hz=float(at[v]),
                passed=bool(passed[v]),
                asd=np.sqrt(file.array(f"/psd/{output}")),
                bound_low=low,
                bound_high=high,
                correlation_ratio=(_largest(factor * low / limit), _largest(factor * high / limit)),
                filter_ratio=None if filter_ratio is None else filter_ratio[v],
                contribution_hz=float(file.array("/contribution/frequency")[o]),
                band_hz=(float(band[o, 0]), float(band[o, 1])),
                contribution=file.array(f"/contribution/amplitude/{output}"),
                share=share[o],
                band_share=band_share[o],
            )
        )
    return tuple(judged)


def _largest(ratio: Array) -> float:
    return float(np.nanmax(ratio))


def read_areas(file: Reader) -> Areas:
    return Areas(file.strings("/area/name"), file.strings("/area/group"), file.strings("/area/shield"))


def read_temperature(file: Reader) -> TemperatureSpectra:
    """Distinct spectra of a case file; each is named by the shield sides and the number of its areas."""
    index = file.array("/temperature/spectrum")
    shield = np.array(file.strings("/area/shield"))
    asd = file.array("/temperature/asd")
    names = []
    for q in range(len(asd)):
        sides, counts = np.unique(shield[index == q], return_counts=True)
        parts = [f"{side} the thermal shield ({n} areas)" for side, n in zip(sides, counts, strict=True)]
        names.append(", ".join(parts) or "no area")
    return TemperatureSpectra(file.array("/frequency"), asd, names)
