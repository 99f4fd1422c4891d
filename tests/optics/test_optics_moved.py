"""A layout after motions of its elements, judged as a layout of its own."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tedm_cli.optics.common_mode import rigid_motion
from tedm_cli.optics.layout import OpticalLayout
from tedm_cli.optics.layout_checks import check_layout
from tedm_cli.optics.moved import findings_after, moved_layout
from tedm_cli.optics.trace import nominal_poses, trace


def test_optics_a_layout_that_moves_as_one_keeps_its_margins(layout: OpticalLayout) -> None:
    """Test masses too; along each axis and about it, by amounts at which the linear motion is one."""
    before = check_layout(layout)
    numbers = np.array([np.nan if f.value is None else f.value for f in before])
    for k, motion in enumerate(rigid_motion(layout).T):
        after = findings_after(layout, (1e-4 if k < 3 else 1e-6) * motion.reshape(-1, 6), before)
        np.testing.assert_allclose(after, numbers, atol=1e-9)


def test_optics_a_moved_layout_is_traced_as_moved_poses_are(layout: OpticalLayout) -> None:
    motion = 1e-4 * np.random.default_rng(3).standard_normal((len(layout.elements), 6))
    moved = moved_layout(layout, motion)
    np.testing.assert_allclose(trace(moved), trace(layout, nominal_poses(layout).moved(motion)), atol=1e-12)
    assert [e.name for e in moved.elements] == [e.name for e in layout.elements]


def test_optics_a_mirror_that_turns_far_loses_its_beam(layout: OpticalLayout) -> None:
    before = check_layout(layout)
    name = next(e.name for e in layout.bench if e.kind == "mirror")
    motion = np.zeros((len(layout.elements), 6))
    motion[layout.index(name), 4] = 1.5
    after = findings_after(layout, motion, before)
    lost = [f.where for f, value in zip(before, after, strict=True) if f.value is not None and np.isnan(value)]
    assert lost
    still = replace(layout)
    assert not np.isnan(
        [v for v, f in zip(findings_after(still, 0.0 * motion, before), before, strict=True) if f.value is not None]
    ).any()


def test_optics_spots_that_part_eat_their_margin(layout: OpticalLayout) -> None:
    """A photodiode that slides along itself keeps both spots together; an injector that slides parts them."""
    before = check_layout(layout)
    overlap = [n for n, f in enumerate(before) if f.check == "overlap"]
    slide = np.zeros((len(layout.elements), 6))
    name = before[overlap[0]].element
    slide[layout.index(name), :3] = 1e-5 * np.array(layout.elements[layout.index(name)].local_y)
    kept = findings_after(layout, slide, before)[overlap]
    assert kept == pytest.approx([before[n].value for n in overlap], abs=1e-9)
    source = next(p.steps[0].element for p in layout.paths if p.photodiode == name and p.beam == "ref")
    other = next(p.steps[0].element for p in layout.paths if p.photodiode == name and p.beam == "meas")
    assert source != other
    slide = np.zeros((len(layout.elements), 6))
    slide[layout.index(source), 2] = 1e-5
    assert findings_after(layout, slide, before)[overlap[0]] == pytest.approx(1e-5, rel=0.5)
