"""What goes wrong with result files: damage of bytes, of records, of counts, of words, and of what they mean."""

from __future__ import annotations

import struct
from collections.abc import Callable
from random import Random

import numpy as np
from fuzz_text import Mutation

BINARY: dict[str, Mutation] = {}
_HEADER = 584
_COUNTS = (0, -1, 1, 2, 3, 4, 8, 12, 584, 583, 4096, 2**31 - 1, -(2**31), 2**30, -4, -584)
_WORDS = (0, -1, 1, 2, 3, 10, 11, 101, 1001, 2001, 2**31 - 1, -(2**31), 9_000_011, 14)
_FLOATS = (float("nan"), float("inf"), -float("inf"), 1e-45, 3.4e38, -0.0, 1.0, 1e-3)


def raw(change: Mutation) -> Mutation:
    BINARY[change.__name__] = change
    return change


def records(change: Callable[[Random, list[bytes]], list[bytes] | None]) -> Mutation:
    """A mutation of the payloads of the Fortran records, whose lengths are written right."""

    def mutate(random: Random, data: bytes) -> bytes:
        payloads = split(data)
        return join(change(random, payloads) or payloads)

    BINARY[change.__name__] = mutate
    return mutate


def split(data: bytes) -> list[bytes]:
    out, at = [], 0
    while at < len(data):
        (size,) = struct.unpack_from("<i", data, at)
        out.append(data[at + 4 : at + 4 + size])
        at += size + 8
    return out


def join(payloads: list[bytes]) -> bytes:
    return b"".join(struct.pack("<i", len(p)) + p + struct.pack("<i", len(p)) for p in payloads)


def _tables(payloads: list[bytes]) -> tuple[list[int], list[int]]:
    """Places of the headers and of the rows of displacements."""
    headers = [i for i, p in enumerate(payloads) if len(p) == _HEADER]
    return headers, [next(j for j in range(i + 1, len(payloads)) if len(payloads[j]) > 4) for i in headers]


# --- damage ----------------------------------------------------------------------------------------------------------


@raw
def cut(random: Random, data: bytes) -> bytes:
    return data[: random.randrange(len(data))]


@raw
def cut_front(random: Random, data: bytes) -> bytes:
    return data[random.randrange(1, len(data)) :]


@raw
def flip_bit(random: Random, data: bytes) -> bytes:
    out = bytearray(data)
    out[random.randrange(len(out))] ^= 1 << random.randrange(8)
    return bytes(out)


@raw
def flip_bits(random: Random, data: bytes) -> bytes:
    out = bytearray(data)
    for _ in range(random.choice((2, 3, 8, 64))):
        out[random.randrange(len(out))] ^= 1 << random.randrange(8)
    return bytes(out)


@raw
def set_byte(random: Random, data: bytes) -> bytes:
    out = bytearray(data)
    out[random.randrange(len(out))] = random.randrange(256)
    return bytes(out)


@raw
def set_word(random: Random, data: bytes) -> bytes:
    at = random.randrange(len(data) // 4) * 4
    return data[:at] + struct.pack("<i", random.choice((*_COUNTS, *_WORDS))) + data[at + 4 :]


@raw
def drop_bytes(random: Random, data: bytes) -> bytes:
    at = random.randrange(len(data))
    return data[:at] + data[at + random.choice((1, 2, 4, 8, 12, 512)) :]


@raw
def insert_garbage(random: Random, data: bytes) -> bytes:
    at = random.choice((random.randrange(len(data)), random.randrange(len(data) // 4) * 4, len(data)))
    return data[:at] + random.randbytes(random.choice((1, 4, 8, 64, 4096))) + data[at:]


@raw
def blank_block(random: Random, data: bytes) -> bytes:
    """A block of the disk that was never written."""
    at, size = random.randrange(len(data)), random.choice((4, 16, 512, 4096))
    return data[:at] + bytes(len(data[at : at + size])) + data[at + size :]


@raw
def line_ends(random: Random, data: bytes) -> bytes:
    """Sent as text."""
    return random.choice(
        (data.replace(b"\n", b"\r\n"), data.replace(b"\x08", b"\n"), data.decode("latin-1").encode(), data[:3])
    )


@raw
def swapped_bytes(random: Random, data: bytes) -> bytes:
    """Every word in the other byte order, text and all."""
    whole = data[: len(data) // 4 * 4]
    return np.frombuffer(whole, "<i4").byteswap().tobytes()


@raw
def wrong_length(random: Random, data: bytes) -> bytes:
    """The length before a record, behind it, or both."""
    payloads = split(data)
    number, count, side = random.randrange(len(payloads)), random.choice(_COUNTS), random.randrange(3)
    out = []
    for i, p in enumerate(payloads):
        a = count if i == number and side in (0, 2) else len(p)
        b = count if i == number and side in (1, 2) else len(p)
        out.append(struct.pack("<i", a) + p + struct.pack("<i", b))
    return b"".join(out)


# --- records ---------------------------------------------------------------------------------------------------------


@records
def wrong_marker(random: Random, payloads: list[bytes]) -> None:
    """The number of words, or of the record, that goes before a record."""
    at = random.choice([i for i, p in enumerate(payloads) if len(p) == 4])
    (old,) = struct.unpack("<i", payloads[at])
    payloads[at] = struct.pack("<i", random.choice((*_COUNTS, old + 1, old - 1, min(2 * old, 2**30), -old)))


@records
def drop_records(random: Random, payloads: list[bytes]) -> None:
    at = random.randrange(len(payloads))
    del payloads[at : at + random.choice((1, 1, 2, 4, 5, 8))]


@records
def repeat_records(random: Random, payloads: list[bytes]) -> None:
    at, count = random.randrange(len(payloads)), random.choice((1, 1, 2, 4, 5, 8))
    payloads[at:at] = payloads[at : at + count]


@records
def swap_records(random: Random, payloads: list[bytes]) -> None:
    a, b = random.randrange(len(payloads)), random.randrange(len(payloads))
    payloads[a], payloads[b] = payloads[b], payloads[a]


@records
def garbage_record(random: Random, payloads: list[bytes]) -> None:
    payloads.insert(random.randrange(len(payloads)), random.randbytes(random.choice((0, 4, 8, 28, 584, 448))))


@records
def shorter_record(random: Random, payloads: list[bytes]) -> None:
    """A record that lacks words, with or without a marker that says so."""
    at = random.choice([i for i, p in enumerate(payloads) if len(p) > 4])
    payloads[at] = payloads[at][: random.randrange(len(payloads[at]) // 4) * 4]
    if random.random() < 0.7:
        payloads[at - 1] = struct.pack("<i", len(payloads[at]) // 4)


@records
def repeat_subcase(random: Random, payloads: list[bytes]) -> None:
    """The records of one subcase once more, numbered on."""
    headers, rows = _tables(payloads)
    k = random.randrange(len(headers))
    first, last = headers[k] - 1, rows[k] + 1
    payloads[last:last] = payloads[first:last]


@records
def more_end_marks(random: Random, payloads: list[bytes]) -> None:
    zero = struct.pack("<i", 0)
    if random.random() < 0.5:
        payloads += [zero] * random.choice((1, 2, 5))
    else:
        del payloads[-random.choice((1, 2, 3)) :]


@records
def whole_file_twice(random: Random, payloads: list[bytes]) -> list[bytes]:
    first = next(i for i, p in enumerate(payloads) if p.startswith(b"OUGV1")) - 1
    return random.choice((payloads + payloads, payloads[:-1] + payloads[first:]))


# --- meaning ---------------------------------------------------------------------------------------------------------


@records
def header_word(random: Random, payloads: list[bytes]) -> None:
    at = random.choice(_tables(payloads)[0])
    words = np.frombuffer(payloads[at], "<i4").copy()
    words[random.choice((0, 1, 2, 3, 3, 8, 9, 10, 22, random.randrange(50)))] = random.choice(_WORDS)
    payloads[at] = words.tobytes()


@records
def label(random: Random, payloads: list[bytes]) -> None:
    at = random.choice(_tables(payloads)[0])
    new = random.choice(
        (b"", b"ROOT", b"WAIST", b"TIP", b"UNIFORM", b"tip", b"TIPP", b"\xff\xfe", b"SUBCASE 1", b"  TIP  ")
    )
    payloads[at] = payloads[at][: _HEADER - 128] + new.ljust(128)


@records
def swapped_labels(random: Random, payloads: list[bytes]) -> None:
    a, b = random.sample(_tables(payloads)[0], 2)
    x, y = payloads[a], payloads[b]
    payloads[a], payloads[b] = x[: _HEADER - 128] + y[_HEADER - 128 :], y[: _HEADER - 128] + x[_HEADER - 128 :]


@records
def swapped_numbers(random: Random, payloads: list[bytes]) -> None:
    a, b = random.sample(_tables(payloads)[0], 2)
    x, y = payloads[a], payloads[b]
    payloads[a], payloads[b] = x[:12] + y[12:20] + x[20:], y[:12] + x[12:20] + y[20:]


@records
def table_name(random: Random, payloads: list[bytes]) -> None:
    at = random.choice([i for i, p in enumerate(payloads) if p[:3] == b"OUG"])
    new = random.choice(
        (b"BOUGV1", b"OUGV2", b"OUGV1PAT", b"OQG1", b"OES1X1", b"GEOM1", b"CASECC", b"XYZ", b"", b"\xff\xff")
    )
    payloads[at] = new.ljust(8) + payloads[at][8:]


@records
def foreign_float(random: Random, payloads: list[bytes]) -> None:
    at = random.choice(_tables(payloads)[1])
    words = np.frombuffer(payloads[at], "<f4").reshape(-1, 8).copy()
    words[random.randrange(len(words)), random.randrange(8)] = random.choice(_FLOATS)
    payloads[at] = words.tobytes()


@records
def scaled_float(random: Random, payloads: list[bytes]) -> None:
    at = random.choice(_tables(payloads)[1])
    words = np.frombuffer(payloads[at], "<f4").reshape(-1, 8).copy()
    words[random.randrange(len(words)), random.randrange(2, 8)] *= random.choice((-1.0, 2.0, 0.5, 1.01, 1.0001, 0.0))
    payloads[at] = words.tobytes()


@records
def foreign_id(random: Random, payloads: list[bytes]) -> None:
    at = random.choice(_tables(payloads)[1])
    words = np.frombuffer(payloads[at], "<i4").reshape(-1, 8).copy()
    words[random.randrange(len(words)), random.randrange(2)] = random.choice(_WORDS)
    payloads[at] = words.tobytes()


@records
def swapped_rows(random: Random, payloads: list[bytes]) -> None:
    at = random.choice(_tables(payloads)[1])
    words = np.frombuffer(payloads[at], "<i4").reshape(-1, 8).copy()
    a, b = random.sample(range(len(words)), 2)
    columns = random.choice((slice(0, 1), slice(2, 8), slice(0, 8)))
    words[[a, b], columns] = words[[b, a], columns]
    payloads[at] = words.tobytes()


@records
def swapped_record(random: Random, payloads: list[bytes]) -> None:
    """One record in the other byte order."""
    at = random.randrange(len(payloads))
    whole = payloads[at][: len(payloads[at]) // 4 * 4]
    payloads[at] = np.frombuffer(whole, "<i4").byteswap().tobytes()
