"""The dimensions of a file as netCDF-4 has them: in every group a scale for each, which holds its labels.

`/S` has its areas in `/area_name`, `/D/translation` in `/D/area`, `/psd/TM1_a_x` its frequencies in `/psd/frequency`:
so xarray and MATLAB find places by name, whichever group they open. A dimension without labels is netCDF's dimension
without coordinates, `n_rank` in the root. A scale is a copy of what the contract calls the label; the readers here do
not use it, but refuse a file where the two differ.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from typing import Any

import h5py

from tedm_cli.arrays import AnyArray
from tedm_cli.contracts import Dataset, FileKind
from tedm_cli.files.datasets import fill, fixed_length, found, opened, say
from tedm_cli.files.elsewhere import kept_elsewhere

_CLASS, _SCALE = "CLASS", b"DIMENSION_SCALE"
_COPIED = ("units", "long_name", "_Encoding")  # attributes of a label that its scales have too
NewDataset = Callable[[str, Any], Any]  # (path, array): an empty dataset for it


class Scales:
    """The scales of a file under construction; `new` makes an empty dataset at a path for an array."""

    def __init__(self, file: Any, kind: FileKind, new: NewDataset) -> None:
        self._file, self._kind, self._new = file, kind, new
        self._made: dict[tuple[str, str], Any] = {}
        self._labels: dict[str | tuple[str, ...], tuple[AnyArray, dict[str, str]]] = {}

    def attach(self, written: Iterable[tuple[Any, Dataset]]) -> None:
        """Tie all datasets to their dimensions, at the end.

        A scale lists the datasets that have it, and HDF5 writes that list anew for each: between data it would leave a
        hole every time, which made a file of many short datasets three times as large as what is in it.
        """
        for dataset, spec in written:
            for axis, dim in enumerate(spec.dims):
                scale = self._scale(dataset, dim, dataset.shape[axis])
                if scale != dataset:  # a dataset that is its own scale has no other
                    dataset.dims[axis].attach_scale(scale)

    def _scale(self, dataset: Any, dim: str, size: int) -> Any:
        group = dataset.name.rpartition("/")[0]
        if (group, dim) not in self._made:
            self._made[group, dim] = self._labelled(group, dim) or self._bare(dim, size)
        return self._made[group, dim]

    def _labelled(self, group: str, dim: str) -> Any | None:
        """The scale of a dimension in a group; None where nothing labels it, or others have its names."""
        label = self._kind.label_of(dim)
        if label is None or (isinstance(label, str) and label not in self._file):
            return None
        if isinstance(label, str) and label == f"{group}/{dim}":
            scale = self._file[label]
        else:
            path = next((p for p in scale_paths(group, dim, label) if p not in self._file), None)
            if path is None:
                return None
            scale = self._copy(path, label)
        scale.make_scale(scale.name.rpartition("/")[2])
        return scale

    def _copy(self, path: str, label: str | tuple[str, ...]) -> Any:
        if label not in self._labels:
            self._labels[label] = self._read(label)
        values, attributes = self._labels[label]
        scale = self._new(path, values)
        fill(scale, values)
        for name, text in attributes.items():
            say(scale, name, text)
        return scale

    def _read(self, label: str | tuple[str, ...]) -> tuple[AnyArray, dict[str, str]]:
        """The values of a label and its attributes, which many groups repeat."""
        if isinstance(label, tuple):
            return fixed_length(label), {"units": "1", "_Encoding": "utf-8"}
        dataset = self._file[label]
        return dataset[()], {name: dataset.attrs[name] for name in _COPIED if name in dataset.attrs}

    def _bare(self, dim: str, size: int) -> Any:
        if ("", f"n_{dim}") not in self._made:
            # netCDF-4's form of a dimension without coordinates: an unwritten dataset of the right length.
            scale = self._file.create_dataset(f"n_{dim}", shape=(size,), dtype="f4", track_times=False)
            scale.make_scale(f"This is a netCDF dimension but not a netCDF variable. {size:10d}")
            self._made["", f"n_{dim}"] = scale
        return self._made["", f"n_{dim}"]


def scale_paths(group: str, dim: str, label: str | tuple[str, ...]) -> Iterator[str]:
    """Where the scale of a dimension in a group may be: called as it is or, where that is taken, as its label."""
    yield f"{group}/{dim}"
    if isinstance(label, str):
        yield f"{group}/{'_'.join(label.strip('/').split('/'))}{'_column' * dim.endswith('_column')}"


def is_scale(file: Any, path: str) -> bool:
    """Whether there is a scale at a path."""
    item = found(file, path)
    return (
        isinstance(item, h5py.Dataset)
        and h5py.h5a.exists(item.id, _CLASS.encode())
        and item.attrs[_CLASS] in (_SCALE, _SCALE.decode())
    )


def scale_problems(file: Any, kind: FileKind, held: dict[str, Dataset]) -> list[str]:
    """Which scales say other things than the labels that they are copies of, of an open file that fits otherwise."""
    problems = []
    labels: dict[str | tuple[str, ...], AnyArray | None] = {}  # values of each, which many groups repeat
    for group, dim in sorted({(path.rpartition("/")[0], dim) for path, spec in held.items() for dim in spec.dims}):
        label = kind.label_of(dim)
        if label is None:
            continue
        if label not in labels:
            labels[label] = _values(file, label)
        if (wanted := labels[label]) is None:
            continue
        for path in scale_paths(group, dim, label):
            if path not in kind.datasets and is_scale(file, path):
                scale, said = opened(file, path), "/".join(label) if isinstance(label, tuple) else label
                if elsewhere := kept_elsewhere(scale):
                    problems.append(f"{path} {elsewhere}")
                elif (scale.shape, scale.dtype) != (wanted.shape, wanted.dtype) or (scale[()] != wanted).any():
                    problems.append(f"{path} labels {dim} otherwise than {said}")
    return problems


def _values(file: Any, label: str | tuple[str, ...]) -> AnyArray | None:
    """The labels of a dimension as an open file has them, None where it has none."""
    if isinstance(label, tuple):
        return fixed_length(label)
    dataset = found(file, label)
    return None if dataset is None else dataset[()]
