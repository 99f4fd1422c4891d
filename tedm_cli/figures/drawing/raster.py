"""Hidden surfaces by a depth buffer: labelled triangles to an image of labels. Arrays only."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tedm_cli.arrays import BoolArray, FloatArray, IntArray

BACKGROUND = -1
_CANDIDATES = 1_000_000  # pixels looked at in one go
_STEP = 1.3
_EDGE = 1e-9  # of an area coordinate: no gap between neighbours


@dataclass(frozen=True, eq=False)
class Raster:
    """What is seen at each pixel, rows from the top: label [H, W], shade [H, W], depth [H, W] (-inf: nothing)."""

    label: IntArray
    shade: FloatArray
    depth: FloatArray


def rasterise(
    corner: FloatArray, label: IntArray, half: BoolArray, shade: FloatArray, width: int, height: int
) -> Raster:
    """Nearest triangle at the centre of every pixel.

    Parameters
    ----------
    corner : [T, 3, 3], pixels to the right, pixels upwards, and depth towards the viewer.
    label : [T, 3], of each corner; a pixel shows that of the nearest corner, by area coordinates.
    half : [T], triangles that are half a quadrilateral, cut from the second corner to the third: nearest in the
        coordinates of the quadrilateral, so that both halves agree.
    shade : [T].
    """
    image = np.full(width * height, BACKGROUND, dtype=np.int64)
    light = np.ones(width * height)
    depth = np.full(width * height, -np.inf)
    edge1, edge2 = corner[:, 1, :2] - corner[:, 0, :2], corner[:, 2, :2] - corner[:, 0, :2]
    doubled = edge1[:, 0] * edge2[:, 1] - edge1[:, 1] * edge2[:, 0]
    low = np.maximum(np.floor(corner[:, :, :2].min(axis=1)).astype(np.int64), 0)
    high = np.minimum(np.ceil(corner[:, :, :2].max(axis=1)).astype(np.int64), (width, height))
    seen = np.flatnonzero((np.abs(doubled) > 1e-9) & (high > low).all(axis=1))  # neither edge-on nor outside
    # Triangles with frames of about one size are looked at together.
    spans = np.ceil(_STEP ** np.ceil(np.log(high[seen] - low[seen]) / np.log(_STEP))).astype(np.int64)
    for span in np.unique(spans, axis=0):
        members = seen[(spans == span).all(axis=1)]
        chunk = max(1, _CANDIDATES // int(span.prod()))
        for start in range(0, len(members), chunk):
            t = members[start : start + chunk]
            x = low[t, 0, None, None] + np.arange(span[0])[None, :, None]
            y = low[t, 1, None, None] + np.arange(span[1])[None, None, :]
            dx, dy = x + 0.5 - corner[t, 0, 0, None, None], y + 0.5 - corner[t, 0, 1, None, None]
            per = 1.0 / doubled[t, None, None]
            b = (dx * edge2[t, 1, None, None] - dy * edge2[t, 0, None, None]) * per
            c = (dy * edge1[t, 0, None, None] - dx * edge1[t, 1, None, None]) * per
            inside = (b >= -_EDGE) & (c >= -_EDGE) & (b + c <= 1.0 + _EDGE) & (x < width) & (y < height)
            row, i, j = np.nonzero(inside)
            b, c = b[row, i, j], c[row, i, j]
            row = t[row]
            z = corner[row, 0, 2] * (1.0 - b - c) + corner[row, 1, 2] * b + corner[row, 2, 2] * c
            place = (height - 1 - low[row, 1] - j) * width + low[row, 0] + i
            np.maximum.at(depth, place, z)
            new = z == depth[place]
            place, row, b, c = place[new], row[new], b[new], c[new]
            nearest = np.argmax([np.where(half[row], 0.5, 1.0 - b - c), b, c], axis=0)
            image[place] = label[row, nearest]
            light[place] = shade[row]
    shape = (height, width)
    return Raster(image.reshape(shape), light.reshape(shape), depth.reshape(shape))


def outlines(raster: Raster, jump: float) -> tuple[BoolArray, BoolArray]:
    """Pixels on the border of two labels, and pixels where the depth breaks by more than `jump` (of its unit)."""
    label = raster.label
    border = np.zeros(label.shape, dtype=bool)
    border[:, 1:] |= label[:, 1:] != label[:, :-1]
    border[1:] |= label[1:] != label[:-1]
    depth = np.where(np.isfinite(raster.depth), raster.depth, 0.0)
    step = np.zeros(label.shape, dtype=bool)
    step[:, 1:-1] |= np.abs(depth[:, 2:] - 2.0 * depth[:, 1:-1] + depth[:, :-2]) > jump
    step[1:-1] |= np.abs(depth[2:] - 2.0 * depth[1:-1] + depth[:-2]) > jump
    return border, step & (label != BACKGROUND)
