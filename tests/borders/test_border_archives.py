"""NPZ and MAT as NumPy and MATLAB write them are read; damaged and lying ones are refused in little memory."""

from __future__ import annotations

import io
import struct
import tracemalloc
import zipfile
import zlib
from collections.abc import Callable
from pathlib import Path
from random import Random
from typing import Any

import numpy as np
import pytest
import scipy.io
import scipy.sparse

from tedm_cli.errors import ConfigError, InputError
from tedm_cli.matrix_files.mat_file import read_mat
from tedm_cli.matrix_files.mat_structure import MOST_BYTES, MatError, plain_mat
from tedm_cli.matrix_files.npz_file import read_npz

VALUE = np.arange(12.0).reshape(3, 4) - 5.5
BYTES = 5e6  # of memory that a refusal may take


def npz(path: Path, **arrays: Any) -> Path:
    np.savez_compressed(path, **{"S": VALUE, "S.rows": np.array(["a", "b", "c"]), **arrays})
    return path


def repacked(path: Path, change: Callable[[str, bytes], bytes], method: int = zipfile.ZIP_DEFLATED) -> Path:
    """The archive with its members changed, under sums that are right."""
    out = io.BytesIO()
    with zipfile.ZipFile(path) as old, zipfile.ZipFile(out, "w", method) as new:
        for name in old.namelist():
            new.writestr(name, change(name, old.read(name)))
    path.write_bytes(out.getvalue())
    return path


def refused(read: Callable[[Path, str], Any], path: Path, match: str) -> None:
    tracemalloc.start()
    try:
        with pytest.raises(InputError, match=match) as caught:
            read(path, "S")
        assert tracemalloc.get_traced_memory()[1] < BYTES
    finally:
        tracemalloc.stop()
    assert caught.value.where == str(path)
    assert len(caught.value.placed.splitlines()) == 1


@pytest.mark.parametrize(
    "value", [VALUE, VALUE.astype("f4"), VALUE.astype(">f8"), np.asfortranarray(VALUE), VALUE.astype("i2")]
)
def test_numbers_of_any_kind_and_order(tmp_path: Path, value: np.ndarray) -> None:
    for save in (np.savez, np.savez_compressed):
        save(tmp_path / "m.npz", S=value, **{"S.rows": np.array([b"a", b"b", b"c"])})
        found = read_npz(tmp_path / "m.npz", "S")
        np.testing.assert_array_equal(found.values, value.astype(float))
        assert found.declared["rows"] == ["a", "b", "c"]
        scipy.io.savemat(tmp_path / "m.mat", {"S": value}, do_compression=save is np.savez_compressed)
        np.testing.assert_array_equal(read_mat(tmp_path / "m.mat", "S").values, value.astype(float))


def head(shape: str, kind: str = "<f8") -> Callable[[str, bytes], bytes]:
    """Another header of the member S, the numbers as they are."""

    def change(name: str, data: bytes) -> bytes:
        if name != "S.npy":
            return data
        text = f"{{'descr': '{kind}', 'fortran_order': False, 'shape': {shape}, }}".ljust(117) + "\n"
        return b"\x93NUMPY\x01\x00" + struct.pack("<H", len(text)) + text.encode() + data[-96:]

    return change


@pytest.mark.parametrize(
    ("change", "fact"),
    [
        (head("(3, 5)"), r"S of shape \(3, 5\) must have 120 bytes, but has 96"),
        (head("(100000, 100000)"), "must have 80,000,000,000 bytes, but has 96"),
        (head("(-3, -4)"), "not a readable NPZ"),
        (head("(3, 4)", "|O"), "holds object"),
        (head("(1,)", "V96"), r"holds \|V96"),
        (head("(99999999999999999999, 4)"), "must have"),
        (head("(3, 4)", "evil"), "not a readable NPZ"),
        (lambda n, d: d[:20], "not a readable NPZ"),
        (lambda n, d: b"", "not a readable NPZ"),
        (lambda n, d: d.replace(b"\x01\x00", b"\x07\x00", 1) if n == "S.npy" else d, "not a readable NPZ"),
        (lambda n, d: d[:-4] + struct.pack("<I", 0x110000) if n == "S.rows.npy" else d, "not a readable NPZ"),
        (lambda n, d: d[:10] + b"(" * 100 + d[110:] if n == "S.npy" else d, "not a readable NPZ"),
    ],
)
def test_headers_that_lie(tmp_path: Path, change: Callable[[str, bytes], bytes], fact: str) -> None:
    refused(read_npz, repacked(npz(tmp_path / "m.npz"), change), fact)


def test_what_no_header_shows(tmp_path: Path) -> None:
    """Encrypted members, methods that NumPy does not write, checksums, names that are there twice, bombs."""
    path = npz(tmp_path / "m.npz")
    sound = path.read_bytes()
    flags = sound.index(b"PK\x01\x02") + 8
    path.write_bytes(sound[:flags] + b"\x01" + sound[flags + 1 :])
    refused(read_npz, path, "S is encrypted")
    path.write_bytes(sound)
    refused(read_npz, repacked(path, lambda n, d: d, zipfile.ZIP_LZMA), "S is compressed by method 14")
    np.savez(path, S=VALUE)
    plain = path.read_bytes()
    at = plain.index(VALUE.tobytes()) + 11
    path.write_bytes(plain[:at] + bytes([plain[at] ^ 1]) + plain[at + 1 :])
    refused(read_npz, path, "Bad CRC-32")
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("S.npy", b"1")
        with pytest.warns(UserWarning, match="Duplicate"):
            archive.writestr("S.npy", b"2")
    refused(read_npz, path, "holds two arrays S")
    path.write_bytes(b"\x93NUMPY\x01\x00")
    refused(read_npz, path, "not a zip file")
    refused(read_npz, tmp_path / "none.npz", "does not exist")
    refused(read_npz, tmp_path, "is a folder, not a regular file")


def test_a_small_archive_that_takes_gigabytes(tmp_path: Path) -> None:
    path, rows = tmp_path / "m.npz", 40_000
    with (
        zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as archive,
        archive.open("S.npy", "w", force_zip64=True) as stream,
    ):
        np.lib.format.write_array_header_1_0(stream, {"descr": "<f8", "fortran_order": False, "shape": (rows, 1000)})
        for _ in range(8 * rows // 1000):
            stream.write(bytes(1_000_000))
    assert path.stat().st_size < 3_000_000
    refused(read_npz, path, f"holds [0-9,]+ bytes of arrays; at most {MOST_BYTES:,} are read")


def test_matrices_as_matlab_writes_them(tmp_path: Path) -> None:
    """Structures with cell arrays of texts, level 4, sparse, logical, empty ones, and others beside the one wanted."""
    path = tmp_path / "m.mat"
    cells = np.array(["a", "bb", "ç"], dtype=object).reshape(-1, 1)
    more = {"x": np.zeros((0, 0)), "t": "text", "z": np.array([[1 + 2j]]), "deep": {"a": {"b": {"c": 1.0}}}}
    for compressed in (True, False):
        scipy.io.savemat(path, {"S": {"value": VALUE, "rows": cells}, **more}, do_compression=compressed)
        found = read_mat(path, "S")
        np.testing.assert_array_equal(found.values, VALUE)
        assert found.declared["rows"] == ["a", "bb", "ç"]
    scipy.io.savemat(path, {"S": VALUE, "T": "text"}, format="4")
    np.testing.assert_array_equal(read_mat(path, "S").values, VALUE)
    scipy.io.savemat(path, {"S": scipy.sparse.csc_array(VALUE)})
    np.testing.assert_array_equal(read_mat(path, "S").values, VALUE)
    scipy.io.savemat(path, {"S": np.array([[1 + 2j]])})
    refused(read_mat, path, "a matrix of real numbers is needed")
    scipy.io.savemat(path, {"S": scipy.sparse.csc_array((2**17, 2**17))})
    refused(read_mat, path, "sparse matrix of shape")


def matlab(element: bytes, order: str = "<") -> bytes:
    text = b"MATLAB 5.0 MAT-file".ljust(124) + (b"\x00\x01IM" if order == "<" else b"\x01\x00MI")
    return text + element


def matrix(flags: int, shape: tuple[int, ...], *parts: bytes, name: bytes = b"S") -> bytes:
    body = struct.pack("<IIII", 6, 8, flags, 0) + struct.pack(f"<II{len(shape)}i", 5, 4 * len(shape), *shape)
    body += b"\0" * (-len(body) % 8) + struct.pack("<HH4s", 1, len(name), name) + b"".join(parts)
    return struct.pack("<II", 14, len(body)) + body


def numbers(kind: int, data: bytes, size: int | None = None) -> bytes:
    return struct.pack("<II", kind, len(data) if size is None else size) + data + b"\0" * (-len(data) % 8)


NESTED = matrix(6, (1, 1), numbers(9, bytes(8)))
for _ in range(40):
    NESTED = matrix(1, (1, 1), NESTED)


@pytest.mark.parametrize(
    ("element", "fact"),
    [
        (matrix(6, (2, 2), numbers(9, bytes(24))), r"shape \(2, 2\) with 3 entries"),
        (matrix(6, (2**15, 2**15), numbers(9, bytes(8))), "with 1 entries"),
        (matrix(6, (1, 1), numbers(9, bytes(8), 2**31 - 1)), "where 8 are left"),
        (matrix(6, (1, 1), numbers(77, bytes(8))), "numbers of type 77"),
        (matrix(4, (1, 2**30), numbers(16, b"")), "with 0 entries"),
        (matrix(1, (2**30, 1)), "with 0 entries"),
        (matrix(2, (1, 2**28), numbers(5, struct.pack("<i", 32)), numbers(1, bytes(32))), "with 0 entries"),
        (matrix(2, (1, 1), numbers(5, struct.pack("<i", 0)), numbers(1, bytes(32))), "field names of 0 letters"),
        (matrix(5, (2**20, 2**20), *3 * [numbers(5, bytes(8))]), "sparse matrix of shape"),
        (matrix(99, (1, 1)), "class 99"),
        (matrix(6, (-1, 1), numbers(9, bytes(8))), r"shape \(-1, 1\)"),
        (NESTED, "nested more than 16 deep"),
        (numbers(9, bytes(8)), "in place of a matrix"),
        (struct.pack("<II", 15, 4) + b"\0\0\0\0", "compressed element that is damaged"),
        (struct.pack("<II", 15, 99) + b"\0\0\0\0", "where 4 are left"),
        (b"\1\2\3", "ends inside the header"),
    ],
)
def test_elements_that_lie(tmp_path: Path, element: bytes, fact: str) -> None:
    (tmp_path / "m.mat").write_bytes(matlab(element))
    refused(read_mat, tmp_path / "m.mat", fact)
    packed = zlib.compress(element)
    (tmp_path / "m.mat").write_bytes(matlab(struct.pack("<II", 15, len(packed)) + packed))
    refused(read_mat, tmp_path / "m.mat", "not a readable MAT file")


def test_a_compressed_element_that_takes_gigabytes(tmp_path: Path) -> None:
    packer = zlib.compressobj(9)
    packed = b"".join(packer.compress(bytes(10**6)) for _ in range(400)) + packer.flush()
    assert len(packed) < 10**6
    with pytest.raises(MatError, match="inflates to more than 268,435,456 bytes"):
        plain_mat(matlab(struct.pack("<II", 15, len(packed)) + packed))


@pytest.mark.parametrize("kind", ["npz", "mat", "mat, plain", "mat, level 4", "mat, inside"])
def test_four_hundred_damaged_archives(tmp_path: Path, kind: str) -> None:
    """Bits, bytes and words anywhere: the same matrix, another one where no sum protects it, or one error."""
    path, random = tmp_path / f"m.{kind[:3]}", Random(kind)
    if kind == "npz":
        npz(path)
    elif kind == "mat, level 4":
        scipy.io.savemat(path, {"S": VALUE}, format="4")
    else:
        fields = {"value": VALUE, "rows": np.array(["a", "b", "c"], dtype=object), "declaration": "frame = 'layout'"}
        scipy.io.savemat(path, {"S": fields}, do_compression=kind == "mat")
    sound = path.read_bytes()
    outcomes = {"same": 0, "other": 0, "refused": 0, "unnamed": 0}
    for _ in range(400):
        data = bytearray(sound)
        for _ in range(random.choice((1, 1, 2, 5))):
            at = random.randrange(len(data) - 4)
            if random.random() < 0.5:
                data[at] ^= 1 << random.randrange(8)
            else:
                data[at : at + 4] = struct.pack("<I", random.choice((0, 1, 14, 15, 2**31 - 1, 2**32 - 1, 2**20)))
        raw = bytes(data)
        if kind == "mat, inside":
            packed = zlib.compress(raw[128:])
            raw = raw[:128] + struct.pack("<II", 15, len(packed)) + packed
        path.write_bytes(raw)
        try:
            found = (read_npz if kind == "npz" else read_mat)(path, "S")
            outcomes["same" if np.array_equal(found.values, VALUE) else "other"] += 1
        except (InputError, ConfigError) as exc:
            outcomes["refused" if str(path) in exc.where else "unnamed"] += 1
    assert outcomes["refused"] > 100, outcomes
    assert not outcomes["unnamed"]
    if kind in ("npz", "mat"):
        assert not outcomes["other"], "checksums hold"
