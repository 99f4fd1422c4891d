"""The command line: load the configuration, call one stage, say what came out. All physics is in the configuration."""

import signal
import sys
import threading

_WINDOWS = """\
error: tedm needs the signals and process groups of Linux or macOS, which Windows does not have
hint: install it in the Windows Subsystem for Linux (WSL 2); see "Installation" in the documentation"""


def main() -> None:
    """Run the command in `sys.argv`, and leave with its exit code."""
    if not hasattr(signal, "SIGALRM"):
        print(_WINDOWS, file=sys.stderr)
        sys.exit(2)
    handler = signal.getsignal(signal.SIGINT)
    quiet = handler is signal.default_int_handler and threading.current_thread() is threading.main_thread()
    if quiet:
        signal.signal(signal.SIGINT, signal.SIG_DFL)  # nothing has begun: no traceback of what is being imported
    try:
        from tedm_cli.cli.run import run
    finally:
        if quiet:
            signal.signal(signal.SIGINT, handler)
    run()


__all__ = ["main"]
