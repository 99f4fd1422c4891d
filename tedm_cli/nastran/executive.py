"""Executive control: the solution that a deck asks for."""

from __future__ import annotations

from collections.abc import Sequence

from tedm_cli.nastran.deck_lines import Line

STATICS = {"101", "1", "24", "STATIC", "STATICS", "SESTATIC", "SESTATICS"}
HEAT = {"153", "159", "NLSCSH", "NLTCSH"}


def words_of(line: Line) -> list[str]:
    """Words of an executive line, in capitals; `=` and `,` part them."""
    return line.code.upper().replace("=", " ").replace(",", " ").split()


def solution(lines: Sequence[Line]) -> str:
    """What the last SOL line names, in capitals; empty without one."""
    found = [words[1] if len(words) > 1 else "" for words in map(words_of, lines) if words[:1] == ["SOL"]]
    return found[-1] if found else ""
