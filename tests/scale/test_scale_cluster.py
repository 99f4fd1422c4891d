"""Results reduced by the workers of a dask scheduler: the same bits whoever does it, and nothing lost with a worker."""

from __future__ import annotations

import os
import signal
import socket
import sys
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from unittest import mock

import h5py
import numpy as np
import pytest
from border_tools import tedm
from distributed import Client, LocalCluster
from parts_project import FILES, parts_project

from tedm_cli.columns import Columns
from tedm_cli.config.project import Project
from tedm_cli.errors import InputError, UsageError
from tedm_cli.progress import silent
from tedm_cli.results.parts import Part
from tedm_cli.stages.gravity.pulls import reduction_of
from tedm_cli.stages.gravity.sensitivity import GivenColumns, build_sensitivity
from tedm_cli.stages.model import cluster
from tedm_cli.stages.model.cluster import parts_on, reduce_on_workers
from tedm_cli.stages.model.merge import assemble
from tedm_cli.stages.model.parts import Prepared, part_of, prepare
from tedm_cli.stages.model.read import read_model

NAMES = ("unit_loads.h5", "distortion.h5", "sensitivity.h5")


@pytest.fixture(scope="module")
def workers() -> Iterator[LocalCluster]:
    """Two processes of one thread each."""
    settings = {"n_workers": 2, "threads_per_worker": 1, "dashboard_address": ":0"}
    with LocalCluster(processes=True, **settings) as found:
        yield found


@pytest.fixture(scope="module")
def client(workers: LocalCluster) -> Iterator[Client]:
    with Client(workers) as found:
        yield found


@pytest.fixture(scope="module")
def project(tmp_path_factory: pytest.TempPathFactory) -> Project:
    return parts_project(tmp_path_factory.mktemp("cluster"))


@pytest.fixture(scope="module")
def prepared(project: Project) -> Prepared:
    results = [project.resolve(name) for name in FILES]
    return prepare(project, read_model(project, results), reduction_of, silent)[0]


@pytest.fixture(scope="module")
def jobs(project: Project) -> list[tuple[Path, str]]:
    return [(project.resolve(name), name) for name in FILES]


@pytest.fixture(scope="module")
def alone(prepared: Prepared, jobs: list[tuple[Path, str]]) -> list[Part]:
    """The parts of this process."""
    return [part_of(prepared, path, name) for path, name in jobs]


def assert_same_bits(found: list[Part], wanted: list[Part]) -> None:
    assert len(found) == len(wanted)
    for one, two in zip(found, wanted, strict=True):
        assert (one.results, one.sha256, one.areas, one.subcases) == (two.results, two.sha256, two.areas, two.subcases)
        for name in ("columns", "sums"):
            ours, theirs = vars(getattr(one, name)), vars(getattr(two, name))
            for key, data in ours.items():
                np.testing.assert_array_equal(data, theirs[key], err_msg=f"{one.results} {key}")


def test_bits_do_not_depend_on_workers_or_order(
    client: Client, prepared: Prepared, jobs: list[tuple[Path, str]], alone: list[Part]
) -> None:
    """Two workers, and one of them alone with the files in another order; against this process."""
    assert_same_bits(parts_on(client, prepared, jobs, silent, "here"), alone)
    order = [5, 2, 7, 0, 3, 6, 1, 4]
    first = sorted(client.scheduler_info()["workers"])[:1]
    scatter, submit = client.scatter, client.submit
    with (
        mock.patch.object(client, "scatter", lambda *a, **k: scatter(*a, **{**k, "workers": first})),
        mock.patch.object(client, "submit", lambda *a, **k: submit(*a, **k, workers=first)),
    ):
        shuffled = parts_on(client, prepared, [jobs[i] for i in order], silent, "here")
    assert_same_bits(shuffled, [alone[i] for i in order])


@pytest.mark.parametrize("count", [1, 2])
def test_a_worker_killed_in_the_middle_loses_nothing(
    client: Client, prepared: Prepared, jobs: list[tuple[Path, str]], alone: list[Part], count: int
) -> None:
    """Killed while they are at work, one and then all: what they had been sent is gone with them as well."""
    client.wait_for_workers(2, timeout=30)
    process = client.run(os.getpid)
    killed: list[int] = []

    def kill(done: int, total: int, what: str) -> None:
        if not killed:
            busy = [worker for worker, tasks in client.processing().items() if tasks]
            killed.extend(process[worker] for worker in [*busy, *(w for w in process if w not in busy)][:count])
            assert busy, f"all done after {done} of {total}"
            for one in killed:
                os.kill(one, signal.SIGKILL)

    assert_same_bits(parts_on(client, prepared, jobs, kill, "here"), alone)
    assert len(killed) == count
    client.wait_for_workers(2, timeout=30)
    assert not set(killed) & set(client.run(os.getpid).values())


def test_the_command_makes_the_files_that_parts_make(
    workers: LocalCluster, project: Project, alone: list[Part]
) -> None:
    """Every number to the bit that of the parts of this process, by the way of `merge`."""
    words = ("--scheduler", workers.scheduler_address, "-c", project.file.path, "-d", project.build_dir)
    assert tedm("build-sensitivity", *words).ok().out.startswith(f"{project.build_dir / NAMES[0]}: of 8 result files")
    assert sorted(path.name for path in project.build_dir.glob("*.h5")) == sorted(NAMES)
    other = replace(project, build_dir=project.build_dir.with_name("other"))

    def write(columns: Columns, _: object) -> object:
        return build_sensitivity(other, None, silent, GivenColumns(columns))

    assemble(other, read_model(other, []), alone, [], write, silent)
    for name in NAMES:
        assert numbers(project.build_dir / name) == numbers(other.build_dir / name), name


def numbers(path: Path) -> dict[str, bytes]:
    found: dict[str, bytes] = {}
    with h5py.File(path) as file:
        file.visititems(lambda n, o: found.update({n: o[()].tobytes()}) if isinstance(o, h5py.Dataset) else None)
    return {name: data for name, data in found.items() if not name.startswith("provenance/")}


def test_results_that_a_worker_does_not_see(
    client: Client, prepared: Prepared, jobs: list[tuple[Path, str]], tmp_path: Path
) -> None:
    missing = [*jobs[:3], (tmp_path / "batch4.op2", FILES[3]), *jobs[4:]]
    with pytest.raises(InputError, match=r"batch4.op2: no such result file") as error:
        parts_on(client, prepared, missing, silent, "here")
    assert error.value.exit_code == 4
    assert error.value.where == str(tmp_path / "batch4.op2")


def test_a_scheduler_that_is_not_there(project: Project, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(cluster, "ANSWER_S", 0.3)
    with socket.socket() as taken:  # bound, and nobody listens
        taken.bind(("127.0.0.1", 0))
        address = f"tcp://127.0.0.1:{taken.getsockname()[1]}"
        with pytest.raises(InputError, match=rf"{address}: no dask scheduler answers within 0 s") as error:
            reduce_on_workers(project, address, reduction_of, None, silent)
    assert "`dask scheduler`" in error.value.hint
    for wrong in ("", "tcp://host", "host:port"):
        with pytest.raises(UsageError, match="is no address of a scheduler"):
            reduce_on_workers(project, wrong, reduction_of, None, silent)


def test_no_workers_other_versions_no_library(
    workers: LocalCluster, project: Project, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(cluster, "__version__", "9.9")
    with pytest.raises(InputError, match=r"worker tcp://.* has 1.0.0, this is tedm 9.9"):
        reduce_on_workers(project, workers.scheduler_address, reduction_of, None, silent)
    monkeypatch.setattr(cluster, "WORKERS_S", 0.3)
    with (
        LocalCluster(n_workers=0, dashboard_address=":0") as empty,
        pytest.raises(InputError, match=r"the scheduler has no worker, and none came within 0 s"),
    ):
        reduce_on_workers(project, empty.scheduler_address, reduction_of, None, silent)
    with mock.patch.dict(sys.modules, {"distributed": None}), pytest.raises(UsageError, match="not installed") as error:
        reduce_on_workers(project, workers.scheduler_address, reduction_of, None, silent)
    assert "tedm[cluster]" in error.value.hint
