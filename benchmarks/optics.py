"""The optical derivative against a complex step and extended precision, and the trace against an open ray tracer."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

from benchmarks.timing import Result, timed
from tedm_cli.arrays import FloatArray
from tedm_cli.optics.layout import OpticalLayout

ROOT = Path(__file__).parents[1]
COMPLEX_STEP = 1e-30
STEP = 1e-4  # five points: (1e-4)^4 of the fourth derivative and 1e-19 / 1e-4 of rounding


def derivative() -> Result:
    """The whole of S_BW of the shipped layout; the note gives the largest errors over all its entries."""
    from tedm_cli.optics.sensitivity import optical_sensitivity

    layout = _shipped()
    matrix = optical_sensitivity(layout)
    scale = np.abs(matrix).max()
    errors = [np.abs(other - matrix).max() / scale for other in (complex_step(layout), extended_differences(layout))]
    note = f"worst difference to complex step {errors[0]:.0e}, to differences in long double {errors[1]:.0e}"
    return timed(lambda: optical_sensitivity(layout), lambda: complex_step(layout), note)


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


def complex_step(layout: OpticalLayout) -> FloatArray:
    """S_BW column by column from traces with an imaginary motion."""
    from tedm_cli.optics.trace import nominal_poses, trace

    poses = nominal_poses(layout)
    units = np.eye(6 * len(layout.elements)).reshape(-1, len(layout.elements), 6)
    columns = [trace(layout, poses.moved(1j * COMPLEX_STEP * unit)).imag.reshape(-1) for unit in units]
    return np.stack(columns, axis=1) / COMPLEX_STEP


def extended_differences(layout: OpticalLayout) -> FloatArray:
    """S_BW from five-point differences of finite motions in long double (64-bit mantissas on x86)."""
    from tedm_cli.optics.trace import Poses, nominal_poses, trace

    nominal = nominal_poses(layout)
    poses = Poses(*(np.longdouble(v) for v in (nominal.ref, nominal.normal, nominal.local_y)))
    h = np.longdouble(STEP)
    columns = []
    for unit in np.eye(6 * len(layout.elements)).reshape(-1, len(layout.elements), 6):
        at = {k: trace(layout, poses.moved(k * h * unit)).reshape(-1) for k in (-2, -1, 1, 2)}
        columns.append((8 * (at[1] - at[-1]) - (at[2] - at[-2])) / (12 * h))
    return np.stack(columns, axis=1).astype(np.float64)


def _shipped() -> OpticalLayout:
    from tedm_cli.config.optics.layout import load_layout

    return load_layout(ROOT / "configs" / "optics.toml")[1]
