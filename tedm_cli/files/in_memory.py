"""Files between the stages that are never on a disk: what a stage would write, as its readers read it."""

from __future__ import annotations

import contextlib
import io
from collections.abc import Callable, Iterator
from pathlib import Path

import h5py

from tedm_cli.contracts import FileKind
from tedm_cli.files.provenance import ConfigFile, Provenance
from tedm_cli.files.store import Reader, Writer


class _Memory:
    """A sink that does not fail."""

    def check(self) -> None:
        """Nothing can have gone wrong."""


@contextlib.contextmanager
def in_memory(
    kind: FileKind, configs: tuple[ConfigFile, ...], command: str, write: Callable[[Writer], None]
) -> Iterator[Reader]:
    """What `write` writes as a file of `kind`, checked against its contract; it is gone when the block ends.

    `configs` and `command` say what it was made from. Its inputs are not summed, as nothing will be held against them.

    Raises
    ------
    PhysicsError : a number is not finite where the contract has finite ones.
    """
    with h5py.File(io.BytesIO(), "w", libver="v110") as file:
        writer = Writer(file, kind, Path(f"{kind.name} in memory"), _Memory())
        write(writer)
        writer.finish(Provenance(configs, (), command))
        yield Reader(file, kind, Path(f"{kind.name} in memory"))
