"""The optics law on photodiodes of any orientation, against the phase front in space."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from random_layouts import random_layout, with_tilted_photodiodes

from tedm_cli.arrays import ComplexArray, FloatArray
from tedm_cli.optics.chain import optics_chain
from tedm_cli.optics.labels import output_labels
from tedm_cli.optics.law import law_matrix
from tedm_cli.optics.layout import BeamPath, OpticalLayout
from tedm_cli.optics.sensitivity import optical_sensitivity
from tedm_cli.optics.trace import Poses, nominal_poses, photodiode_axes, trace, trace_path

STEP = 1e-30

PAIRS = {
    "planar": lambda: random_layout(4, 2, planar=True),
    "two test masses": lambda: random_layout(3, 2),
    "three test masses": lambda: random_layout(1, 3),
}


@pytest.fixture(scope="module", params=["shipped", *PAIRS])
def straight(request: pytest.FixtureRequest, layout: OpticalLayout) -> OpticalLayout:
    return layout if request.param == "shipped" else PAIRS[request.param]()


@pytest.fixture(scope="module")
def tilted(straight: OpticalLayout) -> OpticalLayout:
    return with_tilted_photodiodes(straight, 11)


def curved(layout: OpticalLayout) -> OpticalLayout:
    return replace(
        layout,
        paths=tuple(replace(p, wavefront_radius_m=(-1) ** i * (0.7 + 0.2 * i)) for i, p in enumerate(layout.paths)),
    )


def phase_front(layout: OpticalLayout, path: BeamPath, poses: Poses, q: FloatArray) -> ComplexArray:
    """Optical path at the point `q` of the photodiode and its gradient along ex, ey, from the wave in space [3]."""
    traced = trace_path(layout, path, poses)
    p, d = traced.hits[-1].point, traced.hits[-1].direction
    place = traced.hits[-1].element
    ex, ey = photodiode_axes(poses, place)
    Q = poses.ref[place] + q[0] * ex + q[1] * ey
    if path.wavefront_radius_m is None:
        length, along = traced.output[2] + d @ (Q - p), d
    else:
        radius = path.wavefront_radius_m
        from_centre = Q - (p - radius * d)
        distance = np.sign(radius) * np.sqrt(from_centre @ from_centre)
        length, along = traced.output[2] - radius + distance, from_centre / distance
    return np.array([length, ex @ along, ey @ along])


def phase_derivative(layout: OpticalLayout, direction: FloatArray) -> FloatArray:
    """OPD, WFT1, WFT2 of all photodiodes along a motion of all elements, by a complex step of the phase fronts."""
    out, nominal = [], trace(layout)
    poses = nominal_poses(layout).moved(1j * STEP * direction)
    for name in layout.photodiodes:
        meas, ref = (layout.path_index(name, beam) for beam in ("meas", "ref"))
        q = nominal[[meas, ref], :2].mean(axis=0)
        fronts = [phase_front(layout, layout.paths[i], poses, q) for i in (meas, ref)]
        out.append((fronts[0] - fronts[1]).imag / STEP)
    return np.concatenate(out)


@pytest.mark.parametrize("shape", ["plane", "curved"])
def test_the_law_is_that_of_the_phase_front(tilted: OpticalLayout, shape: str) -> None:
    layout = tilted if shape == "plane" else curved(tilted)
    PS = law_matrix(layout) @ optical_sensitivity(layout)
    for direction in np.random.default_rng(12).normal(size=(10, len(layout.elements), 6)):
        exact = phase_derivative(layout, direction)
        assert (
            np.abs(PS @ direction.reshape(-1) - exact).max()
            < 1e-13 * (np.abs(PS) @ np.abs(direction.reshape(-1))).max()
        )


def test_spots_that_miss_each_other_have_one_reference_point(tilted: OpticalLayout) -> None:
    """Exact for plane waves; a curved one leaves the ratio of the miss to its radius."""
    moved = tuple(
        replace(e, ref_m=tuple(np.array(e.ref_m) + 1e-4 * np.cross([0.0, 0.0, 1.0], e.normal)))
        if e.name in ("FM", "FIM")
        else e
        for e in tilted.elements
    )
    layout = replace(tilted, elements=moved)
    miss = np.abs(np.diff(trace(layout)[:2, :2], axis=0)).max()
    assert miss > 1e-5
    direction = np.random.default_rng(13).normal(size=(len(layout.elements), 6))
    for shape, limit in ((layout, 1e-13), (curved(layout), 1e-3)):
        PS = law_matrix(shape) @ optical_sensitivity(shape)
        error = np.abs(PS @ direction.reshape(-1) - phase_derivative(shape, direction)).max()
        assert error < limit * (np.abs(PS) @ np.abs(direction.reshape(-1))).max()
    plane = law_matrix(layout) @ optical_sensitivity(layout)
    diodes = layout.columns_of(tuple(e for e in layout.elements if e.kind == "photodiode"))
    assert np.abs(plane[:, diodes]).max() < 1e-13 * np.abs(plane).max()


def test_the_tilt_of_a_photodiode_changes_no_length_and_no_read_out(
    straight: OpticalLayout, tilted: OpticalLayout
) -> None:
    """The phase at a point of the light does not know the plane it is read in; path to the plane alone would."""
    PS, PS_tilted = (law_matrix(x) @ optical_sensitivity(x) for x in (straight, tilted))
    scale = np.abs(PS).max()
    assert np.abs(PS - PS_tilted)[::3].max() < 1e-13 * scale
    path_alone = np.zeros_like(law_matrix(tilted))
    for i, path in enumerate(tilted.paths):
        path_alone[3 * tilted.photodiodes.index(path.photodiode), 5 * i + 2] = 1 if path.beam == "meas" else -1
    assert np.abs((path_alone @ optical_sensitivity(tilted) - PS)[::3]).max() > 0.1
    D_opt = np.random.default_rng(14).normal(size=(3, len(straight.bench), 6))
    for a, b in zip(*(optics_chain(x, optical_sensitivity(x), D_opt).sets for x in (straight, tilted)), strict=True):
        assert np.abs(a.N - b.N).max() < 1e-12 * np.abs(a.N).max()


def test_the_law_of_the_shipped_layout_is_the_plain_difference(layout: OpticalLayout) -> None:
    P = law_matrix(layout).reshape(len(layout.photodiodes), 3, len(layout.paths), 5)
    for number, name in enumerate(layout.photodiodes):
        for i, path in enumerate(layout.paths):
            sign = {"meas": 1.0, "ref": -1.0}[path.beam] if path.photodiode == name else 0.0
            assert np.array_equal(P[number, :, i], sign * np.eye(5)[2:])


def test_geometry_of_the_law_on_a_tilted_photodiode(layout: OpticalLayout) -> None:
    """Turned by 30 degrees about its vertical axis, the beams arrive with a slope of half: `OPD = opl - z1 x`."""
    place = layout.index("PD1A")
    e = layout.elements[place]
    normal = (-0.5, -np.sqrt(0.75), 0.0)
    elements = (*layout.elements[:place], replace(e, normal=normal), *layout.elements[place + 1 :])
    P = law_matrix(curved(replace(layout, elements=elements)))
    names = output_labels(layout).names
    slope = trace(replace(layout, elements=elements))[0, 3]
    assert abs(slope) == pytest.approx(0.5, abs=1e-14)
    assert {n: v for n, v in zip(names, P[0], strict=True) if v and "meas" in n} == pytest.approx(
        {"PD1A_meas_x": -slope, "PD1A_meas_opl": 1.0}
    )
    assert P[1, names.index("PD1A_meas_x")] == pytest.approx(-0.75 / 0.7)  # foreshortened once each way
    assert P[2, names.index("PD1A_meas_y")] == pytest.approx(-1 / 0.7)
