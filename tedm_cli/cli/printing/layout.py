"""The checks of an optical layout as lines of text and as plain dictionaries."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from tedm_cli.cli.printing.table import table

if TYPE_CHECKING:
    from tedm_cli.optics.layout_checks import Finding
    from tedm_cli.stages.optics.layout import LayoutReport

_ROUNDING = 1e-9


def layout_lines(done: LayoutReport) -> list[str]:
    """The smallest margin of every element (of all reference points: of one), and what was not judged."""
    layout = done.layout
    worst: dict[tuple[str, str], Finding] = {}
    for f in done.findings:
        margin = f.margin
        if margin is not None and f.check != "obstruction":
            key = (f.check, "" if f.check == "reference_point" else f.element)
            other = worst.setdefault(key, f)
            if other.margin is not None and margin < other.margin:
                worst[key] = f
    rows = [
        (f.check, f.element, *_numbers(f), "pass" if f.passed else _verdict(f), f.where)
        for f in sorted(worst.values(), key=lambda f: f.check)
    ]
    head = ("check", "element", "value", "limit", "margin", "unit", "verdict", "smallest margin at")
    n_errors = sum(not f.passed and f.severity == "error" for f in done.findings)
    blind = [e.name for e in layout.elements if e.aperture_m is None]
    lines = [
        f"{done.path}: {layout.title}; {len(layout.elements)} elements, {len(layout.paths)} paths, read-out sets"
        f" {', '.join(layout.sets)}",
        *bench_lines(done.benches),
        *table(head, rows, right=(2, 3, 4)),
        *warning_lines(done.findings),
        f"{len(done.findings)} checks, {n_errors} failed",
        *_match_lines(done),
    ]
    if not layout.has_geometry:
        lines.append("the layout has no complete geometry: beams are not traced, S_BW is imported")
    if blind and layout.has_geometry:
        lines.append(f"no aperture_m, so neither hits nor obstruction judged: {', '.join(blind)}")
    if done.without_grid:
        lines.append(f"no grid yet, which build-distortion and build-optics need: {', '.join(done.without_grid)}")
    return lines


def _match_lines(done: LayoutReport) -> list[str]:
    """The test masses against those of the model's configuration, and the elements against the grids of the model."""
    if done.match is None:
        return [f"not compared with the test masses of the model: {done.unread}"]
    n = len(done.match.problems)
    names = ", ".join(done.match.compared)
    same = f"test masses as in the model: {names}" if names else "no test masses to compare with those of the model"
    on_grids = sum(e.grid is not None for e in done.layout.bench)
    if done.deck is None:
        grids = [f"not compared with the grids of the model: {done.unread_deck}"]
    else:
        grids = [f"grids of {on_grids} elements are in {done.deck.name}, near their elements"] if on_grids else []
    judged = [f"{n} {'difference' if n == 1 else 'differences'} from the model"] if n else [same]
    return [*(f"warning: {note}" for note in done.match.notes), *judged, *(grids if done.deck is None or not n else [])]


def bench_lines(found: Mapping[str, Sequence[str]]) -> list[str]:
    """Where there are several benches, which elements are on which."""
    listed = "; ".join(f"{name} ({', '.join(elements)})" for name, elements in found.items())
    return [f"{len(found)} benches, each of which may move by itself: {listed}"] if len(found) > 1 else []


def warning_lines(findings: Sequence[Finding]) -> list[str]:
    """What is unusual in the layout but does not make it invalid."""
    return [f"warning: {f.line}" for f in findings if not f.passed and f.severity == "warning"]


def layout_dict(done: LayoutReport) -> dict[str, Any]:
    """What a program needs of the checks: every one of them."""
    return {
        "layout": str(done.path),
        "passed": all(f.passed or f.severity == "warning" for f in done.findings)
        and not (done.match and done.match.problems),
        "against_model": None
        if done.match is None
        else {
            "problems": [{"key": key, "fact": fact} for key, fact in done.match.problems],
            "notes": done.match.notes,
            "deck": None if done.deck is None else str(done.deck),
        },
        "without_grid": done.without_grid,
        "benches": done.benches,
        "findings": [
            {
                "check": f.check,
                "where": f.where,
                "element": f.element,
                "value": f.value,
                "limit": f.limit,
                "margin": f.margin,
                "unit": f.unit,
                "passed": f.passed,
                "severity": f.severity,
                "fact": f.fact,
                "hint": f.hint,
            }
            for f in done.findings
        ],
    }


def _numbers(f: Finding) -> tuple[str, ...]:
    """Value, limit and margin in mm or mrad; what is rounding against the limit is 0."""
    shown = (v for v in (f.value, f.limit, f.margin) if v is not None)
    least = _ROUNDING * abs(f.limit or 0.0)
    return (*("0" if abs(v) <= least else f"{1e3 * v:.4g}" for v in shown), f"m{f.unit}")


def _verdict(f: Finding) -> str:
    return "FAIL" if f.severity == "error" else "warn"
