"""plot: the results of a build folder to SVG figures. The report shows the same figures and shares what is here."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from tedm_cli.config.project import Project
from tedm_cli.figures.data import AreaMap, CaseNoise, kinds_of, quantity, worst_cases
from tedm_cli.figures.spec import FigureSpec
from tedm_cli.progress import Step
from tedm_cli.stages.common import case_file_name
from tedm_cli.stages.plot_optics import area_specs, optics_specs
from tedm_cli.stages.results import Results, open_results, read_areas, read_case, read_temperature
from tedm_cli.store import Reader, replacing

FIGURES = "figures"


def plot(project: Project, output_dir: Path | None, step: Step, areas: Sequence[str] = ()) -> list[Path]:
    """Write every figure of the results as SVG; where `areas` are named, the bench under each of their loads instead.

    Raises
    ------
    UsageError : there is no such area.
    InputError : a case of the configuration has not been run, or stems from other inputs than those there now.
    """
    from tedm_cli.figures.style import svg

    folder = output_dir if output_dir is not None else project.build_dir / FIGURES
    done = []
    with open_results(project) as results:
        specs = area_specs(results, areas) if areas else figure_specs(results, list(map(read_case, results.cases)))
        for number, spec in enumerate(specs, start=1):
            data = svg(spec.draw(), spec.caption, spec.sources)
            with replacing(folder / spec.name) as temporary:
                temporary.write_bytes(data)
            done.append(folder / spec.name)
            step(number, len(specs), "drawing figures")
    return done


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
    specs += optics_specs(results)
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


def gravity_maps(file: Reader) -> list[AreaMap]:
    """S_SG as one panel for each unit."""
    value, labels, units = file.array("/S"), file.strings("/row/label"), file.strings("/row/unit")
    maps = []
    for unit in dict.fromkeys(units):
        rows = [i for i, u in enumerate(units) if u == unit]
        maps.append(AreaMap("|S_SG|", unit, [labels[i] for i in rows], value[rows]))
    return maps
