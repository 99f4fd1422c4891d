"""The lines of a deck with its INCLUDEs in place, each with the file it came from, and the sections they make."""

from __future__ import annotations

import os
import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from typing import NamedTuple

from tedm_cli.errors import InputError
from tedm_cli.regular_file import require_regular_file

_BOM = "\u00ef\u00bb\u00bf"  # of UTF-8, as Latin-1 reads it
_MOST_NAME_LINES = 20  # of one quoted name
_INCLUDE = re.compile(r"\s*INCLUDE(?=[\s'\"=])\s*=?\s*", re.I)


class Line(NamedTuple):
    """One line as it stands in its file, with its line end; Latin-1 keeps every byte."""

    text: str
    file: Path
    number: int

    @property
    def place(self) -> str:
        return f"{self.file}:{self.number}"

    @property
    def code(self) -> str:
        """The line without its comment."""
        return self.text.split("$")[0].rstrip()


@dataclass(frozen=True)
class Sections:
    """Executive control, case control and bulk data of a deck, without CEND, BEGIN BULK and ENDDATA.

    files : the main file, then every included one in the order read.
    left_over : lines after ENDDATA that say something.
    """

    files: tuple[Path, ...]
    executive: tuple[Line, ...]
    control: tuple[Line, ...]
    bulk: tuple[Line, ...]
    has_end: bool
    left_over: tuple[Line, ...]
    newline: str


@dataclass(frozen=True)
class Head:
    """Executive and case control of a deck, without CEND and BEGIN BULK.

    begin : the line of BEGIN BULK. files : the main file, and those that were included before it.
    """

    executive: tuple[Line, ...]
    control: tuple[Line, ...]
    begin: Line
    files: tuple[Path, ...]


def read_head(path: Path) -> Head:
    """Read a deck up to BEGIN BULK, with the INCLUDEs on the way.

    Raises
    ------
    InputError : what `_expand` refuses; no BEGIN BULK, no CEND before it.
    """
    lines: list[Line] = []
    files: list[Path] = []
    cend: int | None = None
    for line in _expand(path, files):
        word = line.code.strip().upper()
        if re.match(r"BEGIN\b", word):
            if cend is None:
                raise _no_cend(path)
            return Head(tuple(lines[:cend]), tuple(lines[cend:]), line, tuple(files))
        if cend is None and re.fullmatch(r"CEND\b.*", word):
            cend = len(lines)
        else:
            lines.append(line)
    raise _no_begin(path)


def _no_begin(path: Path) -> InputError:
    return InputError("has no BEGIN BULK line", where=str(path))


def _no_cend(path: Path) -> InputError:
    return InputError(
        "has no CEND line before BEGIN BULK",
        where=str(path),
        hint="a bare bulk file needs the lines SOL 101, CEND, SPC = <set>, BEGIN BULK around its INCLUDE",
    )


def read_sections(path: Path) -> Sections:
    """Read a deck with its INCLUDEs and split it into sections.

    Raises
    ------
    InputError : a file that is missing, that includes itself, or of which there are two (see `_resolve`); no CEND, no
        BEGIN BULK; a second BEGIN (superelements, modules, auxiliary models).
    """
    files: list[Path] = []
    lines = list(_expand(path, files))
    words = [line.code.strip().upper() for line in lines]
    cend = next((i for i, word in enumerate(words) if re.fullmatch(r"CEND\b.*", word)), None)
    begin = next((i for i, word in enumerate(words) if re.match(r"BEGIN\b", word)), None)
    if begin is None:
        raise _no_begin(path)
    if cend is None or cend > begin:
        raise _no_cend(path)
    end = next((i for i in range(begin + 1, len(lines)) if ends_data(lines[i].text)), len(lines))
    for i in range(begin, end):
        if re.match(r"BEGIN\b", words[i]) and (i > begin or not re.fullmatch(r"BEGIN[\s,]*(BULK)?", words[i])):
            raise InputError(
                f"{words[i]}: superelements, modules and auxiliary models are not read",
                where=lines[i].place,
                hint="write the model in one piece",
            )
    return Sections(
        files=tuple(files),
        executive=tuple(lines[:cend]),
        control=tuple(lines[cend + 1 : begin]),
        bulk=tuple(lines[begin + 1 : end]),
        has_end=end < len(lines),
        left_over=tuple(line for line, word in zip(lines[end + 1 :], words[end + 1 :], strict=True) if word),
        newline="\r\n" if lines[0].text.endswith("\r\n") else "\n",
    )


def ends_data(line: str) -> bool:
    """Whether a line is ENDDATA; behind the first field, of 8 columns, the word is a field of the card before."""
    return re.match(r"[ \t]{0,7}ENDDATA\b", line, re.I) is not None


def _expand(main: Path, files: list[Path]) -> Iterator[Line]:
    """The lines of a deck with its INCLUDEs in place, read as they are asked for, nested to any depth.

    `files` takes the files as they are read.
    """
    opened: dict[Path, Iterator[Line]] = {}  # from the main file down to the one that is being read
    file: Path | None = main
    while opened or file is not None:
        if file is not None:
            if file.resolve() in opened:
                raise InputError("includes itself", where=str(file))
            files.append(file)
            opened[file.resolve()], file = _lines(file), None
        reading = opened[next(reversed(opened))]
        for line in reading:
            statement = _INCLUDE.match(line.text)
            if statement is not None:
                name = _include_name(line.text[statement.end() :], islice(reading, _MOST_NAME_LINES), line.place)
                file = _resolve(name, main, line.file, line.place)
                break
            whole = len(opened) == 1 or line.text.endswith(("\n", "\r"))
            yield line if whole else line._replace(text=line.text + "\n")
        else:
            opened.popitem()


def _lines(file: Path) -> Iterator[Line]:
    """Lines with their ends; only line feed and carriage return end one (`str.splitlines` breaks at more)."""
    require_regular_file(file)
    number = 0
    try:
        with open(file, "rb") as stream:
            for raw in stream:
                for piece in raw.splitlines(keepends=True):
                    text, number = piece.decode("latin-1"), number + 1
                    yield Line(text.removeprefix(_BOM) if number == 1 else text, file, number)
    except OSError as exc:
        raise InputError(f"cannot be read ({exc.strerror})", where=str(file)) from exc


def _include_name(text: str, following: Iterator[Line], place: str) -> str:
    """The name an INCLUDE gives; a quoted name goes on in the lines that follow, until its closing quote."""
    name = text.strip()
    quote = name[:1]
    if quote not in ("'", '"'):
        name = name.split("$")[0]
    else:
        name = name[1:]
        while quote not in name:
            more = next(following, None)
            if more is None:
                raise InputError("INCLUDE lacks its closing quote", where=place)
            name += more.text.strip()
        name = name[: name.index(quote)]
    if not name.strip():
        raise InputError("INCLUDE names no file", where=place)
    return name.strip()


def system_name(name: str) -> str:
    """A file name of a deck, which is read as Latin-1, as the system writes it (UTF-8); `deck_text` is the inverse."""
    return os.fsdecode(name.encode("latin-1"))


def deck_text(name: str) -> str:
    """A file name as it stands in a deck that is read and written as Latin-1."""
    return os.fsencode(name).decode("latin-1")


def _resolve(name: str, main: Path, parent: Path, place: str) -> Path:
    """The file a name stands for, relative to the main file or to the one that includes it.

    Solvers differ in which of the two they take for a nested INCLUDE, so where both exist nobody can know.
    """
    symbol = re.match(r"\$?(\w\w+):(?![\\/]{2})(.*)|\$\{?(\w+)\}?[\\/](.*)", name)
    if symbol:
        variable, rest = symbol[1] or symbol[3], symbol[2] if symbol[1] else symbol[4]
        if variable not in os.environ:
            raise InputError(
                f"INCLUDE '{name}': the environment has no variable {variable}",
                where=place,
                hint=f"set {variable}, or write the path itself",
            )
        name = f"{os.environ[variable]}/{rest}"
    found: dict[Path, Path] = {}
    for folder in (main.parent, parent.parent):
        for spelled in (s for given in (system_name(name), name) for s in (given, given.replace("\\", "/"))):
            if (folder / spelled).is_file():
                found.setdefault((folder / spelled).resolve(), folder / spelled)
                break
    if not found:
        require_regular_file(main.parent / system_name(name), named_at=place)
        raise InputError(f"INCLUDE of a file that does not exist: {main.parent / system_name(name)}", where=place)
    if len(found) > 1:
        raise InputError(
            f"INCLUDE '{name}' can be {' or '.join(str(f) for f in found.values())}",
            where=place,
            hint="Nastran versions differ in which they take: rename one, or write an absolute path",
        )
    return next(iter(found.values()))


def card_places(files: Iterable[Path], name: str, number: int) -> list[str]:
    """File and line of every bulk data card of this name whose first field is `number`, in the order of the files."""
    card = re.compile(rf"\s*{name}\*?(?:\s*,\s*|\s+){number}(?![^\s,$])", re.IGNORECASE)
    found = []
    for file in files:
        with file.open(encoding="latin-1") as lines:
            found += [f"{file}:{i}" for i, line in enumerate(lines, start=1) if card.match(line)]
    return found
