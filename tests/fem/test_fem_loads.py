"""Forces, accelerations and motions of supports: known answers, superposition, equilibrium, and what is refused."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from fem_models import block_mesh, hexes
from load_models import CASES, bulk, deck
from pyNastran.op2.op2 import read_op2

from tedm_cli.deck_units import SYSTEMS, DeckUnits
from tedm_cli.errors import InputError, PhysicsError
from tedm_cli.fem.constraints import rigid_body_matrix
from tedm_cli.fem.mass import weight_per_acceleration
from tedm_cli.fem.static import StaticSolution
from tedm_cli.fem.structure import LoadCase, OnFreedoms, Structure
from tedm_cli.fem.supports import carried
from tedm_cli.nastran.geometry import model_geometry
from tedm_cli.nastran.loads.loads_deck import loads_deck, verify_loads_deck
from tedm_cli.nastran.loads.unit_deck import read_source
from tedm_cli.nastran.reading import read_deck
from tedm_cli.nastran.structure.deck import read_solver_deck
from tedm_cli.nastran.structure.masses import model_mass
from tedm_cli.stages.model.solve import solve_deck

YOUNG, AREA, INERTIA, LENGTH, DENSITY = 7.0e10, 1e-4, 2e-9, 0.8, 2700.0


def cantilever(bars: int, *more: str) -> list[str]:
    """Along x, held at its first grid, plane 1 along y; CBAR without shear."""
    x = np.linspace(0.0, LENGTH, bars + 1)
    return [
        *(f"GRID,{k},,{at:.6f},0.,0." for k, at in enumerate(x, 1)),
        *(f"CBAR,{k},1,{k},{k + 1},0.,1.,0." for k in range(1, bars + 1)),
        "PBAR,1,1,1.-4,2.-9,5.-9,6.-9",
        "MAT1,1,7.+10,,.3,2700.,,20.",
        "SPC1,1,123456,1",
        "PARAM,POST,-1",
        *more,
    ]


def solved(folder: Path, cards: list[str], cases: tuple[int, ...] = (11,)) -> dict[int, np.ndarray]:
    """Motions [N, 6] by subcase, in double precision."""
    path = deck(folder, cards, cases)
    structure, found = read_solver_deck(path)
    model = read_deck(path)
    mass = model_mass(model_geometry(model, [path]))
    return dict(StaticSolution(structure, mass=mass).solve(found))


def test_fem_a_cantilever_bends_twists_and_stretches_as_in_the_books(tmp_path: Path) -> None:
    tip = solved(
        tmp_path,
        cantilever(4, "FORCE,11,5,,10.,0.,1.,0.", "MOMENT,12,5,,2.,1.,0.,0.", "FORCE,13,5,,50.,1.,0.,0."),
        (11, 12, 13),
    )
    shear_modulus = YOUNG / 2.6
    assert tip[11][-1, 1] == pytest.approx(10.0 * LENGTH**3 / (3.0 * YOUNG * INERTIA), rel=1e-10)
    assert tip[11][-1, 5] == pytest.approx(10.0 * LENGTH**2 / (2.0 * YOUNG * INERTIA), rel=1e-10)
    assert tip[12][-1, 3] == pytest.approx(2.0 * LENGTH / (shear_modulus * 6e-9), rel=1e-10)
    assert tip[13][-1, 0] == pytest.approx(50.0 * LENGTH / (YOUNG * AREA), rel=1e-10)


def test_fem_weight_sags_a_cantilever_with_the_square_of_the_mesh(tmp_path: Path) -> None:
    """w L⁴ / (8 E I); the lumped masses of n bars are off by a share of 1/n²."""
    exact = DENSITY * AREA * 9.8 * LENGTH**4 / (8.0 * YOUNG * INERTIA)
    error = []
    for bars in (4, 8, 16):
        motion = solved(tmp_path, cantilever(bars, "GRAV,11,,9.8,0.,1.,0."))[11]
        error.append(abs(motion[-1, 1] / exact - 1.0))
    order = np.log2(np.array(error[:-1]) / error[1:])
    print("errors", error, "orders", order)
    assert error[-1] < 0.005
    assert (order > 1.95).all()


def test_fem_weight_pulls_on_all_mass_where_it_is(tmp_path: Path) -> None:
    """Forces and moments of a field along each axis are those of the masses that the field's law of gravity has."""
    path = deck(tmp_path, bulk())
    geometry = model_geometry(read_deck(path), [path])
    force = weight_per_acceleration(model_mass(geometry)).reshape(-1, 6, 3)
    e, c = geometry.elements, geometry.concentrated
    assert force[:, :3].sum(axis=0) == pytest.approx(geometry.total_kg * np.eye(3), abs=1e-12)
    moment = (
        force[:, 3:].sum(axis=0) + np.cross(geometry.position_m[:, None], force[:, :3].swapaxes(1, 2)).sum(axis=0).T
    )
    centre = np.zeros(3)  # kg m: of elements by their own quadrature over shape functions is that of their corners
    for k in range(len(e.id)):
        at = slice(e.node_offset[k], e.node_offset[k + 1])
        place = geometry.position_m[e.node_index[at]] + e.lever[at]
        corners = 4 if e.type[k] == "CTETRA" else len(place)  # midside grids are in the middle
        centre += e.mass_kg[k] * place[:corners].mean(axis=0)
    centre += c.kg @ (geometry.position_m[c.node] + c.lever)
    # m_k = (c × e_k); column k of the cross-product matrix of c
    wanted = np.cross(centre, np.eye(3)).T
    np.testing.assert_allclose(moment, wanted, atol=1e-9 * np.abs(wanted).max())


def test_fem_supports_that_move_as_one_carry_the_structure(tmp_path: Path) -> None:
    """The six rigid motions of all supports are those of all grids, to rounding."""
    structure, _ = read_solver_deck(deck(tmp_path, bulk()))
    motion = rigid_body_matrix(structure.position - np.array([0.3, 0.2, 0.1]))
    own = np.stack([structure.in_displacement_frames(motion[:, :, k]) for k in range(6)], axis=2)
    dof = 6 * structure.spc_grid + structure.spc_component - 1
    cases = [LoadCase(id=k, label="", enforced=OnFreedoms(dof, own[:, :, k].reshape(-1)[dof])) for k in range(6)]
    attached = ~np.isin(structure.grid_id, StaticSolution(structure).report.unattached_grids)
    stiff = (structure.grid_id < 1000) & attached  # grids of solids do not turn
    for k, found in StaticSolution(structure).solve(cases):
        np.testing.assert_allclose(found[:, :3], motion[:, :3, k], atol=2e-10)
        plate = structure.grid_id[stiff] < 21  # whose rotation about the normal has no stiffness here
        np.testing.assert_allclose(found[stiff][~plate, 3:], motion[stiff][~plate, 3:, k], atol=1e-9)


def mounted(rods: int) -> list[str]:
    """A plate on pinned rods from three of its corners to six places, or more: statically determinate with six."""
    cards = [f"GRID,{1 + 5 * i + j},,{0.1 * i:.1f},{0.1 * j:.1f},0." for i in range(5) for j in range(5)]
    for i in range(4):
        for j in range(4):
            a = 1 + 5 * i + j
            cards.append(f"CQUAD4,{1 + 4 * i + j},1,{a},{a + 5},{a + 6},{a + 1}")
    feet = [(1, (-0.2, 0.1, -0.3)), (1, (0.1, -0.2, -0.3)), (21, (0.5, -0.2, -0.3)), (21, (0.6, 0.2, -0.3))]
    feet += [(13, (0.3, 0.5, -0.3)), (13, (0.0, 0.4, -0.3)), (25, (0.6, 0.6, -0.3))]
    for number, (corner, (x, y, z)) in enumerate(feet[:rods]):
        foot = 101 + number
        cards += [f"GRID,{foot},,{x},{y},{z}", f"CROD,{foot},2,{foot},{corner}", f"SPC1,1,123,{foot}"]
    return [
        *cards,
        *("PSHELL,1,1,.005,1,,1", "PROD,2,1,1.-5", "MAT1,1,7.+10,,.3,2700.", "FORCE,11,1,,1.,1.,0.,0."),
    ]


@pytest.mark.parametrize(("rods", "rigid"), [(6, True), (7, False)])
def test_fem_an_isostatic_mount_transmits_rigid_motion_alone(tmp_path: Path, rods: int, rigid: bool) -> None:
    """Each foot along each axis: the plate moves as one, to rounding; a seventh rod bends it."""
    structure, _ = read_solver_deck(deck(tmp_path, mounted(rods), (11,)))
    plate = np.arange(25)
    cases: list[LoadCase] = []
    for foot in range(25, 25 + rods):
        for axis in range(3):
            enforced = carried(structure, np.array([foot]), structure.position[foot], axis)
            cases.append(LoadCase(id=len(cases) + 1, label="", enforced=enforced))
    bent = []
    for _, motion in StaticSolution(structure).solve(cases):
        modes = rigid_body_matrix(structure.position[plate])[:, :3].reshape(-1, 6)
        moved = motion[plate, :3].reshape(-1)
        bent.append(np.abs(moved - modes @ np.linalg.lstsq(modes, moved, rcond=None)[0]).max())
        assert rigid or np.abs(moved).max() > 0.0
    print("distortion by 1 m of a foot", max(bent))
    assert (max(bent) < 1e-9) if rigid else (max(bent) > 1e-3)


def test_fem_a_foot_moves_in_what_it_is_held_in() -> None:
    """Of a turned frame: one component of three is held, and takes its share; rotations need the size of a foot."""
    turned = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])  # columns: own x is along y
    structure = Structure(
        grid_id=np.array([1, 2]),
        position=np.array([[0.0, 0.0, 0.0], [2.0, 0.0, 0.0]]),
        displacement_frame=np.stack([turned, np.eye(3)]),
        spc_grid=np.array([0, 1, 1]),
        spc_component=np.array([1, 2, 3]),
    )
    both, middle = np.array([0, 1]), np.array([1.0, 0.0, 0.0])
    found = [carried(structure, both, middle, motion) for motion in range(6)]
    assert [dict(zip(f.dof.tolist(), f.value.tolist(), strict=True)) for f in found] == [
        {},
        {0: 1.0, 7: 1.0},
        {8: 1.0},
        {},
        {8: -1.0},
        {0: -1.0, 7: 1.0},
    ]


def test_fem_sums_of_sets_are_sums_of_motions(tmp_path: Path) -> None:
    found = solved(tmp_path, bulk(), CASES)
    wanted = 2.0 * (1.5 * found[11] - found[12] + 0.5 * found[13])
    np.testing.assert_allclose(found[17], wanted, atol=1e-9 * np.abs(wanted).max())


def test_fem_loads_and_temperatures_add_up(tmp_path: Path) -> None:
    """Of one subcase; a subcase of forces alone is free of thermal strain, whatever its grids' temperature is."""
    cards = cantilever(2, "FORCE,11,3,,10.,0.,1.,0.", "TEMPD,5,30.", "GRAV,12,,1.,0.,0.,1.")
    cards = [c.replace("2700.,,20.", "2700.,2.-5,20.") for c in cards]
    path = deck(tmp_path, cards)
    control = "SOL 101\nCEND\nSPC = 1\n"
    for k, lines in ((1, "LOAD = 11"), (2, "TEMP(LOAD) = 5"), (3, "LOAD = 11\nTEMP(LOAD) = 5"), (4, "LOAD = 12")):
        control += f"SUBCASE {k}\n{lines}\n"
    path.write_text(control + path.read_text()[path.read_text().index("BEGIN BULK") :])
    structure, cases = read_solver_deck(path)
    motion = dict(StaticSolution(structure).solve(cases[:3]))
    assert motion[1][-1, 0] == 0.0
    assert motion[2][-1, 0] == pytest.approx(2e-5 * 10.0 * LENGTH)
    np.testing.assert_allclose(motion[3], motion[1] + motion[2], atol=1e-14)
    with pytest.raises(PhysicsError, match=r"load case 4 .*: an acceleration pulls on mass, and there is none"):
        dict(StaticSolution(structure).solve(cases))


def test_fem_what_bubbles_change_is_told_under_forces_and_motions_too() -> None:
    """The estimate for other elements against a solution with them."""
    position, corners = block_mesh((6, 1, 1), (0.3, 0.05, 0.02))
    held = np.flatnonzero((position[:, 0] < 1e-9) | (position[:, 0] > 0.3 - 1e-9))
    model = Structure(
        grid_id=np.arange(len(position)) + 1,
        position=position,
        solids=hexes(corners),
        spc_grid=np.repeat(held, 3),
        spc_component=np.tile([1, 2, 3], len(held)),
    )
    far = held[position[held, 0] > 0.2]
    middle = 6 * np.flatnonzero(np.isclose(position[:, 0], 0.15)) + 2
    for case in (
        LoadCase(id=1, label="", enforced=OnFreedoms(6 * far + 2, np.full(len(far), 1e-4))),
        LoadCase(id=1, label="", force=OnFreedoms(middle, np.full(len(middle), 100.0))),
    ):
        stiff, soft = (StaticSolution(m) for m in (model, replace(model, solids=hexes(corners, bubble=True))))
        ((_, before),), ((_, after),) = stiff.solve([case]), soft.solve([case])
        wanted = np.linalg.norm((after - before)[:, :3]) / np.linalg.norm(after[:, :3])
        assert wanted > 4e-3
        assert stiff.bending_change() == pytest.approx(wanted, abs=1e-3)  # what the solver of it leaves


def test_fem_loads_in_millimetres_and_tonnes_move_the_same(tmp_path: Path) -> None:
    metres = [*cantilever(2), "FORCE,11,3,,10.,0.,1.,0.", "MOMENT,11,3,,2.,1.,0.,0.", "GRAV,11,,9.8,0.,0.,1."]
    metres += ["SPCD,11,1,1,1.-3,1,4,1.-3"]
    text = {
        **{f"GRID,{k},,{x:.6f}": f"GRID,{k},,{1e3 * x:.4f}" for k, x in ((2, 0.4), (3, 0.8))},
        "1.-4,2.-9,5.-9,6.-9": "100.,2000.,5000.,6000.",
        "7.+10,,.3,2700.": "7.+4,,.3,2.7-9",
        "MOMENT,11,3,,2.": "MOMENT,11,3,,2000.",
        "GRAV,11,,9.8": "GRAV,11,,9800.",
        "SPCD,11,1,1,1.-3": "SPCD,11,1,1,1.",
    }
    millimetres = []
    for line in metres:
        for old, new in text.items():
            line = line.replace(old, new)
        millimetres.append(line)
    found = []
    for name, cards, size in (("m-kg-s", metres, 1.0), ("mm-t-s", millimetres, 1e3)):
        units = DeckUnits(*SYSTEMS[name])
        path = deck(tmp_path / name, cards, (11,))
        solve_deck(path, tmp_path / name / "deck.op2", units=units)
        motion = read_op2(str(tmp_path / name / "deck.op2"), debug=None).displacements[11].data[0].astype(float)
        found.append(motion / np.repeat([size, 1.0], 3))
    np.testing.assert_allclose(found[1], found[0], rtol=1e-6)
    assert (np.abs(found[0][-1]) > 0.0).all()


def test_fem_loads_are_written_in_the_units_of_their_deck(tmp_path: Path) -> None:
    """Forces, moments, an acceleration, and motions along and about axes, of a deck in mm and t; read again in SI."""
    units = DeckUnits(*SYSTEMS["mm-t-s"])
    cards = [c.replace("0.400000", "400.").replace("0.800000", "800.") for c in cantilever(2, "TEMPD,1,20.")]
    cards = [c.replace("1.-4,2.-9,5.-9,6.-9", "100.,2000.,5000.,6000.") for c in cards]
    cards = [c.replace("7.+10,,.3,2700.", "7.+4,,.3,2.7-9") for c in cards]
    path = tmp_path / "model.bdf"
    path.write_text("SOL 101\nCEND\nSPC = 1\nBEGIN BULK\n" + "\n".join(cards) + "\nENDDATA\n")
    source = read_source(path, tmp_path / "scratch.bdf", units=units)
    wanted = [
        LoadCase(id=1, label="A", force=OnFreedoms(np.array([12, 13, 17]), np.array([3.0, -5.0, 0.25]))),
        LoadCase(id=2, label="B", acceleration=np.array([1.0, -2.0, 9.8])),
        LoadCase(id=3, label="C", enforced=OnFreedoms(np.array([0, 4]), np.array([1e-3, 2e-3]))),
    ]
    deck = loads_deck(source, wanted)
    out = tmp_path / "loads.bdf"
    out.write_text(deck.text)
    verify_loads_deck(out, out, source, deck, np.arange(6))
    _, found = read_solver_deck(out, units)
    assert [case.label for case in found] == ["A", "B", "C"]
    for one, other in zip(found, wanted, strict=True):
        for a, b in ((one.force, other.force), (one.enforced, other.enforced)):
            held = {} if b is None else dict(zip(b.dof.tolist(), b.value.tolist(), strict=True))
            seen = {} if a is None else {d: v for d, v in zip(a.dof.tolist(), a.value.tolist(), strict=True) if v}
            assert seen == pytest.approx(held, rel=1e-8)
        assert (one.acceleration is None) == (other.acceleration is None)
    assert found[1].acceleration == pytest.approx(wanted[1].acceleration, rel=1e-8)
    spoiled = out.read_text().replace("9.", "8.")
    out.write_text(spoiled)
    with pytest.raises(InputError, match=r"does not read back as it was meant"):
        verify_loads_deck(out, out, source, deck, np.arange(6))


@pytest.mark.parametrize(
    ("cards", "fact"),
    [
        ([], "LOAD = 11 is selected, and no card defines this set"),
        (["TEMPD,11,20."], "LOAD = 11 is selected, and no card defines this set"),
        (["FORCE,11,99,,1.,1.,0.,0."], "FORCE of set 11: names grid 99, which does not exist"),
        (["FORCE,11,2,4,1.,1.,0.,0."], "FORCE of set 11: names coordinate system 4, which does not exist"),
        (["SPCD,11,99,1,1.-3"], "SPCD of set 11: names grid 99, which does not exist"),
        (["SPCD,11,2,1,1.-3"], "SPCD of set 11: enforces grid 2 component 1, which is free"),
        (["SPCD,11,1,1,1.-3", "SPCD,11,1,1,2.-3"], "SPCD of set 11: enforces grid 1 component 1 twice"),
        (["SPC,1,1,1,1.-3", "SPC,1,1,1,2.-3"], "grid 1 component 1 has two enforced displacements, 0.001 and 0.002"),
        (["GRAV,11,8,1.,1.,0.,0.", "CORD2C,8,,0.,0.,0.,0.,0.,1.\n,1.,0.,0."], "system 8, which is curvilinear"),
        (["PLOAD1,11,1,FY,FR,0.,1.,1.,1."], "load set 11 has PLOAD1, which the embedded solver does not model"),
        (["LOAD,11,1.,1.,12"], "LOAD = 12 is selected, and no card defines this set"),
        (["LOAD,11,1.,1.,12", "LOAD,12,1.,1.,13"], "LOAD 11: combines set 12, which is a LOAD itself"),
        (["LOAD,11,1.,1.,12", "FORCE,11,2,,1.,1.,0.,0."], "LOAD 11: this set is given twice"),
        (["LOAD,11,1.,1.,12", "SPCD,12,1,1,1.-3"], "LOAD 11: combines set 12, which has SPCD cards"),
    ],
)
def test_fem_loads_that_mean_nothing_are_refused(tmp_path: Path, cards: list[str], fact: str) -> None:
    with pytest.raises(InputError, match=fact):
        read_solver_deck(deck(tmp_path, cantilever(2, *cards), (11,)))


def test_fem_a_field_of_gravity_needs_mass(tmp_path: Path) -> None:
    weightless = [c.replace("2700.", "") for c in cantilever(2, "GRAV,11,,1.,0.,0.,1.")]
    with pytest.raises(InputError, match="mass"):
        solve_deck(deck(tmp_path, weightless, (11,)), tmp_path / "deck.op2")
    assert not (tmp_path / "deck.op2").exists()
