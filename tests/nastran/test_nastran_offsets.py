"""Masses off their grids: bars, plates, laminates and CONM2 in frames of all kinds, and what is refused."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from tedm_cli.errors import InputError
from tedm_cli.nastran.geometry import ModelGeometry, model_geometry
from tedm_cli.nastran.reading import read_deck
from tedm_cli.stages.model.masses import properties_of

# Grid 2 has a cylindrical displacement frame about the basic z axis: at (0, 1, 0) its radial direction is basic y.
DECK = """SOL 101
CEND
BEGIN BULK
CORD2C,5,0,0.,0.,0.,0.,0.,1.,
,1.,0.,0.
CORD2R,6,0,0.,0.,0.,1.,0.,0.,
,0.,1.,0.
GRID,1,,0.,0.,0.
GRID,2,,0.,1.,0.,5
GRID,3,,1.,1.,0.
GRID,4,,1.,0.,0.
GRID,5,,0.,0.,1.
GRID,6,,0.,1.,1.
GRID,7,,1.,1.,1.
GRID,8,,1.,0.,1.
GRID,9,,0.,0.5,0.
MAT1,1,7.+10,,.3,2700.
MAT1,2,7.+10,,.3,5400.
PBAR,1,1,1.-4,1.-9,1.-9,1.-9
PSHELL,2,1,2.-3,1
PCOMP,3,0.,,,,,,,
,1,2.-3,0.,,2,2.-3,0.
PSOLID,4,1
{cards}
ENDDATA
"""


def read(folder: Path, cards: str) -> ModelGeometry:
    path = folder / "model.bdf"
    path.write_text(DECK.format(cards=cards), encoding="ascii")
    return model_geometry(read_deck(path), [path])


def test_bar_offsets_are_in_the_displacement_frames_of_the_grids(tmp_path: Path) -> None:
    g = read(tmp_path, "CBAR,1,1,1,2,0.,0.,1.\n,,,.01,.02,.03,.01,.02,.03")
    np.testing.assert_allclose(g.elements.lever, [[0.01, 0.02, 0.03], [-0.02, 0.01, 0.03]], rtol=0, atol=1e-15)
    np.testing.assert_allclose(properties_of(g).centre_m, [-0.005, 0.515, 0.03], rtol=0, atol=1e-15)


@pytest.mark.parametrize("order", ["1,4,3,2", "1,2,3,4"])
def test_plate_offset_is_along_its_normal(tmp_path: Path, order: str) -> None:
    g = read(tmp_path, f"CQUAD4,1,2,{order},0.,.005\nCTRIA3,2,2,{order[:5]},0.,.005")
    up = 1.0 if order == "1,4,3,2" else -1.0
    np.testing.assert_allclose(g.elements.lever, np.tile([0, 0, 0.005 * up], (7, 1)), rtol=0, atol=1e-17)


def test_laminate_of_two_densities_has_its_mass_off_its_middle(tmp_path: Path) -> None:
    """Plies of 2 mm from z = 0 (Z0 = 0): masses 1 and 2 at 1 and 3 mm, so 7/3 mm, and ZOFFS adds."""
    g = read(tmp_path, "CQUAD4,1,3,1,4,3,2,0.,.005")
    np.testing.assert_allclose(g.elements.lever[:, 2], 0.005 + 7e-3 / 3, rtol=1e-12)


@pytest.mark.filterwarnings("ignore:CONM2:UserWarning")
def test_concentrated_masses_off_their_grids(tmp_path: Path) -> None:
    """Frame 6 has z along basic x and x along basic y; CID = -1 gives the place itself."""
    cards = "CONM2,1,3,0,1.5,.1,.2,.3\nCONM2,2,3,6,1.5,.1,.2,.3\nCONM2,3,3,-1,1.5,.1,.2,.3\nCROD,9,8,1,4\nPROD,8,1,1.-4"
    g = read(tmp_path, cards)
    wanted = [[0.1, 0.2, 0.3], [0.3, 0.1, 0.2], [-0.9, -0.8, 0.3]]
    np.testing.assert_allclose(g.concentrated.lever, wanted, rtol=0, atol=1e-15)
    np.testing.assert_array_equal(g.concentrated.id, [1, 2, 3])


def test_missing_midside_nodes_leave_the_corners(tmp_path: Path) -> None:
    g = read(tmp_path, "CHEXA,7,4,1,2,3,4,5,6,\n,7,8,9,,,,,,\n,,,,,,,,")
    assert g.elements.partial == [7]
    assert np.diff(g.elements.node_offset) == [8]


@pytest.mark.parametrize(
    ("cards", "fact"),
    [
        ("CBAR,1,1,1,2,0.,1.,0.,GOO\n,,,.01,.02,.03,.01,.02,.03", "CBAR 1: its orientation vector lies along"),
    ],
)
def test_offsets_that_are_not_read_are_refused_by_name(tmp_path: Path, cards: str, fact: str) -> None:
    with pytest.raises(InputError, match=fact):
        read(tmp_path, cards)
