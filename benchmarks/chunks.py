"""How displacements are laid out in files: GB/s of writing and reading by shapes of chunks and HDF5's chunk cache."""

from __future__ import annotations

import tempfile
import time
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Any

import h5py
import numpy as np

MB = 1 << 20
#: Areas × grids of a chunk (none: contiguous) and bytes of the cache; the second is that of the files.
LAYOUTS: tuple[tuple[tuple[int, int] | None, int], ...] = (
    (None, 0),
    ((1, 16384), 0),
    ((1, 16384), MB),
    ((1, 2048), MB),
    ((1, 65536), MB),
    ((8, 8192), MB),
    ((40, 1024), MB),
)
_BLOCK = 16384


def rows(grids: int = 330_000, areas: int = 40, runs: int = 2) -> Iterator[dict[str, Any]]:
    """Of single precision, in the page cache: written by area, read by area, and read by blocks of 16,384 grids."""
    values = np.random.default_rng(1).normal(size=(grids, 3)).astype(np.float32)
    size = areas * values.nbytes / 1e9
    with tempfile.TemporaryDirectory() as name:
        path = Path(name) / "layout.h5"
        for chunk, cache in LAYOUTS:
            works: dict[str, Callable[[], object]] = {
                "write": partial(_write, path, areas, values, chunk, cache),
                "by_area": partial(_by_area, path, cache),
                "by_block": partial(_by_block, path, cache),
            }
            speeds = {what: round(size / min(_seconds(work) for _ in range(runs)), 2) for what, work in works.items()}
            yield {"chunk": chunk, "cache_MB": cache // MB, "gigabytes": size, **speeds}


def _seconds(work: Callable[[], object]) -> float:
    start = time.process_time()
    work()
    return time.process_time() - start


def _write(path: Path, areas: int, values: np.ndarray, chunk: tuple[int, int] | None, cache: int) -> None:
    with h5py.File(path, "w", rdcc_nbytes=cache) as file:
        shape = (areas, *values.shape)
        data = file.create_dataset("d", shape, np.float32, chunks=(*chunk, 3) if chunk else None)
        for i in range(areas):
            data[i] = values


def _by_area(path: Path, cache: int) -> None:
    with h5py.File(path, rdcc_nbytes=cache) as file:
        for i in range(len(file["d"])):
            file["d"][i]


def _by_block(path: Path, cache: int) -> None:
    with h5py.File(path, rdcc_nbytes=cache) as file:
        data = file["d"]
        for start in range(0, data.shape[1], _BLOCK):
            data[:, start : start + _BLOCK]
