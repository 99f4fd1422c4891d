"""Configuration of the noise cases: frequencies, correlation cases, requirements; temperatures are in other modules."""

from __future__ import annotations

import difflib
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Field, field_validator, model_validator

from tedm_cli.config.base import Strict, load
from tedm_cli.config.series import RealisationTable, SeriesTable
from tedm_cli.config.temperature import TemperatureTable
from tedm_cli.errors import ConfigError, UsageError
from tedm_cli.noise.correlation import BlockSelector, CorrelationCase
from tedm_cli.noise.realisation import Plan
from tedm_cli.noise.requirements import PRESETS, AppliedRequirement, Array, frequency_grid
from tedm_cli.noise.spectral_estimate import samples_wanted, segment_length
from tedm_cli.provenance import ConfigFile

_RATE = 2.5  # samples per period of the highest frequency, where the rate is not given
Names = Annotated[list[Annotated[str, Field(min_length=1)]], Field(min_length=1)]


def _identifier(value: Any) -> Any:
    """Case ids may be written as numbers."""
    return str(value) if isinstance(value, int) and not isinstance(value, bool) else value


class FrequencyTable(Strict):
    """Logarithmic frequency grid; band edges of the requirements and 1 mHz are added to it."""

    min_hz: float = Field(default=1e-4, gt=0.0)
    max_hz: float = Field(default=0.1, gt=0.0)
    points: int = Field(default=301, ge=2, le=100_000)

    @model_validator(mode="after")
    def _increasing(self) -> FrequencyTable:
        if self.min_hz >= self.max_hz:
            raise ValueError(f"min_hz {self.min_hz:g} is not below max_hz {self.max_hz:g}")
        return self


class BlockTable(Strict):
    """Areas of one block: each key given narrows the choice, any of its values will do; `areas` are name patterns."""

    groups: Names | None = None
    shield: Annotated[list[Literal["inside", "outside"]], Field(min_length=1)] | None = None
    side: Annotated[list[Literal["+y", "-y", "mid"]], Field(min_length=1)] | None = None
    areas: Names | None = None
    each_alone: bool = False

    @model_validator(mode="after")
    def _selects(self) -> BlockTable:
        if self.groups is None and self.shield is None and self.side is None and self.areas is None:
            raise ValueError('selects nothing: give groups, shield, side or areas (areas = ["*"] for all)')
        return self

    def selector(self) -> BlockSelector:
        """The block as the correlation model takes it."""
        return BlockSelector(
            groups=tuple(self.groups or ()),
            shield=tuple(self.shield or ()),
            side=tuple(self.side or ()),
            areas=tuple(self.areas or ()),
            each_alone=self.each_alone,
        )


class CaseTable(Strict):
    """One correlation case: areas in no block are silent."""

    id: Annotated[str, BeforeValidator(_identifier), Field(pattern=r"^[A-Za-z0-9_-]+$")]
    title: str = Field(min_length=1)
    reason: str = ""
    blocks: list[BlockTable] = Field(min_length=1)


class RequirementTable(Strict):
    """A named requirement and the labels of the outputs it judges."""

    name: str
    outputs: Names

    @field_validator("name")
    @classmethod
    def _known(cls, value: str) -> str:
        if value not in PRESETS:
            near = difflib.get_close_matches(value, PRESETS, n=1)
            hint = f"did you mean {near[0]}?" if near else f"known: {', '.join(PRESETS)}"
            raise ValueError(f"unknown requirement {value!r}; {hint}")
        return value


class CasesConfig(Strict):
    """A whole cases file. `safety_factor` multiplies noise amplitudes in verdicts (Montemurro 2004, section 3.5)."""

    safety_factor: float = Field(default=2.0, gt=0.0)
    temperature: TemperatureTable = TemperatureTable()
    frequency: FrequencyTable = FrequencyTable()
    cases: list[CaseTable] = Field(alias="case", min_length=1)
    requirements: list[RequirementTable] = Field(alias="requirement", default_factory=list)
    realisation: RealisationTable | None = None
    series: list[SeriesTable] = Field(default_factory=list)

    @property
    def ids(self) -> list[str]:
        """Ids of the cases, in the order of the file."""
        return [table.id for table in self.cases]

    def case(self, case_id: str, *, where: str = "") -> CorrelationCase:
        """The case of this id; raise `UsageError` when there is none. `where`, the file, is for messages."""
        for table in self.cases:
            if table.id == case_id:
                return CorrelationCase(table.id, table.title, tuple(b.selector() for b in table.blocks), where)
        near = difflib.get_close_matches(case_id, self.ids, n=1, cutoff=0.3)
        raise UsageError(
            f"there is no case {case_id!r}; there are: {', '.join(self.ids)}",
            where=where,
            hint=f"did you mean {near[0]}?" if near else "",
        )

    def applied_requirements(self) -> list[AppliedRequirement]:
        """Requirements with the outputs they judge."""
        return [AppliedRequirement(PRESETS[table.name], tuple(table.outputs)) for table in self.requirements]

    def lowest_band_hz(self) -> float:
        """Lowest edge of all requirements' bands, or of the frequencies where nothing is required."""
        edges = [PRESETS[table.name].band_hz[0] for table in self.requirements]
        return min(edges, default=self.frequency.min_hz)

    def realisation_plan(self) -> Plan | None:
        """What to realise of each case, where that is configured."""
        table = self.realisation
        if table is None:
            return None
        rate = table.rate_hz if table.rate_hz is not None else _RATE * self.frequency.max_hz
        lowest = table.lowest_hz if table.lowest_hz is not None else self.lowest_band_hz()
        samples = table.samples or samples_wanted(rate, lowest, table.tolerance, table.confidence)
        return Plan(rate, samples, table.seed, self.frequency.min_hz, self.frequency.max_hz, lowest)

    def frequency_hz(self) -> Array:
        """Frequency grid [F] in Hz that holds the band edges of all requirements."""
        bands: Sequence[Sequence[float]] = [PRESETS[table.name].grid_hz for table in self.requirements]
        return frequency_grid(self.frequency.min_hz, self.frequency.max_hz, self.frequency.points, bands)


def load_cases(path: Path) -> tuple[ConfigFile, CasesConfig]:
    """Read and check a cases file.

    Raises `InputError` when it is not there and `ConfigError` with its problems: first those of single tables, then
    those between tables (an id used twice, an output judged twice by one requirement, a band outside the frequencies).
    """
    file, config = load(CasesConfig, path)
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
        band = PRESETS[table.name].band_hz
        if band[0] < low or band[1] > high:
            fact = f"its band {band[0]:g} to {band[1]:g} Hz is outside [frequency] {low:g} to {high:g} Hz"
            problems.append((f"requirement[{number}].name", fact))
        for index, output in enumerate(table.outputs):
            path_here = f"requirement[{number}].outputs[{index}]"
            before = seen.setdefault((table.name, output), path_here)
            if before != path_here:
                problems.append((path_here, f"{table.name} judges {output} already in {before}"))
    problems += _realisation_problems(config)
    names_of_series = [table.name for table in config.series]
    for number, name in enumerate(names_of_series):
        if name.lower() in [other.lower() for other in names_of_series[:number]]:
            problems.append((f"series[{number}].name", f"{name!r} is there twice"))
    if problems:
        raise ConfigError(problems, where=str(path))
    return file, config


def _realisation_problems(config: CasesConfig) -> list[tuple[str, str]]:
    plan, f = config.realisation_plan(), config.frequency
    if plan is None:
        return []
    problems = []
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
