"""A self-contained problem of the dynamics in JSON, as `tedm simulate --problem` reads it."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import Field, field_validator, model_validator

from tedm_cli import quantities as q
from tedm_cli.config.base import Axes, Bounded, Frequency, Mass, Place, Strict, validate
from tedm_cli.dynamics.judging import THERMAL
from tedm_cli.errors import InputError
from tedm_cli.regular_file import require_regular_file

Moment = Annotated[float, Bounded(q.INERTIA)]
Moments = Annotated[list[Moment], Field(min_length=3, max_length=3)]
CornerRatio = Annotated[float, Bounded(q.CORNER_RATIO)]
Level = Annotated[float, Bounded(q.NOISE_LEVEL)]
Matrix = list[list[Annotated[float, Bounded(q.MATRIX_ENTRY)]]]


class BodyTable(Strict):
    """The spacecraft without its test masses; basic frame."""

    mass_kg: Annotated[float, Bounded(q.SPACECRAFT_MASS)]
    inertia_kg_m2: Annotated[list[Moments], Field(min_length=3, max_length=3)]
    centre_of_mass_m: Place


class MassTable(Strict):
    """A test mass: principal moments or tensor of inertia along its axes, centre and axes (rows), basic frame."""

    name: str
    mass_kg: Mass
    inertia_kg_m2: Moments | Annotated[list[Moments], Field(min_length=3, max_length=3)]
    position_m: Place
    axes: Axes


class StiffnessTable(Strict):
    """`fixed` [2, 6, 6] of what moves with the spacecraft, `mutual` [12, 12] of the other test mass."""

    fixed: list[Matrix]
    mutual: Matrix
    rows: list[str] | None = None
    columns: list[str] | None = None


class SensitivityTable(Strict):
    """S and N per kelvin of the areas, with the names of their rows."""

    S: Matrix
    S_rows: list[str]
    N: Matrix
    N_rows: list[str]
    area: list[str]


class ShapeTable(Strict):
    """Corner frequencies of the default loops, relative to their crossover."""

    integral: CornerRatio = 15.0
    lead: CornerRatio = 3.5
    rolloff: CornerRatio = 10.0


class LoopTable(Strict):
    """One default loop."""

    crossover_hz: Annotated[float, Bounded(q.CROSSOVER)]
    delay_s: Annotated[float, Bounded(q.CONTROL_DELAY)]


class ControllerTable(Strict):
    """The default controller with its loops, or A, B, C, D (u = C x + D y) with the names of inputs and outputs."""

    kind: Literal["default", "state_space"] = "default"
    shape: ShapeTable = ShapeTable()
    loops: dict[str, LoopTable] = Field(default_factory=dict)
    A: Matrix = Field(default_factory=list)
    B: Matrix = Field(default_factory=list)
    C: Matrix = Field(default_factory=list)
    D: Matrix = Field(default_factory=list)
    inputs: list[str] = Field(default_factory=list)
    outputs: list[str] = Field(default_factory=list)
    delay_s: Annotated[float, Bounded(q.CONTROL_DELAY)] = 0.0
    dt_s: Annotated[float, Bounded(q.DURATION)] | None = None


class SpectrumFields(Strict):
    """level² (1 + (corner_hz/f)^slope); a table of amplitudes; or the low-pass of temperatures."""

    form: Literal["power", "table", "low_pass"]
    level: Level = 1.0
    corner_hz: Annotated[float, Bounded(q.CORNER)] = 0.0
    slope: Annotated[float, Bounded(q.SPECTRAL_SLOPE)] = 0.0
    reference_hz: Frequency = 1e-3
    order: Annotated[float, Bounded(q.FILTER_ORDER)] = 2.0
    frequency_hz: list[Frequency] = Field(default_factory=list)
    amplitude: list[Level] = Field(default_factory=list)


class SourceTable(Strict):
    """An independent noise: `input` maps disturbances to gains."""

    name: str
    group: str
    input: dict[str, Annotated[float, Bounded(q.NOISE_GAIN)]]
    psd: SpectrumFields

    @field_validator("group")
    @classmethod
    def _not_the_temperatures(cls, value: str) -> str:
        if value == THERMAL:
            raise ValueError(f"{THERMAL!r} is of the temperatures; give it another name")
        return value


class TemperatureTable(Strict):
    """Correlation R of the areas, and the spectrum of each by name."""

    R: Matrix
    area_spectrum: list[str]
    spectrum: dict[str, SpectrumFields]


class Problem(Strict):
    """A whole problem. Results that a file holds beside it are not read."""

    title: str = ""
    spacecraft: BodyTable
    test_mass: Annotated[list[MassTable], Field(min_length=2, max_length=2)]
    stiffness: StiffnessTable
    sensitivity: SensitivityTable | None = None
    controller: ControllerTable = ControllerTable()
    source: list[SourceTable] = Field(default_factory=list)
    temperature: TemperatureTable | None = None
    frequency_hz: Annotated[list[Frequency], Field(min_length=1)]
    result: Any = None
    free_response: Any = None
    matrices: Any = None
    figure_6_2: Any = None

    @model_validator(mode="after")
    def _both_or_none(self) -> Problem:
        if (self.sensitivity is None) != (self.temperature is None):
            raise ValueError("needs both sensitivity and temperature, or neither")
        return self


def load_problem(path: Path) -> Problem:
    """Read a problem.

    Raises
    ------
    InputError : no such file, not JSON.
    ConfigError : keys or values that are not as `Problem` says.
    """
    return validate(Problem, _json(path), where=str(path))


def _json(path: Path) -> dict[str, Any]:
    require_regular_file(path)
    try:
        data = json.loads(path.read_text(encoding="utf-8"))
    except OSError as exc:
        raise InputError(f"cannot be read ({exc.strerror})", where=str(path)) from exc
    except (ValueError, RecursionError) as exc:
        raise InputError(f"is not JSON: {exc}", where=str(path)) from exc
    if not isinstance(data, dict):
        raise InputError("is no JSON object", where=str(path))
    return data
