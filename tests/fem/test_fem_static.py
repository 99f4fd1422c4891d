"""Whole structures of solids, bars and rigid elements: superposition, covariance, solvers, refusals, MYSTRAN."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from fem_models import (
    ALPHA,
    bars,
    block_mesh,
    determinate,
    hexes,
    nearest,
    rotated,
    rotation_matrix,
    solve,
    structure,
)
from solver_libraries import LIBRARIES

from tedm_cli.errors import PhysicsError
from tedm_cli.fem.assembly import assemble
from tedm_cli.fem.linear import factorise
from tedm_cli.fem.structure import Rbe2, Rbe3, Structure
from tedm_cli.nastran.reading import read_deck
from tedm_cli.nastran.structure.references import CardReferences
from tedm_cli.nastran.structure.solids import read_solids

SIZE = (0.4, 0.2, 0.1)


def bench(alpha=None, **changes) -> Structure:
    """A bench of solids on four clamped struts, each tied to it by a rigid hub, with one optical grid on top."""
    position, corners = block_mesh((6, 4, 2), SIZE, distortion=0.2)
    hubs = np.array([[x, y, -0.02] for x in (0.0, SIZE[0]) for y in (0.0, SIZE[1])])
    feet = hubs + (hubs - [0.2, 0.1, 0.0]) * [0.7, 0.9, 4.0]
    optic = np.array([[0.21, 0.11, 0.16]])
    n = len(position)
    everything = np.vstack([position, hubs, feet, optic])
    rbe2 = []
    for k, hub in enumerate(hubs):
        near = np.argsort(np.linalg.norm(position - hub, axis=1))[:4]
        rbe2.append(Rbe2(element_id=900 + k, independent=n + k, dependents=near, components="123"))
    top = np.argsort(np.linalg.norm(position - [0.2, 0.1, 0.1], axis=1))[:5]
    rbe3 = Rbe3(
        element_id=950,
        dependent=len(everything) - 1,
        components="123456",
        independents=top,
        weights=np.ones(5),
        independent_components=("123",) * 5,
    )
    expansion = ALPHA if alpha is not None else np.where(np.arange(len(corners)) % 3, 2e-8, 8.6e-6)
    struts = bars([[n + k, n + 4 + k] for k in range(4)], (0.1, 0.0, 1.0), alpha=4e-6 if alpha is None else alpha)
    parts = {
        "solids": hexes(corners, alpha=expansion),
        "bars": struts,
        "rbe2": tuple(rbe2),
        "rbe3": (rbe3,),
        "held": [(n + 4 + k, "123456") for k in range(4)],
    }
    return structure(everything, **{**parts, **changes})


def areas(model, number):
    """Indicator temperature of each of `number` areas that partition the grids."""
    label = np.random.default_rng(4).integers(0, number, model.n_grids)
    return [(label == k).astype(float) for k in range(number)]


def test_fem_areas_add_up_to_the_uniform_case_across_batches():
    model = bench()
    motion, report = solve(model, *areas(model, 37), 1.0)
    gap = np.abs(motion[:-1].sum(axis=0) - motion[-1])
    assert gap[:, :3].max() < 1e-12 * np.abs(motion[-1][:, :3]).max()
    assert gap[:, 3:].max() < 1e-12 * np.abs(motion[-1][:, 3:]).max()
    assert report.max_relative_residual < 1e-11


def test_fem_rotations_of_grids_of_solids_are_written_as_zero_and_of_others_are_not():
    model = bench()
    (motion,), report = solve(model, areas(model, 3)[0])
    solid = np.unique(model.solids[0].connectivity)
    assert (motion[solid, 3:] == 0.0).all()
    assert (np.abs(motion[len(solid) : len(solid) + 4, 3:]) > 0.0).any(axis=1).all()
    assert np.abs(motion[-1, 3:]).max() > 0.0
    assert report.n_dof == 3 * (len(solid) - 16) + 6 * 4


def test_fem_whole_structure_turns_with_its_coordinates():
    model = bench()
    turn = rotation_matrix((0.3, 1.0, -0.4), 2.0)
    heat = areas(model, 3)
    here, there = solve(model, *heat)[0], solve(rotated(model, turn), *heat)[0]
    for part in (slice(0, 3), slice(3, 6)):
        gap = np.abs(there[..., part] - here[..., part] @ turn.T).max()
        assert gap < 1e-10 * np.abs(here[..., part]).max()


def test_fem_structure_moved_away_deforms_alike():
    model = bench()
    heat = areas(model, 2)
    moved = replace(model, position=model.position + np.array([7.0, -30.0, 11.0]))
    here, there = solve(model, *heat)[0], solve(moved, *heat)[0]
    assert np.abs(there - here).max() < 1e-9 * np.abs(here).max()


def test_fem_reference_temperatures_and_initial_field():
    # Differences of loads at 293 K: a thousand times the rounding of a unit load.
    model = bench()
    heat = areas(model, 2)[0]
    plain = solve(model, heat)[0]
    (block,) = model.solids
    table = block.materials
    warm = replace(
        model,
        solids=(replace(block, materials=replace(table, reference_temperature=table.reference_temperature + 293.0)),),
        bars=replace(model.bars, reference_temperature=np.full(4, 293.0)),
    )
    assert np.abs(solve(warm, heat + 293.0)[0] - plain).max() < 1e-9 * np.abs(plain).max()
    start = np.linspace(280.0, 300.0, model.n_grids)
    initial = replace(warm, initial_temperature=start)
    assert np.abs(solve(initial, start + heat)[0] - plain).max() < 1e-9 * np.abs(plain).max()


@pytest.mark.parametrize("initial", [False, True])
def test_fem_a_small_step_keeps_its_digits_at_any_reference(initial):
    """Forces are those of the step: as a difference of forces at 293 K they would be a hundred times worse."""
    model = bench()
    heat = areas(model, 3)[1]
    plain = solve(model, heat)[0]
    (block,) = model.solids
    reference = block.materials.reference_temperature + (0.0 if initial else 293.0)
    warm = replace(
        model,
        solids=(replace(block, materials=replace(block.materials, reference_temperature=reference)),),
        bars=replace(model.bars, reference_temperature=np.full(4, 0.0 if initial else 293.0)),
        initial_temperature=np.full(model.n_grids, 293.0) if initial else None,
    )
    step = 2.0**-16  # K, exact in a sum with 293
    found = solve(warm, step * heat + 293.0)[0] / step
    assert np.abs(found - plain).max() < 1e-12 * np.abs(plain).max()


def box_model(held, **parts):
    position, corners = block_mesh((2, 2, 2), (0.3, 0.2, 0.1))
    return position, structure(position, solids=hexes(corners), held=held(position), **parts)


@pytest.mark.parametrize(
    ("held", "message"),
    [
        (lambda p: [], r"6 of 6 rigid-body modes \(translation x, translation y, translation z, rotation about x, "),
        (lambda p: [(nearest(p, (0.3, 0.2, 0.1)), "123")], r"3 of 6 .*\(rotation about x, rotation about y, rot"),
        (
            lambda p: [(nearest(p, (0, 0, 0)), "123"), (nearest(p, (0.3, 0.2, 0)), "123")],
            r"1 of 6 .*\(0.83, 0.55, 0.00\)",
        ),
        (
            lambda p: [(row, "3") for row in range(len(p))],
            r"3 of 6 .*\(translation x, translation y, rotation about z\)",
        ),
        (lambda p: determinate(p, (0.3, 0.2, 0.1))[:2], r"1 of 6 rigid-body modes \(rotation about x\)"),
    ],
)
def test_fem_free_rigid_motions_are_named(held, message):
    _, model = box_model(held)
    with pytest.raises(PhysicsError, match=message):
        solve(model, 1.0)


def test_fem_a_loose_part_beside_a_held_one_is_named():
    position, corners = block_mesh((2, 1, 1), (0.2, 0.1, 0.1))
    both = np.vstack([position, position + np.array([1.0, 0.0, 0.0])])
    model = structure(
        both, solids=hexes(np.vstack([corners, corners + 12])), held=determinate(position, (0.2, 0.1, 0.1))
    )
    with pytest.raises(PhysicsError, match=r"the 12 grid\(s\) from 13 to 24 keep 6 of 6"):
        solve(model, 1.0)


@pytest.mark.parametrize(("solver", "package", "name"), LIBRARIES)
@pytest.mark.parametrize("direction", [(0.0, 0.0, 1.0), (0.5, 0.3, 1.0)])
def test_fem_mechanisms_are_refused_and_located(solver, package, name, direction):
    # A post on a grid of solids: nothing stops it from turning about that grid.
    pytest.importorskip(package)
    position, corners = block_mesh((2, 2, 2), (0.3, 0.2, 0.1))
    foot = nearest(position, (0.15, 0.1, 0.1))
    everything = np.vstack([position, position[foot] + 0.3 * np.array(direction)])
    model = structure(
        everything,
        solids=hexes(corners),
        bars=bars([[foot, 27]], (1.0, 0.0, 0.0)),
        held=determinate(position, (0.3, 0.2, 0.1)),
    )
    with pytest.raises(PhysicsError, match=rf"a mechanism moves grid ({foot + 1}|28) component [1-6] most"):
        solve(model, 1.0, solver=solver)


def test_fem_a_long_chain_of_bars_is_soft_but_not_a_mechanism():
    n = 150
    position = np.linspace(0.0, 3.0, n + 1)[:, None] * np.array([0.6, 0.8, 0.0])
    block = bars(np.stack([np.arange(n), np.arange(1, n + 1)], axis=1), (0.0, 0.0, 1.0))
    (motion,), report = solve(structure(position, bars=block, held=[(0, "123456")]), 1.0)
    assert report.smallest_scaled_eigenvalue < 1e-7
    np.testing.assert_allclose(motion[-1, :3], ALPHA * position[-1], rtol=1e-6)


def test_fem_hub_in_line_with_its_grids_does_not_spin():
    # The hub sits on the line of its dependents up to rounding: its turn about that line has no stiffness but noise.
    position, corners = block_mesh((2, 2, 2), (0.3, 0.2, 0.1))
    line = [nearest(position, (x, 0.2, 0.1)) for x in (0.0, 0.15, 0.3)]
    everything = np.vstack([position, [0.2, np.nextafter(0.2, 1.0), np.nextafter(0.1, 1.0)]])
    hub = Rbe2(element_id=1, independent=27, dependents=np.array(line), components="123")
    model = structure(everything, solids=hexes(corners), rbe2=(hub,), held=determinate(position, (0.3, 0.2, 0.1)))
    (motion,), _ = solve(model, everything[:, 2])
    assert motion[27, 3] == 0.0
    assert np.abs(motion[27, 4:]).max() > 0.0


def test_fem_grids_without_stiffness_are_reported():
    position, model = box_model(lambda p: determinate(p, (0.3, 0.2, 0.1)))
    more = replace(model, grid_id=np.append(model.grid_id, 77), position=np.vstack([position, [1.0, 1.0, 1.0]]))
    (motion,), report = solve(more, 1.0)
    assert report.unattached_grids == (77,)
    assert (motion[-1] == 0.0).all()


def test_fem_inner_grids_agree_with_mystran(mini_ltp_dir):
    """Grids of solids alone, solved for with MYSTRAN's motion of all other grids, come out as MYSTRAN's."""
    from pyNastran.bdf.bdf import BDF
    from pyNastran.op2.op2 import read_op2

    deck = BDF(debug=None)
    deck.read_bdf(str(mini_ltp_dir / "mini_ltp.bdf"), xref=False)
    grids = np.array(sorted(deck.nodes))
    read = read_deck(mini_ltp_dir / "mini_ltp.bdf", cross_reference=False)
    blocks = read_solids(read, CardReferences(grids, mini_ltp_dir))
    assert [(block.card, block.bubble) for block in blocks] == [("CHEXA", False), ("CPENTA", False)]
    solid = [e for e in deck.elements.values() if e.type in ("CHEXA", "CPENTA")]
    strut = [e for e in deck.elements.values() if e.type == "CBAR" and e.pid == 7]
    tube, fibre = deck.properties[7], deck.materials[deck.properties[7].mid]
    struts = bars(
        np.searchsorted(grids, [e.nodes for e in strut]), [e.x for e in strut], i1=tube.i1, i2=tube.i2, area=tube.A
    )
    full = np.ones(len(strut))
    struts = replace(
        struts,
        torsion_constant=tube.j * full,
        youngs_modulus=fibre.e * full,
        shear_modulus=fibre.g * full,
        expansion=fibre.a * full,
        reference_temperature=fibre.tref * full,
    )
    model = Structure(grid_id=grids, position=np.array([deck.nodes[g].xyz for g in grids]), solids=blocks, bars=struts)
    operators = assemble(model)
    tables = read_op2(str(mini_ltp_dir / "mini_ltp.op2"), include_results="displacements", debug=None).displacements
    motion = np.stack([table.data[0].reshape(-1) for table in tables.values()], axis=1).astype(float)
    temperature = np.zeros((len(grids), len(tables)))
    for column, number in enumerate(tables):
        temperature[:, column] = deck.tempds[number].temperature
        for card in deck.loads.get(number, []):
            temperature[np.searchsorted(grids, list(card.temperatures)), column] = list(card.temperatures.values())

    ours = {e.eid for e in (*solid, *strut)}
    other = {g for e in deck.elements.values() if e.eid not in ours for g in e.nodes}
    for rigid in deck.rigid_elements.values():
        other |= set(rigid.Gijs[0]) | {rigid.refgrid} if rigid.type == "RBE3" else {rigid.gn, *rigid.Gmi}
    other |= {e.nodes[1] for e in strut if e.nodes[1] % 10 == 4}
    sides = [
        ({g for e in solid for g in e.nodes} - other, range(3)),
        ({g for e in strut for g in e.nodes} - other, range(6)),
    ]
    for members, components in sides:
        rows = np.searchsorted(grids, sorted(members))
        inner = (6 * rows[:, None] + np.array(components)).reshape(-1)
        outer = np.setdiff1d(np.arange(6 * len(grids)), inner)
        right = operators.thermal.forces(temperature)[inner] - operators.stiffness[inner][:, outer] @ motion[outer]
        solution = factorise(operators.stiffness[inner][:, inner]).solve(right)
        assert len(rows) > 20
        gap = np.abs(solution - motion[inner]).reshape(len(rows), len(components), -1)
        assert gap[:, :3].max() < 1e-7 * np.abs(motion).reshape(len(grids), 6, -1)[:, :3].max()
