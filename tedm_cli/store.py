"""The only room that touches HDF5: atomic writing and checked reading of the files in `tedm_cli.contracts`.

A file appears under its name only when it is complete: it is written beside the target under a temporary name, its
datasets are checked against the contract, it is closed and synced, and then renamed. Files carry netCDF-4 dimension
scales, so they open in xarray and MATLAB as well. The same contents give the same bytes.
"""

from __future__ import annotations

import contextlib
import errno
import os
import platform
import re
from collections.abc import Iterator, Mapping
from importlib.metadata import version
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

from tedm_cli import __version__
from tedm_cli.contracts import KINDS, Dataset, FileKind
from tedm_cli.errors import InputError, TedmError
from tedm_cli.provenance import ConfigFile, InputFile, Provenance, relative_name

_NODE_CHUNK = 16384  # rows of a chunk along nodes: blocks of about 0.4 MB for one area
_DTYPES = {"float": np.float64, "int": np.int64}


class Writer:
    """A file under construction; made by `create`."""

    def __init__(self, file: Any, kind: FileKind, target: Path) -> None:
        self._file = file
        self._kind = kind
        self._target = target
        self._dims: dict[str, int] = dict(kind.fixed_dims)

    def write(self, path: str, value: Any, *, units: str | None = None) -> None:
        """Write a whole dataset. `units` is required where the contract leaves it open."""
        spec = self._spec(path)
        data = np.asarray(value, dtype=object) if spec.dtype == "str" else np.asarray(value, dtype=_DTYPES[spec.dtype])
        dataset = self._make(path, spec, data.shape, units)
        if data.shape == ():
            dataset[()] = data.item()
        elif data.size:
            dataset[...] = data

    def allocate(self, path: str, shape: tuple[int, ...], *, units: str | None = None) -> Any:
        """Make an empty dataset for a stage that fills it in blocks (`dataset[i] = ...`)."""
        return self._make(path, self._spec(path), shape, units)

    def _spec(self, path: str) -> Dataset:
        return find_spec(self._kind, path)

    def _make(self, path: str, spec: Dataset, shape: tuple[int, ...], units: str | None) -> Any:
        problem = _shape_problem(spec, shape, self._dims)
        if problem:
            raise TedmError(f"internal: {self._kind.name} {path}: {problem}")
        dtype: Any = h5py.string_dtype() if spec.dtype == "str" else _DTYPES[spec.dtype]
        options: dict[str, Any] = {}
        if "node" in spec.dims and 0 not in shape:
            axis = spec.dims.index("node")
            options["chunks"] = tuple(
                1 if i < axis else min(n, _NODE_CHUNK) if i == axis else n for i, n in enumerate(shape)
            )
        dataset = self._file.create_dataset(path, shape=shape, dtype=dtype, track_times=False, **options)
        unit = spec.units if spec.units is not None else units
        if unit is None:
            raise TedmError(f"internal: {self._kind.name} {path}: no unit given")
        dataset.attrs["units"] = unit
        dataset.attrs["long_name"] = spec.long_name
        if spec.frame:
            dataset.attrs["frame"] = spec.frame
        for axis, dim in enumerate(spec.dims):
            dataset.dims[axis].attach_scale(self._scale(dim, shape[axis]))
        return dataset

    def _scale(self, dim: str, size: int) -> Any:
        name = f"n_{dim}"
        if name not in self._file:
            # netCDF-4's form of a dimension without coordinates: an unwritten dataset of the right length.
            scale = self._file.create_dataset(name, shape=(size,), dtype="f4", track_times=False)
            scale.make_scale(f"This is a netCDF dimension but not a netCDF variable. {size:10d}")
        return self._file[name]

    def _finish(self, provenance: Provenance) -> None:
        attrs = self._file.attrs
        attrs["schema"] = f"tedm.{self._kind.name}"
        attrs["schema_version"] = self._kind.version
        attrs["tedm_version"] = __version__
        attrs["command_line"] = provenance.command
        for library in ("numpy", "scipy", "h5py", "pyNastran"):
            attrs[f"{library}_version"] = version(library)
        attrs["python_version"] = platform.python_version()
        folder = self._target.parent
        group = self._file.create_group("provenance")
        string = h5py.string_dtype()
        for name, items in (("config", provenance.configs), ("input", provenance.inputs)):
            for field, values in (
                ("path", [relative_name(i.path, folder) for i in items]),
                ("sha256", [i.sha256 for i in items]),
            ):
                group.create_dataset(f"{name}_{field}", data=values, dtype=string, track_times=False)
        texts = [c.text for c in provenance.configs]
        group.create_dataset("config_text", data=texts, dtype=string, track_times=False)
        problems = _contract_problems(self._file, self._kind)
        if problems:
            raise TedmError(f"internal: {self._kind.name} was written incompletely: {'; '.join(problems)}")


class Reader:
    """An open file whose contract has been checked; made by `open_checked`."""

    def __init__(self, file: Any, kind: FileKind, path: Path) -> None:
        self._file = file
        self.kind = kind
        self.path = path

    def has(self, path: str) -> bool:
        return path in self._file

    def array(self, path: str) -> NDArray[Any]:
        """The whole dataset as float64 or int64."""
        return np.asarray(self._file[path][()])

    def strings(self, path: str) -> list[str]:
        return [str(s) for s in self._file[path].asstr()[()]]

    def string(self, path: str) -> str:
        return str(self._file[path].asstr()[()])

    def number(self, path: str) -> float:
        return float(self._file[path][()])

    def dataset(self, path: str) -> Any:
        """The dataset itself, for stages that read it in blocks."""
        return self._file[path]

    def names(self, group: str) -> list[str]:
        """Names of the datasets in a group, in alphabetical order."""
        return sorted(self._file[group])

    def units(self, path: str) -> str:
        return str(self._file[path].attrs["units"])

    @property
    def attributes(self) -> dict[str, Any]:
        return dict(self._file.attrs)

    def provenance(self) -> Provenance:
        """Configurations and inputs, with their paths resolved from this file's folder."""
        group = self._file["provenance"]
        folder = self.path.parent

        def column(name: str) -> list[str]:
            return [str(v) for v in group[name].asstr()[()]] if group[name].size else []

        configs = tuple(
            ConfigFile(folder / p, t, h)
            for p, t, h in zip(column("config_path"), column("config_text"), column("config_sha256"), strict=True)
        )
        inputs = tuple(
            InputFile(folder / p, h) for p, h in zip(column("input_path"), column("input_sha256"), strict=True)
        )
        return Provenance(configs, inputs, str(self._file.attrs["command_line"]))

    def table(self) -> Iterator[tuple[str, tuple[int, ...], str, str]]:
        """(path, shape, unit, meaning) of every dataset of the contract that the file holds."""
        found: list[tuple[str, tuple[int, ...], str, str]] = []

        def visit(name: str, item: Any) -> None:
            path = "/" + name
            if isinstance(item, h5py.Dataset) and "units" in item.attrs:
                found.append((path, tuple(item.shape), str(item.attrs["units"]), str(item.attrs["long_name"])))

        self._file.visititems(visit)
        yield from found


@contextlib.contextmanager
def create(path: Path, kind: FileKind, provenance: Provenance) -> Iterator[Writer]:
    """Write a file of `kind` atomically; on any failure the file that was there before stays as it was."""
    with replacing(path) as temporary:
        file = h5py.File(temporary, "w", libver="v110")
        try:
            writer = Writer(file, kind, path)
            yield writer
            writer._finish(provenance)
        except BaseException:
            with contextlib.suppress(OSError, RuntimeError):
                file.close()
            raise
        file.close()


@contextlib.contextmanager
def replacing(path: Path) -> Iterator[Path]:
    """A temporary path beside `path` that becomes `path` when the block ends without an exception.

    Used for every file a stage makes, HDF5 or not. Temporaries that a killed run of the same target left are removed.
    """
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        for orphan in path.parent.glob(f".{path.name}.*.tmp"):
            if not _alive(orphan):
                orphan.unlink(missing_ok=True)
    except OSError as exc:
        raise _cannot_write(path, exc) from exc
    temporary = path.with_name(f".{path.name}.{os.getpid()}.tmp")
    try:
        yield temporary
        with open(temporary, "rb+") as stream:
            os.fsync(stream.fileno())
        os.replace(temporary, path)
    except OSError as exc:
        raise _cannot_write(path, exc) from exc
    except RuntimeError as exc:
        # h5py reports a failed flush as RuntimeError when it notices only on closing; others are not about writing.
        if re.match(r"(Unable to|Can't) ", str(exc)):
            raise _cannot_write(path, exc) from exc
        raise
    finally:
        temporary.unlink(missing_ok=True)


def _alive(temporary: Path) -> bool:
    match = re.search(r"\.(\d+)\.tmp$", temporary.name)
    if match is None:
        return True
    try:
        os.kill(int(match.group(1)), 0)
    except ProcessLookupError:
        return False
    except PermissionError:
        return True
    return True


def _cannot_write(path: Path, exc: Exception) -> InputError:
    number = getattr(exc, "errno", None)
    text = str(exc)
    full = number in (errno.ENOSPC, errno.EFBIG, errno.EDQUOT) or "No space left" in text or "File too large" in text
    fact = "no room left to write it" if full else f"cannot be written ({os.strerror(number) if number else text})"
    return InputError(f"{fact}; the previous file, if any, is untouched", where=str(path))


@contextlib.contextmanager
def open_checked(path: Path, kind: FileKind) -> Iterator[Reader]:
    """Open a file for reading after checking its kind, version and contract.

    Raises
    ------
    InputError : missing, not HDF5, of another kind or version, or with datasets that do not fit the contract.
    """
    rebuild = f"make it with `{kind.made_by}`"
    try:
        file = h5py.File(path, "r")
    except FileNotFoundError as exc:
        raise InputError("no such file", where=str(path), hint=rebuild) from exc
    except OSError as exc:
        raise InputError("not a readable HDF5 file (truncated or damaged)", where=str(path), hint=rebuild) from exc
    with file:
        schema = str(file.attrs.get("schema", ""))
        if schema != f"tedm.{kind.name}":
            raise InputError(
                f"holds {schema or 'no tedm schema'}, wanted tedm.{kind.name}", where=str(path), hint=rebuild
            )
        found = int(file.attrs.get("schema_version", -1))
        if found != kind.version:
            raise InputError(
                f"schema version {found}, this tedm reads {kind.version}", where=str(path), hint=f"re{rebuild}"
            )
        problems = _contract_problems(file, kind)
        if problems:
            raise InputError("; ".join(problems), where=str(path), hint=f"re{rebuild}")
        yield Reader(file, kind, path)


def kind_of(path: Path) -> FileKind:
    """The kind of a file, from its schema attribute."""
    try:
        with h5py.File(path, "r") as file:
            schema = str(file.attrs.get("schema", ""))
    except FileNotFoundError as exc:
        raise InputError("no such file", where=str(path)) from exc
    except OSError as exc:
        raise InputError("not a readable HDF5 file (truncated or damaged)", where=str(path)) from exc
    kind = KINDS.get(schema.removeprefix("tedm."))
    if kind is None:
        raise InputError(f"holds {schema or 'no tedm schema'}", where=str(path), hint=f"known: {', '.join(KINDS)}")
    return kind


def find_spec(kind: FileKind, path: str) -> Dataset:
    """The contract of one dataset, templates (`/psd/{output}`) included."""
    if path in kind.datasets:
        return kind.datasets[path]
    for pattern, spec in kind.datasets.items():
        if "{" in pattern and re.fullmatch(re.sub(r"\\{\w+\\}", "[^/]+", re.escape(pattern)), path):
            return spec
    raise TedmError(f"internal: {kind.name} has no dataset {path} in its contract")


def _shape_problem(spec: Dataset, shape: tuple[int, ...], dims: dict[str, int]) -> str:
    if len(shape) != len(spec.dims):
        return f"has {len(shape)} dimensions, wanted {len(spec.dims)} ({', '.join(spec.dims)})"
    for dim, size in zip(spec.dims, shape, strict=True):
        known = dims.setdefault(dim, size)
        if known != size:
            return f"{size} along {dim}, where other datasets have {known}"
    return ""


def _contract_problems(file: Mapping[str, Any], kind: FileKind) -> list[str]:
    problems = []
    dims = dict(kind.fixed_dims)
    for pattern, spec in kind.datasets.items():
        if "{" in pattern:
            group = pattern.rsplit("/", 1)[0]
            paths = [f"{group}/{name}" for name in file[group]] if group in file else []
        else:
            paths = [pattern]
            if pattern not in file and spec.optional:
                continue
        if not paths or paths[0] not in file:
            problems.append(f"{pattern} is missing")
            continue
        for path in paths:
            data = file[path]
            if not isinstance(data, h5py.Dataset):
                problems.append(f"{path} is not a dataset")
                continue
            wanted = "O" if spec.dtype == "str" else np.dtype(_DTYPES[spec.dtype]).kind
            if data.dtype.kind != wanted:
                problems.append(f"{path} holds {data.dtype}, wanted {spec.dtype}")
            problem = _shape_problem(spec, data.shape, dims)
            if problem:
                problems.append(f"{path} {problem}")
            elif spec.units is not None and data.attrs.get("units") != spec.units:
                problems.append(f"{path} has units {data.attrs.get('units')!r}, wanted {spec.units!r}")
    return problems
