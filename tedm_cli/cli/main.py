"""Run the command line, and turn whatever ends it badly into one message and an exit code."""

from __future__ import annotations

import os
import sys
import traceback
from typing import Any, NoReturn

import typer

from tedm_cli.cli.app import app, verbosity
from tedm_cli.cli.refusal import print_refusal
from tedm_cli.errors import TedmError, UsageError

_INTERRUPTED = 130
_TyperUsageError: Any = typer.BadParameter.__base__  # unknown options and commands, missing arguments


def main() -> None:
    """Run the command; turn expected failures into one message and an exit code (see `tedm_cli.errors`)."""
    try:
        # Typer's own handling of errors is off: it answers in another form, and says nothing of an interrupt.
        code = app(sys.argv[1:] or ["--help"], prog_name="tedm", standalone_mode=False)
        sys.stdout.flush()
        if code == _INTERRUPTED:
            raise KeyboardInterrupt
        sys.exit(code)
    except _TyperUsageError as exc:
        context = getattr(exc, "ctx", None)
        path = context.command_path if context is not None else "tedm"
        _fail(UsageError(exc.format_message().rstrip("."), hint=f"see `{path} --help`"))
    except TedmError as exc:
        _fail(exc)
    except KeyboardInterrupt:
        print("error: interrupted; finished files are kept, the unfinished one is removed", file=sys.stderr)
        sys.exit(_INTERRUPTED)
    except BrokenPipeError:
        # Whoever reads our output has left: what is still buffered must not raise a second time on leaving.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        sys.exit(1)
    except Exception as exc:
        if verbosity() >= 2:
            traceback.print_exc()
        print(f"error: internal fault: {type(exc).__name__}: {exc}", file=sys.stderr)
        print("hint: this is a defect of tedm; run again with -vv and report the traceback", file=sys.stderr)
        sys.exit(1)


def _fail(exc: TedmError) -> NoReturn:
    """Print the refusal, and leave with its exit code."""
    if verbosity() >= 2:
        traceback.print_exc()
    print_refusal(exc)
    sys.exit(exc.exit_code)
