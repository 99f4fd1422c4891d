"""The invariances of a bench, on the shipped layout and on random ones with one to three test masses."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest
from random_layouts import Ray, axis_rows, random_layout, vector, with_tilted_photodiodes
from scipy.spatial.transform import Rotation

from tedm_cli.arrays import FloatArray
from tedm_cli.errors import PhysicsError
from tedm_cli.optics.chain import optics_chain
from tedm_cli.optics.invariances import invariance_residuals
from tedm_cli.optics.labels import input_labels, laser_labels, output_labels
from tedm_cli.optics.law import law_matrix
from tedm_cli.optics.layout import OpticalLayout
from tedm_cli.optics.layout_checks import check_layout, failures
from tedm_cli.optics.sensitivity import move_reference_points, optical_sensitivity
from tedm_cli.optics.trace import nominal_poses, trace, trace_path

STEP = 1e-30

RANDOM = {
    "one test mass, one set": lambda: random_layout(2, 1, sets=("A",)),
    "two test masses, planar": lambda: random_layout(1, 2, planar=True),
    "two test masses": lambda: random_layout(3, 2),
    "three test masses": lambda: random_layout(1, 3),
    "two test masses, planar, tilted photodiodes": lambda: with_tilted_photodiodes(random_layout(4, 2, planar=True), 4),
    "three test masses, tilted photodiodes": lambda: with_tilted_photodiodes(random_layout(1, 3), 5),
}


@pytest.fixture(scope="module", params=["shipped", *RANDOM])
def bench(request: pytest.FixtureRequest, layout: OpticalLayout) -> OpticalLayout:
    return layout if request.param == "shipped" else RANDOM[request.param]()


@pytest.fixture(scope="module")
def S(bench: OpticalLayout) -> FloatArray:
    return optical_sensitivity(bench)


def blocks(layout: OpticalLayout, S: FloatArray, name: str) -> FloatArray:
    """Columns of one element as [n_paths, 5, 6]."""
    return S[:, layout.columns(name)].reshape(-1, 5, 6)


def rigid(layout: OpticalLayout, rotation: Rotation, shift: FloatArray) -> FloatArray:
    """Finite rigid motion of all elements, [n_elements, 6]."""
    motion = np.empty((len(layout.elements), 6))
    motion[:, :3] = rotation.apply(layout.refs_m) + shift - layout.refs_m
    motion[:, 3:] = rotation.as_rotvec()
    return motion


def test_the_random_layouts_are_valid(bench: OpticalLayout) -> None:
    assert [f.line for f in failures(check_layout(bench))] == []


def test_the_trace_follows_every_path_as_another_geometry_does(bench: OpticalLayout) -> None:
    for path in bench.paths:
        source = bench.elements[bench.index(path.steps[0].element)]
        ray = Ray(np.array(source.ref_m), np.array(source.normal), source.opl_offset_m)
        for step in path.steps[1:]:
            ray.follow(bench.elements[bench.index(step.element)], step.op)
        found = trace_path(bench, path, nominal_poses(bench))
        assert found.hits[-1].point == pytest.approx(ray.point, abs=2e-14)
        assert found.hits[-1].direction == pytest.approx(ray.direction, abs=2e-14)
        assert found.output[2] == pytest.approx(ray.path, abs=2e-14)


def test_the_derivative_agrees_with_a_complex_step(bench: OpticalLayout, S: FloatArray) -> None:
    """Along twenty random motions of all elements, and along the same motion of all."""
    rng = np.random.default_rng(4)
    n = len(bench.elements)
    poses = nominal_poses(bench)
    for direction in (*rng.normal(size=(20, n, 6)), *(np.tile(axis, (n, 1)) for axis in np.eye(6))):
        exact = trace(bench, poses.moved(1j * STEP * direction)).imag.reshape(-1) / STEP
        scale = np.abs(S) @ np.abs(direction.reshape(-1))
        assert np.abs(S @ direction.reshape(-1) - exact).max() < 1e-14 * scale.max()


def test_motion_of_everything_at_any_amplitude_changes_no_output(bench: OpticalLayout) -> None:
    rng = np.random.default_rng(5)
    for seed in range(3):
        motion = rigid(bench, Rotation.random(random_state=seed), rng.normal(size=3))
        assert trace(bench, nominal_poses(bench).moved(motion)) == pytest.approx(trace(bench), abs=5e-14)


def test_all_residuals_are_rounding(bench: OpticalLayout, S: FloatArray) -> None:
    residuals = invariance_residuals(bench, S).named()
    assert {f"bench_motion_{name}" for name in bench.sets} < set(residuals)
    assert max(residuals.values()) < 1e-13


def test_a_bench_that_moves_alone_reads_as_minus_its_motion(bench: OpticalLayout, S: FloatArray) -> None:
    rng = np.random.default_rng(6)
    shift, theta = rng.normal(size=3), rng.normal(size=3)
    places = [bench.index(e.name) for e in bench.bench]
    D_opt = np.zeros((1, len(places), 6))
    D_opt[0, :, :3] = shift + np.cross(theta, bench.refs_m[places])
    D_opt[0, :, 3:] = theta
    expected = []
    for mass in bench.test_masses:
        expected += [-(shift + np.cross(theta, np.array(mass.ref_m)))[0], -theta[1], -theta[2]]
    for read in optics_chain(bench, S, D_opt).sets:
        assert read.N[:, 0] == pytest.approx(expected, abs=1e-12)


def test_the_same_bench_in_another_frame_reads_the_same(bench: OpticalLayout, S: FloatArray) -> None:
    """Model and distortion turned and shifted in the basic frame, and the layout frame declared with them."""
    rng = np.random.default_rng(7)
    R, origin = Rotation.random(random_state=7).as_matrix(), rng.normal(size=3)
    places = [bench.index(e.name) for e in bench.bench]
    nodes = bench.refs_m[places] + rng.normal(scale=0.01, size=(len(places), 3))
    D_opt = rng.normal(size=(4, len(places), 2, 3))
    framed = replace(bench, frame_axes=axis_rows(R.T), frame_origin_m=vector(origin))
    moved, turned = nodes @ R.T + origin, D_opt @ R.T
    here = optics_chain(bench, move_reference_points(S, bench, nodes), D_opt.reshape(4, -1, 6))
    there = optics_chain(framed, move_reference_points(S, framed, moved), turned.reshape(4, -1, 6))
    undeclared = optics_chain(bench, move_reference_points(S, bench, moved), turned.reshape(4, -1, 6))
    for a, b, c in zip(here.sets, there.sets, undeclared.sets, strict=True):
        assert pytest.approx(a.N, abs=1e-12) == b.N
        assert np.abs(c.N - a.N).max() > 0.1
    assert pytest.approx(here.D, abs=1e-12) == there.D


def test_photodiodes_and_windows_parallel_to_a_mass_drop_out(bench: OpticalLayout, S: FloatArray) -> None:
    PS = law_matrix(bench) @ S
    scale = np.abs(PS).max()
    for e in bench.elements:
        if e.kind == "photodiode":
            assert np.abs(PS[:, bench.columns(e.name)]).max() < 1e-13 * scale
        if e.kind == "window":
            assert np.abs(blocks(bench, S, e.name)[:, 2:]).max() < 1e-13 * scale


def test_motions_that_map_a_surface_onto_itself_do_nothing(bench: OpticalLayout, S: FloatArray) -> None:
    reflecting = {s.element for p in bench.paths for s in p.steps if s.op == "R"}
    for e in bench.elements:
        block, scale = blocks(bench, S, e.name), np.abs(S).max()
        if e.kind in ("beamsplitter", "window") and e.name not in reflecting:
            assert np.abs(block[..., :3]).max() < 1e-13 * scale
        if e.kind in ("mirror", "beamsplitter", "test_mass", "window"):
            tangent = np.linalg.svd(np.array([e.normal]))[2][1:]
            assert np.abs(block[..., :3] @ tangent.T).max() < 1e-13 * scale
            assert np.abs(block[..., 3:] @ e.normal).max() < 1e-13 * scale
        if e.kind == "injector":
            assert np.abs(block[..., 3:] @ e.normal).max() < 1e-13 * scale
            along = np.zeros((len(bench.paths), 5))
            along[[p.steps[0].element == e.name for p in bench.paths], 2] = -1.0
            assert block[..., :3] @ e.normal == pytest.approx(along, abs=1e-13)


def test_translations_never_tilt_and_paths_see_only_what_they_meet(bench: OpticalLayout, S: FloatArray) -> None:
    parts = S.reshape(len(bench.paths), 5, len(bench.elements), 6)
    assert np.count_nonzero(parts[:, 3:, :, :3]) == 0
    for path in bench.paths:
        for e in bench.elements:
            met = e.name in {s.element for s in path.steps}
            assert S[bench.rows(path), bench.columns(e.name)].any() == met


def test_a_planar_bench_is_symmetric_about_its_plane(bench: OpticalLayout, S: FloatArray) -> None:
    parts = S.reshape(len(bench.paths), 5, len(bench.elements), 6)
    odd_by_even = np.abs(parts[:, [1, 4]][..., [0, 1, 5]]).max()  # y, z2 by ux, uy, rz
    even_by_odd = np.abs(parts[:, [0, 2, 3]][..., [2, 3, 4]]).max()  # x, opl, z1 by uz, rx, ry
    planar = all(e.ref_m[2] == 0 == e.normal[2] for e in bench.elements)
    assert (max(odd_by_even, even_by_odd) < 1e-13) == planar


def test_length_per_motion_of_each_mass(bench: OpticalLayout, S: FloatArray) -> None:
    """`-2 cos(angle of incidence)` along the normal of the face for every reflection, 0 for masses not met."""
    PS = law_matrix(bench) @ S
    poses = nominal_poses(bench)
    rows = laser_labels(bench).names
    for name in bench.photodiodes:
        path = bench.paths[bench.path_index(name, "meas")]
        expected = np.zeros((len(bench.elements), 3))
        for hit in trace_path(bench, path, poses).hits:
            if bench.elements[hit.element].kind == "test_mass":
                expected[hit.element] += 2 * (hit.direction @ hit.normal) * poses.normal[hit.element]
        row = PS[rows.index(f"{name}_OPD")].reshape(-1, 6)
        for mass in bench.test_masses:
            assert row[bench.index(mass.name), :3] == pytest.approx(expected[bench.index(mass.name)], abs=1e-13)
        assert np.count_nonzero(expected) >= 1


def test_redundant_sets_agree_and_curvature_separates_them(bench: OpticalLayout, S: FloatArray) -> None:
    D_opt = np.random.default_rng(8).normal(size=(5, len(bench.bench), 6))
    chain = optics_chain(bench, S, D_opt)
    assert chain.rank == 3 * len(bench.test_masses)
    seen = np.array(input_labels(bench, bench.test_masses).names)[np.abs(chain.O_ideal).max(axis=0) > 1e-12]
    assert set(seen) == {f"{m.name}_{dof}" for m in bench.test_masses for dof in ("ux", "ry", "rz")}
    if len(chain.sets) < 2:
        return
    scale = np.abs(chain.sets[0].N).max()
    assert np.abs(chain.sets[0].N - chain.sets[1].N).max() < 1e-12 * scale
    radii = tuple(replace(p, wavefront_radius_m=1.0 + 0.3 * i) for i, p in enumerate(bench.paths))
    A, B = (read.N for read in optics_chain(replace(bench, paths=radii), S, D_opt).sets)
    assert np.abs(A - B).max() > 0.01 * scale


def test_a_mass_that_no_beam_meets_makes_the_layout_singular() -> None:
    two = RANDOM["two test masses"]()
    blind = replace(two.elements[two.index("TM2")], name="TM3")
    idle = replace(two, elements=(*two.elements, blind), sets={"A": two.photodiodes})
    with pytest.raises(PhysicsError, match=r"set A .*rank 6 for 9 .*does not see TM3_x, TM3_eta and TM3_phi"):
        optics_chain(idle, optical_sensitivity(idle), np.zeros((1, len(idle.bench), 6)))


@pytest.mark.skipif(bool(np.finfo(np.longdouble).eps > 1e-18), reason="long double is no longer than double here")
def test_central_differences_in_extended_precision(bench: OpticalLayout, S: FloatArray) -> None:
    """Five-point differences of the finite trace in 64-bit mantissas; 1e-4 m and rad leave errors of 1e-15."""
    h = np.longdouble(1e-4)
    nominal = nominal_poses(bench)
    poses = type(nominal)(*(v.astype(np.longdouble) for v in (nominal.ref, nominal.normal, nominal.local_y)))
    rng = np.random.default_rng(9)
    for _ in range(6):
        direction = rng.normal(size=(len(bench.elements), 6))
        direction /= np.abs(direction).max()
        at = {k: trace(bench, poses.moved(k * h * direction)) for k in (-2, -1, 1, 2)}
        slope = (8 * (at[1] - at[-1]) - (at[2] - at[-2])) / (12 * h)
        error = np.abs(slope.reshape(-1) - S @ direction.reshape(-1))
        scale = np.abs(S) @ np.abs(direction.reshape(-1))
        assert (error / scale).max() < 1e-12


def test_labels_fit_any_layout(bench: OpticalLayout, S: FloatArray) -> None:
    assert S.shape == (len(output_labels(bench).names), len(input_labels(bench).names))


def test_a_set_of_one_interferometer_names_the_combination_it_does_not_see() -> None:
    """The last interferometer meets the first and the last mass: it reads a difference, weighed by incidence."""
    three = RANDOM["three test masses"]()
    poor = replace(three, sets={"C": ("PD3A",)}, read_out=("x",))
    with pytest.raises(PhysicsError) as caught:
        optics_chain(poor, optical_sensitivity(poor), np.zeros((1, len(poor.bench), 6)))
    text = str(caught.value)
    assert "rank 1 for 3" in text
    assert "the set does not see TM2_x; it cannot tell TM1_x from TM3_x (TM1_x " in text
    sign, size = re.search(r"TM1_x ([+-]) ([\d.]*) ?TM3_x changes nothing", text).groups()  # type: ignore[union-attr]
    row = (law_matrix(three) @ optical_sensitivity(three))[laser_labels(three).names.index("PD3A_OPD")]
    by_mass = [row[three.columns(name)][0] for name in ("TM1", "TM3")]
    assert float(f"{sign}{size or 1}") == pytest.approx(-by_mass[0] / by_mass[1], rel=6e-3)


def test_a_set_without_one_interferometer_does_not_see_its_mass() -> None:
    three = RANDOM["three test masses, tilted photodiodes"]()
    poor = replace(three, sets={"C": ("PD1A", "PD1B", "PD3A")})
    with pytest.raises(PhysicsError, match=r"rank 6 for 9 .* does not see TM2_x, TM2_eta and TM2_phi\n"):
        optics_chain(poor, optical_sensitivity(poor), np.zeros((1, len(poor.bench), 6)))


def thin(layout: OpticalLayout, *names: str) -> OpticalLayout:
    """The layout with these plates (all unless named) as thin as can be."""
    chosen = [e.name for e in layout.elements if e.is_plate and e.name in (names or (e.name,))]
    assert chosen
    elements = tuple(replace(e, thickness_m=0.0) if e.name in chosen else e for e in layout.elements)
    return replace(layout, elements=elements)


def test_a_thin_plate_is_the_limit_of_plates(layout: OpticalLayout) -> None:
    """Pellicles: met from either side, beams pass as if they were not there, and all invariances hold."""
    flat = thin(layout)
    S = optical_sensitivity(flat)
    for thickness in (1e-4, 1e-6):
        nearly = replace(
            layout, elements=tuple(replace(e, thickness_m=thickness) if e.is_plate else e for e in layout.elements)
        )
        assert np.abs(optical_sensitivity(nearly) - S).max() < 3.0 * thickness * 10
    nodes = np.array([e.ref_m for e in flat.bench])
    for name, value in invariance_residuals(flat, S, nodes, law_matrix(flat)).named().items():
        if name != "photodiode_columns":
            assert value < 1e-9, name
    denser = replace(flat, elements=tuple(replace(e, index=1.9) if e.is_plate else e for e in flat.elements))
    np.testing.assert_allclose(optical_sensitivity(denser), S, rtol=0, atol=1e-14)
    for name in ("BS1", "W1", "W2"):  # only transmit
        assert np.abs(S[:, flat.columns(name)]).max() < 1e-14


def test_a_mirror_without_substrate_is_no_thin_plate(layout: OpticalLayout) -> None:
    behind = replace(
        layout,
        elements=tuple(replace(e, kind="mirror", thickness_m=0.0) if e.name == "BS4" else e for e in layout.elements),
    )
    with pytest.raises(PhysicsError, match=r"from behind|goes through|cannot"):
        optical_sensitivity(behind)
