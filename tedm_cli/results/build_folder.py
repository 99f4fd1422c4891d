"""What figures and report are made from: the results of a build folder, open and found to fit together."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from tedm_cli.arrays import FloatArray
from tedm_cli.config.cases import CasesConfig, load_cases
from tedm_cli.config.optics import load_layout
from tedm_cli.config.project import Project
from tedm_cli.contracts import CASE, DISTORTION, OPTICS, SENSITIVITY, SERIES
from tedm_cli.errors import InputError
from tedm_cli.files.build_folder import DISTORTION as DISTORTION_FILE
from tedm_cli.files.build_folder import OPTICS as OPTICS_FILE
from tedm_cli.files.build_folder import SENSITIVITY as SENSITIVITY_FILE
from tedm_cli.files.build_folder import (
    case_file_name,
    require_input,
    require_same_areas,
    require_same_input,
    series_file_name,
)
from tedm_cli.files.provenance import ConfigFile, InputFile, input_files
from tedm_cli.files.store import Reader, open_checked
from tedm_cli.noise.selection import listed
from tedm_cli.noise.spectral_estimate import Estimate
from tedm_cli.optics.layout import OpticalLayout
from tedm_cli.results.noise import (
    REALISATION_CONFIDENCE,
    WAYS,
    Areas,
    CaseNoise,
    JudgedOutput,
    Limit,
    Mending,
    Spectrum,
    TemperatureSpectra,
)


@dataclass(frozen=True)
class Results:
    """Results that fit together, open, what they were made with, and the hashes of what is drawn.

    `series` are those of the configuration that have been run, by name.
    """

    distortion: Reader
    sensitivity: Reader
    optics: Reader
    layout: OpticalLayout
    cases: list[Reader]
    distortion_file: InputFile
    sensitivity_file: InputFile
    optics_file: InputFile
    case_files: list[InputFile]
    config: CasesConfig
    series: dict[str, Reader]
    series_files: dict[str, InputFile]


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
        series = {}
        for name in (table.name for table in config.series if (build / series_file_name(table.name)).exists()):
            series[name] = stack.enter_context(open_checked(build / series_file_name(name), SERIES))
            hint = f"rebuild it with `tedm run-series {name}`, or delete it"
            _require_made_from(series[name], used, file, hint)
        require_same_areas(sensitivity, optics, distortion, *cases, *series.values())
        yield Results(
            distortion, sensitivity, optics, layout, cases, distortion_file, used[0], used[1], list(input_files(paths)),
            config, series, {name: input_files([reader.path])[0] for name, reader in series.items()},
        )  # fmt: skip


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
    """Refuse a case that was run on other results or with another configuration, or that is another case."""
    hint = f"rebuild it with `tedm run-case {case_id}`"
    _require_made_from(case, used, config, f"{hint}, or all cases with `tedm run-case all`")
    if case.string("/case/id") != case_id:
        raise InputError(f"holds case {case.string('/case/id')}, not {case_id}", where=str(case.path), hint=hint)


def _require_made_from(file: Reader, used: Sequence[InputFile], config: ConfigFile, hint: str) -> None:
    """Refuse a file that was made from other sensitivities, or with another configuration, than those there now."""
    provenance = file.provenance()
    made_from = {(i.path.name, i.sha256) for i in provenance.inputs}
    made_from |= {(c.path.name, c.sha256) for c in provenance.configs}
    now = {i.path: i.sha256 for i in used} | {config.path: config.sha256}
    for path, sha256 in now.items():
        if (path.name, sha256) not in made_from:
            raise InputError(f"is stale: not made from {path} as it is now", where=str(file.path), hint=hint)


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
    return CaseNoise(
        id=file.string("/case/id"),
        title=file.string("/case/title"),
        role=file.string("/case/role"),
        reason=file.string("/case/reason"),
        safety_factor=file.number("/case/safety_factor"),
        temperature=file.string("/temperature/model").replace("sqrt(Hz)", "√Hz"),
        block=file.array("/case/block"),
        frequency_hz=file.array("/frequency"),
        judged=_read_judged(file, {q.name: q for q in limits}),
        limits=limits,
        filter_order=file.array("/filter_sensitivity/order") if has_filter else np.empty(0),
        filter_corner_hz=file.array("/filter_sensitivity/corner") if has_filter else np.empty(0),
    )


def _read_judged(file: Reader, limits: dict[str, Limit]) -> tuple[JudgedOutput, ...]:
    labels, kinds, units = (file.strings(f"/output/{c}") for c in ("label", "kind", "unit"))
    filter_ratio = file.array("/filter_sensitivity/ratio") if file.has("/filter_sensitivity/ratio") else None
    ratio, at, passed = (file.array(f"/verdict/{c}") for c in ("ratio", "binding_frequency", "passed"))
    share, band, band_share = (file.array(f"/contribution/{c}") for c in ("share", "band", "band_share"))
    bounds, bound_ratio = file.strings("/bound_ratio/bound"), file.array("/bound_ratio/ratio")
    distortion = file.array("/verdict/distortion_ratio")
    realised = _read_realised(file)
    judged = []
    pairs = zip(file.strings("/verdict/output"), file.strings("/verdict/requirement"), strict=True)
    for v, (output, requirement) in enumerate(pairs):
        o = labels.index(output)
        low, high = (np.sqrt(file.array(f"/bounds/{b}/{output}")) for b in ("minimum", "maximum"))
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
                bound_ratio=dict(zip(bounds, (float(r) for r in bound_ratio[v]), strict=True)),
                distortion_ratio=None if np.isnan(distortion[v]) else float(distortion[v]),
                filter_ratio=None if filter_ratio is None else filter_ratio[v],
                contribution_hz=float(file.array("/contribution/frequency")[o]),
                band_hz=(float(band[o, 0]), float(band[o, 1])),
                contribution=file.array(f"/contribution/amplitude/{output}"),
                share=share[o],
                band_share=band_share[o],
                path=_path_share(file, f"/path/share/{output}"),
                path_band=_path_share(file, f"/path/band_share/{output}"),
                mending=_read_mending(file, v, float(at[v])),
                realised=None if realised is None else realised[o],
            )
        )
    return tuple(judged)


def _path_share(file: Reader, path: str) -> dict[str, float] | None:
    if not file.has(path):
        return None
    return dict(zip(file.strings("/path/name"), (float(s) for s in file.array(path)), strict=True))


def _read_mending(file: Reader, v: int, binding_hz: float) -> Mending:
    """What would mend verdict number `v`."""
    names, block = np.array(file.strings("/area/name")), file.array("/case/block")
    worst = [str(names[i]) for i in file.array("/improvement/area")[v] if i >= 0]
    match = [listed(names[block == b].tolist()) for b in file.array("/improvement/matched_block")[v] if b >= 0]
    groups = file.strings("/stability/group")
    at = int(np.abs(file.array("/frequency") - binding_hz).argmin())
    level = file.array("/temperature/asd")[file.array("/temperature/spectrum"), at]
    level = np.where(block >= 0, level, np.nan)
    of_area = np.array(file.strings("/area/group"))
    return Mending(
        count=file.array("/improvement/count"),
        ratio={way: file.array(f"/improvement/{way}")[v] for way in WAYS},
        chosen=dict(zip(WAYS, (worst, worst, match), strict=True)),
        group_factor=dict(zip(groups, (float(x) for x in file.array("/stability/factor")[v]), strict=True)),
        group_level={g: _common(level[of_area == g]) for g in groups},
        all_factor=float(file.array("/stability/all")[v]),
    )


def _common(values: FloatArray) -> float:
    """The one value of those that are not NaN; NaN where they differ."""
    held = np.unique(values[~np.isnan(values)])
    return float(held[0]) if len(held) and held[-1] <= held[0] * (1 + 1e-9) else np.nan


def _read_realised(file: Reader) -> list[Spectrum] | None:
    """Estimates from a realisation of all outputs over their exact spectra; 1 where there is no noise."""
    if not file.has("/realisation/psd"):
        return None
    f, psd, exact, nu = (file.array(f"/realisation/{c}") for c in ("frequency", "psd", "exact", "degrees_of_freedom"))
    ratio = np.divide(psd, exact, out=np.ones_like(psd), where=exact > 0.0)
    return spectra_of(Estimate(f, ratio, nu), REALISATION_CONFIDENCE)


def spectra_of(estimate: Estimate, confidence: float) -> list[Spectrum]:
    """Amplitude spectral densities of all series of an estimate, with intervals."""
    low, high = estimate.interval(confidence)
    return [Spectrum(estimate.frequency_hz, np.sqrt(p), np.sqrt(p * low), np.sqrt(p * high)) for p in estimate.psd]


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
