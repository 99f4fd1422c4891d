"""Self-gravity, its mesh and its accuracy as lines of text."""

from __future__ import annotations

from typing import TYPE_CHECKING

from tedm_cli.cli.printing.table import table

if TYPE_CHECKING:
    from tedm_cli.gravity.requirements import DcVerdict
    from tedm_cli.stages.gravity.accuracy import AccuracyResult
    from tedm_cli.stages.gravity.audit import AuditSummary
    from tedm_cli.stages.gravity.self_gravity import PointField
    from tedm_cli.stages.gravity.sensitivity import SensitivitySummary

_ROUNDING = 1e-9  # components this far below the largest of their quantity are printed as 0
_LISTED = 0.1  # verdicts on the field at rest are printed where their ratio is above this


def sensitivity_lines(done: SensitivitySummary) -> list[str]:
    """Field at rest, stiffness and largest sensitivities."""
    from tedm_cli.results.compensation import ties_text

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
                least = _ROUNDING * abs(value).max()
                shown = ("0" if abs(v) <= least else f"{v:.4e}" for v in value[t, s])
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


def _dc_verdict_lines(verdicts: list[DcVerdict], subsystems: list[str]) -> list[str]:
    from tedm_cli.gravity.requirements import AT_REST_UNITS
    from tedm_cli.results.field import not_allocated

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


def audit_lines(done: AuditSummary, most: int) -> list[str]:
    """Errors of the sums against what is allowed, worst properties and worst elements."""
    d = done.as_dict(most)
    rows = [
        (
            q["quantity"],
            q["unit"],
            f"{q['value']:.3e}",
            "" if q["requirement"] is None else f"{q['requirement']:.2e}",
            *(f"{q['lumped'][k]:.1e}" for k in ("error_of_sum", "sum_of_errors", "root_sum_square")),
            *(f"{q['quadrature'][k]:.1e}" for k in ("error_of_sum", "sum_of_errors")),
            f"{abs(q['lumped']['error_of_sum']) / q['allowance']:.2g}" if q["allowance"] > 0 else "",
            f"{abs(q['quadrature']['error_of_sum']) / q['allowance']:.2g}" if q["allowance"] > 0 else "",
        )
        for q in d["quantities"]
    ]
    head = ("quantity", "unit", "value", "limit", "lumped", "linear", "rss", "quadr.", "q linear", "l/1%", "q/1%")
    lines = [
        *table(head, rows, right=tuple(range(2, 11))),
        "lumped, quadr.: error of the sum; linear, rss: sum of the elements' errors in magnitude, and root of their",
        "squares (q: by quadrature); l/1%, q/1%: error of the sum against 1 % of the limit, or of the value",
        "S: norm over the areas of a mean temperature"
        if done.per_kelvin
        else "S: every grid moved by a metre the worst way (no distortion.h5)",
        "",
    ]
    found = [
        (str(p["property"]), f"{p['elements']:,}", *(f"{v:.2g}" for v in p["score"].values()))
        for p in d["properties"][:most]
    ]
    lines += [*table(("property", "elements", "lumped", "quadrature"), found, right=(0, 1, 2, 3)), ""]
    names = [tm.name for tm in done.test_masses]
    worst = [
        (
            str(e["element"]),
            e["card"],
            str(e["property"]),
            f"{1e3 * e['size_m']:.3g}",
            *(f"{1e3 * e['gap_m'][n]:.3g}" for n in names),
            *(f"{v:.2g}" for v in e["score"].values()),
            e["quantity"],
        )
        for e in d["elements"]
    ]
    titles = ("element", "card", "property", "size mm", *(f"gap {n} mm" for n in names), "lumped", "quadrature", "in")
    return [
        *lines,
        *table(titles, worst, right=(0, *range(2, 6 + len(names)))),
        "lumped, quadrature: largest error of the element against the allowance of the sum",
    ]


def point_field_lines(done: PointField) -> list[str]:
    """Field and stiffness of point sources, and what each source contributes where that was asked for."""
    from tedm_cli.stages.gravity.self_gravity import totals

    sources = done.sources
    lines = [
        f"{sources.path}: {len(sources.line)} point sources, {sources.mass.sum():.9g} kg; results in the frames of the"
        " test masses"
    ]
    rows: list[tuple[str, ...]] = []
    for tm, field in zip(done.test_masses, done.total, strict=True):
        for quantity, unit, value in totals(tm, field):
            for row, label in zip(value.reshape(-1, 3), "xyz", strict=False):
                name = quantity if value.ndim == 1 else f"{quantity} {label}"
                rows.append((tm.name, name, unit, *(f"{v:.6e}" for v in row)))
    lines += table(("test mass", "quantity", "unit", "x", "y", "z"), rows, right=(3, 4, 5))
    if done.by_source is None:
        return lines
    rows = []
    for n, line in enumerate(sources.line):
        for tm, field in zip(done.test_masses, done.by_source, strict=True):
            values = (*field.acceleration[n], *field.angular_acceleration[n])
            rows.append((str(line), f"{sources.mass[n]:.6g}", tm.name, *(f"{v:.4e}" for v in values)))
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
