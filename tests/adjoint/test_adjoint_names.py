"""Names of suggested areas carry those of the present ones, and what cases tell apart stays apart."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from tedm_cli.area_names import area_name_fact
from tedm_cli.areas.suggested import suggested_names
from tedm_cli.noise.areas import AreaTable
from tedm_cli.noise.correlation import CorrelationCase
from tedm_cli.noise.selection import BlockSelector
from tedm_cli.noise.told_apart import paired, told_apart

OLD = ["OB_LEFT", "OB_RIGHT", "IS1_EH_UP", "IS1_VE_UP", "STRUT"]


def names(label: list[int], area: list[int], volume: list[float] | None = None, old: list[str] = OLD, fits=None):
    sizes = np.ones(len(label)) if volume is None else np.array(volume)
    given, origin = suggested_names(np.array(label), np.array(area), sizes, old, fits or (lambda name, of: True))
    return given, origin.tolist()


def test_of_one_area_its_name_and_a_number_where_it_is_divided() -> None:
    assert names([0, 0, 1, 2, 3, 4], [0, 0, 1, 1, 2, 4]) == (
        ["OB_LEFT", "OB_RIGHT.1", "OB_RIGHT.2", "IS1_EH_UP", "STRUT"],
        [0, 1, 1, 2, 4],
    )


def test_of_several_areas_what_their_names_begin_with() -> None:
    assert names([0, 0, 1, 1, 2, 2], [0, 1, 2, 3, 2, 3])[0] == ["OB_1", "IS1_1", "IS1_2"]
    assert names([0, 0], [0, 1], [95.0, 5.0])[0] == ["OB_LEFT"]
    assert names([0, 0], [0, 1], [85.0, 15.0])[0] == ["OB_1"]


def test_the_largest_area_where_a_common_name_would_not_fit() -> None:
    assert names([0, 0], [0, 4], [60.0, 40.0])[0] == ["OB_LEFT"]
    assert names([0, 0], [0, 1], [40.0, 60.0], fits=lambda name, old: name == old)[0] == ["OB_RIGHT"]


def test_names_are_names_and_each_is_of_one_area() -> None:
    long = "L" * 56
    given, _ = names([0, 1, 2, 2, 3], [0, 0, 1, 2, 1], old=[long, "a_1", "a_2"])
    assert given == ["L" * 54 + ".1", "L" * 54 + ".2", "a_3", "a_1"]
    assert not any(area_name_fact(name) for name in given)
    assert len({name.upper() for name in given}) == len(given)
    assert names([0, 0, 1, 1], [0, 1, 2, 3], old=["a_x", "a_y", "A_p", "A_q"])[0] == ["a_1", "A_2"]


AREAS = AreaTable(
    name=np.array(["A", "B", "C", "D", "E", "F"]),
    group=np.array(["one", "one", "one", "two", "two", "two"]),
    shield=np.array(["inside"] * 3 + ["outside"] * 3),
    side=np.array(["+y", "-y", "mid", "+y", "-y", "mid"]),
)
EVEN = np.ones((1, 6))


def case(*blocks: BlockSelector) -> CorrelationCase:
    return CorrelationCase("1", "", blocks, "")


def test_groups_and_shields_and_spectra_are_told_apart() -> None:
    assert told_apart(AREAS, [], EVEN).tolist() == [0, 0, 0, 1, 1, 1]
    assert told_apart(AREAS, [case(BlockSelector(areas=("*",), partition="none"))], EVEN).tolist() == [0, 0, 0, 1, 1, 1]
    loud = np.array([[1.0, 1.0, 2.0, 1.0, 1.0, 1.0]])
    assert told_apart(AREAS, [], loud).tolist() == [0, 0, 1, 2, 2, 2]
    gradient = replace(AREAS, kind=np.array(["mean"] * 5 + ["gradient"]))
    assert told_apart(gradient, [], EVEN).tolist() == [0, 0, 0, 1, 1, 2]


def test_sides_and_names_are_told_apart_where_a_case_does() -> None:
    sides = case(BlockSelector(shield=("outside",), side=("+y",)), BlockSelector(shield=("outside",), side=("-y",)))
    assert told_apart(AREAS, [sides], EVEN).tolist() == [0, 0, 0, 1, 2, 3]
    by_side = case(BlockSelector(shield=("inside",), partition="side"))
    assert told_apart(AREAS, [by_side], EVEN).tolist() == [0, 1, 2, 3, 3, 3]
    named = case(BlockSelector(areas=("A",)))
    assert told_apart(AREAS, [named], EVEN).tolist() == [0, 1, 1, 2, 2, 2]


def test_mirror_pairs_are_asked_for_by_place_not_by_name() -> None:
    mirror = BlockSelector(groups=("two",), partition="mirror")
    assert paired(AREAS, [case(mirror)]).tolist() == [False] * 3 + [True] * 3
    assert not paired(AREAS, [case(replace(mirror, mirror_names=("D", "E")))]).any()
    assert told_apart(AREAS, [case(mirror)], EVEN).tolist() == [0, 0, 0, 1, 2, 3]
