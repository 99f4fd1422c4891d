"""Conductivity of the elements of a deck: by MAT4 of their materials, or as the configuration gives it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from tedm_cli import deck_units as u
from tedm_cli.errors import ConfigError, InputError
from tedm_cli.fem.conduction import ConductingMesh, has_conduction
from tedm_cli.nastran.bulk.columns import columns_of
from tedm_cli.nastran.geometry import ModelGeometry, id_list
from tedm_cli.nastran.units import units_of

_LAMINATES = ("PCOMP", "PCOMPG")


@dataclass(frozen=True, eq=False)
class Conductors:
    """The elements of a model as conductors, and remarks on their materials."""

    mesh: ConductingMesh
    notes: list[str]


def conductors(model: Any, geometry: ModelGeometry, configured: Mapping[int, float], where: str) -> Conductors:
    """All elements of a cross-referenced model with the conductivity of each.

    Solids, plates and lines conduct; those without thickness or section do not, nor springs, dampers and rigid
    elements. Laminates conduct along their plies.

    Parameters
    ----------
    configured : W/(m K), by id of a material. where : their file, for messages.

    Raises
    ------
    InputError : materials without MAT4 that are not configured either, with elements that have them.
    ConfigError : configured materials that the deck gives a MAT4, or that no conducting element has.
    """
    deck, e = str(geometry.files[0]), geometry.elements
    counts = np.diff(e.node_offset)
    card = np.array(e.type, dtype=str)
    solid = geometry.mesh.solid
    bulk = np.array([has_conduction(c, n) for c, n in zip(e.type, counts.tolist(), strict=True)], dtype=bool)
    bulk &= solid | (e.section > 0.0)
    table = _Table(model, configured)
    conductivity = np.zeros(len(e.id))
    alike, columns = columns_of(model).alike.number, columns_of(model).element
    group = alike[np.searchsorted(columns.id, e.id)]
    for number, first in zip(*np.unique(group[bulk], return_index=True), strict=True):
        rows = np.flatnonzero(bulk & (group == number))
        conductivity[rows] = table.of(model.elements[int(e.id[bulk][first])], e.id[rows].tolist())
    table.refuse(deck, where)
    mesh = ConductingMesh(
        position=geometry.position_m,
        element_id=e.id,
        card=card,
        node_offset=e.node_offset,
        node_index=e.node_index,
        section=e.section,
        conductivity=conductivity,
    )
    return Conductors(mesh, table.notes())


class _Table:
    """Conductivities of materials and properties, and which of them there are not."""

    def __init__(self, model: Any, configured: Mapping[int, float]) -> None:
        self._factor = units_of(model).factor(u.CONDUCTIVITY)
        self._cards = model.thermal_materials
        self._dependent = sorted({*getattr(model, "MATT4", {}), *getattr(model, "MATT5", {})})
        self._configured = configured
        self._known: dict[Any, float] = {}
        self._used: set[int] = set()
        self._lacking: dict[int, list[int]] = {}

    def of(self, element: Any, ids: list[int]) -> float:
        """Of an element, and of others (`ids`) that are alike, W/(m K): the mean over a laminate's thickness. 0 where a
        material has none (see `refuse`)."""
        prop = getattr(element, "pid_ref", None)
        holder = element if prop is None else prop
        if holder.type in _LAMINATES:
            plies = list(zip(holder.mids, holder.thicknesses, strict=True))  # a mirror image changes no mean
            whole = sum(float(t) for _, t in plies)
            return sum(self._material(int(mid), ids) * float(t) for mid, t in plies) / whole
        mid = getattr(holder, "mid1", None) or getattr(holder, "mid2", None) or getattr(holder, "mid", None)
        if mid is None:
            mid = holder.Mid()
        return self._material(int(mid), ids)

    def _material(self, mid: int, ids: list[int]) -> float:
        self._used.add(mid)
        found = self._known.get(mid)
        if found is None:
            found = self._known[mid] = self._found(mid)
        if not found:
            self._lacking.setdefault(mid, []).extend(ids)
        return found

    def _found(self, mid: int) -> float:
        if mid in self._configured:
            return float(self._configured[mid])
        card = self._cards.get(mid)
        if card is None:
            return 0.0
        if card.type == "MAT4":
            return self._factor * float(card.k or 0.0)
        straight, off = {card.kxx, card.kyy, card.kzz}, {card.kxy, card.kxz, card.kyz}
        isotropic = card.type == "MAT5" and len(straight) == 1 and not any(off)
        return self._factor * float(card.kxx or 0.0) if isotropic else 0.0

    def refuse(self, deck: str, where: str) -> None:
        """Raise what `conductors` says."""
        problems = []
        for mid in sorted(self._configured):
            at, card = f"map.conductivity_W_m_K.{mid}", self._cards.get(mid)
            if mid not in self._used:
                problems.append(
                    (at, f"no conducting element has the material {mid}; there are: {id_list(sorted(self._used))}")
                )
            elif card is not None and card.type == "MAT4":
                problems.append((at, f"{deck} has a MAT4 {mid} already: leave one of the two out"))
        if problems:
            raise ConfigError(problems, where=where)
        if self._lacking:
            listed = "; ".join(
                f"{self._why(mid)} (elements {id_list(sorted(ids), 4)})"
                for mid, ids in list(sorted(self._lacking.items()))[:6]
            )
            more = f"; and {len(self._lacking) - 6} more materials" if len(self._lacking) > 6 else ""
            raise InputError(
                f"elements without conductivity: {listed}{more}",
                where=deck,
                hint="give the materials a MAT4, or a number in [map.conductivity_W_m_K] by their ids",
            )

    def _why(self, mid: int) -> str:
        card = self._cards.get(mid)
        if card is None:
            return f"material {mid} has no MAT4"
        if card.type == "MAT4":
            return f"MAT4 {mid} has no positive K"
        return f"{card.type} {mid} conducts otherwise in each direction, which is not modelled"

    def notes(self) -> list[str]:
        """Remarks."""
        ids = [mid for mid in self._dependent if mid in self._used and mid not in self._configured]
        return [f"conductivity of materials {id_list(ids)} is that of MAT4, without MATT4"] if ids else []
