"""Strict TOML: unknown keys are errors, and every problem of a file is reported at once with its dotted path."""

from __future__ import annotations

import difflib
import hashlib
import re
import tomllib
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, Literal, TypeVar, get_args, get_origin

from pydantic import BaseModel, ConfigDict, ValidationError

from tedm_cli.errors import ConfigError, InputError
from tedm_cli.files.provenance import ConfigFile

# Control characters but tab and line feed, and those that turn the direction of what follows.
_STEERING = re.compile("[\x00-\x08\x0b-\x1f\x7f-\x9f\u2028-\u202e\u2066-\u2069]")
IDENTIFIER = r"^[A-Za-z0-9_-]+$"  # what may be part of a file's name anywhere


class Strict(BaseModel):
    """Base of all configuration tables: frozen, no unknown keys, no silent conversion of strings to numbers."""

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True, allow_inf_nan=False)


T = TypeVar("T", bound=Strict)


def read_toml(path: Path) -> tuple[ConfigFile, dict[str, Any]]:
    """Read a TOML file; raise `InputError` when it is not there and `ConfigError` when it is not TOML."""
    try:
        raw = path.read_bytes()
    except OSError as exc:
        raise InputError(
            f"cannot read the configuration ({exc.strerror})", where=str(path), hint="give its path with --config"
        ) from exc
    try:
        text = raw.decode("utf-8")
        data = tomllib.loads(text)
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as exc:
        raise ConfigError([("", f"not valid TOML: {exc}")], where=str(path)) from exc
    problems = list(_steering(data, ""))
    if problems:
        raise ConfigError(problems, where=str(path), hint="delete the character")
    return ConfigFile(path, text, hashlib.sha256(raw).hexdigest()), data


def _steering(value: Any, path: str) -> Iterator[tuple[str, str]]:
    """Places of control characters: no text needs them, and files, pages and terminals do not take them as text."""
    if isinstance(value, str):
        found = _STEERING.search(value)
        if found:
            yield path, f"holds the control character U+{ord(found[0]):04X}"
    elif isinstance(value, list):
        for number, item in enumerate(value):
            yield from _steering(item, f"{path}[{number}]")
    elif isinstance(value, dict):
        for key, item in value.items():
            name = f"{path}.{key}".removeprefix(".")
            yield from _steering(key, _STEERING.sub("?", name))
            yield from _steering(item, _STEERING.sub("?", name))


def load(model: type[T], path: Path) -> tuple[ConfigFile, T]:
    """Read `path` and check it against `model`; raise one `ConfigError` that lists all problems."""
    file, data = read_toml(path)
    return file, validate(model, data, where=str(path))


def validate(model: type[T], data: Mapping[str, Any], *, where: str) -> T:
    """Check `data` against `model`, translating pydantic's report into dotted paths and near-miss suggestions."""
    try:
        return model.model_validate(data)
    except ValidationError as exc:
        raise ConfigError(_problems(model, data, exc), where=where) from exc


def _problems(model: type[BaseModel], data: Mapping[str, Any], exc: ValidationError) -> list[tuple[str, str]]:
    """(dotted path, fact) of every problem; a value that fits no form of several is one problem."""
    found: dict[str, list[str]] = {}
    alternatives = set()
    for error in exc.errors():
        path, is_alternative = _dotted(error, data)
        found.setdefault(path, []).append(_fact(model, error))
        if is_alternative:
            alternatives.add(path)
    # Where one form fits down to some entries, only these are wrong: the value as a whole need not be another form.
    for path in alternatives:
        if any(other != path and other.startswith(path) for other in alternatives):
            del found[path]
    return [(path, _either(facts) if path in alternatives else "; ".join(facts)) for path, facts in found.items()]


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


def _fact(model: type[BaseModel], error: Any) -> str:
    kind = error["type"]
    if kind == "extra_forbidden":
        near = difflib.get_close_matches(str(error["loc"][-1]), _known_keys(model), n=1, cutoff=0.5)
        return "unknown key" + (f"; did you mean {near[0]}?" if near else "")
    if kind == "missing":
        choices = _choices(model, str(error["loc"][-1]))
        return f"missing; wanted one of {', '.join(map(repr, choices))}" if choices else "missing"
    if kind == "string_pattern_mismatch" and error["ctx"]["pattern"] == IDENTIFIER:
        return f"must be made of letters without accents, digits, _ and - (found {error['input']!r:.60})"
    message = str(error["msg"]).removeprefix("Value error, ").replace("Input should", "must")
    shown = repr(error["input"])
    return message if kind == "value_error" or len(shown) > 60 else f"{message} (found {shown})"


def _either(facts: list[str]) -> str:
    """`must be a valid number or must be a valid list (found 'x')`."""
    messages = [fact.rpartition(" (found ")[0] or fact for fact in facts]
    return " or ".join(messages) + facts[-1].removeprefix(messages[-1])


def _known_keys(model: type[BaseModel]) -> list[str]:
    """All keys of `model` and of the tables nested in it, for suggestions."""
    return [key for key, _ in _fields(model)]


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
            for arg in _models_in(field.annotation):
                visit(arg)

    visit(model)
    return fields


def _models_in(annotation: Any) -> list[type[BaseModel]]:
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return [annotation]
    out: list[type[BaseModel]] = []
    for arg in getattr(annotation, "__args__", ()):
        out += _models_in(arg)
    return out
