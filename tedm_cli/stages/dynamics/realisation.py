"""The realisation in time that `simulate --time` makes of a case, beside what the exact spectra expect of it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from tedm_cli.arrays import FloatArray
from tedm_cli.config.dynamics.loop import TimeTable
from tedm_cli.contracts import SIMULATION
from tedm_cli.dynamics.budget import budget
from tedm_cli.dynamics.in_time import TimeLoop, realise, time_loop
from tedm_cli.dynamics.loops import StateSpace
from tedm_cli.dynamics.noise_drive import WhiteDriven, noise_drive, together
from tedm_cli.dynamics.own_controller import StateSpaceController
from tedm_cli.dynamics.sampled_loop import SampledTimeLoop
from tedm_cli.dynamics.sampled_spectra import sampled_psd
from tedm_cli.dynamics.signals import DISTURBANCES
from tedm_cli.dynamics.thermal_input import AnyThermal
from tedm_cli.errors import InputError, PhysicsError
from tedm_cli.files.store import Writer
from tedm_cli.noise.shaping.models import model_of
from tedm_cli.noise.sources import AnySource
from tedm_cli.noise.spectral_estimate import Estimate, Welch, Window, segment_length, through_window
from tedm_cli.stages.dynamics.loop import Loop
from tedm_cli.stages.dynamics.thermal import ThermalRows

_TOLERANCE = 3e-3  # of the shaping filters' amplitudes
_ALIASES = 8  # bands above half the rate that are folded back into what is expected
_GRID_PER_DECADE = 60
_HIGHEST = 0.2  # of the rate: above it what is folded back from farther bands counts


@dataclass(frozen=True, eq=False)
class RealisedLoop:
    """Estimate of the outputs `labels` from a realisation, and what the exact spectra [n, F] expect of it."""

    labels: tuple[str, ...]
    estimate: Estimate
    exact: FloatArray
    plan: TimeTable

    @property
    def ratio(self) -> FloatArray:
        """Estimate over expectation [n, F]."""
        return np.asarray(self.estimate.psd / self.exact)


def realise_loop(
    loop: Loop,
    rows: ThermalRows,
    noise: AnySource,
    labels: tuple[str, ...],
    band_hz: tuple[float, float],
    where: str,
    advance: Callable[[int], None] = lambda done: None,
) -> RealisedLoop:
    """Realise all noise of a case through the loop; `band_hz`: lowest frequency compared, highest of the filters.

    Raises
    ------
    InputError : nothing to realise, a rate too low for the band or no whole fraction of a sampled controller's, areas
        with delays, fewer samples than a segment.
    PhysicsError : a spectrum that no filter reaches.
    """
    plan, lowest = loop.config.time, band_hz[0]
    if not labels:
        raise InputError(
            "no requirement applies, and only outputs that are judged are realised in time",
            where=loop.where,
            hint="add a [[requirement]], or leave --time out",
        )
    if lowest >= _HIGHEST * plan.rate_hz:
        raise InputError(
            f"time.rate_hz: {plan.rate_hz:g} Hz has no frequencies above {_HIGHEST * plan.rate_hz:g} Hz, and the"
            f" requirements begin at {lowest:g} Hz",
            where=loop.where,
            hint=f"sample at more than {lowest / _HIGHEST:g} Hz",
        )
    segment = segment_length(plan.rate_hz, lowest)
    if plan.samples < segment:
        raise InputError(
            f"time.samples: {plan.samples:,} at {plan.rate_hz:g} Hz are too few for a spectrum from {lowest:g} Hz,"
            f" where the requirements begin; it takes {segment:,}",
            where=loop.where,
            hint=f"take samples = {4 * segment} for four segments or more",
        )
    in_time = time_loop(loop.plant, loop.controller, labels)
    periods = _periods(loop, in_time)
    # estimates see three quarters of their lowest frequency; a decade more to fit costs seconds and is not felt
    filters = (lowest / 10.0, max(band_hz[1], 2.0 * plan.rate_hz * periods))
    columns = np.concatenate([rows.read_out, rows.acceleration])
    model = model_of(columns, noise, filters, _TOLERANCE, where)
    system = model.continuous()
    at = len(columns)
    zero_c, zero_d = (np.zeros((len(DISTURBANCES) - at, m.shape[1])) for m in (system.c, system.d))
    thermal = WhiteDriven(
        StateSpace(system.a, system.b, np.concatenate([zero_c, system.c]), np.concatenate([zero_d, system.d]))
    )
    drive = together([noise_drive(loop.sources, filters, _TOLERANCE), thermal])
    welch = Welch(len(labels), plan.rate_hz, segment)
    for block in realise(in_time, drive, plan.rate_hz, plan.samples, plan.seed):
        welch.add(block)
        advance(block.shape[1])
    estimate = welch.estimate()
    inside = (estimate.frequency_hz >= lowest) & (estimate.frequency_hz <= _HIGHEST * plan.rate_hz)
    estimate = Estimate(estimate.frequency_hz[inside], estimate.psd[:, inside], estimate.degrees_of_freedom[inside])
    exact = _expected(loop, rows, noise, labels, estimate.frequency_hz, lowest, periods)
    return RealisedLoop(labels, estimate, exact, plan)


def _periods(loop: Loop, in_time: TimeLoop) -> int:
    """Periods of a sampled controller in a sample; 1 for a continuous one."""
    if not isinstance(in_time, SampledTimeLoop):
        return 1
    try:
        return in_time.periods(1.0 / loop.config.time.rate_hz)
    except PhysicsError as error:
        raise InputError(f"time.rate_hz: {error.fact}", where=loop.where, hint=error.hint) from error


def _expected(
    loop: Loop,
    rows: ThermalRows,
    noise: AnySource,
    labels: tuple[str, ...],
    frequency_hz: FloatArray,
    lowest_hz: float,
    periods: int,
) -> FloatArray:
    """Expectation [n, F] of the estimate: means over samples, folded, through the window."""
    rate = loop.config.time.rate_hz
    low, high = 0.5 * lowest_hz, 1.1 * _HIGHEST * rate
    grid = np.geomspace(low, high, int(_GRID_PER_DECADE * np.log10(high / low)))

    def thermal_at(f: FloatArray) -> AnyThermal:
        return rows.driven_by(noise, f)

    if isinstance(loop.controller, StateSpaceController) and loop.controller.dt_s is not None:
        total = sampled_psd(loop.plant, loop.controller, loop.sources, thermal_at, grid, labels, periods)
    else:
        total = np.zeros((len(labels), len(grid)))
        for alias in range(-_ALIASES, _ALIASES + 1):
            f = np.abs(grid + alias * rate)
            heat = thermal_at(f)
            found = budget(loop.plant, loop.controller, loop.sources, heat, f, labels, difference_s=1.0 / rate)
            total += found.total.T * np.sinc(f / rate) ** 2
    table = np.log(total)

    def psd(f: FloatArray) -> FloatArray:
        return np.asarray(np.exp(np.stack([np.interp(np.log(f), np.log(grid), row) for row in table])))

    return through_window(psd, frequency_hz, Window(rate / segment_length(rate, lowest_hz)))


def write_realisation(writer: Writer, r: RealisedLoop) -> None:
    """Put it into a simulation file."""
    writer.write(SIMULATION.REALISATION_OUTPUT, list(r.labels))
    writer.write(SIMULATION.REALISATION_FREQUENCY, r.estimate.frequency_hz)
    writer.write(SIMULATION.REALISATION_PSD, r.estimate.psd, units="see /output/unit, squared per Hz")
    writer.write(SIMULATION.REALISATION_EXACT, r.exact, units="see /output/unit, squared per Hz")
    writer.write(SIMULATION.REALISATION_DEGREES_OF_FREEDOM, r.estimate.degrees_of_freedom)
    writer.write(SIMULATION.REALISATION_RATE, r.plan.rate_hz)
    writer.write(SIMULATION.REALISATION_SAMPLES, r.plan.samples)
    writer.write(SIMULATION.REALISATION_SEED, r.plan.seed)
