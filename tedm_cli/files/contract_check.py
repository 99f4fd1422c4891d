"""Whether an open file fits the contract of its kind: datasets, dimensions, types, units, provenance."""

from __future__ import annotations

import re
from typing import Any

import numpy as np

from tedm_cli.arrays import AnyArray
from tedm_cli.contracts import Dataset, FileKind

DTYPES = {"float": np.float64, "real": np.float64, "int": np.int64}
_HELD = {"float": ("f8",), "real": ("f4", "f8"), "int": ("i8",), "str": ("O8",)}
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
    if spec.open_ended or spec.dtype not in ("float", "real"):
        return ""
    finite = np.isfinite(value)
    bad = finite.size - int(np.count_nonzero(finite))
    return f"{bad:,} of {finite.size:,} numbers are not finite" if bad else ""


def contract_problems(file: Any, kind: FileKind) -> list[str]:
    """What an open file lacks of the contract of its kind, in words."""
    problems = []
    dims = dict(kind.fixed_dims)
    for pattern, spec in kind.datasets.items():
        if "{" in pattern:
            group = pattern.rsplit("/", 1)[0]
            paths = [f"{group}/{name}" for name in file[group]] if group in file else []
        else:
            paths = [pattern]
        if spec.optional and not any(path in file for path in paths):
            continue
        if not paths or paths[0] not in file:
            problems.append(f"{pattern} is missing")
            continue
        for path in paths:
            data = file[path]
            if not hasattr(data, "shape"):
                problems.append(f"{path} is not a dataset")
                continue
            if f"{data.dtype.kind}{data.dtype.itemsize}" not in _HELD[spec.dtype]:
                problems.append(f"{path} holds {data.dtype}, wanted {spec.dtype}")
            problem = shape_problem(spec, data.shape, dims)
            if problem:
                problems.append(f"{path} {problem}")
            elif spec.units is not None and data.attrs.get("units") != spec.units:
                problems.append(f"{path} has units {data.attrs.get('units')!r}, wanted {spec.units!r}")
            elif "units" not in data.attrs:
                problems.append(f"{path} has no units")
    return problems


def provenance_problems(file: Any) -> list[str]:
    """What an open file does not say of its origin, in words."""
    problems = [f"attribute {name} is missing" for name in ("tedm_version", "command_line") if name not in file.attrs]
    for name, fields in PROVENANCE.items():
        paths = [f"/provenance/{name}_{field}" for field in fields]
        missing = [path for path in paths if path not in file]
        problems += [f"{path} is missing" for path in missing]
        if not missing and len({file[path].shape for path in paths}) > 1:
            problems.append(f"{', '.join(paths)} differ in length")
    return problems
