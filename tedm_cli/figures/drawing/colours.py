"""Colours of thermal areas: a hue for each group, a lightness for each area, different for neighbours."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from tedm_cli.arrays import FloatArray

# Okabe and Ito (2008), with a grey and a brown in place of their black and light blue; a ninth group begins again.
_HUES = ("#0072B2", "#E69F00", "#009E73", "#CC79A7", "#4D4D4D", "#D55E00", "#F0E442", "#7A4A12")
# Towards white (positive) or black; those most unlike first.
_LEVELS = (0.1, 0.6, -0.28, 0.36, 0.78)
LEFT_OUT = (1.0, 0.0, 1.0)  # magenta: of no group, and hard to overlook


def area_colours(group: Sequence[str], neighbours: set[tuple[int, int]]) -> FloatArray:
    """RGB [k, 3] of each area; neighbours of one group differ in lightness as long as the five levels last."""
    groups = list(dict.fromkeys(group))
    beside: dict[int, set[int]] = {}
    for a, b in neighbours:
        beside.setdefault(a, set()).add(b)
        beside.setdefault(b, set()).add(a)
    level: dict[int, int] = {}
    # Those with most neighbours choose first (Welsh and Powell 1967), and take what their group has used least.
    for area in sorted(range(len(group)), key=lambda i: (-len(beside.get(i, ())), i)):
        around = [level[n] for n in beside.get(area, ()) if n in level and group[n] == group[area]]
        used = [level[i] for i in level if group[i] == group[area]]
        level[area] = min(range(len(_LEVELS)), key=lambda n: (around.count(n), used.count(n), n))
    return np.array([_mixed(_HUES[groups.index(g) % len(_HUES)], _LEVELS[level[i]]) for i, g in enumerate(group)])


def _mixed(hue: str, level: float) -> FloatArray:
    rgb = np.array([int(hue[i : i + 2], 16) for i in (1, 3, 5)]) / 255.0
    return np.asarray(rgb + level * (1.0 - rgb) if level >= 0 else rgb * (1.0 + level))
