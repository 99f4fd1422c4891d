"""The field at rest of every subsystem on every test mass, from what pulls: areas, the other test mass, blocks."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from tedm_cli.arrays import FloatArray
from tedm_cli.config.model.at_rest import members, rest_of
from tedm_cli.config.model.file import ModelConfig
from tedm_cli.gravity.compensation import CompensationMass
from tedm_cli.gravity.field import COMPENSATION, SelfGravity
from tedm_cli.gravity.requirements import ALL, dc_quantities

BY_AREA = ("acceleration", "angular_acceleration", "gamma_lin")  # in the order of `dc_quantities`
Fields = dict[str, dict[str, FloatArray]]


def of_field(field: SelfGravity) -> FloatArray:
    """What can be judged [12] of a field."""
    return dc_quantities(*(getattr(field, name) for name in BY_AREA))


def by_group(
    blocks: Sequence[CompensationMass], fields: Sequence[Sequence[SelfGravity]]
) -> dict[str, dict[str, FloatArray]]:
    """Sums of the fields [test mass][block] of blocks that count to groups of areas: each of `BY_AREA` by group."""
    found: dict[str, dict[str, FloatArray]] = {}
    for group in dict.fromkeys(block.group for block in blocks if block.group):
        rows = [b for b, block in enumerate(blocks) if block.group == group]
        found[group] = {n: np.array([sum(getattr(of[b], n) for b in rows) for of in fields]) for n in BY_AREA}
    return found


def fields_at_rest(
    config: ModelConfig,
    sources: Sequence[str],
    pulls: Mapping[str, FloatArray],
    by_area: Mapping[str, FloatArray],
    groups: Sequence[str],
    of_blocks: Mapping[str, Mapping[str, FloatArray]],
) -> Fields:
    """The field [12] by test mass and subsystem, as `judge_at_rest` takes it.

    Parameters
    ----------
    sources, pulls : names, and each of `BY_AREA` by [test mass, source, ...]; all blocks are in one source.
    by_area, groups : each of `BY_AREA` by [test mass, area, ...], and the group of every area.
    of_blocks : what blocks pull that count to groups of areas, of `by_group`.
    """
    subsystems = config.gravity.subsystems
    rest = rest_of(subsystems)
    fields: Fields = {}
    for t, test_mass in enumerate(config.test_mass):
        field = {ALL: dc_quantities(*(pulls[name][t].sum(axis=0) for name in BY_AREA))}
        for name, subsystem in subsystems.items():
            chosen = members(subsystem, test_mass.name)
            areas, pointlike = np.isin(groups, chosen), np.isin(sources, chosen)
            parts = [by_area[n][t, areas].sum(axis=0) + pulls[n][t, pointlike].sum(axis=0) for n in BY_AREA]
            for group, of_group in of_blocks.items():
                # It is among the compensation masses as a source, and counts to its group instead.
                sign = int(group in chosen) - int(COMPENSATION in chosen)
                parts = [part + sign * of_group[n][t] for part, n in zip(parts, BY_AREA, strict=True)]
            field[name] = dc_quantities(*parts)
        if rest:
            field[rest] = field[ALL] - sum(field[name] for name in subsystems if name != rest)
        fields[test_mass.name] = field
    return fields
