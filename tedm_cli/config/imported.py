"""What must be declared about an imported matrix, in its file or beside it: nothing has a default."""

from __future__ import annotations

from typing import Annotated, Any, Literal, TypeVar

from pydantic import Field

from tedm_cli.arrays import FloatArray
from tedm_cli.config.base import Bounded, Form, Length, Place, Strict, validate
from tedm_cli.errors import ConfigError
from tedm_cli.optics.imported import Conventions, Frame, LabelledMatrix, MassAxes, MotionConventions, Slopes
from tedm_cli.optics.labels import Labels
from tedm_cli.optics.layout import Vec3
from tedm_cli.quantities import MATRIX_ACCURACY

Units = list[str] | dict[str, str]
Point = Literal["layout", "grid"]
Points = Annotated[
    Point | dict[str, Point | Place], Form('"layout", "grid", or table of these and of coordinates by element')
]


class BeamsTable(Strict):
    """What the labels call the two beams."""

    meas: str = Field(description="What the labels call the measurement beam.")
    ref: str = Field(description="What the labels call the reference beam.")


class LawTable(Strict):
    """What an imported P has to declare. What its own file says need not be here."""

    rows: list[str] = Field(description="Labels of the rows, in any order.")
    columns: list[str] = Field(description="Labels of the columns, in any order.")
    row_units: Units = Field(
        description="Units of the rows: a list, or by what stands behind the last underscore of the labels."
    )
    column_units: Units = Field(description="Units of the columns, in the same way.")
    beams: BeamsTable = Field(description="What the labels call the two beams.")
    slopes: Slopes = Field(description="Whether z1, z2 are slopes, or lengths: Zernike tilts R z, or Noll's R z / 2.")
    pupil_radius_m: Length | None = Field(
        default=None, description='Pupil radius R of "zernike" and "noll", which need it.'
    )


class SensitivityTable(LawTable):
    """What an imported S_BW has to declare. What its own file says need not be here."""

    frame: Frame = Field(description="Axes of the motions, and of reference points given as coordinates.")
    reference_points: Points = Field(
        description='What elements turn about: "layout" (`ref_m`), "grid", or by element one of these or coordinates.'
    )
    rotations: Literal["small_angle"] = Field(
        description="Rotations are small angles about the axes of the frame; nothing else is taken."
    )
    test_mass_axes: MassAxes | None = Field(
        default=None,
        description="Axes of the columns of test masses: their own, or those of the frame. Needed where test "
        "masses have `axes`.",
    )
    accuracy: Annotated[float, Bounded(MATRIX_ACCURACY)] | None = Field(
        default=None,
        description="Error of the entries where it is larger than their digits tell, as a fraction of the largest.",
    )


T = TypeVar("T", bound=LawTable)


def law_of(
    values: FloatArray, declared: dict[str, Any], *, where: str, hint: str
) -> tuple[LabelledMatrix, Conventions]:
    """P and what its entries mean; `ConfigError` lists all that is missing or wrong in the declaration."""
    table = _checked(LawTable, values, declared, where, hint)
    return _labelled(values, table), _outputs(table, None)


def sensitivity_of(
    values: FloatArray, declared: dict[str, Any], *, where: str, hint: str
) -> tuple[LabelledMatrix, Conventions, MotionConventions]:
    """S_BW and what its entries mean; `ConfigError` lists all that is missing or wrong in the declaration."""
    table = _checked(SensitivityTable, values, declared, where, hint)
    points = table.reference_points
    given: dict[str, str | Vec3] | str = (
        points
        if isinstance(points, str)
        else {name: p if isinstance(p, str) else (p[0], p[1], p[2]) for name, p in points.items()}
    )
    return (
        _labelled(values, table),
        _outputs(table, table.accuracy),
        MotionConventions(table.frame, given, table.test_mass_axes),
    )


def _checked(model: type[T], values: FloatArray, declared: dict[str, Any], where: str, hint: str) -> T:
    problems: list[tuple[str, str]] = []
    table: T | None = None
    try:
        table = validate(model, declared, where=where)
    except ConfigError as exc:
        problems += exc.problems
    slopes, radius = declared.get("slopes"), declared.get("pupil_radius_m")
    if slopes in ("zernike", "noll") and radius is None:
        problems.append(("pupil_radius_m", f"missing; slopes = {slopes!r} needs it"))
    if slopes == "angle" and radius is not None:
        problems.append(("pupil_radius_m", "slopes that are angles have none"))
    for key, size in zip(("rows", "columns"), values.shape, strict=True):
        labels, units = declared.get(key), declared.get(f"{key[:-1]}_units")
        if isinstance(labels, list) and len(labels) != size:
            problems.append((key, f"{len(labels)} labels for {size} {key}"))
        if isinstance(units, list) and len(units) != size:
            problems.append((f"{key[:-1]}_units", f"{len(units)} units for {size} {key}"))
        if isinstance(units, dict) and isinstance(labels, list):
            absent = dict.fromkeys(k for name in labels if (k := _quantity(str(name))) not in units)
            problems += [(f"{key[:-1]}_units.{quantity}", "missing") for quantity in absent]
    if problems or table is None:
        raise ConfigError(problems, where=where, hint=hint)
    return table


def _quantity(label: str) -> str:
    return label.rpartition("_")[2]


def _labelled(values: FloatArray, table: LawTable) -> LabelledMatrix:
    return LabelledMatrix(values, _labels(table.rows, table.row_units), _labels(table.columns, table.column_units))


def _labels(names: list[str], units: Units) -> Labels:
    listed = units if isinstance(units, list) else [units[_quantity(name)] for name in names]
    return Labels(tuple(names), tuple(listed))


def _outputs(table: LawTable, accuracy: float | None) -> Conventions:
    return Conventions({"meas": table.beams.meas, "ref": table.beams.ref}, table.slopes, table.pupil_radius_m, accuracy)
