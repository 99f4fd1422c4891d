"""Superelements of a project on its deck: checked matrices for the unit loads, and the motion of their grids."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass

import numpy as np

from tedm_cli.arrays import FloatArray, IntArray
from tedm_cli.config.model.file import ModelConfig
from tedm_cli.config.model.superelement import Superelement, load_superelements
from tedm_cli.config.project import Project
from tedm_cli.errors import ConfigError, InputError
from tedm_cli.fem.superelement import ReducedMatrices, made_free, require_stiffness
from tedm_cli.nastran.geometry import ModelGeometry, rows_of
from tedm_cli.nastran.loads.unit_loads import UnitLoad
from tedm_cli.nastran.positions import basis_at
from tedm_cli.nastran.superelements.files import MatrixNames, read_matrices


@dataclass(frozen=True, eq=False)
class Reduced:
    """A superelement on a deck: its matrices over the interface alone, in the units of the deck, and the rows [b] and
    displacement frames [b, 3, 3] (columns) of its interface grids."""

    given: Superelement
    matrices: ReducedMatrices
    rows: IntArray
    frame: FloatArray


def reduced_on(project: Project, config: ModelConfig, geometry: ModelGeometry) -> list[Reduced]:
    """The superelements that the configuration names, with their checks.

    Raises
    ------
    ConfigError : an interface grid that the deck does not have.
    InputError : what `load_superelements`, `read_matrices`, `require_stiffness` and `made_free` refuse.
    """
    out = []
    for number, given in enumerate(load_superelements(project, config.superelement)):
        absent = [i for i in given.interface.tolist() if i not in geometry.grid_id]
        if absent:
            fact = f"the deck has no grid {absent[0]} ({len(absent)} of {len(given.interface)} are missing)"
            raise ConfigError([(f"superelement[{number}].interface", fact)], where=str(project.model))
        out.append(_reduced(given, geometry))
    return out


def _reduced(given: Superelement, geometry: ModelGeometry) -> Reduced:
    table, rows = given.table, np.searchsorted(geometry.grid_id, given.interface)
    names = MatrixNames(table.stiffness, table.loads, table.recovery, table.thermal_recovery)
    read = read_matrices(given.matrices, names, given.interface, len(given.area), given.node)
    boundary, length = 6 * len(rows), geometry.units.length_m
    frame = np.array([
        basis_at(geometry.frames, int(geometry.displacement_frame[row]), geometry.position_m[row]).T for row in rows
    ])  # fmt: skip
    try:
        require_stiffness(read.stiffness)
        matrices = read.without_internal(boundary)
        if not table.grounded:
            matrices = made_free(
                matrices, geometry.position_m[rows] / length, frame, given.node, given.position / length
            )
    except InputError as error:
        raise InputError(error.fact, where=str(given.matrices), hint=error.hint) from error
    return Reduced(given, matrices, rows, frame)


def require_own_areas(reduced: Sequence[Reduced], names: Collection[str], where: str) -> None:
    """Refuse areas of superelements that the deck has too, unless they are said to be shared, and shared ones that it
    has not.

    Raises
    ------
    InputError : the first of these.
    """
    known = {name.upper() for name in names}
    for one in reduced:
        name = one.given.table.name
        for area in one.given.own:
            if area.upper() in known:
                raise InputError(
                    f"area '{area}' of superelement '{name}' is one of the deck already",
                    where=where,
                    hint="rename it; or list it in shared, where one area is at both sides of the interface",
                )
        for area in one.given.table.shared:
            if area.upper() not in known:
                raise InputError(f"the deck has no area '{area}', which superelement '{name}' shares", where=where)


@dataclass(frozen=True, eq=False)
class Recovery:
    """Motions of grids with mass [r] of one superelement, SI and basic frame.

    rows : [r], in the deck. by_motion : [6 r, 6 b]. by_area : [6 r, k]. column : of an area in upper case.
    """

    rows: IntArray
    interface: IntArray
    frame: FloatArray
    by_motion: FloatArray
    by_area: FloatArray
    column: dict[str, int]

    @classmethod
    def of(cls, one: Reduced, geometry: ModelGeometry) -> Recovery:
        """On a deck that has the grids, with their masses.

        Raises
        ------
        InputError : a grid with mass that the deck does not have.
        """
        given = one.given
        where = f"{geometry.files[0]}: superelement '{given.table.name}'"
        rows = rows_of(geometry.grid_id, given.node, where=where, what="its list of masses")
        off = np.linalg.norm(geometry.position_m[rows] - given.position, axis=1)
        if off.max(initial=0.0) > 1e-6 * max(1.0, float(np.abs(given.position).max(initial=0.0))):
            worst = int(off.argmax())
            raise InputError(
                f"grid {given.node[worst]} is {off[worst]:.3g} m away from where the list of masses has it",
                where=where,
                hint="write and solve the deck again",
            )
        by_motion, by_area = one.matrices.in_metres(geometry.units.length_m)
        column = {area.upper(): n for n, area in enumerate(given.area)}
        return cls(rows, one.rows, one.frame, by_motion, by_area, column)

    def put_into(
        self, labels: Sequence[str], load_K: float, translation: FloatArray, rotation: FloatArray, *, single: bool
    ) -> None:
        """Write the motions of the grids into those of all grids [N, 3], under a step of `load_K` on some areas.

        They have the digits that the results have, where these are of `single` precision.
        """
        turn = self.frame.transpose(0, 2, 1)
        a = np.concatenate([
            np.einsum("bij,bj->bi", turn, values[self.interface]) for values in (translation, rotation)
        ], axis=1)  # fmt: skip
        motion = self.by_motion @ a.reshape(-1)
        for label in labels:
            if (n := self.column.get(label.upper())) is not None:
                motion += load_K * self.by_area[:, n]
        six = (motion.astype(np.float32) if single else motion).reshape(-1, 6)
        translation[self.rows], rotation[self.rows] = six[:, :3], six[:, 3:]


@dataclass(frozen=True, eq=False)
class AreasElsewhere:
    """Areas of superelements, by name in upper case.

    own, names : those that the deck does not have. centroid, mass, grid : of all of them, [3], m; kg; ids of the grids
    with mass.
    """

    own: frozenset[str]
    names: tuple[str, ...]
    centroid: dict[str, FloatArray]
    mass: dict[str, float]
    grid: dict[str, list[int]]

    @classmethod
    def of(cls, superelements: Sequence[Superelement]) -> AreasElsewhere:
        own = frozenset(name.upper() for one in superelements for name in one.own)
        centroid, mass, grid = {}, dict[str, float](), dict[str, list[int]]()
        for given in superelements:
            for name, place, kg in zip(given.area, given.centroid, given.area_mass.tolist(), strict=True):
                centroid[name.upper()] = place
                mass[name.upper()] = mass.get(name.upper(), 0.0) + kg
            for node, area in zip(given.node.tolist(), given.node_area, strict=True):
                if area and node not in given.interface:  # those of the interface are in areas of the deck
                    grid.setdefault(area, []).append(node)
        return cls(own, tuple(name for one in superelements for name in one.own), centroid, mass, grid)

    def require(self, labels: Collection[str], where: str) -> None:
        """`InputError` for an area that no subcase loads."""
        there = {label.upper() for label in labels}
        lacking = sorted(set(self.centroid) - there)
        if lacking:
            raise InputError(
                f"has no subcase of area {lacking[0]} of a superelement ({len(lacking)} are missing)",
                where=where,
                hint="write and solve the deck again",
            )

    def placed(self, labels: Collection[str], found: FloatArray) -> FloatArray:
        """Centroids [k, 3] of the areas of a deck, those that are elsewhere filled in."""
        names = [label.upper() for label in labels]
        given = [self.centroid[n] if n in self.own else c for n, c in zip(names, found, strict=True)]
        return np.array(given).reshape(-1, 3)

    def members(self, areas: Sequence[UnitLoad], grid_id: IntArray) -> list[IntArray]:
        """Rows of the grids of each area of a deck with grids `grid_id` [N], with what is elsewhere."""
        more = [np.array(self.grid.get(a.label.upper(), []), dtype=np.int64) for a in areas]
        return [np.union1d(a.rows, np.searchsorted(grid_id, ids)) for a, ids in zip(areas, more, strict=True)]

    def weighed(self, labels: Collection[str], found: FloatArray) -> FloatArray:
        """Masses [k] of the areas of a deck, with what is elsewhere."""
        return np.asarray(found + np.array([self.mass.get(label.upper(), 0.0) for label in labels]))
