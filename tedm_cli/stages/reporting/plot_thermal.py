"""plot, the thermal network: its steady state, how disturbances reach it, and what they do in a case of it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from tedm_cli.figures.drawing.pages import in_parts
from tedm_cli.figures.drawing.spec import FigureSpec
from tedm_cli.files.build_folder import UNIT_LOADS_FILE, case_file_name
from tedm_cli.report.thermal import SECTION
from tedm_cli.results.build_folder import Results
from tedm_cli.results.cases.deciding import DIAGNOSTIC
from tedm_cli.results.cases.noise import CaseNoise
from tedm_cli.results.thermal.groups import has_mapped_temperatures, read_group_gains, read_group_temperatures
from tedm_cli.stages.reporting import draw

if TYPE_CHECKING:
    from tedm_cli.figures.model.adjoint_map import MapViews

GAINS, LOW_PASSES = 6, 19  # disturbances of a figure
_WHAT = {"temperature": "the temperatures of boundaries", "power": "powers"}


def thermal_specs(
    results: Results, cases: Sequence[CaseNoise], views: Callable[[], MapViews] | None
) -> list[FigureSpec]:
    """Figures of the network, in the order of the report, then those of the cases that take their noise from it."""
    return [*_network_specs(results, views), *_case_specs(results, cases)]


def _network_specs(results: Results, views: Callable[[], MapViews] | None) -> list[FigureSpec]:
    file = results.thermal
    if file is None or results.thermal_file is None:
        return []
    source = (f"{results.thermal_file.path.name} {results.thermal_file.sha256}",)
    specs = []
    if (temperatures := read_group_temperatures(file, results.areas)) is not None:
        specs.append(
            FigureSpec(
                "steady_temperatures.svg",
                SECTION,
                "Temperatures of the steady state by group of thermal nodes: from the coldest to the warmest node, and"
                " the mean of the nodes. A group is that of the thermal area that a node is in, or else what its name"
                " begins with.",
                source,
                partial(draw.steady_temperatures, temperatures),
            )
        )
    if views is not None and has_mapped_temperatures(file):
        unit_loads = file.path.with_name(UNIT_LOADS_FILE)
        specs.append(
            FigureSpec(
                "temperature_map.svg",
                SECTION,
                "Temperatures of the steady state on the model: those of the thermal nodes are averages over their"
                " elements, and conduction decides about the field in between.",
                source,
                partial(draw.temperature_map, views, file, unit_loads),
            )
        )
    gains = read_group_gains(file, results.areas)
    if gains is None or len(gains.frequency_hz) == 1:  # nothing that goes over frequency
        return specs
    for kind, what in _WHAT.items():
        mine = gains.of_kind(kind)
        for part, some in in_parts([mine[i : i + GAINS] for i in range(0, len(mine), GAINS)]) if mine else ():
            specs.append(
                FigureSpec(
                    f"thermal_gains_{kind}{part.suffix}.svg",
                    SECTION,
                    f"Gain and phase from {what} to groups of thermal nodes: to the mean temperature of the nodes of a"
                    " group, weighted by their heat capacity. Dotted: the low-pass that fits the gain best. Gains below"
                    f" the axis have no phase here{part.words}.",
                    source,
                    partial(draw.thermal_gains, gains, some),
                )
            )
    every, assumed = list(range(len(gains.disturbance))), results.config.temperature.low_passes()
    if not np.isfinite(gains.low_pass.order).any():  # too few frequencies
        return specs
    against = ", against those that the cases assume (dashed)" if assumed else ""
    for part, few in in_parts([every[i : i + LOW_PASSES] for i in range(0, len(every), LOW_PASSES)]):
        specs.append(
            FigureSpec(
                f"thermal_low_passes{part.suffix}.svg",
                SECTION,
                "Order and corner of the low-passes that fit the temperature noise of groups of thermal nodes, and the"
                f" gains from each disturbance to them{against}. The noise holds the spectra of the disturbances as"
                f" well{part.words}.",
                source,
                partial(draw.thermal_low_passes, gains, few, assumed),
            )
        )
    return specs


def _case_specs(results: Results, cases: Sequence[CaseNoise]) -> list[FigureSpec]:
    specs = []
    for case, file in zip(cases, results.case_files, strict=True):
        if not case.thermal or not case.judged:
            continue
        source, end = (f"{file.path.name} {file.sha256}",), Path(case_file_name(case.id)).with_suffix(".svg").name
        specs += [
            FigureSpec(
                f"disturbances_{end}",
                SECTION,
                f"Shares of the disturbances in the noise of every judged output of case {case.id}, at the frequency"
                " that binds. Negative parts cancel others that they are correlated with.",
                source,
                partial(draw.disturbance_shares, case),
                decides=case.role != DIAGNOSTIC,
            ),
            FigureSpec(
                f"required_stability_{end}",
                SECTION,
                f"Required stability of every disturbance of case {case.id}: the noise that it may have over the"
                " assumed noise, the others unchanged, for the output that asks for most. Below 1 it must be quieter.",
                source,
                partial(draw.required_stability, case),
                decides=case.role != DIAGNOSTIC,
            ),
            FigureSpec(
                f"disturbance_spectra_{end}",
                SECTION,
                f"Noise of the output with the largest ratio in case {case.id} by each disturbance alone, as if the"
                " others were silent, times the safety factor.",
                source,
                partial(draw.disturbance_spectra, case),
            ),
        ]
    return specs
