"""Figures, report and page that were written, as lines of text and for programs."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tedm_cli.results.wording import count

if TYPE_CHECKING:
    from tedm_cli.stages.reporting.view import ViewWritten


def written_lines(paths: Sequence[Path]) -> list[str]:
    """The files and their sizes."""
    return [f"{path}: {_megabytes(path)}" for path in paths]


def written_dict(paths: Sequence[Path]) -> dict[str, Any]:
    return {"files": [_file_dict(path) for path in paths]}


def figure_lines(paths: Sequence[Path]) -> list[str]:
    """Where the figures are, and how many."""
    return [f"{paths[0].parent}: {count(len(paths), 'figure')}"]


def view_lines(done: ViewWritten) -> list[str]:
    """The page, its size, and how much of the model is drawn."""
    left = f"; without {', '.join(done.left_out)}: thermal nodes are no areas" if done.left_out else ""
    still = "" if done.moving else "; at rest, for distortion.h5 has no displacements of grids"
    return [f"{done.path}: {_megabytes(done.path)}, {done.drawn:,} of {done.grids:,} grids drawn{left}{still}"]


def view_dict(done: ViewWritten) -> dict[str, Any]:
    return _file_dict(done.path) | {
        "drawn_grids": done.drawn,
        "grids": done.grids,
        "cases": done.cases,
        "series": done.series,
        "left_out": list(done.left_out),
        "moving": done.moving,
    }


def _file_dict(path: Path) -> dict[str, Any]:
    return {"file": path, "bytes": path.stat().st_size}


def _megabytes(path: Path) -> str:
    return f"{path.stat().st_size / 1e6:.2f} MB"
