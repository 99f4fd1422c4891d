"""Superelements in a unit-load deck: grids with mass, one stiffness (K2GG) and the loads of areas (P2G)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from tedm_cli.arrays import FloatArray, IntArray
from tedm_cli.deck_units import LENGTH, MASS
from tedm_cli.errors import InputError
from tedm_cli.fem.superelement import ReducedMatrices
from tedm_cli.nastran.library import without_integration
from tedm_cli.nastran.loads.unit_load_control import SUPERELEMENT_LOADS
from tedm_cli.nastran.superelements.dmig import cards, numbered, six
from tedm_cli.nastran.units import units_of

STIFFNESS = ("TEDMKSE", "TEDMKS2")
"""Names of the stiffness: nine digits of it, and the rest. Ten digits of a stiff plate are few of its bending."""


@dataclass(frozen=True, eq=False)
class DeckMatrices:
    """Stiffness and loads of all superelements together, in the units of the deck.

    grid : [b], ascending. stiffness : [6 b, 6 b]. loads : [6 b] by area in upper case. names : of these areas.
    """

    grid: IntArray = field(default_factory=lambda: np.zeros(0, dtype=np.int64))
    stiffness: FloatArray = field(default_factory=lambda: np.zeros((0, 0)))
    loads: Mapping[str, FloatArray] = field(default_factory=dict)
    names: tuple[str, ...] = ()

    @classmethod
    def of(cls, parts: Sequence[tuple[IntArray, Sequence[str], ReducedMatrices]]) -> DeckMatrices:
        """The sum of condensed matrices, each with its interface grids and its areas."""
        grid = np.unique(np.concatenate([interface for interface, _, _ in parts]))
        stiffness = np.zeros((6 * len(grid),) * 2)
        loads: dict[str, FloatArray] = {}
        names: dict[str, str] = {}
        for interface, areas, matrices in parts:
            dof = (6 * np.searchsorted(grid, interface)[:, None] + np.arange(6)).reshape(-1)
            stiffness[np.ix_(dof, dof)] += (matrices.stiffness + matrices.stiffness.T) / 2.0
            for area, column in zip(areas, matrices.loads.T, strict=True):
                names.setdefault(area.upper(), area)
                loads.setdefault(area.upper(), np.zeros(6 * len(grid)))[dof] += column
        return cls(grid, stiffness, loads, tuple(names.values()))

    def control(self) -> list[str]:
        """Lines above the subcases."""
        return [f"K2GG = {', '.join(STIFFNESS)}", f"P2G = {SUPERELEMENT_LOADS}"] if self.grid.size else []

    def bulk(self, labels: Sequence[str], uniform: str) -> list[str]:
        """The matrices as cards, with a column of loads for each subcase by its label."""
        if not self.grid.size:
            return []
        nothing = np.zeros(6 * len(self.grid))
        total = sum(self.loads.values(), nothing)
        by_label = {**self.loads, uniform.upper(): total}
        columns = np.stack([by_label.get(label.upper(), nothing) for label in labels], axis=1)
        rows = six(self.grid)
        first = np.array([float(f"{v:.8e}") for v in self.stiffness.flat]).reshape(self.stiffness.shape)
        return [
            "$ Superelements: stiffness, and forces of +1 K on their areas by subcase",
            *cards(STIFFNESS[0], first, rows),
            *cards(STIFFNESS[1], self.stiffness - first, rows),
            *cards(SUPERELEMENT_LOADS, columns, rows, numbered(len(labels))),
        ]


def mass_cards(
    model: Any, node: IntArray, position_m: FloatArray, kg: FloatArray, interface: IntArray, where: str
) -> list[str]:
    """GRID, held, and CONM2 of the grids with mass of superelements; of an interface grid its mass alone.

    Raises
    ------
    InputError : a grid that the deck has already, or no ids left for the masses.
    """
    with without_integration():
        from pyNastran.bdf.field_writer_16 import print_card_16

    units = units_of(model)
    there = [i for i in node.tolist() if i in model.nodes and i not in interface]
    if there:
        raise InputError(
            f"grid {there[0]} with mass is in the deck already ({len(there)} of {len(node)} are)",
            where=where,
            hint="number the recovered grids otherwise, or name those that are joined to the deck as interface",
        )
    taken = [0, *model.elements, *model.masses, *model.rigid_elements]
    first = max(taken) + 1
    if first + len(node) > 99_999_999:
        raise InputError("has no ids of elements left for the masses of superelements", where=where)
    places, masses = position_m / units.factor(LENGTH), kg / units.factor(MASS)
    lines = ["$ Grids with mass of superelements: held here, their motion is recovered by tedm ingest"]
    for number, (grid, place, mass) in enumerate(zip(node.tolist(), places.tolist(), masses.tolist(), strict=True)):
        if grid not in interface:
            lines += print_card_16(["GRID", grid, 0, *place, 0, 123456]).splitlines()
        lines += print_card_16(["CONM2", first + number, grid, 0, mass]).splitlines()
    return lines
