"""Case control and parameters of a unit-load deck: temperature is its one load, and every subcase is held alike."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from tedm_cli.errors import InputError
from tedm_cli.nastran.control_words import HELD, LOADS, NOT_LINEAR, Statement, check_selections, read_statements
from tedm_cli.nastran.deck_lines import read_head
from tedm_cli.nastran.executive import STATICS, solution
from tedm_cli.nastran.parameters import check_parameter
from tedm_cli.nastran.reading import parameter_places

SUPERELEMENT_LOADS = "TEDMPSE"
"""The matrix in which `write-deck` puts the loads of superelements."""
_HINT = "remove it: a unit load is a temperature step and nothing else"


def check_unit_load_control(model: Any, path: Path, *, superelements: bool = False) -> None:
    """Refuse what makes a deck, with its bulk data in a pyNastran model, one of other loads than unit loads.

    With `superelements` the forces of P2G are those of temperature on these.

    Raises
    ------
    InputError : another solution than linear statics, heat transfer, a load besides temperature, what is not linear,
        supports that differ between subcases, a parameter that alters a unit load, enforced displacements, a statement
        without its equals sign.
    """
    where, head = str(path), read_head(path)
    _check_heat(model, where)
    statements = read_statements(head.control)
    check_selections(statements)
    subcases: dict[str, dict[str, Statement]] = {}
    above: dict[str, Statement] = {}
    current = above
    number = next((s.value for s in statements if s.word == "SUBCASE"), "")  # what is above all is in the first too
    for s in statements:
        if s.word == "SUBCASE":
            number, current = s.value, subcases.setdefault(s.value, {})
        else:
            if not (superelements and s.word == "P2G"):
                _check(s, f"{s.place}: subcase {number}" if number else s.place)
            current[s.key] = s
    found = solution(head.executive)
    if found not in STATICS:
        raise InputError(
            f"SOL {found} is not linear statics" if found else "has no SOL 101 line",
            where=where,
            hint="a unit-load deck is SOL 101; see `tedm write-deck`",
        )
    for key in (*HELD, "P2G"):
        chosen = {n: own[key].shown if key in (own := above | s) else "none" for n, s in subcases.items()}
        if len(set(chosen.values())) > 1:
            listed = ", ".join(f"{v} in subcase {n}" for n, v in list(chosen.items())[:8])
            raise InputError(f"the subcases have different {key}: {listed}", where=where)
    check_parameters(model, statements, where)
    _check_enforced(model, where)


def check_parameters(model: Any, statements: Sequence[Statement], where: str) -> None:
    """Refuse parameters that alter a unit load, in the bulk data of a model and in case control."""
    for s in statements:
        if s.word == "PARAM":
            check_parameter(*s.parameter, s.place)
    places = parameter_places(model)
    for name, card in model.params.items():
        check_parameter(str(name), str(card.values[0]), places.get(str(name), where))


def _check(s: Statement, place: str) -> None:
    shown = f"{s.word} = {s.value[:60]}"
    if s.word == "P2G" and s.value.strip().upper() == SUPERELEMENT_LOADS:
        raise InputError(
            f"{shown} loads superelements, which are not taken here",
            where=place,
            hint="are the tables [[superelement]] in the model configuration?",
        )
    if s.word in LOADS:
        raise InputError(f"{shown} loads the structure besides its temperature", where=place, hint=_HINT)
    if s.word in NOT_LINEAR:
        raise InputError(f"{shown} makes it no linear statics of the structure alone", where=place, hint=_HINT)
    if s.word == "ANALYSIS" and not s.value.upper().startswith("STAT"):
        raise InputError(f"{shown} is no linear statics", where=place, hint="remove the subcase")


def _check_heat(model: Any, where: str) -> None:
    subcases = {n: s for n, s in sorted(model.case_control_deck.subcases.items()) if n != 0}
    heat = [n for n, s in subcases.items() if "HEAT" in str(s.params.get("ANALYSIS", [""])[0]).upper()]
    if heat or "HEATSTAT" in model.params:
        what = f"subcase {heat[0]} (ANALYSIS = HEAT)" if heat else "PARAM,HEATSTAT"
        raise InputError(
            f"{what} asks for heat transfer: its results are temperatures, not displacements",
            where=where,
            hint="a unit-load deck is SOL 101 with a temperature step per subcase; see `tedm write-deck`",
        )


def _check_enforced(model: Any, where: str) -> None:
    for spcs in model.spcs.values():
        for spc in spcs:
            if spc.type == "SPC" and any(spc.enforced):
                raise InputError(
                    f"SPC {spc.conid} enforces a displacement, which every unit load would contain",
                    where=where,
                    hint="hold the structure at zero",
                )
