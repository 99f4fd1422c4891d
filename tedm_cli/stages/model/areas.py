"""areas: the thermal areas of the model before anything is solved, as a table, a CSV and a figure."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from tedm_cli.areas.attributes import area_attributes
from tedm_cli.areas.configured import configured_areas, defines_areas
from tedm_cli.areas.csv_file import area_csv_text
from tedm_cli.areas.definitions import DefinedAreas, require_partition
from tedm_cli.areas.materials import judge_materials
from tedm_cli.areas.mean_step import MeanStep, mean_steps
from tedm_cli.areas.places import area_centroids, area_masses, area_points, element_owners
from tedm_cli.arrays import FloatArray, IntArray
from tedm_cli.config.model.file import ModelConfig, load_model
from tedm_cli.config.model.superelement import load_superelements
from tedm_cli.config.project import Project
from tedm_cli.config.symmetry_plane import ProjectPlane, project_plane
from tedm_cli.files.store import replacing
from tedm_cli.nastran.geometry import ModelGeometry, model_geometry
from tedm_cli.nastran.loads.area_loads import AreaLoad, none
from tedm_cli.nastran.loads.unit_loads import deck_unit_loads
from tedm_cli.nastran.reading import deck_files, passed_over, read_deck
from tedm_cli.noise.areas import AreaTable
from tedm_cli.stages.area_drawing import draw_areas, require_format
from tedm_cli.stages.model.superelements import AreasElsewhere


@dataclass(frozen=True)
class AreaSummary:
    """The areas of a deck.

    source : the deck; origin : what says the areas; notes : what of the deck was not read.
    mass_kg [k]; centroid_m [k,3], mean of the grids and of the centres of elements with temperatures of their own;
    mean_step [k], of the areas' own elements. structural : number of grids whose temperature is felt.
    """

    source: Path
    origin: str
    found: DefinedAreas
    table: AreaTable
    mass_kg: FloatArray
    centroid_m: FloatArray
    mean_step: list[MeanStep]
    structural: int
    total_kg: float
    notes: list[str]
    plane: ProjectPlane

    @property
    def loads(self) -> list[AreaLoad]:
        """[k], in the order of the table."""
        return list(self.found.loads.values())

    @property
    def on_grids(self) -> dict[str, IntArray]:
        """Ids of the grids of each area that has any."""
        return {name: load.grid_id for name, load in self.found.loads.items() if load.grid_id.size}

    @property
    def is_partition(self) -> bool:
        return not self.found.left.size

    def require_partition(self) -> None:
        require_partition(self.found, where=str(self.source))

    def as_dict(self) -> dict[str, Any]:
        """What a program needs."""
        t = self.table
        numbers = (self.loads, self.mass_kg, self.centroid_m, self.mean_step)
        columns = zip(t.name, *numbers, t.group, t.shield, t.side, strict=True)
        return {
            "deck": str(self.source),
            "defined_by": self.origin,
            "areas": [
                {
                    "name": str(name),
                    "kind": load.kind,
                    "grids": len(load.grid_id),
                    "elements": load.element_id.tolist(),
                    "mass_kg": float(mass),
                    "centroid_m": [float(v) for v in centroid],
                    "mean_step": None if np.isnan(step.share) else step.share,
                    "mean_step_elements": step.elements.tolist(),
                    "group": str(group),
                    "shield": str(shield),
                    "side": str(side),
                }
                for name, load, mass, centroid, step, group, shield, side in columns
            ],
            "symmetry_plane": {
                "point_m": self.plane.plane.point_m.tolist(),
                "normal": self.plane.plane.normal.tolist(),
                "origin": self.plane.origin,
            },
            "structural_grids": self.structural,
            "model_kg": self.total_kg,
            "is_partition": self.is_partition,
            "grids_in_no_area": self.found.left.tolist(),
            "shared_grids": [
                {"area": o.area, "stay_with": o.earlier, "grids": o.grids.tolist()} for o in self.found.overlaps
            ],
            "notes": [*self.found.notes, *self.notes],
        }


def areas(project: Project, output: Path | None, figure: Path | None) -> AreaSummary:
    """Resolve the areas; write the CSV where they are a partition, and the figure in any case.

    The areas are those of the configuration on the model to be solved, or else those of the unit-load deck.
    """
    require_format(figure)
    _, config = load_model(project.model)
    defined = defines_areas(config)
    bdf = config.model.bdf if defined else None
    source = project.resolve(bdf if bdf is not None else config.model.deck)
    table = config.model
    model = read_deck(source, allow_missing_enddata=table.allow_missing_enddata, units=table.deck_units())
    geometry = model_geometry(model, deck_files(model, source))
    elsewhere = AreasElsewhere.of(load_superelements(project, config.superelement))
    there = elsewhere.own if config.superelement else None
    if defined:
        found = configured_areas(project, config, model, geometry)
        origin = " and ".join(
            [
                *([str(project.resolve(config.model.areas_csv))] if config.model.areas_csv is not None else []),
                *([f"{len(config.areas.define)} definitions of {project.model}"] if config.areas.define else []),
            ]
        )
    else:
        loads = deck_unit_loads(model, geometry, config.model.uniform_label, there).areas
        found = DefinedAreas({a.label: a.area_load(geometry) for a in loads}, {}, [], none(), [], [])
        origin = "its temperature cards"
    notes = passed_over(model) + judge_materials(model, geometry, found.loads).lines
    bare = [name for name, load in found.loads.items() if load.element_id.size]
    if output is not None and bare:
        notes.append(f"{output} lists grids alone, and not the elements of {', '.join(bare)}")
    known = {name.upper() for name in found.loads}
    unlisted = {name: AreaLoad(none(), none(), none()) for name in elsewhere.names if name.upper() not in known}
    found = replace(found, loads={**found.loads, **unlisted})
    done = _summary(project, config, source, origin, found, geometry, elsewhere, notes)
    if figure is not None:
        groups = [str(g) for g in done.table.group]
        draw_areas(figure, project, config, source, model, geometry, found.loads, groups, "thermal areas")
    if output is not None and done.is_partition:
        with replacing(output) as temporary:
            temporary.write_text(area_csv_text(done.on_grids), encoding="utf-8", newline="\n")
    return done


def _summary(
    project: Project,
    config: ModelConfig,
    source: Path,
    origin: str,
    found: DefinedAreas,
    geometry: ModelGeometry,
    elsewhere: AreasElsewhere,
    notes: list[str],
) -> AreaSummary:
    loads = found.loads.values()
    centroid = elsewhere.placed(found.loads, area_centroids(geometry, loads))
    plane = project_plane(project, config)
    kinds = {name: load.kind for name, load in found.loads.items()}
    owned = element_owners(geometry, loads) >= 0
    return AreaSummary(
        source=source,
        origin=origin,
        found=found,
        table=area_attributes(kinds, centroid, config.areas, plane.plane, where=str(project.model)),
        mass_kg=elsewhere.weighed(found.loads, area_masses(geometry, loads)),
        centroid_m=centroid,
        mean_step=mean_steps(geometry, found.loads, found.selected),
        structural=int(geometry.mesh.followed(owned).sum()),
        total_kg=geometry.total_kg,
        notes=notes + plane.notes(area_points(geometry, loads)),
        plane=plane,
    )
