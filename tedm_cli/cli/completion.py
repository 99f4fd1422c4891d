"""What the shell completes: names that the files of a project say, read as text, and nothing where there are none."""

from __future__ import annotations

import csv
import functools
import re
import tomllib
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import typer

from tedm_cli.config.nearest import nearest_project

_HEAD = 2_000_000  # characters of a deck, in which its case control is
_ACCELERATIONS = ("a_x", "a_y", "a_z", "omegadot_x", "omegadot_y", "omegadot_z")
STAGES = (
    *("write-deck", "solve", "ingest", "build-distortion", "build-sensitivity", "build-optics"),
    *(
        "build-adjoint",
        "build-thermal",
        "run-case",
        "run-series",
        "build-dynamics",
        "simulate",
        "plot",
        "report",
        "view",
        "build-loads",
    ),
)
FIGURES = ("6.4", "7.2", "7.3", "7.8", "7.9", "8.1")
MATRICES = ("optics", "sensitivity", "distortion")
Names = Callable[[typer.Context], Iterable[str]]
Complete = Callable[[typer.Context, str], list[str]]


@dataclass(frozen=True)
class _Files:
    """The configuration files of a project, and its build folder, as far as they can be read without the library."""

    build_dir: Path
    model_file: Path
    model: dict[str, Any]
    optics: dict[str, Any]
    cases: dict[str, Any]


def completed(names: Names) -> Complete:
    """What typer asks for: those of the names that begin as what is typed. Nothing is said of what goes wrong."""

    @functools.wraps(names)
    def complete(ctx: typer.Context, incomplete: str) -> list[str]:
        try:
            found = list(dict.fromkeys(names(ctx)))
        except Exception:
            return []  # a shell that completes is no place to tell of a broken project
        return [name for name in found if name.lower().startswith(incomplete.lower())]

    # typer reads the signature, and what it wraps has another one.
    del complete.__wrapped__
    return complete


@completed
def cases(ctx: typer.Context) -> Iterable[str]:
    """Ids of the configured cases, and all."""
    return _and_all(str(table["id"]) for table in _files(ctx).cases.get("case", []))


@completed
def series(ctx: typer.Context) -> Iterable[str]:
    """Names of the configured time series, and all."""
    return _and_all(str(table["name"]) for table in _files(ctx).cases.get("series", []))


@completed
def areas(ctx: typer.Context) -> Iterable[str]:
    """Names of the thermal areas."""
    return _areas(_files(ctx))


@completed
def outputs(ctx: typer.Context) -> Iterable[str]:
    """Names of the outputs: self-gravity, then the read-outs by set."""
    return _outputs(_files(ctx))


@completed
def names(ctx: typer.Context) -> Iterable[str]:
    """All that `explain` can be asked for."""
    files = _files(ctx)
    required = [str(table["name"]) for table in files.cases.get("requirement", [])]
    required += [str(table["name"]) for table in files.model.get("requirement_at_rest", [])]
    differences = [o for table in files.cases.get("requirement", []) for o in table.get("outputs", []) if "-" in o]
    groups = [str(rule["group"]) for rule in files.model.get("areas", {}).get("rule", []) if "group" in rule]
    elements = [str(table["name"]) for table in files.optics.get("element", [])]
    return [*_outputs(files), *_read_outs(files), *differences, *required, *_areas(files), *groups, *elements]


@completed
def sets(ctx: typer.Context) -> Iterable[str]:
    """Names of the sets of photodiodes."""
    return _sets(_files(ctx))


@completed
def files(ctx: typer.Context) -> Iterable[str]:
    """The HDF5 files here and in the build folder; the shell completes other paths where none of these is meant."""
    folders = dict.fromkeys((Path(), _files(ctx).build_dir))
    return [str(path) for folder in folders for path in sorted(folder.glob("*.h5"))]


@completed
def stages(ctx: typer.Context) -> Iterable[str]:
    return STAGES


@completed
def figures(ctx: typer.Context) -> Iterable[str]:
    return FIGURES


@completed
def matrices(ctx: typer.Context) -> Iterable[str]:
    return MATRICES


def _and_all(found: Iterable[str]) -> list[str]:
    """The names, and `all` where there are any."""
    names = list(found)
    return [*names, "all"] if names else []


def _files(ctx: typer.Context) -> _Files:
    """Those of the project that the line names, or of the nearest one."""
    found = nearest_project()
    config, build = ctx.params.get("config"), ctx.params.get("build_dir")
    if config is None or not Path(config).is_file():
        config = None if found is None else found.file
    if build is None:
        build = Path("build") if found is None else found.folder / "build"
    if config is None:
        return _Files(Path(build), Path(), {}, {}, {})
    folder, project = Path(config).parent, _table(Path(config))
    model = folder / project.get("model", "model.toml")
    optics = folder / project.get("optics", "optics.toml")
    return _Files(
        Path(build), model, _table(model), _table(optics), _table(folder / project.get("cases", "cases.toml"))
    )


def _table(path: Path) -> dict[str, Any]:
    return tomllib.loads(path.read_text(encoding="utf-8")) if path.is_file() else {}


def _outputs(files: _Files) -> list[str]:
    gravity = [f"{table['name']}_{end}" for table in files.model.get("test_mass", []) for end in _ACCELERATIONS]
    return gravity + [f"{name}_{read_out}" for name in _sets(files) for read_out in _read_outs(files)]


def _read_outs(files: _Files) -> list[str]:
    masses = [t["name"] for t in files.optics.get("element", []) if t.get("kind") == "test_mass"]
    return [f"{mass}_{axis}" for mass in masses for axis in files.optics.get("read_out", ("x", "eta", "phi"))]


def _sets(files: _Files) -> list[str]:
    return list(files.optics.get("sets", {}))


def _areas(files: _Files) -> list[str]:
    """Labels of the unit-load deck, or else what the list of areas and the definitions say."""
    table = files.model.get("model", {})
    deck = _path(files, table.get("deck", "{build_dir}/unit_loads.bdf"))
    if deck.is_file():
        with deck.open(encoding="utf-8", errors="replace") as stream:
            control = re.split("(?im)^ *BEGIN +BULK", stream.read(_HEAD))[0]
        labels = re.findall(r"(?im)^ *LABEL *= *(\S+)", control)
        return [label for label in labels if label != table.get("uniform_label", "UNIFORM")]
    found = [str(area["name"]) for area in files.model.get("areas", {}).get("area", []) if "name" in area]
    listed = _path(files, table["areas_csv"]) if "areas_csv" in table else Path()
    if listed.is_file():
        with listed.open(encoding="utf-8", newline="") as stream:
            found += [row["area"] for row in csv.DictReader(stream) if row.get("area")]
    return found


def _path(files: _Files, text: str) -> Path:
    if "{build_dir}" in text:
        return Path(text.replace("{build_dir}", str(files.build_dir)))
    return files.model_file.parent / text
