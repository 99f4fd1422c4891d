"""Test masses with axes of their own: what is read is along and about these, however the layout is turned."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from random_layouts import axis_rows, random_layout, vector
from scipy.spatial.transform import Rotation

from tedm_cli.arrays import FloatArray
from tedm_cli.optics.bodies import body
from tedm_cli.optics.chain import optics_chain
from tedm_cli.optics.expansion import face_motion
from tedm_cli.optics.invariances import invariance_residuals
from tedm_cli.optics.labels import read_out_labels
from tedm_cli.optics.law import law_matrix
from tedm_cli.optics.layout import LAYOUT_AXES, Dof, Element, MassExpansion, OpticalLayout
from tedm_cli.optics.matrix_checks import judge_matrix
from tedm_cli.optics.sensitivity import move_reference_points, optical_sensitivity
from tedm_cli.optics.trace import nominal_poses, trace

K = 3  # thermal areas
SEEDS = st.integers(0, 2**32 - 1)


@pytest.fixture(scope="module", params=["shipped", "three"])
def bench(request: pytest.FixtureRequest, layout: OpticalLayout) -> OpticalLayout:
    return layout if request.param == "shipped" else random_layout(1, 3)


def moved_element(e: Element, R: FloatArray, shift: FloatArray) -> Element:
    """The element turned by R and shifted, with its axes."""
    return replace(
        e,
        ref_m=vector(R @ e.ref_m + shift),
        normal=vector(R @ e.normal),
        local_y=None if e.local_y is None else vector(R @ e.local_y),
        axes=axis_rows(np.array(e.axes) @ R.T),
    )


def turned_within(layout: OpticalLayout, R: FloatArray, shift: FloatArray) -> OpticalLayout:
    """All vectors of the file turned and shifted, its frame the other way: the same bench in the same place."""
    axes = R @ layout.axes
    return replace(
        layout,
        elements=tuple(moved_element(e, R, shift) for e in layout.elements),
        frame_axes=axis_rows(axes),
        frame_origin_m=vector(np.array(layout.frame_origin_m) - shift @ axes),
    )


def random_bench_motion(layout: OpticalLayout, seed: int) -> tuple[FloatArray, FloatArray]:
    """Grids beside the reference points and their motions per area, basic frame."""
    rng = np.random.default_rng(seed)
    places = [layout.index(e.name) for e in layout.bench]
    nodes = layout.refs_m[places] @ layout.axes + np.array(layout.frame_origin_m)
    return nodes + rng.normal(scale=0.01, size=nodes.shape), 1e-8 * rng.normal(size=(K, len(places), 6))


def read(layout: OpticalLayout, nodes: FloatArray, D_opt: FloatArray) -> list[FloatArray]:
    """N and its rigid part of all sets."""
    S_BW = move_reference_points(optical_sensitivity(layout), layout, nodes)
    assert max(invariance_residuals(layout, S_BW, nodes).bench_motion.values()) < 1e-9
    face = face_motion(layout, ["a", "b", "c"])
    sets = optics_chain(layout, S_BW, D_opt, nodes, face).sets
    return [N for s in sets for N in (s.N, s.N_rigid)]


@settings(max_examples=8)
@given(SEEDS)
def test_the_same_bench_written_in_another_frame_reads_the_same(bench: OpticalLayout, seed: int) -> None:
    """The file's vectors and the axes of its test masses turned, the frame turned back; the bench itself stays."""
    rng = np.random.default_rng(seed)
    bench = replace(bench, expansions=(MassExpansion(bench.test_masses[0].name, 1e-5, "b"),))
    other = turned_within(bench, Rotation.random(random_state=rng).as_matrix(), rng.normal(size=3))
    assert other.test_mass_axes_basic == pytest.approx(bench.test_mass_axes_basic, abs=1e-14)
    nodes, D_opt = random_bench_motion(bench, seed)
    for here, there in zip(read(bench, nodes, D_opt), read(other, nodes, D_opt), strict=True):
        assert there == pytest.approx(here, abs=1e-11 * np.abs(here).max())


@settings(max_examples=8)
@given(SEEDS)
def test_everything_turned_reads_the_same(bench: OpticalLayout, seed: int) -> None:
    """Layout, test masses, grids and their motions all turned in the basic frame, whose axes stay."""
    rng = np.random.default_rng(seed)
    R, shift = Rotation.random(random_state=rng).as_matrix(), rng.normal(size=3)
    turned = replace(bench, elements=tuple(moved_element(e, R, shift) for e in bench.elements))
    assert turned.has_own_axes
    nodes, D_opt = random_bench_motion(bench, seed)
    motion = (D_opt.reshape(K, -1, 2, 3) @ R.T).reshape(D_opt.shape)
    for here, there in zip(read(bench, nodes, D_opt), read(turned, nodes @ R.T + shift, motion), strict=True):
        assert there == pytest.approx(here, abs=1e-11 * np.abs(here).max())


def normal_free(layout: OpticalLayout, rng: np.random.Generator) -> OpticalLayout:
    """Each test mass with axes turned about the normal of its face, by angles of their own, x along or against it."""
    masses = {}
    for e in layout.test_masses:
        x = np.array(e.normal) * rng.choice([-1.0, 1.0])
        y = np.cross(x, rng.normal(size=3))
        y /= np.linalg.norm(y)
        masses[e.name] = replace(e, axes=axis_rows(np.array([x, y, np.cross(x, y)])))
    return replace(layout, elements=tuple(masses.get(e.name, e) for e in layout.elements))


@settings(max_examples=8)
@given(SEEDS)
def test_read_outs_turn_with_the_axes_of_their_test_mass(bench: OpticalLayout, seed: int) -> None:
    """About the normal of the face: x keeps but for its sign, and the vector of eta and phi is the same one."""
    rng = np.random.default_rng(seed)
    other = normal_free(bench, rng)
    nodes, D_opt = random_bench_motion(bench, seed)
    for here, there in zip(read(bench, nodes, D_opt), read(other, nodes, D_opt), strict=True):
        for t, (mass, turned) in enumerate(zip(bench.test_masses, other.test_masses, strict=True)):
            rows = slice(3 * t, 3 * t + 3)
            was, now = np.array(mass.axes), np.array(turned.axes)
            abs_ = 1e-11 * np.abs(here).max()
            assert there[rows][:1].T @ now[:1] == pytest.approx(here[rows][:1].T @ was[:1], abs=abs_)
            assert there[rows][1:].T @ now[1:] == pytest.approx(here[rows][1:].T @ was[1:], abs=abs_)


@settings(max_examples=8)
@given(SEEDS)
def test_a_test_mass_that_moves_along_its_own_axes_reads_as_that(bench: OpticalLayout, seed: int) -> None:
    """Against finite differences of the ray trace, test masses moved along and about the axes of each."""
    rng = np.random.default_rng(seed)
    R = Rotation.random(random_state=rng).as_matrix()
    turned = normal_free(replace(bench, elements=tuple(moved_element(e, R, R[0]) for e in bench.elements)), rng)
    chain = optics_chain(turned, optical_sensitivity(turned), np.zeros((1, len(turned.bench), 6)))
    own = rng.normal(size=(len(turned.test_masses), 6))  # x y z theta eta phi
    motion = np.zeros((len(turned.elements), 6))
    for mass, m in zip(turned.test_masses, own, strict=True):
        axes = np.array(mass.axes)
        motion[turned.index(mass.name)] = [*(m[:3] @ axes), *(m[3:] @ axes)]
    h, at = 1e-5, nominal_poses(turned)
    change = (trace(turned, at.moved(h * motion)) - trace(turned, at.moved(-h * motion))).reshape(-1) / (2 * h)
    assert chain.O_ideal @ own.reshape(-1) == pytest.approx(chain.P @ change, abs=1e-7)
    for s in chain.sets:
        assert s.inverse @ chain.P @ change == pytest.approx(own[:, [0, 4, 5]].reshape(-1), abs=1e-6)


def test_a_face_five_milliradians_off_the_layout_axes(layout: OpticalLayout) -> None:
    """Refused as it stands, for x of the layout is not what the beam measures; read with the axes of the mass."""
    turn = Rotation.from_rotvec([0.0, 0.0, 5e-3]).as_matrix()
    turned = replace(layout, elements=tuple(moved_element(e, turn, np.zeros(3)) for e in layout.elements))
    wrong = replace(turned, elements=tuple(replace(e, axes=LAYOUT_AXES) for e in turned.elements))
    assert invariance_residuals(wrong, optical_sensitivity(wrong)).bench_motion["A"] > 1e-3
    assert invariance_residuals(turned, optical_sensitivity(turned)).bench_motion["A"] < 1e-13


@pytest.mark.parametrize(("off", "passes"), [(0.0, True), (2e-5, True), (0.9e-4, True), (1.1e-4, False), (5e-3, False)])
def test_axes_that_are_rounded_are_no_mistake(layout: OpticalLayout, off: float, passes: bool) -> None:
    """A face off its axes by the rounding of a drawing reads y as x by that angle; more is refused."""
    turn = Rotation.from_rotvec([0.0, 0.0, off]).as_matrix()
    elements = tuple(replace(e, axes=axis_rows(turn)) if e.name == "TM2" else e for e in layout.elements)
    turned = replace(layout, elements=elements)
    assert turned.skews_rad == pytest.approx([0.0, off], abs=1e-12)
    nodes, _ = random_bench_motion(layout, 3)
    matrix = move_reference_points(optical_sensitivity(turned), turned, nodes)
    judged = {j.name: j for j in judge_matrix(turned, matrix, law_matrix(turned), nodes)}
    for name in turned.sets:
        assert judged[f"bench_motion_{name}"].passed == passes
        assert judged[f"bench_motion_{name}"].value == pytest.approx(np.sin(off), rel=1e-3, abs=1e-12)
    assert all(j.passed for name, j in judged.items() if not name.startswith("bench_motion"))


def test_each_test_mass_may_be_measured_otherwise(layout: OpticalLayout) -> None:
    """One degree of freedom fewer of one test mass leaves the others as they are, where nothing is read through it."""
    masses: dict[str, tuple[Dof, ...] | None] = {"TM1": None, "TM2": ("phi", "x")}
    fewer = replace(
        layout,
        elements=tuple(replace(e, read_out=masses[e.name]) if e.name in masses else e for e in layout.elements),
    )
    assert read_out_labels(fewer).names == ("TM1_x", "TM1_eta", "TM1_phi", "TM2_phi", "TM2_x")
    assert read_out_labels(fewer).units == ("m", "rad", "rad", "rad", "m")
    nodes, D_opt = random_bench_motion(layout, 3)
    S_BW = move_reference_points(optical_sensitivity(layout), layout, nodes)
    for a, b in zip(
        optics_chain(layout, S_BW, D_opt, nodes).sets, optics_chain(fewer, S_BW, D_opt, nodes).sets, strict=True
    ):
        # The planar bench reads eta apart from x and phi: without it these stay, and eta of TM1 takes what it hid.
        assert b.N[[0, 2, 3, 4]] == pytest.approx(a.N[[0, 2, 5, 3]], abs=1e-12 * np.abs(a.N).max())
        assert b.gain @ fewer.read_out_motions == pytest.approx(np.eye(5), abs=1e-14)


@settings(max_examples=8)
@given(SEEDS)
def test_a_test_mass_is_drawn_with_edges_along_its_axes(layout: OpticalLayout, seed: int) -> None:
    """With nothing but its normal and its axes given, however it is turned."""
    rng = np.random.default_rng(seed)
    R = Rotation.random(random_state=rng).as_matrix()
    turned = replace(
        layout, elements=tuple(replace(moved_element(e, R, np.zeros(3)), local_y=None) for e in layout.elements)
    )
    for mass in turned.test_masses:
        corners = body(turned, turned.index(mass.name), nominal_poses(turned))
        own = (corners - np.array(mass.ref_m)) @ np.array(mass.axes).T
        assert np.abs(own) == pytest.approx(np.full((8, 3), 0.023), abs=1e-15)
