"""SHA-256 of files, and the seal of those between the stages: a last line that holds the sum of all bytes before it.

HDF5 does not survive every damage to its own records: a zeroed block can make it loop for ever, and a flipped bit in a
string is a string. So the sum is compared before HDF5 sees the file. It stands behind the end that HDF5 knows of, where
other programs pass over it; those that open the file for writing cut it off.

`python -m tedm_cli.files.seal FILE` seals what another program has written or changed.
"""

from __future__ import annotations

import hashlib
import os
import sys
import threading
import time
from collections.abc import Iterator
from concurrent.futures import Future
from dataclasses import dataclass
from pathlib import Path
from typing import IO

from tedm_cli.errors import InputError
from tedm_cli.regular_file import require_regular_file

_MARK = b"\ntedm sha256 "
_HDF5 = b"\x89HDF\r\n\x1a\n"
_SEAL_BYTES = len(_MARK) + 64 + 1
_BLOCK = 1 << 20  # bytes read at once
_SAME_TICK = 10**8  # ns: two writes within may leave the same time of modification
Identity = tuple[int, int, int, int]


@dataclass(frozen=True)
class Digests:
    """What one pass over a file found.

    whole : SHA-256 of all bytes, as `sha256sum` prints it. body : SHA-256 of what is before a seal. head : the first 8
    bytes. tail : the last ones, as many as a seal has. identity : of the file that was read.
    """

    whole: str
    body: str
    head: bytes
    tail: bytes
    identity: Identity

    def refuse_unsealed(self, path: Path, hint: str) -> None:
        """Raise `InputError` unless the file is as it was sealed; `hint`: how to make it."""
        where = str(path)
        if not self.head.startswith(_HDF5):
            raise InputError("is no HDF5 file, or its beginning is damaged", where=where, hint=hint)
        if not self.tail.startswith(_MARK):
            raise InputError(
                "carries no seal: cut short, made or changed by another program, or made by an older tedm",
                where=where,
                hint=f"{hint}; if another program wrote or changed it, seal it with `python -m tedm_cli.files.seal`",
            )
        if self.tail != _seal_of(self.body):
            raise InputError("is damaged: its SHA-256 is not the one that it was sealed with", where=where, hint=hint)


_known: dict[Identity, Future[Digests]] = {}
_lock = threading.Lock()


def digests(path: Path) -> Digests:
    """Sum a file, or take what another call in this process has found or is about to find.

    Raises `OSError` where it fails, `InputError` for what is no regular file.
    """
    require_regular_file(path)
    with open(path, "rb", buffering=0) as stream:
        identity = _identity(os.fstat(stream.fileno()))
        mine: Future[Digests] = Future()
        with _lock:
            found = _known.setdefault(identity, mine)
        if found is mine:
            try:
                mine.set_result(_read(stream, identity))
            except BaseException as exc:
                mine.set_exception(exc)
            if mine.exception() is not None or time.time_ns() - identity[3] < _SAME_TICK:
                with _lock:  # what has just been written may be written again, and look the same
                    del _known[identity]
    return found.result()


def identity_of(path: Path) -> Identity:
    """Device, number, size and time of modification of the file that a path leads to now."""
    return _identity(os.stat(path))


def of_another_file(now: Identity, before: Identity) -> bool:
    """Whether a whole other file has been put in the place of one; otherwise it was written into, if they differ."""
    return now[:2] != before[:2]


def sha256_of(path: Path) -> str:
    """SHA-256 of a file; `InputError` when it cannot be read."""
    try:
        return digests(path).whole
    except OSError as exc:
        raise InputError(f"cannot be read ({exc.strerror})", where=str(path)) from None


def seal(path: Path) -> str:
    """Append the sum of an HDF5 file to it, in place of an older one. SHA-256 of all bytes that it has then."""
    with open(path, "rb+", buffering=0) as stream:
        size = os.fstat(stream.fileno()).st_size
        stream.seek(max(0, size - _SEAL_BYTES))
        if stream.read(len(_MARK)) == _MARK:
            size -= _SEAL_BYTES
        stream.seek(0)
        body = hashlib.sha256()
        for block in _blocks(stream, size):
            body.update(block)
        stream.seek(size)
        line = _seal_of(body.hexdigest())
        body.update(line)
        while line:
            line = line[stream.write(line) :]
    return body.hexdigest()


def _seal_of(sha256: str) -> bytes:
    return _MARK + sha256.encode() + b"\n"


def _identity(found: os.stat_result) -> Identity:
    return found.st_dev, found.st_ino, found.st_size, found.st_mtime_ns


def _read(stream: IO[bytes], identity: Identity) -> Digests:
    """One pass: the sum of the body goes on to that of the whole."""
    digest, head = hashlib.sha256(), b""
    for block in _blocks(stream, max(0, identity[2] - _SEAL_BYTES)):
        head = head or bytes(block[: len(_HDF5)])
        digest.update(block)
    body, tail = digest.hexdigest(), stream.read(_SEAL_BYTES)
    digest.update(tail)
    for block in _blocks(stream, None):  # what has no size beforehand, as a pipe
        digest.update(block)
    return Digests(digest.hexdigest(), body, head, tail, identity)


def _blocks(stream: IO[bytes], size: int | None) -> Iterator[memoryview]:
    """The next `size` bytes, or all; each block is overwritten by the next."""
    buffer = memoryview(bytearray(_BLOCK))
    left = sys.maxsize if size is None else size
    while left and (count := stream.readinto(buffer[:left])):  # type: ignore[attr-defined]
        yield buffer[:count]
        left -= count


def main() -> None:
    """Seal the files that the command line names."""
    for name in sys.argv[1:]:
        try:
            seal(Path(name))
        except OSError as exc:
            raise SystemExit(f"error: {name}: cannot be sealed ({exc.strerror})") from exc


if __name__ == "__main__":
    main()
