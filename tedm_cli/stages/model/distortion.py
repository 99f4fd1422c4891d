"""build-distortion: unit_loads.h5 to the distortion matrix [D] in distortion.h5."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from tedm_cli.arrays import BoolArray, FloatArray, IntArray
from tedm_cli.config.compensation import compensation_masses
from tedm_cli.config.model import load_model
from tedm_cli.config.optics import load_layout
from tedm_cli.config.project import Project
from tedm_cli.contracts import DISTORTION, UNIT_LOADS
from tedm_cli.distortion import (
    Precision,
    RigidFit,
    plausible_translation,
    superposition_excess,
    superposition_residual,
)
from tedm_cli.errors import InputError, PhysicsError
from tedm_cli.files.blocks import SomeNodes, node_blocks
from tedm_cli.files.build_folder import DISTORTION_FILE, UNIT_LOADS_FILE, provenance
from tedm_cli.files.store import Reader, Writer, create, open_checked
from tedm_cli.noise.areas import AreaTable
from tedm_cli.progress import Step
from tedm_cli.results.areas import read_areas
from tedm_cli.results.optics import AREA_COMMA
from tedm_cli.results.sides import require_plane
from tedm_cli.results.ties import Ties, read_ties, require_ties
from tedm_cli.results.unit_loads import areas_of_rows, lever_nodes_of
from tedm_cli.stages.common import copy_areas, copy_places, out_path
from tedm_cli.stages.layout_match import match_grids

IMPLAUSIBLE = 100.0  # times the free growth of the whole model


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


def build_distortion(project: Project, output: Path | None, step: Step) -> DistortionSummary:
    """Scale the unit loads to one kelvin, gather the optical elements, and check superposition and plausibility.

    The layout must fit the model that was ingested, and its configuration. A project without optics has no optical
    elements to gather.
    """
    bench = None if project.optics is None else load_layout(project.optics)
    _, model = load_model(project.model)
    source = project.build_dir / UNIT_LOADS_FILE
    out = out_path(project, DISTORTION_FILE, output)
    with (
        open_checked(source, UNIT_LOADS) as unit,
        create(out, DISTORTION, provenance([] if bench is None else [bench[0]], [source])) as writer,
    ):
        rows, names, notes = np.zeros(0, dtype=np.int64), list[str](), tuple[str, ...]()
        position = unit.array(UNIT_LOADS.GRID_POSITION)
        if bench is not None and project.optics is not None:
            ids, elements = unit.array(UNIT_LOADS.GRID_ID), bench[1].bench
            match = match_grids(bench[1], project.optics, model, project.model, ids, position)
            match.require()
            rows = np.searchsorted(ids, np.array([e.grid for e in elements], dtype=np.int64))
            names, notes = [e.name for e in elements], tuple(match.notes)
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
        result = _scale_areas(unit, writer, rows, names, out, step)
    return replace(result, notes=(*notes, *result.notes))


def _scale_areas(
    unit: Reader, writer: Writer, rows: IntArray, names: list[str], out: Path, step: Step
) -> DistortionSummary:
    areas = read_areas(unit)
    found = _stream(unit, writer, rows, step, ~areas.gradient)
    _check_plausible(unit, areas, found.largest)
    flat = [n for j, n in enumerate(names) if not np.any(found.optical_rotation[:, j])]
    if flat:
        raise PhysicsError(
            f"optical elements whose rotation is zero under every load: {', '.join(flat)}",
            where=str(unit.path),
            hint="a grid of solids alone has no rotation; tie the element's grid with RBE2 or RBE3",
        )
    ties = read_ties(unit)
    _check_tied_turning(unit, ties, found.stiff)
    _check_turning(unit, found.stiff)
    if names:
        writer.write(DISTORTION.D_OPT_TRANSLATION, found.optical_translation)
        writer.write(DISTORTION.D_OPT_ROTATION, found.optical_rotation)
    writer.write(DISTORTION.CHECK_MAX_TRANSLATION, found.largest)
    writer.write(DISTORTION.CHECK_RIGID_TRANSLATION, found.rigid_translation)
    writer.write(DISTORTION.CHECK_RIGID_ROTATION, found.rigid_rotation)
    superposition = _superposition(unit, writer, found, rows)
    worst = _largest(areas, found.largest, "mean")
    bent = _largest(areas, found.largest, "gradient") if areas.gradient.any() else None
    return DistortionSummary(
        out,
        len(areas),
        len(found.total),
        len(rows),
        superposition,
        *worst,
        float(np.abs(found.rigid_translation[found.means]).max()),
        _precision(unit),
        bent,
        _still_ties(ties, found),
    )


def _largest(areas: AreaTable, largest: FloatArray, kind: str) -> tuple[float, str]:
    """The largest translation by any area of a kind, and the area."""
    of_kind = np.flatnonzero(areas.kind == kind)
    row = of_kind[largest[of_kind].argmax()]
    return float(largest[row]), str(areas.name[row])


def _precision(unit: Reader) -> Precision:
    """Of the results that the unit loads are from."""
    return "double" if unit.string(UNIT_LOADS.RESULTS_PRECISION) == "double" else "single"


@dataclass(frozen=True)
class _Reductions:
    """What one pass over the unit loads leaves besides [D], all per kelvin, or kelvin per metre.

    means : [k], the areas of a mean temperature: sums are over these, and make the uniform load.
    optical_translation, optical_rotation : [k,E,3]; largest : [k], length of the largest translation of any grid;
    rigid_translation, rigid_rotation : [k,3]; total : [N,3], sum over areas, and size : [N], of the lengths;
    lever_rows : [L], grids with a lever, total_turn : [L,3] and turn_size : [L] the same of their rotations; stiff :
    rows of those that move and never turn.
    """

    means: BoolArray
    optical_translation: FloatArray
    optical_rotation: FloatArray
    largest: FloatArray
    rigid_translation: FloatArray
    rigid_rotation: FloatArray
    total: FloatArray
    size: FloatArray
    lever_rows: IntArray
    total_turn: FloatArray
    turn_size: FloatArray
    stiff: IntArray


def _stream(unit: Reader, writer: Writer, rows: IntArray, step: Step, means: BoolArray) -> _Reductions:
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
    return _Reductions(
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


def _check_turning(unit: Reader, rows: IntArray) -> None:
    """A lever needs the rotation of its grid; a grid that moves and never turns has none."""
    if rows.size:
        ids = unit.array(UNIT_LOADS.GRID_ID)[rows]
        shown = ", ".join(map(str, ids[:8])) + (" ..." if ids.size > 8 else "")
        raise PhysicsError(
            f"grids that carry offset masses or elements, but never rotate under any load: {shown}",
            where=str(unit.path),
            hint="a grid of solids alone has no rotation; put the mass on a grid of its own, tied by RBE2 or RBE3",
        )


def _check_tied_turning(unit: Reader, ties: Ties, rows: IntArray) -> None:
    """The same of grids that turn tied blocks; others of a block may move without rotations of their own."""
    stiff = {name: found for name in ties.block if (found := np.intersect1d(ties.rows(name), rows)).size}
    if stiff:
        ids = unit.array(UNIT_LOADS.GRID_ID)
        shown = ", ".join(f"{name} (grid {ids[found[0]]})" for name, found in list(stiff.items())[:8])
        raise PhysicsError(
            f"compensation masses tied to grids that move, but never rotate under any load: {shown}",
            where=str(unit.path),
            hint="tie each to three grids or more that are not in a line, or to a grid held by RBE2 or RBE3",
        )


def _still_ties(ties: Ties, found: _Reductions) -> tuple[str, ...]:
    """Remarks on tied blocks that no load moves."""
    turned = np.zeros(len(found.size))
    turned[found.lever_rows] = found.turn_size
    still = [name for name in ties.block if not (found.size + turned)[ties.rows(name)].any()]
    return (f"tied compensation masses whose grids no load moves: {', '.join(still)}",) if still else ()


def _check_plausible(unit: Reader, areas: AreaTable, largest: FloatArray) -> None:
    position = unit.array(UNIT_LOADS.GRID_POSITION)
    scale = plausible_translation(unit.array(UNIT_LOADS.ELEMENT_EXPANSION), position)
    still = [str(a) for a, m in zip(areas.name, largest, strict=True) if m == 0]
    if still:
        more = f" and {len(still) - 5} more" if len(still) > 5 else ""
        raise PhysicsError(
            f"areas whose unit load moves nothing: {', '.join(still[:5])}{more}",
            where=str(unit.path),
            hint="do the materials of their elements have an expansion (`tedm areas` names those without), and are"
            " their grids free to move?",
        )
    extent = float(np.linalg.norm(np.ptp(position, axis=0)))
    # 1 K/m curves what is free by its expansion per metre: over a length L it moves by half of that times L².
    scales = scale * np.where(areas.gradient, extent / 2.0, 1.0)
    worst = int(np.divide(largest, scales, out=np.zeros_like(largest), where=scales > 0.0).argmax())
    if scale > 0 and largest[worst] > IMPLAUSIBLE * scales[worst]:
        unit_text, free = ("m/(K/m)", "free bending") if areas.gradient[worst] else ("m/K", "free growth")
        raise PhysicsError(
            f"area '{areas.name[worst]}' moves a grid by {largest[worst]:.3g} {unit_text};"
            f" {free} is {scales[worst]:.3g} {unit_text}",
            where=str(unit.path),
            hint="is the model held (free-free models drift), are lengths in metres, expansions in 1/K?",
        )


def _superposition(unit: Reader, writer: Writer, found: _Reductions, rows: IntArray) -> float | None:
    """Write and judge what the sum of the areas of a mean temperature leaves of the uniform load.

    Judged are translations, and the rotations that are used.
    """
    if not unit.has(UNIT_LOADS.UNIFORM_TRANSLATION):
        return None
    load = unit.number(UNIT_LOADS.UNIFORM_LOAD_K)
    uniform, turn = unit.array(UNIT_LOADS.UNIFORM_TRANSLATION) / load, unit.array(UNIT_LOADS.UNIFORM_ROTATION) / load
    turning = found.optical_rotation[found.means]
    optics = turning.sum(axis=0)
    translation = superposition_residual(found.total, uniform)
    writer.write(DISTORTION.CHECK_SUPERPOSITION_TRANSLATION, translation)
    if rows.size:
        writer.write(DISTORTION.CHECK_SUPERPOSITION_OPTICS, superposition_residual(optics, turn[rows]))
    size = found.size + np.linalg.norm(uniform, axis=1)
    _judge(unit, "translation", found.total - uniform, size, np.arange(len(size)), translation, 0.0)
    used = np.concatenate([rows, found.lever_rows])
    turned = np.concatenate([np.linalg.norm(turning, axis=2).sum(axis=0), found.turn_size])
    total = np.concatenate([optics, found.total_turn])
    extent = float(np.ptp(unit.array(UNIT_LOADS.GRID_POSITION), axis=0).max())
    turned += np.linalg.norm(turn[used], axis=1)
    if used.size:
        rotation = superposition_residual(total, turn[used])
        _judge(unit, "rotation", total - turn[used], turned, used, rotation, float(size.max()) / extent)
    return translation


def _judge(
    unit: Reader, what: str, gap: FloatArray, size: FloatArray, rows: IntArray, residual: float, floor: float
) -> None:
    precision = _precision(unit)
    excess = superposition_excess(gap, size, floor, precision)
    if excess.max() <= 1.0:
        return
    worst = int(excess.argmax())
    hint = "is an area missing from the deck, do the results belong to another deck, or did the solver iterate?"
    if precision == "double" and superposition_excess(gap, size, floor, "single").max() <= 1.0:
        hint = (
            "single precision would allow it: did the solver iterate, or is the stiffness badly conditioned?"
            " The OP2 of the same run is judged by single precision"
        )
    raise PhysicsError(
        f"the unit loads of the areas do not add up to the uniform load: the {what} of grid"
        f" {unit.array(UNIT_LOADS.GRID_ID)[rows[worst]]} is off by {np.linalg.norm(gap[worst]):.2g}"
        f" {'rad' if what == 'rotation' else 'm'}/K, {excess[worst]:.2g} times what {precision} precision allows"
        f" ({(excess > 1.0).sum()} of {len(excess)} grids; relative difference {residual:.2g})",
        where=str(unit.path),
        hint=hint,
    )
