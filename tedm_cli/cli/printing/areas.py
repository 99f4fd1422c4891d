"""Thermal areas as lines of text."""

from __future__ import annotations

from collections.abc import Sequence
from math import isnan
from typing import TYPE_CHECKING

from tedm_cli.areas.mean_step import LEAST, MeanStep
from tedm_cli.cli.printing.table import table
from tedm_cli.results.areas import plane_words

_NAMED = 3
LOAD = {"mean": "1 K", "gradient": "1 K/m"}

if TYPE_CHECKING:
    from tedm_cli.config.symmetry_plane import ProjectPlane
    from tedm_cli.stages.model.areas import AreaSummary


def area_lines(done: AreaSummary) -> list[str]:
    """Table of the thermal areas, and whether they are a partition of the structural grids."""
    t = done.table
    own = any(load.element_id.size for load in done.loads)
    gradients = any(load.gradient is not None for load in done.loads)
    rows = [
        (
            str(t.name[i]),
            *([LOAD[load.kind]] if gradients else []),
            f"{len(load.grid_id):,}",
            *([f"{len(load.element_id):,}"] if own else []),
            f"{done.mass_kg[i]:.6g}",
            *(_fixed(v) for v in done.centroid_m[i].tolist()),
            share_text(done.mean_step[i].share),
            *(str(column[i]) for column in (t.group, t.shield, t.side)),
        )
        for i, load in enumerate(done.loads)
    ]
    means = [load.gradient is None for load in done.loads]
    mass = float(done.mass_kg[means].sum())
    warmed = [load for load in done.loads if load.gradient is None]
    grids, elements = (sum(map(len, ids)) for ids in ([x.grid_id for x in warmed], [x.element_id for x in warmed]))
    total = (
        "total",
        *([LOAD["mean"]] if gradients else []),
        f"{grids:,}",
        *([f"{elements:,}"] if own else []),
        f"{mass:.6g}",
        *[""] * 7,
    )
    head = (
        "area",
        *(["load"] if gradients else []),
        "grids",
        *(["elements"] if own else []),
        "kg",
        "x m",
        "y m",
        "z m",
        "mean step",
        "group",
        "shield",
        "side",
    )
    right = range(1 + gradients, len(head) - 3)
    left = len(done.found.left)
    elsewhere = done.total_kg - mass
    if abs(elsewhere) < 1e-12 * done.total_kg:  # rounding of the sum
        elsewhere = 0.0
    centroid = "mean of the grids, and of the centres of elements" if own else "mean of the grids"
    return [
        f"{done.source}: areas of {done.origin}",
        *table(head, [*rows, total], right=right),
        *(["elements: those with temperatures of their own, whatever their grids have"] if own else []),
        f"centroid: {centroid}; mass: shared among grids, {elsewhere:.6g} of"
        f" {done.total_kg:.6g} kg on grids of no area; mean step: of the area's own elements, by volume",
        plane_line(done.plane),
        *(f"note: {line}" for line in [*done.found.lines(), *done.notes]),
        *mean_step_lines(done.mean_step),
        f"{done.structural - left:,} of {done.structural:,} structural grids"
        + (" of elements without temperatures of their own" if own else "")
        + " are in exactly one area"
        + ("" if done.is_partition else f", {left:,} in none"),
    ]


def _fixed(value: float) -> str:
    """Metres to a tenth of a millimetre, without the sign of nought."""
    text = f"{value:.4f}"
    return text.removeprefix("-") if float(text) == 0.0 else text


def mean_step_lines(steps: Sequence[MeanStep]) -> list[str]:
    """Smallest and largest mean step of the areas' own elements, and a warning of areas far below their step."""
    known = sorted((s for s in steps if not isnan(s.share)), key=lambda s: round(s.share, 6))
    if not known:
        return []
    low, high = (share_text(s.share) for s in (known[0], known[-1]))
    ends = f"{low} in all" if low == high else f"{low} ({known[0].area}) to {high} ({known[-1].area})"
    lines = [f"mean step of the areas' own elements: {ends}"]
    poor = [s for s in known if s.share < LEAST]
    if poor:
        listed = "; ".join(f"{s.area} {share_text(s.share)} ({_elements(s)})" for s in poor[:_NAMED])
        listed += f"; and {len(poor) - _NAMED} more, which `tedm areas` lists" if len(poor) > _NAMED else ""
        whose = "the own elements of 1 area" if len(poor) == 1 else f"the own elements of {len(poor)} areas"
        lines.append(
            f"warning: {whose} get less than {share_text(LEAST)} of the step, because grids on their border belong to a"
            f" neighbour and are warmed with it: {listed}; {_remedy(poor)}"
        )
    return lines


def mean_step_dict(steps: Sequence[MeanStep]) -> dict[str, float]:
    """By area, for a program; NaN where an area has no elements."""
    return {s.area: s.share for s in steps}


def _remedy(poor: Sequence[MeanStep]) -> str:
    """What raises these steps: solids have no temperatures of their own."""
    carriers, elements = sum(s.carriers for s in poor), sum(len(s.elements) for s in poor)
    if not carriers:
        return "refine the mesh between the borders"
    if carriers == elements:
        return 'give such an area carrier = "elements", or refine the mesh between the borders'
    return 'give shells, bars and rods of such an area carrier = "elements"; refine solids between the borders'


def share_text(share: float) -> str:
    """A mean step in percent."""
    return "-" if isnan(share) else f"{100.0 * share:.3g} %"


def _elements(step: MeanStep) -> str:
    count = len(step.elements)
    return f"element {step.elements[0]}" if count == 1 else f"{count:,} elements"


def plane_line(used: ProjectPlane) -> str:
    """Which plane gives the areas their sides, and where it is from."""
    return f"symmetry plane: {plane_words(used.plane, used.origin, used.layout.name if used.layout else '')}"
