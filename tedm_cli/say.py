"""Results as lines of text and as plain dictionaries, for the terminal and for programs."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from tedm_cli.gravity.requirements import DcVerdict
    from tedm_cli.noise.case_run import CaseResult
    from tedm_cli.stages.accuracy import AccuracyResult
    from tedm_cli.stages.areas import AreaSummary
    from tedm_cli.stages.audit import AuditSummary
    from tedm_cli.stages.ingest import MassSummary
    from tedm_cli.stages.optics import OpticsSummary
    from tedm_cli.stages.self_gravity import PointField
    from tedm_cli.stages.sensitivity import SensitivitySummary
    from tedm_cli.stages.solve import SolveReport

_ROUNDING = 1e-9  # components this far below the largest of their quantity are printed as 0
_STIFF = 0.01  # relative change of displacements by bubble functions above which the mesh is called too stiff
_LISTED = 0.1  # verdicts on the field at rest are printed where their ratio is above this


def table(head: Sequence[str], rows: Sequence[Sequence[str]], right: Sequence[int] = ()) -> list[str]:
    """Columns padded to their widest entry; columns in `right` are aligned to the right."""
    widths = [max(len(str(r[i])) for r in [head, *rows]) for i in range(len(head))]

    def line(cells: Sequence[str]) -> str:
        padded = [c.rjust(w) if i in right else c.ljust(w) for i, (c, w) in enumerate(zip(cells, widths, strict=True))]
        return "  ".join(padded).rstrip()

    return [line(head), "  ".join("-" * w for w in widths), *(line(r) for r in rows)]


def area_lines(done: AreaSummary) -> list[str]:
    """Table of the thermal areas, and whether they are a partition of the structural grids."""
    t = done.table
    rows = [
        (
            str(t.name[i]),
            f"{done.grids[i]:,}",
            f"{done.mass_kg[i]:.6g}",
            *(f"{v:.4f}" for v in done.centroid_m[i]),
            *(str(column[i]) for column in (t.group, t.shield, t.side)),
        )
        for i in range(len(t))
    ]
    total = ("total", f"{done.grids.sum():,}", f"{done.mass_kg.sum():.6g}", *[""] * 6)
    head = ("area", "grids", "kg", "x m", "y m", "z m", "group", "shield", "side")
    left = len(done.found.left)
    elsewhere = done.total_kg - float(done.mass_kg.sum())
    if abs(elsewhere) < 1e-12 * done.total_kg:  # rounding of the sum
        elsewhere = 0.0
    return [
        f"{done.source}: areas of {done.origin}",
        *table(head, [*rows, total], right=(1, 2, 3, 4, 5)),
        f"centroid: mean of the grids; mass: shared among grids, {elsewhere:.6g} of"
        f" {done.total_kg:.6g} kg on grids of no area",
        *(f"note: {line}" for line in done.found.lines()),
        f"{done.structural - left:,} of {done.structural:,} structural grids are in exactly one area"
        + ("" if done.is_partition else f", {left:,} in none"),
    ]


def case_lines(path: Path, result: CaseResult) -> list[str]:
    """Verdict table of a case."""
    lines = [f"case {result.case.id}: {result.case.title} ({path})", _setting(result)]
    rows = [
        (
            v.output,
            v.requirement,
            f"{v.noise:.3g}",
            f"{v.limit:.3g}",
            f"{v.ratio:.3g}",
            f"{v.margin:.3g}",
            f"{v.binding_hz * 1e3:.3g}",
            "pass" if v.passed else "FAIL",
        )
        for v in result.verdicts
    ]
    head = ("output", "requirement", "noise", "limit", "ratio", "margin", "at mHz", "verdict")
    if not rows:
        return [*lines, "no requirement applies to this case's outputs"]
    return [
        *lines,
        *table(head, rows, right=(2, 3, 4, 5, 6)),
        "noise and limit: amplitude spectral density at the binding frequency, "
        + ", ".join(f"{u}/sqrt(Hz) ({k})" for k, u in _units(result)),
    ]


def _units(result: CaseResult) -> list[tuple[str, str]]:
    """(quantity, unit) of the judged outputs, each once."""
    judged = {v.output for v in result.verdicts}
    kinds = zip(result.labels, result.kinds, result.units, strict=True)
    return sorted({(k, u) for label, k, u in kinds if label in judged})


def _setting(result: CaseResult) -> str:
    return (
        f"temperature: {result.temperature.words()}; {int(result.active.sum())} of {len(result.active)} areas in"
        f" {len(result.blocks)} blocks; ratio = safety factor {result.safety_factor:g} x noise / limit"
    )


def case_dict(path: Path, result: CaseResult) -> dict[str, Any]:
    """What a program needs of a case."""
    return {
        "case": result.case.id,
        "title": result.case.title,
        "file": str(path),
        "setting": _setting(result),
        "safety_factor": result.safety_factor,
        "passed": all(v.passed for v in result.verdicts),
        "verdicts": [
            {
                "output": v.output,
                "requirement": v.requirement,
                "ratio": v.ratio,
                "margin": v.margin if v.ratio > 0 else None,
                "binding_hz": v.binding_hz,
                "noise": v.noise,
                "limit": v.limit,
                "passed": v.passed,
            }
            for v in result.verdicts
        ],
    }


def sensitivity_lines(done: SensitivitySummary) -> list[str]:
    """Field at rest, stiffness and largest sensitivities."""
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
        lines.append(
            f"{len(done.blocks)} compensation masses, {sum(b.mass_kg for b in done.blocks):.6g} kg, at rest in S_SG;"
            f" quadrature of {min(points):,} to {max(points):,} points each, estimated relative error at most"
            f" {max(how.error for how in done.block_quadrature):.1e}"
        )
    rows = [
        (label, f"{value:.3e}", unit, area)
        for label, unit, (area, value) in zip(done.row_labels, done.row_units, done.largest, strict=True)
    ]
    lines += table(("sensitivity", "largest", "unit", "area"), rows, right=(1,))
    return lines + _dc_verdict_lines(done.verdicts)


def _dc_verdict_lines(verdicts: list[DcVerdict]) -> list[str]:
    from tedm_cli.gravity.requirements import UNITS

    head = ("DC", "quantity", "subsystem", "unit", "value", "limit", "ratio", "verdict")
    rows = [
        (
            v.test_mass,
            v.quantity,
            v.subsystem,
            UNITS[v.quantity],
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
    lines.append(f"field at rest: {passed} of {len(verdicts)} within their allocation{rest}")
    if not any(v.subsystem == "IS" for v in verdicts):
        lines.append("no [gravity.subsystems]: IS and LTP are judged together only")
    return [*lines, "the rest of the satellite (S/C) is not in the model; its allocation is left to it"]


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
        "S: norm over the areas"
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


def mass_lines(masses: MassSummary) -> list[str]:
    """Mass, centre of gravity and inertia of the structure, and what they were checked against."""
    p, s = masses.properties, masses.sample
    least = _ROUNDING * float(abs(p.inertia_kg_m2).max())
    (xx, xy, xz), (_, yy, yz), (_, _, zz) = (
        (f"{v:.6g}" if abs(v) > least else "0" for v in row) for row in p.inertia_kg_m2
    )
    size = float(p.inertia_kg_m2.trace() / p.mass_kg) ** 0.5
    x, y, z = (f"{v:.6g}" if abs(v) > _ROUNDING * size else "0" for v in p.centre_m)
    lines = [
        f"mass {p.mass_kg:.9g} kg, centre of gravity ({x}, {y}, {z}) m in the basic frame",
        f"inertia about it: xx {xx}, yy {yy}, zz {zz}, xy {xy}, xz {xz}, yz {yz} kg m2",
        f"masses of {s.elements:,} elements agree with pyNastran's, by card and property, to {s.largest:.1e}"
        + (f" ({s.worst})" if s.largest > _ROUNDING else ""),
    ]
    lines += [f"the grid point weight table of {path} agrees" for path in masses.weight_tables]
    return lines + [f"left out: {kg:.6g} kg that stand for {name}" for name, kg in masses.test_mass_kg.items()]


def partial_lines(elements: list[int]) -> list[str]:
    """A note on elements that lack some of their midside nodes."""
    if not elements:
        return []
    shown = ", ".join(map(str, elements[:8])) + (" ..." if len(elements) > 8 else "")
    return [f"note: {len(elements)} elements lack midside nodes; their mass follows their corners alone: {shown}"]


def optics_lines(done: OpticsSummary) -> list[str]:
    """Size, rank, condition and invariances of the optical matrices."""
    conditions = ", ".join(f"cond(O_{name}) = {value:.4g}" for name, value in done.conditions.items())
    return [
        f"{done.path}: S_BW {done.shape[0]} x {done.shape[1]}, rank(O_ideal) = {done.rank}, {conditions} (m, rad)",
        f"layout reference points lie up to {done.largest_offset_m:.3g} m from their grids (accounted for)",
        f"S_BW: {done.origins[0]}; P: {done.origins[1]}",
        *table(
            ("invariance", "residual", "limit"),
            [(j.name, f"{j.value:.1e}", f"{j.limit:.1e}" if j.limit < math.inf else "-") for j in done.judged],
            right=(1, 2),
        ),
        *_difference_lines(done),
    ]


def _difference_lines(done: OpticsSummary) -> list[str]:
    """Where an imported S_BW differs most from the layout's own trace."""
    rows = [(d.path, d.element, f"{d.value:.1e}") for d in done.differences[:5]]
    return table(("path", "element", "difference from the trace"), rows, right=(2,)) if rows else []


def solve_lines(path: Path, done: SolveReport) -> list[str]:
    """Size of the model, quality of the solution, and what the elements do badly."""
    s = done.static
    elements = ", ".join(f"{number:,} {kind}" for kind, number in (done.solids | done.others).items() if number)
    lines = [
        f"{path}: {done.n_cases} load cases, {done.n_grids:,} grids, {elements}",
        f"{s.solver}: {s.n_dof:,} unknowns, assembled in {s.assemble_seconds:.1f} s, factorised in"
        f" {s.factor_seconds:.1f} s, solved in {s.solve_seconds:.1f} s; peak memory {done.peak_bytes / 1e9:.1f} GB",
        f"relative residual {s.max_relative_residual:.1e}, uniform expansion to {s.expansion_residual:.1e}",
    ]
    if done.bending_change is not None:
        lines.append(
            f"bending: with bubble functions in all linear solids displacements change by {done.bending_change:.2g}"
        )
        if done.bending_change > _STIFF:
            lines.append(
                "note: the linear solids are too stiff in bending; leave IN and ISOP of their PSOLID blank (bubble"
                " functions), take CHEXA20, CPENTA15 or CTETRA10, or more elements through the thickness"
            )
    if done.linear_tetrahedra:
        lines.append(
            f"note: {done.linear_tetrahedra:,} CTETRA4 have constant strain and are too stiff in bending, by an amount"
            " that is not estimated; take CTETRA10"
        )
    if s.unattached_grids:
        lines.append(f"note: {len(s.unattached_grids)} grids have no stiffness and are written as zero")
    return lines


def point_field_lines(done: PointField) -> list[str]:
    """Field and stiffness of point sources, and what each source contributes where that was asked for."""
    from tedm_cli.stages.self_gravity import totals

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
