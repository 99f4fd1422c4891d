"""Strict TOML: unknown keys are errors, and every problem of a file is reported at once with its dotted path."""

from __future__ import annotations

import difflib
import hashlib
import math
import re
from codecs import BOM_UTF16_BE, BOM_UTF16_LE
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Literal, TypeVar, get_args, get_origin

import numpy as np
from pydantic import AfterValidator, BaseModel, ConfigDict, Field, GetCoreSchemaHandler, ValidationError
from pydantic_core import CoreSchema, core_schema

from tedm_cli import quantities as q
from tedm_cli.errors import ConfigError, InputError
from tedm_cli.files.provenance import ConfigFile
from tedm_cli.regular_file import require_regular_file
from tedm_cli.strict_toml import parsed_toml

_FEW_KEYS = 6  # a table with no more of them names them all
IDENTIFIER = r"^[A-Za-z0-9_-]{1,64}$"  # what may be part of a file's name anywhere
LABEL = r"^[A-Za-z][A-Za-z0-9]*$"  # what _ may join to others
OPTICAL_NAME = r"^[A-Za-z][A-Za-z0-9_.-]*$"
MATRIX_NAME = r"^[A-Z][A-Z0-9]{0,7}$"
ID_RANGE = r"^[1-9][0-9]{0,8}:[1-9][0-9]{0,8}$"
PATTERNS = {
    IDENTIFIER: "made of letters without accents, digits, _ and -, at most 64",
    LABEL: "made of letters without accents and digits, a letter first",
    OPTICAL_NAME: "made of letters without accents, digits, _ . and -, a letter first",
    MATRIX_NAME: "made of capital letters and digits, a letter first, at most eight",
    ID_RANGE: "a range of ids such as '1:99'",
}


class Strict(BaseModel):
    """Base of all configuration tables: frozen, no unknown keys, no silent conversion of strings to numbers."""

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True, allow_inf_nan=False)


@dataclass(frozen=True)
class Bounded:
    """Marks a number as one of a quantity, whose bounds it must keep; `or_infinite`: infinity is an open end."""

    quantity: q.Quantity
    or_infinite: bool = False

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        return core_schema.no_info_after_validator_function(self._checked, handler(source))

    def _checked(self, value: float) -> float:
        fact = self.quantity.fact(value)
        if fact and not (self.or_infinite and math.isinf(value)):
            raise ValueError(fact)
        return value


@dataclass(frozen=True)
class Form:
    """Says what the values of a type look like, where that does not follow from the type."""

    words: str


def _one_line(text: str) -> str:
    """A text that is seen, in one line."""
    if not text.strip():
        raise ValueError("must not be blank; leave the key out")
    if unseen := [c for c in text if not c.isprintable()]:
        raise ValueError(f"must be one line of printable text; it holds {unseen[0]!r}")
    return text


OneLine = Annotated[str, Field(max_length=200), AfterValidator(_one_line), Form("text in one line")]
Length = Annotated[float, Bounded(q.LENGTH)]
LengthOrZero = Annotated[float, Bounded(q.LENGTH_OR_ZERO)]
LengthTolerance = Annotated[float, Bounded(q.LENGTH_TOLERANCE)]
Offset = Annotated[float, Bounded(q.OFFSET)]
OpticalPath = Annotated[float, Bounded(q.OPTICAL_PATH)]
Coordinate = Annotated[float, Bounded(q.COORDINATE)]
Angle = Annotated[float, Bounded(q.ANGLE)]
AngleTolerance = Annotated[float, Bounded(q.ANGLE_TOLERANCE)]
Mass = Annotated[float, Bounded(q.MASS)]
AbsoluteTemperature = Annotated[float, Bounded(q.ABSOLUTE_TEMPERATURE)]
TemperatureLevel = Annotated[float, Bounded(q.TEMPERATURE_ASD)]
GradientLevel = Annotated[float, Bounded(q.GRADIENT_ASD)]
Frequency = Annotated[float, Bounded(q.FREQUENCY)]
Duration = Annotated[float, Bounded(q.DURATION)]
Probability = Annotated[float, Bounded(q.PROBABILITY)]
Coefficient = Annotated[float, Bounded(q.CORRELATION)]
Id = Annotated[int, Bounded(q.ID)]
FileName = Annotated[str, Field(min_length=1), Form("file name")]  # no name would be the folder itself
Place = Annotated[list[Coordinate], Field(min_length=3, max_length=3)]
Direction = Annotated[list[Annotated[float, Bounded(q.DIRECTION)]], Field(min_length=3, max_length=3)]
Axes = Annotated[list[Direction], Field(min_length=3, max_length=3)]


#: Unit vectors printed to six digits are off unit length and right angles by up to sqrt(3) of a millionth.
PRINTED = 2e-6
_EXACT = 1e-12  # what is off by less is kept to the bit


def _orthonormal(value: list[list[float]]) -> list[list[float]]:
    """Axes that are no more off than printed digits leave them, as the nearest that are orthonormal."""
    a = np.array(value)
    off = float(np.abs(a @ a.T - np.eye(3)).max())
    u, size, v = np.linalg.svd(a)
    nearest = u @ v
    if off <= PRINTED and np.linalg.det(a) > 0.0:
        return value if off <= _EXACT else [[float(c) for c in row] for row in nearest]
    fact = "rows must be three right-handed orthonormal unit vectors"
    if size[-1] < 1e-3 * size[0]:
        raise ValueError(f"{fact}; these do not span the space")
    if np.linalg.det(a) < 0.0:
        raise ValueError(f"{fact}; these are left-handed: turn one round, or exchange two")
    shown = ", ".join("[" + ", ".join(f"{round(float(c), 9) + 0.0!r}" for c in row) + "]" for row in nearest)
    raise ValueError(
        f"{fact}; lengths and right angles are off by {off:.2g}, more than rounded digits leave ({PRINTED:g});"
        f" the nearest are [{shown}]"
    )


OrthonormalAxes = Annotated[Axes, AfterValidator(_orthonormal), Form("3 unit vectors, as rows")]


_MEANT = "unknown key; did you mean "


T = TypeVar("T", bound=Strict)


def read_toml(path: Path, *, hint: str = "") -> tuple[ConfigFile, dict[str, Any]]:
    """Read a TOML file; raise `InputError` when it cannot be read and `ConfigError` when it is not TOML.

    `hint`: what to do where there is no such file.
    """
    require_regular_file(path)
    try:
        raw = path.read_bytes()
    except (OSError, ValueError) as exc:  # ValueError: a path with a null character
        fact = getattr(exc, "strerror", None) or str(exc)
        is_lost = isinstance(exc, FileNotFoundError | IsADirectoryError | NotADirectoryError | ValueError)
        raise InputError(
            f"cannot read the configuration ({fact})", where=str(path), hint=hint if is_lost else ""
        ) from None
    try:
        text = raw.decode("utf-8-sig")
    except UnicodeDecodeError as exc:
        hint = "save it as UTF-8; it begins as UTF-16 does" if raw[:2] in (BOM_UTF16_LE, BOM_UTF16_BE) else ""
        raise ConfigError([("", f"not valid TOML: {exc}")], where=str(path), hint=hint) from None
    return ConfigFile(path, text, hashlib.sha256(raw).hexdigest()), parsed_toml(text, where=str(path))


def named_by_project(key: str) -> str:
    """The hint for a configuration that the project file does not name, and that is not beside it."""
    return f'{key}.toml beside the project file is read where that names no other: {key} = "..."'


def load(model: type[T], path: Path, *, hint: str = "") -> tuple[ConfigFile, T]:
    """Read `path` and check it against `model`; raise one `ConfigError` that lists all problems."""
    file, data = read_toml(path, hint=hint)
    return file, validate(model, data, where=str(path))


def validate(model: type[T], data: Mapping[str, Any], *, where: str) -> T:
    """Check `data` against `model`, translating pydantic's report into dotted paths and near-miss suggestions."""
    try:
        return model.model_validate(data)
    except ValidationError as exc:
        raise ConfigError(_problems(model, data, exc), where=where) from None


def _problems(model: type[BaseModel], data: Mapping[str, Any], exc: ValidationError) -> list[tuple[str, str]]:
    """(dotted path, fact) of every problem; a value that fits no form of several is one problem."""
    found: dict[str, list[str]] = {}
    alternatives, fitting = set(), set()
    for error in exc.errors():
        path, is_alternative = _dotted(error, data)
        if is_alternative:
            alternatives.add(path)
            # Where the value has one of the forms and only breaks its bounds, the other forms are beside the point.
            if path in fitting:
                continue
            if error["type"] in ("value_error", "too_short", "too_long"):
                fitting.add(path)
                found.pop(path, None)
        found.setdefault(path, []).append(
            ("" if is_alternative else _brackets(model, error, path)) or _fact(model, error)
        )
    # Where one form fits down to some entries, only these are wrong: the value as a whole need not be another form.
    for path in alternatives:
        if any(other != path and other.startswith(path) for other in alternatives):
            del found[path]
    problems = [(path, _either(facts) if path in alternatives else "; ".join(facts)) for path, facts in found.items()]
    return _misspelt(problems)


def _misspelt(problems: list[tuple[str, str]]) -> list[tuple[str, str]]:
    """A key that is missing, and beside it an unknown one like it, are one problem: the word that is misspelt."""
    out = list(problems)
    for path, fact in problems:
        table, _, _ = path.rpartition(".")
        meant = fact.removeprefix(_MEANT).removesuffix("?") if fact.startswith(_MEANT) else ""
        place = f"{table}.{meant}" if table else meant
        lost = next((p for p in out if p[0] == place and p[1].startswith("missing")), None)
        if meant and lost is not None:
            out[out.index(lost)] = (path, f"{_MEANT}{meant}, which is missing?")
            out.remove((path, fact))
    return out


def _dotted(error: Any, data: Any) -> tuple[str, bool]:
    """`test_mass[0].side_m`, and whether pydantic's place also names one of several forms, which is no key."""
    out, here, is_alternative = "", data, False
    for number, part in enumerate(error["loc"]):
        if isinstance(part, int) and isinstance(here, list):
            out, here = f"{out}[{part}]", here[part]
        elif isinstance(here, Mapping) and part in here:
            out, here = f"{out}.{part}" if out else part, here[part]
        elif error["type"] == "missing" and number == len(error["loc"]) - 1:
            out = f"{out}.{part}" if out else str(part)
        else:
            is_alternative = True
    return out, is_alternative


def _brackets(model: type[BaseModel], error: Any, path: str) -> str:
    """What to write where a table stands for an array of tables, or an array for a table; "" where it is not that."""
    name = re.sub(r"\[\d+\]", "", path)
    holds_tables = any(models_in(kind) for key, kind in _fields(model) if (key,) == error["loc"][-1:])
    if error["type"] == "list_type" and isinstance(error["input"], Mapping) and holds_tables:
        return f"there may be several of these tables: write [[{name}]], in double brackets"
    if error["type"] == "model_type" and isinstance(error["input"], list) and not path.endswith("]"):
        return f"there is one such table: write [{name}], in single brackets"
    return ""


def _fact(model: type[BaseModel], error: Any) -> str:
    kind = error["type"]
    if kind == "extra_forbidden":
        known = _known_keys(model, error["loc"][:-1])
        near = difflib.get_close_matches(str(error["loc"][-1]), known, n=1, cutoff=0.5)
        few = f"; its table has {', '.join(known)}" if 0 < len(known) <= _FEW_KEYS else ""
        return f"{_MEANT}{near[0]}?" if near else f"unknown key{few}"
    if kind == "missing":
        choices = _choices(model, str(error["loc"][-1]))
        return f"missing; wanted one of {', '.join(map(repr, choices))}" if choices else "missing"
    if kind == "string_pattern_mismatch":
        return f"must be {PATTERNS[error['ctx']['pattern']]} (found {error['input']!r:.60})"
    if kind in ("dict_type", "model_type"):
        return f"must be a table (found {error['input']!r:.60})"
    message = re.sub("^(Input|List|String) should", "must", str(error["msg"]).removeprefix("Value error, "))
    message = message.replace(" after validation", "")
    shown = repr(error["input"])
    return message if kind == "value_error" or len(shown) > 60 else f"{message} (found {shown})"


def _either(facts: list[str]) -> str:
    """`must be a valid number or must be a valid list (found 'x')`."""
    messages = [fact.rpartition(" (found ")[0] or fact for fact in facts]
    return " or ".join(messages) + facts[-1].removeprefix(messages[-1])


def _known_keys(model: type[BaseModel], place: Sequence[int | str]) -> list[str]:
    """The keys that the table at pydantic's `place` may have, of whichever form it has there."""
    tables: list[type[BaseModel]] = [model]
    for part in place:  # one that is no key is a number in a list, or the name of a form
        of_key = [f.annotation for m in tables for name, f in m.model_fields.items() if (f.alias or name) == part]
        tables = [table for annotation in of_key for table in models_in(annotation)] or tables
    return list(dict.fromkeys(f.alias or name for m in tables for name, f in m.model_fields.items()))


def _choices(model: type[BaseModel], key: str) -> tuple[Any, ...]:
    """The values `key` may have, where it is a choice wherever it occurs."""
    found = {get_args(kind) if get_origin(kind) is Literal else () for name, kind in _fields(model) if name == key}
    return found.pop() if len(found) == 1 else ()


def _fields(model: type[BaseModel]) -> list[tuple[str, Any]]:
    """(key, annotation) of all fields of `model` and of the tables nested in it."""
    seen: dict[type[BaseModel], None] = {}
    fields: list[tuple[str, Any]] = []

    def visit(m: type[BaseModel]) -> None:
        if m in seen:
            return
        seen[m] = None
        for name, field in m.model_fields.items():
            fields.append((field.alias or name, field.annotation))
            for arg in models_in(field.annotation):
                visit(arg)

    visit(model)
    return fields


def models_in(annotation: Any) -> list[type[BaseModel]]:
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return [annotation]
    out: list[type[BaseModel]] = []
    for arg in getattr(annotation, "__args__", ()):
        out += models_in(arg)
    return out
