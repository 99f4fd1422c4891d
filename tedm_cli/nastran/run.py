"""Run the user's own Nastran on a deck, and take its results only when they are new, whole and not after a FATAL."""

from __future__ import annotations

import contextlib
import os
import re
import shlex
import shutil
import signal
import subprocess
import sys
import threading
from collections import deque
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import IO

from tedm_cli.deck_units import SI, DeckUnits
from tedm_cli.errors import InputError, UsageError
from tedm_cli.files.processes import is_alive
from tedm_cli.files.store import replacing
from tedm_cli.interrupts import whole
from tedm_cli.nastran.geometry import id_list
from tedm_cli.nastran.reading import read_deck
from tedm_cli.nastran.result_files import open_result_file

_PATIENCE_S = 5.0  # between the request to end and the order to
_FATAL = re.compile(r"\b(USER|SYSTEM|PROGRAM)?\s*FATAL (MESSAGE|ERROR)\b|^\s*\*ERROR\b")
_BLANK_SOLID = re.compile(r"PSOLID ENTRY HAD FIELD FOR \w+ BLANK")  # of MYSTRAN, which has no bubble functions
_MARK = "{deck}"
_FAILED = ".failed"  # behind the name of results that are not taken
OP2, _HDF5 = ".op2", ".h5"
_NAMES = {OP2: "OP2", _HDF5: "HDF5"}
_NOT_OURS = ".msc.h5"  # of an HDF5 beside a deck, whose own name would be that of a file of ours
_RUN = "_tedmrun"  # between a deck's name and the number of the process, in the names of a run's files


def command_of(text: str, deck: Path) -> list[str]:
    """Arguments of the user's command, without a shell; `{deck}` becomes the deck's file name.

    Raises
    ------
    UsageError : quotes that do not close, no `{deck}`, no such program.
    """
    try:
        words = shlex.split(text)
    except ValueError as exc:
        raise UsageError(f"--run {text!r}: {exc}") from exc
    if not any(_MARK in word for word in words):
        raise UsageError(f"--run {text!r} does not name the deck", hint='for example --run "nastran {deck} scr=yes"')
    if shutil.which(words[0]) is None:
        raise UsageError(f"--run: there is no program {words[0]!r} on the PATH", hint="give its whole path")
    program = str(Path(words[0]).absolute()) if os.path.sep in words[0] else words[0]  # the run has another folder
    return [program, *(word.replace(_MARK, deck.name) for word in words[1:])]


def run_nastran(
    text: str,
    deck: Path,
    target: Path,
    say: Callable[[str], None],
    *,
    allow_missing_enddata: bool = False,
    units: DeckUnits = SI,
) -> int:
    """Run the command `text` in the deck's folder and bring its results to `target`.

    The solver gets the deck under a name of this run, so that its files are known from all others. They take the
    deck's name when it has ended. Its OP2, or where `target` ends in .h5 its HDF5, takes the name `target` only when it
    has been found whole.

    Parameters
    ----------
    text : command with `{deck}`; what it prints goes to `say`, line by line.
    deck : unit-load deck. target : where the results go; replaced only by results of this run that hold all subcases.

    Returns
    -------
    Number of subcases in the results.

    Raises
    ------
    UsageError : see `command_of`.
    InputError : no such deck; the solver fails, or its F06 says FATAL; no results, or some that lack subcases.
    KeyboardInterrupt : after the solver and all its processes were ended, and what they left was removed.
    """
    wanted = _subcases(deck, allow_missing_enddata, units)
    kind = results_suffix(target)
    with _run_files(deck, kind) as own:
        results = _new_results(command_of(text, own), own, deck, kind, say)
        failed = str(deck.with_name(deck.stem + _ending(results.suffix, kind)))  # its name if it is not taken
        try:
            with open_result_file(results) as (tables, _):
                missing = sorted(wanted - {table.subcase for table in tables})
        except InputError as exc:
            raise InputError(exc.fact, where=exc.where.replace(str(results), failed), hint=exc.hint) from exc
        if missing:
            raise InputError(
                f"lacks {len(missing)} of {len(wanted)} subcases: {id_list(missing)}",
                where=failed,
                hint="did the solver stop early? is its disk full?",
            )
        with replacing(target) as temporary:
            shutil.move(results, temporary)
    return len(wanted)


def results_suffix(target: Path) -> str:
    """Ending of the solver's file that is asked for by the name of where it goes."""
    return _HDF5 if target.suffix.lower() == _HDF5 else OP2


@contextlib.contextmanager
@whole
def _run_files(deck: Path, kind: str) -> Iterator[Path]:
    """The deck under the name of this run; what the solver leaves beside it takes the deck's name in the end.

    Results that are still there are not taken: they end in `.failed`. What a killed run has left is removed.
    """
    stem = f"{deck.stem}{_RUN}{os.getpid()}"
    for path, number in _of_runs(deck):
        if number == os.getpid() or not is_alive(number):
            path.unlink(missing_ok=True)
    own = deck.with_name(stem + deck.suffix)
    try:
        os.link(deck, own)
    except OSError:  # a file system without links
        shutil.copyfile(deck, own)
    try:
        yield own
    except KeyboardInterrupt:
        for path, number in _of_runs(deck):
            if number == os.getpid():
                path.unlink(missing_ok=True)
        raise
    finally:
        own.unlink(missing_ok=True)
        for path, number in _of_runs(deck):
            if number == os.getpid():
                path.replace(deck.with_name(deck.stem + _ending(path.name[len(stem) :], kind)))


def _ending(end: str, kind: str) -> str:
    if end.lower() == _HDF5:
        return _NOT_OURS + _FAILED * (kind == _HDF5)
    return end + _FAILED * (end.lower() == kind)


def _of_runs(deck: Path) -> list[tuple[Path, int]]:
    """Files of runs of this deck and the process that each belongs to; solvers change the case of names."""
    name = re.compile(re.escape(deck.stem + _RUN) + r"(\d+)(?!\d).*", re.IGNORECASE)
    found = ((path, name.fullmatch(path.name)) for path in deck.parent.iterdir() if path.is_file())
    return [(path, int(match[1])) for path, match in found if match]


def _new_results(command: list[str], own: Path, deck: Path, kind: str, say: Callable[[str], None]) -> Path:
    """Run the command; the results of this kind that it has made."""
    code, last = _run(command, deck.parent, say)
    fatal = _fatal_lines(_outputs(own, ".f06"))
    if code or fatal:
        fact = f"exit code {code}" if code else "a FATAL message"
        said = "; ".join(fatal) or last
        solids = "give every PSOLID of the model IN = TWO and ISOP = FULL, as PSOLID,1,1,,TWO,,FULL; "
        raise InputError(
            f"{command[0]} ended with {fact}" + (f": {said}" if said else " and said nothing"),
            where=str(deck),
            hint=solids
            * bool(_BLANK_SOLID.search(said))
            + f"its F06 and log are left beside the deck as {deck.stem}.*, for you to read and delete; -v shows what it"
            " prints",
        )
    results = _outputs(own, kind)
    if not results:
        old, name = deck.with_name(deck.stem + _ending(kind, "")), _NAMES[kind]
        asked = "; MDLPRM,HDF5 in the deck asks for it" if kind == _HDF5 else ""
        raise InputError(
            f"{command[0]} ended without a new {name}" + (f"; {old} is from before the run" if old.exists() else ""),
            where=str(deck),
            hint="the command has to wait for the solver (MSC Nastran: batch=no), give it {deck}, whose name is new in"
            f" every run, and leave the {name} beside the deck{asked}",
        )
    return max(results, key=lambda path: path.stat().st_mtime_ns)


def _subcases(deck: Path, allow_missing_enddata: bool, units: DeckUnits) -> set[int]:
    model = read_deck(deck, cross_reference=False, allow_missing_enddata=allow_missing_enddata, units=units)
    control = model.case_control_deck
    return set() if control is None else {int(n) for n in control.subcases if n != 0}


def _outputs(own: Path, suffix: str) -> list[Path]:
    """Files of the deck's name with this ending, in either case; solvers on Windows write capitals, some lower them."""
    names = (p for p in own.parent.iterdir() if p.suffix.lower() == suffix)
    return [p for p in names if p.stem.lower() == own.stem.lower()]


def _fatal_lines(f06: list[Path]) -> list[str]:
    """The first FATAL message of the run, with the two lines that explain it."""
    for path in f06:
        lines = path.read_text(encoding="latin-1").splitlines()
        first = next((i for i, line in enumerate(lines) if _FATAL.search(line)), None)
        if first is not None:
            told = [" ".join(line.split()).strip("*^ ") for line in lines[first : first + 8] if line.strip()]
            return told[:3]
    return []


def _run(command: list[str], folder: Path, say: Callable[[str], None]) -> tuple[int, str]:
    """Exit code of the command and the last line it printed."""

    def start() -> subprocess.Popen[bytes]:
        try:
            # In a session of its own, so that the programs it starts can be ended with it.
            return subprocess.Popen(
                command,
                cwd=folder,
                stdin=subprocess.DEVNULL,
                stdout=subprocess.PIPE,
                stderr=subprocess.STDOUT,
                start_new_session=True,
            )
        except OSError as exc:
            raise UsageError(f"--run: {command[0]!r} cannot be started ({exc.strerror})") from exc

    last: deque[str] = deque(maxlen=1)
    with _ending_with_us(start) as child:
        assert child.stdout is not None
        reader = threading.Thread(target=_listen, args=(child.stdout, last, say), daemon=True)
        reader.start()
        code = child.wait()
    reader.join(_PATIENCE_S)  # a program left in the background may hold the pipe
    return code, last[0] if last else ""


def _listen(stream: IO[bytes], last: deque[str], say: Callable[[str], None]) -> None:
    for raw in stream:
        line = raw.decode("utf-8", errors="replace").rstrip()
        if line:
            last.append(line)
            say(line)


# Ends the process group that it reads of, when whoever wrote it is gone without saying that all is done.
_GUARD = """
import os, signal, sys, time
group, _, said = sys.stdin.read().partition(" ")
if group and not said:
    for number in (signal.SIGTERM, signal.SIGKILL):
        try:
            os.killpg(int(group), number)
        except OSError:
            break
        time.sleep(%r)
"""


@contextlib.contextmanager
@whole
def _ending_with_us(start: Callable[[], subprocess.Popen[bytes]]) -> Iterator[subprocess.Popen[bytes]]:
    """A child that is ended with its whole process group when the block is left early, or this process is killed.

    The latter is seen to by a process of its own that waits for the end of a pipe: it is told nothing else by a process
    that is gone, on any system.
    """
    guard = subprocess.Popen(
        [sys.executable, "-I", "-S", "-c", _GUARD % _PATIENCE_S],
        stdin=subprocess.PIPE,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        start_new_session=True,
    )
    assert guard.stdin is not None
    try:
        child = start()
        guard.stdin.write(str(child.pid).encode())
        guard.stdin.flush()
        try:
            yield child
        except BaseException:
            for number in (signal.SIGTERM, signal.SIGKILL):
                with contextlib.suppress(ProcessLookupError, PermissionError):
                    os.killpg(child.pid, number)
                with contextlib.suppress(subprocess.TimeoutExpired):
                    child.wait(_PATIENCE_S)
            raise
    finally:
        with contextlib.suppress(OSError):
            guard.stdin.write(b" done")
            guard.stdin.close()
        guard.wait()
