"""Exaggerated benches, shares of elements, and S_BW without units."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from random_layouts import axis_rows, random_layout

from tedm_cli.arrays import FloatArray
from tedm_cli.optics.exaggerated import exaggerated_bench, motion_of_elements, round_down, traced_bench
from tedm_cli.optics.invariances import scaled_matrix
from tedm_cli.optics.layout import OpticalLayout
from tedm_cli.optics.sensitivity import move_reference_points, optical_sensitivity


def random_motion(layout: OpticalLayout, seed: int, size: float = 1e-7) -> FloatArray:
    motion = size * np.random.default_rng(seed).normal(size=(len(layout.elements), 6))
    motion[[layout.index(e.name) for e in layout.test_masses]] = 0.0
    return motion


def test_beams_after_small_motions_are_the_linear_prediction(layout: OpticalLayout, S_BW: FloatArray) -> None:
    """Spots and slopes of the drawn beams; what is left is of second order in the factor."""
    motion = random_motion(layout, 1, size=1.0)
    before = traced_bench(layout)
    error = []
    for factor in (1e-5, 1e-6):
        after = traced_bench(layout, before.poses.moved(factor * motion))
        change = np.concatenate([a.output - b.output for a, b in zip(after.traces, before.traces, strict=True)])
        predicted = factor * (S_BW @ motion.reshape(-1))
        error.append(float(np.abs(change - predicted).max()) / float(np.abs(predicted).max()))
    assert error[0] < 1e-3
    assert error[0] / error[1] == pytest.approx(10.0, rel=0.2)


def test_beams_begin_at_their_injectors_and_end_on_their_photodiodes(layout: OpticalLayout) -> None:
    bench = exaggerated_bench(layout, random_motion(layout, 2)).after
    for i, path in enumerate(layout.paths):
        corners = bench.beam(i)
        np.testing.assert_allclose(corners[0], bench.poses.ref[layout.index(path.steps[0].element)], atol=1e-15)
        plane = layout.index(path.photodiode)
        assert (corners[-1] - bench.poses.ref[plane]) @ bench.poses.normal[plane] == pytest.approx(0.0, abs=1e-15)


@pytest.mark.parametrize("size", [1e-12, 1e-7, 1e-3])
def test_factor_makes_motions_visible_whatever_their_size(layout: OpticalLayout, size: float) -> None:
    found = exaggerated_bench(layout, random_motion(layout, 3, size))
    shift = max(
        np.linalg.norm(found.after.beam(i) - found.before.beam(i), axis=1).max() for i in range(len(layout.paths))
    )
    assert 0.01 < shift / layout.size_m <= 0.05
    assert float(f"{found.factor:.0e}") == found.factor, "one digit"


def test_a_bench_at_rest_is_not_exaggerated(layout: OpticalLayout) -> None:
    found = exaggerated_bench(layout, np.zeros((len(layout.elements), 6)))
    assert found.factor == 1.0
    assert found.after is found.before


def test_a_motion_that_no_beam_feels_is_still_bounded(layout: OpticalLayout) -> None:
    motion = np.zeros((len(layout.elements), 6))
    motion[layout.index("PD1A"), 5] = 1e-6
    found = exaggerated_bench(layout, motion)
    assert found.factor * 1e-6 == pytest.approx(0.2, rel=1e-9)


@pytest.mark.parametrize("masses", [1, 2, 3])
def test_random_benches_keep_their_rays(masses: int) -> None:
    layout = random_layout(3, masses)
    found = exaggerated_bench(layout, random_motion(layout, masses))
    assert len(found.after.traces) == len(layout.paths)
    assert found.factor > 1.0


@given(st.floats(1e-12, 1e12))
def test_rounding_down_keeps_the_first_digit(value: float) -> None:
    rounded = round_down(value)
    assert rounded <= value * (1 + 2e-9)
    assert value < 2 * rounded
    assert float(f"{rounded:.0e}") == rounded


def test_motion_about_reference_points_reads_as_that_of_the_grids(layout: OpticalLayout) -> None:
    """Grids beside the reference points, and a layout frame that is turned: the same change of all outputs."""
    rng = np.random.default_rng(5)
    q, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    axes = q * np.sign(np.linalg.det(q))
    turned = dataclasses.replace(layout, frame_axes=axis_rows(axes), frame_origin_m=(0.1, -0.2, 0.3))
    inside = np.array([e.ref_m for e in layout.bench]) + 0.02 * rng.normal(size=(len(layout.bench), 3))
    nodes = inside @ axes + np.array(turned.frame_origin_m)
    D_opt = rng.normal(size=(len(layout.bench), 6))
    in_frame = np.concatenate([D_opt[:, :3] @ axes.T, D_opt[:, 3:] @ axes.T], axis=1)
    S_ref = optical_sensitivity(turned)
    by_grids = move_reference_points(S_ref, turned, nodes)[:, turned.columns_of(turned.bench)] @ in_frame.reshape(-1)
    by_references = S_ref @ motion_of_elements(turned, D_opt, nodes).reshape(-1)
    np.testing.assert_allclose(by_references, by_grids, rtol=0, atol=1e-12 * np.abs(by_grids).max())


def test_dimensionless_matrix_does_not_know_the_size_of_the_bench(layout: OpticalLayout, S_BW: FloatArray) -> None:
    """A bench three times as large has other entries in m/rad, and the same ones without units."""

    def scaled(v: tuple[float, float, float]) -> tuple[float, float, float]:
        return (3 * v[0], 3 * v[1], 3 * v[2])

    large = dataclasses.replace(
        layout,
        elements=tuple(
            dataclasses.replace(
                e, ref_m=scaled(e.ref_m), front_offset_m=3 * e.front_offset_m, thickness_m=3 * e.thickness_m
            )
            for e in layout.elements
        ),
    )
    assert large.size_m == pytest.approx(3 * layout.size_m, rel=1e-12)
    other = optical_sensitivity(large)
    assert np.abs(other - S_BW).max() > 0.1
    np.testing.assert_allclose(scaled_matrix(large, other), scaled_matrix(layout, S_BW), rtol=0, atol=1e-12)
