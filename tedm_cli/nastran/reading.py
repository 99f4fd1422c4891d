"""Decks read through pyNastran: what it would ignore is refused first, and its failures become one clear error."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from io import StringIO
from pathlib import Path
from typing import Any

from tedm_cli.deck_units import SI, DeckUnits
from tedm_cli.errors import InputError
from tedm_cli.nastran.bulk.columns import Columns
from tedm_cli.nastran.bulk.lines import NotPlainError
from tedm_cli.nastran.bulk.plain import PlainCards
from tedm_cli.nastran.bulk.streamed import StreamedDeck
from tedm_cli.nastran.bulk.views import install
from tedm_cli.nastran.captured_output import captured_output, card_lines_of, complaint_of, fact_of
from tedm_cli.nastran.cards import LARGEST_INTEGER, BulkChecks, range_problem
from tedm_cli.nastran.control_words import read_statements
from tedm_cli.nastran.deck_lines import card_places, read_head
from tedm_cli.nastran.library import require_pynastran, without_integration
from tedm_cli.nastran.parameters import refuse_misspelt
from tedm_cli.nastran.plausible import check_plausible
from tedm_cli.nastran.scanning import include_file, scan
from tedm_cli.regular_file import require_regular_file


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
    require_regular_file(path)
    if not path.is_file():
        raise InputError("no such deck", where=str(path), hint="make one with `tedm write-deck`, or name your own")
    scan(path)
    head = read_head(path)
    read_statements(head.control)
    how = _How(path, cross_reference, allow_missing_enddata)
    try:
        model = _read(how, StreamedDeck(path, head))
    except (InputError, NotPlainError):  # pyNastran alone says what is wrong, or reads what is not plain
        model = _read(how, None)
    model.tedm_units = units
    for name, place in model.tedm_parameters.items():
        refuse_misspelt(name, place)
    check_plausible(model, str(path), units)
    return model


@dataclass(frozen=True)
class _How:
    """What `read_deck` is asked for."""

    path: Path
    cross_reference: bool
    allow_missing_enddata: bool


def _read(how: _How, streamed: StreamedDeck | None) -> Any:
    """Read a deck, its plain cards as columns where `streamed` takes them; raises as `read_deck`."""
    with without_integration():
        from pyNastran.bdf.bdf import BDF

    path = how.path
    model = BDF(debug=None)
    number = None if streamed is None else streamed.number
    checks = BulkChecks(model, path, allow_missing_enddata=how.allow_missing_enddata, number=number)
    with captured_output() as chatter:
        try:
            with _guided(path, streamed):
                model.read_bdf(str(path), xref=False, punch=False, encoding=any_encoding(model))
            checks.release()
        except (InputError, NotPlainError):
            raise
        except Exception as exc:  # malformed decks make pyNastran raise almost anything, and classes of its own
            raise _unread(
                exc, chatter.getvalue(), checks.place_of(card_lines_of(exc)), deck_files(model, path)
            ) from exc
        plain = PlainCards() if streamed is None else streamed.plain
        for name, count in plain.counts.items():
            model.card_count[name] = model.card_count.get(name, 0) + count
        install(model, Columns(model, plain))
        if how.cross_reference:
            _link(model, path, chatter)
    large = [int(n) for n in model.subcases if int(n) > LARGEST_INTEGER]
    if large:
        raise InputError(f"SUBCASE {large[0]}: is larger than any id", where=str(path))
    model.tedm_passed_over, model.tedm_parameters = checks.passed_over, checks.parameters
    model.tedm_element_temperatures = checks.element_temperatures
    model.tedm_how = None if streamed is None else how
    return model


def cross_reference(model: Any, path: Path) -> None:
    """Cross-reference the elements of a model that was read without; raises as `read_deck` does."""
    with captured_output() as chatter:
        try:
            _link(model, path, chatter)
        except (InputError, NotPlainError):
            if model.tedm_how is None:
                raise
            _link(_read(model.tedm_how, None), path, chatter)  # pyNastran alone says what is wrong


def _link(model: Any, path: Path, chatter: StringIO) -> None:
    try:
        model.cross_reference(
            xref_loads=False, xref_constraints=False, xref_aero=False, xref_sets=False, xref_optimization=False
        )
    except NotPlainError:
        raise
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


@contextmanager
def _guided(path: Path, streamed: StreamedDeck | None) -> Iterator[None]:
    """Let pyNastran find the files of INCLUDEs by the names that `scan` has found, read of each what is not `streamed`,
    and write out no endless SET."""
    from pyNastran.bdf import subcase
    from pyNastran.bdf.bdf_interface import pybdf

    def bounded(values: Sequence[Any]) -> Any:
        problem = range_problem(" ".join(str(value) for value in values).upper().replace(",", " ").split())
        if problem:
            hint = "write SET n = ALL" if "more ids" in problem else ""
            raise InputError(f"SET of the case control: {problem}", where=str(path), hint=hint)
        return expanded(values)

    def opened(reader: Any, *arguments: Any, **keywords: Any) -> Any:
        file = open_file(reader, *arguments, **keywords)
        if streamed is None:
            return file
        file.close()
        return StringIO("".join(streamed.left(Path(file.name))), newline="\n")

    expanded, open_file = subcase.expand_thru_case_control, pybdf.BDFInputPy._open_file
    with ExitStack() as stack:
        for owner, name, value in (
            (pybdf, "get_include_filename", include_file),
            (pybdf.BDFInputPy, "_open_file", opened),
            (subcase, "expand_thru_case_control", bounded),
        ):
            stack.callback(setattr, owner, name, getattr(owner, name))
            setattr(owner, name, value)
        yield
