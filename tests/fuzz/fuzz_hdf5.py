"""What goes wrong with files between the stages: damage of bytes, and edits by programs that seal what they wrote."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from random import Random

import h5py
import numpy as np
from label_scales import is_scale_alone

from tedm_cli.files.seal import seal

Change = Callable[[Random, Path], None]
DAMAGE: dict[str, Change] = {}
EDITS: dict[str, Change] = {}

Damage = Callable[[Random, bytearray], bytes | bytearray]


def damage(change: Damage) -> Damage:
    def apply(random: Random, path: Path) -> None:
        path.write_bytes(change(random, bytearray(path.read_bytes())))

    DAMAGE[change.__name__] = apply
    return change


class UnfitError(Exception):
    """A file has nothing that could be changed in some way."""


def edit(change: Callable[[Random, h5py.File], None]) -> Callable[[Random, h5py.File], None]:
    """A change by another program that seals what it wrote, so that the contract has to stand on its own.

    A file that has nothing of the kind loses a dataset instead.
    """

    def apply(random: Random, path: Path) -> None:
        with h5py.File(path, "r+") as file:
            try:
                change(random, file)
            except UnfitError:
                removed(random, file)
        seal(path)

    EDITS[change.__name__] = apply
    return change


# --- damage ----------------------------------------------------------------------------------------------------------


@damage
def flip_bit(random: Random, data: bytearray) -> bytes | bytearray:
    data[random.randrange(len(data))] ^= 1 << random.randrange(8)
    return data


@damage
def flip_bit_of_metadata(random: Random, data: bytearray) -> bytes | bytearray:
    """In HDF5's own records, where most bytes matter."""
    records = [m.start() for m in re.finditer(rb"OHDR|OCHK|GCOL|FRHP|FHDB|FADB|FAHD|BTHD|BTLF|SNOD|TREE|HEAP", data)]
    data[min(random.choice(records) + random.randrange(256), len(data) - 1)] ^= 1 << random.randrange(8)
    return data


@damage
def flip_bit_of_a_word(random: Random, data: bytearray) -> bytes | bytearray:
    words = [m.span() for m in re.finditer(rb"[A-Za-z0-9_+-]{4,}", data)]
    data[random.randrange(*random.choice(words))] ^= 1 << random.randrange(8)
    return data


@damage
def truncated(random: Random, data: bytearray) -> bytes | bytearray:
    return data[: random.choice((random.randrange(len(data)), len(data) - random.randrange(1, 200)))]


@damage
def zeroed_block(random: Random, data: bytearray) -> bytes | bytearray:
    at, size = random.randrange(len(data)), random.choice((16, 512, 4096, 65536))
    data[at : at + size] = bytes(len(data[at : at + size]))
    return data


@damage
def swapped_blocks(random: Random, data: bytearray) -> bytes | bytearray:
    size = random.choice((16, 512, 4096))
    a, b = sorted(random.sample(range(len(data) // size), 2))
    one, two = data[a * size : (a + 1) * size], data[b * size : (b + 1) * size]
    data[a * size : (a + 1) * size], data[b * size : (b + 1) * size] = two, one
    return data


@damage
def another_files_block(random: Random, data: bytearray) -> bytes | bytearray:
    """As a disk does that writes to the wrong place."""
    at = random.randrange(len(data) // 512) * 512
    data[at : at + 512] = random.randbytes(len(data[at : at + 512]))
    return data


# --- edits -----------------------------------------------------------------------------------------------------------


def datasets(file: h5py.File, kinds: str, *, filled: bool = True) -> list[str]:
    """The datasets of a file of some types, without its provenance and dimensions."""
    found: list[str] = []

    def visit(name: str, item: object) -> None:
        if not isinstance(item, h5py.Dataset) or name.startswith("provenance/") or is_scale_alone(item):
            return
        if item.dtype.kind in kinds:
            found.extend([f"/{name}"] * bool(item.size or not filled))

    file.visititems(visit)
    return sorted(found)


def pick(random: Random, found: list[str]) -> str:
    if not found:
        raise UnfitError
    return random.choice(found)


def put(file: h5py.File, path: str, values: np.ndarray) -> None:
    attributes = {name: file[path].attrs[name] for name in ("units", "long_name")}
    dtype = file[path].dtype
    del file[path]
    file.create_dataset(path, data=values, dtype=dtype)
    file[path].attrs.update(attributes)


@edit
def letter_of_a_string(random: Random, file: h5py.File) -> None:
    path = pick(random, datasets(file, "S"))
    values = np.atleast_1d(file[path][()])
    row = random.randrange(values.size)
    text = bytearray(values.flat[row]) or bytearray(b"x")
    text[random.randrange(len(text))] ^= 1 << random.randrange(7)
    values.flat[row] = bytes(text)
    file[path][...] = np.array(values.tolist(), dtype=file[path].dtype).reshape(file[path].shape)


#: Free words with numbers in them, which `show` prints as they are: nothing is wrong where two rows say the same.
WORDS = ("/disturbance/spectrum",)


@edit
def another_rows_string(random: Random, file: h5py.File) -> None:
    path = pick(random, [p for p in datasets(file, "S") if file[p].size > 1 and p not in WORDS])
    values = file[path][()]
    a, b = random.sample(range(len(values)), 2)
    values[a] = values[b]
    file[path][...] = values


@edit
def integer(random: Random, file: h5py.File) -> None:
    """A number that is no row, id, count or flag."""
    path = pick(random, datasets(file, "i"))
    values = np.atleast_1d(file[path][()])
    values.flat[random.randrange(values.size)] = random.choice((-2, -(2**31), -(2**62)))
    file[path][...] = values.reshape(file[path].shape)


@edit
def shorter(random: Random, file: h5py.File) -> None:
    path = pick(random, [p for p in datasets(file, "ifS") if file[p].ndim])
    axis = random.randrange(file[path].ndim)
    put(file, path, np.delete(file[path][()], random.randrange(file[path].shape[axis]), axis=axis))


@edit
def longer(random: Random, file: h5py.File) -> None:
    path = pick(random, [p for p in datasets(file, "ifS") if file[p].ndim])
    axis, values = random.randrange(file[path].ndim), file[path][()]
    put(file, path, np.concatenate([values, values.take([-1], axis=axis)], axis=axis))


@edit
def flattened(random: Random, file: h5py.File) -> None:
    path = pick(random, [p for p in datasets(file, "ifS") if file[p].ndim > 1])
    put(file, path, file[path][()].ravel())


@edit
def removed(random: Random, file: h5py.File) -> None:
    del file[pick(random, datasets(file, "ifS", filled=False))]


@edit
def link(random: Random, file: h5py.File) -> None:
    path = pick(random, datasets(file, "ifS"))
    kept = Path(file.filename).with_suffix(".other")
    with h5py.File(kept, "w") as other:
        file.copy(path, other, name="kept")
    file.copy(path, "/kept")
    del file[path]
    file[path] = random.choice(
        (h5py.ExternalLink(kept.name, "/kept"), h5py.SoftLink("/kept"), h5py.SoftLink(path), h5py.SoftLink("/none"))
    )


@edit
def stored_elsewhere(random: Random, file: h5py.File) -> None:
    path = pick(random, [p for p in datasets(file, "if") if file[p].ndim])
    values, units = file[path][()], file[path].attrs["units"]
    raw = Path(file.filename).with_suffix(".other")
    raw.write_bytes(values.tobytes())
    del file[path]
    if random.random() < 0.5:
        file.create_dataset(path, values.shape, values.dtype, external=[(str(raw), 0, values.nbytes)])
    else:
        with h5py.File(raw, "w") as other:
            other["kept"] = values
        layout = h5py.VirtualLayout(values.shape, values.dtype)
        layout[...] = h5py.VirtualSource(str(raw), "kept", values.shape)
        file.create_virtual_dataset(path, layout)
    file[path].attrs["units"] = units


@edit
def attribute(random: Random, file: h5py.File) -> None:
    item = file[random.choice(["/", *datasets(file, "ifS")])]
    name = random.choice([n for n in item.attrs if n not in ("DIMENSION_LIST", "REFERENCE_LIST", "CLASS")])
    item.attrs[name] = random.choice((np.arange(3), "", "km", 7, h5py.Empty("f8"), np.bytes_(b"\xff\xfe"), ["a", "b"]))


@edit
def other_type(random: Random, file: h5py.File) -> None:
    path = pick(random, datasets(file, "ifS"))
    values, units = file[path][()], file[path].attrs["units"]
    del file[path]
    text = np.array(values).astype("S8").astype(object)
    file[path] = random.choice((np.float16(1.0), 1j, np.uint8(3), True, text, h5py.Empty("f8")))
    file[path].attrs["units"] = units


@edit
def empty(random: Random, file: h5py.File) -> None:
    """Of the right length, and never written."""
    path = pick(random, [p for p in datasets(file, "ifS") if file[p].ndim])
    shape, dtype, units = file[path].shape, file[path].dtype, file[path].attrs["units"]
    del file[path]
    file.create_dataset(path, shape=shape, dtype=dtype).attrs["units"] = units


MUTATIONS = {**DAMAGE, **EDITS}
