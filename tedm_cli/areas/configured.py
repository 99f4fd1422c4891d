"""Thermal areas as the configuration defines them, on a deck that has been read, and against its temperatures."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from tedm_cli.areas.csv_file import read_area_csv
from tedm_cli.areas.definitions import DefinedAreas, define_areas
from tedm_cli.arrays import IntArray
from tedm_cli.config.model.file import ModelConfig
from tedm_cli.config.project import Project
from tedm_cli.errors import InputError
from tedm_cli.nastran.geometry import Grids, id_list
from tedm_cli.nastran.loads.area_loads import GRADIENT_DIGITS, AreaLoad
from tedm_cli.nastran.membership import membership


def area_csv(project: Project, config: ModelConfig) -> Path | None:
    """The CSV of areas that the configuration names."""
    name = config.model.areas_csv
    return None if name is None else project.resolve(name)


def defines_areas(config: ModelConfig) -> bool:
    """Whether the configuration says what the areas are (else the unit-load deck's TEMP cards do)."""
    return config.model.areas_csv is not None or bool(config.areas.define)


def configured_areas(project: Project, config: ModelConfig, model: Any, grids: Grids) -> DefinedAreas:
    """Areas of the CSV and the definitions on a cross-referenced pyNastran model."""
    path = area_csv(project, config)
    listed = {} if path is None else read_area_csv(path)
    table = config.areas
    members = membership(model, grids, positions=table.has_boxes(), axes=table.has_gradients())
    where = str(project.model if config.areas.define or path is None else path)
    return define_areas(members, config.areas, listed, where=where)


def require_agreement(defined: DefinedAreas, loaded: Mapping[str, AreaLoad], grids: Grids, *, where: str) -> None:
    """Refuse a unit-load deck that loads other grids or elements than the configuration defines, or otherwise.

    Names are compared without regard to case; grids without element stiffness are not compared.

    Raises
    ------
    InputError : an area of one that the other does not have, or the first area with another load.
    """
    ours = {name.upper(): name for name in defined.loads}
    theirs = {name.upper(): name for name in loaded}
    hint = "write and solve the deck again, or remove areas_csv and [[areas.define]]: the deck says its areas itself"
    lacking = [ours[key] for key in ours if key not in theirs]
    unknown = [theirs[key] for key in theirs if key not in ours]
    if lacking or unknown:
        facts = [f"{', '.join(lacking[:8])} defined, but not in the deck"] if lacking else []
        facts += [f"{', '.join(unknown[:8])} in the deck, but not defined"] if unknown else []
        raise InputError(f"the configuration defines other thermal areas: {'; '.join(facts)}", where=where, hint=hint)
    structural = grids.grid_id[grids.structural]
    found = {key: _differences(defined.loads[ours[key]], loaded[theirs[key]], structural) for key in ours}
    different = [key for key, facts in found.items() if facts]
    if different:
        name, facts = ours[different[0]], found[different[0]]
        others = f" ({len(different) - 1} more areas differ)" if len(different) > 1 else ""
        raise InputError(f"area '{name}': {'; '.join(facts)}{others}", where=where, hint=hint)


def _differences(wanted: AreaLoad, given: AreaLoad, structural: IntArray) -> list[str]:
    """How the load of the deck differs from that of the definition, as facts."""
    if wanted.kind != given.kind:
        return [f"a {wanted.kind} temperature is defined, but the deck loads a {given.kind}"]
    facts = []
    on_grids = [np.intersect1d(load.grid_id, structural) for load in (wanted, given)]
    for what, (ours, theirs) in {"grids": on_grids, "elements": [wanted.element_id, given.element_id]}.items():
        missing, more = np.setdiff1d(ours, theirs), np.setdiff1d(theirs, ours)
        facts += [f"{len(missing)} {what} are defined but not warmed: {id_list(missing)}"] if missing.size else []
        facts += [f"{len(more)} {what} are warmed but not defined: {id_list(more)}"] if more.size else []
    if not facts and wanted.gradient is not None and given.gradient is not None:
        apart = np.linalg.norm(wanted.gradient - given.gradient, axis=1) > GRADIENT_DIGITS
        if apart.any():
            listed = id_list(wanted.element_id[apart])
            facts.append(f"the gradients of {apart.sum()} elements are defined otherwise: {listed}")
    return facts
