"""Where a report comes from: configurations, inputs, commands and versions of all its files."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from importlib.metadata import version

from tedm_cli.errors import InputError
from tedm_cli.files.provenance import relative_name
from tedm_cli.files.store import Reader
from tedm_cli.report.document import (
    Block,
    Cell,
    Facts,
    Figure,
    Folded,
    Heading,
    Listing,
    Paragraph,
    Section,
    Table,
    columns,
    row,
)


@dataclass(frozen=True)
class ReportFile:
    """A result file: open, with the SHA-256 of what it holds."""

    reader: Reader
    sha256: str


def provenance_section(files: Sequence[ReportFile], figures: Sequence[Figure]) -> Section:
    """Each configuration, input and version once; names are as seen from the folder of the results.

    Raises
    ------
    InputError : files stem from different versions of one configuration.
    """
    configs: dict[str, tuple[str, str]] = {}
    inputs: dict[str, str] = {}
    commands: list[tuple[str, str]] = []
    versions: dict[str, str] = {}
    for file in files:
        reader = file.reader
        folder = reader.path.parent
        provenance = reader.provenance()
        for config in provenance.configs:
            name = relative_name(config.path, folder)
            if configs.setdefault(name, (config.sha256, config.text))[0] != config.sha256:
                raise InputError(
                    f"and files before it were made from different versions of {config.path}",
                    where=str(reader.path),
                    hint="rebuild them; see tedm check",
                )
        inputs.update((relative_name(i.path, folder), i.sha256) for i in provenance.inputs)
        inputs[reader.path.name] = file.sha256
        commands.append((reader.path.name, provenance.command))
        for key, value in reader.attributes.items():
            if key.endswith("_version") and key != "schema_version":
                name = key.removesuffix("_version")
                found = versions.setdefault(name, str(value))
                versions[name] = found if str(value) in found.split(" and ") else f"{found} and {value}"
    versions["jinja2"] = version("jinja2")
    versions["typst"] = version("typst")
    drawn = {m[1] for f in figures for m in re.finditer(r"<dc:title>tedm \S+, matplotlib (\S+?)</dc:title>", f.svg)}
    versions["matplotlib"] = " and ".join(sorted(drawn))
    blocks: list[Block] = [
        Paragraph("File names are relative to the folder of the results."),
        Facts(tuple(sorted(versions.items(), key=lambda v: v[0].lower()))),
        _table("What made each file.", "Made by", commands),
        _table("Every file and its SHA-256.", "SHA-256", sorted(inputs.items())),
        Heading("Configurations"),
    ]
    for name, (sha, text) in sorted(configs.items()):
        blocks.append(Folded(name, (Paragraph(f"SHA-256 {sha}", quiet=True), Listing(text))))
    return Section("provenance", "Provenance", "Provenance", tuple(blocks))


def _table(caption: str, title: str, pairs: Sequence[tuple[str, str]]) -> Table:
    rows = tuple(row(name, Cell(value, long=True)) for name, value in pairs)
    return Table(columns("File", title, text=(0, 1)), rows, caption)
