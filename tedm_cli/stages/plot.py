"""plot: the results of a build folder to SVG figures. The report shows the same figures and shares what is here."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from tedm_cli.config.cases import load_cases
from tedm_cli.config.project import Project
from tedm_cli.contracts import CASE, OPTICS, SENSITIVITY
from tedm_cli.errors import InputError
from tedm_cli.figures.data import (
    AreaMap,
    Areas,
    Array,
    CaseNoise,
    JudgedOutput,
    Limit,
    TemperatureSpectra,
    kinds_of,
    quantity,
    worst_cases,
)
from tedm_cli.progress import Step
from tedm_cli.provenance import ConfigFile, InputFile, input_files
from tedm_cli.stages.common import OPTICS as OPTICS_FILE
from tedm_cli.stages.common import SENSITIVITY as SENSITIVITY_FILE
from tedm_cli.stages.common import case_file_name, require_same_input
from tedm_cli.store import Reader, open_checked, replacing

FIGURES = "figures"


@dataclass(frozen=True)
class Results:
    """Sensitivities and cases that fit together, open, and the hashes of their files (the cases in their order)."""

    sensitivity: Reader
    optics: Reader
    cases: list[Reader]
    sensitivity_file: InputFile
    optics_file: InputFile
    case_files: list[InputFile]


@dataclass(frozen=True)
class FigureSpec:
    """A figure: name of its file, section of the report, caption, what it is drawn from, and how."""

    name: str
    section: str
    caption: str
    sources: tuple[str, ...]
    draw: Callable[[], Any]


def plot(project: Project, output_dir: Path | None, step: Step) -> list[Path]:
    """Write every figure of the results as SVG.

    Raises
    ------
    InputError : a case of the configuration has not been run, or stems from other inputs than those there now.
    """
    from tedm_cli.figures.style import svg

    folder = output_dir if output_dir is not None else project.build_dir / FIGURES
    done = []
    with open_results(project) as results:
        specs = figure_specs(results, [read_case(r) for r in results.cases])
        for number, spec in enumerate(specs, start=1):
            data = svg(spec.draw(), spec.caption, spec.sources)
            with replacing(folder / spec.name) as temporary:
                temporary.write_bytes(data)
            done.append(folder / spec.name)
            step(number, len(specs), "drawing figures")
    return done


@contextlib.contextmanager
def open_results(project: Project) -> Iterator[Results]:
    """Open sensitivities, optics and all cases of the configuration; refuse what is missing or does not fit."""
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
        used = input_files(sources)
        cases = []
        for case_id, path in zip(config.ids, paths, strict=True):
            case = stack.enter_context(open_checked(path, CASE))
            _require_current(case, case_id, used, file)
            cases.append(case)
        yield Results(sensitivity, optics, cases, used[0], used[1], list(input_files(paths)))


def _require_current(case: Reader, case_id: str, used: Sequence[InputFile], config: ConfigFile) -> None:
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


def figure_specs(results: Results, cases: list[CaseNoise]) -> list[FigureSpec]:
    """All figures, in the order of the report. Without requirements there are no judged outputs to draw."""
    areas = read_areas(results.sensitivity)
    all_cases = tuple(f"{i.path.name} {i.sha256}" for i in results.case_files)
    specs: list[FigureSpec] = []

    def add(name: str, section: str, caption: str, sources: tuple[str, ...], draw: Callable[[], Any]) -> None:
        specs.append(FigureSpec(name, section, caption, sources, draw))

    kinds = kinds_of(cases)
    if kinds:
        add(
            "ratios.svg",
            "verdict",
            "Ratio of noise to requirement in every case, the safety factor included; grey bars: range of that ratio"
            " over the orders and corners of the temperature filter that were tried.",
            all_cases,
            lambda: _areas_room().ratios_figure(cases, kinds),
        )
    for kind in kinds:
        title = quantity(kind, sorted({j.output for c in cases for j in c.of_kind(kind)}))
        add(
            f"all_{kind}.svg",
            "all cases",
            f"All cases: {title}, amplitude spectral density with the safety factor applied.",
            all_cases,
            lambda kind=kind: _spectra_room().overlay_figure(cases, kind),  # type: ignore[misc]
        )
    if kinds:
        worst = [worst_cases(cases, kind) for kind in kinds]
        add(
            "contributions.svg",
            "contributors",
            "Areas that contribute most to the worst case of each quantity: signed amplitude, without the safety"
            " factor. Inside a correlated block they add with their signs, between blocks as powers.",
            all_cases,
            lambda: _areas_room().contributions_figure(worst, areas),
        )
    add(
        "temperature.svg",
        "all cases",
        f"Temperature noise: {cases[0].temperature}.",
        all_cases[:1],
        lambda: _spectra_room().temperature_figure(read_temperature(results.cases[0])),
    )
    add(
        "self_gravity_by_area.svg",
        "sensitivity",
        "Self-gravity sensitivity |S_SG| to each thermal area, test mass frames.",
        (f"{results.sensitivity_file.path.name} {results.sensitivity_file.sha256}",),
        lambda: _areas_room().map_figure(gravity_maps(results.sensitivity), areas, "Self-gravity sensitivity by area"),
    )
    read_out_set = results.optics.strings("/set/name")[0]
    add(
        "read_out_by_area.svg",
        "sensitivity",
        f"Read-out sensitivity |N| of photodiode set {read_out_set} to each thermal area.",
        (f"{results.optics_file.path.name} {results.optics_file.sha256}",),
        lambda: _areas_room().map_figure(
            read_out_maps(results.optics, read_out_set), areas, f"Read-out sensitivity by area, set {read_out_set}"
        ),
    )
    for case, source in zip(cases, all_cases, strict=True) if kinds else ():
        add(
            Path(case_file_name(case.id)).with_suffix(".svg").name,
            "cases",
            f"Case {case.id}: {case.title}. {int(case.active.sum())} of {len(case.active)} areas in {case.blocks}"
            f" block{'s' if case.blocks > 1 else ''}; noise multiplied by the safety factor {case.safety_factor:g}.",
            (source,),
            lambda case=case: _spectra_room().case_figure(case),  # type: ignore[misc]
        )
    return specs


def _spectra_room() -> Any:
    """Loaded only where something is drawn: the report reads figures that are there already."""
    from tedm_cli.figures import spectra

    return spectra


def _areas_room() -> Any:
    from tedm_cli.figures import areas

    return areas


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


def gravity_maps(file: Reader) -> list[AreaMap]:
    """S_SG as one panel for each unit."""
    return _maps(file.array("/S"), file.strings("/row/label"), file.strings("/row/unit"), "|S_SG|")


def read_out_maps(file: Reader, read_out_set: str) -> list[AreaMap]:
    """N of one photodiode set as one panel for each unit."""
    units = [f"{u}/K" for u in file.strings("/label/read_out_unit")]
    return _maps(file.array(f"/N/{read_out_set}"), file.strings("/label/read_out"), units, "|N|")


def _maps(value: Array, labels: list[str], units: list[str], title: str) -> list[AreaMap]:
    maps = []
    for unit in dict.fromkeys(units):
        rows = [i for i, u in enumerate(units) if u == unit]
        maps.append(AreaMap(title, unit, [labels[i] for i in rows], value[rows]))
    return maps
