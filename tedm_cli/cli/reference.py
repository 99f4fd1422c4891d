"""The commands as docs/reference/commands.md, printed by `python -m` of this module."""

from __future__ import annotations

import re
from collections import Counter
from typing import Any

import typer

from tedm_cli.cli.commands import command_line
from tedm_cli.cli.headings import HEADINGS, first_sentence, paragraphs_of
from tedm_cli.errors import ConfigError, InputError, PhysicsError, UsageError

_PREFACE = """\
# Commands

`tedm --help` lists the commands; `tedm COMMAND --help` prints the part of this page about that command.

Results go to standard output, progress and errors to standard error. Files that a command has finished are kept
whatever happens after; an unfinished one is removed.
"""

_ORIGIN = "<!-- Printed from `tedm_cli/cli/` by `python -m tedm_cli.cli.reference > docs/reference/commands.md`. -->"

_CODES = (
    (0, "fine; a violated requirement is a result, not an error, unless `--fail-on-violation` is given"),
    (1, "a fault inside the program: run again with `-vv` and report the traceback"),
    (UsageError.exit_code, "usage: an option, a case, an output or a kind of file that does not exist"),
    (ConfigError.exit_code, "configuration: all problems of a file are listed, each with its key"),
    (
        InputError.exit_code,
        "input: a file that is missing, damaged or stale; output that cannot be written",
    ),
    (PhysicsError.exit_code, "a physical check failed; with `--fail-on-violation` also a requirement"),
    (130, "interrupted by Ctrl-C"),
    (143, "ended by SIGTERM"),
)
_SHARED = 20  # an option that so many commands have is told once


def document() -> str:
    """The text of docs/reference/commands.md."""
    program = command_line()
    root = typer.Context(program, info_name="tedm", **program.context_settings)  # -h, which commands keep once known
    commands = {name: program.commands[name] for name in program.list_commands(root)}
    commands = {name: command for name, command in commands.items() if not command.hidden}
    contexts = {name: typer.Context(command, info_name=name, parent=root) for name, command in commands.items()}
    records = {name: [_record(p, contexts[name]) for p in command.params] for name, command in commands.items()}
    often = Counter(record for rows in records.values() for record in rows)
    shared = [record for record, times in often.items() if times >= _SHARED]
    lines = [*_PREFACE.splitlines()]
    for heading, names in HEADINGS.items():
        lines += ["", f"| {heading} | what it does |", "|---|---|"]
        lines += [f"| [`{name}`](#tedm-{name}) | {first_sentence(commands[name])} |" for name in names]
    lines += [
        "",
        "## Exit codes",
        "",
        "| code | meaning |",
        "|---|---|",
        *(f"| {c} | {words} |" for c, words in _CODES),
    ]
    lines += ["", "## Options of most commands", "", *_table("option", shared)]
    for name, command in commands.items():
        text = [line for paragraph in paragraphs_of(command) for line in ("", paragraph)]
        lines += ["", f"## tedm {name}", "", f"    {_synopsis(command, contexts[name])}", *text]
        own = [record for record in records[name] if record not in shared]
        for title, is_option in (("argument", False), ("option", True)):
            if part := [record for record in own if record[0].startswith("-") == is_option]:
                lines += ["", *_table(title, part)]
        if command.epilog:
            heading, *typed = command.epilog.removeprefix("\b\n").split("\n")
            lines += ["", heading, "", *(f"    {line.strip()}" for line in typed)]
        if general := [f"`{record[0].split(',')[0]}`" for record in records[name] if record in shared]:
            lines += ["", f"And [options of most commands](#options-of-most-commands): {', '.join(general)}."]
    return "\n".join([*lines, "", _ORIGIN]) + "\n"


def _synopsis(command: Any, context: Any) -> str:
    usage = " ".join(command.get_usage(context).split())
    return usage.removeprefix("Usage: ")


def _record(parameter: Any, context: Any) -> tuple[str, str, str]:
    """Names, meaning and default of an argument or option, as its help has them; | would end a cell of a table."""
    names, text = (words.replace("|", ", ") for words in parameter.get_help_record(context))
    found = re.fullmatch(r"(.*?)\s*(?:\[(?:default: )?([^\[\]]*)\])?", text, re.DOTALL)
    meaning, default = (found[1], found[2] or "") if found else (text, "")
    return names, meaning, default.replace("required", "needed").replace("x>=", "at least ")


def _table(title: str, records: list[tuple[str, str, str]]) -> list[str]:
    rows = [f"| `{names}` | {meaning} | {default} |" for names, meaning, default in records]
    return [f"| {title} | meaning | default |", "|---|---|---|", *rows]


if __name__ == "__main__":
    print(document(), end="")
