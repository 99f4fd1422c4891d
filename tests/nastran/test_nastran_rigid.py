"""Rigid elements as a check: right results pass to single precision, a wrong frame or deck is named."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from rod_model import one_load, read, write_deck

from tedm_cli.errors import PhysicsError
from tedm_cli.nastran.displacements import unit_load_displacements
from tedm_cli.nastran.frames import displacement_axes
from tedm_cli.nastran.geometry import ModelGeometry
from tedm_cli.nastran.op2.writer import write_op2
from tedm_cli.nastran.rigid import TOLERANCE, RigidLinks, check_rigidity, rigid_links, rigidity

# A cylindrical and a spherical frame, turned and moved; dependent grids in both, the independent ones in the basic
# frame (100) and in the cylindrical one (200). RBE2 1 ties all, 2 translations, 3 one direction of the grid's frame.
FRAMES = "CORD2C,4,0,.1,-.2,.3,.4,.3,.9\n,.8,-.5,.2\nCORD2S,5,0,-.3,.1,.2,.1,.9,.3\n,.7,.2,-.4"
RBE2 = "RBE2,1,100,123456,1,2,3\nRBE2,2,200,123,4,5,6\nRBE2,3,100,1,7,8"
GRIDS = [
    *((i, 0, tuple(np.round(np.random.default_rng(i).uniform(-1, 1, 3), 6)), (4, 5, 0)[i % 3]) for i in range(1, 9)),
    (100, 0, (0.4, 0.3, 0.2), 0),
    (200, 0, (-0.4, 0.1, 0.6), 4),
    (300, 0, (0.0, 0.0, 1.5), 0),
]


@pytest.fixture(scope="module")
def model(tmp_path_factory: pytest.TempPathFactory) -> tuple[RigidLinks, ModelGeometry]:
    deck, geometry = read(write_deck(tmp_path_factory.mktemp("rigid") / "deck.bdf", GRIDS, f"{FRAMES}\n{RBE2}"))
    return rigid_links(deck, geometry), geometry


def motion(geometry: ModelGeometry, seed: int, size: float = 1e-6) -> tuple[np.ndarray, np.ndarray]:
    """All grids move at will, but in the tied components as the rigid elements say."""
    random = np.random.default_rng(seed)
    t, r = size * random.normal(size=(2, len(geometry.grid_id), 3))
    axes = displacement_axes(geometry.position_m, geometry.displacement_frame, geometry.frames)
    assert axes is not None
    row = {int(g): i for i, g in enumerate(geometry.grid_id)}
    for leader, followers, translations, turns in ((100, (1, 2, 3), 3, 3), (200, (4, 5, 6), 3, 0), (100, (7, 8), 1, 0)):
        i = row[leader]
        for d in (row[f] for f in followers):
            rigid = t[i] + np.cross(r[i], geometry.position_m[d] - geometry.position_m[i])
            local, wanted = axes[d].T @ t[d], axes[d].T @ rigid
            local[:translations] = wanted[:translations]
            t[d] = axes[d] @ local
            if turns:
                r[d] = r[i]
    return t, r


def through_file(folder: Path, geometry: ModelGeometry, t: np.ndarray, r: np.ndarray) -> Path:
    axes = displacement_axes(geometry.position_m, geometry.displacement_frame, geometry.frames)
    assert axes is not None
    local = [np.einsum("nab,na->nb", axes, v) for v in (t, r)]
    write_op2(folder / "loads.op2", geometry.grid_id, [(1, "ALL", np.hstack(local))])
    return folder / "loads.op2"


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 10**6), st.floats(-12, 3))
def test_rigid_motion_has_no_residual(model: tuple[RigidLinks, ModelGeometry], seed: int, power: float) -> None:
    """In double precision, whatever the size of the motion."""
    links, geometry = model
    assert rigidity(links, *motion(geometry, seed, 10**power)).max() < 1e-13


def test_single_precision_passes(tmp_path: Path, model: tuple[RigidLinks, ModelGeometry]) -> None:
    links, geometry = model
    for seed in range(5):
        path = through_file(tmp_path, geometry, *motion(geometry, seed))
        ((_, t, r),) = unit_load_displacements([path], [one_load(geometry)], geometry)
        worst = check_rigidity(links, geometry.grid_id, t, r, where="")
        assert 1e-9 < worst < 2e-7 < TOLERANCE / 100


@pytest.mark.parametrize("cd", [4, 5])
def test_a_frame_that_is_ignored_is_found(tmp_path: Path, model: tuple[RigidLinks, ModelGeometry], cd: int) -> None:
    """The deck says CD = 0 where the results were written in a curved frame."""
    links, geometry = model
    path = through_file(tmp_path, geometry, *motion(geometry, 1))
    wrong = np.where(geometry.displacement_frame == cd, 0, geometry.displacement_frame)
    ((_, t, r),) = unit_load_displacements([path], [one_load(geometry)], replace(geometry, displacement_frame=wrong))
    fact = r"deck: subcase 1: RBE2 [12] is not rigid: grid \d does not follow grid [12]00, by 0\.\d+ of their motion"
    with pytest.raises(PhysicsError, match=fact) as caught:
        check_rigidity(links, geometry.grid_id, t, r, where="deck: subcase 1")
    assert "CD" in caught.value.hint


def test_a_grid_that_was_moved_is_found(model: tuple[RigidLinks, ModelGeometry]) -> None:
    """Results of a deck in which dependent grid 1 lay 5 mm off."""
    links, geometry = model
    lever = links.lever.copy()
    lever[0] += [0.0, 0.005, 0.0]
    assert rigidity(replace(links, lever=lever), *motion(geometry, 2))[0] > 5 * TOLERANCE


def test_only_tied_components_count(model: tuple[RigidLinks, ModelGeometry]) -> None:
    """Components that CM does not name, of the dependent grid's own frame, are free; those it names are not."""
    links, geometry = model
    axes = displacement_axes(geometry.position_m, geometry.displacement_frame, geometry.frames)
    assert axes is not None
    row = int(np.searchsorted(geometry.grid_id, 7))
    for direction, moved in ((0, True), (1, False), (2, False)):
        t, r = motion(geometry, 3)
        t[row] += 1e-6 * axes[row][:, direction]
        r[row] += 1.0
        assert bool(rigidity(links, t, r).max() > TOLERANCE) is moved
    t, r = motion(geometry, 3)
    r[0] *= 1.01
    assert rigidity(links, t, r).argmax() == 0
    assert rigidity(links, t, r).max() > TOLERANCE


def test_still_links_are_judged_against_the_largest_motion(model: tuple[RigidLinks, ModelGeometry]) -> None:
    """Solvers leave some 1e-12 of the largest motion everywhere; that is no broken link. No motion at all is none."""
    links, geometry = model
    t, r = motion(geometry, 4, 1e-18)
    t[-1] = 1e-6
    r[:8] += 1e-18
    t[:8] += 1e-18
    assert check_rigidity(links, geometry.grid_id, t, r, where="") < 1e-7
    assert check_rigidity(links, geometry.grid_id, 0.0 * t, 0.0 * r, where="") == 0.0


def test_expanding_and_absent_rigid_elements(tmp_path: Path) -> None:
    """RBE2 with ALPHA are not rigid when warm; a model without RBE2 has nothing to check."""
    expanding = "RBE2,1,100,123456,1,2,3,2.-5"
    for cards, count in ((f"{FRAMES}\n{expanding}", 0), (FRAMES, 0), (f"{FRAMES}\n{RBE2}", 8)):
        deck, geometry = read(write_deck(tmp_path / "deck.bdf", GRIDS, cards))
        links = rigid_links(deck, geometry)
        assert len(links.element) == count
        if not count:
            t, r = motion(geometry, 1)
            assert check_rigidity(links, geometry.grid_id, t, r, where="") == 0.0
