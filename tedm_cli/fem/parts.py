"""Some elements of a structure by themselves, and the work of their forces: what a parameter of them is about.

An output y = g u of K u = f(T) changes with a parameter p of some elements by

    dy/dp = λᵀ (df/dp - dK/dp u),    K λ = gᵀ

where only the elements that have the parameter enter. Their matrices are either their own changes (all of a stiffness
and of the forces of temperatures grows with a common factor of the moduli) or, of shells, follow from `law_rates`.
"""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from typing import TYPE_CHECKING, TypeVar

import numpy as np

from tedm_cli.arrays import BoolArray, FloatArray, IntArray
from tedm_cli.fem.adjoint import TemperatureSensitivity
from tedm_cli.fem.assembly import assemble
from tedm_cli.fem.element_loads import element_loads
from tedm_cli.fem.structure import ShellBlock, Structure

if TYPE_CHECKING:
    from _typeshed import DataclassInstance

Block = TypeVar("Block", bound="DataclassInstance")


@dataclass(frozen=True, eq=False, kw_only=True)
class NodalForces:
    """Forces of a part for each of r outputs, where it has any.

    dof, force : [n] and [n, r], degrees of freedom 6 row + component, and forces and moments on them.
    """

    dof: IntArray
    force: FloatArray

    def work(self, motion: FloatArray) -> FloatArray:
        """Over k motions [6 N, k] of all grids, [r, k]."""
        return np.asarray(self.force.T @ motion[self.dof])


def of_elements(structure: Structure, ids: IntArray) -> Structure:
    """The elements with these ids alone, on the same grids; without rigid elements and supports."""
    solids = [_kept(block, np.isin(block.element_id, ids)) for block in structure.solids]
    return Structure(
        grid_id=structure.grid_id,
        position=structure.position,
        solids=tuple(block for block in solids if len(block.element_id)),
        bars=_kept(structure.bars, np.isin(structure.bars.element_id, ids)),
        rods=_kept(structure.rods, np.isin(structure.rods.element_id, ids)),
        quads=_kept(structure.quads, np.isin(structure.quads.element_id, ids)),
        trias=_kept(structure.trias, np.isin(structure.trias.element_id, ids)),
    )


def _kept(block: Block, keep: BoolArray) -> Block:
    """The elements of a block that are kept; every array of a block has one row for each."""
    arrays = {f.name: getattr(block, f.name) for f in fields(block)}
    return replace(block, **{n: value[keep] for n, value in arrays.items() if isinstance(value, np.ndarray)})


def shell_ids(part: Structure) -> IntArray:
    """Of quadrilaterals, then of triangles."""
    return np.concatenate([part.quads.element_id, part.trias.element_id])


def with_law_rates(part: Structure, rates: FloatArray) -> Structure:
    """Its shells with `ShellBlock.law_rates` [L, 3], in the order of `shell_ids`."""
    quads, trias = _split(part, rates)
    return replace(part, quads=replace(part.quads, law_rates=quads), trias=replace(part.trias, law_rates=trias))


def with_shell_expansion(part: Structure, factor: FloatArray) -> Structure:
    """Expansions of shells' membranes and of their bending times factors [L, 2], in the order of `shell_ids`."""

    def scaled(block: ShellBlock, by: FloatArray) -> ShellBlock:
        return replace(
            block, expansion=by[:, 0] * block.expansion, bending_expansion=by[:, 1] * block.bending_expansion
        )

    quads, trias = _split(part, factor)
    return replace(part, quads=scaled(part.quads, quads), trias=scaled(part.trias, trias))


def with_unit_expansion(part: Structure) -> Structure:
    """The same elements with an expansion of 1/K in every direction."""

    def shell(block: ShellBlock) -> ShellBlock:
        one = np.ones_like(block.expansion)
        return replace(block, expansion=one, bending_expansion=one)

    isotropic = np.repeat([1.0, 0.0], 3)
    solids = []
    for block in part.solids:
        expansion = np.broadcast_to(isotropic, block.materials.expansion.shape)
        solids.append(replace(block, materials=replace(block.materials, expansion=expansion)))
    return replace(
        part,
        solids=tuple(solids),
        bars=replace(part.bars, expansion=np.ones_like(part.bars.expansion)),
        rods=replace(part.rods, expansion=np.ones_like(part.rods.expansion)),
        quads=shell(part.quads),
        trias=shell(part.trias),
    )


def _split(part: Structure, values: FloatArray) -> tuple[FloatArray, FloatArray]:
    count = len(part.quads.element_id)
    return values[:count], values[count:]


def part_work(
    part: Structure, motion: FloatArray, whole: TemperatureSensitivity
) -> tuple[TemperatureSensitivity, NodalForces]:
    """What a part does over motions λ [6 N, r] of the structure of which `whole` is the sensitivity.

    Returns
    -------
    The work of its thermal forces, by the temperatures of all grids and elements of the structure, and its forces K λ.
    """
    operators, loads = assemble(part), element_loads(part)
    dof = np.flatnonzero(np.diff(operators.stiffness.indptr))
    rows = np.searchsorted(whole.element_id, loads.element_id)
    work = loads.work(motion)
    mean = np.zeros_like(whole.mean)
    gradient = np.zeros_like(whole.gradient)
    mean[:, rows] = work[..., 0]
    gradient[:, rows] = work[..., 1:].reshape(*work.shape[:2], 2, 2)
    grid = np.asarray((operators.thermal.coupling.T @ motion).T)
    thermal = replace(whole, grid=grid, mean=mean, gradient=gradient)
    return thermal, NodalForces(dof=dof, force=np.asarray(operators.stiffness[dof] @ motion))
