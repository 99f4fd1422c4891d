"""Rotation about a shell's normal: what of the displacements hangs on the weight that ties it (K6ROT)."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from fem_models import bars, nearest, structure
from shell_models import sheet, shells

from tedm_cli.cli.printing.model import solve_lines
from tedm_cli.errors import InputError
from tedm_cli.fem.static import StaticSolution
from tedm_cli.fem.structure import LoadCase
from tedm_cli.nastran.structure.deck import read_solver_deck
from tedm_cli.stages.model.solve import solve_deck

DEFAULT = 100.0  # PARAM,K6ROT of MSC and Siemens Nastran and of MYSTRAN


def cranked(k6rot, corners=4):
    """A panel, clamped at a side, with a post on it whose crank a warm strut pushes: the post twists the panel.

    The panel is 0.4 by 0.2 by 0.002 m, the post 0.1 m high, the crank 0.1 m long along x, the strut 0.2 m along y.
    """
    position, connectivity = sheet((8, 4), (0.4, 0.2), corners=corners)
    foot = nearest(position, (0.2, 0.1, 0.0))
    top = position[foot] + np.array([0.0, 0.0, 0.1])
    position = np.vstack([position, top + np.array([[0.0, 0.0, 0.0], [0.1, 0.0, 0.0], [0.1, 0.2, 0.0]])])
    head, tip, ground = range(len(position) - 3, len(position))
    panel = shells(connectivity, 2e-3, drilling=1e-6 * k6rot)
    clamped = [(row, "123456") for row in np.flatnonzero(position[:, 0] < 1e-9)]
    return structure(
        position,
        **{"quads" if corners == 4 else "trias": panel},
        bars=bars([[foot, head], [head, tip], [tip, ground]], (1.0, 1.0, 1.0)),
        held=[*clamped, (ground, "123456")],
    )


def motions(model, *fields):
    solution = StaticSolution(model)
    cases = [LoadCase(id=k, label="", temperature=t) for k, t in enumerate(fields)]
    return solution, np.array([motion for _, motion in solution.solve(cases)])


@pytest.mark.parametrize("corners", [3, 4])
def test_fem_drilling_change_is_that_of_a_second_solution(corners):
    model = cranked(DEFAULT, corners)
    warm = np.where(np.arange(model.n_grids) >= model.n_grids - 2, 1.0, 0.0)
    (soft, before), (_, after) = motions(model, warm), motions(cranked(100 * DEFAULT, corners), warm)
    found = soft.drilling_change()
    for part, change in ((slice(0, 3), found.translation), (slice(3, 6), found.rotation)):
        wanted = np.abs(after - before)[..., part].max() / np.abs(after[..., part]).max()
        assert change == pytest.approx(wanted, rel=1e-3)
    assert found.translation > 0.01


def test_fem_drilling_change_is_next_to_nothing_where_no_bar_twists_a_plate():
    position, connectivity = sheet((6, 4), (0.3, 0.2), distortion=0.2)
    held = [(row, "123456") for row in np.flatnonzero(position[:, 0] < 1e-9)]
    model = structure(position, quads=shells(connectivity, 2e-3, drilling=1e-6 * DEFAULT), held=held)
    solution, _ = motions(model, position[:, 1] / 0.2)
    assert solution.drilling_change().translation < 2e-4


def test_fem_drilling_is_not_judged_without_shells_or_without_drilling_stiffness():
    for model in (replace(cranked(DEFAULT), quads=shells(np.zeros((0, 4), int), 1.0)), cranked(0.0)):
        pinned = replace(model, bars=bars(model.bars.connectivity[1:], (1.0, 1.0, 1.0)))
        solution, _ = motions(pinned, np.zeros(model.n_grids))
        assert solution.drilling_change() is None


def deck_of(folder, *, above="", inside=("", ""), bulk=()):
    """The cranked post of `cranked` as a deck of two subcases, with PARAM lines above them, in them and in the bulk."""
    model = cranked(DEFAULT)
    lines = ["SOL 101", "CEND", "SPC = 1", above]
    for number, own in enumerate(inside, 1):
        lines += [f"SUBCASE {number}", f"  LABEL = A{number}", f"  TEMPERATURE(LOAD) = {number}", own]
    lines += ["BEGIN BULK", *bulk, "MAT1,1,7.+10,,.33,2700.,2.3-5", "PSHELL,1,1,.002,1,,1", "TEMPD,1,0.", "TEMPD,2,0."]
    lines += [f"GRID,{k},,{x:.6f},{y:.6f},{z:.6f}" for k, (x, y, z) in enumerate(model.position, 1)]
    lines += [
        f"CQUAD4,{k},1,{','.join(map(str, corners + 1))}" for k, corners in enumerate(model.quads.connectivity, 1)
    ]
    lines += [f"CBAR,{500 + k},2,{a + 1},{b + 1},1.,1.,1." for k, (a, b) in enumerate(model.bars.connectivity)]
    lines += ["PBAR,2,1,1.-4,3.-9,5.-9,6.-9", "PARAM,POST,-1", f"SPC1,1,123456,{model.n_grids}"]
    lines += [f"SPC1,1,123456,{row + 1}" for row in np.flatnonzero(model.position[:, 0] < 1e-9)]
    lines += [f"TEMP,{sid},{model.n_grids - 1},{sid}.,{model.n_grids},{sid}." for sid in (1, 2)]
    path = folder / "deck.bdf"
    path.write_text("\n".join([line for line in lines if line] + ["ENDDATA", ""]))
    return path


@pytest.mark.parametrize(
    ("where", "k6rot"),
    [
        ({}, 100.0),
        ({"bulk": ["PARAM,K6ROT,1.+4"]}, 1e4),
        ({"bulk": ["PARAM,K6ROT,1.+4"], "above": "PARAM,K6ROT,50."}, 50.0),
        ({"above": "PARAM,K6ROT,50.", "inside": ("PARAM,K6ROT,20.", "PARAM,K6ROT,20.")}, 20.0),
        ({"bulk": ["PARAM,K6ROT,0."]}, 0.0),
    ],
)
def test_fem_drilling_stiffness_is_that_of_the_deck_or_nastrans_default(tmp_path, where, k6rot):
    model, _ = read_solver_deck(deck_of(tmp_path, **where))
    shear = model.quads.membrane_stiffness[:, 2, 2]
    np.testing.assert_allclose(model.quads.drilling_stiffness, 1e-6 * k6rot * shear, rtol=1e-12)


@pytest.mark.parametrize(
    ("where", "fact"),
    [
        ({"inside": ("PARAM,K6ROT,20.", "")}, "different PARAM,K6ROT: 20. in subcase 1, none in subcase 2"),
        ({"bulk": ["PARAM,K6ROT,-1."]}, r"PARAM,K6ROT,-1.0: must be a number not below zero"),
        ({"above": "PARAM,K6ROT,STIFF"}, r"PARAM,K6ROT,STIFF: must be a number not below zero"),
        ({"above": "PARAM,INREL,-1"}, "PARAM INREL"),
    ],
)
def test_fem_parameters_that_cannot_be_followed_are_refused(tmp_path, where, fact):
    with pytest.raises(InputError, match=fact):
        read_solver_deck(deck_of(tmp_path, **where))


def test_fem_solve_says_when_the_drilling_stiffness_decides(tmp_path):
    report = solve_deck(deck_of(tmp_path), tmp_path / "out.op2")
    change = report.drilling_change
    assert change is not None
    assert change.translation > 0.01
    said = [line for line in solve_lines(tmp_path / "out.op2", report) if "K6ROT" in line]
    assert len(said) == 2
    assert f"(grid {change.moves}), rotations by up to {change.rotation:.2g} (grid {change.turns})" in said[0]
    assert change.turn[change.grid_id == change.turns] == change.rotation == change.turn.max()
    assert "spread what stands on a shell over its foot" in said[1]
    for part, advice in ((0.02, "spread the feet of optical elements"), (2e-4, "optical elements hardly feel it")):
        told = solve_lines(tmp_path / "out.op2", replace(report, turned_element=("M1", part)))
        note = next(line for line in told if line.startswith("note: the stiffness of shells"))
        assert f"; of optical elements by up to {part:.2g} (M1), each of the largest rotation" in note
        assert "with PARAM,K6ROT" in note
        assert advice in note
    deck = deck_of(tmp_path)
    post = next(line for line in deck.read_text().splitlines() if line.startswith("CBAR,500"))
    deck.write_text(deck.read_text().replace(post, f"{post}\n,4"))  # a pin that passes on no twist
    quiet = solve_deck(deck, tmp_path / "out.op2")
    change = quiet.drilling_change
    assert change is not None
    assert max(change.translation, change.rotation) < 1e-3
    assert not [line for line in solve_lines(tmp_path / "out.op2", quiet) if "K6ROT" in line]
