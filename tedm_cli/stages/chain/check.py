"""check: walk the files of a build folder and compare what each was made from with what is there now."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

from tedm_cli import __version__
from tedm_cli.config.symmetry_plane import plane_of_frame
from tedm_cli.contracts import UNIT_LOADS
from tedm_cli.errors import InputError, TedmError
from tedm_cli.files.provenance import absolute_path
from tedm_cli.files.seal import sha256_of
from tedm_cli.files.store import Reader, kind_of, open_checked
from tedm_cli.results.areas import read_plane


@dataclass(frozen=True)
class FileCheck:
    """One file and what is wrong with it (nothing, when it is up to date)."""

    path: Path
    kind: str
    problems: list[str]
    inputs: tuple[Path, ...] = ()

    def lines(self) -> list[str]:
        state = "stale or damaged" if self.problems else "up to date"
        return [f"{self.path} ({self.kind}): {state}", *(f"  {p}" for p in self.problems)]

    def as_dict(self) -> dict[str, Any]:
        return {"file": str(self.path), "kind": self.kind, "up_to_date": not self.problems, "problems": self.problems}


def check_folder(folder: Path) -> list[FileCheck]:
    """Check all tedm files in `folder`, in alphabetical order.

    Raises
    ------
    InputError : the folder holds none.
    """
    files = sorted(folder.glob("*.h5"))
    if not files:
        raise InputError("holds no HDF5 files", where=str(folder), hint="`tedm run` makes them")
    sum_of = cache(sha256_of)
    return _with_ancestors([check_file(path, sum_of) for path in files])


def check_file(path: Path, sum_of: Callable[[Path], str] = sha256_of) -> FileCheck:
    """Contract, version, and the hash of every input and configuration, by `sum_of`."""
    try:
        kind = kind_of(path)
    except InputError as exc:
        return FileCheck(path, "unknown", [exc.fact])
    try:
        with open_checked(path, kind) as file:
            provenance = file.provenance()
            turned = _turned(file) if kind is UNIT_LOADS else []
            made_with = str(file.attributes["tedm_version"])
    except InputError as exc:
        return FileCheck(path, kind.name, [exc.fact])
    problems = [] if made_with == __version__ else [f"made by tedm {made_with}, this is {__version__}"]
    items = [(c.path, c.sha256) for c in provenance.configs] + [(i.path, i.sha256) for i in provenance.inputs]
    problems += [p for path_used, digest in items if (p := _compare(path_used, digest, sum_of))]
    return FileCheck(path, kind.name, problems + turned, tuple(i.path for i in provenance.inputs))


def _with_ancestors(checks: list[FileCheck]) -> list[FileCheck]:
    """Pass on along the chain: what was made from a stale file is stale, though that file is as it was then."""
    bad = {c.path.resolve(): c for c in checks if c.problems}
    out = checks
    for _ in checks:  # the chain is not longer than there are files
        out = [
            c
            if c.problems or not (stale := [i for i in c.inputs if i in bad])
            else FileCheck(c.path, c.kind, [f"its input {i} is not up to date" for i in stale], c.inputs)
            for c in out
        ]
        bad = {c.path.resolve(): c for c in out if c.problems}
    return out


def _turned(file: Reader) -> list[str]:
    """Of unit loads whose symmetry plane is from the frame of a layout, of which nothing else matters to them."""
    name = file.string(UNIT_LOADS.PLANE_LAYOUT)
    if not name:
        return []
    layout = absolute_path(name, file.path.parent)
    if not layout.exists():
        return [f"{layout}, whose frame gives the symmetry plane, is gone"]
    try:
        now = plane_of_frame(layout)
    except TedmError:
        return [f"{layout}, whose frame gives the symmetry plane, cannot be read"]
    used = read_plane(file)
    return [] if now.is_same(used) else [f"its symmetry plane was {used.words}; by {layout} it is {now.words} now"]


def _compare(path: Path, sha256: str, sum_of: Callable[[Path], str]) -> str:
    try:
        now = sum_of(path)
    except InputError:
        return f"its input {path} is gone"
    return "" if now == sha256 else f"its input {path} has changed since"
