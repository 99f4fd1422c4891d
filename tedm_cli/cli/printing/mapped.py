"""Mapped temperatures, as lines of text."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from tedm_cli.cli.printing.table import table
from tedm_cli.mapping.node_map import ConductedMap
from tedm_cli.nastran.geometry import id_list
from tedm_cli.results.wording import count

if TYPE_CHECKING:
    from tedm_cli.stages.thermal.map_temperatures import MappedSummary


def mapped_lines(done: MappedSummary, top: int | None) -> list[str]:
    """How the nodes lie on the model, how good the field is, and what was written."""
    m = done.mapping
    grids = int(m.through.mapped.sum())
    lines = [f"{m.fem.source}: {count(len(m.node), 'thermal node')} on {grids:,} grids"]
    lines += _nodes(done, top)
    if isinstance(m.through, ConductedMap) and m.through.several.size:
        names = [m.node[i] for i in m.through.several.tolist()]
        listed = ", ".join(names[:6]) + (f" and {len(names) - 6} more" if len(names) > 6 else "")
        lines.append(f"in parts that nothing joins, the average in each of them: {listed}")
    lines += [
        f"not mapped, by themselves: {', '.join(areas)}"
        + (f" ({len(ids):,} elements: {id_list(ids, 4)})" if len(ids) else "")
        for areas, ids in m.unmapped
    ]
    if m.left_out.size:
        lines.append(f"{len(m.left_out):,} grids without a conducting element are left out: {id_list(m.left_out)}")
    lines += _sets(done, top)
    lines += [f"note: {line}" for line in done.notes]
    return [*lines, *(str(path) for path in done.paths)]


def _nodes(done: MappedSummary, top: int | None) -> list[str]:
    association = done.mapping.association
    if association is None:
        return ["all grids of an area have the weighted mean of its nodes"]
    near = {r.node: r for r in association.nearest}
    head = ["node", "elements", "cm3"] + (["nearest", "mean mm", "largest mm"] if near else [])
    order = np.argsort(done.elements, kind="stable")
    shown = order if top is None else order[:top]
    rows = []
    for i in shown.tolist():
        name = done.mapping.node[i]
        row = [name, f"{done.elements[i]:,}", f"{1e6 * done.volume[i]:.4g}"]
        if near:
            r = near.get(name)
            row += (
                ["", "", ""] if r is None else [f"{r.elements:,}", f"{1e3 * r.mean_m:.3g}", f"{1e3 * r.largest_m:.3g}"]
            )
        rows.append(tuple(row))
    lines = table(tuple(head), rows, right=range(1, len(head)))
    if len(shown) < len(order):
        lines.append(f"... {len(order) - len(shown)} more nodes, of more elements")
    if association.beyond:
        lines.append(f"{association.beyond:,} elements are beyond nearest_within_m of all nodes")
    return lines


def _sets(done: MappedSummary, top: int | None) -> list[str]:
    q = done.found
    order = np.arange(len(done.sets)) if q is None else np.argsort(-q.jump, kind="stable")
    shown = order if top is None else order[:top]
    head = ["set", *(["SID"] if done.sid else []), "least K", "largest K"]
    head += [] if q is None else ["largest change across an element", "in", "by TEMP cards"]
    rows = []
    for i in shown.tolist():
        field = done.field[:, i]
        row = [
            done.sets[i],
            *([str(done.sid[i])] if done.sid else []),
            f"{np.nanmin(field):.5g}",
            f"{np.nanmax(field):.5g}",
        ]
        if q is not None:
            row += [f"{q.jump[i]:.3g}", str(done.element_id(i) or ""), f"{q.step[i]:.3g}"]
        rows.append(tuple(row))
    lines = table(tuple(head), rows, right=range(1, len(head)))
    if len(shown) < len(order):
        lines.append(f"... {len(order) - len(shown)} more sets, of smaller changes")
    if q is not None:
        lines += [
            "by TEMP cards: the same change where all grids of a node have its temperature",
            f"averages over the nodes' elements are kept to {q.kept.max():.1e} K",
        ]
    return lines
