"""Independent checks of masses: pyNastran's own element masses on a sample, and Nastran's grid point weight table."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from tedm_cli.arrays import FloatArray
from tedm_cli.deck_units import INERTIA, LENGTH, MASS, SI, DeckUnits
from tedm_cli.errors import InputError
from tedm_cli.fem.shapes import CARDS, corner_count
from tedm_cli.files.record_tables import is_hdf5
from tedm_cli.nastran.geometry import ModelGeometry, id_list
from tedm_cli.nastran.op2.walk import walked
from tedm_cli.nastran.parameter_values import number_parameter

_PIECE = 1 << 22  # bytes of a file that are looked through at once
_SAMPLE = 50  # elements of each card and property
# pyNastran takes warped plates as flat, and sides as straight where there are midside nodes. What differs by more than
# this in the sum of a sample is no matter of shape.
_WARPED, _CURVED = 0.05, 0.25
_FACES = {
    "CTETRA": ((0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3)),
    "CPYRAM": ((0, 3, 2, 1), (0, 1, 4), (1, 2, 4), (2, 3, 4), (3, 0, 4)),
    "CPENTA": ((0, 2, 1), (3, 4, 5), (0, 1, 4, 3), (1, 2, 5, 4), (2, 0, 3, 5)),
    "CHEXA": ((0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)),
}


@dataclass(frozen=True)
class SampleCheck:
    """Number of elements compared; largest relative difference in the sum of a card and property, and which that is."""

    elements: int
    largest: float
    worst: str


def check_sample(model: Any, geometry: ModelGeometry) -> SampleCheck:
    """Compare up to 50 elements of every card and property, evenly chosen, with pyNastran's densities and masses.

    Parameters
    ----------
    model : cross-referenced pyNastran model.

    Raises
    ------
    InputError : the masses of a sample differ by more than shape can explain.
    """
    e = geometry.elements
    factor = geometry.units.mass_kg * number_parameter(model, "WTMASS", 1.0, str(geometry.files[0]))
    cards, card_of = np.unique(e.type, return_inverse=True)
    most = int(e.property_id.max(initial=0)) + 1
    kinds, kind = np.unique(most * card_of + e.property_id, return_inverse=True)
    names = [f"{cards[key // most]}:{key % most}" for key in kinds.tolist()]
    kind = np.argsort(np.argsort(names))[kind]  # in the order of their names
    order = np.argsort(kind, kind="stable")
    compared, largest, worst = 0, 0.0, ""
    for rows in np.split(order, np.flatnonzero(np.diff(kind[order])) + 1):
        chosen = rows[np.unique(np.linspace(0, len(rows) - 1, _SAMPLE).astype(int))]
        card = e.type[rows[0]]
        if card not in CARDS and card not in _FACES:  # springs and the like, whose mass pyNastran does not know
            continue
        # pyNastran measures bars between their grids
        chosen = chosen[[not _has_offsets(model.elements[int(i)]) for i in e.id[chosen]]]
        elements = [model.elements[int(i)] for i in e.id[chosen]]
        if not elements:
            continue
        theirs = np.array([_reference(x) for x in elements]) * factor
        ours = e.mass_kg[chosen] - e.added_kg[chosen]
        compared += len(chosen)
        scale = float(theirs.sum())
        difference = abs(float(ours.sum()) - scale) / scale if scale else float(ours.any())
        name = f"{card} of property {e.property_id[chosen[0]]}"
        corners = corner_count(card)
        curved = corners is not None and e.node_offset[chosen[0] + 1] - e.node_offset[chosen[0]] > corners
        if difference > (_CURVED if curved else _WARPED):
            raise InputError(
                f"{len(chosen)} {name} have {ours.sum():.9g} kg, pyNastran finds {scale:.9g} kg:"
                f" elements {id_list(e.id[chosen])}",
                where=str(geometry.files[0]),
                hint="are these elements badly warped or curved?",
            )
        if difference > largest or not worst:
            largest, worst = difference, name
    return SampleCheck(compared, largest, worst)


def _has_offsets(element: Any) -> bool:
    return any(np.any(getattr(element, end, 0.0)) for end in ("wa", "wb"))


def _reference(element: Any) -> float:
    """Mass of an element by pyNastran; of a solid, its density there times the volume within its corners."""
    faces = _FACES.get(element.type)
    if faces is None:
        return float(element.Mass())
    return float(element.Rho()) * _volume(
        np.array([n.get_position() for n in element.nodes_ref if n is not None]), faces
    )


def _volume(corner: FloatArray, faces: tuple[tuple[int, ...], ...]) -> float:
    """Volume by the divergence theorem, with each face a fan about the mean of its corners.

    A bilinear face and its fan enclose the same volume: its middle lies half way between the two diagonals.
    """
    total = 0.0
    x = corner - corner[0]
    for face in faces:
        middle = x[list(face)].mean(axis=0)
        for a, b in zip(face, face[1:] + face[:1], strict=True):
            total += float(middle @ np.cross(x[a], x[b]))
    return abs(total) / 6.0


@dataclass(frozen=True)
class WeightTable:
    """A solver's rigid body masses (PARAM,GRDPNT), with PARAM,WTMASS in them or not, in SI and the basic frame.

    mass : [3], along x, y and z; centre : [3] of gravity; inertia : [3, 3] about it.
    """

    file: Path
    mass: FloatArray
    centre: FloatArray
    inertia: FloatArray


def weight_table(path: Path, place_of: Callable[[int], FloatArray], units: DeckUnits = SI) -> WeightTable | None:
    """The grid point weight table of an OP2 (MSC, NX, MYSTRAN), or None where it holds none; HDF5 is not asked for one.

    Only its first part is used, the 6 x 6 mass matrix of rigid motions about the grid of PARAM,GRDPNT (0: the origin):
    what follows in the table are axes and sums made of it, which the solvers write each in their own way.

    Parameters
    ----------
    place_of : position [3] of a grid by its id, m; the origin for 0.
    units : those of the file, which are those of its deck.

    Raises
    ------
    InputError : unreadable table.
    """
    if is_hdf5(path):
        return None
    if not _holds(path, b"OGPW"):
        return None
    with walked(path) as (walk, _):
        found = walk.weights
    if len(found) != 1:
        return None  # superelements have one each
    matrix = found[0].matrix
    mass = np.diag(matrix)[:3].copy()
    if not (np.isfinite(matrix).all() and (mass > 0.0).all()):
        raise InputError("its grid point weight table has no mass", where=str(path))
    # the block of a mass at w is -m [w]x
    moment = matrix[:3, 3:]
    w = np.array([moment[1, 2] - moment[2, 1], moment[2, 0] - moment[0, 2], moment[0, 1] - moment[1, 0]])
    w /= 2.0 * mass.mean()
    inertia = matrix[3:, 3:] - mass.mean() * (w @ w * np.eye(3) - np.multiply.outer(w, w))
    centre = place_of(found[0].grid) + units.factor(LENGTH) * w
    return WeightTable(path, units.factor(MASS) * mass, centre, units.factor(INERTIA) * inertia)


def _holds(path: Path, name: bytes) -> bool:
    """Whether a file has these bytes; read and not mapped, as mapped pages count as memory of the process."""
    piece, kept = bytearray(_PIECE), len(name) - 1
    view, start = memoryview(piece), 0
    with open(path, "rb", buffering=0) as stream:
        while size := stream.readinto(view[start:]):
            if piece.find(name, 0, start + size) >= 0:
                return True
            piece[:kept] = piece[max(0, start + size - kept) : start + size].rjust(kept, b"\0")
            start = kept
    return False
