"""Words of case control and the statements they make: what each means for a unit load; none unknown is passed over."""

from __future__ import annotations

import difflib
import re
from collections.abc import Sequence
from dataclasses import dataclass

from tedm_cli.errors import InputError
from tedm_cli.nastran.deck_lines import Line
from tedm_cli.nastran.parameters import refuse_misspelt

# Makes up the structure or holds it; has to be the same for all unit loads.
HELD = ("SPC", "MPC", "SUPORT1", "SUPORT", "K2GG", "NSM", "BGSET", "RIGID", "AUTOSPC")
KEPT = ("TITLE", "ECHO", "SET", "MAXLINES", "LINE")
# Loads besides temperature, and what makes the answer no linear one of the structure alone.
LOADS = ("LOAD", "CLOAD", "DLOAD", "LOADSET", "DEFORM", "P2G", "TSTRU", "HDOT", "IC", "GUST", "TRIM")
NOT_LINEAR = ("NLPARM", "NLSTEP", "TSTEPNL", "NONLINEAR", "NLLOAD", "STATSUB", "A2GG", "MFLUID", "ADAPT", "BC")
# What linear statics passes over: other solutions, optimisation, names.
IDLE = (
    *("METHOD", "CMETHOD", "FMETHOD", "RMETHOD", "SMETHOD", "ANALYSIS", "MODES", "RESVEC", "FREQUENCY", "SDAMPING"),
    *("TSTEP", "RANDOM", "TFL", "B2GG", "B2PP", "K2PP", "AESYMXY", "AESYMXZ", "AECONFIG", "CSSCHD", "DIVERG"),
    *("DATAREC", "OUTRCV", "MODTRAK", "MODSEL", "DESOBJ", "DESGLB", "DESSUB", "DESVAR", "DRSPAN", "DSAPRT"),
    *("LABEL", "SUBTITLE", "SEALL", "SEFINAL"),
)
OUTPUT = (
    *("DISPLACEMENT", "VECTOR", "PRESSURE", "VELOCITY", "ACCELERATION", "SDISPLACEMENT", "SVELOCITY", "SACCELERATION"),
    *("SPCFORCES", "MPCFORCES", "OLOAD", "STRESS", "ELSTRESS", "STRAIN", "FORCE", "ELFORCE", "GPFORCE", "GPSTRESS"),
    *("GPSTRAIN", "STRFIELD", "ESE", "EKE", "EDE", "GPKE", "THERMAL", "FLUX", "ENTHALPY", "ELSUM", "NLSTRESS"),
    *("GSTRESS", "GSTRAIN", "GPSDCON", "ELSDCON", "SURFACE", "VOLUME", "MEFFMASS", "MAXMIN", "MONITOR", "GROUNDCHECK"),
    *("WEIGHTCHECK", "OFREQUENCY", "OTIME", "OMODES", "SEQDEP", "SKIP", "BOUTPUT", "SVECTOR", "ERP", "OUTPUT"),
    *("GKRESULTS", "BGRESULTS", "OTEMP", "SHELLTHK", "AEROF", "APRESSURE", "POST", "PARTN", "ACFPMRESULT", "CSTRESS"),
    *("MAXLIST", "OPTION", "GPRSORT", "PLOTID", "ELAR", "NOUTPUT", "RCROSS", "FATIGUE", "MCFRACTION", "ELSTRN"),
    *("ACINTENSITY", "ACPOWER", "ACVELOCITY", "ADAPTERR", "ATVOUT", "BCRESULTS", "BOLTRESULTS", "CKGAP", "CZRESULTS"),
    *("ELAROUT", "FLXRESULTS", "GELSTRN", "GPLSTRN", "GTHSTRN", "GCRSTRN", "OPRESS", "OSTNINI", "OTMFORC", "PEAKOUT"),
    *("PFRESULTS", "PLSTRN", "CRSTRN", "RMAXMIN", "SETMC", "SETMCNAME", "TRLOSS", "TRPOWER", "PANCON", "GRDCON"),
    *("MODCON", "MODALE", "MPRES", "JRESULTS", "HOUTPUT", "CYCFORCES", "INTENSITY", "ELDATA"),
)
_COMBINED = "a unit load must not combine subcases"
_CONTACT = "contact is not linear, so unit loads would not add up"
_MATRIX = "the mass of a matrix has no place, so its gravity is not known: give it as CONM2"
REFUSED = {
    **dict.fromkeys(("SUBCOM", "SUBSEQ", "SYM", "SYMCOM", "SYMSEQ", "REPCASE"), _COMBINED),
    "SUPER": "superelements are not read: solve the model in one piece",
    "AUXCASE": "auxiliary models are not read",
    "STEP": "a unit load has no steps",
    **dict.fromkeys(("BCONTACT", "BCSET"), _CONTACT),
    "BOLTLD": "bolt preload loads the structure besides its temperature",
    "INITS": "initial stress loads the structure besides its temperature",
    **dict.fromkeys(("M2GG", "M2PP"), _MATRIX),
}
_KNOWN = ("SUBCASE", "PARAM", "TEMPERATURE", *REFUSED, *HELD, *KEPT, *LOADS, *NOT_LINEAR, *IDLE, *OUTPUT)
_SETS = ("TEMPERATURE", "SPC", "MPC")  # whose value is the id of a set
_TEMPERATURES = ("LOAD", "INITIAL", "MATERIAL", "BOTH", "HSUBCASE", "HTIME")
_SHOWN = 60  # letters of a word or a value in a message
_NAME_AND_REST = re.compile(r"\s*([A-Za-z][A-Za-z0-9]*)(.*)", re.S)
_REST = re.compile(r"\s*(?:\(([^)]*)\)?)?(\s*[=,]\s*|\s+|$)(.*?)\s*", re.S)


@dataclass(frozen=True)
class Statement:
    """A statement of case control: its word in full, what its brackets hold, its value, and its lines.

    separator : what stands before the value, an equals sign, a comma or nothing.
    """

    word: str
    qualifier: str
    separator: str
    value: str
    lines: tuple[Line, ...]

    @property
    def place(self) -> str:
        return self.lines[0].place

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

    @property
    def parameter(self) -> tuple[str, str]:
        """Name and value of a PARAM statement."""
        name, _, value = self.value.partition(",")
        return name.strip().upper(), value.split(",")[0].strip()


def read_statements(lines: Sequence[Line]) -> list[Statement]:
    """The statements of case control, without those of plot sections: OUTPUT(PLOT) and the like, up to a SUBCASE.

    Raises
    ------
    InputError : a word that is not known or misspelt, or that no deck of ours may have, with its file and line.
    """
    out: list[Statement] = []
    in_plot = False
    for statement in _split(lines):
        if statement.word == "OUTPUT" and statement.qualifier:
            in_plot = True
        elif statement.word == "SUBCASE":
            in_plot = False
        elif in_plot:
            continue
        else:
            _check(statement)
        out.append(statement)
    return out


def check_selections(statements: Sequence[Statement]) -> None:
    """Refuse selections without their equals sign, which solvers read and pyNastran passes over, and sets of no id."""
    for s in statements:
        if s.word in ("TEMPERATURE", "LABEL", *HELD) and s.separator != "=":
            fact = f"{s.word} {s.value[:_SHOWN]}: has no equals sign"
            raise InputError(fact, where=s.place, hint=f"write {s.word} = ...")
        if s.word in _SETS and not re.fullmatch("[0-9]+", s.value):
            fact = f"{s.word} = {s.value[:_SHOWN]}: is no id of a set"
            raise InputError(fact, where=s.place, hint="write its number alone, and one command to a line")


def _split(lines: Sequence[Line]) -> list[Statement]:
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
        out.append(_statement(text, tuple(lines[first : last + 1])))
    return out


def _statement(text: str, lines: tuple[Line, ...]) -> Statement:
    named = _NAME_AND_REST.fullmatch(text)
    rest = _REST.fullmatch(named[2]) if named else None
    if named is None or rest is None:
        return Statement(text.split()[0], "", "", "", lines)
    qualifier = ",".join(" ".join(part.split()) for part in (rest[1] or "").upper().split(","))
    return Statement(_canonical(named[1].upper()), qualifier, rest[2].strip(), rest[3], lines)


def _canonical(word: str) -> str:
    """The full name of a command.

    Nastran looks at the first four letters alone. What goes on otherwise than the name does is taken for a slip.
    """
    if word in _KNOWN or len(word) < 4:
        return word
    return next((k for k in _KNOWN if k.startswith(word) or word == f"{k}S"), word)


def _check(s: Statement) -> None:
    if s.word in REFUSED:
        raise InputError(f"{s.word}: {REFUSED[s.word]}", where=s.place, hint="remove it")
    if s.word not in _KNOWN:
        near = difflib.get_close_matches(s.word.upper(), _KNOWN, n=1)
        raise InputError(
            f"case control command {s.word[:_SHOWN]} is not known here: it may load or hold the structure",
            where=s.place,
            hint=f"is it {near[0]}, misspelt? else remove it" if near else "remove it from the deck",
        )
    if s.word == "PARAM":
        refuse_misspelt(s.parameter[0], s.place)
    if s.word == "TEMPERATURE" and s.qualifier and not _is_temperature(s.qualifier):
        raise InputError(
            f"TEMPERATURE({s.qualifier[:_SHOWN]}) is not known here",
            where=s.place,
            hint="write TEMPERATURE(LOAD), (INITIAL), (MATERIAL) or (BOTH)",
        )


def _is_temperature(qualifier: str) -> bool:
    return any(len(part) >= 4 and known.startswith(part) for part in qualifier.split(",") for known in _TEMPERATURES)
