"""Whether rules and correlation cases take suggested areas as they take the present ones."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from tedm_cli.areas.attributes import area_attributes
from tedm_cli.arrays import IntArray
from tedm_cli.config.cases import load_cases
from tedm_cli.config.model.file import ModelConfig
from tedm_cli.config.project import Project
from tedm_cli.config.symmetry_plane import project_plane
from tedm_cli.errors import ConfigError, TedmError
from tedm_cli.noise.areas import AreaTable
from tedm_cli.noise.correlation import correlation
from tedm_cli.stages.adjoint.field import ModelField


def fit_notes(
    project: Project, config: ModelConfig, field: ModelField, members: Mapping[str, IntArray], origin: IntArray
) -> list[str]:
    """What has to follow when the areas are taken.

    Parameters
    ----------
    members : ids of the grids of the new areas [m]. origin : [m], row of the present area that each has its name of.
    """
    areas, kept, notes = field.areas, field.areas.name[field.kept].tolist(), []
    if kept:
        notes.append(f"areas of elements and gradients stay as they are defined: {', '.join(kept)}")
    stay = {name.upper() for name in kept}  # Nastran does not tell upper from lower case in labels
    replaced = [d.name for d in config.areas.define if d.name.upper() not in stay]
    if replaced:
        whose = "its" if len(replaced) == 1 else "their"
        others = "; the other entries stay" if len(replaced) < len(config.areas.define) else ""
        notes.append(
            f"with the CSV, remove {', '.join(replaced)} from [areas] define ({whose} grids are in the CSV){others}"
        )
    rows = [np.searchsorted(field.grid_id, ids) for ids in members.values()]
    centroid = np.array([field.position[r].mean(axis=0) for r in rows]).reshape(-1, 3)
    if areas.centroid_m is not None:
        centroid = np.concatenate([centroid, areas.centroid_m[field.kept]])
    kinds = {**dict.fromkeys(members, "mean"), **dict(zip(kept, areas.kind[field.kept].tolist(), strict=True))}
    plane = project_plane(project, config).plane
    try:
        found = area_attributes(kinds, centroid, config.areas, plane, where=str(project.model))
    except ConfigError as exc:
        return [*notes, *(f"{key}: {fact}" for key, fact in exc.problems)]
    for place, (name, old) in enumerate(zip(members, origin, strict=True)):
        for what, now, before in (("group", found.group, areas.group), ("shield", found.shield, areas.shield)):
            if now[place] != before[old]:
                notes.append(f"areas.rule: {name} is of {what} {now[place]}, but {areas.name[old]} of {before[old]}")
    table = AreaTable(found.name, found.group, found.shield, found.side, centroid, plane=plane, kind=found.kind)
    cases = load_cases(project.cases)[1]
    for case in field.cases:
        if cases.within(case.id):
            notes.append(f"case {case.id} has gradients within areas, and was not tried with these")
            continue
        try:
            correlation(case, table)
        except TedmError as exc:
            facts = [fact for _, fact in exc.problems] if isinstance(exc, ConfigError) else [exc.fact]
            notes.append(f"case {case.id} does not fit these areas: {'; '.join(facts)}")
    return notes
