"""The map from thermal nodes to the grids of the model, with what had to be decided or said."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import scipy.sparse as sp

from tedm_cli.arrays import BoolArray, FloatArray, IntArray
from tedm_cli.config.temperature.node_weights import read_node_weights
from tedm_cli.config.thermal.map import MapTable
from tedm_cli.errors import ConfigError, PhysicsError
from tedm_cli.fem.conduction import conducting_links, conduction_matrix
from tedm_cli.mapping.averages import NONE, conducting_parts
from tedm_cli.mapping.node_map import ConductedMap, DependentNodes, WeightedMap
from tedm_cli.nastran.conductivity import conductors
from tedm_cli.nastran.geometry import id_list
from tedm_cli.stages.thermal.map_files import require_one_spelling
from tedm_cli.stages.thermal.map_model import FiniteElements
from tedm_cli.stages.thermal.map_nodes import Association, associate, near_name


@dataclass(frozen=True, eq=False)
class Mapping:
    """A map of n thermal nodes.

    node : [n] names. through : from their temperatures to those of grids. association : None with weights.
    weights : [areas of a mean temperature, n], where the nodes make those of areas.
    left_out : ids of grids that elements use and the map does not reach: without a conducting element.
    unmapped : of each part that no node is for, its areas and the ids of its elements.
    """

    fem: FiniteElements
    node: list[str]
    through: ConductedMap | WeightedMap
    association: Association | None
    weights: FloatArray | None
    left_out: IntArray
    unmapped: list[tuple[list[str], IntArray]]
    notes: list[str]


def build_map(fem: FiniteElements, table: MapTable, where: Path) -> Mapping:
    """The map of the configuration in the file `where`.

    Raises
    ------
    ConfigError, InputError : what `associate`, `conductors` and `read_node_weights` refuse; areas that are not there;
        parts of the model without a node.
    PhysicsError : averages that cannot be prescribed; conducting elements that are tangled.
    """
    if table.weights is not None:
        return _weighted(fem, table, where)
    found = conductors(fem.model, fem.geometry, {int(k): v for k, v in table.conductivity_W_m_K.items()}, str(where))
    mesh, of = found.mesh, fem.volumes
    association = associate(fem, table, mesh.conducting, where)
    try:
        conduction = conduction_matrix(mesh)
    except PhysicsError as exc:  # the elements know no file
        raise PhysicsError(exc.fact, where=str(fem.source), hint=exc.hint) from exc
    n = len(fem.geometry.grid_id)
    reached = np.zeros(n, dtype=bool)
    reached[of.node_index[mesh.conducting[of.element]]] = True
    notes = [*found.notes, *association.notes]
    if table.rigid_conductance_W_K is not None:
        first, second = _rigid_pairs(fem)
        conduction = conduction + conducting_links(n, first, second, np.full(len(first), table.rigid_conductance_W_K))
        reached[first] = reached[second] = True
        notes.append(f"{len(first):,} links of rigid elements conduct {table.rigid_conductance_W_K:g} W/K each")
    part = conducting_parts(conduction, reached)
    part, unmapped = _with_nodes(fem, part, association, mesh.conducting, table, where)
    through = _conducted(fem, conduction, association, part, where)
    left = fem.geometry.grid_id[fem.geometry.structural & ~reached]
    return Mapping(fem, association.node, through, association, None, left, unmapped, notes)


def _conducted(
    fem: FiniteElements, conduction: sp.csr_matrix, association: Association, part: IntArray, where: Path
) -> ConductedMap:
    nodes = association.node
    try:
        return ConductedMap(conduction, fem.volumes, association.place_node, len(nodes), part)
    except DependentNodes as exc:
        names = list(dict.fromkeys(nodes[i] for i in exc.nodes.tolist()))
        listed = ", ".join(names[:6]) + (f" and {len(names) - 6} more" if len(names) > 6 else "")
        raise PhysicsError(
            f"the averages of {len(names)} thermal nodes follow from those of others: {listed}",
            where=str(where),
            hint="they have the same grids, or more nodes than grids: join nodes, or refine the mesh there",
        ) from exc
    except np.linalg.LinAlgError as exc:
        raise PhysicsError(
            "the conduction between the thermal nodes cannot be solved: it is too uneven",
            where=str(where),
            hint="do conductivities, thicknesses or sections differ by more than ten orders of magnitude?",
        ) from exc


def _rigid_pairs(fem: FiniteElements) -> tuple[IntArray, IntArray]:
    """Rows of the grids that rigid elements link, [L] and [L], each pair once."""
    pairs = {
        (int(a), int(b)) if a < b else (int(b), int(a))
        for _, element in sorted(fem.model.rigid_elements.items())
        for a, b in _links(element)
        if a != b
    }
    rows = np.searchsorted(fem.geometry.grid_id, np.array(sorted(pairs), dtype=np.int64).reshape(-1, 2))
    return rows[:, 0], rows[:, 1]


def _links(element: Any) -> Iterator[tuple[int, int]]:
    """Ids of the grids of one rigid element, leading and led; a rod or bar that both lead links its two ends."""
    leading, led = list(element.independent_nodes), list(element.dependent_nodes)
    if not led or set(led) <= set(leading):
        leading, led = leading[:1], [*leading[1:], *led]
    for a in leading:
        for b in led:
            yield int(a), int(b)


def _with_nodes(
    fem: FiniteElements,
    part: IntArray,
    association: Association,
    conducting: BoolArray,
    table: MapTable,
    where: Path,
) -> tuple[IntArray, list[tuple[list[str], IntArray]]]:
    """Parts [N] that have a node, and of the others, which must be of unmapped areas, these and their elements."""
    of = fem.volumes
    element_part = np.full(len(conducting), NONE)
    element_part[conducting] = part[of.node_index[of.node_offset[:-1][conducting]]]
    with_node = np.unique(part[of.node_index[association.place_node != NONE]])
    without = np.setdiff1d(np.unique(part[part != NONE]), with_node)
    if not (without.size or table.unmapped):
        return part, []
    names, grid_area = list(fem.areas), fem.grid_area()
    wanted = _unmapped_areas(table, names, where)
    problems, found = [], []
    for number in without.tolist():
        elements = fem.geometry.elements.id[element_part == number]
        inside = sorted(set(grid_area[part == number].tolist()) - {NONE})
        if not elements.size:  # rigid links alone
            continue
        if not inside or not set(inside) <= wanted:
            listed = f"; its areas are {', '.join(names[i] for i in inside[:6])}" if inside else ""
            problems.append(
                ("map", f"no thermal node is for the part of {len(elements)} elements {id_list(elements)}{listed}")
            )
        found.append(([names[i] for i in inside], elements))
    mapped = (part != NONE) & ~np.isin(part, without)
    for area in sorted(wanted):
        grids = fem.geometry.grid_id[mapped & (grid_area == area)]
        if grids.size:
            fact = f"{names[area]} has {len(grids)} grids that conduction joins to thermal nodes: {id_list(grids)}"
            problems.append(("map.unmapped", fact))
    if problems:
        hint = (
            "give the part a node, or name its areas in map.unmapped; rigid elements conduct by rigid_conductance_W_K"
        )
        more = len(problems) - 8
        shown = [*problems[:8], *([("map", f"and {more} more such parts and areas")] if more > 0 else [])]
        raise ConfigError(shown, where=str(where), hint=hint)
    return np.where(mapped, part, NONE), found


def _unmapped_areas(table: MapTable, names: list[str], where: Path) -> set[int]:
    """Rows of the areas in `map.unmapped`."""
    known = {name.upper(): row for row, name in enumerate(names)}
    unknown = [name for name in table.unmapped if name.upper() not in known]
    if unknown:
        shown = near_name(unknown[0], names) or f"; there are {', '.join(names[:8])}"
        fact = f"no thermal area of a mean temperature is called {unknown[0]!r}{shown}"
        raise ConfigError([("map.unmapped", fact)], where=str(where))
    return {known[name.upper()] for name in table.unmapped}


def _weighted(fem: FiniteElements, table: MapTable, where: Path) -> Mapping:
    """The nodes as weighted means on whole areas."""
    assert table.weights is not None
    path, names = fem.project.beside(where, table.weights), list(fem.areas)
    weights = read_node_weights(path).weights
    unmapped = _unmapped_areas(table, names, where)
    unknown = [area for area in weights if area not in names]
    problems = []
    if unknown:
        problems.append(f"no thermal area of a mean temperature is called {unknown[0]!r}{near_name(unknown[0], names)}")
    both = [names[i] for i in sorted(unmapped) if names[i] in weights]
    if both:
        problems.append(f"has weights for {', '.join(both)}, which map.unmapped leaves out")
    left = [name for i, name in enumerate(names) if name not in weights and i not in unmapped]
    if left and not unknown:
        listed = ", ".join(left[:8]) + (f" and {len(left) - 8} more" if len(left) > 8 else "")
        problems.append(f"has no weights for {listed}")
    if problems:
        hint = "weights are by the names of areas; areas with a spectrum of their own are named in map.unmapped"
        raise ConfigError([("", fact) for fact in problems], where=str(path), hint=hint)
    nodes = list(dict.fromkeys(node for of in weights.values() for node in of))
    spelled: dict[str, str] = {}
    for node in nodes:
        require_one_spelling(spelled, node, str(path))
    matrix = np.zeros((len(names), len(nodes)))
    for area, of in weights.items():
        for node, weight in of.items():
            matrix[names.index(area), nodes.index(node)] = weight
    owner = fem.grid_area()
    taken = np.isin(owner, [i for i, name in enumerate(names) if name in weights])
    rows, columns = np.flatnonzero(taken), owner[taken]
    on_grids = sp.coo_matrix((np.ones(len(rows)), (rows, columns)), shape=(len(owner), len(names))).tocsr()
    through = WeightedMap(sp.csr_matrix(on_grids @ matrix))
    left_out = fem.geometry.grid_id[fem.geometry.structural & (owner == NONE)]
    return Mapping(
        fem,
        nodes,
        through,
        None,
        matrix,
        left_out,
        [([names[i]], np.zeros(0, dtype=np.int64)) for i in sorted(unmapped)],
        [],
    )
