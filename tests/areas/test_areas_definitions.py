"""Areas from their definitions: who gets each grid, in any coordinate system, and what is refused."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from tedm_cli.areas.definitions import DefinedAreas, define_areas, require_partition
from tedm_cli.config.base import Strict, validate
from tedm_cli.config.model.areas import AreasTable
from tedm_cli.errors import ConfigError, InputError
from tedm_cli.nastran.geometry import grids
from tedm_cli.nastran.membership import Membership, membership
from tedm_cli.nastran.reading import deck_files, read_deck

RULES = {"rule": [{"match": "*", "group": "all", "shield": "inside"}]}
# A row of six bricks along x with grids 1..28 (four to a plane), a plate on the first, a rod with a material of its own
# on the last, and grid 99 that only an RBE2 holds.
CONTROL = "SOL 101\nCEND\nSPC = 1\nSET 21 = 1 THRU 4, 9\nSET 5 = 1,2\nSET 30 = ALL\n"
BULK = """\
CORD2C,7,,0.,0.,0.,1.,0.,0.
,0.,1.,0.
CORD2S,8,7,0.,0.,0.,0.,0.,1.
,1.,0.,0.
CORD2R,9,,.3,.1,.2,.7,.5,.9
,.6,-.4,.1
PSOLID,1,1
PSOLID,2,2
PSOLID,3,2
PCOMP,40
,3,.001,0.,,1,.001,0.
MAT1,1,7.+10,,.33,2700.,2.3-5
MAT1,2,7.+10,,.33,2700.,2.3-5
MAT1,3,7.+10,,.33,2700.,2.3-5
MAT1,4,7.+10,,.33,2700.,2.3-5
CQUAD4,50,40,1,2,3,4
CONROD,60,25,27,4,1.-4
GRID,99,,0.,0.,9.
RBE2,70,99,123,1,2,3
SET1,101,1,THRU,8,500
SET1,5,1,2,3
SET3,102,ELEM,1,2
SET3,103,PROP,3,77
SET3,104,GRID,99
SET3,105,POINT,1
SPC1,1,123,1,2,3,4
ENDDATA
"""


class Document(Strict):
    areas: AreasTable


def deck_text(turned: Rotation | None = None, cp: str = "") -> str:
    lines = [CONTROL + "BEGIN BULK"]
    for i in range(7):
        for j, (y, z) in enumerate(((0.0, 0.0), (0.1, 0.0), (0.1, 0.1), (0.0, 0.1))):
            x = np.array([0.1 * i, y, z])
            x = x if turned is None else turned.apply(x)
            lines.append(f"GRID*,{4 * i + j + 1},{cp},{x[0]:.10f},{x[1]:.10f}\n*,{x[2]:.10f}")
    for e in range(6):
        n = 4 * e + 1
        lines.append(f"CHEXA,{e + 1},{1 + e // 2},{n},{n + 1},{n + 2},{n + 3},{n + 4},{n + 5}\n,{n + 6},{n + 7}")
    return "\n".join(lines) + "\n" + BULK


def members_of(path: Path, text: str) -> Membership:
    path.write_text(text)
    model = read_deck(path)
    return membership(model, grids(model, deck_files(model, path)), positions=True)


@pytest.fixture(scope="module")
def row(tmp_path_factory: pytest.TempPathFactory) -> Membership:
    return members_of(tmp_path_factory.mktemp("row") / "row.bdf", deck_text())


def define(row: Membership, *tables: dict[str, Any], listed: dict[str, Any] | None = None, **more: Any) -> DefinedAreas:
    document = validate(Document, {"areas": {**RULES, **more, "define": list(tables)}}, where="model.toml")
    return define_areas(row, document.areas, listed or {}, where="model.toml")


def one(row: Membership, **criteria: Any) -> list[int]:
    return [int(i) for i in define(row, {"name": "A", **criteria}).loads["A"].grid_id]


def planes(*numbers: int) -> list[int]:
    """Grids of the planes x = 0.1 n."""
    return [4 * n + j + 1 for n in numbers for j in range(4)]


@pytest.mark.parametrize(
    ("criteria", "wanted"),
    [
        ({"property": 1}, planes(0, 1, 2)),
        ({"property": "2:39"}, planes(2, 3, 4, 5, 6)),
        ({"property": [1, 40]}, planes(0, 1, 2)),
        ({"material": 2}, planes(2, 3, 4, 5, 6)),
        ({"material": 3}, planes(0)),  # a layer of the plate
        ({"material": 4}, [25, 27]),  # of an element without property
        ({"element": ["2:3", 60]}, [*planes(1, 2, 3), 25, 27]),
        ({"element": "1:4", "property": 2}, planes(2, 3, 4)),  # elements that are both, not grids of each
        ({"element": 2, "property": 1, "box": {"x_m": [0.2, 1.0]}}, planes(2)),
        ({"set": 101}, planes(0, 1)),
        ({"set": 102}, planes(0, 1, 2)),
        ({"set": 103}, planes(4, 5, 6)),
        ({"set": 21}, [1, 2, 3, 4, 9]),
        ({"set": 30}, planes(*range(7))),  # all with stiffness: grid 99 has none
        ({"set": [21, 102], "box": {"z_m": [0.05, 1.0]}}, [3, 4, 7, 8, 11, 12]),
        ({"box": {"x_m": [0.1, 0.3]}}, planes(1, 2, 3)),
        ({"box": {"x_m": [-float("inf"), 0.05]}}, planes(0)),
        ({"box": [{"x_m": [0.1, 0.12]}, {"x_m": [0.5, 0.6]}]}, planes(1, 5, 6)),
        ({"box": {"frame": 7, "z_m": [0.55, 1.0]}}, planes(6)),  # the cylinder's axis is x
        ({"box": {"frame": 7, "r_m": [0.05, 0.11]}}, [i for i in planes(*range(7)) if i % 4 in (2, 0)]),
        ({"box": {"frame": 7, "theta_deg": [10.0, 80.0]}}, [i for i in planes(*range(7)) if i % 4 == 3]),
        ({"box": {"frame": 7, "theta_deg": [10.0, 45.0]}}, planes(*range(7))[2::4]),  # both ends belong to a box
        ({"box": {"frame": 7, "theta_deg": [45.0, 80.0]}}, planes(*range(7))[2::4]),
        ({"box": {"frame": 7, "theta_deg": [-315.0, -310.0]}}, planes(*range(7))[2::4]),
        ({"box": {"frame": 7, "theta_deg": [350.0, 370.0], "r_m": [0.05, 1.0]}}, planes(*range(7))[1::4]),
        ({"property": 1, "also": [{"element": 6}]}, planes(0, 1, 2, 5, 6)),
        ({"remainder": True}, planes(*range(7))),
    ],
    ids=lambda v: str(v)[:50] if isinstance(v, dict) else "",
)
def test_one_definition(row: Membership, criteria: dict[str, Any], wanted: list[int]) -> None:
    found = one(row, **criteria)
    angles = criteria.get("box", {}) if isinstance(criteria.get("box"), dict) else {}
    if angles.get("theta_deg") == [350.0, 370.0]:  # y axis of system 7 is not known beforehand: compare by geometry
        c = row.coordinates(7, row.position_m)
        near = (np.minimum(c["theta_deg"] % 360, 360 - c["theta_deg"] % 360) <= 10) & (c["r_m"] > 0.05)
        wanted = [int(i) for i in row.grid_id[near & row.structural]]
        assert wanted
    assert found == sorted(wanted)


def test_spherical_box(row: Membership) -> None:
    """Against its own formulas, in a system that stands on a cylindrical one."""
    kind, origin, axes = row.frames[8]
    assert kind == "S"
    local = (row.position_m - origin) @ axes.T
    r = np.linalg.norm(local, axis=1)
    phi = np.degrees(np.arctan2(local[:, 1], local[:, 0]))
    theta = np.degrees(np.arccos(np.divide(local[:, 2], r, out=np.ones_like(r), where=r > 0)))
    box = {"frame": 8, "r_m": [0.15, 0.7], "theta_deg": [20.0, 95.0], "phi_deg": [-40.0, 200.0]}
    wanted = row.structural & (r >= 0.15) & (r <= 0.7) & (theta >= 20) & (theta <= 95) & ((phi >= -40) | (phi <= -160))
    assert 0 < wanted.sum() < row.structural.sum()
    assert one(row, box=box) == [int(i) for i in row.grid_id[wanted]]


def test_box_in_a_turned_system_moves_with_it(tmp_path: Path, row: Membership) -> None:
    """The model written in coordinates of system 9, and boxes of that system: the same grids, faces included."""
    turned = members_of(tmp_path / "turned.bdf", deck_text(cp="9"))
    assert np.abs(turned.position_m - row.position_m).max() > 0.1
    for x, y in (([0.1, 0.3], [0.0, 0.1]), ([0.2, 0.2 + 1e-12], [0.1, 0.1 + 1e-12])):
        here, there = {"x_m": x, "y_m": y}, {"frame": 9, "x_m": x, "y_m": y}
        assert one(row, box=here) == one(turned, box=there) != []


def test_first_definition_wins_and_losses_are_told(row: Membership) -> None:
    found = define(row, {"name": "B", "property": 2}, {"name": "A", "property": 1}, {"name": "C", "property": 3})
    assert {n: load.grid_id.tolist() for n, load in found.loads.items()} == {
        "B": planes(2, 3, 4),
        "A": planes(0, 1),
        "C": planes(5, 6),
    }
    assert [(o.area, o.earlier, o.grids.tolist()) for o in found.overlaps] == [
        ("A", "B", planes(2)),
        ("C", "B", planes(4)),
    ]
    assert found.lines()[0] == "area A: 4 shared grids stay with earlier definitions (B 4)"
    require_partition(found, where="row.bdf")


criteria = st.one_of(
    st.integers(1, 3).map(lambda p: {"property": p}),
    st.integers(1, 6).map(lambda e: {"element": e}),
    st.sampled_from([21, 101, 102, 103]).map(lambda s: {"set": s}),
    st.tuples(st.integers(0, 5), st.integers(1, 4)).map(lambda b: {"box": {"x_m": [0.1 * b[0], 0.1 * sum(b)]}}),
)


@settings(max_examples=60, deadline=None)
@given(chosen=st.lists(criteria, min_size=1, max_size=5), remainder=st.booleans())
def test_areas_are_disjoint_and_nothing_is_lost(row: Membership, chosen: list[Any], remainder: bool) -> None:
    """Whatever is defined: no grid twice, areas and leftovers are all structural grids, order moves borders only."""
    tables = [{"name": f"A{i}", **c} for i, c in enumerate(chosen)]
    tables += [{"name": "REST", "remainder": True}] if remainder else []
    try:
        found = define(row, *tables)
    except ConfigError:
        return  # an area without grids of its own
    parts = [*(load.grid_id for load in found.loads.values()), found.left]
    assert sorted(int(i) for p in parts for i in p) == row.grid_id[row.structural].tolist()
    assert not (remainder and found.left.size)
    for i, c in enumerate(chosen):
        met = set(one(row, **c))
        lost = {int(g) for o in found.overlaps if o.area == f"A{i}" for g in o.grids}
        assert met == set(found.loads[f"A{i}"].grid_id.tolist()) | lost
    if not remainder:
        try:
            backwards = define(row, *tables[::-1])
        except ConfigError:
            return
        np.testing.assert_array_equal(backwards.left, found.left)


def test_csv_comes_first(row: Membership) -> None:
    found = define(row, {"name": "REST", "remainder": True}, listed={"LISTED": np.array([1, 2, 99])})
    assert found.loads["LISTED"].grid_id.tolist() == [1, 2, 99]
    assert found.loads["REST"].grid_id.tolist() == planes(*range(7))[2:]


def test_ids_of_a_set_that_do_not_exist_are_named(row: Membership) -> None:
    notes = define(row, {"name": "A", "set": [101, 103]}).notes
    assert notes == [
        "area A: set 101 names 1 grid ids that the deck does not have: 500",
        "area A: set 103 names 1 property ids that the deck does not have: 77",
    ]


def test_leftovers_are_listed_with_their_properties(row: Membership) -> None:
    found = define(row, {"name": "A", "property": [1, 2]})
    with pytest.raises(InputError, match=r"8 structural .*: 21, 22, 23, 24, 25, 26, 27, 28 \(.* properties 0, 3\)"):
        require_partition(found, where="row.bdf")


REFUSED: list[tuple[list[dict[str, Any]], str, str]] = [
    ([{"property": 12}], "areas.define[0].property", "no element has the property 12; there are: 1, 2, 3, 40"),
    ([{"property": [1, "90:99"]}], "areas.define[0].property", "no element has the property 90:99"),
    ([{"material": 9}], "areas.define[0].material", "no element has the material 9"),
    ([{"element": 7}], "areas.define[0].element", "no element has the element 7"),
    ([{"set": 44}], "areas.define[0].set", "the deck has no set 44; there are: 5, 21, 30, 101, 102, 103, 104"),
    ([{"set": 105}], "areas.define[0].set", "the deck has no set 105"),  # of no grids
    ([{"set": 5}], "areas.define[0].set", "set 5 is a SET1 and a SET of the case control with other members"),
    ([{"set": 104}], "areas.define[0]", "area 'A0' has no grid with element stiffness"),
    ([{"box": {"frame": 3, "x_m": [0, 1]}}], "areas.define[0].box.frame", "no coordinate system 3; there are: 0, 7"),
    ([{"box": [{"frame": 7, "x_m": [0, 1]}]}], "areas.define[0].box[0].x_m", "coordinate system 7 has r_m, theta_deg"),
    ([{"property": 1, "box": {"x_m": [5, 6]}}], "areas.define[0]", "has no grid that meets all its criteria"),
    ([{"property": 1, "also": [{"set": 44}]}], "areas.define[0].also[0].set", "no set 44"),
    ([{"property": 1}, {"element": 1}], "areas.define[1]", "all grids of area 'A1' are in earlier areas (A0 has 8)"),
    ([{"property": "1:40"}, {"remainder": True}], "areas.define[1]", "area 'A1' has no grid: nothing is left"),
    ([{"property": 1, "remainder": True}], "areas.define[0]", "other criteria are given too"),
    ([{"remainder": True}, {"property": 1}], "areas.define", "must be the last definition"),
    ([{}], "areas.define[0]", "selects nothing: give set, property, material, element, box or remainder"),
    ([{"property": 1, "also": [{}]}], "areas.define[0].also[0]", "selects nothing"),
    ([{"property": "9:4"}], "areas.define[0].property", "'9:4' must be 'low:high'"),
    ([{"property": 0}], "areas.define[0].property", "Nastran id 0 is outside 1 to 999,999,999"),
    ([{"box": {}}], "areas.define[0].box", "bounds nothing"),
    ([{"box": {"x_m": [1, 0]}}], "areas.define[0].box.x_m", "must be [low, high]"),
    ([{"box": {"x_m": [0.0, float("nan")]}}], "areas.define[0].box.x_m[1]", "coordinate nan is outside"),
    ([{"box": {"theta_deg": [0.0, float("inf")]}}], "areas.define[0].box.theta_deg[1]", "must be a finite number"),
    ([{"property": 1, "porperty": 2}], "areas.define[0].porperty", "did you mean property?"),
    ([{"box": {"x_mm": [0, 1]}}], "areas.define[0].box.x_mm", "did you mean x_m?"),
    ([{"name": "2A", "property": 1}], "areas.define[0].name", "must begin with a letter"),
    ([{"name": "A", "property": 1}, {"name": "a", "property": 2}], "areas.define", "defined twice"),
]


@pytest.mark.parametrize(("tables", "place", "fact"), REFUSED, ids=[f"{t}"[:60] for t, _, _ in REFUSED])
def test_refused(row: Membership, tables: list[dict[str, Any]], place: str, fact: str) -> None:
    with pytest.raises(ConfigError) as caught:
        define(row, *({"name": f"A{i}", **t} for i, t in enumerate(tables)))
    assert place in [p for p, _ in caught.value.problems], caught.value.problems
    assert any(fact in f for p, f in caught.value.problems if p == place), caught.value.problems


def test_a_remainder_of_nothing_is_to_be_removed(row: Membership) -> None:
    with pytest.raises(ConfigError) as caught:
        define(row, {"name": "A", "property": "1:40"}, {"name": "REST", "remainder": True})
    assert caught.value.hint == "remove areas.define[1] (REST): all grids are in areas_csv or in other areas"
    with pytest.raises(ConfigError) as caught:
        define(row, {"name": "A", "property": 12})
    assert not caught.value.hint


def test_the_documented_examples_are_some() -> None:
    text = (Path(__file__).parents[2] / "docs" / "how-to" / "areas.md").read_text(encoding="utf-8")
    blocks = re.findall(r"(?m)(?:^    .*\n|^\n(?=    ))+", text)
    example = "\n".join(line[4:] for b in blocks if "[[areas.define]]" in b for line in b.splitlines())
    shown = tomllib.loads(example)["areas"]["define"]
    shown.sort(key=lambda d: d.get("remainder", False))  # the last of all, in a file that has them all
    found = validate(Document, {"areas": {**RULES, "define": shown}}, where="areas.md").areas
    names = ["PANEL", "BENCH_PLUS_Y", "STRUT_1", "TUBE", "STRUTS", "PANEL_ACROSS", "STRUTS_ACROSS", "REST"]
    assert [d.name for d in found.define] == names


def test_all_problems_at_once(row: Membership) -> None:
    with pytest.raises(ConfigError) as caught:
        define(
            row,
            {"name": "A", "property": 12},
            {"name": "B", "set": 44},
            {"name": "C", "box": {"frame": 3, "y_m": [0, 1]}},
        )
    assert len(caught.value.problems) == 3


def test_strict_refuses_shared_grids(row: Membership) -> None:
    with pytest.raises(
        ConfigError, match=r"define\[1\]: area 'B' shares grids with earlier ones \(A 4: 9, 10, 11, 12\)"
    ):
        define(row, {"name": "A", "property": 1}, {"name": "B", "property": 2}, strict=True)
    define(row, {"name": "A", "property": 1}, {"name": "B", "remainder": True}, strict=True)
