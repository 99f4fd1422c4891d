"""The trace against an independent open ray tracer (Optiland; `pip install -e '.[peer]'`), at finite amplitude."""

from __future__ import annotations

import numpy as np
import pytest
from random_layouts import random_layout

from tedm_cli.arrays import FloatArray
from tedm_cli.optics.layout import OpticalLayout
from tedm_cli.optics.trace import nominal_poses, trace

pytest.importorskip("optiland")

AGREEMENT = 2e-14  # m and rad over paths of a metre or so: rounding of either

#: One of each kind of element, moved by millimetres along and milliradians about all axes at once; and all together.
MOVED = ("TM1", "TM2", "FIM", "FIR", "W1", "W2", "BS3", "BS4", "BS8", "M1", "M4", "PD1A", "PD12B")


def difference(layout: OpticalLayout, motion: FloatArray) -> float:
    from independent_tracer import outputs

    return float(np.abs(outputs(layout, motion) - trace(layout, nominal_poses(layout).moved(motion))).max())


def test_nominal(layout: OpticalLayout) -> None:
    assert difference(layout, np.zeros((len(layout.elements), 6))) < AGREEMENT


@pytest.mark.parametrize("name", MOVED)
def test_one_element_moved(layout: OpticalLayout, name: str) -> None:
    motion = np.zeros((len(layout.elements), 6))
    motion[layout.index(name)] = 1e-3 * np.random.default_rng(len(name)).normal(size=6)
    assert difference(layout, motion) < AGREEMENT


@pytest.mark.parametrize("column", range(6))
def test_one_motion_of_a_test_mass_and_a_splitter(layout: OpticalLayout, column: int) -> None:
    motion = np.zeros((len(layout.elements), 6))
    motion[[layout.index("TM1"), layout.index("BS5")], column] = 1e-3, -2e-3
    assert difference(layout, motion) < AGREEMENT


def test_everything_moved(layout: OpticalLayout) -> None:
    motion = 1e-3 * np.random.default_rng(1).normal(size=(len(layout.elements), 6))
    assert difference(layout, motion) < AGREEMENT


@pytest.mark.parametrize(("seed", "masses"), [(2, 1), (3, 2), (1, 3)])
def test_benches_out_of_plane(seed: int, masses: int) -> None:
    bench = random_layout(seed, masses)
    motion = 1e-4 * np.random.default_rng(seed).normal(size=(len(bench.elements), 6))
    assert difference(bench, motion) < AGREEMENT
