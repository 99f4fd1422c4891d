"""Which elements move as one: the optical benches of a layout."""

from __future__ import annotations

from itertools import count

import numpy as np

from tedm_cli.arrays import IndexArray
from tedm_cli.errors import InputError
from tedm_cli.optics.layout import Element, OpticalLayout

ONLY = "bench"  # name of the only bench, where the layout gives none


def benches(layout: OpticalLayout) -> dict[str, tuple[Element, ...]]:
    """Elements of every bench by its name, in layout order; test masses are on none.

    Elements are on one bench where a beam joins them, or where beams meet on one photodiode. A name that an element
    gives is that of its whole bench: benches that share a name are one, and where elements of one give several names,
    each of its elements must have one. An element that no beam meets is on the bench of the nearest one that is met.
    The steps of a path that are not known may be anywhere, so that all elements are on one bench then.

    Raises
    ------
    InputError : elements between benches of different names that do not say which they are on.
    """
    group = _joined(layout)
    names: list[str | None] = [e.bench for e in layout.bench]
    for number in range(int(group.max()) + 1):
        members = np.flatnonzero(group == number)
        given = {names[i] for i in members} - {None}
        open_ = [layout.bench[i].name for i in members if names[i] is None]
        if len(given) > 1 and open_:
            raise InputError(
                f"{', '.join(open_)} {'is' if len(open_) == 1 else 'are'} joined by beams to elements on"
                f" {' and '.join(sorted(str(n) for n in given))}, and must say which `bench` to be on",
                where="bench",
            )
        if len(given) == 1:
            for i in members:
                names[i] = next(iter(given))
    unnamed = [g for g in dict.fromkeys(group.tolist()) if names[int(np.flatnonzero(group == g)[0])] is None]
    only = len(unnamed) == 1 and not any(names)
    new = (f"{ONLY}_{n}" for n in count(1))
    for g in unnamed:
        name = ONLY if only else next(n for n in new if n not in names)
        for i in np.flatnonzero(group == g):
            names[i] = name
    return {
        str(name): tuple(e for e, n in zip(layout.bench, names, strict=True) if n == name)
        for name in dict.fromkeys(names)
    }


def _joined(layout: OpticalLayout) -> IndexArray:
    """Number of the group that each bench element is in, [n_bench]."""
    place = {e.name: i for i, e in enumerate(layout.bench)}
    first, second = [], []
    for path in layout.paths:
        known = [place[s.element] for s in path.steps if s.element in place]
        met = [place[path.photodiode], *known] if path.steps else list(place.values())
        first += [met[0]] * len(met)
        second += met
    n = len(place)
    group = np.arange(n)
    for pair in zip(first, second, strict=True):  # a handful: to load SciPy's graphs would take a command longer
        low, high = sorted(group[list(pair)])
        group[group == high] = low
    is_met = np.isin(np.arange(n), second)
    at = np.array([e.ref_m for e in layout.bench])
    for i in np.flatnonzero(~is_met):
        if layout.bench[i].bench is None:
            away = np.where(is_met, np.linalg.norm(at - at[i], axis=1), np.inf)
            group[i] = group[away.argmin()]
    return np.asarray(np.unique(group, return_inverse=True)[1], dtype=np.intp)
