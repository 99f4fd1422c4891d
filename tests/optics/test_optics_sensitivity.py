"""The analytic derivative: complex step, invariances, blindness, symmetry, change of reference point."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from random_layouts import axis_rows, vector
from scipy.linalg import block_diag
from scipy.spatial.transform import Rotation

from tedm_cli.arrays import FloatArray
from tedm_cli.errors import InputError
from tedm_cli.optics.common_mode import rigid_motion
from tedm_cli.optics.invariances import invariance_residuals
from tedm_cli.optics.labels import input_labels, output_labels
from tedm_cli.optics.layout import OpticalLayout
from tedm_cli.optics.sensitivity import (
    cross_matrix,
    move_reference_points,
    optical_sensitivity,
    reference_offsets,
)
from tedm_cli.optics.trace import nominal_poses, trace

STEP = 1e-30  # a complex step takes no difference, so it may be as small as one likes
OUT = ["x", "y", "opl", "z1", "z2"]
IN = ["ux", "uy", "uz", "rx", "ry", "rz"]

Block = Callable[[str], FloatArray]


@pytest.fixture
def block(layout: OpticalLayout, S_BW: FloatArray) -> Block:
    """The columns of one element as [n_paths, 5, 6]."""
    return lambda name: S_BW[:, layout.columns(name)].reshape(-1, 5, 6)


def complex_step(layout: OpticalLayout, direction: FloatArray) -> FloatArray:
    """Derivative [5 * n_paths] of the trace along the motion `direction` [n_elements, 6]."""
    return trace(layout, nominal_poses(layout).moved(1j * STEP * direction)).imag.reshape(-1) / STEP


def turned(layout: OpticalLayout, R: FloatArray, shift: FloatArray) -> OpticalLayout:
    elements = tuple(
        replace(
            e,
            ref_m=tuple(R @ e.ref_m + shift),
            normal=tuple(R @ e.normal),
            local_y=None if e.local_y is None else tuple(R @ e.local_y),
        )
        for e in layout.elements
    )
    return replace(layout, elements=elements)


def mutated(layout: OpticalLayout, rng: np.random.Generator) -> OpticalLayout:
    """Other glasses, elements out of place by millimetres and milliradians; the beams do not recombine."""
    elements = []
    for e in layout.elements:
        glass: dict[str, Any] = (
            {"index": rng.uniform(1.3, 2.0), "thickness_m": rng.uniform(2e-3, 8e-3)} if e.thickness_m else {}
        )
        normal = Rotation.from_rotvec(rng.normal(scale=1e-3, size=3)).apply(e.normal)
        local_y = e.local_y and tuple(np.cross(normal, np.cross(e.local_y, normal)))
        elements.append(
            replace(
                e, **glass, normal=tuple(normal), local_y=local_y, ref_m=tuple(e.ref_m + rng.normal(scale=1e-3, size=3))
            )
        )
    return replace(layout, elements=tuple(elements))


def test_every_entry_agrees_with_a_complex_step(layout: OpticalLayout, S_BW: FloatArray) -> None:
    n = len(layout.elements)
    columns = [complex_step(layout, unit.reshape(n, 6)) for unit in np.eye(6 * n)]
    assert np.abs(np.stack(columns, axis=1) - S_BW).max() < 1e-14 * np.abs(S_BW).max()


@settings(max_examples=25)
@given(st.integers(0, 2**32 - 1))
def test_derivative_and_rigid_motion_hold_for_any_layout(layout: OpticalLayout, seed: int) -> None:
    rng = np.random.default_rng(seed)
    other = turned(mutated(layout, rng), Rotation.random(random_state=seed).as_matrix(), rng.normal(size=3))
    S = optical_sensitivity(other)
    for direction in rng.normal(size=(3, len(other.elements), 6)):
        assert S @ direction.reshape(-1) == pytest.approx(complex_step(other, direction), abs=1e-12)
    assert np.abs(S @ rigid_motion(other)).max() < 1e-12


@settings(max_examples=25)
@given(st.integers(0, 2**32 - 1))
def test_finite_rigid_motion_changes_no_output(layout: OpticalLayout, seed: int) -> None:
    rng = np.random.default_rng(seed)
    R, shift = Rotation.random(random_state=seed), rng.normal(size=3)
    motion = np.empty((len(layout.elements), 6))
    motion[:, :3] = R.apply(layout.refs_m) + shift - layout.refs_m
    motion[:, 3:] = R.as_rotvec()
    assert trace(layout, nominal_poses(layout).moved(motion)) == pytest.approx(trace(layout), abs=2e-14)


def test_the_matrix_turns_with_the_layout(layout: OpticalLayout, S_BW: FloatArray) -> None:
    R = Rotation.from_rotvec([0.4, -1.1, 2.0]).as_matrix()
    S = optical_sensitivity(turned(layout, R, np.array([0.3, 0.1, -2.0])))
    expected = S_BW @ block_diag(*[R.T] * (2 * len(layout.elements)))
    assert np.abs(S - expected).max() < 1e-13


def test_residuals_of_the_exact_matrix_are_rounding(layout: OpticalLayout, S_BW: FloatArray) -> None:
    residuals = invariance_residuals(layout, S_BW).named()
    assert set(residuals) == {
        "rigid_body",
        "bench_motion_A",
        "bench_motion_B",
        "photodiode_columns",
        "slope_translation",
        "untouched_elements",
    }
    assert max(residuals.values()) < 1e-14


@pytest.mark.parametrize(
    ("row", "column", "size", "name"),
    [
        ("PD1A meas 2", "M1 0", 1e-3, "rigid_body"),
        ("PD1A ref 2", "M5 1", 1e-3, "bench_motion_A"),
        ("PD12B meas 3", "PD12B 5", 1e-3, "photodiode_columns"),
        ("PD12A ref 4", "BS6 0", 1e-3, "slope_translation"),
        ("PD1B ref 3", "TM2 4", 1e-3, "untouched_elements"),
    ],
)
def test_a_damaged_entry_shows_in_its_residual(
    layout: OpticalLayout, S_BW: FloatArray, row: str, column: str, size: float, name: str
) -> None:
    beam: Any
    pd, beam, output = row.split()
    element, motion = column.split()
    damaged = S_BW.copy()
    damaged[5 * layout.path_index(pd, beam) + int(output), 6 * layout.index(element) + int(motion)] += size
    residuals = invariance_residuals(layout, damaged).named()
    assert residuals[name] > 1e-2 * size
    assert residuals["rigid_body"] > 1e-2 * size  # whatever entry is wrong, the bodies no longer move as one


def test_residuals_do_not_depend_on_the_unit_of_length(layout: OpticalLayout, S_BW: FloatArray) -> None:
    """The same bench and the same wrong matrix in millimetres."""
    wrong = S_BW * (1.0 + 1e-3 * np.random.default_rng(2).normal(size=S_BW.shape))
    k = 1e3
    elements = tuple(
        replace(
            e,
            ref_m=vector(k * np.array(e.ref_m)),
            front_offset_m=k * e.front_offset_m,
            thickness_m=k * e.thickness_m,
            opl_offset_m=k * e.opl_offset_m,
        )
        for e in layout.elements
    )
    other = replace(layout, elements=elements)
    rows, columns = (
        np.array([k if unit == "m" else 1.0 for unit in labels.units])
        for labels in (output_labels(layout), input_labels(layout))
    )
    found = invariance_residuals(other, rows[:, None] * wrong / columns).named()
    expected = invariance_residuals(layout, wrong).named()
    assert min(v for name, v in expected.items() if name not in ("slope_translation", "untouched_elements")) > 1e-5
    assert found == pytest.approx(expected, rel=1e-6, abs=1e-13)


def test_a_matrix_about_other_points_is_found_out(layout: OpticalLayout, S_BW: FloatArray) -> None:
    """A shift common to the whole bench may stay hidden (along x it does: nothing sees y and z of the test masses)."""
    rng = np.random.default_rng(3)
    nodes = np.array([e.ref_m for e in layout.bench]) + rng.normal(scale=0.02, size=(len(layout.bench), 3))
    moved = move_reference_points(S_BW, layout, nodes)
    assert max(invariance_residuals(layout, moved, nodes).named().values()) < 1e-14
    assert invariance_residuals(layout, moved).rigid_body > 1e-3


def test_photodiode_motion_drops_out_of_the_difference(layout: OpticalLayout, block: Block) -> None:
    for name in layout.photodiodes:
        meas, ref = layout.path_index(name, "meas"), layout.path_index(name, "ref")
        assert np.abs(block(name)[meas, 2:] - block(name)[ref, 2:]).max() < 1e-14
        assert np.abs(block(name)[meas]).max() > 0.9  # though each beam sees it


def test_windows_parallel_to_their_test_mass_do_not_count(layout: OpticalLayout, block: Block) -> None:
    for name in ("W1", "W2"):
        assert np.abs(block(name)[:, 2:]).max() < 1e-14
    tilted = replace(layout.elements[layout.index("W1")], normal=(np.cos(0.1), np.sin(0.1), 0.0))
    places = [tilted if e.name == "W1" else e for e in layout.elements]
    S = optical_sensitivity(replace(layout, elements=tuple(places)))
    assert np.abs(S[:, layout.columns("W1")].reshape(-1, 5, 6)[:, 2:]).max() > 1e-4


def test_motions_that_map_a_surface_onto_itself_do_nothing(layout: OpticalLayout, block: Block) -> None:
    for name in ("BS1", "BS7", "W1", "W2"):  # transmission only
        assert np.abs(block(name)[..., :3]).max() < 1e-14
        assert np.abs(block(name)[..., 3:]).max() > 1e-4 or name.startswith("W")
    for element in layout.elements:
        if element.kind in ("mirror", "test_mass", "beamsplitter"):
            tangent = np.linalg.svd(np.array([element.normal]))[2][1:]
            assert np.abs(block(element.name)[..., :3] @ tangent.T).max() < 1e-14
        if element.kind == "mirror" or element.kind == "injector":
            assert np.abs(block(element.name)[..., 3:] @ element.normal).max() < 1e-14


def test_an_injector_along_its_beam_shortens_the_path_alone(layout: OpticalLayout, block: Block) -> None:
    for name in ("FIM", "FIR"):
        along = block(name)[..., :3] @ layout.elements[layout.index(name)].normal
        expected = np.zeros_like(along)
        expected[[p.steps[0].element == name for p in layout.paths], 2] = -1.0
        assert along == pytest.approx(expected, abs=1e-14)


def test_translations_never_tilt_a_beam(layout: OpticalLayout, S_BW: FloatArray) -> None:
    parts = S_BW.reshape(len(layout.paths), 5, len(layout.elements), 6)
    assert np.count_nonzero(parts[:, 3:, :, :3]) == 0


def test_mirror_symmetry_about_the_bench_plane(layout: OpticalLayout, S_BW: FloatArray) -> None:
    parts = S_BW.reshape(len(layout.paths), 5, len(layout.elements), 6)
    in_plane = [IN.index(c) for c in ("ux", "uy", "rz")]
    out_of_plane = [IN.index(c) for c in ("uz", "rx", "ry")]
    even, odd = [OUT.index(r) for r in ("x", "opl", "z1")], [OUT.index(r) for r in ("y", "z2")]
    assert np.abs(parts[:, odd][..., in_plane]).max() < 1e-14
    assert np.abs(parts[:, even][..., out_of_plane]).max() < 1e-14
    assert min(np.abs(parts[:, odd][..., out_of_plane]).max(), np.abs(parts[:, even][..., in_plane]).max()) > 1


def test_paths_are_blind_to_elements_they_do_not_meet(layout: OpticalLayout, S_BW: FloatArray) -> None:
    blind = 0
    for path in layout.paths:
        for element in layout.elements:
            if element.name not in {s.element for s in path.steps}:
                assert not S_BW[layout.rows(path), layout.columns(element.name)].any()
                blind += 1
    assert blind > 100


def test_thick_splitters_matter(layout: OpticalLayout, S_BW: FloatArray) -> None:
    """Splitters taken as thin surfaces lose more than a millimetre per radian of optical path or spot."""
    thin = [replace(e, thickness_m=1e-12) if e.kind == "beamsplitter" else e for e in layout.elements]
    S = optical_sensitivity(replace(layout, elements=tuple(thin)))
    opl = slice(2, None, 5)
    assert np.abs(S - S_BW)[opl, layout.columns("BS1")].max() > 1e-3


@given(st.integers(0, 2**32 - 1))
@settings(max_examples=20)
def test_change_of_reference_point_against_motion_of_the_node(
    layout: OpticalLayout, S_BW: FloatArray, seed: int
) -> None:
    """Motion about a node 20 mm off, put into the trace as a rigid lever from the node to the reference point."""
    rng = np.random.default_rng(seed)
    lever = rng.normal(scale=0.02, size=(len(layout.bench), 3))
    axes = Rotation.random(random_state=seed).as_matrix()
    origin = rng.normal(size=3)
    framed = replace(layout, frame_axes=axis_rows(axes), frame_origin_m=vector(origin))
    refs = np.array([e.ref_m for e in layout.bench])
    nodes = (refs - lever) @ axes + origin  # basic frame
    assert reference_offsets(framed, nodes) == pytest.approx(lever, abs=1e-14)
    motion = rng.normal(size=(len(layout.elements), 6))
    at_ref = motion.copy()
    for k, element in enumerate(layout.bench):
        at_ref[layout.index(element.name), :3] += np.cross(motion[layout.index(element.name), 3:], lever[k])
    S_node = move_reference_points(S_BW, framed, nodes)
    assert S_node @ motion.reshape(-1) == pytest.approx(complex_step(layout, at_ref), abs=1e-13)
    masses = layout.columns_of(layout.test_masses)
    assert np.array_equal(S_node[:, masses], S_BW[:, masses])


def test_twenty_millimetres_of_lever_are_twenty_millimetres_per_radian(layout: OpticalLayout, S_BW: FloatArray) -> None:
    nodes = np.array([e.ref_m for e in layout.bench])
    nodes[[e.name for e in layout.bench].index("FIM"), 1] -= 0.02
    change = move_reference_points(S_BW, layout, nodes) - S_BW
    row = 5 * layout.path_index("PD1A", "meas") + OUT.index("opl")
    assert change[row, layout.columns("FIM")] == pytest.approx([0, 0, 0, 0, 0, -0.02], abs=1e-15)


def test_cross_matrix() -> None:
    a, b = np.array([[1.0, -2.0, 0.5], [0.3, 4.0, 1.0]]), np.array([0.2, 0.7, -3.0])
    assert cross_matrix(a) @ b == pytest.approx(np.cross(a, b), abs=1e-15)


def test_arrays_that_do_not_fit_are_refused(layout: OpticalLayout, S_BW: FloatArray) -> None:
    nodes = np.zeros((len(layout.bench), 3))
    with pytest.raises(InputError, match=r"\(40, 143\).*\(40, 144\)"):
        move_reference_points(S_BW[:, :-1], layout, nodes)
    with pytest.raises(InputError, match=r"1 entries .* not finite"):
        invariance_residuals(layout, np.where(np.arange(S_BW.size).reshape(S_BW.shape) == 7, np.nan, S_BW))
    with pytest.raises(InputError, match=r"\(24, 3\); 22 finite"):
        move_reference_points(S_BW, layout, np.zeros((24, 3)))
