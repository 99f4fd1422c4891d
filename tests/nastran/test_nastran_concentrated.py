"""CONM1, CONM2 and scalar masses: what they weigh, where they are, and what is no body."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from mass_decks import deck, read

from tedm_cli.errors import InputError
from tedm_cli.nastran.masses.concentrated import Concentrated
from tedm_cli.stages.model.masses import properties_of

# Frame 6 has z along basic x and x along basic y; frame 5 is cylindrical about the basic z axis.
FRAMES = "CORD2C,5,0,0.,0.,0.,0.,0.,1.,\n,1.,0.,0.\nCORD2R,6,0,0.,0.,0.,1.,0.,0.,\n,0.,1.,0.\n"
ROD = "\nCROD,9,9,1,2\nPROD,9,1,1.-3"


def masses(folder: Path, cards: str) -> Concentrated:
    return read(folder, deck(FRAMES + cards + ROD)).concentrated


@pytest.mark.filterwarnings("ignore:CONM2:UserWarning")
def test_offsets_are_along_the_axes_that_the_frame_has_at_the_grid(tmp_path: Path) -> None:
    """Grid 4 is on the basic y axis, where the cylindrical frame has its radius along y and its angle along -x."""
    inertia = ",,\n,1.,.2,2.,.3,.4,3."
    c = masses(
        tmp_path, "\n".join(f"CONM2,{i},4,{cid},1.5,.1,.2,.3{inertia}" for i, cid in enumerate((0, 6, -1, 5), 1))
    )
    np.testing.assert_allclose(
        c.lever, [[0.1, 0.2, 0.3], [0.3, 0.1, 0.2], [0.1, -0.8, 0.3], [-0.2, 0.1, 0.3]], atol=1e-15
    )
    tensor = np.array([[1.0, -0.2, -0.3], [-0.2, 2.0, -0.4], [-0.3, -0.4, 3.0]])
    axes = {6: np.array([[0, 1, 0], [0, 0, 1], [1, 0, 0]]), 5: np.array([[0, 1, 0], [-1, 0, 0], [0, 0, 1]])}
    for found, wanted in zip(
        c.inertia, (tensor, axes[6].T @ tensor @ axes[6], tensor, axes[5].T @ tensor @ axes[5]), strict=True
    ):
        np.testing.assert_allclose(found, wanted, rtol=0, atol=1e-15)


def conm1(matrix: np.ndarray, cid: int = 0) -> str:
    lower = [f"{matrix[i, j]:.5f}" for i in range(6) for j in range(i + 1)]
    return f"CONM1,1,2,{cid},{','.join(lower[:5])}\n,{','.join(lower[5:13])}\n,{','.join(lower[13:])}"


def body(kg: float, w: np.ndarray, own: np.ndarray) -> np.ndarray:
    """Mass matrix of a body at w, from the kinetic energy of u + θ x w."""
    jacobian = np.hstack([np.eye(3), np.cross(np.eye(3), w).T])
    out = kg * jacobian.T @ jacobian
    out[3:, 3:] += own
    return np.asarray(out)


def test_the_matrix_of_a_body_is_that_body(tmp_path: Path) -> None:
    w, own = np.array([0.1, -0.2, 0.3]), np.diag([0.5, 0.25, 0.75])
    c = masses(tmp_path, conm1(body(2.0, w, own), 6))
    assert c.kg == pytest.approx([2.0], rel=1e-12)
    np.testing.assert_allclose(c.lever, [[0.3, 0.1, -0.2]], rtol=0, atol=1e-12)
    np.testing.assert_allclose(c.inertia[0], np.diag([0.75, 0.5, 0.25]), rtol=0, atol=1e-12)
    # the same as a CONM2
    two = masses(tmp_path, "CONM2,1,2,6,2.,.1,-.2,.3,,\n,.5,,.25,,,.75")
    np.testing.assert_allclose(two.inertia, c.inertia, rtol=0, atol=1e-12)


def test_three_equal_scalar_masses_are_a_mass(tmp_path: Path) -> None:
    cards = "CMASS2,1,.3,2,1\nCMASS2,2,.3,2,2\nCMASS1,3,8,2,3\nPMASS,8,.3\nCMASS2,4,.01,2,4\nCMASS2,5,7.,77\nSPOINT,77"
    c = masses(tmp_path, cards)
    assert (c.card, c.kg.tolist(), c.id.tolist()) == (["CMASS"], [pytest.approx(0.3)], [1])
    np.testing.assert_allclose(c.inertia[0], np.diag([0.01, 0, 0]))
    assert properties_of(read(tmp_path, deck(cards + ROD))).mass_kg == pytest.approx(2.3, rel=1e-12)


@pytest.mark.parametrize(
    ("cards", "fact"),
    [
        ("CMASS2,1,.3,2,1\nCMASS2,2,.3,2,2", "CMASS 1: the scalar masses of grid 2 differ by direction: 0.3, 0.3, 0"),
        ("CMASS2,1,.3,2,1,3,1", "CMASS2 1: a mass between two grids"),
        (conm1(np.diag([1.0, 1.0, 2.0, 0.0, 0.0, 0.0])), "CONM1 1: its mass differs by direction"),
        (conm1(np.eye(6) + 0.25 * np.eye(6, k=-3)), "CONM1 1: its static moments are impossible for a body"),
    ],
)
def test_what_is_no_body_is_named(tmp_path: Path, cards: str, fact: str) -> None:
    with pytest.raises(InputError, match=fact):
        masses(tmp_path, cards)
