"""What draws each figure. Matplotlib is loaded where one is drawn: the report reads figures that are there already."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from tedm_cli.arrays import FloatArray
from tedm_cli.contracts import OPTICS, UNIT_LOADS
from tedm_cli.figures.drawing.pages import MapPage
from tedm_cli.files.store import Reader, open_checked
from tedm_cli.noise.areas import AreaTable
from tedm_cli.noise.requirements import AppliedRequirement
from tedm_cli.optics.exaggerated import traced_bench
from tedm_cli.optics.layout import OpticalLayout
from tedm_cli.results.adjoint.map import OutputMap
from tedm_cli.results.cases.deciding import Pair
from tedm_cli.results.cases.noise import CaseNoise, JudgedOutput
from tedm_cli.results.cases.series import read_series
from tedm_cli.results.cases.temperatures import read_temperatures
from tedm_cli.results.dynamics.imposed import ImposedMotion
from tedm_cli.results.dynamics.in_time import RealisedCase, read_simulated_series
from tedm_cli.results.dynamics.loop import LoopOutput, LoopStability, SimulatedCase
from tedm_cli.results.gravity.field import dc_verdicts
from tedm_cli.results.thermal.disturbances import all_together, strictest_of
from tedm_cli.results.thermal.groups import (
    GroupGains,
    GroupTemperatures,
    read_mapped_temperatures,
)

if TYPE_CHECKING:
    from tedm_cli.figures.drawing.spec import Figure
    from tedm_cli.figures.model.adjoint_map import MapViews


def ratios(cases: Sequence[CaseNoise], kinds: Sequence[str]) -> Figure:
    from tedm_cli.figures.cases.ratios import ratios_figure

    return ratios_figure(cases, kinds)


def overlay(cases: Sequence[CaseNoise], kind: str) -> Figure:
    from tedm_cli.figures.cases.overlay import overlay_figure

    return overlay_figure(cases, kind)


def each_case(cases: Sequence[CaseNoise], kind: str) -> Figure:
    from tedm_cli.figures.cases.small_multiples import cases_figure

    return cases_figure(cases, kind)


def certainty(cases: Sequence[CaseNoise], kind: str) -> Figure:
    from tedm_cli.figures.cases.certainty import certainty_figure

    return certainty_figure(cases, kind)


def chances(pairs: Sequence[Pair]) -> Figure:
    from tedm_cli.figures.cases.chances import chances_figure

    return chances_figure(pairs)


def contributors(case: CaseNoise, j: JudgedOutput) -> Figure:
    from tedm_cli.figures.cases.contributors import contributors_figure

    return contributors_figure(case, j)


def improvement(case: CaseNoise, j: JudgedOutput) -> Figure:
    from tedm_cli.figures.cases.improvement import improvement_figure

    return improvement_figure(case, j)


def temperature(cases: Sequence[Reader]) -> Figure:
    from tedm_cli.figures.cases.spectra import temperature_figure

    return temperature_figure(read_temperatures(cases))


def field_ratio(length_mm: FloatArray, ratio: Mapping[str, FloatArray], title: str) -> Figure:
    from tedm_cli.figures.model.field_ratio import field_ratio_figure

    return field_ratio_figure(length_mm, ratio, title)


def self_gravity_by_area(page: MapPage, areas: AreaTable) -> Figure:
    from tedm_cli.figures.model.area_maps import map_figure

    return map_figure(page, areas, "Self-gravity sensitivity by area")


def field_at_rest(sensitivity: Reader) -> Figure:
    from tedm_cli.figures.at_rest import at_rest_figure

    return at_rest_figure(dc_verdicts(sensitivity))


def case(noise: CaseNoise) -> Figure:
    from tedm_cli.figures.cases.spectra import case_figure

    return case_figure(noise)


def series(file: Reader, requirements: Sequence[AppliedRequirement], confidence: float) -> Figure:
    from tedm_cli.figures.cases.series import series_figure

    return series_figure(read_series(file, requirements, confidence))


def loop_margins(stability: LoopStability) -> Figure:
    from tedm_cli.figures.dynamics import loops_figure

    return loops_figure(stability)


def budget(case: SimulatedCase, j: LoopOutput) -> Figure:
    from tedm_cli.figures.dynamics import budget_figure

    return budget_figure(case, j)


def closed_loop_thermal(case: SimulatedCase, j: LoopOutput) -> Figure:
    from tedm_cli.figures.dynamics import thermal_figure

    return thermal_figure(case, j)


def imposed(found: ImposedMotion) -> Figure:
    from tedm_cli.figures.imposed import imposed_figure

    return imposed_figure(found)


def realisation(realised: RealisedCase) -> Figure:
    from tedm_cli.figures.dynamics_in_time import realisation_figure

    return realisation_figure(realised)


def simulated_series(file: Reader, requirements: Sequence[AppliedRequirement], confidence: float) -> Figure:
    from tedm_cli.figures.cases.series import series_figure

    return series_figure(read_simulated_series(file, requirements, confidence))


def adjoint_map(views: Callable[[], MapViews], found: OutputMap, bound: float, title: str, unit: str) -> Figure:
    from tedm_cli.figures.model.adjoint_map import adjoint_figure

    return adjoint_figure(views(), found.density, bound, title, unit)


def steady_temperatures(found: GroupTemperatures) -> Figure:
    from tedm_cli.figures.thermal.steady_temperatures import temperatures_figure

    return temperatures_figure(found)


def temperature_map(views: Callable[[], MapViews], thermal: Reader, unit_loads: Path) -> Figure:
    from tedm_cli.figures.model.temperature_map import temperature_figure

    with open_checked(unit_loads, UNIT_LOADS) as unit:
        temperature = read_mapped_temperatures(thermal, unit)
    return temperature_figure(
        views(), temperature, "Temperatures of the steady state on the model", "absolute temperatures"
    )


def thermal_gains(found: GroupGains, disturbances: Sequence[int]) -> Figure:
    from tedm_cli.figures.thermal.gains import gains_figure

    return gains_figure(found, disturbances)


def thermal_low_passes(
    found: GroupGains, disturbances: Sequence[int], assumed: Sequence[tuple[float, float]]
) -> Figure:
    from tedm_cli.figures.thermal.low_passes import low_passes_figure

    return low_passes_figure(found, disturbances, assumed)


def disturbance_shares(case: CaseNoise) -> Figure:
    from tedm_cli.figures.thermal.disturbances import shares_figure

    return shares_figure(case)


def required_stability(case: CaseNoise) -> Figure:
    from tedm_cli.figures.thermal.disturbances import stability_figure

    return stability_figure(case, strictest_of(case), all_together(case))


def disturbance_spectra(case: CaseNoise) -> Figure:
    from tedm_cli.figures.thermal.disturbances import spectra_figure

    return spectra_figure(case)


def bench(layout: OpticalLayout) -> Figure:
    from tedm_cli.figures.optics.bench import bench_figure

    return bench_figure(layout, traced_bench(layout))


def optical_sensitivity(layout: OpticalLayout, optics: Reader) -> Figure:
    from tedm_cli.figures.optics.matrix import sensitivity_map

    return sensitivity_map(layout, optics.array(OPTICS.S_BW))


def read_out_by_area(page: MapPage, areas: AreaTable) -> Figure:
    from tedm_cli.figures.model.area_maps import noise_map

    return noise_map(page, areas, "Read-out by area")
