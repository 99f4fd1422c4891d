"""The mesh that was written, as lines of text."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from tedm_cli.cli.printing.table import table

if TYPE_CHECKING:
    from tedm_cli.stages.exports.mesh import MeshExport


def mesh_lines(done: MeshExport) -> list[str]:
    """Files, sizes, arrays, and what is not in them."""
    rows = [
        (a.name, where, a.unit, f"{a.values.sum():.6g}" if a.total else "", a.meaning)
        for where, arrays in (("points", done.on_points), ("cells", done.on_cells))
        for a in arrays
    ]
    left = ", ".join(f"{n:,} {card}" for card, n in done.left_out.items())
    return [
        f"{done.paths[0]}: {done.points:,} points, {done.cells:,} cells",
        *(str(path) for path in done.paths[1:]),
        *table(("array", "on", "unit", "sum", "meaning"), rows, right=(3,)),
        *([f"left out, having no shape of their own: {left}"] if left else []),
    ]


def mesh_dict(done: MeshExport) -> dict[str, Any]:
    """What a program needs."""
    return {
        "files": done.paths,
        "points": done.points,
        "cells": done.cells,
        "arrays": [
            {
                "name": a.name,
                "on": where,
                "unit": a.unit,
                "meaning": a.meaning,
                "sum": a.values.sum() if a.total else None,
            }
            for where, arrays in (("points", done.on_points), ("cells", done.on_cells))
            for a in arrays
        ],
        "left_out": done.left_out,
    }
