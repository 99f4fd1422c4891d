"""Quality of the optical matrices as lines of text."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from tedm_cli.cli.printing.layout import bench_lines, warning_lines
from tedm_cli.cli.printing.table import table

if TYPE_CHECKING:
    from tedm_cli.stages.optics.build import OpticsSummary


def optics_lines(done: OpticsSummary, most: int | None) -> list[str]:
    """Size, rank, condition and invariances of the optical matrices."""
    conditions = ", ".join(f"cond(O_{name}) = {value:.4g}" for name, value in done.conditions.items())
    return [
        f"{done.path}: S_BW {done.shape[0]} x {done.shape[1]}, rank(O_ideal) = {done.rank}, {conditions} (m, rad)",
        f"layout reference points lie up to {done.largest_offset_m:.3g} m from their grids (accounted for)",
        f"S_BW: {done.origins[0]}; P: {done.origins[1]}",
        *bench_lines(done.benches),
        *table(
            ("invariance", "residual", "limit"),
            [(j.name, f"{j.value:.1e}", f"{j.limit:.1e}" if j.limit < math.inf else "-") for j in done.judged],
            right=(1, 2),
        ),
        *_difference_lines(done, most),
        *warning_lines(done.warnings),
        *(f"warning: {note}" for note in done.notes),
    ]


def optics_dict(done: OpticsSummary) -> dict[str, Any]:
    """What a program needs; a limit is null where a residual is reported only."""
    return {
        "file": done.path,
        "shape": done.shape,
        "rank": done.rank,
        "conditions": done.conditions,
        "origin": {"S_BW": done.origins[0], "P": done.origins[1]},
        "benches": done.benches,
        "largest_offset_m": done.largest_offset_m,
        "invariances": [{"name": j.name, "residual": j.value, "limit": j.limit} for j in done.judged],
        "differences": [{"path": d.path, "element": d.element, "difference": d.value} for d in done.differences],
        "warnings": [*(f.line for f in done.warnings), *done.notes],
    }


def _difference_lines(done: OpticsSummary, most: int | None) -> list[str]:
    """Where an imported S_BW differs most from the layout's own trace."""
    rows = [(d.path, d.element, f"{d.value:.1e}") for d in done.differences[:most]]
    return table(("path", "element", "difference from the trace"), rows, right=(2,)) if rows else []
