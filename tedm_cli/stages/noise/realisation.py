"""The realisation in the time domain that a cases file may ask for beside the exact spectra of a case."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tedm_cli.arrays import FloatArray
from tedm_cli.config.cases import CasesConfig
from tedm_cli.contracts import CASE
from tedm_cli.errors import InputError
from tedm_cli.files.scratch import scratch_file
from tedm_cli.files.store import Writer
from tedm_cli.noise.case_run import CaseResult
from tedm_cli.noise.log_spectrum import log_estimate
from tedm_cli.noise.network import NetworkNoise, NetworkOutputs
from tedm_cli.noise.network_realisation import network_blocks, network_expected
from tedm_cli.noise.realisation import Plan, estimated, expected_psd, output_blocks, resolved
from tedm_cli.noise.sources import AnySource
from tedm_cli.noise.spectral_estimate import Estimate, Window
from tedm_cli.progress import Step, counter


@dataclass(frozen=True, eq=False)
class Realised:
    """Estimate of the outputs of a case from a realisation, and beside it what the exact spectra [n_out, F] expect.

    `method`: of the estimate, "welch" or "log".
    """

    estimate: Estimate
    exact: FloatArray
    rate_hz: float
    samples: int
    seed: int
    method: str = "welch"

    @property
    def ratio(self) -> FloatArray:
        """Estimate over exact PSD [n_out, F]; nan for an output without noise."""
        return np.divide(self.estimate.psd, self.exact, out=np.full_like(self.exact, np.nan), where=self.exact > 0.0)


def realise_case(result: CaseResult, config: CasesConfig, step: Step, path: Path) -> Realised | None:
    """Realise the outputs of a case; None where the configuration does not ask for it.

    Log-spaced spectra take segments of another length at every frequency, so their series wait in a temporary file
    beside `path`, the file of the case.

    Raises `InputError` for delays that are too long to be held, and for filters that are too much to hold.
    """
    table, plan = config.realisation, config.realisation_plan()
    rows, source = result.outputs.rows, result.source
    if table is None or plan is None:
        return None
    advance = counter(step, plan.samples, f"realising case {result.case.id}")
    window: Window | None = None
    try:
        if table.spectrum == "log":
            estimate, window = _log(_blocks(rows, source, plan), len(rows), plan.rate_hz, advance, path)
        else:
            estimate = estimated(_blocks(rows, source, plan), len(rows), plan, advance)
    except InputError as error:
        raise InputError(error.fact, where=f"case {result.case.id}: {error.where}", hint=error.hint) from error
    inside = resolved(estimate.frequency_hz, plan, window)
    if window is not None:
        window = Window(np.broadcast_to(window.bin_hz, inside.shape)[inside], window.beta)
    estimate = Estimate(estimate.frequency_hz[inside], estimate.psd[:, inside], estimate.degrees_of_freedom[inside])
    noise = source.outputs(rows, estimate.frequency_hz)
    if isinstance(noise, NetworkOutputs):
        exact = network_expected(noise, plan, window)
    else:
        exact = expected_psd(noise, plan, window)
    return Realised(estimate, exact, plan.rate_hz, plan.samples, plan.seed, table.spectrum)


def _blocks(rows: FloatArray, source: AnySource, plan: Plan) -> Iterator[FloatArray]:
    """Series [n_out, B] of the outputs, block after block."""
    if isinstance(source, NetworkNoise):
        return network_blocks(rows, source, plan)
    return output_blocks(rows, source, plan)


def _log(
    blocks: Iterator[FloatArray], n_out: int, rate_hz: float, advance: Callable[[int], None], path: Path
) -> tuple[Estimate, Window]:
    """Log-spaced spectra of series [n_out, B] that come in blocks; one output at a time is held."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with scratch_file(path) as scratch:
        lengths: list[int] = []
        for block in blocks:
            scratch.write(np.ascontiguousarray(block).tobytes())
            lengths.append(block.shape[1])
            advance(block.shape[1])
        first = np.concatenate([[0], np.cumsum(lengths)[:-1]]) * n_out
        psd: list[FloatArray] = []
        for o in range(n_out):
            series = np.empty(sum(lengths))
            filled = 0
            for start, length in zip(first.tolist(), lengths, strict=True):
                scratch.seek(8 * (start + o * length))
                series[filled : filled + length] = np.frombuffer(scratch.read(8 * length))
                filled += length
            estimate, window = log_estimate(series, rate_hz)
            psd.append(estimate.psd)
    return Estimate(estimate.frequency_hz, np.concatenate(psd), estimate.degrees_of_freedom), window


def write_realisation(writer: Writer, r: Realised) -> None:
    """Put it into a case file."""
    writer.write(CASE.REALISATION_FREQUENCY, r.estimate.frequency_hz)
    writer.write(CASE.REALISATION_PSD, r.estimate.psd, units="see /output/unit, squared per Hz")
    writer.write(CASE.REALISATION_EXACT, r.exact, units="see /output/unit, squared per Hz")
    writer.write(CASE.REALISATION_DEGREES_OF_FREEDOM, r.estimate.degrees_of_freedom)
    writer.write(CASE.REALISATION_METHOD, r.method)
    writer.write(CASE.REALISATION_RATE, r.rate_hz)
    writer.write(CASE.REALISATION_SAMPLES, r.samples)
    writer.write(CASE.REALISATION_SEED, r.seed)
