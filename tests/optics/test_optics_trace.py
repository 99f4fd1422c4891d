"""The nominal trace against closed forms of geometrical optics."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from tedm_cli.errors import PhysicsError
from tedm_cli.optics.layout import BeamPath, Element, Kind, Operation, OpticalLayout, Step
from tedm_cli.optics.trace import nominal_poses, rotated, trace, trace_path

DIODE_M = 0.3  # distance from the injector to the photodiode in the small layouts

angles = st.floats(0.0, math.radians(80))
thicknesses = st.floats(1e-3, 0.02)
indices = st.floats(1.01, 2.5)


def one_plate(normal: tuple[float, float, float], kind: Kind = "window", **plate: Any) -> OpticalLayout:
    """An injector at the origin along +x, a plate at x = 0.1 used in transmission, a photodiode."""
    elements = (
        Element("F", "injector", (0.0, 0.0, 0.0), (1.0, 0.0, 0.0)),
        Element("W", kind, (0.1, 0.0, 0.0), normal, **plate),
        Element("P", "photodiode", (DIODE_M, 0.0, 0.0), (-1.0, 0.0, 0.0), local_y=(0.0, 0.0, 1.0)),
    )
    path = BeamPath("P", "meas", (Step("F", "emit"), Step("W", "T"), Step("P", "detect")))
    return OpticalLayout("", 1e-6, elements, (path,), {}, ("x",))


@given(angles, thicknesses, indices, st.booleans())
def test_plate_shifts_and_delays_as_the_textbook_says(i: float, t: float, index: float, from_front: bool) -> None:
    assume(t < 0.09 * math.cos(i))  # a tilted plate this thick would reach behind the source
    sign = -1.0 if from_front else 1.0
    layout = one_plate((sign * math.cos(i), sign * math.sin(i), 0.0), thickness_m=t, index=index)
    x, y, opl, z1, z2 = trace(layout)[0]
    r = math.asin(math.sin(i) / index)
    inside = t / math.cos(r)
    # ex = ey x ez = -y axis of the layout; inside a plate with normal at +i the ray bends towards +y.
    assert x == pytest.approx(-inside * math.sin(i - r), abs=1e-14)
    assert opl == pytest.approx(DIODE_M - inside * math.cos(i - r) + index * inside, abs=1e-14)
    assert (y, z1, z2) == pytest.approx((0, 0, 0), abs=1e-14)


@given(angles.filter(lambda i: 0.1 < i < 1.2), thicknesses, indices)
def test_reflection_through_the_substrate(i: float, t: float, index: float) -> None:
    """Against the reflection at the back face the ray is displaced by 2 t tan r cos i and delayed by 2 t n / cos r."""
    normal = (math.cos(i), math.sin(i), 0.0)  # away from the light: the ray meets the back
    out = np.array([1.0, 0.0, 0.0]) - 2 * math.cos(i) * np.array(normal)
    back = np.array([0.1, 0.0, 0.0])
    elements = (
        Element("F", "injector", (0.0, 0.0, 0.0), (1.0, 0.0, 0.0)),
        Element("B", "beamsplitter", (0.1, 0.0, 0.0), normal, front_offset_m=t, thickness_m=t, index=index),
        Element("P", "photodiode", tuple(back + 0.2 * out), tuple(-out), local_y=(0.0, 0.0, 1.0)),
    )
    path = BeamPath("P", "meas", (Step("F", "emit"), Step("B", "R"), Step("P", "detect")))
    x, _, opl, z1, _ = trace(OpticalLayout("", 1e-6, elements, (path,), {}, ("x",)))[0]
    r = math.asin(math.sin(i) / index)
    along_face = 2 * t * math.tan(r)
    assert abs(x) == pytest.approx(along_face * math.cos(i), abs=1e-14)
    assert opl == pytest.approx(0.3 - along_face * math.sin(i) + 2 * t * index / math.cos(r), abs=1e-14)
    assert z1 == pytest.approx(0, abs=1e-14)


def test_beams_recombine_on_every_photodiode(layout: OpticalLayout) -> None:
    out = trace(layout)
    for name in layout.photodiodes:
        both = out[layout.path_index(name, "meas")] - out[layout.path_index(name, "ref")]
        assert np.abs(both).max() < 1e-14  # spot (m), optical path (m) and direction (rad)
    assert np.abs(out[:, [0, 1, 3, 4]]).max() < 1e-14  # and meet the centre head on


def test_a_test_mass_step_changes_the_path_by_twice_its_projection(layout: OpticalLayout) -> None:
    """Plane mirrors: `2 cos(4.5 deg)` per metre holds at any amplitude."""
    motion = np.zeros((len(layout.elements), 6))
    motion[layout.index("TM1"), 0] = 1e-3
    change = trace(layout, nominal_poses(layout).moved(motion)) - trace(layout)
    for name in ("PD1A", "PD1B", "PD12A", "PD12B"):
        opd = change[layout.path_index(name, "meas"), 2] - change[layout.path_index(name, "ref"), 2]
        assert opd == pytest.approx(-2e-3 * math.cos(math.radians(4.5)), abs=2e-15)


vectors = st.tuples(*[st.floats(-3, 3)] * 3).map(np.array)


@given(vectors, vectors, st.sampled_from([1.0, 1e-2, 1e-3, 1e-9]))
def test_rotation_of_any_amplitude(v: np.ndarray, theta: np.ndarray, scale: float) -> None:
    assert rotated(v, scale * theta) == pytest.approx(Rotation.from_rotvec(scale * theta).apply(v), abs=1e-14)


@pytest.mark.parametrize(
    ("plate", "normal", "op", "fact"),
    [
        ({}, (0.0, 1.0, 0.0), "R", "parallel"),
        ({"kind": "mirror"}, (1.0, 0.0, 0.0), "R", "from behind"),
        ({"front_offset_m": 0.2}, (-1.0, 0.0, 0.0), "R", "behind the ray"),
        ({"thickness_m": 0.01, "index": 0.5}, (-0.6, 0.8, 0.0), "T", "totally reflected"),
    ],
)
def test_a_ray_that_misses_names_path_step_and_element(
    plate: dict[str, Any], normal: tuple[float, float, float], op: Operation, fact: str
) -> None:
    layout = one_plate(normal, **plate)
    path = replace(layout.paths[0], steps=(Step("F", "emit"), Step("W", op), Step("P", "detect")))
    with pytest.raises(PhysicsError, match=f"path P meas, step 2 \\(W:{op}\\).*{fact}"):
        trace_path(layout, path, nominal_poses(layout))


def test_a_photodiode_that_looks_away_is_refused(layout: OpticalLayout) -> None:
    poses = nominal_poses(layout)
    motion = np.zeros((len(layout.elements), 6))
    motion[layout.index("PD12B"), 5] = math.pi
    with pytest.raises(PhysicsError, match=r"path PD12B meas, step 14 \(PD12B\): the ray meets PD12B from behind"):
        trace(layout, poses.moved(motion))
