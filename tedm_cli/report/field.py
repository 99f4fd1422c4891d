"""The field at rest in the report: by source and summed, its verdicts, and the stiffness of the test masses."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from tedm_cli.arrays import FloatArray
from tedm_cli.gravity.requirements import DcVerdict
from tedm_cli.report.document import (
    Block,
    Cell,
    Column,
    Columns,
    Figure,
    Folded,
    Heading,
    Paragraph,
    Row,
    Section,
    Table,
    columns,
    row,
)
from tedm_cli.report.frames import own_axes
from tedm_cli.report.verdicts import NOT_JUDGED
from tedm_cli.results.gravity.compensation import Blocks, ties_text
from tedm_cli.results.gravity.field import FieldAtRest, Linearised, not_allocated, place_text, symbol
from tedm_cli.results.titles import at_rest_requirement, mass_title, subsystem_label
from tedm_cli.results.wording import SUPERSCRIPT, and_text, count, ratio_text, sci, unit_text, vector

_ROUNDING = 1e-9  # entries this far below what they are compared with are shown as 0


def field_section(field: FieldAtRest, figures: Sequence[Figure]) -> Section:
    """All that the annex says of sensitivity.h5 apart from [S_SG]."""
    blocks: list[Block] = [*figures, *_verdicts(field.verdicts), *_by_source(field)]
    blocks += [
        Heading("Stiffness, all sources"),
        Paragraph(
            "Stiffness is the derivative of the acceleration of a test mass by its own displacement or rotation,"
            " everything else at rest: rows are the component of a (Γ) or ω̇ (Ω), columns the axis the test mass moves"
            " along (lin) or turns about (ang), right-handed. With a positive Γ_xx a test mass displaced along x is"
            " pulled further away, which is unstable; with a negative one it is pulled back. A displacement of the"
            " sources acts with the opposite sign."
        ),
    ]
    for t, name in enumerate(field.test_mass):
        blocks += _stiffness(field, t, name)
    return Section("field-at-rest", "Field at rest", "Field at rest", (*blocks, _linearised(field.linearised)))


def _verdicts(verdicts: Sequence[DcVerdict]) -> list[Block]:
    if not verdicts:
        return [Paragraph(NOT_JUDGED)]
    tables = []
    for place in dict.fromkeys(v.place for v in verdicts):
        head = columns("Quantity", "By", "Verdict", "Ratio\n(1)", "Value", "Allowed", text=(0, 1, 2))
        rows = tuple(_verdict_row(v) for v in verdicts if v.place == place)
        tables.append(Table(head, rows, place_text(place), tight=True))
    return [
        Paragraph(" ".join(_what_is_judged(verdicts))),
        Columns(tuple(tables), "Every figure of the field at rest against its limit.", key="at rest"),
    ]


def _what_is_judged(verdicts: Sequence[DcVerdict]) -> list[str]:
    """Sentences on the requirements, whose field it is, differences, and ratios."""
    said = []
    for name in dict.fromkeys(v.requirement for v in verdicts):
        of_work: dict[str, list[str]] = {}  # places in one publication
        for source in dict.fromkeys(v.source for v in verdicts if v.requirement == name):
            work, _, place = source.partition(", ")
            of_work.setdefault(work, []).append(place)
        sources = [", ".join([work, *filter(None, found)]) for work, found in of_work.items()]
        said.append(f"{at_rest_requirement(name)} ({'; '.join(sources)}).")
    if differences := [v for v in verdicts if v.minus]:
        places = and_text([place_text(p) for p in dict.fromkeys(v.place for v in differences)])
        said.append(f"{places}: the difference of the two test masses, each in its own frame.")
    names = dict.fromkeys(v.subsystem for v in verdicts)
    said.append(f"{'; '.join(map(subsystem_label, names))}.")
    said += [f"Not judged: {clause}." for clause in not_allocated(verdicts)]
    said.append(
        "Ratio: value over the limit on its side of the range; met if it is at most 1. A ratio below 10⁻⁹ is rounding;"
        " its value is shown as 0."
    )
    return said


def _verdict_row(v: DcVerdict) -> Row:
    rounding = v.ratio < _ROUNDING
    return row(
        f"{symbol(v.quantity)} ({unit_text(v.unit)})",
        v.subsystem,
        Cell("pass" if v.passed else "FAIL", "met" if v.passed else "violated"),
        Cell("< 10⁻⁹" if rounding else ratio_text(v.ratio), rounding=rounding),
        _number((v.value, rounding)),
        _range_text(v.lower, v.upper),
        kind="" if v.passed else "failed",
    )


def _range_text(lower: float, upper: float) -> str:
    """A range with its power of ten once: ±3.5 × 10⁻¹⁰, (−1 to 2) × 10⁻⁷."""
    exponent = math.floor(math.log10(max(-lower, upper)) + _ROUNDING)
    low, high = (f"{end / 10.0**exponent:.4g}".replace("-", "−") for end in (lower, upper))
    ends = f"±{high}" if low == f"−{high}" else f"({low} to {high})"
    return f"{ends} × 10{str(exponent).translate(SUPERSCRIPT)}"


def _by_source(field: FieldAtRest) -> list[Block]:
    names, sources = field.test_mass, field.source
    a, w = field.acceleration, field.angular_acceleration
    error, points = field.quadrature_error, field.points
    rows = []
    for t, name in enumerate(names):
        for s, source in enumerate(sources):
            numbers = map(_number, (*_marked(a[t, s], a), *_marked(w[t, s], w)))
            quadrature = "no estimate" if math.isnan(error[t, s]) else sci(float(error[t, s]), 2)
            rows.append(row(name, source, *numbers, f"{int(points[t, s]):,}", quadrature))
        whole = map(_number, (*_marked(a[t].sum(axis=0), a), *_marked(w[t].sum(axis=0), w)))
        rows.append(row(name, "sum", *whole, "", "", kind="sum"))
    head = columns(
        *("Test mass", "Source"),
        *(f"a_{axis}\n(m/s²)" for axis in "xyz"),
        *(f"ω̇_{axis}\n(rad/s²)" for axis in "xyz"),
        *("Points", "Quadrature\nerror (1)"),
        text=(0, 1),
    )
    model = field.mass_model
    quality = (
        "quadrature, that is the mass of each element spread over it as Gauss points; the error stated is the tolerance"
        " that each element keeps, relative to its own force (torques: about five times it). Where elements pull"
        " in opposite directions the sum is less exact."
        if model == "quadrature"
        else f"{model}, that is the mass of each element shared equally among its grids; this has no error estimate,"
        " and close to a test mass it can be far off."
    )
    where = zip(names, field.position_m, field.mass_kg, strict=True)
    places = "".join(f" {n}: {sci(float(kg))} kg at {vector(p)} m in the Nastran basic frame." for n, p, kg in where)
    return [
        Heading("By source"),
        Paragraph(
            "Frame: the nominal frame of each test mass, origin at its centre, axes along its edges; theta, eta and phi"
            f" turn about x, y and z.{places}"
        ),
        *own_axes(names, field.axes, "Nastran basic frame"),
        Paragraph(
            "A grey 0 is rounding: less than 10⁻⁹ of the largest entry of the same matrix (3 × 3 block) or, for a and"
            " ω̇, of all sources and test masses."
        ),
        Paragraph(
            "Acceleration a is force over mass, angular acceleration ω̇ torque over moment of inertia. Mass model of the"
            f" structure: {quality} The errors of the other sources are differences between two orders of Gauss"
            " quadrature."
        ),
        *_compensation(field.blocks),
        Table(head, tuple(rows), "Acceleration and angular acceleration by source, and summed.", tight=True),
    ]


def _compensation(blocks: Blocks) -> list[Block]:
    """How many compensation masses there are, and which of them temperature moves."""
    if not blocks.name:
        return []
    kg = sci(float(blocks.mass_kg.sum()), 4)
    number = count(len(blocks.name), "compensation mass", "compensation masses")
    return [Paragraph(f"{number}, {kg} kg: {ties_text(blocks.name, blocks.tie)}.")]


def _marked(values: FloatArray, reference: FloatArray) -> list[tuple[float, bool]]:
    """Values, and whether each is no more than rounding beside the largest of its kind."""
    largest = float(np.abs(reference).max())
    return [(float(v), bool(abs(v) < _ROUNDING * largest)) for v in values]


def _number(marked: tuple[float, bool], digits: int = 4) -> Cell:
    value, rounding = marked
    return Cell("0", rounding=True) if rounding else Cell(sci(value, digits))


def _stiffness(field: FieldAtRest, t: int, name: str) -> list[Block]:
    """The four stiffness matrices of one test mass: sums first, then by source."""
    sums, parts = [], []
    for letter, stiffness in field.stiffness.items():
        value, unit = stiffness.value[t], unit_text(stiffness.unit)
        sums.append(_matrix(value.sum(axis=0), f"{letter} ({unit}): {stiffness.meaning}"))
        parts += [_matrix(v, f"{letter} ({unit}), {s}") for s, v in zip(field.source, value, strict=True)]
    return [
        Heading(name),
        Columns(tuple(sums), f"Stiffness of {mass_title(name)}, all sources."),
        Folded(
            f"Stiffness of {name} by source", (Columns(tuple(parts), f"Stiffness of {mass_title(name)} by source."),)
        ),
    ]


def _matrix(value: FloatArray, caption: str) -> Table:
    rows = tuple(row(axis, *map(_number, _marked(v, value))) for axis, v in zip("xyz", value, strict=True))
    return Table(columns("", "x", "y", "z"), rows, caption, heading_column=True)


def _linearised(motion: Linearised) -> Folded:
    """The equations of motion of all test masses. Blocks of 3 × 3 share a unit and are judged for rounding alone."""
    value = motion.value
    largest = np.abs(value).reshape(len(value) // 3, 3, -1, 3).max(axis=(1, 3)).repeat(3, axis=0).repeat(3, axis=1)
    head = [Column("")]
    head += [Column(f"{n}\n({u})") for n, u in zip(motion.motion, motion.motion_unit, strict=True)]
    rows = []
    for name, unit, values, reference in zip(motion.output, motion.output_unit, value, largest, strict=True):
        marked = [(float(v), bool(abs(v) < _ROUNDING * m)) for v, m in zip(values, reference, strict=True)]
        rows.append(row(f"{name} ({unit_text(unit)})", *(_number(m, 3) for m in marked)))
    return Folded(
        f"Linearised equations of motion of all test masses, {value.shape[0]} × {value.shape[1]}",
        (
            Paragraph(
                "Change of the accelerations in the rows by small motions in the columns, each in the nominal frame of"
                " its test mass; angles are right-handed. Unit of an entry: unit of its row over unit of its column."
                " Structure and compensation masses stay at rest. Blocks on the diagonal are the stiffness matrices"
                " above; the others are the effect of the motion of one test mass on another."
            ),
            Table(tuple(head), tuple(rows), "Linearised equations of motion.", tight=True, heading_column=True),
        ),
    )
