"""report: everything a build folder holds, as a report that decides and an annex, in HTML, PDF and Markdown."""

from __future__ import annotations

import datetime
from collections.abc import Sequence
from os.path import relpath
from pathlib import Path
from typing import Literal

from tedm_cli.config.project import Project, ReportTable
from tedm_cli.contracts import ADJOINT, UNIT_LOADS
from tedm_cli.errors import UsageError
from tedm_cli.files.build_folder import UNIT_LOADS_FILE, require_input
from tedm_cli.files.provenance import input_files
from tedm_cli.files.store import Reader, cannot_write, open_checked, replacing
from tedm_cli.report.contents import Front, ReportFigure, ReportInputs, documents_of
from tedm_cli.report.document import Document
from tedm_cli.report.html import to_html
from tedm_cli.report.inline import read_figure
from tedm_cli.report.markdown import to_markdown
from tedm_cli.report.provenance import ReportFile
from tedm_cli.report.where import Where, binding_output
from tedm_cli.results.adjoint.file import AdjointResults, field_ratio, read_adjoint
from tedm_cli.results.adjoint.map import has_map, read_map, read_mapped_model
from tedm_cli.results.build_folder import Results, open_results
from tedm_cli.results.cases.effects import own_effects
from tedm_cli.results.cases.file import read_case
from tedm_cli.results.cases.noise import CaseNoise
from tedm_cli.results.cases.series import read_series_summary
from tedm_cli.results.dynamics.loop import read_closed_loop
from tedm_cli.results.gravity.field import read_field
from tedm_cli.results.model import read_distortion_size, read_model_size
from tedm_cli.results.optics import read_optics
from tedm_cli.results.thermal.network import read_thermal_network
from tedm_cli.stages.common import out_path
from tedm_cli.stages.reporting.plot import FIGURES, figure_specs

Format = Literal["html", "pdf", "md"]
FORMATS: tuple[Format, ...] = ("html", "pdf", "md")
ANNEX = "_annex"  # end of the name of the annex
VIEW = "view.html"  # shows the model, where it lies beside the report


def report(project: Project, output: Path | None, formats: Sequence[Format] = ()) -> list[Path]:
    """Write report and annex of all cases, with the figures that `plot` left in the build folder.

    `formats`: all, where none is named; `output`: the report, whose ending says its format. The annex lies beside it,
    with `_annex` in its name. Returns the reports of all formats, then the annexes.

    Raises
    ------
    UsageError : the ending of `output` is of no format, or of another than is asked for.
    InputError : a result or a figure is missing, or does not stem from the others as they are now.
    """
    wanted = list(dict.fromkeys(formats)) or list(FORMATS)
    if output is not None:
        wanted = [_format_of(output, formats)]
    paths = [out_path(project, f"report.{fmt}", output) for fmt in wanted]
    documents = _documents(project, paths[0].parent)
    rendered = []
    for document, ending in zip(documents, ("", ANNEX), strict=True):
        for fmt, path in zip(wanted, paths, strict=True):
            own, other = (path.with_name(f"{path.stem}{e}{path.suffix}") for e in (ending, ANNEX if not ending else ""))
            rendered.append((own, _rendered(document, fmt, own, other.name, project.build_dir / FIGURES)))
    for path, data in rendered:
        with replacing(path) as temporary:
            temporary.write_bytes(data)
    return [path for path, _ in rendered]


def _format_of(output: Path, formats: Sequence[Format]) -> Format:
    found = next((fmt for fmt in FORMATS if output.suffix == f".{fmt}"), None)
    if found is None or (formats and list(formats) != [found]):
        raise UsageError(
            f"{output} cannot take the report" + (f" as {', '.join(formats)}" if formats else ""),
            hint="end its name in .html, .pdf or .md; one file takes one format",
        )
    return found


def _rendered(document: Document, fmt: Format, path: Path, other: str, figures: Path) -> bytes:
    if fmt == "html":
        return to_html(document, other).encode()
    if fmt == "md":
        return to_markdown(document, Path(relpath(figures, path.parent)).as_posix(), other).encode()
    from tedm_cli.figures.drawing.fonts import font_folder
    from tedm_cli.report.pdf import to_pdf

    try:
        return to_pdf(document, font_folder())
    except OSError as exc:  # what it is set from lies on a disk for a moment
        raise cannot_write(path, exc) from exc


def _documents(project: Project, folder: Path) -> tuple[Document, Document]:
    """Report and annex, to be written into a folder."""
    build = project.build_dir
    loads = build / UNIT_LOADS_FILE
    with (
        open_results(project) as results,
        open_checked(loads, UNIT_LOADS) as unit_loads,
    ):
        upstream = [*input_files([loads]), results.distortion_file]
        for file in (results.distortion, *(m.reader for m in results.matrices)):
            for used in upstream:
                require_input(file, used)
        cases = [read_case(r) for r in results.cases]
        figures = [
            ReportFigure(s.section, s.caption, read_figure(build / FIGURES / s.name, s.sources), s.name, s.decides)
            for s in figure_specs(results, cases)
        ]
        adjoint = results.adjoint
        by_adjoint = None if adjoint is None else read_adjoint(adjoint)
        made = [reader for reader in (adjoint, results.thermal) if reader is not None]
        readers = [unit_loads, results.distortion, *(m.reader for m in results.matrices), *made, *results.cases]
        readers += results.series.values()
        readers += [results.dynamics, *results.simulations] if results.dynamics is not None else []
        readers += results.simulated_series.values()
        readers += [results.imposed] if results.imposed is not None else []
        hashes = [*upstream, *(m.file for m in results.matrices)]
        hashes += [file for file in (results.adjoint_file, results.thermal_file) if file is not None]
        hashes += results.case_files
        hashes += results.series_files.values()
        hashes += [results.dynamics_file, *results.simulation_files] if results.dynamics_file is not None else []
        hashes += results.simulated_series_files.values()
        hashes += [results.imposed_file] if results.imposed_file is not None else []
        return documents_of(
            ReportInputs(
                title=project.title,
                model=read_model_size(unit_loads),
                distortion=read_distortion_size(results.distortion),
                field=None if results.gravity is None else read_field(results.gravity.reader),
                optics=None if results.read_out is None else read_optics(results.read_out.reader),
                areas=results.areas,
                cases=cases,
                series={name: read_series_summary(file) for name, file in results.series.items()},
                no_loop=results.no_loop,
                closed_loop=read_closed_loop(results.dynamics, results.simulations, results.simulated_series),
                files=[ReportFile(r, h.sha256) for r, h in zip(readers, hashes, strict=True)],
                figures=figures,
                front=_front(project.report),
                requirement_titles=results.requirement_titles,
                model_view=VIEW if (folder / VIEW).is_file() else "",
                no_adjoint=by_adjoint if isinstance(by_adjoint, str) else "",
                where=_where(results, unit_loads, cases),
                materials=by_adjoint.materials if isinstance(by_adjoint, AdjointResults) else (),
                effects=own_effects(results.cases[0]) if results.cases else [],
                network=None
                if results.thermal is None
                else read_thermal_network(results.thermal, results.areas, results.config.temperature.low_passes()),
            )
        )


def _where(results: Results, unit_loads: Reader, cases: Sequence[CaseNoise]) -> Where:
    """Where temperatures act on the output that binds, or why that is not known."""
    adjoint, label = results.adjoint, binding_output(cases)
    if results.gravity is None:
        return Where(no_map="that takes test masses, and the project has none")
    if adjoint is None:
        return Where(no_map=f"{ADJOINT.made_by} has not been run")
    if adjoint.has(ADJOINT.REFUSAL):
        return Where(no_map="; ".join(adjoint.strings(ADJOINT.REFUSAL)))
    if not has_map(adjoint, label):
        return Where(no_map=f"{adjoint.path.name} was made without {label}")
    found = field_ratio(adjoint, label)
    lengths, ratio = (None, None) if found is None else found
    return Where(read_map(adjoint, label), read_mapped_model(adjoint, unit_loads), length_m=lengths, ratio=ratio)


def _front(table: ReportTable) -> Front:
    date = table.date.isoformat() if isinstance(table.date, datetime.date) else table.date
    issue = "" if table.issue is None else str(table.issue)
    return Front(table.title or "", table.mission or "", issue, date or "", table.prepared_by or "")
