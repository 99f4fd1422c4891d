"""Where on the model an output feels temperatures: connected places, and single grids."""

from __future__ import annotations

import numpy as np

from tedm_cli.arrays import FloatArray
from tedm_cli.config.model.file import load_model
from tedm_cli.config.project import Project
from tedm_cli.contracts import ADJOINT, UNIT_LOADS
from tedm_cli.errors import InputError, UsageError
from tedm_cli.files.build_folder import (
    ADJOINT_FILE,
    OPTICS_FILE,
    SENSITIVITY_FILE,
    UNIT_LOADS_FILE,
    require_configuration,
    require_input,
)
from tedm_cli.files.provenance import input_files
from tedm_cli.files.store import open_checked
from tedm_cli.results.adjoint.map import MappedModel, OutputMap, has_map, read_map, read_mapped_model
from tedm_cli.results.explained import Column, Table, Told, clean_sum
from tedm_cli.results.titles import output_title
from tedm_cli.results.wording import count

_MM = tuple(Column(axis, "fixed", "mm") for axis in "xyz")


def explain_grids(project: Project, label: str) -> Told:
    """The places and the grids with the largest shares in an output, or in a difference of two.

    Raises
    ------
    ConfigError : the project has no test masses, and so no adjoint.
    UsageError : the adjoint does not have it.
    InputError : there is no adjoint of the model, or it is missing or stale.
    """
    load_model(project.model)[1].require_adjoint(project.model)
    build = project.build_dir
    path, loads = build / ADJOINT_FILE, build / UNIT_LOADS_FILE
    with open_checked(path, ADJOINT) as adjoint, open_checked(loads, UNIT_LOADS) as unit:
        require_configuration(adjoint, project.model)
        made = (
            [build / SENSITIVITY_FILE, build / OPTICS_FILE]
            if project.optics is not None
            else [build / SENSITIVITY_FILE]
        )
        for one in input_files([loads, *(p for p in made if p.exists())]):
            require_input(adjoint, one)
        if adjoint.has(ADJOINT.REFUSAL):
            raise InputError("; ".join(adjoint.strings(ADJOINT.REFUSAL)), where=str(path))
        if not has_map(adjoint, label):
            raise UsageError(f"{path} does not have {label}", hint=f"rebuild it with `{ADJOINT.made_by}`")
        found, model = read_map(adjoint, label), read_mapped_model(adjoint, unit)
    size = float(np.abs(found.whole).sum())
    own = "" if np.isclose(found.grid.sum(), found.whole.sum(), rtol=0.0, atol=1e-9 * size) else (
        "; elements with temperatures of their own are in no grid"
    )  # fmt: skip
    total = clean_sum(found.whole)
    return Told(
        label,
        "output by grids and elements",
        output_title(label),
        (
            f"1 K everywhere: {total:.3e} {found.unit}; sizes of all elements {size:.3e} {found.unit}"
            + (f", {size / abs(total):.3g} times as much" if total else ""),
        ),
        (_places(found, model), _grids(found, model)),
        (
            "place: connected elements of one area on which a kelvin acts in one direction; x, y, z: their centre, by"
            " what they do; share: of the sizes of all elements",
            f"grid: one kelvin of it alone; share: of the sizes of all {count(len(found.grid), 'grid')}{own}",
        ),
        source=str(path),
    )


def _places(found: OutputMap, model: MappedModel) -> Table:
    rows = tuple(
        (
            model.area_name(p.area),
            p.value,
            p.share,
            *_mm(p.position),
            1e6 * p.volume,
            len(p.elements),
            int(found.element_id[p.elements[np.abs(found.whole[p.elements]).argmax()]]),
        )
        for p in model.places(found)
    )
    columns = (
        *(Column("place in area"), Column("value", "number", found.unit), Column("share", "share", whole="all"), *_MM),
        *(Column("volume", "fixed", "cm^3"), Column("elements", "number"), Column("largest element", "number")),
    )
    return Table("places", columns, rows, ranked=True)


def _grids(found: OutputMap, model: MappedModel) -> Table:
    size = np.abs(found.grid)
    total = float(size.sum())
    order = np.argsort(-size, kind="stable")
    rows = tuple(
        (
            int(found.grid_id[n]),
            model.area_name(int(model.grid_area[n])),
            float(found.grid[n]),
            float(size[n]) / total,
            *_mm(model.position[n]),
        )
        for n in order[size[order] > 0.0].tolist()
    )
    columns = (
        Column("grid", "number"),
        Column("area"),
        Column("value", "number", found.unit),
        Column("share", "share", whole="grids"),
    )
    return Table("grids", (*columns, *_MM), rows, ranked=True)


def _mm(position: FloatArray) -> tuple[float, float, float]:
    x, y, z = (1e3 * position).tolist()
    return x, y, z
