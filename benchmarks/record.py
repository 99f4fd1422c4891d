"""Results as files: what was measured, of which code, when, and on what machine."""

from __future__ import annotations

import json
import os
import platform
import subprocess
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from datetime import UTC, datetime
from importlib.metadata import version
from pathlib import Path
from typing import Any

from benchmarks.process import ROOT

STORED = Path(__file__).parent / "results"
LIBRARIES = ("numpy", "scipy", "h5py", "numba")
#: What a change of the code changes the figures with.
CODE = ("tedm_cli", "benchmarks")


@dataclass(frozen=True)
class About:
    """Of a set of results: the code (commit, `+` if files of it had changes, its date), the day, and the machine."""

    commit: str
    commit_date: str
    day: str
    machine: str
    libraries: str
    load: float

    @classmethod
    def here(cls) -> About:
        """Of this tree and this machine, now; its load is that of the last 15 minutes."""
        changed = _git("status", "--porcelain", "--", *(f"{folder}/*.py" for folder in CODE))
        names = ", ".join(f"{name} {version(name)}" for name in LIBRARIES)
        return cls(
            _git("log", "-1", "--format=%h") + ("+" if changed else ""),
            _git("log", "-1", "--format=%cs"),
            datetime.now(UTC).date().isoformat(),
            f"{os.cpu_count()} × {_processor()}, {_memory_gb():.0f} GB",
            f"Python {platform.python_version()}, {names}",
            round(os.getloadavg()[2], 1),
        )

    def commits_since(self) -> int | None:
        """How many commits have changed the code since; none if that is not known here."""
        text = _git("rev-list", "--count", f"{self.commit.rstrip('+')}..HEAD", "--", *CODE)
        return int(text) if text else None


@dataclass(frozen=True)
class Record:
    """One set of results: its rows have the keys that its table asks for."""

    name: str
    about: About
    rows: Sequence[Mapping[str, Any]]

    def write(self, folder: Path) -> Path:
        folder.mkdir(parents=True, exist_ok=True)
        path = folder / f"{self.name}.json"
        rows = ",\n".join(f"  {json.dumps(row, ensure_ascii=False)}" for row in self.rows)
        about = json.dumps(asdict(self.about), ensure_ascii=False)
        path.write_text(f'{{"about": {about},\n "rows": [\n{rows}\n]}}\n', encoding="utf-8")
        return path


def read(path: Path) -> Record:
    """A set of results that was written."""
    found = json.loads(path.read_text(encoding="utf-8"))
    return Record(path.stem, About(**found["about"]), found["rows"])


def stored(folder: Path = STORED) -> dict[str, Record]:
    """All sets of a folder by name."""
    return {path.stem: read(path) for path in sorted(folder.glob("*.json"))}


def _git(*arguments: str) -> str:
    found = subprocess.run(["git", *arguments], cwd=ROOT, capture_output=True, text=True, check=False)
    return found.stdout.strip()


def _processor() -> str:
    for line in Path("/proc/cpuinfo").read_text().splitlines():
        if line.startswith("model name"):
            return line.split(":", 1)[1].strip()
    return platform.machine()


def _memory_gb() -> float:
    return os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") / 2**30
