"""Shape functions: values at the nodes, partition of unity, reproduction of linears, derivatives, exact moments."""

import math

import numpy as np
import pytest

from tedm_cli.fem.shapes import CARDS, Shape, gauss_rule, measure

SHAPES = list(dict.fromkeys(shape for shapes in CARDS.values() for shape in shapes))
RNG = np.random.default_rng(3)
MEASURE = {
    "line": 1.0,
    "triangle": 1 / 2,
    "quadrilateral": 1.0,
    "tetrahedron": 1 / 6,
    "pentahedron": 1 / 2,
    "hexahedron": 1.0,
}


def identify(shape: Shape) -> str:
    return f"{shape.family}{shape.nodes}"


@pytest.mark.parametrize("shape", SHAPES, ids=identify)
def test_one_at_the_own_node_and_zero_at_the_others(shape: Shape) -> None:
    values, _ = shape.functions(shape.reference_nodes())
    np.testing.assert_allclose(values, np.eye(shape.nodes), rtol=0, atol=1e-15)


@pytest.mark.parametrize("shape", SHAPES, ids=identify)
def test_constants_linears_and_with_midside_nodes_quadratics_are_reproduced(shape: Shape) -> None:
    nodes = shape.reference_nodes()
    xi = shape.to_element(RNG.uniform(size=(40, shape.dimension)))
    values, slopes = shape.functions(xi)
    np.testing.assert_allclose(values.sum(axis=-1), 1.0, rtol=0, atol=1e-14)
    np.testing.assert_allclose(values @ nodes, xi, rtol=0, atol=1e-14)
    jacobian = np.einsum("pnd,nc->pcd", slopes, nodes)
    np.testing.assert_allclose(jacobian - np.eye(shape.dimension), 0.0, rtol=0, atol=1e-13)
    if shape.edges:
        quadratic = RNG.normal(size=(shape.dimension,) * 2)

        def form(x: np.ndarray) -> np.ndarray:
            return np.einsum("pi,ij,pj->p", x, quadratic, x)

        np.testing.assert_allclose(values @ form(nodes), form(xi), rtol=0, atol=1e-13)


@pytest.mark.parametrize("shape", SHAPES, ids=identify)
def test_derivatives_against_central_differences(shape: Shape) -> None:
    xi = shape.to_element(RNG.uniform(size=(20, shape.dimension)))
    _, slopes = shape.functions(xi)
    for axis in range(shape.dimension):
        step = np.zeros(shape.dimension)
        step[axis] = 1e-5
        difference = (shape.functions(xi + step)[0] - shape.functions(xi - step)[0]) / 2e-5
        np.testing.assert_allclose(slopes[..., axis], difference, rtol=0, atol=1e-9)


def monomial_integral(family: str, powers: tuple[int, ...]) -> float:
    """Exact integral of a monomial over the reference element."""
    f = math.factorial
    if family in ("line", "quadrilateral", "hexahedron"):
        return math.prod(1 / (p + 1) for p in powers)
    if family == "pentahedron":
        return monomial_integral("triangle", powers[:2]) / (powers[2] + 1)
    return math.prod(f(p) for p in powers) / f(sum(powers) + len(powers))


@pytest.mark.parametrize("shape", SHAPES, ids=identify)
@pytest.mark.parametrize("n", [1, 2, 4])
def test_rule_is_exact_to_its_degree(shape: Shape, n: int) -> None:
    """Gauss-Jacobi weights carry the collapse, so n points a direction keep total degree 2n - 1 in simplices too."""
    points, weights = gauss_rule((n,) * shape.dimension, shape.collapse)
    xi = shape.to_element(points)
    assert weights.sum() == pytest.approx(MEASURE[shape.family], rel=1e-14)
    for powers in np.ndindex(*(2 * n,) * shape.dimension):
        if sum(powers) <= 2 * n - 1:
            found = weights @ (xi ** np.array(powers)).prod(axis=1)
            assert found == pytest.approx(monomial_integral(shape.family, powers), rel=1e-12)


@pytest.mark.parametrize("shape", SHAPES, ids=identify)
def test_volume_area_or_length_of_an_affine_image(shape: Shape) -> None:
    turn = RNG.normal(size=(shape.dimension, 3))
    points, weights = gauss_rule((2,) * shape.dimension, shape.collapse)
    _, slopes = shape.functions(shape.to_element(points))
    size = measure(np.einsum("qnd,nc->qdc", slopes, shape.reference_nodes() @ turn))
    gram = math.sqrt(np.linalg.det(turn @ turn.T))
    assert abs(weights @ size) == pytest.approx(gram * MEASURE[shape.family], rel=1e-13)


def test_handedness_shows_in_the_sign() -> None:
    for family in ("hexahedron", "pentahedron", "tetrahedron"):
        shape = next(s for s in SHAPES if s.family == family)
        _, slopes = shape.functions(np.full((1, 3), 0.2))
        nodes = shape.reference_nodes()
        assert measure(np.einsum("qnd,nc->qdc", slopes, nodes))[0] > 0
        assert measure(np.einsum("qnd,nc->qdc", slopes, nodes * [1, 1, -1]))[0] < 0
