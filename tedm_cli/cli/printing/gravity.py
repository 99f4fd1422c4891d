"""Self-gravity and its accuracy, as lines of text and for programs."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from tedm_cli.cli.printing.table import scientific, table
from tedm_cli.results.wording import count

if TYPE_CHECKING:
    from tedm_cli.gravity.requirements import DcVerdict
    from tedm_cli.stages.gravity.accuracy import AccuracyResult
    from tedm_cli.stages.gravity.self_gravity import PointField
    from tedm_cli.stages.gravity.sensitivity import SensitivitySummary

_LISTED = 0.1  # verdicts on the field at rest are printed where their ratio is above this


def sensitivity_lines(done: SensitivitySummary) -> list[str]:
    """Field at rest, stiffness and largest sensitivities."""
    from tedm_cli.results.gravity.compensation import ties_text

    lines = [
        f"{done.path}: S_SG with {len(done.row_labels)} rows, in the frames of the test masses;"
        f" masses: {done.mass_model}, {max(done.points):,} points"
    ]
    quantities = (
        ("acceleration", "m/s^2", done.acceleration),
        ("angular acceleration", "rad/s^2", done.angular_acceleration),
        ("Gamma_lin diagonal", "1/s^2", done.gamma_lin.diagonal(axis1=2, axis2=3)),
    )
    rows = []
    for t, tm in enumerate(done.test_masses):
        for s, source in enumerate(done.sources):
            for quantity, unit, value in quantities:
                shown = (scientific(v, abs(value).max(), 4) for v in value[t, s])
                rows.append((tm.name, source, quantity, unit, *shown))
    lines += table(("at rest", "source", "quantity", "unit", "x", "y", "z"), rows, right=(4, 5, 6))
    if done.blocks:
        points = [how.points for how in done.block_quadrature]
        names, ties = [b.name for b in done.blocks], ["" if b.tie is None else b.tie.words for b in done.blocks]
        lines.append(
            f"{len(done.blocks)} compensation masses, {sum(b.mass_kg for b in done.blocks):.6g} kg:"
            f" {ties_text(names, ties)}; quadrature of {min(points):,} to {max(points):,} points each, estimated"
            f" relative error at most {max(how.error for how in done.block_quadrature):.1e}"
        )
    rows = [
        (label, f"{value:.3e}", unit, area)
        for label, unit, (area, value) in zip(done.row_labels, done.row_units, done.largest, strict=True)
    ]
    lines += table(("sensitivity", "largest", "unit", "area"), rows, right=(1,))
    return lines + _dc_verdict_lines(done.verdicts, done.subsystems)


def sensitivity_dict(done: SensitivitySummary) -> dict[str, Any]:
    """What a program needs: sums at rest over all sources, the largest sensitivities, and every verdict."""
    from tedm_cli.gravity.requirements import AT_REST_UNITS

    quantities = (
        ("acceleration_m_s2", done.acceleration),
        ("angular_acceleration_rad_s2", done.angular_acceleration),
        ("gamma_lin_1_s2", done.gamma_lin),
    )
    rows = zip(done.row_labels, done.row_units, done.largest, strict=True)
    return {
        "file": done.path,
        "mass_model": done.mass_model,
        "points": done.points,
        "at_rest": [
            {
                "test_mass": tm.name,
                "source": source,
                **{name: value[t, s] for name, value in quantities},
            }
            for t, tm in enumerate(done.test_masses)
            for s, source in enumerate(done.sources)
        ],
        "compensation_masses": [
            {"name": b.name, "mass_kg": b.mass_kg, "tied_to": None if b.tie is None else b.tie.words}
            for b in done.blocks
        ],
        "largest_sensitivity": [
            {"output": label, "value": value, "unit": unit, "area": area} for label, unit, (area, value) in rows
        ],
        "passed": all(v.passed for v in done.verdicts) if done.verdicts else None,
        "verdicts": [
            {
                "test_mass": v.test_mass,
                "minus": v.minus or None,
                "quantity": v.quantity,
                "subsystem": v.subsystem,
                "requirement": v.requirement,
                "value": v.value,
                "lower": v.lower,
                "upper": v.upper,
                "unit": AT_REST_UNITS[v.quantity],
                "ratio": v.ratio,
                "passed": v.passed,
            }
            for v in done.verdicts
        ],
    }


def _dc_verdict_lines(verdicts: list[DcVerdict], subsystems: list[str]) -> list[str]:
    from tedm_cli.gravity.requirements import AT_REST_UNITS
    from tedm_cli.results.gravity.field import not_allocated

    if not verdicts:
        return ["field at rest: not judged, for the configuration limits nothing ([[requirement_at_rest]])"]
    head = ("DC", "quantity", "subsystem", "unit", "value", "limit", "ratio", "verdict")
    rows = [
        (
            v.place,
            v.quantity,
            v.subsystem,
            AT_REST_UNITS[v.quantity],
            f"{v.value:.3e}",
            f"{v.limit:.3g}",
            f"{v.ratio:.3g}",
            "pass" if v.passed else "FAIL",
        )
        for v in verdicts
        if v.ratio > _LISTED
    ]
    passed = sum(v.passed for v in verdicts)
    lines = table(head, rows, right=(4, 5, 6)) if rows else []
    rest = f"; the rest is below {_LISTED:g} and in the file" if len(rows) < len(verdicts) else ""
    lines.append(f"field at rest: {passed} of {len(verdicts)} within their limits{rest}")
    lines += [
        f"{p}: the difference, each in its own frame" for p in dict.fromkeys(v.place for v in verdicts if v.minus)
    ]
    if all(v.whole for v in verdicts):
        parts = (
            f"no limit is on a part of it ({', '.join(subsystems)})"
            if subsystems
            else "parts need [gravity.subsystems]"
        )
        lines.append(f"only everything in the model together is judged; {parts}")
    return lines + [f"not judged: {clause}" for clause in not_allocated(verdicts)]


def point_field_lines(done: PointField) -> list[str]:
    """Field and stiffness of point sources, and what each source contributes where that was asked for."""
    from tedm_cli.stages.gravity.self_gravity import totals

    sources = done.sources
    lines = [
        f"{sources.path}: {count(len(sources.line), 'point source')}, {sources.mass.sum():.9g} kg; results in the"
        " frames of the test masses"
    ]
    rows: list[tuple[str, ...]] = []
    for tm, field in zip(done.test_masses, done.total, strict=True):
        for quantity, unit, value in totals(tm, field):
            for row, label in zip(value.reshape(-1, 3), "xyz", strict=False):
                name = quantity if value.ndim == 1 else f"{quantity} {label}"
                rows.append((tm.name, name, unit, *(scientific(v, abs(value).max(), 6) for v in row)))
    lines += table(("test mass", "quantity", "unit", "x", "y", "z"), rows, right=(3, 4, 5))
    if done.by_source is None:
        return lines
    rows = []
    for n, line in enumerate(sources.line):
        for tm, field in zip(done.test_masses, done.by_source, strict=True):
            vectors = (field.acceleration[n], field.angular_acceleration[n])
            values = [scientific(v, abs(vector).max(), 4) for vector in vectors for v in vector]
            rows.append((str(line), f"{sources.mass[n]:.6g}", tm.name, *values))
    head = ("line", "kg", "test mass", "a_x m/s^2", "a_y", "a_z", "omegadot_x rad/s^2", "omegadot_y", "omegadot_z")
    return lines + table(head, rows, right=(0, 1, 3, 4, 5, 6, 7, 8))


def accuracy_lines(done: AccuracyResult) -> list[str]:
    """What a study found at a few places."""
    study = done.study
    columns = range(len(study.spot_head))
    return [
        study.title,
        *study.notes,
        *table(study.spot_head, study.spots, right=columns),
        f"{done.data}, {done.figure}",
    ]


def accuracy_dict(done: AccuracyResult) -> dict[str, Any]:
    """What a program needs: the files, whose columns have all numbers, and what is printed of them."""
    study = done.study
    return {
        "title": study.title,
        "notes": study.notes,
        "data": done.data,
        "figure": done.figure,
        "columns": list(study.columns),
        "spots": [dict(zip(study.spot_head, spot, strict=True)) for spot in study.spots],
    }
