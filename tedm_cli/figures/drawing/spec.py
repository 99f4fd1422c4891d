"""What a figure is called, where it stands, how large it may be, and how it is drawn when it is asked for."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Figure

#: The report sets figures at 0.8 of their size as long as they are no larger than this, inches. Type of 8.8 points, the
#: smallest there is in them, then has 7 points on the page, or 6.8 where two figures share it.
PAGE_WIDTH, PAGE_HEIGHT = 8.75, 10.0


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
