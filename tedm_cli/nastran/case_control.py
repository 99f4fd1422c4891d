"""Case and executive control of a user's model: what unit loads keep of it, what they drop, and what they refuse."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from tedm_cli.errors import InputError
from tedm_cli.nastran.control_words import HELD, IDLE, KEPT, LOADS, NOT_LINEAR, OUTPUT, Statement, read_statements
from tedm_cli.nastran.deck_lines import Line, Sections
from tedm_cli.nastran.executive import HEAT, STATICS, words_of
from tedm_cli.nastran.parameters import check_parameter


@dataclass(frozen=True)
class Control:
    """Executive and case control lines that stay, above all subcases, and what the user should know of the rest."""

    executive: tuple[str, ...]
    lines: tuple[str, ...]
    sets: Mapping[str, int]
    material_temperature: bool
    notes: tuple[str, ...]


def unit_control(sections: Sections, subcase: int | None) -> Control:
    """What the unit loads keep of a model's executive and case control.

    Constraints are those common to all subcases, or those of `subcase` where it is given.

    Raises
    ------
    InputError : alters, restarts, heat transfer, combined subcases, superelements, contact, a command not known here;
        subcases with different constraints while `subcase` is None, or no such subcase.
    """
    executive, notes = _executive(sections.executive)
    above, subcases, plots = _levels(sections.control)
    where = str(sections.files[0])
    if subcase is not None and subcase not in subcases:
        listed = ", ".join(str(n) for n in subcases) or "none"
        raise InputError(
            f"has no subcase {subcase}; there are: {listed}", where=where, hint="correct model.constraints_of_subcase"
        )
    base = {s.key: s for s in above if _is_held(s)}
    effective = {n: {**base, **{s.key: s for s in own if _is_held(s)}} for n, own in subcases.items()} or {0: base}
    chosen = effective[next(iter(effective)) if subcase is None else subcase]
    if subcase is None:
        _refuse_differences(effective, where)
    elif len(subcases) > 1:
        notes.append(f"constraints are those of subcase {subcase}")
    lines = [line.text.rstrip() for s in above if s.word in KEPT for line in s.lines]
    lines += [s.text for s in chosen.values()]
    notes += _dropped([*above, *(s for own in subcases.values() for s in own)], len(subcases), plots)
    return Control(
        executive=tuple(executive),
        lines=tuple(lines),
        sets={k: int(s.value) for k, s in chosen.items() if k in ("SPC", "MPC", "SUPORT1") and s.value.isdigit()},
        material_temperature="TEMPERATURE(MATERIAL)" in chosen,
        notes=tuple(notes),
    )


def _executive(lines: Sequence[Line]) -> tuple[list[str], list[str]]:
    kept, notes = [], []
    for line in lines:
        words = words_of(line)
        if not words:
            continue
        head = words[0]
        if head in ("ALTER", "MALTER", "ENDALTER", "COMPILE", "LINK", "DMAP", "SUBDMAP"):
            raise InputError(
                f"{head}: the model alters Nastran's solution sequence", where=line.place, hint="remove it"
            )
        if head in ("RESTART", "DBLOCATE", "DBLOAD", "CONNECT"):
            raise InputError(f"{head}: a unit-load run starts from the deck alone", where=line.place, hint="remove it")
        if head == "ASSIGN":
            if len(words) > 1 and words[1] in ("OUTPUT2", "OUTPUT4", "USERFILE"):
                notes.append(f"dropped from executive control: {line.code.strip()}")
                continue
            raise InputError("ASSIGN: a unit-load run starts from the deck alone", where=line.place, hint="remove it")
        if head == "APP" and words[1:] not in (["DISP"], ["DISPLACEMENT"]):
            raise InputError("APP: only structural models make unit loads", where=line.place)
        if head == "SOL":
            solution = words[1] if len(words) > 1 else ""
            if solution in HEAT:
                raise InputError(f"SOL {solution} is heat transfer, not a structural model", where=line.place)
            if solution not in STATICS:
                notes.append(f"SOL {solution} is now SOL 101, linear statics")
            continue
        kept.append(line.text.rstrip())
    return kept, notes


def _levels(lines: Sequence[Line]) -> tuple[list[Statement], dict[int, list[Statement]], list[str]]:
    """Statements above the subcases, those of each subcase, and the names of plot sections that are skipped."""
    above: list[Statement] = []
    subcases: dict[int, list[Statement]] = {}
    current, plots = above, []
    for s in read_statements(lines):
        if s.word == "OUTPUT" and s.qualifier:
            plots.append(f"OUTPUT({s.qualifier})")
        elif s.word == "SUBCASE":
            if not s.value.isdigit():
                raise InputError("SUBCASE without a number", where=s.place)
            if int(s.value) in subcases:
                raise InputError(f"SUBCASE {s.value} a second time", where=s.place)
            current = subcases.setdefault(int(s.value), [])
        else:
            if s.word == "PARAM":
                check_parameter(*s.parameter, s.place)
            if s.word == "ANALYSIS" and s.value.upper().startswith("HEAT"):
                raise InputError(
                    "ANALYSIS = HEAT is not a structural subcase", where=s.place, hint="remove the subcase"
                )
            current.append(s)
    return above, subcases, plots


def _is_held(s: Statement) -> bool:
    if s.key == "PARAM,POST":
        return False
    return s.word in HELD or s.word == "PARAM" or s.key == "TEMPERATURE(MATERIAL)"


def _refuse_differences(effective: Mapping[int, Mapping[str, Statement]], where: str) -> None:
    for key in dict.fromkeys(key for held in effective.values() for key in held):
        values = {
            n: held[key].shown.removeprefix(key[6:] + ",") if key in held else "none" for n, held in effective.items()
        }
        if len(set(values.values())) > 1:
            listed = ", ".join(f"{v} in subcase {n}" for n, v in list(values.items())[:8])
            raise InputError(
                f"the subcases have different {key}: {listed}",
                where=where,
                hint="set model.constraints_of_subcase to the subcase whose constraints the unit loads shall have",
            )


def _dropped(statements: Sequence[Statement], subcases: int, plots: Sequence[str]) -> list[str]:
    notes = []
    if subcases:
        notes.append(f"{subcases} subcases of the model are replaced by the unit loads")
    selections: dict[str, None] = {}
    outputs: dict[str, None] = {}
    for s in statements:
        if s.word in OUTPUT:
            outputs[s.word] = None
        elif s.word in (*LOADS, *NOT_LINEAR, *IDLE) and s.word not in ("LABEL", "SUBTITLE"):
            selections[f"{s.word} = {s.value}"] = None
        elif s.word == "TEMPERATURE" and s.key == s.word:
            selections[f"TEMPERATURE{f'({s.qualifier})' if s.qualifier else ''} = {s.value}"] = None
    if selections:
        shown = list(selections)
        notes.append("dropped: " + ", ".join(shown[:12]) + (f" and {len(shown) - 12} more" if len(shown) > 12 else ""))
    for own in ("DISPLACEMENT", "OUTPUT"):
        outputs.pop(own, None)
    if outputs or plots:
        notes.append("output requests dropped: " + ", ".join([*outputs, *dict.fromkeys(plots)]))
    return notes
