"""Configuration of the noise cases: frequencies, correlation cases, requirements; temperatures are in other modules."""

from __future__ import annotations

import difflib
from collections.abc import Mapping, Sequence
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Annotated, Any

from pydantic import Field, model_validator

from tedm_cli.arrays import FloatArray
from tedm_cli.config.base import Bounded, Frequency, Strict, named_by_project, read_toml, validate
from tedm_cli.config.correlation.case import CaseTable
from tedm_cli.config.requirements import RequirementTable
from tedm_cli.config.series import RealisationTable, SeriesTable
from tedm_cli.config.temperature.noise import TemperatureTable
from tedm_cli.config.uncertainty import CasesUncertainty
from tedm_cli.errors import ConfigError, UsageError
from tedm_cli.files.provenance import ConfigFile
from tedm_cli.noise.correlation import CorrelationCase
from tedm_cli.noise.realisation import Plan
from tedm_cli.noise.requirements import AppliedRequirement, Criteria, frequency_grid
from tedm_cli.noise.spectral_estimate import samples_wanted, segment_length
from tedm_cli.quantities import GRID_POINTS, SAFETY_FACTOR, SAMPLES

MOST_RATE = 65_536  # samples in a period of the lowest frequency: 8 million in a filter
_RATE = 2.5  # samples per period of the highest frequency, where the rate is not given


class FrequencyTable(Strict):
    """The frequencies of all spectra, evenly spaced in the logarithm."""

    min_hz: Frequency = Field(default=1e-4, description="Lowest frequency.")
    max_hz: Frequency = Field(default=0.1, description="Highest frequency.")
    points: Annotated[int, Bounded(GRID_POINTS)] = Field(
        default=301,
        description="Number of frequencies, evenly spaced in the logarithm. Band edges of the requirements "
        "and 1 mHz are added.",
    )

    @model_validator(mode="after")
    def _increasing(self) -> FrequencyTable:
        if self.min_hz >= self.max_hz:
            raise ValueError(f"min_hz {self.min_hz:g} is not below max_hz {self.max_hz:g}")
        return self


class CasesConfig(Strict):
    """Temperature noise, frequencies, correlation cases, requirements. Paths are relative to this file."""

    safety_factor: Annotated[float, Bounded(SAFETY_FACTOR)] = Field(
        default=2.0,
        description="Multiplies noise amplitudes before they are compared to a requirement (Montemurro 2004, "
        "section 3.5).",
    )
    temperature: TemperatureTable = Field(default=TemperatureTable(), description="Temperature noise of the areas.")
    frequency: FrequencyTable = Field(default=FrequencyTable(), description="The frequencies of all spectra.")
    cases: list[CaseTable] = Field(alias="case", min_length=1, description="The correlation cases.")
    requirements: list[RequirementTable] = Field(
        alias="requirement", default_factory=list, description="The requirements. Without any, nothing is judged."
    )
    realisation: RealisationTable | None = Field(
        default=None,
        description="A realisation of the noise in time, beside the exact spectra. Without it there is none.",
    )
    series: list[SeriesTable] = Field(
        default_factory=list, description="Temperature series for `tedm run-series` and `tedm simulate --series`."
    )
    uncertainty: CasesUncertainty = Field(
        default=CasesUncertainty(), description="Uncertain levels, and how the verdicts are drawn."
    )

    @property
    def ids(self) -> list[str]:
        """Ids of the cases, in the order of the file."""
        return [table.id for table in self.cases]

    @property
    def ids_of_areas(self) -> list[str]:
        """Ids of the cases whose temperatures are of areas, and not of the thermal network."""
        return [table.id for table in self.cases if table.thermal is None]

    def case(self, case_id: str, *, where: str = "") -> CorrelationCase:
        """The case of this id; raise `UsageError` when there is none. `where`, the file, is for messages."""
        return self.case_table(case_id, where=where).correlation_case(where)

    def case_table(self, case_id: str, *, where: str = "") -> CaseTable:
        """The table of the case of this id, without reading its matrix; raises as `case` does."""
        for table in self.cases:
            if table.id == case_id:
                return table
        near = difflib.get_close_matches(case_id, self.ids, n=1, cutoff=0.3)
        raise UsageError(
            f"there is no case {case_id!r}; there are: {', '.join(self.ids)}",
            where=where,
            hint=f"did you mean {near[0]}?" if near else "",
        )

    def within(self, case_id: str) -> list[int]:
        """Numbers of the tables of gradients within areas that a case has."""
        found = enumerate(self.temperature.within)
        return [number for number, table in found if table.is_in(case_id)]

    @property
    def needs_adjoint(self) -> bool:
        """Whether any case takes something of adjoint.h5."""
        return any(self.within(case_id) for case_id in self.ids)

    def applied_requirements(self) -> list[AppliedRequirement]:
        """Requirements with the outputs they judge."""
        return [table.applied() for table in self.requirements]

    def criteria(self) -> Criteria:
        """What the outputs are judged by."""
        return Criteria(tuple(self.applied_requirements()), self.safety_factor)

    @property
    def tables(self) -> list[Path]:
        """Files of the requirements."""
        return list(dict.fromkeys(Path(table.table) for table in self.requirements if table.table is not None))

    @property
    def matrices(self) -> list[Path]:
        """Files of the cases' correlation matrices."""
        return list(dict.fromkeys(Path(table.matrix) for table in self.cases if table.matrix is not None))

    def lowest_band_hz(self) -> float:
        """Lowest edge of all requirements' bands, or of the frequencies where nothing is required."""
        edges = [table.requirement().band_hz[0] for table in self.requirements]
        return min(edges, default=self.frequency.min_hz)

    def realised_frequencies(self, table: RealisationTable) -> tuple[float, float]:
        """Rate of the samples, and lowest frequency of the estimate, in Hz."""
        rate = table.rate_hz if table.rate_hz is not None else _RATE * self.frequency.max_hz
        return rate, table.lowest_hz if table.lowest_hz is not None else self.lowest_band_hz()

    def realisation_plan(self) -> Plan | None:
        """What to realise of each case, where that is configured."""
        table = self.realisation
        if table is None:
            return None
        rate, lowest = self.realised_frequencies(table)
        samples = table.samples or samples_wanted(rate, lowest, table.tolerance, table.confidence)
        return Plan(rate, samples, table.seed, self.frequency.min_hz, self.frequency.max_hz, lowest)

    def frequency_hz(self) -> FloatArray:
        """Frequency grid [F] in Hz that holds the band edges of all requirements."""
        bands = [table.requirement().grid_hz for table in self.requirements]
        return frequency_grid(self.frequency.min_hz, self.frequency.max_hz, self.frequency.points, bands)


def load_cases(path: Path, changes: Mapping[str, Any] | None = None) -> tuple[ConfigFile, CasesConfig]:
    """Read and check a cases file, with `changes` in place of what it has under the same keys.

    Raises `InputError` when it is not there and `ConfigError` with its problems: first those of single tables, then
    those between tables (an id used twice, an output judged twice by one requirement, a band outside the frequencies).
    Requirements given as tables are read for their bands. Paths of files are made relative to the current folder.
    """
    file, data = read_toml(path, hint=named_by_project("cases"))
    where = f"{path}, with {', '.join(changes)} as given" if changes else str(path)
    config = validate(CasesConfig, {**data, **(changes or {})}, where=where)
    config = _beside(path.parent, config)
    problems: list[tuple[str, str]] = []
    # Ids name files: 3 and 03, or 4b and 4B on some file systems, would be one file.
    names = [case_id.lstrip("0").lower() for case_id in config.ids]
    for number, name in enumerate(names):
        first = names.index(name)
        if first != number:
            fact = f"{config.ids[number]!r} names the same case file as the id {config.ids[first]!r} of case[{first}]"
            problems.append((f"case[{number}].id", fact))
    seen: dict[tuple[str, str], str] = {}
    low, high = config.frequency.min_hz, config.frequency.max_hz
    for number, table in enumerate(config.requirements):
        band = table.requirement().band_hz
        if band[0] < low or band[1] > high:
            fact = f"its band {band[0]:g} to {band[1]:g} Hz is outside [frequency] {low:g} to {high:g} Hz"
            problems.append((f"requirement[{number}].name", fact))
        for index, output in enumerate(table.outputs):
            path_here = f"requirement[{number}].outputs[{index}]"
            before = seen.setdefault((table.name, output), path_here)
            if before != path_here:
                problems.append((path_here, f"{table.name} judges {output} already in {before}"))
    problems += config.temperature.filter_problems(low, high)
    for number, of in enumerate(config.temperature.within):
        for wanted in of.cases or ():
            if not any(fnmatchcase(case_id, wanted) for case_id in config.ids):
                fact = f"there is no case {wanted!r}; there are: {', '.join(config.ids)}"
                problems.append((f"temperature.within[{number}].cases", fact))
    problems += config.uncertainty.problems()
    if config.uncertainty.disturbance and len(config.ids_of_areas) == len(config.ids):
        fact = "no case is of the thermal network (thermal = true), whose disturbances these are"
        problems.append(("uncertainty.disturbance[0].disturbances", fact))
    problems += _realisation_problems(config)
    names_of_series = [table.name for table in config.series]
    for number, name in enumerate(names_of_series):
        if name.lower() in [other.lower() for other in names_of_series[:number]]:
            problems.append((f"series[{number}].name", f"{name!r} is there twice"))
        if f"_{name.lower()}" in names:
            fact = f"{name!r} names the same file of a simulation as the case id '_{name}'"
            problems.append((f"series[{number}].name", fact))
    if problems:
        raise ConfigError(problems, where=where)
    return file, config


def select_cases(path: Path, wanted: Sequence[str]) -> list[str]:
    """Case ids of a cases file for what the user typed, `all` included; `UsageError` lists what exists."""
    _, config = load_cases(path)
    if list(wanted) == ["all"]:
        return config.ids
    return list(dict.fromkeys(config.case_table(case_id, where=str(path)).id for case_id in wanted))


def _beside(folder: Path, config: CasesConfig) -> CasesConfig:
    """The configuration with the paths of its files, which are relative to `folder`, made usable from here."""
    cases = [c.model_copy(update={"matrix": str(folder / c.matrix)}) if c.matrix else c for c in config.cases]
    requirements = [
        r.model_copy(update={"table": str(folder / r.table)}) if r.table else r for r in config.requirements
    ]
    uncertainty, mesh = config.uncertainty, config.uncertainty.mesh
    if mesh is not None:
        beside = mesh.model_copy(update={"other": str(folder / mesh.other)})
        uncertainty = uncertainty.model_copy(update={"mesh": beside})
    return config.model_copy(update={"cases": cases, "requirements": requirements, "uncertainty": uncertainty})


def _realisation_problems(config: CasesConfig) -> list[tuple[str, str]]:
    table, f = config.realisation, config.frequency
    if table is None:
        return []
    rate, lowest = config.realised_frequencies(table)
    if rate > MOST_RATE * lowest:
        fact = f"{rate:g} Hz are {rate / lowest:,.0f} samples in a period of lowest_hz {lowest:g} Hz"
        return [("realisation.rate_hz", f"{fact}; at most {MOST_RATE:,}, as filters of 128 periods are held")]
    plan = config.realisation_plan()
    assert plan is not None
    problems = []
    if fact := SAMPLES.fact(plan.samples):
        fact = f"a PSD within {table.tolerance:g} with probability {table.confidence:g} takes too many: {fact}"
        problems.append(("realisation.tolerance", f"{fact}, which take hours for each case"))
    if plan.rate_hz < 2.0 * f.max_hz:
        fact = f"{plan.rate_hz:g} Hz do not reach [frequency] max_hz {f.max_hz:g}; it must be at least {2 * f.max_hz:g}"
        problems.append(("realisation.rate_hz", fact))
    if not f.min_hz <= plan.lowest_hz < f.max_hz:
        fact = f"{plan.lowest_hz:g} Hz is outside [frequency] {f.min_hz:g} to {f.max_hz:g} Hz"
        problems.append(("realisation.lowest_hz", fact))
    segment = segment_length(plan.rate_hz, plan.lowest_hz)
    if plan.samples < segment:
        fact = f"{plan.samples:,} samples are less than one segment of {segment:,} for {plan.lowest_hz:g} Hz"
        problems.append(("realisation.samples", fact))
    return problems
