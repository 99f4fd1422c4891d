"""What a file was made from: configurations verbatim, inputs by name and SHA-256, and the command. No clock."""

from __future__ import annotations

import hashlib
import os
import sys
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from tedm_cli.errors import InputError


@dataclass(frozen=True)
class InputFile:
    """A file that a stage read, and the SHA-256 of what it held then."""

    path: Path
    sha256: str


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


def sha256_of(path: Path) -> str:
    """SHA-256 of a file, read in blocks; `InputError` when it cannot be read."""
    digest = hashlib.sha256()
    try:
        with open(path, "rb") as stream:
            while block := stream.read(1 << 20):
                digest.update(block)
    except OSError as exc:
        raise InputError(f"cannot be read ({exc.strerror})", where=str(path)) from exc
    return digest.hexdigest()


def input_files(paths: Iterable[Path]) -> tuple[InputFile, ...]:
    return tuple(InputFile(p, sha256_of(p)) for p in paths)


def command_line() -> str:
    """The command as typed, without the folder the program happens to live in."""
    return " ".join(["tedm", *sys.argv[1:]])


def absolute_path(name: str, folder: Path) -> Path:
    """The path that `relative_name` made `name` of, seen from the same `folder`."""
    return Path(os.path.normpath(folder.resolve() / name))


def relative_name(path: Path, folder: Path) -> str:
    """`path` as seen from `folder`, so that a chain of files can be moved as a whole and still be checked."""
    return Path(os.path.relpath(path.resolve(), folder.resolve())).as_posix()
