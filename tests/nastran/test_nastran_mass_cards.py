"""Mass, centre of gravity and inertia of every card, against what is computed by hand."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from mass_decks import GRIDS, deck, read
from scipy.spatial.transform import Rotation

from tedm_cli.errors import InputError
from tedm_cli.nastran.masses.audit import check_sample
from tedm_cli.nastran.reading import read_deck
from tedm_cli.stages.model.masses import properties_of

BAR = "CBAR,1,1,1,2,0.,1.,0."
BEAM = "CBEAM,1,1,1,2,0.,1.,0."
QUAD = "CQUAD4,1,1,1,2,3,4"
SHELL = "PSHELL,1,1,.01,1,,1,,2."

# card, mass (kg), centre of gravity (m)
CARDS = {
    "CHEXA": ("CHEXA,1,1,1,2,3,4,5,6,\n,7,8\nPSOLID,1,1", 6000.0, (1, 0.5, 1.5)),
    "CPENTA": ("CPENTA,1,1,1,2,3,5,6,7\nPSOLID,1,1", 3000.0, (4 / 3, 1 / 3, 1.5)),
    "CTETRA": ("CTETRA,1,1,1,2,3,5\nPSOLID,1,1", 1000.0, (1, 0.25, 0.75)),
    "CROD": ("CROD,1,1,1,2\nPROD,1,1,1.-3,,,.5", 3.0, (1, 0, 0)),
    "CONROD": ("CONROD,1,1,2,2,1.-3,,,.5", 7.0, (1, 0, 0)),
    "CTUBE": ("CTUBE,1,1,1,2\nPTUBE,1,1,.1,.01,.5", 2 * (900 * np.pi * 1e-3 + 0.5), (1, 0, 0)),
    # area falls linearly from 900 to 400 pi mm2: centre at (2a + 4b) / (3a + 3b) of half the length
    "CTUBE tapered": ("CTUBE,1,1,1,2\nPTUBE,1,1,.1,.01,,.05", 1.3 * np.pi, (2 * (9 + 2 * 4) / (3 * 13), 0, 0)),
    "CBAR": (f"{BAR}\nPBAR,1,1,1.-3,1.,1.,1.,.5", 3.0, (1, 0, 0)),
    "PBARL": (f"{BAR}\nPBARL,1,1,,BAR\n,.1,.02,.5", 5.0, (1, 0, 0)),
    # ends WA, WB in the offset frame of the element: x along it, y towards the orientation, z
    "OFFT GOO": ("CBAR,1,1,1,2,0.,1.,0.,GOO\n,,,0.,.1,.2,0.,.3,.2\nPBAR,1,1,1.-3,1.,1.,1.", 2.0 * 1.0049876, None),
    "CBAR shortened": (f"{BAR}\n,,,.25,0.,0.,-.25,0.,0.\nPBAR,1,1,1.-3,1.,1.,1.", 1.5, (1, 0, 0)),
    "CBEAM": (f"{BEAM}\nPBEAM,1,1,1.-3,1.,1.,0.,1.,.5", 3.0, (1, 0, 0)),
    # 1e-3 to 3e-3 m2: 4 kg, centre at (a + 2b) / (3a + 3b) of the length
    "PBEAM tapered": (f"{BEAM}\nPBEAM,1,1,1.-3,1.,1.,0.,1.\n,,,,,,,,\n,YES,1.,3.-3,1.,1.,0.,1.", 4.0, (7 / 6, 0, 0)),
    # a polygon 1, 3, 2 (1e-3 m2) over x/xb 0, 0.5, 1: integral 9/4, first moment 7/24 + 22/24
    "PBEAM of three": (
        f"{BEAM}\nPBEAM,1,1,1.-3,1.,1.,0.,1.\n,,,,,,,,\n,YES,.5,3.-3,1.,1.,0.,1.\n,,,,,,,,\n,YES,1.,2.-3,1.,1.,0.,1.",
        4.5,
        (2 * (29 / 24) / (9 / 4), 0, 0),
    ),
    "PBEAML": (f"{BEAM}\nPBEAML,1,1,,BAR\n,.1,.02,.5,YES,1.,.1,.04,.5", 7.0, (2 * (2.5 + 2 * 4.5) / (3 * 7.0), 0, 0)),
    "CQUAD4": (f"{QUAD}\n{SHELL}", 24.0, (1, 0.5, 0)),
    "CQUADR": (f"CQUADR,1,1,1,2,3,4\n{SHELL}", 24.0, (1, 0.5, 0)),
    "CTRIA3": (f"CTRIA3,1,1,1,2,3\n{SHELL}", 12.0, (4 / 3, 1 / 3, 0)),
    "CTRIAR": (f"CTRIAR,1,1,1,2,3\n{SHELL}", 12.0, (4 / 3, 1 / 3, 0)),
    "ZOFFS": (f"CQUAD4,1,1,1,2,3,4,,.05\n{SHELL}", 24.0, (1, 0.5, 0.05)),
    "MID2 only": (f"{QUAD}\nPSHELL,1,,.01,2", 60.0, (1, 0.5, 0)),
    # thickness 10 and 30 mm at x = 0 and 2: 40 kg, centre at (a + 2b) / (3a + 3b) of the length
    "Ti": (f"{QUAD}\n,,,.01,.03,.03,.01\nPSHELL,1,1", 40.0, (7 / 6, 0.5, 0)),
    "TFLAG 1": (f"{QUAD}\n,,1,,3.,3.,\nPSHELL,1,1,.01", 40.0, (7 / 6, 0.5, 0)),
    # t = 10, 30, 10 mm at the corners: centre from the integrals of area coordinates, (1 + δij) / 12
    "Ti of CTRIA3": ("CTRIA3,1,1,1,2,3\n,,,.01,.03,.01\nPSHELL,1,1", 50 / 3, (1.4, 0.3, 0)),
    "CSHEAR": ("CSHEAR,1,1,1,2,3,4\nPSHEAR,1,1,.01,2.", 24.0, (1, 0.5, 0)),
    "PCOMP": (f"{QUAD}\nPCOMP,1,,2.\n,1,.001,0.,,2,.002,0.", 18.0, (1, 0.5, 2e-3 / 7)),
    "PCOMP SYM": (f"{QUAD}\nPCOMP,1,,2.,,,,,SYM\n,1,.001,0.,,8,.002,0.", 24.0, (1, 0.5, 0)),
    "PCOMPG": (f"{QUAD}\nPCOMPG,1,0.,2.\n,11,1,.004,0.", 12.0, (1, 0.5, 0.002)),
    "CPYRAM": ("CPYRAM,1,1,1,2,3,4,5\nPSOLID,1,1", 2000.0, None),
}


@pytest.mark.parametrize("name", CARDS)
def test_mass_and_centre_of_gravity(tmp_path: Path, name: str) -> None:
    cards, mass, centre = CARDS[name]
    g = read(tmp_path, deck(cards))
    check_sample(read_deck(g.files[0]), g)
    found = properties_of(g)
    assert found.mass_kg == pytest.approx(mass, rel=1e-7 if name == "OFFT GOO" else 1e-12)
    if centre is not None:
        np.testing.assert_allclose(found.centre_m, centre, rtol=0, atol=1e-13)


def test_quadratic_elements(tmp_path: Path) -> None:
    """Midside nodes in the middle change nothing, also where corner thicknesses are given."""
    xyz = {**GRIDS, **{9 + i: tuple(((np.array(GRIDS[a]) + GRIDS[b]) / 2).tolist()) for i, (a, b) in enumerate(EDGES)}}
    brick = "CHEXA,1,1,1,2,3,4,5,6,\n,7,8,9,10,11,12,13,14,\n,15,16,17,18,19,20\nPSOLID,1,1"
    found = properties_of(read(tmp_path, deck(brick, xyz)))
    assert found.mass_kg == pytest.approx(6000.0, rel=1e-12)
    np.testing.assert_allclose(np.diag(found.inertia_kg_m2), [5000.0, 6500.0, 2500.0], rtol=1e-12)
    plate = "CQUAD8,1,1,1,2,3,4,9,10,\n,11,12,.01,.03,.03,.01\nPSHELL,1,1"
    found = properties_of(read(tmp_path, deck(plate, xyz)))
    assert found.mass_kg == pytest.approx(40.0, rel=1e-12)
    np.testing.assert_allclose(found.centre_m, [7 / 6, 0.5, 0], rtol=0, atol=1e-13)
    # 10 + 10 x kg/m about 7/6: 10 (L³/3 + L⁴/4) - 40 (7/6)²
    assert found.inertia_kg_m2[1, 1] == pytest.approx(10 * (8 / 3 + 4) - 40 * 49 / 36, rel=1e-12)


EDGES = [(1, 2), (2, 3), (3, 4), (4, 1), (1, 5), (2, 6), (3, 7), (4, 8), (5, 6), (6, 7), (7, 8), (8, 5)]


def test_masses_of_a_beam_off_its_shear_centre(tmp_path: Path) -> None:
    """Structure (2 kg) at N = (0.01, 0.02), load (1 kg) at M = (0.04, -0.01) along the element's y and z."""
    beam = f"{BEAM}\nPBEAM,1,1,1.-3,1.,1.,0.,1.,.5\n,,,,,,,,\n,,,,,,,,\n,.04,-.01,.04,-.01,.01,.02,.01,.02"
    found = properties_of(read(tmp_path, deck(beam)))
    np.testing.assert_allclose(found.centre_m, [1, 0.02, 0.01], rtol=0, atol=1e-14)
    turned = beam.replace("0.,1.,0.", "0.,0.,1.")  # y along basic z, so z along minus basic y
    np.testing.assert_allclose(properties_of(read(tmp_path, deck(turned))).centre_m, [1, -0.01, 0.02], atol=1e-14)


def test_offsets_in_the_frame_of_the_element(tmp_path: Path) -> None:
    """Bar along y, v along z: offset frame x = basic y, y = basic z, z = basic x. End B in the frame of its grid."""
    cards = "CBAR,1,1,1,4,0.,0.,1.,{}\n,,,.01,.02,.03,.01,.02,.03\nPBAR,1,1,1.-3,1.,1.,1."
    for code, ends in {
        "GOO": [(0.03, 0.01, 0.02)] * 2,
        "GGO": [(0.01, 0.02, 0.03), (0.03, 0.01, 0.02)],
        "BOG": [(0.03, 0.01, 0.02), (0.01, 0.02, 0.03)],
        "GGG": [(0.01, 0.02, 0.03)] * 2,
    }.items():
        g = read(tmp_path, deck(cards.format(code)))
        np.testing.assert_allclose(g.elements.lever, ends, rtol=0, atol=1e-16, err_msg=code)


def test_wtmass_once(tmp_path: Path) -> None:
    cards = f"{QUAD}\n{SHELL}\nCONM2,9,1,,2.\nNSM1,5,PSHELL,1.,1\n"
    models = [read(tmp_path, deck(cards + extra, control="NSM = 5")) for extra in ("", "PARAM,WTMASS,.1")]
    plain, scaled = (properties_of(g) for g in models)
    assert plain.mass_kg == pytest.approx(28.0, rel=1e-12)
    assert scaled.mass_kg == pytest.approx(2.8, rel=1e-12)
    np.testing.assert_allclose(scaled.inertia_kg_m2, 0.1 * plain.inertia_kg_m2, rtol=0, atol=1e-13)
    assert [g.elements.density[0] for g in models] == pytest.approx([1000.0, 100.0], rel=1e-12)


def test_wtmass_of_case_control_replaces_that_of_the_bulk_data(tmp_path: Path) -> None:
    cards = f"{QUAD}\n{SHELL}\nPARAM,WTMASS,.5"
    assert read(tmp_path, deck(cards, control="PARAM,WTMASS,.1")).total_kg == pytest.approx(2.4, rel=1e-12)
    one = "SUBCASE 1\nPARAM,WTMASS,.1\nSUBCASE 2"
    with pytest.raises(InputError, match=r"different PARAM,WTMASS: \.1 in subcase 1, 0\.5 in subcase 2"):
        read(tmp_path, deck(cards, control=one))


MATRIX = "DMIG,MEX,0,6,1,0\n" + "\n".join(f"DMIG,MEX,1,{c},,1,{c},5." for c in (1, 2, 3))


def test_mass_of_a_matrix_is_refused_and_not_lost(tmp_path: Path) -> None:
    """5 kg on grid 1 by DMIG: selected they are refused, as nothing here weighs them; not selected they are no mass."""
    cards = f"{QUAD}\n{SHELL}\n{MATRIX}"
    for control in ("M2GG = MEX", "SUBCASE 7\nM2GG = .5*MEX, .5*MEX", "SUBCASE 7\nM2PP = MEX"):
        with pytest.raises(InputError, match=r"M2(GG|PP)"):
            read(tmp_path, deck(cards, control=control))
    assert read(tmp_path, deck(cards)).total_kg == pytest.approx(24.0, rel=1e-12)


ZOO = """CHEXA,1,1,1,2,3,4,5,6,
,7,8
CQUAD4,2,2,1,2,6,5,,.02
,,,.01,.02,.015,.01
CTRIA3,3,3,3,4,8,,.01
CBAR,4,4,1,7,0.,1.,0.,GOO
,,,.01,.02,.03,-.01,.02,.03
CBEAM,5,5,2,8,0.,0.,1.
CROD,6,6,3,5
CSHEAR,7,7,4,3,7,8
CONM2,11,7,90,2.,.1,.2,.3,,
,.1,.02,.3,.01,.03,.4
CONM1,12,6,90,1.,,1.,,
,1.,,-.3,.2,.23,.3,,-.1
,-.02,.2,-.2,.1,,-.03,-.06,.25
PSOLID,1,1
PSHELL,2,1,.01,1,,1,,2.
PCOMP,3,0.,1.
,1,.001,0.,,2,.002,0.
PBAR,4,1,1.-3,1.,1.,1.,.5
PBEAM,5,1,1.-3,1.,1.,0.,1.,.5
,,,,,,,,
,YES,1.,3.-3,1.,1.,0.,1.,.5
,,,,,,,,
,.04,-.01,.04,-.01,.01,.02,.01,.02
PROD,6,1,1.-3
PSHEAR,7,1,.01"""


def test_turned_model_has_turned_mass_properties(tmp_path: Path) -> None:
    """All grids in a turned and shifted system, as CP and, for what is given in displacement frames, as CD."""
    turn = Rotation.from_rotvec([0.4, -0.7, 0.3])
    shift = np.array([5.0, -3.0, 2.0])
    origin, z, xz = shift, shift + turn.apply([0, 0, 1.0]), shift + turn.apply([1.0, 0, 0])
    row = "{:<16s}" * 4
    numbers = [f"{v:.12f}" for v in np.concatenate([origin, z, xz])]
    rows = [row.format("90", "0", *numbers[:2]), row.format(*numbers[2:6]), "".join(f"{v:<16s}" for v in numbers[6:])]
    frame = f"CORD2R* {rows[0]}\n*       {rows[1]}\n*       {rows[2]}\n"
    plain = "CORD2R,90,,0.,0.,0.,0.,0.,1.\n,1.,0.,0.\n"
    first = properties_of(read(tmp_path, deck(plain + ZOO)))
    text = deck(frame + ZOO, cp="90")
    lines = [f"{line},90" if line.startswith("GRID") else line for line in text.splitlines()]
    second = properties_of(read(tmp_path, "\n".join(lines) + "\n"))
    assert second.mass_kg == pytest.approx(first.mass_kg, rel=1e-11)
    np.testing.assert_allclose(second.centre_m, shift + turn.apply(first.centre_m), rtol=0, atol=1e-10)
    matrix = turn.as_matrix()
    wanted = matrix @ first.inertia_kg_m2 @ matrix.T
    np.testing.assert_allclose(second.inertia_kg_m2, wanted, rtol=0, atol=1e-9 * np.abs(wanted).max())


@pytest.mark.parametrize("cp", ["C", "S"])
def test_grids_in_curvilinear_systems(tmp_path: Path, cp: str) -> None:
    """A ring of 1 kg points; cylindrical (r, θ, z) and spherical (r, θ, φ), degrees."""
    place = {1: (2.0, 30.0, 0.0), 2: (2.0, 150.0, 1.0)} if cp == "C" else {1: (2.0, 90.0, 30.0), 2: (2.0, 60.0, 150.0)}
    cards = f"CORD2{cp},90,,1.,0.,0.,1.,0.,1.\n,2.,0.,0.\nCROD,1,1,1,2\nPROD,1,1,1.-3"
    g = read(tmp_path, deck(cards, place, cp="90"))
    half = np.sqrt(3.0)
    second = [1 - half, 1, 1] if cp == "C" else [1 - 1.5, half / 2, 1]
    np.testing.assert_allclose(g.position_m, [[1 + half, 1, 0], second], rtol=0, atol=1e-14)


@pytest.mark.parametrize(
    ("cards", "fact"),
    [
        ("CBEND,1,1,1,2,0.,1.,0.,1\nPBEND,1,1,1.-3,1.,1.,1.", "CBEND 1: elements of this kind"),
        ("CTRIAX6,1,1,1,,2,,5", "CTRIAX6 1: elements of this kind"),
        ("CHEXA,1,1,1,2,3,4,5,6,\n,7,8\nPSOLID,1,1,,,,,PFLUID", "PSOLID 1: FCTN = PFLUID"),
        ("CHEXA,1,1,1,2,3,4,5,6,\n,7,8\nPSOLID,1,9\nMAT10,9,,1000.,1500.", "fluids .MAT10. are not read"),
        ("CHEXA,1,1,1,2,3,4,5,6,\n,7,8\nPLSOLID,1,9\nMATHP,9,1.,,1.,1000.", "PLSOLID 1: solids with this property"),
        (f"{QUAD}\nPSHELL,1,1", "CQUAD4 1: has no thickness"),
        ("CBAR,1,1,1,2,0.,1.,0.,OOO\n,,,.1\nPBAR,1,1,1.-3,1.,1.,1.", "CBAR 1: OFFT OOO is not read"),
    ],
)  # fmt: skip
def test_what_is_not_read_is_named(tmp_path: Path, cards: str, fact: str) -> None:
    with pytest.raises(InputError, match=fact):
        read(tmp_path, deck(cards))


def test_springs_and_dampers_have_no_mass_but_that_of_their_property(tmp_path: Path) -> None:
    cards = """CELAS2,11,1.+6,1,1
CELAS2,12,1.+6,1,2,77
SPOINT,77
CBUSH,13,13,1,2,,,,0
PBUSH,13,K,1.,1.
CBUSH,16,16,3,4,,,,0
PBUSH,16,K,1.,1.
,,M,5.
PLOTEL,14,1,3
CDAMP2,15,1.,1,3"""
    g = read(tmp_path, deck(f"{QUAD}\n{SHELL}\n{cards}"))
    np.testing.assert_allclose(g.elements.mass_kg, [24.0, 0, 0, 0, 0, 5.0], rtol=1e-12)
    assert properties_of(g).mass_kg == pytest.approx(29.0, rel=1e-12)
    check_sample(read_deck(g.files[0]), g)


def test_the_parts_of_a_distorted_block_add_up_to_it(tmp_path: Path) -> None:
    """A cube cut into 3 x 3 x 3 hexahedra with their inner grids moved at random: bilinear faces meet, so the volumes
    sum to the cube's. Height times mean face, pyNastran's volume, does not."""
    rng = np.random.default_rng(3)
    corner = {(i, j, k): 1 + i + 4 * j + 16 * k for i in range(4) for j in range(4) for k in range(4)}
    grids: dict[int, tuple[float, float, float]] = {}
    for (i, j, k), number in corner.items():
        inner = all(0 < n < 3 for n in (i, j, k))
        x = np.array([i, j, k]) / 3.0 + (rng.uniform(-0.1, 0.1, 3) if inner else 0.0)
        grids[number] = (float(x[0]), float(x[1]), float(x[2]))
    cards: list[str] = []
    for i, j, k in ((a, b, c) for a in range(3) for b in range(3) for c in range(3)):
        ring = [(0, 0), (1, 0), (1, 1), (0, 1)]
        n = [corner[i + a, j + b, k + c] for c in (0, 1) for a, b in ring]
        cards.append(f"CHEXA,{len(cards) + 1},1,{','.join(map(str, n[:6]))}\n,{n[6]},{n[7]}")
    g = read(tmp_path, deck("\n".join([*cards, "PSOLID,1,1"]), grids))
    assert g.total_kg == pytest.approx(1000.0, rel=1e-13)
    np.testing.assert_allclose(properties_of(g).centre_m, 0.5, rtol=0, atol=1e-13)
    model = read_deck(tmp_path / "model.bdf")
    check = check_sample(model, g)
    assert check.elements == 27
    assert check.largest == pytest.approx(0.0, abs=1e-14)
    theirs = np.array([model.elements[i].Mass() for i in g.elements.id])
    assert abs(theirs.sum() / 1000.0 - 1.0) > 1e-3
    assert np.abs(theirs / g.elements.mass_kg - 1.0).max() > 0.02
