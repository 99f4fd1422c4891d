"""Clusters of grids that are each other's mirror image, where correlation cases pair areas by a symmetry plane."""

from __future__ import annotations

import numpy as np
from scipy.spatial import KDTree

from tedm_cli.adjoint.like_grids import like_grids
from tedm_cli.adjoint.temperature_field import FieldPoints
from tedm_cli.arrays import BoolArray, FloatArray, IntArray
from tedm_cli.symmetry_plane import SymmetryPlane

_NEAR = 1e-4  # of the extent of the points: how far an image may be off


def images(position: FloatArray, plane: SymmetryPlane, paired: BoolArray) -> IntArray | None:
    """The mirror image [n] of each of the `paired` points [n], -1 of the others; None where one has no image.

    Parameters
    ----------
    position : [n, 3], m, basic frame.
    """
    out, rows = np.full(len(position), -1), np.flatnonzero(paired)
    if rows.size:
        near = _NEAR * float(np.linalg.norm(np.ptp(position, axis=0)))
        distance, nearest = KDTree(position[rows]).query(plane.image(position[rows]))
        if distance.max() > near or not np.array_equal(nearest[nearest], np.arange(len(rows))):
            return None
        out[rows] = rows[nearest]
    return out


def mirrored_clusters(
    points: FieldPoints, pairs: IntArray, image: IntArray, plane: SymmetryPlane, count: int
) -> tuple[IntArray, IntArray, IntArray]:
    """Clusters as of `like_grids`, those with images made on one side for the outputs of both, and copied.

    Parameters
    ----------
    pairs : [p, 2], of points that may be joined. image : [n], of `images`.

    Returns
    -------
    Number [n] of the cluster of each point; its mirror image [k], -1 of clusters without; and the pairs [q, 2] of
    clusters that may be merged, each with its image.
    """
    n = len(image)
    has = image >= 0
    behind = has & (plane.distance(points.position) < 0.0) & (image != np.arange(n))
    side = np.where(behind, 2, np.where(image == np.arange(n), 1, 0))  # grids on the plane are apart from both sides
    ahead = np.flatnonzero(~behind)
    seen = points.sensitivity[:, np.where(has, image, np.arange(n))]
    both = FieldPoints(
        position=points.position[ahead],
        volume=points.volume[ahead],
        sensitivity=np.concatenate([points.sensitivity, seen])[:, ahead],
    )
    place = np.full(n, -1)
    place[ahead] = np.arange(len(ahead))
    close = pairs[side[pairs[:, 0]] == side[pairs[:, 1]]]
    close = place[close]
    found = like_grids(both, close[(close >= 0).all(axis=1)], count * len(ahead) // n)
    label = np.empty(n, dtype=np.int64)
    label[ahead] = found
    k = int(found.max(initial=-1)) + 1
    label[behind] = label[image[behind]] + k
    label = np.unique(label, return_inverse=True)[1]
    twin = np.full(int(label.max(initial=-1)) + 1, -1)
    twin[label[has]] = label[image[has]]
    merging = label[pairs]
    mirrored = merging[(twin[merging] >= 0).all(axis=1)]
    return label, twin, np.concatenate([merging, twin[mirrored]])
