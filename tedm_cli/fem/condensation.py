"""Static condensation of a part of a structure to the grids where it is joined to the rest.

The part's own unknowns q follow from its forces f and from the motions a of the interface by

    [K  Aᵀ] [q]   [f]
    [A  0 ] [m] = [a],        forces on the interface  -m = K_aa a - P

with u = T q for all grids, and A the rows of T of the interface. This holds for interface grids that rigid or
interpolation elements of the part make dependent, too: these become free in what is left.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import scipy.sparse as sp

from tedm_cli.arrays import BoolArray, FloatArray, IntArray
from tedm_cli.errors import InputError, PhysicsError
from tedm_cli.fem.assembly import Operators, assemble, element_ids
from tedm_cli.fem.constraints import to_basic
from tedm_cli.fem.element_loads import element_loads
from tedm_cli.fem.parts import of_elements
from tedm_cli.fem.reduced import reduced_stiffness
from tedm_cli.fem.structure import ElementTemperatures, LoadCase, Structure
from tedm_cli.fem.superelement import ReducedMatrices


def part_grids(structure: Structure, interface: IntArray, inside: int) -> BoolArray:
    """Grids [N] of the part that interface grids (rows [b]) cut off and that has the grid of row `inside`.

    Raises
    ------
    InputError
        If that grid is an interface grid, or the interface does not divide the structure.
    """
    if inside in interface:
        raise InputError(f"grid {structure.grid_id[inside]} is of the interface, and so of no part")
    members = [*_members(structure)]
    owner = np.repeat(np.arange(len(members)), [len(m) for m in members])
    grid = np.concatenate(members)
    cut = np.isin(grid, interface)
    n = structure.n_grids
    links = (np.ones((~cut).sum()), (grid[~cut], n + owner[~cut]))
    graph = sp.csr_matrix(links, shape=(n + len(members),) * 2)
    _, part = sp.csgraph.connected_components(graph, directed=False)
    of_part = np.asarray(part[:n] == part[inside])
    others = np.setdiff1d(grid, np.concatenate([np.flatnonzero(of_part), interface]))
    if not others.size:
        raise InputError(
            f"the interface cuts nothing off: all grids of elements hang together with grid"
            f" {structure.grid_id[inside]}",
            hint="name every grid that the part shares with the rest",
        )
    return of_part


def _members(structure: Structure) -> list[IntArray]:
    """Rows of the grids of every element, rigid element and equation."""
    out = [row for connectivity in _connectivities(structure) for row in connectivity]
    out += [np.append(e.dependents, e.independent) for e in structure.rbe2]
    out += [np.append(e.independents, e.dependent) for e in structure.rbe3]
    return out + [e.grids for e in structure.mpc]


def _connectivities(structure: Structure) -> list[IntArray]:
    """Of all blocks of elements, in the order of `element_ids`."""
    others = (structure.bars, structure.rods, structure.quads, structure.trias)
    return [*(block.connectivity for block in structure.solids), *(block.connectivity for block in others)]


def part_of(structure: Structure, of_part: BoolArray) -> Structure:
    """The elements, rigid elements, equations and supports with a grid of a part [N], on the same grids."""
    has = [of_part[connectivity].any(axis=1) for connectivity in _connectivities(structure)]
    ids = element_ids(structure)[np.concatenate(has)]
    held = of_part[structure.spc_grid]
    return replace(
        of_elements(structure, ids),
        displacement_frame=structure.displacement_frame,
        rbe2=tuple(e for e in structure.rbe2 if of_part[np.append(e.dependents, e.independent)].any()),
        rbe3=tuple(e for e in structure.rbe3 if of_part[np.append(e.independents, e.dependent)].any()),
        mpc=tuple(e for e in structure.mpc if of_part[e.grids].any()),
        spc_grid=structure.spc_grid[held],
        spc_component=structure.spc_component[held],
        initial_temperature=structure.initial_temperature,
    )


def condense(part: Structure, interface: IntArray, recovered: IntArray, cases: list[LoadCase]) -> ReducedMatrices:
    """Matrices of a part at its interface (rows [b]) and its recovery of grids (rows [r]), in SI.

    Load cases are columns of the loads: 1 K each.

    Raises
    ------
    PhysicsError
        If the interface does not hold the part, or part of the interface is rigid in itself.
    """
    operators = assemble(part)
    whole, basic = reduced_stiffness(part, operators.stiffness), to_basic(part)
    reduced, transform, free = whole.matrix, whole.transform.tocsr(), whole.free
    dofs = (6 * interface[:, None] + np.arange(6)).reshape(-1)
    tied = whole.tied[dofs][:, free].tocsr()
    moves = np.flatnonzero(np.diff(tied.indptr))  # what nothing of the part resists passes no force on
    tied, inner = tied[moves], reduced[free][:, free]
    scale = 1.0 / np.sqrt(inner.diagonal())
    scaled = sp.diags(scale)
    row = 1.0 / np.sqrt(np.asarray((tied @ scaled).power(2).sum(axis=1)).reshape(-1))
    link = sp.diags(row) @ tied @ scaled
    system = sp.bmat([[scaled @ inner @ scaled, link.T], [link, None]], format="csc")
    try:
        factors = sp.linalg.splu(system)
    except RuntimeError as error:
        raise _not_condensed() from error
    force = _forces(part, operators, cases)
    n, b, k = len(free), len(moves), len(cases)
    right = np.zeros((n + b, b + k))
    right[n:, :b] = np.diag(row)
    right[:n, b:] = scale[:, None] * (transform[:, free].T @ force)
    solution = factors.solve(right)
    solution += factors.solve(right - system @ solution)  # one step of refinement
    residual = np.abs(system @ solution - right).max() / np.abs(right).max()
    if not residual < 1e-9:
        raise _not_condensed()
    inside, reaction = scale[:, None] * solution[:n], row[:, None] * solution[n:]
    stiffness, thermal = np.zeros((len(dofs),) * 2), np.zeros((len(dofs), k))
    stiffness[np.ix_(moves, moves)] = -(reaction[:, :b] + reaction[:, :b].T) / 2.0
    thermal[moves] = reaction[:, b:]
    rows = (6 * recovered[:, None] + np.arange(6)).reshape(-1)
    motion = transform[rows][:, free] @ inside
    recovery = np.zeros((len(rows), len(dofs)))
    recovery[:, moves] = motion[:, :b]
    own = {int(grid): n for n, grid in enumerate(interface)}
    for place, grid in enumerate(recovered.tolist()):  # interface grids move as they do, also where nothing resists
        if grid in own:
            turn = basic[6 * grid : 6 * grid + 6, 6 * grid : 6 * grid + 6].toarray()
            at = slice(6 * place, 6 * place + 6)
            recovery[at], motion[at, b:] = 0.0, 0.0
            recovery[at, 6 * own[grid] : 6 * own[grid] + 6] = turn
    return ReducedMatrices(stiffness=stiffness, loads=thermal, recovery=recovery, thermal_recovery=motion[:, b:])


def _not_condensed() -> PhysicsError:
    return PhysicsError(
        "the part cannot be condensed: its interface does not hold it, or supports and rigid elements of the part leave"
        " an interface grid not all of its motions",
        hint="name every grid that it shares with the rest, and one grid of each rigid element",
    )


def warms(part: Structure, cases: list[LoadCase]) -> FloatArray:
    """Largest nodal force of each load case on a part, N: zero of areas that are elsewhere."""
    return np.asarray(np.abs(_forces(part, assemble(part), cases)).max(axis=0))


def _forces(part: Structure, operators: Operators, cases: list[LoadCase]) -> FloatArray:
    """Nodal forces [6 N, k] of load cases on a part."""
    kelvin = []
    for case in cases:
        if case.temperature is None:
            raise PhysicsError(
                f"load case {case.id} ({case.label}) has no temperatures, and a superelement no other loads"
            )
        kelvin.append(case.temperature)
    force = operators.thermal.forces(np.stack(kelvin, axis=1))
    if any(case.elements is not None for case in cases):
        loads = element_loads(part)
        own = [loads.own(t, _of(case.elements, loads.element_id)) for t, case in zip(kelvin, cases, strict=True)]
        force += loads.forces(np.stack(own, axis=1))
    return force


def _of(elements: ElementTemperatures | None, ids: IntArray) -> ElementTemperatures | None:
    """Those of some elements."""
    if elements is None:
        return None
    here = np.isin(elements.element_id, ids)
    return ElementTemperatures(
        element_id=elements.element_id[here], mean=elements.mean[here], gradient=elements.gradient[here]
    )
