"""What pages show: blocks by kind, the commands in them, and the files that they have a reader write."""

from __future__ import annotations

import re
import shlex
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).parents[2]
#: In the words of a page `tedm` may begin a name that is no command.
NO_COMMANDS = {
    "tedm element_area",  # a colour map (how-to/paraview.md)
    "tedm sha256",  # the seal of a file (reference/files.md)
}
_SHELL = ("console", "bash", "sh", "shell")
_PROGRAMS = ("tedm", ".venv/bin/tedm", "pip", "make", "python", "cat", "cd")


@dataclass(frozen=True)
class Block:
    """A block of a page.

    Parameters
    ----------
    page : relative to the repository.
    line : number of the first of its `lines` in the page, from 0.
    indent : what each line begins with in the page, and not here.
    language : of a fenced block what is said there, of an indented one "".
    title : of a fenced block the file that it is, else "".
    """

    page: str
    line: int
    indent: str
    language: str
    title: str
    lines: tuple[str, ...]

    @property
    def text(self) -> str:
        return "\n".join(self.lines) + "\n"

    @property
    def where(self) -> str:
        return f"{self.page}:{self.line + 1}"

    @property
    def kind(self) -> str:
        """`session` (commands behind $ and their output), `commands`, `file`, `change` or `part` of one, or `other`."""
        if self.title:
            is_part = self.language in ("markdown", "text") and "..." in self.lines
            return "change" if self.language == "diff" else "part" if is_part else "file"
        if self.language in ("", *_SHELL) and any(line.startswith("$ ") for line in self.lines):
            return "session"
        first = next(iter(self.lines[0].split()), "")
        if self.language in _SHELL or (not self.language and first in _PROGRAMS):
            return "commands"
        return "other"

    @property
    def is_toml(self) -> bool:
        """Whether it is TOML, by its language or, without one, by a table or keys alone."""
        if self.language or self.kind != "other":
            return self.language == "toml"
        lines = [line for line in self.lines if line.strip()]
        return any(re.match(r"\[\[?[\w.\"]+\]\]?\s*(#|$)", line) for line in lines) or all(
            re.match(r"\w+ = [\[\"{\d]", line) for line in lines
        )


@dataclass(frozen=True)
class Shown:
    """A command of a session, and the lines of the page under it."""

    command: str
    line: int
    expected: tuple[str, ...]


def pages() -> list[str]:
    """All pages that commands and blocks are looked for in."""
    documents = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]
    return [path.relative_to(ROOT).as_posix() for path in documents]


def page_lines(page: str) -> list[str]:
    return (ROOT / page).read_text(encoding="utf-8").splitlines()


def blocks(page: str) -> list[Block]:
    """All fenced and indented blocks of a page, in order."""
    return list(_blocks(page, page_lines(page)))


def _blocks(page: str, lines: list[str]) -> Iterator[Block]:
    i, after_blank = 0, True
    while i < len(lines):
        if fence := re.match(r"(\s*)```([\w-]*)(.*)$", lines[i]):
            end = next(j for j in range(i + 1, len(lines)) if lines[j].strip() == "```")
            title = re.search(r'title="([^"]+)"', fence[3])
            body = tuple(line.removeprefix(fence[1]) for line in lines[i + 1 : end])
            yield Block(page, i + 1, fence[1], fence[2], title[1] if title else "", body)
            i, after_blank = end + 1, False
        elif after_blank and lines[i].startswith("    "):
            end = i
            while end < len(lines) and (lines[end].startswith("    ") or not lines[end].strip()):
                end += 1
            while not lines[end - 1].strip():
                end -= 1
            yield Block(page, i, "    ", "", "", tuple(line[4:] for line in lines[i:end]))
            i, after_blank = end, False
        else:
            after_blank = not lines[i].strip()
            i += 1


def session(block: Block) -> list[Shown]:
    """The commands of a session, each with its output; a command goes on behind a backslash."""
    found: list[Shown] = []
    starts = [i for i, line in enumerate(block.lines) if line.startswith("$ ")]
    assert not starts or starts[0] == 0, f"{block.where}: output without a command"
    for start, end in zip(starts, [*starts[1:], len(block.lines)], strict=True):
        rest = start + 1
        while block.lines[rest - 1].endswith("\\"):
            rest += 1
        command = "\n".join(block.lines[start:rest])[2:]
        found.append(Shown(command, block.line + rest, block.lines[rest:end]))
    return found


def command_lines(page: str) -> Iterator[tuple[str, str, bool]]:
    """(place, command line, whether all of it is there) of every `tedm ...` of a page, in blocks and in its words."""
    rest = page_lines(page)
    for block in blocks(page):
        if block.kind == "session":
            for shown in session(block):
                yield from ((f"{page}:{shown.line}", found, True) for found in _tedm_in(shown.command))
        elif block.kind == "commands":
            joined = block.text.replace("\\\n", " ").splitlines()
            for number, line in enumerate(joined):
                yield from ((f"{page}:{block.line + number + 1}", found, True) for found in _tedm_in(line))
        rest[block.line : block.line + len(block.lines)] = [""] * len(block.lines)
    words = "\n".join(rest)
    for paragraph in re.finditer(r"(?:[^\n]+\n?)+", words):
        place = f"{page}:{words.count(chr(10), 0, paragraph.start()) + 1}"
        for code in re.findall(r"(?<!`)`([^`]+)`(?!`)", paragraph[0].replace("\n", " ")):
            if code.startswith("tedm ") and code not in NO_COMMANDS:
                yield from ((place, found, False) for found in _tedm_in(code))


def _tedm_in(line: str) -> Iterator[str]:
    """The commands of a line of the shell that are `tedm`, without what the shell makes of their output."""
    lexer = shlex.shlex(line, posix=True, punctuation_chars=";|&<>")
    lexer.whitespace_split = True
    words: list[str] = []
    is_target = False
    for token in [*lexer, ";"]:
        if set(token) <= set(";|&"):
            if words and Path(words[0]).name == "tedm":
                yield shlex.join(["tedm", *words[1:]])
            words = []
        elif set(token) <= set("<>"):
            is_target = True
        elif is_target:
            is_target = False
        else:
            words.append(token)


def options_in_words(page: str) -> Iterator[tuple[str, str]]:
    """(place, option) of every long option that a page names without its command."""
    for number, line in enumerate(page_lines(page)):
        for code in re.findall(r"`(--[a-z][^`]*)`", line):
            yield f"{page}:{number + 1}", code.split()[0].split("=")[0]
