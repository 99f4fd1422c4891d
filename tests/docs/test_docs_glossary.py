"""The glossary: its links, the names that it gives, and that it has every symbol and output that a report shows."""

from __future__ import annotations

import ast
import importlib
import pkgutil
import re
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from typer.main import get_command

import tedm_cli.config
from tedm_cli.cli.commands import app
from tedm_cli.config.base import Strict
from tedm_cli.contracts import KINDS
from tedm_cli.dynamics.bodies import DynamicTestMass
from tedm_cli.dynamics.presets import lpf_sources
from tedm_cli.dynamics.signals import OUTPUTS
from tedm_cli.gravity.requirements import AT_REST_UNITS
from tedm_cli.results.titles import SUBSYSTEM_TITLES, output_title

ROOT = Path(__file__).parents[2]
GLOSSARY = ROOT / "docs" / "glossary.md"
TEXT = GLOSSARY.read_text(encoding="utf-8")
ROWS = [[cell.strip() for cell in line.strip("|").split(" | ")] for line in TEXT.splitlines() if line.startswith("| ")][
    1:
]
TERMS = [row[0] for row in ROWS]
CODE = set(re.findall(r"`([^`]+)`", TEXT))
#: Every word of the first column: `[D], ...` is D, `S_SG, ...` is S_SG.
WORDS = {word for term in TERMS for word in re.findall(r"[^\W\d][\ẇ]*", term)}
# What a symbol looks like where text is printed: an optical or gravity matrix, a Greek letter with or without an index.
SYMBOL = re.compile(r"\b(?:S_[A-Z]{2}|O_ideal|D_opt|OPD|WFT\d?|OMS|LTP|ΔT|Δg|[ΓΩκ](?:_[a-z]+)?|N_A)(?!\w)")
ALIAS = {"Γ": "Γ_lin", "Ω": "Ω_lin", "Γ_xx": "Γ_lin", "N_A": "N", "ΔT": "T"}


def sort_key(term: str) -> str:
    return re.sub(r"[^0-9a-z]+", " ", re.sub(r"[\[\]`/]", "", term).split(",")[0].casefold()).strip()


def anchor(heading: str) -> str:
    return re.sub(r"[^\w\- ]", "", heading.strip().lower().replace("`", "")).replace(" ", "-")


def paths() -> set[str]:
    """Paths of all datasets, and of the groups they are in."""
    kinds = [d.path for kind in KINDS.values() for d in kind.datasets.values()]
    return {*kinds, *(path.rsplit("/", 1)[0] for path in kinds)}


def keys() -> set[str]:
    """All keys that a configuration may have."""
    for module in pkgutil.walk_packages(tedm_cli.config.__path__, "tedm_cli.config."):
        importlib.import_module(module.name)
    return {field.alias or name for table in below(Strict) for name, field in table.model_fields.items()}


def below(table: type[Strict]) -> Iterator[type[Strict]]:
    for child in table.__subclasses__():
        yield child
        yield from below(child)


def family(label: str) -> str:
    """A label of an output without the number of its test mass and its axis: `TM1_a_x` and `TM2_a_y` are one family."""
    return re.sub(
        r"_(x|y|z|theta|eta|phi)$", "_AXIS", re.sub(r"_([FL])[xyz]$", r"_\1_AXIS", re.sub(r"(TM|^H)\d", r"\1", label))
    )


def test_terms_are_sorted_and_distinct() -> None:
    assert len(ROWS) > 100
    assert all(len(row) == 4 for row in ROWS), [row for row in ROWS if len(row) != 4]
    assert [sort_key(t) for t in TERMS] == sorted(sort_key(t) for t in TERMS)
    assert len(set(TERMS)) == len(TERMS)
    assert all(meaning.endswith(".") for _, meaning, _, _ in ROWS)


def test_every_link_leads_to_a_page_and_a_heading() -> None:
    found = re.findall(r"\]\(([^)#]+)(?:#([^)]+))?\)", TEXT)
    assert len(found) >= len(ROWS)
    for target, place in sorted(set(found)):
        page = GLOSSARY.parent / target
        assert page.is_file(), target
        headings = re.findall(r"^#+ (.*)$", page.read_text(encoding="utf-8"), flags=re.M)
        assert not place or place in map(anchor, headings), f"{target}#{place}"


@pytest.mark.parametrize("name", sorted(CODE))
def test_every_name_exists(name: str) -> None:
    """Datasets, commands, keys, files between the stages, and labels of outputs."""
    key = name.split(" = ")[0].strip("[]")
    if name.startswith("/"):
        assert name in paths()
    elif name.startswith("tedm "):
        assert name.split()[1] in get_command(app).commands  # type: ignore[attr-defined]
    elif name.endswith(".h5"):
        assert name.removesuffix(".h5") in KINDS
    elif name.endswith(".toml"):
        assert (ROOT / "configs" / name).is_file()
    elif name in AT_REST_UNITS or name == "code style":
        pass
    else:
        assert key in keys() or output_title(name) != name


def test_it_has_every_output_of_a_report() -> None:
    in_glossary = {family(name) for name in CODE}
    cases = [f"TM1_{q}" for q in ("a_x", "omegadot_theta")] + [f"A_TM1_{axis}" for axis in ("x", "eta")]
    for label in (*OUTPUTS, *cases):
        assert label in CODE or family(label) in in_glossary, label


def test_it_has_every_symbol_that_a_report_prints() -> None:
    folders = [ROOT / "tedm_cli" / name for name in ("report", "results", "figures")]
    sources = [
        path for folder in folders for path in sorted(folder.rglob("*")) if path.suffix in (".py", ".j2", ".html")
    ]
    found = {symbol for path in sources for text in texts(path) for symbol in SYMBOL.findall(text)}
    assert {"S_BW", "O_ideal", "Γ_lin"} <= found
    assert {ALIAS.get(s, s) for s in found} <= WORDS, sorted({ALIAS.get(s, s) for s in found} - WORDS)


def texts(path: Path) -> list[str]:
    """What a source may print: string literals of a program, all of a template."""
    text = path.read_text(encoding="utf-8")
    if path.suffix != ".py":
        return [text]
    return [n.value for n in ast.walk(ast.parse(text)) if isinstance(n, ast.Constant) and isinstance(n.value, str)]


def test_it_has_subsystems_and_groups_of_noise_sources() -> None:
    assert all(name in TERMS for name in SUBSYSTEM_TITLES)
    masses = [
        DynamicTestMass(f"TM{i}", 1.96, np.full(3, 7e-4), np.array([x, 0.0, 0.0]), np.eye(3))
        for i, x in ((1, -0.188), (2, 0.188))
    ]
    groups = {source.group for source in lpf_sources(masses, np.zeros(12))}
    (said,) = [meaning for term, meaning, _, _ in ROWS if term == "noise source"]
    assert groups <= set(re.findall(r"\w+", said)), groups
