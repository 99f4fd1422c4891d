"""Test masses of layout and model, and levers: nothing depends on how the whole stands in the basic frame."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from tedm_cli.arrays import FloatArray
from tedm_cli.config.optics.against_model import Differences, compare_test_masses
from tedm_cli.gravity.testmass import TestMass
from tedm_cli.optics.layout import OpticalLayout
from tedm_cli.optics.levers import Levers, long_levers

SIDES = np.array([0.046, 0.05, 0.04])


def moved_layout(layout: OpticalLayout, axes: FloatArray, origin: FloatArray) -> OpticalLayout:
    """The layout with its frame moved by a rigid motion, x -> x axes + origin."""
    x, y, z = (tuple(row) for row in (layout.axes @ axes).tolist())
    return replace(layout, frame_axes=(x, y, z), frame_origin_m=tuple(layout.frame_origin_m @ axes + origin))


def masses(axes: FloatArray, origin: FloatArray, slip: FloatArray) -> list[TestMass]:
    """The test masses of the sample, moved along; `slip` [7]: of TM1 a shift (m), a turn (rad), of an edge (m)."""
    out = []
    for name, x, own in (("TM1", -0.188, slip), ("TM2", 0.188, np.zeros(7))):
        turned = Rotation.from_rotvec(own[3:6]).as_matrix().T
        centre = (np.array([x, 0.0, 0.0]) + own[:3]) @ axes + origin
        edges = SIDES + np.array([own[6], 0.0, 0.0])
        out.append(TestMass(name=name, position_m=centre, side_m=edges, mass_kg=1.96, axes=turned @ axes))
    return out


def motion(seed: int) -> tuple[FloatArray, FloatArray]:
    return Rotation.random(random_state=seed).as_matrix(), np.random.default_rng(seed).uniform(-5.0, 5.0, 3)


SLIPS = {
    "none": (np.zeros(7), []),
    "centre": (np.array([2e-4, 0, 0, 0, 0, 0, 0]), ["ref_m"]),
    "axes and face": (np.array([0, 0, 0, 0, 0, 2e-3, 0]), ["axes", "normal"]),
    "axes about the normal": (np.array([0, 0, 0, 2e-3, 0, 0, 0]), ["axes"]),
    "edge": (np.array([0, 0, 0, 0, 0, 0, 1e-3]), ["front_offset_m"]),
    "all": (np.array([0, 1e-3, 0, 0, 1e-3, 0, 1e-3]), ["ref_m", "axes", "normal", "front_offset_m"]),
}


@pytest.mark.parametrize("slip", SLIPS)
@settings(max_examples=20)
@given(seed=st.integers(0, 2**32 - 1))
def test_the_comparison_goes_with_a_rigid_motion(layout: OpticalLayout, slip: str, seed: int) -> None:
    """The edges differ: that along the face is the one that is compared."""
    axes, origin = motion(seed)
    values, keys = SLIPS[slip]
    found = compare_test_masses(moved_layout(layout, axes, origin), masses(axes, origin, values), "model.toml")
    assert [path for path, _ in found.problems] == [f"element[0].{key}" for key in keys]
    assert not found.notes
    assert found.compared == ["TM1", "TM2"]


@pytest.mark.parametrize("size", [0.0, 5e-7, 5e-5, 2e-4])
def test_what_is_rounding_odd_or_wrong(layout: OpticalLayout, size: float) -> None:
    """A micrometre or microradian is rounding, up to a hundred are odd, more is wrong; an edge counts by its half."""
    at_rest = np.eye(3), np.zeros(3)
    for place in range(7):
        slip = np.zeros(7)
        slip[place] = size if place < 6 else 2.0 * size
        found = compare_test_masses(layout, masses(*at_rest, slip), "model.toml")
        assert bool(found.problems) == (size > 1e-4)
        assert bool(found.notes) == (1e-6 < size < 1e-4)


def test_faces_along_another_axis_have_its_edge(layout: OpticalLayout) -> None:
    """A face that looks along -y of its test mass lies half of the edge along y away."""
    bench = replace(
        layout,
        elements=tuple(
            replace(e, normal=(0.0, -1.0, 0.0), front_offset_m=0.025) if e.name == "TM1" else e for e in layout.elements
        ),
    )
    found = compare_test_masses(bench, masses(np.eye(3), np.zeros(3), np.zeros(7)), "model.toml")
    assert not found.problems
    off = compare_test_masses(bench, masses(np.eye(3), np.zeros(3), np.array([0, 0, 0, 0, 0, 0, 1.0])), "model.toml")
    assert not off.problems


def test_half_of_a_project_is_not_compared(layout: OpticalLayout) -> None:
    both = masses(np.eye(3), np.zeros(3), np.ones(7))
    without = replace(layout, elements=layout.bench)
    for found in (compare_test_masses(without, both, "m"), compare_test_masses(layout, [], "m")):
        assert found == Differences()


def test_one_of_two_is_said_to_lack(layout: OpticalLayout) -> None:
    both = masses(np.eye(3), np.zeros(3), np.zeros(7))
    one = replace(layout, elements=tuple(e for e in layout.elements if e.name != "TM2"))
    found = compare_test_masses(one, both, "model.toml")
    assert (found.problems, found.compared) == ([], ["TM1"])
    assert found.notes == ["element: TM2 of model.toml is not here; it has self-gravity, but no read-out"]
    found = compare_test_masses(layout, both[:1], "model.toml")
    assert found.notes == [
        "element[1].name: model.toml has no test mass TM2; it has TM1; TM2 has read-outs here, but no self-gravity"
    ]


def test_a_layout_without_surfaces_has_centres_and_axes(layout: OpticalLayout) -> None:
    """As where S_BW is imported: what is not known is not compared, the rest is."""
    elements = tuple(
        replace(e, normal=(0.0, 0.0, 0.0), front_offset_m=0.0) if e.kind == "test_mass" else e for e in layout.elements
    )
    blind = replace(layout, elements=elements, has_geometry=False)
    values, _ = SLIPS["all"]
    found = compare_test_masses(blind, masses(np.eye(3), np.zeros(3), values), "model.toml")
    assert [path for path, _ in found.problems] == ["element[0].ref_m", "element[0].axes"]


# --- levers ---------------------------------------------------------------------------------------------------------


def nodes(layout: OpticalLayout, lever: FloatArray) -> FloatArray:
    """Grids of the bench that are off from their elements by -lever [n, 3], layout frame."""
    refs = np.array([e.ref_m for e in layout.bench]) - lever
    return np.asarray(refs @ layout.axes + layout.frame_origin_m)


def said(levers: Levers) -> tuple[list[str], list[str]]:
    return [e.name for e, _ in levers.long], [e.name for e, _ in levers.too_long]


@settings(max_examples=20)
@given(seed=st.integers(0, 2**32 - 1))
def test_levers_go_with_a_rigid_motion(layout: OpticalLayout, seed: int) -> None:
    lever = np.random.default_rng(seed).normal(size=(len(layout.bench), 3)) * 0.08
    turned = moved_layout(layout, *motion(seed))
    at_rest, moved = long_levers(layout, nodes(layout, lever)), long_levers(turned, nodes(turned, lever))
    assert said(moved) == said(at_rest)
    assert moved.size_m == pytest.approx(at_rest.size_m, rel=1e-12)
    length = dict(zip((e.name for e in layout.bench), np.linalg.norm(lever, axis=1).tolist(), strict=True))
    long, too_long = said(at_rest)
    assert {*long, *too_long} == {name for name, r in length.items() if r > 0.02}
    assert {name for name, r in length.items() if r > 0.25} <= set(too_long)  # windows, the farthest, have less room
    assert {name for name, r in length.items() if 0.02 < r < 0.2} <= set(long)


def test_an_element_far_off_makes_no_room_for_itself(layout: OpticalLayout) -> None:
    """Its own distance is no part of the size of the bench, which is 0.25 m between the windows."""
    for far in (0.3, 3.0, 300.0):
        lever = np.zeros((len(layout.bench), 3))
        lever[layout.bench.index(next(e for e in layout.bench if e.name == "M5")), 2] = far
        shifted = tuple(replace(e, ref_m=(*e.ref_m[:2], far)) if e.name == "M5" else e for e in layout.elements)
        bench = replace(layout, elements=shifted)
        found = long_levers(bench, nodes(bench, lever))
        assert said(found) == ([], ["M5"])
        assert found.size_m == pytest.approx(0.25, rel=1e-12)
        assert found.common_m is None


def test_a_layout_in_other_units_is_larger_than_its_model(layout: OpticalLayout) -> None:
    """In millimetres all elements are far away, and the bench is no measure of it."""
    in_mm = replace(
        layout,
        elements=tuple(
            replace(e, ref_m=(1e3 * e.ref_m[0], 1e3 * e.ref_m[1], 1e3 * e.ref_m[2])) for e in layout.elements
        ),
    )
    found = long_levers(in_mm, nodes(layout, np.zeros((22, 3))), model_size_m=0.7)
    assert len(found.too_long) == 22
    assert found.size_m == 0.7


def test_a_bench_off_as_a_whole(layout: OpticalLayout) -> None:
    """The common offset is given in the basic frame, and not where the elements are off in different ways."""
    axes, origin = motion(3)
    turned = moved_layout(layout, axes, origin)
    shift = np.array([0.0, 0.1, 0.0])
    found = long_levers(turned, nodes(turned, np.tile(shift, (22, 1))))
    assert found.common_m is not None
    np.testing.assert_allclose(found.common_m, shift @ axes, atol=1e-14)
    apart = np.tile(shift, (22, 1)) * np.where(np.arange(22) % 2, 1.0, -1.0)[:, None]
    assert long_levers(turned, nodes(turned, apart)).common_m is None
