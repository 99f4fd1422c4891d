"""Law matrix, ideal read-out, its inverse per set, and the read-out noise of bench motions."""

from __future__ import annotations

import math
import re
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from random_layouts import axis_rows, vector
from scipy.spatial.transform import Rotation

from tedm_cli.arrays import FloatArray
from tedm_cli.errors import InputError, PhysicsError
from tedm_cli.optics.chain import OpticsChain, optics_chain
from tedm_cli.optics.invariances import invariance_residuals
from tedm_cli.optics.labels import input_labels, laser_labels, output_labels, read_out_labels
from tedm_cli.optics.law import law_matrix
from tedm_cli.optics.layout import Dof, OpticalLayout
from tedm_cli.optics.read_out import lost_degrees_of_freedom
from tedm_cli.optics.sensitivity import move_reference_points
from tedm_cli.optics.trace import nominal_poses, trace


@pytest.fixture
def D_opt(layout: OpticalLayout) -> FloatArray:
    """Two hundred random thermal areas: 1e-9 m/K and rad/K."""
    return 1e-9 * np.random.default_rng(4).normal(size=(200, len(layout.bench), 6))


@pytest.fixture
def chain(layout: OpticalLayout, S_BW: FloatArray, D_opt: FloatArray) -> OpticsChain:
    return optics_chain(layout, S_BW, D_opt)


def curved_layout(layout: OpticalLayout) -> OpticalLayout:
    radii = {("PD1A", "meas"): 1.5, ("PD1A", "ref"): 0.9, ("PD12B", "ref"): 2.0}
    return replace(
        layout,
        paths=tuple(replace(p, wavefront_radius_m=radii.get((p.photodiode, p.beam))) for p in layout.paths),
    )


def test_sizes_follow_the_layout(layout: OpticalLayout, chain: OpticsChain) -> None:
    assert (len(layout.elements), len(layout.bench), len(layout.paths)) == (24, 22, 8)
    assert [e.grid for e in layout.bench] == list(range(900001, 900023))
    assert (chain.P.shape, chain.O_ideal.shape, chain.D.shape) == ((12, 40), (12, 12), (12, 200))
    assert [(s.name, s.law.O.shape, s.gain.shape, s.N.shape) for s in chain.sets] == [
        (name, (6, 6), (6, 144), (6, 200)) for name in ("A", "B")
    ]


def test_labels_name_and_measure_every_row(layout: OpticalLayout, chain: OpticsChain) -> None:
    outputs, inputs = output_labels(layout), input_labels(layout)
    assert outputs.names[:6] == (
        "PD1A_meas_x",
        "PD1A_meas_y",
        "PD1A_meas_opl",
        "PD1A_meas_z1",
        "PD1A_meas_z2",
        "PD1A_ref_x",
    )
    assert outputs.units[:5] == ("m", "m", "m", "rad", "rad")
    assert (len(outputs.names), len(outputs.units), len(inputs.names), len(inputs.units)) == (40, 40, 144, 144)
    assert inputs.names[:6] == ("TM1_ux", "TM1_uy", "TM1_uz", "TM1_rx", "TM1_ry", "TM1_rz")
    assert input_labels(layout, layout.bench).names[::6][:2] == ("FIM_ux", "FIR_ux")
    assert laser_labels(layout).names[:4] == ("PD1A_OPD", "PD1A_WFT1", "PD1A_WFT2", "PD1B_OPD")
    assert laser_labels(layout, ("PD12A",)).units == ("m", "rad", "rad")
    read_out = read_out_labels(layout)
    assert read_out.names == ("TM1_x", "TM1_eta", "TM1_phi", "TM2_x", "TM2_eta", "TM2_phi")
    assert read_out.units == ("m", "rad", "rad") * 2
    # The law takes the difference of like quantities: its entries join labels that end alike.
    pairs = {"OPD": "opl", "WFT1": "z1", "WFT2": "z2"}
    for i, laser in enumerate(laser_labels(layout).names):
        diode, kind = laser.rsplit("_", 1)
        found = {outputs.names[j]: chain.P[i, j] for j in np.flatnonzero(chain.P[i])}
        assert found == {f"{diode}_meas_{pairs[kind]}": 1.0, f"{diode}_ref_{pairs[kind]}": -1.0}


def test_the_ideal_read_out_sees_x_eta_phi_only(layout: OpticalLayout, chain: OpticsChain) -> None:
    names = np.array(input_labels(layout, layout.test_masses).names)
    seen = names[np.abs(chain.O_ideal).max(axis=0) > 1e-12]
    assert list(seen) == ["TM1_ux", "TM1_ry", "TM1_rz", "TM2_ux", "TM2_ry", "TM2_rz"]
    assert chain.rank == 6
    assert chain.singular_values[6:].max() < 1e-14
    assert chain.singular_values[5] > 1.7


def test_length_per_test_mass_motion(layout: OpticalLayout, chain: OpticsChain) -> None:
    rows, columns = laser_labels(layout).names, input_labels(layout, layout.test_masses).names
    value = -2 * math.cos(math.radians(4.5))
    assert value == pytest.approx(-1.993835, abs=5e-7)
    expected = {"PD1A": (value, 0), "PD1B": (value, 0), "PD12A": (value, -value), "PD12B": (value, -value)}
    for diode, values in expected.items():
        row = chain.O_ideal[rows.index(f"{diode}_OPD")]
        assert [row[columns.index(c)] for c in ("TM1_ux", "TM2_ux")] == pytest.approx(values, abs=1e-14)


def test_condition_of_both_sets(chain: OpticsChain) -> None:
    """Published as about 2 (Montemurro 2004, note to eq. 10.9)."""
    for s in chain.sets:
        assert s.law.condition == pytest.approx(2.64, abs=5e-3)
        assert s.law.inverse @ s.law.O == pytest.approx(np.eye(6), abs=1e-14)


@settings(max_examples=20)
@given(st.integers(0, 2**32 - 1))
def test_bench_motion_reads_as_minus_that_motion(layout: OpticalLayout, S_BW: FloatArray, seed: int) -> None:
    """The bench moves rigidly in any frame, about finite-element nodes; the test masses stay where they are."""
    rng = np.random.default_rng(seed)
    axes, origin = Rotation.random(random_state=seed).as_matrix(), rng.normal(size=3)
    framed = replace(layout, frame_axes=axis_rows(axes), frame_origin_m=vector(origin))
    refs = layout.refs_m @ axes + origin  # basic frame
    bench = [layout.index(e.name) for e in layout.bench]
    nodes = refs[bench] + rng.normal(scale=0.02, size=(len(bench), 3))
    shift, theta = rng.normal(size=3), rng.normal(size=3)
    D_opt = np.zeros((1, len(bench), 6))
    D_opt[0, :, :3] = shift + np.cross(theta, nodes)
    D_opt[0, :, 3:] = theta
    expected = []
    for mass in layout.test_masses:
        moved = axes @ (shift + np.cross(theta, refs[layout.index(mass.name)]))
        expected += [-moved[0], *-(axes @ theta)[1:]]
    chain = optics_chain(framed, move_reference_points(S_BW, framed, nodes), D_opt)
    for s in chain.sets:
        assert s.N[:, 0] == pytest.approx(expected, abs=1e-13)


def test_noise_against_a_finite_trace(layout: OpticalLayout, S_BW: FloatArray) -> None:
    """Displace the bench elements by nanometres, trace, and let the ideal read-out interpret the change."""
    D_opt = 1e-7 * np.random.default_rng(8).normal(size=(1, len(layout.bench), 6))
    chain = optics_chain(layout, S_BW, D_opt)
    motion = np.zeros((len(layout.elements), 6))
    motion[[layout.index(e.name) for e in layout.bench]] = D_opt[0]
    change = (trace(layout, nominal_poses(layout).moved(motion)) - trace(layout)).reshape(-1)
    for s in chain.sets:
        seen = np.linalg.solve(s.law.O, (chain.P @ change)[layout.laser_rows(s.photodiodes)])
        assert s.N[:, 0] == pytest.approx(seen, abs=1e-12)  # second order: (1e-7)^2
        assert np.abs(s.N).max() > 1e-8


def test_noise_is_the_inverse_law_on_the_disturbance(
    layout: OpticalLayout, chain: OpticsChain, D_opt: FloatArray
) -> None:
    bench = layout.columns_of(layout.bench)
    for s in chain.sets:
        D_set = chain.D[layout.laser_rows(s.photodiodes)]
        assert pytest.approx(np.linalg.solve(s.law.O, D_set), abs=1e-22) == s.N
        assert pytest.approx(s.gain[:, bench] @ D_opt.reshape(len(D_opt), -1).T, abs=1e-22) == s.N
        assert pytest.approx(s.inverse @ chain.D, abs=1e-22) == s.N
        read = np.eye(6)  # a test mass that moves reads as that motion
        assert s.gain @ layout.read_out_motions == pytest.approx(read, abs=1e-14)


def test_sets_agree_for_plane_waves_and_differ_for_curved_ones(
    layout: OpticalLayout, S_BW: FloatArray, chain: OpticsChain, D_opt: FloatArray
) -> None:
    A, B = (s.N for s in chain.sets)
    assert np.abs(A - B).max() < 1e-13 * np.abs(A).max()
    curved = optics_chain(curved_layout(layout), S_BW, D_opt)
    A, B = (s.N for s in curved.sets)
    assert np.abs(A - B).max() > 0.1 * np.abs(A).max()


def test_curvature_acts_through_the_spot(layout: OpticalLayout) -> None:
    """`WFT = z - x / Rc` is the slope, at the photodiode's centre, of a wave centred Rc upstream of the spot."""
    outputs, rows = output_labels(layout).names, laser_labels(layout).names
    change = law_matrix(curved_layout(layout)) - law_matrix(layout)
    found = {(rows[i], outputs[j]): change[i, j] for i, j in np.argwhere(change)}
    assert found == {
        ("PD1A_WFT1", "PD1A_meas_x"): -1 / 1.5,
        ("PD1A_WFT2", "PD1A_meas_y"): -1 / 1.5,
        ("PD1A_WFT1", "PD1A_ref_x"): 1 / 0.9,
        ("PD1A_WFT2", "PD1A_ref_y"): 1 / 0.9,
        ("PD12B_WFT1", "PD12B_ref_x"): 1 / 2.0,
        ("PD12B_WFT2", "PD12B_ref_y"): 1 / 2.0,
    }
    assert np.array_equal(law_matrix(curved_layout(layout), curved=False), law_matrix(layout))


def test_invariances_hold_for_curved_waves(layout: OpticalLayout, S_BW: FloatArray) -> None:
    assert max(invariance_residuals(curved_layout(layout), S_BW).named().values()) < 1e-13


@pytest.mark.parametrize(
    ("photodiodes", "read_out", "lost"),
    [
        (("PD1A", "PD1B"), ("x", "eta", "phi"), "rank 3 for 6 .* does not see TM2_x, TM2_eta and TM2_phi"),
        (("PD1A", "PD12A"), ("x", "theta", "phi"), "rank 4 for 6 .* does not see TM1_theta and TM2_theta"),
        (("PD12A", "PD12B"), ("x",), r"cannot tell TM1_x from TM2_x \(TM1_x \+ TM2_x changes nothing\)"),
        (("PD12A", "PD12B"), ("x", "phi"), "cannot tell TM1_x, TM1_phi, TM2_x and TM2_phi apart .2 comb"),
    ],
)
def test_a_singular_set_names_what_it_loses(
    layout: OpticalLayout,
    S_BW: FloatArray,
    D_opt: FloatArray,
    photodiodes: tuple[str, ...],
    read_out: tuple[Dof, ...],
    lost: str,
) -> None:
    """The last two read differences of the two masses, so each is lost though neither is unseen."""
    poor = replace(layout, sets={"C": photodiodes}, read_out=read_out)
    with pytest.raises(PhysicsError, match=f"set C .*{lost}"):
        optics_chain(poor, S_BW, D_opt)


@pytest.mark.parametrize("null", [(1.0, -4.0, 0.5, 2.5), (1.0, 0.3, 0.0, 0.0), (1.0, 0.0, 0.0, -7.0)])
def test_the_motion_that_changes_nothing_is_given_in_metres_and_radians(
    layout: OpticalLayout, null: tuple[float, ...]
) -> None:
    """Whatever measures lengths in the search for it: the law times what the message says is nought."""
    mixed = replace(layout, read_out=("x", "phi"))  # TM1_x, TM1_phi, TM2_x, TM2_phi
    names = list(read_out_labels(mixed).names)
    law = np.random.default_rng(3).normal(size=(6, 4))
    law -= np.outer(law @ null, null) / np.dot(null, null)
    (text,) = lost_degrees_of_freedom(mixed, law, 1)
    motion = np.zeros(4)
    said = text[text.index("(") + 1 : text.index(" changes nothing")]
    for sign, size, name in re.findall(r"(^|[+-]) ?([\d.e-]*) ?(TM\w+)", said):
        motion[names.index(name)] = (-1.0 if sign == "-" else 1.0) * float(size or 1.0)
    np.testing.assert_allclose(motion, null, rtol=1e-9)


def test_a_set_of_all_photodiodes_is_a_least_squares_read_out(
    layout: OpticalLayout, S_BW: FloatArray, chain: OpticsChain, D_opt: FloatArray
) -> None:
    every = optics_chain(replace(layout, sets={"all": layout.photodiodes}), S_BW, D_opt).sets[0]
    assert every.law.O.shape == (12, 6)
    least = np.linalg.lstsq(every.law.O, chain.D, rcond=None)[0]
    assert pytest.approx(least, abs=1e-21) == every.N


def test_motions_that_do_not_fit_are_refused(layout: OpticalLayout, S_BW: FloatArray, D_opt: FloatArray) -> None:
    with pytest.raises(InputError, match=r"\(200, 21, 6\); finite values \[k, 22, 6\]"):
        optics_chain(layout, S_BW, D_opt[:, 1:])
    with pytest.raises(InputError, match="D_opt"):
        optics_chain(layout, S_BW, np.where(D_opt == D_opt[0, 0, 0], np.inf, D_opt))
