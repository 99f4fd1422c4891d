from __future__ import annotations

import sys
from collections.abc import Iterator, Sequence
from pathlib import Path

sys.path.append(str(Path(__file__).parents[1] / "borders"))

import pytest
from border_tools import tedm
from trade_project import Bricks, make_bricks

from tedm_cli.stages.chain.workers import Answer, Job


class _InThisProcess:
    """Workers that run commands here, in place of processes that load all libraries: what they do is the same."""

    def __init__(self, program: Sequence[str], number: int, *, alone: bool = False) -> None:
        self._number, self._busy = number, list[tuple[Job, Sequence[str]]]()

    def __enter__(self) -> _InThisProcess:
        return self

    def __exit__(self, *_: object) -> None:
        assert not self._busy

    @property
    def has_room(self) -> bool:
        return len(self._busy) < self._number

    @property
    def are_busy(self) -> bool:
        return bool(self._busy)

    def begin(self, job: Job, options: Sequence[str]) -> None:
        self._busy.append((job, options))

    def wait(self) -> tuple[Job, Answer]:
        job, options = self._busy.pop(0)
        done = tedm(*job.command, *options)
        return job, Answer(done.code, done.out, done.err)


@pytest.fixture(scope="module")
def in_this_process() -> Iterator[None]:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("tedm_cli.stages.chain.perform.Workers", _InThisProcess)
        yield


@pytest.fixture(scope="session")
def plain(tmp_path_factory: pytest.TempPathFactory) -> Bricks:
    """A trade that has not been run. Not to be changed: copy it."""
    return make_bricks(tmp_path_factory.mktemp("trade") / "plain")


@pytest.fixture(scope="module")
def traded(in_this_process: None, plain: Bricks, tmp_path_factory: pytest.TempPathFactory) -> Bricks:
    """The same with all its chains run, two at once. Not to be changed: copy it."""
    bricks = plain.copy(tmp_path_factory.mktemp("traded") / "bricks")
    bricks.run("-j", "2").ok()
    return bricks


@pytest.fixture
def bricks(plain: Bricks, tmp_path: Path) -> Bricks:
    """A trade that a test may change, not run."""
    return plain.copy(tmp_path / "trade")


@pytest.fixture
def done(traded: Bricks, tmp_path: Path) -> Bricks:
    """A trade that a test may change, run."""
    return traded.copy(tmp_path / "trade")
