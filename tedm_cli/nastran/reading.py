"""The guarded border to pyNastran: decks and results in, one clear error out."""

from __future__ import annotations

import re
import struct
from contextlib import redirect_stdout
from io import StringIO
from pathlib import Path
from typing import Any

from tedm_cli.errors import InputError

# Cards whose temperatures pyNastran does not read, or that make subcases leak into one another.
_REFUSED_BULK = {
    "TEMPP1": "plate temperatures are not read: load the grids with TEMP",
    "TEMPP3": "plate temperatures are not read: load the grids with TEMP",
    "TEMPRB": "bar temperatures are not read: load the grids with TEMP",
    "SESET": "superelements are not read: solve the model in one piece",
}
# The first record of an OP2 has 4 or 8 bytes (32 or 64 bit), in either byte order.
_RECORD_MARKERS = tuple(struct.pack(f"{order}i", size) for order in "<>" for size in (4, 8))


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

    if not path.is_file():
        raise InputError("no such deck", where=str(path), hint="make one with `tedm write-deck`, or name your own")
    _scan(path)
    model = BDF(debug=None)
    chatter = StringIO()  # pyNastran explains itself on stdout, which belongs to our results
    try:
        with redirect_stdout(chatter):
            model.read_bdf(str(path), xref=False, punch=False)
            if cross_reference:
                model.cross_reference(
                    xref_loads=False, xref_constraints=False, xref_aero=False, xref_sets=False, xref_optimization=False
                )
    except Exception as exc:  # malformed decks make pyNastran raise almost anything, and classes of its own
        raise InputError(f"pyNastran cannot read the deck: {_fact(exc, chatter.getvalue())}", where=str(path)) from exc
    lost = sorted(name for name in model.reject_count if name.startswith("C"))
    if lost:
        raise InputError(f"elements that pyNastran does not know: {', '.join(lost)}", where=str(path))
    return model


def deck_files(model: Any, path: Path) -> list[Path]:
    """The deck and every file it includes, in the order read."""
    files: list[Path] = []
    for name in [path, *(Path(str(f)) for f in model.active_filenames)]:
        resolved = name if name.exists() else path.parent / name
        if resolved.resolve() not in [f.resolve() for f in files]:
            files.append(resolved)
    return files


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
            if name in _REFUSED_BULK:
                raise InputError(f"{name} card: {_REFUSED_BULK[name]}", where=place)
            if name.startswith("SUBCOM"):
                raise InputError("SUBCOM: a unit load must not combine subcases", where=place, hint="remove it")
            if name.startswith("INCLUDE"):
                included = _included(lines[number - 1 :], path.parent, place)
                if included.resolve() not in seen:
                    seen.add(included.resolve())
                    files.append(included)


def _included(lines: list[str], folder: Path, place: str) -> Path:
    """The file an INCLUDE names, from the line it begins in; like pyNastran, relative to the main file's folder."""
    from pyNastran.bdf.bdf_interface.include_file import get_include_filename

    card = [lines[0].split("$")[0].strip()]
    if card[0].count("'") == 1:  # a long name goes on until its closing quote
        last = next((i for i, line in enumerate(lines[1:], start=1) if "'" in line), None)
        if last is None:
            raise InputError("INCLUDE lacks its closing quote", where=place)
        card += [line.split("$")[0].strip() for line in lines[1 : last + 1]]
    try:
        name = str(get_include_filename(card, include_dir=str(folder.absolute())))
    except SyntaxError as exc:
        raise InputError("INCLUDE names no file", where=place) from exc
    included = folder.absolute() / name
    if not included.is_file():
        raise InputError(f"INCLUDE of a file that does not exist: {included}", where=place)
    return included


def require_results(path: Path) -> None:
    """Refuse what is not an OP2 at first sight, before anything is spent on reading the deck."""
    if not path.is_file():
        raise InputError("no such OP2", where=str(path), hint="run `tedm solve`, or Nastran on the unit-load deck")
    with open(path, "rb") as stream:
        marker = stream.read(4)
    if not marker:
        raise InputError("empty file, not an OP2", where=str(path))
    if marker not in _RECORD_MARKERS:
        raise InputError(
            "not an OP2 (it does not begin with a Fortran record)",
            where=str(path),
            hint="the deck needs PARAM,POST,-1 to write one",
        )


def read_results(path: Path) -> Any:
    """Read the displacement tables of an OP2.

    Returns
    -------
    pyNastran `OP2` with `displacements` keyed by subcase.

    Raises
    ------
    InputError : missing, truncated or not an OP2, no displacements, superelements, a subcase given twice.
    """
    from pyNastran.op2.op2 import OP2

    require_results(path)
    model = OP2(debug=None)
    chatter = StringIO()
    try:
        with redirect_stdout(chatter):
            model.set_results("displacements")
            model.read_op2(str(path), build_dataframe=False, skip_undefined_matrices=True)
    except Exception as exc:  # truncated files make pyNastran raise almost anything
        raise InputError(
            f"truncated or damaged; pyNastran says: {_fact(exc, chatter.getvalue())}",
            where=str(path),
            hint="is the file complete? did the solver end without a FATAL message?",
        ) from exc
    if not model.displacements:
        raise InputError(
            "holds no displacements", where=str(path), hint="the deck needs DISPLACEMENT(PLOT) = ALL and PARAM,POST,-1"
        )
    for key, table in model.displacements.items():
        if isinstance(key, tuple):
            raise InputError(f"superelement results ({key}) are not read", where=str(path))
        if table.data.shape[0] != 1:
            raise InputError(f"subcase {int(key)} occurs {table.data.shape[0]} times", where=str(path))
    return model


def _fact(exc: Exception, chatter: str) -> str:
    """What is worth showing of pyNastran's report: its first telling line, and the card it was at."""
    lines = [line.strip() for line in str(exc).splitlines() if line.strip(" =-*")]
    telling = [line for line in lines if not line.startswith("There are cross-reference errors")]
    fact = (
        re.sub(r"(\\n|\s)+", " ", telling[0]).removeprefix("KeyError: ").strip(" '")[:160]
        if telling
        else "no reason given"
    )
    card = re.search(r"problem adding \['(\w+)', '(\w+)'", chatter)
    return f"{fact} ({type(exc).__name__}{f' at {card[1]} {card[2]}' if card else ''})"
