"""The files between the stages held in memory: HDF5 takes ten times as long as everything that is tried here."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from pathlib import Path
from typing import Any
from unittest import mock

import numpy as np

from tedm_cli.contracts import FileKind
from tedm_cli.errors import InputError
from tedm_cli.files.blocks import Allocated, Blocks, narrowed
from tedm_cli.files.provenance import Provenance


class _Dataset:
    def __init__(self, name: str, values: np.ndarray) -> None:
        self.name, self.values = name, values
        self.shape, self.dtype = values.shape, values.dtype

    def __getitem__(self, index: Any) -> Any:
        return self.values[index].copy()

    def __setitem__(self, index: Any, value: Any) -> None:
        self.values[index] = value


class _Sink:
    def check(self) -> None:
        """Memory does not fail."""


class MemoryFile:
    """Takes what a `Writer` takes, and gives what a `Reader` gives."""

    def __init__(self, path: Path) -> None:
        self.path, self.data = path, dict[str, Any]()

    def write(self, path: str, value: Any, *, units: str | None = None, single: bool = False) -> None:
        value = np.asarray(value)
        self.data[path] = narrowed(value.astype(float)) if single else value

    def allocate(
        self, path: str, shape: tuple[int, ...], *, units: str | None = None, single: bool = False
    ) -> Allocated:
        self.data[path] = np.zeros(shape, np.float32 if single else np.float64)
        return Allocated(_Dataset(path, self.data[path]), _Sink(), lambda value: None)  # type: ignore[arg-type]

    def view(self, path: str, source: MemoryFile) -> bool:
        return False  # memory is no folder

    def has(self, path: str) -> bool:
        return path in self.data

    def array(self, path: str) -> np.ndarray:
        return self.dataset(path)[()]

    def dataset(self, path: str) -> Blocks:
        return Blocks(_Dataset(path, np.asarray(self.data[path])), self.path)

    def strings(self, path: str) -> list[str]:
        return [str(s) for s in self.data[path]]

    def string(self, path: str) -> str:
        return str(self.data[path])

    def number(self, path: str) -> float:
        return float(self.data[path])


@contextlib.contextmanager
def in_memory() -> Iterator[dict[str, MemoryFile]]:
    """Within it, ingest and build-distortion keep their files, by name, in the dictionary given."""
    files: dict[str, MemoryFile] = {}

    @contextlib.contextmanager
    def create(path: Path, kind: FileKind, provenance: Provenance) -> Iterator[MemoryFile]:
        file = MemoryFile(path)
        yield file
        files[path.name] = file

    @contextlib.contextmanager
    def open_checked(path: Path, kind: FileKind) -> Iterator[MemoryFile]:
        if path.name not in files:
            raise InputError("no such file", where=str(path))
        yield files[path.name]

    with (
        mock.patch("tedm_cli.stages.model.ingest.create", create),
        mock.patch("tedm_cli.stages.model.distortion.create", create),
        mock.patch("tedm_cli.stages.model.distortion.open_checked", open_checked),
        mock.patch("tedm_cli.stages.model.distortion.provenance", return_value=Provenance((), (), "")),
    ):
        yield files
