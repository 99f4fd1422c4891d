"""The field at rest as sensitivity.h5 tells it: its verdicts with their symbols and words, by source, and stiffness."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from tedm_cli.arrays import FloatArray, IntArray
from tedm_cli.contracts import SENSITIVITY
from tedm_cli.files.store import Reader
from tedm_cli.gravity.requirement_presets import PRESETS
from tedm_cli.gravity.requirements import DcVerdict
from tedm_cli.results.gravity.compensation import Blocks, read_blocks
from tedm_cli.results.ranking import first_largest
from tedm_cli.results.titles import SUBSYSTEM_TITLES
from tedm_cli.results.wording import and_text


def dc_verdicts(file: Reader) -> list[DcVerdict]:
    """Verdicts on the field at rest in sensitivity.h5, in the order in which they were made."""
    kind = SENSITIVITY
    names = [file.strings(p) for p in (kind.DC_VERDICT_TEST_MASS, kind.DC_VERDICT_QUANTITY, kind.DC_VERDICT_SUBSYSTEM)]
    numbers = [file.array(p).tolist() for p in (kind.DC_VERDICT_VALUE, kind.DC_VERDICT_LOWER, kind.DC_VERDICT_UPPER)]
    more = [file.strings(p) for p in (kind.DC_VERDICT_MINUS, kind.DC_VERDICT_REQUIREMENT, kind.DC_VERDICT_SOURCE)]
    whole = file.array(kind.DC_VERDICT_WHOLE).astype(bool).tolist()
    return [DcVerdict(*row) for row in zip(*names, *numbers, *more, whole, strict=True)]


def not_allocated(verdicts: Sequence[DcVerdict]) -> list[str]:
    """Clauses on what presets allocate to subsystems that the model does not have."""
    judged = {name for v in verdicts for name in v.subsystem.split("+")}
    said = []
    for requirement in dict.fromkeys(v.requirement for v in verdicts if v.requirement in PRESETS):
        if absent := [name for name in PRESETS[requirement].subsystems if name not in judged]:
            names = and_text([f"{name} ({SUBSYSTEM_TITLES[name]})" for name in absent])
            said.append(f"what {requirement} allocates to {names}, for the model has no subsystem of that name")
    return said


def worst_at_rest(verdicts: Sequence[DcVerdict]) -> DcVerdict:
    """The verdict with the largest ratio."""
    return first_largest(verdicts, [v.ratio for v in verdicts])


def place_text(place: str) -> str:
    """Where a verdict is, as it is printed: `TM1`, or `TM2 − TM1` of the difference `TM2-TM1`."""
    return place.replace("-", " − ")


def symbol(quantity: str) -> str:
    """A judged quantity as it is printed: `gamma_xx` as Γ_xx, `omegadot_eta` as ω̇_eta."""
    return quantity.replace("gamma", "Γ").replace("omegadot", "ω̇")


@dataclass(frozen=True, eq=False)
class Stiffness:
    """A stiffness of every test mass by every source, [t, s, 3, 3], with its unit and what it is."""

    value: FloatArray
    unit: str
    meaning: str


@dataclass(frozen=True, eq=False)
class Linearised:
    """The equations of motion of all test masses [n, n]: rows are accelerations, columns small motions."""

    value: FloatArray
    output: list[str]
    output_unit: list[str]
    motion: list[str]
    motion_unit: list[str]


@dataclass(frozen=True, eq=False)
class FieldAtRest:
    """What pulls at each of t test masses at rest, by s sources, in the nominal frame of the test mass.

    Parameters
    ----------
    test_mass, position_m, mass_kg : names, centres [t, 3] in the basic frame, masses [t].
    axes : [t, 3, 3], axes of the test masses as rows, basic frame.
    source, mass_model : names of the sources, and how the mass of the structure is represented.
    acceleration, angular_acceleration : [t, s, 3], m/s² and rad/s².
    points, quadrature_error : [t, s], points that a source is made of, and its relative error; NaN: no estimate.
    blocks : the compensation masses one by one.
    stiffness : by symbol (Γ_lin, Ω_lin, Γ_ang, Ω_ang).
    """

    test_mass: list[str]
    position_m: FloatArray
    mass_kg: FloatArray
    axes: FloatArray
    source: list[str]
    mass_model: str
    acceleration: FloatArray
    angular_acceleration: FloatArray
    points: IntArray
    quadrature_error: FloatArray
    stiffness: dict[str, Stiffness]
    linearised: Linearised
    verdicts: list[DcVerdict]
    blocks: Blocks


_STIFFNESS = {
    "Γ_lin": SENSITIVITY.STIFFNESS_GAMMA_LIN,
    "Ω_lin": SENSITIVITY.STIFFNESS_OMEGA_LIN,
    "Γ_ang": SENSITIVITY.STIFFNESS_GAMMA_ANG,
    "Ω_ang": SENSITIVITY.STIFFNESS_OMEGA_ANG,
}


def read_linearised(file: Reader) -> Linearised:
    """The equations of motion in sensitivity.h5."""
    return Linearised(
        value=file.array(SENSITIVITY.STIFFNESS_LINEARISED),
        output=file.strings(SENSITIVITY.LABEL_TM_OUTPUT),
        output_unit=file.strings(SENSITIVITY.LABEL_TM_OUTPUT_UNIT),
        motion=file.strings(SENSITIVITY.LABEL_TM_MOTION),
        motion_unit=file.strings(SENSITIVITY.LABEL_TM_MOTION_UNIT),
    )


def read_field(file: Reader) -> FieldAtRest:
    """What sensitivity.h5 says apart from [S_SG]."""

    def stiffness(path: str) -> Stiffness:
        return Stiffness(file.array(path), file.units(path), file.kind.datasets[path].long_name)

    return FieldAtRest(
        test_mass=file.strings(SENSITIVITY.TEST_MASS_NAME),
        position_m=file.array(SENSITIVITY.TEST_MASS_POSITION),
        mass_kg=file.array(SENSITIVITY.TEST_MASS_MASS),
        axes=file.array(SENSITIVITY.TEST_MASS_AXES),
        source=file.strings(SENSITIVITY.SOURCE_NAME),
        mass_model=file.string(SENSITIVITY.SOURCE_MASS_MODEL),
        acceleration=file.array(SENSITIVITY.DC_ACCELERATION),
        angular_acceleration=file.array(SENSITIVITY.DC_ANGULAR_ACCELERATION),
        points=file.array(SENSITIVITY.SOURCE_POINTS),
        quadrature_error=file.array(SENSITIVITY.SOURCE_QUADRATURE_ERROR),
        stiffness={letter: stiffness(path) for letter, path in _STIFFNESS.items()},
        linearised=read_linearised(file),
        verdicts=dc_verdicts(file),
        blocks=read_blocks(file),
    )
