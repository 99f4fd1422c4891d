"""build-distortion: unit_loads.h5 to the distortion matrix [D] in distortion.h5."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from tedm_cli.arrays import BoolArray, FloatArray, IntArray
from tedm_cli.columns import Columns, Sums
from tedm_cli.config.model.compensation import compensation_masses
from tedm_cli.config.model.file import ModelConfig, load_model
from tedm_cli.config.optics.layout import load_layout
from tedm_cli.config.project import Project
from tedm_cli.contracts import DISTORTION, UNIT_LOADS
from tedm_cli.distortion import (
    Precision,
    RigidFit,
)
from tedm_cli.errors import InputError, PhysicsError
from tedm_cli.files.blocks import SomeNodes, node_blocks
from tedm_cli.files.build_folder import DISTORTION_FILE, UNIT_LOADS_FILE, provenance
from tedm_cli.files.store import Reader, Writer, create, open_checked
from tedm_cli.noise.areas import AreaTable
from tedm_cli.optics.layout import OpticalLayout
from tedm_cli.progress import Step
from tedm_cli.results.areas import read_areas
from tedm_cli.results.gravity.ties import read_ties, require_ties
from tedm_cli.results.optics import AREA_COMMA
from tedm_cli.results.sides import require_plane
from tedm_cli.results.unit_loads import areas_of_rows, lever_nodes_of
from tedm_cli.stages.common import copy_areas, copy_places, out_path
from tedm_cli.stages.layout_match import match_grids
from tedm_cli.stages.model.distortion_checks import (
    Reductions,
    check_plausible,
    check_tied_turning,
    check_turning,
    precision_of,
    still_ties,
    superposition,
)


@dataclass(frozen=True)
class DistortionSummary:
    """What was made. largest_gradient : of the areas under a gradient, in m/(K/m), and the area; None without any."""

    path: Path
    areas: int
    grids: int
    optical: int
    superposition: float | None
    largest_m_per_K: float
    largest_area: str
    largest_rigid_m_per_K: float
    precision: Precision
    largest_gradient: tuple[float, str] | None = None
    notes: tuple[str, ...] = ()


@dataclass(frozen=True, eq=False)
class GivenMotions:
    """What was reduced of results in parts, of all areas; the files that it is from."""

    columns: Columns
    sums: Sums
    parts: Sequence[Path] = ()


@dataclass(frozen=True)
class Bench:
    """The elements of a layout on the grids of a model: their rows and names, and remarks."""

    rows: IntArray
    names: list[str]
    notes: tuple[str, ...]


def bench_on(
    project: Project, layout: OpticalLayout | None, model: ModelConfig, ids: IntArray, position: FloatArray
) -> Bench:
    """The optical elements of a project on grids with `ids` [N] and `position` [N,3] (m); none without optics.

    Raises
    ------
    ConfigError : a layout that does not fit the model or its configuration.
    """
    if project.optics is None or layout is None:
        return Bench(np.zeros(0, dtype=np.int64), [], ())
    match = match_grids(layout, project.optics, model, project.model, ids, position)
    match.require()
    rows = np.searchsorted(ids, np.array([e.grid for e in layout.bench], dtype=np.int64))
    return Bench(rows, [e.name for e in layout.bench], tuple(match.notes))


def build_distortion(
    project: Project, output: Path | None, step: Step, given: GivenMotions | None = None
) -> DistortionSummary:
    """Scale the unit loads to one kelvin, gather the optical elements, and check superposition and plausibility.

    The layout must fit the model that was ingested, and its configuration. A project without optics has no optical
    elements to gather. What is `given` is in place of the displacements of grids, which then are not kept.
    """
    _, model = load_model(project.model)
    source = project.build_dir / UNIT_LOADS_FILE
    out = out_path(project, DISTORTION_FILE, output)
    layout = None if project.optics is None else load_layout(project.optics)
    parts = () if given is None else given.parts
    with (
        open_checked(source, UNIT_LOADS) as unit,
        create(out, DISTORTION, provenance([] if layout is None else [layout[0]], [source, *parts])) as writer,
    ):
        position = unit.array(UNIT_LOADS.GRID_POSITION)
        bench = bench_on(
            project, None if layout is None else layout[1], model, unit.array(UNIT_LOADS.GRID_ID), position
        )
        rows, names = bench.rows, bench.names
        require_plane(unit, project, model)
        require_ties(unit, compensation_masses(project, model))
        writer.write(DISTORTION.GRID_ID, unit.array(UNIT_LOADS.GRID_ID))
        copy_areas(unit, writer)
        copy_places(unit, writer)
        if names:
            writer.write(DISTORTION.OPTICAL_NAME, names)
            writer.write(DISTORTION.OPTICAL_GRID, unit.array(UNIT_LOADS.GRID_ID)[rows])
            writer.write(DISTORTION.OPTICAL_POSITION, position[rows])
            writer.write(DISTORTION.OPTICAL_AREA, [AREA_COMMA.join(own) for own in areas_of_rows(unit, rows)])
        means = ~read_areas(unit).gradient
        found = _stream(unit, writer, rows, step, means) if given is None else _given(unit, writer, given, means)
        result = _checked(unit, writer, found, rows, names, out)
    return replace(result, notes=(*bench.notes, *result.notes))


def _checked(
    unit: Reader, writer: Writer, found: Reductions, rows: IntArray, names: list[str], out: Path
) -> DistortionSummary:
    """Judge what was found, and write what is small."""
    areas = read_areas(unit)
    check_plausible(unit, areas, found.largest)
    flat = [n for j, n in enumerate(names) if not np.any(found.optical_rotation[:, j])]
    if flat:
        raise PhysicsError(
            f"optical elements whose rotation is zero under every load: {', '.join(flat)}",
            where=str(unit.path),
            hint="a grid of solids alone has no rotation; tie the element's grid with RBE2 or RBE3",
        )
    ties = read_ties(unit)
    check_tied_turning(unit, ties, found.stiff)
    check_turning(unit, found.stiff)
    if names:
        writer.write(DISTORTION.D_OPT_TRANSLATION, found.optical_translation)
        writer.write(DISTORTION.D_OPT_ROTATION, found.optical_rotation)
    writer.write(DISTORTION.CHECK_MAX_TRANSLATION, found.largest)
    writer.write(DISTORTION.CHECK_RIGID_TRANSLATION, found.rigid_translation)
    writer.write(DISTORTION.CHECK_RIGID_ROTATION, found.rigid_rotation)
    residual = superposition(unit, writer, found, rows)
    worst = _largest(areas, found.largest, "mean")
    bent = _largest(areas, found.largest, "gradient") if areas.gradient.any() else None
    return DistortionSummary(
        out,
        len(areas),
        len(found.total),
        len(rows),
        residual,
        *worst,
        float(np.abs(found.rigid_translation[found.means]).max()),
        precision_of(unit),
        bent,
        still_ties(ties, found),
    )


def _largest(areas: AreaTable, largest: FloatArray, kind: str) -> tuple[float, str]:
    """The largest translation by any area of a kind, and the area."""
    of_kind = np.flatnonzero(areas.kind == kind)
    row = of_kind[largest[of_kind].argmax()]
    return float(largest[row]), str(areas.name[row])


def _given(unit: Reader, writer: Writer, given: GivenMotions, means: BoolArray) -> Reductions:
    """The same from results that were reduced in parts."""
    levers, found, sums = lever_nodes_of(unit), given.columns, given.sums
    writer.write(DISTORTION.D_OFFSET_NODE, levers)
    return Reductions(
        means=means,
        optical_translation=found.optical_translation,
        optical_rotation=found.optical_rotation,
        largest=found.largest,
        rigid_translation=found.rigid_translation,
        rigid_rotation=found.rigid_rotation,
        total=sums.total,
        size=sums.size,
        lever_rows=levers,
        total_turn=sums.total_turn,
        turn_size=sums.turn_size,
        stiff=levers[sums.moving & ~sums.turned],
    )


def _stream(unit: Reader, writer: Writer, rows: IntArray, step: Step, means: BoolArray) -> Reductions:
    """Write [D] area by area and piece by piece; what is held does not grow with the number of areas times grids.

    Of loads of 1 K nothing is written: [D] is a view of the displacements where these are in the same folder.
    """
    areas, load = unit.strings(UNIT_LOADS.AREA_NAME), unit.array(UNIT_LOADS.AREA_LOAD_K)
    fit = RigidFit(
        unit.array(UNIT_LOADS.GRID_POSITION),
        unit.array(UNIT_LOADS.MASS_LUMPED),
        unit.array(UNIT_LOADS.MASS_CENTRE_OF_GRAVITY),
    )
    source, turns = unit.dataset(UNIT_LOADS.TRANSLATION), unit.dataset(UNIT_LOADS.ROTATION)
    count, n_nodes, _ = source.shape
    offset_nodes = lever_nodes_of(unit)
    writer.write(DISTORTION.D_OFFSET_NODE, offset_nodes)
    as_held = bool(np.all(load == 1.0))  # then nothing is divided, and single precision stays exact
    target = None
    if not (as_held and writer.view(DISTORTION.D_TRANSLATION, unit)):
        target = writer.allocate(DISTORTION.D_TRANSLATION, source.shape, single=as_held and source.single)
    turning = writer.allocate(DISTORTION.D_ROTATION, (count, len(offset_nodes), 3))
    optics, levers = SomeNodes(rows), SomeNodes(offset_nodes)
    moving, turned = np.zeros((2, len(offset_nodes)), dtype=bool)
    optical_t, optical_r = np.zeros((2, count, len(rows), 3))
    largest = np.zeros(count)
    moments = np.zeros((count, 4, 3))
    total, size = np.zeros((n_nodes, 3)), np.zeros(n_nodes)
    total_turn, turn_size = np.zeros((len(offset_nodes), 3)), np.zeros(len(offset_nodes))
    for i, name in enumerate(areas):
        for block in node_blocks(n_nodes):
            held = source.held((i, block)) if as_held else source[i, block] / load[i]
            move = held.astype(np.float64, copy=False)
            length = np.sqrt(np.einsum("ni,ni->n", move, move))
            largest[i] = np.maximum(largest[i], length.max())  # keeps what is not a number
            if target is not None:
                target[i, block] = held
            moments[i] += fit.moments(block, move)
            if means[i]:
                total[block] += move
                size[block] += length
            at, local = optics.within(block)
            optical_t[i, at] = move[local]
            at, local = levers.within(block)
            moving[at] |= np.any(move[local] != 0.0, axis=1)
        optical_r[i] = optics.read(turns, i) / load[i]
        turn = levers.read(turns, i) / load[i]
        if not (np.isfinite(largest[i]) and np.isfinite(optical_r[i]).all() and np.isfinite(turn).all()):
            raise InputError(f"area '{name}': displacements are not finite", where=str(unit.path))
        turned |= np.any(turn != 0.0, axis=1)
        turning[i] = turn
        if means[i]:
            total_turn += turn
            turn_size += np.linalg.norm(turn, axis=1)
        step(i + 1, count, "scaling unit loads")
    rigid_t, rigid_r = fit.motions(moments)
    return Reductions(
        means=means,
        optical_translation=optical_t,
        optical_rotation=optical_r,
        largest=largest,
        rigid_translation=rigid_t,
        rigid_rotation=rigid_r,
        total=total,
        size=size,
        lever_rows=offset_nodes,
        total_turn=total_turn,
        turn_size=turn_size,
        stiff=offset_nodes[moving & ~turned],
    )
