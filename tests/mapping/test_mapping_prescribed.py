"""The map from averages: its identities, its fields against the exact ones, its adjoint, and what it refuses."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.sparse as sp
from fem_models import KINDS, hexes, solid_mesh, structure
from mapping_models import NONE, SIZE, along, bar, box, mapped, mesh, plate

from tedm_cli.fem.static import StaticSolution
from tedm_cli.fem.structure import LoadCase
from tedm_cli.mapping.averages import averages
from tedm_cli.mapping.node_map import DependentNodes, WeightedMap
from tedm_cli.mapping.quality import quality

SOLIDS = sorted({(card, nodes) for card, nodes, _ in KINDS})
RANDOM = np.random.default_rng(19)


def some(of, nodes):
    """Slices along x, a third of the elements in none."""
    node = along(of, nodes)
    node[RANDOM.random(len(node)) < 0.3] = NONE
    node[[np.flatnonzero(along(of, nodes) == k)[0] for k in range(nodes)]] = range(nodes)
    return node


CASES = [
    *(pytest.param(box(*kind), 3, id=f"{kind[0]}{kind[1]}") for kind in SOLIDS),
    pytest.param(plate((6, 4), distortion=0.2), 3, id="CQUAD4"),
    pytest.param(plate((6, 4), corners=3, distortion=0.2), 3, id="CTRIA3"),
    pytest.param(bar(40), 7, id="CROD"),
]


@pytest.mark.parametrize(("of", "nodes"), CASES)
def test_identities(of, nodes) -> None:
    """Averages are kept, constants to the bit, rows of P sum to one, A P = 1, sᵀ P by μ is sᵀ (P 1)."""
    node = some(of, nodes)
    through, v, _ = mapped(of, node)
    tau = RANDOM.normal(size=(nodes, 5)) * 10.0
    field = through.temperatures(tau)
    a = averages(v, node[v.element], nodes, len(of.position))
    assert np.abs(a.sum(axis=1) - 1.0).max() < 1e-14
    assert np.abs(a @ field - tau).max() < 1e-12
    np.testing.assert_array_equal(through.temperatures(np.full((nodes, 1), 293.15)), 293.15)
    p = through.temperatures(np.eye(nodes))
    assert np.abs(p.sum(axis=1) - 1.0).max() < 1e-13
    assert np.abs(a @ p - np.eye(nodes)).max() < 1e-13
    s = RANDOM.normal(size=(4, len(of.position)))
    assert np.abs(through.sensitivities(s) - s @ p).max() < 1e-12 * np.abs(s @ p).max()
    assert np.abs(p @ tau - field).max() < 1e-12


@pytest.mark.parametrize("solver", ["mumps", "superlu"])
@pytest.mark.parametrize(("of", "nodes"), CASES)
def test_the_saddle_point_itself(of, nodes, solver) -> None:
    """Against the dense solution of [K Aᵀ; A 0], which another library makes."""
    if solver == "mumps":
        pytest.importorskip("mumps")
    node = some(of, nodes)
    through, v, k = mapped(of, node, solver)
    a = averages(v, node[v.element], nodes, len(of.position))
    n = len(of.position)
    whole = sp.bmat([[k, a.T], [a, None]]).toarray()
    inverse = np.linalg.solve(whole, np.vstack([np.zeros((n, nodes)), np.eye(nodes)]))
    assert np.abs(through.temperatures(np.eye(nodes)) - inverse[:n]).max() < 1e-10


def test_fields_of_less_energy_there_are_none() -> None:
    """Any other field with the same averages conducts more."""
    of = plate((6, 4), distortion=0.2)
    node = some(of, 3)
    through, v, k = mapped(of, node)
    a = averages(v, node[v.element], 3, len(of.position)).toarray()
    field = through.temperatures(np.array([[1.0], [-2.0], [0.5]]))[:, 0]
    energy = field @ (k @ field)
    free = np.linalg.svd(a)[2][3:]  # changes that no average notices
    for change in free[::5]:
        assert (field + 0.01 * change) @ (k @ (field + 0.01 * change)) > energy


def test_linear_field_along_a_bar() -> None:
    """Two nodes at its ends, of one element each: nothing heats the bar in between, so the field there is straight."""
    of = bar(30)
    node = np.full(30, NONE)
    node[[0, 29]] = [0, 1]
    x = of.position[:, 0]
    middle = np.array([x[:2].mean(), x[-2:].mean()])
    through, _, _ = mapped(of, node)
    straight = 3.0 + 7.0 * x
    found = through.temperatures((3.0 + 7.0 * middle)[:, None])[:, 0]
    inside = slice(1, -1)
    # within the end elements an even source bends the field: its grids there are off by a quarter of their step
    assert np.abs(np.diff(found[inside], 2)).max() < 1e-12
    slope = (found[-2] - found[1]) / (x[-2] - x[1])
    exact = 7.0 * (middle[1] - middle[0]) / (x[-2] - x[1] + 2 * (x[1] - x[0]) / 4)
    assert slope == pytest.approx(exact, rel=1e-12)
    assert np.abs(found - straight).max() < 7.0 * (x[1] - x[0])


def exact_halves(x, half):
    """Field of averages -1 and 1 over the halves of a bar from -half to half: parabolas, no flow through the ends.

    k T'' = -q and +q on the sides with T(0) = 0, T'(±half) = 0: T = c (2 half x - x²) right of the middle.
    """
    c = 1.0 / (half**2 * 2.0 / 3.0)
    return np.sign(x) * c * (2.0 * half * np.abs(x) - x**2)


@pytest.mark.parametrize("kind", ["bar", "CQUAD4", "CTRIA3", "CHEXA8", "CTETRA10"])
def test_two_nodes_against_the_exact_conduction(kind) -> None:
    """Of two halves the exact field is two parabolas. Linear elements converge to it with the square of their size
    (triangles, whose halves end in a zigzag, not before they are many); quadratic ones have it."""

    def error(n):
        if kind == "bar":
            of, length = bar(n), 1.0
        elif kind in ("CQUAD4", "CTRIA3"):
            of, length = plate((n, n // 4), (1.0, 0.25), corners=3 if kind == "CTRIA3" else 4), 1.0
        else:
            card, nodes = kind[:-1] if kind == "CHEXA8" else "CTETRA", 8 if kind == "CHEXA8" else 10
            position, grids = solid_mesh(card, nodes, (n, 1, 1), (1.0, 0.2, 0.2))
            of, length = mesh(position, (card, grids)), 1.0
        through, _, _ = mapped(of, along(of, 2))
        field = through.temperatures(np.array([[-1.0], [1.0]]))[:, 0]
        return np.abs(field - exact_halves(of.position[:, 0] - length / 2, length / 2)).max()

    coarse, fine = error(8), error(16)
    if kind == "CTETRA10":
        assert coarse < 1e-11
    else:
        assert 2.8 < coarse / fine < 4.5
        assert fine < 0.015


def test_coarse_plate_against_a_fine_solution() -> None:
    """Two patches of a plate with a third of it free: 8 x 4 elements against 64 x 32, at their common grids.

    The source of a patch jumps at its border, where linear elements are off by some h² |log h|: 1.3 % of the step at
    8 x 4, four times less at 16 x 8.
    """

    def field(n):
        of = plate((2 * n, n))
        x, y = (
            np.array([of.position[of.node_index[i : i + 4], a].mean() for i in of.node_offset[:-1]]) for a in (0, 1)
        )
        node = np.where(x < 0.1, 0, np.where((x > 0.2) & (y < 0.1), 1, NONE))
        through, _, _ = mapped(of, node)
        return through.temperatures(np.array([[1.0], [0.0]]))[:, 0].reshape(2 * n + 1, n + 1)

    fine = field(32)
    off = [np.abs(field(n) - fine[:: 32 // n, :: 32 // n]).max() for n in (4, 8, 16)]
    assert off[0] < 0.02
    assert off[0] / off[1] > 3.0
    assert off[1] / off[2] > 3.0


def test_conductivity_and_scale() -> None:
    """Twice all conductivities is the same field; a part that conducts a thousand times better is nearly even."""
    of, node = plate((6, 4)), along(plate((6, 4)), 3)
    tau = np.array([[1.0], [0.0], [2.0]])
    same = mapped(plate((6, 4), k=2.0 * of.conductivity[0]), node)[0].temperatures(tau)
    assert np.abs(same - mapped(of, node)[0].temperatures(tau)).max() < 1e-12
    better = np.where(node == 1, 1e3, 1.0)
    field = mapped(plate((6, 4), k=better), node)[0].temperatures(tau)
    inner = np.unique(of.node_index.reshape(-1, 4)[node == 1])
    assert np.ptp(field[inner]) < 0.02


def test_parts_that_nothing_joins() -> None:
    """A node on two bars has its temperature as average on both, and what is not mapped is NaN."""
    one = bar(4)
    position = np.vstack([one.position, one.position + np.array([0.0, 1.0, 0.0]), [[9.0, 9.0, 9.0]]])
    rods = np.vstack([one.node_index.reshape(-1, 2), one.node_index.reshape(-1, 2) + 5])
    of = mesh(position, ("CROD", rods), section=1e-4)
    through, _, _ = mapped(of, [0, 0, 1, 1, 0, 0, 0, 0])
    assert through.several.tolist() == [0]
    field = through.temperatures(np.array([[2.0], [5.0]]))
    np.testing.assert_allclose(field[5:10], 2.0, rtol=0, atol=1e-14)
    assert np.isnan(field[10]).all()
    assert through.mapped.tolist() == [True] * 10 + [False]
    s = RANDOM.normal(size=(2, 11))
    p = np.nan_to_num(through.temperatures(np.eye(2)))
    np.testing.assert_allclose(through.sensitivities(s), s @ p, rtol=1e-12)


def test_averages_that_follow_from_others() -> None:
    """Parallel rods have one average; more nodes than grids cannot all be prescribed."""
    twice = mesh([[0, 0, 0], [1, 0, 0], [2, 0, 0]], ("CROD", [(0, 1), (0, 1), (1, 2)]))
    with pytest.raises(DependentNodes) as caught:
        mapped(twice, [0, 1, 2])
    assert caught.value.nodes.tolist() in ([0], [1])
    tets = box("CTETRA", 4, (2, 2, 2), 0.0)
    with pytest.raises(DependentNodes) as many:
        mapped(tets, np.arange(48))
    assert len(many.value.nodes) >= 48 - 27
    mapped(bar(60), np.arange(60))  # each element a node: all the same determined


def test_sensitivities_are_what_the_solver_makes_of_the_field() -> None:
    """sᵀ P against the displacements under the mapped field of each node, by the same elements."""
    position, corners = solid_mesh("CHEXA", 8, (3, 2, 2), SIZE, 0.1)
    held = [(int(i), "123") for i in np.flatnonzero(position[:, 0] < 1e-9)]
    model = structure(position, held=held, solids=hexes(corners))
    of = mesh(position, ("CHEXA", corners), k=RANDOM.uniform(1.0, 200.0, len(corners)))
    through, _, _ = mapped(of, some(of, 3))
    solution = StaticSolution(model)
    rows = RANDOM.normal(size=(6 * model.n_grids, 4))
    s = solution.adjoint(rows, ["a", "b", "c", "d"]).grid
    found = through.sensitivities(s)
    fields = through.temperatures(np.eye(3))
    cases = [LoadCase(id=k + 1, label="", temperature=t) for k, t in enumerate(fields.T)]
    wanted = rows.T @ np.array([u.reshape(-1) for _, u in solution.solve(cases)]).T
    assert np.abs(found - wanted).max() < 1e-9 * np.abs(wanted).max()


def test_weighted_map() -> None:
    """The old way: as they are, whole areas at once."""
    weights = sp.csr_matrix(np.array([[1.0, 0.0], [0.25, 0.75], [0.0, 0.0]]))
    through = WeightedMap(weights)
    field = through.temperatures(np.array([[4.0], [8.0]]))
    np.testing.assert_allclose(field[:2, 0], [4.0, 7.0])
    assert np.isnan(field[2, 0])
    np.testing.assert_allclose(through.sensitivities(np.array([[1.0, 2.0, 3.0]])), [[1.5, 1.5]])


def test_quality_says_what_it_should() -> None:
    """A step of 1 K between two halves: TEMP cards make it across one element, conduction over the whole bar."""
    of = bar(20)
    node = along(of, 2)
    through, v, _ = mapped(of, node)
    tau = np.array([[0.0, 1.0], [1.0, 1.0]])
    field = through.temperatures(tau)
    found = quality(through, v, node[v.element], tau, field)
    assert found.kept.max() < 1e-13
    np.testing.assert_allclose(found.step, [1.0, 0.0])
    np.testing.assert_allclose(found.jump, [np.abs(np.diff(field[:, 0])).max(), 0.0], atol=1e-13)
    assert found.element[0] in (9, 10), "in the middle"
    assert found.jump[0] < 0.16
    spoilt = quality(through, v, node[v.element], tau, field + 0.25)
    np.testing.assert_allclose(spoilt.kept, 0.25)


def test_sets_by_the_hundred_are_those_one_by_one() -> None:
    """Maps and their quality are made in blocks."""
    of = plate((6, 4))
    node = along(of, 3)
    through, v, _ = mapped(of, node)
    tau = RANDOM.normal(size=(3, 150))
    field = through.temperatures(tau)
    found = quality(through, v, node[v.element], tau, field)
    for k in (0, 63, 64, 149):
        one = slice(k, k + 1)
        np.testing.assert_allclose(field[:, one], through.temperatures(tau[:, one]), rtol=0, atol=1e-13)
        alone = quality(through, v, node[v.element], tau[:, one], field[:, one])
        assert (found.jump[k], found.step[k], found.element[k]) == (alone.jump[0], alone.step[0], alone.element[0])
