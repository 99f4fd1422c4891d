"""Configuration of the limits on the field at rest, and of the subsystems whose field they limit."""

from __future__ import annotations

import difflib
import re
from collections import Counter
from collections.abc import Collection, Mapping, Sequence
from typing import Annotated, Literal, Self

from pydantic import AfterValidator, Field, ValidationInfo, field_validator, model_validator

from tedm_cli.config.base import Bounded, Form, OneLine, Strict
from tedm_cli.config.correlation.case import Names
from tedm_cli.gravity.field import COMPENSATION, OTHER_TEST_MASS
from tedm_cli.gravity.requirement_presets import PRESETS, lpf_limits
from tedm_cli.gravity.requirements import ALL, AtRestLimit, axes_of
from tedm_cli.gravity.testmass import TestMass
from tedm_cli.parallel_axes import MassAxis, why_no_difference
from tedm_cli.quantities import LIMIT_AT_REST

Quantity = Literal[
    "gamma_xx", "gamma_xy", "gamma_xz", "gamma_yy", "gamma_yz", "gamma_zz",
    "a_x", "a_y", "a_z", "omegadot_theta", "omegadot_eta", "omegadot_phi",
]  # fmt: skip
Limit = Annotated[float, Bounded(LIMIT_AT_REST)]
REST = "rest"


def _subsystem_name(name: str) -> str:
    """Names are joined by + where several are judged together."""
    if not re.fullmatch(r"[A-Za-z0-9_./-]{1,64}", name):
        raise ValueError("names of subsystems are made of letters without accents, digits, _ . / and -, at most 64")
    return name


SubsystemName = Annotated[str, AfterValidator(_subsystem_name)]
#: Groups of areas and sources, the same for every test mass or by test mass; or whatever no other subsystem has.
Subsystem = Annotated[
    Literal["rest"] | Names | dict[str, Names], Form('list of texts, table of such lists by test mass, or "rest"')
]
Problems = list[tuple[str, str]]

_PARALLEL_RAD = 1e-4  # a difference leaves this part of the other components, far less than any limit resolves
_POINTLIKE = (OTHER_TEST_MASS, COMPENSATION)  # what pulls and is in no area


class AtRestTable(Strict):
    """A limit on one quantity of the field at rest, or, without `quantity`, all limits of the preset `name`."""

    quantity: Quantity | None = Field(
        default=None,
        description="The quantity that is limited: a stiffness, acceleration or angular acceleration. Without "
        "it `name` is that of a preset.",
    )
    name: OneLine = Field(description='Name of the limit, or of a preset: "lpf" has all limits of LISA Pathfinder.')
    subsystem: str | Names = Field(
        default=ALL,
        description='The subsystem whose field is limited, several together, or "all", everything in the model.',
    )
    lower: Limit | None = Field(
        default=None, description="Lower end of the range, in the SI unit of the quantity, with `upper`."
    )
    upper: Limit | None = Field(default=None, description="Upper end of the range.")
    magnitude: Limit | None = Field(
        default=None, description="Half width of a range about 0, in place of `lower` and `upper`."
    )
    test_mass: str | Names = Field(default=ALL, description='The test masses: one, several, or "all".')
    applies_to: Literal["single", "difference"] | None = Field(
        default=None,
        description='"single" judges each test mass by itself, "difference" the second minus the first. Left '
        'out: "single", and of a preset as it was published.',
    )
    source: OneLine | None = Field(default=None, description="Where the limit is from, for the report.")

    @field_validator("name")
    @classmethod
    def _known(cls, value: str, info: ValidationInfo) -> str:
        has_no_quantity = "quantity" in info.data and info.data["quantity"] is None  # absent where it is wrong
        if has_no_quantity and value not in PRESETS:
            near = difflib.get_close_matches(value, PRESETS, n=1)
            hint = f"did you mean {near[0]}?" if near else f"known: {', '.join(PRESETS)}; or give a quantity"
            raise ValueError(f"unknown requirement {value!r}; {hint}")
        return value

    @model_validator(mode="after")
    def _preset_or_limit(self) -> Self:
        if self.quantity is None:
            keys = ("subsystem", "lower", "upper", "magnitude", "test_mass", "source")
            if given := [key for key in keys if key in self.model_fields_set]:
                raise ValueError(f"{', '.join(given)} of the preset {self.name} cannot be changed; give a quantity")
            return self
        if self.name in PRESETS:
            raise ValueError(f"{self.name} is the name of a preset; give the limit another")
        ends = (self.lower is not None, self.upper is not None)
        if self.magnitude is not None and any(ends):
            raise ValueError("has both magnitude and lower or upper")
        if self.magnitude is None and not all(ends):
            raise ValueError("needs magnitude, or both lower and upper")
        if self.magnitude is not None and self.magnitude <= 0.0:
            raise ValueError(f"magnitude must be positive (found {self.magnitude:g}); the range is plus and minus it")
        lower, upper = self.ends
        if not lower < 0.0 < upper:
            raise ValueError(f"the range {lower:g} to {upper:g} does not hold 0 inside it; ratios are counted from 0")
        return self

    @property
    def ends(self) -> tuple[float, float]:
        """Lower and upper end of the range."""
        if self.magnitude is not None:
            return -self.magnitude, self.magnitude
        return float(self.lower or 0.0), float(self.upper or 0.0)

    @property
    def is_difference(self) -> bool:
        """Whether it limits the difference of two test masses; presets do as published."""
        return self.applies_to == "difference" or (self.applies_to is None and self.quantity is None)

    @property
    def subsystems(self) -> tuple[str, ...]:
        """Names of the subsystems; none for everything in the model."""
        if isinstance(self.subsystem, str):
            return () if self.subsystem == ALL else (self.subsystem,)
        return tuple(self.subsystem)

    def masses(self, test_masses: Sequence[str]) -> tuple[str, ...]:
        """Names of its test masses, of those there are."""
        if isinstance(self.test_mass, str):
            return tuple(test_masses) if self.test_mass == ALL else (self.test_mass,)
        return tuple(self.test_mass)

    def limits(self, known: Collection[str], test_masses: Sequence[str]) -> list[AtRestLimit]:
        """What it limits in a model with these subsystems and test masses."""
        masses = self.masses(test_masses)
        if self.quantity is None:
            return lpf_limits(known, masses, is_difference=self.is_difference)
        source = self.source or "configuration"
        return [AtRestLimit(self.name, self.quantity, self.subsystems, *self.ends, masses, self.is_difference, source)]


def limits_at_rest(
    tables: Sequence[AtRestTable], subsystems: Mapping[str, Subsystem], test_masses: Sequence[TestMass]
) -> list[AtRestLimit]:
    """All limits on the field at rest; what two tables have in common is judged once."""
    names = [tm.name for tm in test_masses]
    return list(dict.fromkeys(limit for table in tables for limit in table.limits(subsystems, names)))


def members(subsystem: Subsystem, test_mass: str) -> list[str]:
    """Groups and sources of a subsystem for one test mass; none of whatever is the rest."""
    if isinstance(subsystem, dict):
        return subsystem[test_mass]
    return [] if isinstance(subsystem, str) else subsystem


def rest_of(subsystems: Mapping[str, Subsystem]) -> str:
    """The subsystem that is whatever no other has, or ""."""
    return next((name for name, of in subsystems.items() if of == REST), "")


def subsystem_problems(
    subsystems: Mapping[str, Subsystem], groups: Collection[str], test_masses: Sequence[str]
) -> Problems:
    """What is wrong with subsystems, where areas have these groups."""
    problems: Problems = []
    if of_masses := {name: of for name, of in subsystems.items() if name in test_masses}:
        own = ", ".join(f"{name} = [{', '.join(map(repr, of))}]" for name, of in of_masses.items())
        fact = "is a test mass, not a subsystem; name the inertial sensors and what is left: IS = {{ {} }}, LTP = {!r}"
        name = next(iter(of_masses))
        return [(f"gravity.subsystems.{name}", fact.format(own, REST).replace("'", '"'))]
    for name in subsystems:
        if name == ALL:
            problems.append((f"gravity.subsystems.{name}", f"{ALL} is everything in the model; give it another name"))
    if len(rests := [name for name, of in subsystems.items() if of == REST]) > 1:
        problems.append((f"gravity.subsystems.{rests[1]}", f"{rests[0]} is the rest already"))
    owner: dict[tuple[str, str], str] = {}
    for name, of in subsystems.items():
        place = f"gravity.subsystems.{name}"
        if isinstance(of, dict):
            if unknown := [key for key in of if key not in test_masses]:
                problems.append((place, f"no test mass {unknown[0]!r}; there are: {', '.join(test_masses)}"))
                continue
            if missing := [key for key in test_masses if key not in of]:
                problems.append((place, f"says nothing of {', '.join(missing)}; give its groups too"))
                continue
        told: set[str] = set()
        for test_mass in test_masses:
            for group in members(of, test_mass):
                if group not in groups and group not in _POINTLIKE:
                    told.add(f"no rule of [areas] has the group {group!r}, nor is it {' or '.join(_POINTLIKE)}")
                elif (first := owner.setdefault((test_mass, group), name)) != name:
                    told.add(f"group {group!r} belongs to {first} already")
        problems += [(place, fact) for fact in sorted(told)]
    return problems


def limit_problems(
    tables: Sequence[AtRestTable], subsystems: Mapping[str, Subsystem], test_masses: Sequence[TestMass]
) -> Problems:
    """What is wrong between the limits, the subsystems and the test masses."""
    names, problems = [tm.name for tm in test_masses], []
    seen: dict[tuple[object, ...], int] = {}
    for number, table in enumerate(tables):
        place = f"requirement_at_rest[{number}]"
        facts = _preset_problems(table, subsystems) or _name_problems(table, subsystems, names)
        if not facts and table.is_difference:
            facts = _difference_problems(table, subsystems, test_masses)
        key = (table.name, table.quantity, table.subsystems, table.masses(names), table.is_difference)
        if (first := seen.setdefault(key, number)) != number:
            facts.append(("name", f"{table.name} limits the same in requirement_at_rest[{first}]"))
        problems += [(f"{place}.{key}", fact) for key, fact in facts]
    return problems


def _preset_problems(table: AtRestTable, subsystems: Mapping[str, Subsystem]) -> Problems:
    """Subsystems to which a preset allocates and that have another name here: its limits would go without a word."""
    if table.quantity is not None or not subsystems:
        return []
    preset = PRESETS[table.name]
    others = {_plain(name): name for name in subsystems if name not in preset.subsystems}
    lacking, meant = [], []
    for wanted in preset.subsystems:
        key = _plain(wanted)
        if wanted in subsystems or (wanted not in preset.required and key not in others):
            continue
        lacking.append(wanted)
        if near := difflib.get_close_matches(key, others, n=1):
            meant.append(f"{wanted} by {others[near[0]]}")
    if not lacking:
        return []
    they = f"the subsystem{'s' * (len(lacking) > 1)} {' and '.join(lacking)}"
    hint = f"did you mean {', '.join(meant)}?" if meant else f"it has {', '.join(subsystems)}"
    fact = f"{table.name} limits {they}, which [gravity.subsystems] lacks; {hint}; without [gravity.subsystems]"
    return [("name", f"{fact} the model is judged as a whole")]


def _plain(name: str) -> str:
    """A name without its capitals and signs."""
    return "".join(c for c in name.lower() if c.isalnum())


def _name_problems(table: AtRestTable, subsystems: Mapping[str, Subsystem], test_masses: Sequence[str]) -> Problems:
    facts = []
    for key, given, known in (
        ("subsystem", table.subsystems, list(subsystems)),
        ("test_mass", table.masses(test_masses), list(test_masses)),
    ):
        if unknown := [name for name in given if name not in known]:
            there = ", ".join([*known, ALL])
            facts.append((key, f"there is no {key.replace('_', ' ')} {unknown[0]!r}; there are: {there}"))
        elif twice := [name for name, n in Counter(given).items() if n > 1]:
            facts.append((key, f"{twice[0]} is there twice"))
    return facts


def _difference_problems(
    table: AtRestTable, subsystems: Mapping[str, Subsystem], test_masses: Sequence[TestMass]
) -> Problems:
    """Why the difference of test masses cannot be judged."""
    names = [tm.name for tm in test_masses]
    masses = table.masses(names)
    single = 'applies_to = "single" judges each test mass by itself'
    if len(masses) != 2:
        fact = f"a difference is that of two test masses, and this is of {', '.join(masses)}"
        how = 'name two: test_mass = ["A", "B"] is B minus A' if len(names) > 2 and table.quantity else single
        return [("test_mass" if table.quantity else "applies_to", f"{fact}; {how}")]
    first, second = (test_masses[names.index(name)] for name in masses)
    limits = [limit for limit in table.limits(subsystems, names) if limit.is_difference]
    axes = sorted({axis for limit in limits for axis in axes_of(limit.quantity)})
    for axis in axes:
        one, two = (MassAxis(tm.name, "xyz"[axis], tm.axes[axis]) for tm in (first, second))
        if fact := why_no_difference(one, two, _PARALLEL_RAD):
            return [("applies_to", f"{fact}; {single}")]
    return []
