"""Decks read through pyNastran: what it would ignore is refused first, and its failures become one clear error."""

from __future__ import annotations

import os
import re
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from tedm_cli.deck_units import SI, DeckUnits
from tedm_cli.errors import InputError
from tedm_cli.nastran.captured_output import captured_output, card_lines_of, complaint_of, fact_of
from tedm_cli.nastran.card_names import REFUSED
from tedm_cli.nastran.cards import LARGEST_INTEGER, BulkChecks, range_problem
from tedm_cli.nastran.control_words import read_statements
from tedm_cli.nastran.deck_lines import card_places, read_head, system_name
from tedm_cli.nastran.library import require_pynastran, without_integration
from tedm_cli.nastran.parameters import refuse_misspelt
from tedm_cli.nastran.plausible import check_plausible
from tedm_cli.regular_file import require_regular_file

_NEWLINE = b"\n"
_CONTROL = re.compile(r"[\x00-\x08\x0b\x0e-\x19\x1b-\x1f\x7f]")  # but tab, form feed and the old mark of a file's end
_PRINTED = bytes(c for c in range(256) if not _CONTROL.match(chr(c)))


def read_deck(
    path: Path, *, cross_reference: bool = True, allow_missing_enddata: bool = False, units: DeckUnits = SI
) -> Any:
    """Read a bulk data deck and cross-reference its elements; loads and constraints are left as they are written.

    Returns
    -------
    pyNastran `BDF`, whose numbers are those of the deck; `passed_over` says which of the deck's cards it lacks,
    `units_of` what its numbers are in.

    Raises
    ------
    InputError : missing or malformed file or INCLUDE, no ENDDATA, a card, a parameter or a word of case control that is
        not known, a field that only looks like a number, SUBCOM, materials and thicknesses that no structure has.
    """
    require_pynastran()
    with without_integration():
        from pyNastran.bdf.bdf import BDF

    require_regular_file(path)
    if not path.is_file():
        raise InputError("no such deck", where=str(path), hint="make one with `tedm write-deck`, or name your own")
    _scan(path)
    read_statements(read_head(path).control)
    model = BDF(debug=None)
    checks = BulkChecks(model, path, allow_missing_enddata=allow_missing_enddata)
    with captured_output() as chatter, _guided(path):
        try:
            model.read_bdf(str(path), xref=False, punch=False, encoding=any_encoding(model))
            checks.release()
            if cross_reference:
                _cross_reference(model)
        except InputError:
            raise
        except Exception as exc:  # malformed decks make pyNastran raise almost anything, and classes of its own
            raise _unread(
                exc, chatter.getvalue(), checks.place_of(card_lines_of(exc)), deck_files(model, path)
            ) from exc
    large = [int(n) for n in model.subcases if int(n) > LARGEST_INTEGER]
    if large:
        raise InputError(f"SUBCASE {large[0]}: is larger than any id", where=str(path))
    model.tedm_passed_over, model.tedm_parameters = checks.passed_over, checks.parameters
    model.tedm_element_temperatures, model.tedm_units = checks.element_temperatures, units
    for name, place in checks.parameters.items():
        refuse_misspelt(name, place)
    check_plausible(model, str(path), units)
    return model


def cross_reference(model: Any, path: Path) -> None:
    """Cross-reference the elements of a model that was read without; raises as `read_deck` does."""
    with captured_output() as chatter:
        try:
            _cross_reference(model)
        except Exception as exc:
            raise _unread(exc, chatter.getvalue(), str(path), deck_files(model, path)) from exc


def _unread(exc: Exception, chatter: str, where: str, files: Sequence[Path]) -> InputError:
    """What pyNastran says of a deck as an error, at the line of the card that it is about."""
    complaint = complaint_of(exc)
    if complaint is None:
        return InputError(f"pyNastran cannot read the deck: {fact_of(exc, chatter)}", where=where)
    places = [card_places(files, card, complaint.number) for card in complaint.cards]
    if not all(places):
        return InputError(complaint.fact, where=where)
    first = f" (first in {places[0][0]})" if len(places) > 1 else ""
    return InputError(complaint.fact + first, where=places[-1][-1] if first else places[0][0])


def _cross_reference(model: Any) -> None:
    model.cross_reference(
        xref_loads=False, xref_constraints=False, xref_aero=False, xref_sets=False, xref_optimization=False
    )


def passed_over(model: Any) -> list[str]:
    """What `read_deck` left out of a model, as a remark for the user; nothing where it left out nothing."""
    left = [f"{name} ({count:,})" for name, count in model.tedm_passed_over.items()]
    return [f"not read, without influence on unit loads and masses: {', '.join(left)}"] if left else []


def parameter_places(model: Any) -> dict[str, str]:
    """File and line of each PARAM card of a model from `read_deck`, by the parameter's name."""
    return dict(model.tedm_parameters)


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
    """Walk a deck and its INCLUDEs before pyNastran does: it passes over some lines and litters on a missing file."""
    files, seen = [path], {path.resolve()}
    while files:
        file = files.pop()
        try:
            data = file.read_bytes().replace(b"\r\n", b"\n").replace(b"\r", b"\n")
        except OSError as exc:
            raise InputError(f"cannot be read ({exc.strerror})", where=str(file)) from exc
        for start, end in _suspect_lines(data):
            line = data[start:end].decode("latin-1")
            place = f"{file}:{data.count(_NEWLINE, 0, start) + 1}"
            word = line.strip().upper()
            if word.startswith("="):
                raise InputError("replicated cards (=) are not read: write them out", where=place)
            if re.match(r"(BEGIN\s+)?SUPER\s*=\s*\d", word):
                raise InputError(f"{' '.join(line.split())}: {REFUSED['SESET']}", where=place)
            if word.startswith("SUBCOM"):
                raise InputError("SUBCOM: a unit load must not combine subcases", where=place, hint="remove it")
            if word.startswith("INCLUDE"):
                following = data[start : end + 2000].decode("latin-1").split("\n")
                included = _included(following, path.parent, place)
                if included.resolve() in seen:
                    raise InputError(f"INCLUDE of a file that was read already: {included}", where=place)
                seen.add(included.resolve())
                files.append(included)
            control = _CONTROL.search(line.split("$")[0])
            if control:
                raise InputError(
                    f"has a control character ({ord(control[0])}) in a line: is the file damaged?", where=place
                )


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
        name = _include_file(card, str(folder.absolute()))
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
            hint = "write SET n = ALL" if "more ids" in problem else ""
            raise InputError(f"SET of the case control: {problem}", where=str(path), hint=hint)
        return expanded(values)

    pybdf.get_include_filename, subcase.expand_thru_case_control = _include_file, bounded
    try:
        yield
    finally:
        pybdf.get_include_filename, subcase.expand_thru_case_control = include_file, expanded
