"""A project with some keys of another value: configuration files of its own, which lead to the same files elsewhere."""

from __future__ import annotations

import copy
import difflib
import os
import types
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Union, get_args, get_origin

from pydantic import BaseModel

from tedm_cli.config.balance import BalanceConfig
from tedm_cli.config.base import Form, Strict, models_in, read_toml, validate
from tedm_cli.config.cases import CasesConfig
from tedm_cli.config.dynamics.loop import DynamicsConfig
from tedm_cli.config.loads import LoadsConfig
from tedm_cli.config.model.file import ModelConfig
from tedm_cli.config.optics.tables import OpticsTables
from tedm_cli.config.project import Project, ProjectTable
from tedm_cli.config.thermal.file import ThermalConfig
from tedm_cli.errors import ConfigError, printable

#: The files of a project, by the first part of the keys that change them; the project file itself is `PROJECT`.
FILES: dict[str, type[Strict]] = {
    "model": ModelConfig,
    "optics": OpticsTables,
    "cases": CasesConfig,
    "dynamics": DynamicsConfig,
    "thermal": ThermalConfig,
    "balance": BalanceConfig,
    "loads": LoadsConfig,
}
PROJECT = "project"
_NAMES = ("name", "id")  # of entries in arrays of tables
_MARK = "# Made by tedm from {}, with other values of {}. Changes here are lost.\n"


@dataclass(frozen=True)
class Overlay:
    """Texts of the configuration files of a changed project, by their names; the project file is `tedm.toml`."""

    texts: Mapping[str, str]


def overlay(base: Project, values: Mapping[str, Any], folder: Path) -> Overlay:
    """The files of the project `base` with other `values`, to be written into `folder`.

    What is not changed stays where it is, and names of files lead from `folder` to where they led before.

    Raises
    ------
    ConfigError : a key that the file cannot have, or a value that it cannot have; `where` is empty, and the paths of
        the problems are the keys. What is wrong with the file as it is has the file in `where`.
    """
    by_file, problems = _by_file(values)
    named = {key[0] for key in by_file.get(PROJECT, {})}
    problems += [
        (f"{PROJECT}.{name}", f"keys of the {name} file are changed, too") for name in by_file if name in named
    ]
    paths = {name: getattr(base, name) for name in FILES}
    texts: dict[str, str] = {}
    changed: dict[str, str] = {}
    project = read_toml(base.file.path)[1]
    for name, keys in by_file.items():
        table = ProjectTable if name == PROJECT else FILES[name]
        path = base.file.path if name == PROJECT else paths[name]
        if path is None and name == "dynamics":
            data: dict[str, Any] = {}
        elif path is None:
            problems.append((name, f"the project has no {name}"))
            continue
        else:
            _, data = read_toml(path)
            validate(table, data, where=str(path))
        new, found = _with_values(name, data, keys)
        problems += found or _misfits(name, table, new)
        if name == PROJECT:
            project = new
        elif not problems:
            old = base.file.path if path is None else path
            changed[name] = f"{name}.toml"
            texts[changed[name]] = _text(old, keys, _rebased(table, new, _leading(old.parent, folder)))
    if problems:
        raise ConfigError(problems, where="")
    to = _leading(base.file.path.parent, folder)
    for name in FILES:
        if name in changed:
            project[name] = changed[name]
        elif name in named:
            project[name] = to(project[name])
        elif paths[name] is not None:
            project[name] = _path_from(paths[name], folder)
    texts["tedm.toml"] = _text(base.file.path, by_file.get(PROJECT, {}), project)
    return Overlay(texts)


Key = tuple[str, ...]


def _by_file(values: Mapping[str, Any]) -> tuple[dict[str, dict[Key, Any]], list[tuple[str, str]]]:
    """The values by file, with their keys in parts; and what is wrong with the first parts."""
    found: dict[str, dict[Key, Any]] = {}
    problems = []
    for name, value in _flat(values):
        first, *rest = name
        if first not in (*FILES, PROJECT) or not rest or not all(rest):
            near = difflib.get_close_matches(first, [*FILES, PROJECT], n=1)
            hint = f"did you mean {near[0]}?" if near and near[0] != first else f"one of {', '.join((*FILES, PROJECT))}"
            fact = (
                f"begins with no file of a project; {hint}" if first not in (*FILES, PROJECT) else "names no key of it"
            )
            problems.append((".".join(name), fact))
            continue
        found.setdefault(first, {})[tuple(rest)] = value
    return found, problems


def _flat(values: Mapping[str, Any], before: Key = ()) -> list[tuple[Key, Any]]:
    """Keys in parts with their values: `"a.b" = 1` and `a = { b = 1 }` are the same."""
    found: list[tuple[Key, Any]] = []
    for name, value in values.items():
        key = (*before, *name.split("."))
        found += _flat(value, key) if isinstance(value, Mapping) and value else [(key, value)]
    return found


def _with_values(
    file: str, data: Mapping[str, Any], values: Mapping[Key, Any]
) -> tuple[dict[str, Any], list[tuple[str, str]]]:
    """The tables of a file with other values, and the keys that lead nowhere."""
    new, problems = copy.deepcopy(dict(data)), []
    for key, value in values.items():
        here: Any = new
        for depth, part in enumerate(key):
            last = depth == len(key) - 1
            if isinstance(here, list):
                names = [_name_of(entry) for entry in here]
                if part not in names:
                    place = ".".join(key[:depth])
                    problems.append((".".join((file, *key)), _no_entry(place, part, names)))
                    break
                if last:
                    here[names.index(part)] = value
                here = here[names.index(part)]
            elif isinstance(here, dict):
                if last:
                    here[part] = value
                here = here.setdefault(part, {})
            else:
                problems.append((".".join((file, *key)), f"{'.'.join(key[:depth])} is no table"))
                break
    return new, problems


def _misfits(file: str, table: type[Strict], data: Mapping[str, Any]) -> list[tuple[str, str]]:
    """What is wrong with tables that have been changed, by key."""
    try:
        validate(table, data, where="")
    except ConfigError as exc:
        return [(f"{file}.{key}".removesuffix("."), fact) for key, fact in exc.problems]
    return []


def _name_of(entry: Any) -> str:
    found = [entry[key] for key in _NAMES if isinstance(entry, dict) and isinstance(entry.get(key), str)]
    return found[0] if found else ""


def _no_entry(place: str, part: str, names: list[str]) -> str:
    known = [name for name in names if name]
    near = difflib.get_close_matches(part, known, n=1)
    hint = f"did you mean {near[0]}?" if near else f"there are {', '.join(known) or 'none with a name'}"
    return f"{place} has no entry {part!r}; {hint}"


def _leading(old: Path, new: Path) -> Callable[[str], str]:
    """What makes a name that is relative to the folder `old` one that is relative to `new`, and leads to the same."""

    def lead(name: str) -> str:
        return name if "{build_dir}" in name else _path_from(old / name, new)

    return lead


def _path_from(path: Path, folder: Path) -> str:
    return Path(os.path.relpath(path.resolve(), folder.resolve())).as_posix()


def _rebased(table: type[BaseModel], data: Mapping[str, Any], lead: Callable[[str], str]) -> dict[str, Any]:
    """The same tables with all names of files changed."""
    of_key = {(field.alias or name): field for name, field in table.model_fields.items()}
    return {
        key: _value(Annotated[of_key[key].annotation, *of_key[key].metadata, None], value, lead)
        for key, value in data.items()
    }


def _value(kind: Any, value: Any, lead: Callable[[str], str]) -> Any:
    """A value of a type, with the names of files in it changed."""
    if get_origin(kind) is Annotated:
        inner, *said = get_args(kind)
        is_name = any(isinstance(part, Form) and part.words == "file name" for part in said)
        return lead(value) if is_name and isinstance(value, str) else _value(inner, value, lead)
    if get_origin(kind) in (Union, types.UnionType):
        return _value_of_either(get_args(kind), value, lead)
    if isinstance(value, list) and get_origin(kind) is list:
        return [_value(get_args(kind)[0], item, lead) for item in value]
    if isinstance(value, dict) and get_origin(kind) is dict:
        return {key: _value(get_args(kind)[1], item, lead) for key, item in value.items()}
    if isinstance(value, dict) and isinstance(kind, type) and issubclass(kind, BaseModel):
        return _rebased(kind, value, lead)
    return value


def _value_of_either(kinds: tuple[Any, ...], value: Any, lead: Callable[[str], str]) -> Any:
    """A value of one of several types: the first that changes it, of those tables that have its keys."""
    for kind in kinds:
        tables = models_in(kind) if isinstance(value, dict) else []
        if tables and not any(set(value) <= _keys(table) for table in tables):
            continue
        if (new := _value(kind, value, lead)) != value:
            return new
    return value


def _keys(table: type[BaseModel]) -> set[str]:
    return {field.alias or name for name, field in table.model_fields.items()}


def _text(path: Path, keys: Mapping[Key, Any], data: Mapping[str, Any]) -> str:
    import tomli_w

    names = ", ".join(".".join(key) for key in keys) or "the files that it names"
    return _MARK.format(printable(path.name).replace("\n", "?"), names) + tomli_w.dumps(data)
