"""plot: the results of a build folder to figures. The report shows the same figures and shares what is here."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from tedm_cli.config.project import Project
from tedm_cli.figures.drawing.pages import CELL, in_parts, map_pages
from tedm_cli.figures.drawing.spec import FigureSpec
from tedm_cli.files.build_folder import case_file_name
from tedm_cli.files.store import replacing
from tedm_cli.gravity.requirements import DcVerdict
from tedm_cli.noise.areas import AreaTable
from tedm_cli.noise.flight_results import flight_results
from tedm_cli.progress import Step
from tedm_cli.results.areas import maps_by_kind
from tedm_cli.results.build_folder import Matrices, Results, open_results
from tedm_cli.results.cases.deciding import deciding_pairs, worth_showing
from tedm_cli.results.cases.file import read_case
from tedm_cli.results.cases.noise import (
    REALISATION_CONFIDENCE,
    CaseNoise,
    NamedImprovement,
    kinds_of,
    temperature_words,
    titled,
)
from tedm_cli.results.gravity.field import dc_verdicts, place_text
from tedm_cli.results.gravity.self_gravity import gravity_maps
from tedm_cli.results.titles import output_title
from tedm_cli.results.wording import and_text, quantity
from tedm_cli.stages.reporting import draw
from tedm_cli.stages.reporting.plot_adjoint import adjoint_specs, model_views
from tedm_cli.stages.reporting.plot_dynamics import dynamics_specs
from tedm_cli.stages.reporting.plot_dynamics_in_time import in_time_specs
from tedm_cli.stages.reporting.plot_imposed import imposed_specs
from tedm_cli.stages.reporting.plot_optics import area_specs, optics_specs
from tedm_cli.stages.reporting.plot_series import series_specs
from tedm_cli.stages.reporting.plot_thermal import thermal_specs

if TYPE_CHECKING:
    from tedm_cli.figures.drawing.spec import Figure

FIGURES = "figures"


def plot(
    project: Project, output_dir: Path | None, step: Step, areas: Sequence[str] = (), form: str = "svg"
) -> list[Path]:
    """Write every figure of the results; where `areas` are named, the bench under each of their loads instead.

    `form` is `svg`, which the report shows, or `pdf`.

    Raises
    ------
    UsageError : there is no such area.
    ConfigError : a bench is asked for, of a project without optics.
    InputError : a case of the configuration has not been run, or stems from other inputs than those there now.
    """
    from tedm_cli.figures.drawing.style import pdf, svg

    write = {"svg": svg, "pdf": pdf}[form]
    folder = output_dir if output_dir is not None else project.build_dir / FIGURES
    done = []
    with open_results(project) as results:
        specs = (
            area_specs(project, results, areas) if areas else figure_specs(results, list(map(read_case, results.cases)))
        )
        for number, spec in enumerate(specs, start=1):
            data = write(spec.draw(), spec.caption, spec.sources)
            path = (folder / spec.name).with_suffix(f".{form}")
            with replacing(path) as temporary:
                temporary.write_bytes(data)
            done.append(path)
            step(number, len(specs), "drawing figures")
    return done


def figure_specs(results: Results, cases: list[CaseNoise]) -> list[FigureSpec]:
    """All figures, in the order of the report. Without requirements there are no judged outputs to draw."""
    areas = results.areas
    cases = [replace(c, limits=titled(c.limits, results.requirement_titles)) for c in cases]
    all_cases = tuple(f"{i.path.name} {i.sha256}" for i in results.case_files)
    specs: list[FigureSpec] = []

    def add(
        name: str,
        section: str,
        caption: str,
        sources: tuple[str, ...],
        drawn: Callable[[], Figure],
        decides: bool = False,
    ) -> None:
        specs.append(FigureSpec(name, section, caption, sources, drawn, decides))

    kinds, ids = kinds_of(cases), [c.id for c in cases]
    if kinds:
        add(
            "ratios.svg",
            "verdict",
            "Ratio of noise to requirement in every case, the safety factor included: right of 1 it is violated"
            + "; grey bars: range of that ratio over the orders and corners of the temperature filter that were tried"
            * any(_worst_filters(cases, kind) for kind in kinds)
            + ".",
            all_cases,
            partial(draw.ratios, cases, kinds),
            decides=True,
        )
    for kind in kinds:
        title = quantity(kind, sorted({j.output for c in cases for j in c.of_kind(kind)}))
        add(
            f"all_{kind}.svg",
            "all cases",
            f"All cases: {title}, amplitude spectral density with the safety factor applied; a curve above the black"
            f" one violates the requirement.{_flight_words(cases[0], kind)}",
            all_cases,
            partial(draw.overlay, cases, kind),
            decides=True,
        )
    for kind in kinds:
        title = quantity(kind, sorted({j.output for c in cases for j in c.of_kind(kind)}))
        add(
            f"cases_{kind}.svg",
            "all cases",
            f"Every case by itself: {title}, amplitude spectral density with the safety factor applied, of the output"
            " with the largest ratio. "
            + "Hatched: where the requirement is violated. "
            * any(not c.worst(kind).passed for c in cases if c.of_kind(kind))
            + "The light area holds every correlation of the areas that are active in the case.",
            all_cases,
            partial(draw.each_case, cases, kind),
        )
        add(
            f"certainty_{kind}.svg",
            "certainty",
            f"How sure the verdicts on the {title} are: ratio to the requirement of each case, and what it would be"
            " with any correlation between its blocks, any correlation of its areas"
            + (", and other temperature filters." if _worst_filters(cases, kind) else ", or none that is negative."),
            all_cases,
            partial(draw.certainty, cases, kind),
            decides=True,
        )
        for place, (case, judged) in enumerate(worth_showing(cases, kind)):
            title = output_title(judged.output)
            only, which = all_cases[ids.index(case.id)], f"{kind}_{Path(case_file_name(case.id)).stem}"
            add(
                f"contributors_{which}.svg",
                "contributors",
                f"What the noise of the {title} is made of in case {case.id}. Negative bars reduce the total.",
                (only,),
                partial(draw.contributors, case, judged),
                decides=place == 0,
            )
            add(
                f"improvement_{which}.svg",
                "improvement",
                f"What would lower the ratio of the {title} in case {case.id}. Above: the worst areas improved,"
                " each the one that helps most after those before it, or the best blocks matched. Below: the factor"
                " on the temperature amplitude of one group, the others unchanged, that just meets the requirement"
                + _levels_words(judged.improvement)
                + ".",
                (only,),
                partial(draw.improvement, case, judged),
                decides=place == 0 and not judged.passed,
            )
    if decided := [pair for pair in deciding_pairs(cases) if pair[0].uncertainty is not None]:
        add(
            "uncertainty.svg",
            "uncertainty",
            "Probability of the verdicts: ratio to the requirement, safety factor included, of each judged output in"
            " the case that decides it, over all that is uncertain; right: parts of the variance of that ratio by"
            " parameters alone.",
            all_cases,
            partial(draw.chances, decided),
            decides=True,
        )
    shown = _with_own_temperatures(cases)
    add(
        "temperature.svg",
        "all cases",
        f"Temperature noise: {temperature_words({c.id: c.temperature for c in cases})}.",
        tuple(all_cases[i] for i in shown),
        partial(draw.temperature, [results.cases[i] for i in shown]),
    )
    views = model_views(results)
    specs += adjoint_specs(results, cases, views)
    specs += thermal_specs(results, cases, views)
    if results.gravity is not None:
        specs += _gravity_specs(results.gravity, areas)
    specs += imposed_specs(results)
    specs += dynamics_specs(results)
    specs += in_time_specs(results)
    specs += optics_specs(results)
    specs += series_specs(results)
    interval = f"{100 * REALISATION_CONFIDENCE:g} % interval"
    realised = f" Below: estimate from a realisation over the exact curve, with its {interval}."
    for case, source in zip(cases, all_cases, strict=True) if kinds else ():
        add(
            Path(case_file_name(case.id)).with_suffix(".svg").name,
            "cases",
            f"Case {case.id}: {case.title}. {int(case.active.sum())} of {len(case.active)}"
            f" {'thermal nodes and areas' if case.thermal else 'areas'} in {case.blocks}"
            f" block{'s' if case.blocks > 1 else ''}; noise multiplied by the safety factor {case.safety_factor:g}."
            + realised
            * any(j.realised is not None for j in case.judged),
            (source,),
            partial(draw.case, case),
        )
    return specs


def _gravity_specs(gravity: Matrices, areas: AreaTable) -> list[FigureSpec]:
    """Figures of self-gravity: what it feels of each area, and the field at rest."""
    specs = [
        FigureSpec(
            f"self_gravity_by_area{suffix}{part.suffix}.svg",
            "sensitivity",
            f"Self-gravity sensitivity |S_SG| to each {noun}, test mass frames{part.words}.",
            (gravity.source,),
            partial(draw.self_gravity_by_area, page, own),
        )
        for suffix, noun, maps, own in maps_by_kind(gravity_maps(gravity.reader), areas)
        for part, page in in_parts(map_pages(maps, own, CELL))
    ]
    if at_rest := dc_verdicts(gravity.reader):
        specs.append(
            FigureSpec(
                "field_at_rest.svg",
                "field",
                f"Field at rest over its limit, for {_judged_at_rest(at_rest)}: right of 1 it exceeds it; theta, eta"
                " and phi turn about x, y and z.",
                (gravity.source,),
                partial(draw.field_at_rest, gravity.reader),
                decides=True,
            )
        )
    return specs


def _worst_filters(cases: list[CaseNoise], kind: str) -> bool:
    """Whether the worst output of a case was tried with other temperature filters: there is a low-pass."""
    return any(c.worst(kind).filter_ratio is not None for c in cases if c.of_kind(kind))


def _with_own_temperatures(cases: Sequence[CaseNoise]) -> list[int]:
    """The first case of areas, whose spectra of these are those of all, and cases with more or other ones.

    These are gradients within areas, and the nodes of the thermal network.
    """
    first = next((number for number, case in enumerate(cases) if not case.thermal), 0)
    own = (number for number, case in enumerate(cases) if case.thermal or case.areas.within.any())
    return list(dict.fromkeys((first, *own)))


def _levels_words(improvement: NamedImprovement) -> str:
    """What stands right of the groups: a level where the areas of a group have one, its product where a factor does."""
    shown = [group for group, level in improvement.group_level.items() if level > 0.0]
    if not shown:
        return ""
    times = ", times that factor" * any(np.isfinite(improvement.group_factor[group]) for group in shown)
    return f"; right: the amplitude spectral density assumed at the frequency that binds{times}"


def _judged_at_rest(verdicts: Sequence[DcVerdict]) -> str:
    """Whose field at rest is judged."""
    whose = "everything in the model" if all(v.whole for v in verdicts) else "parts of the model and all of it"
    places = dict.fromkeys(place_text(v.place) for v in verdicts if v.minus)
    return f"{whose}, {and_text(list(places))} being the difference of the two" if places else whose


def _flight_words(case: CaseNoise, kind: str) -> str:
    """What was measured in flight, where the figure shows it."""
    shown = flight_results(kind, case.frequency_hz[0], case.frequency_hz[-1], case.limit_names)
    if not shown:
        return ""
    said = [f"{r.mission}, {r.meaning} ({r.source})" for r, _ in shown]
    return f" For orientation, not a limit: {'; '.join(said)}."
