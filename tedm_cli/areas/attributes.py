"""Attributes of thermal areas by name pattern."""

from __future__ import annotations

from collections.abc import Mapping
from fnmatch import fnmatchcase

import numpy as np

from tedm_cli.arrays import FloatArray
from tedm_cli.config.model.areas import AreasTable
from tedm_cli.errors import ConfigError
from tedm_cli.noise.areas import AreaTable
from tedm_cli.symmetry_plane import SymmetryPlane


def rule_of(name: str, table: AreasTable) -> int | None:
    """Number of the first rule whose pattern matches a name."""
    return next((i for i, r in enumerate(table.rule) if fnmatchcase(name, r.match)), None)


def area_attributes(
    kinds: Mapping[str, str], centroids_m: FloatArray, table: AreasTable, plane: SymmetryPlane, *, where: str
) -> AreaTable:
    """Group, shield and side of each area, of these kinds by name, from the first rule whose pattern matches its name.

    The side of the plane comes from the centroid [k,3] (m, basic frame) where the rule does not give it.

    Raises
    ------
    ConfigError : areas that no rule matches, and rules that match no area.
    """
    names = list(kinds)
    problems = []
    used = set()
    group, shield, side = [], [], []
    for name, off in zip(names, plane.distance(centroids_m).tolist(), strict=True):
        number = rule_of(name, table)
        if number is None:
            problems.append(("areas.rule", f"no rule matches the thermal area '{name}'"))
            continue
        rule = table.rule[number]
        used.add(number)
        group.append(rule.group)
        shield.append(rule.shield)
        side.append(rule.side or ("mid" if abs(off) < table.mid_half_width_m else "+y" if off > 0 else "-y"))
    for number, rule in enumerate(table.rule):
        if number not in used:
            taken = any(fnmatchcase(name, rule.match) for name in names)
            fact = "matches no thermal area" + (" that an earlier rule has left over" if taken else "")
            problems.append((f"areas.rule[{number}].match", f"'{rule.match}' {fact}"))
    if problems:
        shown = ", ".join(names[:8]) + (f" and {len(names) - 8} more" if len(names) > 8 else "")
        raise ConfigError(problems, where=where, hint=f"the model's areas: {shown}")
    return AreaTable(
        name=np.array(names),
        group=np.array(group),
        shield=np.array(shield),
        side=np.array(side),
        kind=np.array(list(kinds.values())),
    )
