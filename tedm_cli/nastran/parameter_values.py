"""Values of parameters: PARAM cards of the bulk data, which those of case control replace."""

from __future__ import annotations

from typing import Any

from tedm_cli.errors import InputError


def parameter(model: Any, name: str, where: str) -> str | None:
    """The value of a parameter as it is written, None where the deck does not give it.

    Raises
    ------
    InputError : case control gives subcases different values.
    """
    card = model.params.get(name)
    bulk = None if card is None else str(card.values[0])
    above, own = _in_case_control(model, name)
    values = {number: own.get(number, above) for number in _subcases(model)} or {0: above}
    given = {bulk if value is None else value for value in values.values()}
    if len(given) > 1:
        listed = ", ".join(f"{value or bulk or 'none'} in subcase {n}" for n, value in list(values.items())[:8])
        raise InputError(f"the subcases have different PARAM,{name}: {listed}", where=where)
    return given.pop()


def number_parameter(model: Any, name: str, default: float, where: str) -> float:
    """The value of a parameter that is a number, not below zero.

    Raises
    ------
    InputError : as `parameter`; a value that is no such number.
    """
    text = parameter(model, name, where)
    if text is None:
        return default
    try:
        value = float(text.upper().replace("D", "E"))
    except ValueError:
        value = -1.0
    if not 0.0 <= value < float("inf"):
        raise InputError(f"PARAM,{name},{text}: must be a number not below zero", where=where)
    return value


def _subcases(model: Any) -> list[int]:
    control = model.case_control_deck
    return [] if control is None else [int(number) for number in control.subcases if number]


def _in_case_control(model: Any, name: str) -> tuple[str | None, dict[int, str]]:
    """What PARAM lines say of a parameter above the subcases, and within each."""
    above: str | None = None
    own: dict[int, str] = {}
    number = 0
    for line in [] if model.case_control_deck is None else model.case_control_deck.lines:
        words = [word.strip().upper() for word in line.split("$")[0].replace("=", " ").replace(",", " ").split()]
        if words[:1] == ["SUBCASE"] and len(words) > 1 and words[1].isdigit():
            number = int(words[1])
        elif len(words) > 2 and words[:2] == ["PARAM", name]:
            if number:
                own[number] = words[2]
            else:
                above = words[2]
    return above, own
