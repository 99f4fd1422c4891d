"""What pyNastran passes over in lines as such, found before it reads them: INCLUDEs, superelements, damage."""

from __future__ import annotations

import os
import re
from collections.abc import Iterator, Sequence
from pathlib import Path

from tedm_cli.errors import InputError
from tedm_cli.nastran.card_names import REFUSED
from tedm_cli.nastran.deck_lines import system_name
from tedm_cli.regular_file import require_regular_file

_NEWLINE = b"\n"
_BLOCK = 1 << 24  # bytes
_CONTROL = re.compile(r"[\x00-\x08\x0b\x0e-\x19\x1b-\x1f\x7f]")  # but tab, form feed and the old mark of a file's end
_PRINTED = bytes(c for c in range(256) if not _CONTROL.match(chr(c)))
_NAME_BYTES = 2000  # in which the name of an INCLUDE ends


def scan(path: Path) -> None:
    """Walk a deck and its INCLUDEs before pyNastran does: it passes over some lines and litters on a missing file."""
    files, seen = [path], {path.resolve()}
    while files:
        file = files.pop()
        for block, first, following in _blocks(file):
            for start, end in _suspect_lines(block):
                place = f"{file}:{first + block.count(_NEWLINE, 0, start)}"
                line = block[start:end].decode("latin-1")
                included = _refuse(line, place)
                if included:
                    text = block[start : end + _NAME_BYTES]
                    text += following[: max(end + _NAME_BYTES - len(block), 0)]
                    other = _included(text.decode("latin-1").split("\n"), path.parent, place)
                    if other.resolve() in seen:
                        raise InputError(f"INCLUDE of a file that was read already: {other}", where=place)
                    seen.add(other.resolve())
                    files.append(other)
                control = _CONTROL.search(line.split("$")[0])
                if control:
                    raise InputError(
                        f"has a control character ({ord(control[0])}) in a line: is the file damaged?", where=place
                    )


def _blocks(file: Path) -> Iterator[tuple[bytes, int, bytes]]:
    """Whole lines of a file, the number of the first of them, and what follows them."""
    carried, first = b"", 1
    try:
        with open(file, "rb") as stream:
            while True:
                more = stream.read(_BLOCK)
                data = carried + more
                if more:  # a carriage return may be half of a line's end
                    following = stream.peek(_NAME_BYTES)[:_NAME_BYTES]
                    cut = max(data.rfind(b"\n"), data.rfind(b"\r", 0, -1)) + 1
                else:
                    following, cut = b"", len(data)
                block, carried = (part.replace(b"\r\n", b"\n") for part in (data[:cut], data[cut:]))
                block = block.replace(b"\r", b"\n")
                following = (carried + following).replace(b"\r\n", b"\n").replace(b"\r", b"\n")
                if block:
                    yield block, first, following
                first += block.count(_NEWLINE)
                if not more:
                    return
    except OSError as exc:
        raise InputError(f"cannot be read ({exc.strerror})", where=str(file)) from exc


def _refuse(line: str, place: str) -> bool:
    """Refuse a line of a kind that is not read; whether it is an INCLUDE."""
    word = line.strip().upper()
    if word.startswith("="):
        raise InputError("replicated cards (=) are not read: write them out", where=place)
    if re.match(r"(BEGIN\s+)?SUPER\s*=\s*\d", word):
        raise InputError(f"{' '.join(line.split())}: {REFUSED['SESET']}", where=place)
    if word.startswith("SUBCOM"):
        raise InputError("SUBCOM: a unit load must not combine subcases", where=place, hint="remove it")
    return word.startswith("INCLUDE")


def _suspect_lines(data: bytes) -> list[tuple[int, int]]:
    """Start and end of the lines that may hold what `_scan` looks for: found without a look at every line."""
    upper, marks = data.upper(), [b"INCLUDE", b"SUBCOM", b"SUPER", b"="]
    if data.translate(None, _PRINTED):
        marks += [bytes([c]) for c in sorted(set(data.translate(None, _PRINTED)))]
    found = set()
    for mark in marks:
        at = upper.find(mark)
        while at >= 0:
            start = upper.rfind(_NEWLINE, 0, at) + 1
            end = upper.find(_NEWLINE, at)
            end = len(upper) if end < 0 else end
            found.add((start, end))
            at = upper.find(mark, end)
    return sorted(found)


def _included(lines: list[str], folder: Path, place: str) -> Path:
    """The file an INCLUDE names, from the line it begins in; like pyNastran, relative to the main file's folder."""
    card = [lines[0].split("$")[0].strip()]
    if card[0].count("'") == 1:  # a long name goes on until its closing quote
        last = next((i for i, line in enumerate(lines[1:], start=1) if "'" in line), None)
        if last is None:
            raise InputError("INCLUDE lacks its closing quote", where=place)
        card += [line.split("$")[0].strip() for line in lines[1 : last + 1]]
    try:
        name = include_file(card, str(folder.absolute()))
    except (SyntaxError, IndexError) as exc:
        raise InputError("INCLUDE names no file", where=place) from exc
    included = folder.absolute() / name
    try:
        there = included.is_file()
    except (OSError, ValueError) as exc:  # a name that no file can have
        raise InputError(f"INCLUDE names no file: {name[:80]}", where=place) from exc
    if not there:
        require_regular_file(included, named_at=place)
        raise InputError(f"INCLUDE of a file that does not exist: {included}", where=place)
    return included


def include_file(card: Sequence[str], include_dir: str = "", is_windows: bool | None = None) -> str:
    """The file that the lines of an INCLUDE name, in whichever of the forms of the name there is one."""
    from pyNastran.bdf.bdf_interface.include_file import get_include_filename

    forms = ([system_name(line) for line in card], list(card))
    names = [str(get_include_filename(lines, include_dir=include_dir, is_windows=is_windows)) for lines in forms]
    return next((name for name in names if os.path.isfile(name)), names[0])
