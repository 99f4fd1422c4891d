"""Thermal areas: what the noise model has to know about each of them."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from tedm_cli.arrays import BoolArray, FloatArray
from tedm_cli.errors import InputError
from tedm_cli.symmetry_plane import BASIC_PLANE, SymmetryPlane

SHIELDS = ("inside", "outside")
SIDES = ("+y", "-y", "mid")
AXES = ("x", "y", "z")
WITHIN = tuple(f"gradient_{axis}" for axis in AXES)
UNITS = {"mean": "K", "gradient": "K/m", **dict.fromkeys(WITHIN, "K/m")}
"""Kinds of areas, and the unit of their temperatures: a mean temperature; a gradient through shells and bars at an
unchanged mean; a gradient within areas along x, y or z of the basic frame."""

GRADIENTS = " (gradients)"


@dataclass(frozen=True, eq=False)
class AreaTable:
    """The k thermal areas, in the order of the columns of every sensitivity matrix.

    Parameters
    ----------
    name : [k] str, unique.
    group : [k] str, the assembly the area belongs to (struts, flanges, IS1, IS2, OB for the LISA Technology Package).
    shield : [k] str, `inside` or `outside` of the thermal shield.
    side : [k] str, `+y`, `-y` or `mid` with respect to the symmetry plane of the structure.
    centroid_m : [k, 3], basic frame; only cases with mirror pairs ask for it.
    plane : the symmetry plane.
    kind : [k] str, a key of `UNITS`: what its temperature is. None given: all are means.

    Raises
    ------
    InputError : no areas, unequal lengths, a name used twice, or a shield, side or kind outside the values above.
    """

    name: NDArray[np.str_]
    group: NDArray[np.str_]
    shield: NDArray[np.str_]
    side: NDArray[np.str_]
    centroid_m: FloatArray | None = None
    plane: SymmetryPlane = field(default=BASIC_PLANE, kw_only=True)
    kind: NDArray[np.str_] = field(default_factory=lambda: np.zeros(0, dtype=np.str_), kw_only=True)

    def __post_init__(self) -> None:
        if not len(self.kind):
            object.__setattr__(self, "kind", np.full(len(self.name), "mean"))
        lengths = {key: len(getattr(self, key)) for key in ("name", "group", "shield", "side", "kind")}
        if len(set(lengths.values())) != 1 or not lengths["name"]:
            raise InputError(f"the columns of the thermal areas have lengths {lengths}", where="thermal areas")
        names, count = np.unique(self.name, return_counts=True)
        if count.max() > 1:
            raise InputError(f"area name {str(names[count.argmax()])!r} is used {count.max()} times", where="areas")
        columns = (("shield", self.shield, SHIELDS), ("side", self.side, SIDES), ("kind", self.kind, tuple(UNITS)))
        for key, values, known in columns:
            wrong = np.flatnonzero(~np.isin(values, known))
            if wrong.size:
                raise InputError(
                    f"{key} is {str(values[wrong[0]])!r}; known: {', '.join(known)}",
                    where=f"thermal area {self.name[wrong[0]]!s}",
                )

    def __len__(self) -> int:
        return len(self.name)

    @property
    def gradient(self) -> BoolArray:
        """[k]: the areas whose temperature is a gradient, K/m; the others' is a mean temperature, K."""
        return np.asarray(self.kind != "mean")

    @property
    def within(self) -> BoolArray:
        """[k]: the gradients within areas, which have no unit load and no displacements."""
        return np.isin(self.kind, WITHIN)

    @property
    def group_by_unit(self) -> NDArray[np.str_]:
        """[k]: the group, and of gradients a group apart, `IS1 (gradients)`: kelvins and K/m are not told together."""
        return np.array([group_in_unit(g, unit) for g, unit in zip(self.group.tolist(), self.unit, strict=True)])

    def only(self, mask: BoolArray) -> AreaTable:
        """The areas of the mask [k]."""
        centroid = None if self.centroid_m is None else self.centroid_m[mask]
        columns = (self.name[mask], self.group[mask], self.shield[mask], self.side[mask])
        return AreaTable(*columns, centroid, plane=self.plane, kind=self.kind[mask])

    def and_last(self, more: AreaTable) -> AreaTable:
        """These areas, and after them those of another table; of this one's symmetry plane."""
        names = ("name", "group", "shield", "side", "kind")
        name, group, shield, side, kind = (np.concatenate([getattr(self, n), getattr(more, n)]) for n in names)
        centroid = None
        if self.centroid_m is not None and more.centroid_m is not None:
            centroid = np.concatenate([self.centroid_m, more.centroid_m])
        return AreaTable(name, group, shield, side, centroid, plane=self.plane, kind=kind)

    @property
    def unit(self) -> list[str]:
        """[k]: the unit of each area's temperature, K or K/m; columns of sensitivity matrices are per this unit."""
        return [UNITS[kind] for kind in self.kind.tolist()]


def unit_of_group(group: str) -> str:
    """Unit of the temperatures of a group as `AreaTable.group_by_unit` has it."""
    return UNITS["gradient" if group.endswith(GRADIENTS) else "mean"]


def group_in_unit(group: str, unit: str) -> str:
    """The areas of a group whose temperatures have this unit, as `AreaTable.group_by_unit` has them."""
    return f"{group}{GRADIENTS}" if unit == UNITS["gradient"] else group
