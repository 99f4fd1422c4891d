"""report: everything a build folder holds, as one HTML page."""

from __future__ import annotations

from pathlib import Path

from tedm_cli.config.project import Project
from tedm_cli.contracts import UNIT_LOADS
from tedm_cli.figures.inline import read_figure
from tedm_cli.provenance import input_files
from tedm_cli.report.page import ReportFigure, ReportFile, ReportInputs, render
from tedm_cli.stages.common import UNIT_LOADS as UNIT_LOADS_FILE
from tedm_cli.stages.common import out_path, require_input
from tedm_cli.stages.plot import FIGURES, figure_specs
from tedm_cli.stages.results import open_results, read_case
from tedm_cli.store import open_checked, replacing


def report(project: Project, output: Path | None) -> Path:
    """Write the report of all cases, with the figures that `plot` left in the build folder.

    Raises
    ------
    InputError : a result or a figure is missing, or does not stem from the others as they are now.
    """
    build = project.build_dir
    loads = build / UNIT_LOADS_FILE
    out = out_path(project, "report.html", output)
    with (
        open_results(project) as results,
        open_checked(loads, UNIT_LOADS) as unit_loads,
    ):
        upstream = [*input_files([loads]), results.distortion_file]
        for file in (results.distortion, results.sensitivity, results.optics):
            for used in upstream:
                require_input(file, used)
        cases = [read_case(r) for r in results.cases]
        figures = [
            ReportFigure(s.section, s.caption, read_figure(build / FIGURES / s.name, s.sources))
            for s in figure_specs(results, cases)
        ]
        readers = [unit_loads, results.distortion, results.sensitivity, results.optics, *results.cases]
        hashes = [*upstream, results.sensitivity_file, results.optics_file, *results.case_files]
        page = render(
            ReportInputs(
                title=project.title,
                unit_loads=unit_loads,
                distortion=results.distortion,
                sensitivity=results.sensitivity,
                optics=results.optics,
                cases=cases,
                files=[ReportFile(r, h.sha256) for r, h in zip(readers, hashes, strict=True)],
                figures=figures,
            )
        )
        with replacing(out) as temporary:
            temporary.write_text(page, encoding="utf-8", newline="\n")
    return out
