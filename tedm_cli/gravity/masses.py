"""The mass of a finite-element model as the gravity sums see it: elements with shape functions, and point masses."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tedm_cli.arrays import FloatArray, IntArray
from tedm_cli.errors import PhysicsError
from tedm_cli.fem.shapes import Shape, shape_of


@dataclass(frozen=True, eq=False, kw_only=True)
class ElementBlock:
    """Elements of one card and one number of nodes.

    card : Nastran card name; shape : its shape functions.
    id : [E]; mass : [E], kg, spread over the volume, area or length.
    nodes : [E, n], rows of the grid table in Nastran's order.
    offset : [E, n, 3], lever from each node to where the element's mass reference passes it (basic frame, m).
    half_thickness : [E], m, of plates; 0 for others.
    weight : [E, n], density of the mass (per volume, area or length) at each node over the mean of the nodes, between
    them by the shape functions; None where it is even all over the block.
    """

    card: str
    shape: Shape
    id: IntArray
    mass: FloatArray
    nodes: IntArray
    offset: FloatArray
    half_thickness: FloatArray
    weight: FloatArray | None = None


@dataclass(frozen=True, eq=False, kw_only=True)
class PointMasses:
    """Point masses that ride on grids: lumped nodal masses and concentrated masses.

    name : [P], for messages; mass : [P], kg; node : [P], rows of the grid table; offset : [P, 3], lever from the grid
    (basic frame, m).
    """

    name: Sequence[str]
    mass: FloatArray
    node: IntArray
    offset: FloatArray


@dataclass(frozen=True, eq=False, kw_only=True)
class ElementMasses:
    """The E elements of a model and what each of them weighs, of any cards and numbers of nodes.

    id : [E]; card : [E], Nastran card names; mass : [E], kg.
    node_offset, node_index : ragged connectivity, [E + 1] and [M] rows of the grid table.
    lever : [M, 3], offset of each element's mass reference from each of its nodes, basic frame, m.
    section : [E], thickness of plates, m; not used for solids and line elements.
    weight : [M], density of each element's mass at each of its nodes over the mean of its nodes; None for even masses.
    """

    id: IntArray
    card: Sequence[str]
    mass: FloatArray
    node_offset: IntArray
    node_index: IntArray
    lever: FloatArray
    section: FloatArray
    weight: FloatArray | None = None


@dataclass(frozen=True, eq=False, kw_only=True)
class MassDistribution:
    """Where the mass of a model is and how it moves with the grids.

    A point at shape functions N of an element lies at ``Σ N_n (x_n + w_n)`` and moves by ``Σ N_n (u_n + θ_n x w_n)``,
    with w the offsets; a point mass at ``x + w`` moves by ``u + θ x w``.

    position : [N, 3], grids in the basic frame, m.
    lever_node : [L], ascending rows of the grids whose rotation matters, because something with mass is offset from
    them.
    """

    position: FloatArray
    elements: tuple[ElementBlock, ...]
    points: PointMasses
    lever_node: IntArray

    @property
    def total_kg(self) -> float:
        return float(self.points.mass.sum() + sum(float(block.mass.sum()) for block in self.elements))


def mass_distribution(
    position: FloatArray,
    elements: ElementMasses,
    points: PointMasses,
    *,
    lumped: bool = False,
    grid_id: IntArray | None = None,
) -> MassDistribution:
    """Sort the elements of a model by their shape.

    Elements and points without mass are left out, wherever they are. Elements without shape functions here are lumped
    to their nodes, and with `lumped` all are: the element's mass shared equally among its nodes (the published method,
    Montemurro 2004, chapter 7), at the end of their levers where it has any.

    Parameters
    ----------
    position : [N, 3], grids, basic frame, m.
    points : concentrated masses.
    grid_id : [N], names of the grids in messages (their rows by default).
    """
    mass, lever, weight = elements.mass, elements.lever, elements.weight
    counts = np.diff(elements.node_offset)
    heavy = mass != 0.0
    number = {name: i for i, name in enumerate(sorted(set(elements.card)))}
    kinds = np.fromiter((number[c] for c in elements.card), np.int64, len(elements.card))
    shared = np.zeros(len(position))
    share = np.repeat(np.where(heavy, mass, 0.0) / counts, counts)
    levers = lever_nodes(mass, elements.node_offset, elements.node_index, lever, points)
    on_lever = np.any(lever != 0.0, axis=1) & (share != 0.0)
    aside: list[IntArray] = []
    blocks = []
    pairs = [(name, int(n)) for name, kind in number.items() for n in np.unique(counts[heavy & (kinds == kind)])]
    for name, count in pairs:
        members = np.flatnonzero((kinds == number[name]) & (counts == count) & heavy)
        shape = shape_of(name, count)
        rows = elements.node_offset[members][:, None] + np.arange(count)
        if lumped or shape is None:
            plain = rows[~on_lever[rows]]
            np.add.at(shared, elements.node_index[plain], share[plain])
            aside.append(rows[on_lever[rows]])
            continue
        blocks.append(
            ElementBlock(
                card=name,
                shape=shape,
                id=elements.id[members],
                mass=mass[members],
                nodes=elements.node_index[rows],
                offset=lever[rows],
                half_thickness=elements.section[members] / 2.0 if shape.dimension == 2 else np.zeros(len(members)),
                weight=None if weight is None or (weight[rows] == 1.0).all() else weight[rows],
            )
        )
    nodal = np.flatnonzero(shared)
    kept = np.flatnonzero(points.mass != 0.0)
    names = np.arange(len(position)) if grid_id is None else grid_id
    offset_rows = np.concatenate([*aside, np.zeros(0, dtype=np.int64)])
    lumps = np.concatenate([nodal, elements.node_index[offset_rows]])
    all_points = PointMasses(
        name=[*(f"lumped mass of grid {names[n]}" for n in lumps), *(points.name[n] for n in kept)],
        mass=np.concatenate([shared[nodal], share[offset_rows], points.mass[kept]]),
        node=np.concatenate([lumps, points.node[kept]]),
        offset=np.concatenate([np.zeros((len(nodal), 3)), lever[offset_rows], points.offset[kept]]),
    )
    if not np.isfinite(all_points.mass).all() or not all(np.isfinite(b.mass).all() for b in blocks):
        raise PhysicsError("a mass of the model is not finite")
    return MassDistribution(position=position, elements=tuple(blocks), points=all_points, lever_node=levers)


def lever_nodes(
    mass: FloatArray, node_offset: IntArray, node_index: IntArray, lever: FloatArray, points: PointMasses
) -> IntArray:
    """Ascending rows of the grids from which something with mass is offset; arguments as in `ElementMasses`."""
    heavy = np.repeat(mass != 0.0, np.diff(node_offset))
    moved = points.node[np.any(points.offset != 0.0, axis=1)]
    away = np.unique(np.flatnonzero(lever) // 3)
    return np.asarray(np.unique(np.concatenate([moved, node_index[away[heavy[away]]]])))
