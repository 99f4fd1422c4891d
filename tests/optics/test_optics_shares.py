"""What a read-out is made of: exact sums, single movers, the bench as one, redundant sets, growing test masses."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from random_layouts import axis_rows, random_layout, vector, with_tilted_photodiodes
from scipy.spatial.transform import Rotation

from tedm_cli.arrays import FloatArray
from tedm_cli.errors import InputError
from tedm_cli.optics.chain import OpticsChain, optics_chain
from tedm_cli.optics.common_mode import common_mode, rigid_motion
from tedm_cli.optics.expansion import face_motion
from tedm_cli.optics.labels import input_labels
from tedm_cli.optics.layout import MassExpansion, OpticalLayout
from tedm_cli.optics.sensitivity import move_reference_points, optical_sensitivity
from tedm_cli.optics.shares import beam_terms, compare_sets, motion_terms, shares
from tedm_cli.optics.trace import nominal_poses, trace


@pytest.fixture(scope="module", params=["shipped", "random"])
def bench(request: pytest.FixtureRequest, layout: OpticalLayout) -> OpticalLayout:
    return layout if request.param == "shipped" else with_tilted_photodiodes(random_layout(1, 3), 2)


@pytest.fixture(scope="module")
def S(bench: OpticalLayout) -> FloatArray:
    return optical_sensitivity(bench)


@pytest.fixture(scope="module")
def D_opt(bench: OpticalLayout) -> FloatArray:
    return 1e-8 * np.random.default_rng(21).normal(size=(9, len(bench.bench), 6))


@pytest.fixture(scope="module")
def chain(bench: OpticalLayout, S: FloatArray, D_opt: FloatArray) -> OpticsChain:
    face = 1e-8 * np.random.default_rng(22).normal(size=(len(bench.test_masses), len(D_opt)))
    return optics_chain(bench, S, D_opt, face_m=face)


def moved_alone(layout: OpticalLayout, name: str, motion: FloatArray) -> FloatArray:
    """D_opt [1, n_bench, 6] of one element."""
    out = np.zeros((1, len(layout.bench), 6))
    out[0, [e.name for e in layout.bench].index(name)] = motion
    return out


def test_motions_and_beams_sum_to_the_read_out(chain: OpticsChain, S: FloatArray) -> None:
    for s in chain.sets:
        scale = np.abs(s.gain) @ np.abs(chain.motion)
        assert (np.abs(motion_terms(s.gain, chain.motion).sum(axis=1) - s.N) < 1e-14 * scale).all()
        by_beam = beam_terms(s.inverse, chain.P, S @ chain.motion)
        assert np.abs(by_beam.sum(axis=1) - s.N).max() < 1e-13 * scale.max()
        assert (np.abs(s.N_rigid + s.N_distortion - s.N) < 1e-15 * scale).all()
        for r, total in enumerate(s.N):
            assert shares(motion_terms(s.gain, chain.motion)[r], total).sum() == pytest.approx(1.0, abs=1e-12)
            assert shares(by_beam[r], total).sum() == pytest.approx(1.0, abs=1e-11)


def test_beams_of_the_other_set_carry_nothing(bench: OpticalLayout, chain: OpticsChain, S: FloatArray) -> None:
    for s in chain.sets:
        terms = np.abs(beam_terms(s.inverse, chain.P, S @ chain.motion)).max(axis=(0, 2))
        assert [p.photodiode in s.photodiodes for p in bench.paths] == list(terms > 0)


def test_one_mover_has_it_all(bench: OpticalLayout, S: FloatArray) -> None:
    names = [label.rpartition("_")[0] for label in input_labels(bench).names]
    mirror = next(e.name for e in bench.bench if e.kind == "mirror")
    alone = optics_chain(bench, S, moved_alone(bench, mirror, np.array([1.0, -2.0, 0.5, 0.3, 2.0, 1.0]) * 1e-9))
    mine = np.array([name == mirror for name in names])
    for s in alone.sets:
        for r in range(len(s.N)):
            if abs(s.N[r, 0]) > 1e-12:
                found = shares(motion_terms(s.gain, alone.motion)[r], s.N[r])
                assert found[mine].sum() == pytest.approx(1.0, abs=1e-12)
                assert not found[~mine].any()
        assert np.abs(s.N).max() > 1e-10


def test_shares_do_not_know_the_scale_and_turn_with_the_sign(chain: OpticsChain) -> None:
    s = chain.sets[0]
    terms = motion_terms(s.gain, chain.motion)[0]
    reference = shares(terms, s.N[0])
    assert shares(-3e5 * terms, -3e5 * s.N[0]) == pytest.approx(reference, abs=1e-13)
    signs = np.where(np.arange(terms.shape[1]) % 2, 1.0, -1.0)  # areas that fluctuate alone may do so either way
    assert shares(terms * signs, s.N[0] * signs) == pytest.approx(reference, abs=1e-13)
    assert not shares(terms, np.zeros_like(s.N[0])).any()


def test_shares_are_those_of_the_variance(chain: OpticsChain) -> None:
    """Temperatures that fluctuate alike and independently: covariance of a term with the read-out over its variance."""
    s = chain.sets[0]
    T = np.random.default_rng(23).normal(size=(chain.motion.shape[1], 400_000))
    terms = motion_terms(s.gain, chain.motion)[1]
    best = int(np.argmax(np.abs(shares(terms, s.N[1]))))
    sampled = np.cov(terms[best] @ T, s.N[1] @ T)
    assert sampled[0, 1] / sampled[1, 1] == pytest.approx(shares(terms, s.N[1])[best], rel=2e-2)


def test_the_same_shares_in_another_frame(bench: OpticalLayout, S: FloatArray, D_opt: FloatArray) -> None:
    """Model and distortion turned and shifted, the layout frame declared with them; rotations about other nodes."""
    rng = np.random.default_rng(24)
    R, origin = Rotation.random(random_state=24).as_matrix(), rng.normal(size=3)
    places = [bench.index(e.name) for e in bench.bench]
    nodes = bench.refs_m[places] + rng.normal(scale=0.01, size=(len(places), 3))
    framed = replace(bench, frame_axes=axis_rows(R.T), frame_origin_m=vector(origin))
    moved, turned = nodes @ R.T + origin, (D_opt.reshape(9, -1, 2, 3) @ R.T).reshape(D_opt.shape)
    here = optics_chain(bench, move_reference_points(S, bench, nodes), D_opt, nodes)
    there = optics_chain(framed, move_reference_points(S, framed, moved), turned, moved)
    for a, b in zip(here.sets, there.sets, strict=True):
        scale = np.abs(a.gain) @ np.abs(here.motion)
        assert (np.abs(a.N_rigid - b.N_rigid) < 1e-12 * scale.max()).all()
        assert (
            np.abs(motion_terms(a.gain, here.motion) - motion_terms(b.gain, there.motion)).max() < 1e-12 * scale.max()
        )
    assert pytest.approx(here.rigid.amplitude, rel=1e-11, abs=1e-20) == there.rigid.amplitude


def test_a_bench_that_moves_as_one_has_no_distortion(bench: OpticalLayout, S: FloatArray) -> None:
    """At its nodes, beside the reference points; every test mass reads minus the motion at its own centre."""
    rng = np.random.default_rng(25)
    places = [bench.index(e.name) for e in bench.bench]
    nodes = bench.refs_m[places] + rng.normal(scale=0.01, size=(len(places), 3))
    shift, theta = 1e-8 * rng.normal(size=(2, 3))
    D_opt = np.zeros((1, len(places), 6))
    D_opt[0, :, :3], D_opt[0, :, 3:] = shift + np.cross(theta, nodes), theta
    chain = optics_chain(bench, move_reference_points(S, bench, nodes), D_opt, nodes)
    for s in chain.sets:
        assert np.abs(s.N_distortion).max() < 1e-12 * np.abs(s.N).max()
        for t, mass in enumerate(bench.test_masses):
            here = shift + np.cross(theta, mass.ref_m)
            assert s.N_rigid[3 * t : 3 * t + 3, 0] == pytest.approx(
                [-here[0], -theta[1], -theta[2]], rel=1e-11, abs=1e-20
            )
    assert chain.rigid.amplitude[:3, 0] == pytest.approx(
        shift + np.cross(theta, chain.rigid.about[0]), rel=1e-11, abs=1e-20
    )
    assert chain.rigid.amplitude[3:, 0] == pytest.approx(theta, rel=1e-11, abs=1e-20)


def test_the_rigid_part_is_the_least_squares_one(bench: OpticalLayout, D_opt: FloatArray, chain: OpticsChain) -> None:
    """No other rigid motion leaves less, translations and rotations of bench elements but windows weighed alike."""
    asked = tuple(e for e in bench.bench if e.kind != "window")
    rows = bench.columns_of(asked)
    lever = np.sqrt(np.sum(bench.refs_m[[bench.index(e.name) for e in asked]].var(axis=0)))
    weight = np.tile([1.0] * 3 + [lever] * 3, len(asked))[:, None]
    modes = weight * rigid_motion(bench, about_m=chain.rigid.about[0])[rows]
    left = weight * (chain.motion - chain.rigid.motion)[rows]
    assert np.abs(modes.T @ left).max() < 1e-14 * np.linalg.norm(modes) * np.linalg.norm(left)
    assert np.linalg.norm(left) > 0.5 * np.linalg.norm(weight * chain.motion[rows])
    mean = D_opt[:, [e.kind != "window" for e in bench.bench], :3].mean(axis=1)
    assert pytest.approx(mean, rel=1e-11, abs=1e-20) == chain.rigid.amplitude[:3].T


def test_what_is_left_holds_no_rigid_motion(bench: OpticalLayout, chain: OpticsChain) -> None:
    again = common_mode(bench, chain.motion - chain.rigid.motion)
    assert np.abs(again.amplitude).max() < 1e-14 * np.abs(chain.rigid.amplitude).max()


def test_plane_waves_make_a_second_set_add_nothing(chain: OpticsChain) -> None:
    a, b = chain.sets[:2]
    found = compare_sets(a.name, a.N, b.name, b.N)
    assert found.relative.max() < 1e-12
    assert found.mean == pytest.approx(found.amplitudes[0], rel=1e-12)
    assert found.best == pytest.approx(found.amplitudes[0], rel=1e-12)
    assert (found.weight == 0.5).all()


def with_curvature(layout: OpticalLayout, radius: float) -> OpticalLayout:
    """The measurement beams on the photodiodes of set B curved."""
    curved = [p.photodiode in layout.sets["B"] and p.beam == "meas" for p in layout.paths]
    paths = [replace(p, wavefront_radius_m=radius if c else None) for p, c in zip(layout.paths, curved, strict=True)]
    return replace(layout, paths=tuple(paths))


@pytest.mark.parametrize("radius", [0.5, 3.0, -10.0, 1e4])
def test_curvature_separates_the_sets_by_the_spot_that_is_left(
    layout: OpticalLayout, S_BW: FloatArray, radius: float
) -> None:
    """Let the test masses follow what set A reads: it reads nothing more, set B the moved spot over Rc."""
    D_opt = 1e-8 * np.random.default_rng(26).normal(size=(9, len(layout.bench), 6))
    chain = optics_chain(with_curvature(layout, radius), S_BW, D_opt)
    a, b = chain.sets
    follow = chain.motion.copy()
    follow -= layout.read_out_motions @ a.N
    spots = (S_BW @ follow).reshape(len(layout.paths), 5, -1)[:, :2]
    slopes = np.zeros((6, 9))
    for i, name in enumerate(layout.sets["B"]):
        slopes[3 * i + 1 : 3 * i + 3] = -spots[layout.path_index(name, "meas")] / radius
    assert pytest.approx(b.law.inverse @ slopes, rel=1e-11, abs=1e-20) == b.N - a.N
    assert np.abs(b.N - a.N).max() > 1e-3 * np.abs(a.N).max() / abs(radius)


def test_the_separation_fades_with_the_radius(layout: OpticalLayout, S_BW: FloatArray) -> None:
    D_opt = 1e-8 * np.random.default_rng(27).normal(size=(9, len(layout.bench), 6))
    apart = []
    for radius in (1e3, 1e4):
        a, b = optics_chain(with_curvature(layout, radius), S_BW, D_opt).sets
        apart.append(np.abs(a.N - b.N).max())
    assert apart[0] / apart[1] == pytest.approx(10.0, rel=1e-2)


def test_the_best_weighted_mean_is_no_worse_than_any_other(layout: OpticalLayout, S_BW: FloatArray) -> None:
    D_opt = 1e-8 * np.random.default_rng(28).normal(size=(9, len(layout.bench), 6))
    a, b = optics_chain(with_curvature(layout, 0.1), S_BW, D_opt).sets
    found = compare_sets("A", a.N, "B", b.N)
    assert np.array_equal(found.difference, a.N - b.N)
    assert found.relative.max() > 0.1
    best = np.linalg.norm(found.weight[:, None] * a.N + (1 - found.weight[:, None]) * b.N, axis=1)
    assert found.best == pytest.approx(best, rel=1e-12)
    for w in np.linspace(0, 1, 101):
        assert (found.best <= (1 + 1e-12) * np.linalg.norm(w * a.N + (1 - w) * b.N, axis=1)).all()
    inside = (found.weight > 0) & (found.weight < 1)
    assert inside.any()
    assert not inside.all()
    assert (found.best[inside] < np.minimum(*found.amplitudes)[inside]).all()


def test_independent_sets_average_and_equal_ones_do_not() -> None:
    one, other = np.array([[3.0, 0.0]]), np.array([[0.0, 4.0]])
    found = compare_sets("A", one, "B", other)
    assert found.weight == pytest.approx([16 / 25])
    assert found.best == pytest.approx([12 / 5])
    assert found.mean == pytest.approx([2.5])
    assert found.relative == pytest.approx([5 / 4])
    assert compare_sets("A", one, "B", one).best == pytest.approx([3.0])


AREAS = ["STRUT_1", "IS1_EH_DOWN", "IS2_EH_DOWN"]
ALPHA = 1.65e-5


def expanding(layout: OpticalLayout, *masses: tuple[str, str]) -> OpticalLayout:
    return replace(layout, expansions=tuple(MassExpansion(name, ALPHA, area) for name, area in masses))


def test_a_growing_test_mass_reads_as_its_face(layout: OpticalLayout, S_BW: FloatArray) -> None:
    """Faces look at each other, so both test masses that grow read as if they came nearer."""
    both = expanding(layout, ("TM2", "IS2_EH_DOWN"), ("TM1", "IS1_EH_DOWN"))
    still = np.zeros((3, len(layout.bench), 6))
    chain = optics_chain(both, S_BW, still, face_m=face_motion(both, AREAS))
    expected = np.zeros((6, 3))
    expected[0, 1], expected[3, 2] = ALPHA * 0.023, -ALPHA * 0.023
    for s in chain.sets:
        assert pytest.approx(expected, rel=1e-11, abs=1e-20) == s.N
        assert not s.N_rigid.any()
    assert not face_motion(layout, AREAS).any()


def test_a_growing_test_mass_against_a_trace_with_the_face_moved(bench: OpticalLayout, S: FloatArray) -> None:
    """Non-linear trace at both sides of the nominal offset, by the law; 2e-5 m make errors below 1e-9 of the effect."""
    grown = expanding(bench, (bench.test_masses[-1].name, AREAS[1]), (bench.test_masses[0].name, AREAS[2]))
    face = face_motion(grown, AREAS)
    assert face.shape == (len(bench.test_masses), 3)
    chain = optics_chain(grown, S, np.zeros((3, len(bench.bench), 6)), face_m=face)
    for column, kelvin in ((1, 50.0), (2, 50.0)):
        traces = []
        for sign in (1, -1):
            by = dict(zip((m.name for m in bench.test_masses), sign * kelvin * face[:, column], strict=True))
            changed = [replace(e, front_offset_m=e.front_offset_m + by.get(e.name, 0.0)) for e in bench.elements]
            moved = replace(bench, elements=tuple(changed))
            traces.append(trace(moved, nominal_poses(moved)).reshape(-1))
        difference = chain.P @ (traces[0] - traces[1]) / (2 * kelvin)
        assert chain.D[:, column] == pytest.approx(difference, abs=1e-8 * np.abs(difference).max())
        assert np.abs(difference).max() > 0.9 * 2 * ALPHA * 0.023


def test_expansion_with_an_area_that_is_not_there(layout: OpticalLayout) -> None:
    with pytest.raises(InputError, match="temperature of TM1 follows the thermal area 'IS1_EH'") as caught:
        face_motion(expanding(layout, ("TM1", "IS1_EH")), AREAS)
    assert "did you mean IS1_EH_DOWN?" in caught.value.hint
