"""A second mesh of the same thermal areas: what it makes of the outputs, and the error of this one by both."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tedm_cli.arrays import FloatArray
from tedm_cli.config.project import Project
from tedm_cli.config.uncertainty import MeshDeviation
from tedm_cli.contracts import UNIT_LOADS
from tedm_cli.errors import InputError
from tedm_cli.files.build_folder import UNIT_LOADS_FILE
from tedm_cli.files.store import open_checked
from tedm_cli.noise.differences import rows_of
from tedm_cli.results.outputs import ModelOutputs, outputs_in
from tedm_cli.stages.uncertain_files import build_folder_of

_SOLIDS = ("CHEXA", "CPENTA", "CTETRA", "CPYRAM")
_SHELLS = ("CQUAD", "CTRIA")
_ALIKE = np.log(1.1)  # of the ratio of sizes: nearer ones make a large error of a small difference


@dataclass(frozen=True, eq=False)
class OtherMesh:
    """Another mesh.

    name : its build folder. refinement : size of its elements over that of this mesh's. order : of the error.
    rows : [n, k], the outputs by it. estimate : [n, k], what this mesh's outputs lack by both (Richardson):
    (S - S_other) / (refinement^order - 1). sources : its files.
    """

    name: str
    refinement: float
    order: float
    rows: FloatArray
    estimate: FloatArray
    sources: tuple[Path, ...]


def other_mesh(project: Project, table: MeshDeviation, outputs: ModelOutputs) -> OtherMesh:
    """Read it and hold it against this mesh.

    Raises
    ------
    InputError : files that are missing or stale; outputs or thermal areas that are not those of this mesh, by name;
        sizes of elements that are not told, or hardly differ.
    """
    folder = build_folder_of(Path(table.other))
    other = outputs_in(folder, [path.name for path in outputs.matrices])
    mine, theirs = outputs.areas.name.tolist(), other.areas.name.tolist()
    where = f"{project.build_dir} and {folder}"
    _require_same("thermal areas", mine, theirs, where)
    _require_same(
        "outputs",
        [label for label in outputs.labels if label in other.labels or "-" not in label],
        list(other.labels),
        where,
    )
    order = [theirs.index(name) for name in mine]
    odd = [
        n for n, one, two in zip(mine, outputs.areas.unit, np.array(other.areas.unit)[order], strict=True) if one != two
    ]
    if odd:
        raise InputError(f"area '{odd[0]}' is a mean in one, a gradient in the other", where=where)
    rows = rows_of(outputs.labels, dict(zip(other.labels, other.rows[:, order], strict=True)))
    if outputs.effects is not None:  # of the user's own, the same with any mesh
        rows = rows + outputs.effects.total
    refinement = table.refinement if table.refinement is not None else _refinement(project.build_dir, folder)
    if abs(np.log(refinement)) < _ALIKE:
        raise InputError(
            f"are as fine as each other, or nearly: ratio of element sizes {refinement:.3g}",
            where=where,
            hint="a second mesh tells something when its elements are larger or smaller by a tenth at least, better by"
            " a third",
        )
    estimate = (outputs.rows - rows) / (refinement**table.order - 1.0)
    return OtherMesh(str(folder), refinement, table.order, rows, estimate, other.sources)


def _require_same(what: str, mine: list[str], theirs: list[str], where: str) -> None:
    lacks = [name for name in mine if name not in theirs]
    more = [name for name in theirs if name not in mine]
    if lacks or more:
        name, side = (lacks[0], "the other") if lacks else (more[0], "this one")
        raise InputError(
            f"have different {what}: {side} has no {name} ({len(lacks) + len(more)} in all)",
            where=where,
            hint="both meshes must be of one model, with areas and outputs of the same names",
        )


def _refinement(this: Path, other: Path) -> float:
    """Size of the elements of another mesh over those of this one, by the numbers of solids, or of shells."""
    counts = []
    for folder in (this, other):
        path = folder / UNIT_LOADS_FILE
        if not path.exists():
            hint = "give refinement, the size of the other mesh's elements over that of this one's"
            raise InputError("no such file; it tells how many elements there are", where=str(path), hint=hint)
        with open_checked(path, UNIT_LOADS) as file:
            cards = file.strings(UNIT_LOADS.ELEMENT_TYPE)
        counts.append([sum(card.startswith(kind) for card in cards) for kind in (_SOLIDS, _SHELLS)])
    for dimension, mine, theirs in zip((3, 2), *counts, strict=True):
        if mine and theirs:
            return float((mine / theirs) ** (1.0 / dimension))
    hint = "give refinement, the size of the other mesh's elements over that of this one's"
    raise InputError("have no solids, and no shells, in common", where=f"{this} and {other}", hint=hint)
