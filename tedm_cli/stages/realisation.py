"""The realisation in the time domain that a cases file may ask for beside the exact spectra of a case."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tedm_cli.config.cases import CasesConfig
from tedm_cli.contracts import CASE
from tedm_cli.errors import InputError
from tedm_cli.noise.case_run import CaseResult
from tedm_cli.noise.realisation import expected_psd, in_band, realise
from tedm_cli.noise.spectral_estimate import Estimate
from tedm_cli.progress import Step, counter
from tedm_cli.stages.common import FloatArray
from tedm_cli.store import Writer, open_checked


@dataclass(frozen=True, eq=False)
class Realised:
    """Estimate of the outputs of a case from a realisation, and beside it what the exact spectra [n_out, F] expect."""

    estimate: Estimate
    exact: FloatArray
    rate_hz: float
    samples: int
    seed: int

    @property
    def ratio(self) -> FloatArray:
        """Estimate over exact PSD [n_out, F]; nan for an output without noise."""
        return np.divide(self.estimate.psd, self.exact, out=np.full_like(self.exact, np.nan), where=self.exact > 0.0)


def realise_case(rows: FloatArray, result: CaseResult, config: CasesConfig, step: Step) -> Realised | None:
    """Realise a case for outputs with `rows` [n_out, k]; None where the configuration does not ask for it.

    Raises `InputError` for delays that are too long to be held.
    """
    plan = config.realisation_plan()
    if plan is None:
        return None
    factor, delay_s = result.correlation.factor, result.correlation.delay_s
    advance = counter(step, plan.samples, f"realising case {result.case.id}")
    try:
        estimate = realise(rows, result.temperature, factor, plan, advance, delay_s)
    except InputError as error:
        raise InputError(error.fact, where=f"case {result.case.id}: {error.where}", hint=error.hint) from error
    inside = in_band(estimate.frequency_hz, plan)
    estimate = Estimate(estimate.frequency_hz[inside], estimate.psd[:, inside], estimate.degrees_of_freedom[inside])
    exact = expected_psd(rows, result.temperature, factor, plan, estimate.frequency_hz, delay_s)
    return Realised(estimate, exact, plan.rate_hz, plan.samples, plan.seed)


def write_realisation(writer: Writer, r: Realised) -> None:
    """Put it into a case file."""
    writer.write("/realisation/frequency", r.estimate.frequency_hz)
    writer.write("/realisation/psd", r.estimate.psd, units="see /output/unit, squared per Hz")
    writer.write("/realisation/exact", r.exact, units="see /output/unit, squared per Hz")
    writer.write("/realisation/degrees_of_freedom", r.estimate.degrees_of_freedom)
    writer.write("/realisation/rate", r.rate_hz)
    writer.write("/realisation/samples", r.samples)
    writer.write("/realisation/seed", r.seed)


def read_realisation(path: Path) -> Realised | None:
    """The realisation in a case file, None when it has none."""
    with open_checked(path, CASE) as file:
        if not file.has("/realisation/psd"):
            return None
        estimate = Estimate(
            *(file.array(f"/realisation/{name}") for name in ("frequency", "psd", "degrees_of_freedom"))
        )
        return Realised(
            estimate,
            file.array("/realisation/exact"),
            file.number("/realisation/rate"),
            int(file.number("/realisation/samples")),
            int(file.number("/realisation/seed")),
        )
