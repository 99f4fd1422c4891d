"""Case and executive control of a user's model: what unit loads keep of it, what they drop, and what they refuse."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from tedm_cli.errors import InputError
from tedm_cli.nastran.bulk_lines import check_parameter
from tedm_cli.nastran.deck_lines import Line, Sections

# Makes up the structure or holds it; has to be the same for all unit loads.
_HELD = ("SPC", "MPC", "SUPORT1", "SUPORT", "K2GG", "M2GG", "NSM", "BGSET", "RIGID", "AUTOSPC")
_KEPT = ("TITLE", "ECHO", "SET", "MAXLINES", "LINE")
# Loads, and what belongs to other solutions than linear statics.
_LOADS = (
    *("LOAD", "CLOAD", "DLOAD", "LOADSET", "DEFORM", "P2G", "STATSUB", "TSTRU", "HDOT", "IC", "GUST", "TRIM", "BC"),
    *("METHOD", "CMETHOD", "FMETHOD", "RMETHOD", "SMETHOD", "ANALYSIS", "MODES", "RESVEC", "FREQUENCY", "SDAMPING"),
    *("TSTEP", "TSTEPNL", "NLPARM", "NONLINEAR", "NLLOAD", "RANDOM", "TFL", "B2GG", "B2PP", "K2PP", "M2PP", "A2GG"),
    *("AESYMXY", "AESYMXZ", "AECONFIG", "CSSCHD", "DIVERG", "MFLUID", "ADAPT", "DATAREC", "OUTRCV", "MODTRAK"),
    *("DESOBJ", "DESGLB", "DESSUB", "DESVAR", "DRSPAN", "DSAPRT", "LABEL", "SUBTITLE", "SEALL", "SEFINAL"),
)
_OUTPUT = (
    *("DISPLACEMENT", "VECTOR", "PRESSURE", "VELOCITY", "ACCELERATION", "SDISPLACEMENT", "SVELOCITY", "SACCELERATION"),
    *("SPCFORCES", "MPCFORCES", "OLOAD", "STRESS", "ELSTRESS", "STRAIN", "FORCE", "ELFORCE", "GPFORCE", "GPSTRESS"),
    *("GPSTRAIN", "STRFIELD", "ESE", "EKE", "EDE", "GPKE", "THERMAL", "FLUX", "ENTHALPY", "ELSUM", "NLSTRESS"),
    *("GSTRESS", "GSTRAIN", "GPSDCON", "ELSDCON", "SURFACE", "VOLUME", "MEFFMASS", "MAXMIN", "MONITOR", "GROUNDCHECK"),
    *("WEIGHTCHECK", "OFREQUENCY", "OTIME", "OMODES", "SEQDEP", "SKIP", "BOUTPUT", "SVECTOR", "ERP", "OUTPUT"),
    *("GKRESULTS", "BGRESULTS", "OTEMP", "SHELLTHK", "AEROF", "APRESSURE", "POST", "PARTN", "ACFPMRESULT", "CSTRESS"),
    *(
        "MAXLIST",
        "OPTION",
        "GPRSORT",
        "ELSUM",
        "PLOTID",
        "DATAREC",
        "ELAR",
        "NOUTPUT",
        "RCROSS",
        "FATIGUE",
        "MCFRACTION",
    ),
)
_REFUSED = {
    "SUBCOM": "a unit load must not combine subcases",
    "SUBSEQ": "a unit load must not combine subcases",
    "SYM": "a unit load must not combine subcases",
    "SYMCOM": "a unit load must not combine subcases",
    "SYMSEQ": "a unit load must not combine subcases",
    "REPCASE": "a unit load must not combine subcases",
    "SUPER": "superelements are not read: solve the model in one piece",
    "AUXCASE": "auxiliary models are not read",
    "STEP": "a unit load has no steps",
    "BCONTACT": "contact is not linear, so unit loads would not add up",
    "BCSET": "contact is not linear, so unit loads would not add up",
    "BOLTLD": "bolt preload loads the structure besides its temperature",
    "INITS": "initial stress loads the structure besides its temperature",
}
_STATEMENT = re.compile(r"\s*([A-Za-z][A-Za-z0-9]*)\s*(?:\(([^)]*)\)?)?\s*[=,]?\s*(.*?)\s*$", re.S)
_STATICS = {"101", "1", "STATIC", "STATICS", "SESTATIC", "SESTATICS"}
_HEAT = {"153", "159", "NLSCSH", "NLTCSH"}


@dataclass(frozen=True)
class Control:
    """Executive and case control lines that stay, above all subcases, and what the user should know of the rest."""

    executive: tuple[str, ...]
    lines: tuple[str, ...]
    sets: Mapping[str, int]
    material_temperature: bool
    notes: tuple[str, ...]


@dataclass(frozen=True)
class _Statement:
    word: str
    qualifier: str
    value: str
    lines: tuple[Line, ...]

    @property
    def key(self) -> str:
        """What the statement sets, such that a later one with the same key replaces it."""
        if self.word == "PARAM":
            return f"PARAM,{self.value.split(',')[0].strip().upper()}"
        return "TEMPERATURE(MATERIAL)" if self.word == "TEMPERATURE" and self.qualifier[:4] == "MATE" else self.word

    @property
    def text(self) -> str:
        """The statement on one line, in the form every Nastran and pyNastran read."""
        if self.word == "PARAM":
            return f"PARAM,{self.value}"
        return f"{self.word}{f'({self.qualifier})' if self.qualifier else ''} = {self.value}"

    @property
    def shown(self) -> str:
        return re.sub(r"\s+", "", self.value).upper()


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
    lines = [line.text.rstrip() for s in above if s.word in _KEPT for line in s.lines]
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
        words = line.code.upper().replace("=", " ").replace(",", " ").split()
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
            if solution in _HEAT:
                raise InputError(f"SOL {solution} is heat transfer, not a structural model", where=line.place)
            if solution not in _STATICS:
                notes.append(f"SOL {solution} is now SOL 101, linear statics")
            continue
        kept.append(line.text.rstrip())
    return kept, notes


def _levels(lines: Sequence[Line]) -> tuple[list[_Statement], dict[int, list[_Statement]], list[str]]:
    """Statements above the subcases, those of each subcase, and the names of plot sections that are skipped."""
    above: list[_Statement] = []
    subcases: dict[int, list[_Statement]] = {}
    current, plots, in_plot = above, [], False
    for s in _statements(lines):
        if s.word == "OUTPUT" and s.qualifier:
            in_plot = True
            plots.append(f"OUTPUT({s.qualifier})")
        elif s.word == "SUBCASE":
            in_plot = False
            if not s.value.isdigit():
                raise InputError("SUBCASE without a number", where=s.lines[0].place)
            if int(s.value) in subcases:
                raise InputError(f"SUBCASE {s.value} a second time", where=s.lines[0].place)
            current = subcases.setdefault(int(s.value), [])
        elif not in_plot:
            _check(s)
            current.append(s)
    return above, subcases, plots


def _statements(lines: Sequence[Line]) -> list[_Statement]:
    out, i = [], 0
    while i < len(lines):
        first, last = i, i
        text = lines[i].code
        i += 1
        if not text.strip():
            continue
        is_text = re.match(r"\s*(TITL|SUBT|LABE)", text, re.I) is not None  # may end in a comma without going on
        while text.endswith(",") and not is_text and i < len(lines):
            if lines[i].code.strip():
                text, last = text + lines[i].code.strip(), i
            i += 1
        parts = _STATEMENT.match(text)
        word, qualifier, value = (parts[1], parts[2] or "", parts[3]) if parts else (text.split()[0], "", "")
        qualifier = re.sub(r"\s", "", qualifier).upper()
        out.append(_Statement(_canonical(word.upper()), qualifier, value, tuple(lines[first : last + 1])))
    return out


def _canonical(word: str) -> str:
    """The full name of a command; Nastran looks at the first four letters."""
    known = ("SUBCASE", "PARAM", "TEMPERATURE", *_REFUSED, *_HELD, *_KEPT, *_LOADS, *_OUTPUT)
    if word in known:
        return word
    return next((k for k in known if len(word) >= 4 and len(k) >= 4 and k[:4] == word[:4]), word)


def _check(s: _Statement) -> None:
    place = s.lines[0].place
    if s.word in _REFUSED:
        raise InputError(f"{s.word}: {_REFUSED[s.word]}", where=place, hint="remove it")
    if s.word == "PARAM":
        name, _, value = s.value.partition(",")
        check_parameter(name.strip().upper(), value.split(",")[0].strip(), place)
    if s.word not in ("PARAM", "TEMPERATURE", *_HELD, *_KEPT, *_LOADS, *_OUTPUT):
        raise InputError(
            f"case control command {s.word} is not known here: it may load or hold the structure",
            where=place,
            hint="remove it from the model that write-deck reads",
        )
    if s.word == "ANALYSIS" and s.value.upper().startswith("HEAT"):
        raise InputError("ANALYSIS = HEAT is not a structural subcase", where=place, hint="remove the subcase")


def _is_held(s: _Statement) -> bool:
    if s.key == "PARAM,POST":
        return False
    return s.word in _HELD or s.word == "PARAM" or s.key == "TEMPERATURE(MATERIAL)"


def _refuse_differences(effective: Mapping[int, Mapping[str, _Statement]], where: str) -> None:
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


def _dropped(statements: Sequence[_Statement], subcases: int, plots: Sequence[str]) -> list[str]:
    notes = []
    if subcases:
        notes.append(f"{subcases} subcases of the model are replaced by the unit loads")
    selections: dict[str, None] = {}
    outputs: dict[str, None] = {}
    for s in statements:
        if s.word in _OUTPUT:
            outputs[s.word] = None
        elif s.word in _LOADS and s.word not in ("LABEL", "SUBTITLE"):
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
