"""A process that runs commands one after another (`tedm_cli.stages.chain.workers`): requests in, answers out."""

from __future__ import annotations

import contextlib
import io
import json
import os
import sys
from io import FileIO
from pathlib import Path

import tedm_cli
from tedm_cli.interrupts import Interrupts, leave_if_threads_run

# The folder of a user's project is no place to import from: it may hold a signal.py.
PROGRAM = (
    sys.executable,
    "-P",
    "-c",
    "import sys; sys.path.append(sys.argv[1]); from tedm_cli.cli.worker import work; work()",
    str(Path(tedm_cli.__file__).resolve().parents[1]),
)


def work() -> None:
    """Answer requests until there are no more. An interrupt ends the process: whoever asks tells of it."""
    interrupts = Interrupts()
    try:
        with interrupts, os.fdopen(os.dup(0)) as requests, os.fdopen(os.dup(1), "wb", buffering=0) as answers:
            _occupy_streams()
            for line in requests:
                _answer(json.loads(line), answers)
        if interrupts.number is not None:
            leave_if_threads_run(128 + interrupts.number)
    finally:
        interrupts.release()
    sys.exit(0 if interrupts.number is None else 128 + interrupts.number)


def _answer(request: dict[str, object], answers: FileIO) -> None:
    from tedm_cli.cli.run import collect_seldom, outcome
    from tedm_cli.cli.streams import tell

    collect_seldom()

    argv, alone = request["argv"], request["alone"]
    assert isinstance(argv, list)
    sys.argv = ["tedm", *argv]
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.nullcontext() if alone else contextlib.redirect_stderr(err):
        code, told = outcome()
        tell(told)
    left = json.dumps({"code": code, "out": out.getvalue(), "err": err.getvalue()}).encode() + b"\n"
    with contextlib.suppress(BrokenPipeError):  # nobody wants to know any more
        while left:
            left = left[answers.write(left) :]


def _occupy_streams() -> None:
    """What commands and libraries read and print is not of the conversation."""
    nowhere = os.open(os.devnull, os.O_RDWR)
    os.dup2(nowhere, 0)
    os.dup2(nowhere, 1)
    os.close(nowhere)
