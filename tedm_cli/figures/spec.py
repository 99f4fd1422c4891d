"""What a figure is called, where it stands, and how it is drawn when it is asked for."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Figure


@dataclass(frozen=True)
class FigureSpec:
    """A figure: name of its file, section of the report, caption, what it is drawn from, and how.

    `decides`: it is shown in the report itself, as part of the evidence that decides; else in the annex.
    """

    name: str
    section: str
    caption: str
    sources: tuple[str, ...]
    draw: Callable[[], Figure]
    decides: bool = False
