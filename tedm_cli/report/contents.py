"""The report: what the results say, arranged for its readers. Computes next to nothing."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass

from tedm_cli import __version__
from tedm_cli.noise.areas import AreaTable
from tedm_cli.report.cases import cases_section, spectra_section
from tedm_cli.report.decision import decision_section, summary
from tedm_cli.report.document import Document, Figure, Paragraph, Section
from tedm_cli.report.dynamics import closed_loop_section, closed_loop_words
from tedm_cli.report.evidence import change_section, sure_section, why_section
from tedm_cli.report.field import field_section
from tedm_cli.report.model import model_section
from tedm_cli.report.optics import optics_section
from tedm_cli.report.provenance import ReportFile, provenance_section
from tedm_cli.report.series import series_section
from tedm_cli.results.dynamics import ClosedLoop
from tedm_cli.results.field import FieldAtRest
from tedm_cli.results.model import DistortionSize, ModelSize
from tedm_cli.results.noise import CaseNoise
from tedm_cli.results.optics import OpticsQuality, ReadOuts
from tedm_cli.results.series import SeriesSummary


@dataclass(frozen=True)
class ReportFigure:
    """A figure to be placed in a section of the report: its caption, and the name and the text of its SVG file."""

    section: str
    caption: str
    svg: str
    file: str


@dataclass(frozen=True)
class ReportInputs:
    """All that a report is made from; `files` are all result files in the order of the chain.

    `closed_loop` is None where there are not two `test_masses`, or where it has not been simulated.
    """

    title: str
    model: ModelSize
    distortion: DistortionSize
    field: FieldAtRest
    optics: OpticsQuality
    read_outs: ReadOuts
    areas: AreaTable
    cases: list[CaseNoise]
    series: dict[str, SeriesSummary]
    test_masses: int
    closed_loop: ClosedLoop | None
    files: list[ReportFile]
    figures: list[ReportFigure]


def document_of(inputs: ReportInputs) -> Document:
    """The report: decision first, then why, how sure and what to change, then the evidence.

    Raises
    ------
    InputError : files stem from different versions of one configuration.
    """
    areas = inputs.areas
    figures = _figures(inputs.figures)
    ids = [case.id for case in inputs.cases]
    said = closed_loop_words(inputs.closed_loop, inputs.test_masses, ids)
    sections = [decision_section(inputs.cases, areas, inputs.field.verdicts, said, figures)]
    if any(c.judged for c in inputs.cases):
        sections += [
            why_section(inputs.cases, areas, figures),
            sure_section(inputs.cases, figures),
            change_section(inputs.cases, areas, figures),
        ]
    sections.append(cases_section(inputs.cases, figures))
    if figures["cases"]:
        sections.append(spectra_section(figures))
    if inputs.closed_loop is not None:
        sections.append(closed_loop_section(inputs.closed_loop, ids, figures))
    if inputs.series:
        sections.append(series_section(inputs.series, figures))
    text = (
        "Response to one kelvin in one thermal area. Cells at the dark end of a scale may lie below it (zero by"
        " symmetry)."
    )
    sections += [
        Section("sensitivity", "Sensitivity by area", "Sensitivity", (Paragraph(text), *figures["sensitivity"])),
        field_section(inputs.field, figures),
        optics_section(inputs.optics, inputs.read_outs, areas, figures),
        model_section(inputs.model, inputs.distortion),
        provenance_section(inputs.files, [f for section in figures.values() for f in section]),
    ]
    subject = "Thermo-elastic distortion: self-gravity and read-out noise against requirements"
    return Document(inputs.title, subject, __version__, tuple(sections), (summary(sections[0]),))


def _figures(figures: Sequence[ReportFigure]) -> dict[str, list[Figure]]:
    """Figures by the section they belong to; no list for a section without."""
    found: dict[str, list[Figure]] = defaultdict(list)
    for number, figure in enumerate(figures):
        found[figure.section].append(Figure(f"f{number}", figure.caption, figure.svg, figure.file))
    return found
