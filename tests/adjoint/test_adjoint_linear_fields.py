"""Bodies of areas under temperatures that are straight across them, solved as fields."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

sys.path.append(str(Path(__file__).parents[1] / "areas"))

from strut_model import LOWER, UPPER, deck, define, project
from test_adjoint_areas import PRECISION, model_of, outputs

from tedm_cli.adjoint.areas import Places, Warmed, gradient_sensitivity, temperatures
from tedm_cli.adjoint.linear_fields import AreaShapes, area_shapes, linear_field
from tedm_cli.fem.static import StaticSolution
from tedm_cli.fem.structure import LoadCase
from tedm_cli.stages.model.deck import write_deck


@pytest.mark.parametrize("members", [[0], [0, 1], [0, 1, 2]])
def test_a_body_is_one_field_across_its_areas(tmp_path, members):
    """As a load of all its grids at once: zero at the centroid of the body, not at those of its areas."""
    done = write_deck(project(tmp_path, deck(2, block=True), LOWER + UPPER + define("REST", remainder="true")), None)
    model = model_of(done.path)
    structure = model.structure
    solution, rows = StaticSolution(structure), outputs(structure)
    of = temperatures(solution.adjoint(rows, ["a", "b", "c", "d"]), model.own)
    shapes = area_shapes(model.areas, model.places)
    index = np.array(members)
    found = linear_field(of.sums(model.areas), gradient_sensitivity(of, model.areas, model.places), shapes, index)
    grid = np.concatenate([model.areas[i].grid for i in members])
    at, volume = structure.position[grid], model.places.grid_volume[grid]
    middle = volume @ at / volume.sum()
    np.testing.assert_allclose(shapes.middle_of(index), middle, atol=1e-12)
    np.testing.assert_allclose(shapes.extent_of(index), np.ptp(at, axis=0), atol=1e-12)
    cases = []
    for axis in range(3):
        field = np.zeros(structure.n_grids)
        field[grid] = at[:, axis] - middle[axis]
        cases.append(LoadCase(id=1 + axis, label="", temperature=field))
    motions = np.array([motion.reshape(-1) for _, motion in solution.solve(cases)])
    wanted = rows.T @ motions.T
    assert np.abs(found - wanted).max() < PRECISION * np.abs(wanted).max()


def test_shapes_are_of_what_has_the_temperature():
    """Grids, and elements by their centres; of gradients through shells and bars there are none."""
    areas = [
        Warmed(grid=np.array([0, 1]), element=np.array([0])),
        Warmed(grid=np.array([], dtype=int), element=np.array([1]), gradient=np.ones((1, 2))),
    ]
    places = Places(
        grid=np.array([[0.0, 0.0, 0.0], [4.0, 0.0, 1.0], [9.0, 9.0, 9.0]]),
        grid_volume=np.array([1.0, 2.0, 7.0]),
        element=np.array([[8.0, 2.0, 0.0], [5.0, 5.0, 5.0]]),
        element_volume=np.array([1.0, 3.0]),
    )
    found = area_shapes(areas, places)
    assert found.middle[0].tolist() == [4.0, 0.5, 0.5]
    assert found.volume[0] == 4.0
    assert (found.low[0].tolist(), found.high[0].tolist()) == ([0.0, 0.0, 0.0], [8.0, 2.0, 1.0])
    assert all(np.isnan(getattr(found, name)[1]).all() for name in ("middle", "volume", "low", "high"))


def test_a_mean_step_of_an_area_off_the_middle_is_in_it():
    """Two areas on a line, 2 m apart, of volumes 1 and 3: they warm by -1.5 and 0.5 K under 1 K/m."""
    shapes = AreaShapes(
        middle=np.array([[0.0, 0.0, 0.0], [2.0, 0.0, 0.0]]),
        volume=np.array([1.0, 3.0]),
        low=np.zeros((2, 3)),
        high=np.ones((2, 3)),
    )
    gradient = np.array([[[7.0, 1.0, 0.0], [5.0, 1.0, 0.0]]])
    found = linear_field(np.array([[10.0, 100.0]]), gradient, shapes, np.array([0, 1]))
    assert found.tolist() == [[7.0 + 5.0 - 15.0 + 50.0, 2.0, 0.0]]
