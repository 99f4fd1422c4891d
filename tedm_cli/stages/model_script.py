"""A Python program that writes a model: of a shipped sample, or of a variant in a trade."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path


def run_script(file: Path, arguments: Sequence[str], folder: Path | None = None) -> str:
    """Run a program with the Python that runs this, in `folder` or in the current one; why it failed, or ""."""
    done = subprocess.run(
        [sys.executable, "-B", str(file), *arguments],
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        errors="replace",
        check=False,
        cwd=folder,
    )
    if not done.returncode:
        return ""
    return (done.stderr.strip().splitlines() or [f"it ended with code {done.returncode}"])[-1]
