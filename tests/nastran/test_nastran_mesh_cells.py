"""Elements of decks as VTK's cells: read back by VTK itself, which knows nothing of Nastran's order of nodes."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import meshio
import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from mass_decks import deck, read
from pyvista import CellType, UnstructuredGrid
from pyvista import read as read_vtk

from tedm_cli.exports.mesh import element_cells, label_of_cells
from tedm_cli.exports.vtu import MeshArray, Names, array_name, distinct, write_vtu
from tedm_cli.nastran.geometry import ModelGeometry, model_geometry
from tedm_cli.nastran.reading import read_deck

# Corners, and the edges of the midside nodes, in the order of the Quick Reference Guide.
HEXA = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)]
PENTA = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (0, 1, 1)]
TETRA = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]
PYRAM = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0.5, 0.5, 1)]
QUAD, TRIA = HEXA[:4], TETRA[:3]
HEXA_EDGES = "1-2 2-3 3-4 4-1 1-5 2-6 3-7 4-8 5-6 6-7 7-8 8-5"
PENTA_EDGES = "1-2 2-3 3-1 1-4 2-5 3-6 4-5 5-6 6-4"
TETRA_EDGES = "1-2 2-3 3-1 1-4 2-4 3-4"
# Card, property, corners, edges, VTK's cell and the size of the cell on these corners.
KINDS = [
    ("CHEXA", 1, HEXA, "", CellType.HEXAHEDRON, 1.0),
    ("CHEXA", 1, HEXA, HEXA_EDGES, CellType.QUADRATIC_HEXAHEDRON, 1.0),
    ("CPENTA", 1, PENTA, "", CellType.WEDGE, 0.5),
    ("CPENTA", 1, PENTA, PENTA_EDGES, CellType.QUADRATIC_WEDGE, 0.5),
    ("CTETRA", 1, TETRA, "", CellType.TETRA, 1 / 6),
    ("CTETRA", 1, TETRA, TETRA_EDGES, CellType.QUADRATIC_TETRA, 1 / 6),
    ("CPYRAM", 1, PYRAM, "", CellType.PYRAMID, 1 / 3),
    ("CQUAD4", 2, QUAD, "", CellType.QUAD, 1.0),
    ("CQUAD8", 2, QUAD, "1-2 2-3 3-4 4-1", CellType.QUADRATIC_QUAD, 1.0),
    ("CTRIA3", 2, TRIA, "", CellType.TRIANGLE, 0.5),
    ("CTRIA6", 2, TRIA, "1-2 2-3 3-1", CellType.QUADRATIC_TRIANGLE, 0.5),
]
TYPES = [kind[4].name.lower() for kind in KINDS]
# A sheared, turned and stretched frame: right-handed, so that what is positive stays so.
FRAME = np.array([[0.9, 0.2, -0.1], [-0.4, 1.1, 0.3], [0.2, -0.5, 1.4]])


def all_kinds(folder: Path, kinds: Sequence[tuple[str, int, Any, str, int, float]] = KINDS) -> ModelGeometry:
    """One element of each of the kinds, each on nodes of its own in `FRAME`, with straight sides."""
    grids: dict[int, tuple[float, float, float]] = {}
    cards = ["PSOLID,1,1", "PSHELL,2,1,0.01"]
    for number, (card, prop, corners, edges, _, _) in enumerate(kinds, start=1):
        at = np.array(corners, dtype=float) @ FRAME + [3.0 * number, 0.0, 0.0]
        middle = [(at[int(a) - 1] + at[int(b) - 1]) / 2 for a, b in (e.split("-") for e in edges.split())]
        ids = [100 * number + i for i in range(len(at) + len(middle))]
        grids |= {i: tuple(np.round(p, 9).tolist()) for i, p in zip(ids, [*at, *middle], strict=True)}
        fields = [card, number, prop, *ids]
        lines = [fields[:9], *(["", *fields[i : i + 8]] for i in range(9, len(fields), 8))]
        cards += [",".join(str(f) for f in line) for line in lines]
    return read(folder, deck("\n".join(cards), grids))


def written(folder: Path, geometry: ModelGeometry, on_points: Sequence[MeshArray] = ()) -> Path:
    e = geometry.elements
    cells, left = element_cells(e.type, e.node_offset, e.node_index)
    assert not left.size
    row = np.concatenate([c.row for c in cells])
    write_vtu(
        folder / "mesh.vtu", geometry.position_m, cells, on_points, [MeshArray("id", e.id[row], "1", "element id")], []
    )
    return folder / "mesh.vtu"


def read_grid(path: Path) -> UnstructuredGrid:
    grid = read_vtk(path)
    assert isinstance(grid, UnstructuredGrid)
    return grid


@pytest.fixture(scope="module")
def kinds(tmp_path_factory: pytest.TempPathFactory) -> tuple[ModelGeometry, UnstructuredGrid]:
    folder = tmp_path_factory.mktemp("kinds")
    geometry = all_kinds(folder)
    return geometry, read_grid(written(folder, geometry))


def of_kind(grid: UnstructuredGrid, number: int) -> UnstructuredGrid:
    return grid.extract_cells(np.flatnonzero(grid.cell_data["id"] == number).tolist())


@pytest.mark.parametrize("number", range(1, len(KINDS) + 1), ids=TYPES)
def test_size_of_every_kind_of_cell(kinds: tuple[ModelGeometry, UnstructuredGrid], number: int) -> None:
    """Volume (positive) or area as VTK has it, against the analytic one and the mass over the density."""
    geometry, grid = kinds
    sizes = of_kind(grid, number).compute_cell_sizes()
    _, prop, _, _, _, unit = KINDS[number - 1]
    i = geometry.elements.id.tolist().index(number)
    by_mass = geometry.elements.mass_kg[i] / 1000.0
    if prop == 1:
        assert sizes["Volume"] == pytest.approx([unit * np.linalg.det(FRAME)], rel=1e-8)
        assert sizes["Volume"] == pytest.approx([by_mass], rel=1e-8)
    else:
        a, b = FRAME[0], FRAME[1]
        assert sizes["Area"] == pytest.approx([unit * np.linalg.norm(np.cross(a, b))], rel=1e-8)
        assert sizes["Area"] == pytest.approx([by_mass / 0.01], rel=1e-8)


def test_meshio_reads_the_same(tmp_path: Path) -> None:
    """But for quadratic wedges, which it knows by name and cannot hold."""
    geometry = all_kinds(tmp_path, [kind for kind in KINDS if kind[4] != CellType.QUADRATIC_WEDGE])
    mesh = meshio.read(written(tmp_path, geometry, [MeshArray("grid_id", geometry.grid_id, "1", "")]))
    assert sum(len(block) for block in mesh.cells) == len(KINDS) - 1
    np.testing.assert_array_equal(mesh.points, geometry.position_m)
    np.testing.assert_array_equal(mesh.point_data["grid_id"], geometry.grid_id)
    np.testing.assert_array_equal(np.sort(np.concatenate(mesh.cell_data["id"])), geometry.elements.id)


def test_elements_without_some_midside_nodes_are_drawn_by_their_corners(tmp_path: Path) -> None:
    cards = "PSOLID,1,1\nCHEXA,7,1,1,2,3,4,5,6\n,7,8,9"
    grids = {i: (float(x), float(y), float(z)) for i, (x, y, z) in enumerate(HEXA, start=1)} | {9: (0.5, 0.0, 0.0)}
    grid = read_vtk(written(tmp_path, read(tmp_path, deck(cards, grids))))
    assert grid.n_points == 9
    assert grid.celltypes.tolist() == [CellType.HEXAHEDRON]
    assert grid.compute_cell_sizes()["Volume"] == pytest.approx([1.0])


def test_springs_are_lines_and_points_and_others_are_left_out(tmp_path: Path) -> None:
    cards = "PROD,3,1,1.-4\nCROD,1,3,1,2\nCELAS2,2,1.+5,1,1\nCELAS2,3,1.+5,1,1,2,1\nPLOTEL,4,2,3"
    e = read(tmp_path, deck(cards)).elements
    cells, left = element_cells(e.type, e.node_offset, e.node_index)
    assert {int(e.id[c.row[0]]): c.kind for c in cells} == {1: CellType.LINE, 2: CellType.VERTEX, 3: CellType.LINE}
    assert not left.size
    cells, left = element_cells(["GENEL", "CROD"], np.array([0, 3, 5]), np.array([0, 1, 2, 0, 1]))
    assert [c.kind for c in cells] == [CellType.LINE]
    assert left.tolist() == [0]


def test_label_of_a_cell_is_that_of_most_of_its_nodes() -> None:
    label = np.array([5, 5, 2, 2, 2, -1])
    nodes = np.array([[0, 1, 2, 5], [0, 1, 2, 3], [2, 3, 4, 0], [5, 5, 5, 0]])
    assert label_of_cells(nodes, label).tolist() == [5, 2, 2, -1]


def test_names_that_xml_would_not_take(tmp_path: Path) -> None:
    geometry = all_kinds(tmp_path)
    values = np.arange(float(len(geometry.grid_id)))
    arrays = distinct(
        [
            MeshArray(array_name("displacement", n), values + i, "m", n)
            for i, n in enumerate(('OB <b>&"', "OB [b]__", "ü"))
        ]
    )
    path = written(tmp_path, geometry, arrays)
    grid = read_vtk(path)
    assert list(grid.point_data) == ["displacement_OB__b___", "displacement_OB__b___+2", "displacement__"]
    np.testing.assert_array_equal(grid.point_data["displacement_OB__b___+2"], values + 1)
    table = path.with_name("mesh_arrays.csv").read_text(encoding="utf-8")
    assert '"OB <b>&"""' in table


@given(st.lists(st.sampled_from(["x", "x+2", "x+3", "x+2+2", "y"]), max_size=8))
@example(["x", "x+2", "x"])
def test_arrays_of_one_name_become_distinct(names: list[str]) -> None:
    """Whatever the names are; the first of each name keeps it, and nothing else changes."""
    arrays = [MeshArray(name, np.array([float(i)]), "m", "") for i, name in enumerate(names)]
    found = distinct(arrays)
    assert len({a.name for a in found}) == len(names)
    assert [a.values[0] for a in found] == list(range(len(names)))
    for i, (a, name) in enumerate(zip(found, names, strict=True)):
        assert a.name == name if name not in names[:i] else a.name.startswith(f"{name}+")


def test_colour_maps_name_every_number(tmp_path: Path) -> None:
    import json

    names = [f"area {i}" for i in range(12)]
    write_vtu(
        tmp_path / "a.vtu", np.eye(3), element_cells(["CTRIA3"], np.array([0, 3]), np.arange(3))[0], [], [],
        [Names("area_index", names, ["a"] * 6 + ["b"] * 6)],
    )  # fmt: skip
    (preset,) = json.loads((tmp_path / "a_colours.json").read_text())
    assert preset["Annotations"] == ["-1", "none", *(t for i, n in enumerate(names) for t in (str(i), n))]
    assert len(preset["IndexedColors"]) == 3 * 13
    assert all(0 <= c <= 1 for c in preset["IndexedColors"])


def test_sizes_in_an_independent_model_are_masses_over_densities(mini_ltp_dir: Path, tmp_path: Path) -> None:
    """Bricks and wedges with the sign of their volume, plates by their thickness; bars have a length and no more."""
    path = mini_ltp_dir / "mini_ltp.bdf"
    e = (geometry := model_geometry(read_deck(path), [path])).elements
    grid = read_vtk(written(tmp_path, geometry)).compute_cell_sizes()
    row = np.searchsorted(e.id, grid["id"])
    kinds = np.array(e.type)[row]
    solid, plate = np.isin(kinds, ["CHEXA", "CPENTA"]), kinds == "CQUAD4"
    assert {*kinds[solid], *kinds[plate]} == {"CHEXA", "CPENTA", "CQUAD4"}
    size = np.where(solid, grid["Volume"], grid["Area"] * e.section[row])
    both = solid | plate
    np.testing.assert_allclose((size * e.density[row])[both], e.mass_kg[row][both], rtol=1e-9)
    assert (grid["Length"][kinds == "CBAR"] > 0).all()
