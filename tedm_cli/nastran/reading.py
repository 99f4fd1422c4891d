"""Decks in through pyNastran: what it would pass over is refused first, and its failures become one clear error."""

from __future__ import annotations

import os
import re
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from tedm_cli.errors import InputError
from tedm_cli.nastran.captured_output import captured_output, fact_of
from tedm_cli.nastran.cards import LARGEST_INTEGER, range_problem, refuse_lost_fields
from tedm_cli.nastran.deck_lines import system_name
from tedm_cli.regular_file import require_regular_file

_ON_GRIDS = "temperatures other than of grids are not read: load the grids with TEMP and TEMPD"
# Cards that pyNastran does not read (or that nothing here reads), so that what they say would be passed over.
_REFUSED_BULK = {
    **dict.fromkeys(("TEMPP1", "TEMPP2", "TEMPP3", "TEMPRB", "TEMPB3", "TEMPN1", "TEMPF", "TEMPAX"), _ON_GRIDS),
    **dict.fromkeys(("TEMPADD", "TEMPEX", "TEMPT", "TEMPBC"), "is not read: give each subcase a set of TEMP and TEMPD"),
    **dict.fromkeys(
        ("SESET", "SEELT", "SETREE", "SELOC", "SEMPLN", "SEBULK", "SECONCT", "SEBNDRY", "CSUPER", "RELEASE"),
        "superelements are not read: solve the model in one piece",
    ),
}


def read_deck(path: Path, *, cross_reference: bool = True) -> Any:
    """Read a bulk data deck and cross-reference its elements; loads and constraints are left as they are written.

    Returns
    -------
    pyNastran `BDF`.

    Raises
    ------
    InputError : missing or malformed file or INCLUDE, a card that would be silently ignored, SUBCOM.
    """
    from pyNastran.bdf.bdf import BDF

    require_regular_file(path)
    if not path.is_file():
        raise InputError("no such deck", where=str(path), hint="make one with `tedm write-deck`, or name your own")
    _scan(path)
    model = BDF(debug=None)
    refuse_lost_fields(model, path)
    with captured_output() as chatter, _guided(path):
        try:
            model.read_bdf(str(path), xref=False, punch=False, encoding=any_encoding(model))
            if cross_reference:
                _cross_reference(model)
        except InputError:
            raise
        except Exception as exc:  # malformed decks make pyNastran raise almost anything, and classes of its own
            fact = fact_of(exc, chatter.getvalue())
            raise InputError(f"pyNastran cannot read the deck: {fact}", where=str(path)) from exc
    large = [int(n) for n in model.subcases if int(n) > LARGEST_INTEGER]
    if large:
        raise InputError(f"SUBCASE {large[0]}: is larger than any id", where=str(path))
    lost = sorted(name for name in model.reject_count if name.startswith("C"))
    if lost:
        raise InputError(f"elements that pyNastran does not know: {', '.join(lost)}", where=str(path))
    return model


def cross_reference(model: Any, path: Path) -> None:
    """Cross-reference the elements of a model that was read without; raises as `read_deck` does."""
    with captured_output() as chatter:
        try:
            _cross_reference(model)
        except Exception as exc:
            fact = fact_of(exc, chatter.getvalue())
            raise InputError(f"pyNastran cannot read the deck: {fact}", where=str(path)) from exc


def _cross_reference(model: Any) -> None:
    model.cross_reference(
        xref_loads=False, xref_constraints=False, xref_aero=False, xref_sets=False, xref_optimization=False
    )


def any_encoding(model: Any) -> str:
    """The encoding to read decks in, of which only comments and titles can be other than ASCII.

    pyNastran looks at the beginning of a deck in the encoding of the locale, and obeys comments there that make it
    skip cards: `model` is made to look at neither.
    """
    model._parse_primary_file_header = lambda _: None
    return "latin-1"


def deck_files(model: Any, path: Path) -> list[Path]:
    """The deck and every file it includes, in the order read."""
    files: dict[Path, Path] = {}
    for name in [path, *(Path(str(f)) for f in model.active_filenames)]:
        found = name if name.exists() else path.parent / name
        files.setdefault(found.resolve(), found)
    return list(files.values())


def _scan(path: Path) -> None:
    """Walk a deck and its INCLUDEs before pyNastran does: it passes over some cards and litters on a missing file."""
    files, seen = [path], {path.resolve()}
    while files:
        file = files.pop()
        try:
            lines = file.read_text(encoding="latin-1").splitlines()
        except OSError as exc:
            raise InputError(f"cannot be read ({exc.strerror})", where=str(file)) from exc
        for number, line in enumerate(lines, start=1):
            name = re.split(r"[\s,*]", line.strip().upper(), maxsplit=1)[0]
            place = f"{file}:{number}"
            if name.startswith("="):
                raise InputError("replicated cards (=) are not read: write them out", where=place)
            if name in _REFUSED_BULK:
                raise InputError(f"{name} card: {_REFUSED_BULK[name]}", where=place)
            if re.match(r"\s*(BEGIN\s+)?SUPER\s*=\s*\d", line, re.I):
                raise InputError(f"{' '.join(line.split())}: {_REFUSED_BULK['SESET']}", where=place)
            if name.startswith("SUBCOM"):
                raise InputError("SUBCOM: a unit load must not combine subcases", where=place, hint="remove it")
            if name.startswith("INCLUDE"):
                included = _included(lines[number - 1 :], path.parent, place)
                if included.resolve() in seen:
                    raise InputError(f"INCLUDE of a file that was read already: {included}", where=place)
                seen.add(included.resolve())
                files.append(included)


def _included(lines: list[str], folder: Path, place: str) -> Path:
    """The file an INCLUDE names, from the line it begins in; like pyNastran, relative to the main file's folder."""
    card = [lines[0].split("$")[0].strip()]
    if card[0].count("'") == 1:  # a long name goes on until its closing quote
        last = next((i for i, line in enumerate(lines[1:], start=1) if "'" in line), None)
        if last is None:
            raise InputError("INCLUDE lacks its closing quote", where=place)
        card += [line.split("$")[0].strip() for line in lines[1 : last + 1]]
    try:
        name = _include_file(card, str(folder.absolute()))
    except (SyntaxError, IndexError) as exc:
        raise InputError("INCLUDE names no file", where=place) from exc
    included = folder.absolute() / name
    try:
        there = included.is_file()
    except (OSError, ValueError) as exc:  # a name that no file can have
        raise InputError(f"INCLUDE names no file: {name[:80]}", where=place) from exc
    if not there:
        require_regular_file(included)
        raise InputError(f"INCLUDE of a file that does not exist: {included}", where=place)
    return included


def _include_file(card: Sequence[str], include_dir: str = "", is_windows: bool | None = None) -> str:
    """The file that the lines of an INCLUDE name, in whichever of the forms of the name there is one."""
    from pyNastran.bdf.bdf_interface.include_file import get_include_filename

    forms = ([system_name(line) for line in card], list(card))
    names = [str(get_include_filename(lines, include_dir=include_dir, is_windows=is_windows)) for lines in forms]
    return next((name for name in names if os.path.isfile(name)), names[0])


@contextmanager
def _guided(path: Path) -> Iterator[None]:
    """Let pyNastran find the files of INCLUDEs by the names that `_scan` has found, and write out no endless SET."""
    from pyNastran.bdf import subcase
    from pyNastran.bdf.bdf_interface import pybdf

    include_file, expanded = pybdf.get_include_filename, subcase.expand_thru_case_control

    def bounded(values: Sequence[Any]) -> Any:
        problem = range_problem(" ".join(str(value) for value in values).upper().replace(",", " ").split())
        if problem:
            raise InputError(f"SET of the case control: {problem}", where=str(path), hint="write SET n = ALL")
        return expanded(values)

    pybdf.get_include_filename, subcase.expand_thru_case_control = _include_file, bounded
    try:
        yield
    finally:
        pybdf.get_include_filename, subcase.expand_thru_case_control = include_file, expanded
