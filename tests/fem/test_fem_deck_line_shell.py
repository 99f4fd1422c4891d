"""Line, shell and rigid elements and frames of a deck, and a whole deck against a foreign solver."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from fem_models import YOUNG
from pyNastran.op2.op2 import read_op2

from tedm_cli.errors import InputError
from tedm_cli.fem.bars import bar_matrices
from tedm_cli.fem.static import StaticSolution
from tedm_cli.nastran.structure.deck import read_solver_deck
from tedm_cli.stages.model.solve import solve_deck

CONTROL = """SOL 101
CEND
SPC = 1
MPC = 3
SUBCASE 1
  LABEL = ALL
  TEMPERATURE(LOAD) = 1
BEGIN BULK
"""
CARDS = [
    # a cylindrical frame in a turned one; grid 3 at r = 0.2, theta = 90 degrees, z = 0.1, moving along r, theta, z
    "CORD2R,7,,1.,0.,0.,1.,0.,1.,\n,1.,1.,0.",  # x7 = y, y7 = -x, z7 = z, at (1, 0, 0)
    "CORD2C,8,7,0.,0.,0.,0.,0.,1.,\n,1.,0.,0.",
    "CORD1R,9,1,2,5",  # z from 1 to 2, x towards 5
    *("GRID,1,,0.,0.,0.", "GRID,2,,.2,0.,0.", "GRID,5,,0.,.2,0.", "GRID,6,,.2,.2,0."),
    *("GRID,3,8,.2,90.,.1,8", "GRID,4,9,.1,0.,.3", "GRID,10,,.3,.2,0.", "GRID,11,,.3,.3,0."),
    "CQUAD4,1,1,1,2,6,5,,.004\n,,1,1.5,1.5,1.5,1.5",
    "CTRIA3,2,2,6,10,11",
    "PSHELL,1,1,.002,1,2.,1,.8",
    "PSHELL,2,1,.003,1",
    "CBAR,3,3,3,4,1.,0.,0.,GGG\n,5,16,.01,0.,.02",
    "PBARL,3,1,,BOX\n,.04,.03,.002,.003",
    "CBEAM,4,4,2,10,0.,0.,1.",
    "PBEAM,4,1,2.-4,3.-9,4.-9,,5.-9",
    "CROD,5,5,10,11",
    "PROD,5,1,1.-4,2.-9",
    "CONROD,6,2,11,1,3.-4",
    "CTUBE,7,6,1,10",
    "PTUBE,6,1,.02,.002",
    "RBAR,8,1,4,,123456,123",
    "MPC,3,11,1,2.,6,3,-1.",
    "MAT1,1,7.+10,,.33,2700.,2.3-5,20.",
    "SPC1,1,123456,1",
    "TEMPD,1,21.",
    "PARAM,K6ROT,50.",
]


def write_deck(folder: Path, cards=CARDS) -> Path:
    path = folder / "deck.bdf"
    path.write_text(CONTROL + "\n".join(cards) + "\nENDDATA\n")
    return path


def test_fem_line_shell_and_rigid_elements_are_read(tmp_path):
    model, _ = read_solver_deck(write_deck(tmp_path))
    row = {int(grid): k for k, grid in enumerate(model.grid_id)}
    position, basis = model.position, model.displacement_frame
    assert basis is not None
    np.testing.assert_allclose(position[row[3]], [0.8, 0.0, 0.1], atol=1e-12)
    np.testing.assert_allclose(position[row[4]], [0.3, 0.1, 0.0], atol=1e-12)
    np.testing.assert_allclose(basis[row[3]], [[-1, 0, 0], [0, -1, 0], [0, 0, 1]], atol=1e-12)
    np.testing.assert_array_equal(basis[row[4]], np.eye(3))

    quad, tria = model.quads, model.trias
    direct, shear = YOUNG / (1 - 0.33**2), YOUNG / 2.66
    assert quad.membrane_stiffness[0, 0, 0] == pytest.approx(0.003 * direct, rel=1e-12)  # TFLAG 1: of the property's
    assert quad.bending_stiffness[0, 0, 1] == pytest.approx(2.0 * 0.003**3 / 12 * 0.33 * direct, rel=1e-12)
    assert (quad.offset[0], quad.reference_temperature[0]) == (0.004, 20.0)
    assert quad.shear_stiffness[0] == pytest.approx(0.8 * 0.003 * shear, rel=1e-6)
    assert quad.drilling_stiffness[0] == pytest.approx(50e-6 * 0.003 * shear, rel=1e-6)
    assert tria.shear_stiffness[0] == np.inf

    bar = model.bars
    np.testing.assert_array_equal(bar.element_id, [3, 4])
    np.testing.assert_allclose(bar.orientation[0], [-1.0, 0.0, 0.0], atol=1e-12)  # in the frame of end A
    np.testing.assert_allclose(bar.offset[0], [[-0.01, 0.0, 0.02], [0.0, 0.0, 0.0]], atol=1e-12)
    np.testing.assert_array_equal(np.flatnonzero(bar.released[0]), [4, 6, 11])
    width, height, flange, web = 0.04, 0.03, 0.002, 0.003
    inside = (width - 2 * web, height - 2 * flange)
    assert bar.area[0] == pytest.approx(width * height - inside[0] * inside[1], rel=1e-12)
    assert bar.inertia_1[0] == pytest.approx((width * height**3 - inside[0] * inside[1] ** 3) / 12, rel=1e-12)
    # Bredt: 4 area² / the integral of ds / t over the middle line
    middle = (width - web) * (height - flange)
    bredt = 4 * middle**2 / (2 * (width - web) / flange + 2 * (height - flange) / web)
    assert bar.torsion_constant[0] == pytest.approx(bredt, rel=1e-12)
    np.testing.assert_array_equal(bar.shear_factor[1], [1.0, 1.0])

    np.testing.assert_array_equal(model.rods.element_id, [5, 6, 7])
    np.testing.assert_allclose(model.rods.area, [1e-4, 3e-4, np.pi * (0.01**2 - 0.008**2)], rtol=1e-12)
    np.testing.assert_allclose(
        model.rods.torsion_constant, [2e-9, 0.0, np.pi / 2 * (0.01**4 - 0.008**4)], rtol=1e-12, atol=0
    )
    (arm,) = model.rbe2
    assert (arm.independent, list(arm.dependents), arm.components) == (row[4], [row[1]], "123")
    (equation,) = model.mpc
    assert list(equation.coefficients) == [2.0, -1.0]
    assert [list(equation.grids), list(equation.components)] == [[row[11], row[6]], [1, 3]]


@pytest.mark.parametrize(
    ("card", "components"),
    [
        ("RBAR,8,1,4,,123456,123", "123"),  # end B leads: the components of A follow
        ("RBAR,8,4,1,123456,,,123", "123"),  # end A leads: those of B
        ("RBAR,8,4,1,123456", "123456"),  # all that do not lead, where none are given
    ],
)
def test_fem_a_rigid_bar_is_led_by_either_end(tmp_path, card, components):
    cards = [card if other.startswith("RBAR") else other for other in CARDS]
    model, _ = read_solver_deck(write_deck(tmp_path, cards))
    (arm,) = model.rbe2
    row = {int(grid): k for k, grid in enumerate(model.grid_id)}
    assert (arm.independent, list(arm.dependents), arm.components) == (row[4], [row[1]], components)


@pytest.mark.parametrize(
    ("old", "new", "fact"),
    [
        ("GRID,3,8,.2,90.,.1,8", "GRID,3,80,.2,90.,.1,8", "GRID 3: frame 80"),
        ("GRID,3,8,.2,90.,.1,8", "GRID,3,8,.2,90.,.1,81", "GRID 3: frame 81"),
        ("CORD2C,8,7", "CORD2C,8,70", "CORD2C 8: frame 70"),
        ("CORD1R,9,1,2,5", "CORD1R,9,1,2,55", "CORD1R 9: grid 55"),
        ("CORD1R,9,1,2,5", "CORD1R,9,1,2,2", "cannot read the deck: CORD1R 9 1 2 2"),
        ("MPC,3,11,1", "MPC,3,12,1", "MPC set 3: grid 12"),
        ("MPC,3,11,1", "MPC,4,11,1", "case control selects MPC 3, which is not in the bulk data"),
        (",5,16,.01", ",5,17,.01", "CBAR 3: pins 17 are no components"),
        ("CTRIA3,2,2,6,10,11", "CTRIA3,2,2,6,10,0", "CTRIA3: grid 0 of element 2"),
        ("CROD,5,5,10,11", "CROD,5,5,10,0", "CROD, CONROD and CTUBE: grid 0 of element 5"),
        ("CROD,5,5", "CROD,5,6", "elements: PROD 6"),
        ("CONROD,6,2,11,1", "CONROD,6,2,11,9", "CONROD 6: MAT1 9"),
        ("PSHELL,2,1", "PSHELL,2,4", "PSHELL 2: MAT1 4"),
        ("MAT1,1,7.+10,,.33", "MAT1,1,7.+10,2.+10,.33", "E, G and NU of a shell do not agree"),
    ],
)
def test_fem_faulty_frames_and_references_are_named(tmp_path, old, new, fact):
    path = write_deck(tmp_path)
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new, 1))
    with pytest.raises(InputError, match=fact):
        read_solver_deck(path)


def test_fem_a_bar_without_area_bends_and_does_not_stretch(tmp_path):
    bar = ["PBAR,3,1,0.,3.-9,4.-9,5.-9"]
    model, _ = read_solver_deck(write_deck(tmp_path, [*bar, *(c for c in CARDS if not c.startswith("PBARL"))]))
    assert model.bars.area[0] == 0.0
    stiffness = bar_matrices(model.position, replace(model.bars, released=model.bars.released & False))
    matrix = stiffness.stiffness[0]
    assert np.isfinite(matrix).all()
    ends = model.position[model.bars.connectivity[0]]
    along = (ends[1] - ends[0]) / np.linalg.norm(ends[1] - ends[0])
    across = np.cross(along, [0.3, -0.5, 0.8])
    pulled, pushed = (np.concatenate([np.zeros(6), axis, np.zeros(3)]) for axis in (along, across))
    assert abs(pulled @ matrix @ pulled) < 0.2 * (pushed @ matrix @ pushed)  # the offsets let a pull bend it


def _corners():
    """A strip of 0.1 by 0.05 m in the cylindrical frame of `STRIP`: r and theta in degrees."""
    flat = np.array([[0.0, 1.0], [0.1, 1.0], [0.1, 1.05], [0.0, 1.05]])
    return np.stack([np.hypot(*flat.T), np.degrees(np.arctan2(flat[:, 1], flat[:, 0]))], axis=1)


STRIP = [
    "CORD2C,4,,0.,-1.,0.,0.,-1.,1.,\n,1.,-1.,0.",
    *(f"GRID,{k},4,{x:.14f},{y:.12f},0.,4" for k, (x, y) in enumerate(_corners(), 1)),
    *("CQUAD4,1,1,1,2,3,4", "PSHELL,1,1,.002,1,,1", "MAT1,1,7.+10,,.33,2700.,2.3-5"),
    *("SPC1,1,123456,1", "TEMPD,1,1."),
]


def test_fem_results_are_written_in_the_displacement_frames(tmp_path):
    deck, op2 = write_deck(tmp_path, STRIP), tmp_path / "out.op2"
    deck.write_text(deck.read_text().replace("MPC = 3\n", ""))
    report = solve_deck(deck, op2)
    assert report.others == {"bars": 0, "rods": 0, "CQUAD4": 1, "CTRIA3": 0}
    (table,) = read_op2(str(op2), include_results="displacements", debug=None).displacements.values()
    position = np.array([[0, 0], [0.1, 0], [0.1, 0.05], [0, 0.05]])
    radial = position + np.array([0.0, 1.0])
    radial /= np.linalg.norm(radial, axis=1, keepdims=True)
    grown = 2.3e-5 * position
    across = grown[:, 1] * radial[:, 0] - grown[:, 0] * radial[:, 1]
    np.testing.assert_allclose(table.data[0, :, 0], (grown * radial).sum(axis=1), rtol=1e-6, atol=1e-12)
    np.testing.assert_allclose(table.data[0, :, 1], across, rtol=1e-6, atol=1e-12)


def test_fem_mini_ltp_agrees_with_mystran(mini_ltp_dir):
    """Solids, shells, pinned bars and rigid elements: every grid, area and component, to the precision of the OP2.

    The deck gives no K6ROT: both solvers take Nastran's default of 100.
    """
    model, cases = read_solver_deck(mini_ltp_dir / "mini_ltp.bdf")
    tables = read_op2(str(mini_ltp_dir / "mini_ltp.op2"), include_results="displacements", debug=None).displacements
    plate = np.unique(model.quads.connectivity)
    solution = StaticSolution(model)
    for number, motion in solution.solve(cases):
        wanted = tables[number].data[0].astype(float)
        # MYSTRAN leaves the rotation about a plate's normal at zero, here it follows the plate.
        wanted[plate, 5] = motion[plate, 5]
        for part in (slice(0, 3), slice(3, 6)):
            assert np.abs(motion - wanted)[:, part].max() < 1e-7 * np.abs(wanted[:, part]).max()
