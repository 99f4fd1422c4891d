"""What the project says of itself in several files is the same everywhere; hooks use nothing from elsewhere."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

import tedm_cli

ROOT = Path(__file__).parents[2]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]


def citation() -> dict[str, str]:
    """The keys of CITATION.cff that have a plain value, without those inside of others."""
    lines = (ROOT / "CITATION.cff").read_text(encoding="utf-8").splitlines()
    pairs = [re.fullmatch(r'([a-z-]+): "?(.*?)"?', line) for line in lines]
    return {pair[1]: pair[2] for pair in pairs if pair}


def test_citation_is_of_this_project() -> None:
    cff = citation()
    assert {"cff-version", "message", "title", "version", "license"} <= cff.keys()
    assert cff["title"].split(":")[0] == PROJECT["name"]
    assert cff["version"] == PROJECT["version"] == tedm_cli.__version__
    assert cff["license"] == PROJECT["license"]["text"]
    assert (ROOT / "LICENSE").read_text(encoding="utf-8").startswith(f"{cff['license']} License")
    assert cff["abstract"] == PROJECT["description"]


def test_citation_and_readme_name_the_same_thesis() -> None:
    text = (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    (title,) = re.findall(r'^    title: "(.*)"$', text, re.M)
    readme = " ".join((ROOT / "README.md").read_text(encoding="utf-8").split())
    assert f"*{title}* (Università di Pisa, 2004)" in readme
    assert '"The tedm developers"' in text


def test_hooks_are_local_and_run_what_make_check_runs() -> None:
    text = (ROOT / ".pre-commit-config.yaml").read_text(encoding="utf-8")
    assert set(re.findall(r"repo: *(\S+)", text)) == {"local"}
    assert set(re.findall(r"language: *(\S+)", text)) == {"system"}
    entries = re.findall(r"entry: *\.venv/bin/(.+)", text)
    assert len(entries) == len(re.findall(r"- id:", text))
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    check = makefile.split("\ncheck:")[1].split("\n\n")[0]
    for command in re.findall(r"\$\(BIN\)/(ruff \w+|mypy)", check):
        assert any(entry.startswith(command) for entry in entries), command
