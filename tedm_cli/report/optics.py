"""The optics for the report: quality of the matrices, and the areas that each read-out feels most."""

from __future__ import annotations

from typing import Any

import numpy as np

from tedm_cli.figures.data import first_largest
from tedm_cli.store import Reader


def optics_of(file: Reader) -> dict[str, Any]:
    """What the report says of optics.h5."""
    shape = file.dataset("/S_BW").shape
    sigma = file.array("/singular_values")
    rank = int(file.number("/rank"))
    sets = file.strings("/set/name")
    return {
        "shape": shape,
        "rank": rank,
        "read_outs": len(file.strings("/label/read_out")),
        "singular_values": [float(v) for v in sigma[:rank]],
        "next_singular_value": float(sigma[rank]) if rank < len(sigma) else None,
        "sets": list(zip(sets, file.array("/set/condition"), strict=True)),
        "residuals": list(zip(file.strings("/residual/name"), file.array("/residual/value"), strict=True)),
        "offset": float(np.abs(file.array("/reference_point_offset")).max()),
        "worst": [row for name in sets for row in _worst_areas(file, name)],
    }


def _worst_areas(file: Reader, read_out_set: str) -> list[dict[str, Any]]:
    """The area with the largest read-out for each degree of freedom, and all areas by root sum of squares."""
    areas, noise = file.strings("/area/name"), file.array(f"/N/{read_out_set}")
    rows = []
    for label, unit, row in zip(
        file.strings("/label/read_out"), file.strings("/label/read_out_unit"), noise, strict=True
    ):
        worst = first_largest(range(len(row)), [float(v) for v in np.abs(row)])
        rows.append(
            {
                "read_out": f"{read_out_set}_{label}",
                "unit": f"{unit}/K",
                "area": areas[worst],
                "value": float(row[worst]),
                "all_as_one": float(row.sum()),
                "rss": float(np.linalg.norm(row)),
            }
        )
    return rows
