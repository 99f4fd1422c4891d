"""Strict TOML: unknown keys are errors, and every problem of a file is reported at once with its dotted path."""

from __future__ import annotations

import difflib
import hashlib
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any, TypeVar

from pydantic import BaseModel, ConfigDict, ValidationError

from tedm_cli.errors import ConfigError, InputError
from tedm_cli.provenance import ConfigFile


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
    return ConfigFile(path, text, hashlib.sha256(raw).hexdigest()), data


def load(model: type[T], path: Path) -> tuple[ConfigFile, T]:
    """Read `path` and check it against `model`; raise one `ConfigError` that lists all problems."""
    file, data = read_toml(path)
    return file, validate(model, data, where=str(path))


def validate(model: type[T], data: Mapping[str, Any], *, where: str) -> T:
    """Check `data` against `model`, translating pydantic's report into dotted paths and near-miss suggestions."""
    try:
        return model.model_validate(data)
    except ValidationError as exc:
        problems = [(_dotted(e["loc"]), _fact(model, e)) for e in exc.errors()]
        raise ConfigError(problems, where=where) from exc


def _dotted(loc: tuple[int | str, ...]) -> str:
    out = ""
    for part in loc:
        if isinstance(part, int):
            out += f"[{part}]"
        else:
            out += f".{part}" if out else part
    return out


def _fact(model: type[BaseModel], error: Any) -> str:
    kind = error["type"]
    if kind == "extra_forbidden":
        near = difflib.get_close_matches(str(error["loc"][-1]), _known_keys(model), n=1, cutoff=0.5)
        return "unknown key" + (f"; did you mean {near[0]}?" if near else "")
    if kind == "missing":
        return "missing"
    message = str(error["msg"]).removeprefix("Value error, ")
    shown = repr(error["input"])
    return message if kind == "value_error" or len(shown) > 60 else f"{message} (found {shown})"


def _known_keys(model: type[BaseModel]) -> list[str]:
    """All keys of `model` and of the tables nested in it, for suggestions."""
    seen: dict[type[BaseModel], None] = {}
    keys: list[str] = []

    def visit(m: type[BaseModel]) -> None:
        if m in seen:
            return
        seen[m] = None
        for name, field in m.model_fields.items():
            keys.append(field.alias or name)
            for arg in _models_in(field.annotation):
                visit(arg)

    visit(model)
    return keys


def _models_in(annotation: Any) -> list[type[BaseModel]]:
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return [annotation]
    out: list[type[BaseModel]] = []
    for arg in getattr(annotation, "__args__", ()):
        out += _models_in(arg)
    return out
