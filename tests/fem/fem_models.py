"""Small structures for the tests of the embedded solver."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from tedm_cli.fem.elasticity import isotropic_stiffness
from tedm_cli.fem.shapes import shape_of
from tedm_cli.fem.static import StaticSolution
from tedm_cli.fem.structure import BarBlock, LoadCase, SolidBlock, SolidMaterials, Structure

YOUNG, NU, ALPHA = 7.0e10, 0.33, 2.3e-5


def block_mesh(cells: tuple[int, int, int], size: tuple[float, float, float], distortion: float = 0.0):
    """Positions [N, 3] and connectivity [E, 8] of a box; `distortion` moves inner grids, in cell widths."""
    axes = [np.linspace(0.0, length, n + 1) for length, n in zip(size, cells, strict=True)]
    position = np.stack(np.meshgrid(*axes, indexing="ij"), -1).reshape(-1, 3)
    index = np.arange(len(position)).reshape([n + 1 for n in cells])
    lower = [index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:]]
    corners = np.stack([part[..., :-1] for part in lower] + [part[..., 1:] for part in lower], -1).reshape(-1, 8)
    extent = np.array(size)
    inner = ((position > 1e-9) & (position < extent - 1e-9)).all(axis=1)
    shift = np.random.default_rng(7).uniform(-1.0, 1.0, position.shape) * distortion * extent / np.array(cells)
    return position + shift * inner[:, None], corners


def materials(young=YOUNG, nu=NU, alpha=ALPHA, tref=0.0) -> SolidMaterials:
    """Isotropic materials, one for each entry of the arguments."""
    young, nu, alpha, tref = (np.ravel(a).astype(float) for a in np.broadcast_arrays(young, nu, alpha, tref))
    return SolidMaterials(
        stiffness=np.array([isotropic_stiffness(e, n) for e, n in zip(young, nu, strict=True)]),
        expansion=np.outer(alpha, [1.0, 1.0, 1.0, 0.0, 0.0, 0.0]),
        reference_temperature=tref,
    )


def solids(card, connectivity, *, bubble=False, table=None, material=0) -> SolidBlock:
    """A block of solids; `material` are rows of the table, one for all or one for each."""
    return SolidBlock(
        card=card,
        element_id=np.arange(1, len(connectivity) + 1),
        connectivity=np.asarray(connectivity),
        material=np.broadcast_to(np.asarray(material), len(connectivity)).copy(),
        materials=table or materials(),
        bubble=bubble,
    )


def hexes(corners, young=YOUNG, nu=NU, alpha=ALPHA, tref=0.0, bubble=False) -> tuple[SolidBlock]:
    """Linear hexahedra with material constants for all or for each of them."""
    each = np.zeros(len(corners))
    table = materials(young + each, nu + each, alpha + each, tref + each)
    return (solids("CHEXA", corners, bubble=bubble, table=table, material=np.arange(len(corners))),)


# A hexahedron as six tetrahedra about its main diagonal (neighbours match), and as two pentahedra.
_TETRAHEDRA = [[0, a, b, 6] for a, b in ((1, 2), (2, 3), (3, 7), (7, 4), (4, 5), (5, 1))]
_PENTAHEDRA = [[0, 1, 2, 4, 5, 6], [0, 2, 3, 4, 6, 7]]
KINDS = [
    *(("CHEXA", 8, False), ("CHEXA", 8, True), ("CHEXA", 20, False)),
    *(("CPENTA", 6, False), ("CPENTA", 6, True), ("CPENTA", 15, False)),
    *(("CTETRA", 4, False), ("CTETRA", 10, False)),
]
"""Card, nodes and bubble functions of every solid."""


def solid_mesh(card, nodes, cells, size, distortion=0.0):
    """Positions and connectivity of a box of any solids; midside nodes lie at the middles of straight edges."""
    position, corners = block_mesh(cells, size, distortion)
    if card == "CTETRA":
        corners = corners[:, _TETRAHEDRA].reshape(-1, 4)
    elif card == "CPENTA":
        corners = corners[:, _PENTAHEDRA].reshape(-1, 6)
    shape = shape_of(card, nodes)
    assert shape is not None, (card, nodes)
    if not shape.edges:
        return position, corners
    edges = np.sort(corners[:, np.array(shape.edges)], axis=2)
    unique, inverse = np.unique(edges.reshape(-1, 2), axis=0, return_inverse=True)
    middle = len(position) + inverse.reshape(len(corners), -1)
    return np.vstack([position, position[unique].mean(axis=1)]), np.hstack([corners, middle])


def bars(
    ends,
    orientation,
    *,
    i1=3.0e-9,
    i2=5.0e-9,
    i12=0.0,
    area=1.0e-4,
    alpha=ALPHA,
    tref=0.0,
    shear=np.inf,
    offset=0.0,
    pins=(),
) -> BarBlock:
    """`pins` are the zero-based freedoms released in all bars."""
    ends = np.asarray(ends)
    full = lambda value: np.broadcast_to(np.asarray(value, float), len(ends)).copy()  # noqa: E731
    return BarBlock(
        element_id=np.arange(501, 501 + len(ends)),
        connectivity=ends,
        area=full(area),
        inertia_1=full(i1),
        inertia_2=full(i2),
        inertia_12=full(i12),
        torsion_constant=full(6.0e-9),
        youngs_modulus=full(YOUNG),
        shear_modulus=full(YOUNG / (2 * (1 + NU))),
        expansion=full(alpha),
        reference_temperature=full(tref),
        orientation=np.broadcast_to(np.asarray(orientation, float), (len(ends), 3)).copy(),
        shear_factor=np.broadcast_to(np.asarray(shear, float), (len(ends), 2)).copy(),
        offset=np.broadcast_to(np.asarray(offset, float), (len(ends), 2, 3)).copy(),
        released=np.tile(np.isin(np.arange(12), pins), (len(ends), 1)),
    )


def structure(position, *, held=(), **parts) -> Structure:
    """`held` lists (grid row, components)."""
    pairs = np.array([(row, int(digit)) for row, digits in held for digit in digits], dtype=np.int64).reshape(-1, 2)
    return Structure(
        grid_id=np.arange(1, len(position) + 1),
        position=np.asarray(position, float),
        spc_grid=pairs[:, 0],
        spc_component=pairs[:, 1],
        **parts,
    )


def nearest(position, point) -> int:
    return int(np.linalg.norm(position - np.asarray(point), axis=1).argmin())


def determinate(position, size) -> list[tuple[int, str]]:
    """Supports at three corners of a box that stop its six rigid motions and nothing else (3-2-1)."""
    a, b, _ = size
    return [(nearest(position, p), d) for p, d in (((0, 0, 0), "123"), ((a, 0, 0), "23"), ((0, b, 0), "3"))]


def solve(model: Structure, *temperatures, solver="auto"):
    """Motions [cases, N, 6] and the report."""
    solution = StaticSolution(model, solver=solver)
    cases = [
        LoadCase(id=k, label=f"T{k}", temperature=np.broadcast_to(np.asarray(t, float), model.n_grids).copy())
        for k, t in enumerate(temperatures, 1)
    ]
    return np.array([motion for _, motion in solution.solve(cases)]), solution.report


def rotation_matrix(axis, angle: float):
    axis = np.asarray(axis, float) / np.linalg.norm(axis)
    cross = np.cross(np.eye(3), axis) * -1.0
    return np.eye(3) + np.sin(angle) * cross + (1.0 - np.cos(angle)) * cross @ cross


def rotated(model: Structure, matrix) -> Structure:
    """The same structure in coordinates turned by `matrix` (constraints must be all or none of a triple)."""
    return replace(
        model,
        position=model.position @ matrix.T,
        bars=replace(model.bars, orientation=model.bars.orientation @ matrix.T, offset=model.bars.offset @ matrix.T),
    )
