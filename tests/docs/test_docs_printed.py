"""Pages that are printed from the code, and what they are printed from: every key and command says what it is."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
import tedm
from pydantic import BaseModel

from tedm_cli.cli import reference as commands
from tedm_cli.cli.commands import command_line
from tedm_cli.config import reference as configuration
from tedm_cli.config.base import Strict
from tedm_cli.config.reference import FILES, tables

REFERENCE = Path(__file__).parents[2] / "docs" / "reference"
TABLES = list(dict.fromkeys(table for file in FILES for table in tables(file.table)))


@pytest.mark.parametrize(
    ("page", "module", "text"),
    [
        ("commands.md", "tedm_cli.cli.reference", commands.document),
        ("configuration.md", "tedm_cli.config.reference", configuration.document),
    ],
)
def test_printed_pages_are_what_the_code_says(page: str, module: str, text: object) -> None:
    assert callable(text)
    assert (REFERENCE / page).read_text(encoding="utf-8") == text(), f"run python -m {module} > docs/reference/{page}"


def test_every_key_says_what_it_means() -> None:
    keys = [(f"{table.__name__}.{key}", field) for table in TABLES for key, field in table.model_fields.items()]
    assert len(keys) > 230
    for name, field in keys:
        said = field.description
        assert said, f"{name}: give it Field(description=...)"
        assert said.endswith("."), name
        assert len(said.split()) >= 2, name
        assert said == " ".join(said.split()), name


def test_no_table_of_the_configuration_is_left_out() -> None:
    """But those of the problem in JSON, which is no configuration, and those that others are made of."""

    def below(base: type[BaseModel]) -> list[type[BaseModel]]:
        return [t for c in base.__subclasses__() if c.__module__.startswith("tedm_cli.") for t in (c, *below(c))]

    left = {t for t in below(Strict) if t not in TABLES and not any(issubclass(other, t) for other in TABLES)}
    assert {t.__module__ for t in left} <= {"tedm_cli.config.dynamics.problem"}


def test_every_key_stands_under_the_heading_of_its_table() -> None:
    page = configuration.document()
    found = re.findall(r"(?ms)^#{2,3} ([^\n]+)\n(.*?)(?=^#|\Z)", page)
    sections = {heading.replace("`", ""): text for heading, text in found}
    assert len(re.findall(r"(?m)^#{2,3} ", page)) == len(sections)
    for heading, keys in {
        "tedm.toml": {"title", "model", "optics", "cases", "dynamics", "thermal", "report"},
        "[frequency] of thermal.toml": {"list_hz"},
        "[[test_mass.pocket]]": {"face", "centre_m", "diameter_m", "size_m", "depth_m", "name"},
        "[frequency]": {"min_hz", "max_hz", "points"},
        "[[case]]": {"id", "blocks", "partition", "matrix"},
    }.items():
        assert keys <= set(re.findall(r"(?m)^\| `(\w+)` ", sections[heading])), heading
    assert "| `min_hz` | number | 1e-9 to 1e6 Hz | `0.0001` |" in sections["[frequency]"]
    assert "| `title` | text |  | needed |" in sections["tedm.toml"]
    assert '| `remove` | `"nothing"`, `"mean"`, `"linear"`, `"reference"` |  | needed |' in sections["[[series]]"]
    assert "| `electrostatic_matrix` | table of 6 × 6 numbers by name |" in sections["[stiffness]"]


def test_every_command_and_option_is_told() -> None:
    page = commands.document()
    for name, command in command_line().commands.items():
        assert (f"## tedm {name}\n" in page) != command.hidden
        if command.hidden:
            continue
        part = page.split(f"## tedm {name}\n")[1].split("\n## ")[0]
        for parameter in command.params:
            said = parameter.opts[0] if parameter.opts[0].startswith("-") else f"| {parameter.help.split()[0]}"
            assert said in part, f"{name}: {parameter.opts[0]}"


def test_every_public_name_has_its_docstring_in_the_site() -> None:
    page = (REFERENCE / "python.md").read_text(encoding="utf-8")
    assert set(re.findall(r"(?m)^::: tedm\.(\w+)$", page)) == set(tedm.__all__) - {"__version__"}
