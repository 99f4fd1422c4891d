"""Thermal areas as the configuration defines them, on a deck that has been read, and against its TEMP cards."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from tedm_cli.areas.csv_file import read_area_csv
from tedm_cli.areas.definitions import AreaGrids, define_areas
from tedm_cli.arrays import IntArray
from tedm_cli.config.model import ModelConfig
from tedm_cli.config.project import Project
from tedm_cli.errors import InputError
from tedm_cli.nastran.geometry import Grids, id_list
from tedm_cli.nastran.membership import membership


def area_csv(project: Project, config: ModelConfig) -> Path | None:
    """The CSV of areas that the configuration names."""
    name = config.model.areas_csv
    return None if name is None else project.resolve(name)


def defines_areas(config: ModelConfig) -> bool:
    """Whether the configuration says what the areas are (else the unit-load deck's TEMP cards do)."""
    return config.model.areas_csv is not None or bool(config.areas.define)


def configured_areas(project: Project, config: ModelConfig, model: Any, grids: Grids) -> AreaGrids:
    """Areas of the CSV and the definitions on a pyNastran model, cross-referenced where definitions have boxes."""
    path = area_csv(project, config)
    listed = {} if path is None else read_area_csv(path)
    members = membership(model, grids, positions=config.areas.has_boxes())
    where = str(project.model if config.areas.define or path is None else path)
    return define_areas(members, config.areas, listed, where=where)


def require_agreement(defined: AreaGrids, warmed: Mapping[str, IntArray], grids: Grids, *, where: str) -> None:
    """Refuse a unit-load deck that warms other grids than the configuration defines.

    Names are compared without regard to case; grids without element stiffness are not compared.

    Raises
    ------
    InputError : an area of one that the other does not have, or the first area with other grids.
    """
    structural = grids.grid_id[grids.structural]
    ours = {name.upper(): (name, np.intersect1d(ids, structural)) for name, ids in defined.areas.items()}
    theirs = {name.upper(): (name, np.intersect1d(ids, structural)) for name, ids in warmed.items()}
    hint = "write and solve the deck again, or remove areas_csv and [[areas.define]]: the deck says its areas itself"
    lacking = [ours[key][0] for key in ours if key not in theirs]
    unknown = [theirs[key][0] for key in theirs if key not in ours]
    if lacking or unknown:
        facts = [f"{', '.join(lacking[:8])} defined, but not in the deck"] if lacking else []
        facts += [f"{', '.join(unknown[:8])} in the deck, but not defined"] if unknown else []
        raise InputError(f"the configuration defines other thermal areas: {'; '.join(facts)}", where=where, hint=hint)
    different = [key for key in ours if not np.array_equal(ours[key][1], theirs[key][1])]
    if different:
        name, wanted = ours[different[0]]
        warmed_grids = theirs[different[0]][1]
        missing, more = np.setdiff1d(wanted, warmed_grids), np.setdiff1d(warmed_grids, wanted)
        facts = [f"{len(missing)} grids are defined but not warmed: {id_list(missing)}"] if missing.size else []
        facts += [f"{len(more)} grids are warmed but not defined: {id_list(more)}"] if more.size else []
        others = f" ({len(different) - 1} more areas differ)" if len(different) > 1 else ""
        raise InputError(f"area '{name}': {'; '.join(facts)}{others}", where=where, hint=hint)
