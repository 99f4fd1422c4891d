"""HDF5 files of other programs carry no seal, and a damaged one can make the library loop for ever or end the process.

So such a file is read once from end to end in a process of its own that may take some time and no more, before this one
opens it.
"""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

from tedm_cli.errors import InputError

SECONDS = 60.0  # for the start of Python and the reading of a small file
BYTES_PER_SECOND = 10e6  # of a slow disk, for a large one
REFUSED = 4  # exit code of a trial that came to an end, and found something to refuse


def trial(module: str, path: Path, *words: str, size: int, hint: str) -> bytes:
    """What `python -m module PATH WORDS` prints of a file of `size` bytes.

    A trial that ends with `REFUSED` has come to an end too: whoever asked reads the file again, and finds the reason.

    Raises
    ------
    InputError : it does not end in time, or ends in another way than its own.
    """
    seconds = SECONDS + size / BYTES_PER_SECOND
    command = [sys.executable, "-m", module, str(path), *words]
    try:
        done = subprocess.run(command, stdin=subprocess.DEVNULL, capture_output=True, timeout=seconds, check=False)
    except subprocess.TimeoutExpired as exc:
        fact = f"cannot be read within {seconds:.0f} s: the file is damaged, or its disk hangs"
        raise InputError(fact, where=str(path), hint=hint) from exc
    if done.returncode not in (0, REFUSED):
        why = f"signal {-done.returncode}" if done.returncode < 0 else f"exit code {done.returncode}"
        fact = f"cannot be read, the file is damaged (a process that tried ended with {why})"
        raise InputError(fact, where=str(path), hint=hint)
    return done.stdout
