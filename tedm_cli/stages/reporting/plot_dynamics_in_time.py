"""plot, the loop in time: every realised case over its expectation, and every series that has been through the loop."""

from __future__ import annotations

from functools import partial
from pathlib import Path

from tedm_cli.figures.drawing.spec import FigureSpec
from tedm_cli.files.build_folder import case_file_name, simulated_series_file_name
from tedm_cli.results.build_folder import Results
from tedm_cli.results.cases.noise import REALISATION_CONFIDENCE
from tedm_cli.results.cases.series import read_series_summary
from tedm_cli.results.dynamics.in_time import IN_TIME, read_realised
from tedm_cli.stages.reporting import draw


def in_time_specs(results: Results) -> list[FigureSpec]:
    """Realisations in the order of the cases, then series in that of the configuration."""
    specs = []
    for file, used in zip(results.simulations, results.simulation_files, strict=True):
        found = read_realised(file)
        if found is None:
            continue
        caption = (
            f"Noise of the closed loop realised in time in case {found.case}: amplitude of the estimate over what the"
            f" exact spectra expect, with its {100 * REALISATION_CONFIDENCE:g} % interval, of every judged output."
        )
        name = f"closed_loop_realised_{Path(case_file_name(found.case)).stem}.svg"
        drawn = partial(draw.realisation, found)
        specs.append(FigureSpec(name, IN_TIME, caption, (f"{used.path.name} {used.sha256}",), drawn))
    confidence = {table.name: table.confidence for table in results.config.series}
    for name, file in results.simulated_series.items():
        used, summary = results.simulated_series_files[name], read_series_summary(file)
        caption = (
            f"Time series {summary.source} through the closed loop, {summary.treatment}; temperatures alone: of each"
            f" quantity the output {'that is worst' if summary.verdicts else 'of the largest rms'}. Left: smallest and"
            " largest values, without the safety factor; right: estimated amplitude spectral density times the safety"
            f" factor {summary.safety_factor:g}, with its interval at {100 * confidence[name]:g} %, and its two parts:"
            " of gravity and of the read-outs."
        )
        drawn = partial(draw.simulated_series, file, results.loop_requirements, confidence[name])
        path = Path(simulated_series_file_name(name)).with_suffix(".svg").name
        specs.append(FigureSpec(path, IN_TIME, caption, (f"{used.path.name} {used.sha256}",), drawn))
    return specs
