"""Thermal areas as lines of text."""

from __future__ import annotations

from typing import TYPE_CHECKING

from tedm_cli.cli.printing.table import table
from tedm_cli.results.areas import plane_words

if TYPE_CHECKING:
    from tedm_cli.config.symmetry_plane import ProjectPlane
    from tedm_cli.stages.model.areas import AreaSummary


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
        plane_line(done.plane),
        *(f"note: {line}" for line in [*done.found.lines(), *done.notes]),
        f"{done.structural - left:,} of {done.structural:,} structural grids are in exactly one area"
        + ("" if done.is_partition else f", {left:,} in none"),
    ]


def plane_line(used: ProjectPlane) -> str:
    """Which plane gives the areas their sides, and where it is from."""
    return f"symmetry plane: {plane_words(used.plane, used.origin, used.layout.name if used.layout else '')}"
