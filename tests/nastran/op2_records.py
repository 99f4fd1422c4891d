"""Change an OP2 record by record: other byte order, other word length, other headers."""

from __future__ import annotations

import struct
from collections.abc import Callable
from pathlib import Path

import numpy as np

HEADER, TEXT_FROM = 584, 200  # bytes of a result header, and where its title, subtitle and label begin

# Words of a result header, counted from zero.
APPROACH, TABLE_CODE, SUBCASE, WIDE, THERMAL = 0, 1, 3, 9, 22


def records(data: bytes) -> list[bytes]:
    """Payloads of the Fortran records of a 32-bit little-endian file."""
    out, at = [], 0
    while at < len(data):
        (size,) = struct.unpack_from("<i", data, at)
        out.append(data[at + 4 : at + 4 + size])
        at += size + 8
    return out


def join(payloads: list[bytes], order: str = "<") -> bytes:
    return b"".join(struct.pack(f"{order}i", len(p)) + p + struct.pack(f"{order}i", len(p)) for p in payloads)


def edit(path: Path, change: Callable[[list[bytes]], list[bytes]]) -> None:
    path.write_bytes(join(change(records(path.read_bytes()))))


def set_words(words: dict[int, int], *, subcase: int | None = None) -> Callable[[list[bytes]], list[bytes]]:
    """Put these words into the headers (of one subcase, or of all)."""

    def change(payloads: list[bytes]) -> list[bytes]:
        out = []
        for payload in payloads:
            if len(payload) == HEADER:
                header = np.frombuffer(payload, "<i4").copy()
                if subcase is None or header[SUBCASE] == subcase:
                    for word, value in words.items():
                        header[word] = value
                payload = header.tobytes()
            out.append(payload)
        return out

    return change


def set_text(field: int, text: str) -> Callable[[list[bytes]], list[bytes]]:
    """Replace title (0), subtitle (1) or label (2) of all headers."""

    def change(payloads: list[bytes]) -> list[bytes]:
        at = TEXT_FROM + 128 * field
        new = text.encode().ljust(128)
        return [p[:at] + new + p[at + 128 :] if len(p) == HEADER else p for p in payloads]

    return change


def rename(table: str) -> Callable[[list[bytes]], list[bytes]]:
    """Give the displacement table another name."""
    return lambda payloads: [
        p.replace(b"OUGV1   ", table.encode().ljust(8)) if p.startswith(b"OUGV1") else p for p in payloads
    ]


def converted(
    data: bytes, *, order: str = "<", word: int = 4, version: bytes | None = None, dense: bool = False
) -> bytes:
    """The same results in another byte order and word length (4 or 8).

    Text of 64-bit files has 4 characters to the word, or (`dense`, but for the words that begin the file) 8 and blanks
    behind. `version`: 8 characters in place of those of MSC.
    """

    def integers(payload: bytes) -> bytes:
        return np.frombuffer(payload, "<i4").astype(f"{order}i{word}").tobytes()

    def text(payload: bytes) -> bytes:
        return payload if word == 4 else b"".join(payload[i : i + 4].ljust(8) for i in range(0, len(payload), 4))

    def name(payload: bytes) -> bytes:
        return payload.ljust(len(payload) * 2) if dense else text(payload)

    out, rows = [], False
    for payload in records(data):
        size = len(payload)
        printable = payload[:8].isascii() and payload[:5].strip().isalnum()
        if size == HEADER:
            fields = (payload[i : i + 128] for i in range(TEXT_FROM, HEADER, 128))
            out.append(integers(payload[:TEXT_FROM]) + b"".join(name(f) for f in fields))
            rows = True
            continue
        if rows and size % 32 == 0:
            whole = np.frombuffer(payload, "<i4").reshape(-1, 8)
            real = np.frombuffer(payload, "<f4").reshape(-1, 8)
            row = np.zeros(len(whole), np.dtype([("i", f"{order}i{word}", 2), ("f", f"{order}f{word}", 6)]))
            row["i"], row["f"] = whole[:, :2], real[:, 2:]
            out.append(row.tobytes())
        elif payload.startswith(b"NASTRAN FORT"):
            out.append(text(payload))
        elif size == 8 and printable:
            out.append(text((version or payload).ljust(8)) if payload.startswith(b"XXXX") else name(payload))
        elif size == 28 and printable:
            out.append(name(payload[:8]) + integers(payload[8:]))
        else:
            out.append(integers(payload))
        if size > 4:
            rows = False
    return join(out, order)
