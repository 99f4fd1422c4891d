"""Who may import what: physics knows no files, and each heavy library has one door."""

from __future__ import annotations

import ast
import re
from functools import cache
from pathlib import Path

import pytest
from border_tools import ROOT, tree

from tedm_cli.contracts import KINDS

PACKAGE = ROOT / "tedm_cli"
MODULES = sorted(PACKAGE.rglob("*.py"))
PURE_ROOMS = {
    "adjoint",
    "balance",
    "gravity",
    "optics",
    "noise",
    "dynamics",
    "fem",
    "mapping",
    "thermal",
    "view",
    "uncertainty",
    "columns.py",
    "distortion.py",
    "chain",
    "trade",
}
PURE = [p for p in MODULES if p.relative_to(PACKAGE).parts[0] in PURE_ROOMS]
OUTSIDE = {"h5py", "pyNastran", "typer", "matplotlib", "rich", "pydantic", "jinja2"}
ROOMS = {"cli", "files", "tables", "results", "stages", "nastran", "figures", "config", "report", "exports"}


@cache
def imports(path: Path) -> frozenset[str]:
    """Every module that a file imports anywhere in it, inside functions as well, by its full name."""
    found: set[str] = set()
    for node in ast.walk(tree(path)):
        if isinstance(node, ast.Import):
            found.update(alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path}: relative import"
            found.update({str(node.module), *(f"{node.module}.{alias.name}" for alias in node.names)})
    return frozenset(found)


def heads(path: Path) -> set[str]:
    return {name.split(".")[0] for name in imports(path)}


def rooms(path: Path) -> set[str]:
    return {name.split(".")[1] for name in imports(path) if name.startswith("tedm_cli.")}


def users_of(room: str) -> set[str]:
    return {p.relative_to(PACKAGE).parts[0] for p in MODULES if room in rooms(p)}


def test_there_are_pure_rooms() -> None:
    assert {p.relative_to(PACKAGE).parts[0] for p in PURE} == PURE_ROOMS


@pytest.mark.parametrize("path", PURE, ids=[p.relative_to(PACKAGE).as_posix() for p in PURE])
def test_pure_rooms_know_no_files(path: Path) -> None:
    assert not heads(path) & OUTSIDE
    assert not rooms(path) & ROOMS


@pytest.mark.parametrize(
    ("library", "door"),
    [
        ("h5py", "files"),
        ("pyNastran", "nastran"),
        ("matplotlib", "figures"),
        ("typer", "cli"),
        ("pydantic", "config"),
        ("xarray", "library"),
        ("sklearn", "adjoint"),
    ],
)
def test_one_door_for_each_library(library: str, door: str) -> None:
    users = {p.relative_to(PACKAGE).parts[0] for p in MODULES if library in heads(p)}
    assert users == {door}


def test_only_the_two_doors_import_the_stages() -> None:
    assert users_of("stages") <= {"cli", "library", "stages"}
    assert users_of("cli") <= {"cli"}
    assert users_of("library") <= {"library"}


def test_the_library_prints_nothing() -> None:
    """It is a door by itself, without what the other one needs, and `import tedm` is all that comes before it."""
    library = [p for p in MODULES if p.relative_to(PACKAGE).parts[0] == "library"]
    assert len(library) > 5
    for path in library:
        assert not heads(path) & {"typer", "rich", "matplotlib", "jinja2", "h5py"}, path
        assert "cli" not in rooms(path), path
        assert not [n for n in ast.walk(tree(path)) if isinstance(n, ast.Name) and n.id == "print"]


def test_the_report_is_made_of_results_not_of_figures() -> None:
    """Figures come to it drawn; types and words that both need are in `results`."""
    assert "report" not in users_of("figures")
    assert users_of("results") <= {"cli", "library", "results", "figures", "report", "exports", "stages"}


ROOMS_WITH_TEXT = [p for p in MODULES if p.name == "__init__.py"]
WINGS = sorted(p.name for p in (PACKAGE / "stages").iterdir() if (p / "__init__.py").exists())


def test_there_are_wings() -> None:
    assert WINGS == [
        "adjoint",
        "balance",
        "chain",
        "dynamics",
        "explain",
        "exports",
        "gravity",
        "loads",
        "model",
        "noise",
        "optics",
        "reporting",
        "thermal",
        "trade",
    ]


@pytest.mark.parametrize("wing", WINGS)
def test_wings_do_not_import_each_other(wing: str) -> None:
    """What two wings need is in a pure room, in `results` or in a file of `stages/` itself."""
    others = {f"tedm_cli.stages.{w}" for w in WINGS if w != wing}
    for path in sorted((PACKAGE / "stages" / wing).rglob("*.py")):
        crossed = {name for name in imports(path) for o in others if name == o or name.startswith(f"{o}.")}
        assert not crossed, f"{path.relative_to(ROOT)} imports {sorted(crossed)}"


@pytest.mark.parametrize(
    "room", ROOMS_WITH_TEXT, ids=[p.parent.relative_to(PACKAGE.parent).as_posix() for p in ROOMS_WITH_TEXT]
)
def test_every_room_says_what_it_is_for(room: Path) -> None:
    text = ast.get_docstring(tree(room))
    assert text
    assert len(text.split()) >= 5


def test_dataset_paths_are_spelt_in_the_contracts_alone() -> None:
    """Elsewhere datasets have names (`CASE.VERDICT_RATIO`): no string is a path, or the beginning of one."""
    first = {path.split("/")[1] for kind in KINDS.values() for path in kind.datasets}
    assert {"verdict", "area", "S_BW"} <= first
    for path in MODULES:
        if path.relative_to(PACKAGE).parts[0] == "contracts":
            continue
        said = {id(node.value) for node in ast.walk(tree(path)) if isinstance(node, ast.Expr)}  # docstrings
        for node in ast.walk(tree(path)):
            if isinstance(node, ast.Constant) and isinstance(node.value, str) and id(node) not in said:
                head = re.match(r"/(\w+)(/|$)", node.value)
                assert head is None or head[1] not in first, f"{path.relative_to(ROOT)}:{node.lineno}: {node.value}"
