"""Every mistake about thermal nodes on the finite elements is one clear error."""

from __future__ import annotations

import pytest
from border_tools import Project, replace
from mapped_project import BY_ELEMENT, ELEMENTS, WAYS, K, refused, with_map

PLACES = [(2.0, 0.0, 0.0), (2.2, 0.0, 0.0), (2.0, 0.2, 0.0), (2.0, 0.0, 0.2)]
EDGES = ((0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3))
MIDDLES = [[(a + b) / 2 for a, b in zip(PLACES[i], PLACES[j], strict=True)] for i, j in EDGES]
TETRAHEDRON = "".join(f"GRID,{101 + k},,{x:.3f},{y:.3f},{z:.3f}\n" for k, (x, y, z) in enumerate([*PLACES, *MIDDLES]))
TETRAHEDRON += "CTETRA,9,1,101,102,103,104,105,106\n,107,108,109,110\n"


@pytest.mark.parametrize(
    ("text", "fact"),
    [
        ("set,LOW,HIGH,MID\nup,1,2,3\n", "nodes that the map does not have: 'MID'"),
        ("set,LOW,HIGHER\nup,1,2\n", "did you mean HIGH?; no column for HIGH"),
        ("set,LOW\nup,1\n", "no column for HIGH"),
        ("set,low,HIGH\nup,1,2\n", "names that differ in the case of letters: 'low' (in the map 'LOW')"),
        ("set,LOW,LOW,HIGH\nup,1,2,3\n", "node 'LOW' has two columns"),
        ("node,LOW,HIGH\nup,1,2\n", "must begin with the column set, found 'node'"),
        ("set;LOW;HIGH\nup;1;2\n", "divided by semicolons"),
        ("set,LOW,HIGH\nup,1\n", "tau.csv:2: 2 fields, the header has 3"),
        ("set,LOW,HIGH\nup,1,x\n", "tau.csv:2: HIGH must be a finite number, found 'x'"),
        ("set,LOW,HIGH\nup,1,nan\n", "HIGH must be a finite number"),
        ("set,LOW,HIGH\nup,1,1e9\n", "HIGH: temperature"),
        ("set,LOW,HIGH\n,1,2\n", "tau.csv:2: set is empty"),
        ("set,LOW,HIGH\nup,1,2\nUP,1,2\n", "tau.csv:3: set 'UP' is there twice"),
        ('set,LOW,HIGH\n"up\nFORCE,1",1,2\n', "the name of a set must be one line of printable text"),
        ("set,LOW,HIGH\n", "holds a header and nothing else"),
        ("", "is empty"),
    ],
)
def test_temperatures_that_are_none(two: Project, text: str, fact: str) -> None:
    (two.folder / "tau.csv").write_text(text)
    refused(two, 4, fact)


@pytest.mark.parametrize(
    ("text", "code", "fact"),
    [
        (BY_ELEMENT + "MID,2\n", 4, "nodes.csv:4: element 2 of node 'MID' is in line 3 already of node 'HIGH'"),
        ("tmm_node,element_id\nLOW,1\nLOW,1\nHIGH,2\n", 4, "nodes.csv:3: element 1 of node 'LOW' is in line 2 already"),
        ("tmm_node,element_id\nLOW,1\nlow,2\n", 4, "nodes.csv:3: node 'low' is also spelled 'LOW'"),
        ("tmm_node,element_id\nLOW,1\nHIGH,3\n", 4, "node 'HIGH' names 1 elements that the model lacks: 3"),
        ('tmm_node,element_id\n"LOW\tER",1\n', 4, "the name of a node must be one line of printable text"),
        ("tmm_node,element_id\nLOW,1.5\n", 4, "element_id must be a whole number"),
        ("tmm_node,element_id\nLOW,0\n", 4, "nodes.csv:2: element_id"),
        ("node,element\nLOW,1\n", 4, "must begin with the header tmm_node,element_id"),
    ],
)  # fmt: skip
def test_elements_that_are_none(two: Project, text: str, code: int, fact: str) -> None:
    (two.folder / "nodes.csv").write_text(text)
    refused(two, code, fact)


@pytest.mark.parametrize(
    ("text", "fact"),
    [
        ("[map]\n", "says of no node where it is"),
        ('[map]\nareas = true\nelements = "nodes.csv"\n', "gives elements and areas: these are different ways"),
        ('[map]\nweights = "w.csv"\n' + K, "with weights nothing conducts"),
        (ELEMENTS + "nearest_within_m = 0.1\n", "nearest_within_m is of nearest"),
        (ELEMENTS + 'unmapped = ["A", "a"]\n', "unmapped names an area twice"),
        (ELEMENTS + "[map.conductivity_W_m_K]\nx = 2.0\n", "'x' is no id of a material"),
        (ELEMENTS + "[map.conductivity_W_m_K]\n1 = -2.0\n", "conductivity"),
        (ELEMENTS + K + "7 = 2.0\n", "no conducting element has the material 7; there are: 1"),
        (WAYS["element"].replace("2:9", "1:9") + K, "map.node[1]: element 1 of node 'HIGH' is of node 'LOW' already"),
        (WAYS["element"].replace("2:9", "3:9") + K, "map.node[1].element: no element has the element 3:9"),
        (WAYS["element"].replace("HIGH", "low") + K, "node 'low' is there twice (as 'LOW')"),
        (WAYS["box"].replace("[0.1, 0.2]", "[0.7, 0.8]") + K, "map.node[1]: node 'HIGH' has no element"),
        (ELEMENTS + '[[map.node]]\nname = "low"\nelement = 2\n' + K, "node 'low' is also spelled 'LOW'"),
    ],
)
def test_maps_that_are_none(two: Project, text: str, fact: str) -> None:
    with_map(two, text)
    refused(two, 3, fact)


@pytest.mark.parametrize(
    ("text", "code", "fact"),
    [
        ("node,x_m,y_m,z_m\nLOW,.05,0,0\nHIGH,.15,0,0\nFAR,9,9,9\n", 3, "node 'FAR' is the nearest of no element"),
        ("node,x_m,y_m\nLOW,0.05,0.05\n", 4, "must have one column z_m"),
        ("node,x_m,y_m,z_m\nLOW,0.05,,\n", 4, "node 'LOW' has x_m alone of its place"),
        ("node,x_m,y_m,z_m\nLOW,,,\n", 4, "gives no node a place"),
        ("node,x_m,y_m,z_m\nLOW,0.05,0,0\nLOW,0.1,0,0\n", 4, "node 'LOW' is there twice"),
        ("node,x_m,y_m,z_m\nLOW,0.05,0,0\nlow,0.1,0,0\n", 4, "node 'low' is also spelled 'LOW'"),
    ],
)  # fmt: skip
def test_places_that_are_none(two: Project, text: str, code: int, fact: str) -> None:
    with_map(two, WAYS["nearest"] + K, places=text)
    refused(two, code, fact)


@pytest.mark.parametrize(
    ("weights", "code", "fact"),
    [
        ("node,area,weight\nA,LEFT,1\n", 3, "has no weights for RIGHT"),
        ("node,area,weight\nA,LEFT,1\nA,RIGHTS,1\n", 3, "is called 'RIGHTS'; did you mean RIGHT?"),
        ("node,area,weight\nA,LEFT,1\na,RIGHT,1\n", 4, "node 'a' is also spelled 'A'"),
    ],
)
def test_weights_that_are_none(two: Project, weights: str, code: int, fact: str) -> None:
    with_map(two, '[map]\nweights = "w.csv"\n', w=weights)
    refused(two, code, fact)


def test_nodes_that_others_fix(two: Project) -> None:
    """Two rods between the same grids."""
    replace(two.folder / "model.bdf", "PSOLID,1,1", "CONROD,21,1,5,1,1.-4\nCONROD,22,1,5,1,1.-4\nPSOLID,1,1")
    with_map(two, ELEMENTS + K, nodes=BY_ELEMENT + "ROD,21\nTWIN,22\n")
    refused(two, 5, "the averages of 1 thermal nodes follow from those of others", hint="join nodes")


def test_a_project_without_a_map(two: Project) -> None:
    with_map(two, "[frequency]\nlist_hz = [1.0]\n")
    refused(two, 3, "map: is missing")
    text = (two.folder / "tedm.toml").read_text()
    (two.folder / "tedm.toml").write_text(text.replace('thermal = "thermal.toml"\n', ""))
    refused(two, 3, "the project has no thermal model")


def test_areas_without_volume(two: Project) -> None:
    """Corners of a quadratic tetrahedron alone: the integrals of their shape functions are negative."""
    replace(two.folder / "model.bdf", "PSOLID,1,1", TETRAHEDRON + "PSOLID,1,1")
    with open(two.folder / "areas.csv", "a") as stream:
        stream.writelines(f"{g},{'CORNERS' if g < 105 else 'EDGES'}\n" for g in range(101, 111))
    replace(two.model, "rule = [", 'rule = [\n    { match = "*S", group = "bricks", shield = "inside" },')
    with_map(two, "[map]\nareas = true\n" + K)
    refused(two, 3, "area 'CORNERS' has no volume: its grids are corners of quadratic elements alone", hint="")


def test_conduction_that_no_number_holds(two: Project) -> None:
    """A conductivity of 1e5 through a membrane of nothing beside one of 1e-6: refused, or solved, but no fault."""
    replace(two.folder / "model.bdf", "PSOLID,1,1", "CONROD,21,1,9,2,1.-12\nMAT1,2,7.+10,,.33,2700.\nPSOLID,1,1")
    table = ELEMENTS + "[map.conductivity_W_m_K]\n1 = 1e5\n2 = 1e-6\n"
    with_map(two, table, nodes=BY_ELEMENT + "ROD,21\n", tau="set,LOW,HIGH,ROD\na,1,2,3\n")
    outcome = two.run("map-temperatures", two.folder / "tau.csv")
    assert outcome.code in (0, 5)
    assert "internal" not in outcome.err
