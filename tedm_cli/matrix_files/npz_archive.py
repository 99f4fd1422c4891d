"""Arrays of an NPZ archive, none read before its header has been checked against the archive and a bound of memory."""

from __future__ import annotations

import math
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import IO, Any

import numpy as np

from tedm_cli.arrays import AnyArray
from tedm_cli.errors import InputError
from tedm_cli.regular_file import require_regular_file

#: Of what is read of one file: 33 million numbers, as of 1000 photodiode paths by 1000 optical elements.
MOST_BYTES = 2**28
_KINDS = "fciubUS"
_METHODS = (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED)
_ENCRYPTED = 1  # flag of a member


def read_arrays(path: Path, wanted: Callable[[str], bool]) -> tuple[dict[str, AnyArray], list[str]]:
    """The arrays whose names are `wanted`, and the names of all.

    Raises
    ------
    InputError : no such file, no archive of plain arrays, a member that is encrypted, damaged (by its checksum), of
        objects, there twice, or not as large as its header says; more than 256 MiB in all.
    """
    require_regular_file(path)
    if not path.is_file():
        raise InputError("does not exist or is not a file", where=str(path))
    try:
        with zipfile.ZipFile(path) as archive:
            members = [m for m in archive.infolist() if m.filename.endswith(".npy")]
            names = [m.filename.removesuffix(".npy") for m in members]
            chosen = {name: m for name, m in zip(names, members, strict=True) if wanted(name)}
            twice = [name for name in chosen if names.count(name) > 1]
            if twice:
                raise InputError(f"holds two arrays {twice[0]}", where=str(path))
            total = sum(m.file_size for m in chosen.values())
            if total > MOST_BYTES:
                raise InputError(f"holds {total:,} bytes of arrays; at most {MOST_BYTES:,} are read", where=str(path))
            return {name: _array(archive, m, name, path) for name, m in chosen.items()}, names
    except InputError:
        raise
    except Exception as exc:  # damaged archives make it fail in every way
        raise InputError(f"not a readable NPZ file of plain arrays ({_reason(exc)})", where=str(path)) from exc


def _array(archive: zipfile.ZipFile, member: zipfile.ZipInfo, name: str, path: Path) -> AnyArray:
    if member.flag_bits & _ENCRYPTED:
        raise InputError(f"{name} is encrypted", where=str(path), hint="save the arrays without a password")
    if member.compress_type not in _METHODS:
        raise InputError(
            f"{name} is compressed by method {member.compress_type}", where=str(path), hint="use numpy.savez"
        )
    with archive.open(member) as stream:
        shape, is_fortran, kind = _header(stream)
        if kind.kind not in _KINDS or kind.hasobject:
            fact = f"not a readable NPZ file of plain arrays: {name} holds {kind}"
            raise InputError(fact, where=str(path), hint="save numbers as float64 and labels as strings")
        size = math.prod(shape) * kind.itemsize
        begin = stream.tell()
        if begin + size != member.file_size:
            fact = f"{name} of shape {shape} must have {size:,} bytes, but has {member.file_size - begin:,}"
            raise InputError(fact, where=str(path))
        data = stream.read(size)  # to the end of the member, where its checksum is compared
        if len(data) != size:
            raise InputError(f"{name} is cut off after {len(data):,} of {size:,} bytes", where=str(path))
    array = np.frombuffer(data, kind).reshape(shape, order="F" if is_fortran else "C")
    if kind.kind == "S":
        array = np.char.decode(array, "utf-8")
    if array.dtype.kind == "U":
        array.tolist()  # fails on what is no text
    return array


def _header(stream: IO[bytes]) -> tuple[tuple[int, ...], bool, np.dtype[Any]]:
    """Shape, whether columns come first, and type of the numbers behind; raises for what is no header of an array."""
    form: Any = np.lib.format  # NumPy does not say its types
    version = form.read_magic(stream)
    readers = {(1, 0): form.read_array_header_1_0, (2, 0): form.read_array_header_2_0}
    if version not in readers:
        raise ValueError(f"format {version[0]}.{version[1]} of its arrays is not known")
    shape, is_fortran, kind = readers[version](stream)
    return shape, is_fortran, kind


def _reason(exc: Exception) -> str:
    return str(exc).split("\n")[0][:200] or type(exc).__name__
