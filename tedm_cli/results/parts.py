"""What one result file leaves in the matrices: a part, as it is made and as partial_NAME.h5 tells it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tedm_cli.arrays import FloatArray, IntArray
from tedm_cli.columns import Columns, Sums
from tedm_cli.contracts import PARTIAL
from tedm_cli.files.store import Reader, Writer
from tedm_cli.noise.areas import AreaTable


@dataclass(frozen=True, eq=False)
class UniformLoad:
    """Motions [N, 3] (m and rad) under the load of all areas, and its subcase in the result file."""

    subcase: int
    translation: FloatArray
    rotation: FloatArray


@dataclass(frozen=True, eq=False)
class Part:
    """What one result file leaves.

    results : the file, as the configuration names it; sha256 : of its contents. areas, subcases : of its loads, without
    the uniform one, in their order. by_number : whether it has no labels. single : whether any motion is in single
    precision.
    """

    results: str
    sha256: str
    areas: list[str]
    subcases: list[int]
    columns: Columns
    sums: Sums
    uniform: UniformLoad | None
    by_number: bool
    single: bool


@dataclass(frozen=True, eq=False)
class PartLabels:
    """Labels of the dimensions of all parts of a model.

    grid_id : [N]. levers : [L], rows of the grids with levers. rows : outputs of S; what columns have beyond these are
    changes by uncertain positions. area_id : [k], with their table.
    """

    grid_id: IntArray
    levers: IntArray
    rows: list[str]
    optics: list[str]
    ties: list[str]
    areas: AreaTable
    area_id: IntArray


def write_part(writer: Writer, part: Part, labels: PartLabels) -> None:
    """As `read_part` reads it."""
    names = labels.areas.name.tolist()
    at = np.array([names.index(name) for name in part.areas], dtype=np.int64)
    found, sums, count, table = part.columns, part.sums, len(labels.rows), labels.areas
    for path, values in (
        (PARTIAL.AREA_ID, labels.area_id),
        (PARTIAL.AREA_NAME, table.name),
        (PARTIAL.AREA_GROUP, table.group),
        (PARTIAL.AREA_SHIELD, table.shield),
        (PARTIAL.AREA_SIDE, table.side),
        (PARTIAL.AREA_KIND, table.kind),
        (PARTIAL.AREA_UNIT, table.unit),
    ):
        writer.write(path, np.asarray(values)[at])
    writer.write(PARTIAL.GRID_ID, labels.grid_id)
    writer.write(PARTIAL.RESULTS_FILE, part.results)
    writer.write(PARTIAL.RESULTS_SUBCASE, np.array(part.subcases, dtype=np.int64))
    writer.write(PARTIAL.RESULTS_BY_NUMBER, int(part.by_number))
    writer.write(PARTIAL.RESULTS_PRECISION, "single" if part.single else "double")
    writer.write(PARTIAL.ROW_LABEL, labels.rows)
    writer.write(PARTIAL.S, found.columns[:count], units="m/s^2 or rad/s^2 per /area/unit, see /row/label")
    if len(found.columns) > count:
        writer.write(PARTIAL.POSITION_CHANGE, found.columns[count:], units="those of S per m")
    if labels.optics:
        writer.write(PARTIAL.OPTICAL_NAME, labels.optics)
        writer.write(PARTIAL.D_OPT_TRANSLATION, found.optical_translation)
        writer.write(PARTIAL.D_OPT_ROTATION, found.optical_rotation)
    writer.write(PARTIAL.TIE_BLOCK, labels.ties)
    writer.write(PARTIAL.TIE_TRANSLATION, found.blocks[..., :3])
    writer.write(PARTIAL.TIE_ROTATION, found.blocks[..., 3:])
    writer.write(PARTIAL.CHECK_MAX_TRANSLATION, found.largest)
    writer.write(PARTIAL.CHECK_RIGID_TRANSLATION, found.rigid_translation)
    writer.write(PARTIAL.CHECK_RIGID_ROTATION, found.rigid_rotation)
    writer.write(PARTIAL.OFFSET_NODE, labels.levers)
    writer.write(PARTIAL.SUM_TRANSLATION, sums.total)
    writer.write(PARTIAL.SUM_SIZE, sums.size)
    writer.write(PARTIAL.SUM_ROTATION, sums.total_turn)
    writer.write(PARTIAL.SUM_ROTATION_SIZE, sums.turn_size)
    writer.write(PARTIAL.SUM_MOVES, sums.moving.astype(np.int64))
    writer.write(PARTIAL.SUM_TURNS, sums.turned.astype(np.int64))
    if part.uniform is not None:
        writer.write(PARTIAL.UNIFORM_SUBCASE, part.uniform.subcase)
        writer.write(PARTIAL.UNIFORM_TRANSLATION, part.uniform.translation)
        writer.write(PARTIAL.UNIFORM_ROTATION, part.uniform.rotation)


def read_part(file: Reader) -> Part:
    """The part in an open partial_NAME.h5; its result file is the last of its inputs."""

    def rows(paths: Sequence[str]) -> FloatArray:
        return np.concatenate([file.array(path) for path in paths if file.has(path)])

    areas = file.strings(PARTIAL.AREA_NAME)
    nothing = np.zeros((len(areas), 0, 3))
    optical = file.has(PARTIAL.D_OPT_TRANSLATION)
    return Part(
        results=file.string(PARTIAL.RESULTS_FILE),
        sha256=file.provenance().inputs[-1].sha256,
        areas=areas,
        subcases=file.array(PARTIAL.RESULTS_SUBCASE).tolist(),
        columns=Columns(
            columns=rows((PARTIAL.S, PARTIAL.POSITION_CHANGE)),
            optical_translation=file.array(PARTIAL.D_OPT_TRANSLATION) if optical else nothing,
            optical_rotation=file.array(PARTIAL.D_OPT_ROTATION) if optical else nothing,
            blocks=np.concatenate([file.array(PARTIAL.TIE_TRANSLATION), file.array(PARTIAL.TIE_ROTATION)], axis=2),
            largest=file.array(PARTIAL.CHECK_MAX_TRANSLATION),
            rigid_translation=file.array(PARTIAL.CHECK_RIGID_TRANSLATION),
            rigid_rotation=file.array(PARTIAL.CHECK_RIGID_ROTATION),
        ),
        sums=Sums(
            total=file.array(PARTIAL.SUM_TRANSLATION),
            size=file.array(PARTIAL.SUM_SIZE),
            total_turn=file.array(PARTIAL.SUM_ROTATION),
            turn_size=file.array(PARTIAL.SUM_ROTATION_SIZE),
            moving=file.array(PARTIAL.SUM_MOVES) == 1,
            turned=file.array(PARTIAL.SUM_TURNS) == 1,
        ),
        uniform=UniformLoad(
            int(file.number(PARTIAL.UNIFORM_SUBCASE)),
            file.array(PARTIAL.UNIFORM_TRANSLATION),
            file.array(PARTIAL.UNIFORM_ROTATION),
        )
        if file.has(PARTIAL.UNIFORM_SUBCASE)
        else None,
        by_number=file.number(PARTIAL.RESULTS_BY_NUMBER) == 1.0,
        single=file.string(PARTIAL.RESULTS_PRECISION) == "single",
    )
