"""Configuration of what is uncertain: materials, thicknesses and positions of the model, levels of the temperatures.

Every deviation has a key of its own by what it is: `..sigma` is one standard deviation, `..half_width` half the width
of a uniform distribution; relative ones have no unit, absolute ones have it in the key.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated, ClassVar, Literal

from pydantic import Field, field_validator, model_validator

from tedm_cli.config.base import IDENTIFIER, Bounded, FileName, OneLine, Strict
from tedm_cli.config.correlation.case import SelectorTable
from tedm_cli.config.correlation.uncertain import CorrelationTable, Pairs, correlation_problems, pairs_of
from tedm_cli.config.model.areas import Ids, ranges_increase
from tedm_cli.quantities import (
    DRAWS,
    EXPANSION_DEVIATION,
    MESH_DEVIATION,
    MESH_ORDER,
    MESH_REFINEMENT,
    POSITION_DEVIATION,
    RELATIVE_DEVIATION,
    SEED,
)
from tedm_cli.uncertainty.parameters import (
    EXPANSION,
    LARGEST_NORMAL,
    LEVEL,
    LOGNORMAL,
    NORMAL,
    POSITION,
    POSITIVE,
    THICKNESS,
    UNIFORM,
    Parameter,
)

Relative = Annotated[float, Bounded(RELATIVE_DEVIATION)]
Name = Annotated[str, Field(pattern=IDENTIFIER)]

Axis = Literal["x", "y", "z"]
AXES: tuple[Axis, ...] = ("x", "y", "z")
_UNIFORM_BELOW = 1.0  # half width of what stays positive


class _ParameterTable(Strict):
    """What all uncertain parameters have: a name, a distribution, and where it is from."""

    name: Name = Field(description="Name of the parameter, in prints, results and correlations.")
    distribution: Literal["normal", "uniform", "lognormal"] | None = Field(
        default=None,
        description='"normal" (the default) or "lognormal" with a sigma, "uniform" (the default) with a half width.',
    )
    source: OneLine = Field(description="Where the deviation is from: a data sheet, a measurement, or an assumption.")
    quantity: ClassVar[str] = ""

    def of_quantity(self) -> str:
        """What is uncertain, as a parameter has it."""
        return self.quantity

    def _given(self) -> list[tuple[str, float, str]]:
        """(key, deviation, unit) of the deviations that are given."""
        units = {"_m": "m", "_per_K": "1/K"}
        found = []
        for key in type(self).model_fields:
            if "sigma" in key or "half_width" in key:
                value = getattr(self, key)
                unit = next((u for end, u in units.items() if key.endswith(end)), "1")
                found += [] if value is None else [(key, float(value), unit)]
        return found

    @property
    def relative(self) -> bool:
        """Whether the deviation is relative."""
        return self._given()[0][2] == "1"

    @model_validator(mode="after")
    def _one_deviation_that_fits(self) -> _ParameterTable:
        keys = [key for key in type(self).model_fields if "sigma" in key or "half_width" in key]
        given = self._given()
        if len(given) != 1:
            found = " and ".join(key for key, _, _ in given) or "none"
            raise ValueError(f"give one of {', '.join(keys)} (found {found})")
        key, deviation, unit = given[0]
        wide = "half_width" in key
        if self.distribution is not None and wide != (self.distribution == UNIFORM):
            wanted = "a half width" if self.distribution == UNIFORM else "a sigma"
            raise ValueError(f'distribution = "{self.distribution}" needs {wanted}, found {key}')
        if self.distribution == LOGNORMAL and unit != "1":
            raise ValueError(f"a lognormal deviation is of the logarithm, and relative; found {key}")
        if self.of_quantity() in POSITIVE and self.distribution != LOGNORMAL:
            most = _UNIFORM_BELOW if wide else LARGEST_NORMAL
            if deviation >= most if wide else deviation > most:
                than = "below" if wide else "at most"
                raise ValueError(
                    f"{key} = {deviation:g} could make the {self.of_quantity()} negative: it must be {than} {most:g};"
                    f' wider ones are relative_sigma with distribution = "lognormal"'
                )
        return self

    def parameter(self, of: str, name: str = "") -> Parameter:
        """As the propagation takes it; `of`: of which materials, areas or the like, in words."""
        key, deviation, unit = self._given()[0]
        default = UNIFORM if "half_width" in key else NORMAL
        return Parameter(
            name or self.name, self.of_quantity(), of, deviation, self.distribution or default, unit, self.source
        )


class _RelativeTable(_ParameterTable):
    """A parameter whose deviation is relative."""

    relative_sigma: Relative | None = Field(
        default=None, description="One standard deviation, relative; of a lognormal parameter that of its logarithm."
    )
    relative_half_width: Relative | None = Field(
        default=None, description="Half the width of a uniform distribution, relative."
    )


class MaterialDeviation(_RelativeTable):
    """A property of one material, or of several that deviate together."""

    material: Ids | None = Field(default=None, description="Ids of materials of the deck, MAT1, MAT9 or MAT11.")
    property: Ids | None = Field(
        default=None, description="Ids of properties of elements, in place of `material`: all materials that they name."
    )
    of: Literal["expansion", "modulus", "density"] = Field(
        description='What is uncertain. Moduli of a material grow together: its Poisson ratio stays. "density" leaves '
        "out non-structural and concentrated mass."
    )
    absolute_sigma_per_K: Annotated[float, Bounded(EXPANSION_DEVIATION)] | None = Field(
        default=None,
        description="One standard deviation of an expansion. Expansions near zero, as of glass ceramics, need absolute "
        "deviations.",
    )
    absolute_half_width_per_K: Annotated[float, Bounded(EXPANSION_DEVIATION)] | None = Field(
        default=None, description="Half the width of a uniform distribution of an expansion."
    )

    _order = field_validator("material", "property")(ranges_increase)

    def of_quantity(self) -> str:
        """The property that is named."""
        return self.of

    @model_validator(mode="after")
    def _selects_once(self) -> MaterialDeviation:
        if (self.material is None) == (self.property is None):
            raise ValueError("needs either material or property")
        if self.of != EXPANSION and not self.relative:
            raise ValueError(f"the deviation of a {self.of} is relative: give relative_sigma or relative_half_width")
        return self


class ShellDeviation(_RelativeTable):
    """The thickness of one property of shells, or of several that deviate together."""

    quantity = THICKNESS
    property: Ids = Field(description="Ids of properties of shells in the deck, PSHELL.")

    _order = field_validator("property")(ranges_increase)


class TestMassDeviation(_ParameterTable):
    """The nominal position of a test mass against the structure, along axes of the basic frame.

    Each axis is a parameter of its own, `NAME_x` and so on. It acts on the self-gravity noise alone.
    """

    __test__ = False  # keeps pytest from collecting it

    quantity = POSITION
    test_mass: Annotated[str, Field(min_length=1)] = Field(description="Name of the test mass.")
    axes: Annotated[list[Axis], Field(min_length=1)] = Field(
        default_factory=lambda: list(AXES),
        description="Axes of the basic frame along which the position is uncertain.",
    )
    absolute_sigma_m: Annotated[float, Bounded(POSITION_DEVIATION)] | None = Field(
        default=None, description="One standard deviation along each of the axes."
    )
    absolute_half_width_m: Annotated[float, Bounded(POSITION_DEVIATION)] | None = Field(
        default=None, description="Half the width of a uniform distribution along each of the axes."
    )

    @field_validator("axes")
    @classmethod
    def _each_once(cls, value: list[str]) -> list[str]:
        if len(set(value)) != len(value):
            raise ValueError(f"an axis is there twice: {', '.join(value)}")
        return value

    def names(self) -> list[str]:
        """Names of the parameters, by axis."""
        return [f"{self.name}_{axis}" for axis in self.axes]


class LevelDeviation(SelectorTable, _RelativeTable):
    """The level of the temperatures of some areas, by which their amplitudes are multiplied.

    Each key that selects areas narrows the choice, any of its values will do. Where tables share areas, their factors
    multiply.
    """

    quantity = LEVEL

    @property
    def words(self) -> str:
        """The areas that it selects."""
        keys = ("groups", "shield", "side", "areas")
        return "; ".join(f"{key} {', '.join(value)}" for key in keys if (value := getattr(self, key)))


class DisturbanceDeviation(_RelativeTable):
    """The level of some disturbances of the thermal network, by which their amplitudes are multiplied.

    It acts on cases of the network (`thermal = true`). Where tables share disturbances, their factors multiply.
    """

    quantity = LEVEL
    disturbances: Annotated[list[Annotated[str, Field(min_length=1)]], Field(min_length=1)] = Field(
        description='Disturbances whose names match these patterns; `["*"]` is all.'
    )

    @property
    def words(self) -> str:
        """The disturbances that it selects."""
        return f"disturbances {', '.join(self.disturbances)}"


class MeshDeviation(Strict):
    """A second mesh of the same areas, whose difference estimates the error of this one (Richardson)."""

    other: FileName = Field(description="Project file of the other mesh, or its build folder.")
    refinement: Annotated[float, Bounded(MESH_REFINEMENT)] | None = Field(
        default=None,
        description="Size of its elements over that of this mesh's, below 1 where it is the finer one. Else by the "
        "numbers of elements.",
    )
    order: Annotated[float, Bounded(MESH_ORDER)] = Field(
        default=2.0, description="Order by which the error falls with the size of the elements."
    )
    sigma: Annotated[float, Bounded(MESH_DEVIATION)] = Field(
        default=1.0,
        description="One standard deviation of the error, of a normal distribution about this mesh, by its estimate.",
    )


class ModelUncertainty(Strict):
    """What is uncertain of the model. Without any of its tables nothing is."""

    material: list[MaterialDeviation] = Field(default_factory=list, description="Properties of materials.")
    shell: list[ShellDeviation] = Field(default_factory=list, description="Thicknesses of shells.")
    test_mass: list[TestMassDeviation] = Field(default_factory=list, description="Positions of test masses.")
    correlation: list[CorrelationTable] = Field(
        default_factory=list, description="Correlations between these parameters; others are independent."
    )

    @property
    def of_structure(self) -> bool:
        """Whether materials or thicknesses are uncertain, for which there must be an adjoint."""
        return bool(self.material or self.shell)

    @property
    def names_of_structure(self) -> list[str]:
        """Names of the parameters for which there must be an adjoint."""
        return [*(table.name for table in self.material), *(table.name for table in self.shell)]

    def problems(self, test_masses: Sequence[str]) -> list[tuple[str, str]]:
        """(dotted path, fact) of what is wrong between its tables, or with the names of test masses."""
        named = [
            (f"uncertainty.{kind}[{i}].name", table.name)
            for kind in ("material", "shell")
            for i, table in enumerate(getattr(self, kind))
        ]
        axes: dict[tuple[str, str], str] = {}
        found: list[tuple[str, str]] = []
        for i, table in enumerate(self.test_mass):
            place = f"uncertainty.test_mass[{i}]"
            named += [(f"{place}.name", name) for name in table.names()]
            if table.test_mass not in test_masses:
                there = f"there are: {', '.join(test_masses)}" if test_masses else "the model has none"
                found.append((f"{place}.test_mass", f"there is no test mass {table.test_mass!r}; {there}"))
            for axis in table.axes:
                before = axes.setdefault((table.test_mass, axis), place)
                if before != place:
                    fact = f"the position of {table.test_mass} along {axis} is uncertain already in {before}"
                    found.append((f"{place}.axes", fact))
        return found + correlation_problems(named, self.correlation)

    def pairs(self) -> Pairs:
        """Correlation coefficients of pairs of names."""
        return pairs_of(self.correlation)


class CasesUncertainty(Strict):
    """Uncertain levels of the temperatures, and how verdicts are drawn.

    Without any level, and without `[uncertainty]` in the model's configuration, there are no probabilities.
    """

    samples: Annotated[int, Bounded(DRAWS)] = Field(
        default=10_000, description="Number of draws of all parameters together (a Latin hypercube)."
    )
    seed: Annotated[int, Bounded(SEED)] = Field(default=1, description="Seed of the random numbers.")
    level: list[LevelDeviation] = Field(default_factory=list, description="Levels of the temperatures of areas.")
    disturbance: list[DisturbanceDeviation] = Field(
        default_factory=list, description="Levels of the disturbances of the thermal network."
    )
    correlation: list[CorrelationTable] = Field(
        default_factory=list, description="Correlations between these parameters; others are independent."
    )
    mesh: MeshDeviation | None = Field(default=None, description="A second mesh. Without it the mesh is no source.")

    def problems(self) -> list[tuple[str, str]]:
        """(dotted path, fact) of what is wrong between its tables."""
        named = [
            (f"uncertainty.{kind}[{i}].name", table.name)
            for kind in ("level", "disturbance")
            for i, table in enumerate(getattr(self, kind))
        ]
        return correlation_problems(named, self.correlation)

    def pairs(self) -> Pairs:
        """Correlation coefficients of pairs of names."""
        return pairs_of(self.correlation)
