"""What a kelvin of each grid and each element does to outputs, on the mesh, where adjoint.h5 is there."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from tedm_cli.arrays import FloatArray, IntArray
from tedm_cli.contracts import ADJOINT
from tedm_cli.exports.vtu import MeshArray, array_name
from tedm_cli.files.build_folder import ADJOINT_FILE, OPTICS_FILE, SENSITIVITY_FILE, require_input
from tedm_cli.files.provenance import input_files
from tedm_cli.files.store import Reader, open_checked
from tedm_cli.results.adjoint.map import element_rows, has_map, read_map


def adjoint_arrays(
    build_dir: Path, unit: Reader, outputs: Sequence[str], element: IntArray
) -> tuple[list[MeshArray], list[MeshArray]]:
    """Arrays on grids and on cells, of the outputs that the adjoint has; none where there is no adjoint.

    Parameters
    ----------
    element : [cells], row in unit_loads.h5 of the element of each cell, -1: none.

    Raises
    ------
    InputError : the adjoint is of other results than there are now.
    """
    on_grids: list[MeshArray] = []
    on_cells: list[MeshArray] = []
    path = build_dir / ADJOINT_FILE
    if not path.exists():
        return on_grids, on_cells
    with open_checked(path, ADJOINT) as file:
        used = [unit.path, *(p for n in (SENSITIVITY_FILE, OPTICS_FILE) if (p := build_dir / n).exists())]
        for one in input_files(used):
            require_input(file, one)
        wanted = [label for label in dict.fromkeys(outputs) if has_map(file, label)]
        if not wanted:
            return on_grids, on_cells
        rows, own = element_rows(file, unit), bool(file.array(ADJOINT.ELEMENT_OWN).any())
        for label in wanted:
            found = read_map(file, label)
            per = f"{label} per kelvin of"
            rest = "; without elements that have temperatures of their own" if own else ""
            on_grids.append(
                MeshArray(array_name("adjoint", label), found.grid, found.unit, f"{per} the grid{rest}", total=True)
            )
            on_cells += [
                MeshArray(
                    array_name("adjoint_element", label),
                    _of_cells(found.whole, 0.0, rows, element),
                    found.unit,
                    f"{per} the whole element; its sum is what 1 K everywhere does to the structure",
                    total=True,
                ),
                MeshArray(
                    array_name("adjoint_density", label),
                    _of_cells(found.density, np.nan, rows, element),
                    f"{found.unit}/m^3",
                    f"{per} the element, over its volume; nan: no volume",
                ),
            ]
    return on_grids, on_cells


def _of_cells(value: FloatArray, nothing: float, rows: IntArray, element: IntArray) -> FloatArray:
    """Values of elements in the given rows [E] by the element of each cell."""
    table = np.full(max(int(element.max(initial=-1)), int(rows.max(initial=-1))) + 2, nothing)
    table[rows] = value
    table[-1] = nothing
    return table[element]
