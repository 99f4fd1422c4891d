"""The tables of the configuration files as docs/reference/configuration.md, printed by `python -m` of this module."""

from __future__ import annotations

import datetime
import re
import types
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Annotated, Any, Literal, Union, get_args, get_origin

from pydantic import BaseModel
from pydantic.fields import FieldInfo

from tedm_cli.config.balance import BalanceConfig
from tedm_cli.config.base import PATTERNS, Bounded, Form, Strict, models_in
from tedm_cli.config.cases import CasesConfig
from tedm_cli.config.dynamics.controller_file import ControllerFile
from tedm_cli.config.dynamics.loop import DynamicsConfig
from tedm_cli.config.imported import LawTable, SensitivityTable
from tedm_cli.config.loads import LoadsConfig
from tedm_cli.config.model.file import ModelConfig
from tedm_cli.config.optics.tables import OpticsTables
from tedm_cli.config.project import ProjectTable
from tedm_cli.config.thermal.file import ThermalConfig
from tedm_cli.config.trade import TradeConfig

_PREFACE = """\
# Configuration

A project is a folder of TOML files ([projects](../how-to/project.md)). This page has all of their keys. The shipped
files have comments: [tedm.toml](../../configs/tedm.toml), [model.toml](../../configs/model.toml),
[optics.toml](../../configs/optics.toml), [cases.toml](../../configs/cases.toml),
[dynamics.toml](../../configs/dynamics.toml), [balance.toml](../../configs/balance.toml).

Unknown keys are errors, and so are numbers outside the bounds, which a slip of unit or exponent makes. All problems of
a file are reported at once. Units are in the names of the keys. The basic frame is that of the Nastran deck. A table in
double brackets may be there several times. Where the default is "-", there is none: the last column says what holds
when the key is left out.
"""
_ORIGIN = (
    "<!-- Printed from `tedm_cli/config/` by"
    " `python -m tedm_cli.config.reference > docs/reference/configuration.md`. -->"
)


@dataclass(frozen=True)
class File:
    """A file of the configuration: its name, what its root holds, and the name of that table where it has one."""

    name: str
    table: type[Strict]
    root: str = ""


FILES = (
    File("tedm.toml", ProjectTable),
    File("model.toml", ModelConfig),
    File("optics.toml", OpticsTables),
    File("cases.toml", CasesConfig),
    File("dynamics.toml", DynamicsConfig),
    File("thermal.toml", ThermalConfig),
    File("loads.toml", LoadsConfig),
    File("balance.toml", BalanceConfig),
    File("variants.toml, of a trade", TradeConfig),
    File("S_BW.csv.toml, beside an imported S_BW", SensitivityTable, "S_BW"),
    File("P.csv.toml, beside an imported P", LawTable, "P"),
    File("controller.toml, a controller of your own", ControllerFile),
)

_PLAIN = {bool: "true or false", int: "whole number", float: "number", str: "text", datetime.date: "date"}


def tables(root: type[BaseModel]) -> list[type[BaseModel]]:
    """A table and all that are in it, each once."""
    found = {root: None}
    for table in (todo := [root]):
        for field in table.model_fields.values():
            new = [inner for inner in models_in(field.annotation) if inner not in found]
            found |= dict.fromkeys(new)
            todo += new
    return list(found)


def document() -> str:
    """The text of docs/reference/configuration.md."""
    lines, anchors, headings = _PREFACE.splitlines(), dict[type[BaseModel], str](), set[str]()
    for file in FILES:
        lines += ["", f"## {file.name}"]
        sections = _sections(file, anchors, headings)
        headings |= {path for path, _ in sections}
        for path, table in sections:
            lines += ["", f"### {path}"] if path else []
            lines += ["", *_text(table), "", "| key | type | bounds | default | meaning |", "|---|---|---|---|---|"]
            lines += [_row(key, field, anchors) for key, field in _fields(table)]
    return "\n".join([*lines, "", _ORIGIN]) + "\n"


def _fields(table: type[BaseModel]) -> list[tuple[str, FieldInfo]]:
    """Keys and what is said of them, those first that are needed."""
    fields = [(field.alias or name, field) for name, field in table.model_fields.items()]
    return sorted(fields, key=lambda of: not of[1].is_required())


def _sections(file: File, anchors: dict[type[BaseModel], str], taken: set[str]) -> list[tuple[str, type[BaseModel]]]:
    """Headings and tables of a file, those within a table behind it; what another file has already is left there.

    Another table under a heading that is `taken` says of which file it is.
    """
    root: type[BaseModel] = file.table
    found = [(file.root, f"`[{file.root}]`" if file.root else "", root)]
    for path, _, table in found:
        within = []
        for key, field in _fields(table):
            for inner in models_in(field.annotation):
                if inner not in anchors:
                    place = f"{path}.{key}".removeprefix(".")
                    heading = f"`[[{place}]]`" if _is_array(field) else f"`[{place}]`"
                    heading += f" of {file.name}" if heading in taken else ""
                    anchors[inner] = "".join(c for c in heading.lower().replace(" ", "-") if c.isalnum() or c in "_-")
                    within.append((place, heading, inner))
        at = found.index((path, _, table)) + 1
        found[at:at] = within
    return [(heading, table) for _, heading, table in found]


def _anchor(heading: str) -> str:
    """What links to a heading end with."""
    return "".join(c for c in heading.lower().replace(" ", "-") if c.isalnum() or c in "_-")


def _is_array(field: FieldInfo) -> bool:
    """Whether a key holds several tables, and never one by itself."""
    return not any(isinstance(kind, type) for kind in (field.annotation, *_alternatives(field.annotation)))


def _alternatives(annotation: Any) -> list[Any]:
    """The types of a union but None; any other type by itself."""
    if get_origin(annotation) in (Union, types.UnionType):
        return [kind for kind in get_args(annotation) if kind is not type(None)]
    return [annotation]


def _text(table: type[BaseModel]) -> list[str]:
    """What a table is, in the words of its class."""
    return [line.strip() for line in (table.__doc__ or "").strip().splitlines()]


def _row(key: str, field: FieldInfo, anchors: dict[type[BaseModel], str]) -> str:
    whole = Annotated[field.annotation, *field.metadata] if field.metadata else field.annotation
    kind, inner = _kind(whole), models_in(field.annotation)
    if inner:
        kind = f"[{kind}](#{anchors[inner[0]]})"
    bounds = "; ".join(dict.fromkeys(_bounds(whole)))
    cells = (f"`{key}`", kind, bounds, _default(field), field.description or "")
    return "| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |"


def _default(field: FieldInfo) -> str:
    if field.is_required():
        return "needed"
    value = field.get_default(call_default_factory=True, validated_data={})
    return "-" if value is None or value in ([], {}) or models_in(field.annotation) else f"`{_toml(value)}`"


def _toml(value: Any) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, list):
        return f"[{', '.join(map(_toml, value))}]"
    return f'"{value}"' if isinstance(value, str) else _short(repr(value))


def _kind(annotation: Any) -> str:
    """What values of a type look like."""
    said, inner = _said(annotation)
    if forms := [part.words for part in said if isinstance(part, Form)]:
        return forms[-1]
    if len(alternatives := _alternatives(inner)) > 1:
        return ", or ".join(map(_kind, alternatives))
    (inner,) = alternatives
    origin, arguments = get_origin(inner), get_args(inner)
    if origin is Annotated or (inner is not annotation and said == []):
        return _kind(inner)
    if origin is Literal:
        return ", ".join(f"`{_toml(value)}`" for value in arguments)
    if origin is dict:
        each = _kind(arguments[1])
        return f"table of {each if each[0].isdigit() else _several(each)} by name"
    if origin is list:
        if models_in(inner):
            return "tables"
        several = _several(_kind(arguments[0]))
        low, high = (next((getattr(p, n) for p in said if hasattr(p, n)), None) for n in ("min_length", "max_length"))
        return f"{low} {several}" if low and low == high else f"list of {several}"
    return "table" if issubclass(inner, BaseModel) else _PLAIN[inner]


def _several(words: str) -> str:
    """The plural of what `_kind` says: a list of 3 lists of 3 numbers is 3 × 3 numbers."""
    if words[0].isdigit():
        return f"× {words}"
    return f"lists of {words.removeprefix('list of ')}" if words.startswith("list of") else _plural(words)


def _plural(words: str) -> str:
    return words if "`" in words or " or " in words or "in one line" in words else f"{words}s"


def _said(annotation: Any) -> tuple[list[Any], Any]:
    """What is said of a type, and the type."""
    if get_origin(annotation) is not Annotated:
        return [], annotation
    inner, *said = get_args(annotation)
    return [part for each in said for part in (each.metadata if isinstance(each, FieldInfo) else [each])], inner


def _bounds(annotation: Any) -> Iterator[str]:
    """What numbers and texts in a type must keep, however deep they are."""
    said, inner = _said(annotation)
    for part in said:
        if isinstance(part, Bounded):
            yield _range(part)
        elif pattern := getattr(part, "pattern", None):
            yield PATTERNS[pattern]
        elif isinstance(inner, type) and inner is str and getattr(part, "max_length", None):
            yield f"at most {part.max_length} characters"
    for argument in get_args(inner) if get_origin(inner) is not Literal else ():
        yield from _bounds(argument)


def _range(bounded: Bounded) -> str:
    quantity = bounded.quantity
    words, least = quantity.range, quantity.least
    if least and quantity.low == 0.0:
        words = f"0, or {least:g}{words.removeprefix('0')}"
    elif least:
        words += f", 0 or at least {least:g} in size"
    return _short(words) + (", or infinite" if bounded.or_infinite else "")


def _short(words: str) -> str:
    """Exponents without what they need not have: 1e-9, 1e6."""
    return re.sub(r"e([+-])0*", lambda sign: "e" + sign[1].removeprefix("+"), words)


if __name__ == "__main__":
    print(document(), end="")
