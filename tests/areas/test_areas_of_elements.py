"""Areas of elements and gradients on plates and short struts: sums, what a strut of one bar does, refusals."""

from __future__ import annotations

import tomllib
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from strut_model import ALPHA, LOWER, NX, NY, REST, UPPER, deck, define, plate_grid, project, slopes, strut_element

from tedm_cli.areas.definitions import DefinedAreas, define_areas, require_partition
from tedm_cli.config.base import Strict, validate
from tedm_cli.config.model.areas import AreasTable
from tedm_cli.config.model.file import load_model
from tedm_cli.errors import ConfigError, InputError
from tedm_cli.fem.static import StaticSolution
from tedm_cli.nastran.geometry import grids
from tedm_cli.nastran.membership import Membership, membership
from tedm_cli.nastran.reading import deck_files, read_deck
from tedm_cli.nastran.structure.deck import read_solver_deck
from tedm_cli.stages.model.deck import write_deck

STRUT = define("STRUT", element=5000, carrier='"elements"')
OTHERS = define("OTHERS", element='"5100:5399"', carrier='"elements"')
RULE = {"rule": [{"match": "*", "group": "all", "shield": "inside"}]}
# Springs, a rod and a shear panel beside the struts: elements that have no temperature card, or do not bend.
MORE = "CELAS2,8001,1.+3,1,1,2,1\nCROD,8002,8002,1001,1009\nPROD,8002,2,1.-5\n"


class Document(Strict):
    areas: AreasTable


@pytest.fixture(scope="module")
def members(tmp_path_factory: pytest.TempPathFactory) -> Membership:
    path = tmp_path_factory.mktemp("members") / "model.bdf"
    path.write_text(deck(2, block=True).replace("ENDDATA", MORE + "ENDDATA"))
    model = read_deck(path)
    return membership(model, grids(model, deck_files(model, path)), positions=True, axes=True)


def defined(members: Membership, text: str) -> DefinedAreas:
    table = validate(Document, {"areas": {**RULE, **tomllib.loads(text)["areas"]}}, where="model.toml").areas
    return define_areas(members, table, {}, where="model.toml")


def solved(folder: Path, text: str, tables: str) -> tuple[np.ndarray, dict[str, np.ndarray], dict[str, float]]:
    """Grid ids, motions [N, 6] per unit of each load as solved in memory, and the mean steps."""
    done = write_deck(project(folder, text, tables), None)
    structure, cases = read_solver_deck(done.path)
    motions = dict(StaticSolution(structure).solve(cases))
    return structure.grid_id, {c.label: motions[c.id] for c in cases}, {s.area: s.share for s in done.mean_step}


@cache
def upper() -> list[int]:
    return [plate_grid(1, i, j) for j in range(NY + 1) for i in range(NX + 1)]


def test_a_strut_of_one_bar_has_its_kelvin_as_an_area_of_elements(tmp_path: Path) -> None:
    """What the upper plate does per kelvin of one strut, against ever finer meshes of the strut with areas of grids.

    Of n bars the areas of grids have n - 1 grids, and all of the step but 1/n of it: D grows to that of the area of
    elements as 1 - 1/n. A single bar as an area of grids has one end, and a piece of the plate with it.
    """
    ids, motion, share = solved(tmp_path / "elements", deck(1), STRUT + LOWER + UPPER + OTHERS)
    rows = np.searchsorted(ids, upper())
    wanted = motion["STRUT"][rows]
    assert share == pytest.approx({"STRUT": 1.0, "LOWER": 1.0, "UPPER": 1.0, "OTHERS": 1.0}, rel=1e-12)
    for parts in (4, 16):
        fine = define("STRUT", element='"5000:5099"') + define("OTHERS", property=2)
        ids, motion, share = solved(tmp_path / f"{parts}", deck(parts), LOWER + UPPER + fine)
        assert share["STRUT"] == pytest.approx(1.0 - 1.0 / parts, rel=1e-12)
        found = motion["STRUT"][np.searchsorted(ids, upper())]
        for part in (slice(0, 3), slice(3, 6)):
            gap = np.abs(found - (1.0 - 1.0 / parts) * wanted)[:, part].max()
            assert gap < 1e-6 * np.abs(wanted[:, part]).max()
    coarse = define("STRUT", element=5000, box="{ z_m = [0.05, inf] }")
    ids, motion, share = solved(tmp_path / "grids", deck(1), coarse + LOWER + UPPER)
    assert share["STRUT"] == pytest.approx(0.5, rel=1e-12)
    found = np.abs(motion["STRUT"][np.searchsorted(ids, upper())]).max(axis=0)[:5] / np.abs(wanted).max(axis=0)[:5]
    print("per kelvin of a strut of one bar, area of grids over area of elements: x, y, z, rx, ry", found)
    assert 2.4 < found[0] < 2.7  # too large by the plate that gets warm with its grid
    assert 2.9 < found[1] < 3.2
    assert (found[2:] < 0.6).all()  # too small by the half of the strut that stays cold


PARTS = {
    "bars next to plates": STRUT.replace("5000", "[5000, 5001]") + LOWER + UPPER + OTHERS + define("BLOCK", property=3),
    "shells share borders with one another and with grids": (
        define("BACK", property=1, box="{ x_m = [-inf, 0.0], z_m = [0.05, inf] }", carrier='"elements"')
        + define("FRONT", property=1, box="{ x_m = [0.0, inf], z_m = [0.05, inf] }", carrier='"elements"')
        + define("BLOCK", property=3)
        + LOWER
        + define("STRUTS", property=2, carrier='"elements"')
    ),
    "shells with solids in one area": (
        define("TOP", property="[1, 3]", box="{ z_m = [0.05, inf] }", carrier='"elements"')
        + define("LEFT", box="{ x_m = [-inf, 0.01] }")
        + define("REST", remainder="true")
    ),
    "all that is left, by elements": (
        define("LEFT", box="{ x_m = [-inf, -0.08] }") + define("REST", remainder="true", carrier='"elements"')
    ),
}
GRADIENTS = define("BEND", kind='"gradient"', property=1, direction="[0.0, 0.1, 1.0]") + define(
    "SWAY", kind='"gradient"', property=2, direction="[1.0, 2.0, 0.0]"
)


@pytest.mark.parametrize("name", PARTS)
def test_means_sum_to_the_uniform_load(tmp_path: Path, name: str) -> None:
    """Exactly: every element is warmed once. Gradients are beside them, and in no sum."""
    gradients, tables = GRADIENTS, PARTS[name]
    if "remainder" in tables:
        tables, gradients = tables + gradients, ""
    _, motion, share = solved(tmp_path, deck(2, block=True), gradients + tables)
    uniform = motion.pop("UNIFORM")
    means = [m for label, m in motion.items() if label not in ("BEND", "SWAY")]
    assert len(means) == len(motion) - 2
    total = np.sum(means, axis=0)
    for part in (slice(0, 3), slice(3, 6)):
        size = np.abs([m[:, part] for m in means]).max()
        assert np.abs(total - uniform)[:, part].max() < 1e-10 * size
        assert np.abs(motion["BEND"])[:, part].max() > 1e-4 * size  # a sum with it would not be the uniform load
    assert np.isnan(share["BEND"])
    assert all(0.0 < s <= 1.0 + 1e-12 for label, s in share.items() if label not in ("BEND", "SWAY"))


def test_a_warm_strut_lengthens_as_its_expansion_says(tmp_path: Path) -> None:
    """All struts together lift the upper plate by alpha L, and bend nothing."""
    tables = LOWER + UPPER + define("STRUTS", property=2, carrier='"elements"')
    ids, motion, _ = solved(tmp_path, deck(1), tables)
    lift = motion["STRUTS"][np.searchsorted(ids, upper())]
    np.testing.assert_allclose(lift[:, 2], 0.1 * ALPHA, rtol=1e-9)
    assert np.abs(lift[:, :2]).max() < 1e-9 * ALPHA


def test_who_has_what(members: Membership) -> None:
    """Grids of bars alone go to no area; a neighbour's warm grids keep a strut's elements at rest."""
    tables = STRUT.replace("5000", "[5000, 5001]") + LOWER + UPPER + define("REST", remainder="true")
    found = defined(members, tables)
    loads = found.loads
    assert loads["STRUT"].element_id.tolist() == [5000, 5001]
    assert loads["STRUT"].grid_id.size == 0
    assert loads["STRUT"].held_id.size == 0
    assert loads["LOWER"].held_id.tolist() == [5000]
    assert loads["UPPER"].held_id.tolist() == [5001]
    assert loads["REST"].held_id.size == 0
    warm = set(np.concatenate([load.grid_id for load in loads.values()]).tolist())
    assert {3001, 3101} - warm == {3001}  # in the middle of the strut, which has its own temperature, and of another
    assert not found.left.size
    assert found.selected["UPPER"].tolist() == list(range(1001, 1049))  # the lower ones are LOWER's already


def test_solids_of_an_area_of_elements_are_warmed_through_their_grids(members: Membership) -> None:
    found = defined(members, define("BLOCK", property="[1, 3]", carrier='"elements"') + REST)
    load = found.loads["BLOCK"]
    corners = {plate_grid(p, i, j) for p in (1, 2) for i in (3, 4, 5) for j in (2, 3)}
    assert set(load.grid_id.tolist()) == corners
    assert len(load.element_id) == 96
    assert any("BLOCK: 2 solids have no temperature of their own" in note for note in found.notes)
    # the rest are the bars' grids; those of shells alone are no one's
    assert found.loads["REST"].held_id.size > 0
    assert plate_grid(0, 4, 4) not in set(found.loads["REST"].grid_id.tolist())


def test_gradients_along_a_direction_and_along_axes(members: Membership) -> None:
    text = (
        define("UP", kind='"gradient"', element='"1:48"', direction="[0.0, 3.0, 4.0]")
        + define("DOWN", kind='"gradient"', element='"1001:1048"', direction="[0.0, 0.0, -1.0]")
        + define("SIDE", kind='"gradient"', property=2, direction="[3.0, 4.0, 100.0]")
        + define("PLANE", kind='"gradient"', property=2, plane=2)
        + define("REST", remainder="true")
    )
    with pytest.raises(ConfigError, match=r"less than 0\.1 of it is through them"):
        defined(members, text)
    found = defined(members, text.replace("[3.0, 4.0, 100.0]", "[3.0, -4.0, 1.0]"))
    assert set(slopes(found.loads["UP"])[:, 0]) == {1.0}
    assert set(slopes(found.loads["DOWN"])[:, 0]) == {-1.0}
    # orientation vectors along x: plane 1 holds x, plane 2 the y axis, z x x
    np.testing.assert_allclose(slopes(found.loads["SIDE"]), np.tile([0.6, -0.8], (8, 1)), rtol=1e-9)
    np.testing.assert_array_equal(slopes(found.loads["PLANE"]), np.tile([0.0, 1.0], (8, 1)))
    assert all(load.kind == "gradient" for name, load in found.loads.items() if name != "REST")
    assert len(found.loads["REST"].grid_id) == members.structural.sum()


def test_neighbours_with_opposite_normals_are_told(members: Membership) -> None:
    """One shell of the plate is turned over: its four neighbours, and it, are named once; a direction settles it."""
    row = int(np.searchsorted(members.element_id, 20))
    index = members.node_index.copy()
    ring = slice(members.node_offset[row], members.node_offset[row + 1])
    index[ring] = index[ring][::-1]
    axes = members.axes.copy()
    axes[row] *= -1.0
    turned = replace(members, node_index=index, axes=axes)
    text = define("UP", kind='"gradient"', element='"1:48"')
    rest = define("REST", remainder="true")
    assert defined(members, text + rest).notes == []
    note = defined(turned, text + rest).notes[0]
    assert "12, 19, 20, 21, 28" in note
    assert "give a direction" in note
    found = defined(turned, define("UP", kind='"gradient"', element='"1:48"', direction="[0.0, 0.0, 1.0]") + rest)
    assert found.notes == []
    assert slopes(found.loads["UP"])[:, 0].tolist() == [-1.0 if i == 20 else 1.0 for i in range(1, 49)]


def steps(m: Membership, found: DefinedAreas) -> list[np.ndarray]:
    """The step [M] that each node of each element gets of the areas of a mean temperature, one after the other."""
    element = np.repeat(m.element_id, np.diff(m.node_offset))
    out = []
    for load in found.loads.values():
        if load.kind == "mean":
            step = np.isin(m.grid_id[m.node_index], load.grid_id).astype(float)
            step[np.isin(element, load.element_id)] = 1.0
            step[np.isin(element, load.held_id)] = 0.0
            out.append(step)
    return out


choices = st.one_of(
    st.integers(0, 3).map(lambda k: f"element = {[strut_element(k), strut_element(k, 1)]}"),
    st.integers(1, 3).map(lambda p: f"property = {p}"),
    st.tuples(st.integers(-4, 3), st.integers(1, 5)).map(
        lambda b: f"property = 1\nbox = {{ x_m = [{0.05 * b[0] - 0.01}, {0.05 * sum(b) - 0.01}] }}"
    ),
    st.integers(-3, 2).map(lambda y: f"box = {{ y_m = [{0.05 * y}, inf] }}"),
)


@settings(max_examples=80)
@given(
    chosen=st.lists(st.tuples(choices, st.booleans()), min_size=1, max_size=5),
    last=st.booleans(),
    listed=st.lists(st.integers(3001, 3002), max_size=1) | st.just([1, 2, 3, 3001, 3101]),
)
def test_every_element_is_warmed_once_whatever_is_defined(
    members: Membership, chosen: list[tuple[str, bool]], last: bool, listed: list[int]
) -> None:
    """Areas of grids, of elements and of a list, in any order: at each node of each element the steps sum to one."""
    tables = "".join(
        f'[[areas.define]]\nname = "A{i}"\n{text}\ncarrier = "{"elements" if own else "grids"}"\n'
        for i, (text, own) in enumerate(chosen)
    ) + define("REST", remainder="true", carrier='"elements"' if last else '"grids"')
    table = validate(Document, {"areas": {**RULE, **tomllib.loads(tables)["areas"]}}, where="model.toml").areas
    ids = np.array([i for i in listed if i in members.grid_id], dtype=np.int64)
    try:
        found = define_areas(members, table, {"LISTED": ids} if ids.size else {}, where="model.toml")
    except (ConfigError, InputError) as error:
        told = str(error)
        assert any(w in told for w in ("both select", "shares", "all grids", "nothing is left", "areas w")), told
        return
    heated = np.repeat(~np.isin(members.card, ["CELAS2"]), np.diff(members.node_offset))
    total = np.sum(steps(members, found), axis=0)[heated]
    assert not found.left.size
    assert set(total) == {1.0}


ELEMENTS, GRADIENT = {"carrier": '"elements"'}, {"kind": '"gradient"'}
REFUSED: list[tuple[str, str, str]] = [
    (
        STRUT + define("B", property=2, **ELEMENTS),
        "areas.define[1]",
        "STRUT and B both select element 5000; an element has one temperature: take it out of one of the two areas",
    ),
    (
        define("A", element=8001, **ELEMENTS),
        "areas.define[0]",
        "area 'A' has only elements that have no temperature: CELAS2 8001",
    ),
    (
        define("A", property=2, box="{ x_m = [5.0, 6.0] }", **ELEMENTS),
        "areas.define[0]",
        "area 'A' has no element that meets all",
    ),
    (define("A", element=9, carrier='"element"'), "areas.define[0].carrier", "'grids' or 'elements'"),
    (define("A", property=77, **ELEMENTS), "areas.define[0].property", "no element has the property 77"),
    (define("A", element=4242, **GRADIENT), "areas.define[0].element", "no element has the element 4242"),
    (
        define("A", property=2, **ELEMENTS) + define("B", element='"5000:5001"', box="{ z_m = [0.04, 0.06] }"),
        "areas.define[1]",
        "all grids of area 'B' are of elements whose temperature is their own, in areas of elements: A",
    ),
    (
        define("A", property=3, **GRADIENT),
        "areas.define[0]",
        "a gradient on CHEXA 7001, 7002: a solid has no card for it",
    ),
    (define("A", element=8002, **GRADIENT), "areas.define[0]", "a gradient on CROD 8002: it does not bend"),
    (define("A", element=8001, **GRADIENT), "areas.define[0]", "a gradient on CELAS2 8001: it does not bend"),
    (define("A", property=2, **GRADIENT), "areas.define[0]", "bars 5000, 5001"),
    (
        define("A", property=1, direction="[1.0, 0.0, 0.09]", **GRADIENT),
        "areas.define[0]",
        "its direction lies in the shells, or along the bars, 1, 2, 3, 4, 5, 6, 7, 8 and 88 more",
    ),
    (
        define("A", property=2, direction="[0.0, 0.09, 1.0]", **GRADIENT),
        "areas.define[0]",
        "or along the bars, 5000, 5001",
    ),
    (
        define("A", property=1, **GRADIENT) + define("B", element=7, direction="[0.0, 0.0, -1.0]", **GRADIENT),
        "areas.define[1]",
        "areas 'A' and 'B' have gradients along one direction in elements 7",
    ),
    (define("A", property=1, carrier='"grids"', **GRADIENT), "areas.define[0]", "a gradient is in elements"),
    (define("A", remainder="true", **GRADIENT), "areas.define[0]", "remainder = true is for mean temperatures only"),
    (define("A", property=1, direction="[0.0, 0.0, 1.0]"), "areas.define[0]", 'give kind = "gradient"'),
    (define("A", property=1, plane=1), "areas.define[0]", "plane is that of a gradient"),
    (define("A", property=2, plane=3, **GRADIENT), "areas.define[0].plane", "1 or 2"),
    (define("A", property=1, plane=2, **GRADIENT), "areas.define[0]", "plane is that of bars, and it has shells alone"),
    (define("A", property=2, plane=1, direction="[1.0, 0.0, 0.0]", **GRADIENT), "areas.define[0]", "give one"),
    (
        define("A", property=1, direction="[0.0, 0.0, 0.0]", **GRADIENT),
        "areas.define[0].direction",
        "its length is zero",
    ),
    (define("A", property=1, kind='"slope"'), "areas.define[0].kind", "'mean' or 'gradient'"),
    (REST + define("B", property=1), "areas.define", "must be the last definition"),
    (
        define("A", box="{ x_m = [-0.21, -0.19] }") + define("B", remainder="true", carrier='"elements"'),
        "areas.define[0]",
        "all grids of area 'A' are of elements whose temperature is their own, in areas of elements",
    ),
]


@pytest.mark.parametrize(("tables", "place", "fact"), REFUSED, ids=[f for _, _, f in REFUSED])
def test_refused(members: Membership, tables: str, place: str, fact: str) -> None:
    with pytest.raises(ConfigError) as caught:
        defined(members, tables)
    assert place in [p for p, _ in caught.value.problems], caught.value.problems
    assert any(fact in f for p, f in caught.value.problems if p == place), caught.value.problems


def test_all_of_these_problems_at_once(members: Membership) -> None:
    tables = define("A", property=3, **GRADIENT) + define("B", element=8001, **ELEMENTS) + define("C", property=77)
    with pytest.raises(ConfigError) as caught:
        defined(members, tables)
    assert len(caught.value.problems) == 3


def test_no_area_has_the_name_of_the_uniform_load(tmp_path: Path) -> None:
    made = project(tmp_path, deck(), define("Uniform", remainder="true"))
    with pytest.raises(ConfigError, match=r"areas.define\[0\].name: 'Uniform' is the name of the uniform load"):
        load_model(made.model)
    made = project(tmp_path, deck(), define("Uniform", remainder="true"), 'uniform_label = "ALL"')
    assert load_model(made.model)[1].areas.define[0].name == "Uniform"


def test_a_grid_that_matters_must_be_in_an_area(members: Membership) -> None:
    """A plate's grids, and not those of bars alone that have temperatures of their own."""
    found = defined(members, define("STRUTS", property=2, **ELEMENTS) + define("BLOCK", property=3) + LOWER)
    with pytest.raises(InputError, match=r"57 structural grids are in no thermal area: 1001.*properties 1, 8002\)"):
        require_partition(found, where="model.bdf")
    assert not {3001, 3101, 3201, 3301} & set(found.left.tolist())


def test_a_list_of_grids_that_no_element_follows_is_refused(members: Membership) -> None:
    table = validate(
        Document,
        {"areas": {**RULE, **tomllib.loads(define("STRUTS", property=2, **ELEMENTS) + REST)["areas"]}},
        where="",
    ).areas
    with pytest.raises(
        InputError,
        match="areas whose grids are all of elements whose temperature is their own, in areas of elements: LISTED",
    ):
        define_areas(members, table, {"LISTED": np.array([3001, 3101])}, where="areas.csv")


def test_elements_without_temperature_are_noted_beside_others(members: Membership) -> None:
    found = defined(members, define("A", element="[5000, 8001, 8002]", **ELEMENTS) + REST)
    assert found.notes == ["area A: elements that have no temperature are left out: CELAS2 8001"]
    assert found.loads["A"].element_id.tolist() == [5000, 8002]
