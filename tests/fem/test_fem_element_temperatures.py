"""Shells, bars and rods with temperatures of their own: against those of grids, and in sums of load cases."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from fem_models import ALPHA, YOUNG, bars, block_mesh, hexes, nearest, solve, structure
from own_temperatures import GRADIENT, motions, own
from shell_models import sheet, shells

from tedm_cli.errors import PhysicsError
from tedm_cli.fem.static import StaticSolution
from tedm_cli.fem.structure import ElementTemperatures, LoadCase, RodBlock


def mixed(drilling=1e-4):
    """A panel of quadrilaterals and triangles on bars and rods from a wall, of materials with different TREF."""
    position, quads = sheet((4, 2), (0.4, 0.2), distortion=0.1)
    trias = np.concatenate([quads[-2:][:, [0, 1, 2]], quads[-2:][:, [0, 2, 3]]])
    feet = [nearest(position, p) for p in ((0, 0, 0), (0.4, 0, 0), (0.4, 0.2, 0), (0, 0.2, 0))]
    ground = position[feet] + [0.02, -0.03, -0.2]
    n = len(position)
    lines = [(foot, n + k) for k, foot in enumerate(feet)]
    posts = bars(lines, (1.0, 0.0, 0.0), offset=[[[0.0, 0.01, 0.0], [0.0, 0.0, 0.01]]], pins=(9,), tref=5.0)
    panel, corner = shells(quads[:-2], 2e-3, drilling=drilling), shells(trias, 3e-3, offset=1e-3, drilling=drilling)
    corner = replace(corner, element_id=100 + corner.element_id, reference_temperature=np.full(4, -2.0))
    one = np.ones(2)
    rods = RodBlock(
        element_id=np.array([901, 902]),
        connectivity=np.array([[feet[0], n + 1], [feet[2], n + 3]]),
        area=2e-5 * one,
        torsion_constant=1e-10 * one,
        youngs_modulus=YOUNG * one,
        shear_modulus=3e10 * one,
        expansion=2 * ALPHA * one,
        reference_temperature=3.0 * one,
    )
    held = [(n + k, "123456") for k in range(4)]
    return structure(np.vstack([position, ground]), quads=panel, trias=corner, bars=posts, rods=rods, held=held)


def of_grids(model, temperature) -> ElementTemperatures:
    """Means of all elements that are those of their grids' temperatures."""
    ids, means = [], []
    for block in (model.bars, model.rods):
        ids.append(block.element_id)
        means.append(temperature[block.connectivity])
    for block in (model.quads, model.trias):
        ids.append(block.element_id)
        means.append(np.repeat(temperature[block.connectivity].mean(axis=1)[:, None], 2, axis=1))
    ids, means = np.concatenate(ids), np.concatenate(means)
    order = np.argsort(ids)
    return own(ids[order], mean=means[order])


@pytest.mark.parametrize("initial", [False, True])
def test_fem_means_of_all_elements_are_temperatures_of_their_grids(initial):
    """Whatever the grids have, and from whichever temperature strains count."""
    model, rng = mixed(), np.random.default_rng(5)
    if initial:
        model = replace(model, initial_temperature=rng.uniform(0.0, 10.0, model.n_grids))
    field = rng.uniform(280.0, 300.0, model.n_grids)
    (wanted,), _ = solve(model, field)
    (found,), _ = motions(model, of_grids(model, field), rest=rng.uniform(280.0, 300.0, model.n_grids))
    assert np.abs(found - wanted).max() < 1e-11 * np.abs(wanted).max()


def test_fem_an_element_with_its_own_temperature_leaves_its_neighbours_theirs():
    """The step of a warm grid on an element and its rest is the sum of the two; cards at rest take it off again."""
    model, rng = mixed(), np.random.default_rng(6)
    every = of_grids(model, np.zeros(model.n_grids)).element_id
    some, rest = every[::3], np.delete(every, np.s_[::3])
    field = rng.uniform(0.0, 1.0, model.n_grids)
    solution = StaticSolution(model)
    means = of_grids(model, field)
    pick = lambda ids: own(ids, mean=means.mean[np.searchsorted(every, ids)])  # noqa: E731
    cold = np.zeros(model.n_grids)
    cases = [
        LoadCase(id=1, label="", temperature=field, elements=own(some, mean=0.0)),
        LoadCase(id=2, label="", temperature=cold, elements=pick(some)),
        LoadCase(id=3, label="", temperature=field),
        LoadCase(id=4, label="", temperature=cold),
        LoadCase(id=5, label="", temperature=cold, elements=pick(rest)),
    ]
    others, these, both, none, again = (motion for _, motion in solution.solve(cases))
    np.testing.assert_allclose(others + these - none, both, atol=1e-11 * np.abs(both).max())
    np.testing.assert_allclose(again, others, atol=1e-11 * np.abs(both).max())
    assert np.abs(these - none).max() > 0.05 * np.abs(both).max()


def test_fem_a_gradient_does_nothing_to_a_rod():
    model = mixed()
    (found, none), _ = motions(model, own([901, 902], mean=4.0, gradient=GRADIENT), own([901, 902], mean=4.0))
    np.testing.assert_array_equal(found, none)


def test_fem_temperatures_of_elements_that_are_not_there_are_refused_by_id():
    with pytest.raises(PhysicsError, match=r"1 element.* not shells, bars or rods: 77"):
        motions(mixed(), own([1, 77], mean=1.0))


def loads_of(model, count):
    """Load cases with and without temperatures of elements."""
    rng, every = np.random.default_rng(9), of_grids(model, np.zeros(model.n_grids)).element_id
    gradient = rng.uniform(-GRADIENT, GRADIENT, (len(every), 2, 2))
    shell = every < 500
    gradient[shell, 1], gradient[shell, :, 1] = gradient[shell, 0], 0.0
    out = []
    for k in range(count):
        elements = own(every, mean=rng.uniform(0, 5, (len(every), 1)), gradient=gradient) if k % 2 == 0 else None
        out.append(LoadCase(id=k, label="", temperature=rng.uniform(0, 1, model.n_grids), elements=elements))
    return out


def test_fem_drilling_change_counts_temperatures_of_elements():
    """Of one case, solved in two batches of an odd number of times, it is the change of a second solution."""
    soft, stiff = (StaticSolution(mixed(drilling)) for drilling in (1e-4, 1e-2))
    (case,) = loads_of(mixed(), 1)
    before, after = (next(motion for _, motion in solution.solve([case])) for solution in (soft, stiff))
    assert len(list(soft.solve([case] * 20))) == 20
    found = soft.drilling_change()
    assert found is not None
    for part_, change in ((slice(0, 3), found.translation), (slice(3, 6), found.rotation)):
        wanted = np.abs(after - before)[:, part_].max() / np.abs(after[:, part_]).max()
        assert wanted > 1e-6
        assert change == pytest.approx(wanted, rel=1e-3)


def test_fem_bending_change_counts_temperatures_of_elements():
    """Plain hexahedra in bending under a shell on them, bent by its gradient; the sum of cases has random signs."""
    position, corners = block_mesh((4, 2, 1), (0.2, 0.1, 0.01))
    top = np.flatnonzero(position[:, 2] > 0.01 - 1e-9)
    plane, cover = sheet((4, 2), (0.2, 0.1))
    order = [top[nearest(position[top], p + np.array([0.0, 0.0, 0.01]))] for p in plane]
    block = shells(np.array(order)[cover], 3e-3, offset=1.5e-3)
    held = [(k, "123456") for k in np.flatnonzero(position[:, 0] < 1e-9)]
    model, softer = (
        structure(position, solids=hexes(corners, bubble=bubble), quads=block, held=held) for bubble in (False, True)
    )
    cases = [
        LoadCase(id=1, label="", temperature=np.zeros(len(position)), elements=own(block.element_id, 1.0, GRADIENT)),
        LoadCase(id=2, label="", temperature=position[:, 0] / 0.2),
    ]
    for some in (cases[:1], cases):
        solution, other = StaticSolution(model), StaticSolution(softer)
        before, after = (np.array([m[:, :3] for _, m in s.solve(some)]) for s in (solution, other))
        wanted = np.linalg.norm(after - before) / np.linalg.norm(after)
        assert wanted > 0.05
        assert solution.bending_change() == pytest.approx(wanted, rel=2e-3 if len(some) == 1 else 0.5)
