"""Processes that run commands of the chain, one after another in each: libraries are loaded once for all of them.

A worker reads requests from its standard input and answers on its standard output, each a line of JSON. It ends with
its input, and so with whoever started it.
"""

from __future__ import annotations

import contextlib
import json
import signal
import subprocess
from collections.abc import Sequence
from dataclasses import dataclass
from selectors import EVENT_READ, DefaultSelector
from types import TracebackType

from tedm_cli.interrupts import whole

_PATIENCE_S = 10.0  # for a worker to remove what it has half made


@dataclass(frozen=True)
class Answer:
    """How a command ended: its exit code, and what it printed; of standard error only what was not let through."""

    code: int
    out: str
    err: str


@dataclass(frozen=True)
class Job:
    """A command, and the number of the chain that it is of."""

    command: tuple[str, ...]
    chain: int = 0


class Workers:
    """Context of at most `number` processes; leaving it ends them, by a signal where it is left by an exception.

    Parameters
    ----------
    program : what starts a worker.
    alone : standard error is shared with this process, progress included; else it comes with the answers.
    """

    def __init__(self, program: Sequence[str], number: int, *, alone: bool = False) -> None:
        self._program, self._number, self._alone = program, number, alone
        self._free: list[subprocess.Popen[bytes]] = []
        self._busy: dict[subprocess.Popen[bytes], Job] = {}

    def __enter__(self) -> Workers:
        return self

    @property
    def has_room(self) -> bool:
        """Whether one more command can run now."""
        return len(self._busy) < self._number

    @property
    def are_busy(self) -> bool:
        return bool(self._busy)

    @whole
    def begin(self, job: Job, options: Sequence[str]) -> None:
        """Let a worker run `tedm command options`; a new one where all others are at work."""
        worker = self._free.pop() if self._free else self._start()
        self._busy[worker] = job
        request = {"argv": [*job.command, *options], "alone": self._alone}
        assert worker.stdin is not None
        with contextlib.suppress(BrokenPipeError):  # it has died: `wait` tells
            worker.stdin.write(json.dumps(request).encode() + b"\n")
            worker.stdin.flush()

    def wait(self) -> tuple[Job, Answer]:
        """Wait for a command to end; which, and how it ended. Where its process has died, its error says so."""
        with DefaultSelector() as selector:
            for worker in self._busy:
                assert worker.stdout is not None
                selector.register(worker.stdout, EVENT_READ, worker)
            key, _ = selector.select()[0]
        return self._answer_of(key.data)

    @whole
    def _answer_of(self, worker: subprocess.Popen[bytes]) -> tuple[Job, Answer]:
        assert worker.stdout is not None
        line = worker.stdout.readline()
        job = self._busy.pop(worker)
        if not line.endswith(b"\n"):
            return job, _died(job.command, _ended(worker))
        self._free.append(worker)
        return job, Answer(**json.loads(line))

    def _start(self) -> subprocess.Popen[bytes]:
        return subprocess.Popen(self._program, stdin=subprocess.PIPE, stdout=subprocess.PIPE)

    @whole
    def __exit__(self, kind: type[BaseException] | None, exc: BaseException | None, at: TracebackType | None) -> None:
        workers = [*self._free, *self._busy]
        for worker in workers:
            if exc is not None:
                worker.send_signal(signal.SIGTERM)
            for pipe in (worker.stdin, worker.stdout):
                assert pipe is not None
                with contextlib.suppress(OSError):
                    pipe.close()
        for worker in workers:
            _ended(worker)


def _ended(worker: subprocess.Popen[bytes]) -> int:
    try:
        return worker.wait(_PATIENCE_S)
    except subprocess.TimeoutExpired:
        worker.kill()
        return worker.wait()


def _died(command: tuple[str, ...], code: int) -> Answer:
    how = f"by signal {-code} ({signal.Signals(-code).name})" if code < 0 else f"with code {code}"
    memory = "; the system does so where memory runs out" if code == -signal.SIGKILL else ""
    told = f"error: the process of `tedm {' '.join(command)}` ended {how}{memory}"
    return Answer(1, "", f"{told}\nhint: finished files are kept, and the next run goes on from there\n")
