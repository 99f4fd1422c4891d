"""Verdicts of a case, as lines of text and for programs."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from tedm_cli.cli.printing.table import table
from tedm_cli.cli.printing.titles import legend_lines
from tedm_cli.results.wording import count

if TYPE_CHECKING:
    from tedm_cli.noise.case_run import CaseResult


def case_lines(path: Path, result: CaseResult) -> list[str]:
    """Verdict table of a case."""
    case = result.case
    lines = [f"case {case.id} ({case.role}): {case.title} ({path})", *filter(None, [case.reason]), _setting(result)]
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
        *legend_lines((v.output, v.requirement) for v in result.verdicts),
    ]


def _units(result: CaseResult) -> list[tuple[str, str]]:
    """(quantity, unit) of the judged outputs, each once."""
    judged = {v.output for v in result.verdicts}
    of = result.outputs
    kinds = zip(of.labels, of.kinds, of.units, strict=True)
    return sorted({(k, u) for label, k, u in kinds if label in judged})


def _setting(result: CaseResult) -> str:
    noun = "thermal nodes and areas" if result.case.thermal else "areas"
    return (
        f"temperature: {result.source.words()}; {int(result.active.sum())} of {len(result.active)} {noun} in"
        f" {count(len(result.blocks), 'block')}; ratio = safety factor {result.safety_factor:g} x noise / limit"
    )


def case_dict(path: Path, result: CaseResult) -> dict[str, Any]:
    """What a program needs of a case."""
    return {
        "case": result.case.id,
        "title": result.case.title,
        "role": result.case.role,
        "reason": result.case.reason,
        "file": str(path),
        "setting": _setting(result),
        "safety_factor": result.safety_factor,
        "passed": all(v.passed for v in result.verdicts) if result.verdicts else None,
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
