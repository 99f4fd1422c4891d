"""How datasets lie in a file: in chunks with a checksum each, scalars in their headers, text in fixed length."""

from __future__ import annotations

from typing import Any

import h5py
import numpy as np

from tedm_cli.arrays import AnyArray

_HEADER = 1 << 15  # bytes of a scalar that are kept in its header, which ends at 64 KB


def fixed_length(value: Any) -> AnyArray:
    """Strings as HDF5 stores them in the dataset itself, where a checksum covers them: UTF-8, filled up with zeros."""
    text = np.asarray(value, dtype=object)
    encoded = [str(v).encode() for v in text.ravel()]
    dtype = h5py.string_dtype("utf-8", max([1, *map(len, encoded)]))
    return np.array(encoded, dtype=dtype).reshape(text.shape)


def new_dataset(file: Any, path: str, shape: tuple[int, ...], dtype: Any, chunks: tuple[int, ...]) -> Any:
    """An empty dataset in chunks with a checksum each; a scalar in its header, which has one of its own."""
    if shape:
        options = {} if 0 in shape else {"chunks": chunks, "fletcher32": True}
        return file.create_dataset(path, shape=shape, dtype=dtype, track_times=False, **options)
    how, link = h5py.h5p.create(h5py.h5p.DATASET_CREATE), h5py.h5p.create(h5py.h5p.LINK_CREATE)
    if np.dtype(dtype).itemsize <= _HEADER:
        how.set_layout(h5py.h5d.COMPACT)  # what `create_dataset` has no word for
    how.set_obj_track_times(False)
    link.set_create_intermediate_group(True)
    kind, space = h5py.h5t.py_create(np.dtype(dtype), logical=True), h5py.h5s.create(h5py.h5s.SCALAR)
    return h5py.Dataset(h5py.h5d.create(file.id, path.encode(), kind, space, how, link))
