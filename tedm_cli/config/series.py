"""Configuration of time series: those that are read, and the realisation that checks the exact spectra."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, model_validator

from tedm_cli.config.base import IDENTIFIER, Bounded, Duration, FileName, Frequency, Probability, Strict
from tedm_cli.quantities import SAMPLES, SEED, SPECTRAL_TOLERANCE, TEMPERATURE

Names = Annotated[list[Annotated[str, Field(min_length=1)]], Field(min_length=1)]

Spectrum = Literal["welch", "log"]


class RealisationTable(Strict):
    """A realisation of the temperature noise in the time domain, beside the exact spectra of every case.

    It is as long as `tolerance` and `confidence` take, unless `samples` says otherwise.
    """

    seed: Annotated[int, Bounded(SEED)] = Field(
        description="Seed of the random numbers: the same seed gives the same realisation."
    )
    rate_hz: Frequency | None = Field(
        default=None, description="Samples per second. Else 2.5 times the highest frequency."
    )
    lowest_hz: Frequency | None = Field(
        default=None,
        description="Lowest frequency of the estimated spectra. Else the lowest band edge of the requirements.",
    )
    tolerance: Annotated[float, Bounded(SPECTRAL_TOLERANCE)] = Field(
        default=0.1,
        description="Half width of the interval of a PSD at `lowest_hz`, relative, from which the number of "
        "samples follows.",
    )
    confidence: Probability = Field(
        default=0.95, description="Probability with which that interval holds the expectation."
    )
    samples: Annotated[int, Bounded(SAMPLES)] | None = Field(
        default=None, description="Number of samples, in place of `tolerance`."
    )
    spectrum: Spectrum = Field(
        default="welch", description="The estimate: Welch's method, or log-spaced frequencies by speckit."
    )

    @model_validator(mode="after")
    def _one_length(self) -> RealisationTable:
        if self.samples is not None and "tolerance" in self.model_fields_set:
            raise ValueError("give samples, or tolerance from which they follow, not both")
        return self


class SeriesTable(Strict):
    """A measured or simulated temperature series."""

    name: Annotated[str, Field(pattern=IDENTIFIER)] = Field(
        description="Name of the series, by which commands and files name it."
    )
    file: FileName = Field(
        description="CSV or HDF5 with `time_s`, and a column for each area, group or shield, or `all`; of nodes a "
        "column for each. Or an ESATAN-TMS file `.TMD`, whose columns are the numbers of its nodes."
    )
    of: Literal["areas", "nodes"] = Field(
        default="areas",
        description="Whose temperatures they are: of thermal areas, or of the nodes that the thermal model's file maps "
        "on the finite elements.",
    )
    remove: Literal["nothing", "mean", "linear", "reference"] = Field(
        description="What is taken off each column: nothing where it holds deviations, else its mean, or mean "
        "and straight line, or the temperature `reference`."
    )
    reference: Annotated[float, Bounded(TEMPERATURE)] | None = Field(
        default=None,
        description="Temperature at which the outputs are zero, in the unit of the series. Gradients are zero there.",
    )
    unit: Literal["K", "degC"] | None = Field(
        default=None,
        description="Unit of the temperatures, of which only differences count. Else K, or what a TMD file says. "
        "Gradients are in K/m whatever it is.",
    )
    weights: FileName | None = Field(
        default=None, description="A CSV `node,area,weight` that makes temperatures of areas from columns of nodes."
    )
    constant: Names | None = Field(
        default=None, description="Name patterns of areas or nodes that keep their temperature and need no column."
    )
    unused: Names | None = Field(
        default=None,
        description="Name patterns of columns of a series of nodes that are no node on the model, and are not used. "
        "Nodes of the network and of a TMD file need none.",
    )
    resample_s: Duration | None = Field(default=None, description="Step to which the series is taken, with `method`.")
    method: Literal["linear", "polyphase"] | None = Field(
        default=None,
        description='How: "linear" takes irregular stamps to straight lines between them, "polyphase" regular '
        "ones through a low-pass.",
    )
    max_gap_s: Duration | None = Field(default=None, description='Longest gap that "linear" crosses. Else three steps.')
    lowest_hz: Frequency | None = Field(
        default=None, description="Lowest frequency of Welch's spectra. Else the lowest band edge of the requirements."
    )
    spectrum: Spectrum = Field(
        default="welch", description="The estimate: Welch's method, or log-spaced frequencies by speckit."
    )
    confidence: Probability = Field(
        default=0.95, description="Probability of the intervals that are told of the estimate."
    )

    @model_validator(mode="after")
    def _fits_together(self) -> SeriesTable:
        if (self.resample_s is None) != (self.method is None):
            raise ValueError('resample_s and method ("linear" or "polyphase") go together')
        if self.max_gap_s is not None and self.method != "linear":
            raise ValueError('max_gap_s is for irregular stamps, which method = "linear" takes')
        if self.unit == "degC" and self.remove == "nothing":
            raise ValueError(
                'unit = "degC" needs remove = "mean", "linear" or "reference"; with remove = "nothing" the values are'
                ' deviations, which need unit = "K"'
            )
        if (self.remove == "reference") != (self.reference is not None):
            raise ValueError('reference and remove = "reference" go together')
        if self.of == "nodes" and self.weights is not None:
            raise ValueError('weights make areas of nodes; with of = "nodes" the map of the thermal model does that')
        if self.of == "areas" and self.unused is not None:
            raise ValueError('unused is for of = "nodes"')
        if self.spectrum == "log" and self.lowest_hz is not None:
            raise ValueError("a log-spaced spectrum begins where the series allows; lowest_hz is for welch")
        return self
