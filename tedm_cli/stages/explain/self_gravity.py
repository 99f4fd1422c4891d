"""What an output of the self-gravity is made of: areas, what moves, the field at rest, and the stiffness."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from tedm_cli.arrays import FloatArray
from tedm_cli.config.model.compensation import compensation_masses
from tedm_cli.config.model.file import load_model
from tedm_cli.config.project import Project
from tedm_cli.contracts import DISTORTION, SENSITIVITY
from tedm_cli.files.blocks import node_blocks
from tedm_cli.files.build_folder import DISTORTION_FILE, require_input
from tedm_cli.files.provenance import input_files
from tedm_cli.files.store import Reader, open_checked
from tedm_cli.gravity.compensation import field_of_compensation_masses
from tedm_cli.gravity.motion import by_motion_of_source
from tedm_cli.optics.shares import shares
from tedm_cli.results.areas import read_areas, unit_per
from tedm_cli.results.explained import Column, Table, Told, by_size, clean_sum, row_tables, sizes
from tedm_cli.results.gravity.compensation import Blocks, read_blocks
from tedm_cli.results.gravity.field import FieldAtRest, read_field
from tedm_cli.results.gravity.self_gravity import read_self_gravity
from tedm_cli.results.titles import at_rest_requirement, output_title

_TURNS = {"x": "theta", "y": "eta", "z": "phi"}
Terms = tuple[tuple[float, str], ...]


@dataclass(frozen=True)
class _Place:
    """An output `TM1_a_x`: row of its test mass, whether it turns, and its axis."""

    mass: int
    turns: bool
    axis: int

    @classmethod
    def of(cls, label: str, masses: list[str]) -> _Place:
        name, kind, axis = label.rsplit("_", 2)
        return cls(masses.index(name), kind == "omegadot", "xyz".index(axis))


_Row = tuple[float, int, _Place]  # a factor, the row of [S_SG], and what the output is of


def explain_self_gravity(
    project: Project, file: Reader, label: str, terms: Terms, effects: Mapping[str, FloatArray]
) -> Told:
    """What is in a row of [S_SG], or in a sum of rows: `terms` are factors and labels of rows.

    `effects` : those of the user's own that are added to it, [k] by their names as parts.

    Raises
    ------
    InputError : distortion.h5 is there and not what the sensitivities were made from.
    """
    gravity, areas, rest = read_self_gravity(file), read_areas(file), read_field(file)
    rows = [gravity.label.index(name) for _, name in terms]
    factor = np.array([f for f, _ in terms])
    by_gravity = np.asarray(factor @ gravity.S[rows])
    value = by_gravity + sum(effects.values(), np.zeros_like(by_gravity))
    unit = gravity.unit[rows[0]].removesuffix("/K")
    means = ~areas.gradient
    size, total = sizes(value, means)
    places = [_Place.of(name, rest.test_mass) for _, name in terms]
    at_rest, field = _at_rest(rest, places, factor, unit)
    parts, notes = _parts(project, file, list(zip(factor.tolist(), rows, places, strict=True)), by_gravity)
    of_means = {name: part[means] for name, part in (parts | dict(effects)).items()}
    share = shares(np.array(list(of_means.values())), value[means])
    columns = (
        Column("what moves" if not effects else "what moves, or acts"),
        Column("size", "number", unit_per(unit, "K")),
        Column("share", "share"),
    )
    moving = Table(
        "moving",
        columns,
        by_size(
            [(n, float(np.linalg.norm(v)), float(s)) for (n, v), s in zip(of_means.items(), share, strict=True)], 2
        ),
    )
    listed, *others = row_tables(value, unit, areas)
    tables = (
        listed,
        *others,
        moving,
        field,
        _stiffness(rest, [name for _, name in terms], factor),
        _verdicts(rest, places),
    )
    return Told(
        label,
        "output of the self-gravity",
        output_title(label),
        (
            f"size {size:.3e} {unit_per(unit, 'K')} over {int(means.sum())} areas; sum, the uniform load,"
            f" {total:.3e} {unit_per(unit, 'K')}",
            f"at rest {at_rest:.4e} {unit}",
        ),
        tables,
        (
            "size: root of the sum of squares over the areas; share: of the variance for areas that fluctuate alike and"
            " independently, signed; in the frame of each test mass",
            *notes,
        ),
        source=str(file.path),
    )


def _at_rest(rest: FieldAtRest, places: list[_Place], factor: FloatArray, unit: str) -> tuple[float, Table]:
    """The component at rest, all in all and by source."""
    fields = [(rest.angular_acceleration if p.turns else rest.acceleration)[p.mass, :, p.axis] for p in places]
    by_source = np.asarray(factor @ np.array(fields))
    sums = clean_sum(by_source)
    rows = [(name, float(v), float(v) / sums if sums else None) for name, v in zip(rest.source, by_source, strict=True)]
    columns = (Column("at rest, source"), Column("field", "number", unit), Column("of the sum", "share"))
    return sums, Table("at_rest", columns, by_size(rows, 1))


def _stiffness(rest: FieldAtRest, names: list[str], factor: FloatArray) -> Table:
    """What small motions of the test masses do to it: its row of the equations of motion."""
    lin = rest.linearised
    row = np.asarray(factor @ lin.value[[lin.output.index(name) for name in names]])
    unit = lin.output_unit[lin.output.index(names[0])]
    rows = [
        (motion, float(v), f"{unit} per {of}")
        for motion, of, v in zip(lin.motion, lin.motion_unit, row, strict=True)
        if v
    ]
    columns = (Column("test mass moves"), Column("stiffness", "number"), Column("unit"))
    return Table("stiffness", columns, by_size(rows, 1), ranked=True)


def _verdicts(rest: FieldAtRest, places: list[_Place]) -> Table:
    """What limits the component at rest."""
    quantity = {f"omegadot_{_TURNS['xyz'[p.axis]]}" if p.turns else f"a_{'xyz'[p.axis]}" for p in places}
    masses = {rest.test_mass[p.mass] for p in places}
    rows = [
        (at_rest_requirement(v.requirement), v.place, v.subsystem, v.value, v.limit, v.ratio, v.passed)
        for v in rest.verdicts
        if v.quantity in quantity and masses & {v.test_mass, v.minus}
    ]
    columns = (
        *(Column("limit at rest"), Column("on"), Column("field of"), Column("value", "number")),
        *(Column("limit", "number"), Column("ratio", "ratio"), Column("verdict", "verdict")),
    )
    return Table("at_rest_verdicts", columns, by_size(rows, 5), ranked=True)


def _parts(
    project: Project, file: Reader, rows: list[_Row], value: FloatArray
) -> tuple[dict[str, FloatArray], list[str]]:
    """Parts [k] of a sum of rows by what moves, which add up to it, and what is not told apart."""
    blocks = read_blocks(file)
    parts: dict[str, FloatArray] = {}
    notes: list[str] = []
    structure, tied = "structure", any(blocks.tie)
    if tied:
        parts["tied compensation masses"] = _tied(project, rows, blocks)
    elif blocks.name:
        notes.append("compensation masses stay still: they are in the field at rest, not in the sensitivity")
    turning, why = len(file.array(SENSITIVITY.OPERATOR_OFFSET_NODE)), ""
    path = project.build_dir / DISTORTION_FILE
    if tied:
        why = "tied compensation masses turn with some of them"
    elif not path.exists():
        why = f"there is no {path.name}"
    elif turning:
        with open_checked(path, DISTORTION) as distortion:
            require_input(file, input_files([path])[0])
            if distortion.has(DISTORTION.D_ROTATION):
                parts["offset masses, by rotations of their grids"] = _levers(file, distortion, rows)
                structure = "structure, by translations of its grids"
            else:
                why = f"{path.name} has no displacements of grids"
    if turning and why:
        notes.append(f"rotations of {turning:,} grids, whose masses are offset, are not told apart: {why}")
    rest = value - sum(parts.values(), np.zeros_like(value))
    return {structure: rest} | parts, notes


def _tied(project: Project, rows: list[_Row], blocks: Blocks) -> FloatArray:
    """What the motion of tied blocks does [k]: their field, as their motion in the file changes it."""
    config = load_model(project.model)[1]
    masses = {block.name: block for block in compensation_masses(project, config)}
    tied = [i for i, tie in enumerate(blocks.tie) if tie]
    motion = np.concatenate([blocks.translation, blocks.rotation], axis=2)
    test_masses = config.test_masses()
    total = np.zeros(len(motion))
    wanted = [masses[blocks.name[i]] for i in tied]
    for factor, _, place in rows:
        tm, row = test_masses[place.mass], 3 * place.turns + place.axis
        found = field_of_compensation_masses(
            tm,
            wanted,
            config.gravity.gravitational_constant_m3_kg_s2,
            tolerance=config.gravity.compensation_tolerance,
        )[2]
        for i, how in zip(tied, found, strict=True):
            by_motion = by_motion_of_source(tm, blocks.centre[i], how.field) @ np.kron(np.eye(2), tm.axes)
            total -= factor * (motion[:, i] @ by_motion[row])
    return total


def _levers(file: Reader, distortion: Reader, rows: list[_Row]) -> FloatArray:
    """What the rotations of grids with offset masses do [k], read for some grids at a time."""
    operator, turns = file.dataset(SENSITIVITY.OPERATOR_G_ROTATION), distortion.dataset(DISTORTION.D_ROTATION)
    total = np.zeros(turns.shape[0])
    for block in node_blocks(turns.shape[1], 1024):
        g = sum(factor * operator[row, block] for factor, row, _ in rows)
        total -= np.einsum("nc,knc->k", g, turns[:, block])
    return total
