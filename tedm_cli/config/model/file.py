"""Configuration of the model: decks, results, attributes of the thermal areas, test masses."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

import numpy as np
import scipy
from pydantic import Field, PrivateAttr, field_validator, model_validator

from tedm_cli.arrays import FloatArray
from tedm_cli.config.base import (
    AbsoluteTemperature,
    Angle,
    Bounded,
    FileName,
    Id,
    Mass,
    OneLine,
    OrthonormalAxes,
    Place,
    Strict,
    load,
    named_by_project,
)
from tedm_cli.config.effects import EffectTable
from tedm_cli.config.model.areas import AreasTable, Ids, id_ranges, ranges_increase
from tedm_cli.config.model.at_rest import (
    AtRestTable,
    Subsystem,
    SubsystemName,
    limit_problems,
    limits_at_rest,
    subsystem_problems,
)
from tedm_cli.config.model.body import Edges, TestMassTable
from tedm_cli.config.model.superelement import SuperelementTable
from tedm_cli.config.model.units import UnitsTable
from tedm_cli.config.uncertainty import ModelUncertainty
from tedm_cli.errors import ConfigError, InputError, PhysicsError
from tedm_cli.files.provenance import ConfigFile
from tedm_cli.gravity.compensation import DEFAULT_TOLERANCE, CompensationMass, Tie
from tedm_cli.gravity.constants import G_CODATA_2018
from tedm_cli.gravity.requirements import AtRestLimit
from tedm_cli.gravity.testmass import TestMass
from tedm_cli.quantities import (
    COMPENSATION_TOLERANCE,
    DENSITY,
    GAUSS_POINTS,
    GRAVITATIONAL_CONSTANT,
    QUADRATURE_TOLERANCE,
)

RotationVector = Annotated[list[Angle], Field(min_length=3, max_length=3)]


class ModelTable(UnitsTable):
    """Where the finite-element model and its results are; `{build_dir}` in a path stands for the build folder."""

    bdf: FileName | None = Field(
        default=None, description="The finite-element model from which `tedm write-deck` makes the unit-load deck."
    )
    areas_csv: FileName | None = Field(
        default=None,
        description="A CSV `node_id,area` that puts grids into thermal areas, before the definitions of "
        "`[[areas.define]]`.",
    )
    deck: FileName = Field(
        default="{build_dir}/unit_loads.bdf",
        description="The unit-load deck: your own where your Nastran solved it, else the one that `tedm "
        "write-deck` writes.",
    )
    op2: list[FileName] = Field(
        min_length=1,
        default_factory=lambda: ["{build_dir}/unit_loads.op2"],
        description="Results of that deck: OP2 files, or MSC Nastran's HDF5. Else the one that `tedm solve` writes.",
    )
    adjoint_op2: list[FileName] = Field(
        default_factory=list,
        description="Results of the deck of `tedm write-deck --adjoint`, where your Nastran solves the adjoint too; "
        "files as of `op2`. Without them `tedm build-adjoint` solves it.",
    )
    uniform_label: str = Field(
        default="UNIFORM",
        description="LABEL of the subcase that warms all areas together. It checks superposition, and the "
        "deck may lack it.",
    )
    reference_temperature_K: AbsoluteTemperature | None = Field(
        default=None,
        description="Temperature from which the unit loads start, in place of TREF. Materials with MATTi need it.",
    )
    constraints_of_subcase: Id | None = Field(
        default=None,
        description="The subcase of `bdf` whose constraints all unit loads have. Needed where those of its "
        "subcases differ.",
    )
    allow_missing_enddata: bool = Field(
        default=False, description="Whether decks may end without ENDDATA, as one does that was cut off."
    )
    subcases: dict[str, Id] = Field(
        default_factory=dict, description="Subcase id of each area, by name, where the results carry no labels."
    )


class CompensationMassTable(Strict):
    """A cuboid block. Its edges are along the basic frame unless it is turned. It stays still, or follows grids."""

    name: Annotated[str, Field(min_length=1)] = Field(description="Name of the block, in prints and results.")
    centre_m: Place = Field(description="Centre of the block, basic frame.")
    size_m: Edges = Field(description="Full edge lengths; one number is a cube.")
    mass_kg: Mass | None = Field(default=None, description="Mass of the block. Either this or `density_kg_m3`.")
    density_kg_m3: Annotated[float, Bounded(DENSITY)] | None = Field(
        default=None, description="Density of the block. Either this or `mass_kg`."
    )
    rotation_rad: RotationVector | None = Field(
        default=None, description="Rotation vector that turns the block from the basic frame. This or `axes`."
    )
    axes: OrthonormalAxes | None = Field(
        default=None, description="Unit vectors along the edges, as rows, basic frame. This or `rotation_rad`."
    )
    grid: Ids | None = Field(
        default=None,
        description="The grid that the block follows, or several of them, as an RBE3 would. Without it and `set` the "
        "block stays still.",
    )
    set: Ids | None = Field(
        default=None, description="Sets of the deck whose members the block follows, in place of `grid`."
    )
    group: OneLine | None = Field(
        default=None,
        description="Group of thermal areas whose subsystem the field of the block counts to, as if it were a part of "
        'it. Left out: that of "compensation masses".',
    )

    _order = field_validator("grid", "set")(ranges_increase)

    @model_validator(mode="after")
    def _one_of_each(self) -> CompensationMassTable:
        if (self.mass_kg is None) == (self.density_kg_m3 is None):
            raise ValueError("needs either mass_kg or density_kg_m3")
        if self.rotation_rad is not None and self.axes is not None:
            raise ValueError("has both rotation_rad and axes")
        if self.grid is not None and self.set is not None:
            raise ValueError("has both grid and set: it can follow one of them")
        return self

    def block(self) -> CompensationMass:
        """The block as the gravity room takes it."""
        size = np.array(self.size_m if isinstance(self.size_m, list) else [self.size_m] * 3)
        mass = self.mass_kg if self.mass_kg is not None else float(self.density_kg_m3 or 0.0) * float(size.prod())
        axes = np.array(self.axes) if self.axes is not None else axes_of_rotation(self.rotation_rad or [0.0, 0.0, 0.0])
        ids = tuple(id_ranges(self.grid if self.set is None else self.set))
        return CompensationMass(
            name=self.name,
            centre_m=np.array(self.centre_m),
            size_m=size,
            mass_kg=mass,
            axes=axes,
            tie=Tie("grid" if self.set is None else "set", ids) if ids else None,
            group=self.group or "",
        )


def axes_of_rotation(rotation_rad: list[float]) -> FloatArray:
    """Edges (rows) of a body turned from the basic frame by a rotation vector."""
    turned: FloatArray = scipy.spatial.transform.Rotation.from_rotvec(rotation_rad).as_matrix()
    return turned.T


class GravityTable(Strict):
    """How the structure's mass is represented, the other test mass, compensation masses, subsystems."""

    gravitational_constant_m3_kg_s2: Annotated[float, Bounded(GRAVITATIONAL_CONSTANT)] = Field(
        default=G_CODATA_2018, description="The gravitational constant; CODATA 2018 where left out."
    )
    mass_model: Literal["quadrature", "lumped"] = Field(
        default="quadrature",
        description='"quadrature" spreads the mass of every element over it; "lumped" shares it among the '
        "element's grids, the published method.",
    )
    quadrature_tolerance: Annotated[float, Bounded(QUADRATURE_TOLERANCE)] = Field(
        default=1e-4, description='Relative error of the field of each element, to which "quadrature" cuts it.'
    )
    other_test_mass_points: Annotated[int, Bounded(GAUSS_POINTS)] = Field(
        default=8, description="Gauss points along each edge of the other test mass."
    )
    compensation_masses: FileName | None = Field(
        default=None, description="A CSV of compensation masses; `[[compensation_mass]]` tables add to it."
    )
    compensation_tolerance: Annotated[float, Bounded(COMPENSATION_TOLERANCE)] = Field(
        default=DEFAULT_TOLERANCE, description="Estimated relative error of the field of each compensation mass."
    )
    subsystems: dict[SubsystemName, Subsystem] = Field(
        default_factory=dict,
        description="Subsystems whose field at rest is limited, by name: groups of thermal areas, the same "
        'for every test mass or by test mass, or "rest", all that no other subsystem has. "other '
        'test mass" and "compensation masses" count as groups.',
    )


class ModelConfig(Strict):
    """Model, thermal areas, test masses, and limits on the field at rest. Paths are relative to this file."""

    model: ModelTable = Field(description="Decks, results and their units.")
    areas: AreasTable = Field(description="Thermal areas and their attributes.")
    test_mass: list[TestMassTable] = Field(
        default_factory=list,
        description="The test masses. Without any there is no self-gravity, and the project is of read-outs alone.",
    )
    gravity: GravityTable = Field(default=GravityTable(), description="How self-gravity is computed.")
    compensation_mass: list[CompensationMassTable] = Field(
        default_factory=list,
        description="Compensation masses, one block each. They have no mass in the deck, where a CONM2 would "
        "count twice.",
    )
    requirement_at_rest: list[AtRestTable] = Field(
        default_factory=list, description="Limits on the field at rest. Without any, nothing is judged at rest."
    )
    effect: list[EffectTable] = Field(
        default_factory=list,
        description="Other effects of temperature on accelerations and read-outs, which are added to those that the "
        "program computes.",
    )
    superelement: list[SuperelementTable] = Field(
        default_factory=list,
        description="Structures that are given as matrices on grids of the deck. `tedm reduce` makes such matrices.",
    )
    uncertainty: ModelUncertainty = Field(
        default=ModelUncertainty(), description="What is uncertain of the model, for probabilities of verdicts."
    )
    _test_masses: list[TestMass] | None = PrivateAttr(default=None)

    @field_validator("test_mass")
    @classmethod
    def _names_differ(cls, value: list[TestMassTable]) -> list[TestMassTable]:
        names = [t.name for t in value]
        if len(set(names)) != len(names):
            raise ValueError(f"two test masses have the same name: {', '.join(names)}")
        return value

    @field_validator("superelement")
    @classmethod
    def _superelements_differ(cls, value: list[SuperelementTable]) -> list[SuperelementTable]:
        names = [table.name for table in value]
        if len(set(names)) != len(names):
            raise ValueError(f"two superelements have the same name: {', '.join(names)}")
        return value

    @field_validator("effect")
    @classmethod
    def _effects_differ(cls, value: list[EffectTable]) -> list[EffectTable]:
        names = [effect.name for effect in value]
        if len(set(names)) != len(names):
            raise ValueError(f"two effects have the same name: {', '.join(names)}")
        return value

    def test_masses(self) -> list[TestMass]:
        """The test masses as the gravity room takes them, of a configuration that `load_model` has read."""
        assert self._test_masses is not None, "their bodies have not been made: they may be in files"
        return self._test_masses

    def make_test_masses(self, folder: Path) -> list[tuple[str, str]]:
        """Make the bodies of the test masses, from files in `folder` where they are in files; what is wrong."""
        made, problems = [], []
        for number, table in enumerate(self.test_mass):
            where, file = f"test_mass[{number}]", ""
            if table.stl is not None:
                where, file = f"{where}.stl", f"{folder / table.stl}: "
            try:
                made.append(table.test_mass(table.body(folder)))
            except (PhysicsError, InputError) as error:
                problems.append((where, file + error.fact + (f"; {error.hint}" if error.hint else "")))
            except OSError as error:
                problems.append((where, f"{file}cannot read the file ({error.strerror})"))
        self._test_masses = made
        return problems

    def body_files(self) -> list[str]:
        """Names of the files that hold bodies of test masses."""
        return [table.stl for table in self.test_mass if table.stl is not None]

    def required_test_masses(
        self, where: Path, why: str = "self-gravity is the field on test masses"
    ) -> list[TestMass]:
        """The test masses, for what cannot be done without; `ConfigError` names the file `where` if it has none."""
        if not self.test_mass:
            hint = "describe each in a table [[test_mass]]; read-outs and their noise need none"
            raise ConfigError([("test_mass", f"the model has none, and {why}")], where=str(where), hint=hint)
        return self.test_masses()

    def require_adjoint(self, where: Path) -> None:
        """`ConfigError` for a project that has no adjoint, as it has no test masses."""
        self.require_outputs(where, "the adjoint")

    def require_outputs(self, where: Path, what: str) -> None:
        """`ConfigError` for a project without test masses, of whose outputs `what` cannot be made."""
        self.required_test_masses(where, f"{what}, also that of read-outs, is of projects that have")

    def limits_at_rest(self) -> list[AtRestLimit]:
        """What the field at rest is judged by."""
        return limits_at_rest(self.requirement_at_rest, self.gravity.subsystems, self.test_masses())


def load_model(path: Path) -> tuple[ConfigFile, ModelConfig]:
    """Read a model configuration; `ConfigError` lists the problems of its tables, then those between tables."""
    file, config = load(ModelConfig, path, hint=named_by_project("model"))
    if problems := config.make_test_masses(path.parent):
        raise ConfigError(problems, where=str(path))
    subsystems, masses = config.gravity.subsystems, config.test_masses()
    groups = {rule.group for rule in config.areas.rule}
    if masses:
        problems = subsystem_problems(subsystems, groups, [tm.name for tm in masses])
        problems = problems or limit_problems(config.requirement_at_rest, subsystems, masses)
    else:
        fact = "the model has no [[test_mass]] whose field at rest there could be"
        given = {"gravity.subsystems": subsystems, "requirement_at_rest": config.requirement_at_rest}
        problems = [(key, fact) for key, tables in given.items() if tables]
    for number, definition in enumerate(config.areas.define):
        if definition.name.upper() == config.model.uniform_label.upper():
            fact = f"'{definition.name}' is the name of the uniform load; choose another, or set model.uniform_label"
            problems.append((f"areas.define[{number}].name", fact))
    problems += config.uncertainty.problems([tm.name for tm in masses])
    if problems:
        raise ConfigError(problems, where=str(path))
    return file, config
