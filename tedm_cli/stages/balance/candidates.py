"""Boxes of the configuration as candidates: cut, with images and ties, and clear of all that is in their way."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path

import numpy as np

from tedm_cli.arrays import FloatArray, IntArray
from tedm_cli.balance.boxes import Box, Column, Image, columns_of
from tedm_cli.balance.keep_out import Elements, KeepOut, met_by, overlapping
from tedm_cli.config.balance import BalanceConfig, BoxTable
from tedm_cli.config.model.file import ModelConfig
from tedm_cli.config.project import Project
from tedm_cli.config.symmetry_plane import project_plane
from tedm_cli.contracts import UNIT_LOADS
from tedm_cli.errors import ConfigError
from tedm_cli.files.store import Reader
from tedm_cli.gravity.compensation import CompensationMass, Tie
from tedm_cli.gravity.testmass import TestMass
from tedm_cli.gravity.ties import needs_rotations
from tedm_cli.symmetry_plane import SymmetryPlane

MIRROR, ALIKE = "_mirror", "_alike"  # ends of the names of images
_SHOWN = 3
_AS_NEAR_M = 1e-6


@dataclass(frozen=True, eq=False)
class Candidates:
    """Parts of boxes, of which those that are in the way are left out, and the unknowns that they make.

    box : for each part, the row of the table that it is of. left_out : by name of a box, how many of its parts are.
    """

    parts: list[Box]
    box: list[int]
    columns: list[Column]
    left_out: dict[str, int]


def candidates(
    project: Project, model: ModelConfig, config: BalanceConfig, unit: Reader, kept: Sequence[CompensationMass],
    where: Path,
) -> Candidates:  # fmt: skip
    """The parts of all boxes.

    Raises
    ------
    ConfigError : boxes that reach into a test mass, the structure, a keep-out, each other or a compensation mass that
        stays; boxes that are left without parts, or too small for a shim or a step.
    """
    test_masses = model.test_masses()
    keep_outs = [
        *(
            KeepOut(f"test mass {tm.name}", tm.box_centre_m, tm.side_m, tm.axes, config.clearance_m)
            for tm in test_masses
        ),
        *(KeepOut(f"keep-out {table.name}", *table.place(test_masses)) for table in config.keep_out),
        *(KeepOut(f"compensation mass {b.name}", b.centre_m, b.size_m, b.axes) for b in kept),
    ]
    elements = structure_of(unit) if config.structure == "keep out" else None
    plane = project_plane(project, model).plane
    parts: list[Box] = []
    owner: list[int] = []
    left_out: dict[str, int] = {}
    problems: list[tuple[str, str]] = []
    for number, table in enumerate(config.box):
        try:
            box = _box(table, test_masses, plane)
        except ValueError as error:
            problems.append((f"box[{number}]", str(error)))
            continue
        facts, clear = [], []
        if (empty := _holds_nothing(box)) is not None:
            problems.append((f"box[{number}]", empty))
            continue
        for part in box.cut():
            found = _in_the_way(part, keep_outs, elements)
            facts += found
            if not found:
                clear.append(part)
        if facts and (not table.around or not clear):
            more = f" and {len(facts) - _SHOWN} more" if len(facts) > _SHOWN else ""
            problems.append((f"box[{number}]", "; ".join(facts[:_SHOWN]) + more))
            continue
        left_out[box.name] = int(np.prod(box.parts)) - len(clear)
        parts += clear
        owner += [number] * len(clear)
    if not problems:
        every = [block for part in parts for block in part.with_images(part.full())]
        problems = _crossing(every, config, kept)
    if problems:
        hint = "around = true leaves out the parts of a box that are in the way of something; parts cuts it finer"
        raise ConfigError(problems, where=str(where), hint=hint)
    return Candidates(parts, owner, columns_of(parts), left_out)


def _box(table: BoxTable, test_masses: Sequence[TestMass], plane: SymmetryPlane) -> Box:
    centre, size, axes = table.place(list(test_masses))
    own, other = table.group or "", table.alike_group or table.group or ""
    images = [Image(group=own)]
    if table.alike:
        first, second = (tm.position_m for tm in test_masses)
        between = SymmetryPlane((first + second) / 2.0, second - first)
        images.append(Image(planes=(between,), suffix=ALIKE, group=other))
    if table.mirror:
        images += [
            replace(image, planes=(*image.planes, plane), suffix=image.suffix + MIRROR) for image in images.copy()
        ]
    return Box(
        name=table.name,
        centre_m=centre,
        size_m=size,
        axes=axes,
        density_kg_m3=table.density_kg_m3,
        parts=(table.parts[0], table.parts[1], table.parts[2]),
        shim_m=table.shim_m or 0.0,
        stack=("xyz".index(table.direction[1]), 1 if table.direction[0] == "+" else -1),
        step_kg=table.step_kg or 0.0,
        least_kg=table.least_kg or 0.0,
        most_kg=np.inf if table.most_kg is None else table.most_kg,
        images=tuple(images),
        tie=table.tie(),
        inner_m=table.inner(size),
        vary_size=table.search_size,
    )


def _holds_nothing(box: Box) -> str | None:
    """Why not even one shim, step or least mass has room in a part."""
    part = box.cut()[0]
    if box.shim_m:
        thick = float(box.size_m[box.stack[0]])
        return f"{box.name} has no room for a shim of {box.shim_m:g} m: it is {thick:g} m" if part.shims < 1 else None
    full = part.full().mass_kg
    wanted, what = (box.step_kg, "step") if box.step_kg else (box.least_kg, "least mass")
    return (
        f"{box.name} has no room for a {what} of {wanted:g} kg: a part holds {full:.4g} kg" if full < wanted else None
    )


def _in_the_way(part: Box, keep_outs: Sequence[KeepOut], elements: Elements | None) -> list[str]:
    facts = []
    for block in part.with_images(part.full()):
        names = met_by(block, keep_outs)
        within = [] if elements is None else elements.met_by(block)
        if within:
            more = f" and {len(within) - 1} more elements" if len(within) > 1 else ""
            names.append(f"{within[0]}{more} of the structure")
        if names:
            facts.append(f"{block.name} is in the way of {', '.join(names[:_SHOWN])}")
    return facts


def _crossing(
    blocks: Sequence[CompensationMass], config: BalanceConfig, kept: Sequence[CompensationMass]
) -> list[tuple[str, str]]:
    """Boxes that reach into each other, or into their own images; names that are taken."""
    found = []
    for first, second in overlapping(blocks)[:_SHOWN]:
        found.append(("box", f"{first} and {second} reach into each other: mass would be there twice"))
    taken = {block.name for block in kept}
    names = [block.name for block in blocks]
    twice = sorted({name for name in names if name in taken or names.count(name) > 1})
    found += [("box", f"there is a block {name!r} already; give the box another name") for name in twice[:_SHOWN]]
    return found


def structure_of(unit: Reader) -> Elements:
    """Cuboids along the basic axes that hold the elements with mass, and concentrated masses."""
    position = unit.array(UNIT_LOADS.GRID_POSITION)
    offset, index = unit.array(UNIT_LOADS.ELEMENT_NODE_OFFSET), unit.array(UNIT_LOADS.ELEMENT_NODE_INDEX)
    lever, section = unit.array(UNIT_LOADS.ELEMENT_LEVER), unit.array(UNIT_LOADS.ELEMENT_SECTION)
    mass, ids = unit.array(UNIT_LOADS.ELEMENT_MASS), unit.array(UNIT_LOADS.ELEMENT_ID)
    cards = unit.strings(UNIT_LOADS.ELEMENT_TYPE)
    names, low, high = [], np.zeros((0, 3)), np.zeros((0, 3))
    if len(ids):
        corner = position[index] + lever
        low = np.minimum.reduceat(corner, offset[:-1], axis=0)
        high = np.maximum.reduceat(corner, offset[:-1], axis=0)
        plate = np.array([card.startswith(("CQUAD", "CTRIA", "CSHEAR")) for card in cards])
        half = np.where(plate, section / 2.0, 0.0)[:, None]
        heavy = np.flatnonzero(mass > 0.0)
        low, high = (low - half)[heavy], (high + half)[heavy]
        names = [f"{cards[i]} {ids[i]}" for i in heavy]
    points = position[unit.array(UNIT_LOADS.MASS_CONCENTRATED_NODE)] + unit.array(UNIT_LOADS.MASS_CONCENTRATED_LEVER)
    cards_of = unit.strings(UNIT_LOADS.MASS_CONCENTRATED_CARD)
    names += [f"{c} {i}" for c, i in zip(cards_of, unit.array(UNIT_LOADS.MASS_CONCENTRATED_ID), strict=True)]
    return Elements(names, np.concatenate([low, points]), np.concatenate([high, points]))


def with_ties(
    blocks: Sequence[CompensationMass], wanted: Mapping[str, tuple[int, FloatArray]], unit: Reader
) -> list[CompensationMass]:
    """Blocks tied to grids of elements with mass: by name of a block, how many, and the point they are nearest to."""
    if not wanted:
        return list(blocks)
    ids, position = unit.array(UNIT_LOADS.GRID_ID), unit.array(UNIT_LOADS.GRID_POSITION)
    offset, index = unit.array(UNIT_LOADS.ELEMENT_NODE_OFFSET), unit.array(UNIT_LOADS.ELEMENT_NODE_INDEX)
    heavy = np.repeat(unit.array(UNIT_LOADS.ELEMENT_MASS) > 0.0, np.diff(offset))
    rows = np.unique(index[heavy])
    return [
        replace(block, tie=_nearest(*wanted[block.name], ids[rows], position[rows])) if block.name in wanted else block
        for block in blocks
    ]


def _nearest(count: int, at: FloatArray, ids: IntArray, position: FloatArray) -> Tie:
    """The grids nearest to a point, and those that are as near as the last of them, so that images follow images."""
    distance = np.linalg.norm(position - at, axis=1)
    near = np.argsort(distance, kind="stable")
    while True:
        count = int((distance <= distance[near[min(count, len(near)) - 1]] + _AS_NEAR_M).sum())
        if count >= len(near) or not needs_rotations(position[near[:count]]):
            break
        count += 1
    found = sorted(int(i) for i in ids[near[:count]])
    starts = [0, *(i + 1 for i, (a, b) in enumerate(pairwise(found)) if b != a + 1), len(found)]
    return Tie("grid", tuple((found[a], found[b - 1]) for a, b in pairwise(starts)))
