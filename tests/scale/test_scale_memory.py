"""What the stages hold does not grow with areas times grids, and what they stream is what goes through them."""

from __future__ import annotations

import tracemalloc
from collections.abc import Callable

import h5py
import numpy as np
import pytest

from benchmarks import synthetic
from tedm_cli.config.project import Project
from tedm_cli.contracts import DISTORTION, SENSITIVITY, UNIT_LOADS
from tedm_cli.files.store import open_checked
from tedm_cli.progress import silent
from tedm_cli.stages.exports.mesh import WantedArrays, export_mesh
from tedm_cli.stages.gravity.sensitivity import build_sensitivity
from tedm_cli.stages.model.distortion import build_distortion

CELLS = (24, 15, 10)  # 4,400 grids
FEW, MANY = 40, 160


def peak(work: Callable[[], object]) -> int:
    """Bytes that Python and NumPy hold at most during some work, beyond what they held before."""
    tracemalloc.start()
    try:
        before = tracemalloc.get_traced_memory()[0]
        work()
        return tracemalloc.get_traced_memory()[1] - before
    finally:
        tracemalloc.stop()


def stages(where: Project, areas: int) -> dict[str, Callable[[], object]]:
    return {
        "ingest": lambda: synthetic.write_unit_loads(where, synthetic.block(CELLS), areas),
        "build-distortion": lambda: build_distortion(where, None, silent),
        "build-sensitivity": lambda: build_sensitivity(where, None, silent),
        "export-vtu": lambda: export_mesh(where.build_dir, None, WantedArrays(("uniform",), ("TM1_a_x",)), silent),
    }


@pytest.fixture(scope="module")
def peaks(tmp_path_factory: pytest.TempPathFactory) -> dict[str, dict[int, int]]:
    """Peak of every stage by the number of areas, at one number of grids, after a run that imports and compiles.

    On one processor: what two test masses hold in passing meets or does not, by chance.
    """

    def project() -> Project:
        return synthetic.project(tmp_path_factory.mktemp("areas"), "lumped")

    for work in stages(project(), FEW).values():
        work()
    runs = {areas: stages(project(), areas) for areas in (FEW, MANY)}
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("os.cpu_count", lambda: 1)
        return {name: {areas: peak(run[name]) for areas, run in runs.items()} for name in runs[FEW]}


@pytest.mark.parametrize("stage", ["ingest", "build-distortion", "build-sensitivity", "export-vtu"])
def test_memory_does_not_grow_with_the_number_of_areas(peaks: dict[str, dict[int, int]], stage: str) -> None:
    more = (MANY - FEW) * len(synthetic.block(CELLS).grid_id) * 3 * 4  # bytes of [D] in single precision
    assert peaks[stage][MANY] - peaks[stage][FEW] < 0.1 * more


@pytest.fixture(scope="module")
def large(tmp_path_factory: pytest.TempPathFactory) -> Project:
    """More grids than four chunks and more areas than a tile, neither a multiple of it."""
    where = synthetic.project(tmp_path_factory.mktemp("large"), "lumped")
    synthetic.write_unit_loads(where, synthetic.block((58, 39, 29)), 37)
    build_distortion(where, None, silent)
    build_sensitivity(where, None, silent)
    return where


def test_streamed_matrix_and_reductions_are_those_of_the_whole_array(large: Project) -> None:
    with (
        open_checked(large.build_dir / "unit_loads.h5", UNIT_LOADS) as unit,
        open_checked(large.build_dir / "distortion.h5", DISTORTION) as distortion,
    ):
        d, moved, turned = (
            f.array(p) for f, p in ((distortion, "/D/translation"), (unit, "/translation"), (unit, "/rotation"))
        )
        assert d.shape[1] > 65536
        np.testing.assert_array_equal(d, moved)
        length = np.linalg.norm(d.astype(np.float64), axis=2)
        np.testing.assert_allclose(distortion.array("/check/max_translation"), length.max(axis=1), rtol=1e-14)
        rows = np.searchsorted(unit.array("/grid/id"), distortion.array("/optical/grid"))
        np.testing.assert_array_equal(distortion.array("/D_opt/translation"), d[:, rows])
        np.testing.assert_array_equal(distortion.array("/D_opt/rotation"), turned[:, rows])
        total, uniform = d.sum(axis=0), unit.array("/uniform/translation")
        residual = np.abs(total - uniform).max() / np.abs(uniform).max()
        assert distortion.number("/check/superposition_translation") == pytest.approx(residual, rel=1e-6, abs=0)


def test_sensitivity_by_tiles_is_that_of_the_whole_arrays(large: Project) -> None:
    with (
        open_checked(large.build_dir / "distortion.h5", DISTORTION) as distortion,
        open_checked(large.build_dir / "sensitivity.h5", SENSITIVITY) as file,
    ):
        whole = -np.einsum("rna,kna->rk", file.array("/operator/G"), distortion.array("/D/translation"))
        found = file.array("/S")
    np.testing.assert_allclose(found, whole, rtol=0, atol=1e-12 * np.abs(whole).max())


def test_displacements_take_four_bytes_a_number(large: Project) -> None:
    for name, path in (
        ("unit_loads.h5", "translation"),
        ("unit_loads.h5", "rotation"),
        ("distortion.h5", "D/translation"),
    ):
        with h5py.File(large.build_dir / name) as file:
            assert file[path].dtype == np.float32
            assert file[path].id.get_storage_size() < 1.2 * 4 * file[path].size
