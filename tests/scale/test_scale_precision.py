"""Single precision only where it changes nothing; reading in pieces; sums of files beside other work."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tedm_cli.config.project import load_project
from tedm_cli.contracts import Dataset, FileKind
from tedm_cli.distortion import RigidFit
from tedm_cli.errors import InputError
from tedm_cli.files.blocks import Blocks, PrecisionLossError, SomeNodes, narrowed, node_blocks
from tedm_cli.files.provenance import Provenance, input_files
from tedm_cli.files.seal import seal
from tedm_cli.files.store import create, open_checked
from tedm_cli.nastran.displacements import unit_load_displacements
from tedm_cli.nastran.loads.unit_loads import UnitLoad
from tedm_cli.progress import silent
from tedm_cli.stages.model.ingest import ingest

SMALL = Path(__file__).parents[2] / "sample_models" / "small"

KIND = FileKind(
    "probe",
    1,
    "probe",
    {"/x": Dataset("/x", ("area", "node", "xyz"), "real", "m", "x"), "/y": Dataset("/y", ("area",), "float", "m", "y")},
)


def write(path: Path, x: np.ndarray, *, single: bool) -> None:
    with create(path, KIND, Provenance((), (), "probe")) as writer:
        target = writer.allocate("/x", x.shape, single=single)
        for i, row in enumerate(x):
            target[i] = row
        writer.write("/y", np.zeros(len(x)))


@given(st.floats(allow_nan=False, width=64))
def test_narrowing_is_exact_or_refused(value: float) -> None:
    try:
        assert float(narrowed(np.array([value]))[0]) == value
    except PrecisionLossError:
        with np.errstate(over="ignore"):
            assert float(np.float32(value)) != value


def test_a_number_of_double_precision_keeps_the_old_file(tmp_path: Path) -> None:
    path, x = tmp_path / "probe.h5", np.full((2, 5, 3), 0.5)
    write(path, x, single=True)
    before = path.read_bytes()
    x[1, 4, 2] = 0.1
    with pytest.raises(PrecisionLossError):
        write(path, x, single=True)
    assert path.read_bytes() == before


@pytest.mark.parametrize("single", [True, False])
def test_stages_read_double_precision_from_either(tmp_path: Path, single: bool) -> None:
    x = np.arange(30.0).reshape(2, 5, 3) / 8
    write(tmp_path / "probe.h5", x, single=single)
    with open_checked(tmp_path / "probe.h5", KIND) as file:
        blocks = file.dataset("/x")
        assert blocks.single is single
        assert blocks[1, 1:3].dtype == np.float64
        np.testing.assert_array_equal(file.array("/x"), x)


def test_single_precision_where_the_contract_wants_double_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "probe.h5"
    write(path, np.ones((2, 5, 3)), single=True)
    with h5py.File(path, "a") as file:
        attributes = dict(file["y"].attrs)
        del file["y"]
        file["y"] = np.zeros(2, dtype=np.float32)
        file["y"].attrs["units"] = attributes["units"]
    seal(path)
    with pytest.raises(InputError, match="/y holds float32, wanted float"), open_checked(path, KIND):
        pass


@given(st.lists(st.integers(0, 199_999), max_size=40), st.integers(1, 3))
def test_some_nodes_are_found_in_whatever_block_they_are(rows: list[int], length: int) -> None:
    wanted = np.array(rows, dtype=np.int64)
    found = np.full(len(rows), -1)
    for block in node_blocks(200_000, 40_000 * length):
        at, local = SomeNodes(wanted).within(block)
        found[at] = np.arange(block.start, block.stop)[local]
    np.testing.assert_array_equal(found, wanted)


@given(st.lists(st.integers(0, 49_999), max_size=40))
def test_some_nodes_are_read_in_their_order(dataset: Blocks, rows: list[int]) -> None:
    wanted = np.array(rows, dtype=np.int64)
    np.testing.assert_array_equal(SomeNodes(wanted).read(dataset, 1), dataset[()][1, wanted].reshape(-1, 3))


@pytest.fixture(scope="module")
def dataset(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Blocks]:
    path = tmp_path_factory.mktemp("blocks") / "file.h5"
    with h5py.File(path, "w") as file:
        file["d"] = np.random.default_rng(0).normal(size=(2, 50_000, 3))
        yield Blocks(file["d"], path)


def test_rigid_fit_finds_a_rigid_motion_from_parts_and_removes_it_from_any_other() -> None:
    rng = np.random.default_rng(4)
    p, w, centre = rng.normal(size=(50, 3)), rng.uniform(0.1, 1.0, 50), np.array([0.3, -0.2, 0.1])
    shift, turn = rng.normal(size=(2, 3))
    fit = RigidFit(p, w, centre)

    def motion(u: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        moments = sum(fit.moments(s, u[s]) for s in (slice(0, 13), slice(13, 50)))
        (_, translation), (_, rotation) = fit.motions(np.stack([0.0 * moments, moments]))
        return translation, rotation

    u = shift + np.cross(turn, p - centre)
    np.testing.assert_allclose(np.concatenate(motion(u)), np.concatenate([shift, turn]), rtol=1e-12)
    v = rng.normal(size=(50, 3))
    t, theta = motion(v)
    rest = v - t - np.cross(theta, p - centre)
    # the rest has neither momentum nor angular momentum: the normal equations themselves
    assert np.abs(w @ rest).max() < 1e-12
    assert np.abs(w @ np.cross(p - centre, rest)).max() < 1e-12


def test_sums_of_files_come_in_their_order_and_errors_where_they_are_asked_for(tmp_path: Path) -> None:
    paths = [tmp_path / name for name in "ab"]
    for path in paths:
        path.write_bytes(path.name.encode() * 3_000_000)
    missing = tmp_path / "c"
    *found, lost = input_files([*paths, missing])
    assert [f.sha256 for f in found] == [hashlib.sha256(p.read_bytes()).hexdigest() for p in paths]
    with pytest.raises(InputError, match="cannot be read"):
        _ = lost.sha256


@pytest.mark.parametrize(("factor", "dtype"), [(1.0, np.float32), (1.1, np.float64)])
def test_ingest_takes_the_precision_that_its_numbers_need(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, factor: float, dtype: type
) -> None:
    """1.1 stands for turned frames or a solver that writes double precision."""
    kept: list[np.ndarray] = []

    def motions(*args: Any, **options: Any) -> Iterator[tuple[UnitLoad, np.ndarray, np.ndarray]]:
        kept.clear()
        for load, t, r in unit_load_displacements(*args, **options):
            kept.append(factor * t)
            yield load, factor * t, factor * r

    monkeypatch.setattr("tedm_cli.stages.model.read.unit_load_displacements", motions)
    ingest(load_project(SMALL / "tedm.toml", tmp_path), None, silent)
    with h5py.File(tmp_path / "unit_loads.h5") as file:
        assert file["translation"].dtype == dtype
        np.testing.assert_array_equal(file["translation"][()], kept[: len(file["translation"])])
