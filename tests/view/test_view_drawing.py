"""What is drawn: coarser surfaces on grids of the model, and a bench whose bodies and beams move as they are traced."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace

import numpy as np
import pytest
from view_project import ROOT

from tedm_cli.config.optics.layout import load_layout
from tedm_cli.fem.surface import Surface, outer_surface
from tedm_cli.optics.bodies import body
from tedm_cli.optics.exaggerated import motion_of_elements, traced_bench
from tedm_cli.optics.layout import OpticalLayout
from tedm_cli.optics.trace import nominal_poses, rotated
from tedm_cli.view.bench import BEAMS, drawn_bench
from tedm_cli.view.mesh import DrawnMesh, drawn_mesh


def plate(
    nx: int, ny: int, nz: int, size: tuple[float, float, float]
) -> tuple[np.ndarray, list[str], np.ndarray, np.ndarray]:
    """Grids, cards, connectivity and its offsets: a block of solids, and a bar from its corner to a grid outside."""
    x, y, z = (np.linspace(0.0, s, n + 1) for s, n in zip(size, (nx, ny, nz), strict=True))
    grid = np.stack(np.meshgrid(x, y, z, indexing="ij"), axis=-1).reshape(-1, 3)
    place = np.arange(len(grid)).reshape(nx + 1, ny + 1, nz + 1)
    corners = [place[i : nx + i, j : ny + j, k : nz + k] for k in (0, 1) for i, j in ((0, 0), (1, 0), (1, 1), (0, 1))]
    hexa = np.stack(corners, axis=-1).reshape(-1, 8)
    bars = np.array([[0, len(grid)], [len(grid), len(grid) + 1]])
    position = np.concatenate([grid, [[-0.1, 0.0, 0.0], [-0.1005, 0.0, 0.0]]])
    offset = np.concatenate([8 * np.arange(len(hexa) + 1), 8 * len(hexa) + 2 * np.arange(1, 3)])
    return position, ["CHEXA"] * len(hexa) + ["CBAR"] * 2, np.concatenate([hexa.reshape(-1), bars.reshape(-1)]), offset


def drawn(most: int) -> tuple[np.ndarray, np.ndarray, DrawnMesh]:
    """A plate of two areas, drawn on at most so many grids."""
    position, card, index, offset = plate(40, 20, 2, (0.4, 0.2, 0.01))
    surface = outer_surface(card, offset, index)
    area = (position[:, 0] > 0.2).astype(np.int64)
    face_area = area[surface.face].max(axis=1)
    return position, area, drawn_mesh(position, surface, face_area, area[surface.line].max(axis=1), area, most)


def area_vectors(position: np.ndarray, mesh: DrawnMesh) -> np.ndarray:
    """Area times normal [F, 3] of the faces, a quadrilateral's by its diagonals."""
    p = position[mesh.grid][mesh.face]
    return 0.5 * np.cross(p[:, 2] - p[:, 0], p[:, 3] - p[:, 1])


def test_a_small_model_is_drawn_on_all_grids_of_its_surface() -> None:
    position, _, mesh = drawn(10_000)
    assert mesh.cell_m == 0.0
    inside = 39 * 19 * 1
    assert len(mesh.grid) == len(position) - inside
    assert len(mesh.face) == 2 * (40 * 20 + 40 * 2 + 20 * 2)
    assert np.abs(area_vectors(position, mesh).sum(axis=0)).max() < 1e-15


@pytest.mark.parametrize("most", [900, 300, 120])
def test_a_large_model_is_drawn_on_fewer_grids(most: int) -> None:
    """A closed surface stays closed and of the same size, its two sides stay apart, and areas keep to themselves."""
    position, area, mesh = drawn(most)
    assert 0.6 * most < len(mesh.grid) <= most
    assert mesh.cell_m > 0.0
    assert len(np.unique(mesh.face)) <= len(mesh.grid)
    vectors = area_vectors(position, mesh)
    assert np.abs(vectors.sum(axis=0)).max() < 2e-3 * 0.08
    for axis, of_side in ((2, 0.08), (1, 0.004)):
        there = vectors[:, axis][vectors[:, axis] > 0].sum()
        assert there == pytest.approx(of_side, rel=0.12)
    at = position[mesh.grid]
    np.testing.assert_array_equal(at.min(axis=0), position.min(axis=0))
    np.testing.assert_array_equal(at.max(axis=0), position.max(axis=0))
    assert set(at[:, 2]) <= set(position[:, 2])
    corner_area = area[mesh.grid][mesh.face]
    assert (mesh.face_area == corner_area.max(axis=1)).mean() > 0.95
    shapes = Counter(tuple(sorted(f)) for f in mesh.face.tolist())
    assert max(shapes.values()) == 1, "a face is drawn twice"
    assert all(len({*f}) >= 3 for f in mesh.face.tolist())


def test_faces_that_become_one_are_drawn_once() -> None:
    """Two plates on each other, with grids of their own: on half of the grids they are one plate."""
    x, y = (v.reshape(-1) for v in np.meshgrid(np.linspace(0, 1, 11), np.linspace(0, 1, 11), indexing="ij"))
    one = np.column_stack([x, y, 0 * x])
    place = np.arange(121).reshape(11, 11)
    face = np.stack([place[:-1, :-1], place[1:, :-1], place[1:, 1:], place[:-1, 1:]], axis=-1).reshape(-1, 4)
    faces = np.concatenate([face, face + 121])
    none = np.zeros((0, 2), dtype=np.int64)
    surface = Surface(faces, np.zeros(len(faces), dtype=bool), none, none, faces, none, none)
    area = np.zeros(242, dtype=np.int64)
    mesh = drawn_mesh(np.concatenate([one, one]), surface, area[: len(faces)], area[:0], area, 121)
    assert len(mesh.grid) == 121
    assert len(mesh.face) == len(mesh.face_area) == 100


def test_bars_keep_their_ends() -> None:
    position, _, mesh = drawn(120)
    ends = position[mesh.grid][mesh.line]
    np.testing.assert_array_equal(
        ends, np.array([[[0.0, 0.0, 0.0], [-0.1, 0.0, 0.0]], [[-0.1, 0.0, 0.0], [-0.1005, 0.0, 0.0]]])
    )


@pytest.fixture(scope="module")
def layout() -> OpticalLayout:
    return load_layout(ROOT / "configs" / "optics.toml")[1]


def test_bench_moves_as_bodies_and_beams_do(layout: OpticalLayout) -> None:
    """Bodies as rigid bodies, beams as the full trace through moved poses, for motions small enough to be linear."""
    rng = np.random.default_rng(1)
    n, k, small = len(layout.bench), 3, 1e-6
    nodes = np.array(layout.frame_origin_m) + layout.refs_m[[layout.index(e.name) for e in layout.bench]] @ layout.axes
    nodes += 1e-3 * rng.normal(size=nodes.shape)
    motion = rng.normal(size=(k, n, 6))
    bench = drawn_bench(layout, motion, nodes)
    assert set(bench.segment_beam) == {BEAMS.index("meas"), BEAMS.index("ref")}
    origin, axes = np.array(layout.frame_origin_m), layout.axes
    poses = nominal_poses(layout)
    for area in range(k):
        of_elements = motion_of_elements(layout, small * motion[area], nodes)
        first = 0
        for place, element in enumerate(layout.elements):
            if element.kind == "test_mass":
                continue
            before, ref = body(layout, place, poses, 12), poses.ref[place]
            after = ref + of_elements[place, :3] + rotated(before - ref, of_elements[place, 3:])
            part = slice(first, first + len(before))
            np.testing.assert_allclose(bench.position[part], origin + before @ axes, atol=1e-15)
            np.testing.assert_allclose(small * bench.motion[area, part], (after - before) @ axes, atol=20 * small**2)
            first += len(before)
        straight, bent = traced_bench(layout, poses), traced_bench(layout, poses.moved(of_elements))
        for number in range(len(layout.paths)):
            before, after = straight.beam(number), bent.beam(number)
            part = slice(first, first + len(before))
            np.testing.assert_allclose(bench.position[part], origin + before @ axes, atol=1e-12)
            np.testing.assert_allclose(small * bench.motion[area, part], (after - before) @ axes, atol=500 * small**2)
            assert np.abs(bench.motion[area, part]).max() > 0.1
            first += len(before)
        assert first == len(bench.position)


def test_a_bench_that_moves_as_one_carries_its_beams_along(layout: OpticalLayout) -> None:
    """Along z, to which the faces of the test masses are parallel: these stay, and nothing else does."""
    nodes = layout.refs_m[[layout.index(e.name) for e in layout.bench]] @ layout.axes + np.array(layout.frame_origin_m)
    motion = np.zeros((1, len(nodes), 6))
    motion[0, :, :3] = np.array([0.0, 0.0, 1.0]) @ layout.axes
    bench = drawn_bench(layout, motion, nodes)
    np.testing.assert_allclose(bench.motion[0], np.broadcast_to(motion[0, 0, :3], bench.motion[0].shape), atol=1e-12)


def test_a_layout_without_surfaces_has_no_bench_to_draw(layout: OpticalLayout) -> None:
    bench = drawn_bench(replace(layout, has_geometry=False), np.zeros((4, len(layout.bench), 6)), np.zeros((0, 3)))
    assert bench.position.shape == (0, 3)
    assert bench.motion.shape == (4, 0, 3)
    assert len(bench.face) == len(bench.segment) == 0
