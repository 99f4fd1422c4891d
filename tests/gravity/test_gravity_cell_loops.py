"""The compiled loops over elements, cells and their Gauss points, against the same in arrays."""

import numpy as np
import pytest
from bodies import CUBE
from scipy.spatial.transform import Rotation

from tedm_cli.arrays import FloatArray
from tedm_cli.fem.shapes import CARDS, Shape, measure, polynomials
from tedm_cli.gravity.cutting import put_departure, put_extent, put_wanted
from tedm_cli.gravity.gauss_points import add_rows, put_coefficients, put_measures, put_points

SHAPES = list(dict.fromkeys(shape for shapes in CARDS.values() for shape in shapes))
each_shape = pytest.mark.parametrize("shape", SHAPES, ids=lambda shape: f"{shape.family}{shape.nodes}")
ELEMENTS = 40


def elements(shape: Shape, spread: float, seed: int = 1) -> FloatArray:
    """Sheared elements whose nodes are off by a part of their size, [E, n, 3]."""
    rng = np.random.default_rng(seed)
    affine = rng.normal(size=(ELEMENTS, shape.dimension, 3))
    noise = spread * rng.uniform(-1.0, 1.0, (ELEMENTS, shape.nodes, 3))
    return np.ascontiguousarray(shape.reference_nodes() @ affine + noise)


@each_shape
@pytest.mark.parametrize("shared", [True, False])
def test_points_and_measures_are_those_of_the_shape_functions(shape: Shape, shared: bool) -> None:
    rng = np.random.default_rng(2)
    nodes = elements(shape, 0.1)
    cells = rng.integers(0, ELEMENTS, 25)
    xi = shape.to_element(rng.uniform(size=(1 if shared else len(cells), 7, shape.dimension)))
    powers, coefficients = polynomials(shape)
    values, slopes = shape.functions(xi)
    found, position, size = np.empty_like(values), np.empty((len(cells), 7, 3)), np.empty((len(cells), 7))
    put_points(powers, coefficients[0], xi, cells, nodes, found, position)
    put_measures(powers, coefficients[1:], xi, cells, nodes, size)
    np.testing.assert_allclose(found, values, rtol=0, atol=2e-15)
    np.testing.assert_allclose(position, values @ nodes[cells], rtol=0, atol=2e-14)
    jacobian = np.swapaxes(slopes, -1, -2) @ nodes[cells][:, None]
    np.testing.assert_allclose(size, measure(jacobian), rtol=0, atol=1e-13)


@each_shape
def test_polynomials_are_the_shape_functions(shape: Shape) -> None:
    powers, coefficients = polynomials(shape)
    assert powers.shape[0] <= 3**shape.dimension
    assert not powers[0].any()
    xi = np.random.default_rng(3).uniform(size=(30, shape.dimension))
    monomials = (xi[:, None] ** powers).prod(axis=-1)
    values, slopes = shape.functions(xi)
    np.testing.assert_allclose(monomials @ coefficients[0], values, rtol=0, atol=3e-15)
    np.testing.assert_allclose(np.einsum("pk,dkn->pnd", monomials, coefficients[1:]), slopes, rtol=0, atol=5e-15)


def departure_in_arrays(shape: Shape, nodes: FloatArray) -> FloatArray:
    basis = shape.reference_nodes() - shape.reference_nodes().mean(axis=0)
    centred = nodes - nodes.mean(axis=1, keepdims=True)
    affine = np.linalg.pinv(basis) @ centred
    rest = centred - basis @ affine
    inside = rest @ np.linalg.pinv(affine)
    outside = np.linalg.norm(rest - inside @ affine, axis=2).max(axis=1)
    smallest = np.linalg.svd(affine, compute_uv=False)[:, -1]
    return np.asarray(2.0 * np.maximum(np.abs(inside).max(axis=(1, 2)), outside / smallest))


def departure(shape: Shape, nodes: FloatArray) -> FloatArray:
    basis = shape.reference_nodes() - shape.reference_nodes().mean(axis=0)
    found = np.empty(len(nodes))
    put_departure(basis, np.ascontiguousarray(np.linalg.pinv(basis)), nodes, found)
    return found


@each_shape
@pytest.mark.parametrize("spread", [0.0, 1e-3, 0.2])
def test_departure_from_an_affine_element(shape: Shape, spread: float) -> None:
    nodes = elements(shape, spread)
    wanted = departure_in_arrays(shape, nodes)
    np.testing.assert_allclose(departure(shape, nodes), wanted, rtol=1e-9, atol=1e-10)


def test_departure_of_elements_without_extent_is_finite() -> None:
    """Flat, drawn to a line, and all nodes in one place: such an element is refused later, by its Jacobian."""
    hexahedron = CARDS["CHEXA"][0]
    flat = hexahedron.reference_nodes() * np.array([[[1.0, 1.0, 0.0]], [[1.0, 0.0, 0.0]], [[0.0, 0.0, 0.0]]])
    warped = flat + np.random.default_rng(0).uniform(size=(1, 8, 1)) * [1.0, 0.0, 0.0]
    assert np.isfinite(departure(hexahedron, np.ascontiguousarray(flat))).all()
    assert np.isfinite(departure(hexahedron, np.ascontiguousarray(warped))).all()


@pytest.mark.parametrize(("k", "dimension"), [(2, 1), (2, 2), (2, 3), (3, 1), (3, 2), (3, 3)])
def test_extents_and_distances(k: int, dimension: int) -> None:
    rng = np.random.default_rng(5)
    net, points = rng.normal([1.5, 0.0, 0.0], size=(2, 30, k**dimension, 3))
    points[3, 1, 2] = np.nan
    low, high = np.array([-0.2, -0.3, -0.4]), np.array([0.4, 0.3, 0.2])
    lengths, gap, closest = np.empty((30, dimension)), np.empty(30), np.empty(30)
    put_extent(net, points, low, high, lengths, gap, closest)
    grid = net.reshape(-1, *(k,) * dimension, 3)
    for axis in range(dimension):
        polygon = np.linalg.norm(np.diff(grid, axis=axis + 1), axis=-1).sum(axis=axis + 1)
        np.testing.assert_allclose(lengths[:, axis], polygon.reshape(30, -1).max(axis=1), rtol=1e-14)
    between = np.maximum(0.0, np.maximum(net.min(axis=1) - high, low - net.max(axis=1)))
    np.testing.assert_allclose(gap, np.linalg.norm(between, axis=1), rtol=1e-14)
    out = np.linalg.norm(np.maximum(0.0, np.maximum(low - points, points - high)), axis=2).min(axis=1)
    assert closest[3] == -1.0
    finite = np.arange(30) != 3
    np.testing.assert_allclose(closest[finite], out[finite], rtol=1e-14)


@pytest.mark.parametrize(("degree", "jacobian_degree", "factor"), [(1, 2, 3.0), (1, 2, 3e4), (4, 4, 3e4)])
def test_points_wanted_are_the_fewest_that_converge(degree: int, jacobian_degree: int, factor: float) -> None:
    """ρ^(degree - 2p) (1 + κρ)^jacobian_degree at p points is below the tolerance, and above it at one less."""
    rng = np.random.default_rng(6)
    lengths, gap = 10.0 ** rng.uniform(-3, 0, (200, 3)), 10.0 ** rng.uniform(-3, 0, 200)
    lengths[0], kappa = 0.0, rng.choice([0.0, 1e-9, 0.05, 0.4], 200)
    wanted, most = np.empty((200, 3), dtype=np.int64), 5
    put_wanted(lengths, gap, kappa, degree, jacobian_degree, np.log(factor), most, wanted)
    with np.errstate(divide="ignore", over="ignore"):
        ratio = 2.0 * gap[:, None] / lengths
        rho = np.minimum(ratio + np.sqrt(1.0 + ratio**2), np.exp(50.0))
    fewest = np.full(wanted.shape, most + 1)
    for p in range(most, 0, -1):
        error = rho ** (degree - 2.0 * p) * (1.0 + kappa[:, None] * rho) ** jacobian_degree
        fewest[error <= 1.0 / factor] = p
    np.testing.assert_array_equal(wanted, fewest)
    assert len(np.unique(wanted)) >= 3


def test_coefficients_at_the_nodes_and_their_sums() -> None:
    rng = np.random.default_rng(7)
    cells, q, n = 12, 5, 8
    axes = Rotation.from_rotvec([0.3, -1.0, 0.2]).as_matrix()
    mass, values = rng.uniform(size=(cells, q)), rng.uniform(size=(cells, q, n))
    field = CUBE.field(rng.normal(size=(cells * q, 3)) + 5.0)
    found = np.empty((cells, n, 24))
    put_coefficients(field.gamma_lin, field.omega_lin, field.force, field.torque, axes, mass, values, found)
    rows = [field.gamma_lin @ axes, field.omega_lin @ axes, field.force, field.torque]
    point = np.concatenate([row.reshape(cells, q, -1) for row in rows], axis=-1)
    wanted = np.einsum("cq,cqn,cqk->cnk", mass, values, point)
    np.testing.assert_allclose(found, wanted, rtol=1e-13, atol=1e-14 * np.abs(wanted).max())
    index, sums = rng.integers(0, 6, (cells, n)), np.zeros((6, 24))
    expected = np.zeros((6, 24))
    np.add.at(expected, index.ravel(), found.reshape(-1, 24))
    add_rows(sums, index.ravel(), found.reshape(-1, 24))
    np.testing.assert_array_equal(sums, expected)
