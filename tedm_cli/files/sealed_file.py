"""HDF5 files of which the seal has been compared: HDF5 sees no other."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import h5py

from tedm_cli.errors import InputError
from tedm_cli.files.seal import digests, identity_of, of_another_file

NO_CACHE = 0  # chunks are read and written whole: HDF5's cache of them would only copy them once more
_REPLACED = 20  # times that a file may be replaced between its sum and its opening, before we give up


@contextlib.contextmanager
def sealed(path: Path, hint: str) -> Iterator[tuple[Any, str]]:
    """A file that is as it was sealed, open for reading, and its SHA-256; HDF5 sees no other."""
    where = str(path)
    try:
        file, sha256 = _opened(path, hint)
    except FileNotFoundError:
        raise InputError("no such file", where=where, hint=hint) from None
    except OSError as exc:
        raise InputError(f"cannot be read ({exc.strerror or exc})", where=where, hint=hint) from None
    with file:
        yield file, sha256


def _opened(path: Path, hint: str) -> tuple[Any, str]:
    """As `_sealed`: where another run of a command puts a new file in its place meanwhile, that one is taken."""
    for _ in range(_REPLACED):
        summed = digests(path)
        summed.refuse_unsealed(path, hint)
        file = h5py.File(path, "r", rdcc_nbytes=NO_CACHE)
        now = identity_of(path)
        if now == summed.identity:
            return file, summed.whole
        file.close()
        if not of_another_file(now, summed.identity):
            break
    raise InputError("was changed while it was read", where=str(path), hint="run again when nothing writes it")
