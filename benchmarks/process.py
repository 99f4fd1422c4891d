"""A command in a process of its own: its seconds of processor and of the clock, and its memory by kind."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).parents[1]
INTERVAL_S = 0.004
_THREADS = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS")
_KINDS = ("VmHWM", "VmRSS", "RssAnon", "RssFile", "RssShmem")


@dataclass(frozen=True)
class Usage:
    """What a process took, with the processes that it started.

    processor_s : seconds of processor, user and system, of all of them; wall_s : of the clock. Peaks of memory in MB:
    resident_mb of everything; anonymous_mb of what the program itself holds (RssAnon); file_mb of mapped files, its
    libraries among them, which the system may drop at any time (RssFile and RssShmem). The resident peak of a single
    process is exact (VmHWM); the others are the largest of samples, 4 ms apart. output : what it printed.
    """

    processor_s: float
    wall_s: float
    resident_mb: float
    anonymous_mb: float
    file_mb: float
    output: str = ""


def run(arguments: Sequence[str], *, tree: Path = ROOT, folder: Path | None = None, one_thread: bool = True) -> Usage:
    """`python ARGUMENTS` with the code of `tree`, in a folder; its peers and tasks are always those of this tree.

    With `one_thread`, BLAS has one: its others wait for work by spinning, which counts as seconds of processor. Threads
    of the program's own are as ever. subprocess.CalledProcessError, with what it said, if it fails.
    """
    paths = os.pathsep.join(str(path) for path in dict.fromkeys((tree, tree / "tedm_cli/library/top_level", ROOT)))
    environment = {**os.environ, "PYTHONPATH": paths, "COLUMNS": "120"}
    if arguments[0] == "-m":  # would look in the working folder first, and may find another tree there
        environment["PYTHONSAFEPATH"] = "1"
    if one_thread:
        environment |= dict.fromkeys(_THREADS, "1")
    with tempfile.TemporaryFile() as output, tempfile.TemporaryFile() as errors:
        start = time.perf_counter()
        process = subprocess.Popen(
            [sys.executable, *arguments], env=environment, cwd=folder, stdout=output, stderr=errors
        )
        peaks = _Peaks(process.pid)
        # processor time of descendants counts as far as they have been waited for, as every pool does with its own
        _, status, usage = os.wait4(process.pid, 0)
        wall = time.perf_counter() - start
        process.returncode = os.waitstatus_to_exitcode(status)
        resident, anonymous, file = peaks.end()
        output.seek(0), errors.seek(0)
        text, said = (stream.read().decode("utf-8", "replace") for stream in (output, errors))
    if process.returncode:
        sys.stderr.write(said)
        raise subprocess.CalledProcessError(process.returncode, [*map(str, arguments)], text, said)
    return Usage(usage.ru_utime + usage.ru_stime, wall, resident, anonymous, file, text)


class _Peaks:
    """Largest sums of memory over a process and its descendants, from samples of /proc in a thread."""

    def __init__(self, pid: int) -> None:
        self._pid, self._ended = pid, threading.Event()
        self._highest = self._resident = self._anonymous = self._file = 0
        self._thread = threading.Thread(target=self._watch, daemon=True)
        self._thread.start()

    def end(self) -> tuple[float, float, float]:
        self._ended.set()
        self._thread.join()
        return max(self._resident, self._highest) / 1e3, self._anonymous / 1e3, self._file / 1e3

    def _watch(self) -> None:
        while not self._ended.wait(INTERVAL_S):
            family = _family(self._pid)
            found = [memory(pid) for pid in family]
            self._resident = max(self._resident, sum(one["VmRSS"] for one in found))
            self._anonymous = max(self._anonymous, sum(one["RssAnon"] for one in found))
            self._file = max(self._file, sum(one["RssFile"] + one["RssShmem"] for one in found))
            self._highest = max([self._highest, *(one["VmHWM"] for one in found)])


def memory(pid: int | str = "self") -> dict[str, int]:
    """Memory of a process by kind, kB; zeros of one that has ended."""
    try:
        text = Path(f"/proc/{pid}/status").read_text()
    except OSError:
        text = ""
    lines = dict(line.split(":", 1) for line in text.splitlines())
    return {kind: int(lines[kind].split()[0]) if kind in lines else 0 for kind in _KINDS}


def _command(pid: int | str) -> bytes:
    try:
        return Path(f"/proc/{pid}/cmdline").read_bytes()
    except OSError:
        return b""


def _family(pid: int) -> list[int]:
    """A process and its descendants, without copies of another that still share its memory: forks, and what begins."""
    found, i = [pid], 0
    while i < len(found):
        own = _command(found[i])
        try:
            for task in os.listdir(f"/proc/{found[i]}/task"):
                children = Path(f"/proc/{found[i]}/task/{task}/children").read_text().split()
                found += [child for child in map(int, children) if _command(child) != own]
        except OSError:
            pass  # ended meanwhile
        i += 1
    return found
