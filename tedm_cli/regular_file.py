"""Inputs are regular files: a pipe would be waited for without end, and nothing can be read from it twice."""

from __future__ import annotations

import stat
from pathlib import Path

from tedm_cli.errors import InputError

_KINDS = {
    stat.S_IFIFO: "a pipe (FIFO)",
    stat.S_IFCHR: "a device",
    stat.S_IFBLK: "a device",
    stat.S_IFSOCK: "a socket",
    stat.S_IFDIR: "a folder",
}


def require_regular_file(path: Path, *, named_at: str = "") -> None:
    """Refuse a path to what is there and is no regular file, before it is opened; what is missing its reader tells.

    `named_at`: the place of the INCLUDE that names it, if one does.

    Raises
    ------
    InputError : a pipe, device, socket or folder.
    """
    try:
        kind = stat.S_IFMT(path.stat().st_mode)
    except (OSError, ValueError):
        return
    if kind != stat.S_IFREG:
        fact = f"is {_KINDS.get(kind, 'something')}, not a regular file"
        raise InputError(
            f"INCLUDE of {path}, which {fact}" if named_at else fact,
            where=named_at or str(path),
            hint="inputs are read more than once: save its content as a file and give the name of this file",
        )
