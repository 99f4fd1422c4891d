"""The loads of a configuration as load cases of a structure."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tedm_cli.adjoint.materials import MaterialUse
from tedm_cli.areas.selection import Selector
from tedm_cli.arrays import BoolArray, FloatArray, IntArray
from tedm_cli.config.loads import INTERFACE, FootTable, LoadsConfig, MoistureReleaseTable
from tedm_cli.config.model.areas import id_ranges
from tedm_cli.contracts.spec import MOTIONS
from tedm_cli.errors import ConfigError
from tedm_cli.fem.structure import LoadCase, OnFreedoms, Structure
from tedm_cli.fem.supports import carried
from tedm_cli.fem.swelling import added, swelling_force
from tedm_cli.nastran.geometry import id_list
from tedm_cli.nastran.membership import Membership

_MOST_SUPPORTS = 100  # each has up to six motions, and every one of them a column of all grids


@dataclass(frozen=True, eq=False)
class Column:
    """One load: its kind and unit as in loads.h5, the foot that moves ("" of a release), and its case."""

    kind: str
    unit: str
    foot: str
    case: LoadCase

    @property
    def name(self) -> str:
        return self.case.label


def columns(
    config: LoadsConfig, structure: Structure, members: Membership, use: MaterialUse, where: Path
) -> list[Column]:
    """Motions of each foot, those of all supports as one where there are feet, then releases.

    Raises
    ------
    ConfigError : grids, sets, frames or materials that the deck has not; a foot that the deck does not hold, or not in
        a motion that is asked for; supports in two feet. All of it at once.
    """
    work = _Work(structure, members, use)
    for number, foot in enumerate(config.foot):
        if not foot.each_support:
            work.foot(f"foot[{number}]", foot)
    for number, foot in enumerate(config.foot):
        if foot.each_support:
            work.each(f"foot[{number}]", foot)
    if config.foot:
        work.interface()
    for gravity in config.gravity_release:
        work.add("gravity_release", "1", "", gravity.name, acceleration=-np.array(gravity.ground_m_s2))
    for number, moisture in enumerate(config.moisture_release):
        work.moisture(f"moisture_release[{number}]", moisture)
    if work.problems:
        raise ConfigError(work.problems, where=str(where))
    names = Counter(column.name.upper() for column in work.found)
    twice = [("", f"two loads are called {name}") for name, number in names.items() if number > 1]
    if twice:  # a release may have the name of a foot's motion
        raise ConfigError(twice, where=str(where), hint="the motions of a foot are NAME_ux to NAME_rz")
    return work.found


class _Work:
    """The columns as they are found; problems with their places in the configuration."""

    def __init__(self, structure: Structure, members: Membership, use: MaterialUse) -> None:
        self.structure, self.members, self.use = structure, members, use
        self.problems: list[tuple[str, str]] = []
        self.found: list[Column] = []
        self.owner: dict[int, str] = {}

    @property
    def held(self) -> IntArray:
        """Rows of the grids that constraints hold in any component."""
        return np.unique(self.structure.spc_grid)

    def add(
        self,
        kind: str,
        unit: str,
        foot: str,
        name: str,
        *,
        force: OnFreedoms | None = None,
        acceleration: FloatArray | None = None,
        enforced: OnFreedoms | None = None,
    ) -> None:
        case = LoadCase(id=len(self.found) + 1, label=name, force=force, acceleration=acceleration, enforced=enforced)
        self.found.append(Column(kind, unit, foot, case))

    def foot(self, at: str, table: FootTable) -> None:
        before = len(self.problems)
        rows = self.held[self._selected(at, table)[self.held]]
        if len(self.problems) > before:
            return
        if not rows.size:
            held = id_list(self.structure.grid_id[self.held])
            self.problems.append((at, f"foot {table.name} has no grid that the deck holds; it holds {held}"))
            return
        for row in rows.tolist():
            other = self.owner.setdefault(row, table.name)
            if other != table.name:
                grid = self.structure.grid_id[row]
                self.problems.append((at, f"grid {grid} is of foot {other} already"))
        about = self.structure.position[rows].mean(axis=0) if table.about_m is None else np.array(table.about_m)
        self._motions(at, table.name, rows, about, table.motions)

    def each(self, at: str, table: FootTable) -> None:
        """A foot of every support that is of no foot yet."""
        rows = [row for row in self.held.tolist() if row not in self.owner]
        if not rows:
            self.problems.append((at, "the deck holds no grid that is not of a foot already"))
        if len(rows) > _MOST_SUPPORTS:
            few = f"at most {_MOST_SUPPORTS} may be feet of their own: select feet by box"
            self.problems.append((at, f"the deck holds {len(rows)} more grids, and {few}"))
            return
        for row in rows:
            name = f"{table.name}_{self.structure.grid_id[row]}"
            self.owner[row] = name
            self._motions(at, name, np.array([row]), self.structure.position[row], table.motions)

    def interface(self) -> None:
        about = self.structure.position[self.held].mean(axis=0)
        self._motions("foot", INTERFACE, self.held, about, None)

    def _motions(self, at: str, name: str, rows: IntArray, about: FloatArray, wanted: Sequence[str] | None) -> None:
        for number, motion in enumerate(MOTIONS):
            if wanted is not None and motion not in wanted:
                continue
            enforced = carried(self.structure, rows, about, number)
            if enforced.dof.size:
                self.add("motion", "m" if number < 3 else "rad", name, f"{name}_{motion}", enforced=enforced)
            elif wanted is not None:
                self.problems.append((f"{at}.motions", f"the supports of foot {name} are free in {motion}"))

    def _selected(self, at: str, table: FootTable) -> BoolArray:
        """Grids [N] that a foot names."""
        m = self.members
        selector = Selector(m, at, self.problems, [])
        if table.box is not None:
            return selector.inside([table.box], f"{at}.box", m.position_m)
        if table.set is not None:
            return selector.sets(table.set, f"{at}.set", table.name)[0]
        chosen = np.zeros(len(m.grid_id), dtype=bool)
        for low, high in id_ranges(table.grid):
            found = (m.grid_id >= low) & (m.grid_id <= high)
            if not found.any():
                text = f"{low}" if low == high else f"{low}:{high}"
                held = id_list(self.structure.grid_id[self.held])
                self.problems.append((f"{at}.grid", f"the deck has no grid {text}; it holds {held}"))
            chosen |= found
        return chosen

    def moisture(self, at: str, table: MoistureReleaseTable) -> None:
        forces = []
        for number, swelling in enumerate(table.swelling):
            for low, high in id_ranges(swelling.material):
                ids = self.use.material_id
                rows = np.flatnonzero((ids >= low) & (ids <= high))
                if not rows.size:
                    text = f"{low}" if low == high else f"{low}:{high}"
                    fact = f"no element has the material {text}; there are: {id_list(ids)}"
                    self.problems.append((f"{at}.swelling[{number}].material", fact))
                elements = self.use.element_id[np.isin(self.use.law[:, 0], rows)]
                strain = swelling.expansion_per_percent * swelling.change_percent
                if elements.size:
                    forces.append(swelling_force(self.structure, elements, strain))
        if forces:
            self.add("moisture_release", "1", "", table.name, force=added(*forces))
