"""Which processes still run, as far as their numbers tell."""

from __future__ import annotations

import os
from pathlib import Path

_ENDED = (b"Z", b"X")


def is_alive(process: int) -> bool:
    """Whether a process of this number runs.

    One that has ended does not, though its number is taken until its parent has asked how: of a killed chain that is
    the first process of the machine, which may be slow to ask, or in a container never do it.
    """
    try:
        os.kill(process, 0)
    except (ProcessLookupError, OverflowError):
        return False
    except PermissionError:
        return True
    try:
        told = Path(f"/proc/{process}/stat").read_bytes()
    except OSError:
        return not Path("/proc/self/stat").exists()  # it ended just now, or this system keeps no such files
    return told.rpartition(b")")[2].split()[0] not in _ENDED
