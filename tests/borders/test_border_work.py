"""Work that would take days or all memory is refused before it begins, with the number that makes it too large."""

from __future__ import annotations

import time
import tracemalloc
from pathlib import Path

import h5py
import numpy as np
import pytest
from border_tools import Project, replace

from tedm_cli.noise.requirements import frequency_grid

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


def test_a_fine_grid_and_a_long_table_of_limits_are_no_square_of_memory() -> None:
    """Points beside what the grid must hold are found by neighbours; both have up to 100,000."""
    held = np.geomspace(1e-3, 3e-2, 60_000)
    tracemalloc.start()
    try:
        grid = frequency_grid(1e-4, 0.1, 60_000, [tuple(held)])
        assert tracemalloc.get_traced_memory()[1] < 50e6
    finally:
        tracemalloc.stop()
    assert np.all(np.diff(grid) > 0.0)
    assert np.isin(held, grid).all()
    assert len(grid) > 100_000


def test_a_small_file_of_a_long_table_is_refused(small: Project) -> None:
    """Equal numbers take next to no room in a compressed file, however many they are."""
    with h5py.File(small.folder / "spectra.h5", "w") as file:
        for name in ("frequency_hz", "all"):
            file.create_dataset(name, data=np.full(2_000_000, 1e-3), compression="gzip", compression_opts=9)
    assert (small.folder / "spectra.h5").stat().st_size < 200_000
    replace(small.folder / "cases.toml", 'preset = "thesis"', 'preset = "table"\ntable = "spectra.h5"')
    for key in ("outside_K", "inside_K", "reference_hz", "order", "corner_hz"):
        replace(small.folder / "cases.toml", f"\n{key} = ", f"\n# {key} = ")
    small.run("run-case", "3").refused(4, "spectra.h5: holds more than 100,000 frequencies")
