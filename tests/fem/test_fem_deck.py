"""Deck in, OP2 out: what is read, what is refused, and that the file is a real one."""

from __future__ import annotations

import os

import numpy as np
import pytest
from deck_models import CASE_CONTROL, SIZE, bulk, write_deck
from fem_models import ALPHA, NU, YOUNG, block_mesh, nearest
from pyNastran.op2.op2 import read_op2

from tedm_cli.errors import InputError
from tedm_cli.fem.elasticity import isotropic_stiffness
from tedm_cli.fem.static import StaticSolution
from tedm_cli.nastran.structure.deck import read_solver_deck
from tedm_cli.stages.model.solve import solve_deck


def displacements(path):
    return read_op2(str(path), include_results="displacements", debug=None).displacements


def test_fem_deck_is_read_completely(tmp_path):
    structure, cases = read_solver_deck(write_deck(tmp_path))
    position, corners = block_mesh((2, 2, 2), SIZE)
    np.testing.assert_array_equal(structure.grid_id, [*range(1, 28), 80, 81, 90, 95])
    np.testing.assert_allclose(structure.position[:27], position, atol=1e-12)
    np.testing.assert_array_equal(structure.solids[0].connectivity, corners)
    (block,) = structure.solids
    assert (block.card, block.bubble, set(block.material)) == ("CHEXA", True, {0})
    np.testing.assert_allclose(block.materials.stiffness, [isotropic_stiffness(YOUNG, NU)])
    np.testing.assert_array_equal(block.materials.expansion, [[ALPHA] * 3 + [0.0] * 3])
    np.testing.assert_array_equal(block.materials.reference_temperature, [20.0])
    bar = structure.bars
    assert (bar.area[0], bar.inertia_1[0], bar.inertia_2[0], bar.torsion_constant[0]) == (
        1.131e-4,
        4.637e-9,
        3e-9,
        9.274e-9,
    )
    assert bar.shear_modulus[0] == pytest.approx(4.5e10 / 2.56)
    np.testing.assert_allclose(bar.orientation, [[0.85, 0.9, 0.0]])
    (hub,), (optic,) = structure.rbe2, structure.rbe3
    assert (hub.independent, hub.components, len(hub.dependents)) == (27, "123", 3)
    assert (optic.dependent, optic.components, list(optic.weights)) == (29, "123456", [1.0, 1.0, 2.0, 2.0])
    held = sorted(zip(structure.grid_id[structure.spc_grid], structure.spc_component, strict=True))
    upper = [nearest(position, p) + 1 for p in ((0, 0.2, 0.1), (0.3, 0.2, 0.1))]
    assert held == [(upper[0], 1), (upper[1], 1), *((81, c) for c in range(1, 7))]
    assert [(case.id, case.label) for case in cases] == [(3, "Left_Half, mixed Case"), (7, "STRUT"), (99, "UNIFORM")]
    assert cases[0].temperature is not None
    assert cases[1].temperature is not None
    np.testing.assert_array_equal(cases[0].temperature, np.where(structure.grid_id < 10, 21.0, 20.0))
    np.testing.assert_array_equal(np.flatnonzero(cases[1].temperature - 20.0), [27, 28])


def test_fem_deck_to_op2_keeps_labels_ids_and_motion(tmp_path):
    deck, op2 = write_deck(tmp_path), tmp_path / "deck.op2"
    seen = []
    report = solve_deck(deck, op2, lambda done, total, what: seen.append((done, total, what)))
    assert (report.n_grids, report.n_cases) == (31, 3)
    assert (report.solids, report.others["bars"]) == ({"CHEXA8 with bubbles": 8}, 1)
    assert report.static.unattached_grids == (95,)
    assert seen[-1] == (3, 3, "solve")
    structure, cases = read_solver_deck(deck)
    expected = dict(StaticSolution(structure).solve(cases))
    tables = displacements(op2)
    assert [(int(k), t.label) for k, t in tables.items()] == [(c.id, c.label) for c in cases]
    for number, table in tables.items():
        assert (table.table_name, table.data.shape) == ("OUGV1", (1, 31, 6))
        np.testing.assert_array_equal(table.node_gridtype, np.stack([structure.grid_id, np.ones(31)], axis=1))
        np.testing.assert_array_equal(table.data[0], expected[number].astype(np.float32))
    assert np.abs(tables[7].data).max() > 0.0


def test_fem_includes_are_followed(tmp_path):
    cards = bulk()
    (tmp_path / "mesh.bdf").write_text("\n".join(cards[:40]) + "\n")
    whole, _ = read_solver_deck(write_deck(tmp_path))
    split, _ = read_solver_deck(write_deck(tmp_path, ["INCLUDE 'mesh.bdf'", *cards[40:]]))
    np.testing.assert_array_equal(whole.solids[0].connectivity, split.solids[0].connectivity)


def test_fem_unmodelled_cards_are_named_all_at_once(tmp_path):
    extra = [
        "CQUAD8,200,20,1,2,3,4,5,6,\n,7,8",
        "CQUAD4,201,21,1,2,3,4,,.1,\n,,1,.1,.1,.1,.2",
        "CQUAD4,206,22,1,2,3,4",
        "PSHELL,21,1,.01,1,,1,,,\n,,,1",
        "PCOMP,22,,,,,,,,\n,1,.1,0.,YES",
        "CELAS2,202,1.+5,1,1,2,1",
        "RROD,7,1,2,1",
        "RBAR,8,80,81,123,456",
        "CBAR,203,2,80,81,95,,,GGO\n,456,,.1",
        "CBAR,205,4,80,81,0.,0.,1.,BGG",
        "PBARL,4,2,,I,\n,.1,.1,.1,.01,.01,.01",
        "CBEAM,207,5,80,81,95",
        "PBEAM,5,2,1.,1.,1.,,,,\n,,,,,,,,,\n,YES,1.,2.,1.,1.",
        "RBE2,204,300,123,81,2.-5",
        "PARAM,INREL,-1",
        "MATT1,1,3",
    ]
    with pytest.raises(InputError) as refusal:
        read_solver_deck(write_deck(tmp_path, bulk() + extra))
    for name in (
        *("CQUAD8 (1)", "PCOMP (1)", "CELAS2 (1)", "RROD (1)", "MATT1 (1)", "PARAM INREL (1)"),
        *("CQUAD4 with unequal corner thicknesses Ti (1)", "PSHELL with membrane-bending coupling MID4 (1)"),
        *("CBAR with OFFT GGO (1)", "CBAR with OFFT BGG (1)", "PBARL with section I (1)", "PBEAM that tapers (1)"),
        *("RBAR with independent freedoms at both ends (1)",),
        *("RBE2 with thermal expansion ALPHA (1)",),
    ):
        assert name in refusal.value.fact
    assert "CHEXA" not in refusal.value.fact
    assert "Nastran" in refusal.value.hint


@pytest.mark.parametrize(
    ("old", "new", "fact"),
    [
        ("SPC1,5,1,", "SPC1,5,1,4444,", "SPC set 4: grid 4444"),
        ("RBE2,61,80", "RBE2,61,880", "RBE2 61: grid 880"),
        ("CBAR,60,2,80,81", "CBAR,60,2,80,818", "CBAR and CBEAM: grid 818"),
        ("PSOLID,1,1", "PSOLID,1,17", "PSOLID 1: MAT1 or MAT9 or MAT11 17"),
        ("PSOLID,1,1", "PSOLID,14,1", "elements: PSOLID 1"),
        ("MAT1,1,7.+10,,.33", "MAT1,1,7.+10,,.5", r"MAT1 1: E = 7e\+10 and NU = 0.5 are not those of a solid"),
        ("TEMPD,32,20.", "TEMPD,33,20.", r"TEMP set 32: 27 grid\(s\) of elements have no temperature"),
        ("TEMP,31,1,21.", "TEMP,31,1,21.\nTEMP,31,1,22.", "grid 1 has two different temperatures"),
        ("TEMP,31,1,21.", "TEMP,31,4001,21.", "do not exist, the first is 4001"),
        ("TEMPD,99,21.", "TEMPD,98,21.", "TEMP set 99: selected by case control, but"),
        ("SOL 101", "SOL 103", "SOL 103 is not"),
        ("SPC = 4", "SPC = 40", "SPC 40, which is not in the bulk data"),
        ("SUBCASE 7", "SUBCASE 7\n  SPC = 5", "different SPC sets"),
        ("SUBCASE 7", "SUBCASE 7\n  LOAD = 13", "LOAD = 13 is selected, and no card defines this set"),
        ("SUBCASE 7", "SUBCASE 7\n  CLOAD = 12", "subcase 7 selects CLOAD"),
        ("  TEMP(LOAD) = 32\n", "", "subcase 7 has no TEMPERATURE"),
        ("SUBCASE 99", "SUBCOM 99", "SUBCOM: a unit load must not combine"),
        ("PBAR,2,2,1.131-4", "PBAR,2,2,-1.131-4", "PBAR 2: .* is negative"),
        ("CBAR,60,2,80,81,95", "CBAR,60,2,80,eighty", "pyNastran cannot read the deck"),
    ],
)
def test_fem_faulty_decks_say_what_is_wrong(tmp_path, old, new, fact):
    path = write_deck(tmp_path)
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new, 1))
    with pytest.raises(InputError, match=fact):
        read_solver_deck(path)


def test_fem_ranges_of_constraints_may_have_gaps(tmp_path):
    structure, _ = read_solver_deck(write_deck(tmp_path, [*bulk(), "SPC1,5,3,26,THRU,79"]))
    held = structure.grid_id[structure.spc_grid[structure.spc_component == 3]]
    np.testing.assert_array_equal(held, [26, 27, 81])


def test_fem_initial_temperatures_replace_the_reference(tmp_path):
    control = CASE_CONTROL.replace("SPC = 4", "SPC = 4\nTEMP(INITIAL) = 50")
    structure, _ = read_solver_deck(write_deck(tmp_path, [*bulk(), "TEMPD,50,21.", "TEMP,50,80,20."], control))
    assert structure.initial_temperature is not None
    np.testing.assert_array_equal(structure.initial_temperature, np.where(structure.grid_id == 80, 20.0, 21.0))


def test_fem_missing_and_empty_decks_are_refused(tmp_path):
    with pytest.raises(InputError, match="no such deck"):
        read_solver_deck(tmp_path / "none.bdf")
    with pytest.raises(InputError, match="no elements"):
        read_solver_deck(write_deck(tmp_path, ["GRID,1,,0.,0.,0.", "TEMPD,99,1."]))


def test_fem_unreadable_decks_leave_no_output_and_no_files(tmp_path, monkeypatch, capfd):
    monkeypatch.chdir(tmp_path)
    for cards in (["INCLUDE 'mesh.bdf'"], ["GRID,1,,abc"]):
        with pytest.raises(
            InputError,
            match=r"INCLUDE of a file that does not exist: .*mesh\.bdf|pyNastran cannot read the deck: .*ABC",
        ):
            read_solver_deck(write_deck(tmp_path, cards))
    assert capfd.readouterr() == ("", "")
    assert os.listdir(tmp_path) == ["deck.bdf"]
