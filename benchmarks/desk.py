"""What a whole chain costs in processor time: in one `tedm run`, against a process for each of its commands."""

from __future__ import annotations

import contextlib
import json
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from pathlib import Path

from benchmarks.timing import Result, Times


def one_run(jobs: int = 2) -> Result:
    """The project of `tedm init`, by `tedm run -j JOBS` and then by its commands; once each, as a chain is run once."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        _tedm(folder, "init")
        plan = json.loads(_tedm(folder, "run", "-n", "--json"))
        commands = [step["command"] for step in plan["stale"]]
        _tedm(folder, *commands[0], "-d", "warm")  # files are in memory, and what is compiled is compiled
        with _spent() as ours:
            _tedm(folder, "run", "-j", str(jobs), "-d", "together")
        with _spent() as theirs:
            for command in commands:
                _tedm(folder, *command, "-d", "alone")
                if command[0] == "plot":
                    (folder / "alone" / "figures.stamp").touch()
        note = f"processor time of {len(commands)} commands; elapsed {ours.elapsed:.1f} against {theirs.elapsed:.1f} s"
        return Result(Times((ours.processor,), (ours.elapsed,)), Times((theirs.processor,), (theirs.elapsed,)), note)


class _Spent:
    processor = elapsed = 0.0


@contextlib.contextmanager
def _spent() -> Iterator[_Spent]:
    """Seconds that programs started within take; those that they start are counted with them."""
    spent, before, start = _Spent(), _of_children(), time.perf_counter()
    yield spent
    spent.processor, spent.elapsed = _of_children() - before, time.perf_counter() - start


def _of_children() -> float:
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def _tedm(folder: Path, *arguments: str) -> str:
    program: Sequence[str] = [sys.executable, "-m", "tedm_cli.cli", *arguments]
    return subprocess.run(program, cwd=folder, check=True, stdout=subprocess.PIPE, text=True).stdout
