"""Derivatives by materials and thicknesses, against solutions of decks whose cards are changed."""

from __future__ import annotations

import re
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import cast

import numpy as np
import pytest

sys.path.append(str(Path(__file__).parents[1] / "areas"))

from strut_model import card, deck, define, project

from tedm_cli.adjoint.density import GravitySum
from tedm_cli.adjoint.materials import MaterialUse
from tedm_cli.contracts import UNIT_LOADS
from tedm_cli.fem.static import StaticSolution
from tedm_cli.files.store import Reader
from tedm_cli.gravity.structure import stack_rows, structure_gravity
from tedm_cli.gravity.testmass import TestMass
from tedm_cli.nastran.geometry import model_geometry
from tedm_cli.nastran.reading import cross_reference, deck_files, read_deck
from tedm_cli.nastran.structure.deck import solver_structure
from tedm_cli.nastran.structure.material_use import material_use
from tedm_cli.progress import silent
from tedm_cli.stages.adjoint.model import coupled_structure, warmed_model
from tedm_cli.stages.material_changes import MaterialChanges, gravity_of, material_changes, unit_motions
from tedm_cli.stages.model.deck import write_deck
from tedm_cli.stages.model.masses import distribution_of

# The upper plate has materials of its own for membrane (6, of the rod as well), bending (3) and shear (4), an offset
# and non-structural mass; a piece of it has corners of their own thickness, and another one of triangles.
MORE = "\n".join(
    [
        card("MAT1", 3, "9.+10", "", ".28", "3000.", "0.", "0."),
        card("MAT1", 4, "2.+10", "", ".3", "1000.", "1.-5", "0."),
        card("MAT1", 6, "1.2+11", "", ".3", "7800.", "1.2-5", "0."),
        card("PSHELL", 4, 6, ".008", 3, "", 4, "", "2."),
        "MAT11,5,6.+10,4.+10,5.+10,.2,.25,.3,2.+10\n,1.5+10,1.8+10,1900.,1.-6,5.-6,2.-5,0.",
        "CROD,8002,8002,2,1002\nPROD,8002,6,1.-4,1.-9,,.5",
        "CONM2,8100,1005,,3.,0.,0.,.02",
        "PARAM,K6ROT,1.+5\n",
    ]
)
AREAS = (
    define("BEND", kind='"gradient"', property="[1, 4]", direction="[0.0, 0.1, 1.0]")
    + define("SWAY", kind='"gradient"', property=2, direction="[1.0, 2.0, 0.0]")
    + define("LOWER", property=1, box="{ z_m = [-inf, 0.05] }")
    + define("UPPER", property=4, carrier='"elements"')
    + define("BLOCK", property=3)
    + define("STRUTS", property=2, carrier='"elements"')
    + define("ROD", property=8002, carrier='"elements"')
)
TEST_MASS = TestMass(name="TM", position_m=np.array([0.05, 0.02, 0.4]), side_m=np.full(3, 0.046), mass_kg=1.96)
HOW = GravitySum(test_masses=[TEST_MASS], tolerance=1e-9, constant=1.0, lumped=False)


def text() -> str:
    lines = deck(2, block=True).replace("PARAM,K6ROT,0.\n", MORE)
    lines = re.sub(r"(?m)^(PSOLID\* +3 +)1\b", r"\g<1>5", lines)
    lines, changed = re.subn(r"(?m)^(CQUAD4\* +10\d\d +)1\b", r"\g<1>4", lines)
    assert changed == 48
    found = re.findall(r"(?m)^(CQUAD4\* +(1001|1002|1048) .*\n.*\n)", lines)
    assert len(found) == 3
    for whole, number in found:
        a, b, c, d = (int(n) for n in whole.split()[3:5] + whole.split()[6:8])
        more = f"CQUAD4,{number},4,{a},{b},{c},{d},,.003\n,,,.008,.008,.008,.008\n"
        if number == "1002":
            more = f"CQUAD4,{number},4,{a},{b},{c},{d}\n,,1,1.5,1.5,1.5,1.5\n"
        if number == "1048":
            more = f"CTRIA3,1048,4,{a},{b},{c},,-.002\nCTRIA3,1049,4,{a},{c},{d},,-.002\n"
        lines = lines.replace(whole, more)
    return lines


@dataclass
class Solved:
    path: Path
    rows: np.ndarray
    value: np.ndarray
    changes: MaterialChanges
    use: MaterialUse


def gravity_rows(geometry) -> np.ndarray:
    """The whole operator as outputs [6 N, 6], by a quadrature of all mass."""
    masses = distribution_of(geometry)
    found = structure_gravity(masses, TEST_MASS, tolerance=HOW.tolerance, G=HOW.constant)
    out = np.zeros((len(geometry.grid_id), 6, 6))
    out[:, :3] = -stack_rows([found.operator]).transpose(1, 2, 0)
    out[masses.lever_node, 3:] = -stack_rows([found.rotation]).transpose(1, 2, 0)
    return out.reshape(-1, 6)


def geometry_of(raw, path):
    cross_reference(raw, path)
    return model_geometry(raw, deck_files(raw, path))


def solved_rows(path, rows, change=lambda raw: None, *, gravity=False):
    """Outputs [r, k] of the deck with changed cards; with those of gravity by its mass, if wanted."""
    raw = read_deck(path, cross_reference=False)
    change(raw)
    structure, cases = solver_structure(raw, path)
    if gravity:
        rows = np.concatenate([gravity_rows(geometry_of(raw, path)), rows[:, 6:]], axis=1)
    motions = [m.reshape(-1) for _, m in StaticSolution(structure).solve([c for c in cases if c.label != "UNIFORM"])]
    return rows.T @ np.array(motions).T, np.array(motions).T


@pytest.fixture(scope="module")
def solved(tmp_path_factory) -> Solved:
    path = write_deck(project(tmp_path_factory.mktemp("materials"), text(), AREAS), None).path
    raw = read_deck(path, cross_reference=False)
    use = material_use(raw)
    structure = coupled_structure(raw, path)
    model = warmed_model(raw, structure, [path], "UNIFORM")
    geometry = geometry_of(read_deck(path, cross_reference=False), path)
    others = np.random.default_rng(8).normal(size=(6 * structure.n_grids, 3))
    rows = np.concatenate([gravity_rows(geometry), others], axis=1)
    found = StaticSolution(structure).adjoint(rows, [f"{k}" for k in range(9)])
    value, motions = solved_rows(path, rows)
    gravity = gravity_of(geometry, use, np.ones(len(use.element_id), dtype=bool), HOW, silent)
    batches = iter([motions[:, :2], motions[:, 2:]])
    changes = material_changes(structure, use, found, model.own, model.areas, gravity, batches)
    return Solved(path, rows, value, changes, use)


def scaled(names, factor, mid):
    def change(raw):
        for name in names:
            value = getattr(raw.materials[mid], name)
            setattr(raw.materials[mid], name, factor * value)

    return change


def agree(found, wanted, tolerance):
    """Of each output and kind of area by itself: gradients (the first two), and means."""
    assert np.isfinite(found).all()
    for some in (slice(0, 2), slice(2, None)):
        size = np.abs(wanted[:, some]).max(axis=1, keepdims=True)
        assert (np.abs(found[:, some] - wanted[:, some]) <= tolerance * size).all()


MODULI = {"MAT1": ("e", "g"), "MAT11": ("e1", "e2", "e3", "g12", "g13", "g23")}
EXPANSIONS = {"MAT1": ("a",), "MAT11": ("a1", "a2", "a3")}
MATERIALS = {1: "MAT1", 2: "MAT1", 3: "MAT1", 4: "MAT1", 5: "MAT11", 6: "MAT1"}
STEP = 1e-3


@pytest.mark.parametrize("mid", MATERIALS)
def test_moduli(solved, mid):
    names = MODULI[MATERIALS[mid]]
    up, down = (solved_rows(solved.path, solved.rows, scaled(names, np.exp(s), mid))[0] for s in (STEP, -STEP))
    found = solved.changes.dlne[list(solved.use.material_id).index(mid)]
    assert np.abs(found).max() > 0.0
    agree(found, (up - down) / (2.0 * STEP), 1e-5)


def test_a_common_factor_of_all_moduli_changes_nothing(solved):
    total = solved.changes.dlne.sum(axis=0)
    size = np.abs(solved.changes.dlne).max(axis=0)
    assert (np.abs(total) < 1e-9 * size.max(axis=1, keepdims=True)).all()


@pytest.mark.parametrize("mid", [m for m in MATERIALS if m != 4])
def test_expansions(solved, mid):
    """y is linear in them: a difference is exact, however large. All directions grow by a factor, and by one sum."""
    names, row = EXPANSIONS[MATERIALS[mid]], list(solved.use.material_id).index(mid)
    without = solved_rows(solved.path, solved.rows, scaled(names, 0.0, mid))[0]

    def more(raw):
        for name in names:
            setattr(raw.materials[mid], name, getattr(raw.materials[mid], name) + 1e-5)

    by_one = (solved_rows(solved.path, solved.rows, more)[0] - solved.value) / 1e-5
    assert by_one.any()
    agree(solved.changes.dalpha[row], by_one, 1e-9)
    agree(solved.changes.dlnalpha[row], solved.value - without, 1e-9)
    assert solved.changes.dlnalpha[row].any() == (mid != 3)


def test_expansions_sum_to_the_output(solved):
    agree(solved.changes.dlnalpha.sum(axis=0), solved.value, 1e-9)
    assert not solved.changes.dalpha[list(solved.use.material_id).index(4)].any()  # of transverse shear alone


@pytest.mark.parametrize("mid", MATERIALS)
def test_densities(solved, mid):
    """Non-structural and concentrated masses stay; materials of bending and shear alone weigh nothing."""
    up, down = (solved_rows(solved.path, solved.rows, scaled(("rho",), f, mid), gravity=True)[0] for f in (1.5, 0.5))
    found, wanted = solved.changes.dlnrho[list(solved.use.material_id).index(mid)], up - down
    assert wanted[:6].any() == (mid not in (3, 4))
    assert not found[6:].any()
    agree(found, wanted, 1e-10)


@pytest.mark.parametrize("pid", [1, 4])
def test_thicknesses(solved, pid):
    """Stiffness, thermal forces and structural mass; corners with thicknesses of their own keep them."""

    def change(step):
        def changed(raw):
            raw.properties[pid].t *= np.exp(step)

        return solved_rows(solved.path, solved.rows, changed, gravity=True)[0]

    found = solved.changes.dlnt[list(solved.use.shell_property_id).index(pid)]
    agree(found, (change(STEP) - change(-STEP)) / (2.0 * STEP), 1e-5)


def test_which_material_is_whose(solved):
    use = solved.use
    np.testing.assert_array_equal(use.material_id, [1, 2, 3, 4, 5, 6])
    np.testing.assert_array_equal(use.shell_property_id, [1, 4])
    rows = np.searchsorted(use.element_id, [1, 1001, 1002, 1048, 5000, 7001, 8002])
    of = np.append(use.material_id, 0)  # row -1: none
    wanted = [[1, 1, 1], [6, 3, 4], [6, 3, 4], [6, 3, 4], [2, 2, 2], [5, 5, 5], [6, 6, 6]]
    np.testing.assert_array_equal(of[use.law[rows]], wanted)
    np.testing.assert_array_equal(of[use.mass[rows]], [1, 6, 6, 6, 2, 5, 6])
    np.testing.assert_array_equal(use.thickness[rows], [0, -1, 1, 1, -1, -1, -1])


def test_motions_are_per_unit_of_their_area():
    """Of 40 areas, more than are held at a time, with steps of their own."""
    rng = np.random.default_rng(2)
    data: dict[str, np.ndarray] = {
        UNIT_LOADS.AREA_LOAD_K: rng.uniform(1.0, 5.0, 40),
        UNIT_LOADS.TRANSLATION: rng.normal(size=(40, 3, 3)).astype(np.float32),
        UNIT_LOADS.ROTATION: rng.normal(size=(40, 3, 3)).astype(np.float32),
    }

    class File:
        array = dataset = staticmethod(data.__getitem__)

    found = np.concatenate(list(unit_motions(cast(Reader, File()))), axis=1)
    assert found.dtype == np.float64
    for area in (0, 16, 39):
        both = np.hstack([data[UNIT_LOADS.TRANSLATION][area], data[UNIT_LOADS.ROTATION][area]]).astype(float)
        np.testing.assert_array_equal(found[:, area], both.ravel() / data[UNIT_LOADS.AREA_LOAD_K][area])
