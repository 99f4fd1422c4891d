"""The mesh against what it has to resolve, as lines of text: verdict first, conclusion last."""

from __future__ import annotations

from typing import TYPE_CHECKING

from tedm_cli.cli.printing.table import above_rounding, table
from tedm_cli.results.wording import ratio_text

if TYPE_CHECKING:
    from tedm_cli.stages.gravity.audit import AuditSummary

_WORDS = {"lumped": "lumped masses", "quadrature": "quadrature over the elements"}


def audit_lines(done: AuditSummary, most: int | None) -> list[str]:
    """Verdict, errors of the sums against what is allowed, worst properties and elements, and what follows."""
    return [*_verdict_lines(done), "", *_quantity_lines(done), "", *_element_lines(done, most), conclusion(done)]


def _verdict_lines(done: AuditSummary) -> list[str]:
    """How each mass model does, the one in use first."""
    lines = []
    for model in sorted(_WORDS, key=lambda name: name != done.mass_model):
        label, ratio = done.largest(model)
        use = "in use" if model == done.mass_model else "not in use"
        lines.append(
            f"{'pass' if ratio <= 1.0 else 'FAIL'}: {_WORDS[model]} ({use}); the largest error of a sum is"
            f" {ratio_text(ratio)} of what is allowed, in {label}"
        )
    return lines


def _quantity_lines(done: AuditSummary) -> list[str]:
    a = done.audit
    scale: dict[str, float] = {}
    for unit, value in zip(a.unit, a.value.tolist(), strict=True):
        scale[unit] = max(scale.get(unit, 0.0), abs(value))
    rows = []
    for q in done.as_dict(0)["quantities"]:
        lumped, quadrature = q["lumped"], q["quadrature"]
        errors = [above_rounding(m["error_of_sum"], m["sum_of_errors"]) for m in (lumped, quadrature)]
        ratios = [ratio_text(abs(e) / q["allowance"]) if q["allowance"] > 0.0 else "" for e in errors]
        rows.append(
            (
                q["quantity"],
                q["unit"],
                _number(above_rounding(q["value"], scale[q["unit"]]), 3),
                "" if q["requirement"] is None else f"{q['requirement']:.2e}",
                *(_number(v, 1) for v in (errors[0], lumped["sum_of_errors"], lumped["root_sum_square"])),
                *(_number(v, 1) for v in (errors[1], quadrature["sum_of_errors"])),
                *ratios,
            )
        )
    head = ("quantity", "unit", "value", "limit", "lumped", "l. sum", "l. rss", "quadr.", "q. sum")
    moved = "norm over the areas of a mean temperature"
    if not done.per_kelvin:
        moved = "every grid moved by a metre the worst way, as there is no distortion.h5"
    return [
        *table((*head, "l. ratio", "q. ratio"), rows, right=tuple(range(2, 11))),
        "lumped, quadr.: error of the sum over all elements, with lumped masses and by quadrature; l. sum, q. sum: the",
        "elements' errors summed in magnitude; l. rss: root of the sum of their squares; ratio: error of the sum over",
        "what is allowed, 1 % of the limit (without a limit, of the largest value of its kind); S_...: sensitivities",
        f"S: {moved}",
    ]


def _element_lines(done: AuditSummary, most: int | None) -> list[str]:
    d = done.as_dict(most)
    found = [
        (str(p["property"]), f"{p['elements']:,}", *(f"{v:.2g}" for v in p["score"].values()))
        for p in d["properties"][:most]
    ]
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
        *table(("property", "elements", "lumped", "quadrature"), found, right=(0, 1, 2, 3)),
        "",
        *table(titles, worst, right=(0, *range(2, 6 + len(names)))),
        "lumped, quadrature: largest error of the element over what is allowed of the sum; of a property, their sum",
    ]


def conclusion(done: AuditSummary) -> str:
    """In one sentence what remains, whether that is allowed, and what to do."""
    label, ratio = done.largest(done.mass_model)
    said = (
        f"conclusion: with {_WORDS[done.mass_model]} the largest error that remains, in {label}, is {ratio_text(ratio)}"
    )
    if done.passed:
        return f"{said} of what is allowed: the mesh is fine enough for its masses, and nothing is to be done"
    if done.mass_model == "lumped":
        other = done.largest("quadrature")[1]
        if other <= 1.0:
            return (
                f'{said} times what is allowed: set mass_model = "quadrature" in [gravity] of the model, which leaves'
                f" {ratio_text(other)} of it"
            )
    first = done.by_property()[0][0]
    finer = f", or lower quadrature_tolerance, now {done.tolerance:g}" if done.mass_model == "quadrature" else ""
    return f"{said} times what is allowed: refine the elements of property {first} near the test mass{finer}"


def _number(value: float, digits: int) -> str:
    return f"{value:.{digits}e}" if value else "0"
