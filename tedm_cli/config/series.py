"""Configuration of time series: those that are read, and the realisation that checks the exact spectra."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, model_validator

from tedm_cli.config.base import IDENTIFIER, Bounded, Duration, FileName, Frequency, Probability, Strict
from tedm_cli.quantities import SAMPLES, SEED, SPECTRAL_TOLERANCE

Names = Annotated[list[Annotated[str, Field(min_length=1)]], Field(min_length=1)]

Spectrum = Literal["welch", "log"]


class RealisationTable(Strict):
    """A realisation of the temperature noise in the time domain, beside the exact spectra of every case.

    By default it is long enough for the PSD at `lowest_hz` to be within ±`tolerance` with probability `confidence`,
    estimated by Welch's method.
    """

    seed: Annotated[int, Bounded(SEED)]
    rate_hz: Frequency | None = None
    lowest_hz: Frequency | None = None
    tolerance: Annotated[float, Bounded(SPECTRAL_TOLERANCE)] = 0.1
    confidence: Probability = 0.95
    samples: Annotated[int, Bounded(SAMPLES)] | None = None
    spectrum: Spectrum = "welch"

    @model_validator(mode="after")
    def _one_length(self) -> RealisationTable:
        if self.samples is not None and "tolerance" in self.model_fields_set:
            raise ValueError("give samples, or tolerance from which they follow, not both")
        return self


class SeriesTable(Strict):
    """A measured or simulated temperature series: `time_s`, and a column for each area, group or shield, or `all`.

    `unit` of its temperatures, of which only differences count. `weights`: a CSV node,area,weight that makes the
    temperature of areas from columns of nodes.
    """

    name: Annotated[str, Field(pattern=IDENTIFIER)]
    file: FileName
    remove: Literal["nothing", "mean", "linear"]
    unit: Literal["K", "degC"] = "K"
    weights: FileName | None = None
    constant: Names | None = None
    resample_s: Duration | None = None
    method: Literal["linear", "polyphase"] | None = None
    max_gap_s: Duration | None = None
    lowest_hz: Frequency | None = None
    spectrum: Spectrum = "welch"
    confidence: Probability = 0.95

    @model_validator(mode="after")
    def _fits_together(self) -> SeriesTable:
        if (self.resample_s is None) != (self.method is None):
            raise ValueError('resample_s and method ("linear" or "polyphase") go together')
        if self.max_gap_s is not None and self.method != "linear":
            raise ValueError('max_gap_s is for irregular stamps, which method = "linear" takes')
        if self.unit == "degC" and self.remove == "nothing":
            raise ValueError(
                'unit = "degC" needs remove = "mean" or "linear"; with remove = "nothing" the values are deviations,'
                ' which need unit = "K"'
            )
        if self.spectrum == "log" and self.lowest_hz is not None:
            raise ValueError("a log-spaced spectrum begins where the series allows; lowest_hz is for welch")
        return self
