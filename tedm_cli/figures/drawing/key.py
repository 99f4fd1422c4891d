"""Keys of figures: as many columns as there is room for, with samples that show how lines are dashed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.artist import Artist
from matplotlib.figure import Figure

from tedm_cli.figures.drawing.fit import line_count, text_width, wrapped
from tedm_cli.figures.drawing.style import KEY, SMALL

_COLUMN, _PAD = 1.4, 0.7  # between columns, and between a sample and its words, in sizes of the type
_SPACING = 0.3  # between entries, in sizes of the type


@dataclass(frozen=True)
class Key:
    """Samples with words beside them in some columns, and the inches from its upper to its lower edge."""

    handles: list[Artist]
    labels: list[str]
    columns: int
    height: float
    sample: float

    def draw(self, figure: Figure, left: float, bottom: float) -> None:
        """Draw it with its lower left corner at a place in inches."""
        width, height = (float(v) for v in figure.get_size_inches())
        figure.legend(
            self.handles, self.labels, loc="lower left", bbox_to_anchor=(left / width, bottom / height),
            ncols=self.columns, handlelength=self.sample, handletextpad=_PAD, columnspacing=_COLUMN,
            labelspacing=_SPACING, borderaxespad=0.0, borderpad=0.0,
        )  # fmt: skip


def key(handles: Sequence[Artist], width: float, sample: float = KEY, most: int = 4) -> Key:
    """A key of artists with labels that is at most `width` inches wide, and has at most so many columns.

    Words that are wider than a single column are broken into lines. `sample` is the length of a sample in sizes of
    the type.
    """
    beside = (sample + _PAD) * SMALL / 72
    texts = [str(h.get_label()) for h in handles]
    columns = min(most, len(handles))
    while columns > 1 and _width(texts, columns, beside) > width:
        columns -= 1
    labels = [wrapped(t, width - beside, SMALL) for t in texts]
    tall = max(
        sum(1.2 * SMALL / 72 * line_count(t) for t in part) + _SPACING * SMALL / 72 * (len(part) - 1)
        for part in _parts(labels, columns)
    )
    return Key(list(handles), labels, columns, tall + 0.02, sample)


def _parts(labels: list[str], columns: int) -> list[list[str]]:
    """What stands in each column, as matplotlib shares it out."""
    return [[labels[i] for i in part] for part in np.array_split(np.arange(len(labels)), columns) if len(part)]


def _width(texts: list[str], columns: int, beside: float) -> float:
    parts = _parts(texts, columns)
    return sum(beside + max(text_width(t, SMALL) for t in part) for part in parts) + _COLUMN * SMALL / 72 * (
        len(parts) - 1
    )
