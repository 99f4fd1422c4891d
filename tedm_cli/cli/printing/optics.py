"""Quality of the optical matrices as lines of text."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from tedm_cli.cli.printing.layout import bench_lines
from tedm_cli.cli.printing.table import table

if TYPE_CHECKING:
    from tedm_cli.stages.optics.build import OpticsSummary


def optics_lines(done: OpticsSummary) -> list[str]:
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
        *_difference_lines(done),
    ]


def _difference_lines(done: OpticsSummary) -> list[str]:
    """Where an imported S_BW differs most from the layout's own trace."""
    rows = [(d.path, d.element, f"{d.value:.1e}") for d in done.differences[:5]]
    return table(("path", "element", "difference from the trace"), rows, right=(2,)) if rows else []
