"""Parts of an HDF5 file that are kept in other files: the sums and paths of a file say nothing of them."""

from __future__ import annotations

from math import prod
from typing import Any

import h5py


def links_elsewhere(file: Any, *, soft: bool) -> list[str]:
    """The links of an open file that lead to another, in words; with `soft` also those that lead to a path in it.

    They are not followed. Without external links a soft link cannot leave the file.
    """
    found: list[str] = []

    def visit(name: bytes | str, info: Any) -> None:
        path = name.decode("utf-8", "replace") if isinstance(name, bytes) else name
        if info.type == h5py.h5l.TYPE_SOFT:
            found.extend([f"/{path} is a soft link, wanted the data themselves"] * soft)
        elif info.type != h5py.h5l.TYPE_HARD:
            found.append(f"/{path} is a link to another file, wanted the data themselves")

    file.id.links.visit(visit, info=True)
    return found


def kept_elsewhere(dataset: Any, view_of: tuple[str, str] | None = None) -> str:
    """Why the values of a dataset are not in its file; empty when they are, or are where they may be.

    `view_of` : a file beside its own and a path in it, of which the dataset may be a view.
    """
    how = dataset.id.get_create_plist()  # asked for once, as HDF5 copies it each time
    layout = how.get_layout()
    if layout == h5py.h5d.COMPACT:
        return ""
    if layout == h5py.h5d.VIRTUAL:
        return _view_problem(how, dataset.shape, view_of)
    if how.get_external_count():
        return f"keeps its values in another file ({dataset.external[0][0]}), wanted the data themselves"
    shape, chunk_shape = dataset.shape, how.get_chunk() if layout == h5py.h5d.CHUNKED else None
    if 0 in shape:
        return ""
    if chunk_shape is None:
        whole = dataset.id.get_storage_size() >= prod(shape) * dataset.dtype.itemsize
    else:
        chunks = prod(-(-length // chunk) for length, chunk in zip(shape, chunk_shape, strict=True))
        whole = dataset.id.get_num_chunks() >= chunks
    return "" if whole else "lacks values: it was not written to its end"


def _view_problem(how: Any, shape: tuple[int, ...], view_of: tuple[str, str] | None) -> str:
    """What is wrong with a virtual dataset; its source is not opened, as it may be any file."""
    if view_of is None:
        return "is a virtual dataset, wanted the data themselves"
    whole = False
    if how.get_virtual_count() == 1:
        sides = (how.get_virtual_vspace(0), how.get_virtual_srcspace(0))
        source = (how.get_virtual_filename(0), how.get_virtual_dsetname(0))
        whole = source == view_of and all(
            side.get_simple_extent_dims() == shape and side.get_select_npoints() == prod(shape) for side in sides
        )
    return "" if whole else f"is a virtual dataset of other data than {view_of[1]} of {view_of[0]}, whole"
