"""Solids of a deck: every element, its integration by PSOLID, its material and the material's axes."""

from __future__ import annotations

import numpy as np
import pytest
from deck_models import SIZE, bulk, write_deck
from fem_models import KINDS, NU, YOUNG, solid_mesh

from tedm_cli.errors import InputError
from tedm_cli.fem.elasticity import isotropic_stiffness, orthotropic_stiffness, rotated
from tedm_cli.nastran.structure.deck import read_solver_deck


@pytest.mark.parametrize(
    ("fields", "bubble"),
    [
        *(("", True), (",,BUBBLE", True), (",,0,,REDUCED", True), (",,,,0", True)),
        *((",,TWO,,FULL", False), (",,2,,1", False), (",,,GAUSS,FULL", False)),
    ],
)
def test_fem_integration_of_linear_solids_follows_psolid(tmp_path, fields, bubble):
    cards = [card.replace("PSOLID,1,1", f"PSOLID,1,1{fields}") for card in bulk()]
    (block,) = read_solver_deck(write_deck(tmp_path, cards))[0].solids
    assert block.bubble is bubble


@pytest.mark.parametrize(
    ("fields", "fact"),
    [
        (",,TWO", "CHEXA of 8 nodes with PSOLID IN=TWO, ISOP= (8)"),
        (",,THREE,,FULL", "CHEXA of 8 nodes with PSOLID IN=THREE, ISOP=FULL (8)"),
        (",,BUBBLE,,FULL", "CHEXA of 8 nodes with PSOLID IN=BUBBLE, ISOP=FULL (8)"),
        (",,,,,PFLUID", "PSOLID with FCTN=PFLUID (8)"),
    ],
)
def test_fem_integration_that_is_not_modelled_is_refused_by_name(tmp_path, fields, fact):
    cards = [card.replace("PSOLID,1,1", f"PSOLID,1,1{fields}") for card in bulk()]
    with pytest.raises(InputError) as refusal:
        read_solver_deck(write_deck(tmp_path, cards))
    assert fact in refusal.value.fact


def solid_deck(folder, card, nodes, psolid="", missing=None):
    """A box of any solids, its connectivity, and the path of its deck."""
    position, connectivity = solid_mesh(card, nodes, (2, 1, 1), SIZE)
    grids = [f"GRID,{k},,{x:.9f},{y:.9f},{z:.9f}" for k, (x, y, z) in enumerate(position, 1)]
    cards = []
    for k, row in enumerate(connectivity + 1, 1):
        fields = [card, k, 1, *("" if n == missing else n for n in range(nodes))]
        fields[3:] = ["" if n == missing else g for n, g in enumerate(row)]
        lines = [fields[:9], *(["", *fields[i : i + 8]] for i in range(9, len(fields), 8))]
        cards += [",".join(map(str, line)) for line in lines]
    rest = [f"PSOLID,1,1{psolid}", "MAT1,1,7.+10,,.33,2700.,2.3-5", "SPC1,4,123,1,2,3"]
    rest += [card for t in (31, 32, 99) for card in (f"TEMPD,{t},0.", f"TEMP,{t},{t - 29 if t < 99 else 5},1.")]
    return connectivity, write_deck(folder, [*grids, *cards, *rest])


@pytest.mark.parametrize(("card", "nodes", "bubble"), KINDS)
def test_fem_every_solid_is_read_in_nastran_order(tmp_path, card, nodes, bubble):
    plain = ",,TWO,,FULL" if nodes in (6, 8) and not bubble else ""
    connectivity, path = solid_deck(tmp_path, card, nodes, plain)
    (block,) = read_solver_deck(path)[0].solids
    assert (block.card, block.bubble) == (card, bubble)
    np.testing.assert_array_equal(block.connectivity, connectivity)


@pytest.mark.parametrize(("card", "nodes", "elements"), [("CHEXA", 20, 2), ("CPENTA", 15, 4), ("CTETRA", 10, 12)])
def test_fem_solids_without_all_their_midside_nodes_are_refused(tmp_path, card, nodes, elements):
    with pytest.raises(InputError, match=rf"{card} with some midside nodes missing \({elements}\)"):
        read_solver_deck(solid_deck(tmp_path, card, nodes, missing=nodes - 2)[1])


@pytest.mark.parametrize("fields", [",,TWO,,FULL", ",,,,REDUCED", ",,BUBBLE"])
def test_fem_quadratic_solids_are_integrated_in_full_or_refused(tmp_path, fields):
    with pytest.raises(InputError, match=r"CHEXA of 20 nodes with PSOLID IN=.*, ISOP=.* \(2\)"):
        read_solver_deck(solid_deck(tmp_path, "CHEXA", 20, fields)[1])


MAT9 = """MAT9,1,11.+9,2.+9,1.+9,,,,12.+9,
,3.+9,,,,13.+9,,,,
,4.+9,,,5.+9,,6.+9,2700.,1.-6,
,2.-6,3.-6,4.-6,5.-6,6.-6,20."""
MAT11 = "MAT11,1,1.4+11,1.+10,9.+9,.3,.28,.4,5.+9,\n,4.5+9,3.5+9,1600.,-1.-6,3.-5,2.-5,20."


def deck_of_material(folder, card, cordm):
    # System 6 has its z along the basic x and its x along the basic y; system 7 is system 6 turned by 90° about that z.
    systems = ["CORD2R,6,,0.,0.,0.,1.,0.,0.,\n,0.,1.,0.", "CORD2R,7,6,0.,0.,0.,0.,0.,1.,\n,0.,1.,0."]
    systems += ["CORD2C,8,,0.,0.,0.,0.,0.,1.,\n,1.,0.,0."]
    cards = [one for one in bulk() if not one.startswith(("MAT1,1", "PSOLID"))]
    return write_deck(folder, [*cards, *systems, card, f"PSOLID,1,1,{cordm}"])


def test_fem_anisotropic_materials_are_read(tmp_path):
    table = read_solver_deck(deck_of_material(tmp_path, MAT9, 0))[0].solids[0].materials
    upper = np.zeros((6, 6))
    upper[0, :3], upper[1, 1:3], upper[range(2, 6), range(2, 6)] = (11, 2, 1), (12, 3), (13, 4, 5, 6)
    np.testing.assert_allclose(table.stiffness, [(np.triu(upper) + np.triu(upper, 1).T) * 1e9])
    np.testing.assert_allclose(table.expansion, [np.arange(1, 7) * 1e-6])
    assert table.reference_temperature == 20.0
    table = read_solver_deck(deck_of_material(tmp_path, MAT11, 0))[0].solids[0].materials
    constants = ([1.4e11, 1e10, 9e9], [0.3, 0.28, 0.4], [5e9, 4.5e9, 3.5e9])
    np.testing.assert_allclose(table.stiffness, [orthotropic_stiffness(*map(np.array, constants))], atol=1e-3)
    np.testing.assert_allclose(table.expansion, [[-1e-6, 3e-5, 2e-5, 0, 0, 0]])


def test_fem_material_axes_follow_cordm(tmp_path):
    straight = read_solver_deck(deck_of_material(tmp_path, MAT9, 0))[0].solids[0].materials
    turned = read_solver_deck(deck_of_material(tmp_path, MAT9, 7))[0].solids[0].materials
    # Axes of system 7 in the basic frame: x is basic z (system 6's y), y is minus basic y, z is basic x.
    axes = np.array([[0.0, 0.0, 1.0], [0.0, -1.0, 0.0], [1.0, 0.0, 0.0]])
    np.testing.assert_allclose(turned.expansion[0], [3e-6, 2e-6, 1e-6, -5e-6, -4e-6, 6e-6], atol=1e-20)
    expected = rotated(straight.stiffness[0], straight.expansion[0], axes)
    np.testing.assert_allclose(turned.stiffness[0], expected[0], atol=1e-3)


@pytest.mark.parametrize(
    ("card", "cordm", "fact"),
    [
        (MAT9, -1, r"MAT9 in element axes, PSOLID CORDM=-1 \(8\)"),
        (MAT11, 8, r"MAT11 in a curvilinear system, PSOLID CORDM=8 \(CORD2C\) \(8\)"),
        (MAT9, 44, r"PSOLID 1: CORD1R or CORD2R 44"),
        (MAT9.replace("11.+9", "-1.+9"), 0, "MAT9 1: the stiffness is not positive definite"),
        (MAT11.replace("1.4+11", "0."), 0, "MAT11 1: E1, E2, E3, G12, G13 and G23 must be positive"),
    ],
)
def test_fem_materials_that_are_not_modelled_are_refused(tmp_path, card, cordm, fact):
    with pytest.raises(InputError, match=fact):
        read_solver_deck(deck_of_material(tmp_path, card, cordm))


def test_fem_solids_follow_e_and_nu_whatever_g_and_axes(tmp_path):
    cards = [
        card.replace("MAT1,1,7.+10,,", "MAT1,1,7.+10,1.+10,").replace("PSOLID,1,1", "PSOLID,1,1,-1") for card in bulk()
    ]
    (block,) = read_solver_deck(write_deck(tmp_path, cards))[0].solids
    np.testing.assert_allclose(block.materials.stiffness, [isotropic_stiffness(YOUNG, NU)])
