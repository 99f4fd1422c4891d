"""The loop in time as its files tell it: realisations of cases, and temperature series through it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from tedm_cli.contracts import SIMULATED_SERIES, SIMULATION
from tedm_cli.files.store import Reader
from tedm_cli.noise.requirements import AppliedRequirement
from tedm_cli.noise.spectral_estimate import Estimate
from tedm_cli.results.cases.noise import REALISATION_CONFIDENCE, Spectrum, spectra_of
from tedm_cli.results.cases.series import SeriesNoise, SeriesSummary, read_series, read_series_summary

IN_TIME = "closed loop in time"  # section of the report that their figures belong to
#: The two parts of a series in closed loop, and where their spectra are.
PARTS = {"gravity": SIMULATED_SERIES.GRAVITY_PSD, "read-out": SIMULATED_SERIES.READ_OUT_PSD}


@dataclass(frozen=True, eq=False)
class RealisedCase:
    """A realisation of a case in closed loop, beside what the exact spectra expect of it.

    Parameters
    ----------
    ratio : by output, amplitude of the estimate over its expectation [F], with its interval.
    mean : by output, mean over the frequencies of the estimated PSD over its expectation.
    held : part of all values whose interval holds their expectation.
    degrees_of_freedom : of an estimate (chi-square).
    """

    case: str
    rate_hz: float
    samples: int
    seed: int
    ratio: Mapping[str, Spectrum]
    mean: Mapping[str, float]
    held: float
    degrees_of_freedom: float


@dataclass(frozen=True)
class LoopInTime:
    """What there is of the loop in time: realised cases, and series by name."""

    realised: tuple[RealisedCase, ...] = ()
    series: Mapping[str, SeriesSummary] = field(default_factory=dict)


def read_loop_in_time(simulations: Sequence[Reader], series: Mapping[str, Reader]) -> LoopInTime:
    """From open simulation files."""
    found = [read_realised(file) for file in simulations]
    return LoopInTime(
        tuple(r for r in found if r is not None), {name: read_series_summary(file) for name, file in series.items()}
    )


def read_realised(file: Reader) -> RealisedCase | None:
    """The realisation in an open simulation file; None where there is none."""
    if not file.has(SIMULATION.REALISATION_OUTPUT):
        return None
    f, psd, exact, nu = (
        file.array(d)
        for d in (
            SIMULATION.REALISATION_FREQUENCY,
            SIMULATION.REALISATION_PSD,
            SIMULATION.REALISATION_EXACT,
            SIMULATION.REALISATION_DEGREES_OF_FREEDOM,
        )
    )
    ratio = psd / exact
    estimate = Estimate(f, ratio, nu)
    low, high = estimate.interval(REALISATION_CONFIDENCE)
    labels = file.strings(SIMULATION.REALISATION_OUTPUT)
    return RealisedCase(
        case=file.string(SIMULATION.CASE_ID),
        rate_hz=file.number(SIMULATION.REALISATION_RATE),
        samples=int(file.number(SIMULATION.REALISATION_SAMPLES)),
        seed=int(file.number(SIMULATION.REALISATION_SEED)),
        ratio=dict(zip(labels, spectra_of(estimate, REALISATION_CONFIDENCE), strict=True)),
        mean=dict(zip(labels, (float(m) for m in ratio.mean(axis=1)), strict=True)),
        held=float(np.mean((ratio * low <= 1.0) & (ratio * high >= 1.0))),
        degrees_of_freedom=float(nu.min()),
    )


def read_simulated_series(file: Reader, requirements: Sequence[AppliedRequirement], confidence: float) -> SeriesNoise:
    """`read_series` of a series in closed loop, with the spectra of its two parts."""
    noise = read_series(file, requirements, confidence)
    f, nu = file.array(SIMULATED_SERIES.FREQUENCY), file.array(SIMULATED_SERIES.DEGREES_OF_FREEDOM)
    outputs = []
    for o in noise.outputs:
        psd = np.stack([file.array(family.of(o.output)) for family in PARTS.values()])
        spectra = spectra_of(Estimate(f, psd, nu), confidence)
        outputs.append(replace(o, parts=dict(zip(PARTS, spectra, strict=True))))
    return replace(noise, source=f"{noise.source}, in closed loop", outputs=tuple(outputs))
