"""build-sensitivity --scheduler: result files reduced by the workers of a dask scheduler, one task for each."""

from __future__ import annotations

import contextlib
import logging
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tedm_cli import __version__
from tedm_cli.config.project import Project
from tedm_cli.errors import InputError, UsageError
from tedm_cli.progress import Step
from tedm_cli.results.parts import Part
from tedm_cli.stages.model.ingest import own_results
from tedm_cli.stages.model.merge import MergeSummary, SensitivityOf, assemble
from tedm_cli.stages.model.parts import Prepared, ReductionOf, part_of, prepare
from tedm_cli.stages.model.read import read_model

if TYPE_CHECKING:
    from distributed import Client, Future

ANSWER_S = 10.0  # for a scheduler to answer
WORKERS_S = 60.0  # for workers to come, at the beginning and where none is left
ROUNDS = 4  # times that a task is given out whose worker, or what was sent to it, is gone


def reduce_on_workers(
    project: Project, address: str, reduction_of: ReductionOf, sensitivity_of: Any, step: Step
) -> MergeSummary:
    """The files of the chain from all result files of model.op2, each reduced by a worker that sees it.

    `sensitivity_of(pulls)` is the `SensitivityOf` of what was summed for the operator.

    Raises
    ------
    UsageError : distributed is not installed; an address that is none.
    InputError : no scheduler answers, or no worker comes; workers of another version; what a worker refuses.
    """
    results = own_results(project)
    with _connected(address) as client:
        _require_version(client, address)
        read = read_model(project, [path for path in results if path.exists()])
        prepared, _, pulls = prepare(project, read, reduction_of, step)
        jobs = [(path.resolve(), name) for path, name in zip(results, read.config.model.op2, strict=True)]
        parts = parts_on(client, prepared, jobs, step, address)
    finish: SensitivityOf = sensitivity_of(pulls)
    return assemble(project, read, parts, (), finish, step)


@contextlib.contextmanager
def _connected(address: str) -> Iterator[Client]:
    try:
        from distributed import Client
    except ImportError:
        raise UsageError(
            "--scheduler needs distributed, which is not installed", hint='pip install "tedm[cluster]"'
        ) from None
    for name in ("distributed", "distributed.client"):  # it tells in errors here what is left to say
        logging.getLogger(name).setLevel(logging.CRITICAL)
    host, _, port = address.rpartition("://")[2].rpartition(":")
    if not host or not port.isdigit():
        raise UsageError(f"{address!r} is no address of a scheduler", hint="such as tcp://HOST:8786, as it says itself")
    try:
        client = Client(address, timeout=ANSWER_S)
    except OSError as exc:
        raise InputError(
            f"no dask scheduler answers within {ANSWER_S:.0f} s ({_first_line(exc)})",
            where=address,
            hint="start one with `dask scheduler`, and workers with `dask worker ADDRESS`; without --scheduler this"
            " machine does the work",
        ) from None
    try:
        yield client
    finally:
        client.close(timeout=ANSWER_S)


def _first_line(exc: BaseException) -> str:
    return (str(exc) or type(exc).__name__).splitlines()[0]


def _workers(client: Client) -> list[str]:
    return sorted(client.scheduler_info(n_workers=-1)["workers"])


def _wait_for_workers(client: Client, address: str) -> None:
    try:
        client.wait_for_workers(1, timeout=WORKERS_S)
    except OSError:
        raise InputError(
            f"the scheduler has no worker, and none came within {WORKERS_S:.0f} s",
            where=address,
            hint=f"start some with `dask worker {address}`; results of tasks that were done are not kept",
        ) from None


def worker_version() -> str:
    """The version of tedm where this runs."""
    return __version__


def _require_version(client: Client, address: str) -> None:
    """Workers must have this version: others may define the same columns otherwise, or not at all."""
    _wait_for_workers(client, address)
    try:
        found = client.run(worker_version, on_error="return")
    except OSError as exc:
        raise InputError(f"lost the workers ({_first_line(exc)})", where=address) from None
    for worker, version in sorted(found.items()):
        if version != __version__:
            what = f"has no tedm ({_first_line(version)})" if isinstance(version, BaseException) else f"has {version}"
            raise InputError(
                f"worker {worker} {what}, this is tedm {__version__}",
                where=address,
                hint="install the same tedm where the workers run, and start them again",
            )


def parts_on(
    client: Client, prepared: Prepared, jobs: Sequence[tuple[Path, str]], step: Step, address: str
) -> list[Part]:
    """The parts of the result files, in their order, whoever made them and when.

    What they are reduced with is sent to all workers once. A result is fetched as soon as it is there, so that no
    worker that goes takes one with it; what one was at is given to another, and what was sent is sent again where
    nobody has it any more.

    Raises
    ------
    InputError, PhysicsError : what `part_of` refuses, of a file; workers that do not come back.
    """
    done: dict[int, Part] = {}
    for _ in range(ROUNDS):
        _wait_for_workers(client, address)
        try:
            _round(client, prepared, jobs, done, step, address)
        except (OSError, RuntimeError) as exc:
            lost = _first_line(exc)
        else:
            lost = "workers have gone"
        if len(done) == len(jobs):
            return [done[number] for number in range(len(jobs))]
    left = [str(path) for number, (path, _) in enumerate(jobs) if number not in done]
    raise InputError(
        f"not done after {ROUNDS} attempts, {len(left)} of {len(jobs)} result files: {left[0]} ({lost})",
        where=address,
        hint="do the workers have memory enough? `dask worker --memory-limit`, and one thread each, `--nthreads 1`",
    )


def _round(
    client: Client,
    prepared: Prepared,
    jobs: Sequence[tuple[Path, str]],
    done: dict[int, Part],
    step: Step,
    address: str,
) -> None:
    """Give out what is not `done`, and gather what comes back; what was lost stays for another round."""
    from concurrent.futures import CancelledError

    from distributed import KilledWorker, wait

    sent = client.scatter(prepared, broadcast=True, hash=False)
    futures: dict[Future[Part], int] = {
        client.submit(part_of, sent, path, name, pure=False, retries=0): number
        for number, (path, name) in enumerate(jobs)
        if number not in done
    }
    try:
        while futures:
            with contextlib.suppress(TimeoutError, CancelledError):  # what is cancelled is among those that are done
                wait(list(futures), timeout=WORKERS_S, return_when="FIRST_COMPLETED")
            for future in [future for future in futures if future.done()]:
                number = futures.pop(future)
                try:
                    done[number] = future.result()
                except CancelledError:
                    continue
                except KilledWorker:
                    raise InputError(
                        "one worker after the other was killed while it reduced this file",
                        where=str(jobs[number][0]),
                        hint="is their memory enough? `dask worker --memory-limit`, and `--nthreads 1`",
                    ) from None
                step(len(done), len(jobs), "reducing results")
            if futures and not _workers(client):
                _wait_for_workers(client, address)
    finally:
        client.cancel(list(futures))
