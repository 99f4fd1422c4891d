"""A surface of triangles as it is given, checked to bound a solid."""

from __future__ import annotations

import numpy as np
import scipy

from tedm_cli.arrays import FloatArray, IntArray
from tedm_cli.errors import PhysicsError
from tedm_cli.gravity.bodies.crossing import crossing_pairs
from tedm_cli.gravity.bodies.polyhedron import Polyhedron

MOST_TRIANGLES = 200_000
_NAMED = 3
_STEP = 1e-6  # how far off a triangle its sides are looked at, over the square root of its area
_INSIDE, _ROUNDING = 4.0 * np.pi, 1e-3


def checked_polyhedron(triangles: FloatArray) -> Polyhedron:
    """The solid that triangles [t, 3, 3] (m) bound, numbered from 1 in messages as they come.

    Corners are joined where they are equal to the last bit. A surface that is wholly inside out is turned: nothing else
    can be meant. Shells inside a shell are cavities if they are oriented as such.

    Raises
    ------
    PhysicsError
        If the surface is open, has edges of more than two triangles, is oriented here one way and there the other, cuts
        through itself, or has shells inside out; names edges or triangles.
    """
    if not len(triangles) >= 4:
        raise PhysicsError(f"the surface has {len(triangles)} triangles; the least that bounds a solid is 4")
    if len(triangles) > MOST_TRIANGLES:
        raise PhysicsError(
            f"the surface has {len(triangles):,} triangles, more than {MOST_TRIANGLES:,}",
            hint="export it coarser: every source near the body is summed over all of them",
        )
    if not np.isfinite(triangles).all():
        raise PhysicsError(f"triangle {int(np.argmin(np.isfinite(triangles).all(axis=(1, 2)))) + 1} is not finite")
    corner, flat = np.unique(triangles.reshape(-1, 3) + 0.0, axis=0, return_inverse=True)
    triangle = flat.reshape(-1, 3).astype(np.int64)
    number = np.arange(len(triangle))
    kept = (triangle != np.roll(triangle, 1, axis=1)).all(axis=1)  # two corners in one: an edge, no triangle
    triangle, number = triangle[kept], number[kept]
    _check_edges(corner, triangle, number)
    if pairs := crossing_pairs(corner, triangle):
        named = ", ".join(f"{number[a] + 1} and {number[b] + 1}" for a, b in pairs[:_NAMED])
        more = ", and others" if len(pairs) > _NAMED else ""
        a = triangles[number[pairs[0][0]]].mean(axis=0)
        raise PhysicsError(
            f"the surface intersects itself: triangles {named}{more}; the first near {_place(a)}",
            hint="unite the solids before they are exported",
        )
    whole = Polyhedron(corner, triangle)
    if whole.volume_m3 < 0.0:
        triangle = np.ascontiguousarray(triangle[:, ::-1])
        whole = Polyhedron(corner, triangle)
    _check_shells(whole, number)
    return whole


def _check_edges(corner: FloatArray, triangle: IntArray, number: IntArray) -> None:
    directed = triangle[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)
    owner = np.repeat(number, 3)
    _, which, count = np.unique(np.sort(directed, axis=1), axis=0, return_inverse=True, return_counts=True)
    which = which.reshape(-1)
    if (count < 2).any():
        open_ = np.flatnonzero(count[which] < 2)
        named = "; ".join(
            f"of triangle {owner[e] + 1} from {_place(corner[directed[e, 0]])} to {_place(corner[directed[e, 1]])}"
            for e in open_[:_NAMED]
        )
        more = f"; and {open_.size - _NAMED} more" if open_.size > _NAMED else ""
        raise PhysicsError(
            f"the surface is open: {open_.size} edges belong to one triangle alone, {named}{more}",
            hint="export a closed solid; corners of neighbours must be equal to the last digit",
        )
    if (count > 2).any():
        e = int(np.flatnonzero(count[which] > 2)[0])
        raise PhysicsError(
            f"{count[which[e]]} triangles meet at one edge, from {_place(corner[directed[e, 0]])} to"
            f" {_place(corner[directed[e, 1]])} (triangle {owner[e] + 1})",
            hint="solids that touch along an edge must be united or moved apart",
        )
    upward = np.bincount(which, weights=np.where(directed[:, 0] < directed[:, 1], 1.0, -1.0))
    if upward.any():
        both = np.flatnonzero(which == int(np.argmax(upward != 0.0)))
        raise PhysicsError(
            f"triangles {owner[both[0]] + 1} and {owner[both[1]] + 1} have opposite orientations at their common edge",
            hint="order the corners of all triangles counter-clockwise, seen from outside",
        )


def _check_shells(whole: Polyhedron, number: IntArray) -> None:
    """Each shell must have the solid on its inner side and nothing on its outer."""
    from tedm_cli.gravity.bodies.polyhedron_form import enclosed_angle

    count = len(whole.triangle)
    graph = scipy.sparse.coo_array(
        (np.ones(3 * count), (np.repeat(np.arange(count), 3), whole.triangle.ravel())),
        shape=(count, len(whole.corner_m)),
    )
    shells, shell = scipy.sparse.csgraph.connected_components(graph @ graph.T, directed=False)
    if shells == 1:
        return
    surface = whole.surface()
    normal = np.cross(surface[:, 1] - surface[:, 0], surface[:, 2] - surface[:, 0])
    area = np.linalg.norm(normal, axis=1)
    for s in range(shells):
        members = np.flatnonzero(shell == s)
        t = members[area[members].argmax()]
        step = _STEP * np.sqrt(area[t]) * normal[t] / area[t]
        angle = np.empty(2)
        enclosed_angle(np.stack([surface[t].mean(axis=0) - step, surface[t].mean(axis=0) + step]), surface, angle)
        if abs(angle[0] - _INSIDE) > _ROUNDING or abs(angle[1]) > _ROUNDING:
            raise PhysicsError(
                f"the shell of {members.size} triangles with triangle {number[t] + 1} is inside out,"
                " or lies within another",
                hint="triangles of a cavity are counter-clockwise seen from it; solids must not contain each other",
            )


def _place(point: FloatArray) -> str:
    return "(" + ", ".join(f"{c:.6g}" for c in point) + ") m"
