"""Which entry of a configuration file a problem is of: its name and its line, for paths count from zero."""

from __future__ import annotations

import contextlib
import re
import tomllib
from pathlib import Path
from typing import Any

from tedm_cli.errors import ConfigError

_PART = re.compile(r"\[(\d+)\]|([^.\[\]]+)")
_NAMES = ("name", "id")


def placed_lines(exc: ConfigError) -> list[str]:
    """Its problems, each with the name and the line of the entry that it is of, where the file tells them."""
    lines = exc.fact.split("\n")
    paths = sorted({path for path, _ in exc.problems if "[" in path}, key=len, reverse=True)
    if not paths:
        return lines
    text, data = "", dict[str, Any]()
    with contextlib.suppress(OSError, ValueError, RecursionError):
        text = Path(exc.where).read_text(encoding="utf-8-sig")
        data = tomllib.loads(text)
    return [line + _entry(text, data, _path_of(line, paths), line) for line in lines]


def _path_of(line: str, paths: list[str]) -> str:
    """The path that a line begins with, "" for none."""
    return next((path for path in paths if line.startswith(f"{path}: ")), "")


def _entry(text: str, data: Any, path: str, line: str) -> str:
    """` (STRUT_2, line 12)` of the innermost table of an array that has a name; "" where there is none."""
    here, found = data, ("", "")
    for index, key in _PART.findall(path):
        if index and isinstance(here, list) and int(index) < len(here):
            here = here[int(index)]
            if isinstance(here, dict):
                found = next(((k, here[k]) for k in _NAMES if isinstance(here.get(k), str)), found)
        elif isinstance(here, dict) and key in here:
            here = here[key]
        else:
            break
    key, name = found
    if not name:
        return ""
    written = re.compile(rf"""(?<![\w-]){key}\s*=\s*(["']){re.escape(name)}\1""")
    at = [number for number, row in enumerate(text.splitlines(), start=1) if written.search(row)]
    words = [] if re.search(rf"(?<!\w){re.escape(name)}(?!\w)", line) else [name]
    words += [f"line {at[0]}"] if len(at) == 1 else []
    return f" ({', '.join(words)})" if words else ""
