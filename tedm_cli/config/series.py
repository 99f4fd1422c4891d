"""Configuration of time series: those that are read, and the realisation that checks the exact spectra."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, model_validator

from tedm_cli.config.base import IDENTIFIER, Strict

Names = Annotated[list[Annotated[str, Field(min_length=1)]], Field(min_length=1)]

Spectrum = Literal["welch", "log"]


class RealisationTable(Strict):
    """A realisation of the temperature noise in the time domain, beside the exact spectra of every case.

    By default it is long enough for the PSD at `lowest_hz` to be within ±`tolerance` with probability `confidence`,
    estimated by Welch's method.
    """

    seed: int = Field(ge=0)
    rate_hz: float | None = Field(default=None, gt=0.0)
    lowest_hz: float | None = Field(default=None, gt=0.0)
    tolerance: float = Field(default=0.1, gt=0.0, lt=1.0)
    confidence: float = Field(default=0.95, gt=0.0, lt=1.0)
    samples: int | None = Field(default=None, ge=1)
    spectrum: Spectrum = "welch"

    @model_validator(mode="after")
    def _one_length(self) -> RealisationTable:
        if self.samples is not None and "tolerance" in self.model_fields_set:
            raise ValueError("give samples, or tolerance from which they follow, not both")
        return self


class SeriesTable(Strict):
    """A measured or simulated temperature series: `time_s`, and a column for each area, group or shield, or `all`."""

    name: Annotated[str, Field(pattern=IDENTIFIER)]
    file: str = Field(min_length=1)
    remove: Literal["nothing", "mean", "linear"]
    constant: Names | None = None
    resample_s: float | None = Field(default=None, gt=0.0)
    method: Literal["linear", "polyphase"] | None = None
    max_gap_s: float | None = Field(default=None, gt=0.0)
    lowest_hz: float | None = Field(default=None, gt=0.0)
    spectrum: Spectrum = "welch"
    confidence: float = Field(default=0.95, gt=0.0, lt=1.0)

    @model_validator(mode="after")
    def _fits_together(self) -> SeriesTable:
        if (self.resample_s is None) != (self.method is None):
            raise ValueError('resample_s and method ("linear" or "polyphase") go together')
        if self.max_gap_s is not None and self.method != "linear":
            raise ValueError('max_gap_s is for irregular stamps, which method = "linear" takes')
        if self.spectrum == "log" and self.lowest_hz is not None:
            raise ValueError("a log-spaced spectrum begins where the series allows; lowest_hz is for welch")
        return self
