"""Which thermal areas a block of a correlation case takes, and how it is divided."""

from __future__ import annotations

import difflib
from collections.abc import Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase

import numpy as np
from numpy.typing import NDArray

from tedm_cli.arrays import BoolArray, IndexArray
from tedm_cli.noise.areas import AreaTable

Facts = list[tuple[str, str]]


@dataclass(frozen=True)
class BlockSelector:
    """Areas of one block, those that meet every key given, each key by any of its values; and how they are divided.

    Parameters
    ----------
    groups, shield, side : values of the columns of `AreaTable`.
    areas : patterns of area names, with `*`, `?` and `[...]`.
    partition : `all`: one block; `none`: every area a block of its own; `group`, `shield`, `side`: one block for each
        value of that column; `mirror`: every area on +y with its mirror image on -y, areas in the middle alone.
    mirror_names : with `mirror`, the parts of the names that tell +y from -y; () matches centroids instead.
    rho : correlation coefficient of any two areas of a block: R = rho J + (1 - rho) I.
    across_kinds : a block holds means and gradients together; otherwise it is a block of each. Not with `mirror`, where
        both have one centroid.
    """

    groups: tuple[str, ...] = ()
    shield: tuple[str, ...] = ()
    side: tuple[str, ...] = ()
    areas: tuple[str, ...] = ()
    partition: str = "all"
    mirror_names: tuple[str, ...] = ()
    rho: float = 1.0
    across_kinds: bool = False


def select(selector: BlockSelector, areas: AreaTable, *, ignore_side: bool = False) -> tuple[BoolArray, Facts]:
    """BoolArray [k] of the selected areas, and what is wrong with the selector as (key, fact)."""
    mask = np.ones(len(areas), dtype=bool)
    facts: Facts = []
    for key, wanted, column in (
        ("groups", selector.groups, areas.group),
        ("shield", selector.shield, areas.shield),
        ("side", () if ignore_side else selector.side, areas.side),
    ):
        if wanted:
            mask &= np.isin(column, wanted)
            existing = sorted(set(column.tolist()))
            facts += [(f".{key}", unknown(value, existing)) for value in wanted if value not in existing]
    if selector.areas:
        names = areas.name.tolist()
        hits = np.array([[fnmatchcase(name, p) for p in selector.areas] for name in names])
        mask &= hits.any(axis=1)
        matched = zip(selector.areas, hits.any(axis=0), strict=True)
        facts += [(".areas", unknown(p, names)) for p, hit in matched if not hit]
    if not facts and not mask.any():
        facts.append(("", f"selects none of the {len(areas)} thermal areas; present: {_present(areas)}"))
    return mask, facts


def divide(selector: BlockSelector, mask: BoolArray, areas: AreaTable) -> tuple[list[IndexArray], Facts]:
    """Column indices of the blocks that the selected areas `mask` [k] are divided into, and what forbids it."""
    index = np.flatnonzero(mask)
    if selector.partition == "none":
        return [np.array([i]) for i in index], []
    if selector.partition == "mirror":
        return _mirror_pairs(selector, index, areas)
    if selector.partition == "all":
        return [index], []
    column: NDArray[np.str_] = getattr(areas, selector.partition)[index]
    return [index[column == value] for value in dict.fromkeys(column.tolist())], []


def _mirror_pairs(selector: BlockSelector, index: IndexArray, areas: AreaTable) -> tuple[list[IndexArray], Facts]:
    """(+y area, its mirror image) each, and areas in the middle alone; areas without a partner are refused."""
    plus, minus = (index[areas.side[index] == side] for side in ("+y", "-y"))
    if selector.mirror_names:
        here, there = selector.mirror_names
        place = {name: i for i, name in enumerate(areas.name.tolist())}
        partner = np.array([place.get(areas.name[i].replace(here, there), -1) for i in plus], dtype=np.intp)
        partner[~np.isin(partner, minus)] = -1
    elif areas.centroid_m is None:
        fact = "mirror pairs are matched by centroids, which these areas do not have; rebuild distortion.h5 and on"
        return [], [("", fact)]
    else:
        partner = _nearest_images(areas, plus, minus)
    alone = np.concatenate([plus[partner < 0], minus[~np.isin(minus, partner)]])
    if alone.size:
        how = f"name with {selector.mirror_names[1]!r}" if selector.mirror_names else "area near its mirrored centroid"
        names = listed(areas.name[alone].tolist(), 6)
        mend = "change mirror_names" if selector.mirror_names else "pair areas by mirror_names"
        side = f"the other side of {areas.plane.words}"
        fact = f"without a mirror image on {side} (no {how}): {names}; {mend}, or delete the case"
        return [], [("", fact)]
    middle = index[areas.side[index] == "mid"]
    pairs = [np.array(pair) for pair in zip(plus.tolist(), partner.tolist(), strict=True)]
    return pairs + [np.array([i]) for i in middle], []


def _nearest_images(areas: AreaTable, plus: IndexArray, minus: IndexArray) -> IndexArray:
    """For each area in `plus` the one in `minus` of its kind at its mirrored centroid, -1 where there is none.

    Both must be each other's nearest image, and miss it by less than their distance from the plane: areas that are
    further off are neighbours along the structure, no images.
    """
    centroid_m, plane = areas.centroid_m, areas.plane
    if centroid_m is None or not (plus.size and minus.size):
        return np.full(len(plus), -1, dtype=np.intp)
    image = plane.image(centroid_m[plus])
    distance = np.linalg.norm(image[:, None] - centroid_m[minus], axis=2)
    distance[areas.kind[plus][:, None] != areas.kind[minus]] = np.inf  # three gradients have one centroid
    nearest = distance.argmin(axis=1)
    mutual = distance.argmin(axis=0)[nearest] == np.arange(len(plus))
    near = distance[np.arange(len(plus)), nearest] < np.abs(plane.distance(centroid_m[plus]))
    return np.where(mutual & near, minus[nearest], -1)


def unknown(value: str, existing: Sequence[str]) -> str:
    """That no area has `value`, with the nearest of the `existing` values."""
    near = difflib.get_close_matches(value, existing, n=1)
    return f"no thermal area has {value!r}{f'; did you mean {near[0]}?' if near else ''}; there are: " + (
        ", ".join(existing[:12]) + (f", ... ({len(existing)} in all)" if len(existing) > 12 else "")
    )


def listed(names: Sequence[str], most: int = 4) -> str:
    """The first few names, and how many there are more."""
    return ", ".join(names[:most]) + (f" and {len(names) - most} more" if len(names) > most else "")


def _present(areas: AreaTable) -> str:
    combos = sorted(set(zip(areas.group.tolist(), areas.shield.tolist(), areas.side.tolist(), strict=True)))
    return "; ".join("/".join(combo) for combo in combos[:12]) + ("; ..." if len(combos) > 12 else "")
