"""The report and its annex: what the results say, arranged for their readers. Computes next to nothing."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from dataclasses import field as default
from functools import partial

from tedm_cli import __version__
from tedm_cli.gravity.requirements import DcVerdict
from tedm_cli.noise.areas import AreaTable
from tedm_cli.report.cases import cases_section, every_case_section, spectra_section
from tedm_cli.report.decision import cards_section
from tedm_cli.report.document import Block, Document, Facts, Figure, FileLink, Link, Paragraph, Section, Text
from tedm_cli.report.dynamics import closed_loop_section, closed_loop_words, loop_detail_section
from tedm_cli.report.effects import effects_section
from tedm_cli.report.evidence import change_section, sure_section, why_section
from tedm_cli.report.field import field_section
from tedm_cli.report.materials import materials_section
from tedm_cli.report.model import model_section
from tedm_cli.report.network_case import network_case_section, network_correlation_section
from tedm_cli.report.numbering import held, numbered
from tedm_cli.report.optics import optics_section
from tedm_cli.report.proof import (
    assumptions_section,
    at_rest_section,
    binding_section,
    how_sure_section,
    key_figures_section,
)
from tedm_cli.report.provenance import ReportFile, provenance_section
from tedm_cli.report.remedy import remedy_section
from tedm_cli.report.series import series_section
from tedm_cli.report.summary import summary_section
from tedm_cli.report.thermal import SECTION as THERMAL
from tedm_cli.report.thermal import thermal_section
from tedm_cli.report.uncertain import uncertainty_section
from tedm_cli.report.verdicts import Titles
from tedm_cli.report.where import Where, where_section
from tedm_cli.results.adjoint.materials import MaterialEffect
from tedm_cli.results.cases.chances import uncertain_cases
from tedm_cli.results.cases.effects import OwnEffect
from tedm_cli.results.cases.noise import CaseNoise
from tedm_cli.results.cases.series import SeriesSummary
from tedm_cli.results.dynamics.in_time import IN_TIME
from tedm_cli.results.dynamics.loop import ClosedLoop
from tedm_cli.results.gravity.field import FieldAtRest
from tedm_cli.results.model import DistortionSize, ModelSize
from tedm_cli.results.optics import OpticsResults
from tedm_cli.results.thermal.network import ThermalNetwork
from tedm_cli.results.titles import requirement_title
from tedm_cli.results.wording import GRAVITY_ALONE, READ_OUT_ALONE, and_text, capital, count

ANNEX = "A"  # mark of the annex


@dataclass(frozen=True)
class ReportFigure:
    """A figure to be placed in a section: its caption, and the name and the text of its SVG file.

    `decides`: it belongs to the evidence that the report itself shows; the others are in the annex.
    """

    section: str
    caption: str
    svg: str
    file: str
    decides: bool = False


@dataclass(frozen=True)
class Front:
    """The title block; empty texts are not given."""

    title: str = ""
    mission: str = ""
    issue: str = ""
    date: str = ""
    prepared_by: str = ""


@dataclass(frozen=True)
class ReportInputs:
    """All that a report is made from; `files` are all result files in the order of the chain.

    `field` is None of a project without test masses, `optics` of one without optics. `closed_loop` is None where there
    can be none, and then `no_loop` says why, or where it has not been simulated. `no_adjoint`: why there is no adjoint
    of the model, where one was asked for; `where`, `materials`: what it says of the output that binds, and of
    materials.
    `requirement_titles`: plain titles in the configuration, by name. `model_view`: name of a file beside the report
    that shows the model, or "". `effects`: those of the user's own, by output. `network`: the thermal model, where it
    has been made.
    """

    title: str
    model: ModelSize
    distortion: DistortionSize
    field: FieldAtRest | None
    optics: OpticsResults | None
    areas: AreaTable
    cases: list[CaseNoise]
    series: dict[str, SeriesSummary]
    no_loop: str
    closed_loop: ClosedLoop | None
    files: list[ReportFile]
    figures: list[ReportFigure]
    front: Front = Front()
    requirement_titles: Mapping[str, str] = default(default_factory=dict)
    model_view: str = ""
    no_adjoint: str = ""
    where: Where = default(default_factory=Where)
    materials: Sequence[MaterialEffect] = ()
    effects: Sequence[OwnEffect] = ()
    network: ThermalNetwork | None = None

    @property
    def at_rest(self) -> list[DcVerdict]:
        """Verdicts on the field at rest."""
        return [] if self.field is None else self.field.verdicts

    @property
    def benches(self) -> int:
        """Number of optical benches."""
        return 0 if self.optics is None else len(self.optics.read_outs.benches)

    @property
    def half(self) -> str:
        """What is not there of a project with one half of the chain; empty of one with both."""
        return GRAVITY_ALONE if self.optics is None else READ_OUT_ALONE if self.field is None else ""

    @property
    def layout_notes(self) -> list[str]:
        """What is odd in the optical layout, or between it and the model, but no error."""
        return [] if self.optics is None else self.optics.quality.notes

    @property
    def remarks(self) -> list[Text]:
        """What to know of the project before its verdicts are believed."""
        remarks: list[Text] = [self.half] if self.half else []
        if notes := self.layout_notes:
            what = f"{count(len(notes), 'thing')} to look at in the optical layout, listed under "
            remarks.append((capital(what), Link("Assumptions", "assumptions"), "."))
        return remarks

    @property
    def judged_noise(self) -> str:
        """What noise is judged, for the title."""
        halves = ["self-gravity"] * (self.field is not None) + ["read-out"] * (self.optics is not None)
        return f"{and_text(halves)} noise"


@dataclass(frozen=True)
class _Figures:
    """Figures by the section they belong to, of the report and of the annex."""

    report: dict[str, list[Figure]]
    annex: dict[str, list[Figure]]

    @property
    def all(self) -> list[Figure]:
        return [figure for of in (self.report, self.annex) for section in of.values() for figure in section]


def documents_of(inputs: ReportInputs) -> tuple[Document, Document]:
    """The report and its annex, numbered, with references to each other.

    Raises
    ------
    InputError : files stem from different versions of one configuration.
    """
    figures, titles = _figures(inputs.figures), partial(requirement_title, own=inputs.requirement_titles)
    subject = inputs.front.title or f"Thermo-elastic distortion: {inputs.judged_noise} against requirements"
    others = _annex_sections(inputs, figures, titles)
    sections = (*_report_sections(inputs, figures.report, titles), _annex_words(others))
    report = Document(inputs.title, subject, __version__, sections, front=_front(inputs.front))
    annex = Document(
        inputs.title,
        f"Annex to: {subject}",
        __version__,
        (_about(inputs), *others),
        front=_front(inputs.front),
        mark=ANNEX,
    )
    first, second = numbered([report, annex])
    return first, second


def _front(front: Front) -> tuple[tuple[str, str], ...]:
    rows = (
        ("Mission", front.mission),
        ("Issue", front.issue or "not given"),
        ("Date", front.date or "not given"),
        ("Prepared by", front.prepared_by),
        ("Made by", f"tedm {__version__}"),
    )
    return tuple((name, value) for name, value in rows if value)


def _report_sections(inputs: ReportInputs, figures: dict[str, list[Figure]], titles: Titles) -> tuple[Section, ...]:
    """Decision, remedy, and the evidence that decides."""
    cases, areas, dc, loop = inputs.cases, inputs.areas, inputs.at_rest, inputs.closed_loop
    ids = [case.id for case in cases]
    words = closed_loop_words(loop, inputs.no_loop, ids, titles)
    judged = any(c.judged for c in cases)
    sections = [
        summary_section(cases, dc, loop, words, titles, inputs.field is not None, inputs.remarks, inputs.model_view),
        remedy_section(cases, dc, loop, titles, figures["improvement"]),
        cases_section(cases, [*figures["verdict"], *figures["all cases"]]),
    ]
    if judged:
        sections.append(binding_section(cases, inputs.benches, figures["contributors"]))
        sections.append(where_section(cases, inputs.where, figures["where"]))
    sections += network_case_section(cases, figures[THERMAL], titles)
    if dc:
        sections.append(at_rest_section(dc, figures["field"]))
    if loop is not None:
        sections.append(closed_loop_section(loop, words, figures["closed loop"], titles))
    if judged:
        sections.append(how_sure_section(cases, [*figures["certainty"], *figures["uncertainty"]]))
    sections += [
        key_figures_section(inputs.model, inputs.distortion, inputs.field, inputs.optics, areas, loop),
        assumptions_section(cases, inputs.field, inputs.layout_notes, loop, titles),
    ]
    return tuple(sections)


def _annex_sections(inputs: ReportInputs, figures: _Figures, titles: Titles) -> tuple[Section, ...]:
    """Everything else."""
    cases, areas, loop, of = inputs.cases, inputs.areas, inputs.closed_loop, figures.annex
    words = closed_loop_words(loop, inputs.no_loop, [case.id for case in cases], titles)
    sections = [cards_section(cases, inputs.at_rest, words, titles, inputs.benches)]
    sections.append(every_case_section(cases, [*of["verdict"], *of["all cases"]], titles))
    if of["cases"]:
        sections.append(spectra_section(of["cases"]))
    if any(c.judged for c in cases):
        sections += [
            why_section(cases, of["contributors"], titles),
            sure_section(cases, of["certainty"]),
            *([uncertainty_section(cases, of["uncertainty"])] if uncertain_cases(cases) else []),
            change_section(cases, of["improvement"], titles),
        ]
    sections += network_correlation_section(cases)
    if loop is not None:
        ids = [case.id for case in cases]
        sections.append(loop_detail_section(loop, ids, of["closed loop"], of[IN_TIME], titles))
    if inputs.series:
        sections.append(series_section(inputs.series, of["series"], titles))
    if inputs.network is not None:
        sections.append(thermal_section(inputs.network, of[THERMAL]))
    if inputs.field is not None:
        sections += [
            _sensitivity_section([*of["sensitivity"], *of["where"]], inputs.no_adjoint),
            *([materials_section(inputs.materials)] if inputs.materials else []),
            field_section(inputs.field, of["field"]),
        ]
    if inputs.optics is not None:
        sections.append(optics_section(inputs.optics.quality, inputs.optics.read_outs, areas, of))
    if inputs.effects:
        sections.append(effects_section(inputs.effects, areas))
    sections += [
        model_section(inputs.model, inputs.distortion),
        provenance_section(inputs.files, figures.all),
    ]
    return tuple(sections)


def _sensitivity_section(figures: Sequence[Figure], no_adjoint: str) -> Section:
    text = (
        "Response to one kelvin in one thermal area. Cells at the dark end of a scale may lie below it (zero by"
        " symmetry)."
    )
    blocks: list[Block] = [Paragraph(text), *figures]
    if no_adjoint:
        blocks.append(Paragraph(f"What single grids do within the areas has not been found: {no_adjoint}.", quiet=True))
    return Section("sensitivity", "Sensitivity by area", "Sensitivity", tuple(blocks))


def _annex_words(sections: Sequence[Section]) -> Section:
    """What the annex holds, section by section."""
    rows = tuple(
        (s.title, (Link(numbers or "text", s.id),)) for s, numbers in zip(sections, held(sections, ANNEX), strict=True)
    )
    text = "All that does not change the decision is in the annex, by section:"
    return Section("more", "What the annex holds", "In the annex", (Paragraph(text), Facts(rows)))


def _about(inputs: ReportInputs) -> Section:
    blocks: list[Block] = [Paragraph(inputs.half)] if inputs.half else []
    blocks += [
        Paragraph(
            (
                "This annex has everything that the report itself leaves out. The decision and what to do are in ",
                Link("the report", "verdict"),
                ".",
            )
        )
    ]
    if inputs.model_view:
        blocks.append(Paragraph(("The model with its motions: ", FileLink(inputs.model_view, inputs.model_view), ".")))
    return Section("annex", "What this annex holds", "About", tuple(blocks))


def _figures(figures: Sequence[ReportFigure]) -> _Figures:
    """Figures by document and section; no list for a section without."""
    found = _Figures(defaultdict(list), defaultdict(list))
    for number, figure in enumerate(figures):
        of = found.report if figure.decides else found.annex
        of[figure.section].append(Figure(f"f{number}", figure.caption, figure.svg, figure.file))
    return found
