"""The trace of the optical bench against an open ray tracer."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

from benchmarks.timing import Result, timed
from tedm_cli.optics.layout import OpticalLayout

ROOT = Path(__file__).parents[1]


def against_optiland() -> Result:
    """All paths of the shipped layout with every element moved by millimetres and milliradians."""
    from tedm_cli.optics.trace import nominal_poses, trace

    sys.path.insert(0, str(ROOT / "tests" / "optics"))
    from independent_tracer import outputs

    layout = _shipped()
    motion = 1e-3 * np.random.default_rng(1).normal(size=(len(layout.elements), 6))
    poses = nominal_poses(layout)
    worst = np.abs(outputs(layout, motion) - trace(layout, poses.moved(motion))).max()
    note = f"worst difference {worst:.0e} m or rad"
    return timed(lambda: trace(layout, poses.moved(motion)), lambda: outputs(layout, motion), note)


def _shipped() -> OpticalLayout:
    from tedm_cli.config.optics.layout import load_layout

    return load_layout(ROOT / "configs" / "optics.toml")[1]
