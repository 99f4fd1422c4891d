"""The picture of the model: what is in front is seen, each corner has its colour, neighbours differ."""

from __future__ import annotations

from itertools import combinations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tedm_cli.figures.drawing.colours import LEFT_OUT, area_colours
from tedm_cli.figures.drawing.raster import BACKGROUND, Raster, outlines, rasterise

W, H = 60, 40
# Simulated deuteranopia in linear RGB (Machado, Oliveira and Fernandes 2009, severity 1).
DEUTERANOPIA = np.array(
    [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.01182, 0.04294, 0.968881]]
)


def raster(corner: np.ndarray, label: np.ndarray, half: bool = False) -> Raster:
    label = np.broadcast_to(np.asarray(label).reshape(len(corner), -1), (len(corner), 3))
    return rasterise(corner, label, np.full(len(corner), half), np.ones(len(corner)), W, H)


coordinate = st.floats(-10, 70, allow_nan=False, width=32)
triangles = st.lists(st.lists(coordinate, min_size=9, max_size=9), min_size=1, max_size=6)


@settings(max_examples=60, deadline=None)
@given(triangles)
def test_every_pixel_shows_the_nearest_triangle(data: list[list[float]]) -> None:
    """Against a loop over pixels and triangles."""
    corner = np.array(data).reshape(-1, 3, 3)
    found = raster(corner, np.arange(len(corner)))
    for row, column in ((0, 0), (H - 1, W - 1), (20, 30), (7, 44), (33, 12), (15, 5)):
        p = np.array([column + 0.5, H - 1 - row + 0.5])
        best = -np.inf
        edge_on = False
        for x in corner:
            m = np.column_stack([x[1, :2] - x[0, :2], x[2, :2] - x[0, :2]])
            if abs(np.linalg.det(m)) < 1e-6:
                edge_on = True
                continue
            b, c = np.linalg.solve(m, p - x[0, :2])
            if abs(min(b, c, 1 - b - c)) < 1e-6:
                edge_on = True
            elif min(b, c, 1 - b - c) > 0:
                best = max(best, x[0, 2] * (1 - b - c) + x[1, 2] * b + x[2, 2] * c)
        if not edge_on:
            assert found.depth[row, column] == pytest.approx(best, rel=1e-6, abs=1e-4)
            assert (found.label[row, column] == BACKGROUND) == (best == -np.inf)


def test_area_in_pixels_and_order() -> None:
    """A square behind a smaller one: pixels count their areas, in whichever order they are drawn."""

    def square(low: float, high: float, z: float) -> list[list[list[float]]]:
        a, b, c, d = ([x, y, z] for x, y in ((low, low), (high, low), (high, high), (low, high)))
        return [[b, c, a], [d, a, c]]

    corner = np.array(square(5, 35, 0.0) + square(10, 20, 1.0))
    label = np.array([0, 0, 1, 1])
    for order in ([0, 1, 2, 3], [3, 2, 1, 0]):
        found = raster(corner[order], label[order])
        assert [(found.label == i).sum() for i in (0, 1)] == [900 - 100, 100]
    border, step = outlines(raster(corner, label), jump=0.5)
    assert border.sum() == 2 * (30 + 30) - 1 + 2 * (10 + 10) - 1  # the first corner of each is in two sides
    assert step[20:30, 10].all()


def test_corners_share_a_square_in_quarters() -> None:
    a, b, c, d = ([5.0, 5.0, 0.0], [35.0, 5.0, 0.0], [35.0, 35.0, 0.0], [5.0, 35.0, 0.0])
    corner, label = np.array([[b, c, a], [d, a, c]]), np.array([[1, 2, 0], [3, 0, 2]])
    found = raster(corner, label, half=True).label[5:35, 5:35]
    wanted = np.kron(np.array([[3, 2], [0, 1]]), np.ones((15, 15), dtype=int))
    assert (found != wanted).sum() <= 15  # on the diagonal


def lightness(rgb: np.ndarray) -> np.ndarray:
    """CIE L* of sRGB colours."""
    linear = np.where(rgb <= 0.04045, rgb / 12.92, ((rgb + 0.055) / 1.055) ** 2.4)
    y = linear @ np.array([0.2126, 0.7152, 0.0722])
    return 116 * np.cbrt(y) - 16


@given(
    sizes=st.lists(st.integers(1, 12), min_size=1, max_size=7),
    seed=st.integers(0, 99),
)
def test_neighbours_of_a_group_differ_in_lightness(sizes: list[int], seed: int) -> None:
    """Wherever the map is planar enough (here: each has at most four neighbours), as anyone sees it."""
    group = [f"g{i}" for i, n in enumerate(sizes) for _ in range(n)]
    order = np.random.default_rng(seed).permutation(len(group))
    ring = [(order[i], order[(i + s) % len(order)]) for i in range(len(order)) for s in (1, 2)]
    pairs = {(int(min(p)), int(max(p))) for p in ring if p[0] != p[1]}
    colours = area_colours(group, pairs)
    for a, b in pairs:
        if group[a] == group[b]:
            assert abs(lightness(colours[a]) - lightness(colours[b])) > 2.0
        else:
            assert not np.array_equal(colours[a], colours[b])
    assert (np.abs(colours - LEFT_OUT).max(axis=1) > 0.2).all()


def test_groups_differ_without_red_and_green() -> None:
    colours = area_colours([f"g{i}" for i in range(8)], set())
    linear = np.where(colours <= 0.04045, colours / 12.92, ((colours + 0.055) / 1.055) ** 2.4)
    seen = np.clip(linear @ DEUTERANOPIA.T, 0, 1)
    xyz = seen @ np.array([[0.4124, 0.2126, 0.0193], [0.3576, 0.7152, 0.1192], [0.1805, 0.0722, 0.9505]])
    f = np.cbrt(xyz / np.array([0.9505, 1.0, 1.089]))
    lab = np.column_stack([116 * f[:, 1] - 16, 500 * (f[:, 0] - f[:, 1]), 200 * (f[:, 1] - f[:, 2])])
    assert min(np.linalg.norm(a - b) for a, b in combinations(lab, 2)) > 10.0
