"""The outer surface of a mesh: closed, outward, complete, whatever the elements are."""

from __future__ import annotations

from collections import Counter

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tedm_cli.fem.surface import Surface, outer_surface

# A brick as other solids on the same corners: two wedges, six tetrahedra about a diagonal, three pyramids.
SPLIT: dict[str, list[tuple[int, ...]]] = {
    "CHEXA": [tuple(range(8))],
    "CPENTA": [(0, 1, 2, 4, 5, 6), (0, 2, 3, 4, 6, 7)],
    "CTETRA": [(0, 1, 2, 6), (0, 2, 3, 6), (0, 3, 7, 6), (0, 7, 4, 6), (0, 4, 5, 6), (0, 5, 1, 6)],
    "CPYRAM": [(0, 1, 2, 3, 6), (0, 4, 5, 1, 6), (0, 3, 7, 4, 6)],
}


def bricks(n: int, m: int, k: int) -> tuple[np.ndarray, np.ndarray]:
    """Grid positions [N, 3] and corners [E, 8] of a block of n x m x k unit cubes."""
    ids = np.arange((n + 1) * (m + 1) * (k + 1)).reshape(n + 1, m + 1, k + 1)
    a, b = slice(None, -1), slice(1, None)
    corners = [(a, a, a), (b, a, a), (b, b, a), (a, b, a), (a, a, b), (b, a, b), (b, b, b), (a, b, b)]
    position = np.stack(np.meshgrid(*(np.arange(s + 1.0) for s in (n, m, k)), indexing="ij"), -1).reshape(-1, 3)
    return position, np.stack([ids[c].reshape(-1) for c in corners], axis=1)


def surface_of(elements: list[tuple[str, tuple[int, ...]]]) -> Surface:
    offset = np.cumsum([0, *(len(nodes) for _, nodes in elements)])
    return outer_surface([card for card, _ in elements], offset, np.array([n for _, nodes in elements for n in nodes]))


def solid(corners: np.ndarray, card: str) -> list[tuple[str, tuple[int, ...]]]:
    return [(card, tuple(brick[list(part)])) for brick in corners for part in SPLIT[card]]


def polygons(surface: Surface) -> list[list[int]]:
    return [list(dict.fromkeys(int(i) for i in face)) for face in surface.face]


def edges(surface: Surface) -> Counter[tuple[int, int]]:
    """Directed edges of the faces."""
    return Counter((p[i - 1], p[i]) for p in polygons(surface) for i in range(len(p)))


def euler(surface: Surface) -> int:
    """Corners - edges + faces."""
    faces = polygons(surface)
    return len({n for f in faces for n in f}) - len({frozenset(e) for e in edges(surface)}) + len(faces)


def enclosed(surface: Surface, position: np.ndarray) -> float:
    """Volume by the divergence theorem, over the triangles of the faces."""
    x = position[surface.face]
    total = 0.0
    for a, b, c in ((0, 1, 2), (0, 2, 3)):
        total += float(np.einsum("fi,fi->", x[:, a], np.cross(x[:, b], x[:, c])) / 6.0)
    return total


@settings(max_examples=20, deadline=None)
@given(size=st.tuples(*[st.integers(1, 4)] * 3))
@pytest.mark.parametrize(("card", "per_square"), [("CHEXA", 1), ("CTETRA", 2)])
def test_block(card: str, per_square: int, size: tuple[int, int, int]) -> None:
    """A block has 2 (nm + mk + kn) squares outside, is closed, a sphere, and encloses its volume from outside."""
    n, m, k = size
    position, corners = bricks(n, m, k)
    surface = surface_of(solid(corners, card))
    assert len(surface.face) == 2 * (n * m + m * k + k * n) * per_square
    directed = edges(surface)
    assert all(count == 1 and directed[b, a] == 1 for (a, b), count in directed.items())
    assert euler(surface) == 2
    assert enclosed(surface, position) == pytest.approx(n * m * k, rel=1e-12)
    assert surface.solid.all()


@pytest.mark.parametrize("card", ["CPENTA", "CPYRAM"])
def test_one_brick_in_parts_has_its_volume_and_is_closed(card: str) -> None:
    position, corners = bricks(1, 1, 1)
    surface = surface_of(solid(corners, card))
    directed = edges(surface)
    assert all(count == 1 and directed[b, a] == 1 for (a, b), count in directed.items())
    assert euler(surface) == 2
    assert enclosed(surface, position) == pytest.approx(1.0, rel=1e-12)


def test_hole_through_a_block_makes_a_torus() -> None:
    position, corners = bricks(3, 3, 1)
    surface = surface_of(solid(np.delete(corners, 4, axis=0), "CHEXA"))
    assert euler(surface) == 0
    assert enclosed(surface, position) == pytest.approx(8.0, rel=1e-12)


def test_solids_of_different_cards_share_their_faces() -> None:
    """A brick beside two wedges and a brick collapsed to a wedge: nothing of what they share is outside."""
    position, corners = bricks(3, 1, 1)
    a, b, c, d, e, f, g, h = corners[2]
    elements = [("CHEXA", tuple(corners[0])), *solid(corners[1:2], "CPENTA")]
    elements += [("CHEXA", (a, b, c, c, e, f, g, g)), ("CPENTA", (a, c, d, e, g, h))]
    surface = surface_of(elements)
    directed = edges(surface)
    assert all(count == 1 and directed[q, p] == 1 for (p, q), count in directed.items())
    assert euler(surface) == 2
    assert enclosed(surface, position) == pytest.approx(3.0, rel=1e-12)


def test_midside_nodes_change_nothing() -> None:
    _, corners = bricks(2, 1, 1)
    linear = surface_of(solid(corners, "CHEXA"))
    quadratic = surface_of([("CHEXA", (*nodes, *range(100, 112))) for nodes in map(tuple, corners)])
    np.testing.assert_array_equal(linear.face, quadratic.face)


@pytest.mark.parametrize(("n", "m"), [(1, 1), (3, 2)])
def test_plates_are_drawn_with_their_rim(n: int, m: int) -> None:
    ids = np.arange((n + 1) * (m + 1)).reshape(n + 1, m + 1)
    squares = np.stack([ids[:-1, :-1], ids[1:, :-1], ids[1:, 1:], ids[:-1, 1:]], -1).reshape(-1, 4)
    elements = [("CQUAD4", tuple(s)) for s in squares[:-1]]
    a, b, c, d = squares[-1]
    surface = surface_of([*elements, ("CTRIA3", (a, b, c)), ("CTRIA3", (a, c, d))])
    assert len(surface.face) == n * m + 1
    assert not surface.solid.any()
    assert len(surface.rim) == 2 * (n + m)
    assert euler(surface) == 1  # a disc


def test_lines_and_elements_without_a_shape() -> None:
    elements = [("CBAR", (0, 1)), ("CBUSH", (1, 2)), ("CELAS2", (3,)), ("CNOVEL", (0, 1, 2))]
    surface = surface_of(elements)
    assert surface.line.tolist() == [[0, 1], [1, 2]]
    assert not len(surface.face)
