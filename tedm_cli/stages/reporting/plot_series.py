"""plot, the time series: of every configured series that has been run, the output of each quantity that is worst."""

from __future__ import annotations

from functools import partial

from tedm_cli.figures.drawing.spec import FigureSpec
from tedm_cli.files.build_folder import series_file_name
from tedm_cli.results.build_folder import Results
from tedm_cli.results.cases.series import read_series_summary
from tedm_cli.stages.reporting import draw


def series_specs(results: Results) -> list[FigureSpec]:
    """A figure for each series, in the order of the configuration."""
    requirements = results.config.applied_requirements()
    confidence = {table.name: table.confidence for table in results.config.series}
    specs = []
    for name, file in results.series.items():
        used, summary = results.series_files[name], read_series_summary(file)
        specs.append(
            FigureSpec(
                series_file_name(name).replace(".h5", ".svg"),
                "series",
                f"Time series {summary.source}, {summary.treatment}: of each"
                f" quantity the output {'that is worst' if summary.verdicts else 'of the largest rms'}."
                " Left: smallest and largest values, without the safety factor; right:"
                f" estimated amplitude spectral density times the safety factor"
                f" {summary.safety_factor:g}, with its interval at {100 * confidence[name]:g} %.",
                (f"{used.path.name} {used.sha256}",),
                partial(draw.series, file, requirements, confidence[name]),
            )
        )
    return specs
