"""audit-mesh reads what it needs of [D] and holds neither translations nor rotations of all grids and areas."""

from __future__ import annotations

import tracemalloc
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import h5py
import numpy as np

from tedm_cli.files.blocks import Blocks
from tedm_cli.stages.gravity.audit import element_motion

AREAS, NODES = 20, 40_000
CHOSEN = np.delete(np.arange(AREAS), 3)


def test_motion_of_plates_is_exact_and_flat_in_memory(tmp_path: Path) -> None:
    rng = np.random.default_rng(6)
    lever_node = np.arange(1, NODES, 2)
    u, turn = rng.normal(size=(AREAS, NODES, 3)).astype(np.float32), rng.normal(size=(AREAS, len(lever_node), 3))
    nodes = rng.integers(0, NODES, size=(30, 4))
    lever = np.where((nodes % 2 == 1)[..., None], rng.normal(size=(30, 4, 3)), 0.0)
    path = tmp_path / "file.h5"
    with h5py.File(path, "w") as file:
        file.create_dataset("/D/translation", data=u, chunks=(1, 16384, 3))
        file.create_dataset("/D/rotation", data=turn, chunks=(1, 16384, 3))
    with h5py.File(path, rdcc_nbytes=0) as file:
        distortion: Any = SimpleNamespace(dataset=lambda name: Blocks(file[name], path))
        masses: Any = SimpleNamespace(lever_node=lever_node)
        tracemalloc.start()
        motion = element_motion(distortion, masses, CHOSEN)
        found, again = motion(nodes, lever), motion(nodes, lever)
        peak = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
        other = motion(nodes[::-1], lever[::-1])
    wanted = u[:, nodes].astype(np.float64)
    on = nodes % 2 == 1
    wanted[:, on] += np.cross(turn[:, np.searchsorted(lever_node, nodes[on])], lever[on])
    wanted = wanted[CHOSEN]
    np.testing.assert_array_equal(found, wanted)
    np.testing.assert_array_equal(again, wanted)
    np.testing.assert_array_equal(other, wanted[:, ::-1])
    assert peak < 0.3 * turn.nbytes
