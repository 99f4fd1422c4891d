"""Thermal areas as sums over the adjoint: the unit loads of any definition, and fields within an area."""

from __future__ import annotations

import re
import sys
from pathlib import Path

import numpy as np
import pytest

sys.path.append(str(Path(__file__).parents[1] / "areas"))

from strut_model import LOWER, REST, UPPER, deck, define, project
from test_areas_of_elements import GRADIENTS, PARTS

from tedm_cli.adjoint.agreement import agreement
from tedm_cli.adjoint.areas import Places, Temperatures, Warmed, gradient_sensitivity, temperatures
from tedm_cli.adjoint.outputs import acceleration_outputs, read_out_outputs
from tedm_cli.errors import InputError
from tedm_cli.fem.static import StaticSolution
from tedm_cli.fem.structure import LoadCase
from tedm_cli.nastran.reading import read_deck
from tedm_cli.nastran.structure.deck import read_solver_deck
from tedm_cli.stages.adjoint.model import coupled_structure, warmed_model
from tedm_cli.stages.model.deck import write_deck

PRECISION = 1e-10


def outputs(structure):
    return np.random.default_rng(8).normal(size=(6 * structure.n_grids, 4))


def model_of(path):
    raw = read_deck(path, cross_reference=False)
    return warmed_model(raw, coupled_structure(raw, path), [path], "UNIFORM")


@pytest.mark.parametrize("name", [*PARTS, "grids alone"])
def test_sums_over_areas_are_their_unit_loads(tmp_path, name):
    """Of grids and of elements, with elements kept at rest, and gradients; and the uniform load is their sum."""
    tables = PARTS.get(name, LOWER + UPPER + REST)
    tables = tables + GRADIENTS if "remainder" in tables else GRADIENTS + tables
    done = write_deck(project(tmp_path, deck(2, block=True), tables), None)
    model = model_of(done.path)
    structure, cases = read_solver_deck(done.path)
    solution, rows = StaticSolution(structure), outputs(structure)
    of = temperatures(solution.adjoint(rows, ["a", "b", "c", "d"]), model.own)
    found = of.sums(model.areas)
    wanted = np.array([rows.T @ motion.reshape(-1) for _, motion in solution.solve(cases)]).T
    labels = [case.label for case in cases]
    assert [*model.name, "UNIFORM"] == labels
    assert model.own.any() == (name != "grids alone")
    for column, label in enumerate(model.name):
        size = np.abs(wanted[:, column]).max()
        assert np.abs(found[:, column] - wanted[:, column]).max() < PRECISION * size, label
    uniform = found[:, ~model.gradient].sum(axis=1)
    size = np.abs(found[:, ~model.gradient]).max()
    np.testing.assert_allclose(uniform, wanted[:, -1], rtol=0.0, atol=PRECISION * size)
    assert (of.cancellation(model.areas) >= 1.0 - 1e-12).all()


def test_areas_are_per_unit_of_their_step(tmp_path):
    """A deck of one's own with a gradient of 4 K/m."""
    path = write_deck(project(tmp_path, deck(1), GRADIENTS + LOWER + UPPER), None).path
    text, changed = re.subn(r"(?m)^(TEMPP1 +1 +\d+ +0\. +)1\.$", r"\g<1>4.", path.read_text())
    assert changed == 2
    path.write_text(text)
    model, (structure, cases) = model_of(path), read_solver_deck(path)
    solution, rows = StaticSolution(structure), outputs(structure)
    found = temperatures(solution.adjoint(rows, ["a", "b", "c", "d"]), model.own).sums(model.areas)
    bend = next(motion for _, motion in solution.solve(cases[:1]))
    assert model.name[0] == "BEND"
    np.testing.assert_allclose(4.0 * found[:, 0], rows.T @ bend.reshape(-1), rtol=1e-9)


def test_a_gradient_within_an_area_is_that_field_of_its_grids(tmp_path):
    """Solved as an ordinary temperature field, zero at the centroid by volume and outside of the area."""
    done = write_deck(project(tmp_path, deck(2, block=True), LOWER + UPPER + define("REST", remainder="true")), None)
    model = model_of(done.path)
    structure = model.structure
    solution, rows = StaticSolution(structure), outputs(structure)
    of = temperatures(solution.adjoint(rows, ["a", "b", "c", "d"]), model.own)
    found = gradient_sensitivity(of, model.areas, model.places)
    cases = []
    for number, area in enumerate(model.areas):
        place, weight = structure.position[area.grid], model.places.grid_volume[area.grid]
        middle = (weight[:, None] * place).sum(axis=0) / weight.sum()
        for axis in range(3):
            field = np.zeros(structure.n_grids)
            field[area.grid] = place[:, axis] - middle[axis]
            cases.append(LoadCase(id=3 * number + axis, label="", temperature=field))
    motions = np.array([motion.reshape(-1) for _, motion in solution.solve(cases)])
    wanted = (rows.T @ motions.T).reshape(4, len(model.areas), 3)
    assert np.abs(found - wanted).max() < PRECISION * np.abs(wanted).max()
    assert model.name[0] == "LOWER"
    plate = [-0.2 + 0.05 * 8 / 2, -0.15 + 0.05 * 6 / 2, 0.0]
    lower = model.places.at(model.areas[0]) - model.places.centroid(model.areas[0])
    wanted = np.tile(plate, (len(lower), 1))
    np.testing.assert_allclose(structure.position[model.areas[0].grid] - lower, wanted, rtol=0.0, atol=2e-4)


def tiny():
    """Two grids at -1 and 1 m along x and a shell beyond them, as if each output were made of their terms."""
    return Temperatures(
        grid=np.array([[3.0, -1.0, 5.0], [1.0, -1.0, 5.0], [0.0, 0.0, 5.0]]),
        own=np.array([True, False]),
        mean=np.array([[2.0, 7.0], [0.0, 7.0], [0.0, 7.0]]),
        gradient=np.array([[[1.0, 0.5], [9.0, 9.0]]] * 3),
    )


AREAS = [
    Warmed(grid=np.array([0, 1]), element=np.array([0])),
    Warmed(grid=np.zeros(0, dtype=np.int64), element=np.array([0]), gradient=np.array([[4.0, -2.0]])),
]


def test_cancellation_by_hand():
    of = tiny()
    np.testing.assert_array_equal(of.sums(AREAS), [[4.0, 3.0], [0.0, 3.0], [0.0, 3.0]])
    np.testing.assert_array_equal(of.cancellation(AREAS), [[1.5, 1.0], [np.inf, 1.0], [np.nan, 1.0]])


@pytest.mark.parametrize(("volume", "middle"), [((1.0, 2.0, 1.0), 1.0), ((1.0, -1.0, 0.0), 1.0)])
def test_gradient_by_hand(volume, middle):
    """About the centroid by volume; about the mean place where there is no volume to speak of."""
    places = Places(
        grid=np.array([[-1.0, 0, 0], [1.0, 0, 0], [9.0, 0, 0]]),
        grid_volume=np.array([volume[0], volume[1], 50.0]),
        element=np.array([[3.0, 0, 0], [9.0, 0, 0]]),
        element_volume=np.array([volume[2], 50.0]),
    )
    found = gradient_sensitivity(tiny(), AREAS, places)
    np.testing.assert_allclose(found[0, 0], [3.0 * (-1.0 - middle) - (1.0 - middle) + 2.0 * (3.0 - middle), 0.0, 0.0])
    assert np.isnan(found[:, 1]).all()


def test_differences_are_over_the_largest_of_a_block_and_kind():
    """And so is what rounding explains of them, where that is more than 1e-6."""
    wanted = np.array([[1.0, 4.0, 1e6], [2.0, 0.0, 0.0], [0.0, 0.0, 1e3]])
    found = wanted + np.array([[0.0, 0.4, 1.0], [0.8, 0.0, 0.0], [1e-30, 0.0, 0.0]])
    rounding = np.array([[8e-6, 1e-6, 2.0], [0.0, 0.0, 0.0], [1.0, 0.0, 0.0]])
    done = agreement(found, wanted, rounding, ["a", "a", "b"], np.array([False, False, True]))
    np.testing.assert_allclose(done.difference, [[0.0, 0.1, 1e-6], [0.2, 0.0, 0.0], [np.inf, 0.0, 0.0]])
    np.testing.assert_allclose(done.allowed, [[2e-6, 1e-6, 2e-6], [1e-6, 1e-6, 1e-6], [1e-6, 1e-6, 1e-6]])
    assert done.worst == (2, 0)


def test_outputs_are_forces_on_grids():
    """A product with any motion: -G u with levers, and the gain on elements in the axes of a layout."""
    rng = np.random.default_rng(3)
    motion = rng.normal(size=(5, 6))
    operator, lever, rotation = rng.normal(size=(2, 5, 3)), np.array([1, 4]), rng.normal(size=(2, 2, 3))
    wanted = -np.einsum("rnc,nc->r", operator, motion[:, :3]) - np.einsum("rlc,lc->r", rotation, motion[lever, 3:])
    np.testing.assert_allclose(acceleration_outputs(operator, lever, rotation).T @ motion.reshape(-1), wanted)
    axes, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    gain, node = rng.normal(size=(2, 18)), np.array([3, 0, 3])
    turned = np.concatenate([(axes @ motion[n].reshape(2, 3).T).T.reshape(-1) for n in node])
    np.testing.assert_allclose(read_out_outputs(gain, axes, node, 5).T @ motion.reshape(-1), gain @ turned)


UNMODELLED = {
    "CELAS2,77001,1.+3,1,1,2,1\nCELAS2,77002,1.+3,1,2,2,2": "CELAS2 77001, 77002",
    "PCOMP,77\n,1,.001,0.\nCQUAD4,77001,77,1,2,11,10": "CQUAD4 of PCOMP 77001",
    "RBE2,77001,1002,123,2,1.-5": r"RBE2 that expands \(ALPHA\) 77001",
    "RROD,77001,2,1002,1": "RROD 77001",
    "MATT1,1,7\nTABLEM1,7\n,0.,1.,1.,1.,ENDT": "MATT1 1, which depends on temperature",
}


@pytest.mark.parametrize("cards", UNMODELLED)
def test_what_has_no_thermal_coupling_is_refused_by_id(tmp_path, cards):
    path = tmp_path / "model.bdf"
    path.write_text(deck(1).replace("ENDDATA", f"{cards}\nENDDATA"))
    with pytest.raises(InputError, match=UNMODELLED[cards]) as error:
        coupled_structure(read_deck(path, cross_reference=False), path)
    assert error.value.where == str(path)
    assert "The embedded solver" in error.value.hint


def test_what_the_solver_alone_refuses_is_refused_too(tmp_path):
    path = tmp_path / "model.bdf"
    path.write_text(deck(1).replace("ENDDATA", "PARAM,INREL,-1\nENDDATA"))
    with pytest.raises(InputError, match="PARAM INREL"):
        coupled_structure(read_deck(path, cross_reference=False), path)
