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

from tedm_cli.errors import InputError, UsageError
from tedm_cli.files.store import replacing
from tedm_cli.nastran.geometry import id_list
from tedm_cli.nastran.op2.reader import open_op2
from tedm_cli.nastran.reading import read_deck

_PATIENCE_S = 5.0  # between the request to end and the order to
_FATAL = re.compile(r"\b(USER|SYSTEM|PROGRAM)?\s*FATAL (MESSAGE|ERROR)\b|^\s*\*ERROR\b")
_MARK = "{deck}"
_State = dict[Path, tuple[int, int, int]]


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
    text: str, deck: Path, op2: Path, say: Callable[[str], None], *, allow_missing_enddata: bool = False
) -> int:
    """Run the command `text` in the deck's folder and bring its OP2 to `op2`.

    Parameters
    ----------
    text : command with `{deck}`; what it prints goes to `say`, line by line.
    deck : unit-load deck. op2 : where the results go; replaced only by results of this run that hold all subcases.

    Returns
    -------
    Number of subcases in the results.

    Raises
    ------
    UsageError : see `command_of`.
    InputError : no such deck; the solver fails, or its F06 says FATAL; no OP2, one that is older than the run, or one
        that lacks subcases.
    KeyboardInterrupt : after the solver and all its processes were ended.
    """
    wanted = _subcases(deck, allow_missing_enddata)
    command = command_of(text, deck)
    with _kept_aside(op2):
        newest = _new_results(command, deck, op2, say)
        with open_op2(newest) as (tables, _):
            missing = sorted(wanted - {table.subcase for table in tables})
        if missing:
            raise InputError(
                f"lacks {len(missing)} of {len(wanted)} subcases: {id_list(missing)}",
                where=str(newest),
                hint="did the solver stop early? is its disk full?",
            )
    if newest.resolve() != op2.resolve():
        with replacing(op2) as temporary:
            shutil.copyfile(newest, temporary)
        newest.unlink()
    return len(wanted)


@contextlib.contextmanager
def _kept_aside(op2: Path) -> Iterator[None]:
    """Keep the results of the last run while another one may write over them, and put them back when it fails."""
    old, failed = op2.with_name(op2.name + ".before"), op2.with_name(op2.name + ".failed")
    if op2.is_file():
        op2.replace(old)
    try:
        yield
    except BaseException:
        if op2.is_file():
            op2.replace(failed)
        if old.is_file():
            old.replace(op2)
        raise
    if op2.is_file():
        old.unlink(missing_ok=True)
    elif old.is_file():
        old.replace(op2)


def _new_results(command: list[str], deck: Path, op2: Path, say: Callable[[str], None]) -> Path:
    """Run the command; the newest OP2 that it has made."""
    before = {**_outputs(deck, ".op2"), **_outputs(deck, ".f06"), **_state([op2])}
    code, last = _run(command, deck.parent, say)
    fatal = _fatal_lines(_changed(_outputs(deck, ".f06"), before))
    if code or fatal:
        fact = f"exit code {code}" if code else "a FATAL message"
        said = "; ".join(fatal) or last
        raise InputError(
            f"{command[0]} ended with {fact}" + (f": {said}" if said else " and said nothing"),
            where=str(deck),
            hint="see its F06 and log in the folder of the deck; -v shows what it prints",
        )
    results = _changed({**_outputs(deck, ".op2"), **_state([op2])}, before)
    if not results:
        old = [str(p) for p in before if p.suffix.lower() == ".op2"]
        raise InputError(
            f"{command[0]} ended without a new OP2" + (f"; {', '.join(old)} is from before the run" if old else ""),
            where=str(deck),
            hint="the command has to wait for the solver (MSC Nastran: batch=no) and leave the OP2 beside the deck",
        )
    return max(results, key=lambda path: path.stat().st_mtime_ns)


def _subcases(deck: Path, allow_missing_enddata: bool) -> set[int]:
    model = read_deck(deck, cross_reference=False, allow_missing_enddata=allow_missing_enddata)
    control = model.case_control_deck
    return set() if control is None else {int(n) for n in control.subcases if n != 0}


def _outputs(deck: Path, suffix: str) -> _State:
    """Files of the deck's name with this ending, in either case; solvers on Windows write capitals, some lower them."""
    names = (p for p in deck.parent.iterdir() if p.suffix.lower() == suffix)
    return _state([p for p in names if p.stem.lower() == deck.stem.lower()])


def _state(paths: list[Path]) -> _State:
    stats = [(p, p.stat()) for p in paths if p.is_file()]
    return {p: (s.st_mtime_ns, s.st_size, s.st_ino) for p, s in stats}


def _changed(now: _State, before: _State) -> list[Path]:
    return [path for path, state in now.items() if before.get(path) != state]


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
    try:
        # In a session of its own, so that the programs it starts can be ended with it.
        child = subprocess.Popen(
            command,
            cwd=folder,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            start_new_session=True,
        )
    except OSError as exc:
        raise UsageError(f"--run: {command[0]!r} cannot be started ({exc.strerror})") from exc
    assert child.stdout is not None
    last: deque[str] = deque(maxlen=1)
    reader = threading.Thread(target=_listen, args=(child.stdout, last, say), daemon=True)
    reader.start()
    with _ended_with_us(child):
        code = child.wait()
    reader.join(_PATIENCE_S)  # a program left in the background may hold the pipe
    return code, last[0] if last else ""


def _listen(stream: IO[bytes], last: deque[str], say: Callable[[str], None]) -> None:
    for raw in stream:
        line = raw.decode("utf-8", errors="replace").rstrip()
        if line:
            last.append(line)
            say(line)


@contextlib.contextmanager
def _ended_with_us(child: subprocess.Popen[bytes]) -> Iterator[None]:
    """End the child and its whole process group when this process is interrupted or told to end."""

    def leave(number: int, frame: object) -> None:
        sys.exit(128 + number)

    before = signal.signal(signal.SIGTERM, leave)
    try:
        yield
    except BaseException:
        for number in (signal.SIGTERM, signal.SIGKILL):
            with contextlib.suppress(ProcessLookupError, PermissionError):
                os.killpg(child.pid, number)
            with contextlib.suppress(subprocess.TimeoutExpired):
                child.wait(_PATIENCE_S)
        raise
    finally:
        signal.signal(signal.SIGTERM, before)
