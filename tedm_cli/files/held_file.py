"""The file under HDF5 when we write: a failure is held back until HDF5 is out of the way."""

from __future__ import annotations

import io
from pathlib import Path
from typing import Protocol

from tedm_cli.interrupts import whole


class Sink(Protocol):
    """What a file is written to: whoever writes asks it, often enough, whether that has failed."""

    def check(self) -> None:
        """Raise what went wrong, if anything did."""


class HeldFile(io.RawIOBase):
    """A new binary file that never fails towards its user.

    The HDF5 library does not survive a write that fails: it can neither close the file nor end the process in order.
    So the first failure (a full disk, an interrupt) is kept for `check`, and what is written from then on is held in
    memory, where HDF5 finds it again. Whoever writes calls `check` often enough for that to be little. An interrupt
    waits until HDF5 is done with the file (`whole`); where no one sees to that, it is kept like a failure.
    """

    def __init__(self, path: Path) -> None:
        self._file = open(path, "w+b", buffering=0)  # noqa: SIM115 (closed by `close`)
        self._failure: BaseException | None = None
        self._held: list[tuple[int, bytes]] = []
        self._place = 0
        self._size = 0

    def check(self) -> None:
        """Raise what went wrong, if anything did."""
        if self._failure is not None:
            raise self._failure

    @whole
    def write(self, data: object) -> int:
        view = memoryview(data).cast("B")  # type: ignore[arg-type]
        start, done = self._place, 0
        while done < len(view) and self._failure is None:
            try:
                self._file.seek(start + done)
                done += self._file.write(view[done:])
            except BaseException as exc:
                self._failure = exc
        if done < len(view):
            self._held.append((start + done, bytes(view[done:])))
        self._place = start + len(view)
        self._size = max(self._size, self._place)
        return len(view)

    @whole
    def readinto(self, buffer: object) -> int:
        view = memoryview(buffer).cast("B")  # type: ignore[arg-type]
        start, wanted = self._place, max(0, min(len(view), self._size - self._place))
        self._file.seek(start)
        found = self._file.read(wanted) or b""
        view[:wanted] = found + bytes(wanted - len(found))
        for place, data in self._held:
            low, high = max(place, start), min(place + len(data), start + wanted)
            if low < high:
                view[low - start : high - start] = data[low - place : high - place]
        self._place = start + wanted
        return wanted

    @whole
    def seek(self, offset: int, whence: int = io.SEEK_SET) -> int:
        self._place = offset + (0, self._place, self._size)[whence]
        return self._place

    @whole
    def tell(self) -> int:
        return self._place

    @whole
    def truncate(self, size: int | None = None) -> int:
        self._size = self._place if size is None else size
        try:
            if self._failure is None:
                self._file.truncate(self._size)
        except BaseException as exc:
            self._failure = exc
        return self._size

    def readable(self) -> bool:
        return True

    def writable(self) -> bool:
        return True

    def seekable(self) -> bool:
        return True

    def close(self) -> None:
        self._file.close()
        super().close()
