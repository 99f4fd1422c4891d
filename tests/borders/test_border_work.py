"""Work that would take days or all memory is refused before it begins, with the number that makes it too large."""

from __future__ import annotations

import time
import tracemalloc
from pathlib import Path

import h5py
import numpy as np
import pytest
from border_tools import Project, replace

SECONDS, BYTES = 20.0, 400e6


def realised(project: Project, *keys: str) -> None:
    with open(project.folder / "cases.toml", "a", encoding="utf-8") as stream:
        stream.write("\n".join(["", "[realisation]", "seed = 1", *keys, ""]))


@pytest.mark.parametrize(
    ("keys", "fact"),
    [
        (
            ["rate_hz = 1e6"],
            "realisation.rate_hz: 1e+06 Hz are 1,000,000,000 samples in a period of lowest_hz 0.001 Hz",
        ),
        (["tolerance = 1e-9"], "realisation.tolerance: tolerance 1e-09 is outside 0.0001 to 0.99"),
        (["tolerance = 2e-4"], "realisation.tolerance: a PSD within 0.0002 with probability 0.95 takes too many"),
        (["samples = 1000000000000000"], "realisation.samples: number of samples 1,000,000,000,000,000 is outside"),
        (
            ["lowest_hz = 1e-9"],
            "realisation.rate_hz: 0.25 Hz are 250,000,000 samples in a period of lowest_hz 1e-09 Hz",
        ),
        (["confidence = 0.99999999999999999"], "realisation.confidence: probability 1 is outside 0.001 to 0.999999"),
    ],
)
def test_a_realisation_without_end_is_refused(small: Project, keys: list[str], fact: str) -> None:
    realised(small, *keys)
    begin = time.process_time()
    small.run("run-case", "3").refused(3, fact)
    assert time.process_time() - begin < SECONDS


def test_seeds_that_numpy_and_hdf5_do_not_both_hold_are_refused(small: Project) -> None:
    replace(small.folder / "cases.toml", "[frequency]", "[realisation]\nseed = 9223372036854775808\n\n[frequency]")
    small.run("run-case", "3").refused(3, "realisation.seed: seed 9,223,372,036,854,775,808 is outside 0 to 9,223")


def test_a_realisation_that_does_not_fit_into_memory_is_refused(small: Project) -> None:
    """Whatever the plan, filters of many independent fluctuations are held at once."""
    replace(small.folder / "cases.toml", "min_hz = 1e-4", "min_hz = 1e-5")
    realised(small, "lowest_hz = 1e-5", "rate_hz = 0.6", "samples = 100000000")
    tracemalloc.start()
    try:
        small.run("run-case", "2").refused(4, "case 2: realisation: filters of 128 periods of 1e-05 Hz at 0.6 Hz take")
        assert tracemalloc.get_traced_memory()[1] < BYTES
    finally:
        tracemalloc.stop()


def series(project: Project, rows: str, *keys: str) -> None:
    (project.folder / "warm.csv").write_text("time_s,all\n" + rows)
    with open(project.folder / "cases.toml", "a", encoding="utf-8") as stream:
        stream.write("\n".join(["", "[[series]]", 'name = "warm"', 'file = "warm.csv"', 'remove = "mean"', *keys, ""]))


ROWS = "".join(f"{n},{0.1 * np.sin(n):.6f}\n" for n in range(2000))


@pytest.mark.parametrize(
    ("rows", "keys", "code", "fact"),
    [
        (ROWS, ["lowest_hz = 1e-9"], 4, "are too few for a spectrum from 1e-09 Hz, which takes 32,000,000,000"),
        (ROWS, ["resample_s = 1e-6", 'method = "linear"'], 3, "resample_s: steps of 1e-06 s make too many samples"),
        (
            "0,0\n1,1\n2,0\n1000000,1\n",
            ["resample_s = 1", 'method = "linear"', "max_gap_s = 1e9"],
            3,
            "999,998 samples between two rows; at most 262,144",
        ),
    ],
)
def test_a_series_without_end_is_refused(
    small: Project, rows: str, keys: list[str], code: int, fact: str, tmp_path: Path
) -> None:
    series(small, rows, *keys)
    tracemalloc.start()
    try:
        small.run("run-series", "warm").refused(code, fact)
        assert tracemalloc.get_traced_memory()[1] < BYTES
    finally:
        tracemalloc.stop()


def test_resampling_in_pieces_is_resampling_at_once(small: Project) -> None:
    """A series whose samples come in many pieces, of a straight line, which interpolation keeps as it is."""
    rows = "".join(f"{5.0 * n},{1e-3 * n}\n" for n in range(3000))
    series(small, rows, "resample_s = 0.01", 'method = "linear"', "lowest_hz = 0.01")
    small.run("run-series", "warm").ok()
    with h5py.File(small.build / "series_warm.h5") as file:
        stamps, values = file["/time"][()], file["/series/TM1_a_x"][()]
    assert len(stamps) == 2999 * 500 + 1
    np.testing.assert_allclose(np.diff(values), np.diff(values).mean(), rtol=1e-6)
