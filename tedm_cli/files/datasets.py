"""How datasets lie in a file: in chunks with a checksum each, scalars in their headers, text in fixed length."""

from __future__ import annotations

from typing import Any

import h5py
import numpy as np

from tedm_cli.arrays import AnyArray

_TEXT = h5py.string_dtype()
_TEXT_ID, _ONE = h5py.h5t.py_create(_TEXT, logical=True), h5py.h5s.create(h5py.h5s.SCALAR)
_HEADER = 1 << 15  # bytes of a scalar that are kept in its header, which ends at 64 KB


def fixed_length(value: Any) -> AnyArray:
    """Strings as HDF5 stores them in the dataset itself, where a checksum covers them: UTF-8, filled up with zeros."""
    text = np.asarray(value, dtype=object)
    encoded = [str(v).encode() for v in text.ravel()]
    dtype = h5py.string_dtype("utf-8", max([1, *map(len, encoded)]))
    return np.array(encoded, dtype=dtype).reshape(text.shape)


def new_dataset(file: Any, path: str, shape: tuple[int, ...], dtype: Any, chunks: tuple[int, ...]) -> Any:
    """An empty dataset in chunks with a checksum each; a scalar in its header, which has one of its own.

    In the words of HDF5: those of h5py take several times as long, and have none for a header.
    """
    how, link = h5py.h5p.create(h5py.h5p.DATASET_CREATE), h5py.h5p.create(h5py.h5p.LINK_CREATE)
    if shape and 0 not in shape:
        how.set_chunk(chunks)
        how.set_fletcher32()
    elif not shape and np.dtype(dtype).itemsize <= _HEADER:
        how.set_layout(h5py.h5d.COMPACT)
    how.set_obj_track_times(False)
    link.set_create_intermediate_group(True)
    if not path.isascii():
        link.set_char_encoding(h5py.h5t.CSET_UTF8)
    space = h5py.h5s.create_simple(shape) if shape else h5py.h5s.create(h5py.h5s.SCALAR)
    kind = h5py.h5t.py_create(np.dtype(dtype), logical=True)
    return h5py.Dataset(h5py.h5d.create(file.id, path.encode(), kind, space, how, link))


def fill(dataset: Any, data: AnyArray) -> None:
    """Write all values of a dataset that has the shape and type of `data`, with none of h5py's choosing of places."""
    if data.size:
        dataset.id.write(h5py.h5s.ALL, h5py.h5s.ALL, np.ascontiguousarray(data).reshape(data.shape))


def say(item: Any, name: str, text: str) -> None:
    """Give a new attribute to an object that has none of this name; `item.attrs[name] = text` takes twice as long."""
    attribute = h5py.h5a.create(item.id, name.encode(), _TEXT_ID, _ONE)
    attribute.write(np.array(text, dtype=_TEXT))


def opened(file: Any, path: str) -> Any:
    """What is at a path, as `file[path]`, which takes several times as long: it asks for the file of each anew."""
    item = h5py.h5o.open(file.id, path.encode("utf-8", "surrogateescape"))
    return h5py.Dataset(item, readonly=True) if isinstance(item, h5py.h5d.DatasetID) else file[path]


def found(file: Any, path: str) -> Any | None:
    """What is at a path; None where nothing is."""
    try:
        return opened(file, path)
    except KeyError:
        return None


def texts(dataset: Any) -> list[str]:
    """The strings of fixed length that a dataset holds, in one list."""
    return [v.decode() for v in np.atleast_1d(dataset[()]).ravel().tolist()]
