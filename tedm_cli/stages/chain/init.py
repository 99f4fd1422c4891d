"""init: a project in a folder of its own, from one of the shipped samples."""

from __future__ import annotations

import contextlib
import filecmp
import os
import re
import shutil
from collections.abc import Iterator, Sequence
from pathlib import Path

from tedm_cli.errors import InputError
from tedm_cli.files.processes import is_alive
from tedm_cli.files.store import cannot_write, replacing
from tedm_cli.interrupts import whole
from tedm_cli.samples.shipped import LAYOUT, PROJECT, SAMPLES, Script, root
from tedm_cli.stages.model_script import run_script

_ASIDE = ".tedm-init."  # and the number of the process: where files are made before any has its name
_BUILT = '"{build_dir}/'  # before the names of models that Make makes in the build folder
_SHARED = '"../'  # in project files, before the names of files that are another sample's, too
_SHOWN = 5


def begin_project(sample: str, folder: Path) -> list[str]:
    """Write the project of a sample into a new or empty folder; the names of its files, the project file first.

    A model that a script makes is made here, as the project's own file. All files are made aside, and then put in
    their places, the project file last. What a killed run has left is removed first.

    Raises
    ------
    InputError : the folder holds something, or cannot be written; the samples are not installed.
    """
    existed = os.path.lexists(folder)
    _clear_leftovers(folder)
    _require_empty(folder)
    aside = folder / f"{_ASIDE}{os.getpid()}"
    with _made(aside, folder, existed=existed):
        aside.mkdir(parents=True)
        _write_sample(sample, aside)
        names = sorted(path.name for path in aside.iterdir())
        names = [PROJECT, *(name for name in names if name != PROJECT)]
        _put_in_place(aside, folder, names)
        shutil.rmtree(aside)
    return names


def _write_sample(name: str, folder: Path) -> None:
    """Its files, with the paths in them as they are in one folder, and its model."""
    sample = SAMPLES[name]
    for source in sample.files:
        path = root() / source
        if not path.is_file():
            raise InputError("no such file", where=str(path), hint="install tedm again: its samples are not with it")
        text = path.read_bytes()
        if path.suffix == ".toml":
            text = text.replace(_BUILT.encode(), b'"')
        if path.name == PROJECT:
            text = text.replace(_SHARED.encode(), b'"')
        (folder / path.name).write_bytes(text)
    if sample.script is not None:
        _make_model(sample.script, folder)


def _make_model(script: Script, folder: Path) -> None:
    options = [*script.arguments, "--layout", str(folder / LAYOUT), "-o", str(folder / script.model)]
    if why := run_script(root() / script.file, options):
        raise InputError(f"cannot make the model ({why})", where=str(folder.parent / script.model))


@whole
def _put_in_place(aside: Path, folder: Path, names: Sequence[str]) -> None:
    """Copies of the files aside, so that a run that comes after a kill can tell them; the project file last."""
    for name in reversed(names):
        with replacing(folder / name) as temporary:
            shutil.copyfile(aside / name, temporary)


@contextlib.contextmanager
def _made(aside: Path, folder: Path, *, existed: bool) -> Iterator[None]:
    """Remove what has been made in a folder when the block ends by an exception."""
    try:
        yield
    except BaseException as exc:
        with contextlib.suppress(OSError):
            if aside.exists():
                _remove(aside, folder)
            if not existed:
                folder.rmdir()
        if isinstance(exc, OSError):
            raise cannot_write(folder, exc) from exc
        raise


def _clear_leftovers(folder: Path) -> None:
    """Remove what killed runs have left, where nothing else is there: files made aside, and copies in their places."""
    for aside in folder.glob(f"{_ASIDE}*"):
        number = re.fullmatch(r"\d+", aside.name.removeprefix(_ASIDE))
        if number is None or is_alive(int(number[0])):
            continue
        if set(_visible(folder)) <= set(_placed(aside, folder)):
            _remove(aside, folder)


@whole
def _remove(aside: Path, folder: Path) -> None:
    """Remove what was made aside, and the copies in their places unless they are all there: then it is a project."""
    if not (folder / PROJECT).exists():
        for name in _placed(aside, folder):
            (folder / name).unlink()
    shutil.rmtree(aside)


def _placed(aside: Path, folder: Path) -> list[str]:
    """The names of files that are in their places as they were made aside."""
    pairs = [(path, folder / path.name) for path in aside.iterdir()]
    return [made.name for made, there in pairs if there.is_file() and filecmp.cmp(made, there, shallow=False)]


def _visible(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir() if path.name[0] != ".")


def _require_empty(folder: Path) -> None:
    """Refuse what is no folder, and a folder that holds anything but names that begin with a dot."""
    try:
        there = _visible(folder)
    except FileNotFoundError:
        return
    except OSError as exc:
        raise InputError(f"is no folder to write in ({exc.strerror})", where=str(folder)) from exc
    if there:
        more = f" and {len(there) - _SHOWN} more" if len(there) > _SHOWN else ""
        raise InputError(
            f"is not empty: {', '.join(there[:_SHOWN])}{more}",
            where=str(folder),
            hint="nothing is overwritten: name a new folder, `tedm init FOLDER`",
        )
