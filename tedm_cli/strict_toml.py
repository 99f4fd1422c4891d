"""TOML as text to tables, for whoever reads it: configuration files, and what files of matrices declare."""

from __future__ import annotations

import tomllib
from collections.abc import Iterator
from typing import Any

from tedm_cli.control_characters import control_fact
from tedm_cli.errors import ConfigError

_LAYOUT = "\t\n"  # of the control characters these alone may stand in a text of several lines


def parsed_toml(text: str, *, where: str, at: str = "") -> dict[str, Any]:
    """The tables of a TOML text; `at` is the dotted path of the text itself, where it stands inside something.

    Raises
    ------
    ConfigError : not TOML, or with control characters in a key or a string, which no title, label or path has; all of
        these at once.
    """
    try:
        data = tomllib.loads(text)
    except RecursionError:
        raise ConfigError([(at, "not valid TOML: nested too deeply")], where=where) from None
    except ValueError as exc:  # TOMLDecodeError, and integers of thousands of digits
        raise ConfigError([(at, f"not valid TOML: {exc}")], where=where) from None
    problems = list(_control_characters(data, at))
    if problems:
        raise ConfigError(problems, where=where, hint="delete the character")
    return data


def _control_characters(value: Any, at: str) -> Iterator[tuple[str, str]]:
    if isinstance(value, dict):
        for key, inner in value.items():
            place = f"{at}.{key}" if at else key
            if fact := control_fact(key):
                yield place, f"the key {fact}"
            yield from _control_characters(inner, place)
    elif isinstance(value, list):
        for number, inner in enumerate(value):
            yield from _control_characters(inner, f"{at}[{number}]")
    elif isinstance(value, str) and (fact := control_fact(value, _LAYOUT)):
        yield at, fact
