"""What a file was made from: configurations verbatim, inputs by name and SHA-256, and the command. No clock."""

from __future__ import annotations

import os
import sys
import threading
from collections.abc import Iterable
from concurrent.futures import Future
from dataclasses import dataclass
from pathlib import Path

from tedm_cli.errors import InputError
from tedm_cli.files.seal import sha256_of
from tedm_cli.regular_file import require_regular_file


@dataclass(frozen=True)
class InputFile:
    """A file that a stage read, and the SHA-256 of what it held then, or who computes it."""

    path: Path
    digest: str | Future[str]

    @property
    def sha256(self) -> str:
        """Waits for the sum where it is under way; `InputError` when the file cannot be read."""
        return self.digest if isinstance(self.digest, str) else self.digest.result()


@dataclass(frozen=True)
class ConfigFile:
    """A configuration file as the stage read it."""

    path: Path
    text: str
    sha256: str


@dataclass(frozen=True)
class Provenance:
    """Everything the file depends on besides the versions of the libraries."""

    configs: tuple[ConfigFile, ...]
    inputs: tuple[InputFile, ...]
    command: str


def input_files(paths: Iterable[Path]) -> tuple[InputFile, ...]:
    """Sum the files in their order beside what the stage does next: it takes about as long as reading them.

    Raises
    ------
    InputError : a path to what is no regular file, or whose name is not UTF-8 and cannot be recorded.
    """
    sums: list[tuple[Path, Future[str]]] = [(path, Future()) for path in paths]
    for path, _ in sums:
        require_regular_file(path)
        if not os.fsencode(path).isascii() and str(path) != os.fsencode(path).decode("utf-8", "replace"):
            raise InputError("has a name that is not UTF-8", where=str(path), hint="rename the file, or its folder")

    def run() -> None:
        for path, digest in sums:
            try:
                digest.set_result(sha256_of(path))
            except BaseException as exc:
                digest.set_exception(exc)

    threading.Thread(target=run, daemon=True).start()  # a daemon, lest a failed stage wait for it
    return tuple(InputFile(*item) for item in sums)


def command_line() -> str:
    """The command as typed, without the folder the program happens to live in; bytes that are no UTF-8 as escapes."""
    return os.fsencode(" ".join(["tedm", *sys.argv[1:]])).decode("utf-8", "backslashreplace")


def absolute_path(name: str, folder: Path) -> Path:
    """The path that `relative_name` made `name` of, seen from the same `folder`."""
    return Path(os.path.normpath(folder.resolve() / name))


def relative_name(path: Path, folder: Path) -> str:
    """`path` as seen from `folder`, so that a chain of files can be moved as a whole and still be checked."""
    return Path(os.path.relpath(path.resolve(), folder.resolve())).as_posix()
