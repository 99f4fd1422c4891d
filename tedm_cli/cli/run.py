"""Run the command line, and turn whatever ends it badly into one message and an exit code."""

from __future__ import annotations

import gc
import sys
import traceback
from typing import Any

from tedm_cli.cli.streams import OutputLostError, answers, open_all, refusal_lines, tell
from tedm_cli.errors import InputError, TedmError, UsageError
from tedm_cli.interrupts import Interrupts, leave_if_threads_run

_KEPT = "finished files are kept, the unfinished one is removed"
_SELDOM = (200_000, 50, 1000)  # objects and rounds between searches for garbage in cycles; figures leave most of it


def collect_seldom() -> None:
    """Let Python search for garbage in cycles less often, for as long as this process lives."""
    gc.set_threshold(*_SELDOM)


def run() -> None:
    """Run the command; turn expected failures into one message and an exit code (see `tedm_cli.errors`)."""
    collect_seldom()
    open_all()
    code, told = 1, [""]
    interrupts = Interrupts()
    try:
        with interrupts:
            code, told = outcome()
        if interrupts.number is not None:
            code, told = 128 + interrupts.number, [f"error: interrupted; {_KEPT}"]
        tell(told)
        if interrupts.number is not None:
            leave_if_threads_run(code)
    finally:
        interrupts.release()
    sys.exit(code)


def outcome() -> tuple[int, list[str]]:
    """Exit code of the command in `sys.argv`, and what is to be said on standard error."""
    with answers():
        try:
            # Imported here, so that an interrupt in the meantime is heeded.
            from tedm_cli.cli.commands import command_line

            # Typer's own handling of errors is off: it answers in another form, and says nothing of an interrupt.
            code = command_line()(sys.argv[1:] or ["--help"], prog_name="tedm", standalone_mode=False)
            sys.stdout.flush()
            return (code if isinstance(code, int) else 0), []
        except TedmError as exc:
            return _failed(exc)
        except OutputLostError as exc:
            fact = f"cannot be written ({getattr(exc.__cause__, 'strerror', '')}); finished files are kept"
            return _failed(InputError(fact, where="standard output"))
        except OSError as exc:  # of a file that no stage expected to fail
            where = "" if exc.filename is None else str(exc.filename)
            return _failed(InputError(exc.strerror or str(exc), where=where, hint="-vv shows where it happened"))
        except Exception as exc:
            known = _usage_error(exc) or _name_error(exc)
            if known is not None:
                return _failed(known)
            told = traceback.format_exc().splitlines() if _verbosity() >= 2 else []
            told.append(f"error: internal fault: {type(exc).__name__}: {exc}")
            return 1, [*told, "hint: this is a defect of tedm; run again with -vv and report the traceback"]


def _usage_error(exc: Exception) -> UsageError | None:
    """Typer's complaints: unknown options and commands, missing arguments."""
    import typer

    kind: Any = typer.BadParameter.__base__
    if not isinstance(exc, kind):
        return None
    context = getattr(exc, "ctx", None)
    path = context.command_path if context is not None else "tedm"
    return UsageError(exc.format_message().rstrip("."), hint=f"see `{path} --help`")


def _name_error(exc: Exception) -> InputError | None:
    """Names whose bytes are no UTF-8, which Python keeps as halves of characters, where they have to be written."""
    if not isinstance(exc, UnicodeEncodeError) or not any("\udc80" <= c <= "\udcff" for c in exc.object):
        return None
    return InputError("a name that is not in UTF-8", where=exc.object, hint="rename the file or its folder")


def _failed(exc: TedmError) -> tuple[int, list[str]]:
    # The traceback ends with the hint, which follows.
    told = traceback.format_exc().rstrip().removesuffix(f"\nhint: {exc.hint}").splitlines() if _verbosity() >= 2 else []
    return exc.exit_code, [*told, *refusal_lines(exc)]


def _verbosity() -> int:
    from tedm_cli.cli.app import verbosity

    return verbosity()
