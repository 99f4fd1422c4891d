"""Datasets that are views of one in a file beside their own: the numbers are on the disk once.

Other programs follow them by HDF5 itself. It reads zeros where the file is gone, and whatever is in another one of its
name. So the readers here take the numbers from that file, once it has proved to be the one that the view was made of.
"""

from __future__ import annotations

import contextlib
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from tedm_cli.contracts import Dataset
from tedm_cli.errors import InputError
from tedm_cli.files.blocks import Blocks, reading
from tedm_cli.files.datasets import opened
from tedm_cli.files.provenance import InputFile
from tedm_cli.files.sealed_file import sealed


def view_source(spec: Dataset) -> tuple[str, str] | None:
    """The file beside its own that a dataset may be a view of, and the path in it."""
    return None if spec.view_of is None else (f"{spec.view_of[0]}.h5", spec.view_of[1])


def make_view(file: Any, path: str, shape: tuple[int, ...], dtype: Any, source: tuple[str, str]) -> Any:
    """A virtual dataset onto a whole one of the same shape and type: `source` is a file beside this, and a path."""
    how, link = h5py.h5p.create(h5py.h5p.DATASET_CREATE), h5py.h5p.create(h5py.h5p.LINK_CREATE)
    space, there = h5py.h5s.create_simple(shape), h5py.h5s.create_simple(shape)
    there.select_hyperslab((0,) * len(shape), (1,) * len(shape), block=shape)  # of "all" HDF5 keeps no extent
    how.set_virtual(space, source[0].encode(), source[1].encode(), there)
    how.set_obj_track_times(False)
    link.set_create_intermediate_group(True)
    kind = h5py.h5t.py_create(np.dtype(dtype), logical=True)
    return h5py.Dataset(h5py.h5d.create(file.id, path.encode(), kind, space, how, link))


def is_view(dataset: Any) -> bool:
    """Whether a dataset is a virtual one."""
    return bool(dataset.id.get_create_plist().get_layout() == h5py.h5d.VIRTUAL)


class ViewSources:
    """The files that views in the file `path` are of: each is opened when it is asked for, until `close`."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._files: dict[str, Any] = {}
        self._open = contextlib.ExitStack()

    def close(self) -> None:
        self._open.close()
        self._files.clear()

    def blocks(self, found: Any, spec: Dataset, made_by: str, inputs: Iterable[InputFile]) -> Blocks:
        """The numbers of a view `found`, from the file that has them.

        Parameters
        ----------
        spec, made_by, inputs : of the file with the view: the contract of the dataset, its command, its provenance.

        Raises
        ------
        InputError : that file is not beside, is damaged, or is another than the view was made of.
        """
        source = view_source(spec)
        if source is None:
            raise InputError(f"{spec} is a virtual dataset, wanted the data themselves", where=str(self._path))
        name, path = source
        if name not in self._files:
            self._files[name] = self._source(name, spec, made_by, inputs)
        beside = self._path.parent / name
        with reading(beside, path):
            held = opened(self._files[name], path)
        if (held.shape, held.dtype) != (found.shape, found.dtype):
            fact = f"{spec} has {found.shape} {found.dtype}, {path} of {name} {held.shape} {held.dtype}"
            raise InputError(fact, where=str(self._path), hint=f"remake it with `{made_by}`, or `tedm run`")
        return Blocks(held, beside)

    def _source(self, name: str, spec: Dataset, made_by: str, inputs: Iterable[InputFile]) -> Any:
        beside = self._path.parent / name
        hint = f"keep the two together, or remake {self._path.name} with `{made_by}`, or `tedm run`"
        if not beside.exists():
            raise InputError(f"{spec} is a view of {name}, which is not beside it", where=str(self._path), hint=hint)
        file, sha256 = self._open.enter_context(sealed(beside, hint))
        if sha256 not in {item.sha256 for item in inputs if item.path.name == name}:
            fact = f"is stale: {spec} is a view of {beside}, which is not as it was then"
            raise InputError(fact, where=str(self._path), hint=hint)
        return file
