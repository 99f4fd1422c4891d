"""The axes of test masses in the report, where they are not those of the frame that everything else is told in."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from tedm_cli.arrays import FloatArray
from tedm_cli.report.document import Table, columns, row
from tedm_cli.results.wording import decimals

_SAME = 1e-9


def own_axes(test_mass: Sequence[str], axes: FloatArray, frame: str) -> list[Table]:
    """A table of the axes [t, 3, 3] (rows) in this frame; none where all are the axes of the frame itself."""
    if np.abs(axes - np.eye(3)).max(initial=0.0) <= _SAME:
        return []
    rows = [
        row(name, *(decimals(axis.tolist(), 1.0, 6) for axis in of)) for name, of in zip(test_mass, axes, strict=True)
    ]
    head = columns("Test mass", "x", "y", "z", text=(0, 1, 2, 3))
    return [Table(head, tuple(rows), f"Axes x, y, z of each test mass, components in the {frame}.")]
