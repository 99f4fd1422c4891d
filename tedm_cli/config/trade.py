"""Configuration of a trade: the variants that are compared, and the criteria by which they are."""

from __future__ import annotations

import difflib
from pathlib import Path
from typing import Annotated, Any, Literal, Self

from pydantic import Field, ValidationInfo, field_validator, model_validator

from tedm_cli.config.base import IDENTIFIER, Bounded, FileName, Form, Frequency, OneLine, Strict, load
from tedm_cli.config.correlation.case import CaseId
from tedm_cli.config.model.at_rest import Quantity
from tedm_cli.errors import ConfigError
from tedm_cli.files.provenance import ConfigFile
from tedm_cli.quantities import CRITERION_LIMIT, CRITERION_WEIGHT
from tedm_cli.trade.criteria import KINDS, CriterionKind

ONE_MHZ = 1e-3  # where a noise is compared, unless the criterion says otherwise


class ScriptTable(Strict):
    """A Python program that makes the model of a variant. It is run before the chain where it has not been run yet.

    It is run again when its arguments, the program, a Python file beside it, or a file that an argument names has
    changed. Paths are relative to the file of the trade.
    """

    file: FileName = Field(description="The program.")
    arguments: list[str] = Field(
        default=[], description="Its arguments; {build_dir} is the build folder of the variant."
    )


class VariantTable(Strict):
    """One variant: a project, and what is changed in it. Paths are relative to this file."""

    name: Annotated[str, Field(pattern=IDENTIFIER)] = Field(description="Name of the variant, also of its folder.")
    project: FileName = Field(description="Folder of the project, or its project file. Several variants may have one.")
    differs: OneLine | None = Field(default=None, description="What differs, in a sentence for the page.")
    set: dict[str, Annotated[Any, Form("value")]] = Field(
        default={},
        description='Keys of the project\'s files that have another value here: "cases.safety_factor" = 1.0. The first '
        "part is project, model, optics, cases, dynamics, thermal, balance or loads. Entries of arrays of tables go by "
        'name or id: "model.test_mass.TM1.mass_kg".',
    )
    script: ScriptTable | None = Field(default=None, description="What makes its model, where the project has none.")


class CriterionTable(Strict):
    """One criterion: a number of each variant, of which less is better unless `goal` says otherwise."""

    name: OneLine = Field(description="Name of the criterion, as the page has it.")
    kind: Annotated[str, Form(", ".join(f"`{kind}`" for kind in KINDS))] = Field(description="What the number is.")
    case: CaseId | None = Field(
        default=None,
        description="The correlation case. Else the largest value of the likely cases; of all but the diagnostic ones "
        "where none is likely.",
    )
    outputs: Annotated[list[OneLine], Field(min_length=1)] | None = Field(
        default=None, description="Outputs, of which the largest value counts. Else all that are judged."
    )
    requirement: OneLine | None = Field(default=None, description="Only what this requirement judges.")
    frequency_hz: Frequency | None = Field(default=None, description="Frequency of a noise. Else 1 mHz.")
    contributors: Literal["areas", "groups"] | None = Field(
        default=None, description='What contributors of a noise are told: "areas" (the default), or "groups" of them.'
    )
    quantities: Annotated[list[Quantity], Field(min_length=1)] | None = Field(
        default=None, description="Only these quantities at rest. Else all that are judged."
    )
    subsystem: OneLine | None = Field(
        default=None, description='Only the field of this subsystem at rest; "all" is everything in the model.'
    )
    motion: Literal["translation", "rotation"] | None = Field(
        default=None, description="How feet move: by 1 m along (the default), or by 1 rad about, each axis."
    )
    feet: Annotated[list[OneLine], Field(min_length=1)] | None = Field(
        default=None, description="Feet of the file of loads that move, each alone. Else all of them."
    )
    goal: Literal["min", "max"] | None = Field(
        default=None, description='Whether less or more is better. Else "max" for `first_frequency`, "min" for others.'
    )
    limit: Annotated[float, Bounded(CRITERION_LIMIT)] | None = Field(
        default=None,
        description="The value is judged by it: at most this, or at least this where more is better. Else 1 for "
        "ratios, 0 for `rest_violations`; others are not judged then.",
    )
    weight: Annotated[float, Bounded(CRITERION_WEIGHT)] = Field(
        default=0.0, description="Weight in the score by which variants are ranked; without any there is no score."
    )

    @field_validator("kind")
    @classmethod
    def _known(cls, value: str) -> str:
        if value not in KINDS:
            near = difflib.get_close_matches(value, KINDS, n=1)
            raise ValueError(f"unknown kind {value!r}; did you mean {near[0]}?" if near else _unknown(value))
        return value

    @field_validator(
        "case", "outputs", "requirement", "frequency_hz", "contributors", "quantities", "subsystem", "motion", "feet"
    )
    @classmethod
    def _of_its_kind(cls, value: Any, info: ValidationInfo) -> Any:
        kind = info.data.get("kind")
        if value is not None and kind is not None and info.field_name not in KINDS[kind].keys:
            keys = ", ".join(KINDS[kind].keys) or "no such keys"
            raise ValueError(f"a criterion of the kind {kind} has no {info.field_name}; it has {keys}")
        return value

    @model_validator(mode="after")
    def _complete(self) -> Self:
        if missing := [key for key in self.of_kind.needed if getattr(self, key) is None]:
            raise ValueError(f"a criterion of the kind {self.kind} needs {', '.join(missing)}")
        return self

    @property
    def of_kind(self) -> CriterionKind:
        """What its kind is."""
        return KINDS[self.kind]

    @property
    def better(self) -> Literal["min", "max"]:
        """Whether less or more is better."""
        return self.goal or self.of_kind.goal

    @property
    def judged_by(self) -> float | None:
        """Its limit, or that of its kind where less is better."""
        return self.limit if self.limit is not None or self.better == "max" else self.of_kind.limit

    def passes(self, value: float) -> bool | None:
        """The verdict on a value; None where it is not judged."""
        limit = self.judged_by
        return None if limit is None else value <= limit if self.better == "min" else value >= limit


def _unknown(value: str) -> str:
    return f"unknown kind {value!r}; there are {', '.join(KINDS)}"


class TradeConfig(Strict):
    """A trade: variants of a design, and the criteria by which they are compared."""

    title: OneLine = Field(default="Trade of variants", description="Title of the page.")
    variants: list[VariantTable] = Field(
        alias="variant", min_length=1, description="The variants. What has changed is told against the first."
    )
    criteria: list[CriterionTable] = Field(alias="criterion", min_length=1, description="The criteria.")


def load_trade(path: Path) -> tuple[ConfigFile, TradeConfig]:
    """Read the file of a trade.

    Raises
    ------
    InputError : there is no such file.
    ConfigError : what is wrong in it; two variants, or two criteria, of one name.
    """
    file, config = load(TradeConfig, path, hint="name the file of the trade: tedm trade variants.toml")
    problems = []
    # Names of variants are names of folders, which some file systems do not tell apart by case.
    named = (
        ("variant", [variant.name.lower() for variant in config.variants]),
        ("criterion", [criterion.name for criterion in config.criteria]),
    )
    for table, names in named:
        for number, name in enumerate(names):
            if (first := names.index(name)) != number:
                problems.append((f"{table}[{number}].name", f"has the name of {table}[{first}]"))
    if problems:
        raise ConfigError(problems, where=str(path))
    return file, config
