"""The only room that touches HDF5: atomic writing and checked reading of the files in `tedm_cli.contracts`.

A file appears under its name only when it is complete: it is written beside the target under a temporary name, its
datasets are checked against the contract, it is closed and synced, and then renamed. Files carry netCDF-4 dimension
scales, so they open in xarray and MATLAB as well. The same contents give the same bytes.
"""

from __future__ import annotations

import contextlib
import errno
import glob
import os
import platform
import re
from collections.abc import Iterator
from functools import cache, partial
from importlib.metadata import version
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from tedm_cli import __version__
from tedm_cli.arrays import AnyArray
from tedm_cli.contracts import KINDS, Dataset, FileKind
from tedm_cli.contracts.spec import ON_GRIDS
from tedm_cli.errors import InputError, PhysicsError, TedmError
from tedm_cli.files.blocks import BLOCK_NODES, Allocated, Blocks, narrowed, reading
from tedm_cli.files.contract_check import (
    DTYPES,
    PROVENANCE,
    attribute_text,
    contract_problems,
    find_spec,
    finite_problem,
    provenance_problems,
    shape_problem,
)
from tedm_cli.files.datasets import fill, fixed_length, new_dataset, opened, say, texts
from tedm_cli.files.held_file import HeldFile, Sink
from tedm_cli.files.processes import is_alive
from tedm_cli.files.provenance import ConfigFile, InputFile, Provenance, absolute_path, relative_name
from tedm_cli.files.scales import Scales, is_scale
from tedm_cli.files.seal import seal
from tedm_cli.files.sealed_file import NO_CACHE, sealed
from tedm_cli.files.views import ViewSources, is_view, make_view, view_source
from tedm_cli.interrupts import unfinished, whole

_SHOWN = 5  # problems of one file that a message lists
_NAME_BYTES = 200  # of a target's name in that of its temporary, which must not be too long where the target's is not
_CHUNKED = ("node", "offset_node", "sample")  # dimensions that grow with the model
_version_of = cache(version)  # each asks for the metadata of the installed package anew
_fitting: set[tuple[str, str]] = set()  # SHA-256 and kind of the files whose contents this process has found to fit


class Writer:
    """A file under construction; made by `create`."""

    def __init__(self, file: Any, kind: FileKind, target: Path, sink: Sink) -> None:
        self._file = file
        self._kind = kind
        self._target = target
        self._sink = sink
        self._dims: dict[str, int] = dict(kind.fixed_dims)
        self._written: list[tuple[Any, Dataset]] = []

    def write(self, path: str, value: Any, *, units: str | None = None, single: bool = False) -> None:
        """Write a whole dataset. `units` is required where the contract leaves it open; `single` as for `allocate`."""
        spec = self._spec(path)
        data = fixed_length(value) if spec.dtype == "str" else np.asarray(value, dtype=DTYPES[spec.dtype])
        self._require_finite(path, spec, data)
        data = narrowed(data) if single else data
        dataset = self._make(path, spec, data.shape, data.dtype, units)
        fill(dataset, data)
        self._sink.check()

    def allocate(
        self, path: str, shape: tuple[int, ...], *, units: str | None = None, single: bool = False
    ) -> Allocated:
        """Make an empty dataset for a stage that fills it in blocks (`dataset[i] = ...`).

        With `single` (for the contract's `real` alone) it takes half the room and `PrecisionLossError` says where that
        would change a number.
        """
        spec = self._spec(path)
        check = partial(self._require_finite, path, spec)
        dtype = np.float32 if single else DTYPES[spec.dtype]
        return Allocated(self._make(path, spec, shape, dtype, units), self._sink, check)

    def view(self, path: str, source: Reader) -> bool:
        """Make a dataset a view of the one in `source` that its contract allows, in place of its numbers.

        False, and nothing is made, where the two files are not in one folder: together they can be moved.
        """
        spec = self._spec(path)
        wanted = view_source(spec)
        if wanted is None:
            raise TedmError(f"internal: {self._kind.name} {path} is no view of anything")
        beside = self._target.parent / wanted[0]
        if not (beside.exists() and os.path.samefile(beside, source.path)):
            return False
        held = source.dataset(wanted[1])
        dtype = np.float32 if held.single else DTYPES[spec.dtype]
        self._require_shape(path, spec, held.shape)
        self._describe(make_view(self._file, path, held.shape, dtype, wanted), spec, None)
        return True

    def _require_finite(self, path: str, spec: Dataset, value: AnyArray) -> None:
        """The last line of defence: a result that is not finite is none."""
        if problem := finite_problem(spec, value):
            raise PhysicsError(
                f"nothing is written: of {path} {problem}",
                where=str(self._target),
                hint="a number of the configuration or of an input is far from what it stands for; look for the largest"
                " and the smallest",
            )

    def _spec(self, path: str) -> Dataset:
        return find_spec(self._kind, path)

    def _make(self, path: str, spec: Dataset, shape: tuple[int, ...], dtype: Any, units: str | None) -> Any:
        self._require_shape(path, spec, shape)
        axis = next((i for i, dim in enumerate(spec.dims) if dim in _CHUNKED), 0)
        chunks = tuple(1 if i < axis else min(n, BLOCK_NODES) if i == axis else n for i, n in enumerate(shape))
        return self._describe(new_dataset(self._file, path, shape, dtype, chunks), spec, units)

    def _require_shape(self, path: str, spec: Dataset, shape: tuple[int, ...]) -> None:
        problem = shape_problem(spec, shape, self._dims)
        if problem:
            raise TedmError(f"internal: {self._kind.name} {path}: {problem}")

    def _describe(self, dataset: Any, spec: Dataset, units: str | None) -> Any:
        """Give a new dataset its attributes."""
        unit = spec.units if spec.units is not None else units
        if unit is None:
            raise TedmError(f"internal: {self._kind.name} {dataset.name}: no unit given")
        say(dataset, "units", unit)
        say(dataset, "long_name", spec.long_name)
        if spec.frame:
            say(dataset, "frame", spec.frame)
        if spec.dtype == "str":
            say(dataset, "_Encoding", "utf-8")  # netCDF's: xarray makes strings of the bytes
        self._written.append((dataset, spec))
        return dataset

    def _chunked(self, path: str, values: Any) -> Any:
        """An empty dataset for the labels of a dimension."""
        return new_dataset(self._file, path, values.shape, values.dtype, (min(len(values), BLOCK_NODES),))

    def finish(self, provenance: Provenance) -> None:
        """Say where the file is from, and check it against its contract."""
        Scales(self._file, self._kind, self._chunked).attach(self._written)
        attrs = self._file.attrs
        attrs["schema"] = f"tedm.{self._kind.name}"
        attrs["schema_version"] = self._kind.version
        attrs["tedm_version"] = __version__
        attrs["command_line"] = provenance.command
        for library in ("numpy", "scipy", "h5py", "pyNastran"):
            attrs[f"{library}_version"] = _version_of(library)
        attrs["python_version"] = platform.python_version()
        folder = self._target.parent
        for name, items in (("config", provenance.configs), ("input", provenance.inputs)):
            for field in PROVENANCE[name]:
                values = [relative_name(i.path, folder) if field == "path" else getattr(i, field) for i in items]
                data = fixed_length(values)
                dataset = new_dataset(self._file, f"/provenance/{name}_{field}", data.shape, data.dtype, data.shape)
                fill(dataset, data)
        problems = contract_problems(self._file, self._kind, self._target) + provenance_problems(self._file)
        if problems:
            raise TedmError(f"internal: {self._kind.name} was written incompletely: {'; '.join(problems)}")


class Reader:
    """An open file whose contract has been checked; made by `open_checked`."""

    def __init__(self, file: Any, kind: FileKind, path: Path) -> None:
        self._file = file
        self.kind = kind
        self.path = path
        self._sources = ViewSources(path)

    def close(self) -> None:
        """Close what was opened beside the file itself."""
        self._sources.close()

    def has(self, path: str) -> bool:
        return path in self._file

    def array(self, path: str) -> AnyArray:
        """The whole dataset as float64, int64 or complex128."""
        return self.dataset(path)[()]

    def strings(self, path: str) -> list[str]:
        with reading(self.path, path):
            return texts(opened(self._file, path))

    def string(self, path: str) -> str:
        with reading(self.path, path):
            return texts(opened(self._file, path))[0]

    def number(self, path: str) -> float:
        return float(self.dataset(path)[()])

    def dataset(self, path: str) -> Blocks:
        """A numeric dataset, for stages that read it in blocks; `InputError` where a family of datasets lacks it."""
        try:
            found = opened(self._file, path)
        except KeyError:
            raise self.absent(path) from None
        if not is_view(found):
            return Blocks(found, self.path)
        return self._sources.blocks(found, find_spec(self.kind, path), self.kind.made_by, self.provenance().inputs)

    def absent(self, path: str) -> InputError:
        """The error for a dataset that is not there, be it one that is kept only where all results were."""
        spec = self.kind.datasets.get(path)
        if spec is None or spec.comes_with != ON_GRIDS:
            return InputError(
                f"has no {path}", where=str(self.path), hint=f"make it with `{self.kind.made_by}`, or `tedm run`"
            )
        return InputError(
            f"has no displacements of grids ({path}): its results were reduced without keeping them",
            where=str(self.path),
            hint="`tedm ingest` and `tedm build-distortion` keep them",
        )

    def units(self, path: str) -> str:
        with reading(self.path, path):
            return attribute_text(opened(self._file, path), "units") or ""

    @property
    def attributes(self) -> dict[str, str | int | float | list[Any]]:
        """The attributes of the file; what is neither text nor numbers as text."""
        with reading(self.path):
            return {str(name): _plain(value) for name, value in self._file.attrs.items()}

    def provenance(self) -> Provenance:
        """Configurations and inputs, with their paths resolved from this file's folder."""

        def column(name: str) -> list[str]:
            return self.strings(f"/provenance/{name}") if self._file[f"/provenance/{name}"].size else []

        def paths(name: str) -> list[Path]:
            return [absolute_path(p, self.path.parent) for p in column(name)]

        configs = zip(paths("config_path"), column("config_text"), column("config_sha256"), strict=True)
        inputs = zip(paths("input_path"), column("input_sha256"), strict=True)
        return Provenance(
            tuple(ConfigFile(*c) for c in configs),
            tuple(InputFile(*i) for i in inputs),
            attribute_text(self._file, "command_line") or "",
        )

    def table(self) -> Iterator[tuple[str, tuple[int, ...], str, str]]:
        """(path, shape, unit, meaning) of every dataset of the contract that the file holds."""
        found: list[tuple[str, tuple[int, ...], str, str]] = []

        def visit(name: str, item: Any) -> None:
            path = "/" + name
            labels = path not in self.kind.datasets and is_scale(self._file, path)
            if isinstance(item, h5py.Dataset) and "units" in item.attrs and not labels:
                with contextlib.suppress(KeyError):  # what a user has added is not of the contract
                    meaning = find_spec(self.kind, path).long_name
                    found.append((path, tuple(item.shape), attribute_text(item, "units") or "", meaning))

        with reading(self.path):
            self._file.visititems(visit)
        yield from found


@contextlib.contextmanager
def create(path: Path, kind: FileKind, provenance: Provenance) -> Iterator[Writer]:
    """Write a file of `kind` atomically; on any failure the file that was there before stays as it was."""
    with replacing(path) as temporary, contextlib.closing(HeldFile(temporary)) as sink:
        with h5py.File(sink, "w", libver="v110", rdcc_nbytes=NO_CACHE) as file:
            writer = Writer(file, kind, path, sink)
            yield writer
            writer.finish(provenance)
        sink.check()
        _fitting.add((seal(temporary), kind.name))  # `finish` has compared it with its contract


def _plain(value: Any) -> str | int | float | list[Any]:
    """The value of an attribute as JSON has it."""
    if isinstance(value, bytes):
        return value.decode("utf-8", "replace")
    if isinstance(value, np.ndarray | np.generic):
        return value.tolist() if value.dtype.kind in "biuf" else [_plain(v) for v in np.ravel(value)]
    return value if isinstance(value, str | int | float) else str(value)


@contextlib.contextmanager
@whole
def replacing(path: Path) -> Iterator[Path]:
    """A temporary path beside `path` that becomes `path` when the block ends without an exception.

    Used for every file a stage makes, HDF5 or not. Temporaries that a killed run of the same target left are removed.
    """
    name = f".{os.fsdecode(os.fsencode(path.name)[:_NAME_BYTES])}."
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        for orphan in path.parent.glob(f"{glob.escape(name)}*.tmp"):
            if not _alive(orphan):
                orphan.unlink(missing_ok=True)
    except OSError as exc:
        raise cannot_write(path, exc) from None
    temporary = path.with_name(f"{name}{os.getpid()}.tmp")
    unfinished.add(temporary)
    try:
        yield temporary
        with open(temporary, "rb+") as stream:
            os.fsync(stream.fileno())
        os.replace(temporary, path)
    except OSError as exc:
        raise cannot_write(path, exc) from None
    finally:
        with contextlib.suppress(OSError):  # what went wrong with the file is told, not that nothing is there
            temporary.unlink()
        unfinished.discard(temporary)


def _alive(temporary: Path) -> bool:
    match = re.search(r"\.(\d+)\.tmp$", temporary.name)
    return match is None or is_alive(int(match.group(1)))


def cannot_write(path: Path, exc: OSError) -> InputError:
    """The error for a file that could not be made."""
    full = exc.errno in (errno.ENOSPC, errno.EFBIG, errno.EDQUOT)
    fact = "no room left to write it" if full else f"cannot be written ({exc.strerror or exc})"
    return InputError(f"{fact}; the previous file, if any, is untouched", where=str(path))


@contextlib.contextmanager
def open_checked(path: Path, kind: FileKind) -> Iterator[Reader]:
    """Open a file for reading after checking its seal, kind, version and contract.

    Raises
    ------
    InputError : missing, not as it was sealed, of another kind or version, or not as the contract says.
    """
    rebuild = f"make it with `{kind.made_by}`, or `tedm run`"
    with sealed(path, rebuild) as (file, sha256):
        with reading(path):
            schema = attribute_text(file, "schema")
            found = attribute_text(file, "schema_version")
        if schema != f"tedm.{kind.name}":
            raise InputError(
                f"holds {schema or 'no tedm schema'}, wanted tedm.{kind.name}", where=str(path), hint=rebuild
            )
        if found != str(kind.version):
            fact = f"schema version {found or 'none'}, this tedm reads {kind.version}"
            raise InputError(fact, where=str(path), hint=f"re{rebuild}")
        problems: list[str] = []
        if (sha256, kind.name) not in _fitting:  # the same bytes have the same contents
            with reading(path):
                problems = contract_problems(file, kind, path) + provenance_problems(file)
        if problems:
            more = f"; and {len(problems) - _SHOWN} more" if len(problems) > _SHOWN else ""
            raise InputError("; ".join(problems[:_SHOWN]) + more, where=str(path), hint=f"re{rebuild}")
        _fitting.add((sha256, kind.name))
        with contextlib.closing(Reader(file, kind, path)) as reader:
            yield reader


def kind_of(path: Path) -> FileKind:
    """The kind of a file, from its schema attribute."""
    with sealed(path, f"known: {', '.join(KINDS)}") as (file, _), reading(path):
        schema = attribute_text(file, "schema") or ""
    kind = KINDS.get(schema.removeprefix("tedm."))
    if kind is None:
        raise InputError(f"holds {schema or 'no tedm schema'}", where=str(path), hint=f"known: {', '.join(KINDS)}")
    return kind
