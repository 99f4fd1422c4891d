"""Meshes of conducting elements with thermal nodes on them."""

from __future__ import annotations

import numpy as np
from fem_models import solid_mesh
from shell_models import sheet

from tedm_cli.fem.conduction import ConductingMesh, conduction_matrix
from tedm_cli.fem.measure import whole_rule
from tedm_cli.fem.shapes import CARDS, PYRAMID_AS_BRICK, shape_of
from tedm_cli.mapping.averages import NONE, Volumes, conducting_parts
from tedm_cli.mapping.node_map import ConductedMap

SIZE = (0.3, 0.2, 0.1)


def mesh(position, *blocks, k=100.0, section=1.0):
    """Of blocks (card, connectivity); conductivity and section of all elements or of each."""
    cards = [card for card, grids in blocks for _ in grids]
    nodes = [row for _, grids in blocks for row in np.asarray(grids).tolist()]
    return ConductingMesh(
        position=np.asarray(position, float),
        element_id=np.arange(1, len(cards) + 1),
        card=np.array(cards),
        node_offset=np.cumsum([0, *map(len, nodes)]),
        node_index=np.array([n for row in nodes for n in row]),
        section=np.broadcast_to(section, len(cards)).astype(float),
        conductivity=np.broadcast_to(k, len(cards)).astype(float),
    )


def volumes(of: ConductingMesh) -> Volumes:
    """Integrals of the shape functions, one element after the other."""
    out = np.zeros(len(of.node_index))
    for e, card in enumerate(of.card.tolist()):
        at = np.arange(of.node_offset[e], of.node_offset[e + 1])
        shape = CARDS["CHEXA"][0] if card == "CPYRAM" else shape_of(card, len(at))
        assert shape is not None
        at = at[PYRAMID_AS_BRICK] if card == "CPYRAM" else at
        values, weight = whole_rule(shape, of.position[of.node_index[at]][None])
        share = np.abs(weight[0]) @ values * (of.section[e] if shape.dimension < 3 else 1.0)
        np.add.at(out, at, share)
    return Volumes(node_offset=of.node_offset, node_index=of.node_index, volume=out)


def mapped(of: ConductingMesh, element_node, solver="auto"):
    """The map of nodes by element, or `NONE`; its volumes and conduction matrix."""
    k, v = conduction_matrix(of), volumes(of)
    element_node = np.asarray(element_node)
    reached = np.zeros(len(of.position), dtype=bool)
    reached[v.node_index[of.conducting[v.element]]] = True
    part = conducting_parts(k, reached)
    return ConductedMap(k, v, element_node[v.element], int(element_node.max()) + 1, part, solver), v, k


def bar(elements, *, length=1.0, k=100.0, area=1e-4):
    """A straight chain of rods along x."""
    position = np.zeros((elements + 1, 3))
    position[:, 0] = np.linspace(0.0, length, elements + 1)
    return mesh(
        position, ("CROD", np.column_stack([np.arange(elements), np.arange(1, elements + 1)])), k=k, section=area
    )


def box(card, nodes, cells=(3, 2, 2), distortion=0.15, k=100.0):
    """A box of solids."""
    position, grids = solid_mesh(card, nodes, cells, SIZE, distortion)
    return mesh(position, (card, grids), k=k)


def plate(cells, size=(0.4, 0.2), *, corners=4, k=150.0, thickness=2e-3, distortion=0.0):
    """A flat plate in z = 0."""
    position, grids = sheet(cells, size, corners=corners, distortion=distortion)
    return mesh(position, ("CQUAD4" if corners == 4 else "CTRIA3", grids), k=k, section=thickness)


def centres(of: ConductingMesh):
    """Mean position of the grids of each element."""
    parts = np.split(of.position[of.node_index], of.node_offset[1:-1])
    return np.array([p.mean(axis=0) for p in parts])


def along(of: ConductingMesh, nodes, axis=0):
    """Nodes as slices of even width along an axis."""
    x = of.position[:, axis]
    share = (centres(of)[:, axis] - x.min()) / (x.max() - x.min())
    return np.minimum((share * nodes).astype(int), nodes - 1)


__all__ = ["NONE", "SIZE", "along", "bar", "box", "centres", "mapped", "mesh", "plate", "volumes"]
