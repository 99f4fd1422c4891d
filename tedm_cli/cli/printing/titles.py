"""What the labels of a table of verdicts stand for, in plain words."""

from __future__ import annotations

from collections.abc import Iterable

from tedm_cli.results.titles import outputs_title, requirement_title


def legend_lines(judged: Iterable[tuple[str, str]]) -> list[str]:
    """A line for each requirement of (output, requirement) pairs: its title, and what it judges."""
    outputs: dict[str, list[str]] = {}
    for output, requirement in judged:
        outputs.setdefault(requirement, []).append(output)
    lines = []
    for name, own in outputs.items():
        title = requirement_title(name, {})
        lines.append(f"{name}: {f'{title}; ' if title != name else ''}on {outputs_title(own)}")
    return lines
