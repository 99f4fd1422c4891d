"""What unit loads leave besides [D], and whether linear elasticity and the model allow it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tedm_cli.arrays import BoolArray, FloatArray, IntArray
from tedm_cli.contracts import DISTORTION, UNIT_LOADS
from tedm_cli.distortion import Precision, plausible_translation, superposition_excess, superposition_residual
from tedm_cli.errors import PhysicsError
from tedm_cli.files.store import Reader, Writer
from tedm_cli.noise.areas import AreaTable
from tedm_cli.results.gravity.ties import Ties

IMPLAUSIBLE = 100.0  # times the free growth of the whole model


@dataclass(frozen=True)
class Reductions:
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


def precision_of(unit: Reader) -> Precision:
    """Of the results that the unit loads are from."""
    return "double" if unit.string(UNIT_LOADS.RESULTS_PRECISION) == "double" else "single"


def check_turning(unit: Reader, rows: IntArray) -> None:
    """A lever needs the rotation of its grid; a grid that moves and never turns has none."""
    if rows.size:
        ids = unit.array(UNIT_LOADS.GRID_ID)[rows]
        shown = ", ".join(map(str, ids[:8])) + (" ..." if ids.size > 8 else "")
        raise PhysicsError(
            f"grids that carry offset masses or elements, but never rotate under any load: {shown}",
            where=str(unit.path),
            hint="a grid of solids alone has no rotation; put the mass on a grid of its own, tied by RBE2 or RBE3",
        )


def check_tied_turning(unit: Reader, ties: Ties, rows: IntArray) -> None:
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


def still_ties(ties: Ties, found: Reductions) -> tuple[str, ...]:
    """Remarks on tied blocks that no load moves."""
    turned = np.zeros(len(found.size))
    turned[found.lever_rows] = found.turn_size
    still = [name for name in ties.block if not (found.size + turned)[ties.rows(name)].any()]
    return (f"tied compensation masses whose grids no load moves: {', '.join(still)}",) if still else ()


def check_plausible(unit: Reader, areas: AreaTable, largest: FloatArray) -> None:
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


def superposition(unit: Reader, writer: Writer, found: Reductions, rows: IntArray) -> float | None:
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
    precision = precision_of(unit)
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
