"""Benches without a beam between them move each by themselves; names join what no beam joins."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from random_layouts import axis_rows, random_layout, vector
from scipy.spatial.transform import Rotation

from tedm_cli.arrays import FloatArray
from tedm_cli.config.optics.layout import load_layout
from tedm_cli.errors import ConfigError
from tedm_cli.optics.benches import benches
from tedm_cli.optics.chain import OpticsChain, optics_chain
from tedm_cli.optics.invariances import invariance_residuals
from tedm_cli.optics.layout import BeamPath, Element, OpticalLayout, Step
from tedm_cli.optics.sensitivity import move_reference_points, optical_sensitivity

R = Rotation.from_rotvec([0.3, -0.2, np.pi / 3]).as_matrix()
SHIFT = np.array([0.4, 1.1, -0.2])
AREAS = 4


def renamed(layout: OpticalLayout, mark: str) -> OpticalLayout:
    """The same bench with a mark before all its names."""
    return replace(
        layout,
        elements=tuple(replace(e, name=mark + e.name) for e in layout.elements),
        paths=tuple(
            BeamPath(mark + p.photodiode, p.beam, tuple(Step(mark + s.element, s.op) for s in p.steps))
            for p in layout.paths
        ),
        sets={name: tuple(mark + d for d in diodes) for name, diodes in layout.sets.items()},
    )


def placed(e: Element) -> Element:
    """On the second bench: turned and shifted, its axes with it."""
    return replace(
        e,
        ref_m=vector(R @ e.ref_m + SHIFT),
        normal=vector(R @ e.normal),
        local_y=None if e.local_y is None else vector(R @ e.local_y),
        axes=axis_rows(np.array(e.axes) @ R.T),
    )


def together(a: OpticalLayout, b: OpticalLayout) -> OpticalLayout:
    """Two benches in one file, elements and paths of both in turn."""
    elements = [*a.elements, *(placed(e) for e in b.elements)]
    return replace(
        a,
        elements=tuple(elements[i] for i in np.random.default_rng(7).permutation(len(elements))),
        paths=(*a.paths, *b.paths),
        sets={name: (*a.sets[name], *b.sets[name]) for name in a.sets},
    )


def chain_of(layout: OpticalLayout, motion: dict[str, FloatArray], nodes: dict[str, FloatArray]) -> OpticsChain:
    at = np.array([nodes[e.name] for e in layout.bench])
    S_BW = move_reference_points(optical_sensitivity(layout), layout, at)
    assert max(invariance_residuals(layout, S_BW, at).bench_motion.values()) < 1e-12
    return optics_chain(layout, S_BW, np.stack([motion[e.name] for e in layout.bench], axis=1), at)


def rows_of(chain: OpticsChain, layout: OpticalLayout, name: str) -> FloatArray:
    """N, its rigid part and the rest of all sets [3, sets, 3, k] of one test mass."""
    first = 3 * [e.name for e in layout.test_masses].index(name)
    rows = slice(first, first + 3)
    return np.array([[getattr(s, key)[rows] for s in chain.sets] for key in ("N", "N_rigid", "N_distortion")])


def test_two_benches_in_one_file_read_as_each_alone() -> None:
    """Every part of N of each test mass is that of its own bench, whatever the other does; unturned as well."""
    a, b = renamed(random_layout(2, 1), "A_"), renamed(random_layout(5, 1), "B_")
    both, rng = together(a, b), np.random.default_rng(1)
    motion, nodes = {}, {}
    for layout in (a, b):
        for e in layout.bench:
            nodes[e.name] = np.array(e.ref_m) + 0.01 * rng.normal(size=3)
            motion[e.name] = 1e-8 * rng.normal(size=(AREAS, 6))
    there = {e.name: R @ nodes[e.name] + SHIFT for e in b.bench}
    turned = {e.name: (motion[e.name].reshape(AREAS, 2, 3) @ R.T).reshape(AREAS, 6) for e in b.bench}
    found = chain_of(both, motion | turned, nodes | there)
    assert {name: {e.name[0] for e in on} for name, on in benches(both).items()} in (
        {"bench_1": {"A"}, "bench_2": {"B"}},
        {"bench_1": {"B"}, "bench_2": {"A"}},
    )
    assert found.rigid.amplitude.shape == (12, AREAS)
    assert found.rigid.about.shape == (2, 3)
    for layout, mass in ((a, "A_TM1"), (b, "B_TM1")):
        alone = rows_of(chain_of(layout, motion, nodes), layout, mass)
        scale = np.abs(alone).max()
        assert rows_of(found, both, mass) == pytest.approx(alone, abs=1e-12 * scale)
        assert np.abs(alone[1]).max() > 0.1 * scale
    # As one bench the rigid part is another, and the sum is the same.
    named = replace(
        both, elements=tuple(replace(e, bench=None if e.kind == "test_mass" else "OB") for e in both.elements)
    )
    one = chain_of(named, motion | turned, nodes | there)
    assert one.rigid.benches == ("OB",)
    assert one.rigid.amplitude.shape == (6, AREAS)
    for mass in ("A_TM1", "B_TM1"):
        two_parts, one_part = rows_of(found, both, mass), rows_of(one, named, mass)
        assert one_part[0] == pytest.approx(two_parts[0], abs=1e-12 * np.abs(two_parts[0]).max())
        assert np.abs(one_part[1] - two_parts[1]).max() > 0.1 * np.abs(two_parts[1]).max()


def test_each_bench_that_moves_by_itself_has_no_distortion() -> None:
    """Each reads its own motion against its test mass, and nothing of the other's."""
    a, b = renamed(random_layout(2, 1), "A_"), renamed(random_layout(5, 1), "B_")
    both, rng = together(a, b), np.random.default_rng(2)
    move = {mark: 1e-8 * rng.normal(size=(2, 3)) for mark in "AB"}
    nodes = {e.name: np.array(e.ref_m) for e in both.bench}
    motion = {}
    for e in both.bench:
        shift, theta = move[e.name[0]]
        motion[e.name] = np.concatenate([shift + np.cross(theta, e.ref_m), theta])[None]
    found = chain_of(both, motion, nodes)
    for mass in both.test_masses:
        shift, theta = move[mass.name[0]]
        axes = np.array(mass.axes)
        N, rigid, rest = rows_of(found, both, mass.name)
        expected = -np.array([axes[0] @ (shift + np.cross(theta, mass.ref_m)), axes[1] @ theta, axes[2] @ theta])
        assert N[:, :, 0] == pytest.approx(np.array([expected] * len(N)), abs=1e-18)
        assert rigid[:, :, 0] == pytest.approx(np.array([expected] * len(N)), abs=1e-18)
        assert np.abs(rest).max() < 1e-18


def test_the_shipped_bench_is_one(layout: OpticalLayout) -> None:
    assert benches(layout) == {"bench": layout.bench}


def test_names_are_those_of_whole_benches() -> None:
    a, b = renamed(random_layout(2, 1), "A_"), renamed(random_layout(5, 1), "B_")
    both = together(a, b)

    def said(**names: str) -> dict[str, set[str]]:
        other = tuple(replace(e, bench=names.get(e.name)) for e in both.elements)
        return {k: {e.name[0] for e in on} for k, on in benches(replace(both, elements=other)).items()}

    assert said(B_FM="OB2") in ({"OB2": {"B"}, "bench_1": {"A"}}, {"bench_1": {"A"}, "OB2": {"B"}})
    assert said(B_FM="bench_1").keys() == {"bench_1", "bench_2"}
    assert said(A_FM="OB", B_FM="OB") == {"OB": {"A", "B"}}


def test_an_element_on_no_beam_is_on_the_nearest_bench() -> None:
    a, b = renamed(random_layout(2, 1), "A_"), renamed(random_layout(5, 1), "B_")
    both = together(a, b)
    near = next(e for e in both.bench if e.name.startswith("B_M"))
    spare = replace(near, name="SPARE", ref_m=vector(np.array(near.ref_m) + 1e-3))
    on = benches(replace(both, elements=(spare, *both.elements)))
    assert next(name for name, es in on.items() if spare in es) == next(name for name, es in on.items() if near in es)
    apart = benches(replace(both, elements=(replace(spare, bench="C"), *both.elements)))
    assert [e.name for e in apart["C"]] == ["SPARE"]


def test_beams_that_are_not_known_may_join_everything() -> None:
    a, b = renamed(random_layout(2, 1), "A_"), renamed(random_layout(5, 1), "B_")
    both = together(a, b)
    blind = replace(both, paths=(replace(both.paths[0], steps=()), *both.paths[1:]))
    assert list(benches(blind)) == ["bench"]
    marked = tuple(replace(e, bench=None if e.kind == "test_mass" else e.name[0]) for e in blind.elements)
    assert set(benches(replace(blind, elements=marked))) == {"A", "B"}


def test_an_element_between_two_named_benches_must_say_which(layout_file: Path, tmp_path: Path) -> None:
    file = tmp_path / "optics.toml"
    text = layout_file.read_text()
    file.write_text(
        text.replace('name = "FIM"', 'name = "FIM"\nbench = "A"').replace('name = "M1"', 'name = "M1"\nbench = "B"')
    )
    with pytest.raises(ConfigError) as caught:
        load_layout(file)
    assert caught.value.problems[0][0] == "element"
    assert "BS1" in caught.value.problems[0][1]
    assert "joined by beams to elements on A and B, and must say which `bench` to be on" in caught.value.problems[0][1]
    file.write_text(text.replace('name = "TM1"', 'name = "TM1"\nbench = "A"', 1))
    with pytest.raises(ConfigError) as caught:
        load_layout(file)
    assert caught.value.problems == [("element[0].bench", "a test_mass (TM1) has no such key")]
