"""What a stage keeps on disk while it works, and no longer."""

from __future__ import annotations

import contextlib
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import IO

from tedm_cli.files.store import cannot_write


@contextlib.contextmanager
def scratch_file(path: Path) -> Iterator[IO[bytes]]:
    """A nameless file in the folder of `path`, the file that is being made; gone at the end, however that comes.

    Raises
    ------
    InputError : it cannot be written, for want of room for instance; names `path`.
    """
    try:
        with tempfile.TemporaryFile(dir=path.parent) as file:
            yield file
    except OSError as exc:
        raise cannot_write(path, exc) from exc
