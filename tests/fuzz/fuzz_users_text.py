"""What goes wrong with what users write: damage, numbers without measure, other types, archives that lie."""

from __future__ import annotations

import io
import re
import struct
import zipfile
import zlib
from collections.abc import Callable
from random import Random

import numpy as np
from fuzz_text import Mutation

_NUMBERS = (
    "1e308",
    "-1e308",
    "1e-300",
    "5e-324",
    "inf",
    "-inf",
    "nan",
    "0",
    "-1",
    "1" + 40 * "0",
    "1" + 400 * "0",
    "1e15",
)
_TYPES = ('"x"', "true", "[]", "{}", "[1, 2]", "1979-05-27", "''", '"\\u0000"', '"a\\nb"', '[["a"]]', "0x10")
_TOML_NUMBER = re.compile(r"(?<![\w.\"-])-?\d+(\.\d+)?(e-?\d+)?(?![\w.:\"])")

USERS_TEXT: dict[str, Mutation] = {}
USERS_BINARY: dict[str, Mutation] = {}


def lines(change: Callable[[Random, list[str]], None]) -> Mutation:
    def mutate(random: Random, data: bytes) -> bytes:
        found = data.decode("utf-8").split("\n")
        change(random, found)
        return "\n".join(found).encode("utf-8")

    USERS_TEXT[change.__name__] = mutate
    return mutate


def both(change: Mutation) -> Mutation:
    USERS_TEXT[change.__name__] = USERS_BINARY[change.__name__] = change
    return change


def binary(change: Mutation) -> Mutation:
    USERS_BINARY[change.__name__] = change
    return change


@both
def flip_bit(random: Random, data: bytes) -> bytes:
    out = bytearray(data)
    for _ in range(random.choice((1, 1, 3))):
        out[random.randrange(len(out))] ^= 1 << random.randrange(8)
    return bytes(out)


@both
def set_byte(random: Random, data: bytes) -> bytes:
    out = bytearray(data)
    out[random.randrange(len(out))] = random.choice((0, 9, 10, 13, 34, 35, 44, 45, 48, 57, 61, 91, 127, 255))
    return bytes(out)


@both
def cut(random: Random, data: bytes) -> bytes:
    return data[: random.randrange(len(data))]


@both
def drop_bytes(random: Random, data: bytes) -> bytes:
    at = random.randrange(len(data))
    return data[:at] + data[at + random.choice((1, 1, 2, 8, 40)) :]


@both
def insert_garbage(random: Random, data: bytes) -> bytes:
    at = random.randrange(len(data))
    return (
        data[:at]
        + random.choice((random.randbytes(8), b"\n", b"7", b",", b"-", b"\0" * 20, b"\xef\xbb\xbf"))
        + data[at:]
    )


@lines
def drop_line(random: Random, found: list[str]) -> None:
    del found[random.randrange(len(found))]


@lines
def repeat_line(random: Random, found: list[str]) -> None:
    at = random.randrange(len(found))
    found.insert(at, found[at])


@lines
def swap_lines(random: Random, found: list[str]) -> None:
    a, b = random.randrange(len(found)), random.randrange(len(found))
    found[a], found[b] = found[b], found[a]


def _number_at(random: Random, found: list[str], new: Callable[[str], str]) -> None:
    places = [(i, m) for i, s in enumerate(found) if not s.startswith("#") for m in _TOML_NUMBER.finditer(s)]
    if places:
        i, m = random.choice(places)
        found[i] = found[i][: m.start()] + new(m[0]) + found[i][m.end() :]


@lines
def extreme_number(random: Random, found: list[str]) -> None:
    _number_at(random, found, lambda _: random.choice(_NUMBERS))


@lines
def scaled_number(random: Random, found: list[str]) -> None:
    _number_at(random, found, lambda old: f"{float(old) * 10.0 ** random.randrange(-12, 13):.6g}")


@lines
def other_type(random: Random, found: list[str]) -> None:
    _number_at(random, found, lambda _: random.choice(_TYPES))


@lines
def other_value(random: Random, found: list[str]) -> None:
    places = [i for i, s in enumerate(found) if " = " in s and not s.startswith("#")]
    if places:
        i = random.choice(places)
        found[i] = found[i].split(" = ")[0] + " = " + random.choice(_TYPES + _NUMBERS)


@lines
def drop_field(random: Random, found: list[str]) -> None:
    at = random.randrange(len(found))
    fields = found[at].split(",")
    del fields[random.randrange(len(fields))]
    found[at] = ",".join(fields)


@binary
def set_word(random: Random, data: bytes) -> bytes:
    at = random.randrange(len(data) - 4)
    word = random.choice((0, 1, 7, 14, 15, 2**31 - 1, 2**31, 2**32 - 1, 2**20, 64))
    return data[:at] + struct.pack("<I", word) + data[at + 4 :]


@binary
def inside(random: Random, data: bytes) -> bytes:
    """Damage within, under sums that are right: a lying header, for instance."""
    mutate = random.choice((flip_bit, set_byte, set_word, drop_bytes, insert_garbage, cut))
    if data.startswith(b"PK"):
        out = io.BytesIO()
        with zipfile.ZipFile(io.BytesIO(data)) as old, zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as new:
            names = old.namelist()
            chosen = random.choice(names)
            for name in names:
                member = old.read(name)
                head = member[:128]
                new.writestr(name, mutate(random, head) + member[128:] if name == chosen else member)
        return out.getvalue()
    elements, at = [], 128
    while at < len(data):
        size = struct.unpack_from("<I", data, at + 4)[0]
        elements.append(zlib.decompress(data[at + 8 : at + 8 + size]))
        at += 8 + size
    chosen_at = random.randrange(len(elements))
    elements[chosen_at] = mutate(random, elements[chosen_at])
    packed = [zlib.compress(e) for e in elements]
    return data[:128] + b"".join(struct.pack("<II", 15, len(p)) + p for p in packed)


@binary
def bomb(random: Random, data: bytes) -> bytes:
    """A small file that would take gigabytes."""
    zeros = 2**31 + 2**27
    if data.startswith(b"PK"):
        out = io.BytesIO()
        with (
            zipfile.ZipFile(io.BytesIO(data)) as old,
            zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as new,
        ):
            for name in old.namelist():
                if name in ("R.npy", "S_BW.npy"):
                    with new.open(name, "w", force_zip64=True) as stream:
                        head = io.BytesIO()
                        side = zeros // 8 // 4096
                        np.lib.format.write_array_header_1_0(
                            head, {"descr": "<f8", "fortran_order": False, "shape": (side, 4096)}
                        )
                        stream.write(head.getvalue())
                        for _ in range(random.choice((1, 16))):  # the header may lie besides
                            stream.write(bytes(2**20))
                else:
                    new.writestr(name, old.read(name))
        return out.getvalue()
    packer = zlib.compressobj(1)
    tags = (
        struct.pack("<II", 14, 2**31 - 1) + struct.pack("<IIII", 6, 8, 6, 0) + struct.pack("<IIii", 5, 8, 2**14, 2**14)
    )
    packed = packer.compress(tags) + b"".join(packer.compress(bytes(2**20)) for _ in range(300)) + packer.flush()
    return data[:128] + struct.pack("<II", 15, len(packed)) + packed
