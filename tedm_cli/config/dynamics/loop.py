"""Configuration of the drag-free dynamics: spacecraft, stiffness, controller, noise, requirements."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Literal

import numpy as np
from pydantic import Field, field_validator, model_validator

from tedm_cli import quantities as q
from tedm_cli.arrays import FloatArray
from tedm_cli.config.base import IDENTIFIER, Bounded, FileName, Place, Strict, load, named_by_project
from tedm_cli.config.dynamics.noise import NoiseTable
from tedm_cli.config.requirements import RequirementTable
from tedm_cli.dynamics.bodies import DynamicTestMass, Spacecraft
from tedm_cli.dynamics.controller import LOOPS
from tedm_cli.dynamics.loops import INTEGRAL, LEAD, ROLL_OFF, Loop, LoopShape
from tedm_cli.dynamics.presets import (
    TOTAL_STIFFNESS_S2,
    lpf_spacecraft,
)
from tedm_cli.dynamics.signals import OUTPUTS, TEST_MASSES
from tedm_cli.dynamics.stiffness import electrostatic_to_total
from tedm_cli.files.provenance import ConfigFile
from tedm_cli.noise.requirements import AppliedRequirement

Moment = Annotated[float, Bounded(q.INERTIA)]
Moments = Annotated[list[Moment], Field(min_length=3, max_length=3)]
Stiffness = Annotated[float, Bounded(q.STIFFNESS)]
Six = Annotated[list[Stiffness], Field(min_length=6, max_length=6)]
CornerRatio = Annotated[float, Bounded(q.CORNER_RATIO)]
Coefficient = Annotated[float, Bounded(q.TRANSFER_COEFFICIENT)]


class SpacecraftTable(Strict):
    """The spacecraft without its test masses. What is left out is LISA Pathfinder's."""

    mass_kg: Annotated[float, Bounded(q.SPACECRAFT_MASS)] | None = Field(
        default=None, description="Mass without the test masses. Else LISA Pathfinder's, 422.7 kg."
    )
    inertia_kg_m2: Moments | None = Field(
        default=None,
        description="Moments of inertia about the centre of mass and the basic axes, without products. Else "
        "LISA Pathfinder's: 202.5, 209.7, 191.7.",
    )
    inertia_matrix_kg_m2: Annotated[list[Moments], Field(min_length=3, max_length=3)] | None = Field(
        default=None, description="The whole tensor, in place of `inertia_kg_m2`."
    )
    centre_of_mass_m: Place | None = Field(
        default=None, description="Centre of mass, basic frame. Else LISA Pathfinder's, around the test masses."
    )

    @model_validator(mode="after")
    def _one_inertia(self) -> SpacecraftTable:
        if self.inertia_kg_m2 is not None and self.inertia_matrix_kg_m2 is not None:
            raise ValueError("has both inertia_kg_m2 and inertia_matrix_kg_m2")
        return self

    def spacecraft(self, test_masses: list[DynamicTestMass]) -> Spacecraft:
        """The body; `PhysicsError` for an inertia that no body has."""
        preset = lpf_spacecraft(test_masses)
        inertia = preset.inertia_kg_m2
        if self.inertia_matrix_kg_m2 is not None:
            inertia = np.array(self.inertia_matrix_kg_m2)
        elif self.inertia_kg_m2 is not None:
            inertia = np.diag(self.inertia_kg_m2)
        return Spacecraft(
            preset.mass_kg if self.mass_kg is None else self.mass_kg,
            inertia,
            preset.centre_of_mass_m if self.centre_of_mass_m is None else np.array(self.centre_of_mass_m),
        )


class StiffnessTable(Strict):
    """Electrostatic stiffness per mass and moment, 1/s² along the diagonal, positive where it destabilises."""

    preset: Literal["ltpda", "none"] = Field(
        default="ltpda",
        description='"ltpda" fills the stiffness of gravity up to the totals of LISA Pathfinder; "none" is '
        "gravity alone.",
    )
    electrostatic: dict[str, Six] = Field(
        default_factory=dict,
        description="By test mass six numbers of the diagonal (x, y, z, theta, eta, phi), in place of the preset.",
    )
    electrostatic_matrix: dict[str, Annotated[list[Six], Field(min_length=6, max_length=6)]] = Field(
        default_factory=dict, description="By test mass the whole matrix, in place of the preset."
    )

    @model_validator(mode="after")
    def _both_test_masses(self) -> StiffnessTable:
        if self.electrostatic and self.electrostatic_matrix:
            raise ValueError("has both electrostatic and electrostatic_matrix")
        own = self.electrostatic or self.electrostatic_matrix
        if own and sorted(own) != sorted(TEST_MASSES):
            raise ValueError(f"electrostatics must have one entry for each of {', '.join(TEST_MASSES)}")
        return self

    def matrix(self, gravity: FloatArray) -> FloatArray:
        """[2, 6, 6] beside the `gravity` [2, 6, 6] of what moves with the spacecraft."""
        if self.electrostatic:
            return np.stack([np.diag(self.electrostatic[tm]) for tm in TEST_MASSES])
        if self.electrostatic_matrix:
            return np.array([self.electrostatic_matrix[tm] for tm in TEST_MASSES])
        return electrostatic_to_total(gravity) if self.preset == "ltpda" else np.zeros((2, 6, 6))

    def words(self) -> str:
        """Where the electrostatic stiffness is from."""
        if self.electrostatic or self.electrostatic_matrix:
            return "configured"
        shown = " ".join(f"{1e6 * k:g}" for k in TOTAL_STIFFNESS_S2)
        return f"up to LISA Pathfinder's totals, {shown} 1e-6/s^2 (LTPDA)" if self.preset == "ltpda" else "none"


class ReadOutTable(Strict):
    """Which redundant set of read-outs the controller hears."""

    set: Annotated[str, Field(pattern=IDENTIFIER)] | None = Field(
        default=None, description="The redundant set of read-outs that the controller hears. Else the first."
    )


class ShapeTable(Strict):
    """Corner frequencies of the default loops, relative to their crossover."""

    integral: CornerRatio = Field(default=INTEGRAL, description="Crossover over the corner of the integral part.")
    lead: CornerRatio = Field(default=LEAD, description="Crossover over the corner of the lead.")
    roll_off: CornerRatio = Field(default=ROLL_OFF, description="Corner of the roll-off over the crossover.")


class LoopTable(Strict):
    """One of the default loops with another crossover, delay or shape, or a transfer function of one's own."""

    name: str = Field(
        description="Which of the default loops: TM1_x, x12, SC_theta and so on; another name is refused with "
        "the list of them."
    )
    crossover_hz: Annotated[float, Bounded(q.CROSSOVER)] | None = Field(
        default=None, description="Crossover frequency. Else that of the default loop."
    )
    delay_s: Annotated[float, Bounded(q.CONTROL_DELAY)] | None = Field(
        default=None, description="Delay of the loop. Else that of the default loop."
    )
    shape: ShapeTable | None = Field(default=None, description="Corners of this loop. Else those of the controller.")
    numerator: Annotated[list[Coefficient], Field(min_length=1, max_length=12)] | None = Field(
        default=None,
        description="Numerator of a transfer function of your own, highest power of s first: acceleration "
        "demand per m or rad.",
    )
    denominator: Annotated[list[Coefficient], Field(min_length=1, max_length=12)] | None = Field(
        default=None, description="Denominator of that transfer function."
    )

    @field_validator("name")
    @classmethod
    def _known(cls, value: str) -> str:
        if value not in LOOPS:
            raise ValueError(f"no loop is called {value!r}; there are {', '.join(LOOPS)}")
        return value

    @model_validator(mode="after")
    def _both_or_none(self) -> LoopTable:
        if (self.numerator is None) != (self.denominator is None):
            raise ValueError("needs both numerator and denominator, or neither")
        if self.numerator is not None and (self.crossover_hz is not None or self.shape is not None):
            raise ValueError("has a transfer function: its crossover and shape follow from it")
        return self

    def loop(self, default: Loop, shape: LoopShape) -> Loop:
        """The loop; `PhysicsError` for an improper transfer function."""
        transfer = None if self.numerator is None else (tuple(self.numerator), tuple(self.denominator or ()))
        own = shape if self.shape is None else LoopShape(**self.shape.model_dump())
        crossover = default.crossover_hz if self.crossover_hz is None else self.crossover_hz
        return Loop(self.name, crossover, default.delay_s if self.delay_s is None else self.delay_s, own, transfer)


class ControllerTable(Strict):
    """The default controller, changed loop by loop, or one of one's own."""

    file: FileName | None = Field(
        default=None,
        description="A controller of your own: A, B, C, D with `inputs` and `outputs` in NPZ, MAT or TOML.",
    )
    shape: ShapeTable = Field(default=ShapeTable(), description="Corners of all default loops.")
    loop: list[LoopTable] = Field(default_factory=list, description="Default loops that are changed.")

    @model_validator(mode="after")
    def _one_of_both(self) -> ControllerTable:
        if self.file is not None and (self.loop or self.shape != ShapeTable()):
            raise ValueError("has both a file and loops of the default controller")
        names = [loop.name for loop in self.loop]
        twice = sorted({name for name in names if names.count(name) > 1})
        if twice:
            raise ValueError(f"loop {twice[0]} is there twice")
        return self


class TimeTable(Strict):
    """Realisations of the loop in time."""

    rate_hz: Annotated[float, Bounded(q.CROSSOVER)] = Field(default=0.5, description="Samples per second.")
    samples: Annotated[int, Bounded(q.REALISED_SAMPLES)] = Field(
        default=2**20, description="Number of samples; of a release the largest."
    )
    seed: Annotated[int, Bounded(q.SEED)] = Field(default=1, description="Seed of the random numbers.")


def _default_requirements() -> list[RequirementTable]:
    return [
        RequirementTable(name="lpf_acceleration", outputs=["delta_g"], applies_to="differential"),
        RequirementTable(name="lisa_acceleration", outputs=["TM1_a_x", "TM2_a_x"]),
        RequirementTable(name="lisa_acceleration_differential", outputs=["delta_g"], applies_to="differential"),
        RequirementTable(name="lpf_jitter", outputs=["TM1_x"]),
    ]


class DynamicsConfig(Strict):
    """Spacecraft, stiffness, controller and noise of the drag-free loop. Everything may be left out."""

    spacecraft: SpacecraftTable = Field(default=SpacecraftTable(), description="The spacecraft.")
    stiffness: StiffnessTable = Field(default=StiffnessTable(), description="Electrostatic stiffness.")
    read_out: ReadOutTable = Field(default=ReadOutTable(), description="What the controller hears.")
    controller: ControllerTable = Field(default=ControllerTable(), description="The controller.")
    noise: NoiseTable = Field(default=NoiseTable(), description="Noise sources beside the temperatures.")
    time: TimeTable = Field(default=TimeTable(), description="Realisations in time.")
    requirements: list[RequirementTable] = Field(
        alias="requirement",
        default_factory=_default_requirements,
        description="Requirements on outputs of the closed loop. Else lpf_acceleration and "
        "lisa_acceleration_differential on delta_g, lisa_acceleration on both test masses, "
        "lpf_jitter on TM1_x.",
    )

    def file_names(self) -> list[str]:
        """Files beside this one: the controller and the spectra of noise sources."""
        names = [self.controller.file, *(t.table for t in (*self.noise.source, *self.noise.thruster))]
        return list(dict.fromkeys(name for name in names if name is not None))

    def applied_requirements(self, outputs: Sequence[str] = OUTPUTS) -> list[AppliedRequirement]:
        """Requirements with the outputs of the closed loop that they judge; of the defaults those on `outputs`."""
        is_given = "requirements" in self.model_fields_set
        return [t.applied() for t in self.requirements if is_given or set(t.outputs) <= set(outputs)]


def load_dynamics(path: Path | None) -> tuple[ConfigFile | None, DynamicsConfig]:
    """Read a dynamics file, or the defaults where the project names none; `ConfigError` lists all problems.

    Tables of requirements are made relative to the current folder.
    """
    if path is None:
        return None, DynamicsConfig()
    file, config = load(DynamicsConfig, path, hint=named_by_project("dynamics"))
    if "requirements" not in config.model_fields_set:
        return file, config
    requirements = [
        r.model_copy(update={"table": str(path.parent / r.table)}) if r.table else r for r in config.requirements
    ]
    return file, config.model_copy(update={"requirements": requirements})
