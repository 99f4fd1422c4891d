"""What every temperature does to an output, by the adjoint, against solutions of temperature fields."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from fem_models import KINDS, bars, determinate, hexes, nearest, rotation_matrix, solid_mesh, solids, structure
from own_temperatures import GRADIENT, own
from test_fem_element_temperatures import mixed, of_grids

from tedm_cli.errors import PhysicsError
from tedm_cli.fem.static import StaticSolution
from tedm_cli.fem.structure import LoadCase, Rbe2, Rbe3

OUTPUTS = ["one", "two", "three"]
PRECISION = 1e-10


def outputs(model, single=-1):
    """Forces and moments of any size on all grids, the second on a single grid, as that of an optical element is."""
    rng = np.random.default_rng(4)
    rows = rng.normal(size=(6 * model.n_grids, 3))
    rows[:, 1] = 0.0
    grid = range(model.n_grids)[single]
    rows[6 * grid : 6 * grid + 6, 1] = rng.normal(size=6)
    return rows


def by_solution(solution, rows, *cases):
    """The outputs [r, cases] less those of the first case."""
    motion = np.array([u.reshape(-1) for _, u in solution.solve(list(cases))])
    return rows.T @ (motion[1:] - motion[0]).T


def case(number, temperature, elements=None):
    return LoadCase(id=number, label="", temperature=temperature, elements=elements)


def agree(found, wanted):
    assert (np.abs(wanted).max(axis=1) > 0.0).all()
    assert (np.abs(found - wanted).max(axis=1) < PRECISION * np.abs(wanted).max(axis=1)).all()


def with_rigid_elements(position, block, size):
    """A block of solids with grids on an RBE2 and an RBE3 of the first ones, and frames of their own on all grids."""
    top = [nearest(position, np.array(size) * corner) for corner in ((0, 0, 1), (1, 0, 1), (0, 1, 1), (1, 1, 1))]
    n = len(position)
    apart = np.array(size) * [[0.5, 0.5, 1.5], [0.3, 0.4, 1.8]]
    everywhere = np.vstack([position, apart])
    held = determinate(position, size)
    loose = [grid for grid in top if grid not in {grid for grid, _ in held}]
    turned = np.array([rotation_matrix((1.0, 2.0, 3.0), 0.1 * k) for k in range(n + 2)])
    turned[[grid for grid, _ in held]] = np.eye(3)
    return structure(
        everywhere,
        solids=block,
        rbe3=(Rbe3(element_id=801, dependent=n, components="123456", independents=np.array(loose),
                   weights=np.ones(len(loose)), independent_components=("123",) * len(loose)),),
        rbe2=(Rbe2(element_id=802, independent=n, dependents=np.array([n + 1]), components="123456"),),
        held=held,
        displacement_frame=turned,
    )  # fmt: skip


@pytest.mark.parametrize(("card", "nodes", "bubble"), KINDS)
def test_fem_adjoint_of_solids_is_every_field_of_temperatures(card, nodes, bubble):
    """Ten fields of any temperatures at all grids: in quadratic elements as the solver itself takes them."""
    size = (0.3, 0.2, 0.1)
    position, cells = solid_mesh(card, nodes, (2, 2, 1), size, distortion=0.15)
    table = hexes(np.zeros((3, 8)), young=[7e10, 2e11, 9e10], alpha=[2.3e-5, 1e-6, 1e-5], tref=[0.0, 3.0, -2.0])[0]
    block = solids(card, cells, bubble=bubble, table=table.materials, material=np.arange(len(cells)) % 3)
    model = with_rigid_elements(position, (block,), size)
    solution, rows, rng = StaticSolution(model), outputs(model), np.random.default_rng(1)
    found = solution.adjoint(rows, OUTPUTS)
    assert found.grid.shape == (3, model.n_grids)
    assert not found.element_id.size
    fields = rng.uniform(280.0, 300.0, (10, model.n_grids))
    wanted = by_solution(solution, rows, case(0, np.full(model.n_grids, 290.0)), *(case(1, f) for f in fields))
    agree(found.grid @ (fields - 290.0).T, wanted)
    assert not found.grid[:, -2:].any(), "grids of rigid elements alone are felt by nothing"


@pytest.mark.parametrize("initial", [False, True])
def test_fem_adjoint_of_shells_bars_and_rods(initial):
    """Fields of temperatures, and some elements with means and gradients of their own that differ from end to end."""
    model, rng = mixed(), np.random.default_rng(2)
    if initial:
        model = replace(model, initial_temperature=rng.uniform(0.0, 10.0, model.n_grids))
    every = of_grids(model, np.zeros(model.n_grids)).element_id
    some = every[::3]
    gradient = rng.uniform(-GRADIENT, GRADIENT, (len(some), 2, 2))
    shell = some < 500
    gradient[shell, 1], gradient[shell, :, 1] = gradient[shell, 0], 0.0
    mean = rng.uniform(0.0, 5.0, (len(some), 2))
    solution, rows = StaticSolution(model), outputs(model, single=4)
    field, start = rng.uniform(0.0, 5.0, (2, model.n_grids))
    cases = (case(0, start), case(1, field), case(2, field, own(some, mean=mean, gradient=gradient)))
    wanted = by_solution(solution, rows, *cases)
    found = solution.adjoint(rows, OUTPUTS)
    np.testing.assert_array_equal(found.element_id, every)
    mine = np.isin(every, some)
    without = found.felt(mine) @ field - found.grid @ start
    own_part = found.mean[:, mine] @ mean.mean(axis=1) + np.einsum("rlep,lep->r", found.gradient[:, mine], gradient)
    agree(np.column_stack([found.grid @ (field - start), without + own_part]), wanted)
    assert np.abs(own_part).min() > 1e-3 * np.abs(wanted).max(), "the elements' own temperatures matter here"


@pytest.mark.parametrize(("card", "nodes", "bubble"), KINDS)
def test_fem_adjoint_of_whole_solids_is_each_of_them_expanding_alone(card, nodes, bubble):
    """Against solutions in which all but one are of a material that does not expand, warmed everywhere."""
    size = (0.3, 0.2, 0.1)
    position, cells = solid_mesh(card, nodes, (2, 1, 1), size, distortion=0.15)
    alpha = 1e-5 * (1.0 + np.arange(len(cells)))

    def model(expansion):
        table = hexes(np.zeros((len(cells), 8)), alpha=expansion)[0].materials
        block = solids(card, cells, bubble=bubble, table=table, material=np.arange(len(cells)))
        block = replace(block, element_id=block.element_id[::-1].copy())  # ids that descend
        return with_rigid_elements(position, (block,), size), block.element_id

    whole, ids = model(alpha)
    rows = outputs(whole)
    found = StaticSolution(whole).adjoint(rows, OUTPUTS)
    np.testing.assert_array_equal(found.whole_id, np.sort(ids))
    np.testing.assert_allclose(
        found.whole.sum(axis=1), found.grid.sum(axis=1), rtol=0, atol=1e-11 * abs(found.whole).sum()
    )
    for number in (0, len(cells) - 1):
        one, _ = model(np.where(np.arange(len(cells)) == number, alpha, 0.0))
        cold, warm = np.zeros(one.n_grids), np.ones(one.n_grids)
        wanted = by_solution(StaticSolution(one), rows, case(0, cold), case(1, warm))
        agree(found.whole[:, found.whole_id == ids[number]], wanted)


def test_fem_adjoint_of_whole_shells_bars_and_rods_is_that_of_their_means():
    model = mixed()
    found = StaticSolution(model).adjoint(outputs(model), OUTPUTS)
    np.testing.assert_array_equal(found.whole_id, found.element_id)
    np.testing.assert_allclose(found.whole, found.mean, rtol=0, atol=1e-12 * np.abs(found.mean).max())


def test_fem_adjoint_of_a_structure_that_is_not_held_is_refused():
    position, cells = solid_mesh("CHEXA", 8, (1, 1, 1), (1.0, 1.0, 1.0))
    with pytest.raises(PhysicsError, match="not held"):
        StaticSolution(structure(position, solids=hexes(cells))).adjoint(np.zeros((48, 1)), ["one"])


def test_fem_adjoint_names_the_output_that_is_not_solved():
    position = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]])
    solution = StaticSolution(structure(position, bars=bars([(0, 1)], (0.0, 1.0, 0.0)), held=[(0, "123456")]))
    rows = np.zeros((12, 2))
    rows[6, 1] = np.nan
    with pytest.raises(PhysicsError, match="TM1_a_x: relative residual nan"):
        solution.adjoint(rows, ["TM2_a_x", "TM1_a_x"])
