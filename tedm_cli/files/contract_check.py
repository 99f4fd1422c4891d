"""Whether an open file fits the contract of its kind: its parts are in it, and have their types, shapes and units."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from tedm_cli.arrays import AnyArray
from tedm_cli.contracts import Dataset, FileKind
from tedm_cli.files.contract_values import value_problems
from tedm_cli.files.datasets import found
from tedm_cli.files.elsewhere import kept_elsewhere, links_elsewhere
from tedm_cli.files.scales import is_scale, scale_problems
from tedm_cli.files.views import view_source

DTYPES = {"float": np.float64, "real": np.float64, "int": np.int64, "complex": np.complex128}
_HELD = {"float": ("f8",), "real": ("f4", "f8"), "int": ("i8",), "complex": ("c16",)}
_WORDS = {"str": "strings of fixed length"}
PROVENANCE = {"config": ("path", "sha256", "text"), "input": ("path", "sha256")}


def find_spec(kind: FileKind, path: str) -> Dataset:
    """The contract of one dataset, templates (`/psd/{output}`) included."""
    if path in kind.datasets:
        return kind.datasets[path]
    for pattern, spec in kind.datasets.items():
        if "{" in pattern and re.fullmatch(re.sub(r"\\{\w+\\}", "[^/]+", re.escape(pattern)), path):
            return spec
    raise KeyError(f"{kind.name} has no dataset {path} in its contract")


def shape_problem(spec: Dataset, shape: tuple[int, ...], dims: dict[str, int]) -> str:
    """What is wrong with the shape of a dataset; sizes met for the first time are added to `dims`."""
    if len(shape) != len(spec.dims):
        return f"has {len(shape)} dimensions, wanted {len(spec.dims)} ({', '.join(spec.dims)})"
    for dim, size in zip(spec.dims, shape, strict=True):
        known = dims.setdefault(dim, size)
        if known != size:
            return f"{size} along {dim}, where other datasets have {known}"
    return ""


def finite_problem(spec: Dataset, value: AnyArray) -> str:
    """What is wrong with numbers that are to be written: any that is not finite, unless the contract allows it."""
    if spec.open_ended or spec.dtype not in ("float", "real", "complex"):
        return ""
    finite = np.isfinite(value)
    bad = finite.size - int(np.count_nonzero(finite))
    return f"{bad:,} of {finite.size:,} numbers are not finite" if bad else ""


def contract_problems(file: Any, kind: FileKind, where: Path) -> list[str]:
    """What an open file lacks of the contract of its kind, in words; `InputError` names `where` if it is unreadable."""
    problems = links_elsewhere(file, soft=True)
    if problems:
        return problems
    dims = dict(kind.fixed_dims)
    held: dict[str, Dataset] = {}
    for pattern, spec in kind.datasets.items():
        items = {path: found(file, path) for path in _paths(file, pattern, spec.dims)}
        if all(item is None for item in items.values()):
            problems += [] if spec.optional else [f"{pattern} is missing"]
            continue
        for path, item in items.items():
            wrong = [*_dataset_problems(item, spec, dims)]
            problems += [f"{path} {problem}" for problem in wrong]
            if not wrong:
                held[path] = spec
    for dim, (base, factor, addend) in kind.derived_dims.items():
        if dim in dims and base in dims and dims[dim] != factor * dims[base] + addend:
            problems.append(f"{dims[dim]} along {dim}, wanted {factor * dims[base] + addend} ({kind.length_law(dim)})")
    return problems or value_problems(file, kind, held, dims, where) or scale_problems(file, kind, held)


def _paths(file: Any, pattern: str, dims: tuple[str, ...]) -> list[str]:
    """The dataset of a path, or all of a family, one name for each pair of braces; without the scales of its `dims`."""
    if "{" not in pattern:
        return [pattern]
    paths = [""]
    for part in pattern.strip("/").split("/"):
        if "{" not in part:
            paths = [f"{path}/{part}" for path in paths]
            continue
        groups = [(path, item) for path in paths if isinstance(item := found(file, path), h5py.Group)]
        paths = [f"{path}/{name}" for path, group in groups for name in group]
        paths = [p for p in paths if p.rpartition("/")[2] not in dims or not is_scale(file, p)]
    return paths


def _dataset_problems(data: Any, spec: Dataset, dims: dict[str, int]) -> Iterator[str]:
    shape = getattr(data, "shape", None)
    if shape is None:
        yield "is not a dataset"
        return
    if elsewhere := kept_elsewhere(data, view_source(spec)):
        yield elsewhere
        return
    dtype = data.dtype  # asked for once, as HDF5 is each time
    fits = dtype.kind == "S" if spec.dtype == "str" else f"{dtype.kind}{dtype.itemsize}" in _HELD[spec.dtype]
    if not fits:
        yield f"holds {dtype}, wanted {_WORDS.get(spec.dtype, spec.dtype)}"
    problem = shape_problem(spec, shape, dims)
    units = attribute_text(data, "units")
    if problem:
        yield problem
    elif units is None:
        yield "has no units"
    elif spec.units is not None and units != spec.units:
        yield f"has units {units!r}, wanted {spec.units!r}"


def attribute_text(item: Any, name: str) -> str | None:
    """An attribute as text, None where there is none; what is no string is shown as Python would."""
    try:
        value = h5py.AttributeManager(item)[name]
    except KeyError:
        return None
    return value.decode("utf-8", "replace") if isinstance(value, bytes) else str(value)


def provenance_problems(file: Any) -> list[str]:
    """What an open file does not say of its origin, in words."""
    problems = [f"attribute {name} is missing" for name in ("tedm_version", "command_line") if name not in file.attrs]
    for name, fields in PROVENANCE.items():
        paths = [f"/provenance/{name}_{field}" for field in fields]
        found = [path for path in paths if path in file]
        problems += [f"{path} is missing" for path in paths if path not in file]
        wrong = [path for path in found if getattr(file[path], "ndim", None) != 1 or file[path].dtype.kind != "S"]
        problems += [f"{path} is not a list of strings of fixed length" for path in wrong]
        if len(found) == len(paths) and not wrong and len({file[path].shape for path in paths}) > 1:
            problems.append(f"{', '.join(paths)} differ in length")
    return problems
