"""The list of commands in `tedm --help`: under headings, in the order in which a project needs them."""

from __future__ import annotations

from typing import Any

from typer.core import TyperGroup

#: Every command stands under one of these, which a test asks for.
HEADINGS = {
    "Begin": ("init", "run", "check"),
    "Model": ("areas", "write-deck", "solve", "ingest", "build-distortion", "reduce"),
    "Gravity": ("build-sensitivity", "merge", "balance", "audit-mesh", "self-gravity", "accuracy"),
    "Optics": ("check-layout", "build-optics"),
    "Temperatures of grids": ("build-adjoint", "suggest-areas"),
    "Other loads": ("build-loads",),
    "Thermal model": ("build-thermal", "map-temperatures", "simulate-thermal"),
    "Correlation cases and time series": ("run-case", "run-series"),
    "Drag-free loop": ("build-dynamics", "simulate"),
    "Variants of a design": ("trade",),
    "Results": ("explain", "show", "plot", "report", "view"),
    "Exports": ("export", "export-case", "export-state-space", "export-extremal", "export-vtu"),
}


def examples(*lines: str) -> str:
    """Lines that end the help of a command, as they are typed."""
    return "\n".join(["\b", "Examples:" if len(lines) > 1 else "Example:", *(f"  {line}" for line in lines)])


class Headed(TyperGroup):
    """The commands under headings; what each is for stands there in full, in one column."""

    def list_commands(self, ctx: Any) -> list[str]:
        headed = [name for names in HEADINGS.values() for name in names if name in self.commands]
        return [*headed, *(name for name in self.commands if name not in headed)]

    def format_commands(self, ctx: Any, formatter: Any) -> None:
        names = [name for name in self.list_commands(ctx) if not self.commands[name].hidden]
        column = max(map(len, names))
        listed = {heading: [name for name in each if name in names] for heading, each in HEADINGS.items()}
        listed["Others"] = [name for name in names if not any(name in each for each in HEADINGS.values())]
        for heading, each in listed.items():
            if each:
                with formatter.section(heading):
                    formatter.write_dl([(name.ljust(column), first_sentence(self.commands[name])) for name in each])


def first_sentence(command: Any) -> str:
    """The first paragraph of a command's help."""
    return paragraphs_of(command)[0]


def paragraphs_of(command: Any) -> list[str]:
    """What a command says of itself, a line for each paragraph; the sign \\b keeps the lines of one in a terminal."""
    return [" ".join(paragraph.replace("\b", "").split()) for paragraph in command.help.split("\n\n")]
